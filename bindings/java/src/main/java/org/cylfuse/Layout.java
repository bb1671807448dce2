package org.cylfuse;

/** How the points of an output buffer are arranged. */
public enum Layout {
    /** Only the points that exist, one after the other, row by row of the image. */
    PACKED(0),
    /** One point for each pixel of the image, NaN where there is none. */
    ORGANISED(1);

    private final int value;

    Layout(int value) {
        this.value = value;
    }

    /**
     * The number in the C interface.
     *
     * @return the number of {@code CYLFUSE_LAYOUT_...}
     */
    public int value() {
        return value;
    }
}
