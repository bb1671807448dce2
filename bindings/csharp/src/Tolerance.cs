namespace Cylfuse
{
    /// <summary>The limits of a radius, a diameter or another length.</summary>
    public sealed class Tolerance
    {
        /// <summary>The lower limit, which conforms itself; negative infinity for none.</summary>
        public double Lower { get; }

        /// <summary>The upper limit likewise, greater than the lower one; infinity for none.</summary>
        public double Upper { get; }

        /// <summary>The coverage factor k: standard deviations on either side of a value.</summary>
        public double Coverage { get; }

        /// <summary>Limits; the decision checks them.</summary>
        public Tolerance(double lower, double upper, double coverage = 2.0)
        {
            Lower = lower;
            Upper = upper;
            Coverage = coverage;
        }

        /// <summary>Decides by the rule of ISO 14253-1 whether a length conforms: only where the value with <see
        /// cref="Coverage"/> deviations on either side lies within the limits, and not only where it lies outside. <see
        /// cref="FitResult.RadiusConforms"/> and <see cref="FitResult.DiameterConforms"/> ask for those of a fit.</summary>
        /// <param name="value">The value.</param>
        /// <param name="deviation">Its standard deviation; NaN, and 0 as of a radius that the limits of the fit fix, decide
        /// nothing. A wrong scale of the depth and wrong intrinsics are in none.</param>
        /// <param name="flags">The warnings of the result. With one of which a deviation says nothing, such as PoorFit or
        /// RadiusAtLimit, nothing is decided.</param>
        /// <exception cref="CylfuseException">Limits, a value or a deviation that are none (InvalidArgument).</exception>
        public Conformity Decide(double value, double deviation, ResultFlags flags = ResultFlags.None)
        {
            Native.Check(Native.Functions.DecideConformity(
                value, deviation, (uint)flags, Lower, Upper, Coverage, out int conformity));
            return (Conformity)conformity;
        }
    }
}
