package org.cylfuse;

/**
 * An image of the numbers of cylinders.
 *
 * @param width Columns of the colour image or of the cloud.
 * @param height Rows; 1 for a cloud that is not organised.
 * @param numbers Row by row, 1 for the first detection and so on; 0 = none.
 */
public record Labels(int width, int height, int[] numbers) {}
