package org.cylfuse;

/** The distortion of the lens. What the numbers in Intrinsics mean. */
public enum DistortionModel implements NativeNumber {
    /** A pinhole; all coefficients are 0. */
    NONE(0),
    /** Brown and Conrady: k1 k2 p1 p2 k3 k4 k5 k6 in the order of OpenCV; the missing ones of a shorter list are 0. */
    BROWN_CONRADY(1),
    /**
     * Kannala and Brandt, the fisheye model of OpenCV: k1 k2 k3 k4; the other coefficients are 0. Rays less than 89
     * degrees from the axis.
     */
    KANNALA_BRANDT(2);

    private final int value;

    DistortionModel(int value) {
        this.value = value;
    }

    /**
     * The number in the C interface.
     *
     * @return the number of {@code CYLFUSE_DISTORTION_...}
     */
    @Override
    public int value() {
        return value;
    }
}
