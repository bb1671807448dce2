using System;

namespace Cylfuse
{
    /// <summary>A cylinder with the middle of its axis on the optical axis, of which a camera will take measurements. Lengths
    /// are in metres, angles in radians.</summary>
    public sealed class Plan
    {
        /// <summary>From the camera to the middle of the axis.</summary>
        public double Distance { get; set; }

        /// <summary>The radius.</summary>
        public double Radius { get; set; }

        /// <summary>The length.</summary>
        public double Length { get; set; }

        /// <summary>The angle of the axis out of the plane of the image.</summary>
        public double Tilt { get; set; }

        /// <summary>The angle of the axis in the image from the vertical.</summary>
        public double Turn { get; set; }

        /// <summary>Six numbers: a, b, c of the noise of depth a + b z + c z² at the depth z; the side of the squares of
        /// pixels that share it, at least 1; the noise of a pixel of the image as a part of the step of brightness at limbs
        /// and ends; the blur of the image in pixels. Null for that of structured light and an ordinary image.</summary>
        public double[] Noise { get; set; }

        /// <summary>The standard deviations to be expected of a camera.</summary>
        /// <exception cref="CylfuseException">A number is out of range (InvalidArgument, InvalidIntrinsics), or the
        /// pixels that see the cylinder are worth fewer than 8 points with independent noise (TooFewPoints).</exception>
        public unsafe Expectation Expect(Intrinsics intrinsics)
        {
            if (intrinsics == null) throw new ArgumentNullException(nameof(intrinsics));
            if (Noise != null && Noise.Length != 6)
            {
                throw new ArgumentException("the noise has " + Noise.Length + " numbers; it must have 6");
            }
            NativeIntrinsics camera;
            intrinsics.Write(&camera);
            var cylinder = new[] { Distance, Radius, Length, Tilt, Turn };
            var scatter = new double[4];
            var total = new double[4];
            fixed (double* given = cylinder, noise = Noise, first = scatter, second = total)
            {
                Native.Check(Native.Functions.Plan(&camera, given, noise, first, second));
            }
            return new Expectation(new Deviations(scatter), new Deviations(total));
        }
    }

    /// <summary>What is to be expected of measurements.</summary>
    public sealed class Expectation
    {
        /// <summary>How much captures of one scene scatter.</summary>
        public Deviations Scatter { get; }

        /// <summary>How far a measurement is off: what a fit states.</summary>
        public Deviations Total { get; }

        internal Expectation(Deviations scatter, Deviations total)
        {
            Scatter = scatter;
            Total = total;
        }
    }

    /// <summary>Standard deviations of what is measured of a cylinder.</summary>
    public sealed class Deviations
    {
        /// <summary>Of the radius in metres.</summary>
        public double Radius { get; }

        /// <summary>Of the direction of the axis in radians, in the plane in which it is least certain.</summary>
        public double Direction { get; }

        /// <summary>Of the position of the axis across itself in metres, in the direction in which it is least
        /// certain.</summary>
        public double Position { get; }

        /// <summary>Of the length in metres; NaN where an end lies outside the image.</summary>
        public double Length { get; }

        internal Deviations(double[] numbers)
        {
            Radius = numbers[0];
            Direction = numbers[1];
            Position = numbers[2];
            Length = numbers[3];
        }
    }
}
