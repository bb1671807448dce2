//! Whether the mask that the caller gave ends beside the limbs of the fitted cylinder, or its sides converge.
//!
//! A mask is a hint and roughly drawn, but not by many pixels along most of a body. Where it ends far within a limb, or goes on
//! far beyond one, depth and image are misaligned, the depth is smeared beyond the body, or the mask holds something else.
//! Lids, handles and what stands in front change the width of a mask, too: along a part of the axis, or the depth shows it. Where
//! the width changes all along it, the body is no cylinder.

use super::constraints::{Constraints, ViewConstraints};
use super::data::{Data, ViewData};
use super::result::Flags;
use super::scales::Scales;
use crate::camera::Camera;
use crate::geometry::{Cylinder, LimbFrame};
use crate::memory::List;
use crate::observations::{DepthImage, Mask, pixel_at};
use crate::statistics::{at_both_ends, median, median_and_deviation};
use nalgebra::{Vector2, Vector3};

/// Positions along the axis at which the mask is looked at.
const SAMPLES: usize = 16;

/// Points that tell along which part of the axis the body is seen, and the part of them beyond it at either end: caps and rims
/// have another width.
const SAMPLE: usize = 64;
const BEYOND: usize = SAMPLE / 10;

/// Masks may end this many standard deviations of a side beside it, where the masks of the caller are rougher, and of the radius.
const DEVIATIONS: f64 = 3.0;

/// Steps from a limb to the middle of the surface in which the end of a mask is looked for.
const STEPS: usize = 16;

/// How steep the sides of a mask are at least against the limbs, as a change of the radius along the axis, where the body tapers.
const STEEPEST: f64 = 0.05;

/// What stands in front is nearer than the surface by this many standard deviations of the points.
const NEARER: f64 = 3.0;

/// How a mask ends beside a limb at one position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Beside {
    Near,
    Within,
    Beyond,
}

/// A view of a cylinder, in the coordinates of the view.
struct Silhouette<'a> {
    camera: &'a Camera,
    mask: &'a Mask,
    depth: Option<&'a DepthImage>,
    cylinder: Cylinder,
    /// How far nearer something in front is.
    nearer: f64,
}

impl Data<'_> {
    /// What the masks of the views say against a cylinder whose radius has a standard deviation: `MASK_DISAGREES` where one ends
    /// beside a limb along most of the axis, `BODY_TAPERS` where its sides converge.
    pub fn masks_against(
        &self,
        constraints: &Constraints,
        cylinder: &Cylinder,
        scales: &Scales,
        deviation: f64,
    ) -> Flags {
        let views = self.views.iter().zip(&constraints.views).zip(&scales.views).filter(|_| self.is_robust());
        let against = views.filter_map(|((view, constraints), scales)| {
            mask_against(view, constraints, view.seen(cylinder), NEARER * scales.point, deviation)
        });
        against.fold(Flags::empty(), Flags::union)
    }
}

/// `None` where there is nothing to compare.
fn mask_against(
    view: &ViewData<'_>,
    constraints: &ViewConstraints,
    cylinder: Cylinder,
    nearer: f64,
    deviation: f64,
) -> Option<Flags> {
    // Two limbs that are seen confirm each other, whatever the mask is.
    if constraints.located + constraints.given >= 2 || !view.view.sides_tell() {
        return None;
    }
    let (camera, mask) = (view.camera()?, view.view.mask.as_ref()?);
    let silhouette = Silhouette { camera, mask, depth: view.view.depth(), cylinder, nearer };
    let Cylinder { axis, radius } = cylinder;
    let positions: List<f64> =
        view.view.cloud.sampled(SAMPLE).map(|point| axis.position_of(&point)).collect();
    let [low, high] = at_both_ends(&positions, BEYOND.min(positions.len().checked_sub(1)? / 2));
    let noise = &view.noise;
    let allowed = noise.largest_margin().max(DEVIATIONS * noise.side);
    let lines = LimbFrame::new(&cylinder)?.limb_lines();
    let samples: [f64; SAMPLES] =
        std::array::from_fn(|k| low + (high - low) * (k as f64 + 0.5) / SAMPLES as f64);
    let disagrees = lines.iter().any(|line| {
        let counts = samples.iter().fold([0; 3], |mut counts, &along| {
            let middle = axis.at(along);
            let limb = line.nearest_to(&middle);
            let beside = silhouette.beside([&middle, &limb], allowed, DEVIATIONS * deviation / radius);
            counts[beside.map_or(0, |beside| beside as usize)] += usize::from(beside.is_some());
            counts
        });
        let [near, within, beyond] = counts;
        let most = (near + within + beyond).max(SAMPLES / 2) / 2;
        within > most || beyond > most
    });
    let width = |&along: &f64| {
        let middle = axis.at(along);
        let sides = lines.each_ref().map(|line| silhouette.side([&middle, &line.nearest_to(&middle)]));
        let [(one, half), (other, other_half)] = [sides[0]?, sides[1]?];
        Some([along / radius, (one + other) / (half + other_half), half + other_half])
    };
    // Only the depth tells what hides a limb.
    let seen = silhouette.depth.map_or(&samples[..0], |_| &samples);
    let widths: List<[f64; 3]> = seen.iter().filter_map(width).collect();
    let tapers = slope(&widths, noise.side)
        .is_some_and(|[slope, deviation]| slope.abs() > STEEPEST.max(DEVIATIONS * deviation));
    let mut against = Flags::empty();
    against.set(Flags::MASK_DISAGREES, disagrees);
    against.set(Flags::BODY_TAPERS, tapers);
    // The most work comes last: most masks are where the limbs are.
    (!against.is_empty() && view.view.mask_is_drawn()).then_some(against)
}

/// How the radius changes along the axis and the standard deviation of that, by positions along it in radii, by how much the
/// mask is wider there than the cylinder as a part of its width, and that width in pixels. By the median of the slopes of all
/// pairs (Theil and Sen), as lids and handles change the width of a part. Masks are off by `side` at either end of a side: they may
/// be drawn from corner to corner.
fn slope(widths: &[[f64; 3]], side: f64) -> Option<[f64; 2]> {
    if widths.len() < SAMPLES / 2 {
        return None;
    }
    let pairs = widths.iter().enumerate().flat_map(|(k, a)| widths[..k].iter().map(move |b| (a, b)));
    let mut slopes: List<f64> = pairs.map(|(a, b)| (a[1] - b[1]) / (a[0] - b[0])).collect();
    let slope = median(&mut slopes);
    let mut left: List<f64> = widths.iter().map(|[x, y, _]| y - slope * x).collect();
    let [_, left] = median_and_deviation(&mut left);
    let reach = widths[widths.len() - 1][0] - widths[0][0];
    let mean = |k: usize| widths.iter().map(|width| width[k]).sum::<f64>() / widths.len() as f64;
    let (middle, pixels) = (mean(0), mean(2));
    let spread = widths.iter().map(|[x, ..]| (x - middle).powi(2)).sum::<f64>().sqrt();
    let corners = 2.0 * side / (pixels * reach);
    Some([slope, (left / spread).max(corners)])
}

impl Silhouette<'_> {
    /// Where the mask ends at the limb beside a point of the axis: near it when they differ by no more than what masks are `allowed`,
    /// in pixels, and what the radius is `uncertain`, as a part of it. `None` where the image ends, something in front hides the
    /// limb, or neither is seen.
    fn beside(&self, across: [&Vector3<f64>; 2], allowed: f64, uncertain: f64) -> Option<Beside> {
        let (limb, outward, width) = self.limb_across(across)?;
        let limit = allowed.hypot(uncertain * width);
        let at = |offset: f64| self.pixel(&self.on_surface(across, (offset / width).min(1.0))?);
        let within = at(limit)?;
        let beyond = self.pixel(&(limb + outward * limit))?;
        if self.mask.contains(beyond.0, beyond.1) {
            return Some(Beside::Beyond);
        }
        if limit >= width || self.mask.contains(within.0, within.1) {
            return Some(Beside::Near);
        }
        let step = (width - limit) / STEPS as f64;
        let inward = (0..STEPS).map_while(|k| at(limit + step * k as f64));
        let mut missing = inward.take_while(|&(x, y)| !self.mask.contains(x, y));
        let hidden = missing.any(|pixel| self.is_hidden(pixel));
        (!hidden).then_some(Beside::Within)
    }

    /// Where the surface at the position of a point of the axis is seen, at a part of the way from the limb to the axis. Of an axis that
    /// leads away from the camera the straight way would cross a cap, and surface at other positions.
    fn on_surface(&self, [middle, limb]: [&Vector3<f64>; 2], part: f64) -> Option<Vector2<f64>> {
        let sideways = limb - middle;
        let across = self.cylinder.axis.direction.cross(&sideways);
        let toward_camera = across * -across.dot(middle).signum();
        let cosine = 1.0 - part;
        let sine = (1.0 - cosine * cosine).sqrt();
        self.camera.project(&(middle + sideways * cosine + toward_camera * sine))
    }

    /// By how many pixels the mask ends beyond the limb beside a point of the axis, and how many lie between the two. `None` as in
    /// [`Self::beside`], and where the mask ends farther beyond the limb than the axis lies within.
    fn side(&self, across: [&Vector3<f64>; 2]) -> Option<(f64, f64)> {
        let (limb, outward, width) = self.limb_across(across)?;
        let pixel = |offset: f64| self.pixel(&(limb + outward * offset));
        let is_set = |(x, y): (usize, usize)| self.mask.contains(x, y);
        let beyond = is_set(pixel(0.0)?);
        let step = if beyond { 1.0 } else { -1.0 };
        for k in 1..=width as usize {
            let offset = step * k as f64;
            let at = pixel(offset)?;
            if is_set(at) != beyond {
                return Some((offset - step / 2.0, width));
            }
            if !beyond && self.is_hidden(at) {
                return None;
            }
        }
        None
    }

    /// A point of a limb beside one of the axis in the image, the direction away from the axis, and the pixels between the two.
    fn limb_across(&self, [middle, limb]: [&Vector3<f64>; 2]) -> Option<(Vector2<f64>, Vector2<f64>, f64)> {
        let (middle, limb) = (self.camera.project(middle)?, self.camera.project(limb)?);
        let width = (limb - middle).norm();
        Some((limb, (limb - middle) / width, width))
    }

    /// The pixel at a position in the image.
    fn pixel(&self, at: &Vector2<f64>) -> Option<(usize, usize)> {
        pixel_at(at).filter(|&(x, y)| x < self.mask.width() && y < self.mask.height())
    }

    /// Whether something is seen there in front of the cylinder.
    fn is_hidden(&self, (x, y): (usize, usize)) -> bool {
        let depth = self.depth.and_then(|depth| depth.depth(x, y));
        let surface = self.camera.ray_of_pixel(x, y).and_then(|ray| self.cylinder.first_hit(&ray));
        depth.zip(surface).is_some_and(|(depth, surface)| depth < surface.z - self.nearer)
    }
}
