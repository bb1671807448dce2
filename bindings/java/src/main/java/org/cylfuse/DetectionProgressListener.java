package org.cylfuse;

/** Is called with the progress of a detector, on the thread of the search. */
@FunctionalInterface
public interface DetectionProgressListener {
    /**
     * Is called before the search, after it, and after each fit. Of the methods of the same detector only {@link
     * Detector#cancel()} and {@link Detector#close()} may be called.
     *
     * @param progress how far the detector is
     * @return whether to go on; false stops the search, which throws with {@link Status#CANCELLED}
     */
    boolean onProgress(DetectionProgress progress);
}
