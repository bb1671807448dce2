//! Whether the mask that the caller gave holds another body besides the fitted cylinder.
//!
//! The mask of a whole object holds lids, handles and some background along its outline besides the lateral surface. A mask
//! of two objects is fitted, too: by one of them, or by a cylinder between them. Which one was meant nobody can tell.

use super::data::{Data, ViewData};
use super::scales::Scales;
use crate::geometry::Cylinder;
use crate::memory::List;
use crate::noise::{LARGEST_DEPTH_NOISE, NoiseModel};
use crate::parts::Collar;
use nalgebra::Vector3;

/// About how many pixels of a mask are looked at, and how many of them must have a depth.
const SAMPLE: f64 = 1000.0;
const LEAST: usize = 40;

/// A point belongs to something else farther outside of the surface than this many standard deviations of the points, and
/// than this part of the radius: rims are a few per cent wider. Inside of it are inner walls, bottoms and necks.
const DEVIATIONS: f64 = 3.0;
const WIDER: f64 = 0.05;

/// The largest part of the pixels that may belong to something else: docs/measurements-masks.md, "Masks of two bodies".
const LARGEST_PART: f64 = 0.1;

impl Data<'_> {
    /// Whether the mask of a view holds much besides a cylinder.
    pub fn mask_holds_another(&self, cylinder: &Cylinder, scales: &Scales) -> bool {
        let mut views = self.views.iter().zip(&scales.views);
        self.is_robust()
            && views.any(|(view, scales)| {
                let cylinder = view.seen(cylinder);
                let distance = view.into_view.point(&self.center).norm();
                let wider = (WIDER * cylinder.radius).min(LARGEST_DEPTH_NOISE * distance);
                let reach = (DEVIATIONS * scales.point).max(wider);
                holds_another(view, &cylinder, reach, &self.options.noise) == Some(true)
            })
    }
}

/// Whether many pixels of a mask, away from its outline, have points outside of a cylinder and its lids and rings; `None` where
/// too few have a depth, and where the mask is no hint of the caller.
fn holds_another(view: &ViewData<'_>, cylinder: &Cylinder, reach: f64, noise: &NoiseModel) -> Option<bool> {
    let (camera, mask, depth) = (view.camera()?, view.view.mask.as_ref()?, view.view.depth()?);
    if view.view.is_body || cylinder.contains_origin() {
        return None;
    }
    // Beside its outline a mask may hold the background.
    let margin = view.noise.largest_margin().ceil() as usize;
    let is_inner = |&(x, y): &(usize, usize)| {
        let set = |x: Option<usize>, y: Option<usize>| x.zip(y).is_some_and(|(x, y)| mask.contains(x, y));
        set(x.checked_sub(margin), Some(y))
            && set(x.checked_add(margin), Some(y))
            && set(Some(x), y.checked_sub(margin))
            && set(Some(x), y.checked_add(margin))
    };
    // What the caller has cut off is no part of the mask.
    let range = view.view.frame.depth_range();
    let depth = |x, y| depth.depth(x, y).filter(|z| (range.min..=range.max).contains(z));
    let stride = (mask.count() as f64 / SAMPLE).sqrt().ceil().max(1.0) as usize;
    let pixels = mask.set_pixels_of_grid(stride).filter(is_inner);
    let mut all = 0;
    let mut others: List<Vector3<f64>> = List::new();
    let point_at = |x: usize, y: usize| Some(camera.ray_of_pixel(x, y)? * depth(x, y)?);
    let is_outside = |point: &Vector3<f64>| cylinder.distance(point) > reach;
    // Where a body is most of the neighbours lie on it, too; those of an outlying depth do not.
    let has_company = |x: usize, y: usize| {
        let beside = (x.saturating_sub(1)..=x + 1)
            .flat_map(|x| (y.saturating_sub(1)..=y + 1).map(move |y| (x, y)))
            .filter(|&at| at != (x, y));
        let count = |(outside, all), point| (outside + usize::from(is_outside(&point)), all + 1);
        let (outside, all) = beside.filter_map(|(x, y)| point_at(x, y)).fold((0, 0), count);
        2 * outside >= all
    };
    for (x, y, point) in pixels.filter_map(|(x, y)| Some((x, y, point_at(x, y)?))) {
        all += 1;
        if is_outside(&point) && has_company(x, y) {
            others.push(point);
        }
    }
    let are_many = |count: usize| all >= LEAST && count as f64 > LARGEST_PART * all as f64;
    if !are_many(others.len()) {
        return (all >= LEAST).then_some(false);
    }
    let collars = view.view.parts(cylinder, noise).map(|parts| parts.collars).unwrap_or_default();
    let on_collar = |point: &Vector3<f64>| {
        let along = cylinder.axis.position_of(point);
        let within = |collar: &Collar| (collar.stretch[0]..=collar.stretch[1]).contains(&along);
        let outer = |collar: &Collar| collar.radius - cylinder.radius + reach;
        collars.iter().any(|collar| within(collar) && cylinder.distance(point) <= outer(collar))
    };
    Some(are_many(others.iter().filter(|point| !on_collar(point)).count()))
}
