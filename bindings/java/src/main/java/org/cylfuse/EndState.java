package org.cylfuse;

/** What an end of the visible cylinder is. */
public enum EndState implements NativeNumber {
    /** Nothing tells what lies beyond the end: no depth was measured there, or no depth image pushed. */
    UNKNOWN(0),
    /** The surface ends there: what lies beyond is farther than the surface would be. */
    SEEN(1),
    /** The border of the image cuts the cylinder off. */
    CUT(2),
    /** Something nearer than the surface covers what lies beyond. */
    HIDDEN(3);

    private final int value;

    EndState(int value) {
        this.value = value;
    }

    /**
     * The number in the C interface.
     *
     * @return the number of {@code CYLFUSE_END_STATE_...}
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
        return NativeFunctions.cylfuse_end_state_string(value);
    }
}
