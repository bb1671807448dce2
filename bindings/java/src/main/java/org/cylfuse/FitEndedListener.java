package org.cylfuse;

/** Is called after each fit of {@link FitterBatch#fitAll}. */
@FunctionalInterface
public interface FitEndedListener {
    /**
     * A fit ended.
     *
     * @param index the index of the fitter
     * @param status OK, or why it failed
     * @return whether to go on
     */
    boolean onEnd(int index, Status status);
}
