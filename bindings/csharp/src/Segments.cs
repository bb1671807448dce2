using System;

namespace Cylfuse
{
    /// <summary>Edge segments in an array: pieces of the two lines that bound the cylinder in the (distorted) image,
    /// each x1, y1, x2, y2 in pixels, its endpoints in any order.</summary>
    public sealed class Segments
    {
        private readonly ArrayPart segments;
        private ArrayPart weights;

        private Segments(ArrayPart segments)
        {
            this.segments = segments;
        }

        /// <summary>Number of segments.</summary>
        public int Count => segments.Width;

        /// <summary>One segment a row: n × 4 numbers.</summary>
        /// <exception cref="ArgumentException">The second dimension is not 4.</exception>
        public static Segments From(double[,] segments) => FromRows(segments);

        /// <summary>One segment a row: n × 4 numbers.</summary>
        /// <exception cref="ArgumentException">The second dimension is not 4.</exception>
        public static Segments From(float[,] segments) => FromRows(segments);

        /// <summary>Segments somewhere in an array.</summary>
        /// <param name="data">The array.</param>
        /// <param name="count">Number of segments.</param>
        /// <param name="offset">Index of x1 of the first segment; y1, x2 and y2 follow it.</param>
        /// <param name="stride">Elements from a segment to the next one, negative too; 0 = 4.</param>
        /// <exception cref="ArgumentException">A segment lies outside the array.</exception>
        public static Segments From(double[] data, int count, int offset = 0, int stride = 0) =>
            new Segments(new ArrayPart("segments", data, 4, count, 1, offset, stride));

        /// <summary>Segments somewhere in an array.</summary>
        /// <inheritdoc cref="From(double[], int, int, int)"/>
        public static Segments From(float[] data, int count, int offset = 0, int stride = 0) =>
            new Segments(new ArrayPart("segments", data, 4, count, 1, offset, stride));

        /// <summary>The same segments with weights, 0 or greater; 0 leaves a segment out.</summary>
        /// <exception cref="ArgumentException">The number of weights is not that of the segments.</exception>
        public Segments WithWeights(double[] data)
        {
            if (data == null) throw new ArgumentNullException(nameof(data));
            if (data.Length != Count)
                throw new ArgumentException($"There are {data.Length} weights for {Count} segments.", nameof(data));
            var copy = (Segments)MemberwiseClone();
            copy.weights = new ArrayPart("weights", data, 1, Count, 1);
            return copy;
        }

        internal unsafe void Write(NativeSegmentsView* native, Pins pins)
        {
            Native.Check(Native.Functions.SegmentsViewInit(native, (UIntPtr)sizeof(NativeSegmentsView)));
            native->scalar = segments.ElementSize == 4 ? Native.ScalarF32 : Native.ScalarF64;
            native->data = segments.Pin(pins);
            native->count = (UIntPtr)Count;
            native->segment_stride = segments.ItemStride;
            if (weights != null) native->weights = weights.Pin(pins);
        }

        private static Segments FromRows(Array segments)
        {
            if (segments == null) throw new ArgumentNullException(nameof(segments));
            ArrayPart.RequireColumns("segments", segments.GetLength(1), 4);
            return new Segments(new ArrayPart("segments", segments, 4, segments.GetLength(0), 1));
        }
    }
}
