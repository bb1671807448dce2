package org.cylfuse;

/** Takes log lines, on the thread of the call. */
@FunctionalInterface
public interface LogListener {
    /**
     * Takes a line. Of the methods of the same fitter only {@link Fitter#cancel()} and {@link Fitter#close()} may be
     * called.
     *
     * @param level how much it matters
     * @param message one line without a line break
     */
    void onLine(LogLevel level, String message);
}
