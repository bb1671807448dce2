package org.cylfuse;

/** What a fit is doing. */
public enum Phase {
    /** It is about to look for a start. */
    START(1),
    /** It iterates. */
    SOLVE(2);

    private final int value;

    Phase(int value) {
        this.value = value;
    }

    /**
     * The number in the C interface.
     *
     * @return the number of {@code CYLFUSE_PHASE_...}
     */
    public int value() {
        return value;
    }

    static Phase of(int value) {
        for (Phase candidate : values()) {
            if (candidate.value == value) {
                return candidate;
            }
        }
        throw new IllegalStateException("the native library gave Phase " + value + ", which this package does not know");
    }
}
