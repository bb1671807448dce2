package org.cylfuse;

/** Where the iteration starts. */
public enum StartKind implements NativeNumber {
    /** The candidate of the kinds below that explains the data best. Never in a result. */
    AUTO(0),
    /** From two limb segments, scaled by the points. */
    LIMBS(1),
    /** Eberly's algebraic fit by the moments of the points. */
    MOMENTS(2),
    /** Random sample consensus over the points. */
    RANSAC(3),
    /** The model given by {@link Fitter#setStartModel}. */
    MODEL(4);

    private final int value;

    StartKind(int value) {
        this.value = value;
    }

    /**
     * The number in the C interface.
     *
     * @return the number of {@code CYLFUSE_START_...}
     */
    @Override
    public int value() {
        return value;
    }
}
