namespace Cylfuse
{
    /// <summary>The outcome of a fit: the cylinder, how certain it is, and the numbers to judge it. NaN stands for what
    /// does not apply.</summary>
    public sealed class FitResult
    {
        private readonly NativeResult native;
        private readonly NativeCylinderEstimate estimate;

        /// <summary>The cylinder, its axis point the one nearest to the middle of the points.</summary>
        public Cylinder Model { get; }

        /// <summary>Warnings; None when there are none.</summary>
        public ResultFlags Flags => (ResultFlags)native.flags;

        /// <summary>Standard deviation of the radius, unit of length. This and what follows is that of the noise of the
        /// data, with the weights that were used and the correlation of neighbouring depths. With the method Fused and the
        /// objective Robust it also has the errors that all points of a view share and DepthShared of the options states,
        /// by default 0.2 % of the depth. Errors of the calibration, the registration and a scale of the depth are not in
        /// it. For an expanded uncertainty with the coverage factor 2 multiply by 2. NaN for RANSAC and Eberly, for an edge
        /// weight of 1, and where the data do not determine the number.</summary>
        public double RadiusDeviation => estimate.radius_deviation;

        /// <summary>Standard deviation of the direction in radians: the tilt in the plane in which it is least
        /// certain.</summary>
        public double DirectionDeviation => estimate.direction_deviation;

        /// <summary>Standard deviation of the position of the axis across itself, at the point of the model and in the
        /// direction in which it is least certain, unit of length.</summary>
        public double PositionDeviation => estimate.position_deviation;

        /// <summary>Whether the radius conforms to a tolerance, by its deviation and the warnings.</summary>
        /// <exception cref="CylfuseException">Limits that are none (InvalidArgument).</exception>
        public Conformity RadiusConforms(Tolerance tolerance)
        {
            if (tolerance == null) throw new System.ArgumentNullException(nameof(tolerance));
            return tolerance.Decide(Model.Radius, RadiusDeviation, Flags);
        }

        /// <summary>The same for the diameter, with limits of the diameter.</summary>
        /// <exception cref="CylfuseException">Limits that are none (InvalidArgument).</exception>
        public Conformity DiameterConforms(Tolerance tolerance)
        {
            if (tolerance == null) throw new System.ArgumentNullException(nameof(tolerance));
            return tolerance.Decide(2.0 * Model.Radius, 2.0 * RadiusDeviation, Flags);
        }

        /// <summary>Why the iteration ended.</summary>
        public Termination Termination => (Termination)native.termination;

        /// <summary>Iterations: linear systems that were solved.</summary>
        public int Iterations => (int)native.iterations;

        /// <summary>Solves whose step was rejected.</summary>
        public int RejectedSteps => (int)native.rejected_steps;

        /// <summary>Limb lines that were located in the images and took part, at most 2 a view.</summary>
        public int LimbsLocated => (int)native.limbs_located;

        /// <summary>Edge segments that were pushed.</summary>
        public int SegmentsGiven => (int)native.segments_given;

        /// <summary>Edge segments that took part.</summary>
        public int SegmentsUsed => (int)native.segments_used;

        /// <summary>Points that were pushed; <see cref="Fitter.Counts()"/> says why some were left out.</summary>
        public long PointsGiven => (long)native.points_given;

        /// <summary>Points that took part.</summary>
        public long PointsUsed => (long)native.points_used;

        /// <summary>How many points with independent noise the points of all views are worth: the noise of neighbours
        /// in a depth image is alike.</summary>
        public double IndependentPoints => native.independent_points;

        /// <summary>Standard deviation of the points from the surface by their median, unit of length: points beyond
        /// some of it lose their weight in the objective Robust.</summary>
        public double PointDeviation => native.point_deviation;

        /// <summary>Root mean square distance of the points from the surface, unit of length.</summary>
        public double PointRms => native.point_rms;

        /// <summary>Root mean square distance of the given endpoints from the limb lines in ideal pixels; NaN without
        /// edges.</summary>
        public double EdgeRmsPixels => native.edge_rms_pixels;

        /// <summary>The part of the points on the wall that the camera sees; NaN when the origin is no
        /// camera.</summary>
        public double NearWallFraction => native.near_wall_fraction;

        /// <summary>Cost of the start, unit of length squared.</summary>
        public double InitialCost => native.initial_cost;

        /// <summary>Cost of the outcome, unit of length squared.</summary>
        public double Cost => native.cost;

        /// <summary>E_P: mean squared distance of the points from the surface, unit of length squared.</summary>
        public double EnergyPoints => native.energy_points;

        /// <summary>E_L: mean squared distance of the back-projected endpoints from the limb lines, unit of length
        /// squared; NaN without exactly two usable segments.</summary>
        public double EnergyEdges => native.energy_edges;

        /// <summary>The edge weight that was used, 0 when no edges count; NaN where the objective has none.</summary>
        public double EdgeWeight => native.edge_weight;

        /// <summary>Condition number of the Jacobian at the outcome, in units of the size of the data; may be
        /// infinite.</summary>
        public double Condition => native.condition;

        /// <summary>Norm of half the gradient of the cost at the end, as far as the limits leave it free, in units of
        /// the size of the data.</summary>
        public double GradientNorm => native.gradient_norm;

        /// <summary>Norm of the last accepted step, in units of the size of the data.</summary>
        public double StepNorm => native.step_norm;

        /// <summary>The last damping.</summary>
        public double Lambda => native.lambda;

        /// <summary>Wall-clock seconds to find the start.</summary>
        public double SecondsStart => native.seconds_start;

        /// <summary>Wall-clock seconds to iterate.</summary>
        public double SecondsSolve => native.seconds_solve;

        /// <summary>Wall-clock seconds of the whole fit.</summary>
        public double SecondsTotal => native.seconds_total;

        /// <summary>How the start was found.</summary>
        public StartKind StartKind => (StartKind)estimate.start_kind;

        /// <summary>The cylinder that the iteration started from, moved into the limits.</summary>
        public Cylinder StartModel { get; }

        /// <summary>The radius by the curvature of the points alone, unit of length; NaN without segments or limbs, and
        /// where the points alone determine no cylinder.</summary>
        public double RadiusFromPoints => estimate.radius_from_points;

        /// <summary>Its standard deviation.</summary>
        public double RadiusFromPointsDeviation => estimate.radius_from_points_deviation;

        /// <summary>The radius by the limbs, with distance and tilt of the axis from the points, unit of length; NaN
        /// likewise.</summary>
        public double RadiusFromLimbs => estimate.radius_from_limbs;

        /// <summary>Its standard deviation.</summary>
        public double RadiusFromLimbsDeviation => estimate.radius_from_limbs_deviation;

        /// <summary><see cref="RadiusFromPoints"/> minus <see cref="RadiusFromLimbs"/> in standard deviations of the
        /// difference; beyond 4 the flag PointsAndLimbsDisagree is set.</summary>
        public double RadiusZScore => estimate.radius_z_score;

        /// <summary>Covariance of the point, the direction and the radius of <see cref="Model"/>, 7 x 7, symmetric, of
        /// rank 5; element [i, j] is that of the numbers i and j.</summary>
        public double[,] Covariance { get; }

        internal unsafe FitResult(NativeResult native, NativeCylinderEstimate estimate)
        {
            this.native = native;
            this.estimate = estimate;
            Model = new Cylinder(estimate.model);
            StartModel = new Cylinder(estimate.start_model);
            Covariance = Native.Square(estimate.covariance, 7);
        }
    }
}
