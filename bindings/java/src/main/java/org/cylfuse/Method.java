package org.cylfuse;

/** How the cylinder is estimated. */
public enum Method implements NativeNumber {
    /** Points and edges together, by the chosen {@link Objective}. */
    FUSED(0),
    /** Points alone by plain least squares; edges are ignored. */
    POINTS(1),
    /** Random sample consensus over the points, without a final iteration. */
    RANSAC(2),
    /** Eberly's algebraic fit by the moments of the points, without a final iteration. */
    EBERLY(3);

    private final int value;

    Method(int value) {
        this.value = value;
    }

    /**
     * The number in the C interface.
     *
     * @return the number of {@code CYLFUSE_METHOD_...}
     */
    @Override
    public int value() {
        return value;
    }
}
