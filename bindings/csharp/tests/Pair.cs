using System;

namespace Cylfuse.Tests
{
    /// <summary>Two cylinders before a wall: what a camera sees of them, the same as a cloud, and who is seen where (0
    /// the wall).</summary>
    internal static class Pair
    {
        internal const int Width = 160, Height = 120;
        internal static readonly Intrinsics Camera = new Intrinsics(Width, Height, 170, 170, 79.5, 59.5);
        internal static readonly Cylinder[] Truths =
        {
            new Cylinder(new Vector(-0.12, 0, 0.7), new Vector(0.1, 0.99, 0.1), 0.05),
            new Cylinder(new Vector(0.13, 0.05, 0.8), new Vector(0.9, 0.3, 0.2), 0.035),
        };
        internal static readonly double[] Lengths = { 0.24, 0.2 };
        internal static readonly float[,] Depth = new float[Height, Width];
        internal static readonly byte[,] Grey = new byte[Height, Width];
        internal static readonly double[,,] Points = new double[Height, Width, 3];
        internal static readonly int[,] Owners = new int[Height, Width];

        static Pair()
        {
            uint state = 1;
            for (int row = 0; row < Height; row++)
                for (int column = 0; column < Width; column++)
                {
                    double z = Seen(column, row, out Owners[row, column]);
                    Grey[row, column] = 40;
                    for (int ray = 0; ray < 16; ray++)
                    {
                        Seen(column + (ray % 4 - 1.5) / 4, row + (ray / 4 - 1.5) / 4, out int owner);
                        if (owner > 0) Grey[row, column] += 10;
                    }
                    // Errors of up to 1 mm, evenly spread.
                    state = unchecked(state * 1664525u + 1013904223u);
                    z += 0.001 * (state / 2147483648.0 - 1);
                    Depth[row, column] = (float)z;
                    Points[row, column, 0] = z * (column - Camera.Cx) / Camera.Fx;
                    Points[row, column, 1] = z * (row - Camera.Cy) / Camera.Fy;
                    Points[row, column, 2] = z;
                }
        }

        internal static Frame Frame(bool withImage = true)
        {
            var frame = new Frame { Intrinsics = Camera };
            frame.SetDepth(DepthImage.From(Depth, 1));
            if (withImage) frame.SetImage(Image.From(Grey));
            return frame;
        }

        internal static double Dot(Vector a, Vector b) => a.X * b.X + a.Y * b.Y + a.Z * b.Z;

        /// <summary>The depth at a place of the image, and who is there.</summary>
        private static double Seen(double column, double row, out int owner)
        {
            var ray = new Vector((column - Camera.Cx) / Camera.Fx, (row - Camera.Cy) / Camera.Fy, 1);
            double depth = 1.2 / (1 + 0.1 * ray.X - 0.2 * ray.Y);
            owner = 0;
            for (int k = 0; k < Truths.Length; k++)
            {
                Vector p = Truths[k].Point, d = Truths[k].Direction;
                double norm = Math.Sqrt(Dot(d, d)), along = Dot(ray, d) / norm, middle = Dot(p, d) / norm;
                double a = Dot(ray, ray) - along * along, b = Dot(ray, p) - along * middle;
                double c = Dot(p, p) - middle * middle - Truths[k].Radius * Truths[k].Radius;
                double z = (b - Math.Sqrt(b * b - a * c)) / a;
                // Not for NaN, where the ray misses.
                if (!(Math.Abs(z * along - middle) <= Lengths[k] / 2 && z < depth)) continue;
                depth = z;
                owner = k + 1;
            }
            return depth;
        }
    }
}
