package org.cylfuse;

/** What a point in the mask belongs to. */
public enum Part implements NativeNumber {
    /** The lateral surface. */
    BODY(1),
    /** A cap: it lies in the plane across the axis at an end. */
    CAP(2),
    /** The inside of the cylinder, seen through an open end: its inner wall or its bottom. */
    INNER_WALL(3),
    /** Something nearer than the surface: a lid or a rim that is wider, a handle, what stands in front. */
    OTHER(4),
    /** Something farther away than the cylinder: the background. */
    BEHIND(5);

    private final int value;

    Part(int value) {
        this.value = value;
    }

    /**
     * The number in the C interface.
     *
     * @return the number of {@code CYLFUSE_PART_...}
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
        return NativeFunctions.cylfuse_part_string((byte) value);
    }
}
