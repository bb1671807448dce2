package org.cylfuse;

import com.sun.jna.Pointer;
import java.util.Objects;
import java.util.concurrent.atomic.AtomicBoolean;
import java.util.function.ToIntFunction;

/** Runs the calls of one fitter, one at a time, and turns failures into exceptions. Keeps what its callbacks need. */
final class FitterCalls {
    final FitterHandle handle = new FitterHandle();
    private final AtomicBoolean busy = new AtomicBoolean();
    // Fields, because the library keeps these functions and the garbage collector does not know that.
    private final NativeFunctions.ProgressCallback nativeProgress = this::onProgress;
    private final NativeFunctions.LogCallback nativeLog = this::onLine;
    private ProgressListener progress;
    private LogListener log;
    private Throwable listenerFailure;
    private Intrinsics camera;

    /** The camera that was set last; null when there is none. Asked for during a call. */
    Intrinsics camera() {
        return camera;
    }

    void setCamera(Intrinsics intrinsics) {
        Objects.requireNonNull(intrinsics, "camera");
        NativeStructs.Intrinsics n = intrinsics.toNative();
        run(fitter -> {
            int status = NativeFunctions.cylfuse_fitter_set_intrinsics(fitter, n);
            if (status == Status.OK.value()) {
                camera = intrinsics;
            }
            return status;
        });
    }

    void setProgressListener(ProgressListener listener) {
        run(fitter -> {
            progress = listener;
            return NativeFunctions.cylfuse_fitter_set_progress(fitter, listener == null ? null : nativeProgress, null);
        });
    }

    void setLogListener(LogLevel maxLevel, LogListener listener) {
        int level = Objects.requireNonNull(maxLevel, "maxLevel").value();
        run(fitter -> {
            log = listener;
            return NativeFunctions.cylfuse_fitter_set_log(fitter, level, listener == null ? null : nativeLog, null);
        });
    }

    /** Runs one call; holds the fitter until its message has been read, before another call replaces it. */
    void run(ToIntFunction<Pointer> body) {
        Pointer fitter = handle.acquire();
        try {
            if (!busy.compareAndSet(false, true)) {
                throw CylfuseException.of(Status.BUSY, Library.statusText(Status.BUSY));
            }
            try {
                listenerFailure = null;
                int status = body.applyAsInt(fitter);
                if (listenerFailure != null) {
                    FitterCalls.<RuntimeException>rethrow(listenerFailure);
                }
                if (status != Status.OK.value()) {
                    String message = NativeFunctions.cylfuse_fitter_last_error(fitter);
                    Status kind = Status.of(status);
                    throw CylfuseException.of(kind, message.isEmpty() ? NativeFunctions.cylfuse_status_string(status) : message);
                }
            } finally {
                busy.set(false);
            }
        } finally {
            handle.release();
        }
    }

    /** Throws what a listener threw, which may be checked: languages other than Java do not declare what they throw. */
    @SuppressWarnings("unchecked")
    private static <T extends Throwable> void rethrow(Throwable failure) throws T {
        throw (T) failure;
    }

    // No exception may pass through the library.
    private int onProgress(Pointer address, Pointer userData) {
        try {
            NativeStructs.Progress n = new NativeStructs.Progress(address);
            n.read();
            return progress.onProgress(Progress.of(n)) ? 0 : 1;
        } catch (Throwable failure) {
            listenerFailure = failure;
            return 1;
        }
    }

    private void onLine(int level, String message, Pointer userData) {
        try {
            log.onLine(NativeNumber.find(LogLevel.class, level), message);
        } catch (Throwable failure) {
            if (listenerFailure == null) {
                listenerFailure = failure;
            }
        }
    }
}
