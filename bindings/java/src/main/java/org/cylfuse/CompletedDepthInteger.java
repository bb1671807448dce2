package org.cylfuse;

/**
 * The depth image of a completion in integers.
 *
 * @param depth the pixels row by row, unsigned; 0 where there is no depth
 * @param width columns
 * @param height rows
 * @param pixels what became of the pixels
 */
public record CompletedDepthInteger(short[] depth, int width, int height, Completion pixels) {}
