namespace Cylfuse
{
    /// <summary>How much each point of a view counts at the cylinder of a fit, by the weights of
    /// <see cref="Objective.Robust"/>, in the order of the residuals of points.</summary>
    public sealed class PointWeights
    {
        /// <summary>From 1 for a point on the surface down to 0 for an outlier, without the weight that the point was
        /// given.</summary>
        public double[] Weights { get; }

        /// <summary>Whether the weight is above 0.</summary>
        public bool[] Inliers { get; }

        internal PointWeights(double[] weights, bool[] inliers)
        {
            Weights = weights;
            Inliers = inliers;
        }
    }
}
