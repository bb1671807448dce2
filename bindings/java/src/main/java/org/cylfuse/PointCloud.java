package org.cylfuse;

import java.nio.Buffer;
import java.nio.DoubleBuffer;
import java.nio.FloatBuffer;

/**
 * Points in an array or buffer, organised in rows and columns or not. Nothing is copied until a call takes the cloud,
 * and then a direct buffer by the library alone.
 */
public final class PointCloud {
    private final BufferPart points;
    private final BufferPart weights;
    private final BufferPart normals;

    private PointCloud(BufferPart points, BufferPart weights, BufferPart normals) {
        this.points = points;
        this.weights = weights;
        this.normals = normals;
    }

    /**
     * Points in an array.
     *
     * @param xyz x, y, z of one point after the other
     * @return the cloud
     * @throws IllegalArgumentException when the length is not a multiple of 3
     */
    public static PointCloud of(double[] xyz) {
        return flat(DoubleBuffer.wrap(xyz));
    }

    /**
     * Points in an array.
     *
     * @param xyz x, y, z of one point after the other
     * @return the cloud
     * @throws IllegalArgumentException when the length is not a multiple of 3
     */
    public static PointCloud of(float[] xyz) {
        return flat(FloatBuffer.wrap(xyz));
    }

    /**
     * Points, copied.
     *
     * @param points one point a row
     * @return the cloud
     * @throws IllegalArgumentException when a row has not 3 numbers
     */
    public static PointCloud of(double[][] points) {
        return of(Rows.flatten("point", points, 3));
    }

    /**
     * Points somewhere in a buffer, from its position to its limit.
     *
     * @param data the buffer; {@link DoubleBuffer#wrap(double[])} makes one of an array
     * @param width columns, or the number of points
     * @param height rows, or 1
     * @param offset index of x of the first point; y and z follow it
     * @param pointStride elements from a point to the next one in its row, negative too; 0 = 3
     * @param rowStride elements from a row to the next one, negative too; 0 = width * pointStride
     * @return the cloud
     * @throws IllegalArgumentException when a point lies outside the buffer
     */
    public static PointCloud of(DoubleBuffer data, int width, int height, int offset, int pointStride, int rowStride) {
        return new PointCloud(new BufferPart("points", data, 3, width, height, offset, pointStride, rowStride), null, null);
    }

    /**
     * Points somewhere in a buffer, from its position to its limit.
     *
     * @param data the buffer; {@link FloatBuffer#wrap(float[])} makes one of an array
     * @param width columns, or the number of points
     * @param height rows, or 1
     * @param offset index of x of the first point; y and z follow it
     * @param pointStride elements from a point to the next one in its row, negative too; 0 = 3
     * @param rowStride elements from a row to the next one, negative too; 0 = width * pointStride
     * @return the cloud
     * @throws IllegalArgumentException when a point lies outside the buffer
     */
    public static PointCloud of(FloatBuffer data, int width, int height, int offset, int pointStride, int rowStride) {
        return new PointCloud(new BufferPart("points", data, 3, width, height, offset, pointStride, rowStride), null, null);
    }

    /**
     * The same points with weights.
     *
     * @param data one weight a point, 0 or greater; 0 drops the point
     * @return another cloud on the same points
     * @throws IllegalArgumentException when the number of weights is wrong or the coordinates are float
     */
    public PointCloud withWeights(double[] data) {
        return weighted(BufferPart.whole("weights", DoubleBuffer.wrap(data), width(), height()));
    }

    /**
     * The same points with weights.
     *
     * @param data one weight a point, 0 or greater; 0 drops the point
     * @return another cloud on the same points
     * @throws IllegalArgumentException when the number of weights is wrong or the coordinates are double
     */
    public PointCloud withWeights(float[] data) {
        return weighted(BufferPart.whole("weights", FloatBuffer.wrap(data), width(), height()));
    }

    /**
     * The same points with weights somewhere in a buffer of the type of the coordinates.
     *
     * @param data a {@link DoubleBuffer} or {@link FloatBuffer}
     * @param offset index of the weight of the first point
     * @param stride elements from a weight to the next one in its row; 0 = 1
     * @param rowStride elements from a row of weights to the next one; 0 = width * stride
     * @return another cloud on the same points
     * @throws IllegalArgumentException when a weight lies outside the buffer or has another type
     */
    public PointCloud withWeights(Buffer data, int offset, int stride, int rowStride) {
        return weighted(new BufferPart("weights", data, 1, width(), height(), offset, stride, rowStride));
    }

    /**
     * The same points with normals of any length and sign, of which one of length 0 or that is not finite counts as
     * unknown. Only {@link Method#RANSAC} uses them, when all points come with normals.
     *
     * @param data a {@link DoubleBuffer} or {@link FloatBuffer}, of the type of the coordinates
     * @param offset index of x of the first normal; y and z follow it
     * @param stride elements from a normal to the next one in its row; 0 = 3
     * @param rowStride elements from a row of normals to the next one; 0 = width * stride
     * @return another cloud on the same points
     * @throws IllegalArgumentException when a normal lies outside the buffer or has another type
     */
    public PointCloud withNormals(Buffer data, int offset, int stride, int rowStride) {
        BufferPart part = new BufferPart("normals", data, 3, width(), height(), offset, stride, rowStride);
        return new PointCloud(points, weights, ofSameType(part, "normals"));
    }

    /**
     * Columns of an organised cloud, or the number of points.
     *
     * @return the number
     */
    public int width() {
        return points.width;
    }

    /**
     * Rows of an organised cloud, or 1.
     *
     * @return the number
     */
    public int height() {
        return points.height;
    }

    /**
     * Number of points.
     *
     * @return the number
     */
    public long count() {
        return (long) width() * height();
    }

    NativeStructs.PointsView toNative(NativeCopies copies) {
        NativeStructs.PointsView n =
                NativeFunctions.initialised(new NativeStructs.PointsView(), NativeFunctions::cylfuse_points_view_init);
        n.scalar = points.isDouble() ? Formats.SCALAR_F64 : Formats.SCALAR_F32;
        n.data = points.address(copies);
        n.width = width();
        n.height = height();
        n.point_stride = points.itemStrideBytes();
        n.row_stride = points.rowStrideBytes();
        if (weights != null) {
            n.weights = weights.address(copies);
            n.weight_stride = weights.itemStrideBytes();
            n.weight_row_stride = weights.rowStrideBytes();
        }
        if (normals != null) {
            n.normals = normals.address(copies);
            n.normal_stride = normals.itemStrideBytes();
            n.normal_row_stride = normals.rowStrideBytes();
        }
        return n;
    }

    private static PointCloud flat(Buffer xyz) {
        if (xyz.limit() % 3 != 0) {
            throw new IllegalArgumentException(
                    xyz.limit() + " numbers are not x, y, z of points: their count must be a multiple of 3.");
        }
        return new PointCloud(new BufferPart("points", xyz, 3, xyz.limit() / 3, 1), null, null);
    }

    private PointCloud weighted(BufferPart part) {
        return new PointCloud(points, ofSameType(part, "weights"), normals);
    }

    private BufferPart ofSameType(BufferPart part, String what) {
        if (part.isDouble() != points.isDouble() || part.isFloat() != points.isFloat()) {
            throw new IllegalArgumentException("The " + what + " are not " + (points.isDouble() ? "double" : "float")
                    + " as the coordinates: both must be the same type.");
        }
        return part;
    }
}
