//! The limbs in the next image of a sequence: about where they are expected, and as they looked in the last image.
//!
//! Blur, noise, shading and background are those of the last image, and the lines begin where the limbs are expected, so
//! that a few steps remain of the search. Where the image does not agree with that, nothing is found here.

use super::block::{INSIDE, OUTSIDE};
use super::compression::noise_of_compression;
use super::consensus::{RoughLine, is_long_enough};
use super::limb::{Expected, Limb, Look, SHADING};
use super::refine::refine_again;
use super::shading::{LimbShading, Shading};
use super::strip::{Baseline, Grid, Strip};
use super::{
    LimbObservation, LimbSearch, SIDES, SeenLimbs, baselines, drop_same_line, inner_shading, near_image,
    observed,
};
use crate::camera::Camera;
use crate::geometry::{Cylinder, LimbFrame};
use crate::observations::{GreyImage, ReducedImage};
use nalgebra::{Vector2, Vector3};

constants! {
    /// How many times as far from the profile the pixels may be as in the last image: noise alone changes this by some
    /// hundredths.
    WORSE = 1.5, "";

    /// Where the last image was so blurred that its grid was made coarser, and this one has less blur, in pixels of that grid, a finer
    /// grid shows more: sharp images have about 0.4 on boxes of two and three pixels.
    SHARPER = 0.5, "px";

    /// By how much the surface beside a limb may be brighter or darker than in the last image, as a part: the exposure of a camera follows
    /// slowly, lamps are switched.
    BRIGHTER = 0.1, "";

    /// When the axis, or the direction from the camera to it, has turned by more, in radians, the light is looked at again:
    /// half the distance of the lamps that are tried.
    TURNED = 0.065, "rad";
}

/// What both limbs of a cylinder looked like in an image, in pixels of its grid.
#[derive(Debug, Clone)]
pub struct Appearance {
    /// Columns and rows of the boxes of the grid.
    factor: usize,
    blur: f64,
    light: Light,
    limbs: [Look; 2],
    /// Two positions of each line.
    lines: [[Vector2<f64>; 2]; 2],
}

impl Appearance {
    /// `None` where a line was not found. `seen` is in pixels of the grid.
    pub(super) fn new(
        factor: usize,
        blur: f64,
        light: Light,
        limbs: [&Limb<'_>; 2],
        seen: &[LimbObservation; 2],
    ) -> Option<Self> {
        let [Ok(first), Ok(second)] = seen.each_ref().map(|limb| limb.line) else { return None };
        Some(Self { factor, blur, light, limbs: limbs.map(Limb::look), lines: [first.ends, second.ends] })
    }

    /// Whether the pixels are as near to the profiles as they were in another image.
    fn is_as_good_as(&self, last: &Self) -> bool {
        let mut pairs = self.limbs.iter().zip(&last.limbs);
        pairs.all(|(limb, last)| limb.residual <= WORSE.get() * last.residual.max(last.noise))
    }

    /// Whether the surface is as bright beside the limbs as it was in another image: where the lamps changed, its shading is another one,
    /// and a line may slide to where that looks like the old one.
    fn is_lit_like(&self, last: &Self) -> bool {
        let mut pairs = self.limbs.iter().zip(&last.limbs);
        pairs.all(|(limb, last)| (limb.level - last.level).abs() <= BRIGHTER.get() * last.level.abs())
    }
}

/// The shading of a cylinder and where it was seen from.
#[derive(Debug, Clone)]
pub(super) struct Light {
    shading: Option<Shading>,
    toward: Vector3<f64>,
    direction: Vector3<f64>,
}

impl Light {
    /// `None` where the cylinder has no limbs.
    pub fn new(model: &Cylinder, shading: Option<Shading>) -> Option<Self> {
        let LimbFrame { toward, direction, .. } = LimbFrame::new(model)?;
        Some(Self { shading, toward, direction })
    }

    /// Whether another cylinder is seen in the same light.
    fn is_that_of(&self, model: &Cylinder) -> bool {
        let least = TURNED.get().cos();
        LimbFrame::new(model).is_some_and(|now| {
            now.toward.dot(&self.toward) >= least && now.direction.dot(&self.direction) >= least
        })
    }
}

/// Where a line is at the ends of a baseline; on it where the line does not go along it.
fn at_ends(baseline: &Baseline, line: &[Vector2<f64>; 2]) -> [f64; 2] {
    let [(s0, u0), (s1, u1)] = line.map(|end| baseline.coordinates(&end));
    let slope = (u1 - u0) / (s1 - s0);
    let half = baseline.half_length;
    let ends = [-half, half].map(|s| u0 + slope * (s - s0));
    if ends.iter().all(|u| u.is_finite()) { ends } else { [0.0; 2] }
}

/// Locates both limbs of a cylinder within `search.reach` of where it has them, as they looked in the last image of a
/// sequence, and where they were there if it is at `rest`. `None` where they are not there, or look otherwise.
#[must_use]
pub fn locate_limbs_again(
    image: &GreyImage,
    camera: &Camera,
    model: &Cylinder,
    search: &LimbSearch,
    last: &Appearance,
    rest: bool,
) -> Option<SeenLimbs> {
    let factor = last.factor;
    let finest = search.noise.factor(None, 1);
    let (camera, search) = (camera.reduced(factor), search.reduced(factor));
    let lit_alike = last.light.is_that_of(model);
    // Only the shading asks for it.
    let least_noise = if lit_alike { 0.0 } else { noise_of_compression(image) };
    let image = ReducedImage::new(image, factor);
    let grid = Grid { image, camera: &camera, noise: search.noise, least_noise };
    let (baselines, radius) = baselines(grid.camera, model, &search.ranges)?;
    let [first, second] = [0, 1].map(|k| {
        let half_width = search.reach[k] + OUTSIDE.get().max(INSIDE.get());
        let (baseline, strip) = long_enough_strip(&grid, &baselines[k], half_width)?;
        let ends = if rest { at_ends(&baseline, &last.lines[k]) } else { [0.0; 2] };
        let rough = RoughLine { ends, score: 0.0, visible: true };
        let (half_length, deviation) = (baseline.half_length, search.deviation[k]);
        let noise = last.limbs[k].noise;
        Some((baseline, strip, Expected { rough, half_length, deviation, noise }))
    });
    let found = [first?, second?];
    let light = match lit_alike {
        true => last.light.clone(),
        false => {
            let known =
                found.each_ref().map(|(baseline, strip, expected)| Some((strip, baseline, *expected)));
            Light::new(model, inner_shading(&grid, &baselines, &known, radius))?
        }
    };
    let mut limbs = [0, 1].map(|k| {
        let (_, strip, expected) = &found[k];
        let plain = || LimbShading::plain(SHADING.get());
        let near = light.shading.map_or_else(plain, |shading| shading.near_limb(SIDES[k], radius));
        let shading = if lit_alike { last.limbs[k].shading } else { Vector2::zeros() };
        Limb::again(strip, *expected, &near, radius, &Look { shading, ..last.limbs[k] })
    });
    let blur = refine_again(&mut limbs, search.noise.blur, last.blur, search.reach, rest)?;
    let mut seen = [0, 1].map(|k| observed(&limbs[k], &found[k].0, search.reach[k], blur, &search.noise));
    drop_same_line(&mut seen, search.noise.apart());
    let [first, second] = &limbs;
    let appearance = Appearance::new(factor, blur, light, [first, second], &seen)?;
    let is_sharper = factor > finest && blur < SHARPER.get();
    (appearance.is_as_good_as(last) && (!lit_alike || appearance.is_lit_like(last)) && !is_sharper)
        .then(|| SeenLimbs { limbs: seen.map(|limb| limb.enlarged(factor)), appearance: Some(appearance) })
}

/// The part of the image around a baseline, and the baseline, cut to what the image shows where more than a pixel of it is beyond; `None`
/// where that is too short.
fn long_enough_strip(grid: &Grid<'_>, baseline: &Baseline, half_width: f64) -> Option<(Baseline, Strip)> {
    let mut baseline = near_image(grid.camera, baseline)?;
    let half = baseline.half_length;
    let [low, high] = Strip::extent_of(grid, &baseline, half_width)?;
    if low > 1.0 - half || high < half - 1.0 {
        baseline = baseline.between(low.max(-half), high.min(half))?;
    }
    let strip = Strip::gather(grid, &baseline, half_width);
    is_long_enough(strip.len()).then_some((baseline, strip))
}
