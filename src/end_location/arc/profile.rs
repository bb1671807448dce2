//! The image along one generator, and how well a blurred step explains it.

use super::windows::{LANES, Windows};
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
    /// Pixels across the arc by length along the axis; negative across the far rim, which is sampled inward.
    pub across: f64,
    /// Width of the cap beyond the arc in pixels across the arc; infinite where none is seen.
    pub cap: f64,
    /// The same of the edge of a wall, for each thickness that is tried; no wider than the cap.
    pub walls: [f64; WALLS],
    /// Brightness every `SAMPLE_PIXELS` outward, on the far rim inward, less the mean against cancellation; the sample `zero` lies on the
    /// rough end.
    pub samples: List<f64>,
    /// Sums of the samples and of their squares before each sample, and of all.
    pub sums: List<(f64, f64)>,
    pub zero: f64,
    /// The samples whose light may be any from their value on.
    cut_off: List<usize>,
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
        for some in profiles.chunks(LANES) {
            let mut windows = Windows::default();
            for (k, profile) in some.iter().enumerate() {
                windows.set(k, profile, shift * profile.across, template);
            }
            let mut product = 1.0;
            for ratio in windows.ratios(noise).iter().take(some.len()) {
                product *= ratio;
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
        Self { angle, across, cap, walls, samples, sums, zero, cut_off: List::apart() }
    }

    /// The same with samples whose light may be any from their value on.
    pub fn with_cut_off(self, cut_off: List<usize>) -> Self {
        Self { cut_off, ..self }
    }

    /// The first and the last sample that a step at `edge` is judged by.
    #[inline(always)]
    pub fn window(&self, edge: f64) -> (usize, usize) {
        let last = self.nearest(edge + WINDOW_PIXELS.get()).min(self.samples.len() - 1);
        (self.nearest(edge - WINDOW_PIXELS.get()).min(last), last)
    }

    /// The sample nearest to a position.
    #[inline(always)]
    fn nearest(&self, edge: f64) -> usize {
        // Rounded; the conversion holds what is below 0 at 0.
        (edge / SAMPLE_PIXELS.get() + self.zero + 0.5) as u32 as usize
    }

    /// Whether light about a step at `edge` is cut off at white.
    pub fn is_cut_off(&self, edge: f64) -> bool {
        let (first, last) = self.window(edge);
        self.cut_off.iter().any(|sample| (first..=last).contains(sample))
    }

    /// What another template may gain there at most: all that is left but the noise.
    pub fn unexplained(&self, edge: f64, template: Template<'_>, noise: f64) -> f64 {
        let mut windows = Windows::default();
        windows.set(0, self, edge, template);
        let floor = windows.samples(0) * noise * noise;
        log_likelihood((windows.left()[0] + floor) / (2.0 * floor)).max(0.0)
    }

    /// The step of this profile alone near `expected`, and its standard deviation, in pixels across the arc.
    pub fn step(&self, expected: f64, template: Template<'_>, noise: f64) -> Option<(f64, f64)> {
        let Found { k, ratios } = Arch::new().dispatch(Step { profile: self, expected, template, noise });
        let edge = expected + SIDE * k as f64;
        let [before, best, after] = ratios.map(log_likelihood);
        let curvature = (before - 2.0 * best + after) / (SIDE * SIDE);
        let reach = (SAMPLE_REACH_PIXELS.get() / SIDE) as i64;
        if k.abs() >= reach || best < LEAST_GAIN.get() || !(curvature < 0.0) {
            return None;
        }
        let shift = (-0.5 * (after - before) / SIDE / curvature).clamp(-SIDE, SIDE);
        Some((edge + shift, (-1.0 / curvature).sqrt()))
    }
}

/// Spacing of the positions at which the step of a single profile is looked for, in pixels.
const SIDE: f64 = 0.25;

/// Which of these positions explains a profile best, and the ratios before it, there and after it.
struct Found {
    k: i64,
    ratios: [f64; 3],
}

/// The search for the step of a single profile, with the widest instructions of the machine; they all round alike.
struct Step<'a> {
    profile: &'a Profile,
    expected: f64,
    template: Template<'a>,
    noise: f64,
}

impl WithSimd for Step<'_> {
    type Output = Found;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Found {
        let Self { profile, expected, template, noise } = self;
        let reach = (SAMPLE_REACH_PIXELS.get() / SIDE) as i64;
        // Every other position first: a step is wider than that.
        let (mut rough, mut value, mut beside) = (-reach, f64::NEG_INFINITY, [0.0; 2]);
        let mut last = 0.0;
        let mut first = -reach;
        while first <= reach {
            let mut windows = Windows::default();
            let count = LANES.min((reach - first) as usize / 2 + 1);
            for k in 0..count {
                let edge = expected + SIDE * (first + 2 * k as i64) as f64;
                windows.set(k, profile, edge, template);
            }
            for ratio in windows.ratios(noise).iter().take(count) {
                if first == rough + 2 {
                    beside[1] = *ratio;
                }
                if *ratio >= value {
                    (rough, value, beside) = (first, *ratio, [last, 0.0]);
                }
                last = *ratio;
                first += 2;
            }
        }
        let mut windows = Windows::default();
        windows.set(0, profile, expected + SIDE * (rough - 1) as f64, template);
        windows.set(1, profile, expected + SIDE * (rough + 1) as f64, template);
        let [below, above, ..] = windows.ratios(noise);
        if value >= below.max(above) {
            Found { k: rough, ratios: [below, value, above] }
        } else if above > below {
            Found { k: rough + 1, ratios: [value, above, beside[1]] }
        } else {
            Found { k: rough - 1, ratios: [beside[0], below, value] }
        }
    }
}

/// A step blurred by a Gaussian, the normal distribution function, at the samples of a window: the same numbers
/// for all edges that lie at one position between two samples.
#[derive(Debug, Clone)]
pub(super) struct Steps {
    /// Standard deviation of the blur, in pixels.
    pub blur: f64,
    /// What lies farther beyond an edge than this does not shine into its window, in pixels.
    pub reach: f64,
    /// A row for each position, of `length` samples, of which `before` lie before the edge.
    rows: List<f64>,
    /// Of each row the sums of the samples and of their squares before each sample, and of all.
    sums: List<[f64; 2]>,
    length: usize,
    before: usize,
}

/// How many positions between two samples are told apart.
const PHASES: usize = 64;

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
        let mut rows = List::with_capacity((PHASES + 1) * length);
        let mut sums = List::with_capacity((PHASES + 1) * (length + 1));
        for phase in 0..=PHASES {
            let part = phase as f64 / PHASES as f64 - before as f64;
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
    pub fn at(&self, first: f64, count: usize) -> (&[f64], [f64; 2]) {
        let position = first + self.before as f64;
        // The conversion holds what is below 0 at 0.
        let whole = (position as u32 as usize).min(self.length - count);
        let row = ((position - whole as f64) * PHASES as f64 + 0.5) as usize;
        let row = row.min(PHASES);
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
    let position = |k: usize| (2.0 * k as f64 / TABLE as f64 - 1.0) * TABLE_REACH;
    Normal(std::array::from_fn(|k| 0.5 * libm::erfc(-position(k) * FRAC_1_SQRT_2)))
});

impl Normal {
    fn at(&self, x: f64) -> f64 {
        let position = ((x + TABLE_REACH) * (TABLE as f64 / (2.0 * TABLE_REACH))).clamp(0.0, TABLE as f64);
        let (k, part) = (position as usize, position.fract());
        self.0[k] + part * (self.0[k + 1] - self.0[k])
    }
}
