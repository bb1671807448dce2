//! From rough limb lines to lines within a few hundredths of a pixel: the profile model, fitted to short
//! blocks of both limbs at once.
//!
//! Each block has its own two levels of brightness, outside and inside (eliminated by variable projection);
//! each limb has its line and its shading relative to the level inside; the image has its blur. Gauss–Newton steps on
//! lines, shading and blur; in every step the blocks that disagree with the others about the line lose weight.

use super::consensus::{BLOCK_RUNS, RoughLine};
use super::profile::Profile;
use super::strip::Strip;
use crate::residuals::{Loss, TUKEY_EFFICIENT, Tukey, Wall};
use nalgebra::{Matrix2, Matrix4, SMatrix, SVector, Vector2, Vector4};
use std::ops::Range;

/// How far the profile reaches outside the limb, in pixels: more meets other things in the background.
pub(super) const OUTSIDE: f64 = 4.0;

/// How far the profile reaches inside the limb, in pixels: more meets labels, and shading turns from what two
/// coefficients describe.
pub(super) const INSIDE: f64 = 3.5;

/// Standard deviation of the coefficients of sin θ and 1 − cos θ relative to the brightness near the limb: what
/// lamps and paint do, so that noise is not explained by shading that no surface has.
const SHADING: f64 = 0.3;

/// Blur where the iteration starts, standard deviation in pixels: a lens in focus and the aperture of a pixel.
const FIRST_BLUR: f64 = 0.8;

/// Blur cannot be less than that of the aperture of a pixel, 1/√12.
const LEAST_BLUR: f64 = 0.29;

/// More blur than this leaves no limb within the profile.
const MOST_BLUR: f64 = 2.0;

/// Gauss–Newton steps at most; five to eight are usual.
const STEPS: usize = 15;

/// The iteration ends when no line moves by more, in pixels.
const SETTLED: f64 = 1e-3;

/// Longest step of a line or the blur, in pixels: the linearisation reaches about a blur.
const LONGEST_STEP: f64 = 0.5;

/// Standard deviation by which the limb in one block may be off for reasons other than noise, in pixels.
const BLOCK_FLOOR: f64 = 0.05;

/// Fewest pixels of a block: a few per unknown.
const LEAST_PIXELS: usize = 20;

/// Lines through pairs of blocks are tried for that many blocks at most.
const MOST_HYPOTHESES: usize = 16;

/// Steps of reweighting about the line through the blocks.
const REWEIGHTINGS: usize = 5;

/// Parallel lines are tried that far from the rough one, in pixels: where shading only bends at the limb, the
/// step filter peaks beside it by the width of the filter.
const SCAN_REACH: f64 = 2.5;

/// Spacing of these lines in pixels: well within the reach of the Gauss–Newton steps.
const SCAN_STEP: f64 = 0.5;

/// A line across a strip: u = offset + slope · s.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct StripLine {
    pub offset: f64,
    pub slope: f64,
}

impl StripLine {
    pub fn at(&self, s: f64) -> f64 {
        self.offset + self.slope * s
    }
}

/// What one block says about the line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block {
    /// Mean position along the strip.
    pub s: f64,
    /// Where the block sees the limb, relative to the line, in pixels.
    pub shift: f64,
    /// Standard deviation of `shift` in pixels, at the shading and blur of all blocks together.
    pub sigma: f64,
    /// What is left of the block in the fit of the line, 0 to 1.
    pub weight: f64,
    /// Pixels, and the sum of their squared residuals.
    count: f64,
    squares: f64,
    /// `JᵀJ` and `Jᵀr` over the variance of a pixel, in (line, blur, shading), levels eliminated.
    information: Matrix4<f64>,
    gradient: Vector4<f64>,
}

impl Block {
    /// Variance of `shift` with everything that is not noise.
    fn variance(&self) -> f64 {
        self.sigma * self.sigma + BLOCK_FLOOR * BLOCK_FLOOR
    }
}

/// What is known of a limb before it is refined.
#[derive(Debug, Clone, Copy)]
pub(super) struct Expected {
    pub rough: RoughLine,
    /// Half the length of the strip, in pixels.
    pub half_length: f64,
    /// Standard deviation of the limb about u = 0 at the ends of the strip, in pixels.
    pub deviation: f64,
}

/// One limb to refine.
pub(super) struct Limb<'a> {
    strip: &'a Strip,
    expected: Expected,
    noise: f64,
    /// Coefficients of sin θ and 1 − cos θ, relative to the level inside.
    shading: Vector2<f64>,
    /// How much more the blocks scatter about the line than their noise explains, at least 1.
    scatter: f64,
    pub line: StripLine,
    pub blocks: Vec<Block>,
    /// Covariance of (offset, slope).
    pub covariance: Matrix2<f64>,
}

impl<'a> Limb<'a> {
    pub fn new(strip: &'a Strip, expected: Expected) -> Self {
        let [a, b] = expected.rough.ends;
        let line = StripLine { offset: f64::midpoint(a, b), slope: (b - a) / (2.0 * expected.half_length) };
        Self {
            strip,
            expected,
            noise: strip.noise(),
            shading: Vector2::zeros(),
            scatter: 1.0,
            line,
            blocks: Vec::new(),
            covariance: Matrix2::zeros(),
        }
    }

    /// The part of the blocks that carries the line: 1 when all count alike, 1/n when one of n carries it.
    pub fn spread(&self) -> f64 {
        let weight = |block: &Block| block.weight / block.variance();
        let sum: f64 = self.blocks.iter().map(weight).sum();
        let squares: f64 = self.blocks.iter().map(|block| weight(block).powi(2)).sum();
        sum * sum / (squares * self.blocks.len() as f64)
    }

    /// Moves the line to the parallel one whose profile explains the blocks best.
    fn scan(&mut self, profile: &Profile) {
        let start = self.line;
        let count = (SCAN_REACH / SCAN_STEP) as i32;
        let mut best = (f64::INFINITY, 0.0, Vector2::zeros());
        for k in -count..=count {
            let shift = f64::from(k) * SCAN_STEP;
            self.shading = Vector2::zeros();
            self.shading = self.best_shading(&self.fit_blocks(profile, shift));
            let cost =
                |block: &Block| block.count * (block.squares / block.count + self.noise * self.noise).ln();
            let far = (start.offset + shift) / self.expected.deviation;
            let blocks = self.fit_blocks(profile, shift);
            let cost = blocks.iter().map(cost).sum::<f64>() + far * far;
            if cost < best.0 {
                best = (cost, shift, self.shading);
            }
        }
        self.line.offset += best.1;
        self.shading = best.2;
    }

    /// The shading that suits the blocks best at a given line.
    fn best_shading(&self, blocks: &[Block]) -> Vector2<f64> {
        let mut normal = Matrix2::identity() * SHADING.powi(-2);
        let mut right = Vector2::zeros();
        for block in blocks {
            normal += block.information.fixed_view::<2, 2>(2, 2);
            right += block.gradient.fixed_rows::<2>(2);
        }
        normal.try_inverse().map_or(self.shading, |inverse| self.shading + inverse * right)
    }

    fn fit_blocks(&self, profile: &Profile, shift: f64) -> Vec<Block> {
        let count = self.strip.len();
        let runs = (0..count.div_ceil(BLOCK_RUNS)).map(|k| k * BLOCK_RUNS..((k + 1) * BLOCK_RUNS).min(count));
        runs.filter_map(|runs| self.fit_block(profile, shift, runs)).collect()
    }

    /// One block, with the limb moved by `shift` but the pixels about the line as it is: costs of different
    /// shifts are over the same pixels.
    fn fit_block(&self, profile: &Profile, shift: f64, runs: Range<usize>) -> Option<Block> {
        let mut rows = Vec::with_capacity(128);
        let mut sum_s = 0.0;
        for pixel in runs.flat_map(|k| self.strip.run(k)) {
            let v = pixel.u - self.line.at(pixel.s);
            if (-OUTSIDE..=INSIDE).contains(&v) {
                rows.push((profile.at(v - shift)?, pixel.value));
                sum_s += pixel.s;
            }
        }
        if rows.len() < LEAST_PIXELS {
            return None;
        }
        let count = rows.len() as f64;
        let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
        for (row, value) in &rows {
            let [outer, inner, sine, lean] = row.values;
            let f = Vector2::new(outer, inner + self.shading[0] * sine + self.shading[1] * lean);
            normal += f * f.transpose();
            right += f * *value;
        }
        let inverse = normal.try_inverse()?;
        let levels = inverse * right;
        let coefficients =
            Vector4::new(levels[0], levels[1], levels[1] * self.shading[0], levels[1] * self.shading[1]);
        let mut cross = SMatrix::<f64, 2, 4>::zeros();
        let (mut square, mut gradient, mut squares) = (Matrix4::zeros(), Vector4::zeros(), 0.0);
        for (row, value) in &rows {
            let [outer, inner, sine, lean] = row.values;
            let f = Vector2::new(outer, inner + self.shading[0] * sine + self.shading[1] * lean);
            let residual = value - f.dot(&levels);
            let j = Vector4::new(
                -coefficients.dot(&Vector4::from(row.slopes)),
                coefficients.dot(&Vector4::from(row.blur_slopes)),
                levels[1] * sine,
                levels[1] * lean,
            );
            cross += f * j.transpose();
            square += j * j.transpose();
            gradient += j * residual;
            squares += residual * residual;
        }
        let variance = (squares / (count - 4.0)).max(self.noise * self.noise);
        let information = (square - cross.transpose() * inverse * cross) / variance;
        let gradient = gradient / variance;
        let of_line = information[(0, 0)].max(f64::MIN_POSITIVE);
        Some(Block {
            s: sum_s / count,
            shift: gradient[0] / of_line,
            sigma: (1.0 / of_line).sqrt(),
            weight: 1.0,
            count,
            squares,
            information,
            gradient,
        })
    }

    /// Tukey weights about the line through the shifts of the blocks.
    fn weigh(&mut self) {
        let count = self.blocks.len();
        if count < 2 {
            return;
        }
        let mut line = self.line_of_most_blocks();
        for _ in 0..REWEIGHTINGS {
            let distance = |block: &Block| (block.shift - line.at(block.s)) / block.variance().sqrt();
            let mut sizes: Vec<f64> = self.blocks.iter().map(|block| distance(block).abs()).collect();
            let median = *sizes.select_nth_unstable_by(count / 2, f64::total_cmp).1;
            self.scatter = (1.4826 * median).max(1.0);
            let loss = Tukey { cutoff: TUKEY_EFFICIENT * self.scatter, wall: Wall::Either };
            let weights: Vec<f64> =
                self.blocks.iter().map(|block| loss.loss_and_weight(distance(block), 0.0).1).collect();
            let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
            for (block, weight) in self.blocks.iter_mut().zip(weights) {
                block.weight = weight;
                let row = Vector2::new(1.0, block.s);
                let w = weight / block.variance();
                normal += row * row.transpose() * w;
                right += row * (w * block.shift);
            }
            let Some(inverse) = normal.try_inverse() else { return };
            let solution = inverse * right;
            line = StripLine { offset: solution[0], slope: solution[1] };
        }
    }

    /// The line through the shifts of two blocks that most others agree with.
    fn line_of_most_blocks(&self) -> StripLine {
        let blocks = &self.blocks;
        let stride = blocks.len().div_ceil(MOST_HYPOTHESES);
        let mut best = (f64::INFINITY, StripLine::default());
        for i in (0..blocks.len()).step_by(stride) {
            for j in (0..i).step_by(stride) {
                let slope = (blocks[i].shift - blocks[j].shift) / (blocks[i].s - blocks[j].s);
                let line = StripLine { offset: blocks[i].shift - slope * blocks[i].s, slope };
                let cost = |block: &Block| {
                    // Beyond three standard deviations all blocks disagree alike.
                    ((block.shift - line.at(block.s)).powi(2) / block.variance()).min(9.0)
                };
                let cost: f64 = blocks.iter().map(cost).sum();
                if cost < best.0 {
                    best = (cost, line);
                }
            }
        }
        best.1
    }

    /// Adds the normal equations of this limb, its unknowns (offset, slope, shading) from `first` on.
    fn add_to(&self, normal: &mut SMatrix<f64, 9, 9>, right: &mut SVector<f64, 9>, first: usize) {
        for block in &self.blocks {
            let factor = block.weight * (block.sigma * block.sigma) / block.variance();
            let mut map = SMatrix::<f64, 4, 9>::zeros();
            map[(0, first)] = 1.0;
            map[(0, first + 1)] = block.s;
            map[(1, BLUR)] = 1.0;
            map[(2, first + 2)] = 1.0;
            map[(3, first + 3)] = 1.0;
            *normal += map.transpose() * block.information * map * factor;
            *right += map.transpose() * block.gradient * factor;
        }
        let half = self.expected.half_length;
        let of_line = 2.0 / self.expected.deviation.powi(2);
        let of_shading = SHADING.powi(-2);
        let priors = [
            (of_line, self.line.offset),
            (of_line * half * half, self.line.slope),
            (of_shading, self.shading[0]),
            (of_shading, self.shading[1]),
        ];
        for (k, (weight, value)) in priors.into_iter().enumerate() {
            normal[(first + k, first + k)] += weight;
            right[first + k] -= weight * value;
        }
    }

    /// Takes a step; returns the largest shift of the line in pixels.
    fn take(&mut self, step: &Vector4<f64>, covariance: Matrix2<f64>) -> f64 {
        let size = step[0].abs() + step[1].abs() * self.expected.half_length;
        let shrink = (LONGEST_STEP / size).min(1.0);
        self.line.offset += step[0] * shrink;
        self.line.slope += step[1] * shrink;
        self.shading += step.fixed_rows::<2>(2) * shrink;
        self.covariance = covariance * (self.scatter * self.scatter);
        size
    }
}

/// Where the blur stands among the unknowns, after four of each limb.
const BLUR: usize = 8;

/// Refines one or two limbs of a cylinder of some radius in the image, in pixels, and the blur; returns the blur.
pub(super) fn refine(limbs: &mut [Limb<'_>], radius: f64) -> f64 {
    let wide = Profile::new(FIRST_BLUR, radius, SCAN_REACH);
    for limb in limbs.iter_mut() {
        limb.scan(&wide);
    }
    let mut blur = FIRST_BLUR;
    for _ in 0..STEPS {
        let mut normal = SMatrix::<f64, 9, 9>::zeros();
        let mut right = SVector::<f64, 9>::zeros();
        // A standard deviation of a pixel keeps the blur where no limb tells, and a missing limb harmless.
        normal[(BLUR, BLUR)] = 1.0;
        right[BLUR] = FIRST_BLUR - blur;
        for k in 4 * limbs.len()..BLUR {
            normal[(k, k)] = 1.0;
        }
        let profile = Profile::new(blur, radius, 0.0);
        for (index, limb) in limbs.iter_mut().enumerate() {
            limb.blocks = limb.fit_blocks(&profile, 0.0);
            limb.weigh();
            limb.add_to(&mut normal, &mut right, 4 * index);
        }
        let Some(inverse) = normal.try_inverse() else { break };
        let step = inverse * right;
        let mut moved: f64 = step[BLUR].abs();
        for (index, limb) in limbs.iter_mut().enumerate() {
            let covariance = inverse.fixed_view::<2, 2>(4 * index, 4 * index).into_owned();
            moved = moved.max(limb.take(&step.fixed_rows::<4>(4 * index).into_owned(), covariance));
        }
        blur = (blur + step[BLUR].clamp(-LONGEST_STEP, LONGEST_STEP)).clamp(LEAST_BLUR, MOST_BLUR);
        if moved < SETTLED {
            break;
        }
    }
    blur
}
