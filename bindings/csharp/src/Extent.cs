namespace Cylfuse
{
    /// <summary>The visible piece of the cylinder: <see cref="End"/> = <see cref="Start"/> + <see cref="Length"/> *
    /// direction of the model.</summary>
    public sealed class Extent
    {
        private readonly NativeExtent native;

        /// <summary>What the end against the direction is.</summary>
        public EndState StartState => (EndState)native.start_state;

        /// <summary>What the end along the direction is.</summary>
        public EndState EndState => (EndState)native.end_state;

        /// <summary>What the position of the start was taken from.</summary>
        public EndSource StartSource => (EndSource)native.start_source;

        /// <summary>What the position of the end was taken from.</summary>
        public EndSource EndSource => (EndSource)native.end_source;

        /// <summary>The view that tells most of the start.</summary>
        public int StartView => (int)native.start_view;

        /// <summary>The view that tells most of the end.</summary>
        public int EndView => (int)native.end_view;

        /// <summary>Whether the limbs of the model were taken as good to a fraction of a pixel, so that the bias of the
        /// mask was read off at them.</summary>
        public bool LimbsKnown => native.limbs_known != 0;

        /// <summary>The end against the direction, a point on the axis.</summary>
        public Vector Start => native.start;

        /// <summary>The end along the direction, a point on the axis.</summary>
        public Vector End => native.end;

        /// <summary>The middle of the ends.</summary>
        public Vector Center => native.center;

        /// <summary>The distance of the ends.</summary>
        public double Length => native.length;

        /// <summary>Standard deviation of the position of the start along the axis, for a model without error; NaN for
        /// an extreme position. Of a start that is not Seen it is that of the visible piece: the cylinder may well go
        /// on.</summary>
        public double StartDeviation => native.start_deviation;

        /// <summary>The same for the end.</summary>
        public double EndDeviation => native.end_deviation;

        /// <summary>Standard deviation of the length together with the uncertainty of the fit, of the visible piece.
        /// This and what follows is NaN for a model that was given, for extreme positions and when the fit has no
        /// uncertainty.</summary>
        public double LengthDeviation => native.length_deviation;

        /// <summary>Covariance of <see cref="Start"/>, 3 x 3, symmetric, unit of length squared.</summary>
        public double[,] StartCovariance { get; }

        /// <summary>Covariance of <see cref="End"/>.</summary>
        public double[,] EndCovariance { get; }

        /// <summary>Covariance of <see cref="Center"/>.</summary>
        public double[,] CenterCovariance { get; }

        internal unsafe Extent(NativeExtent native)
        {
            this.native = native;
            StartCovariance = Native.Square(native.start_covariance, 3);
            EndCovariance = Native.Square(native.end_covariance, 3);
            CenterCovariance = Native.Square(native.center_covariance, 3);
        }
    }
}
