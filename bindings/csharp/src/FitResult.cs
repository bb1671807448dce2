namespace Cylfuse
{
    /// <summary>The outcome of a fit with the numbers to judge it. NaN stands for what does not apply.</summary>
    public sealed class FitResult
    {
        private readonly NativeResult native;

        /// <summary>Why the iteration ended.</summary>
        public Termination Termination => (Termination)native.termination;

        /// <summary>How the start was found.</summary>
        public StartKind StartKind => (StartKind)native.start_kind;

        /// <summary>Doubts; None when there are none.</summary>
        public ResultFlags Flags => (ResultFlags)native.flags;

        /// <summary>Linear solves.</summary>
        public int Iterations => (int)native.iterations;

        /// <summary>Solves whose step was rejected.</summary>
        public int RejectedSteps => (int)native.rejected_steps;

        /// <summary>Segments that took part.</summary>
        public int SegmentsUsed => (int)native.segments_used;

        /// <summary>Segments that were pushed.</summary>
        public int SegmentsGiven => (int)native.segments_given;

        /// <summary>Points that took part.</summary>
        public long PointsUsed => (long)native.points_used;

        /// <summary>Points that were pushed; <see cref="Fitter.Counts()"/> says why the others were left out.</summary>
        public long PointsGiven => (long)native.points_given;

        /// <summary>The cylinder, its axis point the one nearest to the middle of the points.</summary>
        public Cylinder Model { get; }

        /// <summary>The model that the iteration started from, moved into the limits.</summary>
        public Cylinder StartModel { get; }

        /// <summary>Cost of the start, unit of length squared.</summary>
        public double InitialCost => native.initial_cost;

        /// <summary>Cost of the cylinder, unit of length squared.</summary>
        public double Cost => native.cost;

        /// <summary>E_P: mean squared distance of the points from the surface, unit of length squared.</summary>
        public double EnergyPoints => native.energy_points;

        /// <summary>E_L: mean squared distance of the back-projected endpoints from the limb lines, unit of length
        /// squared; NaN without exactly two usable segments.</summary>
        public double EnergyEdges => native.energy_edges;

        /// <summary>The edge weight that was used, 0 when no edges count; NaN where the objective has none.</summary>
        public double EdgeWeight => native.edge_weight;

        /// <summary>Root of E_P, unit of length.</summary>
        public double PointRms => native.point_rms;

        /// <summary>Root mean square distance of the endpoints from the limb lines in ideal pixels; NaN without
        /// edges.</summary>
        public double EdgeRmsPixels => native.edge_rms_pixels;

        /// <summary>The part of the points on the wall that the camera sees; NaN when the origin is no
        /// camera.</summary>
        public double NearWallFraction => native.near_wall_fraction;

        /// <summary>Condition number of the Jacobian at the cylinder, in units of the size of the data; may be
        /// infinite.</summary>
        public double Condition => native.condition;

        /// <summary>The last damping.</summary>
        public double Lambda => native.lambda;

        /// <summary>Norm of half the gradient of the cost at the end, as far as the limits leave it free, in units of
        /// the size of the data.</summary>
        public double GradientNorm => native.gradient_norm;

        /// <summary>Norm of the last accepted step, in units of the size of the data.</summary>
        public double StepNorm => native.step_norm;

        /// <summary>Wall-clock seconds to find the start.</summary>
        public double SecondsStart => native.seconds_start;

        /// <summary>Wall-clock seconds to iterate.</summary>
        public double SecondsSolve => native.seconds_solve;

        /// <summary>Wall-clock seconds of the whole fit.</summary>
        public double SecondsTotal => native.seconds_total;

        /// <summary>Standard deviation of the radius, unit of length. This and what follows is that of the noise of the
        /// data, with the weights that were used and the correlation of the depth noise along the order of the points;
        /// errors that all data share (calibration, a scale of the depth) are not in it. NaN for RANSAC and Eberly, for
        /// an edge weight of 1, and where the data do not determine a cylinder.</summary>
        public double RadiusDeviation => native.radius_deviation;

        /// <summary>Standard deviation of the direction in radians: the tilt in the plane in which it is least
        /// certain.</summary>
        public double DirectionDeviation => native.direction_deviation;

        /// <summary>Standard deviation of the position of the axis across itself, at <see cref="Cylinder.Point"/> and
        /// in the direction in which it is least certain, unit of length.</summary>
        public double PositionDeviation => native.position_deviation;

        /// <summary>The radius by the curvature of the points alone, unit of length; NaN without segments or limbs, and
        /// where the points alone determine no cylinder.</summary>
        public double RadiusFromPoints => native.radius_from_points;

        /// <summary>Its standard deviation.</summary>
        public double RadiusFromPointsDeviation => native.radius_from_points_deviation;

        /// <summary>The radius by the limbs, with distance and tilt of the axis from the points, unit of length; NaN
        /// likewise.</summary>
        public double RadiusFromLimbs => native.radius_from_limbs;

        /// <summary>Its standard deviation.</summary>
        public double RadiusFromLimbsDeviation => native.radius_from_limbs_deviation;

        /// <summary><see cref="RadiusFromPoints"/> minus <see cref="RadiusFromLimbs"/> in standard deviations of the
        /// difference; beyond 4 the flag <see cref="ResultFlags.PointsAndLimbsDisagree"/> is set.</summary>
        public double RadiusZScore => native.radius_z_score;

        /// <summary>Covariance of (<see cref="Cylinder.Point"/>, <see cref="Cylinder.Direction"/>, <see
        /// cref="Cylinder.Radius"/>), 7 x 7, symmetric, of rank 5; element [i, j] is that of the numbers i and
        /// j.</summary>
        public double[,] Covariance { get; }

        /// <summary>Limb lines that were located in the grey image and took part, 0 to 2.</summary>
        public int LimbsLocated => (int)native.limbs_located;

        internal unsafe FitResult(NativeResult native)
        {
            this.native = native;
            Model = new Cylinder(native.model);
            StartModel = new Cylinder(native.start_model);
            Covariance = Native.Square(native.covariance, 7);
        }
    }
}
