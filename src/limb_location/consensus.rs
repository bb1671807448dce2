//! The rough limb line: the line along which the image has an edge almost everywhere.
//!
//! A single strong edge (a tile of the background, a letter of a label, the rim of a cap) covers a short
//! stretch; the limb is weak perhaps, but long. Every line that crosses the strip within reach of the expected
//! one is scored by the sum over short blocks of ln(1 + t²), t the significance of an edge there, which lets no
//! block count for much more than another, and by the significance of all blocks together.

use super::strip::Strip;
use crate::memory::List;
use pulp::{Arch, Simd, WithSimd};

/// Pixels on either side of an edge that the step filter spans.
pub(super) const FILTER_HALF: usize = 3;

/// Weights of the step filter on one side, from the edge outwards: a step less its part along a ramp, so that
/// shading without an edge gives nothing. At v = ½, 1½, 2½: 1 − v Σ|v| / Σv².
const FILTER: [f64; FILTER_HALF] =
    [0.742_857_142_857_142_9, 0.228_571_428_571_428_6, -0.285_714_285_714_285_7];

constants! {
    /// Spacing of the lines that are tried, at either end of the strip, in pixels: half the width of the filter's
    /// response to a sharp step.
    LINE_STEP = 0.5, "px";

    /// How many runs form a block: edges shorter than this are no evidence, and polarity may change from one block
    /// to the next.
    pub(super) BLOCK_RUNS = 8.0, "rows";

    /// A significance in the sum along the whole line that counts as full: beyond it a short strong edge would pass
    /// for a long one.
    FULL_SIGNIFICANCE = 6.0, "σ";

    /// How many standard deviations above what noise gives an edge must be: of a thousand lines on noise alone the
    /// best is at 3.3.
    VISIBLE_DEVIATIONS = 4.0, "σ";

    /// Fewest blocks that a limb is located on: one of them may be wrong.
    pub(super) LEAST_BLOCKS = 3.0, "blocks";
}

/// Mean and variance of ln(1 + t²) for Gaussian t: what a block without any edge gives.
const NOISE_MEAN: f64 = 0.535;
const NOISE_VARIANCE: f64 = 0.45;

/// A line across the strip by its u at both ends, s = ∓ half length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RoughLine {
    /// u at s = −half length and s = +half length.
    pub ends: [f64; 2],
    /// Twice the log-evidence of an edge along the line, less the prior.
    pub score: f64,
    /// Whether noise alone would not give as much.
    pub visible: bool,
}

/// 2⁵²: a number from here on is a whole one, and ends with what was added.
const WHOLE: f64 = 4_503_599_627_370_496.0;

/// Lines whose evidence is summed side by side.
const LINES: usize = 8;

/// Responses of the step filter in one run.
struct Response {
    s: f64,
    first_u: f64,
    step: f64,
    /// Each response with the next one; zeros at the end.
    pairs: List<[f64; 2]>,
}

/// The best line within `reach` pixels of u = 0 at both ends, where it is expected with a standard deviation of
/// `deviation` pixels; `None` when the strip is too short. `noise` is that of a pixel of the strip.
pub(super) fn rough_line(
    strip: &Strip,
    noise: f64,
    half_length: f64,
    reach: f64,
    deviation: f64,
) -> Option<RoughLine> {
    let norm = (2.0 * FILTER.iter().map(|w| w * w).sum::<f64>()).sqrt() * noise;
    let responses: List<Response> = strip.runs().filter_map(|run| respond(run, norm)).collect();
    if responses.len() < LEAST_BLOCKS.count() * BLOCK_RUNS.count() {
        return None;
    }
    let blocks = responses.len().div_ceil(BLOCK_RUNS.count()) as f64;
    let needed = blocks * NOISE_MEAN
        + VISIBLE_DEVIATIONS.get() * (blocks * NOISE_VARIANCE).sqrt()
        + VISIBLE_DEVIATIONS.get() * VISIBLE_DEVIATIONS.get();
    let count = (reach / LINE_STEP.get()).ceil().max(1.0) as usize;
    let places = 2 * count + 1;
    let place = |k: usize| (k as f64 - count as f64) * reach / count as f64;
    let mut best: Option<RoughLine> = None;
    for first in (0..places * places).step_by(LINES) {
        // Those beyond the last are not looked at.
        let ends: [_; LINES] =
            std::array::from_fn(|k| [place((first + k) / places), place((first + k) % places)]);
        let evidence = Arch::new().dispatch(Evidence { responses: &responses, half_length, ends: &ends });
        for ((ends, evidence), _) in ends.into_iter().zip(evidence).zip(first..places * places) {
            let deviations = ends.map(|u| u / deviation);
            let prior = deviations[0] * deviations[0] + deviations[1] * deviations[1];
            let score = evidence - prior;
            if best.is_none_or(|best| score > best.score) {
                best = Some(RoughLine { ends, score, visible: score >= needed });
            }
        }
    }
    best
}

/// The step filter at every place of a run between two pixels, in units of its noise.
fn respond(run: &[super::strip::StripPixel], norm: f64) -> Option<Response> {
    let count = run.len().checked_sub(2 * FILTER_HALF - 1).filter(|&count| count >= 2)?;
    let step = (run[run.len() - 1].u - run[0].u) / (run.len() - 1) as f64;
    let mut values = (0..count).map(|k| {
        let sum = |sum: f64, (d, w): (usize, &f64)| {
            sum + w * (run[k + FILTER_HALF + d].value - run[k + FILTER_HALF - 1 - d].value)
        };
        FILTER.iter().enumerate().fold(0.0, sum) / norm
    });
    let first_u = run[0].u + step * (FILTER_HALF as f64 - 0.5);
    let mut below = values.next()?;
    let mut pairs = List::with_capacity(count);
    pairs.extend(values.map(|above| [std::mem::replace(&mut below, above), above]));
    pairs.push([0.0; 2]);
    Some(Response { s: run[run.len() / 2].s, first_u, step, pairs })
}

/// Twice the log-evidence of an edge along each of some lines, given by u at their ends.
struct Evidence<'a> {
    responses: &'a [Response],
    half_length: f64,
    ends: &'a [[f64; 2]; LINES],
}

impl WithSimd for Evidence<'_> {
    type Output = [f64; LINES];

    /// Plain loops over the lines, which the compiler makes the widest instructions of the machine of. Each line has the sums
    /// that it has alone.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> [f64; LINES] {
        let Self { responses, half_length, ends } = self;
        let middle = ends.map(|ends| f64::midpoint(ends[0], ends[1]));
        let slope = ends.map(|ends| (ends[1] - ends[0]) / (2.0 * half_length));
        let mut products: [Logarithm; LINES] = std::array::from_fn(|_| Logarithm::default());
        let (mut sums_of_all, mut blocks) = ([0.0; LINES], 0.0);
        for block in responses.chunks(BLOCK_RUNS.count()) {
            let mut sums = [0.0; LINES];
            for response in block {
                add_responses(response, &middle, &slope, &mut sums);
            }
            let norm = (block.len() as f64).sqrt();
            for ((sum, product), sum_of_all) in sums.iter().zip(&mut products).zip(&mut sums_of_all) {
                let t = sum / norm;
                product.add(1.0 + t * t);
                *sum_of_all += t.clamp(-FULL_SIGNIFICANCE.get(), FULL_SIGNIFICANCE.get());
            }
            blocks += 1.0;
        }
        // Of one polarity, the blocks tell more together than one by one.
        std::array::from_fn(|k| products[k].sum() + sums_of_all[k] * sums_of_all[k] / blocks)
    }
}

/// Adds to each sum what a run responds where a line crosses it: between two responses by both, outside of them 0.
#[inline(always)]
#[allow(clippy::needless_range_loop, reason = "closures are not inlined for sure")]
fn add_responses(response: &Response, middle: &[f64; LINES], slope: &[f64; LINES], sums: &mut [f64; LINES]) {
    let Response { s, first_u, step, pairs } = response;
    let last = (pairs.len() - 1) as f64;
    let (mut place, mut part) = ([0.0; LINES], [0.0; LINES]);
    for k in 0..LINES {
        let x = (middle[k] + slope[k] * s - first_u) / step;
        let x = if x >= 0.0 { x } else { last };
        let x = if x < last { x } else { last };
        // The whole number below; `f64::floor` is a call.
        let nearest = (x + WHOLE) - WHOLE;
        let whole = if nearest > x { nearest - 1.0 } else { nearest };
        part[k] = x - whole;
        place[k] = whole + WHOLE;
    }
    let (mut below, mut above) = ([0.0; LINES], [0.0; LINES]);
    for k in 0..LINES {
        [below[k], above[k]] = pairs[place[k].to_bits() as u32 as usize];
    }
    for k in 0..LINES {
        sums[k] += below[k] * (1.0 - part[k]) + above[k] * part[k];
    }
}

/// A sum of logarithms, of which hardly any is computed: the logarithm of a product is their sum.
struct Logarithm {
    sum: f64,
    product: f64,
}

impl Default for Logarithm {
    fn default() -> Self {
        Self { sum: 0.0, product: 1.0 }
    }
}

impl Logarithm {
    /// Adds the logarithm of a number, 1 at least.
    #[inline(always)]
    fn add(&mut self, number: f64) {
        /// Products beyond it might overflow with the next factor.
        const LARGE: f64 = 1e150;
        self.product *= number;
        if self.product > LARGE {
            self.sum += self.product.ln();
            self.product = 1.0;
        }
    }

    fn sum(&self) -> f64 {
        self.sum + self.product.ln()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a run responds at u.
    fn at(response: &Response, u: f64) -> f64 {
        let x = (u - response.first_u) / response.step;
        let inside = x >= 0.0 && x < (response.pairs.len() - 1) as f64;
        let [below, above] = response.pairs[if inside { x.floor() as usize } else { 0 }];
        let part = x - x.floor();
        if inside { below * (1.0 - part) + above * part } else { 0.0 }
    }

    #[test]
    fn lines_side_by_side_have_the_evidence_of_each_alone() {
        let responses: Vec<Response> = (0..29)
            .map(|k| {
                let value = |j: usize| ((7 * k + 3 * j) % 11) as f64 - 4.0;
                let mut pairs: List<[f64; 2]> = (0..12).map(|j| [value(j), value(j + 1)]).collect();
                pairs.push([0.0; 2]);
                Response { s: k as f64 - 14.0, first_u: -5.5 - 0.01 * k as f64, step: 0.97, pairs }
            })
            .collect();
        // Some leave the runs at either side.
        let ends: [[f64; 2]; LINES] = std::array::from_fn(|k| [2.0 * k as f64 - 7.0, 5.5 - 1.5 * k as f64]);
        let half_length = 15.0;
        let found = Arch::new().dispatch(Evidence { responses: &responses, half_length, ends: &ends });
        for ([first, last], found) in ends.into_iter().zip(found) {
            let (middle, slope) = (f64::midpoint(first, last), (last - first) / (2.0 * half_length));
            let (mut sum_of_logarithms, mut sum_of_all, mut blocks) = (0.0, 0.0, 0.0);
            for block in responses.chunks(BLOCK_RUNS.count()) {
                let sum: f64 = block.iter().map(|response| at(response, middle + slope * response.s)).sum();
                let t = sum / (block.len() as f64).sqrt();
                sum_of_logarithms += (1.0 + t * t).ln();
                sum_of_all += t.clamp(-FULL_SIGNIFICANCE.get(), FULL_SIGNIFICANCE.get());
                blocks += 1.0;
            }
            let plain = sum_of_logarithms + sum_of_all * sum_of_all / blocks;
            assert!((found - plain).abs() <= 1e-12 * plain, "{found} {plain}");
        }
    }
}
