//! The image along one generator, and how well a blurred step explains it.

use super::{INDEPENDENT, LEAST_GAIN, RIM_BLURS, SAMPLE_PIXELS, SAMPLE_REACH_PIXELS, WINDOW_PIXELS};
use crate::memory::List;
use std::f64::consts::FRAC_1_SQRT_2;
use std::sync::LazyLock;

/// How many thicknesses of a wall are tried.
pub(super) const WALLS: usize = 3;

/// What the image along a generator is compared with.
#[derive(Debug, Clone, Copy)]
pub(super) struct Template {
    /// Standard deviation of the blur, in pixels.
    pub blur: f64,
    /// The edge of a wall lies beyond the arc, of the thickness of this number.
    pub wall: Option<usize>,
}

/// The image along one generator about the rough end.
pub(super) struct Profile {
    pub angle: f64,
    /// Pixels across the arc by length along the axis.
    pub across: f64,
    /// Width of the cap beyond the arc in pixels across the arc; infinite where none is seen.
    pub cap: f64,
    /// The same of the edge of a wall, for each thickness that is tried; no wider than the cap.
    pub walls: [f64; WALLS],
    /// Brightness every `SAMPLE_PIXELS` outward, less the mean against cancellation; the sample `zero` lies on the
    /// rough end.
    pub samples: List<f64>,
    /// Sums of the samples and of their squares before each sample, and of all.
    sums: List<(f64, f64)>,
    pub zero: f64,
    /// The samples whose light may be any from their value on.
    cut_off: List<usize>,
}

/// Sums over a window for the brightness x of the surface, the cap and the background by least squares.
struct Window {
    n: f64,
    /// Sums of the products of the three parts of the template and the samples: surface, cap, background.
    ss: f64,
    sc: f64,
    cc: f64,
    cb: f64,
    bb: f64,
    sb: f64,
    sy: f64,
    cy: f64,
    by: f64,
    y: f64,
    yy: f64,
}

impl Window {
    fn new(profile: &Profile, edge: f64, template: Template, smooth_step: &SmoothStep) -> Self {
        let blur = template.blur;
        let cap = template.wall.map_or(profile.cap, |wall| profile.walls[wall]);
        let (first, last) = profile.window(edge);
        let has_cap = cap < WINDOW_PIXELS.get() + RIM_BLURS.get() * blur;
        // In units of the blur.
        let step = SAMPLE_PIXELS.get() / blur;
        let origin = ((first as f64 - profile.zero) * SAMPLE_PIXELS.get() - edge) / blur;
        let cap = cap / blur;
        // Of what lies beyond the surface (p), and beyond the cap (q).
        let (mut p, mut pp, mut py) = (0.0, 0.0, 0.0);
        let (mut q, mut qq, mut qy, mut pq) = (0.0, 0.0, 0.0, 0.0);
        for (y, k) in profile.samples[first..=last].iter().zip(0_u32..) {
            let at = origin + f64::from(k) * step;
            let beyond = smooth_step.at(at);
            p += beyond;
            pp += beyond * beyond;
            py += beyond * y;
            if has_cap {
                let beyond_cap = smooth_step.at(at - cap);
                q += beyond_cap;
                qq += beyond_cap * beyond_cap;
                qy += beyond_cap * y;
                pq += beyond * beyond_cap;
            }
        }
        if !has_cap {
            (q, qq, qy, pq) = (p, pp, py, pp);
        }
        let n = (last + 1 - first) as f64;
        let (before, through) = (profile.sums[first], profile.sums[last + 1]);
        let (y, yy) = (through.0 - before.0, through.1 - before.1);
        // The parts are 1 − p, p − q and q.
        Self {
            n,
            ss: n - 2.0 * p + pp,
            sc: p - q - pp + pq,
            cc: pp - 2.0 * pq + qq,
            cb: pq - qq,
            bb: qq,
            sb: q - pq,
            sy: y - py,
            cy: py - qy,
            by: qy,
            y,
            yy,
        }
    }

    /// Sum of squares about the mean.
    fn constant(&self) -> f64 {
        (self.yy - self.y * self.y / self.n).max(0.0)
    }

    /// Sum of squares about the best steps.
    fn left(&self) -> f64 {
        let [a, b, c] = self.steps();
        if c > 1e-6 * self.n { (a - b * b / c).max(0.0) } else { a }
    }

    /// The same for a cap of brightness x: A − 2 B x + C x².
    fn steps(&self) -> [f64; 3] {
        let determinant = self.ss * self.bb - self.sb * self.sb;
        if !(determinant > 1e-9 * self.ss * self.bb) {
            return [self.constant(), 0.0, 0.0];
        }
        // Product of two vectors freed of what surface and background explain.
        let project = |s1: f64, b1: f64, s2: f64, b2: f64| {
            (self.bb * s1 * s2 - self.sb * (s1 * b2 + b1 * s2) + self.ss * b1 * b2) / determinant
        };
        [
            (self.yy - project(self.sy, self.by, self.sy, self.by)).max(0.0),
            self.cy - project(self.sc, self.cb, self.sy, self.by),
            (self.cc - project(self.sc, self.cb, self.sc, self.cb)).max(0.0),
        ]
    }
}

/// The log-likelihood that a window gains where sums of squares have this ratio.
fn log_likelihood(ratio: f64) -> f64 {
    INDEPENDENT.get() * WINDOW_PIXELS.get() * ratio.ln()
}

/// By how much a step at the end circle, moved outward by `shift`, explains the profiles better than constant
/// brightness does: the sum of log-likelihoods, each with its own noise so that texture on one generator does
/// not count.
pub(super) fn gain(
    profiles: &[Profile],
    shift: f64,
    template: Template,
    noise: f64,
    smooth_step: &SmoothStep,
) -> f64 {
    profiles.iter().map(|profile| profile.gain(shift * profile.across, template, noise, smooth_step)).sum()
}

impl Profile {
    pub fn new(
        angle: f64,
        across: f64,
        cap: f64,
        walls: [f64; WALLS],
        mut samples: List<f64>,
        zero: f64,
    ) -> Self {
        let mean = samples.iter().sum::<f64>() / samples.len() as f64;
        let mut sums = List::with_capacity(samples.len() + 1);
        let mut sum = (0.0, 0.0);
        sums.push(sum);
        for sample in &mut samples {
            *sample -= mean;
            sum = (sum.0 + *sample, sum.1 + *sample * *sample);
            sums.push(sum);
        }
        Self { angle, across, cap, walls, samples, sums, zero, cut_off: List::new() }
    }

    /// The same with samples whose light may be any from their value on.
    pub fn with_cut_off(self, cut_off: List<usize>) -> Self {
        Self { cut_off, ..self }
    }

    /// The first and the last sample that a step at `edge` is judged by.
    fn window(&self, edge: f64) -> (usize, usize) {
        // Rounded; the conversion holds what is below 0 at 0.
        let place = |edge: f64| (edge / SAMPLE_PIXELS.get() + self.zero + 0.5) as u32 as usize;
        let last = place(edge + WINDOW_PIXELS.get()).min(self.samples.len() - 1);
        (place(edge - WINDOW_PIXELS.get()).min(last), last)
    }

    /// Whether light about a step at `edge` is cut off at white.
    pub fn is_cut_off(&self, edge: f64) -> bool {
        let (first, last) = self.window(edge);
        self.cut_off.iter().any(|sample| (first..=last).contains(sample))
    }

    /// The same for one profile and a step at `edge`, in pixels across the arc.
    pub fn gain(&self, edge: f64, template: Template, noise: f64, smooth_step: &SmoothStep) -> f64 {
        let window = Window::new(self, edge, template, smooth_step);
        let floor = window.n * noise * noise;
        log_likelihood((window.constant() + floor) / (window.left() + floor))
    }

    /// What another template may gain there at most: all that is left but the noise.
    pub fn unexplained(&self, edge: f64, template: Template, noise: f64, smooth_step: &SmoothStep) -> f64 {
        let window = Window::new(self, edge, template, smooth_step);
        let floor = window.n * noise * noise;
        log_likelihood((window.left() + floor) / (2.0 * floor)).max(0.0)
    }

    /// The step of this profile alone near `expected`, and its standard deviation, in pixels across the arc.
    pub fn step(
        &self,
        expected: f64,
        template: Template,
        noise: f64,
        smooth_step: &SmoothStep,
    ) -> Option<(f64, f64)> {
        let side = 0.25;
        let reach = (SAMPLE_REACH_PIXELS.get() / side) as i64;
        let score = |k: i64| self.gain(expected + side * k as f64, template, noise, smooth_step);
        // Every other place first: a step is wider than that.
        let places = (-reach..=reach).step_by(2).map(|k| (k, score(k)));
        let (rough, value) = places.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let (below, above) = (score(rough - 1), score(rough + 1));
        let (k, before, best, after) = if value >= below.max(above) {
            (rough, below, value, above)
        } else if above > below {
            (rough + 1, value, above, score(rough + 2))
        } else {
            (rough - 1, score(rough - 2), below, value)
        };
        let edge = expected + side * k as f64;
        let curvature = (before - 2.0 * best + after) / (side * side);
        if k.abs() >= reach || best < LEAST_GAIN.get() || !(curvature < 0.0) {
            return None;
        }
        let shift = (-0.5 * (after - before) / side / curvature).clamp(-side, side);
        Some((edge + shift, (-1.0 / curvature).sqrt()))
    }
}

/// A step blurred by a Gauss curve of unit deviation, the normal distribution function, from a table: it is
/// evaluated some hundred thousand times an end.
pub(super) struct SmoothStep([f64; TABLE + 1]);

/// The table covers ± 4 deviations.
const TABLE: usize = 512;
const TABLE_REACH: f64 = 4.0;

pub(super) static SMOOTH_STEP: LazyLock<SmoothStep> = LazyLock::new(|| {
    let place = |k: usize| (2.0 * k as f64 / TABLE as f64 - 1.0) * TABLE_REACH;
    SmoothStep(std::array::from_fn(|k| 0.5 * libm::erfc(-place(k) * FRAC_1_SQRT_2)))
});

impl SmoothStep {
    #[inline]
    fn at(&self, x: f64) -> f64 {
        let place = (x + TABLE_REACH) * (TABLE as f64 / (2.0 * TABLE_REACH)) + 0.5;
        // The conversion holds what is below the table at its first entry.
        self.0[(place as u32 as usize).min(TABLE)]
    }
}
