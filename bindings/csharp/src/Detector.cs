using System;
using System.Threading;

namespace Cylfuse
{
    /// <summary>Finds all cylinders of a frame or a cloud, without masks, and fits each by the full method.</summary>
    /// <remarks>
    /// <para>A search returns the cylinders by falling score; there may be none. <see cref="Detections"/>, <see
    /// cref="Labels"/>, <see cref="Indices"/> and <see cref="MakeFitter"/> are of the last search that
    /// succeeded.</para>
    /// <para>The threads of a detector follow the rules of a <see cref="Fitter"/>: calls that only read run side by
    /// side, and what would disturb another call throws with <see cref="Status.Busy"/> at once.</para>
    /// </remarks>
    public sealed class Detector : IDisposable
    {
        private readonly DetectorHandle handle = new DetectorHandle();
        private readonly NativeFunctions.DetectionProgressCallback nativeProgress;
        private Func<DetectionProgress, bool> progress;
        private bool progressInstalled;

        // A search holds it for writing, what reads its scene in several calls for reading. A callback, on the thread of
        // the search, may enter it again, and is refused by the library.
        private readonly ReaderWriterLockSlim scene = new ReaderWriterLockSlim(LockRecursionPolicy.SupportsRecursion);
        // Of the last scene; the camera is null for a cloud.
        private int rows;
        private int columns;
        private Intrinsics camera;

        /// <summary>A detector with default options.</summary>
        /// <exception cref="DllNotFoundException">The native library was not found or cannot be loaded.</exception>
        /// <exception cref="EntryPointNotFoundException">The native library is older than this package.</exception>
        /// <exception cref="CylfuseException">The native library has another binary interface
        /// (AbiMismatch).</exception>
        public unsafe Detector()
        {
            // A field, because the library keeps this function and the garbage collector does not know that.
            nativeProgress = OnProgress;
        }

        /// <summary>Destroys the detector and frees what it holds; fitters that it made stay. May be called more than
        /// once.</summary>
        public void Dispose() => handle.Dispose();

        /// <summary>The options; setting them replaces all. What is read is a copy.</summary>
        /// <exception cref="CylfuseException">A value is out of range (InvalidArgument); the old options
        /// stay.</exception>
        public unsafe DetectorOptions Options
        {
            get
            {
                NativeDetectorOptions native;
                Native.Check(Native.Functions.DetectorOptionsInit(&native, (UIntPtr)sizeof(NativeDetectorOptions)));
                using (Call call = Enter()) call.Check(Native.Functions.DetectorGetOptions(call.Pointer, &native));
                return new DetectorOptions(native);
            }
            set
            {
                if (value == null) throw new ArgumentNullException(nameof(value));
                NativeDetectorOptions native = value.ToNative();
                using (Call call = Enter()) call.Check(Native.Functions.DetectorSetOptions(call.Pointer, &native));
            }
        }

        /// <summary>The options of the fits. Limits, threads and start must have their defaults: they are the
        /// detector's.</summary>
        /// <exception cref="CylfuseException">A value is out of range or the detector's (InvalidArgument); the old
        /// options stay.</exception>
        public unsafe FitOptions FitOptions
        {
            get
            {
                NativeOptions native;
                Native.Check(Native.Functions.OptionsInit(&native, (UIntPtr)sizeof(NativeOptions)));
                using (Call call = Enter()) call.Check(Native.Functions.DetectorGetFitOptions(call.Pointer, &native));
                return new FitOptions(native);
            }
            set
            {
                if (value == null) throw new ArgumentNullException(nameof(value));
                NativeOptions native = value.ToNative();
                using (Call call = Enter()) call.Check(Native.Functions.DetectorSetFitOptions(call.Pointer, &native));
            }
        }

        /// <summary>Sets or takes away the function that is called with the progress of a search: before it, after it,
        /// and after each fit, on the thread of the search. It returns whether to go on; otherwise the search throws with <see
        /// cref="Status.Cancelled"/>. An exception that it throws stops the search and comes out of it.</summary>
        /// <param name="handler">null for none.</param>
        public void SetProgress(Func<DetectionProgress, bool> handler)
        {
            using (Call call = Enter())
            {
                InstallProgress(call, handler != null);
                progress = handler;
            }
        }

        /// <summary>Asks the call that is running to stop: a search throws with <see cref="Status.Cancelled"/>. When no
        /// call is running it does nothing. From any thread, at any time.</summary>
        public void Cancel()
        {
            using (Call call = Enter()) call.Check(Native.Functions.DetectorCancel(call.Pointer));
        }

        /// <summary>Finds all cylinders in the depth image of a frame, and fits each to its region by depth and image,
        /// in the reference frame to which the pose of the frame leads.</summary>
        /// <param name="frame">The frame, with intrinsics and a depth image. The images are shared and not copied; it
        /// may be changed or disposed afterwards, of which the detector sees nothing.</param>
        /// <param name="cancellation">Stops the search.</param>
        /// <returns>The cylinders by falling score.</returns>
        /// <exception cref="CylfuseException">BadState without intrinsics or depth, Unsupported for options of the fits
        /// that need edges, Cancelled; the last scene stays then.</exception>
        /// <exception cref="OperationCanceledException">The token was cancelled.</exception>
        public Detection[] Detect(Frame frame, CancellationToken cancellation = default(CancellationToken))
        {
            if (frame == null) throw new ArgumentNullException(nameof(frame));
            // The call on the detector is the inner one: it is the one that fails.
            using (Call used = frame.Enter())
            {
                Intrinsics seenBy = frame.Intrinsics;
                return Search(pointer => Native.Functions.DetectorDetect(pointer, used.Pointer), seenBy?.Height ?? 0,
                    seenBy?.Width ?? 0, seenBy, cancellation);
            }
        }

        /// <summary>Finds all cylinders in a cloud, organised or not, and fits each to its points. Points with a
        /// coordinate that is not finite or a weight of 0 are left out. It is looked at from
        /// where one sensor has seen it, in its origin or where the densities of the points tell; other clouds are looked
        /// at from all sides, which takes about ten times as long.</summary>
        /// <param name="points">The points.</param>
        /// <param name="cancellation">Stops the search.</param>
        /// <returns>The cylinders by falling score.</returns>
        /// <exception cref="CylfuseException">InvalidArgument for a negative weight, Unsupported for options of the fits
        /// that need edges, Cancelled; the last scene stays then.</exception>
        /// <exception cref="OperationCanceledException">The token was cancelled.</exception>
        public unsafe Detection[] DetectPoints(PointCloud points,
            CancellationToken cancellation = default(CancellationToken))
        {
            if (points == null) throw new ArgumentNullException(nameof(points));
            using (var pins = new Pins())
            {
                NativePointsView view;
                points.Write(&view, pins);
                NativePointsView* given = &view;
                return Search(pointer => Native.Functions.DetectorDetectPoints(pointer, given), points.Height,
                    points.Width, null, cancellation);
            }
        }

        /// <summary>The cylinders of the last search that succeeded, by falling score.</summary>
        /// <exception cref="CylfuseException">BadState before the first search.</exception>
        public Detection[] Detections() => Reading(Read);

        /// <summary>Whether the scene was looked at as a whole. The work of a search with its fits is bounded: of a scene
        /// with more in it than that, cylinders may be missing. One for whose fit there was no work left is what the search
        /// found, with <see cref="ResultFlags.NotConverged"/>.</summary>
        /// <exception cref="CylfuseException">BadState before the first search.</exception>
        public bool IsComplete
        {
            get
            {
                using (Call call = Enter())
                {
                    call.Check(Native.Functions.DetectorIsComplete(call.Pointer, out int complete));
                    return complete != 0;
                }
            }
        }

        /// <summary>The columns (to the right) and rows (down) by which the depth of the frame was moved to where the image
        /// shows the same bodies; zeros where it was not. Each result then has
        /// <see cref="ResultFlags.DepthShifted"/>; labels and indices are those of the depth as it was given.</summary>
        /// <exception cref="CylfuseException">BadState before the first search.</exception>
        public (int Columns, int Rows) DepthMoved
        {
            get
            {
                using (Call call = Enter())
                {
                    call.Check(Native.Functions.DetectorDepthMoved(call.Pointer, out int columns, out int rows));
                    return (columns, rows);
                }
            }
        }

        /// <summary>For each pixel of the colour image, or each point of the cloud, the number of its cylinder from 1
        /// on: 1 for the first detection; 0 = none. One row for a cloud that is not organised.</summary>
        /// <exception cref="CylfuseException">BadState before the first search.</exception>
        public unsafe ushort[,] Labels() => Reading(() =>
        {
            using (Call call = Enter())
            {
                int status = Native.Functions.DetectorLabels(call.Pointer, null, UIntPtr.Zero, out UIntPtr count);
                if (status != (int)Status.BufferTooSmall) call.Check(status);
                var labels = new ushort[rows, columns];
                fixed (ushort* buffer = labels)
                {
                    call.Check(Native.Functions.DetectorLabels(call.Pointer, buffer, (UIntPtr)labels.LongLength, out count));
                }
                return labels;
            }
        });

        /// <summary>Lists the pixels or points of one detection, counted from 0 row by row, rising.</summary>
        /// <param name="index">The detection, from 0.</param>
        /// <exception cref="CylfuseException">BadState before the first search, InvalidArgument when there is no such
        /// detection.</exception>
        public unsafe uint[] Indices(int index)
        {
            NotNegative(index);
            return Reading(() =>
            {
                using (Call call = Enter())
                {
                    int status = Native.Functions.DetectorIndices(call.Pointer, (UIntPtr)index, null, UIntPtr.Zero,
                        out UIntPtr count);
                    if (status != (int)Status.BufferTooSmall) call.Check(status);
                    var indices = new uint[(long)count];
                    fixed (uint* buffer = indices)
                    {
                        call.Check(Native.Functions.DetectorIndices(call.Pointer, (UIntPtr)index, buffer, count, out count));
                    }
                    return indices;
                }
            });
        }

        /// <summary>Makes a fitter of one detection as its fit left it, with options, frame or points, region as mask,
        /// start model and result: for residuals, completion, limbs and all else that can be asked of a fit, or for
        /// another fit. It shares the images of the frame and does not depend on the detector.</summary>
        /// <param name="index">The detection, from 0.</param>
        /// <exception cref="CylfuseException">BadState before the first search, InvalidArgument when there is no such
        /// detection.</exception>
        public Fitter MakeFitter(int index)
        {
            NotNegative(index);
            return Reading(() =>
            {
                using (Call call = Enter()) return new Fitter(new FitterHandle(call, index), camera);
            });
        }

        private Detection[] Search(Func<IntPtr, int> search, int height, int width, Intrinsics seenBy,
            CancellationToken cancellation)
        {
            cancellation.ThrowIfCancellationRequested();
            if (!scene.TryEnterWriteLock(0)) throw Busy();
            try
            {
                using (Call call = Enter())
                {
                    if (cancellation.CanBeCanceled && !progressInstalled) InstallProgress(call, true);
                    int status;
                    using (call.StopBy(cancellation, Native.Functions.DetectorCancel)) status = search(call.Pointer);
                    if (status == (int)Status.Cancelled && !call.CallbackFailed) cancellation.ThrowIfCancellationRequested();
                    call.Check(status);
                }
                rows = height;
                columns = width;
                camera = seenBy;
                return Read();
            }
            finally { scene.ExitWriteLock(); }
        }

        private T Reading<T>(Func<T> read)
        {
            if (!scene.TryEnterReadLock(0)) throw Busy();
            try { return read(); }
            finally { scene.ExitReadLock(); }
        }

        private unsafe Detection[] Read()
        {
            using (Call call = Enter())
            {
                call.Check(Native.Functions.DetectorCount(call.Pointer, out UIntPtr count));
                var found = new NativeDetection[(int)count];
                fixed (NativeDetection* buffer = found)
                {
                    call.Check(Native.Functions.DetectorDetections(call.Pointer, buffer, (UIntPtr)sizeof(NativeDetection),
                        count, out count));
                }
                var detections = new Detection[found.Length];
                for (int index = 0; index < found.Length; index++)
                {
                    NativeResult result;
                    NativeCylinderEstimate estimate;
                    NativeExtent extent;
                    Fitter.Prepare(&result, &estimate);
                    Native.Check(Native.Functions.ExtentInit(&extent, (UIntPtr)sizeof(NativeExtent)));
                    call.Check(Native.Functions.DetectorGetResult(call.Pointer, (UIntPtr)index, &result));
                    call.Check(Native.Functions.DetectorGetCylinder(call.Pointer, (UIntPtr)index, &estimate));
                    int status = Native.Functions.DetectorGetExtent(call.Pointer, (UIntPtr)index, &extent);
                    CylfuseException error = status == 0 ? null : call.Failure(status);
                    if (error?.Status == Status.Busy) throw error;
                    detections[index] = new Detection(found[index], new FitResult(result, estimate),
                        error == null ? new Extent(extent) : null, error);
                }
                return detections;
            }
        }

        private void InstallProgress(Call call, bool wanted)
        {
            call.Check(Native.Functions.DetectorSetProgress(call.Pointer, wanted ? nativeProgress : null, IntPtr.Zero));
            progressInstalled = wanted;
        }

        private unsafe int OnProgress(NativeDetectionProgress* native, IntPtr userData)
        {
            bool goesOn = false;
            Call call = Call.Current;
            call.Guard(() => goesOn = !call.Token.IsCancellationRequested &&
                (progress == null || progress(new DetectionProgress(*native))));
            return goesOn ? 0 : 1;
        }

        private static void NotNegative(int index)
        {
            if (index < 0)
                throw new ArgumentOutOfRangeException(nameof(index), $"There is no cylinder {index}: they count from 0.");
        }

        private static CylfuseException Busy() => CylfuseException.For(Status.Busy, Library.StatusText(Status.Busy));

        private Call Enter() => new Call(handle);
    }
}
