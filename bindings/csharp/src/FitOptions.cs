namespace Cylfuse
{
    /// <summary>The settings of a fit. The constructor fills in the defaults, which are named below; a number
    /// that says "0 = default" may also be left 0.</summary>
    public sealed class FitOptions
    {
        /// <summary>How the cylinder is estimated. Default Fused.</summary>
        public Method Method { get; set; }

        /// <summary>What Fused minimises. Default Robust.</summary>
        public Objective Objective { get; set; }

        /// <summary>Where the iteration starts. Default Auto.</summary>
        public StartKind Start { get; set; }

        /// <summary>Whether the points must lie on the wall that the camera sees. Default Auto.</summary>
        public NearWall NearWall { get; set; }

        /// <summary>The coordinates of the iteration. Default Auto.</summary>
        public Chart Chart { get; set; }

        /// <summary>Most linear solves. Default 400; 0 = default.</summary>
        public uint MaxIterations { get; set; }

        /// <summary>Most threads for the sums over the points; small clouds take one. The result has the same bits for
        /// any number. Default 0 = as many as the machine has.</summary>
        public uint MaxThreads { get; set; }

        /// <summary>The weight w of the edges in Paper, in [0, 1]. Default 0.6. Here 0 is a weight: points
        /// only.</summary>
        public double EdgeWeight { get; set; }

        /// <summary>Damping of the first step, greater than 0. Default 1e-3; 0 = default.</summary>
        public double InitialLambda { get; set; }

        /// <summary>Factor by which the damping falls after an accepted step and grows after a rejected one, greater
        /// than 1. Default 10; 0 = default.</summary>
        public double LambdaFactor { get; set; }

        /// <summary>Damping at which no smaller step is tried any more, at least <see cref="InitialLambda"/>. Default
        /// 1e12; 0 = default.</summary>
        public double MaxLambda { get; set; }

        /// <summary>Smallest relative decrease of the cost that counts as progress, in [0, 1). Default 1e-12. Here 0 is
        /// a tolerance: iterate until nothing decreases.</summary>
        public double CostTolerance { get; set; }

        /// <summary>Distance within which RANSAC counts a point as an inlier, in the unit of length, 0 or greater.
        /// Default 0 = from the data.</summary>
        public double RansacThreshold { get; set; }

        /// <summary>Seed of the random samples of RANSAC: the same seed gives the same result. Default 0.</summary>
        public ulong Seed { get; set; }

        /// <summary>Most random samples of RANSAC. Default 1000; 0 = default.</summary>
        public uint RansacMaxIterations { get; set; }

        /// <summary>What given edge segments are for the objective Robust. Default Refine.</summary>
        public EdgeUse EdgeUse { get; set; }

        /// <summary>How the ends of the visible cylinder are found. Default Auto.</summary>
        public ExtentRule ExtentRule { get; set; }

        /// <summary>The smallest radius, in the unit of length, which the returned cylinder keeps whatever the method
        /// and the start. Default 0 = no limit.</summary>
        public double RadiusMin { get; set; }

        /// <summary>The largest radius, at least <see cref="RadiusMin"/>; equal to it for a radius that is known.
        /// Default 0 = no limit.</summary>
        public double RadiusMax { get; set; }

        /// <summary>The middle of the cone of directions that the returned axis keeps, of any length. Default {0, 0, 0}
        /// = all directions.</summary>
        public Vector Axis { get; set; }

        /// <summary>The largest angle of the axis from <see cref="Axis"/>, in radians from 0 to pi/2, whatever the
        /// signs; 0 for a direction that is known. Default 0; must be 0 without <see cref="Axis"/>.</summary>
        public double AxisMaxAngle { get; set; }

        /// <summary>The defaults of the library.</summary>
        public unsafe FitOptions()
        {
            NativeOptions native;
            NativeFunctions.Check(NativeFunctions.OptionsInit(&native, NativeFunctions.SizeOf<NativeOptions>()));
            Read(&native);
        }

        internal unsafe FitOptions(NativeOptions* native)
        {
            Read(native);
        }

        internal unsafe void Write(NativeOptions* native)
        {
            NativeFunctions.Check(NativeFunctions.OptionsInit(native, NativeFunctions.SizeOf<NativeOptions>()));
            native->method = (int)Method;
            native->objective = (int)Objective;
            native->start = (int)Start;
            native->near_wall = (int)NearWall;
            native->chart = (int)Chart;
            native->max_iterations = MaxIterations;
            native->max_threads = MaxThreads;
            native->edge_weight = EdgeWeight;
            native->initial_lambda = InitialLambda;
            native->lambda_factor = LambdaFactor;
            native->max_lambda = MaxLambda;
            native->cost_tolerance = CostTolerance;
            native->ransac_threshold = RansacThreshold;
            native->seed = Seed;
            native->ransac_max_iterations = RansacMaxIterations;
            native->edge_use = (int)EdgeUse;
            native->extent_rule = (int)ExtentRule;
            native->radius_min = RadiusMin;
            native->radius_max = RadiusMax;
            Axis.CopyTo(native->axis);
            native->axis_max_angle = AxisMaxAngle;
        }

        private unsafe void Read(NativeOptions* native)
        {
            Method = (Method)native->method;
            Objective = (Objective)native->objective;
            Start = (StartKind)native->start;
            NearWall = (NearWall)native->near_wall;
            Chart = (Chart)native->chart;
            MaxIterations = native->max_iterations;
            MaxThreads = native->max_threads;
            EdgeWeight = native->edge_weight;
            InitialLambda = native->initial_lambda;
            LambdaFactor = native->lambda_factor;
            MaxLambda = native->max_lambda;
            CostTolerance = native->cost_tolerance;
            RansacThreshold = native->ransac_threshold;
            Seed = native->seed;
            RansacMaxIterations = native->ransac_max_iterations;
            EdgeUse = (EdgeUse)native->edge_use;
            ExtentRule = (ExtentRule)native->extent_rule;
            RadiusMin = native->radius_min;
            RadiusMax = native->radius_max;
            Axis = new Vector(native->axis);
            AxisMaxAngle = native->axis_max_angle;
        }
    }
}
