package org.cylfuse;

import com.sun.jna.Memory;
import com.sun.jna.ptr.LongByReference;

/** The calls that write points or depths into native memory. */
final class Completing {
    private Completing() {}

    /** What a completion wrote, and its size in points or pixels. */
    record CompletedMemory(Memory memory, int width, int height, Completion pixels) {}

    static CompletedMemory cloud(
            FitterCalls calls, int scalar, Layout layout, Cylinder model, Mask mask, NativeCopies copies) {
        NativeStructs.Cylinder n = Cylinder.toNative(model);
        NativeStructs.MaskView region = Mask.toNative(mask, copies);
        NativeStructs.PointsOut target = new NativeStructs.PointsOut();
        NativeFunctions.check(NativeFunctions.cylfuse_points_out_init(target, target.size()));
        NativeStructs.Completion completion = new NativeStructs.Completion();
        completion.struct_size = completion.size();
        CompletedMemory[] points = new CompletedMemory[1];
        calls.run(fitter -> {
            LongByReference capacity = new LongByReference();
            int status = NativeFunctions.cylfuse_fitter_complete_bound(fitter, region, layout.value(), capacity);
            if (status != Status.OK.value()) {
                return status;
            }
            int size = scalar == Formats.SCALAR_F64 ? Double.BYTES : Float.BYTES;
            Memory memory = copies.allocate(3 * size * capacity.getValue());
            target.scalar = scalar;
            target.data = memory;
            target.capacity = capacity.getValue();
            target.layout = layout.value();
            status = NativeFunctions.cylfuse_fitter_complete(fitter, n, region, target, completion);
            if (status == Status.OK.value()) {
                boolean organised = layout == Layout.ORGANISED;
                points[0] = new CompletedMemory(
                        memory,
                        organised ? calls.camera().width() : Math.toIntExact(completion.count),
                        organised ? calls.camera().height() : 1,
                        Completion.of(completion));
            }
            return status;
        });
        return points[0];
    }

    static CompletedMemory depth(
            FitterCalls calls, int format, double scale, Cylinder model, Mask mask, NativeCopies copies) {
        NativeStructs.Cylinder n = Cylinder.toNative(model);
        NativeStructs.MaskView region = Mask.toNative(mask, copies);
        NativeStructs.DepthOut target = new NativeStructs.DepthOut();
        NativeFunctions.check(NativeFunctions.cylfuse_depth_out_init(target, target.size()));
        NativeStructs.Completion completion = new NativeStructs.Completion();
        completion.struct_size = completion.size();
        CompletedMemory[] image = new CompletedMemory[1];
        calls.run(fitter -> {
            // Without a camera the image has no size; the library then says what is missing.
            int width = calls.camera() == null ? 0 : calls.camera().width();
            int height = calls.camera() == null ? 0 : calls.camera().height();
            int pixelBytes = format == Formats.DEPTH_F32 ? Float.BYTES : Short.BYTES;
            Memory memory = copies.allocate((long) pixelBytes * width * height);
            target.format = format;
            target.data = memory;
            target.width = width;
            target.height = height;
            target.scale = scale;
            int status = NativeFunctions.cylfuse_fitter_complete_depth(fitter, n, region, target, completion);
            if (status == Status.OK.value()) {
                image[0] = new CompletedMemory(memory, width, height, Completion.of(completion));
            }
            return status;
        });
        return image[0];
    }
}
