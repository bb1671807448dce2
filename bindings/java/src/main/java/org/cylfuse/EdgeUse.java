package org.cylfuse;

/** What given edge segments are for the objective ROBUST. No other looks for limbs in the image. */
public enum EdgeUse implements NativeNumber {
    /** A start: where there is an image, the limbs are located in it and join the fit. */
    REFINE(0),
    /** The measurement: no limbs are looked for in the image. The arcs of the ends are. */
    AS_GIVEN(1);

    private final int value;

    EdgeUse(int value) {
        this.value = value;
    }

    /**
     * The number in the C interface.
     *
     * @return the number of {@code CYLFUSE_EDGE_USE_...}
     */
    @Override
    public int value() {
        return value;
    }
}
