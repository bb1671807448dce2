package org.cylfuse;

/** Where the iteration starts. */
public enum StartKind implements NativeNumber {
    /** The candidate of the kinds below that explains the data best. Never in a result. */
    AUTO(0),
    /** From two limb segments, scaled by the points. */
    LIMBS(1),
    /** Eberly's algebraic fit by the moments of the points. */
    MOMENTS(2),
    /** Random sample consensus over the points. */
    RANSAC(3),
    /** The model given by {@link Fitter#setStartModel}. */
    MODEL(4),
    /**
     * The cylinder of the last successful fit of the fitter, for frames of a sequence, also after {@link Fitter#clear}.
     * Where its limbs are about where it or the points have them, and look in the image as they did, they are not
     * searched, and the result depends on the fits before. Where not, and before the first fit, as {@link #AUTO}, with
     * that cylinder or the start model one of the candidates. Of points alone that hold several bodies the one near
     * that cylinder is fitted.
     */
    LAST(5);

    private final int value;

    StartKind(int value) {
        this.value = value;
    }

    /**
     * The number in the C interface.
     *
     * @return the number of {@code CYLFUSE_START_...}
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
        return NativeFunctions.cylfuse_start_string(value);
    }
}
