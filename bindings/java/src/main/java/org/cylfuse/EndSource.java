package org.cylfuse;

/** What the position of an end was taken from. */
public enum EndSource implements NativeNumber {
    /** The extreme point completed over the mask. */
    EXTREME(0),
    /** Where the lines along the surface leave the mask. */
    MASK(1),
    /** The arc of the end circle in the image. */
    IMAGE(2),
    /** The last of the surface inside the border of the image. */
    BORDER(3),
    /** The points on the surface, where there is no mask, and from inside a pipe. */
    POINTS(4);

    private final int value;

    EndSource(int value) {
        this.value = value;
    }

    /**
     * The number in the C interface.
     *
     * @return the number of {@code CYLFUSE_END_SOURCE_...}
     */
    @Override
    public int value() {
        return value;
    }

    /**
     * Says in a few words what it means.
     *
     * @return its name, a colon, and what it means
     */
    public String description() {
        return NativeFunctions.cylfuse_end_source_string(value);
    }
}
