package org.cylfuse;

/** What a detector is doing. */
public enum DetectionPhase implements NativeNumber {
    /** It is about to look for cylinders. */
    SEARCH(1),
    /** It fits those that were found. */
    FIT(2);

    private final int value;

    DetectionPhase(int value) {
        this.value = value;
    }

    /**
     * The number in the C interface.
     *
     * @return the number of {@code CYLFUSE_DETECTION_PHASE_...}
     */
    @Override
    public int value() {
        return value;
    }
}
