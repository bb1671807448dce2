package org.cylfuse;

/**
 * What the data determine at a cylinder: the singular values of the stacked Jacobian of the five degrees of freedom, in
 * units of the size of the data.
 *
 * @param rank How many singular values stand out of the rounding error; 5 when everything is determined.
 * @param singularValues Singular values, the largest first.
 * @param condition Largest over smallest singular value; may be infinite.
 * @param weakestShift The step along which the residuals change least: how it moves the axis at the middle of the
 *     points, in the unit of length. Shift and radius over the size of the data and the tilt have a joint norm of 1.
 * @param weakestTilt How that step tilts the axis, in radians towards this vector.
 * @param weakestRadius How that step changes the radius, in the unit of length.
 */
public record Diagnosis(
        int rank,
        double[] singularValues,
        double condition,
        Vector weakestShift,
        Vector weakestTilt,
        double weakestRadius) {
    static Diagnosis of(NativeStructs.CylinderDiagnosis n) {
        return new Diagnosis(
                n.rank,
                n.singular_values.clone(),
                n.condition,
                Vector.of(n.weakest_shift),
                Vector.of(n.weakest_tilt),
                n.weakest_radius);
    }
}
