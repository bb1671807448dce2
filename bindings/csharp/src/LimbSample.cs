namespace Cylfuse
{
    /// <summary>What a short piece of a limb in the grey image says.</summary>
    public sealed class LimbSample
    {
        private readonly NativeLimbSample native;

        /// <summary>Where the limb is seen, x and y in pixels of the (distorted) image.</summary>
        public double[] Pixel { get; }

        /// <summary>Standard deviation across the limb in ideal pixels, by the noise of the image only.</summary>
        public double Sigma => native.sigma;

        /// <summary>What the sample counted, from 1 down to 0 for a refused one.</summary>
        public double Weight => native.weight;

        /// <summary>The limb that it belongs to, 0 or 1.</summary>
        public int Limb => (int)native.limb;

        internal unsafe LimbSample(NativeLimbSample native)
        {
            this.native = native;
            Pixel = Native.Copy(native.pixel, 2);
        }
    }
}
