namespace Cylfuse
{
    /// <summary>What became of the pixels of a completion.</summary>
    public sealed class Completion
    {
        /// <summary>Points or pixels that were written; after <see cref="Status.BufferTooSmall"/> the capacity that is
        /// needed.</summary>
        public long Count { get; }

        /// <summary>Pixels of the mask whose ray meets the cylinder.</summary>
        public long Hits { get; }

        /// <summary>Pixels of the mask whose ray passes the cylinder by.</summary>
        public long Misses { get; }

        /// <summary>Pixels of the mask for which the camera model has no ray.</summary>
        public long OutsideCamera { get; }

        /// <summary>Hits whose depth does not fit the pixel format: written as 0 and not in <see
        /// cref="Count"/>.</summary>
        public long OutOfRange { get; }

        internal unsafe Completion(NativeCompletion* native)
        {
            Count = (long)native->count;
            Hits = (long)native->hits;
            Misses = (long)native->misses;
            OutsideCamera = (long)native->outside_camera;
            OutOfRange = (long)native->out_of_range;
        }
    }
}
