package org.cylfuse;

import com.sun.jna.Memory;
import com.sun.jna.Pointer;
import com.sun.jna.ptr.LongByReference;
import java.lang.ref.Cleaner;
import java.util.Objects;

/**
 * Estimates one cylinder: holds options, camera, data and the last result.
 *
 * <p>Create it, push points (or set the intrinsics, push a depth image with a mask and edges), fit. For the next frame:
 * clear, push, fit. The library copies what is pushed.
 *
 * <p>A fitter may move between threads, but runs one call at a time: a second one, from another thread or from a listener,
 * throws a {@link CylfuseException} with {@link Status#BUSY}. Only {@link #cancel()} and {@link #close()} may come while
 * another call is running; the fitter is then destroyed after that call. Different fitters run in parallel. After
 * {@link #close()} every other method throws an {@link IllegalStateException}.
 *
 * <p>Where a method takes a model, null stands for that of the last fit; where it takes a mask, null stands for the mask of
 * the last depth image, and another one must have the size of the intrinsics.
 */
public final class Fitter implements AutoCloseable {
    private static final Cleaner CLEANER = Cleaner.create();

    private final FitterCalls calls = new FitterCalls();
    // Knows the handle alone: what knows the fitter or its listeners would keep it from being collected.
    private final Cleaner.Cleanable cleanable = CLEANER.register(this, calls.handle::close);

    /**
     * A fitter with default options and no data.
     *
     * @throws UnsatisfiedLinkError when the native library was not found or is not that of this package
     */
    public Fitter() {}

    /** Destroys the fitter and frees what it holds. May be called more than once. */
    @Override
    public void close() {
        cleanable.clean();
    }

    /**
     * Replaces the options.
     *
     * @param options the options, copied
     * @throws CylfuseException INVALID_ARGUMENT when a value is out of range; the old options stay
     */
    public void setOptions(FitOptions options) {
        NativeStructs.Options n = Objects.requireNonNull(options, "options").toNative();
        calls.run(fitter -> NativeFunctions.cylfuse_fitter_set_options(fitter, n));
    }

    /**
     * Reads the options.
     *
     * @return a copy
     */
    public FitOptions options() {
        NativeStructs.Options n = new NativeStructs.Options();
        n.struct_size = n.size();
        calls.run(fitter -> NativeFunctions.cylfuse_fitter_get_options(fitter, n));
        return new FitOptions(n);
    }

    /**
     * Sets the camera, which depth images and edges need. Points that were pushed before stay as they are.
     *
     * @param camera the camera
     * @throws CylfuseException INVALID_INTRINSICS when no camera works with these numbers; the old one stays
     */
    public void setIntrinsics(Intrinsics camera) {
        calls.setCamera(camera);
    }

    /**
     * Sets a start model: a candidate for the start AUTO, the start of MODEL.
     *
     * @param model the model; null takes it away
     * @throws CylfuseException INVALID_ARGUMENT when the model is no cylinder; the old one stays
     */
    public void setStartModel(Cylinder model) {
        NativeStructs.Cylinder n = Cylinder.toNative(model);
        calls.run(fitter -> NativeFunctions.cylfuse_fitter_set_start_model(fitter, n));
    }

    /**
     * Sets or takes away the listener that hears of every linear solve. What it throws stops the fit and comes out of it.
     *
     * @param listener null for none
     */
    public void setProgressListener(ProgressListener listener) {
        calls.setProgressListener(listener);
    }

    /**
     * Sets or takes away the listener that takes log lines. What it throws comes out of the call when that has ended.
     *
     * @param maxLevel lines up to this level are handed over
     * @param listener null for none
     */
    public void setLogListener(LogLevel maxLevel, LogListener listener) {
        calls.setLogListener(maxLevel, listener);
    }

    /**
     * Makes room, so that pushing that many more points and segments needs no memory.
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
     * Forgets data, result and a pending request to cancel; keeps options, camera, start model, listeners and memory: the
     * way from one frame to the next.
     */
    public void clear() {
        calls.run(NativeFunctions::cylfuse_fitter_clear);
    }

    /**
     * Asks the running fit to stop: it throws with {@link Status#CANCELLED}. When no fit is running, the next one stops at
     * once, unless {@link #clear()} comes before it. From any thread, at any time.
     */
    public void cancel() {
        Pointer fitter = calls.handle.acquire();
        try {
            int status = NativeFunctions.cylfuse_fitter_cancel(fitter);
            // The fitter may be running: its message is that of another call.
            if (status != 0) {
                throw CylfuseException.of(Status.of(status), NativeFunctions.cylfuse_status_string(status));
            }
        } finally {
            calls.handle.release();
        }
    }

    /**
     * Adds points.
     *
     * @param points the points
     * @throws CylfuseException as {@link #pushPoints(PointCloud, Mask)}
     */
    public void pushPoints(PointCloud points) {
        pushPoints(points, null);
    }

    /**
     * Adds points, in the camera frame when edges, the near-wall rule, completion or extent matter, else in any frame.
     * Points with a coordinate that is not finite, a weight of 0 or outside the mask are left out and counted.
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
     * Adds the points of a depth image of the camera. Pixels without a depth, out of range or outside the mask are left out
     * and counted. The image and the mask are kept, in place of earlier ones, for completion and extent.
     *
     * @param depth the image
     * @param mask of the same size as the image; null = all pixels
     * @throws CylfuseException BAD_STATE without intrinsics, SIZE_MISMATCH, EMPTY_MASK, NO_DEPTH when no pixel is usable,
     *     INVALID_ARGUMENT for a bad scale or range; nothing is added then
     */
    public void pushDepth(DepthImage depth, Mask mask) {
        try (NativeCopies copies = new NativeCopies()) {
            NativeStructs.DepthView view = Objects.requireNonNull(depth, "depth").toNative(copies);
            NativeStructs.MaskView region = Mask.toNative(mask, copies);
            calls.run(fitter -> NativeFunctions.cylfuse_fitter_push_depth(fitter, view, region));
        }
    }

    /**
     * Takes the grey image of the camera, in place of an earlier one: limbs, arcs of the ends and ends are located in it,
     * as options and objective say.
     *
     * @param image the image
     * @throws CylfuseException BAD_STATE without intrinsics, SIZE_MISMATCH, INVALID_ARGUMENT for a value that is not
     *     finite; the earlier image stays then
     */
    public void pushImage(GreyImage image) {
        try (NativeCopies copies = new NativeCopies()) {
            NativeStructs.ImageView view = Objects.requireNonNull(image, "image").toNative(copies);
            calls.run(fitter -> NativeFunctions.cylfuse_fitter_push_image(fitter, view));
        }
    }

    /**
     * Adds edge segments, any number of either limb. A fit with segments needs intrinsics.
     *
     * @param segments the segments
     * @throws CylfuseException INVALID_ARGUMENT when a coordinate is not finite or a weight is negative; nothing is added
     *     then
     */
    public void pushEdges(Segments segments) {
        try (NativeCopies copies = new NativeCopies()) {
            NativeStructs.SegmentsView view = Objects.requireNonNull(segments, "segments").toNative(copies);
            calls.run(fitter -> NativeFunctions.cylfuse_fitter_push_edges(fitter, view));
        }
    }

    /**
     * Says what was pushed since the fitter was created or cleared, and what was left out by reason.
     *
     * @return the counts
     */
    public Counts counts() {
        NativeStructs.Counts n = new NativeStructs.Counts();
        n.struct_size = n.size();
        calls.run(fitter -> NativeFunctions.cylfuse_fitter_counts(fitter, n));
        return Counts.of(n);
    }

    /**
     * Estimates the cylinder from everything that was pushed. No convergence and other doubts are not errors but numbers
     * of the result.
     *
     * @return the result
     * @throws UnusableDataException when the data do not determine a cylinder; the last result stays
     * @throws CylfuseException UNSUPPORTED, BAD_STATE when the data do not go with the options; CANCELLED
     */
    public FitResult fit() {
        return result(NativeFunctions::cylfuse_fitter_fit);
    }

    /**
     * Says what a fit would report for a given model, without iterating. The last result stays.
     *
     * @param model the model
     * @return the result
     * @throws CylfuseException INVALID_ARGUMENT for a bad model, else as {@link #fit()}
     */
    public FitResult evaluate(Cylinder model) {
        NativeStructs.Cylinder n = Objects.requireNonNull(model, "model").toNative();
        return result((fitter, result) -> NativeFunctions.cylfuse_fitter_evaluate(fitter, n, result));
    }

    /**
     * Reads the result of the last fit that succeeded.
     *
     * @return the result
     * @throws CylfuseException BAD_STATE when there is none
     */
    public FitResult result() {
        return result(NativeFunctions::cylfuse_fitter_get_result);
    }

    /**
     * Lists residuals.
     *
     * @param kind which residuals
     * @param model the model
     * @return of points in the order in which they were pushed, without the dropped ones, in the unit of length, negative
     *     inside; of both endpoints of every used segment in ideal pixels
     * @throws CylfuseException BAD_STATE without a model and a result; EDGE_GEOMETRY for edges when the camera is inside
     *     the cylinder
     */
    public double[] residuals(ResidualKind kind, Cylinder model) {
        Objects.requireNonNull(kind, "kind");
        NativeStructs.Cylinder n = Cylinder.toNative(model);
        double[][] residuals = new double[1][];
        calls.run(fitter -> {
            LongByReference count = new LongByReference();
            int status = NativeFunctions.cylfuse_fitter_residuals(fitter, n, kind.value(), null, 0, count);
            if (status != Status.BUFFER_TOO_SMALL.value() && status != Status.OK.value()) {
                return status;
            }
            residuals[0] = new double[Math.toIntExact(count.getValue())];
            return NativeFunctions.cylfuse_fitter_residuals(fitter, n, kind.value(), residuals[0], count.getValue(), count);
        });
        return residuals[0];
    }

    /**
     * Lists what the last fit saw of the limbs in the grey image, piece by piece, used and refused; all samples of a limb
     * that was not located in the end are refused.
     *
     * @return the samples; none when the image was not searched
     * @throws CylfuseException BAD_STATE without a result
     */
    public LimbSample[] limbSamples() {
        LimbSample[][] samples = new LimbSample[1][];
        calls.run(fitter -> {
            LongByReference count = new LongByReference();
            int status = NativeFunctions.cylfuse_fitter_limb_samples(fitter, null, 0, count);
            if (status != Status.BUFFER_TOO_SMALL.value() && status != Status.OK.value()) {
                return status;
            }
            int size = new NativeStructs.LimbSample().size();
            samples[0] = new LimbSample[Math.toIntExact(count.getValue())];
            try (Memory memory = new Memory(Math.max(size * count.getValue(), 1))) {
                status = NativeFunctions.cylfuse_fitter_limb_samples(fitter, memory, count.getValue(), count);
                for (int k = 0; k < samples[0].length && status == Status.OK.value(); k++) {
                    NativeStructs.LimbSample n = new NativeStructs.LimbSample(memory.share((long) size * k));
                    n.read();
                    samples[0][k] = LimbSample.of(n);
                }
            }
            return status;
        });
        return samples[0];
    }

    /**
     * Says what the data determine at a model, by an orthogonal factorisation of the whole Jacobian: more precise than
     * {@link FitResult#condition()}, and far slower.
     *
     * @param model the model
     * @return the diagnosis
     * @throws CylfuseException BAD_STATE without a model and a result, EDGE_GEOMETRY where the cost is infinite,
     *     TOO_FEW_POINTS, NUMERICAL
     */
    public Diagnosis diagnose(Cylinder model) {
        NativeStructs.Cylinder n = Cylinder.toNative(model);
        NativeStructs.Diagnosis diagnosis = new NativeStructs.Diagnosis();
        diagnosis.struct_size = diagnosis.size();
        calls.run(fitter -> NativeFunctions.cylfuse_fitter_diagnose(fitter, n, diagnosis));
        return Diagnosis.of(diagnosis);
    }

    /**
     * Selects, of straight edges that a line detector found in the image, those on the two limbs of a rough cylinder beside
     * the points that were pushed, such as a fit to these points alone. For each limb the edge with the longest pieces
     * wins, the nearer the limb the better, if they cover 30 % of it. Nothing is pushed.
     *
     * @param segments the edges; their weights are ignored
     * @param model the rough cylinder
     * @param reach how far a limb may be from that of the model, in pixels, 0 or greater; 0 = 15 % of the distance of the
     *     limbs, at least 4
     * @return for each segment 1 or 2 for the limb that it lies on, in the order of {@link Cylinder#project}, 0 for none
     * @throws CylfuseException BAD_STATE without model, intrinsics or points, INVALID_ARGUMENT for a bad segment or reach,
     *     EDGE_GEOMETRY when the camera is inside the cylinder or a limb cannot be seen
     */
    public byte[] selectEdges(Segments segments, Cylinder model, double reach) {
        try (NativeCopies copies = new NativeCopies()) {
            NativeStructs.Cylinder n = Cylinder.toNative(model);
            NativeStructs.SegmentsView view = Objects.requireNonNull(segments, "segments").toNative(copies);
            byte[] limbs = new byte[segments.count()];
            calls.run(fitter -> NativeFunctions.cylfuse_fitter_select_edges(fitter, n, view, reach, limbs, limbs.length));
            return limbs;
        }
    }

    /**
     * Finds the visible piece of the cylinder of the last fit.
     *
     * @return the extent
     * @throws CylfuseException as {@link #extent(Cylinder, Mask)}
     */
    public Extent extent() {
        return extent(null, null);
    }

    /**
     * Finds the visible piece of the cylinder and what its ends are, by {@link FitOptions#extentRule()}.
     *
     * @param model the model
     * @param mask the region
     * @return the extent
     * @throws CylfuseException BAD_STATE without model, intrinsics or mask, SIZE_MISMATCH, EMPTY_MASK, EDGE_GEOMETRY when
     *     no ray of the mask meets the cylinder
     */
    public Extent extent(Cylinder model, Mask mask) {
        try (NativeCopies copies = new NativeCopies()) {
            NativeStructs.Cylinder n = Cylinder.toNative(model);
            NativeStructs.MaskView region = Mask.toNative(mask, copies);
            NativeStructs.Extent extent = new NativeStructs.Extent();
            extent.struct_size = extent.size();
            calls.run(fitter -> NativeFunctions.cylfuse_fitter_extent(fitter, n, region, extent));
            return Extent.of(extent);
        }
    }

    /**
     * Says how many points a completion may give at most.
     *
     * @param layout for which layout
     * @param mask the region
     * @return the set pixels of the mask when packed, all pixels of the image when organised
     * @throws CylfuseException BAD_STATE without intrinsics or mask, SIZE_MISMATCH, EMPTY_MASK
     */
    public long completeBound(Layout layout, Mask mask) {
        Objects.requireNonNull(layout, "layout");
        try (NativeCopies copies = new NativeCopies()) {
            NativeStructs.MaskView region = Mask.toNative(mask, copies);
            LongByReference capacity = new LongByReference();
            calls.run(fitter -> NativeFunctions.cylfuse_fitter_complete_bound(fitter, region, layout.value(), capacity));
            return capacity.getValue();
        }
    }

    /**
     * Completes the cloud of the last fit, packed.
     *
     * @return the points
     * @throws CylfuseException as {@link #complete(Layout, Cylinder, Mask)}
     */
    public CompletedCloud complete() {
        return complete(Layout.PACKED, null, null);
    }

    /**
     * Completes the cloud: casts the ray of every pixel of a mask and takes its first meeting with the cylinder, the near
     * wall from outside, the far one from inside a pipe.
     *
     * @param layout only the points that exist, or one for each pixel of the image
     * @param model the model
     * @param mask the region
     * @return the points
     * @throws CylfuseException BAD_STATE without model, intrinsics or mask, SIZE_MISMATCH, EMPTY_MASK, INVALID_ARGUMENT
     */
    public CompletedCloud complete(Layout layout, Cylinder model, Mask mask) {
        Objects.requireNonNull(layout, "layout");
        try (NativeCopies copies = new NativeCopies()) {
            Completing.CompletedMemory points = new Completing(calls, model, mask, copies).cloud(Formats.SCALAR_F64, layout);
            double[] coordinates = points.memory().getDoubleArray(0, 3 * points.width() * points.height());
            return new CompletedCloud(coordinates, points.width(), points.height(), points.pixels());
        }
    }

    /**
     * Completes the cloud with coordinates of single precision.
     *
     * @param layout only the points that exist, or one for each pixel of the image
     * @param model the model
     * @param mask the region
     * @return the points
     * @throws CylfuseException as {@link #complete(Layout, Cylinder, Mask)}
     */
    public CompletedCloudSingle completeSingle(Layout layout, Cylinder model, Mask mask) {
        Objects.requireNonNull(layout, "layout");
        try (NativeCopies copies = new NativeCopies()) {
            Completing.CompletedMemory points = new Completing(calls, model, mask, copies).cloud(Formats.SCALAR_F32, layout);
            float[] coordinates = points.memory().getFloatArray(0, 3 * points.width() * points.height());
            return new CompletedCloudSingle(coordinates, points.width(), points.height(), points.pixels());
        }
    }

    /**
     * Completes the depth image: the z of every point of a completed cloud, 0 where there is none.
     *
     * @param scale length of one unit of the stored value
     * @param model the model
     * @param mask the region
     * @return the image
     * @throws CylfuseException BAD_STATE without model, intrinsics or mask, SIZE_MISMATCH, EMPTY_MASK, INVALID_ARGUMENT
     */
    public CompletedDepth completeDepth(double scale, Cylinder model, Mask mask) {
        try (NativeCopies copies = new NativeCopies()) {
            Completing.CompletedMemory image = new Completing(calls, model, mask, copies).depth(Formats.DEPTH_F32, scale);
            float[] depth = image.memory().getFloatArray(0, image.width() * image.height());
            return new CompletedDepth(depth, image.width(), image.height(), image.pixels());
        }
    }

    /**
     * Completes the depth image in integers of 16 bits. A depth beyond their range becomes 0 and is counted.
     *
     * @param scale length of one unit of the stored value
     * @param model the model
     * @param mask the region
     * @return the image
     * @throws CylfuseException as {@link #completeDepth(double, Cylinder, Mask)}
     */
    public CompletedDepthInteger completeDepthInteger(double scale, Cylinder model, Mask mask) {
        try (NativeCopies copies = new NativeCopies()) {
            Completing.CompletedMemory image = new Completing(calls, model, mask, copies).depth(Formats.DEPTH_U16, scale);
            short[] depth = image.memory().getShortArray(0, image.width() * image.height());
            return new CompletedDepthInteger(depth, image.width(), image.height(), image.pixels());
        }
    }

    /** A call that writes a result. */
    private interface ResultCall {
        int apply(Pointer fitter, NativeStructs.Result result);
    }

    private FitResult result(ResultCall resultCall) {
        NativeStructs.Result n = new NativeStructs.Result();
        n.struct_size = n.size();
        calls.run(fitter -> resultCall.apply(fitter, n));
        return FitResult.of(n);
    }
}
