package org.cylfuse;

import com.sun.jna.ptr.LongByReference;
import com.sun.jna.ptr.PointerByReference;
import java.lang.ref.Cleaner;
import java.util.Arrays;
import java.util.List;
import java.util.Objects;
import java.util.function.ToIntBiFunction;

/**
 * Estimates one cylinder: holds options, views with their data, and the last result.
 *
 * <p>Create it, push points (or set the intrinsics, push a depth image with a mask and the image), fit. For the next
 * frame: clear, push, fit. The library copies what is pushed.
 *
 * <p>A fitter may move between threads. Calls that only read, such as {@link #result()}, {@link #residuals} or {@link
 * #evaluate}, run side by side; a call that may change the fitter runs alone. What would disturb another call, from
 * another thread or from a listener, throws a {@link CylfuseException} with {@link Status#BUSY} at once. Only {@link
 * #cancel()} and {@link #close()} always go through; the fitter is then destroyed after the calls that are running.
 * Different fitters run in parallel. After {@link #close()} every other method throws an {@link IllegalStateException}.
 *
 * <p>Where a method takes a model, in the reference frame, null stands for that of the last fit; where it takes a mask,
 * null stands for the mask of the selected view, and another one must have the size of the intrinsics.
 */
public final class Fitter extends FitterData implements AutoCloseable {
    private static final Cleaner CLEANER = Cleaner.create();

    // Knows the handle alone: what knows the fitter or its listeners would keep it from being collected.
    private final Cleaner.Cleanable cleanable = CLEANER.register(this, calls.handle::close);

    /**
     * A fitter with default options, one view at the identity, and no data.
     *
     * @throws UnsatisfiedLinkError when the native library was not found or is not that of this package
     */
    public Fitter() {
        this(NativeFunctions::cylfuse_fitter_create, null);
    }

    /** A fitter that another function creates, with the camera of its first view. */
    Fitter(ToIntBiFunction<Integer, PointerByReference> create, Intrinsics camera) {
        super(new FitterCalls(create, camera));
    }

    /**
     * Makes another fitter with all that this one holds, settings, data and result, but no listeners. Images are shared,
     * points are copied: copy one that is set up for each thread before data are pushed.
     *
     * @return the fitter, for the caller to close
     * @throws CylfuseException OUT_OF_MEMORY
     */
    public Fitter copy() {
        Fitter[] made = new Fitter[1];
        calls.run(fitter -> {
            made[0] = new Fitter((abiVersion, out) -> NativeFunctions.cylfuse_fitter_clone(fitter, out), null);
            return Status.OK.value();
        });
        made[0].calls.setCamerasOf(calls);
        return made[0];
    }

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
        NativeStructs.Options n =
                NativeFunctions.initialised(new NativeStructs.Options(), NativeFunctions::cylfuse_options_init);
        calls.run(fitter -> NativeFunctions.cylfuse_fitter_get_options(fitter, n));
        return new FitOptions(n);
    }

    /**
     * Sets a start model: a candidate for the start AUTO, the start of MODEL.
     *
     * @param model the model, in the reference frame; null takes it away
     * @throws CylfuseException INVALID_ARGUMENT when the model is no cylinder; the old one stays
     */
    public void setStartModel(Cylinder model) {
        NativeStructs.Cylinder n = Cylinder.toNative(model);
        calls.run(fitter -> NativeFunctions.cylfuse_fitter_set_start_model(fitter, n));
    }

    /**
     * Sets or takes away the listener that is called before every iteration. What it throws stops the fit and comes out of
     * it.
     *
     * @param listener null for none
     */
    public void setProgressListener(ProgressListener listener) {
        calls.setProgressListener(listener);
    }

    /**
     * Sets or takes away the listener that takes log lines: on several threads at once when several make
     * calls that only read. What it throws comes out of the call when that has ended.
     *
     * @param maxLevel lines up to this level are handed over
     * @param listener null for none
     */
    public void setLogListener(LogLevel maxLevel, LogListener listener) {
        calls.setLogListener(Objects.requireNonNull(maxLevel, "maxLevel"), listener);
    }

    /**
     * Asks the calls that are running to stop: a fit throws with {@link Status#CANCELLED}. When no call is running it
     * does nothing. From any thread, at any time.
     */
    public void cancel() {
        calls.run(NativeFunctions::cylfuse_fitter_cancel);
    }

    /**
     * Estimates the cylinder from everything that was pushed into all views. Lack of convergence and other warnings are
     * not errors but numbers of the result.
     *
     * @return the result
     * @throws UnusableDataException when the data do not determine a cylinder; the last result stays
     * @throws CylfuseException UNSUPPORTED, BAD_STATE when the data do not go with the options; CANCELLED
     */
    public FitResult fit() {
        Outcome outcome = new Outcome();
        calls.run(fitter -> NativeFunctions.cylfuse_fitter_fit(fitter, outcome.result, outcome.estimate));
        return outcome.read();
    }

    /**
     * Says what a fit would report for a given cylinder, without iterating. The last result stays.
     *
     * @param model the model
     * @return the result
     * @throws CylfuseException INVALID_ARGUMENT for a bad model, else as {@link #fit()}
     */
    public FitResult evaluate(Cylinder model) {
        NativeStructs.Cylinder n = Objects.requireNonNull(model, "model").toNative();
        Outcome outcome = new Outcome();
        calls.run(fitter -> NativeFunctions.cylfuse_fitter_evaluate(fitter, n, outcome.result, outcome.estimate));
        return outcome.read();
    }

    /**
     * Reads the result of the last fit that succeeded.
     *
     * @return the result
     * @throws CylfuseException BAD_STATE when there is none
     */
    public FitResult result() {
        Outcome outcome = new Outcome();
        calls.run(fitter -> {
            int status = NativeFunctions.cylfuse_fitter_get_result(fitter, outcome.result);
            return status == Status.OK.value()
                    ? NativeFunctions.cylfuse_fitter_get_cylinder(fitter, outcome.estimate)
                    : status;
        });
        return outcome.read();
    }

    /**
     * Lists residuals of the selected view.
     *
     * @param kind which residuals
     * @param model the model
     * @return of points in the order in which they were pushed, without the dropped ones, in the unit of length,
     *     negative inside; of both endpoints of every used segment in ideal pixels
     * @throws CylfuseException BAD_STATE without a model and a result; EDGE_GEOMETRY for edges when the camera is
     *     inside the cylinder
     */
    public double[] residuals(ResidualKind kind, Cylinder model) {
        Objects.requireNonNull(kind, "kind");
        NativeStructs.Cylinder n = Cylinder.toNative(model);
        double[][] residuals = new double[1][];
        int length = NativeList.fill(calls.handle, (fitter, capacity, count) -> {
            residuals[0] = new double[capacity];
            return NativeFunctions.cylfuse_fitter_residuals(fitter, n, kind.value(), residuals[0], capacity, count);
        });
        return Arrays.copyOf(residuals[0], length);
    }

    /**
     * Lists how much each point of the selected view counts at the cylinder of the last fit.
     *
     * @return weights and inliers, in the order of the residuals of points
     * @throws CylfuseException BAD_STATE without a result
     */
    public PointWeights pointWeights() {
        double[][] weights = new double[1][];
        byte[][] bytes = new byte[1][];
        int length = NativeList.fill(calls.handle, (fitter, capacity, count) -> {
            weights[0] = new double[capacity];
            bytes[0] = new byte[capacity];
            return NativeFunctions.cylfuse_fitter_point_weights(fitter, weights[0], bytes[0], capacity, count);
        });
        boolean[] inliers = new boolean[length];
        for (int k = 0; k < length; k++) {
            inliers[k] = bytes[0][k] != 0;
        }
        return new PointWeights(Arrays.copyOf(weights[0], length), inliers);
    }

    /**
     * Tells what each point of the selected view belongs to.
     *
     * @param model the model; null = that of the last fit
     * @return the parts, in the order of the residuals of points
     * @throws CylfuseException BAD_STATE without a model and a result
     */
    public Part[] pointParts(Cylinder model) {
        NativeStructs.Cylinder n = Cylinder.toNative(model);
        byte[][] parts = new byte[1][];
        int length = NativeList.fill(calls.handle, (fitter, capacity, count) -> {
            parts[0] = new byte[capacity];
            return NativeFunctions.cylfuse_fitter_point_parts(fitter, n, parts[0], capacity, count);
        });
        Part[] listed = new Part[length];
        for (int k = 0; k < listed.length; k++) {
            listed[k] = NativeNumber.find(Part.class, parts[0][k]);
        }
        return listed;
    }

    /**
     * Lists the two limbs of the last fit in each view, view after view: where they were located in the image, or why
     * they were not.
     *
     * @return the limbs; all are NOT_SEARCHED once data or options have changed since
     * @throws CylfuseException BAD_STATE without a result
     */
    public List<LimbLine> limbs() {
        return NativeList.read(calls.handle, NativeFunctions::cylfuse_fitter_limbs, NativeStructs.Limb::new, LimbLine::of);
    }

    /**
     * Lists what the last fit saw of the limbs in the image of the selected view, piece by piece, used and refused; all
     * samples of a limb that was not located in the end are refused.
     *
     * @return the samples; none when the image was not searched, and once data or options have changed since
     * @throws CylfuseException BAD_STATE without a result
     */
    public List<LimbSample> limbSamples() {
        return NativeList.read(
                calls.handle, NativeFunctions::cylfuse_fitter_limb_samples, NativeStructs.LimbSample::new, LimbSample::of);
    }

    /**
     * Lists the samples on the arcs of both ends that {@link #extent(Cylinder, Mask)} finds in the images, view after
     * view: first those of the start, then those of the end. There are none for an end that the image of a view does
     * not show.
     *
     * @param model the model
     * @param mask the region
     * @return the places
     * @throws CylfuseException as {@link #extent(Cylinder, Mask)}
     */
    public List<EndSample> endSamples(Cylinder model, Mask mask) {
        try (NativeCopies copies = new NativeCopies()) {
            NativeStructs.Cylinder n = Cylinder.toNative(model);
            NativeStructs.MaskView region = Mask.toNative(mask, copies);
            return NativeList.read(
                    calls.handle,
                    (fitter, out, size, capacity, count) ->
                            NativeFunctions.cylfuse_fitter_end_samples(fitter, n, region, out, size, capacity, count),
                    NativeStructs.EndSample::new,
                    EndSample::of);
        }
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
        NativeStructs.CylinderDiagnosis diagnosis = NativeFunctions.initialised(
                new NativeStructs.CylinderDiagnosis(), NativeFunctions::cylfuse_cylinder_diagnosis_init);
        calls.run(fitter -> NativeFunctions.cylfuse_fitter_diagnose(fitter, n, diagnosis));
        return Diagnosis.of(diagnosis);
    }

    /**
     * Selects, of straight edges that a line detector found in the image, those on the two limbs of a rough cylinder
     * beside the points that were pushed, such as a fit to these points alone. For each limb the edge with the longest
     * pieces wins, the nearer the limb the better, if they cover 30 % of it. Nothing is pushed.
     *
     * @param segments the edges; their weights are ignored
     * @param model the rough cylinder
     * @param reach how far a limb may be from that of the model, in pixels, 0 or greater; 0 = 15 % of the distance of
     *     the limbs, at least 4
     * @return for each segment 1 or 2 for the limb that it lies on, in the order of {@link Cylinder#project}, 0 for
     *     none
     * @throws CylfuseException BAD_STATE without model, intrinsics or points, INVALID_ARGUMENT for a bad segment or
     *     reach, EDGE_GEOMETRY when the camera is inside the cylinder or a limb cannot be seen
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
     * Finds the visible piece of the cylinder and what its ends are: in a view with a camera and a mask by
     * {@link FitOptions#extentRule()}, in others, and from inside a pipe, by the points on the surface. An end that is
     * seen in several views is their mean by their variances; one that is seen in none is the outermost of what they
     * show.
     *
     * @param model the model
     * @param mask the region
     * @return the extent
     * @throws CylfuseException BAD_STATE without a model, without points or a mask, and for a mask that is given without
     *     intrinsics; SIZE_MISMATCH, EMPTY_MASK, EDGE_GEOMETRY when no ray of the mask meets the cylinder and no points
     *     lie along it
     */
    public Extent extent(Cylinder model, Mask mask) {
        try (NativeCopies copies = new NativeCopies()) {
            NativeStructs.Cylinder n = Cylinder.toNative(model);
            NativeStructs.MaskView region = Mask.toNative(mask, copies);
            NativeStructs.Extent extent =
                    NativeFunctions.initialised(new NativeStructs.Extent(), NativeFunctions::cylfuse_extent_init);
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
     * Completes the cloud of the selected view: casts the ray of every pixel of a mask and takes its first meeting with
     * the cylinder, the near wall from outside, the far one from inside a pipe. The points are in the reference frame.
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
     * Completes the depth image of the selected view, on the pixels of its colour image: the z of every point of a
     * completed cloud, 0 where there is none.
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

    /** The two structs of an outcome. */
    static final class Outcome {
        final NativeStructs.Result result =
                NativeFunctions.initialised(new NativeStructs.Result(), NativeFunctions::cylfuse_result_init);
        final NativeStructs.CylinderEstimate estimate = NativeFunctions.initialised(
                new NativeStructs.CylinderEstimate(), NativeFunctions::cylfuse_cylinder_estimate_init);

        FitResult read() {
            return FitResult.of(result, estimate);
        }
    }
}
