package org.cylfuse;

/** The numbers of the C interface for element types. */
final class Formats {
    static final int SCALAR_F32 = 1;
    static final int SCALAR_F64 = 2;
    static final int DEPTH_U16 = 1;
    static final int DEPTH_F32 = 2;
    static final int IMAGE_U8 = 1;
    static final int IMAGE_U16 = 2;
    static final int IMAGE_F32 = 3;

    private Formats() {}
}
