namespace Cylfuse
{
    /// <summary>What a fit gave each point of a view to say, in the order of the residuals of points.</summary>
    public sealed class PointWeights
    {
        /// <summary>The part of each point in the fit, from 1 for a point near the surface down to 0 for an outlier, times
        /// the weight that it was given.</summary>
        public double[] Weights { get; }

        /// <summary>Whether each point is within the reach of the robust weights, or of the threshold of RANSAC.</summary>
        public bool[] Inliers { get; }

        internal PointWeights(double[] weights, bool[] inliers)
        {
            Weights = weights;
            Inliers = inliers;
        }
    }
}
