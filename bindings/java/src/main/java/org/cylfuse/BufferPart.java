package org.cylfuse;

import com.sun.jna.Native;
import com.sun.jna.Pointer;
import java.math.BigInteger;
import java.nio.Buffer;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.DoubleBuffer;
import java.nio.FloatBuffer;
import java.nio.ShortBuffer;
import java.util.Objects;

/**
 * The elements of a buffer that a view takes: a grid of items of a few neighbouring elements each, of which every one
 * is checked to lie between the position and the limit of the buffer.
 */
final class BufferPart {
    private final Buffer buffer;
    private final int first;
    private final int last;
    private final int offset;
    private final int itemStride;
    private final int rowStride;
    final int width;
    final int height;

    /**
     * @param what the name of the items in messages, in the plural
     * @param data the buffer
     * @param components elements of an item
     * @param width items of a row
     * @param height rows
     * @param offset index of the first element of the first item, from the position of the buffer
     * @param itemStride elements from an item to the next one; 0 = components
     * @param rowStride elements from a row to the next one; 0 = width * itemStride
     */
    BufferPart(String what, Buffer data, int components, int width, int height, int offset, int itemStride, int rowStride) {
        Objects.requireNonNull(data, what);
        if (width < 0 || height < 0) {
            throw new IllegalArgumentException(
                    width + " x " + height + " " + what + " cannot be: neither number may be negative.");
        }
        // A slice of its own: the caller may move the position later.
        this.buffer = data.slice();
        this.width = width;
        this.height = height;
        this.offset = offset;
        this.itemStride = itemStride;
        this.rowStride = rowStride;
        if (width == 0 || height == 0) {
            first = offset;
            last = offset - 1;
            return;
        }
        BigInteger item = BigInteger.valueOf(itemStride == 0 ? components : itemStride);
        BigInteger row = rowStride == 0 ? item.multiply(BigInteger.valueOf(width)) : BigInteger.valueOf(rowStride);
        BigInteger alongRow = item.multiply(BigInteger.valueOf(width - 1));
        BigInteger alongColumn = row.multiply(BigInteger.valueOf(height - 1));
        BigInteger start = BigInteger.valueOf(offset);
        BigInteger lowest = start.add(alongRow.min(BigInteger.ZERO)).add(alongColumn.min(BigInteger.ZERO));
        BigInteger highest = start.add(alongRow.max(BigInteger.ZERO))
                .add(alongColumn.max(BigInteger.ZERO))
                .add(BigInteger.valueOf(components - 1));
        if (lowest.signum() < 0 || highest.compareTo(BigInteger.valueOf(buffer.limit())) >= 0) {
            throw new IllegalArgumentException(width + " x " + height + " " + what + " need the elements " + lowest + " to "
                    + highest + " of an array that has " + buffer.limit()
                    + ": check its length, the width and height, the offset and the strides.");
        }
        first = lowest.intValueExact();
        last = highest.intValueExact();
    }

    /** A packed grid. */
    BufferPart(String what, Buffer data, int components, int width, int height) {
        this(what, data, components, width, height, 0, 0, 0);
    }

    /** A packed grid that must fill its buffer. */
    static BufferPart whole(String what, Buffer data, int width, int height) {
        if ((long) width * height != data.remaining()) {
            throw new IllegalArgumentException(
                    width + " x " + height + " " + what + " are not the " + data.remaining() + " elements of the array.");
        }
        return new BufferPart(what, data, 1, width, height);
    }

    boolean isDouble() {
        return buffer instanceof DoubleBuffer;
    }

    boolean isFloat() {
        return buffer instanceof FloatBuffer;
    }

    boolean isByte() {
        return buffer instanceof ByteBuffer;
    }

    long itemStrideBytes() {
        return (long) itemStride * elementSize();
    }

    long rowStrideBytes() {
        return (long) rowStride * elementSize();
    }

    /**
     * The address of the first item, valid until {@code copies} is closed. Only a direct buffer in the byte order of
     * the machine has one of its own; of others the elements from the first to the last that is needed are copied.
     */
    Pointer address(NativeCopies copies) {
        if (last < first) {
            return Pointer.NULL;
        }
        if (buffer.isDirect() && order() == ByteOrder.nativeOrder()) {
            // The slice begins at the position of the caller's buffer, and its address is that of its first element.
            return copies.keep(buffer, Native.getDirectBufferPointer(buffer).share((long) offset * elementSize()));
        }
        int count = last - first + 1;
        Pointer copy = copies.allocate((long) count * elementSize());
        ByteBuffer target = copy.getByteBuffer(0, (long) count * elementSize()).order(ByteOrder.nativeOrder());
        Buffer source = buffer.duplicate().position(first).limit(last + 1);
        if (source instanceof DoubleBuffer doubles) {
            target.asDoubleBuffer().put(doubles);
        } else if (source instanceof FloatBuffer floats) {
            target.asFloatBuffer().put(floats);
        } else if (source instanceof ShortBuffer shorts) {
            target.asShortBuffer().put(shorts);
        } else {
            target.put((ByteBuffer) source);
        }
        return copy.share((long) (offset - first) * elementSize());
    }

    private int elementSize() {
        return isDouble() ? Double.BYTES : isFloat() ? Float.BYTES : isByte() ? Byte.BYTES : Short.BYTES;
    }

    private ByteOrder order() {
        if (buffer instanceof DoubleBuffer doubles) {
            return doubles.order();
        }
        if (buffer instanceof FloatBuffer floats) {
            return floats.order();
        }
        // Bytes have no order.
        return buffer instanceof ShortBuffer shorts ? shorts.order() : ByteOrder.nativeOrder();
    }
}
