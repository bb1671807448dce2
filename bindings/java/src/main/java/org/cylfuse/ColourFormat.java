package org.cylfuse;

/** The order of the values of a pixel in colour, each a byte. A fourth one (alpha) is ignored. */
public enum ColourFormat {
    /** Red, green, blue. */
    RGB8(4, 3),
    /** Blue, green, red, as OpenCV reads image files. */
    BGR8(5, 3),
    /** Red, green, blue, alpha. */
    RGBA8(6, 4),
    /** Blue, green, red, alpha. */
    BGRA8(7, 4);

    private final int value;
    private final int channels;

    ColourFormat(int value, int channels) {
        this.value = value;
        this.channels = channels;
    }

    /**
     * The number in the C interface.
     *
     * @return the number of {@code CYLFUSE_IMAGE_FORMAT_...}
     */
    public int value() {
        return value;
    }

    /**
     * How many values a pixel has.
     *
     * @return 3 or 4
     */
    public int channels() {
        return channels;
    }
}
