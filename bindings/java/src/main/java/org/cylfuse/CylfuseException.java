package org.cylfuse;

/**
 * A call of the library failed. {@link #status()} is the kind; the message names the value, the limit and the remedy. A
 * call that failed has changed nothing.
 *
 * <p>Arrays of a wrong shape give an {@link IllegalArgumentException} before the library is called.
 */
public class CylfuseException extends RuntimeException {
    private static final long serialVersionUID = 1;

    /** The kind of the failure. */
    private final Status status;

    CylfuseException(Status status, String message) {
        super(message);
        this.status = status;
    }

    /** The exception of the class for a status. */
    static CylfuseException of(Status status, String message) {
        boolean data = status.value() <= Status.TOO_FEW_POINTS.value() && status.value() > Status.CANCELLED.value();
        return data ? new UnusableDataException(status, message) : new CylfuseException(status, message);
    }

    /**
     * The kind of the failure.
     *
     * @return the status of the C interface
     */
    public Status status() {
        return status;
    }
}
