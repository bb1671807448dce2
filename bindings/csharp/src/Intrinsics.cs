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

        /// <summary>The pixels of the (distorted) image at which the camera sees points of its frame, row by row of the
        /// points.</summary>
        /// <returns>n × 2 numbers, x and y. Pixels may lie beyond the border of the image; NaN for a point that is not
        /// finite, not in front of the camera or outside the field of its model.</returns>
        /// <exception cref="CylfuseException">No camera works with these numbers (InvalidIntrinsics,
        /// InvalidArgument).</exception>
        public unsafe double[,] Project(PointCloud points)
        {
            if (points == null) throw new ArgumentNullException(nameof(points));
            using (var pins = new Pins())
            {
                NativeIntrinsics camera;
                Write(&camera);
                NativePointsView view;
                points.Write(&view, pins);
                var pixels = new double[points.Count, 2];
                fixed (double* buffer = pixels)
                    Native.Check(Native.Functions.IntrinsicsProject(&camera, &view, buffer, (UIntPtr)points.Count));
                return pixels;
            }
        }

        /// <summary>The rays along which the camera sees pixels of the (distorted) image: the points at z = 1 of its
        /// frame. The ray of an ideal pixel, as those of limb lines are, is that of the same intrinsics without
        /// distortion.</summary>
        /// <param name="pixels">n × 2 numbers, x and y, in the image or beyond its border.</param>
        /// <returns>n × 3 numbers; NaN for a pixel that is not finite or for which the model has no ray.</returns>
        /// <exception cref="ArgumentException">The second dimension is not 2.</exception>
        /// <exception cref="CylfuseException">No camera works with these numbers (InvalidIntrinsics,
        /// InvalidArgument).</exception>
        public unsafe double[,] Unproject(double[,] pixels)
        {
            if (pixels == null) throw new ArgumentNullException(nameof(pixels));
            ArrayPart.RequireColumns("pixels", pixels.GetLength(1), 2);
            NativeIntrinsics camera;
            Write(&camera);
            int count = pixels.GetLength(0);
            var rays = new double[count, 3];
            fixed (double* given = pixels, buffer = rays)
                Native.Check(Native.Functions.IntrinsicsUnproject(&camera, given, (UIntPtr)count, buffer));
            return rays;
        }

        /// <summary>Fills the struct and gives its address; null where there is no camera.</summary>
        internal static unsafe NativeIntrinsics* Write(Intrinsics intrinsics, NativeIntrinsics* native)
        {
            if (intrinsics == null) return null;
            intrinsics.Write(native);
            return native;
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
