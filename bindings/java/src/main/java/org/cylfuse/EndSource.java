package org.cylfuse;

/** What the position of an end was taken from. */
public enum EndSource implements NativeNumber {
    /** The extreme point completed over the mask. */
    EXTREME(0),
    /**
     * Where the lines along the surface leave the mask, or where within the mask the depth shows that the body ends: at a
     * cap, an opening, a shoulder or a narrower part. Also where the image shows an arc that is less certain than that.
     */
    MASK(1),
    /**
     * Mostly the arc of the end circle in the image: it is joined with mask and depth by the variances, and is the more
     * certain.
     */
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
