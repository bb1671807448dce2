package org.cylfuse;

/** Data of a view, one bit each. */
public enum Input {
    /** Clouds, of {@link Fitter#pushPoints}. */
    POINTS(1),
    /** The depth images with their masks, of {@link Fitter#pushDepth} and of a frame. */
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
