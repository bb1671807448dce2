//! From rough limb lines to lines within a few hundredths of a pixel: the profile model, fitted to short
//! blocks of both limbs at once.
//!
//! Each block has its own two levels of brightness, outside and inside (eliminated by variable projection);
//! each limb has its line and its shading relative to the level inside; the image has its blur. Gauss–Newton steps on
//! lines, shading and blur; in every step the blocks that disagree with the others about the line lose weight.

use super::block::{Background, Block, BlockSums, LimbState, StripLine, Window, fit_blocks, sums_of_blocks};
use super::consensus::RoughLine;
use super::profile::{ShadedRow, SharpProfile, Table};
use super::shading::LimbShading;
use super::strip::Strip;
use crate::residuals::{Progress, Reweighted, Reweighting, Scale};
use nalgebra::{Matrix2, SMatrix, SVector, Vector2, Vector4};

constants! {
    /// Standard deviation of the coefficients of sin θ and 1 − cos θ relative to the brightness near the limb: what
    /// lamps and paint do, so that noise is not explained by shading that no surface has.
    pub(super) SHADING = 0.3, "";

    /// Blur where the iteration starts, standard deviation in pixels: a lens in focus and the aperture of a pixel.
    FIRST_BLUR = 0.8, "px";

    /// More blur than this leaves no limb within the profile.
    pub(super) MOST_BLUR = 2.0, "px";

    /// Gauss–Newton steps at most; five to eight are usual.
    STEPS = 15.0, "";

    /// Steps after which a place of the limbs is dropped that is worse than the best so far by more than `AMBIGUOUS`.
    FIRST_STEPS = 4.0, "";

    /// The iteration ends when no line moves by more, in pixels.
    SETTLED = 1e-3, "px";

    /// The same where a limb is known from another image: a seventh of what its pixels do not show. No other place waits to
    /// be told apart.
    SETTLED_AGAIN = 1e-2, "px";

    /// Longest step of a line or the blur, in pixels: the linearisation reaches about a blur.
    LONGEST_STEP = 0.5, "px";

    /// Lines through pairs of blocks are tried for that many blocks at most.
    MOST_HYPOTHESES = 16.0, "";

    /// Rounds of reweighting of the line through the blocks.
    REWEIGHTINGS = 4.0, "";

    /// Parallel lines are tried that far from the rough one, in pixels: where shading only bends at the limb, the
    /// step filter peaks beside it by the width of the filter.
    SCAN_REACH = 2.5, "px";

    /// Spacing of these lines in pixels: well within the reach of the Gauss–Newton steps.
    SCAN_STEP = 0.5, "px";

    /// Twice the log-likelihood within which two places of a limb are both followed up: the blur is not known yet.
    AMBIGUOUS = 100.0, "";

    /// The least distance of such places in pixels: blur moves a minimum by less.
    ELSEWHERE = 1.0, "px";

    /// Places this close to each other are one, in pixels.
    SAME_PLACE = 0.1, "px";

    /// The standard deviation of the offset of a line that moves when less of its surroundings is looked at, in parts of
    /// what it moves: the windows show a part of what is wrong.
    LEFT_OUT = 1.4, "";

    /// By how much twice the log-likelihood is divided when places are weighed against each other: what is odd about one
    /// pixel is odd about its neighbours, too.
    TEMPERATURE = 4.0, "";

    /// The part that one place has of the weight of all from which on the limbs can be nowhere else.
    UNAMBIGUOUS = 0.99, "";
}

/// Blur cannot be less than that of the aperture of a pixel, 1/√12.
const LEAST_BLUR: f64 = 0.29;

/// One over the variance of a blur that was told: no image says otherwise.
const TOLD: f64 = 1e12;

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
}

/// One limb to refine.
#[derive(Clone)]
pub(super) struct Limb<'a> {
    strip: &'a Strip,
    expected: Expected,
    noise: f64,
    sharp: SharpProfile,
    /// Standard deviation of the coefficients of the shading.
    shading_deviation: f64,
    background: Background,
    /// How much more the blocks scatter about the line than their noise explains, at least 1.
    scatter: f64,
    pub state: LimbState,
    pub blocks: Vec<Block>,
    /// Covariance of (offset, slope).
    pub covariance: Matrix2<f64>,
    /// Variance of the offset for what the profile does not describe: see [`see_less`].
    pub misfit: f64,
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
            scatter: 1.0,
            state: LimbState { line, shading: Vector2::zeros() },
            blocks: Vec::new(),
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
        }
    }

    /// Whether the line is farther than `reach` from where it is expected at either end.
    fn is_beyond(&self, reach: f64) -> bool {
        let half = self.expected.half_length;
        [-half, half].iter().any(|s| self.state.line.at(*s).abs() > reach)
    }

    /// How many blocks carry the line: all when they count alike, one when one of them carries it.
    pub fn carriers(&self) -> f64 {
        let weight = |block: &Block| block.weight / block.variance();
        let sum: f64 = self.blocks.iter().map(weight).sum();
        let squares: f64 = self.blocks.iter().map(|block| weight(block).powi(2)).sum();
        sum * sum / squares
    }

    /// The parallel lines whose profiles explain the blocks best, one or two, from better to worse.
    fn scan(&mut self, blur: f64) -> Vec<LimbState> {
        let profile = &self.sharp.blurred(blur, SCAN_REACH.get());
        let count = (SCAN_REACH.get() / SCAN_STEP.get()) as i32;
        let sums: Vec<(LimbState, Vec<BlockSums>)> = (-count..=count)
            .map(|k| {
                let mut limb = self.state;
                limb.line.offset += f64::from(k) * SCAN_STEP.get();
                (limb, sums_of_blocks(self.strip, profile, &limb.line, &self.state.line))
            })
            .collect();
        let places_on = |background: Background| -> Vec<(f64, LimbState)> {
            let place = |(limb, blocks): &(LimbState, Vec<BlockSums>)| {
                let limb = LimbState { shading: self.best_shading(blocks, background), ..*limb };
                (self.cost(blocks, &limb, background), limb)
            };
            sums.iter().map(place).collect()
        };
        let mut places = places_on(Background::Flat);
        // A slope of each block is worth its while where it explains more than any number would.
        let price: f64 = sums[0].1.iter().map(|block| TEMPERATURE.get() * block.count.ln()).sum();
        let sloped = places_on(Background::Sloped);
        let lowest =
            |places: &[(f64, LimbState)]| places.iter().map(|place| place.0).fold(f64::INFINITY, f64::min);
        if lowest(&sloped) + price < lowest(&places) {
            places = sloped;
            self.background = Background::Sloped;
        }
        let least = |places: &mut dyn Iterator<Item = &(f64, LimbState)>| {
            places.min_by(|a, b| a.0.total_cmp(&b.0)).copied()
        };
        let Some(best) = least(&mut places.iter()) else { return vec![self.state] };
        // A blur that is not known yet turns a second minimum into a shoulder.
        let other = least(&mut places.iter().filter(|place| {
            (place.1.line.offset - best.1.line.offset).abs() >= ELSEWHERE.get()
                && place.0 < best.0 + AMBIGUOUS.get()
        }));
        [Some(best), other].into_iter().flatten().map(|place| place.1).collect()
    }

    /// Twice the negative log-likelihood of the pixels of the blocks, and of what is expected of line and shading.
    fn cost(&self, blocks: &[BlockSums], state: &LimbState, background: Background) -> f64 {
        let floor = self.noise * self.noise;
        let cost = |block: &BlockSums| {
            let squares = block.squared_residuals(&state.shading, self.noise, background)?;
            Some(block.count * (squares / block.count + floor).ln())
        };
        let blocks: f64 = blocks.iter().filter_map(cost).sum();
        let ends = [-1.0, 1.0].map(|side| state.line.at(side * self.expected.half_length));
        let far = (ends[0] * ends[0] + ends[1] * ends[1]) / self.expected.deviation.powi(2);
        blocks + far + state.shading.norm_squared() / self.shading_deviation.powi(2)
    }

    /// The shading that suits the blocks best.
    fn best_shading(&self, blocks: &[BlockSums], background: Background) -> Vector2<f64> {
        let mut normal = Matrix2::identity() * self.shading_deviation.powi(-2);
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
    fn weigh(&mut self) {
        let count = self.blocks.len();
        if count < 2 {
            return;
        }
        let blocks = &mut self.blocks;
        let distance =
            |block: &Block, line: &StripLine| (block.shift - line.at(block.s)) / block.variance().sqrt();
        let start = line_of_most_blocks(blocks);
        let mut distances: Vec<f64> = blocks.iter().map(|block| distance(block, &start)).collect();
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
    fn add_to(&self, normal: &mut SMatrix<f64, 9, 9>, right: &mut SVector<f64, 9>, first: usize) {
        // Where the line at the place of a block, the blur and the shading stand, and how the offset and the slope move
        // the line there.
        for block in &self.blocks {
            let factor = block.weight * (block.sigma * block.sigma) / block.variance();
            let places = [
                (first, 0, 1.0),
                (first + 1, 0, block.s),
                (BLUR, 1, 1.0),
                (first + 2, 2, 1.0),
                (first + 3, 3, 1.0),
            ];
            for (row, i, of_row) in places {
                right[row] += block.gradient[i] * of_row * factor;
                for (column, k, of_column) in places {
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
    fn take(&mut self, step: &Vector4<f64>, covariance: Matrix2<f64>) -> f64 {
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
    let stride = blocks.len().div_ceil(MOST_HYPOTHESES.count());
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

/// Where the blur stands among the unknowns, after four of each limb.
const BLUR: usize = 8;

/// What is common to the limbs when they are refined.
pub(super) struct RefinedImage {
    /// The blur, which is the told one where that is above 0.
    pub blur: f64,
    /// Whether the limbs can be nowhere else.
    pub unambiguous: bool,
}

/// Refines one or two limbs of a cylinder and the blur.
pub(super) fn refine(limbs: &mut [Limb<'_>], told_blur: f64) -> RefinedImage {
    let blur = ExpectedBlur::new(told_blur);
    let scans: Vec<Vec<LimbState>> = limbs.iter_mut().map(|limb| limb.scan(blur.value)).collect();
    let mut starts: Vec<Vec<LimbState>> = vec![Vec::new()];
    for scan in &scans {
        let extended = |start: &Vec<LimbState>| {
            scan.iter().map(|state| start.iter().copied().chain([*state]).collect()).collect::<Vec<_>>()
        };
        starts = starts.iter().flat_map(extended).collect();
    }
    let windows: Vec<StripLine> = limbs.iter().map(|limb| limb.state.line).collect();
    let several = starts.len() > 1;
    let mut modes: Vec<Mode<'_>> = Vec::new();
    for start in &starts {
        for (limb, state) in limbs.iter_mut().zip(start) {
            limb.state = *state;
        }
        let Some(blur) = follow(limbs, &blur, &windows, &modes) else { continue };
        let cost = if several { cost(limbs, blur, &windows) } else { 0.0 };
        modes.push(Mode { cost, limbs: limbs.to_vec(), blur });
    }
    modes.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    limbs.clone_from_slice(&modes[0].limbs);
    see_less(limbs, &blur, modes[0].blur);
    let weights: Vec<f64> =
        modes.iter().map(|mode| ((modes[0].cost - mode.cost) / (2.0 * TEMPERATURE.get())).exp()).collect();
    let sum: f64 = weights.iter().sum();
    for (k, limb) in limbs.iter_mut().enumerate() {
        let line = |mode: &Mode<'_>| mode.limbs[k].state.line.vector();
        let lines = || modes.iter().map(line).zip(weights.iter().map(|weight| weight / sum));
        let mean = lines().fold(Vector2::zeros(), |mean, (line, weight)| mean + line * weight);
        for (line, weight) in lines() {
            limb.covariance += (line - mean) * (line - mean).transpose() * weight;
        }
        limb.state.line = StripLine { offset: mean[0], slope: mean[1] };
    }
    RefinedImage { blur: modes[0].blur, unambiguous: weights[0] > UNAMBIGUOUS.get() * sum }
}

/// Refines limbs that are about where they are expected, from the blur of another image of a sequence; returns the blur.
/// `None` where a line goes farther than `reach` from there.
pub(super) fn refine_again(
    limbs: &mut [Limb<'_>],
    told_blur: f64,
    last_blur: f64,
    reach: [f64; 2],
) -> Option<f64> {
    let expected = ExpectedBlur::new(told_blur);
    let mut blur = if told_blur > 0.0 { expected.value } else { last_blur };
    for _ in 0..STEPS.count() {
        let moved = step(limbs, &profiles(limbs, blur), &expected, &mut blur, Window::full());
        if limbs.iter().zip(reach).any(|(limb, reach)| limb.is_beyond(reach)) {
            return None;
        }
        if moved < SETTLED_AGAIN.get() {
            break;
        }
    }
    see_less(limbs, &expected, blur);
    Some(blur)
}

/// Looks at less of the surroundings of the limbs. Where the profile is right the lines stay; where a shadow, a label or
/// another body comes in they move, by about as much as they are wrong. The difference of an efficient estimate and of one
/// from a part of the same data has the difference of their variances (Hausman, Econometrica 46, 1978).
fn see_less(limbs: &mut [Limb<'_>], expected: &ExpectedBlur, blur: f64) {
    let profiles = profiles(limbs, blur);
    for window in Window::smaller() {
        let mut near = limbs.to_vec();
        let mut blur = blur;
        step(&mut near, &profiles, expected, &mut blur, window);
        for (limb, near) in limbs.iter_mut().zip(&near) {
            let moved = near.state.line.offset - limb.state.line.offset;
            let variance = (near.covariance[(0, 0)] - limb.covariance[(0, 0)]).max(0.0);
            let more = moved * moved - variance;
            limb.misfit = limb.misfit.max(more * LEFT_OUT.get().powi(2));
        }
    }
}

/// What is known of the blur beforehand: the value in pixels and one over its variance.
struct ExpectedBlur {
    value: f64,
    weight: f64,
}

impl ExpectedBlur {
    /// The told blur, or where it is 0 that of most images, to a pixel.
    fn new(told: f64) -> Self {
        if told > 0.0 {
            Self { value: told.clamp(LEAST_BLUR, MOST_BLUR.get()), weight: TOLD }
        } else {
            Self { value: FIRST_BLUR.get(), weight: 1.0 }
        }
    }
}

/// One of several places where the limbs may be.
struct Mode<'a> {
    cost: f64,
    limbs: Vec<Limb<'a>>,
    blur: f64,
}

impl Mode<'_> {
    /// Whether the lines are the same.
    fn is_at(&self, limbs: &[Limb<'_>]) -> bool {
        let pairs = || self.limbs.iter().zip(limbs);
        pairs().all(|(a, b)| (a.state.line.offset - b.state.line.offset).abs() < SAME_PLACE.get())
    }
}

/// The cost of the limbs over the pixels of some windows.
fn cost(limbs: &[Limb<'_>], blur: f64, windows: &[StripLine]) -> f64 {
    let cost = |(limb, window): (&Limb<'_>, &StripLine)| {
        let profile = limb.sharp.blurred(blur, SCAN_REACH.get());
        let sums = sums_of_blocks(limb.strip, &profile, &limb.state.line, window);
        limb.cost(&sums, &limb.state, limb.background)
    };
    limbs.iter().zip(windows).map(cost).sum()
}

/// Gauss–Newton steps from where the limbs are until they have settled; returns the blur. `None` where they come to a
/// place that is known, or to one that is far worse.
fn follow(
    limbs: &mut [Limb<'_>],
    expected: &ExpectedBlur,
    windows: &[StripLine],
    known: &[Mode<'_>],
) -> Option<f64> {
    let mut blur = expected.value;
    for count in 1..=STEPS.count() {
        let moved = step(limbs, &profiles(limbs, blur), expected, &mut blur, Window::full());
        if known.iter().any(|mode| mode.is_at(limbs)) {
            return None;
        }
        if moved < SETTLED.get() {
            break;
        }
        if count == FIRST_STEPS.count() && !known.is_empty() {
            let least = known.iter().map(|mode| mode.cost).fold(f64::INFINITY, f64::min);
            if cost(limbs, blur, windows) > least + AMBIGUOUS.get() {
                return None;
            }
        }
    }
    Some(blur)
}

/// The profiles of limbs.
fn profiles(limbs: &[Limb<'_>], blur: f64) -> Vec<Table<ShadedRow>> {
    limbs.iter().map(|limb| limb.sharp.shaded(blur, &limb.state.shading)).collect()
}

/// A Gauss–Newton step on lines, shading and blur from where the limbs have these profiles; returns by how many pixels it
/// moved them, 0 where nothing is determined.
fn step(
    limbs: &mut [Limb<'_>],
    profiles: &[Table<ShadedRow>],
    expected: &ExpectedBlur,
    blur: &mut f64,
    window: Window,
) -> f64 {
    let mut normal = SMatrix::<f64, 9, 9>::zeros();
    let mut right = SVector::<f64, 9>::zeros();
    // What is expected keeps the blur where no limb tells, and a missing limb harmless.
    normal[(BLUR, BLUR)] = expected.weight;
    right[BLUR] = expected.weight * (expected.value - *blur);
    for k in 4 * limbs.len()..BLUR {
        normal[(k, k)] = 1.0;
    }
    for ((index, limb), profile) in limbs.iter_mut().enumerate().zip(profiles) {
        limb.blocks = fit_blocks(limb.strip, limb.noise, limb.background, profile, &limb.state.line, window);
        limb.weigh();
        limb.add_to(&mut normal, &mut right, 4 * index);
    }
    let Some(inverse) = normal.try_inverse() else { return 0.0 };
    let step = inverse * right;
    let mut moved: f64 = step[BLUR].abs();
    for (index, limb) in limbs.iter_mut().enumerate() {
        let covariance = inverse.fixed_view::<2, 2>(4 * index, 4 * index).into_owned();
        moved = moved.max(limb.take(&step.fixed_rows::<4>(4 * index).into_owned(), covariance));
    }
    *blur = (*blur + step[BLUR].clamp(-LONGEST_STEP.get(), LONGEST_STEP.get()))
        .clamp(LEAST_BLUR, MOST_BLUR.get());
    moved
}
