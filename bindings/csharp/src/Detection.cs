namespace Cylfuse
{
    /// <summary>A cylinder of a scene.</summary>
    public sealed class Detection
    {
        /// <summary>The probability that there is a cylinder.</summary>
        public double Score { get; }

        /// <summary>Pixels of its region; points for a cloud.</summary>
        public long Pixels { get; }

        /// <summary>The outcome of its fit. Residuals, completion and so on are asked of <see
        /// cref="Detector.MakeFitter"/>.</summary>
        public FitResult Result { get; }

        /// <summary>Its visible piece; that of a cylinder of a cloud ends with its points; null where there is
        /// none.</summary>
        public Extent Extent { get; }

        /// <summary>Why there is no <see cref="Extent"/>; null where there is one.</summary>
        public CylfuseException ExtentError { get; }

        internal Detection(NativeDetection native, FitResult result, Extent extent, CylfuseException extentError)
        {
            Score = native.score;
            Pixels = (long)native.pixels;
            Result = result;
            Extent = extent;
            ExtentError = extentError;
        }
    }
}
