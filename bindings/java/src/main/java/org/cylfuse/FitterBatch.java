package org.cylfuse;

import com.sun.jna.Memory;
import com.sun.jna.Native;
import com.sun.jna.Pointer;
import java.util.List;
import java.util.stream.IntStream;

/** Many fits at once. */
public final class FitterBatch {
    private FitterBatch() {}

    /**
     * Fits many fitters, several at once, each as {@link Fitter#fit()} does. The results stay in the fitters, for {@link
     * Fitter#result()} and all else that can be asked of a fit. The listeners of the fitters are not called.
     *
     * @param fitters the fitters, each once
     * @param threads how many fits run at the same time, 0 for as many as the machine has processors; the results have
     *     the same bits for any number
     * @param listener is called after each fit, on this thread, and may stop the rest; null for none. What it throws
     *     comes out of this method.
     * @return why each fit failed, in the order of the fitters; null for one that succeeded. One that is in another call
     *     has BUSY. Where the listener stopped the rest, those that had not ended have CANCELLED.
     * @throws CylfuseException INVALID_ARGUMENT for a fitter that is there twice
     * @throws IllegalArgumentException for a fitter that is null
     */
    public static CylfuseException[] fitAll(List<Fitter> fitters, int threads, FitEndedListener listener) {
        if (threads < 0) {
            throw new IllegalArgumentException("threads is " + threads + "; it must be 0 or greater");
        }
        Pointer[] handles = new Pointer[fitters.size()];
        int[] statuses = new int[handles.length];
        CylfuseException[] failures = new CylfuseException[handles.length];
        List<NativeHandle> every = IntStream.range(0, handles.length).mapToObj(k -> handle(fitters, k)).toList();
        NativeHandle.runAll(every, handles, () -> {
            Memory list = new Memory(Math.max(1, (long) handles.length * Native.POINTER_SIZE));
            list.write(0, handles, 0, handles.length);
            NativeFunctions.FitEndedCallback callback = (index, status, userData) -> {
                try {
                    return listener.onEnd(Math.toIntExact(index), Status.of(status)) ? 0 : 1;
                } catch (Throwable failure) {
                    NativeHandle.keep(failure);
                    return 1;
                }
            };
            int status = NativeFunctions.cylfuse_fit_all(
                    list, handles.length, threads, listener == null ? null : callback, null, statuses);
            if (status != Status.OK.value() && status != Status.CANCELLED.value()) {
                return status;
            }
            for (int k = 0; k < statuses.length; k++) {
                if (statuses[k] != Status.OK.value()) {
                    String text = NativeFunctions.cylfuse_fitter_last_error(handles[k]);
                    failures[k] = CylfuseException.of(Status.of(statuses[k]), text);
                }
            }
            return Status.OK.value();
        });
        return failures;
    }

    private static NativeHandle handle(List<Fitter> fitters, int index) {
        Fitter fitter = fitters.get(index);
        if (fitter == null) {
            throw new IllegalArgumentException("fitters[" + index + "] is null; it must be a fitter");
        }
        return fitter.calls.handle;
    }
}
