//! A limb on its way from a rough line to one within a few hundredths of a pixel: its line and its shading, the blocks of
//! its strip with their two levels of brightness each, and how much each of them says about the line.

use super::block::{Background, Block, BlockSums, INSIDE, LimbState, StripLine, sums_of_blocks};
use super::consensus::RoughLine;
use super::gather::Near;
use super::profile::{Kernel, SharpProfile};
use super::shading::LimbShading;
use super::strip::{Pixels, Strip};
use crate::memory::List;
use crate::residuals::{Progress, Reweighted, Reweighting, Scale};
use nalgebra::{Matrix2, SMatrix, SVector, Vector2, Vector4};
use pulp::{Arch, Simd, WithSimd};

constants! {
    /// Standard deviation of the coefficients of sin θ and 1 − cos θ relative to the brightness near the limb: what
    /// lamps and paint do, so that noise is not explained by shading that no surface has.
    pub(super) SHADING = 0.3, "";

    /// Longest step of a line or the blur, in pixels: the linearisation reaches about a blur.
    pub(super) LONGEST_STEP = 0.5, "px";

    /// Lines through pairs of blocks are tried for that many blocks at most.
    MOST_HYPOTHESES = 16.0, "";

    /// Rounds of reweighting of the line through the blocks.
    REWEIGHTINGS = 4.0, "";

    /// Parallel lines are tried that far from the rough one, in pixels: where shading only bends at the limb, the
    /// step filter peaks beside it by the width of the filter.
    pub(super) SCAN_REACH = 2.5, "px";

    /// Spacing of these lines in pixels: well within the reach of the Gauss–Newton steps.
    SCAN_STEP = 0.5, "px";

    /// The cost within which two positions of a limb are both followed up, three standard deviations squared: the blur is not known
    /// yet.
    pub(super) AMBIGUOUS = 9.0, "";

    /// The least distance of such positions in pixels: blur moves a minimum by less.
    pub(super) ELSEWHERE = 1.0, "px";

    /// The effective number of blocks of a limb where positions are weighed against each other. What is odd about a position, an edge
    /// of a label or of a shadow, is odd about all blocks and about many pixels of each: together they say no more than half of
    /// one block would whose pixels were independent (docs/measurements-limbs.md).
    EFFECTIVE_BLOCKS = 0.5, "";

    /// By how much twice the log-likelihood is divided before it pays for the slopes of a background that choose a position: what
    /// is odd about one pixel is odd about its neighbours, too.
    TEMPERATURE = 4.0, "";

    /// The same for slopes beside a position that was chosen without: 1 if no pixel shared anything with its neighbours
    /// (docs/measurements-limbs.md).
    SLOPE_TEMPERATURE = 1.4, "";
}

/// What speaks against a line that ran away from its position: more than against any position.
const RAN_AWAY: f64 = 1e6;

/// Where the blur stands among the unknowns, after four of each limb.
pub(super) const BLUR: usize = 8;

/// What is known of a limb before it is refined.
#[derive(Debug, Clone, Copy)]
pub(super) struct Expected {
    pub rough: RoughLine,
    /// Half the length of the strip, in pixels.
    pub half_length: f64,
    /// Standard deviation of the limb about u = 0 at the ends of the strip, in pixels.
    pub deviation: f64,
    /// Standard deviation of a pixel of the strip.
    pub noise: f64,
}

/// What a limb looks like in an image: what the next one of a sequence need not find out again.
#[derive(Debug, Clone, Copy)]
pub(super) struct Look {
    /// Standard deviation of a pixel.
    pub noise: f64,
    pub background: Background,
    /// Coefficients of the shading that is not as expected.
    pub shading: Vector2<f64>,
    /// Root mean square distance of the pixels from the profile.
    pub residual: f64,
    /// The mean of the pixels inside.
    pub level: f64,
}

/// One limb to refine.
#[derive(Clone)]
pub(super) struct Limb<'a> {
    pub strip: &'a Strip,
    expected: Expected,
    pub noise: f64,
    pub sharp: SharpProfile,
    /// Standard deviation of the coefficients of the shading.
    shading_deviation: f64,
    pub background: Background,
    /// Where the scan found the limb without slopes of the background, if these explain it better there.
    sloped_at: Option<f64>,
    /// How many blocks the scan compared positions by.
    scanned_blocks: usize,
    /// How much more the blocks scatter about the line than their noise explains, at least 1.
    scatter: f64,
    pub state: LimbState,
    /// The line about which pixels are looked at.
    pub near: StripLine,
    pub blocks: List<Block>,
    /// Covariance of (offset, slope).
    pub covariance: Matrix2<f64>,
    /// Variance of the offset for what the profile does not describe: see [`super::refine`].
    pub misfit: f64,
}

/// A candidate position of a limb, and what speaks against it.
#[derive(Clone, Copy)]
struct Candidate {
    state: LimbState,
    /// Twice the negative log-likelihood of the pixels.
    of_pixels: f64,
    /// The same for the effective number of blocks, with that of what is expected of line and shading.
    cost: f64,
}

impl<'a> Limb<'a> {
    /// `radius` is that of the cylinder in the image, in pixels.
    pub fn new(strip: &'a Strip, expected: Expected, shading: &LimbShading, radius: f64) -> Self {
        let sharp = SharpProfile::new(radius, shading, SCAN_REACH.get());
        Self::with(strip, expected, sharp, shading.deviation)
    }

    fn with(strip: &'a Strip, expected: Expected, sharp: SharpProfile, shading_deviation: f64) -> Self {
        let [a, b] = expected.rough.ends;
        let line = StripLine { offset: f64::midpoint(a, b), slope: (b - a) / (2.0 * expected.half_length) };
        Self {
            strip,
            expected,
            noise: expected.noise,
            sharp,
            shading_deviation,
            background: Background::Flat,
            sloped_at: None,
            scanned_blocks: 0,
            scatter: 1.0,
            state: LimbState { line, shading: Vector2::zeros() },
            near: line,
            blocks: List::new(),
            covariance: Matrix2::zeros(),
            misfit: 0.0,
        }
    }

    /// The same for a limb that is where it is expected, and looks as it did.
    pub fn again(
        strip: &'a Strip,
        expected: Expected,
        shading: &LimbShading,
        radius: f64,
        look: &Look,
    ) -> Self {
        // It is not looked for anywhere else.
        let sharp = SharpProfile::new(radius, shading, 0.0);
        let mut limb = Self::with(strip, expected, sharp, shading.deviation);
        limb.background = look.background;
        limb.state.shading = look.shading;
        limb
    }

    /// What it looks like.
    pub fn look(&self) -> Look {
        let weight: f64 = self.blocks.iter().map(|block| block.weight).sum();
        let squares: f64 = self.blocks.iter().map(|block| block.weight * block.variance_of_pixel).sum();
        Look {
            noise: self.noise,
            background: self.background,
            shading: self.state.shading,
            residual: (squares / weight).sqrt(),
            level: self.level_inside(),
        }
    }

    /// The mean of the pixels inside the line, as far as the window of a block reaches.
    fn level_inside(&self) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for Pixels { s, u, values, .. } in self.strip.runs() {
            for ((s, u), value) in s.iter().zip(u).zip(values) {
                if (0.0..INSIDE.get()).contains(&(u - self.state.line.at(*s))) {
                    (sum, count) = (sum + value, count + 1.0);
                }
            }
        }
        sum / f64::max(count, 1.0)
    }

    /// Whether the line is farther than `reach` from where it is expected at either end.
    pub fn is_beyond(&self, reach: f64) -> bool {
        let half = self.expected.half_length;
        [-half, half].iter().any(|s| self.state.line.at(*s).abs() > reach)
    }

    /// Gives the background slopes where the scan found that they explain it better, if the line is still there; whether it did.
    pub fn take_slopes(&mut self) -> bool {
        let near = |at: f64| (self.state.line.offset - at).abs() < ELSEWHERE.get();
        let takes = self.sloped_at.is_some_and(near);
        if takes {
            self.background = Background::Sloped;
        }
        takes
    }

    /// Whether the line goes within `distance` of another one, in pixels.
    pub fn is_along(&self, other: &StripLine, distance: f64) -> bool {
        let half = self.expected.half_length;
        [-half, half].iter().all(|s| (self.state.line.at(*s) - other.at(*s)).abs() <= distance)
    }

    /// How many blocks carry the line: all when they count alike, one when one of them carries it.
    pub fn carriers(&self) -> f64 {
        let weight = |block: &Block| block.weight / block.variance();
        let sum: f64 = self.blocks.iter().map(weight).sum();
        let squares: f64 = self.blocks.iter().map(|block| weight(block).powi(2)).sum();
        sum * sum / squares
    }

    /// The parallel lines whose profiles explain the blocks best, one or two, from better to worse; `near` are the pixels about the
    /// limb as it is.
    pub fn scan(&mut self, kernel: &Kernel, near: &Near) -> List<LimbState> {
        let profile = &self.sharp.blurred(kernel);
        let count = (SCAN_REACH.get() / SCAN_STEP.get()) as i32;
        let sums: List<(StripLine, List<BlockSums>)> = (-count..=count)
            .map(|k| {
                let mut line = self.state.line;
                line.offset += f64::from(k) * SCAN_STEP.get();
                (line, sums_of_blocks(profile, &line, near))
            })
            .collect();
        self.scanned_blocks = sums[0].1.len();
        let candidates_on = |background: Background| -> List<Candidate> {
            let candidate = |(line, blocks): &(StripLine, List<BlockSums>)| {
                let state = LimbState { line: *line, shading: self.best_shading(blocks, background) };
                self.candidate(blocks, state, background)
            };
            sums.iter().map(candidate).collect()
        };
        let [flat, sloped] = [Background::Flat, Background::Sloped].map(candidates_on);
        let least = |candidates: &mut dyn Iterator<Item = &Candidate>| {
            candidates.min_by(|a, b| a.cost.total_cmp(&b.cost)).copied()
        };
        let [Some(of_flat), Some(of_sloped)] =
            [&flat, &sloped].map(|candidates| least(&mut candidates.iter()))
        else {
            return List::from([self.state]);
        };
        // The price of a slope in each block (Schwarz, Annals of Statistics 6, 1978).
        let price: f64 = sums[0].1.iter().map(|block| block.count.ln()).sum();
        let pays = |sloped: &Candidate, times: f64| sloped.of_pixels + times * price < of_flat.of_pixels;
        let apart = |a: &Candidate, b: &Candidate| (a.state.line.offset - b.state.line.offset).abs();
        let (candidates, best) = if pays(&of_sloped, TEMPERATURE.get()) {
            self.background = Background::Sloped;
            (&sloped, of_sloped)
        } else {
            let there =
                least(&mut sloped.iter().filter(|candidate| apart(candidate, &of_flat) < ELSEWHERE.get()));
            let there = there.filter(|there| pays(there, SLOPE_TEMPERATURE.get()));
            self.sloped_at = there.map(|_| of_flat.state.line.offset);
            (&flat, of_flat)
        };
        // A blur that is not known yet turns a second minimum into a shoulder.
        let other = least(&mut candidates.iter().filter(|candidate| {
            apart(candidate, &best) >= ELSEWHERE.get() && candidate.cost < best.cost + AMBIGUOUS.get()
        }));
        [Some(best), other].into_iter().flatten().map(|candidate| candidate.state).collect()
    }

    /// What speaks against the position where the limb is by the blocks that the scan compared positions by, some of which the profile
    /// does not reach where the line ran away.
    pub fn cost(&self, blocks: &[BlockSums]) -> f64 {
        if blocks.len() < self.scanned_blocks {
            return RAN_AWAY;
        }
        self.candidate(blocks, self.state, self.background).cost
    }

    /// A candidate position, and what speaks against it.
    fn candidate(&self, blocks: &[BlockSums], state: LimbState, background: Background) -> Candidate {
        let of_pixels = self.cost_of_pixels(blocks, &state, background);
        let cost = of_pixels / self.variance_inflation() + self.cost_of_expected(&state);
        Candidate { state, of_pixels, cost }
    }

    /// Twice the negative log-likelihood of what is expected of line and shading.
    fn cost_of_expected(&self, state: &LimbState) -> f64 {
        let ends = [-1.0, 1.0].map(|side| state.line.at(side * self.expected.half_length));
        let far = (ends[0] * ends[0] + ends[1] * ends[1]) / self.expected.deviation.powi(2);
        let of_shading = state.shading.norm_squared() / self.shading_deviation.powi(2);
        far + of_shading
    }

    /// Twice the negative log-likelihood of the pixels of the blocks.
    fn cost_of_pixels(&self, blocks: &[BlockSums], state: &LimbState, background: Background) -> f64 {
        let floor = self.noise * self.noise;
        let cost = |block: &BlockSums| {
            let squares = block.squared_residuals(&state.shading, self.noise, background)?;
            Some(block.count * (squares / block.count + floor).ln())
        };
        blocks.iter().filter_map(cost).sum()
    }

    /// By how much the variance of what all blocks say about a position is larger than if their pixels were independent.
    fn variance_inflation(&self) -> f64 {
        self.scanned_blocks.max(1) as f64 / EFFECTIVE_BLOCKS.get()
    }

    /// The shading with which about least speaks against a position.
    fn best_shading(&self, blocks: &[BlockSums], background: Background) -> Vector2<f64> {
        let mut normal = Matrix2::identity() * (self.variance_inflation() * self.shading_deviation.powi(-2));
        let mut right = Vector2::zeros();
        for (information, gradient) in
            blocks.iter().filter_map(|block| block.of_shading(self.noise, background))
        {
            normal += information;
            right += gradient;
        }
        normal.try_inverse().map_or(Vector2::zeros(), |inverse| inverse * right)
    }

    /// Tukey weights about the line through the shifts of the blocks.
    pub fn weigh(&mut self) {
        let count = self.blocks.len();
        if count < 2 {
            return;
        }
        let blocks = &mut self.blocks;
        let distance =
            |block: &Block, line: &StripLine| (block.shift - line.at(block.s)) / block.variance().sqrt();
        let start = line_of_most_blocks(blocks);
        let mut distances: List<f64> = blocks.iter().map(|block| distance(block, &start)).collect();
        let reweighting = Reweighting { rounds: REWEIGHTINGS.count(), scale: Scale::AtLeast(1.0) };
        let reweighted = reweighting.continue_from(&mut distances, |weights, distances| {
            let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
            for (block, weight) in blocks.iter().zip(weights) {
                let row = Vector2::new(1.0, block.s);
                let w = weight / block.variance();
                normal += row * row.transpose() * w;
                right += row * (w * block.shift);
            }
            let solution = normal.try_inverse()? * right;
            let line = StripLine { offset: solution[0], slope: solution[1] };
            for (block, own) in blocks.iter().zip(distances) {
                *own = distance(block, &line);
            }
            Some(Progress::Moved)
        });
        let Some(Reweighted { weights, scale }) = reweighted else { return };
        self.scatter = scale;
        for (block, weight) in self.blocks.iter_mut().zip(weights) {
            block.weight = weight;
        }
    }

    /// Adds the normal equations of this limb, its unknowns (offset, slope, shading) from `first` on.
    pub fn add_to(&self, normal: &mut SMatrix<f64, 9, 9>, right: &mut SVector<f64, 9>, first: usize) {
        // Where the line at the position of a block, the blur and the shading stand, and how the offset and the slope move
        // the line there.
        for block in &self.blocks {
            let factor = block.weight * (block.sigma * block.sigma) / block.variance();
            let entries = [
                (first, 0, 1.0),
                (first + 1, 0, block.s),
                (BLUR, 1, 1.0),
                (first + 2, 2, 1.0),
                (first + 3, 3, 1.0),
            ];
            for (row, i, of_row) in entries {
                right[row] += block.gradient[i] * of_row * factor;
                for (column, k, of_column) in entries {
                    normal[(row, column)] += block.information[(i, k)] * of_row * of_column * factor;
                }
            }
        }
        let half = self.expected.half_length;
        let of_line = 2.0 / self.expected.deviation.powi(2);
        let of_shading = self.shading_deviation.powi(-2);
        let priors = [
            (of_line, self.state.line.offset),
            (of_line * half * half, self.state.line.slope),
            (of_shading, self.state.shading[0]),
            (of_shading, self.state.shading[1]),
        ];
        for (k, (weight, value)) in priors.into_iter().enumerate() {
            normal[(first + k, first + k)] += weight;
            right[first + k] -= weight * value;
        }
    }

    /// Takes a step; returns the largest shift of the line in pixels.
    pub fn take(&mut self, step: &Vector4<f64>, covariance: Matrix2<f64>) -> f64 {
        let size = step[0].abs() + step[1].abs() * self.expected.half_length;
        let shrink = (LONGEST_STEP.get() / size).min(1.0);
        self.state.line.offset += step[0] * shrink;
        self.state.line.slope += step[1] * shrink;
        self.state.shading += step.fixed_rows::<2>(2) * shrink;
        self.covariance = covariance * (self.scatter * self.scatter);
        size
    }
}

/// The line through the shifts of two blocks that most others agree with.
fn line_of_most_blocks(blocks: &[Block]) -> StripLine {
    let shifts: List<Shift> = blocks
        .iter()
        .map(|block| Shift { s: block.s, shift: block.shift, variance: block.variance() })
        .collect();
    Arch::new().dispatch(MostBlocks { shifts: &shifts })
}

/// Where a block sees the limb.
#[derive(Clone, Copy)]
struct Shift {
    s: f64,
    shift: f64,
    variance: f64,
}

/// Lines that are compared side by side.
const LINES: usize = 8;

/// The search of [`line_of_most_blocks`]. Plain loops, which the compiler makes the widest instructions of the machine of; they
/// all round alike.
struct MostBlocks<'a> {
    shifts: &'a [Shift],
}

impl WithSimd for MostBlocks<'_> {
    type Output = StripLine;

    #[inline(always)]
    #[allow(clippy::needless_range_loop, reason = "closures are not inlined for sure")]
    fn with_simd<S: Simd>(self, _simd: S) -> StripLine {
        let Self { shifts } = self;
        let stride = shifts.len().div_ceil(MOST_HYPOTHESES.count());
        let (mut best, mut least) = (StripLine::default(), f64::INFINITY);
        for i in (0..shifts.len()).step_by(stride) {
            let one = shifts[i];
            for first in (0..i).step_by(stride * LINES) {
                // The line of a block with itself is none, and costs no number.
                let (mut offset, mut slope, mut cost) = ([0.0; LINES], [0.0; LINES], [0.0; LINES]);
                for k in 0..LINES {
                    let other = shifts[(first + k * stride).min(i)];
                    slope[k] = (one.shift - other.shift) / (one.s - other.s);
                    offset[k] = one.shift - slope[k] * one.s;
                }
                for Shift { s, shift, variance } in shifts {
                    for k in 0..LINES {
                        let distance = shift - (offset[k] + slope[k] * s);
                        let square = distance * distance / variance;
                        // Beyond three standard deviations all blocks disagree alike.
                        cost[k] += if square < 9.0 { square } else { 9.0 };
                    }
                }
                for k in 0..LINES {
                    if cost[k] < least {
                        (least, best) = (cost[k], StripLine { offset: offset[k], slope: slope[k] });
                    }
                }
            }
        }
        best
    }
}
