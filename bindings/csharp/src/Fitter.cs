using System;
using System.Collections.Generic;
using System.Threading;

namespace Cylfuse
{
    /// <summary>Estimates one cylinder: holds options, views with their data, and the last result.</summary>
    /// <remarks>
    /// <para>Create it, push points (or set the intrinsics, push a depth image with a mask and the image), fit. For the
    /// next frame: clear, push, fit. The library copies what is pushed.</para>
    /// <para>A fitter may move between threads. Calls that only read, such as <see cref="Result"/>, <see
    /// cref="Residuals"/> or <see cref="Evaluate"/>, run side by side; a call that may change the fitter runs alone.
    /// What would disturb another call, from another thread or from a callback, throws a <see cref="CylfuseException"/>
    /// with <see cref="Status.Busy"/> at once. Only <see cref="Cancel"/> and <see cref="Dispose"/> always go through;
    /// the fitter is then destroyed after the calls that are running. Different fitters run in parallel.</para>
    /// </remarks>
    public sealed partial class Fitter : IDisposable
    {
        private readonly FitterHandle handle;
        private readonly NativeFunctions.ProgressCallback nativeProgress;
        private readonly NativeFunctions.LogCallback nativeLog;
        private Func<Progress, bool> progress;
        private Action<LogLevel, string> log;
        private bool progressInstalled;

        /// <summary>A fitter with default options, one view at the identity, and no data.</summary>
        /// <exception cref="DllNotFoundException">The native library was not found or cannot be loaded.</exception>
        /// <exception cref="EntryPointNotFoundException">The native library is older than this package.</exception>
        /// <exception cref="CylfuseException">The native library has another binary interface
        /// (AbiMismatch).</exception>
        public Fitter() : this(new FitterHandle(), null) { }

        /// <summary>Takes a fitter with the camera of its first view.</summary>
        internal unsafe Fitter(FitterHandle handle, Intrinsics camera)
        {
            // Fields, because the library keeps these functions and the garbage collector does not know that.
            nativeProgress = OnProgress;
            nativeLog = OnLog;
            this.handle = handle;
            cameras = new List<Intrinsics> { camera };
        }

        /// <summary>Destroys the fitter and frees what it holds. May be called more than once.</summary>
        public void Dispose() => handle.Dispose();

        /// <summary>The options; setting them replaces all. What is read is a copy.</summary>
        /// <exception cref="CylfuseException">A value is out of range (InvalidArgument); the old options
        /// stay.</exception>
        public unsafe FitOptions Options
        {
            get
            {
                NativeOptions native;
                Native.Check(Native.Functions.OptionsInit(&native, (UIntPtr)sizeof(NativeOptions)));
                using (Call call = Enter()) call.Check(Native.Functions.FitterGetOptions(call.Pointer, &native));
                return new FitOptions(native);
            }
            set
            {
                if (value == null) throw new ArgumentNullException(nameof(value));
                NativeOptions native = value.ToNative();
                using (Call call = Enter()) call.Check(Native.Functions.FitterSetOptions(call.Pointer, &native));
            }
        }

        /// <summary>Sets a start model: a candidate for the start Auto, the start of Model.</summary>
        /// <param name="model">The model, in the reference frame; null takes it away.</param>
        /// <exception cref="CylfuseException">The model is no cylinder (InvalidArgument); the old one
        /// stays.</exception>
        public unsafe void SetStartModel(Cylinder model)
        {
            NativeCylinder native;
            using (Call call = Enter())
                call.Check(Native.Functions.FitterSetStartModel(call.Pointer, Cylinder.Write(model, &native)));
        }

        /// <summary>Sets or takes away the function that is called before every iteration of a fit, on the thread of the
        /// fit. It returns whether to go on; otherwise the fit throws with <see cref="Status.Cancelled"/>. An exception
        /// that it throws stops the fit and comes out of it.</summary>
        /// <param name="handler">null for none.</param>
        public void SetProgress(Func<Progress, bool> handler)
        {
            using (Call call = Enter())
            {
                InstallProgress(call, handler != null);
                progress = handler;
            }
        }

        /// <summary>Sets or takes away the function that takes log lines, on the thread of the call: on
        /// several at once when several threads make calls that only read. An exception that it
        /// throws comes out of the call when that has ended.</summary>
        /// <param name="maxLevel">Lines up to this level are handed over.</param>
        /// <param name="handler">null for none.</param>
        public unsafe void SetLog(LogLevel maxLevel, Action<LogLevel, string> handler)
        {
            using (Call call = Enter())
            {
                call.Check(Native.Functions.FitterSetLog(call.Pointer,
                    (int)maxLevel, handler == null ? null : nativeLog,
                    IntPtr.Zero));
                log = handler;
            }
        }

        /// <summary>Makes room for the coordinates of that many more points and for that many more segments in the
        /// selected view.</summary>
        /// <exception cref="CylfuseException">OutOfMemory.</exception>
        public void Reserve(int points, int segments)
        {
            if (points < 0 || segments < 0)
                throw new ArgumentOutOfRangeException(nameof(points),
                    $"Room for {points} points and {segments} segments cannot be made: neither number may be negative.");
            using (Call call = Enter())
                call.Check(Native.Functions.FitterReserve(call.Pointer, (UIntPtr)points, (UIntPtr)segments));
        }

        /// <summary>Forgets the data, all views but the first, its pose and the result; keeps options, the cameras of
        /// the first view, start model, what the start <see cref="StartKind.Last"/> goes on from, callbacks and memory: the
        /// way from one frame to the next.</summary>
        public void Clear()
        {
            using (Call call = Enter())
            {
                call.Check(Native.Functions.FitterClear(call.Pointer));
                lock (cameras)
                {
                    cameras.RemoveRange(1, cameras.Count - 1);
                    selected = 0;
                }
            }
        }

        /// <summary>Forgets some of the data of the selected view, and keeps the rest and the last result.</summary>
        /// <param name="inputs">Which data.</param>
        /// <exception cref="CylfuseException">An unknown bit (InvalidArgument).</exception>
        public void ClearInput(Inputs inputs)
        {
            using (Call call = Enter()) call.Check(Native.Functions.FitterClearInput(call.Pointer, (uint)inputs));
        }

        /// <summary>Asks the calls that are running to stop: a fit throws with <see cref="Status.Cancelled"/>. When no
        /// call is running it does nothing. From any thread, at any time.</summary>
        public void Cancel()
        {
            using (Call call = Enter()) call.Check(Native.Functions.FitterCancel(call.Pointer));
        }

        /// <summary>Adds points to the selected view, in its camera frame when edges, the near-wall rule, completion or
        /// extent matter, else in any frame. Points with a coordinate that is not finite, a weight of 0 or outside the
        /// mask are left out and counted.</summary>
        /// <param name="points">The points.</param>
        /// <param name="mask">Selects pixels of an organised cloud, of the same size as it; null = all.</param>
        /// <exception cref="CylfuseException">SizeMismatch, EmptyMask, InvalidArgument for a negative weight; nothing
        /// is added then.</exception>
        public unsafe void PushPoints(PointCloud points, Mask mask = null)
        {
            if (points == null) throw new ArgumentNullException(nameof(points));
            using (var pins = new Pins())
            {
                NativePointsView view;
                points.Write(&view, pins);
                NativeMaskView region;
                NativeMaskView* regionOrNull = Mask.Write(mask, &region, pins);
                using (Call call = Enter())
                    call.Check(Native.Functions.FitterPushPoints(call.Pointer, &view, regionOrNull));
            }
        }

        /// <summary>Adds the points of a depth image of the selected view. Pixels without a depth, out of range,
        /// outside the mask or hidden from the colour camera are left out and counted. The image and the mask are kept,
        /// in place of earlier ones, for completion and extent.</summary>
        /// <param name="depth">The image.</param>
        /// <param name="mask">In the pixels of the colour image; null = all pixels.</param>
        /// <exception cref="CylfuseException">BadState without intrinsics, SizeMismatch, EmptyMask, NoDepth when no
        /// pixel is usable, InvalidArgument for a bad scale or range; nothing is added then.</exception>
        public unsafe void PushDepth(DepthImage depth, Mask mask = null)
        {
            if (depth == null) throw new ArgumentNullException(nameof(depth));
            using (var pins = new Pins())
            {
                NativeDepthView view;
                depth.Write(&view, pins);
                NativeMaskView region;
                NativeMaskView* regionOrNull = Mask.Write(mask, &region, pins);
                using (Call call = Enter())
                    call.Check(Native.Functions.FitterPushDepth(call.Pointer, &view, regionOrNull));
            }
        }

        /// <summary>Takes the image of the selected view, grey or in colour, in place of an earlier one: limbs, arcs of
        /// the ends and ends are located in it, as options and objective say.</summary>
        /// <exception cref="CylfuseException">BadState without intrinsics, SizeMismatch, InvalidArgument for a bad
        /// gamma or a value that is not finite or that the gamma forbids; the earlier image stays then.</exception>
        public unsafe void PushImage(Image image)
        {
            if (image == null) throw new ArgumentNullException(nameof(image));
            using (var pins = new Pins())
            {
                NativeImageView view;
                image.Write(&view, pins);
                using (Call call = Enter()) call.Check(Native.Functions.FitterPushImage(call.Pointer, &view));
            }
        }

        /// <summary>Adds edge segments to the selected view, any number of either limb. A fit with segments needs
        /// intrinsics.</summary>
        /// <exception cref="CylfuseException">InvalidArgument when a coordinate is not finite or a weight is negative;
        /// nothing is added then.</exception>
        public unsafe void PushEdges(Segments segments)
        {
            if (segments == null) throw new ArgumentNullException(nameof(segments));
            using (var pins = new Pins())
            {
                NativeSegmentsView view;
                segments.Write(&view, pins);
                using (Call call = Enter()) call.Check(Native.Functions.FitterPushEdges(call.Pointer, &view));
            }
        }

        /// <summary>Adds edge segments, one a row: x1, y1, x2, y2.</summary>
        public void PushEdges(double[,] segments) => PushEdges(Segments.From(segments));

        /// <summary>Says what was pushed into the selected view since the fitter was created or cleared, and what was
        /// left out by reason.</summary>
        public unsafe Counts Counts()
        {
            NativeCounts native;
            Native.Check(Native.Functions.CountsInit(&native, (UIntPtr)sizeof(NativeCounts)));
            using (Call call = Enter()) call.Check(Native.Functions.FitterCounts(call.Pointer, &native));
            return new Counts(native);
        }

        /// <summary>Estimates the cylinder from everything that was pushed into all views. Lack of convergence and
        /// other warnings are not errors but properties of the result.</summary>
        /// <param name="cancellation">Stops the fit.</param>
        /// <exception cref="UnusableDataException">The data do not determine a cylinder; the last result
        /// stays.</exception>
        /// <exception cref="CylfuseException">Unsupported, BadState: the data do not go with the options;
        /// Cancelled.</exception>
        /// <exception cref="OperationCanceledException">The token was cancelled.</exception>
        public unsafe FitResult Fit(CancellationToken cancellation = default(CancellationToken))
        {
            cancellation.ThrowIfCancellationRequested();
            NativeResult result;
            NativeCylinderEstimate estimate;
            Prepare(&result, &estimate);
            using (Call call = Enter())
            {
                if (cancellation.CanBeCanceled && !progressInstalled) InstallProgress(call, true);
                int status;
                using (call.StopBy(cancellation, Native.Functions.FitterCancel))
                    status = Native.Functions.FitterFit(call.Pointer, &result, &estimate);
                if (status == (int)Status.Cancelled && !call.CallbackFailed) cancellation.ThrowIfCancellationRequested();
                call.Check(status);
            }
            return new FitResult(result, estimate);
        }

        /// <summary>Says what a fit would report for a given cylinder, in the reference frame, without iterating. The
        /// last result stays.</summary>
        /// <exception cref="CylfuseException">InvalidArgument for a bad model, else as <see cref="Fit"/>.</exception>
        public unsafe FitResult Evaluate(Cylinder model)
        {
            if (model == null) throw new ArgumentNullException(nameof(model));
            NativeCylinder cylinder;
            NativeResult result;
            NativeCylinderEstimate estimate;
            Prepare(&result, &estimate);
            using (Call call = Enter())
                call.Check(Native.Functions.FitterEvaluate(call.Pointer,
                    Cylinder.Write(model, &cylinder), &result, &estimate));
            return new FitResult(result, estimate);
        }

        /// <summary>The result of the last fit that succeeded.</summary>
        /// <exception cref="CylfuseException">There is none (BadState).</exception>
        public unsafe FitResult Result()
        {
            NativeResult result;
            NativeCylinderEstimate estimate;
            Prepare(&result, &estimate);
            using (Call call = Enter())
            {
                call.Check(Native.Functions.FitterGetResult(call.Pointer, &result));
                call.Check(Native.Functions.FitterGetCylinder(call.Pointer, &estimate));
            }
            return new FitResult(result, estimate);
        }

        internal static unsafe void Prepare(NativeResult* result, NativeCylinderEstimate* estimate)
        {
            Native.Check(Native.Functions.ResultInit(result, (UIntPtr)sizeof(NativeResult)));
            Native.Check(Native.Functions.CylinderEstimateInit(estimate, (UIntPtr)sizeof(NativeCylinderEstimate)));
        }

        private void InstallProgress(Call call, bool wanted)
        {
            call.Check(Native.Functions.FitterSetProgress(call.Pointer, wanted ? nativeProgress : null, IntPtr.Zero));
            progressInstalled = wanted;
        }

        private unsafe int OnProgress(NativeProgress* native, IntPtr userData)
        {
            bool goesOn = false;
            Call call = Call.Current;
            call.Guard(() => goesOn = !call.Token.IsCancellationRequested &&
                (progress == null || progress(new Progress(*native))));
            return goesOn ? 0 : 1;
        }

        private void OnLog(int level, IntPtr message, IntPtr userData) =>
            Call.Current?.Guard(() => log?.Invoke((LogLevel)level, Library.Text(message)));

        private Call Enter() => new Call(handle);
    }
}
