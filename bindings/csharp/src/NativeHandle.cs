using System;
using System.Runtime.InteropServices;

namespace Cylfuse
{
    /// <summary>Owns a native fitter, frame or detector, which is destroyed when the handle is disposed and no call holds
    /// it.</summary>
    internal abstract class NativeHandle : SafeHandle
    {
        private readonly string owner;

        /// <param name="owner">The name of the class that owns the handle, for messages.</param>
        protected NativeHandle(string owner) : base(IntPtr.Zero, true)
        {
            this.owner = owner;
        }

        /// <inheritdoc/>
        public override bool IsInvalid => handle == IntPtr.Zero;

        /// <summary>The native object for one call; <see cref="SafeHandle.DangerousRelease"/> comes after it.</summary>
        internal IntPtr Acquire()
        {
            bool held = false;
            try { DangerousAddRef(ref held); }
            // That of the handle names the handle.
            catch (ObjectDisposedException) { throw new ObjectDisposedException(owner); }
            return handle;
        }

        /// <summary>Why the last call of this thread on the native object failed.</summary>
        internal abstract IntPtr LastError(IntPtr pointer);
    }

    /// <summary>Owns a native fitter.</summary>
    internal sealed class FitterHandle : NativeHandle
    {
        internal FitterHandle() : base(nameof(Fitter))
        {
            Native.Check(Native.Functions.FitterCreate(NativeFunctions.AbiVersionOfBinding, out handle));
        }

        /// <summary>Takes the clone that a fitter makes.</summary>
        internal FitterHandle(Call call) : base(nameof(Fitter))
        {
            call.Check(Native.Functions.FitterClone(call.Pointer, out handle));
        }

        /// <summary>Takes the fitter that a detector makes.</summary>
        internal FitterHandle(Call call, int index) : base(nameof(Fitter))
        {
            call.Check(Native.Functions.DetectorMakeFitter(call.Pointer, (UIntPtr)index, out handle));
        }

        /// <inheritdoc/>
        internal override IntPtr LastError(IntPtr pointer) => Native.Functions.FitterLastError(pointer);

        /// <inheritdoc/>
        protected override bool ReleaseHandle() => Native.Functions.FitterDestroy(handle) == 0;
    }

    /// <summary>Owns a native detector.</summary>
    internal sealed class DetectorHandle : NativeHandle
    {
        internal DetectorHandle() : base(nameof(Detector))
        {
            Native.Check(Native.Functions.DetectorCreate(NativeFunctions.AbiVersionOfBinding, out handle));
        }

        /// <inheritdoc/>
        internal override IntPtr LastError(IntPtr pointer) => Native.Functions.DetectorLastError(pointer);

        /// <inheritdoc/>
        protected override bool ReleaseHandle() => Native.Functions.DetectorDestroy(handle) == 0;
    }

    /// <summary>Owns a native frame.</summary>
    internal sealed class FrameHandle : NativeHandle
    {
        internal FrameHandle() : base(nameof(Frame))
        {
            Native.Check(Native.Functions.FrameCreate(NativeFunctions.AbiVersionOfBinding, out handle));
        }

        /// <inheritdoc/>
        internal override IntPtr LastError(IntPtr pointer) => Native.Functions.FrameLastError(pointer);

        /// <inheritdoc/>
        protected override bool ReleaseHandle() => Native.Functions.FrameDestroy(handle) == 0;
    }
}
