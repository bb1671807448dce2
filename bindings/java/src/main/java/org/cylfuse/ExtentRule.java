package org.cylfuse;

/**
 * How the ends of the visible cylinder are found in a mask. Without one, and from inside a pipe, the points on the surface tell
 * them.
 */
public enum ExtentRule implements NativeNumber {
    /** LOCATED for the method FUSED with the objective ROBUST, EXTREMES otherwise. */
    AUTO(0),
    /** The rule of the paper: the extreme positions along the axis of the points completed over the mask. */
    EXTREMES(1),
    /** From all lines along the surface together, in the mask and, when there is one, in the image. */
    LOCATED(2);

    private final int value;

    ExtentRule(int value) {
        this.value = value;
    }

    /**
     * The number in the C interface.
     *
     * @return the number of {@code CYLFUSE_EXTENT_RULE_...}
     */
    @Override
    public int value() {
        return value;
    }
}
