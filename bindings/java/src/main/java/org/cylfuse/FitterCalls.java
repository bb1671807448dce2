package org.cylfuse;

import com.sun.jna.Pointer;
import com.sun.jna.ptr.PointerByReference;
import java.util.ArrayList;
import java.util.List;
import java.util.function.ToIntBiFunction;
import java.util.function.ToIntFunction;

/** The native fitter with its callbacks, and the cameras of its views. */
final class FitterCalls {
    final NativeHandle handle;
    // Fields, because the library keeps these functions and the garbage collector does not know that.
    private final NativeFunctions.ProgressCallback nativeProgress = this::onProgress;
    private final NativeFunctions.LogCallback nativeLog = this::onLine;
    private volatile ProgressListener progress;
    private volatile LogListener log;
    private final List<Intrinsics> cameras = new ArrayList<>();
    private int selected;

    /**
     * @param create makes the native fitter
     * @param camera that of the first view; null when there is none
     */
    FitterCalls(ToIntBiFunction<Integer, PointerByReference> create, Intrinsics camera) {
        handle = new NativeHandle(
                "fitter", create, NativeFunctions::cylfuse_fitter_destroy, NativeFunctions::cylfuse_fitter_last_error);
        cameras.add(camera);
    }

    /** Knows the cameras of another fitter. */
    synchronized void setCamerasOf(FitterCalls other) {
        synchronized (other) {
            cameras.clear();
            cameras.addAll(other.cameras);
            selected = other.selected;
        }
    }

    /** Runs one call. */
    void run(ToIntFunction<Pointer> body) {
        handle.run(body);
    }

    /** The camera of the selected view; null when there is none. */
    synchronized Intrinsics camera() {
        return cameras.get(selected);
    }

    synchronized void setCamera(Intrinsics camera) {
        cameras.set(selected, camera);
    }

    synchronized void selectView(int index) {
        if (index == cameras.size()) {
            cameras.add(null);
        }
        selected = index;
    }

    synchronized void keepFirstView() {
        cameras.subList(1, cameras.size()).clear();
        selected = 0;
    }

    void setProgressListener(ProgressListener listener) {
        run(fitter -> NativeFunctions.cylfuse_fitter_set_progress(fitter, listener == null ? null : nativeProgress, null));
        progress = listener;
    }

    void setLogListener(LogLevel maxLevel, LogListener listener) {
        run(fitter ->
                NativeFunctions.cylfuse_fitter_set_log(fitter, maxLevel.value(), listener == null ? null : nativeLog, null));
        log = listener;
    }

    private int onProgress(Pointer address, Pointer userData) {
        try {
            NativeStructs.Progress n = new NativeStructs.Progress(address);
            n.read();
            ProgressListener listener = progress;
            return listener == null || listener.onProgress(Progress.of(n)) ? 0 : 1;
        } catch (Throwable failure) {
            NativeHandle.keep(failure);
            return 1;
        }
    }

    private void onLine(int level, String message, Pointer userData) {
        try {
            LogListener listener = log;
            if (listener != null) {
                listener.onLine(NativeNumber.find(LogLevel.class, level), message);
            }
        } catch (Throwable failure) {
            NativeHandle.keep(failure);
        }
    }
}
