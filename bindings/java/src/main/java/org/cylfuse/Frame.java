package org.cylfuse;

import java.lang.ref.Cleaner;
import java.util.Objects;

/**
 * What one camera delivered at one time: intrinsics, pose, depth image, image. Any number of fitters use one frame
 * without a copy, such as one for each cylinder of a scene.
 *
 * <p>A fitter ({@link Fitter#useFrame}) takes what the frame holds at that time: what is set later, and closing the
 * frame, change nothing in fitters. Calls that fill a frame run one at a time; any number of threads may use it at
 * once. After {@link #close()} every other method throws an {@link IllegalStateException}.
 */
public final class Frame implements AutoCloseable {
    private static final Cleaner CLEANER = Cleaner.create();

    final NativeHandle handle = new NativeHandle(
            "frame",
            NativeFunctions::cylfuse_frame_create,
            NativeFunctions::cylfuse_frame_destroy,
            NativeFunctions::cylfuse_frame_last_error);
    private final Cleaner.Cleanable cleanable = CLEANER.register(this, handle::close);
    private volatile Intrinsics camera;

    /**
     * A frame at the identity, without a camera and data.
     *
     * @throws UnsatisfiedLinkError when the native library was not found or is not that of this package
     */
    public Frame() {}

    /** Destroys the frame; fitters that use it go on. May be called more than once. */
    @Override
    public void close() {
        cleanable.clean();
    }

    Intrinsics camera() {
        return camera;
    }

    /**
     * Sets the colour camera; it comes before depth and image, which must have its size.
     *
     * @param camera the camera
     * @throws CylfuseException INVALID_INTRINSICS when no camera works with these numbers; the old one stays
     */
    public void setIntrinsics(Intrinsics camera) {
        NativeStructs.Intrinsics n = Objects.requireNonNull(camera, "camera").toNative();
        handle.run(frame -> NativeFunctions.cylfuse_frame_set_intrinsics(frame, n));
        this.camera = camera;
    }

    /**
     * Sets the pose, from the camera frame to the reference frame. The identity at first.
     *
     * @param pose the pose
     * @throws CylfuseException INVALID_ARGUMENT when the matrix is no rotation or a number is not finite
     */
    public void setPose(RigidMotion pose) {
        Objects.requireNonNull(pose, "pose");
        handle.run(frame -> NativeFunctions.cylfuse_frame_set_pose(frame, pose.numbers(), pose.translation().toArray()));
    }

    /**
     * Gives the depth a camera of its own, whose size the depth image must have.
     *
     * @param camera the depth camera; null takes it away
     * @param toColour from the frame of the depth camera to that of the colour camera
     * @throws CylfuseException INVALID_INTRINSICS, INVALID_ARGUMENT; the old depth camera stays
     */
    public void setDepthCamera(Intrinsics camera, RigidMotion toColour) {
        NativeStructs.Intrinsics n = Intrinsics.toNative(camera);
        Objects.requireNonNull(toColour, "toColour");
        handle.run(frame -> NativeFunctions.cylfuse_frame_set_depth_camera(
                frame, n, toColour.numbers(), toColour.translation().toArray()));
    }

    /**
     * Sets the depth image.
     *
     * @param depth the image
     * @throws CylfuseException BAD_STATE without intrinsics, SIZE_MISMATCH, INVALID_ARGUMENT for a bad scale or range;
     *     the earlier image stays then
     */
    public void setDepth(DepthImage depth) {
        try (NativeCopies copies = new NativeCopies()) {
            NativeStructs.DepthView view = Objects.requireNonNull(depth, "depth").toNative(copies);
            handle.run(frame -> NativeFunctions.cylfuse_frame_set_depth(frame, view));
        }
    }

    /**
     * Sets the image, grey or in colour.
     *
     * @param image the image
     * @throws CylfuseException BAD_STATE without intrinsics, SIZE_MISMATCH, INVALID_ARGUMENT for a bad gamma or a value
     *     that is not finite or that the gamma forbids; the earlier image stays then
     */
    public void setImage(Image image) {
        try (NativeCopies copies = new NativeCopies()) {
            NativeStructs.ImageView view = Objects.requireNonNull(image, "image").toNative(copies);
            handle.run(frame -> NativeFunctions.cylfuse_frame_set_image(frame, view));
        }
    }
}
