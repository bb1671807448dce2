package org.cylfuse;

/** What {@link Method#FUSED} minimises. */
public enum Objective implements NativeNumber {
    /**
     * Robust points and the distances of the segment endpoints in pixels, each weighted by its own scale. Takes any
     * number of segments, none included.
     */
    ROBUST(0),
    /**
     * F = (1 - w) E_P + w E_L of Zhang, Liu and Wang (Sensors 2026, 26(5), 1687), exactly, with the weight w = {@link
     * FitOptions#edgeWeight()}. Takes exactly two segments, or w = 0.
     */
    PAPER(1);

    private final int value;

    Objective(int value) {
        this.value = value;
    }

    /**
     * The number in the C interface.
     *
     * @return the number of {@code CYLFUSE_OBJECTIVE_...}
     */
    @Override
    public int value() {
        return value;
    }
}
