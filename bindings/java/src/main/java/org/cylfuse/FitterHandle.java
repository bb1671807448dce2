package org.cylfuse;

import com.sun.jna.Pointer;
import com.sun.jna.ptr.PointerByReference;

/** Owns a native fitter and destroys it when it is closed and no call on it is running. Has no way back to its Fitter. */
final class FitterHandle {
    private final Pointer fitter;
    private int calls;
    private boolean closed;

    FitterHandle() {
        PointerByReference created = new PointerByReference();
        NativeFunctions.check(NativeFunctions.cylfuse_fitter_create(NativeFunctions.ABI_VERSION, created));
        fitter = created.getValue();
    }

    /** The fitter for one call; {@link #release()} comes after it. */
    synchronized Pointer acquire() {
        if (closed) {
            throw new IllegalStateException("The fitter is closed.");
        }
        calls++;
        return fitter;
    }

    synchronized void release() {
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
            NativeFunctions.cylfuse_fitter_destroy(fitter);
        }
    }
}
