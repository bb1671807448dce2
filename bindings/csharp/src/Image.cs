using System;

namespace Cylfuse
{
    /// <summary>The order of the values of a pixel in colour, each a byte. A fourth one (alpha) is ignored.</summary>
    public enum ColourFormat
    {
        /// <summary>Red, green, blue.</summary>
        Rgb8 = 4,
        /// <summary>Blue, green, red, as OpenCV reads image files.</summary>
        Bgr8 = 5,
        /// <summary>Red, green, blue, alpha.</summary>
        Rgba8 = 6,
        /// <summary>Blue, green, red, alpha.</summary>
        Bgra8 = 7,
    }

    /// <summary>An image in an array, grey or in colour, on the pixels of the camera. Its values have no unit, but are
    /// those of the light, as they are or with a gamma, not an equalised or filtered picture. The array is not copied
    /// until a call takes the image, and then by the library alone.</summary>
    public sealed class Image
    {
        private readonly ArrayPart pixels;
        private readonly int format;

        private Image(ArrayPart pixels)
        {
            this.pixels = pixels;
            format = pixels.ElementSize == 1 ? Native.ImageFormatU8
                : pixels.ElementSize == 2 ? Native.ImageFormatU16 : Native.ImageFormatF32;
        }

        private Image(ArrayPart pixels, ColourFormat colours)
        {
            this.pixels = pixels;
            format = (int)colours;
        }

        /// <summary>Light is the value to this power, from 0.1 to 10. Default 1: values linear in light; 2.2 is about
        /// sRGB. With another one than 1 no value may be negative.</summary>
        public double Gamma { get; set; } = 1;

        /// <summary>Rows × columns × 3 or 4 values of a pixel.</summary>
        /// <param name="image">The values.</param>
        /// <param name="format">Their order.</param>
        /// <exception cref="ArgumentException">The third dimension is not that of the format.</exception>
        public static Image From(byte[,,] image, ColourFormat format)
        {
            if (image == null) throw new ArgumentNullException(nameof(image));
            ArrayPart.RequireColumns("pixels", image.GetLength(2), Channels(format));
            return new Image(new ArrayPart("pixels", image, Channels(format), image.GetLength(1), image.GetLength(0)), format);
        }

        /// <summary>An image in colour somewhere in an array.</summary>
        /// <param name="data">The array.</param>
        /// <param name="width">Columns; must be those of the intrinsics.</param>
        /// <param name="height">Rows; must be those of the intrinsics.</param>
        /// <param name="format">The order of the values of a pixel, which follow each other.</param>
        /// <param name="offset">Index of the first value of the first row.</param>
        /// <param name="pixelStride">Elements from a pixel to the next one; 0 = 3 or 4 by the format.</param>
        /// <param name="rowStride">Elements from a row to the next one, negative too; 0 = width * pixelStride.</param>
        /// <exception cref="ArgumentException">A pixel lies outside the array.</exception>
        public static Image From(byte[] data, int width, int height, ColourFormat format, int offset = 0,
            int pixelStride = 0, int rowStride = 0) =>
            new Image(new ArrayPart("pixels", data, Channels(format), width, height, offset, pixelStride, rowStride), format);

        private static int Channels(ColourFormat format) =>
            format == ColourFormat.Rgb8 || format == ColourFormat.Bgr8 ? 3 : 4;

        /// <summary>Rows × columns of values.</summary>
        public static Image From(byte[,] image) => new Image(Grid.Of("pixels", image));

        /// <summary>Rows × columns of values.</summary>
        public static Image From(ushort[,] image) => new Image(Grid.Of("pixels", image));

        /// <summary>Rows × columns of values, finite.</summary>
        public static Image From(float[,] image) => new Image(Grid.Of("pixels", image));

        /// <summary>An image somewhere in an array.</summary>
        /// <param name="data">The array.</param>
        /// <param name="width">Columns; must be those of the intrinsics.</param>
        /// <param name="height">Rows; must be those of the intrinsics.</param>
        /// <param name="offset">Index of the first pixel of the first row.</param>
        /// <param name="pixelStride">Elements from a pixel to the next one; 0 = 1.</param>
        /// <param name="rowStride">Elements from a row to the next one, negative too; 0 = width * pixelStride.</param>
        /// <exception cref="ArgumentException">A pixel lies outside the array.</exception>
        public static Image From(byte[] data, int width, int height, int offset = 0, int pixelStride = 0,
            int rowStride = 0) =>
            new Image(new ArrayPart("pixels", data, 1, width, height, offset, pixelStride, rowStride));

        /// <summary>An image somewhere in an array.</summary>
        /// <inheritdoc cref="From(byte[], int, int, int, int, int)"/>
        public static Image From(ushort[] data, int width, int height, int offset = 0, int pixelStride = 0,
            int rowStride = 0) =>
            new Image(new ArrayPart("pixels", data, 1, width, height, offset, pixelStride, rowStride));

        /// <summary>An image somewhere in an array.</summary>
        /// <inheritdoc cref="From(byte[], int, int, int, int, int)"/>
        public static Image From(float[] data, int width, int height, int offset = 0, int pixelStride = 0,
            int rowStride = 0) =>
            new Image(new ArrayPart("pixels", data, 1, width, height, offset, pixelStride, rowStride));

        internal unsafe void Write(NativeImageView* native, Pins pins)
        {
            Native.Check(Native.Functions.ImageViewInit(native, (UIntPtr)sizeof(NativeImageView)));
            native->format = format;
            native->data = pixels.Pin(pins);
            native->width = (uint)pixels.Width;
            native->height = (uint)pixels.Height;
            native->row_stride = pixels.RowStride;
            native->pixel_stride = pixels.ItemStride;
            native->gamma = Gamma;
        }
    }
}
