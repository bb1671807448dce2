namespace Cylfuse
{
    /// <summary>What was pushed, and what was left out by reason.</summary>
    public sealed class Counts
    {
        /// <summary>Points and pixels that were pushed.</summary>
        public long PointsGiven { get; }

        /// <summary>Points that a fit uses.</summary>
        public long PointsUsed { get; }

        /// <summary>Left out: a coordinate or weight is not finite.</summary>
        public long DroppedNotFinite { get; }

        /// <summary>Left out: the weight is 0.</summary>
        public long DroppedZeroWeight { get; }

        /// <summary>Left out: the mask is 0 there.</summary>
        public long DroppedOutsideMask { get; }

        /// <summary>Left out: no depth was measured there.</summary>
        public long DroppedNoDepth { get; }

        /// <summary>Left out: the depth is below <see cref="DepthImage.MinDepth"/> or above <see
        /// cref="DepthImage.MaxDepth"/>.</summary>
        public long DroppedOutOfRange { get; }

        /// <summary>Left out: the camera model has no ray for the pixel.</summary>
        public long DroppedOutsideCamera { get; }

        /// <summary>Edge segments that were pushed; <see cref="FitResult.SegmentsUsed"/> says how many count.</summary>
        public long SegmentsGiven { get; }

        internal unsafe Counts(NativeCounts* native)
        {
            PointsGiven = (long)native->points_given;
            PointsUsed = (long)native->points_used;
            DroppedNotFinite = (long)native->dropped_not_finite;
            DroppedZeroWeight = (long)native->dropped_zero_weight;
            DroppedOutsideMask = (long)native->dropped_outside_mask;
            DroppedNoDepth = (long)native->dropped_no_depth;
            DroppedOutOfRange = (long)native->dropped_out_of_range;
            DroppedOutsideCamera = (long)native->dropped_outside_camera;
            SegmentsGiven = (long)native->segments_given;
        }
    }
}
