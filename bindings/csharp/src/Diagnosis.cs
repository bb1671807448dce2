namespace Cylfuse
{
    /// <summary>What the data determine at a cylinder: the singular values of the stacked Jacobian of the five degrees
    /// of freedom, in units of the size of the data.</summary>
    public sealed class Diagnosis
    {
        /// <summary>How many singular values stand out of the rounding error; 5 when everything is
        /// determined.</summary>
        public int Rank { get; }

        /// <summary>Singular values, the largest first.</summary>
        public double[] SingularValues { get; }

        /// <summary>Largest over smallest singular value; may be infinite.</summary>
        public double Condition { get; }

        /// <summary>The step along which the residuals change least: how it moves the axis at the middle of the points,
        /// in the unit of length,</summary>
        public Vector WeakestShift { get; }

        /// <summary>how it tilts the axis, in radians towards this vector,</summary>
        public Vector WeakestTilt { get; }

        /// <summary>and how it changes the radius, in the unit of length. Shift and radius over the size of the data
        /// and the tilt have a joint norm of 1.</summary>
        public double WeakestRadius { get; }

        internal unsafe Diagnosis(NativeDiagnosis* native)
        {
            Rank = (int)native->rank;
            SingularValues = Native.Copy(native->singular_values, 5);
            Condition = native->condition;
            WeakestShift = new Vector(native->weakest_shift);
            WeakestTilt = new Vector(native->weakest_tilt);
            WeakestRadius = native->weakest_radius;
        }
    }
}
