//! The image along one generator, and how well a blurred step explains it.

use super::{BLURS, INDEPENDENT, LEAST_GAIN, RIM_BLURS, SAMPLE_PIXELS, SAMPLE_REACH_PIXELS, WINDOW_PIXELS};
use crate::memory::{List, apart};
use pulp::{Arch, Simd, WithSimd};
use std::borrow::Cow;
use std::f64::consts::FRAC_1_SQRT_2;
use std::sync::LazyLock;

/// How many thicknesses of a wall are tried.
pub(super) const WALLS: usize = 3;

/// What the image along a generator is compared with.
#[derive(Debug, Clone, Copy)]
pub(super) struct Template<'a> {
    /// The steps at the arc and at what lies beyond it.
    pub steps: &'a Steps,
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
    #[inline(always)]
    fn new(profile: &Profile, edge: f64, Template { steps, wall }: Template<'_>) -> Self {
        let cap = wall.map_or(profile.cap, |wall| profile.walls[wall]);
        let (first, last) = profile.window(edge);
        let samples = &profile.samples[first..=last];
        let origin = first as f64 - profile.zero - edge / SAMPLE_PIXELS.get();
        // Of what lies beyond the surface (p), and beyond the cap (q).
        let (beyond, [p, pp]) = steps.at(origin, samples.len());
        let (py, [q, qq], qy, pq) = if cap < steps.reach {
            let (beyond_cap, sums) = steps.at(origin - cap / SAMPLE_PIXELS.get(), samples.len());
            let [py, qy, pq] = dots(beyond, beyond_cap, samples);
            (py, sums, qy, pq)
        } else {
            let py = dot(beyond, samples);
            (py, [p, pp], py, pp)
        };
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
    #[inline(always)]
    fn constant(&self) -> f64 {
        (self.yy - self.y * self.y / self.n).max(0.0)
    }

    /// Sum of squares about the best steps.
    #[inline(always)]
    fn left(&self) -> f64 {
        let [a, b, c] = self.steps();
        if c > 1e-6 * self.n { (a - b * b / c).max(0.0) } else { a }
    }

    /// The same for a cap of brightness x: A − 2 B x + C x².
    #[inline(always)]
    fn steps(&self) -> [f64; 3] {
        let determinant = self.ss * self.bb - self.sb * self.sb;
        if !(determinant > 1e-9 * self.ss * self.bb) {
            return [self.constant(), 0.0, 0.0];
        }
        let (cap, samples) = ((self.sc, self.cb), (self.sy, self.by));
        [
            (self.yy - self.project(samples, samples) / determinant).max(0.0),
            self.cy - self.project(cap, samples) / determinant,
            (self.cc - self.project(cap, cap) / determinant).max(0.0),
        ]
    }

    /// The product of two vectors freed of what surface and background explain, times the determinant of these.
    #[inline(always)]
    fn project(&self, (s1, b1): (f64, f64), (s2, b2): (f64, f64)) -> f64 {
        self.bb * s1 * s2 - self.sb * (s1 * b2 + b1 * s2) + self.ss * b1 * b2
    }
}

/// The log-likelihood that a window gains where sums of squares have this ratio.
fn log_likelihood(ratio: f64) -> f64 {
    INDEPENDENT.get() * WINDOW_PIXELS.get() * ratio.ln()
}

/// By how much a step at the end circle, moved outward by `shift`, explains the profiles better than constant
/// brightness does: the sum of log-likelihoods, each with its own noise so that texture on one generator does
/// not count.
pub(super) fn gain(profiles: &[Profile], shift: f64, template: Template<'_>, noise: f64) -> f64 {
    Arch::new().dispatch(Gain { profiles, shift, template, noise })
}

/// What [`gain`] computes, with the widest instructions of the machine; they all round alike. No closures: what is not
/// inlined here does without them.
struct Gain<'a> {
    profiles: &'a [Profile],
    shift: f64,
    template: Template<'a>,
    noise: f64,
}

impl WithSimd for Gain<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> f64 {
        let Self { profiles, shift, template, noise } = self;
        let mut sum = 0.0;
        // The logarithm of eight ratios, of a million at most each, is as dear as that of one.
        for some in profiles.chunks(8) {
            let mut product = 1.0;
            for profile in some {
                product *= profile.ratio(shift * profile.across, template, noise);
            }
            sum += log_likelihood(product);
        }
        sum
    }
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
    #[inline(always)]
    fn window(&self, edge: f64) -> (usize, usize) {
        let last = self.place(edge + WINDOW_PIXELS.get()).min(self.samples.len() - 1);
        (self.place(edge - WINDOW_PIXELS.get()).min(last), last)
    }

    /// The sample nearest to a place.
    #[inline(always)]
    fn place(&self, edge: f64) -> usize {
        // Rounded; the conversion holds what is below 0 at 0.
        (edge / SAMPLE_PIXELS.get() + self.zero + 0.5) as u32 as usize
    }

    /// Whether light about a step at `edge` is cut off at white.
    pub fn is_cut_off(&self, edge: f64) -> bool {
        let (first, last) = self.window(edge);
        self.cut_off.iter().any(|sample| (first..=last).contains(sample))
    }

    /// How much larger the sum of squares about a constant brightness is than that about a step at `edge`, in pixels across the
    /// arc.
    #[inline(always)]
    fn ratio(&self, edge: f64, template: Template<'_>, noise: f64) -> f64 {
        let window = Window::new(self, edge, template);
        let floor = window.n * noise * noise;
        (window.constant() + floor) / (window.left() + floor)
    }

    /// What another template may gain there at most: all that is left but the noise.
    pub fn unexplained(&self, edge: f64, template: Template<'_>, noise: f64) -> f64 {
        let window = Window::new(self, edge, template);
        let floor = window.n * noise * noise;
        log_likelihood((window.left() + floor) / (2.0 * floor)).max(0.0)
    }

    /// The step of this profile alone near `expected`, and its standard deviation, in pixels across the arc.
    pub fn step(&self, expected: f64, template: Template<'_>, noise: f64) -> Option<(f64, f64)> {
        let side = 0.25;
        let reach = (SAMPLE_REACH_PIXELS.get() / side) as i64;
        let score = |k: i64| self.ratio(expected + side * k as f64, template, noise);
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
        let [before, best, after] = [before, best, after].map(log_likelihood);
        let curvature = (before - 2.0 * best + after) / (side * side);
        if k.abs() >= reach || best < LEAST_GAIN.get() || !(curvature < 0.0) {
            return None;
        }
        let shift = (-0.5 * (after - before) / side / curvature).clamp(-side, side);
        Some((edge + shift, (-1.0 / curvature).sqrt()))
    }
}

/// A step blurred by a Gauss curve, the normal distribution function, at the samples of a window: the same numbers
/// for all edges that lie at one place between two samples.
#[derive(Debug, Clone)]
pub(super) struct Steps {
    /// Standard deviation of the blur, in pixels.
    pub blur: f64,
    /// What lies farther beyond an edge than this does not shine into its window, in pixels.
    reach: f64,
    /// A row for each place, of `length` samples, of which `before` lie before the edge.
    rows: List<f64>,
    /// Of each row the sums of the samples and of their squares before each sample, and of all.
    sums: List<[f64; 2]>,
    length: usize,
    before: usize,
}

/// How many places between two samples are told apart.
const PLACES: usize = 64;

/// The steps of the blurs that are tried.
static TRIED: LazyLock<[Steps; BLURS.len()]> = LazyLock::new(|| apart(|| BLURS.map(Steps::new)));

impl Steps {
    /// The steps of the blurs that are tried.
    pub fn tried() -> Cow<'static, [Self; BLURS.len()]> {
        // What a window is may change from fit to fit there.
        if cfg!(feature = "sensitivity") { Cow::Owned(BLURS.map(Self::new)) } else { Cow::Borrowed(&TRIED) }
    }

    /// The steps of a blur.
    pub fn new(blur: f64) -> Self {
        let normal = &*NORMAL;
        let reach = WINDOW_PIXELS.get() + RIM_BLURS.get() * blur;
        let samples = |pixels: f64| (pixels / SAMPLE_PIXELS.get()).ceil() as usize + 2;
        let before = samples(reach + WINDOW_PIXELS.get());
        let length = before + samples(WINDOW_PIXELS.get());
        let mut rows = List::with_capacity((PLACES + 1) * length);
        let mut sums = List::with_capacity((PLACES + 1) * (length + 1));
        for place in 0..=PLACES {
            let part = place as f64 / PLACES as f64 - before as f64;
            let mut sum = [0.0; 2];
            sums.push(sum);
            for k in 0..length {
                let sample = normal.at((k as f64 + part) * SAMPLE_PIXELS.get() / blur);
                sum = [sum[0] + sample, sum[1] + sample * sample];
                rows.push(sample);
                sums.push(sum);
            }
        }
        Self { blur, reach, rows, sums, length, before }
    }

    /// The step in so many samples, the first of which lies `first` samples beyond the edge, and the sums of these and of
    /// their squares.
    #[inline(always)]
    fn at(&self, first: f64, count: usize) -> (&[f64], [f64; 2]) {
        let place = first + self.before as f64;
        // The conversion holds what is below 0 at 0.
        let whole = (place as u32 as usize).min(self.length - count);
        let row = ((place - whole as f64) * PLACES as f64 + 0.5) as usize;
        let row = row.min(PLACES);
        let start = row * self.length + whole;
        // There is one more of the sums in a row.
        let (before, through) = (self.sums[start + row], self.sums[start + row + count]);
        (&self.rows[start..start + count], [through[0] - before[0], through[1] - before[1]])
    }
}

/// The normal distribution function, from a table: there are some thousand numbers in the rows of a blur.
struct Normal([f64; TABLE + 2]);

/// The table covers ± 5 deviations.
const TABLE: usize = 512;
const TABLE_REACH: f64 = 5.0;

static NORMAL: LazyLock<Normal> = LazyLock::new(|| {
    let place = |k: usize| (2.0 * k as f64 / TABLE as f64 - 1.0) * TABLE_REACH;
    Normal(std::array::from_fn(|k| 0.5 * libm::erfc(-place(k) * FRAC_1_SQRT_2)))
});

impl Normal {
    fn at(&self, x: f64) -> f64 {
        let place = ((x + TABLE_REACH) * (TABLE as f64 / (2.0 * TABLE_REACH))).clamp(0.0, TABLE as f64);
        let (k, part) = (place as usize, place.fract());
        self.0[k] + part * (self.0[k + 1] - self.0[k])
    }
}

/// The sum of the products of two lists of the same length, four side by side.
#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    let (mut sums, mut rest) = ([0.0; 4], 0.0);
    for (a, b) in a.iter().zip(b) {
        for k in 0..4 {
            sums[k] += a[k] * b[k];
        }
    }
    for (a, b) in a_rest.iter().zip(b_rest) {
        rest += a * b;
    }
    total(sums, rest)
}

/// The same of three lists: p · y, q · y and p · q.
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

#[inline(always)]
fn total(sums: [f64; 4], rest: f64) -> f64 {
    (sums[0] + sums[2]) + (sums[1] + sums[3]) + rest
}
