package org.cylfuse;

/** The coordinates in which the iteration steps. All reach the same optima. */
public enum Chart implements NativeNumber {
    /** ORTHONORMAL for the paper's objective where a camera stands outside the cylinder, else LOCAL. */
    AUTO(0),
    /** Shift and tilt of the axis at the data: regular wherever the axis runs. */
    LOCAL(1),
    /**
     * The orthonormal representation about the origin of coordinates, as in the paper: singular for an axis through the
     * origin.
     */
    ORTHONORMAL(2);

    private final int value;

    Chart(int value) {
        this.value = value;
    }

    /**
     * The number in the C interface.
     *
     * @return the number of {@code CYLFUSE_CHART_...}
     */
    @Override
    public int value() {
        return value;
    }
}
