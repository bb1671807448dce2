namespace Cylfuse
{
    /// <summary>What was pushed into one view, and what was left out by reason.</summary>
    public sealed class Counts
    {
        private readonly NativeCounts native;

        /// <summary>The view that the counts are of.</summary>
        public int View => (int)native.view;

        /// <summary>Points and pixels that were pushed.</summary>
        public long PointsGiven => (long)native.points_given;

        /// <summary>Points that a fit uses.</summary>
        public long PointsUsed => (long)native.points_used;

        /// <summary>Left out: a coordinate or weight is not finite.</summary>
        public long DroppedNotFinite => (long)native.dropped_not_finite;

        /// <summary>Left out: the weight is 0.</summary>
        public long DroppedZeroWeight => (long)native.dropped_zero_weight;

        /// <summary>Left out: the mask is 0 there.</summary>
        public long DroppedOutsideMask => (long)native.dropped_outside_mask;

        /// <summary>Left out: no depth was measured there.</summary>
        public long DroppedNoDepth => (long)native.dropped_no_depth;

        /// <summary>Left out: the depth is outside the range of the depth image.</summary>
        public long DroppedOutOfRange => (long)native.dropped_out_of_range;

        /// <summary>Left out: the camera model has no ray for the pixel.</summary>
        public long DroppedOutsideCamera => (long)native.dropped_outside_camera;

        /// <summary>Left out: the mask is set there, but the colour camera sees something nearer. Only with a depth
        /// camera of its own.</summary>
        public long DroppedHidden => (long)native.dropped_hidden;

        /// <summary>Edge segments that were pushed; <see cref="FitResult.SegmentsUsed"/> of a result says how many
        /// count.</summary>
        public long SegmentsGiven => (long)native.segments_given;

        internal Counts(NativeCounts native)
        {
            this.native = native;
        }
    }
}
