package org.cylfuse;

/**
 * What a short piece of a limb in the image says.
 *
 * @param view The view, from 0.
 * @param limb The limb that it belongs to, 0 or 1, in the order of {@link Cylinder#project}.
 * @param pixel Where the limb is seen, x and y in pixels of the (distorted) image.
 * @param deviation Standard deviation across the limb in ideal pixels, by the noise of the image only.
 * @param weight Its part in the line, from 1 down to 0 for a refused sample.
 */
public record LimbSample(
        int view,
        int limb,
        double[] pixel,
        double deviation,
        double weight) {
    static LimbSample of(NativeStructs.LimbSample n) {
        return new LimbSample(
                n.view,
                n.limb,
                n.pixel.clone(),
                n.deviation,
                n.weight);
    }
}
