package org.cylfuse;

/** A constant with a number in the C interface. */
interface NativeNumber {
    int value();

    /** The constant of a number that the library gave. */
    static <E extends Enum<E> & NativeNumber> E find(Class<E> type, int value) {
        for (E candidate : type.getEnumConstants()) {
            if (candidate.value() == value) {
                return candidate;
            }
        }
        throw new IllegalStateException("The native library gave " + type.getSimpleName() + " " + value
                + ", which this package does not know: the library is newer. Use those that belong together.");
    }
}
