package org.cylfuse;

/** Data of a view, one bit each. */
public enum Input {
    /** All points: those of clouds and those that were made of depth images. */
    POINTS(1),
    /** The depth image and its mask, which completion and extent look at; the points that were made of it stay. */
    DEPTH(2),
    /** Edge segments, of {@link Fitter#pushEdges}. */
    EDGES(4),
    /** The image, of {@link Fitter#pushImage} and of a frame. */
    IMAGE(8);

    private final int value;

    Input(int value) {
        this.value = value;
    }

    /**
     * The number in the C interface.
     *
     * @return the number of {@code CYLFUSE_INPUT_...}
     */
    public int value() {
        return value;
    }
}
