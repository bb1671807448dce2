package org.cylfuse;

/**
 * A sample on the arc of an end of the cylinder in the image.
 *
 * @param view The view, from 0.
 * @param end 0 for the start of the extent, 1 for its end.
 * @param pixel Where the arc is seen, x and y in pixels of the (distorted) image.
 * @param normal The unit vector across the arc in the image, away from the surface.
 * @param deviation Standard deviation along {@link #normal()}, in pixels.
 */
public record EndSample(
        int view,
        int end,
        double[] pixel,
        double[] normal,
        double deviation) {
    static EndSample of(NativeStructs.EndSample n) {
        return new EndSample(
                n.view,
                n.end,
                n.pixel.clone(),
                n.normal.clone(),
                n.deviation);
    }
}
