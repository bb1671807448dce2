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
        /// <exception cref="DllNotFoundException">The native library was not found or cannot be loaded.</exception>
        /// <exception cref="EntryPointNotFoundException">The native library is older than this package.</exception>
        /// <exception cref="CylfuseException">The native library has another binary interface (AbiMismatch).</exception>
        public unsafe Fitter()
        {
            // Fields, because the library keeps these functions and the garbage collector does not know that.
            nativeProgress = OnProgress;
            nativeLog = OnLog;
            handle = new FitterHandle();
        }

        /// <summary>Destroys the fitter and frees what it holds. May be called more than once.</summary>
        public void Dispose() => handle.Dispose();

        /// <summary>The options; setting them replaces all. What is read is a copy.</summary>
        /// <exception cref="CylfuseException">A value is out of range (InvalidArgument); the old options stay.</exception>
        public unsafe FitOptions Options
        {
            get
            {
                var native = new NativeOptions { struct_size = (uint)sizeof(NativeOptions) };
                using (Enter()) Check(Native.Functions.FitterGetOptions(Pointer, &native));
                return new FitOptions(native);
            }
            set
            {
                if (value == null) throw new ArgumentNullException(nameof(value));
                NativeOptions native = value.ToNative();
                using (Enter()) Check(Native.Functions.FitterSetOptions(Pointer, &native));
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
                using (Enter())
                {
                    Check(Native.Functions.FitterSetIntrinsics(Pointer, &native));
                    intrinsics = value;
                }
            }
        }

        /// <summary>Sets a start model: a candidate for the start Auto, the start of Model.</summary>
        /// <param name="model">The model; null takes it away.</param>
        /// <exception cref="CylfuseException">The model is no cylinder (InvalidArgument); the old one stays.</exception>
        public unsafe void SetStartModel(Cylinder model)
        {
            NativeCylinder native;
            using (Enter()) Check(Native.Functions.FitterSetStartModel(Pointer, Cylinder.Write(model, &native)));
        }

        /// <summary>Sets or takes away the function that hears of every linear solve of a fit, on the thread of the
        /// fit. It returns whether to go on; otherwise the fit throws with <see cref="Status.Cancelled"/>. An exception
        /// that it throws stops the fit and comes out of it.</summary>
        /// <param name="handler">null for none.</param>
        public void SetProgress(Func<Progress, bool> handler)
        {
            using (Enter())
            {
                progress = handler;
                InstallProgress();
            }
        }

        /// <summary>Sets or takes away the function that takes log lines, on the thread of the call. An exception that it
        /// throws comes out of the call when that has ended.</summary>
        /// <param name="maxLevel">Lines up to this level are handed over.</param>
        /// <param name="handler">null for none.</param>
        public unsafe void SetLog(LogLevel maxLevel, Action<LogLevel, string> handler)
        {
            using (Enter())
            {
                Check(Native.Functions.FitterSetLog(Pointer, (int)maxLevel, handler == null ? null : nativeLog,
                    IntPtr.Zero));
                log = handler;
            }
        }

        /// <summary>Makes room, so that pushing that many more points and segments needs no memory.</summary>
        /// <exception cref="CylfuseException">OutOfMemory.</exception>
        public void Reserve(int points, int segments)
        {
            if (points < 0 || segments < 0)
                throw new ArgumentOutOfRangeException(nameof(points),
                    $"Room for {points} points and {segments} segments cannot be made: neither number may be negative.");
            using (Enter()) Check(Native.Functions.FitterReserve(Pointer, (UIntPtr)points, (UIntPtr)segments));
        }

        /// <summary>Forgets data, result and a pending request to cancel; keeps options, camera, start model, callbacks and
        /// memory: the way from one frame to the next.</summary>
        public void Clear()
        {
            using (Enter()) Check(Native.Functions.FitterClear(Pointer));
        }

        /// <summary>Asks the running fit to stop: it throws with <see cref="Status.Cancelled"/>. When no fit is running,
        /// the next one stops at once, unless <see cref="Clear"/> comes before it. From any thread, at any time.</summary>
        public void Cancel()
        {
            IntPtr fitter = handle.Acquire();
            try
            {
                var status = (Status)Native.Functions.FitterCancel(fitter);
                // The fitter may be running: its message is that of another call.
                if (status != Status.Ok) throw CylfuseException.For(status, Library.StatusText(status));
            }
            finally { handle.DangerousRelease(); }
        }

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
                NativeMaskView* regionOrNull = Mask.Write(mask, &region, pins);
                using (Enter()) Check(Native.Functions.FitterPushPoints(Pointer, &view, regionOrNull));
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
                NativeMaskView* regionOrNull = Mask.Write(mask, &region, pins);
                using (Enter()) Check(Native.Functions.FitterPushDepth(Pointer, &view, regionOrNull));
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
                using (Enter()) Check(Native.Functions.FitterPushImage(Pointer, &view));
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
                using (Enter()) Check(Native.Functions.FitterPushEdges(Pointer, &view));
            }
        }

        /// <summary>Adds edge segments, one a row: x1, y1, x2, y2.</summary>
        public void PushEdges(double[,] segments) => PushEdges(Segments.From(segments));

        /// <summary>Says what was pushed since the fitter was created or cleared, and what was left out by
        /// reason.</summary>
        public unsafe Counts Counts()
        {
            var native = new NativeCounts { struct_size = (uint)sizeof(NativeCounts) };
            using (Enter()) Check(Native.Functions.FitterCounts(Pointer, &native));
            return new Counts(native);
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
            var native = new NativeResult { struct_size = (uint)sizeof(NativeResult) };
            using (Enter())
            {
                token = cancellation;
                if (cancellation.CanBeCanceled) InstallProgress();
                int status = Native.Functions.FitterFit(Pointer, &native);
                if (status == (int)Status.Cancelled && callbackFailure == null)
                    cancellation.ThrowIfCancellationRequested();
                Check(status);
            }
            return new FitResult(native);
        }

        /// <summary>Says what a fit would report for a given model, without iterating. The last result stays.</summary>
        /// <exception cref="CylfuseException">InvalidArgument for a bad model, else as <see cref="Fit"/>.</exception>
        public unsafe FitResult Evaluate(Cylinder model)
        {
            if (model == null) throw new ArgumentNullException(nameof(model));
            NativeCylinder cylinder;
            var native = new NativeResult { struct_size = (uint)sizeof(NativeResult) };
            using (Enter()) Check(Native.Functions.FitterEvaluate(Pointer, Cylinder.Write(model, &cylinder), &native));
            return new FitResult(native);
        }

        /// <summary>The result of the last fit that succeeded.</summary>
        /// <exception cref="CylfuseException">There is none (BadState).</exception>
        public unsafe FitResult Result()
        {
            var native = new NativeResult { struct_size = (uint)sizeof(NativeResult) };
            using (Enter()) Check(Native.Functions.FitterGetResult(Pointer, &native));
            return new FitResult(native);
        }

        private void InstallProgress()
        {
            if (progressInstalled) return;
            Check(Native.Functions.FitterSetProgress(Pointer, nativeProgress, IntPtr.Zero));
            progressInstalled = true;
        }

        private unsafe int OnProgress(NativeProgress* native, IntPtr userData)
        {
            bool goesOn = false;
            Guard(() => goesOn = !token.IsCancellationRequested &&
                (progress == null || progress(new Progress(*native))));
            return goesOn ? 0 : 1;
        }

        private void OnLog(int level, IntPtr message, IntPtr userData) =>
            Guard(() => log?.Invoke((LogLevel)level, Library.Text(message)));

        /// <summary>Keeps what a callback throws for the end of the call: nothing may pass through the library. An abortion
        /// of the thread would by itself.</summary>
        private void Guard(Action callback)
        {
            try { callback(); }
            catch (Exception failure)
            {
                if (failure is ThreadAbortException) Thread.ResetAbort();
                callbackFailure = callbackFailure ?? ExceptionDispatchInfo.Capture(failure);
            }
        }

        /// <summary>The native fitter, during a call.</summary>
        private IntPtr Pointer => handle.DangerousGetHandle();

        /// <summary>Takes the fitter for one call: it is not destroyed before the end, and its message is read before
        /// another call replaces it.</summary>
        private Call Enter()
        {
            handle.Acquire();
            if (Interlocked.CompareExchange(ref busy, 1, 0) != 0)
            {
                handle.DangerousRelease();
                throw CylfuseException.For(Status.Busy, Library.StatusText(Status.Busy));
            }
            callbackFailure = null;
            token = CancellationToken.None;
            return new Call(this);
        }

        /// <summary>Throws what a callback threw, or the failure of the call with its message.</summary>
        private void Check(int status)
        {
            if (callbackFailure?.SourceException is ThreadAbortException) Thread.CurrentThread.Abort();
            callbackFailure?.Throw();
            Native.Check(status, Pointer);
        }

        /// <summary>A call that is running; disposing it ends it.</summary>
        private struct Call : IDisposable
        {
            private readonly Fitter fitter;

            internal Call(Fitter fitter)
            {
                this.fitter = fitter;
            }

            public void Dispose()
            {
                Volatile.Write(ref fitter.busy, 0);
                fitter.handle.DangerousRelease();
            }
        }
    }
}
