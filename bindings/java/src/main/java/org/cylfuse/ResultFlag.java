package org.cylfuse;

import java.util.EnumSet;
import java.util.List;
import java.util.Set;

/**
 * Warnings about a result, one bit each. None of them is an error: the numbers of the result say how much it matters.
 */
public enum ResultFlag {
    /** Segments were given but none of them counts; the other flags and the counts say why. */
    EDGES_IGNORED(1),
    /** Some segments have no length or lie outside the field of the camera model. */
    SEGMENTS_UNUSABLE(2),
    /** Two segments cross each other: they cannot be the two limbs. */
    EDGES_CROSS(4),
    /** Two segments lie on one line to within 2 pixels: they are the same limb. */
    EDGES_COINCIDE(8),
    /** The rays of the endpoints do not meet the plane of the limbs in front of the camera. */
    EDGES_BEHIND(16),
    /** The edges alone (an edge weight of 1) do not tell the scale: that of the start was kept. */
    SCALE_HELD(32),
    /** The data hardly determine the radius: see its stated deviation. */
    WEAK_RADIUS(64),
    /** The coordinates are coarser than 0.01 % of the radius: a float cloud far from the origin. */
    RESOLUTION_LOST(128),
    /**
     * The limit of iterations came before convergence. Of a cylinder of a scene also: its depth came without an image, no
     * work was left for its fit, or no fit was as good, and it is what the search found.
     */
    NOT_CONVERGED(256),
    /** Most points lie on the wall that the camera cannot see. */
    HIDDEN_WALL(512),
    /** The camera is inside the cylinder: there are no limbs. */
    CAMERA_INSIDE(1024),
    /** Points with coordinates that are not finite were left out. */
    POINTS_NOT_FINITE(2048),
    /**
     * The radius by the points alone and the radius by the limbs differ by more than 4 standard deviations: {@link
     * FitResult#radiusFromPoints()} and {@link FitResult#radiusFromLimbs()} say how. An offset of the depth, depth that
     * is smeared or bent, wrong intrinsics or edges that are not the limbs do that. Or the points alone, far from edges
     * that were taken as given, would be another cylinder: one 1.5 times nearer to them, or surely 1.5 times as large
     * or as small. Or the points contradict limbs or edges, which were not followed.
     */
    POINTS_AND_LIMBS_DISAGREE(4096),
    /**
     * The radius is at its limit, and the data fit better beyond it. Of a known radius: the data contradict it by more than
     * 4 standard deviations.
     */
    RADIUS_AT_LIMIT(8192),
    /**
     * The axis is on the border of its cone, and the data fit better beyond it. Of a known direction: the data contradict it
     * by more than 4 standard deviations.
     */
    AXIS_AT_LIMIT(16384),
    /**
     * The data do not tell how uncertain the result is, and deviations and covariance are NaN: fewer than eight points
     * are independent, some degree of freedom is not determined, the coordinates are coarser than the noise, or most points
     * lie on the cylinder to the last digit and more than a tenth do not.
     */
    UNCERTAINTY_UNKNOWN(32768),
    /**
     * Depth and image are shifted against each other across the axis, by a wrong registration or wrong principal points.
     * Or one of the limbs is the edge of something else, and the radius is wrong. From a detector also: the whole depth
     * image was shifted, and has been moved.
     */
    DEPTH_SHIFTED(65536),
    /**
     * A mask holds the pixels that have depth and no others, although depth is missing around it: its sides are no hint
     * where the limbs are.
     */
    MASK_ENDS_WITH_DEPTH(131072),
    /**
     * The points do not lie on the cylinder: they scatter about its surface by more than 1 % of their distance from the
     * camera or, without a camera, by more than a quarter of the radius, or have a shape along the axis that no
     * cylinder has, or lie on two planes, as the sides of a box do.
     */
    POOR_FIT(262144),
    /**
     * The lines of both limbs turn against each other, so that the radius changes along the axis: the body is no
     * cylinder, or one of the lines is no limb. Or, without them, the sides of the mask do, or points without a camera tell it.
     */
    BODY_TAPERS(524288),
    /**
     * The mask ends beside a limb of the cylinder along most of the axis, by more than masks are off and the deviation of
     * the radius says; or no limb was seen, and the radii by the mask and by the points differ by more than 2.5 standard
     * deviations, or the points would scatter 3 times as much if the mask were followed; or the mask holds another body.
     */
    MASK_DISAGREES(1048576);

    private final int value;

    ResultFlag(int value) {
        this.value = value;
    }

    /**
     * The number in the C interface.
     *
     * @return the number of {@code CYLFUSE_RESULT_FLAGS_...}
     */
    public int value() {
        return value;
    }

    /**
     * Says in a few words what it means.
     *
     * @return its name, a colon, and what it means
     */
    public String description() {
        return NativeFunctions.cylfuse_flag_string(value);
    }

    /**
     * Says in a few words what each of several warnings means.
     *
     * @param flags the warnings, as {@link FitResult#flags()}
     * @return for each, in the order of this enumeration, its name, a colon, and what it means; empty for none
     */
    public static List<String> descriptions(Set<ResultFlag> flags) {
        return flags.stream().sorted().map(ResultFlag::description).toList();
    }

    /** The flags whose bits are set; bits that a newer library has added are left out. */
    static Set<ResultFlag> setOf(int bits) {
        EnumSet<ResultFlag> flags = EnumSet.noneOf(ResultFlag.class);
        for (ResultFlag flag : values()) {
            if ((bits & flag.value) != 0) {
                flags.add(flag);
            }
        }
        return flags;
    }
}
