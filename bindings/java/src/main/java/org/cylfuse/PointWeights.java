package org.cylfuse;

/**
 * What a fit gave each point of a view to say, in the order of the residuals of points.
 *
 * @param weights The part of each point in the fit, from 1 for a point near the surface down to 0 for an outlier.
 * @param inliers Whether the weight is greater than 0.
 */
public record PointWeights(double[] weights, boolean[] inliers) {}
