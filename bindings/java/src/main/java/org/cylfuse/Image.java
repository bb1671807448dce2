package org.cylfuse;

import java.nio.ByteBuffer;
import java.nio.FloatBuffer;
import java.nio.ShortBuffer;

/**
 * An image on the pixels of the camera, grey or in colour. Its values have no unit, but are those of the light, as they
 * are or with a gamma, not an equalised or filtered picture. Nothing is copied until a call takes the image, and then a
 * direct buffer by the library alone.
 */
public final class Image {
    private final BufferPart pixels;
    private final int format;
    private final double gamma;

    private Image(BufferPart pixels) {
        this(pixels, pixels.isByte() ? Formats.IMAGE_U8 : pixels.isFloat() ? Formats.IMAGE_F32 : Formats.IMAGE_U16, 1);
    }

    private Image(BufferPart pixels, int format, double gamma) {
        this.pixels = pixels;
        this.format = format;
        this.gamma = gamma;
    }

    /**
     * An image in colour in an array.
     *
     * @param image the pixels row by row, 3 or 4 values each; unsigned
     * @param width columns; must be those of the intrinsics
     * @param height rows; must be those of the intrinsics
     * @param format the order of the values
     * @return the image
     * @throws IllegalArgumentException when the array has another length
     */
    public static Image of(byte[] image, int width, int height, ColourFormat format) {
        if ((long) width * height * format.channels() != image.length) {
            throw new IllegalArgumentException(width + " x " + height + " pixels of " + format.channels()
                    + " values are not the " + image.length + " elements of the array.");
        }
        return of(ByteBuffer.wrap(image), width, height, format, 0, 0, 0);
    }

    /**
     * An image in colour somewhere in a buffer, from its position to its limit.
     *
     * @param data the buffer; unsigned
     * @param width columns; must be those of the intrinsics
     * @param height rows; must be those of the intrinsics
     * @param format the order of the values of a pixel, which follow each other
     * @param offset index of the first value of the first row
     * @param pixelStride elements from a pixel to the next one; 0 = 3 or 4 by the format
     * @param rowStride elements from a row to the next one, negative too; 0 = width * pixelStride
     * @return the image
     * @throws IllegalArgumentException when a pixel lies outside the buffer
     */
    public static Image of(
            ByteBuffer data, int width, int height, ColourFormat format, int offset, int pixelStride, int rowStride) {
        return new Image(
                new BufferPart("pixels", data, format.channels(), width, height, offset, pixelStride, rowStride),
                format.value(),
                1);
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
    public static Image of(byte[] image, int width, int height) {
        return new Image(BufferPart.whole("pixels", ByteBuffer.wrap(image), width, height));
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
    public static Image of(short[] image, int width, int height) {
        return new Image(BufferPart.whole("pixels", ShortBuffer.wrap(image), width, height));
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
    public static Image of(float[] image, int width, int height) {
        return new Image(BufferPart.whole("pixels", FloatBuffer.wrap(image), width, height));
    }

    /**
     * An image somewhere in a buffer, from its position to its limit.
     *
     * @param data the buffer; unsigned
     * @param width columns; must be those of the intrinsics
     * @param height rows; must be those of the intrinsics
     * @param offset index of the first pixel of the first row
     * @param pixelStride elements from a pixel to the next one; 0 = 1
     * @param rowStride elements from a row to the next one, negative too; 0 = width * pixelStride
     * @return the image
     * @throws IllegalArgumentException when a pixel lies outside the buffer
     */
    public static Image of(ByteBuffer data, int width, int height, int offset, int pixelStride, int rowStride) {
        return new Image(new BufferPart("pixels", data, 1, width, height, offset, pixelStride, rowStride));
    }

    /**
     * An image somewhere in a buffer, from its position to its limit.
     *
     * @param data the buffer; unsigned
     * @param width columns; must be those of the intrinsics
     * @param height rows; must be those of the intrinsics
     * @param offset index of the first pixel of the first row
     * @param pixelStride elements from a pixel to the next one; 0 = 1
     * @param rowStride elements from a row to the next one, negative too; 0 = width * pixelStride
     * @return the image
     * @throws IllegalArgumentException when a pixel lies outside the buffer
     */
    public static Image of(ShortBuffer data, int width, int height, int offset, int pixelStride, int rowStride) {
        return new Image(new BufferPart("pixels", data, 1, width, height, offset, pixelStride, rowStride));
    }

    /**
     * An image somewhere in a buffer, from its position to its limit.
     *
     * @param data the buffer; finite
     * @param width columns; must be those of the intrinsics
     * @param height rows; must be those of the intrinsics
     * @param offset index of the first pixel of the first row
     * @param pixelStride elements from a pixel to the next one; 0 = 1
     * @param rowStride elements from a row to the next one, negative too; 0 = width * pixelStride
     * @return the image
     * @throws IllegalArgumentException when a pixel lies outside the buffer
     */
    public static Image of(FloatBuffer data, int width, int height, int offset, int pixelStride, int rowStride) {
        return new Image(new BufferPart("pixels", data, 1, width, height, offset, pixelStride, rowStride));
    }

    /**
     * The same image with a gamma.
     *
     * @param gamma light is the value to this power, from 0.1 to 10: 1, as without it, for values linear in light; 2.2
     *     is about sRGB. With another one than 1 no value may be negative.
     * @return another view of the same pixels
     */
    public Image withGamma(double gamma) {
        return new Image(pixels, format, gamma);
    }

    NativeStructs.ImageView toNative(NativeCopies copies) {
        NativeStructs.ImageView n =
                NativeFunctions.initialised(new NativeStructs.ImageView(), NativeFunctions::cylfuse_image_view_init);
        n.format = format;
        n.data = pixels.address(copies);
        n.width = pixels.width;
        n.height = pixels.height;
        n.row_stride = pixels.rowStrideBytes();
        n.pixel_stride = pixels.itemStrideBytes();
        n.gamma = gamma;
        return n;
    }
}
