package org.cylfuse;

/**
 * A limb of the cylinder in the image of one view: where it was located, or why it was not.
 *
 * @param view The view, from 0.
 * @param limb The limb, 0 or 1, in the order of {@link Cylinder#project}.
 * @param status Whether the limb was located, or why not.
 * @param samples How many pieces of it {@link Fitter#limbSamples} lists.
 * @param line x1 y1 x2 y2: the two points of the located line whose errors across it are independent and equally large,
 *     in ideal pixels. They need not lie on the part that was seen. NaN when the limb was not located.
 * @param deviation Standard deviation of either point across the line, in ideal pixels; NaN when the limb was not
 *     located.
 */
public record LimbLine(
        int view,
        int limb,
        LimbStatus status,
        int samples,
        double[] line,
        double deviation) {
    static LimbLine of(NativeStructs.Limb n) {
        return new LimbLine(
                n.view,
                n.limb,
                NativeNumber.find(LimbStatus.class, n.status),
                n.samples,
                n.line.clone(),
                n.deviation);
    }
}
