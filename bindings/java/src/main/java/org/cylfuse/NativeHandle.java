package org.cylfuse;

import com.sun.jna.Pointer;
import com.sun.jna.ptr.PointerByReference;
import java.util.List;
import java.util.function.Function;
import java.util.function.IntSupplier;
import java.util.function.Supplier;
import java.util.function.ToIntBiFunction;
import java.util.function.ToIntFunction;

/**
 * Owns a native fitter, frame or detector, runs its calls and turns failures into exceptions. Destroys it when it is closed and
 * no call on it is running. Has no way back to its owner. Calls may run side by side; the library says which exclude
 * each other.
 */
final class NativeHandle {
    // The library calls back on the thread of the call, and keeps its messages by thread.
    private static final ThreadLocal<Throwable[]> LISTENER_FAILURE = new ThreadLocal<>();

    private final String owner;
    private final ToIntFunction<Pointer> destroy;
    private final Function<Pointer, String> lastError;
    private final Pointer pointer;
    private int calls;
    private boolean closed;

    /**
     * @param owner what is owned, for messages
     * @param create makes the native object
     * @param destroy frees it
     * @param lastError says why the last call on it failed
     */
    NativeHandle(
            String owner,
            ToIntBiFunction<Integer, PointerByReference> create,
            ToIntFunction<Pointer> destroy,
            Function<Pointer, String> lastError) {
        this.owner = owner;
        this.destroy = destroy;
        this.lastError = lastError;
        PointerByReference created = new PointerByReference();
        NativeFunctions.check(create.applyAsInt(NativeFunctions.ABI_VERSION, created));
        pointer = created.getValue();
    }

    /** Runs one call. */
    void run(ToIntFunction<Pointer> body) {
        Pointer object = acquire();
        try {
            run(() -> body.applyAsInt(object), () -> lastError.apply(object));
        } finally {
            release();
        }
    }

    /** Runs one call on several, which are written to {@code pointers}. */
    static void runAll(List<NativeHandle> handles, Pointer[] pointers, IntSupplier body) {
        int held = 0;
        try {
            for (; held < pointers.length; held++) {
                pointers[held] = handles.get(held).acquire();
            }
            run(body, () -> NativeFunctions.cylfuse_fitter_last_error(null));
        } finally {
            while (held > 0) {
                handles.get(--held).release();
            }
        }
    }

    private static void run(IntSupplier body, Supplier<String> lastError) {
        Throwable[] outer = LISTENER_FAILURE.get();
        Throwable[] failure = new Throwable[1];
        LISTENER_FAILURE.set(failure);
        try {
            int status = body.getAsInt();
            if (failure[0] != null) {
                NativeHandle.<RuntimeException>rethrow(failure[0]);
            }
            if (status != Status.OK.value()) {
                throw CylfuseException.of(Status.of(status), lastError.get());
            }
        } finally {
            LISTENER_FAILURE.set(outer);
        }
    }

    /** Keeps what a listener threw for the end of the call of this thread: nothing may pass through the library. */
    static void keep(Throwable failure) {
        Throwable[] kept = LISTENER_FAILURE.get();
        if (kept != null && kept[0] == null) {
            kept[0] = failure;
        }
    }

    /** Throws what a listener threw, which may be checked: languages other than Java do not declare what they throw. */
    @SuppressWarnings("unchecked")
    private static <T extends Throwable> void rethrow(Throwable failure) throws T {
        throw (T) failure;
    }

    private synchronized Pointer acquire() {
        if (closed) {
            throw new IllegalStateException("The " + owner + " is closed.");
        }
        calls++;
        return pointer;
    }

    private synchronized void release() {
        calls--;
        destroyWhenIdle();
    }

    synchronized void close() {
        if (!closed) {
            closed = true;
            destroyWhenIdle();
        }
    }

    private void destroyWhenIdle() {
        if (closed && calls == 0) {
            destroy.applyAsInt(pointer);
        }
    }
}
