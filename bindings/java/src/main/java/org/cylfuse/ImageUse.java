package org.cylfuse;

/** Whether a detector looks at the image of a frame. */
public enum ImageUse implements NativeNumber {
    /** Where there is one. */
    AUTO(0),
    /** Never: by depth alone. */
    IGNORE(1);

    private final int value;

    ImageUse(int value) {
        this.value = value;
    }

    /**
     * The number in the C interface.
     *
     * @return the number of {@code CYLFUSE_IMAGE_USE_...}
     */
    @Override
    public int value() {
        return value;
    }
}
