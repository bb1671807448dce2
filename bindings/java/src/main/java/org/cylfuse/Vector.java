package org.cylfuse;

/**
 * Three numbers: a point or a direction. Camera frame: x to the right, y down, z forward.
 *
 * @param x the x coordinate
 * @param y the y coordinate
 * @param z the z coordinate
 */
public record Vector(double x, double y, double z) {
    static Vector of(double[] numbers) {
        return new Vector(numbers[0], numbers[1], numbers[2]);
    }

    double[] toArray() {
        return new double[] {x, y, z};
    }
}
