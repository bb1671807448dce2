package org.cylfuse;

/** Two cylinders before a wall: what a camera sees of them, the same as a cloud, and who is seen where (0 the wall). */
final class Pair {
    static final int WIDTH = 160;
    static final int HEIGHT = 120;
    static final int ALL = WIDTH * HEIGHT;
    static final Intrinsics CAMERA = new Intrinsics(WIDTH, HEIGHT, 170, 170, 79.5, 59.5);
    static final Cylinder[] TRUTHS = {
        new Cylinder(new Vector(-0.12, 0, 0.7), new Vector(0.1, 0.99, 0.1), 0.05),
        new Cylinder(new Vector(0.13, 0.05, 0.8), new Vector(0.9, 0.3, 0.2), 0.035),
    };
    static final double[] LENGTHS = {0.24, 0.2};
    static final float[] DEPTH = new float[ALL];
    static final byte[] GREY = new byte[ALL];
    static final double[] POINTS = new double[3 * ALL];
    static final int[] OWNERS = new int[ALL];

    static {
        int state = 1;
        for (int k = 0; k < ALL; k++) {
            int column = k % WIDTH;
            int row = k / WIDTH;
            OWNERS[k] = owner(column, row);
            GREY[k] = 40;
            for (int ray = 0; ray < 16; ray++) {
                if (owner(column + (ray % 4 - 1.5) / 4, row + (ray / 4 - 1.5) / 4) > 0) {
                    GREY[k] += 10;
                }
            }
            // Errors of up to 1 mm, evenly spread.
            state = state * 1664525 + 1013904223;
            double z = depth(OWNERS[k], column, row) + 0.001 * (Integer.toUnsignedLong(state) / 2147483648.0 - 1);
            DEPTH[k] = (float) z;
            POINTS[3 * k] = z * (column - CAMERA.cx()) / CAMERA.fx();
            POINTS[3 * k + 1] = z * (row - CAMERA.cy()) / CAMERA.fy();
            POINTS[3 * k + 2] = z;
        }
    }

    private Pair() {}

    static PointCloud cloud() {
        return PointCloud.of(java.nio.DoubleBuffer.wrap(POINTS), WIDTH, HEIGHT, 0, 0, 0);
    }

    static Frame frame(boolean withImage) {
        Frame frame = new Frame();
        frame.setIntrinsics(CAMERA);
        frame.setDepth(DepthImage.of(java.nio.FloatBuffer.wrap(DEPTH), WIDTH, HEIGHT, 1, 0, 0, 0));
        if (withImage) {
            frame.setImage(Image.of(java.nio.ByteBuffer.wrap(GREY), WIDTH, HEIGHT, 0, 0, 0));
        }
        return frame;
    }

    private static double dot(Vector a, Vector b) {
        return a.x() * b.x() + a.y() * b.y() + a.z() * b.z();
    }

    private static int owner(double column, double row) {
        int owner = 0;
        for (int k = 1; k <= TRUTHS.length; k++) {
            if (depth(k, column, row) < depth(owner, column, row)) {
                owner = k;
            }
        }
        return owner;
    }

    /** The depth of one of them at a place of the image, NaN where it is not. */
    private static double depth(int owner, double column, double row) {
        Vector ray = new Vector((column - CAMERA.cx()) / CAMERA.fx(), (row - CAMERA.cy()) / CAMERA.fy(), 1);
        if (owner == 0) {
            return 1.2 / (1 + 0.1 * ray.x() - 0.2 * ray.y());
        }
        Vector p = TRUTHS[owner - 1].point();
        Vector d = TRUTHS[owner - 1].direction();
        double radius = TRUTHS[owner - 1].radius();
        double norm = Math.sqrt(dot(d, d));
        double along = dot(ray, d) / norm;
        double middle = dot(p, d) / norm;
        double a = dot(ray, ray) - along * along;
        double b = dot(ray, p) - along * middle;
        double z = (b - Math.sqrt(b * b - a * (dot(p, p) - middle * middle - radius * radius))) / a;
        return Math.abs(z * along - middle) <= LENGTHS[owner - 1] / 2 ? z : Double.NaN;
    }
}
