package org.cylfuse;

import java.nio.ByteBuffer;

/**
 * A mask on the pixels of the colour image: non-zero = the cylinder. It may hold the lateral surface alone, or the whole
 * object with caps, lids and handles: with the objective ROBUST a fit leaves out what the depth image shows to be no part of
 * the lateral surface. Its boundary may be some pixels off: it is a hint and never measured.
 */
public final class Mask {
    private final BufferPart pixels;
    private final int label;

    private Mask(BufferPart pixels) {
        this(pixels, 0);
    }

    private Mask(BufferPart pixels, int label) {
        this.pixels = pixels;
        this.label = label;
    }

    /**
     * A mask in an array.
     *
     * @param mask the pixels row by row
     * @param width columns
     * @param height rows
     * @return the mask
     * @throws IllegalArgumentException when the array has another length
     */
    public static Mask of(byte[] mask, int width, int height) {
        return new Mask(BufferPart.whole("pixels", ByteBuffer.wrap(mask), width, height));
    }

    /**
     * A mask, copied.
     *
     * @param mask the pixels row by row
     * @param width columns
     * @param height rows
     * @return the mask
     * @throws IllegalArgumentException when the array has another length
     */
    public static Mask of(boolean[] mask, int width, int height) {
        byte[] bytes = new byte[mask.length];
        for (int k = 0; k < bytes.length; k++) {
            bytes[k] = (byte) (mask[k] ? 1 : 0);
        }
        return of(bytes, width, height);
    }

    /**
     * A mask somewhere in a buffer, from its position to its limit.
     *
     * @param data the buffer
     * @param width columns
     * @param height rows
     * @param offset index of the first pixel of the first row
     * @param pixelStride elements from a pixel to the next one; 0 = 1
     * @param rowStride elements from a row to the next one, negative too; 0 = width * pixelStride
     * @return the mask
     * @throws IllegalArgumentException when a pixel lies outside the buffer
     */
    public static Mask of(ByteBuffer data, int width, int height, int offset, int pixelStride, int rowStride) {
        return new Mask(new BufferPart("pixels", data, 1, width, height, offset, pixelStride, rowStride));
    }

    /**
     * The pixels of one label in an image of labels.
     *
     * @param label that of the cylinder, 1 to 255; 0 = all pixels that are not 0
     * @return another mask of the same pixels
     */
    public Mask withLabel(int label) {
        return new Mask(pixels, label);
    }

    NativeStructs.MaskView toNative(NativeCopies copies) {
        NativeStructs.MaskView n =
                NativeFunctions.initialised(new NativeStructs.MaskView(), NativeFunctions::cylfuse_mask_view_init);
        n.label = label;
        n.data = pixels.address(copies);
        n.width = pixels.width;
        n.height = pixels.height;
        n.row_stride = pixels.rowStrideBytes();
        n.pixel_stride = pixels.itemStrideBytes();
        return n;
    }

    /** NULL where there is no mask. */
    static NativeStructs.MaskView toNative(Mask mask, NativeCopies copies) {
        return mask == null ? null : mask.toNative(copies);
    }
}
