package org.cylfuse;

import java.util.Arrays;
import java.util.List;
import java.util.Objects;
import java.util.stream.DoubleStream;

/**
 * A camera as a calibration gives it. Pixel centres are at integer coordinates, as in OpenCV. The call that takes it
 * checks the numbers.
 *
 * @param width width of the image in pixels, at least 1
 * @param height height of the image in pixels, at least 1; both together at most 2^28 pixels
 * @param fx focal length in pixel widths, greater than 0
 * @param fy focal length in pixel heights, greater than 0
 * @param cx principal point in pixels from the centre of the first pixel, to the right
 * @param cy principal point in pixels from the centre of the first pixel, down
 * @param distortionModel what the coefficients mean
 * @param distortion at most 8 coefficients in the order of the model
 */
public record Intrinsics(
        int width,
        int height,
        double fx,
        double fy,
        double cx,
        double cy,
        DistortionModel distortionModel,
        double... distortion) {
    private static final int MOST_COEFFICIENTS = 8;

    /**
     * Checks the size and the number of coefficients.
     *
     * @param width width of the image in pixels
     * @param height height of the image in pixels
     * @param fx focal length in pixel widths
     * @param fy focal length in pixel heights
     * @param cx principal point, to the right
     * @param cy principal point, down
     * @param distortionModel what the coefficients mean
     * @param distortion at most 8 coefficients
     * @throws IllegalArgumentException for a negative size or too many coefficients
     */
    public Intrinsics {
        Objects.requireNonNull(distortionModel, "distortionModel");
        Objects.requireNonNull(distortion, "distortion");
        if (width < 0 || height < 0) {
            throw new IllegalArgumentException("An image of " + width + " x " + height + " pixels is none: both must be at least 1.");
        }
        if (distortion.length > MOST_COEFFICIENTS) {
            throw new IllegalArgumentException(
                    "There are " + distortion.length + " coefficients; a distortion model has at most " + MOST_COEFFICIENTS + ".");
        }
        distortion = distortion.clone();
    }

    /** {@return a copy of the coefficients} */
    @Override
    public double[] distortion() {
        return distortion.clone();
    }

    // What a record has by itself would compare the coefficients by the address of their array, and print it.
    @Override
    public boolean equals(Object other) {
        return other instanceof Intrinsics camera && values().equals(camera.values());
    }

    @Override
    public int hashCode() {
        return values().hashCode();
    }

    private List<Object> values() {
        return List.of(width, height, fx, fy, cx, cy, distortionModel, DoubleStream.of(distortion).boxed().toList());
    }

    @Override
    public String toString() {
        return "Intrinsics[width=" + width + ", height=" + height + ", fx=" + fx + ", fy=" + fy + ", cx=" + cx + ", cy=" + cy
                + ", distortionModel=" + distortionModel + ", distortion=" + Arrays.toString(distortion) + "]";
    }

    /**
     * A pinhole.
     *
     * @param width width of the image in pixels
     * @param height height of the image in pixels
     * @param fx focal length in pixel widths
     * @param fy focal length in pixel heights
     * @param cx principal point, to the right
     * @param cy principal point, down
     */
    public Intrinsics(int width, int height, double fx, double fy, double cx, double cy) {
        this(width, height, fx, fy, cx, cy, DistortionModel.NONE);
    }

    /**
     * The pixels of the (distorted) image at which the camera sees points of its frame.
     *
     * @param points the points
     * @return x and y of one pixel after the other, row by row of the points. Pixels may lie beyond the border of the
     *     image; NaN for a point that is not finite, not in front of the camera or outside the field of its model.
     * @throws CylfuseException INVALID_INTRINSICS, INVALID_ARGUMENT when no camera works with these numbers
     */
    public double[] project(PointCloud points) {
        try (NativeCopies copies = new NativeCopies()) {
            NativeStructs.PointsView view = Objects.requireNonNull(points, "points").toNative(copies);
            double[] pixels = new double[Math.toIntExact(2 * points.count())];
            NativeFunctions.check(
                    NativeFunctions.cylfuse_intrinsics_project(toNative(), view, pixels, points.count()));
            return pixels;
        }
    }

    /**
     * The rays along which the camera sees pixels of the (distorted) image: the points at z = 1 of its frame. The ray
     * of an ideal pixel, as those of limb lines are, is that of the same intrinsics without distortion.
     *
     * @param pixels x and y of one pixel after the other, in the image or beyond its border
     * @return x, y and z of one ray after the other; NaN for a pixel that is not finite or for which the model has no
     *     ray
     * @throws IllegalArgumentException when the length is odd
     * @throws CylfuseException INVALID_INTRINSICS, INVALID_ARGUMENT when no camera works with these numbers
     */
    public double[] unproject(double... pixels) {
        if (pixels.length % 2 != 0) {
            throw new IllegalArgumentException(pixels.length + " numbers are not x, y of pixels: their count must be even.");
        }
        int count = pixels.length / 2;
        double[] rays = new double[3 * count];
        NativeFunctions.check(NativeFunctions.cylfuse_intrinsics_unproject(toNative(), pixels, count, rays));
        return rays;
    }

    static Intrinsics of(NativeStructs.Intrinsics n) {
        return new Intrinsics(
                n.width,
                n.height,
                n.fx,
                n.fy,
                n.cx,
                n.cy,
                NativeNumber.find(DistortionModel.class, n.distortion_model),
                n.distortion);
    }

    /** NULL where there is no camera. */
    static NativeStructs.Intrinsics toNative(Intrinsics camera) {
        return camera == null ? null : camera.toNative();
    }

    NativeStructs.Intrinsics toNative() {
        NativeStructs.Intrinsics n =
                NativeFunctions.initialised(new NativeStructs.Intrinsics(), NativeFunctions::cylfuse_intrinsics_init);
        n.distortion_model = distortionModel.value();
        n.width = width;
        n.height = height;
        n.fx = fx;
        n.fy = fy;
        n.cx = cx;
        n.cy = cy;
        n.distortion = Arrays.copyOf(distortion, MOST_COEFFICIENTS);
        return n;
    }
}
