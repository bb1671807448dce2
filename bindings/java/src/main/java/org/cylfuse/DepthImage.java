package org.cylfuse;

import java.nio.FloatBuffer;
import java.nio.ShortBuffer;

/**
 * A depth image on the pixels of the camera, or of the depth camera where there is one. A value is z, not the distance
 * along the ray. Nothing is copied until a call takes the image, and then a direct buffer by the library alone.
 */
public final class DepthImage {
    private final BufferPart pixels;
    private final double scale;
    private final double minDepth;
    private final double maxDepth;

    private DepthImage(BufferPart pixels, double scale, double minDepth, double maxDepth) {
        this.pixels = pixels;
        this.scale = scale;
        this.minDepth = minDepth;
        this.maxDepth = maxDepth;
    }

    /**
     * An image in an array.
     *
     * @param depth the pixels row by row; unsigned, 0 and 65535 (too far) = no measurement
     * @param width columns; must be those of the intrinsics
     * @param height rows; must be those of the intrinsics
     * @param scale length of one unit of the stored value, greater than 0: 0.001 for millimetres when the unit of
     *     length is the metre
     * @return the image
     * @throws IllegalArgumentException when the array has another length
     */
    public static DepthImage of(short[] depth, int width, int height, double scale) {
        return new DepthImage(BufferPart.whole("pixels", ShortBuffer.wrap(depth), width, height), scale, 0, 0);
    }

    /**
     * An image in an array.
     *
     * @param depth the pixels row by row; 0, negative or not finite = no measurement
     * @param width columns; must be those of the intrinsics
     * @param height rows; must be those of the intrinsics
     * @param scale length of one unit of the stored value, greater than 0: 0.001 for millimetres when the unit of
     *     length is the metre
     * @return the image
     * @throws IllegalArgumentException when the array has another length
     */
    public static DepthImage of(float[] depth, int width, int height, double scale) {
        return new DepthImage(BufferPart.whole("pixels", FloatBuffer.wrap(depth), width, height), scale, 0, 0);
    }

    /**
     * An image somewhere in a buffer, from its position to its limit.
     *
     * @param data the buffer; unsigned, 0 and 65535 (too far) = no measurement
     * @param width columns; must be those of the intrinsics
     * @param height rows; must be those of the intrinsics
     * @param scale length of one unit of the stored value, greater than 0: 0.001 for millimetres when the unit of
     *     length is the metre
     * @param offset index of the first pixel of the first row
     * @param pixelStride elements from a pixel to the next one; 0 = 1
     * @param rowStride elements from a row to the next one, negative too; 0 = width * pixelStride
     * @return the image
     * @throws IllegalArgumentException when a pixel lies outside the buffer
     */
    public static DepthImage of(
            ShortBuffer data, int width, int height, double scale, int offset, int pixelStride, int rowStride) {
        return new DepthImage(new BufferPart("pixels", data, 1, width, height, offset, pixelStride, rowStride), scale, 0, 0);
    }

    /**
     * An image somewhere in a buffer, from its position to its limit.
     *
     * @param data the buffer; 0, negative or not finite = no measurement
     * @param width columns; must be those of the intrinsics
     * @param height rows; must be those of the intrinsics
     * @param scale length of one unit of the stored value, greater than 0: 0.001 for millimetres when the unit of
     *     length is the metre
     * @param offset index of the first pixel of the first row
     * @param pixelStride elements from a pixel to the next one; 0 = 1
     * @param rowStride elements from a row to the next one, negative too; 0 = width * pixelStride
     * @return the image
     * @throws IllegalArgumentException when a pixel lies outside the buffer
     */
    public static DepthImage of(
            FloatBuffer data, int width, int height, double scale, int offset, int pixelStride, int rowStride) {
        return new DepthImage(new BufferPart("pixels", data, 1, width, height, offset, pixelStride, rowStride), scale, 0, 0);
    }

    /**
     * The same image with limits of the depth: those of the points, and of the search of a detector. The extent is found
     * with all depths.
     *
     * @param min the nearest depth that becomes a point, in the unit of length, 0 or greater
     * @param max the farthest depth that becomes a point, in the unit of length; 0 = no limit
     * @return another view of the same pixels
     */
    public DepthImage withRange(double min, double max) {
        return new DepthImage(pixels, scale, min, max);
    }

    NativeStructs.DepthView toNative(NativeCopies copies) {
        NativeStructs.DepthView n =
                NativeFunctions.initialised(new NativeStructs.DepthView(), NativeFunctions::cylfuse_depth_view_init);
        n.format = pixels.isFloat() ? Formats.DEPTH_F32 : Formats.DEPTH_U16;
        n.data = pixels.address(copies);
        n.width = pixels.width;
        n.height = pixels.height;
        n.row_stride = pixels.rowStrideBytes();
        n.pixel_stride = pixels.itemStrideBytes();
        n.scale = scale;
        n.min_depth = minDepth;
        n.max_depth = maxDepth;
        return n;
    }
}
