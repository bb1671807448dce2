package org.cylfuse;

import com.sun.jna.Callback;
import com.sun.jna.Native;
import com.sun.jna.NativeLibrary;
import com.sun.jna.Pointer;
import com.sun.jna.Structure;
import com.sun.jna.ptr.DoubleByReference;
import com.sun.jna.ptr.IntByReference;
import com.sun.jna.ptr.LongByReference;
import com.sun.jna.ptr.PointerByReference;
import java.io.IOException;
import java.util.function.ToIntBiFunction;

/** The functions of cylfuse.h; {@code size_t} is {@code long}, as the library is opened in 64-bit processes only. */
final class NativeFunctions {
    /** The version of the binary interface that {@link NativeStructs} describes. */
    static final int ABI_VERSION = 1;

    static {
        open();
    }

    private NativeFunctions() {}

    /**
     * Opens the library: the file that CYLFUSE_LIBRARY names and no other, else that of the jar, else what JNA finds.
     */
    private static void open() {
        if (Native.POINTER_SIZE != 8) {
            throw new UnsatisfiedLinkError("cylfuse needs a 64-bit Java; this one has " + 8 * Native.POINTER_SIZE + " bits.");
        }
        String file = System.getenv("CYLFUSE_LIBRARY");
        boolean named = file != null && !file.isEmpty();
        NativeLibrary library;
        try {
            library = NativeLibrary.getInstance(named ? file : bundled());
        } catch (UnsatisfiedLinkError failure) {
            throw explained("The native library of cylfuse cannot be opened. "
                    + (named
                            ? "The environment variable CYLFUSE_LIBRARY names this file; correct or remove it. "
                            : "Name its file in the environment variable CYLFUSE_LIBRARY. "), failure);
        }
        try {
            // Before the other functions are looked up: those of another interface may be others.
            int version = library.getFunction("cylfuse_abi_version").invokeInt(new Object[0]);
            if (version != ABI_VERSION) {
                throw new UnsatisfiedLinkError("it has version " + version + " of the binary interface; this package needs version "
                        + ABI_VERSION + ". Use the library that belongs to it.");
            }
            Native.register(NativeFunctions.class, library);
        } catch (UnsatisfiedLinkError failure) {
            throw explained(library.getFile() + " is not the native library of this package: ", failure);
        }
    }

    /** The library in the jar, which goes with this package as one that the system has may not; its plain name without. */
    private static String bundled() {
        try {
            return Native.extractFromResourcePath("cylfuse", NativeFunctions.class.getClassLoader()).getPath();
        } catch (IOException notThere) {
            return "cylfuse";
        }
    }

    private static UnsatisfiedLinkError explained(String what, UnsatisfiedLinkError cause) {
        UnsatisfiedLinkError failure = new UnsatisfiedLinkError(what + cause.getMessage());
        failure.initCause(cause);
        return failure;
    }

    /** Called before every iteration. */
    interface ProgressCallback extends Callback {
        int invoke(Pointer progress, Pointer userData);
    }

    /** Is called with the progress of a detector. */
    interface DetectionProgressCallback extends Callback {
        int invoke(Pointer progress, Pointer userData);
    }

    /** Takes a log line. */
    interface FitEndedCallback extends Callback {
        int invoke(long index, int status, Pointer userData);
    }

    interface LogCallback extends Callback {
        void invoke(int level, String message, Pointer userData);
    }

    static native int cylfuse_abi_version();

    static native int cylfuse_version_number();

    static native String cylfuse_version_string();

    static native String cylfuse_build_info();

    static native String cylfuse_status_string(int status);

    static native String cylfuse_flag_string(int flag);

    static native String cylfuse_termination_string(int termination);

    static native String cylfuse_start_string(int start);

    static native String cylfuse_end_state_string(int state);

    static native String cylfuse_end_source_string(int source);

    static native String cylfuse_limb_status_string(int status);

    static native String cylfuse_part_string(byte part);

    static native String cylfuse_conformity_string(int conformity);

    static native int cylfuse_options_init(NativeStructs.Options options, long structSize);

    static native int cylfuse_detector_options_init(NativeStructs.DetectorOptions options, long structSize);

    static native int cylfuse_intrinsics_init(NativeStructs.Intrinsics intrinsics, long structSize);

    static native int cylfuse_points_view_init(NativeStructs.PointsView points, long structSize);

    static native int cylfuse_depth_view_init(NativeStructs.DepthView depth, long structSize);

    static native int cylfuse_mask_view_init(NativeStructs.MaskView mask, long structSize);

    static native int cylfuse_image_view_init(NativeStructs.ImageView image, long structSize);

    static native int cylfuse_segments_view_init(NativeStructs.SegmentsView segments, long structSize);

    static native int cylfuse_points_out_init(NativeStructs.PointsOut out, long structSize);

    static native int cylfuse_depth_out_init(NativeStructs.DepthOut out, long structSize);

    static native int cylfuse_counts_init(NativeStructs.Counts counts, long structSize);

    static native int cylfuse_result_init(NativeStructs.Result result, long structSize);

    static native int cylfuse_cylinder_estimate_init(NativeStructs.CylinderEstimate estimate, long structSize);

    static native int cylfuse_cylinder_diagnosis_init(NativeStructs.CylinderDiagnosis diagnosis, long structSize);

    static native int cylfuse_completion_init(NativeStructs.Completion completion, long structSize);

    static native int cylfuse_extent_init(NativeStructs.Extent extent, long structSize);

    static native int cylfuse_fitter_create(int abiVersion, PointerByReference fitter);

    static native int cylfuse_fitter_destroy(Pointer fitter);

    static native int cylfuse_fitter_reserve(Pointer fitter, long points, long segments);

    static native int cylfuse_fitter_clear(Pointer fitter);

    static native int cylfuse_fitter_clear_input(Pointer fitter, int inputs);

    static native String cylfuse_fitter_last_error(Pointer fitter);

    static native int cylfuse_fitter_cancel(Pointer fitter);

    static native int cylfuse_fitter_set_options(Pointer fitter, NativeStructs.Options options);

    static native int cylfuse_fitter_clone(Pointer fitter, PointerByReference clone);

    static native int cylfuse_fitter_get_intrinsics(Pointer fitter, NativeStructs.Intrinsics intrinsics);

    static native int cylfuse_fitter_get_options(Pointer fitter, NativeStructs.Options options);

    static native int cylfuse_fitter_select_view(Pointer fitter, long index);

    static native int cylfuse_fitter_view_count(Pointer fitter, LongByReference count);

    static native int cylfuse_fitter_set_pose(Pointer fitter, double[] rotation, double[] translation);

    static native int cylfuse_fitter_set_depth_camera(
            Pointer fitter, NativeStructs.Intrinsics intrinsics, double[] rotation, double[] translation);

    static native int cylfuse_fitter_use_frame(Pointer fitter, Pointer frame, NativeStructs.MaskView mask);

    static native int cylfuse_fitter_set_intrinsics(Pointer fitter, NativeStructs.Intrinsics intrinsics);

    static native int cylfuse_fitter_set_start_model(Pointer fitter, NativeStructs.Cylinder model);

    static native int cylfuse_fitter_set_progress(Pointer fitter, ProgressCallback callback, Pointer userData);

    static native int cylfuse_fitter_set_log(Pointer fitter, int maxLevel, LogCallback callback, Pointer userData);

    static native int cylfuse_fitter_push_points(Pointer fitter, NativeStructs.PointsView points, NativeStructs.MaskView mask);

    static native int cylfuse_fitter_push_depth(Pointer fitter, NativeStructs.DepthView depth, NativeStructs.MaskView mask);

    static native int cylfuse_fitter_push_image(Pointer fitter, NativeStructs.ImageView image);

    static native int cylfuse_fitter_push_edges(Pointer fitter, NativeStructs.SegmentsView segments);

    static native int cylfuse_fitter_counts(Pointer fitter, NativeStructs.Counts counts);

    static native int cylfuse_fitter_fit(
            Pointer fitter, NativeStructs.Result result, NativeStructs.CylinderEstimate estimate);

    static native int cylfuse_fitter_evaluate(
            Pointer fitter,
            NativeStructs.Cylinder model,
            NativeStructs.Result result,
            NativeStructs.CylinderEstimate estimate);

    static native int cylfuse_fitter_get_result(Pointer fitter, NativeStructs.Result result);

    static native int cylfuse_fitter_get_cylinder(Pointer fitter, NativeStructs.CylinderEstimate estimate);

    static native int cylfuse_fitter_residuals(
            Pointer fitter, NativeStructs.Cylinder model, int kind, double[] out, long capacity, LongByReference count);

    static native int cylfuse_fitter_point_weights(
            Pointer fitter, double[] weights, byte[] inliers, long capacity, LongByReference count);

    static native int cylfuse_fitter_point_parts(
            Pointer fitter, NativeStructs.Cylinder model, byte[] parts, long capacity, LongByReference count);

    static native int cylfuse_fit_all(
            Pointer fitters, long count, int threads, FitEndedCallback callback, Pointer userData, int[] statuses);

    static native int cylfuse_fitter_limbs(Pointer fitter, Pointer out, long elementSize, long capacity, LongByReference count);

    static native int cylfuse_fitter_limb_samples(Pointer fitter, Pointer out, long elementSize, long capacity, LongByReference count);

    static native int cylfuse_fitter_end_samples(
            Pointer fitter,
            NativeStructs.Cylinder model,
            NativeStructs.MaskView mask,
            Pointer out,
            long elementSize,
            long capacity,
            LongByReference count);

    static native int cylfuse_fitter_diagnose(
            Pointer fitter, NativeStructs.Cylinder model, NativeStructs.CylinderDiagnosis diagnosis);

    static native int cylfuse_fitter_complete_bound(
            Pointer fitter, NativeStructs.MaskView mask, int layout, LongByReference capacity);

    static native int cylfuse_fitter_complete(
            Pointer fitter,
            NativeStructs.Cylinder model,
            NativeStructs.MaskView mask,
            int layout,
            NativeStructs.PointsOut out,
            NativeStructs.Completion completion);

    static native int cylfuse_fitter_complete_depth(
            Pointer fitter,
            NativeStructs.Cylinder model,
            NativeStructs.MaskView mask,
            NativeStructs.DepthOut out,
            NativeStructs.Completion completion);

    static native int cylfuse_fitter_extent(
            Pointer fitter, NativeStructs.Cylinder model, NativeStructs.MaskView mask, NativeStructs.Extent extent);

    static native int cylfuse_fitter_select_edges(
            Pointer fitter,
            NativeStructs.Cylinder model,
            NativeStructs.SegmentsView segments,
            double reach,
            byte[] limbs,
            long capacity);

    static native int cylfuse_frame_create(int abiVersion, PointerByReference frame);

    static native int cylfuse_frame_destroy(Pointer frame);

    static native String cylfuse_frame_last_error(Pointer frame);

    static native int cylfuse_frame_set_intrinsics(Pointer frame, NativeStructs.Intrinsics intrinsics);

    static native int cylfuse_frame_set_pose(Pointer frame, double[] rotation, double[] translation);

    static native int cylfuse_frame_set_depth_camera(
            Pointer frame, NativeStructs.Intrinsics intrinsics, double[] rotation, double[] translation);

    static native int cylfuse_frame_set_depth(Pointer frame, NativeStructs.DepthView depth);

    static native int cylfuse_frame_set_image(Pointer frame, NativeStructs.ImageView image);

    static native int cylfuse_detector_create(int abiVersion, PointerByReference detector);

    static native int cylfuse_detector_destroy(Pointer detector);

    static native String cylfuse_detector_last_error(Pointer detector);

    static native int cylfuse_detector_cancel(Pointer detector);

    static native int cylfuse_detector_set_options(Pointer detector, NativeStructs.DetectorOptions options);

    static native int cylfuse_detector_get_options(Pointer detector, NativeStructs.DetectorOptions options);

    static native int cylfuse_detector_set_fit_options(Pointer detector, NativeStructs.Options options);

    static native int cylfuse_detector_get_fit_options(Pointer detector, NativeStructs.Options options);

    static native int cylfuse_detector_set_progress(Pointer detector, DetectionProgressCallback callback, Pointer userData);

    static native int cylfuse_detector_detect(Pointer detector, Pointer frame);

    static native int cylfuse_detector_detect_points(Pointer detector, NativeStructs.PointsView points);

    static native int cylfuse_detector_count(Pointer detector, LongByReference count);

    static native int cylfuse_detector_is_complete(Pointer detector, IntByReference complete);

    static native int cylfuse_detector_depth_moved(Pointer detector, IntByReference columns, IntByReference rows);

    static native int cylfuse_detector_detections(
            Pointer detector, Pointer out, long elementSize, long capacity, LongByReference count);

    static native int cylfuse_detector_get_result(Pointer detector, long index, NativeStructs.Result result);

    static native int cylfuse_detector_get_cylinder(Pointer detector, long index, NativeStructs.CylinderEstimate estimate);

    static native int cylfuse_detector_get_extent(Pointer detector, long index, NativeStructs.Extent extent);

    static native int cylfuse_detector_labels(Pointer detector, short[] out, long capacity, LongByReference count);

    static native int cylfuse_detector_indices(Pointer detector, long index, int[] out, long capacity, LongByReference count);

    static native int cylfuse_detector_make_fitter(Pointer detector, long index, PointerByReference fitter);

    static native int cylfuse_intrinsics_project(
            NativeStructs.Intrinsics intrinsics, NativeStructs.PointsView points, double[] pixels, long capacity);

    static native int cylfuse_intrinsics_unproject(
            NativeStructs.Intrinsics intrinsics, double[] pixels, long count, double[] rays);

    static native int cylfuse_cylinder_distances(
            NativeStructs.Cylinder model, NativeStructs.PointsView points, double[] out, long capacity);

    static native int cylfuse_cylinder_project(
            NativeStructs.Cylinder model, NativeStructs.Intrinsics intrinsics, double[] lines);

    static native int cylfuse_plan(
            NativeStructs.Intrinsics intrinsics, double[] cylinder, double[] noise, double[] scatter, double[] total);

    static native int cylfuse_decide_conformity(
            double value,
            double deviation,
            int flags,
            double lower,
            double upper,
            double coverage,
            IntByReference conformity);

    static native int cylfuse_cylinder_compare(
            NativeStructs.Cylinder a,
            NativeStructs.Cylinder b,
            DoubleByReference angle,
            DoubleByReference axisDistance,
            DoubleByReference radiusRelative);

    /** Throws for a failed call without a handle. */
    static void check(int status) {
        if (status != 0) {
            throw CylfuseException.of(Status.of(status), cylfuse_fitter_last_error(null));
        }
    }

    /** A struct after its init function, which comes before everything else. */
    static <T extends Structure> T initialised(T struct, ToIntBiFunction<T, Long> init) {
        check(init.applyAsInt(struct, (long) struct.size()));
        return struct;
    }

    /** The rows of a square matrix. */
    static double[][] square(double[] numbers, int size) {
        double[][] rows = new double[size][size];
        for (int row = 0; row < size; row++) {
            System.arraycopy(numbers, size * row, rows[row], 0, size);
        }
        return rows;
    }
}
