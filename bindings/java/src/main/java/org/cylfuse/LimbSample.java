package org.cylfuse;

/**
 * What a short piece of a limb in the grey image says.
 *
 * @param pixel Where the limb is seen, x and y in pixels of the (distorted) image.
 * @param sigma Standard deviation across the limb in ideal pixels, by the noise of the image only.
 * @param weight What the sample counted, from 1 down to 0 for a refused one.
 * @param limb The limb that it belongs to, 0 or 1.
 */
public record LimbSample(
        double[] pixel,
        double sigma,
        double weight,
        int limb) {
    static LimbSample of(NativeStructs.LimbSample n) {
        return new LimbSample(
                n.pixel.clone(),
                n.sigma,
                n.weight,
                n.limb);
    }
}
