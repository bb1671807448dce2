package org.cylfuse;

import static org.junit.Assert.assertArrayEquals;
import static org.junit.Assert.assertEquals;
import static org.junit.Assert.assertNotEquals;
import static org.junit.Assert.assertNull;
import static org.junit.Assert.assertThrows;
import static org.junit.Assert.assertTrue;

import java.util.ArrayList;
import java.util.List;
import java.util.Set;
import java.util.concurrent.ExecutionException;
import java.util.concurrent.ExecutorService;
import java.util.concurrent.Executors;
import java.util.concurrent.Future;
import org.junit.Test;
import org.junit.function.ThrowingRunnable;

/** Views, frames, depth cameras, colour, and reading from many threads. */
public class ViewTest {
    private static final int PIXELS = Scene.WIDTH * Scene.HEIGHT;

    private static void fails(Status status, ThrowingRunnable call, String part) {
        CylfuseException failure = assertThrows(CylfuseException.class, call);
        assertEquals(status, failure.status());
        assertTrue(failure.getMessage(), !failure.getMessage().isEmpty() && failure.getMessage().contains(part));
    }

    @Test
    public void twoViewsGiveOneCylinder() {
        try (Fitter fitter = Scene.loaded()) {
            assertEquals(1, fitter.viewCount());
            long first = fitter.counts().pointsUsed();
            fitter.selectView(1);
            assertEquals(2, fitter.viewCount());
            Scene.pushView(fitter, Scene.ASIDE);
            long second = fitter.counts().pointsUsed();
            assertEquals(1, fitter.counts().view());

            FitResult result = fitter.fit();
            CylinderDifference difference = Scene.TRUTH.compare(result.model());
            assertTrue(difference.angle() < 1e-3 && difference.axisDistance() < 1e-4);
            assertEquals(0, difference.radiusRelative(), 1e-3);
            assertEquals(first + second, result.pointsUsed());
            assertTrue(result.pointDeviation() > 0 && result.independentPoints() > 0);

            PointWeights weights = fitter.pointWeights();
            assertEquals(second, weights.weights().length);
            assertEquals(second, fitter.residuals(ResidualKind.POINTS, null).length);
            for (int k = 0; k < second; k++) {
                assertEquals(weights.weights()[k] > 0, weights.inliers()[k]);
            }
            Part[] parts = fitter.pointParts(null);
            assertEquals(second, parts.length);
            assertEquals(Part.BODY, parts[parts.length / 2]);
            assertEquals(List.of(0, 0, 1, 1), fitter.limbs().stream().map(LimbLine::view).toList());
            assertTrue(fitter.limbs().stream().allMatch(limb -> limb.status() == LimbStatus.NOT_SEARCHED));

            // The points of both views are in the reference frame.
            for (int view = 0; view < 2; view++) {
                fitter.selectView(view);
                double[] distances = result.model().distances(PointCloud.of(fitter.complete().coordinates()));
                assertTrue(distances.length > 0);
                assertArrayEquals(new double[distances.length], distances, 1e-12);
            }
            Extent extent = fitter.extent();
            assertTrue(extent.startView() < 2 && extent.endView() < 2 && extent.length() > 0.2);

            fails(Status.INVALID_ARGUMENT, () -> fitter.selectView(5), "5");
            assertThrows(IllegalArgumentException.class, () -> fitter.selectView(-1));
            fitter.clear();
            assertEquals(1, fitter.viewCount());
        }
    }

    @Test
    public void posesAreChecked() {
        double[][] bent = {{1, 0, 0}, {0, 1, 0}, {0, 0, 2}};
        Vector nowhere = new Vector(Double.NaN, 0, 0);
        try (Fitter fitter = new Fitter()) {
            fails(Status.INVALID_ARGUMENT, () -> fitter.setPose(new RigidMotion(bent, new Vector(0, 0, 0))), "rotation");
            double[][] none = RigidMotion.IDENTITY.rotation();
            fails(Status.INVALID_ARGUMENT, () -> fitter.setPose(new RigidMotion(none, nowhere)), "");
            assertThrows(NullPointerException.class, () -> fitter.setPose(null));
        }
        assertThrows(IllegalArgumentException.class, () -> new RigidMotion(new double[2][3], nowhere));
    }

    @Test
    public void twoFittersShareAFrame() {
        DepthImage depth = DepthImage.of(Scene.depth(), Scene.WIDTH, Scene.HEIGHT, 1e-4);
        Image image = Image.of(Scene.grey(), Scene.WIDTH, Scene.HEIGHT);
        Mask mask = Mask.of(Scene.mask(), Scene.WIDTH, Scene.HEIGHT);
        try (Fitter pushed = Scene.loaded();
                Fitter one = new Fitter();
                Fitter other = new Fitter()) {
            pushed.clearInput(Input.EDGES);
            pushed.pushImage(image);
            Frame frame = new Frame();
            fails(Status.BAD_STATE, () -> frame.setDepth(depth), "intrinsics");
            fails(Status.BAD_STATE, () -> one.useFrame(frame, null), "intrinsics");
            frame.setIntrinsics(Scene.CAMERA);
            frame.setPose(RigidMotion.IDENTITY);
            frame.setDepth(depth);
            frame.setImage(image);
            fails(Status.SIZE_MISMATCH, () -> one.useFrame(frame, Mask.of(new byte[] {1, 1}, 2, 1)), "2 x 1");
            one.useFrame(frame, mask);
            other.useFrame(frame, mask);
            frame.close();
            frame.close();
            assertThrows(IllegalStateException.class, () -> other.useFrame(frame, mask));
            FitResult expected = pushed.fit();
            for (Fitter fitter : List.of(one, other)) {
                assertEquals(expected.model(), fitter.fit().model());
                assertEquals(pushed.extent().length(), fitter.extent().length(), 0);
                assertArrayEquals(
                        pushed.completeDepth(1, null, null).depth(), fitter.completeDepth(1, null, null).depth(), 0);
            }
        }
    }

    @Test
    public void aDepthCameraOfItsOwnIsUsed() {
        RigidMotion toColour = new RigidMotion(RigidMotion.IDENTITY.rotation(), new Vector(0.02, 0, 0));
        short[] depth = Scene.depth(Scene.seen(toColour));
        try (Fitter fitter = new Fitter()) {
            fitter.setIntrinsics(Scene.CAMERA);
            fitter.setDepthCamera(Scene.CAMERA, toColour);
            fitter.pushDepth(
                    DepthImage.of(depth, Scene.WIDTH, Scene.HEIGHT, 1e-4), Mask.of(Scene.mask(), Scene.WIDTH, Scene.HEIGHT));
            CylinderDifference difference = Scene.TRUTH.compare(fitter.fit().model());
            assertEquals(0, difference.axisDistance(), 1e-3);
            assertEquals(0, difference.radiusRelative(), 5e-3);
            Intrinsics bad = new Intrinsics(9, 9, 0, 1, 0, 0);
            fails(Status.INVALID_INTRINSICS, () -> fitter.setDepthCamera(bad, RigidMotion.IDENTITY), "0");
            fitter.clearInput(Input.DEPTH);
            fitter.setDepthCamera(null, RigidMotion.IDENTITY);
        }
    }

    @Test
    public void colourImagesAreTaken() {
        byte[] grey = Scene.grey();
        byte[] rgb = new byte[3 * PIXELS];
        byte[] bgr = new byte[3 * PIXELS];
        byte[] bgra = new byte[4 * PIXELS];
        for (int k = 0; k < PIXELS; k++) {
            rgb[3 * k] = bgr[3 * k + 2] = bgra[4 * k + 2] = grey[k];
            rgb[3 * k + 1] = bgr[3 * k + 1] = bgra[4 * k + 1] = 7;
        }
        double radius = radius(Image.of(rgb, Scene.WIDTH, Scene.HEIGHT, ColourFormat.RGB8));
        assertEquals(radius, radius(Image.of(bgr, Scene.WIDTH, Scene.HEIGHT, ColourFormat.BGR8)), 0);
        assertEquals(radius, radius(Image.of(bgra, Scene.WIDTH, Scene.HEIGHT, ColourFormat.BGRA8)), 0);
        assertNotEquals(radius, radius(Image.of(bgr, Scene.WIDTH, Scene.HEIGHT, ColourFormat.RGB8)), 0);
        assertThrows(
                IllegalArgumentException.class, () -> Image.of(bgr, Scene.WIDTH, Scene.HEIGHT, ColourFormat.RGBA8));
    }

    private static double radius(Image image) {
        try (Fitter fitter = Scene.loaded()) {
            fitter.pushImage(image);
            FitResult result = fitter.fit();
            long located = fitter.limbs().stream().filter(limb -> limb.status() == LimbStatus.LOCATED).count();
            assertEquals(result.limbsLocated(), located);
            assertTrue(located > 0);
            assertTrue(fitter.endSamples(null, null).stream().allMatch(sample -> sample.end() < 2 && sample.deviation() > 0));
            return result.model().radius();
        }
    }

    @Test
    public void oneInputIsForgotten() {
        try (Fitter fitter = Scene.loaded()) {
            FitResult result = fitter.fit();
            fitter.clearInput(Input.EDGES);
            assertEquals(0, fitter.counts().segmentsGiven());
            assertEquals(result.pointsUsed(), fitter.counts().pointsUsed());
            assertEquals(result.cost(), fitter.result().cost(), 0);
            assertEquals(0, fitter.fit().segmentsUsed());
            fitter.clearInput(Input.POINTS, Input.IMAGE);
            fails(Status.TOO_FEW_POINTS, fitter::fit, "");
        }
    }

    @Test
    public void aLabelSelectsPixels() {
        byte[] labels = Scene.mask();
        for (int k = 0; k < PIXELS; k++) {
            labels[k] = (byte) (labels[k] != 0 ? 3 : 1);
        }
        try (Fitter expected = Scene.loaded();
                Fitter fitter = new Fitter()) {
            fitter.setIntrinsics(Scene.CAMERA);
            fitter.pushDepth(
                    DepthImage.of(Scene.depth(), Scene.WIDTH, Scene.HEIGHT, 1e-4),
                    Mask.of(labels, Scene.WIDTH, Scene.HEIGHT).withLabel(3));
            assertEquals(expected.counts().pointsUsed(), fitter.counts().pointsUsed());
        }
    }

    @Test
    public void camerasProjectAndUnproject() {
        Intrinsics camera =
                new Intrinsics(640, 480, 500, 510, 320, 240, DistortionModel.BROWN_CONRADY, 0.1, -0.05);
        double[] pixels = {0, 0, 320, 240, 600.5, 20.25};
        double[] rays = camera.unproject(pixels);
        assertEquals(1, rays[8], 0);
        assertArrayEquals(pixels, camera.project(PointCloud.of(rays)), 1e-9);
        assertTrue(Double.isNaN(camera.project(PointCloud.of(new double[] {0, 0, -1}))[0]));
        assertEquals(0, camera.unproject().length);
        assertThrows(IllegalArgumentException.class, () -> camera.unproject(1));
    }

    /** Calls that only read run side by side, and each thread reads the message of its own failure. */
    @Test
    public void manyThreadsReadAtOnce() throws ExecutionException, InterruptedException {
        ExecutorService threads = Executors.newFixedThreadPool(8);
        try (Fitter fitter = Scene.loaded()) {
            FitResult result = fitter.fit();
            double length = fitter.extent().length();
            List<Future<?>> readers = new ArrayList<>();
            for (int reader = 1; reader <= 8; reader++) {
                int own = reader;
                Cylinder bad = new Cylinder(result.model().point(), result.model().direction(), -own);
                readers.add(threads.submit(() -> {
                    for (int round = 0; round < 20; round++) {
                        assertEquals(result.cost(), fitter.result().cost(), 0);
                        assertEquals(result.pointRms(), fitter.evaluate(result.model()).pointRms(), 1e-12);
                        assertEquals(result.pointsUsed(), fitter.residuals(ResidualKind.POINTS, null).length);
                        assertEquals(length, fitter.extent().length(), 0);
                        fails(Status.INVALID_ARGUMENT, () -> fitter.evaluate(bad), "-" + own);
                    }
                }));
            }
            for (Future<?> reader : readers) {
                reader.get();
            }
        }
        threads.shutdown();
    }

    @Test
    public void aCallThatReadsIsBusyWhileAFitRuns() throws InterruptedException {
        ExecutorService thread = Executors.newSingleThreadExecutor();
        try (Fitter fitter = Scene.loaded()) {
            fitter.setProgressListener(progress -> {
                try {
                    thread.submit(() -> fails(Status.BUSY, fitter::result, "busy")).get();
                } catch (InterruptedException | ExecutionException failure) {
                    throw new AssertionError(failure);
                }
                return true;
            });
            fitter.fit();
        }
        thread.shutdown();
    }

    @Test
    public void aCameraIsThatOfItsView() {
        try (Fitter fitter = Scene.loaded()) {
            fitter.fit();
            assertEquals(Scene.WIDTH, fitter.completeDepth(1, null, null).width());
            fitter.selectView(1);
            fails(Status.BAD_STATE, () -> fitter.completeDepth(1, null, null), "");
            assertNull(fitter.calls.camera());
            fitter.selectView(0);
            assertEquals(PIXELS, fitter.completeDepth(1, null, null).depth().length);
        }
    }

    @Test
    public void theIntervalDecidesAboutATolerance() {
        Tolerance tolerance = new Tolerance(19.5, 20.25);
        assertEquals(Conformity.CONFORMING, tolerance.decide(20.0, 0.12, Set.of()));
        assertEquals(Conformity.UNDECIDED, tolerance.decide(20.0, 0.13, Set.of()));
        assertEquals(Conformity.CONFORMING, new Tolerance(19.5, 20.25, 1.0).decide(20.0, 0.13, Set.of()));
        assertEquals(Conformity.NOT_CONFORMING, tolerance.decide(21.0, 0.3, Set.of()));
        assertEquals(Conformity.UNDECIDED, tolerance.decide(20.0, Double.NaN, Set.of()));
        assertEquals(Conformity.CONFORMING, tolerance.decide(20.0, 0.12, Set.of(ResultFlag.WEAK_RADIUS)));
        assertEquals(
                Conformity.UNDECIDED, tolerance.decide(20.0, 0.12, Set.of(ResultFlag.WEAK_RADIUS, ResultFlag.POOR_FIT)));
        CylfuseException failure =
                assertThrows(CylfuseException.class, () -> new Tolerance(21.0, 19.0).decide(20.0, 0.1, Set.of()));
        assertEquals(Status.INVALID_ARGUMENT, failure.status());
        assertTrue(failure.getMessage(), failure.getMessage().contains("21 to 19"));
    }

    @Test
    public void aResultIsJudgedAndAFitterCopied() {
        double[] points = Scene.pipe(200);
        for (int k = 2; k < points.length; k += 3) {
            points[k] += 0.002 * Math.sin(7 * k);
        }
        Intrinsics camera = new Intrinsics(
                640, 480, 570, 571, 319.5, 239.5, DistortionModel.KANNALA_BRANDT, 0.01, 0, 0, -0.002, 0, 0, 0, 0);
        Fitter fitter = new Fitter();
        assertEquals(Status.BAD_STATE, assertThrows(CylfuseException.class, fitter::intrinsics).status());
        fitter.setIntrinsics(camera);
        fitter.pushPoints(PointCloud.of(points));
        FitResult result = fitter.fit();
        double radius = result.model().radius();
        double deviation = result.radiusDeviation();
        assertTrue("deviation " + deviation, deviation > 0 && deviation < 0.1 * radius);
        assertEquals(
                Conformity.CONFORMING,
                result.radiusConforms(new Tolerance(radius - 2.1 * deviation, radius + 2.1 * deviation)));
        assertEquals(Conformity.UNDECIDED, result.radiusConforms(new Tolerance(radius - 1.9 * deviation, 9.0)));
        assertEquals(
                Conformity.CONFORMING,
                result.diameterConforms(new Tolerance(2 * radius - 4.2 * deviation, 2 * radius + 4.2 * deviation)));
        assertEquals(Conformity.UNDECIDED, result.diameterConforms(new Tolerance(2 * radius - 3.8 * deviation, 9.0)));
        assertEquals(Conformity.NOT_CONFORMING, result.diameterConforms(new Tolerance(0, radius)));

        fitter.setProgressListener(progress -> false);
        try (Fitter copy = fitter.copy()) {
            assertEquals(camera, copy.intrinsics());
            assertEquals(radius, copy.result().model().radius(), 0);
            assertEquals(radius, copy.fit().model().radius(), 0); // Without the listener.
            copy.clear();
            assertEquals(200, fitter.counts().pointsGiven());
        }
        fitter.close();
        assertThrows(IllegalStateException.class, fitter::copy);
    }
}
