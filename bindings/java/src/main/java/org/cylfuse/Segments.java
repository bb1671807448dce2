package org.cylfuse;

import java.nio.Buffer;
import java.nio.DoubleBuffer;
import java.nio.FloatBuffer;

/**
 * Edge segments: pieces of the two lines that bound the cylinder in the (distorted) image, each x1, y1, x2, y2 in
 * pixels, its endpoints in any order.
 */
public final class Segments {
    private final BufferPart segments;
    private final BufferPart weights;

    private Segments(BufferPart segments, BufferPart weights) {
        this.segments = segments;
        this.weights = weights;
    }

    /**
     * Segments, copied.
     *
     * @param segments one segment a row
     * @return the segments
     * @throws IllegalArgumentException when a row has not 4 numbers
     */
    public static Segments of(double[]... segments) {
        return of(DoubleBuffer.wrap(Rows.flatten("segment", segments, 4)), segments.length, 0, 0);
    }

    /**
     * Segments somewhere in a buffer, from its position to its limit.
     *
     * @param data the buffer
     * @param count number of segments
     * @param offset index of x1 of the first segment; y1, x2 and y2 follow it
     * @param stride elements from a segment to the next one, negative too; 0 = 4
     * @return the segments
     * @throws IllegalArgumentException when a segment lies outside the buffer
     */
    public static Segments of(DoubleBuffer data, int count, int offset, int stride) {
        return new Segments(new BufferPart("segments", data, 4, count, 1, offset, stride, 0), null);
    }

    /**
     * Segments somewhere in a buffer, from its position to its limit.
     *
     * @param data the buffer
     * @param count number of segments
     * @param offset index of x1 of the first segment; y1, x2 and y2 follow it
     * @param stride elements from a segment to the next one, negative too; 0 = 4
     * @return the segments
     * @throws IllegalArgumentException when a segment lies outside the buffer
     */
    public static Segments of(FloatBuffer data, int count, int offset, int stride) {
        return new Segments(new BufferPart("segments", data, 4, count, 1, offset, stride, 0), null);
    }

    /**
     * The same segments with weights.
     *
     * @param data one weight a segment, 0 or greater; 0 leaves the segment out
     * @return other segments on the same numbers
     * @throws IllegalArgumentException when the number of weights is wrong
     */
    public Segments withWeights(double... data) {
        Buffer buffer = DoubleBuffer.wrap(data);
        return new Segments(segments, BufferPart.whole("weights", buffer, segments.width, 1));
    }

    /**
     * Number of segments.
     *
     * @return the number
     */
    public int count() {
        return segments.width;
    }

    NativeStructs.SegmentsView toNative(NativeCopies copies) {
        NativeStructs.SegmentsView n =
                NativeFunctions.initialised(new NativeStructs.SegmentsView(), NativeFunctions::cylfuse_segments_view_init);
        n.scalar = segments.isDouble() ? Formats.SCALAR_F64 : Formats.SCALAR_F32;
        n.data = segments.address(copies);
        n.count = segments.width;
        n.segment_stride = segments.itemStrideBytes();
        if (weights != null) {
            n.weights = weights.address(copies);
        }
        return n;
    }
}
