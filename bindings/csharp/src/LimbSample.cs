namespace Cylfuse
{
    /// <summary>What a short piece of a limb in the image says.</summary>
    public sealed class LimbSample
    {
        private readonly NativeLimbSample native;

        /// <summary>The view, from 0.</summary>
        public int View => (int)native.view;

        /// <summary>The limb that it belongs to, 0 or 1, in the order of <see cref="Cylinder.Project"/>.</summary>
        public int Limb => (int)native.limb;

        /// <summary>Where the limb is seen, x and y in pixels of the (distorted) image.</summary>
        public double[] Pixel { get; }

        /// <summary>Standard deviation across the limb in ideal pixels, by the noise of the image only.</summary>
        public double Deviation => native.deviation;

        /// <summary>Its part in the line, from 1 down to 0 for a refused sample.</summary>
        public double Weight => native.weight;

        internal unsafe LimbSample(NativeLimbSample native)
        {
            this.native = native;
            Pixel = Native.Copy(native.pixel, 2);
        }
    }
}
