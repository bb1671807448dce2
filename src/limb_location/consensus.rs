//! The rough limb line: the line along which the image has an edge almost everywhere.
//!
//! A single strong edge (a tile of the background, a letter of a label, the rim of a cap) covers a short
//! stretch; the limb is weak perhaps, but long. Every line that crosses the strip within reach of the expected
//! one is scored by the sum over short blocks of ln(1 + t²), t the significance of an edge there, which lets no
//! block count for much more than another, and by the significance of all blocks together. Labels and a patterned
//! background turn the polarity of a limb here and there: each turn along the line costs something.

use super::strip::{Pixels, Strip};
use crate::memory::List;
use pulp::{Arch, Simd, WithSimd};
use std::f64::consts::LN_2;

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

    /// How many form one of a strip too short for blocks of that many, at least.
    pub(super) LEAST_RUNS = 4.0, "rows";

    /// A significance in the sum along the whole line that counts as full: beyond it a short strong edge would pass
    /// for a long one.
    FULL_SIGNIFICANCE = 6.0, "σ";

    /// What it costs in that sum where the polarity changes from one block to the next: less, and noise would pass for
    /// edges that change all the time; with more, a label on the surface makes half of its limb count against the rest.
    POLARITY_CHANGE = 2.0, "σ";

    /// How many standard deviations above what noise gives an edge must be: of a thousand lines on noise alone the
    /// best is at 3.3.
    VISIBLE_DEVIATIONS = 4.0, "σ";

    /// Fewest blocks that a limb is located on: one of them may be wrong.
    pub(super) LEAST_BLOCKS = 3.0, "blocks";
}

/// The filter's response to a step turns its sign beside it, and is there at most 0.46 times as large, two pixels away. So a
/// response that is within that distance of one of the other sign, more than so many times as large, may be nothing else: of
/// a clear step it would count in full, too.
const LOBE: f64 = 2.0;
const LOBE_DISTANCE: usize = 2;

/// Mean and variance a block of the score of a line on Gaussian noise: a block without any edge gives ln(1 + t²) with 0.535
/// and 0.45, and all of them together, as polarity may change, the rest.
const NOISE_MEAN: f64 = 0.64;
const NOISE_VARIANCE: f64 = 0.65;

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

/// How many runs form a block of a strip of so many.
pub(super) fn runs_of_block(runs: usize) -> usize {
    runs.div_ceil(LEAST_BLOCKS.count()).clamp(LEAST_RUNS.count(), BLOCK_RUNS.count())
}

/// Whether a strip of so many runs has the blocks that a limb is located on.
pub(super) fn is_long_enough(runs: usize) -> bool {
    runs >= LEAST_BLOCKS.count() * LEAST_RUNS.count()
}

/// 2⁵²: a number from here on is a whole one, and ends with what was added.
const WHOLE: f64 = 4_503_599_627_370_496.0;

/// Far more than sums of evidence are rounded by.
const ROUNDING: f64 = 1e-6;

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

/// The blocks of a strip.
fn in_blocks(responses: &[Response]) -> std::slice::Chunks<'_, Response> {
    responses.chunks(runs_of_block(responses.len()))
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
    let mut room = Room::default();
    let responses: List<Response> = strip.runs().filter_map(|run| respond(&run, norm, &mut room)).collect();
    if !is_long_enough(responses.len()) {
        return None;
    }
    let blocks = in_blocks(&responses).len() as f64;
    let needed = blocks * NOISE_MEAN
        + VISIBLE_DEVIATIONS.get() * (blocks * NOISE_VARIANCE).sqrt()
        + VISIBLE_DEVIATIONS.get() * VISIBLE_DEVIATIONS.get();
    let count = (reach / LINE_STEP.get()).ceil().max(1.0) as usize;
    let positions = 2 * count + 1;
    let position = |k: usize| (k as f64 - count as f64) * reach / count as f64;
    let most = most_after(&responses);
    // The first best of some lines, given by the positions of their ends; those below a score need not be followed to their end.
    let best_of = |lines: usize, ends: &dyn Fn(usize) -> [usize; 2], least: f64| {
        let mut best: Option<RoughLine> = None;
        for first in (0..lines).step_by(LINES) {
            // Those beyond the last are not looked at.
            let ends: [_; LINES] = std::array::from_fn(|k| ends(first + k).map(position));
            let prior = ends.map(|ends| ends.map(|u| u / deviation)).map(|[a, b]| a * a + b * b);
            let least = best.map_or(least, |best| least.max(best.score));
            let least = prior.map(|prior| least + prior - ROUNDING);
            let asked = Lines { ends: &ends, least: &least };
            let evidence = Evidence { responses: &responses, most: &most, half_length, lines: asked };
            let evidence = Arch::new().dispatch(evidence);
            for (((ends, prior), evidence), _) in ends.into_iter().zip(prior).zip(evidence).zip(first..lines)
            {
                let score = evidence - prior;
                if best.is_none_or(|best| score > best.score) {
                    best = Some(RoughLine { ends, score, visible: score >= needed });
                }
            }
        }
        best
    };
    // One of the lines along the expected one is nearly the best, so that others are left early.
    let along = best_of(positions, &|k| [k, k], f64::NEG_INFINITY)?;
    best_of(positions * positions, &|k| [k / positions, k % positions], along.score)
}

/// What the blocks that follow each block can add to the evidence of a line at most: to the sum of logarithms, and to the sum
/// along the best way of polarities.
fn most_after(responses: &[Response]) -> List<[f64; 2]> {
    let mut most = List::with_capacity(in_blocks(responses).len());
    let mut after = [0.0; 2];
    for block in in_blocks(responses).rev() {
        most.push(after);
        let largest =
            |response: &Response| response.pairs.iter().fold(0.0, |most, pair| pair[0].abs().max(most));
        let t = block.iter().map(largest).sum::<f64>() / (block.len() as f64).sqrt();
        after = [after[0] + (1.0 + t * t).ln(), after[1] + t.min(FULL_SIGNIFICANCE.get())];
    }
    most.reverse();
    most
}

/// The step filter at every position of a run between two pixels, in units of its noise.
fn respond(run: &Pixels<'_>, norm: f64, room: &mut Room) -> Option<Response> {
    let Pixels { s, u, values, .. } = *run;
    let count = values.len().checked_sub(2 * FILTER_HALF - 1).filter(|&count| count >= 2)?;
    let step = (u[u.len() - 1] - u[0]) / (u.len() - 1) as f64;
    let pairs = Arch::new().dispatch(Filter { values, norm, count, room });
    let first_u = u[0] + step * (FILTER_HALF as f64 - 0.5);
    Some(Response { s: s[s.len() / 2], first_u, step, pairs })
}

/// Room for the numbers of one run, which the next one has again.
#[derive(Default)]
struct Room {
    /// What the filter responds; zeros on both sides.
    all: List<f64>,
    /// The same without lobes.
    own: List<f64>,
}

/// The step filter along a run. Plain loops, which the compiler makes the widest instructions of the machine of; they all round
/// alike.
struct Filter<'a> {
    values: &'a [f64],
    norm: f64,
    /// How many positions there are.
    count: usize,
    room: &'a mut Room,
}

impl WithSimd for Filter<'_> {
    /// [`Response::pairs`].
    type Output = List<[f64; 2]>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Self::Output {
        let Self { values, norm, count, room: Room { all, own } } = self;
        all.clear();
        all.resize(count + 2 * LOBE_DISTANCE, 0.0);
        for (response, values) in all[LOBE_DISTANCE..].iter_mut().zip(values.windows(2 * FILTER_HALF)) {
            let mut sum = 0.0;
            for (d, weight) in FILTER.iter().enumerate() {
                sum += weight * (values[FILTER_HALF + d] - values[FILTER_HALF - 1 - d]);
            }
            *response = sum / norm;
        }
        own.resize(count, 0.0);
        for (own, near) in own.iter_mut().zip(all.windows(2 * LOBE_DISTANCE + 1)) {
            let response = near[LOBE_DISTANCE];
            let (mut low, mut high) = (0.0, 0.0);
            for other in near {
                low = if *other < low { *other } else { low };
                high = if *other > high { *other } else { high };
            }
            let of_other_sign = if response > 0.0 { -low } else { high };
            *own = if of_other_sign > LOBE * response.abs() { 0.0 } else { response };
        }
        let mut pairs = List::filled([0.0; 2], count);
        for (pair, own) in pairs.iter_mut().zip(own.windows(2)) {
            *pair = [own[0], own[1]];
        }
        pairs
    }
}

/// Some lines, given by u at their ends, and the evidence that each of them needs to be of interest.
struct Lines<'a> {
    ends: &'a [[f64; 2]; LINES],
    least: &'a [f64; LINES],
}

/// Twice the log-evidence of an edge along each of some lines; minus infinity for all where none has as much as it needs.
struct Evidence<'a> {
    responses: &'a [Response],
    /// What the blocks after each can add at most: [`most_after`].
    most: &'a [[f64; 2]],
    half_length: f64,
    lines: Lines<'a>,
}

impl WithSimd for Evidence<'_> {
    type Output = [f64; LINES];

    /// Plain loops over the lines, which the compiler makes the widest instructions of the machine of. Each line has the sums
    /// that it has alone.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> [f64; LINES] {
        let Self { responses, most, half_length, lines: Lines { ends, least } } = self;
        let count = most.len() as f64;
        let middle = ends.map(|ends| f64::midpoint(ends[0], ends[1]));
        let slope = ends.map(|ends| (ends[1] - ends[0]) / (2.0 * half_length));
        let mut products: [Logarithm; LINES] = std::array::from_fn(|_| Logarithm::default());
        // The sum of all blocks along the best way of polarities that ends with either of them.
        let (mut rising, mut falling) = ([0.0_f64; LINES], [0.0_f64; LINES]);
        for (block, [most_logarithm, most_significance]) in in_blocks(responses).zip(most) {
            let mut sums = [0.0; LINES];
            for response in block {
                add_responses(response, &middle, &slope, &mut sums);
            }
            let norm = (block.len() as f64).sqrt();
            for k in 0..LINES {
                let t = sums[k] / norm;
                products[k].add(1.0 + t * t);
                let t = t.clamp(-FULL_SIGNIFICANCE.get(), FULL_SIGNIFICANCE.get());
                let turned = [falling[k], rising[k]].map(|sum| sum - POLARITY_CHANGE.get());
                rising[k] = rising[k].max(turned[0]) + t;
                falling[k] = falling[k].max(turned[1]) - t;
            }
            let mut open = 0;
            for k in 0..LINES {
                let significance = rising[k].max(falling[k]) + most_significance;
                let most = products[k].most() + most_logarithm + significance * significance / count;
                // So that what is not a number is followed to its end.
                open += usize::from(!(most < least[k]));
            }
            if open == 0 {
                return [f64::NEG_INFINITY; LINES];
            }
        }
        // The blocks tell more together than one by one.
        std::array::from_fn(|k| products[k].sum() + rising[k].max(falling[k]).powi(2) / count)
    }
}

/// Adds to each sum what a run responds where a line crosses it: between two responses by both, outside of them 0.
#[inline(always)]
#[allow(clippy::needless_range_loop, reason = "closures are not inlined for sure")]
fn add_responses(response: &Response, middle: &[f64; LINES], slope: &[f64; LINES], sums: &mut [f64; LINES]) {
    let Response { s, first_u, step, pairs } = response;
    let last = (pairs.len() - 1) as f64;
    let (mut index, mut part) = ([0.0; LINES], [0.0; LINES]);
    for k in 0..LINES {
        let x = (middle[k] + slope[k] * s - first_u) / step;
        let x = if x >= 0.0 { x } else { last };
        let x = if x < last { x } else { last };
        // The whole number below; `f64::floor` is a call.
        let nearest = (x + WHOLE) - WHOLE;
        let whole = if nearest > x { nearest - 1.0 } else { nearest };
        part[k] = x - whole;
        index[k] = whole + WHOLE;
    }
    let (mut below, mut above) = ([0.0; LINES], [0.0; LINES]);
    for k in 0..LINES {
        [below[k], above[k]] = pairs[index[k].to_bits() as u32 as usize];
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

    /// A number that is no less than the sum, by the exponent of the product alone.
    #[inline(always)]
    fn most(&self) -> f64 {
        let exponent = f64::from_bits(self.product.to_bits() >> 52 | WHOLE.to_bits()) - WHOLE;
        self.sum + (exponent - 1022.0) * LN_2
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limb_location::strip::StripPixel;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};

    /// What a run responds at u.
    fn at(response: &Response, u: f64) -> f64 {
        let x = (u - response.first_u) / response.step;
        let inside = x >= 0.0 && x < (response.pairs.len() - 1) as f64;
        let [below, above] = response.pairs[if inside { x.floor() as usize } else { 0 }];
        let part = x - x.floor();
        if inside { below * (1.0 - part) + above * part } else { 0.0 }
    }

    fn evidence_of(
        responses: &[Response],
        half_length: f64,
        ends: &[[f64; 2]; LINES],
        least: f64,
    ) -> [f64; LINES] {
        let lines = Lines { ends, least: &[least; LINES] };
        Arch::new().dispatch(Evidence { responses, most: &most_after(responses), half_length, lines })
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
        let found = evidence_of(&responses, half_length, &ends, f64::NEG_INFINITY);
        for ([first, last], found) in ends.into_iter().zip(found) {
            let (middle, slope) = (f64::midpoint(first, last), (last - first) / (2.0 * half_length));
            let (mut sum_of_logarithms, mut blocks) = (0.0, Vec::new());
            for block in in_blocks(&responses) {
                let sum: f64 = block.iter().map(|response| at(response, middle + slope * response.s)).sum();
                let t = sum / (block.len() as f64).sqrt();
                sum_of_logarithms += (1.0 + t * t).ln();
                blocks.push(t.clamp(-FULL_SIGNIFICANCE.get(), FULL_SIGNIFICANCE.get()));
            }
            // Every way of polarities, one bit a block.
            let sum = |way: u32| {
                let of_block = |k: usize| if way >> k & 1 == 1 { -blocks[k] } else { blocks[k] };
                let changes = (way ^ way >> 1) & ((1 << (blocks.len() - 1)) - 1);
                (0..blocks.len()).map(of_block).sum::<f64>()
                    - f64::from(changes.count_ones()) * POLARITY_CHANGE.get()
            };
            let best = (0..1 << blocks.len()).map(sum).fold(f64::NEG_INFINITY, f64::max);
            let plain = sum_of_logarithms + best * best / blocks.len() as f64;
            assert!((found - plain).abs() <= 1e-12 * plain, "{found} {plain}");
            // A line that has what it needs is followed to its end.
            let ends = [[first, last]; LINES];
            assert_eq!(evidence_of(&responses, half_length, &ends, found)[0], found);
        }
    }

    /// A strip of 60 rows whose brightness at each u is told by the row.
    fn strip(brightness: impl Fn(usize, f64) -> f64) -> Strip {
        let run = |row: usize| {
            let pixel = |k: usize| {
                let (s, u) = (row as f64 - 29.5, k as f64 - 14.0);
                StripPixel { s, u, value: brightness(row, u), saturated: false }
            };
            (0..29).map(pixel).collect()
        };
        Strip::of_runs((0..60).map(run))
    }

    /// A step at u = 0 as a lens in focus shows it.
    fn step(u: f64) -> f64 {
        libm::erf(u / (0.8 * 2.0_f64.sqrt()))
    }

    fn line_of(strip: &Strip) -> RoughLine {
        rough_line(strip, 1.0, 29.5, 6.0, 2.0).unwrap()
    }

    /// The evidence of an upright line.
    fn evidence(strip: &Strip, u: f64) -> f64 {
        let norm = (2.0 * FILTER.iter().map(|w| w * w).sum::<f64>()).sqrt();
        let mut room = Room::default();
        let responses: Vec<Response> =
            strip.runs().filter_map(|run| respond(&run, norm, &mut room)).collect();
        evidence_of(&responses, 29.5, &[[u; 2]; LINES], f64::NEG_INFINITY)[0]
    }

    #[test]
    fn two_pixels_beside_a_clear_step_there_is_no_second_edge() {
        let strip = strip(|_, u| 200.0 * step(u - 0.5));
        let at_the_step = evidence(&strip, 0.5);
        for u in [-1.5, 2.5] {
            let beside = evidence(&strip, u);
            assert!(beside < 0.1 * at_the_step, "{beside} {at_the_step}");
        }
    }

    #[test]
    fn a_limb_whose_polarity_changes_is_as_good_as_another() {
        let score = |bright: usize| line_of(&strip(|row, u| if row < bright { 5.0 } else { -5.0 } * step(u)));
        let (alike, changing) = (score(60), score(32));
        assert!(changing.score > 0.85 * alike.score, "{alike:?} {changing:?}");
        assert_eq!(changing.ends, [0.0; 2]);
    }

    #[test]
    fn noise_is_no_limb() {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let mut uniform = || f64::from(rng.next_u32()) / f64::from(u32::MAX);
        // Twelve uniform numbers are nearly Gaussian, with variance 1.
        let mut noise = || (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
        for (rows, repeat) in [24, 60, 400, 1200].into_iter().flat_map(|rows| (0..20).map(move |k| (rows, k)))
        {
            let half_length = f64::from(rows - 1) / 2.0;
            let run = |row: i32| {
                let mut pixel = |u: i32| StripPixel {
                    s: f64::from(row) - half_length,
                    u: f64::from(u),
                    value: noise(),
                    saturated: false,
                };
                (-14..=14).map(&mut pixel).collect()
            };
            let strip = Strip::of_runs((0..rows).map(run));
            let found = rough_line(&strip, 1.0, half_length, 6.0, 2.0).unwrap();
            assert!(!found.visible, "{rows} rows, {repeat}: {found:?}");
        }
    }
}
