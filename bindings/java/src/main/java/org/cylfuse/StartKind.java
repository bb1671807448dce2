package org.cylfuse;

/** Where the iteration starts. */
public enum StartKind {
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
    public int value() {
        return value;
    }

    static StartKind of(int value) {
        for (StartKind candidate : values()) {
            if (candidate.value == value) {
                return candidate;
            }
        }
        throw new IllegalStateException("the native library gave StartKind " + value + ", which this package does not know");
    }
}
