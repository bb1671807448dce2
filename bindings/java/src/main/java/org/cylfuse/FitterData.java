package org.cylfuse;

import com.sun.jna.ptr.LongByReference;
import java.util.Objects;

/** What a {@link Fitter} is given: its views and their data. */
abstract class FitterData {
    final FitterCalls calls;

    FitterData(FitterCalls calls) {
        this.calls = calls;
    }

    /**
     * Selects a view, so that what is set and pushed, and what follows a fit in one view, concerns that view. There is
     * one at first, number 0, and it is selected: with one view this is not needed.
     *
     * <p>All views see the same cylinder. A fit uses the data of all of them; models, results and extents are in the
     * reference frame, in which the poses of the views are given.
     *
     * @param index the view, from 0; {@link #viewCount()} adds one, at the identity and without a camera
     * @throws IllegalArgumentException when the number is negative
     * @throws CylfuseException INVALID_ARGUMENT for a larger index
     */
    public void selectView(int index) {
        if (index < 0) {
            throw new IllegalArgumentException("There is no view " + index + ": they count from 0.");
        }
        calls.run(fitter -> NativeFunctions.cylfuse_fitter_select_view(fitter, index));
        calls.selectView(index);
    }

    /**
     * Says how many views there are.
     *
     * @return the number, at least 1
     */
    public int viewCount() {
        LongByReference count = new LongByReference();
        calls.run(fitter -> NativeFunctions.cylfuse_fitter_view_count(fitter, count));
        return Math.toIntExact(count.getValue());
    }

    /**
     * Sets the colour camera of the selected view, which depth images, images and edges need. Points that were pushed
     * before stay as they are.
     *
     * @param camera the camera
     * @throws CylfuseException INVALID_INTRINSICS when no camera works with these numbers, SIZE_MISMATCH when an image
     *     of another size is there ({@link #clearInput} takes it away); the old one stays
     */
    public void setIntrinsics(Intrinsics camera) {
        NativeStructs.Intrinsics n = Objects.requireNonNull(camera, "camera").toNative();
        calls.run(fitter -> NativeFunctions.cylfuse_fitter_set_intrinsics(fitter, n));
        calls.setCamera(camera);
    }

    /**
     * Sets the pose of the selected view, which leads from its camera frame to the reference frame. The identity at
     * first.
     *
     * @param pose the pose
     * @throws CylfuseException INVALID_ARGUMENT when the matrix is no rotation or a number is not finite; the old pose
     *     stays
     */
    public void setPose(RigidMotion pose) {
        Objects.requireNonNull(pose, "pose");
        calls.run(fitter ->
                NativeFunctions.cylfuse_fitter_set_pose(fitter, pose.numbers(), pose.translation().toArray()));
    }

    /**
     * Reads the colour camera of the selected view, which was set or came with a frame.
     *
     * @return the camera, with all 8 coefficients
     * @throws CylfuseException BAD_STATE where the view has none
     */
    public Intrinsics intrinsics() {
        NativeStructs.Intrinsics n =
                NativeFunctions.initialised(new NativeStructs.Intrinsics(), NativeFunctions::cylfuse_intrinsics_init);
        calls.run(fitter -> NativeFunctions.cylfuse_fitter_get_intrinsics(fitter, n));
        return Intrinsics.of(n);
    }

    /**
     * Gives the depth of the selected view a camera of its own, for depth that is not registered to the colour image:
     * depth images that are pushed later are then in its pixels; mask, image and edges stay in those of the colour
     * camera.
     *
     * @param camera the depth camera; null takes it away
     * @param toColour from the frame of the depth camera to that of the colour camera
     * @throws CylfuseException INVALID_INTRINSICS, INVALID_ARGUMENT, SIZE_MISMATCH with a depth image that is there;
     *     the old depth camera stays
     */
    public void setDepthCamera(Intrinsics camera, RigidMotion toColour) {
        NativeStructs.Intrinsics n = Intrinsics.toNative(camera);
        Objects.requireNonNull(toColour, "toColour");
        calls.run(fitter -> NativeFunctions.cylfuse_fitter_set_depth_camera(
                fitter, n, toColour.numbers(), toColour.translation().toArray()));
    }

    /**
     * Lets the selected view take cameras, pose and images from a frame, in place of its own, and adds the points of
     * the depth image inside a mask. Points and edge segments that were pushed stay.
     *
     * @param frame the frame, with intrinsics; it may be changed or closed afterwards, of which the fitter sees
     *     nothing. The images are shared and not copied.
     * @param mask in the pixels of the colour image, copied; null = all pixels
     * @throws CylfuseException BAD_STATE without intrinsics, SIZE_MISMATCH, EMPTY_MASK, NO_DEPTH when no pixel in the
     *     mask is usable, BUSY when the frame is being filled; the view stays as it was then
     */
    public void useFrame(Frame frame, Mask mask) {
        Objects.requireNonNull(frame, "frame");
        try (NativeCopies copies = new NativeCopies()) {
            NativeStructs.MaskView region = Mask.toNative(mask, copies);
            // The call on the fitter is the inner one: it is the one that fails.
            frame.handle.run(used -> {
                calls.run(fitter -> NativeFunctions.cylfuse_fitter_use_frame(fitter, used, region));
                calls.setCamera(frame.camera());
                return Status.OK.value();
            });
        }
    }

    /**
     * Makes room for the coordinates of that many more points and for that many more segments in the selected view.
     *
     * @param points how many points
     * @param segments how many edge segments
     * @throws IllegalArgumentException when a number is negative
     * @throws CylfuseException OUT_OF_MEMORY
     */
    public void reserve(long points, long segments) {
        if (points < 0 || segments < 0) {
            throw new IllegalArgumentException("Room for " + points + " points and " + segments
                    + " segments cannot be made: neither number may be negative.");
        }
        calls.run(fitter -> NativeFunctions.cylfuse_fitter_reserve(fitter, points, segments));
    }

    /**
     * Forgets the data, all views but the first, its pose and the result; keeps options, the cameras of the first view,
     * start model, what the start {@link StartKind#LAST} goes on from, listeners and memory: the way from one frame to the
     * next.
     */
    public void clear() {
        calls.run(NativeFunctions::cylfuse_fitter_clear);
        calls.keepFirstView();
    }

    /**
     * Forgets some of the data of the selected view, and keeps the rest and the last result.
     *
     * @param inputs which data
     */
    public void clearInput(Input... inputs) {
        int bits = 0;
        for (Input input : inputs) {
            bits |= input.value();
        }
        int all = bits;
        calls.run(fitter -> NativeFunctions.cylfuse_fitter_clear_input(fitter, all));
    }

    /**
     * Adds points to the selected view.
     *
     * @param points the points
     * @throws CylfuseException as {@link #pushPoints(PointCloud, Mask)}
     */
    public void pushPoints(PointCloud points) {
        pushPoints(points, null);
    }

    /**
     * Adds points to the selected view, in its camera frame when edges, the near-wall rule, completion or extent
     * matter, else in any frame. Points with a coordinate that is not finite, a weight of 0 or outside the mask are
     * left out and counted.
     *
     * @param points the points
     * @param mask selects pixels of an organised cloud, of the same size as it; null = all
     * @throws CylfuseException SIZE_MISMATCH, EMPTY_MASK, INVALID_ARGUMENT for a negative weight; nothing is added then
     */
    public void pushPoints(PointCloud points, Mask mask) {
        try (NativeCopies copies = new NativeCopies()) {
            NativeStructs.PointsView view = Objects.requireNonNull(points, "points").toNative(copies);
            NativeStructs.MaskView region = Mask.toNative(mask, copies);
            calls.run(fitter -> NativeFunctions.cylfuse_fitter_push_points(fitter, view, region));
        }
    }

    /**
     * Adds the points of a depth image of the selected view. Pixels without a depth, out of range, outside the mask or
     * hidden from the colour camera are left out and counted. The image and the mask are kept, in place of earlier
     * ones, for completion and extent.
     *
     * @param depth the image
     * @param mask in the pixels of the colour image; null = all pixels
     * @throws CylfuseException BAD_STATE without intrinsics, SIZE_MISMATCH, EMPTY_MASK, NO_DEPTH when no pixel is
     *     usable, INVALID_ARGUMENT for a bad scale or range; nothing is added then
     */
    public void pushDepth(DepthImage depth, Mask mask) {
        try (NativeCopies copies = new NativeCopies()) {
            NativeStructs.DepthView view = Objects.requireNonNull(depth, "depth").toNative(copies);
            NativeStructs.MaskView region = Mask.toNative(mask, copies);
            calls.run(fitter -> NativeFunctions.cylfuse_fitter_push_depth(fitter, view, region));
        }
    }

    /**
     * Takes the image of the selected view, grey or in colour, in place of an earlier one: limbs, arcs of the ends and
     * ends are located in it, as options and objective say.
     *
     * @param image the image
     * @throws CylfuseException BAD_STATE without intrinsics, SIZE_MISMATCH, INVALID_ARGUMENT for a bad gamma or a value
     *     that is not finite or that the gamma forbids; the earlier image stays then
     */
    public void pushImage(Image image) {
        try (NativeCopies copies = new NativeCopies()) {
            NativeStructs.ImageView view = Objects.requireNonNull(image, "image").toNative(copies);
            calls.run(fitter -> NativeFunctions.cylfuse_fitter_push_image(fitter, view));
        }
    }

    /**
     * Adds edge segments to the selected view, any number of either limb. A fit with segments needs intrinsics.
     *
     * @param segments the segments
     * @throws CylfuseException INVALID_ARGUMENT when a coordinate is not finite or a weight is negative; nothing is
     *     added then
     */
    public void pushEdges(Segments segments) {
        try (NativeCopies copies = new NativeCopies()) {
            NativeStructs.SegmentsView view = Objects.requireNonNull(segments, "segments").toNative(copies);
            calls.run(fitter -> NativeFunctions.cylfuse_fitter_push_edges(fitter, view));
        }
    }

    /**
     * Says what was pushed into the selected view since the fitter was created or cleared, and what was left out by
     * reason.
     *
     * @return the counts
     */
    public Counts counts() {
        NativeStructs.Counts n =
                NativeFunctions.initialised(new NativeStructs.Counts(), NativeFunctions::cylfuse_counts_init);
        calls.run(fitter -> NativeFunctions.cylfuse_fitter_counts(fitter, n));
        return Counts.of(n);
    }
}
