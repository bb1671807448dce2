using System;

namespace Cylfuse
{
    // What follows a fit. Each call takes a model in the reference frame, null = that of the last fit, and where the
    // image matters a mask of the size of the intrinsics, null = that of the selected view.
    public sealed partial class Fitter
    {
        /// <summary>Lists residuals of the selected view: of points in the order in which they were pushed, without the
        /// dropped ones, in the unit of length, negative inside; of both endpoints of every used segment in ideal
        /// pixels.</summary>
        /// <param name="kind">Which residuals.</param>
        /// <param name="model">The model; null = that of the last fit.</param>
        /// <exception cref="CylfuseException">BadState without a model and a result; EdgeGeometry for edges when the
        /// camera is inside the cylinder.</exception>
        public unsafe double[] Residuals(ResidualKind kind, Cylinder model = null)
        {
            NativeCylinder cylinder;
            using (Call call = Enter())
            {
                NativeCylinder* modelOrNull = Cylinder.Write(model, &cylinder);
                double[] residuals = null;
                int length = Fill(call, (UIntPtr capacity, out UIntPtr count) =>
                {
                    residuals = new double[(long)capacity];
                    fixed (double* buffer = residuals)
                    {
                        return Native.Functions.FitterResiduals(call.Pointer, modelOrNull, (int)kind, buffer, capacity,
                            out count);
                    }
                });
                Array.Resize(ref residuals, length);
                return residuals;
            }
        }

        /// <summary>Lists the two limbs of the last fit in each view, view after view: where they were located in the
        /// image, or why they were not. All are NotSearched once data or options have changed since.</summary>
        /// <exception cref="CylfuseException">BadState without a result.</exception>
        public unsafe LimbLine[] Limbs() => Array.ConvertAll(
            List<NativeLimb>(Native.Functions.FitterLimbs, sizeof(NativeLimb)), limb => new LimbLine(limb));

        /// <summary>Lists what the last fit saw of the limbs in the image of the selected view, piece by piece, used
        /// and refused; all samples of a limb that was not located in the end are refused. Empty when the image was not
        /// searched, and once data or options have changed since.</summary>
        /// <exception cref="CylfuseException">BadState without a result.</exception>
        public unsafe LimbSample[] LimbSamples() => Array.ConvertAll(
            List<NativeLimbSample>(Native.Functions.FitterLimbSamples, sizeof(NativeLimbSample)),
            sample => new LimbSample(sample));

        /// <summary>Lists the samples on the arcs of both ends that <see cref="Extent"/> finds in the images, view after
        /// view: first those of the start, then those of the end. There are none for an end that the image of a view
        /// does not show.</summary>
        /// <param name="model">The model; null = that of the last fit.</param>
        /// <param name="mask">The region; null = the mask of the selected view.</param>
        /// <exception cref="CylfuseException">As <see cref="Extent"/>.</exception>
        public unsafe EndSample[] EndSamples(Cylinder model = null, Mask mask = null)
        {
            using (var pins = new Pins())
            {
                NativeCylinder cylinder;
                NativeMaskView region;
                NativeCylinder* modelOrNull = Cylinder.Write(model, &cylinder);
                NativeMaskView* regionOrNull = Mask.Write(mask, &region, pins);
                NativeEndSample[] samples = List<NativeEndSample>(
                    (IntPtr fitter, void* elements, UIntPtr size, UIntPtr capacity, out UIntPtr count) =>
                        Native.Functions.FitterEndSamples(fitter, modelOrNull, regionOrNull, (NativeEndSample*)elements, size,
                            capacity, out count),
                    sizeof(NativeEndSample));
                return Array.ConvertAll(samples, sample => new EndSample(sample));
            }
        }

        /// <summary>Lists how much each point of the selected view counts at the cylinder of the last fit, in the order
        /// of the residuals of points.</summary>
        /// <exception cref="CylfuseException">BadState without a result.</exception>
        public unsafe PointWeights PointWeights()
        {
            using (Call call = Enter())
            {
                double[] weights = null;
                byte[] inliers = null;
                int length = Fill(call, (UIntPtr capacity, out UIntPtr count) =>
                {
                    weights = new double[(long)capacity];
                    inliers = new byte[(long)capacity];
                    fixed (double* weight = weights)
                    fixed (byte* inlier = inliers)
                    {
                        return Native.Functions.FitterPointWeights(call.Pointer, weight, inlier, capacity, out count);
                    }
                });
                Array.Resize(ref weights, length);
                Array.Resize(ref inliers, length);
                return new PointWeights(weights, Array.ConvertAll(inliers, inlier => inlier != 0));
            }
        }

        /// <summary>Tells what each point of the selected view belongs to, in the order of the residuals of
        /// points.</summary>
        /// <param name="model">The model; null = that of the last fit.</param>
        /// <exception cref="CylfuseException">BadState without a model and a result.</exception>
        public unsafe Part[] PointParts(Cylinder model = null)
        {
            NativeCylinder cylinder;
            using (Call call = Enter())
            {
                NativeCylinder* modelOrNull = Cylinder.Write(model, &cylinder);
                Part[] parts = null;
                int length = Fill(call, (UIntPtr capacity, out UIntPtr count) =>
                {
                    parts = new Part[(long)capacity];
                    fixed (Part* buffer = parts)
                    {
                        return Native.Functions.FitterPointParts(call.Pointer, modelOrNull, buffer, capacity, out count);
                    }
                });
                Array.Resize(ref parts, length);
                return parts;
            }
        }

        /// <summary>Says what the data determine at a model, by an orthogonal factorisation of the whole Jacobian: more
        /// precise than <see cref="FitResult.Condition"/>, and far slower.</summary>
        /// <param name="model">The model; null = that of the last fit.</param>
        /// <exception cref="CylfuseException">BadState without a model and a result, EdgeGeometry where the cost is
        /// infinite, TooFewPoints, Numerical.</exception>
        public unsafe Diagnosis Diagnose(Cylinder model = null)
        {
            NativeCylinder cylinder;
            NativeCylinderDiagnosis native;
            Native.Check(Native.Functions.CylinderDiagnosisInit(&native, (UIntPtr)sizeof(NativeCylinderDiagnosis)));
            using (Call call = Enter())
                call.Check(Native.Functions.FitterDiagnose(call.Pointer, Cylinder.Write(model, &cylinder), &native));
            return new Diagnosis(native);
        }

        /// <summary>Says how many points a completion may give at most: the set pixels of the mask when packed, all
        /// pixels of the image when organised.</summary>
        /// <param name="layout">For which layout.</param>
        /// <param name="mask">The region; null = the mask of the selected view.</param>
        /// <exception cref="CylfuseException">BadState without intrinsics or mask, SizeMismatch, EmptyMask.</exception>
        public unsafe long CompleteBound(Layout layout = Layout.Packed, Mask mask = null)
        {
            using (var pins = new Pins())
            {
                NativeMaskView region;
                NativeMaskView* regionOrNull = Mask.Write(mask, &region, pins);
                using (Call call = Enter()) return Bound(call, regionOrNull, layout);
            }
        }

        /// <summary>Completes the cloud of the selected view: casts the ray of every pixel of a mask and takes its
        /// first meeting with the cylinder, the near wall from outside, the far one from inside a pipe. The points are
        /// in the reference frame.</summary>
        /// <param name="layout">Only the points that exist, or one for each pixel of the image.</param>
        /// <param name="model">The model; null = that of the last fit.</param>
        /// <param name="mask">The region; null = the mask of the selected view.</param>
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

        /// <summary>Completes the depth image of the selected view, on the pixels of its colour image: the z of every
        /// point of a completed cloud, 0 where there is none.</summary>
        /// <param name="scale">Length of one unit of the stored value.</param>
        /// <param name="model">The model; null = that of the last fit.</param>
        /// <param name="mask">The region; null = the mask of the selected view.</param>
        /// <exception cref="CylfuseException">BadState without model, intrinsics or mask, SizeMismatch, EmptyMask,
        /// InvalidArgument.</exception>
        public CompletedDepth<float> CompleteDepth(double scale = 1.0, Cylinder model = null, Mask mask = null) =>
            CompleteDepth<float>(Native.DepthFormatF32, scale, model, mask);

        /// <summary>Completes the depth image in integers. A depth beyond their range becomes 0 and is
        /// counted.</summary>
        /// <inheritdoc cref="CompleteDepth(double, Cylinder, Mask)"/>
        public CompletedDepth<ushort> CompleteDepthUInt16(double scale, Cylinder model = null, Mask mask = null) =>
            CompleteDepth<ushort>(Native.DepthFormatU16, scale, model, mask);

        /// <summary>Finds the visible piece of the cylinder and what its ends are: in a view with a camera and a mask by
        /// <see cref="FitOptions.ExtentRule"/>, in others, and from inside a pipe, by the points on the surface. An end
        /// that is seen in several views is their mean by their variances; one that is seen in none is the outermost of
        /// what they show.</summary>
        /// <param name="model">The model; null = that of the last fit.</param>
        /// <param name="mask">The region; null = the mask of the selected view.</param>
        /// <exception cref="CylfuseException">BadState without a model, without points or a mask, and for a mask that is
        /// given without intrinsics; SizeMismatch, EmptyMask, EdgeGeometry when no ray of the mask meets the cylinder and
        /// no points lie along it.</exception>
        public unsafe Extent Extent(Cylinder model = null, Mask mask = null)
        {
            using (var pins = new Pins())
            {
                NativeCylinder cylinder;
                NativeMaskView region;
                NativeMaskView* regionOrNull = Mask.Write(mask, &region, pins);
                NativeExtent native;
                Native.Check(Native.Functions.ExtentInit(&native, (UIntPtr)sizeof(NativeExtent)));
                using (Call call = Enter())
                    call.Check(Native.Functions.FitterExtent(call.Pointer,
                        Cylinder.Write(model, &cylinder), regionOrNull, &native));
                return new Extent(native);
            }
        }

        /// <summary>Selects, of straight edges that a line detector found in the image, those on the two limbs of a
        /// rough cylinder beside the points that were pushed, such as a fit to these points alone. For each limb the
        /// edge with the longest pieces wins, the nearer the limb the better, if they cover 30 % of it. Nothing is
        /// pushed.</summary>
        /// <param name="segments">The edges; their weights are ignored.</param>
        /// <param name="model">The rough cylinder; null = that of the last fit.</param>
        /// <param name="reach">How far a limb may be from that of the model, in pixels, 0 or greater; 0 = 15 % of the
        /// distance of the limbs, at least 4.</param>
        /// <returns>For each segment 1 or 2 for the limb that it lies on, in the order of <see
        /// cref="Cylinder.Project"/>, 0 for none.</returns>
        /// <exception cref="CylfuseException">BadState without model, intrinsics or points, InvalidArgument for a bad
        /// segment or reach, EdgeGeometry when the camera is inside the cylinder or a limb cannot be seen.</exception>
        public unsafe byte[] SelectEdges(Segments segments, Cylinder model = null, double reach = 0)
        {
            if (segments == null) throw new ArgumentNullException(nameof(segments));
            using (var pins = new Pins())
            {
                NativeCylinder cylinder;
                NativeSegmentsView view;
                segments.Write(&view, pins);
                var limbs = new byte[segments.Count];
                using (Call call = Enter())
                {
                    fixed (byte* buffer = limbs)
                    {
                        call.Check(Native.Functions.FitterSelectEdges(
                            call.Pointer,
                                Cylinder.Write(model, &cylinder), &view, reach, buffer, (UIntPtr)limbs.Length));
                    }
                }
                return limbs;
            }
        }

        private delegate int Filling(UIntPtr capacity, out UIntPtr count);

        /// <summary>Asks for the number of elements and then for the elements, again where another thread has added some
        /// meanwhile; says how many there are, which may have become fewer.</summary>
        private static int Fill(Call call, Filling fill)
        {
            int status = fill(UIntPtr.Zero, out UIntPtr count);
            while (status == (int)Status.BufferTooSmall) status = fill(count, out count);
            call.Check(status);
            return (int)count;
        }

        private unsafe T[] List<T>(NativeFunctions.ListFunction function, int elementSize) where T : struct
        {
            using (Call call = Enter())
            {
                var size = (UIntPtr)elementSize;
                T[] elements = null;
                int length = Fill(call, (UIntPtr capacity, out UIntPtr count) =>
                {
                    elements = new T[(long)capacity];
                    using (var pins = new Pins())
                        return function(call.Pointer, (void*)pins.Add(elements), size, capacity, out count);
                });
                Array.Resize(ref elements, length);
                return elements;
            }
        }

        private static unsafe long Bound(Call call, NativeMaskView* mask, Layout layout)
        {
            call.Check(Native.Functions.FitterCompleteBound(call.Pointer, mask, (int)layout, out UIntPtr capacity));
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
                NativeCompletion completion;
                Native.Check(Native.Functions.CompletionInit(&completion, (UIntPtr)sizeof(NativeCompletion)));
                NativePointsOut target;
                Native.Check(Native.Functions.PointsOutInit(&target, (UIntPtr)sizeof(NativePointsOut)));
                using (Call call = Enter())
                {
                    Intrinsics camera = Intrinsics;
                    long capacity = Bound(call, regionOrNull, layout);
                    var coordinates = new T[3 * capacity];
                    target.scalar = scalar;
                    target.data = pins.Add(coordinates);
                    target.capacity = (UIntPtr)capacity;
                    call.Check(Native.Functions.FitterComplete(call.Pointer,
                        Cylinder.Write(model, &cylinder), regionOrNull,
                        (int)layout, &target, &completion));
                    if (layout == Layout.Organised)
                        return new CompletedCloud<T>(coordinates, camera.Width, camera.Height,
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
                NativeCompletion completion;
                Native.Check(Native.Functions.CompletionInit(&completion, (UIntPtr)sizeof(NativeCompletion)));
                NativeDepthOut target;
                Native.Check(Native.Functions.DepthOutInit(&target, (UIntPtr)sizeof(NativeDepthOut)));
                using (Call call = Enter())
                {
                    // Without a camera the image has no size; the library then says what is missing.
                    Intrinsics camera = Intrinsics;
                    var depth = new T[camera?.Height ?? 0, camera?.Width ?? 0];
                    target.format = format;
                    target.data = pins.Add(depth);
                    target.width = (uint)depth.GetLength(1);
                    target.height = (uint)depth.GetLength(0);
                    target.scale = scale;
                    call.Check(Native.Functions.FitterCompleteDepth(call.Pointer,
                        Cylinder.Write(model, &cylinder), regionOrNull,
                        &target, &completion));
                    return new CompletedDepth<T>(depth, new Completion(completion));
                }
            }
        }
    }
}
