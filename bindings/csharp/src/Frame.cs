using System;

namespace Cylfuse
{
    /// <summary>What one camera delivered at one time: intrinsics, pose, depth image, image. Any number of fitters use
    /// one frame without a copy, such as one for each cylinder of a scene.</summary>
    /// <remarks>A fitter (<see cref="Fitter.UseFrame"/>) takes what the frame holds at that time: what is set later,
    /// and its disposal, change nothing in fitters. Calls that fill a frame run one at a time; any number of threads
    /// may use it at once.</remarks>
    public sealed class Frame : IDisposable
    {
        private readonly FrameHandle handle = new FrameHandle();
        private volatile Intrinsics intrinsics;

        /// <summary>Destroys the frame. Fitters that use it go on with what they need of it. May be called more than
        /// once.</summary>
        public void Dispose() => handle.Dispose();

        /// <summary>The colour camera; it comes before depth and image, which must have its size. null when it was not
        /// set.</summary>
        /// <exception cref="CylfuseException">No camera works with these numbers (InvalidIntrinsics).</exception>
        public unsafe Intrinsics Intrinsics
        {
            get => intrinsics;
            set
            {
                if (value == null) throw new ArgumentNullException(nameof(value));
                NativeIntrinsics native;
                value.Write(&native);
                using (Call call = Enter())
                {
                    call.Check(Native.Functions.FrameSetIntrinsics(call.Pointer, &native));
                    intrinsics = value;
                }
            }
        }

        /// <summary>Sets the pose, from the camera frame to the reference frame. The identity at first.</summary>
        /// <exception cref="CylfuseException">The matrix is no rotation or a number is not finite
        /// (InvalidArgument).</exception>
        public unsafe void SetPose(RigidMotion pose)
        {
            if (pose == null) throw new ArgumentNullException(nameof(pose));
            using (Call call = Enter())
                call.Check(pose.Give((rotation, translation) =>
                    Native.Functions.FrameSetPose(call.Pointer, rotation, translation)));
        }

        /// <summary>Gives the depth a camera of its own, whose size the depth image must have.</summary>
        /// <inheritdoc cref="Fitter.SetDepthCamera"/>
        public unsafe void SetDepthCamera(Intrinsics intrinsics, RigidMotion toColour = null)
        {
            NativeIntrinsics native;
            NativeIntrinsics* nativeOrNull = Intrinsics.Write(intrinsics, &native);
            using (Call call = Enter())
                call.Check((toColour ?? RigidMotion.Identity).Give((rotation, translation) =>
                    Native.Functions.FrameSetDepthCamera(call.Pointer, nativeOrNull, rotation, translation)));
        }

        /// <summary>Sets the depth image.</summary>
        /// <exception cref="CylfuseException">BadState without intrinsics, SizeMismatch, InvalidArgument for a bad
        /// scale or range; the earlier image stays then.</exception>
        public unsafe void SetDepth(DepthImage depth)
        {
            if (depth == null) throw new ArgumentNullException(nameof(depth));
            using (var pins = new Pins())
            {
                NativeDepthView view;
                depth.Write(&view, pins);
                using (Call call = Enter()) call.Check(Native.Functions.FrameSetDepth(call.Pointer, &view));
            }
        }

        /// <summary>Sets the image, grey or in colour.</summary>
        /// <exception cref="CylfuseException">BadState without intrinsics, SizeMismatch, InvalidArgument for a bad
        /// gamma or a value that is not finite or that the gamma forbids; the earlier image stays then.</exception>
        public unsafe void SetImage(Image image)
        {
            if (image == null) throw new ArgumentNullException(nameof(image));
            using (var pins = new Pins())
            {
                NativeImageView view;
                image.Write(&view, pins);
                using (Call call = Enter()) call.Check(Native.Functions.FrameSetImage(call.Pointer, &view));
            }
        }

        internal Call Enter() => new Call(handle);
    }
}
