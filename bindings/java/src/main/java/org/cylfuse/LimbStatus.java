package org.cylfuse;

/** Whether a limb was located in the image, or why not. */
public enum LimbStatus implements NativeNumber {
    /** It was located. */
    LOCATED(0),
    /** The image was not searched: there is none, the edges were taken as given, or the objective does not look. */
    NOT_SEARCHED(1),
    /** The cylinder has no limbs in front of the camera: the camera is inside it, or it lies behind. */
    NO_LIMBS(2),
    /** Fewer than 12 rows or columns of the image show the limb, or something in front covers it. */
    TOO_SHORT(3),
    /** No line near the expected place has more of an edge than noise gives. */
    NO_EDGE(4),
    /** The line left the expected place while it was refined, or lies beside the mask. */
    OUT_OF_REACH(5),
    /** The line would be less certain than one set by hand, or what is there is softer than any limb. */
    UNCERTAIN(6),
    /** A small part of the line carries it all. */
    PATCHY(7),
    /** The other limb was found at the same place, and more certainly. */
    SAME_LINE(8);

    private final int value;

    LimbStatus(int value) {
        this.value = value;
    }

    /**
     * The number in the C interface.
     *
     * @return the number of {@code CYLFUSE_LIMB_STATUS_...}
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
        return NativeFunctions.cylfuse_limb_status_string(value);
    }
}
