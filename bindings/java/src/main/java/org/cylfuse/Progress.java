package org.cylfuse;

/**
 * The state of a running fit, before each iteration.
 *
 * @param phase What the fit is doing.
 * @param iteration Iterations so far. Begins again at 0 with every start that is tried and every robust round.
 * @param maxIterations Maximum number of iterations.
 * @param cost The lowest cost so far, unit of length squared; infinite in the phase START.
 * @param lambda The damping of the next step; 0 in the phase START.
 * @param cylinder The best cylinder so far; null in the phase START.
 */
public record Progress(
        Phase phase,
        int iteration,
        int maxIterations,
        double cost,
        double lambda,
        Cylinder cylinder) {
    static Progress of(NativeStructs.Progress n) {
        return new Progress(
                NativeNumber.find(Phase.class, n.phase),
                n.iteration,
                n.max_iterations,
                n.cost,
                n.lambda,
                Cylinder.at(n.cylinder));
    }
}
