using System;
using System.Collections.Generic;

namespace Cylfuse
{
    // The views and their cameras.
    public sealed partial class Fitter
    {
        // By view, as they were given; null where none was set.
        private readonly List<Intrinsics> cameras;
        private int selected;

        /// <summary>Selects a view, so that what is set and pushed, and what follows a fit in one view, concerns that
        /// view. There is one at first, number 0, and it is selected: with one view this is not needed.</summary>
        /// <remarks>All views see the same cylinder. A fit uses the data of all of them; models, results and extents
        /// are in the reference frame, in which the poses of the views are given.</remarks>
        /// <param name="index">The view, from 0; <see cref="ViewCount"/> adds one, at the identity and without a
        /// camera.</param>
        /// <exception cref="CylfuseException">A larger index (InvalidArgument).</exception>
        public void SelectView(int index)
        {
            if (index < 0) throw new ArgumentOutOfRangeException(nameof(index), $"There is no view {index}: they count from 0.");
            using (Call call = Enter())
            {
                call.Check(Native.Functions.FitterSelectView(call.Pointer, (UIntPtr)index));
                lock (cameras)
                {
                    if (index == cameras.Count) cameras.Add(null);
                    selected = index;
                }
            }
        }

        /// <summary>Makes another fitter with all that this one holds, settings, data and result, but no callbacks. Images are
        /// shared, points are copied: clone one that is set up for each thread before data are pushed.</summary>
        /// <exception cref="CylfuseException">OutOfMemory.</exception>
        public Fitter Clone()
        {
            Fitter clone;
            using (Call call = Enter()) clone = new Fitter(new FitterHandle(call), null);
            clone.cameras.Clear();
            lock (cameras)
            {
                clone.cameras.AddRange(cameras);
                clone.selected = selected;
            }
            return clone;
        }

        /// <summary>How many views there are, at least 1.</summary>
        public int ViewCount
        {
            get
            {
                using (Call call = Enter())
                {
                    call.Check(Native.Functions.FitterViewCount(call.Pointer, out UIntPtr count));
                    return (int)count;
                }
            }
        }

        /// <summary>The colour camera of the selected view, which depth images, images and edges need; null when there
        /// is none. Points that were pushed before stay as they are.</summary>
        /// <exception cref="CylfuseException">No camera works with these numbers (InvalidIntrinsics), or an image of
        /// another size is there (SizeMismatch; <see cref="ClearInput"/> takes it away); the old one stays.</exception>
        public unsafe Intrinsics Intrinsics
        {
            get
            {
                lock (cameras) return cameras[selected];
            }
            set
            {
                if (value == null) throw new ArgumentNullException(nameof(value));
                NativeIntrinsics native;
                value.Write(&native);
                using (Call call = Enter())
                {
                    call.Check(Native.Functions.FitterSetIntrinsics(call.Pointer, &native));
                    lock (cameras) cameras[selected] = value;
                }
            }
        }

        /// <summary>Sets the pose of the selected view, which leads from its camera frame to the reference frame. The
        /// identity at first.</summary>
        /// <exception cref="CylfuseException">The matrix is no rotation or a number is not finite (InvalidArgument);
        /// the old pose stays.</exception>
        public unsafe void SetPose(RigidMotion pose)
        {
            if (pose == null) throw new ArgumentNullException(nameof(pose));
            using (Call call = Enter())
                call.Check(pose.Give((rotation, translation) =>
                    Native.Functions.FitterSetPose(call.Pointer, rotation, translation)));
        }

        /// <summary>Gives the depth of the selected view a camera of its own, for depth that is not registered to the
        /// colour image: depth images that are pushed later are then in its pixels; mask, image and edges stay in those
        /// of the colour camera.</summary>
        /// <param name="intrinsics">Those of the depth camera; null takes it away.</param>
        /// <param name="toColour">From the frame of the depth camera to that of the colour camera; null = the
        /// identity.</param>
        /// <exception cref="CylfuseException">InvalidIntrinsics, InvalidArgument, SizeMismatch with a depth image that
        /// is there; the old depth camera stays.</exception>
        public unsafe void SetDepthCamera(Intrinsics intrinsics, RigidMotion toColour = null)
        {
            NativeIntrinsics native;
            NativeIntrinsics* nativeOrNull = Intrinsics.Write(intrinsics, &native);
            using (Call call = Enter())
                call.Check((toColour ?? RigidMotion.Identity).Give((rotation, translation) =>
                    Native.Functions.FitterSetDepthCamera(call.Pointer, nativeOrNull, rotation, translation)));
        }

        /// <summary>Lets the selected view take cameras, pose and images from a frame, in place of its own, and adds
        /// the points of the depth image inside a mask. Points and edge segments that were pushed stay.</summary>
        /// <param name="frame">The frame, with intrinsics; it may be changed or disposed afterwards, of which the
        /// fitter sees nothing. The images are shared and not copied.</param>
        /// <param name="mask">In the pixels of the colour image, copied; null = all pixels.</param>
        /// <exception cref="CylfuseException">BadState without intrinsics, SizeMismatch, EmptyMask, NoDepth when no
        /// pixel in the mask is usable, Busy when the frame is being filled; the view stays as it was then.</exception>
        public unsafe void UseFrame(Frame frame, Mask mask = null)
        {
            if (frame == null) throw new ArgumentNullException(nameof(frame));
            using (var pins = new Pins())
            {
                NativeMaskView region;
                NativeMaskView* regionOrNull = Mask.Write(mask, &region, pins);
                // The call on the fitter is the inner one: it is the one that fails.
                using (Call used = frame.Enter())
                using (Call call = Enter())
                {
                    call.Check(Native.Functions.FitterUseFrame(call.Pointer, used.Pointer, regionOrNull));
                    lock (cameras) cameras[selected] = frame.Intrinsics;
                }
            }
        }
    }
}
