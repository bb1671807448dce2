using System;

namespace Cylfuse
{
    /// <summary>Points in an array, organised in rows and columns or not. The array is not copied until a call takes
    /// the cloud, and then by the library alone.</summary>
    public sealed class PointCloud
    {
        private readonly ArrayPart points;
        private ArrayPart weights;
        private ArrayPart normals;

        private PointCloud(ArrayPart points)
        {
            this.points = points;
        }

        /// <summary>Columns of an organised cloud, or the number of points.</summary>
        public int Width => points.Width;

        /// <summary>Rows of an organised cloud, or 1.</summary>
        public int Height => points.Height;

        /// <summary>Number of points.</summary>
        public long Count => (long)Width * Height;

        /// <summary>One point a row: n × 3 numbers.</summary>
        /// <exception cref="ArgumentException">The second dimension is not 3.</exception>
        public static PointCloud From(double[,] xyz) => FromRows(xyz);

        /// <summary>One point a row: n × 3 numbers.</summary>
        /// <exception cref="ArgumentException">The second dimension is not 3.</exception>
        public static PointCloud From(float[,] xyz) => FromRows(xyz);

        /// <summary>An organised cloud: rows × columns × 3 numbers.</summary>
        /// <exception cref="ArgumentException">The third dimension is not 3.</exception>
        public static PointCloud From(double[,,] xyz) => FromGrid(xyz);

        /// <summary>An organised cloud: rows × columns × 3 numbers.</summary>
        /// <exception cref="ArgumentException">The third dimension is not 3.</exception>
        public static PointCloud From(float[,,] xyz) => FromGrid(xyz);

        /// <summary>x, y, z of one point after the other.</summary>
        /// <exception cref="ArgumentException">The length is not a multiple of 3.</exception>
        public static PointCloud From(double[] xyz) => FromFlat(xyz);

        /// <summary>x, y, z of one point after the other.</summary>
        /// <exception cref="ArgumentException">The length is not a multiple of 3.</exception>
        public static PointCloud From(float[] xyz) => FromFlat(xyz);

        /// <summary>Points somewhere in an array.</summary>
        /// <param name="data">The array.</param>
        /// <param name="width">Columns, or the number of points.</param>
        /// <param name="height">Rows.</param>
        /// <param name="offset">Index of x of the first point; y and z follow it.</param>
        /// <param name="pointStride">Elements from a point to the next one in its row, negative too; 0 = 3.</param>
        /// <param name="rowStride">Elements from a row to the next one, negative too; 0 = width * pointStride.</param>
        /// <exception cref="ArgumentException">A point lies outside the array.</exception>
        public static PointCloud From(double[] data, int width, int height = 1, int offset = 0, int pointStride = 0,
            int rowStride = 0) =>
            new PointCloud(new ArrayPart("points", data, 3, width, height, offset, pointStride, rowStride));

        /// <summary>Points somewhere in an array.</summary>
        /// <inheritdoc cref="From(double[], int, int, int, int, int)"/>
        public static PointCloud From(float[] data, int width, int height = 1, int offset = 0, int pointStride = 0,
            int rowStride = 0) =>
            new PointCloud(new ArrayPart("points", data, 3, width, height, offset, pointStride, rowStride));

        /// <summary>The same points with weights, 0 or greater; 0 drops a point.</summary>
        /// <param name="data">The array.</param>
        /// <param name="offset">Index of the weight of the first point.</param>
        /// <param name="stride">Elements from a weight to the next one in its row; 0 = 1.</param>
        /// <param name="rowStride">Elements from a row of weights to the next one; 0 = width * stride.</param>
        /// <exception cref="ArgumentException">The coordinates are float, or a weight lies outside the
        /// array.</exception>
        public PointCloud WithWeights(double[] data, int offset = 0, int stride = 0, int rowStride = 0) =>
            Weighted(data, offset, stride, rowStride);

        /// <summary>The same points with weights, 0 or greater; 0 drops a point.</summary>
        /// <inheritdoc cref="WithWeights(double[], int, int, int)"/>
        public PointCloud WithWeights(float[] data, int offset = 0, int stride = 0, int rowStride = 0) =>
            Weighted(data, offset, stride, rowStride);

        /// <summary>The same points with normals of any length and sign, of which one of length 0 or that is not finite
        /// counts as unknown. Only <see cref="Method.Ransac"/> uses them, when all points come with normals.</summary>
        /// <param name="data">The array.</param>
        /// <param name="offset">Index of x of the first normal; y and z follow it.</param>
        /// <param name="stride">Elements from a normal to the next one in its row; 0 = 3.</param>
        /// <param name="rowStride">Elements from a row of normals to the next one; 0 = width * stride.</param>
        /// <exception cref="ArgumentException">The coordinates are float, or a normal lies outside the
        /// array.</exception>
        public PointCloud WithNormals(double[] data, int offset = 0, int stride = 0, int rowStride = 0) =>
            Oriented(data, offset, stride, rowStride);

        /// <summary>The same points with normals.</summary>
        /// <inheritdoc cref="WithNormals(double[], int, int, int)"/>
        public PointCloud WithNormals(float[] data, int offset = 0, int stride = 0, int rowStride = 0) =>
            Oriented(data, offset, stride, rowStride);

        internal unsafe void Write(NativePointsView* native, Pins pins)
        {
            Native.Check(Native.Functions.PointsViewInit(native, (UIntPtr)sizeof(NativePointsView)));
            native->scalar = points.ElementSize == 4 ? Native.ScalarF32 : Native.ScalarF64;
            native->data = points.Pin(pins);
            native->width = (UIntPtr)Width;
            native->height = (UIntPtr)Height;
            native->point_stride = points.ItemStride;
            native->row_stride = points.RowStride;
            if (weights != null)
            {
                native->weights = weights.Pin(pins);
                native->weight_stride = weights.ItemStride;
                native->weight_row_stride = weights.RowStride;
            }
            if (normals != null)
            {
                native->normals = normals.Pin(pins);
                native->normal_stride = normals.ItemStride;
                native->normal_row_stride = normals.RowStride;
            }
        }

        private static PointCloud FromRows(Array xyz)
        {
            if (xyz == null) throw new ArgumentNullException(nameof(xyz));
            ArrayPart.RequireColumns("points", xyz.GetLength(1), 3);
            return new PointCloud(new ArrayPart("points", xyz, 3, xyz.GetLength(0), 1));
        }

        private static PointCloud FromGrid(Array xyz)
        {
            if (xyz == null) throw new ArgumentNullException(nameof(xyz));
            ArrayPart.RequireColumns("points", xyz.GetLength(2), 3);
            return new PointCloud(new ArrayPart("points", xyz, 3, xyz.GetLength(1), xyz.GetLength(0)));
        }

        private static PointCloud FromFlat(Array xyz)
        {
            if (xyz == null) throw new ArgumentNullException(nameof(xyz));
            if (xyz.Length % 3 != 0)
                throw new ArgumentException(
                    $"{xyz.Length} numbers are not x, y, z of points: their count must be a multiple of 3.", nameof(xyz));
            return new PointCloud(new ArrayPart("points", xyz, 3, xyz.Length / 3, 1));
        }

        private PointCloud Weighted(Array data, int offset, int stride, int rowStride)
        {
            var copy = (PointCloud)MemberwiseClone();
            copy.weights = OfSameType(new ArrayPart("weights", data, 1, Width, Height, offset, stride, rowStride),
                "weights");
            return copy;
        }

        private PointCloud Oriented(Array data, int offset, int stride, int rowStride)
        {
            var copy = (PointCloud)MemberwiseClone();
            copy.normals = OfSameType(new ArrayPart("normals", data, 3, Width, Height, offset, stride, rowStride),
                "normals");
            return copy;
        }

        private ArrayPart OfSameType(ArrayPart part, string what)
        {
            if (part.ElementSize != points.ElementSize)
                throw new ArgumentException(
                    $"The {what} are {Name(part)} and the coordinates {Name(points)}: both must be the same type.");
            return part;
        }

        private static string Name(ArrayPart part) => part.ElementSize == 4 ? "float" : "double";
    }
}
