package org.cylfuse;

/**
 * The depth image of a completion.
 *
 * @param depth the pixels row by row; 0 where there is no depth
 * @param width columns
 * @param height rows
 * @param pixels what became of the pixels
 */
public record CompletedDepth(float[] depth, int width, int height, Completion pixels) {}
