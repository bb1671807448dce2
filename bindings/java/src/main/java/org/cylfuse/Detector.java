package org.cylfuse;

import com.sun.jna.Memory;
import com.sun.jna.Pointer;
import com.sun.jna.ptr.IntByReference;
import com.sun.jna.ptr.LongByReference;
import java.lang.ref.Cleaner;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import java.util.Objects;
import java.util.concurrent.locks.Lock;
import java.util.concurrent.locks.ReentrantReadWriteLock;
import java.util.function.Supplier;
import java.util.function.ToIntFunction;

/**
 * Finds all cylinders of a frame or a cloud, without masks, and fits each by the full method.
 *
 * <p>A search returns the cylinders by falling score; there may be none. {@link #detections()}, {@link #labels()}, {@link
 * #indices} and {@link #makeFitter} are of the last search that succeeded.
 *
 * <p>The threads of a detector follow the rules of a {@link Fitter}: calls that only read run side by side, and what would
 * disturb another call throws with {@link Status#BUSY} at once. After {@link #close()} every other method throws an {@link
 * IllegalStateException}.
 */
public final class Detector implements AutoCloseable {
    private static final Cleaner CLEANER = Cleaner.create();

    private final NativeHandle handle = new NativeHandle(
            "detector",
            NativeFunctions::cylfuse_detector_create,
            NativeFunctions::cylfuse_detector_destroy,
            NativeFunctions::cylfuse_detector_last_error);
    // Knows the handle alone: what knows the detector or its listener would keep it from being collected.
    private final Cleaner.Cleanable cleanable = CLEANER.register(this, handle::close);
    // A field, because the library keeps this function and the garbage collector does not know that.
    private final NativeFunctions.DetectionProgressCallback nativeProgress = this::onProgress;
    private volatile DetectionProgressListener progress;

    // A search holds it for writing, what reads its scene in several calls for reading. A listener, on the thread of the
    // search, may enter it again, and is refused by the library.
    private final ReentrantReadWriteLock lock = new ReentrantReadWriteLock();
    // Of the last scene; the camera is null for a cloud.
    private int width;
    private int height;
    private Intrinsics camera;

    /**
     * A detector with default options.
     *
     * @throws UnsatisfiedLinkError when the native library was not found or is not that of this package
     */
    public Detector() {}

    /** Destroys the detector and frees what it holds; fitters that it made stay. May be called more than once. */
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
    public void setOptions(DetectorOptions options) {
        NativeStructs.DetectorOptions n = Objects.requireNonNull(options, "options").toNative();
        handle.run(detector -> NativeFunctions.cylfuse_detector_set_options(detector, n));
    }

    /**
     * Reads the options.
     *
     * @return a copy
     */
    public DetectorOptions options() {
        DetectorOptions options = new DetectorOptions();
        handle.run(detector -> NativeFunctions.cylfuse_detector_get_options(detector, options.toNative()));
        return options;
    }

    /**
     * Replaces the options of the fits. Limits, threads and start must have their defaults: they are the detector's.
     *
     * @param options the options, copied
     * @throws CylfuseException INVALID_ARGUMENT when a value is out of range or the detector's; the old options stay
     */
    public void setFitOptions(FitOptions options) {
        NativeStructs.Options n = Objects.requireNonNull(options, "options").toNative();
        handle.run(detector -> NativeFunctions.cylfuse_detector_set_fit_options(detector, n));
    }

    /**
     * Reads the options of the fits.
     *
     * @return a copy
     */
    public FitOptions fitOptions() {
        FitOptions options = new FitOptions();
        handle.run(detector -> NativeFunctions.cylfuse_detector_get_fit_options(detector, options.toNative()));
        return options;
    }

    /**
     * Sets or takes away the listener that is called with the progress of a search: before it, after it, and after each
     * fit. What it throws stops the search and comes out of it.
     *
     * @param listener null for none
     */
    public void setProgressListener(DetectionProgressListener listener) {
        handle.run(detector -> NativeFunctions.cylfuse_detector_set_progress(
                detector, listener == null ? null : nativeProgress, null));
        progress = listener;
    }

    /**
     * Asks the call that is running to stop: a search throws with {@link Status#CANCELLED}. When no call is running it
     * does nothing. From any thread, at any time.
     */
    public void cancel() {
        handle.run(NativeFunctions::cylfuse_detector_cancel);
    }

    /**
     * Finds all cylinders in the depth image of a frame, and fits each to its region by depth and image, in the reference
     * frame to which the pose of the frame leads.
     *
     * @param frame the frame, with intrinsics and a depth image. The images are shared and not copied; it may be changed
     *     or closed afterwards, of which the detector sees nothing.
     * @return the cylinders by falling score
     * @throws CylfuseException BAD_STATE without intrinsics or depth, UNSUPPORTED for options of the fits that need edges,
     *     CANCELLED; the last scene stays then
     */
    public List<Detection> detect(Frame frame) {
        Objects.requireNonNull(frame, "frame");
        List<Detection> found = new ArrayList<>();
        // The call on the detector is the inner one: it is the one that fails.
        frame.handle.run(used -> {
            Intrinsics seenBy = frame.camera();
            found.addAll(search(
                    detector -> NativeFunctions.cylfuse_detector_detect(detector, used),
                    seenBy == null ? 0 : seenBy.width(),
                    seenBy == null ? 0 : seenBy.height(),
                    seenBy));
            return Status.OK.value();
        });
        return found;
    }

    /**
     * Finds all cylinders in a cloud, organised or not, and fits each to its points. Points with a coordinate that is not
     * finite or a weight of 0 are left out. It is looked at from where one sensor has seen it, in its origin or
     * where the densities of the points tell; other clouds are looked at from all sides, which takes ten times as long and
     * more.
     *
     * @param points the points
     * @return the cylinders by falling score
     * @throws CylfuseException INVALID_ARGUMENT for a negative weight, UNSUPPORTED for options of the fits that need
     *     edges, CANCELLED; the last scene stays then
     */
    public List<Detection> detectPoints(PointCloud points) {
        try (NativeCopies copies = new NativeCopies()) {
            NativeStructs.PointsView view = Objects.requireNonNull(points, "points").toNative(copies);
            return search(
                    detector -> NativeFunctions.cylfuse_detector_detect_points(detector, view),
                    points.width(),
                    points.height(),
                    null);
        }
    }

    /**
     * Reads the cylinders of the last search that succeeded.
     *
     * @return the cylinders by falling score
     * @throws CylfuseException BAD_STATE before the first search
     */
    public List<Detection> detections() {
        return locked(lock.readLock(), this::read);
    }

    /**
     * Says whether the scene was looked at as a whole. The work of a search with its fits is bounded: of a scene with more
     * in it than that, cylinders may be missing. One for whose fit there was no work left is what the search found, with
     * {@link ResultFlag#NOT_CONVERGED}.
     *
     * @return false when cylinders may be missing
     * @throws CylfuseException BAD_STATE before the first search
     */
    public boolean isComplete() {
        IntByReference complete = new IntByReference();
        handle.run(detector -> NativeFunctions.cylfuse_detector_is_complete(detector, complete));
        return complete.getValue() != 0;
    }

    /**
     * Says by how many pixels the depth of the frame was moved to where the image shows the same bodies. Each result then
     * has {@link ResultFlag#DEPTH_SHIFTED}; labels and indices are those of the depth as it was given.
     *
     * @return columns (to the right) and rows (down); zeros where it was not moved
     * @throws CylfuseException BAD_STATE before the first search
     */
    public int[] depthMoved() {
        IntByReference columns = new IntByReference();
        IntByReference rows = new IntByReference();
        handle.run(detector -> NativeFunctions.cylfuse_detector_depth_moved(detector, columns, rows));
        return new int[] {columns.getValue(), rows.getValue()};
    }

    /**
     * Says for each pixel of the colour image, or each point of the cloud, the number of its cylinder from 1 on.
     *
     * @return the labels: 1 for the first detection, 0 = none
     * @throws CylfuseException BAD_STATE before the first search
     */
    public Labels labels() {
        return locked(lock.readLock(), () -> {
            short[] stored = new short[Math.multiplyExact(width, height)];
            LongByReference count = new LongByReference();
            handle.run(detector -> NativeFunctions.cylfuse_detector_labels(detector, stored, stored.length, count));
            int[] numbers = new int[stored.length];
            for (int k = 0; k < numbers.length; k++) {
                numbers[k] = Short.toUnsignedInt(stored[k]);
            }
            return new Labels(width, height, numbers);
        });
    }

    /**
     * Lists the pixels or points of one detection.
     *
     * @param index the detection, from 0
     * @return its places, counted from 0 row by row, rising
     * @throws IllegalArgumentException when the number is negative
     * @throws CylfuseException BAD_STATE before the first search, INVALID_ARGUMENT when there is no such detection
     */
    public int[] indices(int index) {
        notNegative(index);
        int[][] indices = new int[1][];
        return locked(lock.readLock(), () -> {
            int length = NativeList.fill(handle, (detector, capacity, count) -> {
                indices[0] = new int[capacity];
                return NativeFunctions.cylfuse_detector_indices(detector, index, indices[0], capacity, count);
            });
            return Arrays.copyOf(indices[0], length);
        });
    }

    /**
     * Makes a fitter of one detection as its fit left it, with options, frame or points, region as mask, start model and
     * result: for residuals, completion, limbs and all else that can be asked of a fit, or for another fit. It shares the
     * images of the frame and does not depend on the detector.
     *
     * @param index the detection, from 0
     * @return the fitter, for the caller to close
     * @throws IllegalArgumentException when the number is negative
     * @throws CylfuseException BAD_STATE before the first search, INVALID_ARGUMENT when there is no such detection
     */
    public Fitter makeFitter(int index) {
        notNegative(index);
        Fitter[] made = new Fitter[1];
        return locked(lock.readLock(), () -> {
            handle.run(detector -> {
                made[0] = new Fitter(
                        (abiVersion, out) -> NativeFunctions.cylfuse_detector_make_fitter(detector, index, out), camera);
                return Status.OK.value();
            });
            return made[0];
        });
    }

    private List<Detection> search(ToIntFunction<Pointer> call, int columns, int rows, Intrinsics seenBy) {
        return locked(lock.writeLock(), () -> {
            handle.run(call);
            width = columns;
            height = rows;
            camera = seenBy;
            return read();
        });
    }

    private static <T> T locked(Lock part, Supplier<T> body) {
        if (!part.tryLock()) {
            String text = NativeFunctions.cylfuse_status_string(Status.BUSY.value());
            throw CylfuseException.of(Status.BUSY, text);
        }
        try {
            return body.get();
        } finally {
            part.unlock();
        }
    }

    private List<Detection> read() {
        List<Detection> found = new ArrayList<>();
        long size = new NativeStructs.Detection().size();
        handle.run(detector -> {
            LongByReference count = new LongByReference();
            int status = NativeFunctions.cylfuse_detector_count(detector, count);
            if (status != Status.OK.value()) {
                return status;
            }
            try (Memory memory = new Memory(Math.max(size * count.getValue(), 1))) {
                status = NativeFunctions.cylfuse_detector_detections(detector, memory, size, count.getValue(), count);
                for (long k = 0; k < count.getValue() && status == Status.OK.value(); k++) {
                    NativeStructs.Detection one = new NativeStructs.Detection(memory.share(size * k));
                    one.read();
                    status = add(found, detector, k, one);
                }
            }
            return status;
        });
        return found;
    }

    private static int add(List<Detection> found, Pointer detector, long index, NativeStructs.Detection one) {
        Fitter.Outcome outcome = new Fitter.Outcome();
        NativeStructs.Extent extent =
                NativeFunctions.initialised(new NativeStructs.Extent(), NativeFunctions::cylfuse_extent_init);
        int status = NativeFunctions.cylfuse_detector_get_result(detector, index, outcome.result);
        if (status == Status.OK.value()) {
            status = NativeFunctions.cylfuse_detector_get_cylinder(detector, index, outcome.estimate);
        }
        if (status == Status.OK.value()) {
            int seen = NativeFunctions.cylfuse_detector_get_extent(detector, index, extent);
            if (seen == Status.BUSY.value()) {
                return seen;
            }
            CylfuseException error = seen == Status.OK.value()
                    ? null
                    : CylfuseException.of(Status.of(seen), NativeFunctions.cylfuse_detector_last_error(detector));
            found.add(new Detection(
                    one.score, one.pixels, outcome.read(), error == null ? Extent.of(extent) : null, error));
        }
        return status;
    }

    private int onProgress(Pointer address, Pointer userData) {
        try {
            NativeStructs.DetectionProgress n = new NativeStructs.DetectionProgress(address);
            n.read();
            DetectionProgressListener listener = progress;
            return listener == null || listener.onProgress(DetectionProgress.of(n)) ? 0 : 1;
        } catch (Throwable failure) {
            NativeHandle.keep(failure);
            return 1;
        }
    }

    private static void notNegative(int index) {
        if (index < 0) {
            throw new IllegalArgumentException("There is no cylinder " + index + ": they count from 0.");
        }
    }
}
