package org.cylfuse;

/** The settings of {@link FitOptions} about the noise of the data. */
abstract sealed class NoiseOptions permits FitOptions {
    final NativeStructs.Options n;

    NoiseOptions(NativeStructs.Options n) {
        this.n = n;
    }

    /**
     * {@return how many points with independent noise the points of one view are worth, by which points and limbs are
     * weighed against each other; 0 or greater. Default 0 = from the data}
     */
    public double independentPoints() {
        return n.independent_points;
    }

    /**
     * Sets {@link #independentPoints()}.
     *
     * @param independentPoints the setting
     * @return these options
     */
    public FitOptions independentPoints(double independentPoints) {
        n.independent_points = independentPoints;
        return (FitOptions) this;
    }

    /**
     * {@return the standard deviation of a point across the surface, in the unit of length, 0 or greater. Default 0 =
     * from the data}
     */
    public double depthNoise() {
        return n.depth_noise;
    }

    /**
     * Sets {@link #depthNoise()}.
     *
     * @param depthNoise the setting
     * @return these options
     */
    public FitOptions depthNoise(double depthNoise) {
        n.depth_noise = depthNoise;
        return (FitOptions) this;
    }

    /**
     * {@return the standard deviation of the values of the image, in their unit where that is linear in light, 0 or
     * greater. Default 0 = from the image}
     */
    public double imageNoise() {
        return n.image_noise;
    }

    /**
     * Sets {@link #imageNoise()}.
     *
     * @param imageNoise the setting
     * @return these options
     */
    public FitOptions imageNoise(double imageNoise) {
        n.image_noise = imageNoise;
        return (FitOptions) this;
    }

    /**
     * {@return the standard deviation of an endpoint of a given edge segment across its limb, in drawn pixels, 0 or
     * greater. Default 0 = 0.5, that of edges set by hand}
     */
    public double edgeNoise() {
        return n.edge_noise;
    }

    /**
     * Sets {@link #edgeNoise()}.
     *
     * @param edgeNoise the setting
     * @return these options
     */
    public FitOptions edgeNoise(double edgeNoise) {
        n.edge_noise = edgeNoise;
        return (FitOptions) this;
    }

    /**
     * {@return the standard deviation of a side of the mask as a whole across its limb, in drawn pixels, 0 or greater.
     * Default 0 = 1.6, that of masks drawn by hand}
     */
    public double maskNoise() {
        return n.mask_noise;
    }

    /**
     * Sets {@link #maskNoise()}.
     *
     * @param maskNoise the setting
     * @return these options
     */
    public FitOptions maskNoise(double maskNoise) {
        n.mask_noise = maskNoise;
        return (FitOptions) this;
    }

    /**
     * {@return the blur of the image, the standard deviation of a Gaussian in pixels, 0 or greater. Default 0 = from
     * the image}
     */
    public double imageBlur() {
        return n.image_blur;
    }

    /**
     * Sets {@link #imageBlur()}.
     *
     * @param imageBlur the setting
     * @return these options
     */
    public FitOptions imageBlur(double imageBlur) {
        n.image_blur = imageBlur;
        return (FitOptions) this;
    }

    /**
     * {@return the size of a pixel of the drawing in which edges and masks were made, in pixels of the image, 0 or
     * greater: people and networks draw on a grid of some hundred columns, whatever the size of the image. Default 0 =
     * 1 up to 640 x 480 pixels, beyond that the square root of how many times as many pixels the image has}
     */
    public double drawnPixel() {
        return n.drawn_pixel;
    }

    /**
     * Sets {@link #drawnPixel()}.
     *
     * @param drawnPixel the setting
     * @return these options
     */
    public FitOptions drawnPixel(double drawnPixel) {
        n.drawn_pixel = drawnPixel;
        return (FitOptions) this;
    }

    /**
     * {@return the standard deviation of the errors that all points of a view share, as a part of their distance. Default 0
     * = 0.002, a fifth of what data sheets grant; less than 0 = they share none}
     */
    public double depthShared() {
        return n.depth_shared;
    }

    /**
     * Sets {@link #depthShared()}.
     *
     * @param depthShared the setting
     * @return these options
     */
    public FitOptions depthShared(double depthShared) {
        n.depth_shared = depthShared;
        return (FitOptions) this;
    }
}
