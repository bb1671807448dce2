using System;
using System.Runtime.InteropServices;

namespace Cylfuse
{
    /// <summary>Owns a native fitter, which is destroyed when the handle is disposed and no call holds it.</summary>
    internal sealed class FitterHandle : SafeHandle
    {
        internal FitterHandle() : base(IntPtr.Zero, true)
        {
            Native.Check(Native.Functions.FitterCreate(NativeFunctions.AbiVersionOfBinding, out handle));
        }

        /// <inheritdoc/>
        public override bool IsInvalid => handle == IntPtr.Zero;

        /// <summary>The fitter for one call; <see cref="SafeHandle.DangerousRelease"/> comes after it.</summary>
        internal IntPtr Acquire()
        {
            bool held = false;
            try { DangerousAddRef(ref held); }
            // That of the handle names the handle.
            catch (ObjectDisposedException) { throw new ObjectDisposedException(nameof(Fitter)); }
            return handle;
        }

        /// <inheritdoc/>
        protected override bool ReleaseHandle() => Native.Functions.FitterDestroy(handle) == 0;
    }
}
