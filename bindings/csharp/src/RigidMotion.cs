using System;

namespace Cylfuse
{
    /// <summary>A rotation and a translation: x' = rotation * x + translation. The call that takes it checks the
    /// numbers.</summary>
    public sealed class RigidMotion
    {
        /// <summary>A rotation matrix, 3 x 3, to 1e-4.</summary>
        public double[,] Rotation { get; }

        /// <summary>The translation, in the unit of length.</summary>
        public Vector Translation { get; }

        /// <summary>A motion.</summary>
        /// <param name="rotation">A rotation matrix, 3 x 3, copied.</param>
        /// <param name="translation">The translation.</param>
        /// <exception cref="ArgumentException">The matrix is not 3 x 3.</exception>
        public RigidMotion(double[,] rotation, Vector translation)
        {
            if (rotation == null) throw new ArgumentNullException(nameof(rotation));
            if (rotation.GetLength(0) != 3 || rotation.GetLength(1) != 3)
                throw new ArgumentException(
                    $"The rotation is {rotation.GetLength(0)} x {rotation.GetLength(1)}; it must be 3 x 3.", nameof(rotation));
            Rotation = (double[,])rotation.Clone();
            Translation = translation;
        }

        /// <summary>The motion that leaves everything where it is.</summary>
        public static RigidMotion Identity =>
            new RigidMotion(new double[,] { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } }, new Vector());

        /// <summary>A function that takes rotation and translation.</summary>
        internal unsafe delegate int Taker(double* rotation, double* translation);

        /// <summary>Hands the numbers to a function.</summary>
        internal unsafe int Give(Taker taker)
        {
            Vector translation = Translation;
            fixed (double* rotation = Rotation) return taker(rotation, (double*)&translation);
        }
    }
}
