package org.cylfuse;

/**
 * A cylinder of a scene.
 *
 * @param score The probability that there is a cylinder.
 * @param pixels Pixels of its region; points for a cloud.
 * @param result The outcome of its fit. Residuals, completion and so on are asked of {@link Detector#makeFitter}.
 * @param extent Its visible piece; that of a cylinder of a cloud ends with its points; null where there is none.
 * @param extentError Why there is no extent; null where there is one.
 */
public record Detection(double score, long pixels, FitResult result, Extent extent, CylfuseException extentError) {}
