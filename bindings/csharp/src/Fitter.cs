using System;
using System.Runtime.ExceptionServices;
using System.Threading;

namespace Cylfuse
{
    /// <summary>Estimates one cylinder: holds options, camera, data and the last result.</summary>
    /// <remarks>
    /// <para>Create it, push points (or set the intrinsics, push a depth image with a mask and edges), fit. For the next
    /// frame: clear, push, fit. The library copies what is pushed.</para>
    /// <para>A fitter may move between threads, but runs one call at a time: a second one, from another thread or from a
    /// callback, throws a <see cref="CylfuseException"/> with <see cref="Status.Busy"/>. Only <see cref="Cancel"/> and
    /// <see cref="Dispose"/> may come while another call is running; the fitter is then destroyed after that call.
    /// Different fitters run in parallel.</para>
    /// </remarks>
    public sealed partial class Fitter : IDisposable
    {
        private readonly FitterHandle handle;
        private readonly NativeFunctions.ProgressCallback nativeProgress;
        private readonly NativeFunctions.LogCallback nativeLog;
        private Func<Progress, bool> progress;
        private Action<LogLevel, string> log;
        private bool progressInstalled;
        private CancellationToken token;
        private ExceptionDispatchInfo callbackFailure;
        private Intrinsics intrinsics;
        private int busy;

        /// <summary>A fitter with default options and no data.</summary>
        /// <exception cref="DllNotFoundException">The native library was not found.</exception>
        /// <exception cref="CylfuseException">The native library has another binary interface (AbiMismatch).</exception>
        public unsafe Fitter()
        {
            // Fields, because the library keeps these functions and the garbage collector does not know that.
            nativeProgress = OnProgress;
            nativeLog = OnLog;
            handle = FitterHandle.Create();
        }

        /// <summary>Destroys the fitter and frees what it holds. May be called more than once.</summary>
        public void Dispose() => handle.Dispose();

        /// <summary>The options; setting them replaces all. What is read is a copy.</summary>
        /// <exception cref="CylfuseException">A value is out of range (InvalidArgument); the old options stay.</exception>
        public unsafe FitOptions Options
        {
            get
            {
                NativeOptions native = default(NativeOptions);
                native.struct_size = (uint)NativeFunctions.SizeOf<NativeOptions>();
                Enter();
                try { Check(NativeFunctions.FitterGetOptions(handle, &native)); }
                finally { Leave(); }
                return new FitOptions(&native);
            }
            set
            {
                if (value == null) throw new ArgumentNullException(nameof(value));
                NativeOptions native;
                value.Write(&native);
                Enter();
                try { Check(NativeFunctions.FitterSetOptions(handle, &native)); }
                finally { Leave(); }
            }
        }

        /// <summary>The camera, which depth images and edges need; null when it was not set. Points that were pushed before
        /// stay as they are.</summary>
        /// <exception cref="CylfuseException">No camera works with these numbers (InvalidIntrinsics); the old one
        /// stays.</exception>
        public unsafe Intrinsics Intrinsics
        {
            get => intrinsics;
            set
            {
                if (value == null) throw new ArgumentNullException(nameof(value));
                NativeIntrinsics native;
                value.Write(&native);
                Enter();
                try
                {
                    Check(NativeFunctions.FitterSetIntrinsics(handle, &native));
                    intrinsics = value;
                }
                finally { Leave(); }
            }
        }

        /// <summary>Sets a start model: a candidate for the start Auto, the start of Model.</summary>
        /// <param name="model">The model; null takes it away.</param>
        /// <exception cref="CylfuseException">The model is no cylinder (InvalidArgument); the old one stays.</exception>
        public unsafe void SetStartModel(Cylinder model)
        {
            NativeCylinder native;
            Enter();
            try { Check(NativeFunctions.FitterSetStartModel(handle, Model(model, &native))); }
            finally { Leave(); }
        }

        /// <summary>Sets or takes away the function that hears of every linear solve of a fit, on the thread of the
        /// fit. It returns whether to go on; otherwise the fit throws with <see cref="Status.Cancelled"/>. An exception
        /// that it throws stops the fit and comes out of it.</summary>
        /// <param name="handler">null for none.</param>
        public void SetProgress(Func<Progress, bool> handler)
        {
            Enter();
            try
            {
                progress = handler;
                InstallProgress();
            }
            finally { Leave(); }
        }

        /// <summary>Sets or takes away the function that takes log lines, on the thread of the call. An exception that it
        /// throws comes out of the call when that has ended.</summary>
        /// <param name="maxLevel">Lines up to this level are handed over.</param>
        /// <param name="handler">null for none.</param>
        public unsafe void SetLog(LogLevel maxLevel, Action<LogLevel, string> handler)
        {
            Enter();
            try
            {
                Check(NativeFunctions.FitterSetLog(handle, (int)maxLevel, handler == null ? null : nativeLog,
                    IntPtr.Zero));
                log = handler;
            }
            finally { Leave(); }
        }

        /// <summary>Makes room, so that pushing that many more points and segments needs no memory.</summary>
        /// <exception cref="CylfuseException">OutOfMemory.</exception>
        public void Reserve(int points, int segments)
        {
            if (points < 0 || segments < 0)
                throw new ArgumentOutOfRangeException(nameof(points),
                    $"Room for {points} points and {segments} segments cannot be made: neither number may be negative.");
            Enter();
            try { Check(NativeFunctions.FitterReserve(handle, (UIntPtr)points, (UIntPtr)segments)); }
            finally { Leave(); }
        }

        /// <summary>Forgets data, result and a pending request to cancel; keeps options, camera, start model, callbacks and
        /// memory: the way from one frame to the next.</summary>
        public void Clear()
        {
            Enter();
            try { Check(NativeFunctions.FitterClear(handle)); }
            finally { Leave(); }
        }

        /// <summary>Asks the running fit to stop: it throws with <see cref="Status.Cancelled"/>. When no fit is running,
        /// the next one stops at once, unless <see cref="Clear"/> comes before it. From any thread, at any time.</summary>
        public void Cancel() => NativeFunctions.Check(NativeFunctions.FitterCancel(handle));

        /// <summary>Adds points, in the camera frame when edges, the near-wall rule, completion or extent matter, else in
        /// any frame. Points with a coordinate that is not finite, a weight of 0 or outside the mask are left out and
        /// counted.</summary>
        /// <param name="points">The points.</param>
        /// <param name="mask">Selects pixels of an organised cloud, of the same size as it; null = all.</param>
        /// <exception cref="CylfuseException">SizeMismatch, EmptyMask, InvalidArgument for a negative weight; nothing is
        /// added then.</exception>
        public unsafe void PushPoints(PointCloud points, Mask mask = null)
        {
            if (points == null) throw new ArgumentNullException(nameof(points));
            using (var pins = new Pins())
            {
                NativePointsView view;
                points.Write(&view, pins);
                NativeMaskView region;
                NativeMaskView* regionOrNull = Region(mask, &region, pins);
                Enter();
                try { Check(NativeFunctions.FitterPushPoints(handle, &view, regionOrNull)); }
                finally { Leave(); }
            }
        }

        /// <summary>Adds the points of a depth image of the camera. Pixels without a depth, out of range or outside the mask
        /// are left out and counted. The image and the mask are kept, in place of earlier ones, for completion and
        /// extent.</summary>
        /// <param name="depth">The image.</param>
        /// <param name="mask">Of the same size as the image; null = all pixels.</param>
        /// <exception cref="CylfuseException">BadState without intrinsics, SizeMismatch, EmptyMask, NoDepth when no pixel
        /// is usable, InvalidArgument for a bad scale or range; nothing is added then.</exception>
        public unsafe void PushDepth(DepthImage depth, Mask mask = null)
        {
            if (depth == null) throw new ArgumentNullException(nameof(depth));
            using (var pins = new Pins())
            {
                NativeDepthView view;
                depth.Write(&view, pins);
                NativeMaskView region;
                NativeMaskView* regionOrNull = Region(mask, &region, pins);
                Enter();
                try { Check(NativeFunctions.FitterPushDepth(handle, &view, regionOrNull)); }
                finally { Leave(); }
            }
        }

        /// <summary>Takes the grey image of the camera, in place of an earlier one: limbs, arcs of the ends and ends are
        /// located in it, as options and objective say.</summary>
        /// <exception cref="CylfuseException">BadState without intrinsics, SizeMismatch, InvalidArgument for a value that is
        /// not finite; the earlier image stays then.</exception>
        public unsafe void PushImage(GreyImage image)
        {
            if (image == null) throw new ArgumentNullException(nameof(image));
            using (var pins = new Pins())
            {
                NativeImageView view;
                image.Write(&view, pins);
                Enter();
                try { Check(NativeFunctions.FitterPushImage(handle, &view)); }
                finally { Leave(); }
            }
        }

        /// <summary>Adds edge segments, any number of either limb. A fit with segments needs intrinsics.</summary>
        /// <exception cref="CylfuseException">InvalidArgument when a coordinate is not finite or a weight is negative;
        /// nothing is added then.</exception>
        public unsafe void PushEdges(Segments segments)
        {
            if (segments == null) throw new ArgumentNullException(nameof(segments));
            using (var pins = new Pins())
            {
                NativeSegmentsView view;
                segments.Write(&view, pins);
                Enter();
                try { Check(NativeFunctions.FitterPushEdges(handle, &view)); }
                finally { Leave(); }
            }
        }

        /// <summary>Adds edge segments, one a row: x1, y1, x2, y2.</summary>
        public void PushEdges(double[,] segments) => PushEdges(Segments.From(segments));

        /// <summary>Says what was pushed since the fitter was created or cleared, and what was left out by
        /// reason.</summary>
        public unsafe Counts Counts()
        {
            NativeCounts native = default(NativeCounts);
            native.struct_size = (uint)NativeFunctions.SizeOf<NativeCounts>();
            Enter();
            try { Check(NativeFunctions.FitterCounts(handle, &native)); }
            finally { Leave(); }
            return new Counts(&native);
        }

        /// <summary>Estimates the cylinder from everything that was pushed. No convergence and other doubts are not errors
        /// but properties of the result.</summary>
        /// <param name="cancellation">Stops the fit before its next linear solve.</param>
        /// <exception cref="UnusableDataException">The data do not determine a cylinder; the last result stays.</exception>
        /// <exception cref="CylfuseException">Unsupported, BadState: the data do not go with the options; Cancelled.</exception>
        /// <exception cref="OperationCanceledException">The token was cancelled.</exception>
        public unsafe FitResult Fit(CancellationToken cancellation = default(CancellationToken))
        {
            cancellation.ThrowIfCancellationRequested();
            NativeResult native = default(NativeResult);
            native.struct_size = (uint)NativeFunctions.SizeOf<NativeResult>();
            Enter();
            try
            {
                token = cancellation;
                if (cancellation.CanBeCanceled) InstallProgress();
                int status = NativeFunctions.FitterFit(handle, &native);
                if (status == (int)Status.Cancelled && callbackFailure == null)
                    cancellation.ThrowIfCancellationRequested();
                Check(status);
            }
            finally
            {
                token = CancellationToken.None;
                Leave();
            }
            return new FitResult(&native);
        }

        /// <summary>Says what a fit would report for a given model, without iterating. The last result stays.</summary>
        /// <exception cref="CylfuseException">InvalidArgument for a bad model, else as <see cref="Fit"/>.</exception>
        public unsafe FitResult Evaluate(Cylinder model)
        {
            if (model == null) throw new ArgumentNullException(nameof(model));
            NativeCylinder cylinder;
            NativeResult native = default(NativeResult);
            native.struct_size = (uint)NativeFunctions.SizeOf<NativeResult>();
            Enter();
            try { Check(NativeFunctions.FitterEvaluate(handle, Model(model, &cylinder), &native)); }
            finally { Leave(); }
            return new FitResult(&native);
        }

        /// <summary>The result of the last fit that succeeded.</summary>
        /// <exception cref="CylfuseException">There is none (BadState).</exception>
        public unsafe FitResult Result()
        {
            NativeResult native = default(NativeResult);
            native.struct_size = (uint)NativeFunctions.SizeOf<NativeResult>();
            Enter();
            try { Check(NativeFunctions.FitterGetResult(handle, &native)); }
            finally { Leave(); }
            return new FitResult(&native);
        }

        private static unsafe NativeCylinder* Model(Cylinder model, NativeCylinder* native)
        {
            if (model == null) return null;
            model.Write(native);
            return native;
        }

        private static unsafe NativeMaskView* Region(Mask mask, NativeMaskView* native, Pins pins)
        {
            if (mask == null) return null;
            mask.Write(native, pins);
            return native;
        }

        private unsafe void InstallProgress()
        {
            if (progressInstalled) return;
            Check(NativeFunctions.FitterSetProgress(handle, nativeProgress, IntPtr.Zero));
            progressInstalled = true;
        }

        private unsafe int OnProgress(NativeProgress* native, IntPtr userData)
        {
            // No exception may pass through the library.
            try
            {
                if (token.IsCancellationRequested) return 1;
                return progress == null || progress(new Progress(native)) ? 0 : 1;
            }
            catch (Exception failure)
            {
                callbackFailure = ExceptionDispatchInfo.Capture(failure);
                return 1;
            }
        }

        private void OnLog(int level, IntPtr message, IntPtr userData)
        {
            try { log?.Invoke((LogLevel)level, Library.Text(message)); }
            catch (Exception failure) { callbackFailure = callbackFailure ?? ExceptionDispatchInfo.Capture(failure); }
        }

        /// <summary>Takes the fitter for one call, so that its message is read before another call replaces it.</summary>
        private void Enter()
        {
            if (handle.IsClosed) throw new ObjectDisposedException(nameof(Fitter));
            if (Interlocked.CompareExchange(ref busy, 1, 0) != 0)
                throw CylfuseException.For(Status.Busy, Library.StatusText(Status.Busy));
            callbackFailure = null;
        }

        private void Leave() => Volatile.Write(ref busy, 0);

        /// <summary>Throws what a callback threw, or the failure of the call with its message.</summary>
        private void Check(int status)
        {
            callbackFailure?.Throw();
            if (status == 0) return;
            string message = Library.Text(NativeFunctions.FitterLastError(handle));
            if (string.IsNullOrEmpty(message)) message = Library.StatusText((Status)status);
            throw CylfuseException.For((Status)status, message);
        }
    }
}
