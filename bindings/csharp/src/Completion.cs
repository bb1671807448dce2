namespace Cylfuse
{
    /// <summary>What became of the pixels of a completion.</summary>
    public sealed class Completion
    {
        private readonly NativeCompletion native;

        /// <summary>The view whose pixels were completed.</summary>
        public int View => (int)native.view;

        /// <summary>Points or pixels that were written.</summary>
        public long Count => (long)native.count;

        /// <summary>Pixels of the mask whose ray meets the cylinder.</summary>
        public long Hits => (long)native.hits;

        /// <summary>Pixels of the mask whose ray passes the cylinder by.</summary>
        public long Misses => (long)native.misses;

        /// <summary>Pixels of the mask for which the camera model has no ray.</summary>
        public long OutsideCamera => (long)native.outside_camera;

        /// <summary>Hits whose depth does not fit the pixel format: written as 0 and not in <see
        /// cref="Count"/>.</summary>
        public long OutOfRange => (long)native.out_of_range;

        internal Completion(NativeCompletion native)
        {
            this.native = native;
        }
    }
}
