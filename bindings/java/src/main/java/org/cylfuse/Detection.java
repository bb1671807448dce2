package org.cylfuse;

/**
 * A cylinder of a scene.
 *
 * @param score The probability that there is a cylinder.
 * @param pixels Pixels of its region; points for a cloud.
 * @param result The outcome of its fit. Residuals, completion and so on are asked of {@link Detector#makeFitter}.
 * @param extent Its visible piece; null where there is none: the cylinders of a cloud have no ends.
 */
public record Detection(double score, long pixels, FitResult result, Extent extent) {}
