package org.cylfuse;

/**
 * How much each point of a view counts at the cylinder of a fit, by the weights of {@link Objective#ROBUST}, in the
 * order of the residuals of points.
 *
 * @param weights From 1 for a point on the surface down to 0 for an outlier, without the weight that the point was
 *     given.
 * @param inliers Whether the weight is above 0.
 */
public record PointWeights(double[] weights, boolean[] inliers) {}
