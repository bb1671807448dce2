package org.cylfuse;

import java.util.Set;

/**
 * The outcome of a fit: the cylinder, how certain it is, and the numbers to judge it. NaN stands for what does not
 * apply.
 *
 * @param model The cylinder, its axis point the one nearest to the middle of the points.
 * @param flags Warnings; empty when there are none.
 * @param radiusDeviation Standard deviation of the radius, unit of length. This and what follows is that of the noise
 *     of the data, with the weights that were used and the correlation of neighbouring depths. With the method FUSED
 *     and the objective ROBUST it also has the errors that all points of a view share and {@code depthShared} of the
 *     options states, by default 0.2 % of the depth. Errors of the calibration, the registration and a scale of the
 *     depth are not in it. For an expanded uncertainty with the coverage factor 2 multiply by 2. NaN for RANSAC and
 *     EBERLY, for an edge weight of 1, and where the data do not determine the number.
 * @param directionDeviation Standard deviation of the direction in radians: the tilt in the plane in which it is least
 *     certain.
 * @param positionDeviation Standard deviation of the position of the axis across itself, at the point of the model and
 *     in the direction in which it is least certain, unit of length.
 * @param termination Why the iteration ended.
 * @param iterations Iterations: linear systems that were solved.
 * @param rejectedSteps Solves whose step was rejected.
 * @param limbsLocated Limb lines that were located in the images and took part, at most 2 a view.
 * @param segmentsGiven Edge segments that were pushed.
 * @param segmentsUsed Edge segments that took part.
 * @param pointsGiven Points that were pushed; {@link Fitter#counts} says why some were left out.
 * @param pointsUsed Points that took part.
 * @param independentPoints How many points with independent noise the points of all views are worth: the noise of
 *     neighbours in a depth image is alike.
 * @param pointDeviation Standard deviation of the points from the surface by their median, unit of length: points
 *     beyond some of it lose their weight in the objective ROBUST.
 * @param pointRms Root mean square distance of the points from the surface, unit of length.
 * @param edgeRmsPixels Root mean square distance of the given endpoints from the limb lines in ideal pixels; NaN
 *     without edges.
 * @param nearWallFraction The part of the points on the wall that the camera sees; NaN when the origin is no camera.
 * @param initialCost Cost of the start, unit of length squared.
 * @param cost Cost of the outcome, unit of length squared.
 * @param energyPoints E_P: mean squared distance of the points from the surface, unit of length squared.
 * @param energyEdges E_L: mean squared distance of the back-projected endpoints from the limb lines, unit of length
 *     squared; NaN without exactly two usable segments.
 * @param edgeWeight The edge weight that was used, 0 when no edges count; NaN where the objective has none.
 * @param condition Condition number of the Jacobian at the outcome, in units of the size of the data; may be infinite.
 * @param gradientNorm Norm of half the gradient of the cost at the end, as far as the limits leave it free, in units of
 *     the size of the data.
 * @param stepNorm Norm of the last accepted step, in units of the size of the data.
 * @param lambda The last damping.
 * @param secondsStart Wall-clock seconds to find the start.
 * @param secondsSolve Wall-clock seconds to iterate.
 * @param secondsTotal Wall-clock seconds of the whole fit.
 * @param startKind How the start was found.
 * @param startModel The cylinder that the iteration started from, moved into the limits.
 * @param radiusFromPoints The radius by the curvature of the points alone, unit of length; NaN without segments or
 *     limbs, and where the points alone determine no cylinder.
 * @param radiusFromPointsDeviation Its standard deviation.
 * @param radiusFromLimbs The radius by the limbs, with distance and tilt of the axis from the points, unit of length;
 *     NaN likewise.
 * @param radiusFromLimbsDeviation Its standard deviation.
 * @param radiusZScore {@link #radiusFromPoints()} minus {@link #radiusFromLimbs()} in standard deviations of the
 *     difference; beyond 4 the flag POINTS_AND_LIMBS_DISAGREE is set.
 * @param covariance Covariance of the point, the direction and the radius of {@link #model()}, 7 x 7, symmetric, of
 *     rank 5; element [i][j] is that of the numbers i and j.
 */
public record FitResult(
        Cylinder model,
        Set<ResultFlag> flags,
        double radiusDeviation,
        double directionDeviation,
        double positionDeviation,
        Termination termination,
        int iterations,
        int rejectedSteps,
        int limbsLocated,
        int segmentsGiven,
        int segmentsUsed,
        long pointsGiven,
        long pointsUsed,
        double independentPoints,
        double pointDeviation,
        double pointRms,
        double edgeRmsPixels,
        double nearWallFraction,
        double initialCost,
        double cost,
        double energyPoints,
        double energyEdges,
        double edgeWeight,
        double condition,
        double gradientNorm,
        double stepNorm,
        double lambda,
        double secondsStart,
        double secondsSolve,
        double secondsTotal,
        StartKind startKind,
        Cylinder startModel,
        double radiusFromPoints,
        double radiusFromPointsDeviation,
        double radiusFromLimbs,
        double radiusFromLimbsDeviation,
        double radiusZScore,
        double[][] covariance) {
    /**
     * Whether the radius conforms to a tolerance, by its deviation and the warnings.
     *
     * @param tolerance the limits of the radius
     * @return what the measurement says
     * @throws CylfuseException INVALID_ARGUMENT for limits that are none
     */
    public Conformity radiusConforms(Tolerance tolerance) {
        return tolerance.decide(model.radius(), radiusDeviation, flags);
    }

    /**
     * Whether the diameter conforms to a tolerance, by its deviation and the warnings.
     *
     * @param tolerance the limits of the diameter
     * @return what the measurement says
     * @throws CylfuseException INVALID_ARGUMENT for limits that are none
     */
    public Conformity diameterConforms(Tolerance tolerance) {
        return tolerance.decide(2.0 * model.radius(), 2.0 * radiusDeviation, flags);
    }

    static FitResult of(NativeStructs.Result n, NativeStructs.CylinderEstimate e) {
        return new FitResult(
                Cylinder.of(e.model),
                ResultFlag.setOf(n.flags),
                e.radius_deviation,
                e.direction_deviation,
                e.position_deviation,
                NativeNumber.find(Termination.class, n.termination),
                n.iterations,
                n.rejected_steps,
                n.limbs_located,
                n.segments_given,
                n.segments_used,
                n.points_given,
                n.points_used,
                n.independent_points,
                n.point_deviation,
                n.point_rms,
                n.edge_rms_pixels,
                n.near_wall_fraction,
                n.initial_cost,
                n.cost,
                n.energy_points,
                n.energy_edges,
                n.edge_weight,
                n.condition,
                n.gradient_norm,
                n.step_norm,
                n.lambda,
                n.seconds_start,
                n.seconds_solve,
                n.seconds_total,
                NativeNumber.find(StartKind.class, e.start_kind),
                Cylinder.of(e.start_model),
                e.radius_from_points,
                e.radius_from_points_deviation,
                e.radius_from_limbs,
                e.radius_from_limbs_deviation,
                e.radius_z_score,
                NativeFunctions.square(e.covariance, 7));
    }
}
