package org.cylfuse;

import com.sun.jna.Memory;
import com.sun.jna.Pointer;
import com.sun.jna.ptr.LongByReference;
import java.util.function.ToIntFunction;

/** A completion, whose points or depths are written into native memory. */
final class Completing {
    private final FitterCalls calls;
    private final NativeStructs.Cylinder model;
    private final NativeStructs.MaskView region;
    private final NativeCopies copies;
    private final NativeStructs.Completion completion =
            NativeFunctions.initialised(new NativeStructs.Completion(), NativeFunctions::cylfuse_completion_init);
    private Memory memory;

    Completing(FitterCalls calls, Cylinder model, Mask mask, NativeCopies copies) {
        this.calls = calls;
        this.model = Cylinder.toNative(model);
        this.region = Mask.toNative(mask, copies);
        this.copies = copies;
    }

    /** What a completion wrote, and its size in points or pixels. */
    record CompletedMemory(Memory memory, int width, int height, Completion pixels) {}

    CompletedMemory cloud(int scalar, Layout layout) {
        NativeStructs.PointsOut target =
                NativeFunctions.initialised(new NativeStructs.PointsOut(), NativeFunctions::cylfuse_points_out_init);
        target.scalar = scalar;
        return run(layout == Layout.ORGANISED, fitter -> {
            LongByReference capacity = new LongByReference();
            int status = NativeFunctions.cylfuse_fitter_complete_bound(fitter, region, layout.value(), capacity);
            if (status != Status.OK.value()) {
                return status;
            }
            memory = copies.allocate(3 * (scalar == Formats.SCALAR_F64 ? Double.BYTES : Float.BYTES) * capacity.getValue());
            target.data = memory;
            target.capacity = capacity.getValue();
            return NativeFunctions.cylfuse_fitter_complete(fitter, model, region, layout.value(), target, completion);
        });
    }

    CompletedMemory depth(int format, double scale) {
        NativeStructs.DepthOut target =
                NativeFunctions.initialised(new NativeStructs.DepthOut(), NativeFunctions::cylfuse_depth_out_init);
        target.format = format;
        target.scale = scale;
        return run(true, fitter -> {
            // Without a camera the image has no size; the library then says what is missing.
            target.width = calls.camera() == null ? 0 : calls.camera().width();
            target.height = calls.camera() == null ? 0 : calls.camera().height();
            int pixelBytes = format == Formats.DEPTH_F32 ? Float.BYTES : Short.BYTES;
            memory = copies.allocate((long) pixelBytes * target.width * target.height);
            target.data = memory;
            return NativeFunctions.cylfuse_fitter_complete_depth(fitter, model, region, target, completion);
        });
    }

    /** @param image whether an image of the camera is written, else a list */
    private CompletedMemory run(boolean image, ToIntFunction<Pointer> call) {
        CompletedMemory[] completed = new CompletedMemory[1];
        calls.run(fitter -> {
            int status = call.applyAsInt(fitter);
            if (status == Status.OK.value()) {
                // During the call: another one may set another camera.
                int width = image ? calls.camera().width() : Math.toIntExact(completion.count);
                completed[0] = new CompletedMemory(
                        memory, width, image ? calls.camera().height() : 1, Completion.of(completion));
            }
            return status;
        });
        return completed[0];
    }
}
