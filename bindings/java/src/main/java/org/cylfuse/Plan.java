package org.cylfuse;

import java.util.Objects;

/**
 * A cylinder with the middle of its axis on the optical axis, of which a camera will take measurements. Lengths are in metres,
 * angles in radians.
 *
 * @param distance from the camera to the middle of the axis
 * @param radius the radius
 * @param length the length
 * @param tilt the angle of the axis out of the plane of the image
 * @param turn the angle of the axis in the image from the vertical
 */
public record Plan(double distance, double radius, double length, double tilt, double turn) {
    /**
     * Standard deviations of what is measured of a cylinder.
     *
     * @param radius of the radius in metres
     * @param direction of the direction of the axis in radians, in the plane in which it is least certain
     * @param position of the position of the axis across itself in metres, in the direction in which it is least certain
     * @param length of the length in metres; NaN where an end lies outside the image
     */
    public record Deviations(double radius, double direction, double position, double length) {
        private static Deviations of(double[] numbers) {
            return new Deviations(numbers[0], numbers[1], numbers[2], numbers[3]);
        }
    }

    /**
     * What is to be expected of measurements.
     *
     * @param scatter how much captures of one scene scatter
     * @param total how far a measurement is off: what a fit states
     */
    public record Expectation(Deviations scatter, Deviations total) {}

    /**
     * The standard deviations to be expected with structured light and an ordinary image.
     *
     * @param intrinsics the camera
     * @return the standard deviations
     * @throws CylfuseException INVALID_ARGUMENT, INVALID_INTRINSICS, TOO_FEW_POINTS when the pixels that see the cylinder are
     *     worth fewer than 8 points with independent noise, NUMERICAL where the view does not determine it
     */
    public Expectation expect(Intrinsics intrinsics) {
        return expected(intrinsics, null);
    }

    /**
     * The standard deviations to be expected with other noise.
     *
     * @param intrinsics the camera
     * @param noise six numbers: a, b, c of the noise of depth a + b z + c z² at the depth z; the side of the squares of pixels
     *     that share it, at least 1; the noise of a pixel of the image as a part of the step of brightness at limbs and ends;
     *     the blur of the image in pixels
     * @return the standard deviations
     * @throws CylfuseException INVALID_ARGUMENT, INVALID_INTRINSICS, TOO_FEW_POINTS when the pixels that see the cylinder are
     *     worth fewer than 8 points with independent noise, NUMERICAL where the view does not determine it
     */
    public Expectation expect(Intrinsics intrinsics, double[] noise) {
        if (Objects.requireNonNull(noise, "noise").length != 6) {
            throw new IllegalArgumentException("the noise has " + noise.length + " numbers; it must have 6");
        }
        return expected(intrinsics, noise);
    }

    private Expectation expected(Intrinsics intrinsics, double[] noise) {
        Objects.requireNonNull(intrinsics, "intrinsics");
        double[] cylinder = {distance, radius, length, tilt, turn};
        double[] scatter = new double[4];
        double[] total = new double[4];
        NativeFunctions.check(NativeFunctions.cylfuse_plan(intrinsics.toNative(), cylinder, noise, scatter, total));
        return new Expectation(Deviations.of(scatter), Deviations.of(total));
    }
}
