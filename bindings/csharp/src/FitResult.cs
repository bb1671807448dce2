namespace Cylfuse
{
    /// <summary>The outcome of a fit with the numbers to judge it. NaN stands for what does not apply.</summary>
    public sealed class FitResult
    {
        /// <summary>Why the iteration ended.</summary>
        public Termination Termination { get; }

        /// <summary>How the start was found.</summary>
        public StartKind StartKind { get; }

        /// <summary>Doubts, <see cref="ResultFlags"/> by bit; 0 when there are none.</summary>
        public ResultFlags Flags { get; }

        /// <summary>Linear solves.</summary>
        public int Iterations { get; }

        /// <summary>Solves whose step was rejected.</summary>
        public int RejectedSteps { get; }

        /// <summary>Segments that took part.</summary>
        public int SegmentsUsed { get; }

        /// <summary>Segments that were pushed.</summary>
        public int SegmentsGiven { get; }

        /// <summary>Points that took part.</summary>
        public long PointsUsed { get; }

        /// <summary>Points that were pushed; <see cref="Fitter.Counts()"/> says why the others were left out.</summary>
        public long PointsGiven { get; }

        /// <summary>The cylinder, its axis point the one nearest to the middle of the points.</summary>
        public Cylinder Model { get; }

        /// <summary>The model that the iteration started from, moved into the limits.</summary>
        public Cylinder StartModel { get; }

        /// <summary>Cost of the start, unit of length squared.</summary>
        public double InitialCost { get; }

        /// <summary>Cost of the cylinder, unit of length squared.</summary>
        public double Cost { get; }

        /// <summary>E_P: mean squared distance of the points from the surface, unit of length squared.</summary>
        public double EnergyPoints { get; }

        /// <summary>E_L: mean squared distance of the back-projected endpoints from the limb lines, unit of length
        /// squared; NaN without exactly two usable segments.</summary>
        public double EnergyEdges { get; }

        /// <summary>The edge weight that was used, 0 when no edges count; NaN where the objective has none.</summary>
        public double EdgeWeight { get; }

        /// <summary>Root of E_P, unit of length.</summary>
        public double PointRms { get; }

        /// <summary>Root mean square distance of the endpoints from the limb lines in ideal pixels; NaN without
        /// edges.</summary>
        public double EdgeRmsPixels { get; }

        /// <summary>The part of the points on the wall that the camera sees; NaN when the origin is no
        /// camera.</summary>
        public double NearWallFraction { get; }

        /// <summary>Condition number of the Jacobian at the cylinder, in units of the size of the data; may be
        /// infinite.</summary>
        public double Condition { get; }

        /// <summary>The last damping.</summary>
        public double Lambda { get; }

        /// <summary>Norm of half the gradient of the cost at the end, as far as the limits leave it free, in units of
        /// the size of the data.</summary>
        public double GradientNorm { get; }

        /// <summary>Norm of the last accepted step, in units of the size of the data.</summary>
        public double StepNorm { get; }

        /// <summary>Wall-clock seconds to find the start.</summary>
        public double SecondsStart { get; }

        /// <summary>Wall-clock seconds to iterate.</summary>
        public double SecondsSolve { get; }

        /// <summary>Wall-clock seconds of the whole fit.</summary>
        public double SecondsTotal { get; }

        /// <summary>Standard deviation of the radius, unit of length. This and what follows is that of the noise of the
        /// data, with the weights that were used and the correlation of the depth noise along the order of the points;
        /// errors that all data share (calibration, a scale of the depth) are not in it. NaN for RANSAC and Eberly, for
        /// an edge weight of 1, and where the data do not determine a cylinder.</summary>
        public double RadiusDeviation { get; }

        /// <summary>Standard deviation of the direction in radians: the tilt in the plane in which it is least
        /// certain.</summary>
        public double DirectionDeviation { get; }

        /// <summary>Standard deviation of the position of the axis across itself, at <see cref="Cylinder.Point"/> and
        /// in the direction in which it is least certain, unit of length.</summary>
        public double PositionDeviation { get; }

        /// <summary>The radius by the curvature of the points alone, unit of length; NaN without segments or limbs, and
        /// where the points alone determine no cylinder.</summary>
        public double RadiusFromPoints { get; }

        /// <summary>Its standard deviation.</summary>
        public double RadiusFromPointsDeviation { get; }

        /// <summary>The radius by the limbs, with distance and tilt of the axis from the points, unit of length; NaN
        /// likewise.</summary>
        public double RadiusFromLimbs { get; }

        /// <summary>Its standard deviation.</summary>
        public double RadiusFromLimbsDeviation { get; }

        /// <summary><see cref="RadiusFromPoints"/> minus <see cref="RadiusFromLimbs"/> in standard deviations of the
        /// difference; beyond 4 the flag <see cref="ResultFlags.PointsAndLimbsDisagree"/> is set.</summary>
        public double RadiusZScore { get; }

        /// <summary>Covariance of (<see cref="Cylinder.Point"/>, <see cref="Cylinder.Direction"/>, <see
        /// cref="Cylinder.Radius"/>), 7 x 7, symmetric, of rank 5; element [i, j] is that of the numbers i and
        /// j.</summary>
        public double[,] Covariance { get; }

        /// <summary>Limb lines that were located in the grey image and took part, 0 to 2.</summary>
        public int LimbsLocated { get; }

        internal unsafe FitResult(NativeResult* native)
        {
            Termination = (Termination)native->termination;
            StartKind = (StartKind)native->start_kind;
            Flags = (ResultFlags)native->flags;
            Iterations = (int)native->iterations;
            RejectedSteps = (int)native->rejected_steps;
            SegmentsUsed = (int)native->segments_used;
            SegmentsGiven = (int)native->segments_given;
            PointsUsed = (long)native->points_used;
            PointsGiven = (long)native->points_given;
            Model = new Cylinder(&native->model);
            StartModel = new Cylinder(&native->start_model);
            InitialCost = native->initial_cost;
            Cost = native->cost;
            EnergyPoints = native->energy_points;
            EnergyEdges = native->energy_edges;
            EdgeWeight = native->edge_weight;
            PointRms = native->point_rms;
            EdgeRmsPixels = native->edge_rms_pixels;
            NearWallFraction = native->near_wall_fraction;
            Condition = native->condition;
            Lambda = native->lambda;
            GradientNorm = native->gradient_norm;
            StepNorm = native->step_norm;
            SecondsStart = native->seconds_start;
            SecondsSolve = native->seconds_solve;
            SecondsTotal = native->seconds_total;
            RadiusDeviation = native->radius_deviation;
            DirectionDeviation = native->direction_deviation;
            PositionDeviation = native->position_deviation;
            RadiusFromPoints = native->radius_from_points;
            RadiusFromPointsDeviation = native->radius_from_points_deviation;
            RadiusFromLimbs = native->radius_from_limbs;
            RadiusFromLimbsDeviation = native->radius_from_limbs_deviation;
            RadiusZScore = native->radius_z_score;
            Covariance = Native.Square(native->covariance, 7);
            LimbsLocated = (int)native->limbs_located;
        }
    }
}
