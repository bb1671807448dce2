package org.cylfuse;

/** Facts about the loaded native library. */
public final class Library {
    private Library() {}

    /**
     * The version of the binary interface.
     *
     * @return the version
     */
    public static int abiVersion() {
        return NativeFunctions.cylfuse_abi_version();
    }

    /**
     * The version as text.
     *
     * @return a text such as "0.2.0"
     */
    public static String versionString() {
        return NativeFunctions.cylfuse_version_string();
    }

    /**
     * The version as a number.
     *
     * @return major * 65536 + minor * 256 + patch
     */
    public static int versionNumber() {
        return NativeFunctions.cylfuse_version_number();
    }

    /**
     * How the library was built, for reports of defects.
     *
     * @return version, target, profile, compiler, features
     */
    public static String buildInfo() {
        return NativeFunctions.cylfuse_build_info();
    }

    /**
     * What a status means.
     *
     * @param status the status
     * @return its name, a colon, and what it means in a few words
     */
    public static String statusText(Status status) {
        return NativeFunctions.cylfuse_status_string(status.value());
    }
}
