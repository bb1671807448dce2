namespace Cylfuse
{
    /// <summary>A limb of the cylinder in the image of one view: where it was located, or why it was not.</summary>
    public sealed class LimbLine
    {
        private readonly NativeLimb native;

        /// <summary>The view, from 0.</summary>
        public int View => (int)native.view;

        /// <summary>The limb, 0 or 1, in the order of <see cref="Cylinder.Project"/>.</summary>
        public int Limb => (int)native.limb;

        /// <summary>Whether the limb was located, or why not.</summary>
        public LimbStatus Status => (LimbStatus)native.status;

        /// <summary>How many pieces of it <see cref="Fitter.LimbSamples"/> lists.</summary>
        public int Samples => (int)native.samples;

        /// <summary>x1 y1 x2 y2: the two points of the located line whose errors across it are independent and equally
        /// large, in ideal pixels. They need not lie on the part that was seen. NaN when the limb was not
        /// located.</summary>
        public double[] Line { get; }

        /// <summary>Standard deviation of either point across the line, in ideal pixels; NaN when the limb was not
        /// located.</summary>
        public double Deviation => native.deviation;

        internal unsafe LimbLine(NativeLimb native)
        {
            this.native = native;
            Line = Native.Copy(native.line, 4);
        }
    }
}
