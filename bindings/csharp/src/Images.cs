using System;

namespace Cylfuse
{
    /// <summary>A depth image in an array, on the pixels of the camera, or of the depth camera where there is one. A
    /// value is z, not the distance along the ray. The array is not copied until a call takes the image, and then by
    /// the library alone.</summary>
    public sealed class DepthImage
    {
        private readonly ArrayPart pixels;

        private DepthImage(ArrayPart pixels, double scale)
        {
            this.pixels = pixels;
            Scale = scale;
        }

        /// <summary>Length of one unit of the stored value, greater than 0: 0.001 for millimetres when the unit of
        /// length is the metre.</summary>
        public double Scale { get; }

        /// <summary>The nearest depth that becomes a point, in the unit of length, 0 or greater. Default 0. Both limits are
        /// those of the points, and of the search of a detector: the extent is found with all depths.</summary>
        public double MinDepth { get; set; }

        /// <summary>The farthest depth that becomes a point, in the unit of length. Default 0 = no limit.</summary>
        public double MaxDepth { get; set; }

        /// <summary>Rows × columns of integers; 0 and 65535 (too far) = no measurement.</summary>
        public static DepthImage From(ushort[,] depth, double scale) => new DepthImage(Grid.Of("pixels", depth), scale);

        /// <summary>Rows × columns of floating-point numbers; 0, negative or not finite = no measurement.</summary>
        public static DepthImage From(float[,] depth, double scale = 1.0) =>
            new DepthImage(Grid.Of("pixels", depth), scale);

        /// <summary>An image somewhere in an array.</summary>
        /// <param name="data">The array.</param>
        /// <param name="width">Columns; must be those of the intrinsics.</param>
        /// <param name="height">Rows; must be those of the intrinsics.</param>
        /// <param name="scale">Length of one unit of the stored value.</param>
        /// <param name="offset">Index of the first pixel of the first row.</param>
        /// <param name="pixelStride">Elements from a pixel to the next one; 0 = 1.</param>
        /// <param name="rowStride">Elements from a row to the next one, negative too; 0 = width * pixelStride.</param>
        /// <exception cref="ArgumentException">A pixel lies outside the array.</exception>
        public static DepthImage From(ushort[] data, int width, int height, double scale, int offset = 0,
            int pixelStride = 0, int rowStride = 0) =>
            new DepthImage(new ArrayPart("pixels", data, 1, width, height, offset, pixelStride, rowStride), scale);

        /// <summary>An image somewhere in an array.</summary>
        /// <inheritdoc cref="From(ushort[], int, int, double, int, int, int)"/>
        public static DepthImage From(float[] data, int width, int height, double scale = 1.0, int offset = 0,
            int pixelStride = 0, int rowStride = 0) =>
            new DepthImage(new ArrayPart("pixels", data, 1, width, height, offset, pixelStride, rowStride), scale);

        internal unsafe void Write(NativeDepthView* native, Pins pins)
        {
            Native.Check(Native.Functions.DepthViewInit(native, (UIntPtr)sizeof(NativeDepthView)));
            native->format = pixels.ElementSize == 2 ? Native.DepthFormatU16 : Native.DepthFormatF32;
            native->data = pixels.Pin(pins);
            native->width = (uint)pixels.Width;
            native->height = (uint)pixels.Height;
            native->row_stride = pixels.RowStride;
            native->pixel_stride = pixels.ItemStride;
            native->scale = Scale;
            native->min_depth = MinDepth;
            native->max_depth = MaxDepth;
        }
    }

    /// <summary>A mask in an array, on the pixels of the colour image: non-zero = the cylinder. It may hold the lateral
    /// surface alone, or the whole object with caps, lids and handles: with the objective Robust a fit leaves out what the
    /// depth image shows to be no part of the lateral surface. Its boundary may be some pixels off: it is a hint and never
    /// measured.</summary>
    public sealed class Mask
    {
        private readonly ArrayPart pixels;

        private Mask(ArrayPart pixels)
        {
            this.pixels = pixels;
        }

        /// <summary>In an image of labels, that of the cylinder, 1 to 255: the pixels of this value are the mask.
        /// Default 0 = all pixels that are not 0.</summary>
        public byte Label { get; set; }

        /// <summary>Rows × columns of bytes, which are not copied until a call takes them.</summary>
        public static Mask From(byte[,] mask) => new Mask(Grid.Of("pixels", mask));

        /// <summary>Rows × columns, copied.</summary>
        public static Mask From(bool[,] mask)
        {
            if (mask == null) throw new ArgumentNullException(nameof(mask));
            // An array of bool cannot be pinned. Its elements are bytes.
            var bytes = new byte[mask.GetLength(0), mask.GetLength(1)];
            Buffer.BlockCopy(mask, 0, bytes, 0, bytes.Length);
            return From(bytes);
        }

        /// <summary>A mask somewhere in an array.</summary>
        /// <param name="data">The array.</param>
        /// <param name="width">Columns.</param>
        /// <param name="height">Rows.</param>
        /// <param name="offset">Index of the first pixel of the first row.</param>
        /// <param name="pixelStride">Elements from a pixel to the next one; 0 = 1.</param>
        /// <param name="rowStride">Elements from a row to the next one, negative too; 0 = width * pixelStride.</param>
        /// <exception cref="ArgumentException">A pixel lies outside the array.</exception>
        public static Mask From(byte[] data, int width, int height, int offset = 0, int pixelStride = 0,
            int rowStride = 0) =>
            new Mask(new ArrayPart("pixels", data, 1, width, height, offset, pixelStride, rowStride));

        /// <summary>Fills the struct and gives its address; null where there is no mask.</summary>
        internal static unsafe NativeMaskView* Write(Mask mask, NativeMaskView* native, Pins pins)
        {
            if (mask == null) return null;
            Native.Check(Native.Functions.MaskViewInit(native, (UIntPtr)sizeof(NativeMaskView)));
            native->label = mask.Label;
            native->data = mask.pixels.Pin(pins);
            native->width = (uint)mask.pixels.Width;
            native->height = (uint)mask.pixels.Height;
            native->row_stride = mask.pixels.RowStride;
            native->pixel_stride = mask.pixels.ItemStride;
            return native;
        }
    }

    /// <summary>Arrays of rows × columns.</summary>
    internal static class Grid
    {
        internal static ArrayPart Of(string what, Array rows)
        {
            if (rows == null) throw new ArgumentNullException(nameof(rows), $"The array of the {what} is null.");
            return new ArrayPart(what, rows, 1, rows.GetLength(1), rows.GetLength(0));
        }
    }
}
