package org.cylfuse;

import java.util.Objects;

/** A rotation and a translation: x' = rotation * x + translation. The call that takes it checks the numbers. */
public final class RigidMotion {
    /** The motion that leaves everything where it is. */
    public static final RigidMotion IDENTITY =
            new RigidMotion(new double[][] {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, new Vector(0, 0, 0));

    private final double[] rotation;
    private final Vector translation;

    /**
     * A motion.
     *
     * @param rotation a rotation matrix of 3 rows, to 1e-4, copied
     * @param translation the translation, in the unit of length
     * @throws IllegalArgumentException when the matrix is not 3 x 3
     */
    public RigidMotion(double[][] rotation, Vector translation) {
        Objects.requireNonNull(rotation, "rotation");
        this.translation = Objects.requireNonNull(translation, "translation");
        this.rotation = Rows.flatten("row of the rotation", rotation, 3);
        if (rotation.length != 3) {
            throw new IllegalArgumentException("The rotation has " + rotation.length + " rows; it must have 3.");
        }
    }

    /** {@return a copy of the rotation matrix} */
    public double[][] rotation() {
        return NativeFunctions.square(rotation, 3);
    }

    /** {@return the translation} */
    public Vector translation() {
        return translation;
    }

    /** The rotation, row by row. */
    double[] numbers() {
        return rotation;
    }
}
