namespace Cylfuse
{
    /// <summary>The visible piece of the cylinder: <see cref="End"/> = <see cref="Start"/> + <see cref="Length"/> *
    /// direction of the model.</summary>
    public sealed class Extent
    {
        /// <summary>What the end against the direction is.</summary>
        public EndState StartState { get; }

        /// <summary>What the end along the direction is.</summary>
        public EndState EndState { get; }

        /// <summary>The end against the direction, a point on the axis.</summary>
        public Vector Start { get; }

        /// <summary>The end along the direction, a point on the axis.</summary>
        public Vector End { get; }

        /// <summary>The middle of the ends.</summary>
        public Vector Center { get; }

        /// <summary>The distance of the ends.</summary>
        public double Length { get; }

        /// <summary>Standard deviation of the position of the start along the axis, for a model without error; NaN for
        /// an extreme position. Of a start that is not Seen it is that of the visible piece: the cylinder may well go
        /// on.</summary>
        public double StartDeviation { get; }

        /// <summary>The same for the end.</summary>
        public double EndDeviation { get; }

        /// <summary>Standard deviation of the length together with the uncertainty of the fit, of the visible piece.
        /// This and what follows is NaN for a model that was given, for extreme positions and when the fit has no
        /// uncertainty.</summary>
        public double LengthDeviation { get; }

        /// <summary>Covariance of <see cref="Start"/>, 3 x 3, symmetric, unit of length squared.</summary>
        public double[,] StartCovariance { get; }

        /// <summary>Covariance of <see cref="End"/>.</summary>
        public double[,] EndCovariance { get; }

        /// <summary>Covariance of <see cref="Center"/>.</summary>
        public double[,] CenterCovariance { get; }

        internal unsafe Extent(NativeExtent* native)
        {
            StartState = (EndState)native->start_state;
            EndState = (EndState)native->end_state;
            Start = new Vector(native->start);
            End = new Vector(native->end);
            Center = new Vector(native->center);
            Length = native->length;
            StartDeviation = native->start_deviation;
            EndDeviation = native->end_deviation;
            LengthDeviation = native->length_deviation;
            StartCovariance = Native.Square(native->start_covariance, 3);
            EndCovariance = Native.Square(native->end_covariance, 3);
            CenterCovariance = Native.Square(native->center_covariance, 3);
        }
    }
}
