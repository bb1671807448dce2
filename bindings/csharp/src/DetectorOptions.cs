using System;

namespace Cylfuse
{
    /// <summary>The settings of a detector. The constructor fills in the defaults, which are named below. The limits of
    /// radius and axis hold for the search and for the fits.</summary>
    public sealed class DetectorOptions
    {
        private NativeDetectorOptions native;

        /// <summary>Whether the image of a frame is looked at. Default Auto.</summary>
        public ImageUse ImageUse { get => (ImageUse)native.image_use; set => native.image_use = (int)value; }

        /// <summary>Most threads, on which cylinders are fitted side by side. The result has the same bits for any
        /// number. Default 1: no thread is started; 0 = 1.</summary>
        public uint MaxThreads { get => native.max_threads; set => native.max_threads = value; }

        /// <summary>Most cylinders, those with the highest scores. Default 0 = no limit.</summary>
        public uint MaxCount { get => native.max_count; set => native.max_count = value; }

        /// <summary>Fewest pixels of a cylinder; points for a cloud. Default 100.</summary>
        public ulong MinPixels { get => native.min_pixels; set => native.min_pixels = value; }

        /// <summary>The least score, in [0, 1]: the probability that there is a cylinder. Default 0.5.</summary>
        public double MinScore { get => native.min_score; set => native.min_score = value; }

        /// <summary>The smallest radius, in the unit of length. Default 0 = no limit.</summary>
        public double RadiusMin { get => native.radius_min; set => native.radius_min = value; }

        /// <summary>The largest radius, at least <see cref="RadiusMin"/>; equal to it for a radius that is known.
        /// Default 0 = no limit.</summary>
        public double RadiusMax { get => native.radius_max; set => native.radius_max = value; }

        /// <summary>The middle of the cone of directions that the axes keep, in the reference frame and of any length.
        /// Default {0, 0, 0} = all directions.</summary>
        public Vector Axis { get => native.axis; set => native.axis = value; }

        /// <summary>The largest angle of an axis from <see cref="Axis"/>, in radians from 0 to pi/2, whatever the
        /// signs; 0 for a direction that is known. Default 0; must be 0 without <see cref="Axis"/>.</summary>
        public double AxisMaxAngle { get => native.axis_max_angle; set => native.axis_max_angle = value; }

        /// <summary>The defaults of the library.</summary>
        public unsafe DetectorOptions()
        {
            fixed (NativeDetectorOptions* options = &native)
                Native.Check(Native.Functions.DetectorOptionsInit(options, (UIntPtr)sizeof(NativeDetectorOptions)));
        }

        internal DetectorOptions(NativeDetectorOptions native)
        {
            this.native = native;
        }

        internal NativeDetectorOptions ToNative() => native;
    }
}
