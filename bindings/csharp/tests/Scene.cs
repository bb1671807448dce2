using System;

namespace Cylfuse.Tests
{
    /// <summary>A small rendered view of a cylinder: 96 × 80 pixels, radius 0.1, axis tilted in the image and in
    /// depth.</summary>
    internal static class Scene
    {
        internal const int Width = 96, Height = 80;
        internal static readonly Cylinder Truth = new Cylinder(new Vector(0.01, -0.02, 1.0), Unit(0.2, 0.95, 0.24),
            0.1);
        internal static readonly Intrinsics Camera = new Intrinsics(Width, Height, 150, 150, 47.5, 39.5);

        /// <summary>z of the near wall in units of 0.1 mm, 0 where the ray misses or the pixel is near the
        /// border.</summary>
        internal static ushort[,] Depth() => Depth(Truth);

        /// <summary>That of a cylinder in the camera frame.</summary>
        internal static ushort[,] Depth(Cylinder cylinder)
        {
            var depth = new ushort[Height, Width];
            for (int v = 4; v < Height - 4; v++)
                for (int u = 4; u < Width - 4; u++)
                    depth[v, u] = (ushort)Math.Round(NearWall(cylinder, (u - Camera.Cx) / Camera.Fx,
                        (v - Camera.Cy) / Camera.Fy) / 1e-4);
            return depth;
        }

        internal static byte[,] Mask() => Mask(Truth);

        internal static byte[,] Mask(Cylinder cylinder)
        {
            ushort[,] depth = Depth(cylinder);
            var mask = new byte[Height, Width];
            for (int v = 0; v < Height; v++)
                for (int u = 0; u < Width; u++)
                    mask[v, u] = (byte)(depth[v, u] > 0 ? 255 : 0);
            return mask;
        }

        /// <summary>Bright on the cylinder, dark beside it.</summary>
        internal static byte[,] Grey()
        {
            byte[,] image = Mask();
            for (int v = 0; v < Height; v++)
                for (int u = 0; u < Width; u++) image[v, u] = (byte)(image[v, u] > 0 ? 200 : 50);
            return image;
        }

        /// <summary>A camera that looks at the cylinder from 30 degrees beside the first one.</summary>
        internal static readonly RigidMotion Aside = new RigidMotion(
            new[,] { { Math.Sqrt(0.75), 0, 0.5 }, { 0, 1, 0 }, { -0.5, 0, Math.Sqrt(0.75) } },
            new Vector(-0.5, 0, 1 - Math.Sqrt(0.75)));

        /// <summary>The cylinder in the frame of a camera with a pose.</summary>
        internal static Cylinder Seen(RigidMotion pose)
        {
            Vector t = pose.Translation, p = Truth.Point;
            return new Cylinder(Back(pose.Rotation, new Vector(p.X - t.X, p.Y - t.Y, p.Z - t.Z)),
                Back(pose.Rotation, Truth.Direction), Truth.Radius);
        }

        private static Vector Back(double[,] r, Vector x) => new Vector(
            r[0, 0] * x.X + r[1, 0] * x.Y + r[2, 0] * x.Z, r[0, 1] * x.X + r[1, 1] * x.Y + r[2, 1] * x.Z,
            r[0, 2] * x.X + r[1, 2] * x.Y + r[2, 2] * x.Z);

        /// <summary>Pushes the depth that a camera with a pose sees into the selected view.</summary>
        internal static void PushView(Fitter fitter, RigidMotion pose)
        {
            Cylinder seen = Seen(pose);
            fitter.Intrinsics = Camera;
            fitter.SetPose(pose);
            fitter.PushDepth(DepthImage.From(Depth(seen), 1e-4), Cylfuse.Mask.From(Mask(seen)));
        }

        /// <summary>The two limb lines between the rows 10 and 70.</summary>
        internal static double[,] Edges()
        {
            double[,] lines = Truth.Project(Camera);
            var edges = new double[2, 4];
            for (int k = 0; k < 2; k++)
                for (int end = 0; end < 2; end++)
                {
                    double v = end == 0 ? 10 : 70;
                    edges[k, 2 * end] = -(lines[k, 1] * v + lines[k, 2]) / lines[k, 0];
                    edges[k, 2 * end + 1] = v;
                }
            return edges;
        }

        /// <summary>A fitter with everything pushed.</summary>
        internal static Fitter Loaded()
        {
            var fitter = new Fitter { Intrinsics = Camera };
            fitter.PushDepth(DepthImage.From(Depth(), 1e-4), Cylfuse.Mask.From(Mask()));
            fitter.PushEdges(Edges());
            return fitter;
        }

        /// <summary>A quarter of a pipe of radius 0.5 along y.</summary>
        internal static double[,] Pipe(int count = 200)
        {
            var points = new double[count, 3];
            for (int k = 0; k < count; k++)
            {
                points[k, 0] = 0.5 * Math.Cos(0.008 * k);
                points[k, 1] = 0.1 * (k % 7);
                points[k, 2] = 2.0 - 0.5 * Math.Sin(0.008 * k);
            }
            return points;
        }

        private static double NearWall(Cylinder cylinder, double x, double y)
        {
            // |(t r - p) × d|² = R² for the ray t r with r = (x, y, 1), so that t is the depth.
            Vector p = cylinder.Point, d = cylinder.Direction;
            double rd = x * d.X + y * d.Y + d.Z, pd = p.X * d.X + p.Y * d.Y + p.Z * d.Z;
            double a = x * x + y * y + 1 - rd * rd;
            double b = x * p.X + y * p.Y + p.Z - rd * pd;
            double c = p.X * p.X + p.Y * p.Y + p.Z * p.Z - pd * pd - cylinder.Radius * cylinder.Radius;
            double discriminant = b * b - a * c;
            return discriminant < 0 ? 0 : (b - Math.Sqrt(discriminant)) / a;
        }

        private static Vector Unit(double x, double y, double z)
        {
            double length = Math.Sqrt(x * x + y * y + z * z);
            return new Vector(x / length, y / length, z / length);
        }
    }
}
