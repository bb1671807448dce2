package org.cylfuse;

/** How much a log line matters. */
public enum LogLevel implements NativeNumber {
    /** No lines. */
    OFF(0),
    /** Calls that failed, with the text of {@code cylfuse_fitter_last_error}. */
    ERROR(1),
    /** Warnings about a result, such as ignored edges. */
    WARNING(2),
    /** What was pushed, which start was taken, how a fit ended. */
    INFO(3),
    /** Every iteration. */
    DEBUG(4);

    private final int value;

    LogLevel(int value) {
        this.value = value;
    }

    /**
     * The number in the C interface.
     *
     * @return the number of {@code CYLFUSE_LOG_LEVEL_...}
     */
    @Override
    public int value() {
        return value;
    }
}
