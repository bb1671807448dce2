package org.cylfuse;

import com.sun.jna.Pointer;
import com.sun.jna.ptr.DoubleByReference;
import java.util.Objects;

/**
 * An infinite cylinder. The call that takes it checks the numbers.
 *
 * @param point a point on the axis, in the unit of length of the data
 * @param direction the direction of the axis: as input of any length but 0, from the library of length 1. Its sign has
 *     no meaning; the library gives the one with a positive largest component.
 * @param radius the radius in the unit of length of the data, greater than 0
 */
public record Cylinder(Vector point, Vector direction, double radius) {
    /**
     * Refuses null.
     *
     * @param point a point on the axis
     * @param direction the direction of the axis
     * @param radius the radius
     */
    public Cylinder {
        Objects.requireNonNull(point, "point");
        Objects.requireNonNull(direction, "direction");
    }

    static Cylinder of(NativeStructs.Cylinder n) {
        return new Cylinder(Vector.of(n.point), Vector.of(n.direction), n.radius);
    }

    /** The cylinder at an address; null at that of none. */
    static Cylinder at(Pointer address) {
        if (address == null) {
            return null;
        }
        NativeStructs.Cylinder n = new NativeStructs.Cylinder(address);
        n.read();
        return of(n);
    }

    /**
     * Signed distances of points from the surface, negative inside. Weights are ignored.
     *
     * @param points the points
     * @return the distances, row by row of the points; NaN for a point with a coordinate that is not finite
     * @throws CylfuseException INVALID_ARGUMENT when this is no cylinder
     */
    public double[] distances(PointCloud points) {
        try (NativeCopies copies = new NativeCopies()) {
            NativeStructs.PointsView view = Objects.requireNonNull(points, "points").toNative(copies);
            double[] distances = new double[Math.toIntExact(points.count())];
            NativeFunctions.check(NativeFunctions.cylfuse_cylinder_distances(toNative(), view, distances, distances.length));
            return distances;
        }
    }

    /**
     * The two limb lines in the image: a u + b v + c = 0 with a² + b² = 1, in ideal pixels, which are those of a
     * pinhole with the same fx, fy, cx and cy: without distortion the pixels of the image.
     *
     * @param intrinsics the camera
     * @return a, b, c of the first line and of the second
     * @throws CylfuseException EDGE_GEOMETRY when the camera is inside the cylinder or a line lies at infinity;
     *     INVALID_ARGUMENT, INVALID_INTRINSICS
     */
    public double[][] project(Intrinsics intrinsics) {
        Objects.requireNonNull(intrinsics, "intrinsics");
        double[] lines = new double[6];
        NativeFunctions.check(NativeFunctions.cylfuse_cylinder_project(toNative(), intrinsics.toNative(), lines));
        return new double[][] {{lines[0], lines[1], lines[2]}, {lines[3], lines[4], lines[5]}};
    }

    /**
     * How another cylinder differs from this one, which is the truth, say.
     *
     * @param other the other cylinder
     * @return the difference
     * @throws CylfuseException INVALID_ARGUMENT when one of the two is no cylinder
     */
    public CylinderDifference compare(Cylinder other) {
        Objects.requireNonNull(other, "other");
        DoubleByReference angle = new DoubleByReference();
        DoubleByReference axisDistance = new DoubleByReference();
        DoubleByReference radiusRelative = new DoubleByReference();
        NativeFunctions.check(NativeFunctions.cylfuse_cylinder_compare(
                toNative(), other.toNative(), angle, axisDistance, radiusRelative));
        return new CylinderDifference(angle.getValue(), axisDistance.getValue(), radiusRelative.getValue());
    }

    NativeStructs.Cylinder toNative() {
        NativeStructs.Cylinder n = new NativeStructs.Cylinder();
        n.point = point.toArray();
        n.direction = direction.toArray();
        n.radius = radius;
        return n;
    }

    /** NULL where there is no model. */
    static NativeStructs.Cylinder toNative(Cylinder model) {
        return model == null ? null : model.toNative();
    }
}
