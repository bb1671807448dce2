package org.cylfuse;

/** Arrays of rows. */
final class Rows {
    private Rows() {}

    static double[] flatten(String what, double[][] rows, int columns) {
        double[] flat = new double[rows.length * columns];
        for (int row = 0; row < rows.length; row++) {
            if (rows[row].length != columns) {
                throw new IllegalArgumentException(
                        "The " + what + " " + row + " has " + rows[row].length + " numbers; it must have " + columns + ".");
            }
            System.arraycopy(rows[row], 0, flat, columns * row, columns);
        }
        return flat;
    }
}
