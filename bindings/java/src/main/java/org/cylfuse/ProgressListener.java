package org.cylfuse;

/** Called before every iteration of a fit, on the thread of the fit. */
@FunctionalInterface
public interface ProgressListener {
    /**
     * Is called with the state of the fit. Of the methods of the same fitter only {@link Fitter#cancel()} and
     * {@link Fitter#close()} may be called.
     *
     * @param progress the state before the next iteration
     * @return whether to go on; false stops the fit, which throws with {@link Status#CANCELLED}
     */
    boolean onProgress(Progress progress);
}
