package org.cylfuse;

/**
 * Whether the points must lie on the wall of the cylinder that a camera at the origin sees. There is often a second
 * minimum with the cylinder between camera and surface; this rule refuses it.
 */
public enum NearWall implements NativeNumber {
    /** On when intrinsics are set: only then is the origin known to be a camera. */
    AUTO(0),
    /** On: the origin is the observer. */
    ON(1),
    /** Off: the minimum nearest to the start stays. */
    OFF(2);

    private final int value;

    NearWall(int value) {
        this.value = value;
    }

    /**
     * The number in the C interface.
     *
     * @return the number of {@code CYLFUSE_NEAR_WALL_...}
     */
    @Override
    public int value() {
        return value;
    }
}
