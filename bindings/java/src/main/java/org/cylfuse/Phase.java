package org.cylfuse;

/** What a fit is doing. */
public enum Phase implements NativeNumber {
    /** It is about to look for a start, or looks for one and asks whether to go on. */
    START(1),
    /** It iterates, or asks after an iteration whether to go on: the last state is reported again then. */
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
    @Override
    public int value() {
        return value;
    }
}
