package org.cylfuse;

/** Hears of each fit of {@link FitterBatch#fitAll} that ended. */
@FunctionalInterface
public interface FitEndedListener {
    /**
     * A fit ended.
     *
     * @param index the place of the fitter
     * @param status OK, or why it failed
     * @return whether to go on
     */
    boolean onEnd(int index, Status status);
}
