using System;
using System.Runtime.InteropServices;

namespace Cylfuse
{
    /// <summary>Owns a native fitter. A call in flight holds a reference, so that it is destroyed only after it.</summary>
    internal sealed class FitterHandle : SafeHandle
    {
        private FitterHandle(IntPtr fitter) : base(IntPtr.Zero, true)
        {
            SetHandle(fitter);
        }

        internal static FitterHandle Create()
        {
            NativeFunctions.Check(NativeFunctions.FitterCreate(NativeFunctions.AbiVersionOfBinding, out IntPtr fitter));
            return new FitterHandle(fitter);
        }

        /// <inheritdoc/>
        public override bool IsInvalid => handle == IntPtr.Zero;

        /// <inheritdoc/>
        protected override bool ReleaseHandle() => NativeFunctions.FitterDestroy(handle) == 0;
    }
}
