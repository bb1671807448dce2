namespace Cylfuse
{
    /// <summary>What the data determine at a cylinder: the singular values of the stacked Jacobian of the five degrees
    /// of freedom, in units of the size of the data.</summary>
    public sealed class Diagnosis
    {
        private readonly NativeCylinderDiagnosis native;

        /// <summary>How many singular values stand out of the rounding error; 5 when everything is
        /// determined.</summary>
        public int Rank => (int)native.rank;

        /// <summary>Singular values, the largest first.</summary>
        public double[] SingularValues { get; }

        /// <summary>Largest over smallest singular value; may be infinite.</summary>
        public double Condition => native.condition;

        /// <summary>The step along which the residuals change least: how it moves the axis at the middle of the points,
        /// in the unit of length. Shift and radius over the size of the data and the tilt have a joint norm of
        /// 1.</summary>
        public Vector WeakestShift => native.weakest_shift;

        /// <summary>How that step tilts the axis, in radians towards this vector.</summary>
        public Vector WeakestTilt => native.weakest_tilt;

        /// <summary>How that step changes the radius, in the unit of length.</summary>
        public double WeakestRadius => native.weakest_radius;

        internal unsafe Diagnosis(NativeCylinderDiagnosis native)
        {
            this.native = native;
            SingularValues = Native.Copy(native.singular_values, 5);
        }
    }
}
