package org.cylfuse;

import java.nio.ByteBuffer;
import java.nio.FloatBuffer;
import java.nio.ShortBuffer;

/**
 * A grey image on the pixels of the camera. Its values have no unit, but are those of the light, as they are or with a
 * gamma, not an equalised or filtered picture. Nothing is copied until a call takes the image, and then a direct buffer by
 * the library alone.
 */
public final class GreyImage {
    private final BufferPart pixels;
    private final double gamma;

    private GreyImage(BufferPart pixels) {
        this(pixels, 1);
    }

    private GreyImage(BufferPart pixels, double gamma) {
        this.pixels = pixels;
        this.gamma = gamma;
    }

    /**
     * An image in an array.
     *
     * @param image the pixels row by row; unsigned
     * @param width columns; must be those of the intrinsics
     * @param height rows; must be those of the intrinsics
     * @return the image
     * @throws IllegalArgumentException when the array has another length
     */
    public static GreyImage of(byte[] image, int width, int height) {
        return new GreyImage(BufferPart.whole("pixels", ByteBuffer.wrap(image), width, height));
    }

    /**
     * An image in an array.
     *
     * @param image the pixels row by row; unsigned
     * @param width columns; must be those of the intrinsics
     * @param height rows; must be those of the intrinsics
     * @return the image
     * @throws IllegalArgumentException when the array has another length
     */
    public static GreyImage of(short[] image, int width, int height) {
        return new GreyImage(BufferPart.whole("pixels", ShortBuffer.wrap(image), width, height));
    }

    /**
     * An image in an array.
     *
     * @param image the pixels row by row; finite
     * @param width columns; must be those of the intrinsics
     * @param height rows; must be those of the intrinsics
     * @return the image
     * @throws IllegalArgumentException when the array has another length
     */
    public static GreyImage of(float[] image, int width, int height) {
        return new GreyImage(BufferPart.whole("pixels", FloatBuffer.wrap(image), width, height));
    }

    /**
     * An image somewhere in a buffer, from its position to its limit.
     *
     * @param data the buffer; unsigned
     * @param width columns; must be those of the intrinsics
     * @param height rows; must be those of the intrinsics
     * @param offset index of the first pixel of the first row
     * @param pixelStride elements from a pixel to the next one; 0 = 1; 3 for the first of packed colours
     * @param rowStride elements from a row to the next one, negative too; 0 = width * pixelStride
     * @return the image
     * @throws IllegalArgumentException when a pixel lies outside the buffer
     */
    public static GreyImage of(ByteBuffer data, int width, int height, int offset, int pixelStride, int rowStride) {
        return new GreyImage(new BufferPart("pixels", data, 1, width, height, offset, pixelStride, rowStride));
    }

    /**
     * An image somewhere in a buffer, from its position to its limit.
     *
     * @param data the buffer; unsigned
     * @param width columns; must be those of the intrinsics
     * @param height rows; must be those of the intrinsics
     * @param offset index of the first pixel of the first row
     * @param pixelStride elements from a pixel to the next one; 0 = 1; 3 for the first of packed colours
     * @param rowStride elements from a row to the next one, negative too; 0 = width * pixelStride
     * @return the image
     * @throws IllegalArgumentException when a pixel lies outside the buffer
     */
    public static GreyImage of(ShortBuffer data, int width, int height, int offset, int pixelStride, int rowStride) {
        return new GreyImage(new BufferPart("pixels", data, 1, width, height, offset, pixelStride, rowStride));
    }

    /**
     * An image somewhere in a buffer, from its position to its limit.
     *
     * @param data the buffer; finite
     * @param width columns; must be those of the intrinsics
     * @param height rows; must be those of the intrinsics
     * @param offset index of the first pixel of the first row
     * @param pixelStride elements from a pixel to the next one; 0 = 1; 3 for the first of packed colours
     * @param rowStride elements from a row to the next one, negative too; 0 = width * pixelStride
     * @return the image
     * @throws IllegalArgumentException when a pixel lies outside the buffer
     */
    public static GreyImage of(FloatBuffer data, int width, int height, int offset, int pixelStride, int rowStride) {
        return new GreyImage(new BufferPart("pixels", data, 1, width, height, offset, pixelStride, rowStride));
    }

    /**
     * The same image with values that are coded with a gamma.
     *
     * @param gamma the power of the value that is light, from 0.1 to 10: 1 for values linear in light, as which an image is
     *     taken without it; 2.2 for sRGB, in which cameras and image files usually come
     * @return another view of the same pixels
     */
    public GreyImage withGamma(double gamma) {
        return new GreyImage(pixels, gamma);
    }

    NativeStructs.ImageView toNative(NativeCopies copies) {
        NativeStructs.ImageView n = new NativeStructs.ImageView();
        NativeFunctions.check(NativeFunctions.cylfuse_image_view_init(n, n.size()));
        n.format = pixels.isByte() ? Formats.IMAGE_U8 : pixels.isFloat() ? Formats.IMAGE_F32 : Formats.IMAGE_U16;
        n.data = pixels.address(copies);
        n.width = pixels.width;
        n.height = pixels.height;
        n.row_stride = pixels.rowStrideBytes();
        n.pixel_stride = pixels.itemStrideBytes();
        n.gamma = gamma;
        return n;
    }
}
