using System;

namespace Cylfuse
{
    /// <summary>A camera as a calibration gives it. Pixel centres are at integer coordinates, as in OpenCV.</summary>
    public sealed class Intrinsics
    {
        private const int MostCoefficients = 8;

        /// <summary>Width of the image in pixels, at least 1.</summary>
        public int Width { get; }

        /// <summary>Height of the image in pixels, at least 1; both together at most 2^28 pixels.</summary>
        public int Height { get; }

        /// <summary>Focal length in pixel widths, greater than 0.</summary>
        public double Fx { get; }

        /// <summary>Focal length in pixel heights, greater than 0.</summary>
        public double Fy { get; }

        /// <summary>Principal point in pixels from the centre of the first pixel, to the right.</summary>
        public double Cx { get; }

        /// <summary>Principal point in pixels from the centre of the first pixel, down.</summary>
        public double Cy { get; }

        /// <summary>What the coefficients mean.</summary>
        public DistortionModel DistortionModel { get; }

        /// <summary>The coefficients, 8 numbers in the order of the model; those that it does not have are 0.</summary>
        public double[] Distortion { get; }

        /// <summary>A camera; the call that takes it checks the numbers.</summary>
        /// <param name="width">Width of the image in pixels.</param>
        /// <param name="height">Height of the image in pixels.</param>
        /// <param name="fx">Focal length in pixel widths.</param>
        /// <param name="fy">Focal length in pixel heights.</param>
        /// <param name="cx">Principal point, to the right.</param>
        /// <param name="cy">Principal point, down.</param>
        /// <param name="distortionModel">What the coefficients mean.</param>
        /// <param name="distortion">At most 8 coefficients; null = none.</param>
        /// <exception cref="ArgumentException">A negative size or too many coefficients.</exception>
        public Intrinsics(int width, int height, double fx, double fy, double cx, double cy,
            DistortionModel distortionModel = DistortionModel.None, double[] distortion = null)
        {
            if (width < 0 || height < 0)
                throw new ArgumentOutOfRangeException(nameof(width),
                    $"An image of {width} x {height} pixels is none: both must be at least 1.");
            if (distortion != null && distortion.Length > MostCoefficients)
                throw new ArgumentException($"There are {distortion.Length} coefficients; a distortion model has at most {MostCoefficients}.", nameof(distortion));
            Width = width;
            Height = height;
            Fx = fx;
            Fy = fy;
            Cx = cx;
            Cy = cy;
            DistortionModel = distortionModel;
            Distortion = new double[MostCoefficients];
            if (distortion != null) Array.Copy(distortion, Distortion, distortion.Length);
        }

        internal unsafe void Write(NativeIntrinsics* native)
        {
            Native.Check(Native.Functions.IntrinsicsInit(native, (UIntPtr)sizeof(NativeIntrinsics)));
            native->distortion_model = (int)DistortionModel;
            native->width = (uint)Width;
            native->height = (uint)Height;
            native->fx = Fx;
            native->fy = Fy;
            native->cx = Cx;
            native->cy = Cy;
            for (int k = 0; k < MostCoefficients; k++) native->distortion[k] = Distortion[k];
        }
    }
}
