package org.cylfuse;

import static org.junit.Assert.assertEquals;
import static org.junit.Assert.assertNull;
import static org.junit.Assert.assertThrows;
import static org.junit.Assert.assertTrue;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import org.junit.Test;

public class BatchTest {
    /** Pieces of a pipe; that of the third is a line. */
    private static List<Fitter> fitters() {
        List<Fitter> fitters = new ArrayList<>();
        for (int k = 0; k < 8; k++) {
            double[] points = new double[3 * (200 + 10 * k)];
            for (int n = 0; n < points.length / 3; n++) {
                double angle = k == 2 ? 0 : 0.007 * n;
                points[3 * n] = 0.5 * Math.cos(angle);
                points[3 * n + 1] = 0.1 * (n % 7);
                points[3 * n + 2] = 2 - 0.5 * Math.sin(angle);
            }
            Fitter fitter = new Fitter();
            fitter.pushPoints(PointCloud.of(points));
            fitters.add(fitter);
        }
        return fitters;
    }

    @Test
    public void fitsAreThoseOfSingleCalls() {
        List<Fitter> alone = fitters();
        for (int threads : new int[] {0, 1, 3}) {
            List<Fitter> fitters = fitters();
            boolean[] heard = new boolean[fitters.size()];
            CylfuseException[] failures = FitterBatch.fitAll(fitters, threads, (index, status) -> {
                heard[index] = status == (index == 2 ? Status.COLLINEAR_POINTS : Status.OK);
                return true;
            });
            for (int k = 0; k < heard.length; k++) {
                assertTrue(heard[k]);
                if (k == 2) {
                    assertEquals(Status.COLLINEAR_POINTS, failures[k].status());
                    assertTrue(failures[k].getMessage(), failures[k].getMessage().contains("line"));
                } else {
                    assertNull(failures[k]);
                    assertEquals(alone.get(k).fit().model(), fitters.get(k).result().model());
                }
                fitters.get(k).close();
            }
        }
        alone.forEach(Fitter::close);
    }

    @Test
    public void theRestCanBeStopped() {
        List<Fitter> fitters = fitters();
        CylfuseException[] failures = FitterBatch.fitAll(fitters, 1, (index, status) -> index < 3);
        for (int k = 0; k < failures.length; k++) {
            Status expected = k == 2 ? Status.COLLINEAR_POINTS : k < 4 ? Status.OK : Status.CANCELLED;
            assertEquals(expected, failures[k] == null ? Status.OK : failures[k].status());
        }
        assertTrue(failures[4].getMessage(), failures[4].getMessage().contains("cancel"));
        assertTrue(fitters.get(3).result().model().radius() > 0);
        assertThrows(CylfuseException.class, () -> fitters.get(4).result());
        assertThrows(IllegalArgumentException.class, () -> FitterBatch.fitAll(fitters, 2, (index, status) -> {
            throw new IllegalArgumentException("heard");
        }));
        List<Fitter> twice = List.of(fitters.get(0), fitters.get(0));
        CylfuseException refused = assertThrows(CylfuseException.class, () -> FitterBatch.fitAll(twice, 0, null));
        assertEquals(Status.INVALID_ARGUMENT, refused.status());
        IllegalArgumentException missing = assertThrows(
                IllegalArgumentException.class,
                () -> FitterBatch.fitAll(Arrays.asList(fitters.get(0), null), 0, null));
        assertEquals("fitters[1] is null; it must be a fitter", missing.getMessage());
        fitters.get(5).close();
        assertThrows(IllegalStateException.class, () -> FitterBatch.fitAll(fitters, 0, null));
        assertEquals(0, FitterBatch.fitAll(List.of(), 0, null).length);
        fitters.forEach(Fitter::close);
    }

    @Test
    public void aBusyFitterHasItsText() {
        List<Fitter> fitters = fitters().subList(0, 2);
        boolean[] heard = {false};
        fitters.get(0).setProgressListener(progress -> {
            CylfuseException[] failures = FitterBatch.fitAll(fitters, 2, null);
            assertEquals(Status.BUSY, failures[0].status());
            assertTrue(failures[0].getMessage(), failures[0].getMessage().contains("the handle is busy in another call"));
            assertNull(failures[1]);
            heard[0] = true;
            return true;
        });
        fitters.get(0).fit();
        assertTrue(heard[0]);
        fitters.forEach(Fitter::close);
    }
}
