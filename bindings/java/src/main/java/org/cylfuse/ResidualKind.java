package org.cylfuse;

/** Which residuals to list. */
public enum ResidualKind implements NativeNumber {
    /**
     * Signed distance of every used point from the surface, in the unit of length, negative inside; in the order in
     * which the points were pushed, without the dropped ones.
     */
    POINTS(1),
    /** Signed distance of both endpoints of every used segment from its limb line, in ideal pixels. */
    EDGES(2);

    private final int value;

    ResidualKind(int value) {
        this.value = value;
    }

    /**
     * The number in the C interface.
     *
     * @return the number of {@code CYLFUSE_RESIDUAL_KIND_...}
     */
    @Override
    public int value() {
        return value;
    }
}
