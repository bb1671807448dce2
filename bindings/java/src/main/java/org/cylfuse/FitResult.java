package org.cylfuse;

import java.util.Set;

/**
 * The outcome of a fit with the numbers to judge it. NaN stands for what does not apply.
 *
 * @param termination Why the iteration ended.
 * @param startKind How the start was found.
 * @param flags Doubts; empty when there are none.
 * @param iterations Linear solves.
 * @param rejectedSteps Solves whose step was rejected.
 * @param segmentsUsed Segments that took part.
 * @param segmentsGiven Segments that were pushed.
 * @param pointsUsed Points that took part.
 * @param pointsGiven Points that were pushed; {@link Fitter#counts()} says why the others were left out.
 * @param model The cylinder, its axis point the one nearest to the middle of the points.
 * @param startModel The model that the iteration started from, moved into the limits.
 * @param initialCost Cost of the start, unit of length squared.
 * @param cost Cost of the cylinder, unit of length squared.
 * @param energyPoints E_P: mean squared distance of the points from the surface, unit of length squared.
 * @param energyEdges E_L: mean squared distance of the back-projected endpoints from the limb lines, unit of length
 *     squared; NaN without exactly two usable segments.
 * @param edgeWeight The edge weight that was used, 0 when no edges count; NaN where the objective has none.
 * @param pointRms Root of E_P, unit of length.
 * @param edgeRmsPixels Root mean square distance of the endpoints from the limb lines in ideal pixels; NaN without
 *     edges.
 * @param nearWallFraction The part of the points on the wall that the camera sees; NaN when the origin is no camera.
 * @param condition Condition number of the Jacobian at the cylinder, in units of the size of the data; may be infinite.
 * @param lambda The last damping.
 * @param gradientNorm Norm of half the gradient of the cost at the end, as far as the limits leave it free, in units of
 *     the size of the data.
 * @param stepNorm Norm of the last accepted step, in units of the size of the data.
 * @param secondsStart Wall-clock seconds to find the start.
 * @param secondsSolve Wall-clock seconds to iterate.
 * @param secondsTotal Wall-clock seconds of the whole fit.
 * @param radiusDeviation Standard deviation of the radius, unit of length. This and what follows is that of the noise
 *     of the data, with the weights that were used and the correlation of the depth noise along the order of the
 *     points; errors that all data share (calibration, a scale of the depth) are not in it. NaN for RANSAC and EBERLY,
 *     for an edge weight of 1, and where the data do not determine a cylinder.
 * @param directionDeviation Standard deviation of the direction in radians: the tilt in the plane in which it is least
 *     certain.
 * @param positionDeviation Standard deviation of the position of the axis across itself, at {@link Cylinder#point()}
 *     and in the direction in which it is least certain, unit of length.
 * @param radiusFromPoints The radius by the curvature of the points alone, unit of length; NaN without segments or
 *     limbs, and where the points alone determine no cylinder.
 * @param radiusFromPointsDeviation Its standard deviation.
 * @param radiusFromLimbs The radius by the limbs, with distance and tilt of the axis from the points, unit of length;
 *     NaN likewise.
 * @param radiusFromLimbsDeviation Its standard deviation.
 * @param radiusZScore {@link #radiusFromPoints()} minus {@link #radiusFromLimbs()} in standard deviations of the
 *     difference; beyond 4 the flag {@link ResultFlag#POINTS_AND_LIMBS_DISAGREE} is set.
 * @param covariance Covariance of ({@link Cylinder#point()}, {@link Cylinder#direction()}, {@link Cylinder#radius()}),
 *     7 x 7, symmetric, of rank 5; element [i][j] is that of the numbers i and j.
 * @param limbsLocated Limb lines that were located in the grey image and took part, 0 to 2.
 */
public record FitResult(
        Termination termination,
        StartKind startKind,
        Set<ResultFlag> flags,
        int iterations,
        int rejectedSteps,
        int segmentsUsed,
        int segmentsGiven,
        long pointsUsed,
        long pointsGiven,
        Cylinder model,
        Cylinder startModel,
        double initialCost,
        double cost,
        double energyPoints,
        double energyEdges,
        double edgeWeight,
        double pointRms,
        double edgeRmsPixels,
        double nearWallFraction,
        double condition,
        double lambda,
        double gradientNorm,
        double stepNorm,
        double secondsStart,
        double secondsSolve,
        double secondsTotal,
        double radiusDeviation,
        double directionDeviation,
        double positionDeviation,
        double radiusFromPoints,
        double radiusFromPointsDeviation,
        double radiusFromLimbs,
        double radiusFromLimbsDeviation,
        double radiusZScore,
        double[][] covariance,
        int limbsLocated) {
    static FitResult of(NativeStructs.Result n) {
        return new FitResult(
                NativeNumber.find(Termination.class, n.termination),
                NativeNumber.find(StartKind.class, n.start_kind),
                ResultFlag.setOf(n.flags),
                n.iterations,
                n.rejected_steps,
                n.segments_used,
                n.segments_given,
                n.points_used,
                n.points_given,
                Cylinder.of(n.model),
                Cylinder.of(n.start_model),
                n.initial_cost,
                n.cost,
                n.energy_points,
                n.energy_edges,
                n.edge_weight,
                n.point_rms,
                n.edge_rms_pixels,
                n.near_wall_fraction,
                n.condition,
                n.lambda,
                n.gradient_norm,
                n.step_norm,
                n.seconds_start,
                n.seconds_solve,
                n.seconds_total,
                n.radius_deviation,
                n.direction_deviation,
                n.position_deviation,
                n.radius_from_points,
                n.radius_from_points_deviation,
                n.radius_from_limbs,
                n.radius_from_limbs_deviation,
                n.radius_z_score,
                NativeFunctions.square(n.covariance, 7),
                n.limbs_located);
    }
}
