package org.cylfuse;

/**
 * How far a detector is: before the search, after it, and after each fit.
 * A cloud that is searched from many places begins again with each.
 *
 * @param phase What the detector is doing.
 * @param fitsDone Cylinders that are fitted.
 * @param fits Cylinders to fit; 0 before the search.
 */
public record DetectionProgress(DetectionPhase phase, int fitsDone, int fits) {
    static DetectionProgress of(NativeStructs.DetectionProgress n) {
        return new DetectionProgress(NativeNumber.find(DetectionPhase.class, n.phase), n.fits_done, n.fits);
    }
}
