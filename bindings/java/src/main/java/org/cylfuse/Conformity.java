package org.cylfuse;

/** What a measurement says about a tolerance. */
public enum Conformity implements NativeNumber {
    /** It does not tell: its uncertainty reaches over a limit or is not known, or a warning puts it in doubt. */
    UNDECIDED(0),
    /** The value is within the limits with all of its uncertainty. */
    CONFORMING(1),
    /** The value is outside the limits with all of its uncertainty. */
    NOT_CONFORMING(2);

    private final int value;

    Conformity(int value) {
        this.value = value;
    }

    /**
     * The number in the C interface.
     *
     * @return the number of {@code CYLFUSE_CONFORMITY_...}
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
        return NativeFunctions.cylfuse_conformity_string(value);
    }
}
