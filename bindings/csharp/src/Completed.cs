namespace Cylfuse
{
    /// <summary>The points of a completion.</summary>
    /// <typeparam name="T">Type of a coordinate: double or float.</typeparam>
    public sealed class CompletedCloud<T> where T : struct
    {
        /// <summary>x, y, z of one point after the other, in the reference frame: only the points that exist when
        /// packed, one for each pixel of the image and NaN where there is none when organised.</summary>
        public T[] Coordinates { get; }

        /// <summary>Columns of the image when organised, else the number of points.</summary>
        public int Width { get; }

        /// <summary>Rows of the image when organised, else 1.</summary>
        public int Height { get; }

        /// <summary>What became of the pixels.</summary>
        public Completion Pixels { get; }

        internal CompletedCloud(T[] coordinates, int width, int height, Completion pixels)
        {
            Coordinates = coordinates;
            Width = width;
            Height = height;
            Pixels = pixels;
        }
    }

    /// <summary>The depth image of a completion.</summary>
    /// <typeparam name="T">Type of a pixel: float or ushort.</typeparam>
    public sealed class CompletedDepth<T> where T : struct
    {
        /// <summary>Rows × columns of depths, 0 where there is none.</summary>
        public T[,] Depth { get; }

        /// <summary>What became of the pixels.</summary>
        public Completion Pixels { get; }

        internal CompletedDepth(T[,] depth, Completion pixels)
        {
            Depth = depth;
            Pixels = pixels;
        }
    }
}
