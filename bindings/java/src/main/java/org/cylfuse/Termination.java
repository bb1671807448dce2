package org.cylfuse;

/** Why an iteration ended. */
public enum Termination implements NativeNumber {
    /** There was no iteration: the method has none, or a given model was evaluated. */
    NONE(0),
    /** The cost no longer fell by more than the tolerance, or reached the rounding error of the data. */
    COST(1),
    /** No step down to the largest damping lowered the cost: a minimum to rounding. */
    STALLED(2),
    /** The limit of iterations was reached; {@link ResultFlag#NOT_CONVERGED} is set too. */
    MAX_ITERATIONS(3),
    /** The radius left all proportion to the data: they are flat. */
    RADIUS_RAN_AWAY(4),
    /** The gradient fell below its tolerance. */
    GRADIENT(5),
    /** The step fell below its tolerance. */
    STEP(6);

    private final int value;

    Termination(int value) {
        this.value = value;
    }

    /**
     * The number in the C interface.
     *
     * @return the number of {@code CYLFUSE_TERMINATION_...}
     */
    @Override
    public int value() {
        return value;
    }

    /**
     * Says in a few words what it means.
     *
     * @return its name, a colon, and what it means
     */
    public String description() {
        return NativeFunctions.cylfuse_termination_string(value);
    }
}
