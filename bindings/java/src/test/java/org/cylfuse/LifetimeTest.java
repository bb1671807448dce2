package org.cylfuse;

import static org.junit.Assert.assertEquals;
import static org.junit.Assert.assertThrows;
import static org.junit.Assert.assertTrue;
import static org.junit.Assert.fail;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import java.util.concurrent.CountDownLatch;
import java.util.concurrent.ExecutionException;
import java.util.concurrent.ExecutorService;
import java.util.concurrent.Executors;
import java.util.concurrent.Future;
import java.util.concurrent.atomic.AtomicBoolean;
import org.junit.Test;

public class LifetimeTest {
    private static final int THREADS = 8;
    private static final int CYCLES = 10000;

    @Test
    public void aClosedFitterSaysSo() {
        Fitter fitter = new Fitter();
        fitter.close();
        fitter.close();
        assertThrows(IllegalStateException.class, fitter::fit);
        assertThrows(IllegalStateException.class, fitter::cancel);
    }

    @Test
    public void closeInsideACallWaitsForIt() {
        Fitter fitter = Scene.loaded();
        fitter.setProgressListener(progress -> {
            fitter.close();
            return true;
        });
        assertEquals(Scene.TRUTH.radius(), fitter.fit().model().radius(), 1e-3);
        assertThrows(IllegalStateException.class, fitter::fit);
    }

    /** A call that the other thread may keep from being made. */
    private static void free(Runnable call) {
        try {
            call.run();
        } catch (CylfuseException failure) {
            assertEquals(Status.BUSY, failure.status());
        }
    }

    /** Points that come and go between asking for their number and for their residuals. */
    @Test
    public void whatIsListedIsOfOneMoment() throws Exception {
        // At the distance 1 of the surface, each.
        double[] points = new double[150];
        for (int k = 0; k < 150; k += 3) {
            points[k] = 1.5;
        }
        PointCloud cloud = PointCloud.of(points);
        Cylinder along = new Cylinder(new Vector(0, 0, 0), new Vector(0, 0, 1), 0.5);
        AtomicBoolean ended = new AtomicBoolean();
        ExecutorService thread = Executors.newSingleThreadExecutor();
        try (Fitter fitter = new Fitter()) {
            Future<?> changing = thread.submit(() -> {
                for (int k = 0; !ended.get(); k++) {
                    if (k % 8 == 0) {
                        free(fitter::clear);
                    } else {
                        free(() -> fitter.pushPoints(cloud));
                    }
                }
            });
            for (int k = 0; k < 20000; k++) {
                free(() -> assertTrue(
                        Arrays.stream(fitter.residuals(ResidualKind.POINTS, along)).allMatch(distance -> distance == 1)));
                free(() -> fitter.pointParts(along));
            }
            ended.set(true);
            changing.get();
        } finally {
            ended.set(true);
            thread.shutdown();
        }
    }

    @Test
    public void closeInsideACallLeavesItsFailure() {
        Fitter fitter = Scene.loaded();
        fitter.setProgressListener(progress -> {
            fitter.close();
            return false;
        });
        assertEquals(Status.CANCELLED, assertThrows(CylfuseException.class, fitter::fit).status());
        assertThrows(IllegalStateException.class, fitter::fit);
    }

    @Test
    public void anotherThreadCancelsAFit() throws InterruptedException, ExecutionException {
        ExecutorService thread = Executors.newSingleThreadExecutor();
        try (Fitter fitter = Scene.loaded()) {
            CountDownLatch inside = new CountDownLatch(1);
            CountDownLatch cancelled = new CountDownLatch(1);
            fitter.setProgressListener(progress -> {
                inside.countDown();
                await(cancelled);
                return true;
            });
            Future<CylfuseException> fit = thread.submit(() -> assertThrows(CylfuseException.class, fitter::fit));
            inside.await();
            fitter.cancel();
            cancelled.countDown();
            assertEquals(Status.CANCELLED, fit.get().status());
        }
        thread.shutdown();
    }

    private static void await(CountDownLatch latch) {
        try {
            latch.await();
        } catch (InterruptedException interruption) {
            throw new IllegalStateException(interruption);
        }
    }

    @Test
    public void tenThousandCyclesLeaveMemoryFlat() throws IOException {
        // The Java heap is resident from the start (pom.xml); what grows after the first rounds is native.
        cycle(CYCLES, true);
        memoryStaysFlat(16, () -> cycle(CYCLES, true));
    }

    @Test
    public void theCleanerFreesWhatWasNotClosed() throws IOException {
        cycle(CYCLES, false);
        memoryStaysFlat(16, () -> cycle(CYCLES, false));
    }

    private static void cycle(int count, boolean close) {
        PointCloud points = PointCloud.of(Scene.pipe(50));
        FitOptions options = new FitOptions().maxThreads(1).start(StartKind.MOMENTS);
        for (int k = 0; k < count; k++) {
            Fitter fitter = new Fitter();
            fitter.setOptions(options);
            // Listeners that know their fitter do not keep it alive.
            fitter.setProgressListener(progress -> fitter != null);
            fitter.setLogListener(LogLevel.DEBUG, (level, line) -> fitter.hashCode());
            fitter.pushPoints(points);
            fitter.fit();
            if (close) {
                fitter.close();
            } else if (k % 1000 == 0) {
                // The collector does not know how large a fitter is; a program that never closes needs its runs.
                System.gc();
            }
        }
        System.gc();
    }

    /** A leak of one frame a cycle would be 1,000 times 100 kB. */
    @Test
    public void framesAreFreedWithTheirFitters() throws IOException {
        cycleFrames(200);
        memoryStaysFlat(16, () -> cycleFrames(1000));
    }

    private static void cycleFrames(int count) {
        DepthImage depth = DepthImage.of(Scene.depth(), Scene.WIDTH, Scene.HEIGHT, 1e-4);
        Image image = Image.of(Scene.grey(), Scene.WIDTH, Scene.HEIGHT);
        for (int k = 0; k < count; k++) {
            try (Fitter fitter = new Fitter();
                    Frame frame = new Frame()) {
                frame.setIntrinsics(Scene.CAMERA);
                frame.setDepth(depth);
                frame.setImage(image);
                fitter.useFrame(frame, null);
            }
        }
    }

    /** A leak shows every time, what a collector is late with does not. */
    static void memoryStaysFlat(int megabytes, Runnable use) throws IOException {
        long growth = 0;
        for (int round = 0; round < 3; round++) {
            long before = residentKilobytes();
            use.run();
            growth = residentKilobytes() - before;
            if (growth < megabytes * 1024L) {
                return;
            }
        }
        fail("memory grew by " + growth + " kB");
    }

    private static long residentKilobytes() throws IOException {
        return Files.readAllLines(Path.of("/proc/self/status")).stream()
                .filter(line -> line.startsWith("VmRSS:"))
                .mapToLong(line -> Long.parseLong(line.split("\\s+")[1]))
                .findFirst()
                .orElseThrow();
    }

    @Test
    public void eightThreadsOnTheirOwnFittersAgree() throws ExecutionException, InterruptedException {
        ExecutorService threads = Executors.newFixedThreadPool(THREADS);
        List<Future<FitResult>> futures = new ArrayList<>();
        for (int k = 0; k < THREADS; k++) {
            futures.add(threads.submit(() -> {
                try (Fitter fitter = Scene.loaded()) {
                    FitResult last = null;
                    for (int round = 0; round < 20; round++) {
                        last = fitter.fit();
                    }
                    return last;
                }
            }));
        }
        for (Future<FitResult> future : futures) {
            assertEquals(futures.get(0).get().model(), future.get().model());
            assertEquals(futures.get(0).get().cost(), future.get().cost(), 0);
        }
        threads.shutdown();
    }

    @Test
    public void oneFitterInTwoThreadsThrowsBusy() throws ExecutionException, InterruptedException {
        ExecutorService thread = Executors.newSingleThreadExecutor();
        try (Fitter fitter = Scene.loaded()) {
            // A fit that stays inside its listener until the other thread has tried.
            CountDownLatch inside = new CountDownLatch(1);
            CountDownLatch tried = new CountDownLatch(1);
            fitter.setProgressListener(progress -> {
                inside.countDown();
                await(tried);
                return true;
            });
            Future<FitResult> fit = thread.submit(fitter::fit);
            inside.await();
            assertEquals(Status.BUSY, assertThrows(CylfuseException.class, fitter::counts).status());
            assertEquals(Status.BUSY, assertThrows(CylfuseException.class, fitter::fit).status());
            tried.countDown();
            assertEquals(Scene.TRUTH.radius(), fit.get().model().radius(), 1e-3);
        }
        thread.shutdown();
    }

    @Test
    public void misuseFromEightThreadsNeverCrashes() throws ExecutionException, InterruptedException {
        ExecutorService threads = Executors.newFixedThreadPool(THREADS);
        for (int round = 0; round < 20; round++) {
            Fitter fitter = Scene.loaded();
            List<Future<?>> futures = new ArrayList<>();
            for (int k = 0; k < THREADS; k++) {
                boolean closes = k == 0;
                futures.add(threads.submit(() -> misuse(fitter, closes)));
            }
            for (Future<?> future : futures) {
                future.get();
            }
        }
        threads.shutdown();
    }

    private static void misuse(Fitter fitter, boolean closes) {
        for (int call = 0; call < 50; call++) {
            try {
                if (closes && call == 25) {
                    fitter.close();
                }
                if (call % 2 == 0) {
                    fitter.fit();
                } else {
                    fitter.residuals(ResidualKind.POINTS, null);
                }
            } catch (CylfuseException failure) {
                assertTrue(failure.status().toString(), failure.status() == Status.BUSY || failure.status() == Status.BAD_STATE);
            } catch (IllegalStateException closed) {
                assertTrue(closed.getMessage(), closed.getMessage().contains("closed"));
            }
        }
    }
}
