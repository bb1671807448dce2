//! Location of the two limb lines in the image, from all pixels along them.
//!
//! From a grey image and a rough cylinder to two lines in ideal pixels with their covariance:
//!
//! 1. The pixels around each expected limb are gathered with their ideal positions; none is interpolated.
//! 2. The line along which there is an edge almost everywhere, of whatever polarity, is found among all lines in
//!    reach: consensus, not strength.
//! 3. A model of the brightness across the limb (background, shading inside, blur of the image) is fitted to
//!    short blocks of both limbs at once; blocks that disagree about the line lose weight.
//!
//! A limb that cannot be seen is reported, with the reason.
//!
//! All lengths in pixels are those of an image that is about as sharp as its grid allows. Where the limbs turn out to
//! be more blurred they are located again on means of boxes of pixels, which lose nothing then. Where nothing about them is
//! sharp they are located on such means to begin with: the smear of a wide blur is no edge for the filter, and shading for the model.

mod again;
mod block;
mod compression;
mod consensus;
mod contact;
mod detected;
mod gather;
mod grids;
mod lamps;
mod limb;
mod profile;
mod refine;
mod region;
mod shading;
mod sharpness;
mod strip;
#[cfg(test)]
mod tests;

#[cfg(feature = "sensitivity")]
/// The constants of the location of limbs.
#[must_use]
pub fn constants() -> Vec<crate::constant::Constant> {
    let files = [
        CONSTANTS,
        again::CONSTANTS,
        block::CONSTANTS,
        compression::CONSTANTS,
        consensus::CONSTANTS,
        contact::CONSTANTS,
        detected::CONSTANTS,
        grids::CONSTANTS,
        lamps::CONSTANTS,
        limb::CONSTANTS,
        profile::CONSTANTS,
        refine::CONSTANTS,
        region::CONSTANTS,
        shading::CONSTANTS,
        sharpness::CONSTANTS,
        strip::CONSTANTS,
    ];
    files.concat()
}

pub use again::{Appearance, locate_limbs_again};
pub use contact::is_crowded;
pub use detected::edges_on_limbs;
pub use grids::locate_limbs;
pub use region::{Outline, Side, axial_range, may_be_covered};

use crate::camera::Camera;
use crate::geometry::{Cylinder, LimbFrame, across};
use crate::memory::List;
use crate::noise::{ImageNoise, box_blur};
use crate::observations::from_reduced;
use again::Light;
use block::{Block, INSIDE, OUTSIDE};
use consensus::{FILTER_HALF, rough_line};
use limb::{Expected, Limb, SHADING};
use nalgebra::{Matrix2, Vector2};
use refine::{MOST_BLUR, RefinedImage, refine};
use shading::{LimbShading, Shading};
use sharpness::{STILL_BLURRED, blurred_part};
use smallvec::SmallVec;
use strip::{Baseline, Grid, Strip};

constants! {
    /// Standard deviation of a located line for reasons that its pixels do not show, in pixels at either end: what is
    /// left of errors of the profile model where noise is low, by the scatter of lines on rendered frames.
    LINE_FLOOR = 0.07, "px";

    /// A line less certain than this at the ends of what is seen is hardly better than one set by hand, in deviations of a
    /// hand-set endpoint.
    LARGEST_DEVIATION = 1.2, "σ";

    /// The least part of the blocks that must carry a line: less is an edge beside the limb that the line meets here
    /// and there.
    LEAST_SPREAD = 0.4, "";

    /// So many blocks are enough, however many there are: on a patterned surface some see the limb ten times as well as
    /// others.
    ENOUGH_BLOCKS = 8.0, "blocks";
}

/// Where to look for the limbs of a rough cylinder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimbSearch {
    /// By limb, in the order of [`LimbFrame::limb_lines`]: the visible part, from one position along the axis to another,
    /// measured from the point of the axis in the unit of length: see [`axial_range`].
    pub ranges: [[f64; 2]; 2],
    /// How far each limb may be from that of the cylinder at most, in pixels of the image, in the order of
    /// [`LimbFrame::limb_lines`]: 4 for a fit with segments set by hand, 8 for a fit of points alone.
    pub reach: [f64; 2],
    /// Standard deviation of the limbs of the cylinder, in pixels, in the same order. A clear limb is found
    /// anywhere in reach; a faint one is believed near the expected position only.
    pub deviation: [f64; 2],
    /// Limbs of which nothing is seen because something in front covers them: an edge there is not theirs.
    pub covered: [bool; 2],
    /// What is known of the image.
    pub noise: ImageNoise,
}

impl LimbSearch {
    /// The same search in an image whose pixels are boxes of `factor` columns and rows.
    fn reduced(&self, factor: usize) -> Self {
        let ratio = factor as f64;
        Self {
            ranges: self.ranges,
            reach: self.reach.map(|reach| reach / ratio),
            deviation: self.deviation.map(|deviation| deviation / ratio),
            covered: self.covered,
            noise: self.noise.reduced(factor),
        }
    }
}

/// Why a limb was not found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NotVisible {
    /// The cylinder has no limbs in front of the camera: the camera is inside it, or the range lies behind.
    NoLimbs,
    /// Fewer than 12 rows or columns of the image show the range, or something covers the limb.
    TooShort,
    /// No line in reach has more of an edge than noise gives.
    NoEdge,
    /// The line left the reach while it was refined, or lies beside the mask.
    OutOfReach,
    /// The line would be less certain than one set by hand, or what is there is softer than any limb.
    Uncertain,
    /// A small part of the line carries it all.
    Patchy,
    /// The other limb was found at the same position, and more certainly.
    SameLine,
}

/// A located limb line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimbLine {
    /// The two points of the line whose errors across it are independent and equally large, in ideal pixels. They
    /// say all about line and covariance: two pixel residuals of standard deviation `sigma` are equivalent to the
    /// whole line. They need not lie on the part that was seen: what all pixels share, such as the blur, makes the
    /// offset less certain than the angle and moves them apart.
    pub ends: [Vector2<f64>; 2],
    /// Standard deviation of either end across the line, in pixels.
    pub sigma: f64,
}

impl LimbLine {
    /// The covariance of the offset across the line, in pixels at the middle of the ends, and of the angle in
    /// radians.
    #[must_use]
    pub fn covariance(&self) -> Matrix2<f64> {
        let variance = self.sigma * self.sigma;
        let length_squared = (self.ends[1] - self.ends[0]).norm_squared();
        Matrix2::new(variance / 2.0, 0.0, 0.0, 2.0 * variance / length_squared)
    }
}

/// What a short piece of a limb says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimbSample {
    /// Where the limb is seen, in ideal pixels.
    pub position: Vector2<f64>,
    /// Standard deviation across the limb in pixels, noise only.
    pub sigma: f64,
    /// What it counted, from 1 down to 0 for a refused sample.
    pub weight: f64,
}

/// What was seen of one limb.
#[derive(Debug, Clone, PartialEq)]
pub struct LimbObservation {
    /// The line, or why there is none.
    pub line: Result<LimbLine, NotVisible>,
    /// A line that is not believed alone, as too few blocks carry it.
    pub(crate) of_few: Option<LimbLine>,
    /// The pieces along it, used and refused, also where no line came of them.
    pub samples: List<LimbSample>,
    /// Blur of the image at the limbs, standard deviation of a Gaussian in pixels, common to both limbs; `None`
    /// where no limb tells.
    pub blur: Option<f64>,
}

impl LimbObservation {
    /// Whether a sample of it has a part in the result: no sample of a limb without a line has.
    #[must_use]
    pub fn uses(&self, sample: &LimbSample) -> bool {
        self.line.is_ok() && sample.weight > 0.0
    }

    /// The piece of the line from the first to the last sample that has a part in it, in ideal pixels; `None` without a line.
    pub(crate) fn seen(&self) -> Option<[Vector2<f64>; 2]> {
        let [a, b] = self.line.ok()?.ends;
        let along = (b - a).normalize();
        let used = self.samples.iter().filter(|sample| self.uses(sample));
        let positions = used.map(|sample| along.dot(&(sample.position - a)));
        let range = positions.fold(None, |range: Option<[f64; 2]>, position| {
            let [first, last] = range.unwrap_or([position; 2]);
            Some([first.min(position), last.max(position)])
        });
        range.map(|range| range.map(|position| a + along * position))
    }

    fn none(reason: NotVisible) -> Self {
        Self { line: Err(reason), of_few: None, samples: List::new(), blur: None }
    }

    /// The same in pixels of the image, of whose boxes of `factor` columns and rows it was in pixels.
    fn enlarged(mut self, factor: usize) -> Self {
        let ratio = factor as f64;
        let in_pixels = |position: Vector2<f64>| position.map(|x| from_reduced(x, factor));
        let enlarged =
            |line: LimbLine| LimbLine { ends: line.ends.map(in_pixels), sigma: line.sigma * ratio };
        self.line = self.line.map(enlarged);
        self.of_few = self.of_few.map(enlarged);
        for sample in &mut self.samples {
            sample.position = in_pixels(sample.position);
            sample.sigma *= ratio;
        }
        let own = |blur: f64| ((blur * ratio).powi(2) - box_blur(factor).powi(2)).max(0.0).sqrt();
        self.blur = self.blur.map(own);
        self
    }
}

/// What an image shows of the limbs of a cylinder.
#[derive(Debug, Clone)]
pub struct SeenLimbs {
    /// In the order of [`LimbFrame::limb_lines`].
    pub limbs: [LimbObservation; 2],
    /// What the next image of a sequence need not be asked again; `None` where a limb was not found, or may be elsewhere.
    pub appearance: Option<Appearance>,
}

impl SeenLimbs {
    /// Neither, for a reason.
    fn none(reason: NotVisible) -> Self {
        Self { limbs: [(); 2].map(|()| LimbObservation::none(reason)), appearance: None }
    }
}

/// The blur of an image as the limbs show it, in pixels; `None` where none tells.
#[must_use]
pub fn blur_of(limbs: &[LimbObservation; 2]) -> Option<f64> {
    limbs.iter().find_map(|limb| limb.blur)
}

/// Locates the limbs on one grid of pixels; `None` where more than a part of what is seen there is blurred, or where the limbs are
/// more blurred than the model allows and it is not shading or a shadow beside what is sharp that makes them so.
fn located_on(
    grid: &Grid<'_>,
    model: &Cylinder,
    search: &LimbSearch,
    most_blurred: f64,
) -> Option<SeenLimbs> {
    let mut observations = SeenLimbs::none(NotVisible::NoLimbs).limbs;
    let without = |limbs| Some(SeenLimbs { limbs, appearance: None });
    let Some((baselines, radius)) = baselines(grid.camera, model, &search.ranges) else {
        return without(observations);
    };
    let strips: [Option<(Baseline, Strip)>; 2] = [0, 1].map(|k| {
        let half_width = search.reach[k] + OUTSIDE.get().max(INSIDE.get()) + FILTER_HALF as f64;
        strip_cut_to_image(grid, &baselines[k], half_width)
    });
    let is_asked = most_blurred.is_finite();
    let part = if is_asked { blurred_part(strips.iter().flatten().map(|(_, strip)| strip)) } else { 0.0 };
    if part > most_blurred {
        return None;
    }
    let mut roughs = [None, None];
    for (k, strip) in strips.iter().enumerate() {
        observations[k].line = Err(NotVisible::TooShort);
        let Some((baseline, strip)) = strip.as_ref().filter(|_| !search.covered[k]) else { continue };
        let (half_length, deviation) = (baseline.half_length, search.deviation[k]);
        let noise = strip.noise(grid);
        let Some(rough) = rough_line(strip, noise, half_length, search.reach[k], deviation) else { continue };
        observations[k].line = Err(NotVisible::NoEdge);
        if rough.visible {
            roughs[k] = Some((strip, baseline, Expected { rough, half_length, deviation, noise }));
        }
    }
    if roughs.iter().all(Option::is_none) {
        return without(observations);
    }
    let shading = inner_shading(grid, &baselines, &roughs, radius);
    let (mut limbs, mut seen) = (SmallVec::<[_; 2]>::new(), SmallVec::<[_; 2]>::new());
    for (k, found) in roughs.into_iter().enumerate() {
        let Some((strip, baseline, expected)) = found else { continue };
        let near =
            shading.map_or(LimbShading::plain(SHADING.get()), |shading| shading.near_limb(SIDES[k], radius));
        limbs.push(Limb::new(strip, expected, &near, radius));
        seen.push((k, baseline));
    }
    let RefinedImage { blur, unambiguous } = refine(&mut limbs, grid.noise.blur);
    if part > STILL_BLURRED.get() && blur >= MOST_BLUR.get() {
        return None;
    }
    for ((k, baseline), limb) in seen.into_iter().zip(&limbs) {
        observations[k] = observed(limb, baseline, search.reach[k], blur, &search.noise);
    }
    drop_same_line(&mut observations, search.noise.apart());
    let factor = grid.image.factor();
    let appearance = match &limbs[..] {
        [first, second] if unambiguous => Light::new(model, shading)
            .and_then(|light| Appearance::new(factor, blur, light, [first, second], &observations)),
        _ => None,
    };
    Some(SeenLimbs { limbs: observations.map(|limb| limb.enlarged(factor)), appearance })
}

/// What a refined limb shows.
fn observed(
    limb: &Limb<'_>,
    baseline: &Baseline,
    reach: f64,
    blur: f64,
    noise: &ImageNoise,
) -> LimbObservation {
    let (line, of_few) = match judged(limb, baseline, reach, blur, noise) {
        Ok(line) if is_patchy(limb) => (Err(NotVisible::Patchy), Some(line)),
        line => (line, None),
    };
    LimbObservation { line, of_few, samples: samples(limb, baseline), blur: Some(blur) }
}

/// The angle φ of each limb about the axis, in units of 90°: u rises from the first limb to the second.
const SIDES: [f64; 2] = [-1.0, 1.0];

/// A limb that is visible: its pixels, where they are, and what is known of it.
type Found<'a> = Option<(&'a Strip, &'a Baseline, Expected)>;

/// The shading of the surface between the limbs, as far as they are known.
fn inner_shading(
    grid: &Grid<'_>,
    baselines: &[Baseline; 2],
    found: &[Found<'_>; 2],
    radius: f64,
) -> Option<Shading> {
    // The ends of each limb, where it is seen or else where it is expected, in the same direction.
    let ends = [0, 1].map(|k| match &found[k] {
        Some((_, baseline, expected)) => {
            let half = baseline.half_length;
            let [a, b] = expected.rough.ends;
            [baseline.position(-half, a), baseline.position(half, b)]
        }
        None => [-1.0, 1.0].map(|side| baselines[k].position(side * baselines[k].half_length, 0.0)),
    });
    let middle = [0, 1].map(|k| (ends[0][k] + ends[1][k]) / 2.0);
    let baseline = Baseline::new(&middle, &((ends[1][0] + ends[1][1]) / 2.0))?;
    let limbs = ends.map(|ends| {
        let [(s0, u0), (s1, u1)] = ends.map(|end| baseline.coordinates(&end));
        let slope = (u1 - u0) / (s1 - s0);
        (u0 - slope * s0, slope)
    });
    let strip = Strip::gather(grid, &near_image(grid.camera, &baseline)?, radius);
    Shading::observe(&strip, strip.noise(grid), limbs, radius)
}

/// The expected limb lines within their ranges and the radius of the cylinder in the image, in pixels; `None` when
/// any part lies behind the camera.
fn baselines(camera: &Camera, model: &Cylinder, ranges: &[[f64; 2]; 2]) -> Option<([Baseline; 2], f64)> {
    let limbs = LimbFrame::new(model)?;
    let axis = &model.axis;
    let [first, second] = ranges.map(|[low, high]| f64::midpoint(low, high));
    let inner = camera.ideal_pixel(&axis.at(f64::midpoint(first, second)))?;
    // Limb lines are given by their point nearest to the origin, ranges from the point of the axis.
    let start = axis.point.dot(&axis.direction);
    let lines = limbs.limb_lines();
    let [first, second] = [0, 1].map(|k| {
        let (line, [low, high]) = (&lines[k], ranges[k]);
        let end = |position: f64| camera.ideal_pixel(&line.at(start + position));
        Baseline::new(&[end(low)?, end(high)?], &inner)
    });
    let (first, second) = (first?, second?);
    let radius = (second.middle - first.middle).dot(&first.inward).abs() / 2.0;
    (radius > 0.0).then_some(([first, second], radius))
}

/// The part of a baseline that an image may show: a range may be far longer, and a lens shows more than a pinhole.
fn near_image(camera: &Camera, baseline: &Baseline) -> Option<Baseline> {
    let intrinsics = camera.intrinsics();
    let size = Vector2::new(f64::from(intrinsics.width), f64::from(intrinsics.height));
    baseline.clipped(&(size / 2.0), size.norm())
}

/// The part of the image around a baseline, and the baseline cut to what the image shows of it.
fn strip_cut_to_image(grid: &Grid<'_>, baseline: &Baseline, half_width: f64) -> Option<(Baseline, Strip)> {
    let baseline = near_image(grid.camera, baseline)?;
    let [low, high] = Strip::extent_of(grid, &baseline, half_width)?;
    let baseline = baseline.between(low.max(-baseline.half_length), high.min(baseline.half_length))?;
    Some((baseline, Strip::gather(grid, &baseline, half_width)))
}

/// The line of a refined limb, if it can be trusted.
fn judged(
    limb: &Limb<'_>,
    baseline: &Baseline,
    reach: f64,
    blur: f64,
    noise: &ImageNoise,
) -> Result<LimbLine, NotVisible> {
    let ends = [-1.0, 1.0].map(|side| limb.state.line.at(side * baseline.half_length));
    if noise.blur == 0.0 && blur >= MOST_BLUR.get() {
        // A limb is as sharp as the image; what is softer is the edge of a shadow.
        return Err(NotVisible::Uncertain);
    }
    if ends.iter().any(|u| u.abs() > reach) {
        return Err(NotVisible::OutOfReach);
    }
    // The offset where it is independent of the slope, and the distance from there at which the slope adds as
    // much variance as the offset has.
    let covariance = &limb.covariance;
    let of_slope = covariance[(1, 1)];
    let center = -covariance[(0, 1)] / of_slope;
    let of_offset = covariance[(0, 0)] + covariance[(0, 1)] * center;
    let half = (of_offset / of_slope).sqrt();
    let sigma = (2.0 * (of_offset + limb.misfit) + LINE_FLOOR.get().powi(2)).sqrt();
    let at_ends = (of_offset + of_slope * (baseline.half_length + center.abs()).powi(2)).sqrt();
    if at_ends.is_nan() || at_ends > LARGEST_DEVIATION.get() * noise.endpoint || half.is_nan() {
        return Err(NotVisible::Uncertain);
    }
    let ends = [center - half, center + half].map(|s| baseline.position(s, limb.state.line.at(s)));
    Ok(LimbLine { ends, sigma })
}

/// Whether so few blocks carry a line that it may as well be an edge beside the limb.
fn is_patchy(limb: &Limb<'_>) -> bool {
    limb.carriers() < (LEAST_SPREAD.get() * limb.blocks.len() as f64).min(ENOUGH_BLOCKS.get())
}

fn samples(limb: &Limb<'_>, baseline: &Baseline) -> List<LimbSample> {
    let sample = |block: &Block| LimbSample {
        position: baseline.position(block.s, limb.state.line.at(block.s) + block.shift),
        sigma: block.sigma,
        weight: block.weight,
    };
    limb.blocks.iter().map(sample).collect()
}

/// Refuses the less certain of two limbs found at one position, within some pixels.
fn drop_same_line(observations: &mut [LimbObservation; 2], apart: f64) {
    let [Ok(first), Ok(second)] = [observations[0].line, observations[1].line] else { return };
    if second.ends.iter().all(|q| across(&first.ends, q).abs() < apart) {
        observations[usize::from(second.sigma >= first.sigma)].line = Err(NotVisible::SameLine);
    }
}
