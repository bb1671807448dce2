namespace Cylfuse
{
    /// <summary>How far a detector is: before the search, after it, and after each fit.
    /// A cloud that is searched from many places begins again with each.</summary>
    public sealed class DetectionProgress
    {
        private readonly NativeDetectionProgress native;

        /// <summary>What the detector is doing.</summary>
        public DetectionPhase Phase => (DetectionPhase)native.phase;

        /// <summary>Cylinders that are fitted.</summary>
        public int FitsDone => (int)native.fits_done;

        /// <summary>Cylinders to fit; 0 before the search.</summary>
        public int Fits => (int)native.fits;

        internal DetectionProgress(NativeDetectionProgress native)
        {
            this.native = native;
        }
    }
}
