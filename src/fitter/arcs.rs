//! Fourth stage: the arcs of the ends, located in the images for the tilt of the axis.

use super::data::{Data, ViewData};
use super::guided::CONTRADICTION;
use super::held::{EndPlace, Held, HeldView};
use super::located::Located;
use super::objective::{Minimum, Precision};
use super::run::Run;
use crate::camera::Camera;
use crate::end_location::{ArcSample, EndSearch, LastArc, depth_tolerance, locate_ends};
use crate::error::Result;
use crate::geometry::Cylinder;
use crate::limb_location::blur_of;
use crate::memory::List;
use crate::residuals::{ArcRay, ArcTerm, Progress, Reweighted, Reweighting, Scale, near_wall};
use crate::statistics::independent_part;
use nalgebra::{Matrix3, Vector3};
use std::ops::ControlFlow;

/// Fewest places that tell how an arc is bent.
const LEAST_PLACES: usize = 8;

/// A ray that meets the surface at a sine below this grazes it: its position along the axis hangs on the limb.
const LEAST_SINE: f64 = 0.25;

/// Rounds of reweighting.
const REWEIGHTINGS: usize = 5;

/// Most rounds of arcs and minimum: the first tilt may be off by degrees, and the arcs are looked for where it says. Most
/// frames settle in two, short cans in three.
pub(super) const ARC_ROUNDS: usize = 5;

/// An axis that turned by less than this, in radians, leaves the arcs where they were found: at a radius of 25
/// pixels it moves them by a tenth of a pixel.
pub(super) const SETTLED_TURN: f64 = 0.004;

/// A minimum contradicts the lines that it is held to where it leaves them by this many standard deviations, root mean
/// square.
const LEFT_LINES: f64 = 3.0;

/// Locates the arcs of the ends from a minimum and iterates on with them, until the axis settles. Arcs that
/// contradict the points or the limbs are something else and are dropped.
pub(super) fn bend(data: &Data<'_>, located: Located, run: &mut Run<'_>) -> Result<Located> {
    // With a radius that no limb holds the arcs bend otherwise.
    if located.held.limbs_located() == 0 {
        return Ok(located);
    }
    let scale = located.minimum.scale();
    let without = located.held.clone();
    let Located { mut minimum, mut held } = located;
    for _ in 0..ARC_ROUNDS {
        let before = *minimum.cylinder();
        let known =
            held.views.iter().map(|view| KnownEnds { whole: view.is_whole(), ..KnownEnds::default() });
        held = with_arcs(data, &without, &known.collect::<List<_>>(), &before, run)?;
        if held.views.iter().all(|view| view.arcs.ends.is_empty()) {
            break;
        }
        let after = data.minimise_again(&held, &minimum, Precision::Rough, run)?;
        if contradicts(data, &held, &after, scale) {
            held = without;
            break;
        }
        minimum = after;
        if before.axis.angle(&minimum.cylinder().axis) < SETTLED_TURN {
            break;
        }
    }
    Ok(Located { minimum, held })
}

/// Whether a minimum with arcs contradicts the points, whose `scale` without arcs is known, or the lines. Points that scatter less
/// with the arcs side with them: then it is a line that is wrong.
pub(super) fn contradicts(data: &Data<'_>, held: &Held, minimum: &Minimum, scale: f64) -> bool {
    let is_left = |(view, held): (&ViewData<'_>, &HeldView)| {
        let squares = held.lines.as_ref()?.mean_square(&view.seen(minimum.cylinder()))?;
        Some(squares > (LEFT_LINES * view.noise.endpoint).powi(2))
    };
    let mut views = data.views.iter().zip(&held.views);
    minimum.scale() > CONTRADICTION * scale
        || minimum.scale() > scale && views.any(|view| is_left(view) == Some(true))
}

/// What is known of the ends of a view before they are located.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct KnownEnds {
    /// Whether the mask holds the body alone.
    pub whole: bool,
    /// The arcs of the last image of a sequence.
    pub last: [Option<LastArc>; 2],
}

/// The arcs of the ends that the images show, each place weighed by how well it agrees with its neighbours.
pub(super) fn with_arcs(
    data: &Data<'_>,
    held: &Held,
    known: &[KnownEnds],
    cylinder: &Cylinder,
    run: &mut Run<'_>,
) -> Result<Held> {
    let views = data.views.iter().zip(&held.views).zip(known).map(|((view, held), known)| {
        let found = arcs(view, held, known, &view.seen(cylinder), run)?;
        let (arcs, ends) = found.unwrap_or_default();
        Ok(HeldView {
            arcs,
            ends: ends.map(|end| end.map(|end| EndPlace::new(&end, cylinder))),
            ..held.clone()
        })
    });
    Ok(Held { views: views.collect::<Result<_>>()?, ..held.clone() })
}

/// The arcs that one view shows, and where they are; `None` when it shows none.
fn arcs(
    view: &ViewData<'_>,
    held: &HeldView,
    known: &KnownEnds,
    cylinder: &Cylinder,
    run: &mut Run<'_>,
) -> Result<Option<(ArcTerm, [Option<LastArc>; 2])>> {
    if cylinder.contains_origin() {
        return Ok(None);
    }
    let (Some(camera), Some(mask), Some(image)) = (view.camera(), view.view.mask.as_ref(), view.view.image())
    else {
        return Ok(None);
    };
    let search = EndSearch {
        camera,
        mask,
        whole: known.whole || view.view.mask_is_body,
        depth: view.view.depth(),
        image: Some(image),
        tolerance: depth_tolerance(&view.view.cloud, cylinder),
        limbs_known: held.given + held.located > 0,
        noise: view.noise,
        blur: held.limbs.as_ref().and_then(blur_of),
        last: known.last,
    };
    let ControlFlow::Continue(ends) = locate_ends(&search, cylinder, &mut || run.hear()) else {
        return Err(run.cancelled());
    };
    let Some(ends) = ends else { return Ok(None) };
    let endpoint = view.noise.endpoint;
    // A mask that goes on beyond an end is that of a whole object. A lid or rim may be at either end of it, and the circle
    // of one that is wider by a part of the radius looks like a tilt by that part.
    if ends.iter().any(|end| end.rim) {
        return Ok(None);
    }
    let last = ends.each_ref().map(|end| end.arc);
    let ends = ends.iter().filter_map(|end| places(camera, cylinder, &end.samples, endpoint));
    Ok(Some((ArcTerm { ends: ends.collect() }, last)))
}

/// The places of one end with their weights, in units of the standard deviation of an endpoint; `None` where they do not tell how the arc is bent.
fn places(
    camera: &Camera,
    cylinder: &Cylinder,
    samples: &[ArcSample],
    endpoint: f64,
) -> Option<List<ArcRay>> {
    let away = cylinder.axis.nearest_to_origin().normalize();
    let sideways = cylinder.axis.direction.cross(&away);
    let found: List<(ArcRay, f64, Vector3<f64>)> = samples
        .iter()
        .filter_map(|sample| {
            let ray = camera.unproject(&sample.pixel)?;
            let (position, normal) = near_wall(cylinder, &ray)?;
            let grazing = -normal.dot(&ray) < LEAST_SINE * ray.norm();
            // An arc seen under a wrong tilt departs like this.
            let shape = Vector3::new(1.0, normal.dot(&away), normal.dot(&sideways));
            let place = ArcRay { ray, across: sample.across, weight: sample.deviation.powi(-2) };
            (!grazing).then_some((place, position, shape))
        })
        .collect();
    if found.len() < LEAST_PLACES {
        return None;
    }
    let deviations: List<f64> = found.iter().map(|(place, ..)| place.weight.sqrt().recip()).collect();
    // The scale is how much more the places scatter than their deviations explain.
    let driver = Reweighting { rounds: REWEIGHTINGS, scale: Scale::AtLeast(1.0) };
    let mut left = List::filled(0.0, found.len());
    let Reweighted { weights, scale } = driver.fit(found.len(), |weights, residuals| {
        let (mut square, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for ((place, position, shape), weight) in found.iter().zip(weights) {
            let w = weight * place.weight * place.across * place.across;
            square += shape * shape.transpose() * w;
            right += shape * (w * position);
        }
        let solution = square.try_inverse()? * right;
        for (((place, position, shape), deviation), residual) in
            found.iter().zip(&deviations).zip(residuals.iter_mut())
        {
            *residual = (position - shape.dot(&solution)) * place.across / deviation;
        }
        left.copy_from_slice(residuals);
        Some(Progress::Moved)
    })?;
    left.iter_mut().zip(&weights).for_each(|(residual, weight)| *residual *= weight.sqrt());
    // Neighbours share pixels, and what the model of the profile leaves out.
    let factor = independent_part(&left) * (endpoint / scale).powi(2);
    let weighted = |((place, ..), weight): ((ArcRay, f64, Vector3<f64>), f64)| ArcRay {
        weight: place.weight * weight * factor,
        ..place
    };
    Some(found.into_iter().zip(weights).map(weighted).collect())
}
