package org.cylfuse;

/**
 * The visible piece of the cylinder: {@link #end()} = {@link #start()} + {@link #length()} * direction of the model.
 *
 * @param startState What the end against the direction is.
 * @param endState What the end along the direction is.
 * @param startSource What the position of the start was taken from.
 * @param endSource What the position of the end was taken from.
 * @param startView The view that tells most of the start.
 * @param endView The view that tells most of the end.
 * @param limbsKnown Whether the limbs of the model were taken as good to a fraction of a pixel, so that the bias of the
 *     mask was read off at them.
 * @param start The end against the direction, a point on the axis.
 * @param end The end along the direction, a point on the axis.
 * @param center The middle of the ends.
 * @param length The distance of the ends.
 * @param startDeviation Standard deviation of the position of the start along the axis, for a model without error; NaN
 *     for an extreme position. Of a start that is not SEEN it is that of the visible piece: the cylinder may well go
 *     on.
 * @param endDeviation The same for the end.
 * @param lengthDeviation Standard deviation of the length together with the uncertainty of the fit, of the visible
 *     piece. This and what follows is NaN for a model that was given, for extreme positions and when the fit has no
 *     uncertainty.
 * @param startCovariance Covariance of {@link #start()}, 3 x 3, symmetric, unit of length squared.
 * @param endCovariance Covariance of {@link #end()}.
 * @param centerCovariance Covariance of {@link #center()}.
 */
public record Extent(
        EndState startState,
        EndState endState,
        EndSource startSource,
        EndSource endSource,
        int startView,
        int endView,
        boolean limbsKnown,
        Vector start,
        Vector end,
        Vector center,
        double length,
        double startDeviation,
        double endDeviation,
        double lengthDeviation,
        double[][] startCovariance,
        double[][] endCovariance,
        double[][] centerCovariance) {
    static Extent of(NativeStructs.Extent n) {
        return new Extent(
                NativeNumber.find(EndState.class, n.start_state),
                NativeNumber.find(EndState.class, n.end_state),
                NativeNumber.find(EndSource.class, n.start_source),
                NativeNumber.find(EndSource.class, n.end_source),
                n.start_view,
                n.end_view,
                n.limbs_known != 0,
                Vector.of(n.start),
                Vector.of(n.end),
                Vector.of(n.center),
                n.length,
                n.start_deviation,
                n.end_deviation,
                n.length_deviation,
                NativeFunctions.square(n.start_covariance, 3),
                NativeFunctions.square(n.end_covariance, 3),
                NativeFunctions.square(n.center_covariance, 3));
    }
}
