using System;
using System.Globalization;

namespace Cylfuse
{
    /// <summary>An infinite cylinder.</summary>
    public sealed class Cylinder
    {
        /// <summary>A point on the axis, in the unit of length of the data.</summary>
        public Vector Point { get; }

        /// <summary>The direction of the axis: as input of any length but 0, from the library of length 1. Its sign has
        /// no meaning; the library gives the one with a positive largest component.</summary>
        public Vector Direction { get; }

        /// <summary>The radius in the unit of length of the data, greater than 0.</summary>
        public double Radius { get; }

        /// <summary>A cylinder. The numbers are checked by the call that takes it.</summary>
        public Cylinder(Vector point, Vector direction, double radius)
        {
            Point = point;
            Direction = direction;
            Radius = radius;
        }

        internal Cylinder(NativeCylinder native) : this(native.point, native.direction, native.radius) { }

        /// <summary>Signed distances of points from the surface, negative inside, row by row of the points; NaN for a
        /// point with a coordinate that is not finite. Weights are ignored.</summary>
        /// <exception cref="CylfuseException">The cylinder is none (InvalidArgument).</exception>
        public unsafe double[] Distances(PointCloud points)
        {
            if (points == null) throw new ArgumentNullException(nameof(points));
            using (var pins = new Pins())
            {
                NativeCylinder model = ToNative();
                NativePointsView view;
                points.Write(&view, pins);
                var distances = new double[points.Count];
                fixed (double* buffer = distances)
                {
                    Native.Check(Native.Functions.CylinderDistances(&model, &view, buffer,
                        (UIntPtr)distances.Length));
                }
                return distances;
            }
        }

        /// <summary>The two limb lines in the image, one a row: a u + b v + c = 0 with a² + b² = 1, in ideal pixels,
        /// which are those of a pinhole with the same fx, fy, cx and cy: without distortion the pixels of the
        /// image.</summary>
        /// <returns>2 × 3 numbers: a, b, c of the first line, then of the second.</returns>
        /// <exception cref="CylfuseException">The camera is inside the cylinder or a line lies at infinity
        /// (EdgeGeometry); InvalidArgument, InvalidIntrinsics.</exception>
        public unsafe double[,] Project(Intrinsics intrinsics)
        {
            if (intrinsics == null) throw new ArgumentNullException(nameof(intrinsics));
            NativeCylinder model = ToNative();
            NativeIntrinsics camera;
            intrinsics.Write(&camera);
            var lines = new double[2, 3];
            fixed (double* buffer = lines)
            {
                Native.Check(Native.Functions.CylinderProject(&model, &camera, buffer));
            }
            return lines;
        }

        /// <summary>How another cylinder differs from this one, which is the truth, say.</summary>
        /// <exception cref="CylfuseException">One of the cylinders is none (InvalidArgument).</exception>
        public unsafe CylinderDifference Compare(Cylinder other)
        {
            if (other == null) throw new ArgumentNullException(nameof(other));
            NativeCylinder a = ToNative(), b = other.ToNative();
            Native.Check(Native.Functions.CylinderCompare(&a, &b, out double angle, out double axisDistance,
                out double radiusRelative));
            return new CylinderDifference(angle, axisDistance, radiusRelative);
        }

        /// <inheritdoc/>
        public override string ToString() => string.Format(
            CultureInfo.InvariantCulture, "Cylinder: radius {0}, axis through {1} along {2}", Radius, Point, Direction);

        /// <summary>Fills the struct and gives its address; null where there is no cylinder.</summary>
        internal static unsafe NativeCylinder* Write(Cylinder cylinder, NativeCylinder* native)
        {
            if (cylinder == null) return null;
            *native = cylinder.ToNative();
            return native;
        }

        private NativeCylinder ToNative() =>
            new NativeCylinder { point = Point, direction = Direction, radius = Radius };
    }

    /// <summary>How two cylinders differ.</summary>
    public sealed class CylinderDifference
    {
        /// <summary>Angle between the axes in radians, in [0, π/2], whatever the signs of the directions.</summary>
        public double Angle { get; }

        /// <summary>Shortest distance between the two axes, in the unit of length.</summary>
        public double AxisDistance { get; }

        /// <summary>(radius of the second - radius of the first) / radius of the first.</summary>
        public double RadiusRelative { get; }

        internal CylinderDifference(double angle, double axisDistance, double radiusRelative)
        {
            Angle = angle;
            AxisDistance = axisDistance;
            RadiusRelative = radiusRelative;
        }
    }
}
