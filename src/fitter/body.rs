//! Before a fit: what in the mask of each view is the body of the cylinder. The rest is left out of the fit.

use super::edges::UsableEdges;
use super::options::Options;
use super::run::Run;
use super::start::{SAMPLE, median_distance};
use super::view::View;
use crate::camera::Camera;
use crate::detection::detect_in_mask;
use crate::error::Result;
use crate::geometry::{Cylinder, CylinderLimits};
use crate::memory::List;
use crate::parts::Parts;
use crate::start::moments::Moments;
use std::cell::RefCell;

/// Fewest points of a body, as a part of those in the mask: with less the cylinder that was found is hardly the one that
/// was meant.
const LEAST_PART: f64 = 0.1;

/// A cylinder is known before it is searched where the points are within this part of its radius of it in the median:
/// as near as the surface is looked for where the parts of a mask are told.
const KNOWN: f64 = 0.05;

/// What is known of a view before a fit.
#[derive(Default)]
pub(super) struct Separated {
    /// The view with the points and the pixels of the body alone; `None` where all of them are, or nobody can tell.
    pub body: Option<View>,
    /// The cylinder of the two segments of a view whose mask holds the body alone, where it was asked for.
    pub of_limbs: Option<Cylinder>,
    /// Whether all of the mask is the body of the start model, on which the points lie.
    pub whole: bool,
}

/// Separates the body in the mask of a view from the rest.
///
/// # Errors
/// `Cancelled`.
pub(super) fn separate(
    view: &View,
    options: &Options,
    start: Option<&Cylinder>,
    run: &mut Run<'_>,
) -> Result<Separated> {
    let (Some(camera), Some(depth), Some(mask)) = (view.camera(), view.depth(), view.mask.as_ref()) else {
        return Ok(Separated::default());
    };
    if view.is_body {
        return Ok(Separated { whole: true, ..Separated::default() });
    }
    // Most masks hold the body alone, and that takes no search.
    let Known { cylinder, of_limbs, given } = known(view, camera, options, start);
    let parts = cylinder.and_then(|cylinder| view.parts(&cylinder, &options.noise));
    if parts.is_some_and(|parts| parts.all_body()) {
        return Ok(Separated { body: None, of_limbs, whole: given });
    }
    let run = RefCell::new(run);
    let stopped = || run.borrow_mut().report_again().is_break();
    let found = detect_in_mask(camera, depth, mask, &limits_in(view, options), &stopped)?;
    let body = found.and_then(|cylinder| body(view, options, &cylinder));
    Ok(Separated { of_limbs: of_limbs.filter(|_| body.is_none()), body, whole: false })
}

/// The view with the body of a cylinder alone; `None` where all of it is, or too little.
pub(super) fn body(view: &View, options: &Options, cylinder: &Cylinder) -> Option<View> {
    let (camera, mask) = (view.camera()?, view.mask.as_ref()?);
    let parts = view.parts(cylinder, &options.noise)?;
    if parts.all_body() {
        return None;
    }
    let cloud = view.cloud.chosen(|index| parts.within_body(&view.cloud.point(index)));
    if (cloud.len() as f64) < LEAST_PART * view.cloud.len() as f64 {
        return None;
    }
    let body = parts.shown(camera, mask, Parts::within_body)?;
    Some(view.with_points(cloud, Some(body)))
}

/// The limits of cylinders in the coordinates of a view.
pub(super) fn limits_in(view: &View, options: &Options) -> CylinderLimits {
    options.cylinder_limits.moved(&view.pose().inverse())
}

/// A cylinder that is known before it is searched, on which the points lie.
struct Known {
    cylinder: Option<Cylinder>,
    of_limbs: Option<Cylinder>,
    /// Whether it is the start model.
    given: bool,
}

/// The start model, the cylinder of two segments or that of the moments of the points, where the points lie on it.
fn known(view: &View, camera: &Camera, options: &Options, start: Option<&Cylinder>) -> Known {
    let sample: List<_> = view.cloud.sampled(SAMPLE).collect();
    let explains = |cylinder: &Cylinder| median_distance(cylinder, &sample) <= KNOWN * cylinder.radius;
    let given = start.map(|start| view.seen(start)).filter(explains);
    if given.is_some() {
        return Known { cylinder: given, of_limbs: None, given: true };
    }
    let noise = options.noise.in_image(camera.size());
    let edges = UsableEdges::new(Some(camera), &view.segments, &noise);
    let of_limbs = if edges.segments.len() == 2 { edges.cylinder(&sample) } else { None };
    let of_moments = || {
        let points = sample.iter().map(|p| (*p, 1.0));
        let fit = Moments::new(points)?.best(limits_in(view, options).cone())?;
        Some(fit.cylinder).filter(explains)
    };
    Known { cylinder: of_limbs.filter(explains).or_else(of_moments), of_limbs, given: false }
}
