package org.cylfuse;

/**
 * How two cylinders differ.
 *
 * @param angle angle between the axes in radians, in [0, π/2], whatever the signs of the directions
 * @param axisDistance shortest distance between the two axes, in the unit of length
 * @param radiusRelative (radius of the second - radius of the first) / radius of the first
 */
public record CylinderDifference(double angle, double axisDistance, double radiusRelative) {}
