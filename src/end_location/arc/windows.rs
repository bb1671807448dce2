//! How well blurred steps explain windows of profiles, some side by side.

use super::SAMPLE_PIXELS;
use super::profile::{Profile, Template};
use crate::statistics::{dot, total};

/// Windows side by side.
pub(super) const LANES: usize = 8;

/// Sums over windows, side by side, for the brightness of the surface, the cap and the background by least squares.
#[derive(Default)]
pub(super) struct Windows {
    /// How many samples there are.
    n: [f64; LANES],
    /// Of what lies beyond the surface (p) and beyond the cap (q), of the samples (y), and of their products.
    p: [f64; LANES],
    pp: [f64; LANES],
    py: [f64; LANES],
    q: [f64; LANES],
    qq: [f64; LANES],
    qy: [f64; LANES],
    pq: [f64; LANES],
    y: [f64; LANES],
    yy: [f64; LANES],
}

impl Windows {
    /// Makes number `k` that of a profile about a step at `edge`, in pixels across the arc.
    #[inline(always)]
    pub fn set(&mut self, k: usize, profile: &Profile, edge: f64, Template { steps, wall }: Template<'_>) {
        let cap = wall.map_or(profile.cap, |wall| profile.walls[wall]);
        let (first, last) = profile.window(edge);
        let samples = &profile.samples[first..=last];
        let origin = first as f64 - profile.zero - edge / SAMPLE_PIXELS.get();
        let (beyond, [p, pp]) = steps.at(origin, samples.len());
        let (py, [q, qq], qy, pq) = if cap < steps.reach {
            let (beyond_cap, sums) = steps.at(origin - cap / SAMPLE_PIXELS.get(), samples.len());
            let [py, qy, pq] = dots(beyond, beyond_cap, samples);
            (py, sums, qy, pq)
        } else {
            let py = dot(beyond, samples);
            (py, [p, pp], py, pp)
        };
        let (before, through) = (profile.sums[first], profile.sums[last + 1]);
        self.n[k] = (last + 1 - first) as f64;
        (self.p[k], self.pp[k], self.py[k]) = (p, pp, py);
        (self.q[k], self.qq[k], self.qy[k]) = (q, qq, qy);
        self.pq[k] = pq;
        (self.y[k], self.yy[k]) = (through.0 - before.0, through.1 - before.1);
    }

    /// How many samples a window has.
    pub fn samples(&self, k: usize) -> f64 {
        self.n[k]
    }

    /// How much larger the sums of squares about a constant brightness are than those about the steps.
    #[inline(always)]
    pub fn ratios(&self, noise: f64) -> [f64; LANES] {
        let (left, mut ratios) = (self.left(), [0.0; LANES]);
        for k in 0..LANES {
            let floor = self.n[k] * noise * noise;
            ratios[k] = (self.constant(k) + floor) / (left[k] + floor);
        }
        ratios
    }

    /// Sum of squares about the mean.
    #[inline(always)]
    fn constant(&self, k: usize) -> f64 {
        (self.yy[k] - self.y[k] * self.y[k] / self.n[k]).max(0.0)
    }

    /// Sums of squares about the best steps. Without branches, so that vector instructions are made of it.
    #[inline(always)]
    pub fn left(&self) -> [f64; LANES] {
        let Self { n, p, pp, py, q, qq, qy, pq, y, yy } = self;
        let mut left = [0.0; LANES];
        for k in 0..LANES {
            // The parts of the template are 1 − p, p − q and q: surface (s), cap (c) and background (b).
            let (ss, cc, bb) = (n[k] - 2.0 * p[k] + pp[k], pp[k] - 2.0 * pq[k] + qq[k], qq[k]);
            let (sc, cb, sb) = (p[k] - q[k] - pp[k] + pq[k], pq[k] - qq[k], q[k] - pq[k]);
            let (sy, cy, by) = (y[k] - py[k], py[k] - qy[k], qy[k]);
            let determinant = ss * bb - sb * sb;
            // The products of two vectors freed of what surface and background explain, times the determinant of these.
            let of_samples = bb * sy * sy - sb * (sy * by + by * sy) + ss * by * by;
            let of_both = bb * sc * sy - sb * (sc * by + cb * sy) + ss * cb * by;
            let of_cap = bb * sc * sc - sb * (sc * cb + cb * sc) + ss * cb * cb;
            // For a cap of brightness x it is A − 2 B x + C x².
            let a = (yy[k] - of_samples / determinant).max(0.0);
            let b = cy - of_both / determinant;
            let c = (cc - of_cap / determinant).max(0.0);
            let with_cap = (a - b * b / c).max(0.0);
            let best = if c > 1e-6 * n[k] { with_cap } else { a };
            left[k] = if determinant > 1e-9 * ss * bb { best } else { self.constant(k) };
        }
        left
    }
}

/// The sums of the products of three lists of the same length: p · y, q · y and p · q.
#[inline(always)]
fn dots(p: &[f64], q: &[f64], y: &[f64]) -> [f64; 3] {
    let ((p, p_rest), (q, q_rest), (y, y_rest)) =
        (p.as_chunks::<4>(), q.as_chunks::<4>(), y.as_chunks::<4>());
    let (mut py, mut qy, mut pq, mut rest) = ([0.0; 4], [0.0; 4], [0.0; 4], [0.0; 3]);
    for ((p, q), y) in p.iter().zip(q).zip(y) {
        for k in 0..4 {
            py[k] += p[k] * y[k];
            qy[k] += q[k] * y[k];
            pq[k] += p[k] * q[k];
        }
    }
    for ((p, q), y) in p_rest.iter().zip(q_rest).zip(y_rest) {
        rest[0] += p * y;
        rest[1] += q * y;
        rest[2] += p * q;
    }
    [total(py, rest[0]), total(qy, rest[1]), total(pq, rest[2])]
}
