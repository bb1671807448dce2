package org.cylfuse;

import static org.junit.Assert.assertArrayEquals;
import static org.junit.Assert.assertEquals;
import static org.junit.Assert.assertNotEquals;
import static org.junit.Assert.assertThrows;
import static org.junit.Assert.assertTrue;

import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.DoubleBuffer;
import java.nio.FloatBuffer;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.EnumSet;
import java.util.List;
import java.util.Map;
import java.util.Set;
import java.util.function.Function;
import org.junit.Test;
import org.junit.function.ThrowingRunnable;

public class FitterTest {
    @Test
    public void theLibrarySaysWhatItIs() {
        assertEquals(1, Library.abiVersion());
        String[] parts = Library.versionString().split("\\.");
        int number = Integer.parseInt(parts[0]) * 65536 + Integer.parseInt(parts[1]) * 256 + Integer.parseInt(parts[2]);
        assertEquals(number, Library.versionNumber());
        assertTrue(Library.buildInfo(), Library.buildInfo().contains(Library.versionString()));
        assertTrue(Library.statusText(Status.PLANAR_POINTS).startsWith("PLANAR_POINTS:"));
    }

    @Test
    public void pointsGiveTheCylinder() {
        try (Fitter fitter = new Fitter()) {
            fitter.pushPoints(PointCloud.of(Scene.pipe(200)));
            FitResult result = fitter.fit();
            assertEquals(0.5, result.model().radius(), 1e-9);
            assertEquals(1.0, result.model().direction().y(), 1e-12);
            assertEquals(200, result.pointsUsed());
            assertEquals(Set.of(), result.flags());
            assertEquals(result.cost(), fitter.result().cost(), 0);
            assertEquals(result.radiusDeviation(), Math.sqrt(result.covariance()[6][6]), 1e-15);
        }
    }

    @Test
    public void allArraysAndBuffersOfTheSamePointsGiveTheSameBits() {
        double[] flat = Scene.pipe(200);
        double[][] rows = new double[200][];
        double[] strided = new double[5 + 200 * 4];
        double[] reversed = new double[600];
        float[] single = new float[600];
        for (int k = 0; k < 200; k++) {
            rows[k] = Arrays.copyOfRange(flat, 3 * k, 3 * k + 3);
            System.arraycopy(flat, 3 * k, strided, 5 + 4 * k, 3);
            System.arraycopy(flat, 3 * k, reversed, 3 * (199 - k), 3);
        }
        for (int k = 0; k < 600; k++) {
            single[k] = (float) flat[k];
        }
        DoubleBuffer direct = ByteBuffer.allocateDirect(8 * 602).order(ByteOrder.nativeOrder()).asDoubleBuffer();
        direct.position(2).put(flat).position(2);
        DoubleBuffer swapped = ByteBuffer.allocateDirect(8 * 600).order(ByteOrder.BIG_ENDIAN).asDoubleBuffer();
        swapped.put(flat).position(0);
        double[] ones = new double[200];
        Arrays.fill(ones, 1.0);

        double radius = radius(PointCloud.of(flat));
        assertEquals(radius, radius(PointCloud.of(rows)), 0);
        assertEquals(radius, radius(PointCloud.of(DoubleBuffer.wrap(strided), 200, 1, 5, 4, 0)), 0);
        assertEquals(radius, radius(PointCloud.of(DoubleBuffer.wrap(strided), 20, 10, 5, 4, 80)), 0);
        assertEquals(radius, radius(PointCloud.of(DoubleBuffer.wrap(strided).position(5), 200, 1, 0, 4, 0)), 0);
        assertEquals(radius, radius(PointCloud.of(DoubleBuffer.wrap(reversed), 200, 1, 597, -3, 0)), 0);
        assertEquals(radius, radius(PointCloud.of(direct, 200, 1, 0, 0, 0)), 0);
        assertEquals(radius, radius(PointCloud.of(swapped, 200, 1, 0, 0, 0)), 0);
        assertEquals(radius, radius(PointCloud.of(flat).withWeights(ones)), 0);
        assertEquals(0.5, radius(PointCloud.of(single)), 1e-6);
    }

    private static double radius(PointCloud points) {
        try (Fitter fitter = new Fitter()) {
            fitter.pushPoints(points);
            return fitter.fit().model().radius();
        }
    }

    @Test
    public void weightsAndMasksSelectPoints() {
        try (Fitter fitter = new Fitter()) {
            double[] weights = new double[200];
            boolean[] mask = new boolean[200];
            for (int k = 0; k < 200; k++) {
                weights[k] = k % 2;
                mask[k] = k < 50;
            }
            fitter.pushPoints(PointCloud.of(Scene.pipe(200)).withWeights(weights));
            assertEquals(200, fitter.counts().pointsGiven());
            assertEquals(100, fitter.counts().droppedZeroWeight());
            fitter.clear();
            fitter.pushPoints(PointCloud.of(Scene.pipe(200)), Mask.of(mask, 200, 1));
            assertEquals(150, fitter.counts().droppedOutsideMask());
        }
    }

    @Test
    public void aDepthImageGivesEverything() {
        try (Fitter fitter = Scene.loaded()) {
            FitResult result = fitter.fit();
            CylinderDifference difference = Scene.TRUTH.compare(result.model());
            assertTrue(difference.angle() < 1e-3 && difference.axisDistance() < 1e-4);
            assertEquals(0, difference.radiusRelative(), 1e-3);
            assertEquals(2, result.segmentsUsed());
            assertNotEquals(StartKind.AUTO, result.startKind());

            double[] residuals = fitter.residuals(ResidualKind.POINTS, null);
            assertEquals(result.pointsUsed(), residuals.length);
            double sum = Arrays.stream(residuals).map(r -> r * r).sum();
            assertEquals(result.pointRms(), Math.sqrt(sum / residuals.length), 1e-12);
            assertEquals(4, fitter.residuals(ResidualKind.EDGES, result.model()).length);
            assertEquals(5, fitter.diagnose(null).rank());
            assertEquals(List.of(), fitter.limbSamples());

            Extent extent = fitter.extent();
            assertEquals(extent.endState(), fitter.extent(result.model(), null).endState());
            assertTrue(extent.length() > 0.2 && extent.length() < 1);

            CompletedCloud cloud = fitter.complete();
            assertEquals(cloud.pixels().count(), cloud.width());
            assertEquals(fitter.completeBound(Layout.PACKED, null), cloud.pixels().hits() + cloud.pixels().misses());
            for (double distance : result.model().distances(PointCloud.of(cloud.coordinates()))) {
                assertEquals(0, distance, 1e-12);
            }
            CompletedCloudSingle organised = fitter.completeSingle(Layout.ORGANISED, null, null);
            assertEquals(Scene.WIDTH * Scene.HEIGHT * 3, organised.coordinates().length);

            CompletedDepth depth = fitter.completeDepth(1.0, null, null);
            CompletedDepthInteger integers = fitter.completeDepthInteger(1e-4, null, null);
            int pixels = 0;
            for (int k = 0; k < depth.depth().length; k++) {
                assertEquals(depth.depth()[k], Short.toUnsignedInt(integers.depth()[k]) * 1e-4, 6e-5);
                boolean there = depth.depth()[k] > 0;
                pixels += there ? 1 : 0;
                assertEquals(!there, Float.isNaN(organised.coordinates()[3 * k]));
            }
            assertEquals(cloud.pixels().count(), pixels);
        }
    }

    @Test
    public void edgesOfADetectorAreSelected() {
        try (Fitter fitter = Scene.loaded()) {
            double[][] edges = Scene.edges();
            double[] border = {2, 10, 2, 70};
            Segments found = Segments.of(border, edges[1], edges[0]);
            assertArrayEquals(new byte[] {0, 2, 1}, fitter.selectEdges(found, Scene.TRUTH, 0));
            fails(Status.BAD_STATE, () -> fitter.selectEdges(found, null, 0), "model");
            fails(Status.INVALID_ARGUMENT, () -> fitter.selectEdges(found, Scene.TRUTH, -1), "-1");
        }
    }

    @Test
    public void theImageIsSearchedForLimbs() {
        try (Fitter fitter = Scene.loaded()) {
            byte[] mask = Scene.mask();
            float[] image = new float[mask.length];
            for (int k = 0; k < image.length; k++) {
                image[k] = mask[k] != 0 ? 200 : 50;
            }
            Image grey = Image.of(image, Scene.WIDTH, Scene.HEIGHT);
            fails(Status.INVALID_ARGUMENT, () -> fitter.pushImage(grey.withGamma(22)), "gamma of the image is 22");
            fitter.pushImage(grey);
            FitResult result = fitter.fit();
            List<LimbSample> samples = fitter.limbSamples();
            assertTrue(samples.size() > 0);
            assertEquals(samples.stream().anyMatch(sample -> sample.weight() > 0), result.limbsLocated() > 0);
        }
    }

    @Test
    public void optionsRoundTripAndCount() {
        try (Fitter fitter = Scene.loaded()) {
            FitOptions options = new FitOptions()
                    .method(Method.FUSED).objective(Objective.PAPER).start(StartKind.MODEL).nearWall(NearWall.ON)
                    .chart(Chart.LOCAL).maxIterations(123).maxThreads(2).edgeWeight(0.25).initialLambda(0.5)
                    .lambdaFactor(3).maxLambda(1e9).costTolerance(1e-11).ransacThreshold(0.125).seed(77)
                    .ransacMaxIterations(321).edgeUse(EdgeUse.AS_GIVEN).extentRule(ExtentRule.EXTREMES).radiusMin(0.05)
                    .radiusMax(0.0625).axis(new Vector(0, 1, 0.5)).axisMaxAngle(0.75)
                    .gradientTolerance(1e-9).stepTolerance(1e-10).independentPoints(500).depthNoise(2e-3).imageNoise(3)
                    .edgeNoise(0.75).maskNoise(2).imageBlur(1.25).drawnPixel(1.5)
                    .depthShared(0.004);
            fitter.setOptions(options);
            assertEquals(describe(options), describe(fitter.options()));
            fitter.setStartModel(Scene.TRUTH);
            FitResult result = fitter.fit();
            assertEquals(StartKind.MODEL, result.startKind());
            assertEquals(0.0625, result.model().radius(), 1e-15);
            assertTrue(result.flags().contains(ResultFlag.RADIUS_AT_LIMIT));
            assertEquals(0.25, result.edgeWeight(), 0);
        }
    }

    /** The values of all getters. */
    private static List<String> describe(FitOptions options) {
        return Arrays.stream(FitOptions.class.getMethods())
                .filter(method -> method.getDeclaringClass() == FitOptions.class && method.getParameterCount() == 0)
                .map(method -> {
                    try {
                        return method.getName() + " = " + method.invoke(options);
                    } catch (ReflectiveOperationException failure) {
                        throw new AssertionError(failure);
                    }
                })
                .sorted()
                .toList();
    }

    @Test
    public void evaluateDoesNotIterate() {
        try (Fitter fitter = Scene.loaded()) {
            FitResult result = fitter.evaluate(Scene.TRUTH);
            assertEquals(Termination.NONE, result.termination());
            assertEquals(0, result.iterations());
            fails(Status.BAD_STATE, fitter::result, "");
        }
    }

    private static void fails(Status status, ThrowingRunnable call, String part) {
        CylfuseException failure = assertThrows(CylfuseException.class, call);
        assertEquals(status, failure.status());
        assertTrue(failure.getMessage(), !failure.getMessage().isEmpty() && failure.getMessage().contains(part));
    }

    private static void refuses(ThrowingRunnable call, String part) {
        IllegalArgumentException failure = assertThrows(IllegalArgumentException.class, call);
        assertTrue(failure.getMessage(), failure.getMessage().contains(part));
    }

    @Test
    public void failuresHaveTheKindAndTheMessageOfTheLibrary() {
        try (Fitter fitter = new Fitter()) {
            assertThrows(UnusableDataException.class, fitter::fit);
            DepthImage depth = DepthImage.of(Scene.depth(), Scene.WIDTH, Scene.HEIGHT, 1e-4);
            fitter.pushPoints(PointCloud.of(new double[12]));
            fails(Status.TOO_FEW_POINTS, fitter::fit, "4");
            fails(Status.BAD_STATE, () -> fitter.pushDepth(depth, null), "intrinsics");
            fails(Status.BAD_STATE, () -> fitter.completeDepth(1, null, null), "");
            fails(Status.BAD_STATE, fitter::complete, "");
            fails(Status.INVALID_INTRINSICS, () -> fitter.setIntrinsics(new Intrinsics(9, 9, Double.NaN, 1, 0, 0)), "NaN");
            fails(Status.INVALID_ARGUMENT, () -> fitter.setOptions(new FitOptions().edgeWeight(2)), "2");
            fails(Status.INVALID_ARGUMENT, () -> fitter.pushEdges(Segments.of(new double[] {Double.NaN, 0, 1, 1})), "NaN");
            Vector zero = new Vector(0, 0, 0);
            fails(Status.INVALID_ARGUMENT, () -> Scene.TRUTH.compare(new Cylinder(zero, zero, 1)), "");
            fails(Status.INVALID_ARGUMENT, () -> new Plan(0.7, -1, 0.1, 0, 0).expect(Scene.CAMERA), "radius is -1");
            fitter.setIntrinsics(Scene.CAMERA);
            fails(Status.SIZE_MISMATCH, () -> fitter.pushDepth(DepthImage.of(new short[12], 4, 3, 1), null), "4");
            byte[] empty = new byte[Scene.WIDTH * Scene.HEIGHT];
            fails(Status.EMPTY_MASK, () -> fitter.pushDepth(depth, Mask.of(empty, Scene.WIDTH, Scene.HEIGHT)), "");
        }
    }

    @Test
    public void wrongShapesAreRefusedBeforeTheCall() {
        DoubleBuffer thirty = DoubleBuffer.allocate(30);
        refuses(() -> PointCloud.of(new double[7]), "multiple of 3");
        refuses(() -> PointCloud.of(new double[][] {{1, 2, 3}, {1, 2}}), "point 1 has 2 numbers");
        refuses(() -> PointCloud.of(thirty, 10, 1, 1, 0, 0), "elements 1 to 30 of an array that has 30");
        refuses(() -> PointCloud.of(thirty, 10, 1, 0, -3, 0), "elements -27 to 2");
        refuses(() -> PointCloud.of(thirty, Integer.MAX_VALUE, Integer.MAX_VALUE, 0, 0, 0), "elements");
        refuses(() -> PointCloud.of(new double[30]).withWeights(new float[10]), "same type");
        refuses(() -> PointCloud.of(new double[30]).withWeights(new double[9]), "weights");
        refuses(() -> PointCloud.of(new double[30]).withNormals(FloatBuffer.allocate(30), 0, 0, 0), "same type");
        refuses(() -> DepthImage.of(new short[11], 4, 3, 1.0), "4 x 3 pixels are not the 11 elements");
        refuses(() -> Mask.of(ByteBuffer.allocate(12), 4, -3, 0, 0, 0), "negative");
        refuses(() -> Image.of(ByteBuffer.allocate(33), 4, 3, 0, 3, 0), "elements 0 to 33 of an array that has 33");
        refuses(() -> Segments.of(new double[3]), "must have 4");
        refuses(() -> Segments.of(new double[4]).withWeights(1, 2), "2 elements");
        refuses(() -> new Intrinsics(1, 1, 1, 1, 0, 0, DistortionModel.BROWN_CONRADY, new double[9]), "at most 8");
        refuses(() -> new FitOptions().maxThreads(-1), "0 or greater");
        assertThrows(NullPointerException.class, () -> PointCloud.of((double[]) null));
    }

    @Test
    public void stridesOfImagesAndSegmentsAreFollowed() {
        float[] wide = new float[2 * Scene.WIDTH * Scene.HEIGHT];
        byte[] colours = new byte[3 * Scene.WIDTH * Scene.HEIGHT];
        for (int k = 0; k < Scene.WIDTH * Scene.HEIGHT; k++) {
            wide[2 * k] = Short.toUnsignedInt(Scene.depth()[k]);
            colours[3 * k + 1] = Scene.mask()[k];
        }
        double[] edges = new double[9];
        System.arraycopy(Scene.edges()[1], 0, edges, 0, 4);
        System.arraycopy(Scene.edges()[0], 0, edges, 5, 4);
        try (Fitter plain = Scene.loaded();
                Fitter fitter = new Fitter()) {
            fitter.setIntrinsics(Scene.CAMERA);
            fitter.pushDepth(
                    DepthImage.of(FloatBuffer.wrap(wide), Scene.WIDTH, Scene.HEIGHT, 1e-4, 0, 2, 0),
                    Mask.of(ByteBuffer.wrap(colours), Scene.WIDTH, Scene.HEIGHT, 1, 3, 0));
            fitter.pushEdges(Segments.of(DoubleBuffer.wrap(edges), 2, 5, -5));
            assertEquals(plain.fit().pointsUsed(), fitter.fit().pointsUsed());
            assertArrayEquals(
                    plain.residuals(ResidualKind.EDGES, Scene.TRUTH), fitter.residuals(ResidualKind.EDGES, Scene.TRUTH), 0);
        }
    }

    private static <E extends Enum<E>> void described(E[] constants, Function<E, String> describe) {
        for (E constant : constants) {
            String text = describe.apply(constant);
            assertTrue(text, text.startsWith(constant.name() + ": ") && text.length() > constant.name().length() + 7);
        }
    }

    @Test
    public void constantsAreDescribed() {
        described(Termination.values(), Termination::description);
        described(StartKind.values(), StartKind::description);
        described(EndState.values(), EndState::description);
        described(EndSource.values(), EndSource::description);
        described(LimbStatus.values(), LimbStatus::description);
        described(Part.values(), Part::description);
        described(Conformity.values(), Conformity::description);
        described(ResultFlag.values(), ResultFlag::description);
        assertEquals(
                List.of(ResultFlag.WEAK_RADIUS.description(), ResultFlag.POOR_FIT.description()),
                ResultFlag.descriptions(Set.of(ResultFlag.POOR_FIT, ResultFlag.WEAK_RADIUS)));
        assertEquals(List.of(), ResultFlag.descriptions(Set.of()));
    }

    @SuppressWarnings("unchecked")
    private static <T extends Throwable> boolean hurl(Throwable failure) throws T {
        throw (T) failure;
    }

    @Test
    public void nullArgumentsAreNamed() {
        try (Fitter fitter = Scene.loaded()) {
            Map<String, ThrowingRunnable> calls = Map.ofEntries(
                    Map.entry("points", () -> fitter.pushPoints(null)),
                    Map.entry("depth", () -> fitter.pushDepth(null, null)),
                    Map.entry("image", () -> fitter.pushImage(null)),
                    Map.entry("segments", () -> fitter.pushEdges(null)),
                    Map.entry("options", () -> fitter.setOptions(null)),
                    Map.entry("camera", () -> fitter.setIntrinsics(null)),
                    Map.entry("model", () -> fitter.evaluate(null)),
                    Map.entry("kind", () -> fitter.residuals(null, null)),
                    Map.entry("layout", () -> fitter.complete(null, null, null)),
                    Map.entry("maxLevel", () -> fitter.setLogListener(null, null)),
                    Map.entry("intrinsics", () -> Scene.TRUTH.project(null)),
                    Map.entry("other", () -> Scene.TRUTH.compare(null)));
            calls.forEach((name, call) -> assertEquals(name, assertThrows(NullPointerException.class, call).getMessage()));
            fitter.fit();
        }
    }

    @Test
    public void camerasAreComparedByTheirNumbers() {
        Intrinsics camera = new Intrinsics(4, 3, 1, 1, 0, 0, DistortionModel.BROWN_CONRADY, 0.5, 0.25);
        Intrinsics same = new Intrinsics(4, 3, 1, 1, 0, 0, DistortionModel.BROWN_CONRADY, 0.5, 0.25);
        same.distortion()[0] = 7; // a copy
        assertEquals(camera, same);
        assertEquals(camera.hashCode(), same.hashCode());
        assertNotEquals(camera, new Intrinsics(4, 3, 1, 1, 0, 0, DistortionModel.BROWN_CONRADY, 0.5, 0.75));
        assertTrue(camera.toString(), camera.toString().endsWith("distortion=[0.5, 0.25]]"));
    }

    @Test
    public void listenersHearAndStop() {
        try (Fitter fitter = Scene.loaded()) {
            Set<Phase> phases = EnumSet.noneOf(Phase.class);
            List<String> lines = new ArrayList<>();
            fitter.setProgressListener(progress -> phases.add(progress.phase()) || true);
            fitter.setLogListener(LogLevel.INFO, (level, line) -> lines.add(line));
            fitter.fit();
            assertEquals(EnumSet.allOf(Phase.class), phases);
            assertTrue(lines.size() > 0 && lines.stream().noneMatch(String::isEmpty));
            fitter.setLogListener(LogLevel.OFF, null);

            fitter.setProgressListener(progress -> false);
            fails(Status.CANCELLED, fitter::fit, "");
            fitter.setProgressListener(progress -> {
                throw new ArithmeticException("from the listener");
            });
            assertThrows(ArithmeticException.class, fitter::fit);
            // A checked one, as from a language that declares none.
            fitter.setProgressListener(progress -> FitterTest.<RuntimeException>hurl(new IOException("undeclared")));
            assertThrows(IOException.class, fitter::fit);
            fitter.setProgressListener(null);
            fitter.setLogListener(LogLevel.DEBUG, (level, line) -> FitterTest.<RuntimeException>hurl(new IOException("undeclared")));
            assertThrows(IOException.class, fitter::fit);
            fitter.setLogListener(LogLevel.OFF, null);
            fitter.setProgressListener(progress -> {
                fitter.clear();
                return true;
            });
            fails(Status.BUSY, fitter::fit, "busy");
            fitter.setProgressListener(null);
            fitter.cancel(); // no fit is running: nothing happens
            assertEquals(Scene.TRUTH.radius(), fitter.fit().model().radius(), 1e-3);
        }
    }
}
