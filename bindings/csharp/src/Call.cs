using System;
using System.Runtime.ExceptionServices;
using System.Threading;

namespace Cylfuse
{
    /// <summary>A call that is running on a fitter, a frame or a detector: until it is disposed the native object is not destroyed.
    /// Many may run on one object at once; the library says which of them exclude each other.</summary>
    internal sealed class Call : IDisposable
    {
        // The library calls back on the thread of the call, and keeps its messages by thread.
        [ThreadStatic] private static Call current;

        private readonly NativeHandle handle;
        private readonly Call outer;
        private ExceptionDispatchInfo callbackFailure;

        internal Call(NativeHandle handle)
        {
            this.handle = handle;
            Pointer = handle.Acquire();
            outer = current;
            current = this;
        }

        /// <summary>The innermost call of this thread, which is the one that a callback belongs to.</summary>
        internal static Call Current => current;

        /// <summary>The native fitter, frame or detector.</summary>
        internal IntPtr Pointer { get; }

        /// <summary>Stops a fit or a search: the progress callbacks ask it.</summary>
        internal CancellationToken Token { get; private set; }

        /// <summary>Lets a token stop the call until what is returned is disposed. A cancellation that comes before the
        /// library is in the call stops nothing there; the first progress callback sees it. Disposal waits for a
        /// cancellation that is under way, so that it meets no later call.</summary>
        internal CancellationTokenRegistration StopBy(CancellationToken token, NativeFunctions.HandleFunction cancel)
        {
            Token = token;
            // Not by the owner, which may have been disposed during the call: the call still holds the native object.
            return token.Register(() => cancel(Pointer));
        }

        /// <summary>Whether a callback has thrown.</summary>
        internal bool CallbackFailed => callbackFailure != null;

        /// <summary>Throws what a callback threw, or the failure of the call with its message.</summary>
        internal void Check(int status)
        {
            if (callbackFailure?.SourceException is ThreadAbortException) Thread.CurrentThread.Abort();
            callbackFailure?.Throw();
            if (status != 0) throw Failure(status);
        }

        /// <summary>The failure of the call with its message.</summary>
        internal CylfuseException Failure(int status) => Native.Failure(status, handle.LastError(Pointer));

        /// <summary>Keeps what a callback throws for the end of the call: nothing may pass through the library. An
        /// abortion of the thread would by itself.</summary>
        internal void Guard(Action callback)
        {
            try { callback(); }
            catch (Exception failure)
            {
                if (failure is ThreadAbortException) Thread.ResetAbort();
                callbackFailure = callbackFailure ?? ExceptionDispatchInfo.Capture(failure);
            }
        }

        public void Dispose()
        {
            current = outer;
            handle.DangerousRelease();
        }
    }
}
