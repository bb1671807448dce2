package org.cylfuse;

import java.util.Objects;

/**
 * The settings of a detector. The constructor fills in the defaults, which are named below. Each setting has a method that
 * reads it and one that sets it and returns the options. The limits of radius and axis hold for the search and for the
 * fits.
 */
public final class DetectorOptions {
    private final NativeStructs.DetectorOptions n;

    /** The defaults of the library. */
    public DetectorOptions() {
        this(NativeFunctions.initialised(
                new NativeStructs.DetectorOptions(), NativeFunctions::cylfuse_detector_options_init));
    }

    DetectorOptions(NativeStructs.DetectorOptions n) {
        this.n = n;
    }

    /** {@return whether the image of a frame is looked at. Default AUTO} */
    public ImageUse imageUse() {
        return NativeNumber.find(ImageUse.class, n.image_use);
    }

    /**
     * Sets {@link #imageUse()}.
     *
     * @param imageUse the setting
     * @return these options
     */
    public DetectorOptions imageUse(ImageUse imageUse) {
        n.image_use = Objects.requireNonNull(imageUse, "imageUse").value();
        return this;
    }

    /**
     * {@return the most threads, on which cylinders are fitted side by side. The result has the same
     * bits for any number. Default 1: no thread is started; 0 = 1}
     */
    public int maxThreads() {
        return n.max_threads;
    }

    /**
     * Sets {@link #maxThreads()}.
     *
     * @param maxThreads the setting
     * @return these options
     */
    public DetectorOptions maxThreads(int maxThreads) {
        n.max_threads = (int) notNegative("maxThreads", maxThreads);
        return this;
    }

    /** {@return the most cylinders, those with the highest scores. Default 0 = no limit} */
    public int maxCount() {
        return n.max_count;
    }

    /**
     * Sets {@link #maxCount()}.
     *
     * @param maxCount the setting
     * @return these options
     */
    public DetectorOptions maxCount(int maxCount) {
        n.max_count = (int) notNegative("maxCount", maxCount);
        return this;
    }

    /** {@return the fewest pixels of a cylinder; points for a cloud. Default 100} */
    public long minPixels() {
        return n.min_pixels;
    }

    /**
     * Sets {@link #minPixels()}.
     *
     * @param minPixels the setting
     * @return these options
     */
    public DetectorOptions minPixels(long minPixels) {
        n.min_pixels = notNegative("minPixels", minPixels);
        return this;
    }

    /** {@return the least score, in [0, 1]: the probability that there is a cylinder. Default 0.5} */
    public double minScore() {
        return n.min_score;
    }

    /**
     * Sets {@link #minScore()}.
     *
     * @param minScore the setting
     * @return these options
     */
    public DetectorOptions minScore(double minScore) {
        n.min_score = minScore;
        return this;
    }

    /** {@return the smallest radius, in the unit of length. Default 0 = no limit} */
    public double radiusMin() {
        return n.radius_min;
    }

    /**
     * Sets {@link #radiusMin()}.
     *
     * @param radiusMin the setting
     * @return these options
     */
    public DetectorOptions radiusMin(double radiusMin) {
        n.radius_min = radiusMin;
        return this;
    }

    /**
     * {@return the largest radius, at least {@link #radiusMin()}; equal to it for a radius that is known.
     * Default 0 = no limit}
     */
    public double radiusMax() {
        return n.radius_max;
    }

    /**
     * Sets {@link #radiusMax()}.
     *
     * @param radiusMax the setting
     * @return these options
     */
    public DetectorOptions radiusMax(double radiusMax) {
        n.radius_max = radiusMax;
        return this;
    }

    /**
     * {@return the middle of the cone of directions that the axes keep, in the reference frame and of any
     * length. Default {0, 0, 0} = all directions}
     */
    public Vector axis() {
        return Vector.of(n.axis);
    }

    /**
     * Sets {@link #axis()}.
     *
     * @param axis the setting
     * @return these options
     */
    public DetectorOptions axis(Vector axis) {
        n.axis = Objects.requireNonNull(axis, "axis").toArray();
        return this;
    }

    /**
     * {@return the largest angle of an axis from {@link #axis()}, in radians from 0 to pi/2, whatever the
     * signs; 0 for a direction that is known. Default 0; must be 0 without {@link #axis()}}
     */
    public double axisMaxAngle() {
        return n.axis_max_angle;
    }

    /**
     * Sets {@link #axisMaxAngle()}.
     *
     * @param axisMaxAngle the setting
     * @return these options
     */
    public DetectorOptions axisMaxAngle(double axisMaxAngle) {
        n.axis_max_angle = axisMaxAngle;
        return this;
    }

    NativeStructs.DetectorOptions toNative() {
        return n;
    }

    private static long notNegative(String name, long value) {
        if (value < 0) {
            throw new IllegalArgumentException(name + " is " + value + "; it must be 0 or greater.");
        }
        return value;
    }
}
