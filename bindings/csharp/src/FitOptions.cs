using System;

namespace Cylfuse
{
    /// <summary>The settings of a fit. The constructor fills in the defaults, which are named below.</summary>
    public sealed class FitOptions
    {
        private NativeOptions native;

        /// <summary>How the cylinder is estimated. Default Fused.</summary>
        public Method Method { get => (Method)native.method; set => native.method = (int)value; }

        /// <summary>What Fused minimises. Default Robust.</summary>
        public Objective Objective { get => (Objective)native.objective; set => native.objective = (int)value; }

        /// <summary>Where the iteration starts. Default Auto.</summary>
        public StartKind Start { get => (StartKind)native.start; set => native.start = (int)value; }

        /// <summary>Whether the points must lie on the wall that the camera sees. Default Auto.</summary>
        public NearWall NearWall { get => (NearWall)native.near_wall; set => native.near_wall = (int)value; }

        /// <summary>The coordinates of the iteration. Default Auto.</summary>
        public Chart Chart { get => (Chart)native.chart; set => native.chart = (int)value; }

        /// <summary>What given edge segments are for the objective Robust. Default Refine.</summary>
        public EdgeUse EdgeUse { get => (EdgeUse)native.edge_use; set => native.edge_use = (int)value; }

        /// <summary>How the ends of the visible cylinder are found. Default Auto.</summary>
        public ExtentRule ExtentRule { get => (ExtentRule)native.extent_rule; set => native.extent_rule = (int)value; }

        /// <summary>Most threads for the sums over the points; small clouds take one. The result has the same bits for
        /// any number. Default 1: no thread is started; 0 = 1.</summary>
        public uint MaxThreads { get => native.max_threads; set => native.max_threads = value; }

        /// <summary>Maximum number of iterations, at least 1. Default 400.</summary>
        public uint MaxIterations { get => native.max_iterations; set => native.max_iterations = value; }

        /// <summary>Smallest relative decrease of the cost that counts as progress, in [0, 1). Default 1e-12.</summary>
        public double CostTolerance { get => native.cost_tolerance; set => native.cost_tolerance = value; }

        /// <summary>The iteration ends where the cosine of the angle between the residuals and what a step can change
        /// of them is not above this, in [0, 1). Default 2^-52.</summary>
        public double GradientTolerance { get => native.gradient_tolerance; set => native.gradient_tolerance = value; }

        /// <summary>The iteration ends with a step that moves the surface at the data by not more than this part of
        /// their largest coordinate and of their size, in [0, 1). Default 2^-52.</summary>
        public double StepTolerance { get => native.step_tolerance; set => native.step_tolerance = value; }

        /// <summary>Damping of the first step, greater than 0. Default 1e-3.</summary>
        public double InitialLambda { get => native.initial_lambda; set => native.initial_lambda = value; }

        /// <summary>Factor by which the damping falls after an accepted step and grows after a rejected one, greater
        /// than 1. Default 10.</summary>
        public double LambdaFactor { get => native.lambda_factor; set => native.lambda_factor = value; }

        /// <summary>Damping at which no smaller step is tried any more, at least <see cref="InitialLambda"/>. Default
        /// 1e12.</summary>
        public double MaxLambda { get => native.max_lambda; set => native.max_lambda = value; }

        /// <summary>The weight w of the edges in Paper, in [0, 1]. Default 0.6; 0 is points only.</summary>
        public double EdgeWeight { get => native.edge_weight; set => native.edge_weight = value; }

        /// <summary>Seed of the random samples of RANSAC: the same seed gives the same result. Default 0.</summary>
        public ulong Seed { get => native.seed; set => native.seed = value; }

        /// <summary>Most random samples of RANSAC, 1 to 1,000,000. Default 1000.</summary>
        public ulong RansacMaxIterations
        {
            get => native.ransac_max_iterations;
            set => native.ransac_max_iterations = value;
        }

        /// <summary>Distance within which RANSAC counts a point as an inlier, in the unit of length, 0 or greater.
        /// Default 0 = from the data.</summary>
        public double RansacThreshold { get => native.ransac_threshold; set => native.ransac_threshold = value; }

        /// <summary>How many points with independent noise the points of one view are worth, by which points and limbs
        /// are weighed against each other; 0 or greater. Default 0 = from the data.</summary>
        public double IndependentPoints { get => native.independent_points; set => native.independent_points = value; }

        /// <summary>Standard deviation of a point across the surface, in the unit of length, 0 or greater. Default 0 =
        /// from the data.</summary>
        public double DepthNoise { get => native.depth_noise; set => native.depth_noise = value; }

        /// <summary>Standard deviation of the values of the image, in their unit where that is linear in light, 0 or
        /// greater. Default 0 = from the image.</summary>
        public double ImageNoise { get => native.image_noise; set => native.image_noise = value; }

        /// <summary>Standard deviation of an endpoint of a given edge segment across its limb, in drawn pixels, 0 or
        /// greater. Default 0 = 0.5, that of edges set by hand.</summary>
        public double EdgeNoise { get => native.edge_noise; set => native.edge_noise = value; }

        /// <summary>Standard deviation of a side of the mask as a whole across its limb, in drawn pixels, 0 or greater.
        /// Default 0 = 1.6, that of masks drawn by hand.</summary>
        public double MaskNoise { get => native.mask_noise; set => native.mask_noise = value; }

        /// <summary>Blur of the image, the standard deviation of a Gaussian in pixels, 0 or greater. Default 0 =
        /// from the image.</summary>
        public double ImageBlur { get => native.image_blur; set => native.image_blur = value; }

        /// <summary>Size of a pixel of the drawing in which edges and masks were made, in pixels of the image, 0 or
        /// greater: people and networks draw on a grid of some hundred columns, whatever the size of the image. Default
        /// 0 = 1 up to 640 x 480 pixels, beyond that the square root of how many times as many pixels the image
        /// has.</summary>
        public double DrawnPixel { get => native.drawn_pixel; set => native.drawn_pixel = value; }

        /// <summary>Standard deviation of the errors that all points of a view share, as a part of their distance. Default
        /// 0 = 0.002, a fifth of what data sheets grant; less than 0 = they share none.</summary>
        public double DepthShared { get => native.depth_shared; set => native.depth_shared = value; }

        /// <summary>The smallest radius, in the unit of length, which the returned cylinder keeps whatever the method
        /// and the start. Default 0 = no limit.</summary>
        public double RadiusMin { get => native.radius_min; set => native.radius_min = value; }

        /// <summary>The largest radius, at least <see cref="RadiusMin"/>; equal to it for a radius that is known.
        /// Default 0 = no limit.</summary>
        public double RadiusMax { get => native.radius_max; set => native.radius_max = value; }

        /// <summary>The middle of the cone of directions that the returned axis keeps, of any length. Default {0, 0, 0}
        /// = all directions.</summary>
        public Vector Axis { get => native.axis; set => native.axis = value; }

        /// <summary>The largest angle of the axis from <see cref="Axis"/>, in radians from 0 to pi/2, whatever the
        /// signs; 0 for a direction that is known. Default 0; must be 0 without <see cref="Axis"/>.</summary>
        public double AxisMaxAngle { get => native.axis_max_angle; set => native.axis_max_angle = value; }

        /// <summary>The defaults of the library.</summary>
        public unsafe FitOptions()
        {
            fixed (NativeOptions* options = &native)
                Native.Check(Native.Functions.OptionsInit(options, (UIntPtr)sizeof(NativeOptions)));
        }

        internal FitOptions(NativeOptions native)
        {
            this.native = native;
        }

        internal NativeOptions ToNative() => native;
    }
}
