package org.cylfuse;

/** A small rendered view of a cylinder: 96 × 80 pixels, radius 0.1, axis tilted in the image and in depth. */
final class Scene {
    static final int WIDTH = 96;
    static final int HEIGHT = 80;
    static final Cylinder TRUTH = new Cylinder(new Vector(0.01, -0.02, 1.0), unit(0.2, 0.95, 0.24), 0.1);
    static final Intrinsics CAMERA = new Intrinsics(WIDTH, HEIGHT, 150, 150, 47.5, 39.5);

    private Scene() {}

    /** z of the near wall in units of 0.1 mm, 0 where the ray misses or the pixel is near the border. */
    static short[] depth() {
        return depth(TRUTH);
    }

    /** That of a cylinder in the camera frame. */
    static short[] depth(Cylinder cylinder) {
        short[] depth = new short[WIDTH * HEIGHT];
        for (int v = 4; v < HEIGHT - 4; v++) {
            for (int u = 4; u < WIDTH - 4; u++) {
                double z = nearWall(cylinder, (u - CAMERA.cx()) / CAMERA.fx(), (v - CAMERA.cy()) / CAMERA.fy());
                depth[v * WIDTH + u] = (short) Math.round(z / 1e-4);
            }
        }
        return depth;
    }

    static byte[] mask() {
        return mask(TRUTH);
    }

    static byte[] mask(Cylinder cylinder) {
        short[] depth = depth(cylinder);
        byte[] mask = new byte[depth.length];
        for (int k = 0; k < mask.length; k++) {
            mask[k] = (byte) (depth[k] != 0 ? 255 : 0);
        }
        return mask;
    }

    /** Bright on the cylinder, dark beside it. */
    static byte[] grey() {
        byte[] image = mask();
        for (int k = 0; k < image.length; k++) {
            image[k] = (byte) (image[k] != 0 ? 200 : 50);
        }
        return image;
    }

    /** A camera that looks at the cylinder from 30 degrees beside the first one. */
    static final RigidMotion ASIDE = new RigidMotion(
            new double[][] {{Math.sqrt(0.75), 0, 0.5}, {0, 1, 0}, {-0.5, 0, Math.sqrt(0.75)}},
            new Vector(-0.5, 0, 1 - Math.sqrt(0.75)));

    /** The cylinder in the frame of a camera with a pose. */
    static Cylinder seen(RigidMotion pose) {
        Vector t = pose.translation();
        Vector p = TRUTH.point();
        return new Cylinder(
                back(pose.rotation(), new Vector(p.x() - t.x(), p.y() - t.y(), p.z() - t.z())),
                back(pose.rotation(), TRUTH.direction()),
                TRUTH.radius());
    }

    private static Vector back(double[][] r, Vector x) {
        return new Vector(
                r[0][0] * x.x() + r[1][0] * x.y() + r[2][0] * x.z(),
                r[0][1] * x.x() + r[1][1] * x.y() + r[2][1] * x.z(),
                r[0][2] * x.x() + r[1][2] * x.y() + r[2][2] * x.z());
    }

    /** Pushes the depth that a camera with a pose sees into the selected view. */
    static void pushView(Fitter fitter, RigidMotion pose) {
        Cylinder seen = seen(pose);
        fitter.setIntrinsics(CAMERA);
        fitter.setPose(pose);
        fitter.pushDepth(DepthImage.of(depth(seen), WIDTH, HEIGHT, 1e-4), Mask.of(mask(seen), WIDTH, HEIGHT));
    }

    /** The two limb lines between the rows 10 and 70. */
    static double[][] edges() {
        double[][] lines = TRUTH.project(CAMERA);
        double[][] edges = new double[2][];
        for (int k = 0; k < 2; k++) {
            edges[k] = new double[] {
                -(lines[k][1] * 10 + lines[k][2]) / lines[k][0], 10, -(lines[k][1] * 70 + lines[k][2]) / lines[k][0], 70
            };
        }
        return edges;
    }

    /** A fitter with everything pushed. */
    static Fitter loaded() {
        Fitter fitter = new Fitter();
        fitter.setIntrinsics(CAMERA);
        fitter.pushDepth(DepthImage.of(depth(), WIDTH, HEIGHT, 1e-4), Mask.of(mask(), WIDTH, HEIGHT));
        fitter.pushEdges(Segments.of(edges()));
        return fitter;
    }

    /** A quarter of a pipe of radius 0.5 along y. */
    static double[] pipe(int count) {
        double[] points = new double[3 * count];
        for (int k = 0; k < count; k++) {
            points[3 * k] = 0.5 * Math.cos(0.008 * k);
            points[3 * k + 1] = 0.1 * (k % 7);
            points[3 * k + 2] = 2.0 - 0.5 * Math.sin(0.008 * k);
        }
        return points;
    }

    private static double nearWall(Cylinder cylinder, double x, double y) {
        // |(t r - p) × d|² = R² for the ray t r with r = (x, y, 1), so that t is the depth.
        Vector p = cylinder.point();
        Vector d = cylinder.direction();
        double rd = x * d.x() + y * d.y() + d.z();
        double pd = p.x() * d.x() + p.y() * d.y() + p.z() * d.z();
        double a = x * x + y * y + 1 - rd * rd;
        double b = x * p.x() + y * p.y() + p.z() - rd * pd;
        double c = p.x() * p.x() + p.y() * p.y() + p.z() * p.z() - pd * pd - cylinder.radius() * cylinder.radius();
        double discriminant = b * b - a * c;
        return discriminant < 0 ? 0 : (b - Math.sqrt(discriminant)) / a;
    }

    private static Vector unit(double x, double y, double z) {
        double length = Math.sqrt(x * x + y * y + z * z);
        return new Vector(x / length, y / length, z / length);
    }
}
