package org.cylfuse;

/**
 * What became of the pixels of a completion.
 *
 * @param view The view whose pixels were completed.
 * @param count Points or pixels that were written.
 * @param hits Pixels of the mask whose ray meets the cylinder.
 * @param misses Pixels of the mask whose ray passes the cylinder by.
 * @param outsideCamera Pixels of the mask for which the camera model has no ray.
 * @param outOfRange Hits whose depth does not fit the pixel format: written as 0 and not in {@link #count()}.
 */
public record Completion(
        int view,
        long count,
        long hits,
        long misses,
        long outsideCamera,
        long outOfRange) {
    static Completion of(NativeStructs.Completion n) {
        return new Completion(
                n.view,
                n.count,
                n.hits,
                n.misses,
                n.outside_camera,
                n.out_of_range);
    }
}
