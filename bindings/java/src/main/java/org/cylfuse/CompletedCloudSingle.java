package org.cylfuse;

/**
 * The points of a completion in single precision.
 *
 * @param coordinates x, y, z of one point after the other, in the reference frame: only the points that exist when
 *     packed, one for each pixel of the image and NaN where there is none when organised
 * @param width columns of the image when organised, else the number of points
 * @param height rows of the image when organised, else 1
 * @param pixels what became of the pixels
 */
public record CompletedCloudSingle(float[] coordinates, int width, int height, Completion pixels) {}
