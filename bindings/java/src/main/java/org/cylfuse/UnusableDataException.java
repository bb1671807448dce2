package org.cylfuse;

/**
 * The data do not determine a cylinder: too few points, flat points, no depth in the mask and the like. In a loop over
 * frames the reason to leave one out; every other failure is one of the program.
 */
public final class UnusableDataException extends CylfuseException {
    private static final long serialVersionUID = 1;

    UnusableDataException(Status status, String message) {
        super(status, message);
    }
}
