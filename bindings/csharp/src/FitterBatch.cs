using System;
using System.Collections.Generic;
using System.Runtime.ExceptionServices;

namespace Cylfuse
{
    // Many fits at once.
    public sealed partial class Fitter
    {
        /// <summary>Fits many fitters, several at once, each as <see cref="Fit"/> does. The results stay in the fitters,
        /// for <see cref="Result"/> and all else that can be asked of a fit. What the fitters call back is not
        /// called.</summary>
        /// <param name="fitters">The fitters, each once.</param>
        /// <param name="threads">How many fits run at the same time, 0 for as many as the machine has processors. The
        /// results have the same bits for any number.</param>
        /// <param name="ended">Is called after each fit, on this thread, with the index of its fitter, and Ok or why it
        /// failed. It returns whether to go on; null for none. What it throws stops the rest and comes out of this
        /// method.</param>
        /// <returns>Why each fit failed, in the order of the fitters; null for one that succeeded. One that is in
        /// another call has Busy. Where <paramref name="ended"/> stopped the rest, those that had not ended have
        /// Cancelled.</returns>
        /// <exception cref="CylfuseException">InvalidArgument for a fitter that is there twice.</exception>
        public static unsafe CylfuseException[] FitAll(IReadOnlyList<Fitter> fitters, int threads = 0,
            Func<int, Status, bool> ended = null)
        {
            if (fitters == null) throw new ArgumentNullException(nameof(fitters));
            if (threads < 0) throw new ArgumentOutOfRangeException(nameof(threads), threads, "must be 0 or greater");
            var handles = new IntPtr[fitters.Count];
            var statuses = new int[fitters.Count];
            ExceptionDispatchInfo thrown = null;
            int held = 0;
            try
            {
                for (; held < handles.Length; held++)
                {
                    Fitter fitter = fitters[held]
                        ?? throw new ArgumentNullException(nameof(fitters), $"fitters[{held}] is null; it must be a fitter");
                    handles[held] = fitter.handle.Acquire();
                }
                NativeFunctions.FitEndedCallback callback = (index, status, _) =>
                {
                    try { return ended((int)index, (Status)status) ? 0 : 1; }
                    catch (Exception failure)
                    {
                        thrown = ExceptionDispatchInfo.Capture(failure);
                        return 1;
                    }
                };
                int outcome;
                fixed (IntPtr* first = handles)
                fixed (int* status = statuses)
                {
                    outcome = Native.Functions.FitAll(first, (UIntPtr)handles.Length, (uint)threads,
                        ended == null ? null : callback, IntPtr.Zero, status);
                }
                GC.KeepAlive(callback);
                thrown?.Throw();
                if ((Status)outcome != Status.Cancelled) Native.Check(outcome);
                var failures = new CylfuseException[handles.Length];
                for (int k = 0; k < failures.Length; k++)
                {
                    if (statuses[k] != 0)
                        failures[k] = Native.Failure(statuses[k], Native.Functions.FitterLastError(handles[k]));
                }
                return failures;
            }
            finally
            {
                while (held > 0) fitters[--held].handle.DangerousRelease();
            }
        }
    }
}
