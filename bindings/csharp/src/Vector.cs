using System;
using System.Globalization;
using System.Runtime.InteropServices;

namespace Cylfuse
{
    /// <summary>Three numbers: a point or a direction. Camera frame: x to the right, y down, z forward.</summary>
    // Three numbers in this order: it stands in the structs of the library.
    [StructLayout(LayoutKind.Sequential)]
    public struct Vector : IEquatable<Vector>
    {
        /// <summary>The x coordinate.</summary>
        public double X { get; }

        /// <summary>The y coordinate.</summary>
        public double Y { get; }

        /// <summary>The z coordinate.</summary>
        public double Z { get; }

        /// <summary>A vector of three coordinates.</summary>
        public Vector(double x, double y, double z)
        {
            X = x;
            Y = y;
            Z = z;
        }

        /// <inheritdoc/>
        public bool Equals(Vector other) => X.Equals(other.X) && Y.Equals(other.Y) && Z.Equals(other.Z);

        /// <inheritdoc/>
        public override bool Equals(object other) => other is Vector vector && Equals(vector);

        /// <inheritdoc/>
        public override int GetHashCode() => (X.GetHashCode() * 397 ^ Y.GetHashCode()) * 397 ^ Z.GetHashCode();

        /// <inheritdoc/>
        public override string ToString() => string.Format(CultureInfo.InvariantCulture, "({0}, {1}, {2})", X, Y, Z);
    }
}
