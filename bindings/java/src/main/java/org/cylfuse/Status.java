package org.cylfuse;

/**
 * What a call returns: 0 when it did what it was asked to, else a negative number that says why not.
 *
 * <p>A failed call changes nothing and writes no output unless its text says so; the handle stays usable, but for
 * {@link Status#PANIC}. The numbers never change and new ones may be added: treat an unknown negative number as a
 * failure.
 */
public enum Status {
    /** The call did what it was asked to. */
    OK(0),
    /** An argument or field has a value outside its documented range. */
    INVALID_ARGUMENT(-1),
    /** A pointer that is needed is null. */
    NULL_POINTER(-2),
    /**
     * A {@code struct_size} or {@code element_size} is smaller than the first version of the struct or larger than
     * 4096, or a struct to be read is larger than this library knows it and uses fields that this library does not
     * know.
     */
    STRUCT_SIZE(-3),
    /** The program was compiled for another, incompatible version of the library. */
    ABI_MISMATCH(-4),
    /** The call came before something that it needs. */
    BAD_STATE(-5),
    /**
     * Another call on the same handle is running, in another thread or around a callback, and one of the two may change
     * it.
     */
    BUSY(-6),
    /** The buffer for the output is too small; the call says how much it needs and writes nothing else. */
    BUFFER_TOO_SMALL(-7),
    /** Memory could not be allocated: pass less data at once, or free memory. */
    OUT_OF_MEMORY(-8),
    /** Not supported with these options or data. */
    UNSUPPORTED(-9),
    /** Images on one pixel grid have different sizes. */
    SIZE_MISMATCH(-10),
    /** No camera works with these intrinsics. */
    INVALID_INTRINSICS(-11),
    /**
     * Too few usable points. A fit needs 5, as many as a cylinder has degrees of freedom; a plan needs 8 points with
     * independent noise.
     */
    TOO_FEW_POINTS(-20),
    /** The points are as flat as a plane. */
    PLANAR_POINTS(-21),
    /** The points lie on one straight line. */
    COLLINEAR_POINTS(-22),
    /** No pixel of the mask is set. */
    EMPTY_MASK(-23),
    /** No pixel in the region has a usable depth. */
    NO_DEPTH(-24),
    /** No start for the iteration could be found. */
    NO_START(-25),
    /** The camera sees no limbs of the cylinder, or nothing that was given meets it. */
    EDGE_GEOMETRY(-26),
    /** The arithmetic left the range of numbers. */
    NUMERICAL(-27),
    /** The progress callback or {@link Fitter#cancel} asked to stop. */
    CANCELLED(-40),
    /** A defect of the library. The handle can only be destroyed after it; others are not affected. */
    PANIC(-99),
    /** A failure that this package does not know: the native library is newer. */
    UNKNOWN(Integer.MIN_VALUE);

    private final int value;

    Status(int value) {
        this.value = value;
    }

    /**
     * The number in the C interface.
     *
     * @return the number of {@code CYLFUSE_STATUS_...}
     */
    public int value() {
        return value;
    }

    static Status of(int value) {
        for (Status candidate : values()) {
            if (candidate.value == value) {
                return candidate;
            }
        }
        return UNKNOWN;
    }
}
