package org.cylfuse;

/**
 * What was pushed into one view, and what was left out by reason.
 *
 * @param view The view that the counts are of.
 * @param pointsGiven Points and pixels that were pushed.
 * @param pointsUsed Points that a fit uses.
 * @param droppedNotFinite Left out: a coordinate or weight is not finite.
 * @param droppedZeroWeight Left out: the weight is 0.
 * @param droppedOutsideMask Left out: the mask is 0 there.
 * @param droppedNoDepth Left out: no depth was measured there.
 * @param droppedOutOfRange Left out: the depth is outside the range of the depth image.
 * @param droppedOutsideCamera Left out: the camera model has no ray for the pixel.
 * @param droppedHidden Left out: the mask is set there, but the colour camera sees something nearer. Only with a depth
 *     camera of its own.
 * @param segmentsGiven Edge segments that were pushed; {@link FitResult#segmentsUsed()} of a result says how many
 *     count.
 */
public record Counts(
        int view,
        long pointsGiven,
        long pointsUsed,
        long droppedNotFinite,
        long droppedZeroWeight,
        long droppedOutsideMask,
        long droppedNoDepth,
        long droppedOutOfRange,
        long droppedOutsideCamera,
        long droppedHidden,
        long segmentsGiven) {
    static Counts of(NativeStructs.Counts n) {
        return new Counts(
                n.view,
                n.points_given,
                n.points_used,
                n.dropped_not_finite,
                n.dropped_zero_weight,
                n.dropped_outside_mask,
                n.dropped_no_depth,
                n.dropped_out_of_range,
                n.dropped_outside_camera,
                n.dropped_hidden,
                n.segments_given);
    }
}
