namespace Cylfuse
{
    /// <summary>A sample on the arc of an end of the cylinder in the image.</summary>
    public sealed class EndSample
    {
        private readonly NativeEndSample native;

        /// <summary>The view, from 0.</summary>
        public int View => (int)native.view;

        /// <summary>0 for the start of the extent, 1 for its end.</summary>
        public int End => (int)native.end;

        /// <summary>Where the arc is seen, x and y in pixels of the (distorted) image.</summary>
        public double[] Pixel { get; }

        /// <summary>The unit vector across the arc in the image, away from the surface.</summary>
        public double[] Normal { get; }

        /// <summary>Standard deviation along <see cref="Normal"/>, in pixels.</summary>
        public double Deviation => native.deviation;

        internal unsafe EndSample(NativeEndSample native)
        {
            this.native = native;
            Pixel = Native.Copy(native.pixel, 2);
            Normal = Native.Copy(native.normal, 2);
        }
    }
}
