using System;

namespace Cylfuse
{
    // What follows a fit. Each call takes a model, null = that of the last fit, and where the image matters a mask of the
    // size of the intrinsics, null = that of the last depth image.
    public sealed partial class Fitter
    {
        /// <summary>Lists residuals: of points in the order in which they were pushed, without the dropped ones, in the unit
        /// of length, negative inside; of both endpoints of every used segment in ideal pixels.</summary>
        /// <param name="kind">Which residuals.</param>
        /// <param name="model">The model; null = that of the last fit.</param>
        /// <exception cref="CylfuseException">BadState without a model and a result; EdgeGeometry for edges when the camera
        /// is inside the cylinder.</exception>
        public unsafe double[] Residuals(ResidualKind kind, Cylinder model = null)
        {
            NativeCylinder cylinder;
            using (Enter())
            {
                NativeCylinder* modelOrNull = Cylinder.Write(model, &cylinder);
                int status = Native.Functions.FitterResiduals(Pointer, modelOrNull, (int)kind, null, UIntPtr.Zero,
                    out UIntPtr count);
                if (status != (int)Status.BufferTooSmall) Check(status);
                var residuals = new double[(long)count];
                fixed (double* buffer = residuals)
                {
                    Check(Native.Functions.FitterResiduals(Pointer, modelOrNull, (int)kind, buffer, count, out count));
                }
                return residuals;
            }
        }

        /// <summary>Lists what the last fit saw of the limbs in the grey image, piece by piece, used and refused; all samples
        /// of a limb that was not located in the end are refused. Empty when the image was not searched.</summary>
        /// <exception cref="CylfuseException">BadState without a result.</exception>
        public unsafe LimbSample[] LimbSamples()
        {
            using (Enter())
            {
                int status = Native.Functions.FitterLimbSamples(Pointer, null, UIntPtr.Zero, out UIntPtr count);
                if (status != (int)Status.BufferTooSmall) Check(status);
                var native = new NativeLimbSample[(long)count];
                fixed (NativeLimbSample* buffer = native)
                {
                    Check(Native.Functions.FitterLimbSamples(Pointer, buffer, count, out count));
                }
                return Array.ConvertAll(native, sample => new LimbSample(sample));
            }
        }

        /// <summary>Says what the data determine at a model, by an orthogonal factorisation of the whole Jacobian: more
        /// precise than <see cref="FitResult.Condition"/>, and far slower.</summary>
        /// <param name="model">The model; null = that of the last fit.</param>
        /// <exception cref="CylfuseException">BadState without a model and a result, EdgeGeometry where the cost is infinite,
        /// TooFewPoints, Numerical.</exception>
        public unsafe Diagnosis Diagnose(Cylinder model = null)
        {
            NativeCylinder cylinder;
            var native = new NativeDiagnosis { struct_size = (uint)sizeof(NativeDiagnosis) };
            using (Enter()) Check(Native.Functions.FitterDiagnose(Pointer, Cylinder.Write(model, &cylinder), &native));
            return new Diagnosis(native);
        }

        /// <summary>Says how many points a completion may give at most: the set pixels of the mask when packed, all pixels of
        /// the image when organised.</summary>
        /// <param name="layout">For which layout.</param>
        /// <param name="mask">The region; null = the mask of the last depth image.</param>
        /// <exception cref="CylfuseException">BadState without intrinsics or mask, SizeMismatch, EmptyMask.</exception>
        public unsafe long CompleteBound(Layout layout = Layout.Packed, Mask mask = null)
        {
            using (var pins = new Pins())
            {
                NativeMaskView region;
                NativeMaskView* regionOrNull = Mask.Write(mask, &region, pins);
                using (Enter()) return Bound(regionOrNull, layout);
            }
        }

        /// <summary>Completes the cloud: casts the ray of every pixel of a mask and takes its first meeting with the
        /// cylinder, the near wall from outside, the far one from inside a pipe.</summary>
        /// <param name="layout">Only the points that exist, or one for each pixel of the image.</param>
        /// <param name="model">The model; null = that of the last fit.</param>
        /// <param name="mask">The region; null = the mask of the last depth image.</param>
        /// <exception cref="CylfuseException">BadState without model, intrinsics or mask, SizeMismatch, EmptyMask,
        /// InvalidArgument.</exception>
        public CompletedCloud<double> Complete(Layout layout = Layout.Packed, Cylinder model = null,
            Mask mask = null) =>
            Complete<double>(Native.ScalarF64, layout, model, mask);

        /// <summary>Completes the cloud with coordinates of single precision.</summary>
        /// <inheritdoc cref="Complete(Layout, Cylinder, Mask)"/>
        public CompletedCloud<float> CompleteSingle(Layout layout = Layout.Packed, Cylinder model = null,
            Mask mask = null) =>
            Complete<float>(Native.ScalarF32, layout, model, mask);

        /// <summary>Completes the depth image: the z of every point of a completed cloud, 0 where there is none.</summary>
        /// <param name="scale">Length of one unit of the stored value.</param>
        /// <param name="model">The model; null = that of the last fit.</param>
        /// <param name="mask">The region; null = the mask of the last depth image.</param>
        /// <exception cref="CylfuseException">BadState without model, intrinsics or mask, SizeMismatch, EmptyMask,
        /// InvalidArgument.</exception>
        public CompletedDepth<float> CompleteDepth(double scale = 1.0, Cylinder model = null, Mask mask = null) =>
            CompleteDepth<float>(Native.DepthFormatF32, scale, model, mask);

        /// <summary>Completes the depth image in integers. A depth beyond their range becomes 0 and is counted.</summary>
        /// <inheritdoc cref="CompleteDepth(double, Cylinder, Mask)"/>
        public CompletedDepth<ushort> CompleteDepthUInt16(double scale, Cylinder model = null, Mask mask = null) =>
            CompleteDepth<ushort>(Native.DepthFormatU16, scale, model, mask);

        /// <summary>Finds the visible piece of the cylinder and what its ends are, by
        /// <see cref="FitOptions.ExtentRule"/>.</summary>
        /// <param name="model">The model; null = that of the last fit.</param>
        /// <param name="mask">The region; null = the mask of the last depth image.</param>
        /// <exception cref="CylfuseException">BadState without model, intrinsics or mask, SizeMismatch, EmptyMask,
        /// EdgeGeometry when no ray of the mask meets the cylinder.</exception>
        public unsafe Extent Extent(Cylinder model = null, Mask mask = null)
        {
            using (var pins = new Pins())
            {
                NativeCylinder cylinder;
                NativeMaskView region;
                NativeMaskView* regionOrNull = Mask.Write(mask, &region, pins);
                var native = new NativeExtent { struct_size = (uint)sizeof(NativeExtent) };
                using (Enter())
                    Check(Native.Functions.FitterExtent(Pointer, Cylinder.Write(model, &cylinder), regionOrNull, &native));
                return new Extent(native);
            }
        }

        /// <summary>Selects, of straight edges that a line detector found in the image, those on the two limbs of a rough
        /// cylinder beside the points that were pushed, such as a fit to these points alone. For each limb the edge with
        /// the longest pieces wins, the nearer the limb the better, if they cover 30 % of it. Nothing is pushed.</summary>
        /// <param name="segments">The edges; their weights are ignored.</param>
        /// <param name="model">The rough cylinder; null = that of the last fit.</param>
        /// <param name="reach">How far a limb may be from that of the model, in pixels, 0 or greater; 0 = 15 % of the
        /// distance of the limbs, at least 4.</param>
        /// <returns>For each segment 1 or 2 for the limb that it lies on, in the order of
        /// <see cref="Cylinder.Project"/>, 0 for none.</returns>
        /// <exception cref="CylfuseException">BadState without model, intrinsics or points, InvalidArgument for a bad segment
        /// or reach, EdgeGeometry when the camera is inside the cylinder or a limb cannot be seen.</exception>
        public unsafe byte[] SelectEdges(Segments segments, Cylinder model = null, double reach = 0)
        {
            if (segments == null) throw new ArgumentNullException(nameof(segments));
            using (var pins = new Pins())
            {
                NativeCylinder cylinder;
                NativeSegmentsView view;
                segments.Write(&view, pins);
                var limbs = new byte[segments.Count];
                using (Enter())
                {
                    fixed (byte* buffer = limbs)
                    {
                        Check(Native.Functions.FitterSelectEdges(
                            Pointer, Cylinder.Write(model, &cylinder), &view, reach, buffer, (UIntPtr)limbs.Length));
                    }
                }
                return limbs;
            }
        }

        private unsafe long Bound(NativeMaskView* mask, Layout layout)
        {
            Check(Native.Functions.FitterCompleteBound(Pointer, mask, (int)layout, out UIntPtr capacity));
            return (long)capacity;
        }

        private unsafe CompletedCloud<T> Complete<T>(int scalar, Layout layout, Cylinder model, Mask mask)
            where T : struct
        {
            using (var pins = new Pins())
            {
                NativeCylinder cylinder;
                NativeMaskView region;
                NativeMaskView* regionOrNull = Mask.Write(mask, &region, pins);
                var completion = new NativeCompletion { struct_size = (uint)sizeof(NativeCompletion) };
                NativePointsOut target;
                Native.Check(Native.Functions.PointsOutInit(&target, (UIntPtr)sizeof(NativePointsOut)));
                using (Enter())
                {
                    long capacity = Bound(regionOrNull, layout);
                    var coordinates = new T[3 * capacity];
                    target.scalar = scalar;
                    target.data = pins.Add(coordinates);
                    target.capacity = (UIntPtr)capacity;
                    target.layout = (int)layout;
                    Check(Native.Functions.FitterComplete(Pointer, Cylinder.Write(model, &cylinder), regionOrNull, &target,
                        &completion));
                    if (layout == Layout.Organised)
                        return new CompletedCloud<T>(coordinates, intrinsics.Width, intrinsics.Height,
                            new Completion(completion));
                    if ((long)completion.count < capacity) Array.Resize(ref coordinates, 3 * (int)completion.count);
                    return new CompletedCloud<T>(coordinates, (int)completion.count, 1, new Completion(completion));
                }
            }
        }

        private unsafe CompletedDepth<T> CompleteDepth<T>(int format, double scale, Cylinder model, Mask mask)
            where T : struct
        {
            using (var pins = new Pins())
            {
                NativeCylinder cylinder;
                NativeMaskView region;
                NativeMaskView* regionOrNull = Mask.Write(mask, &region, pins);
                var completion = new NativeCompletion { struct_size = (uint)sizeof(NativeCompletion) };
                NativeDepthOut target;
                Native.Check(Native.Functions.DepthOutInit(&target, (UIntPtr)sizeof(NativeDepthOut)));
                using (Enter())
                {
                    // Without a camera the image has no size; the library then says what is missing.
                    var depth = new T[intrinsics?.Height ?? 0, intrinsics?.Width ?? 0];
                    target.format = format;
                    target.data = pins.Add(depth);
                    target.width = (uint)depth.GetLength(1);
                    target.height = (uint)depth.GetLength(0);
                    target.scale = scale;
                    Check(Native.Functions.FitterCompleteDepth(Pointer, Cylinder.Write(model, &cylinder), regionOrNull,
                        &target, &completion));
                    return new CompletedDepth<T>(depth, new Completion(completion));
                }
            }
        }
    }
}
