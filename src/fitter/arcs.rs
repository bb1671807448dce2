//! Fourth stage: the arcs of the ends, located in the images for the tilt of the axis.

use super::constraints::{Constraints, EndPosition, ViewConstraints};
use super::data::{Data, ViewData};
use super::guided::SCALE_CONTRADICTION;
use super::located::Located;
use super::objective::{Minimum, Precision};
use super::run::Run;
use crate::camera::Camera;
use crate::end_location::{ArcSample, End, EndSearch, LastArc, MaskContent, depth_tolerance, locate_ends};
use crate::error::Result;
use crate::geometry::Cylinder;
use crate::limb_location::blur_of;
use crate::memory::List;
use crate::residuals::{ArcRay, ArcTerm, Progress, Reweighted, Reweighting, Rim, Scale, on_wall};
use crate::statistics::independent_part;
use nalgebra::{SMatrix, SVector, Vector4};
use std::ops::ControlFlow;

/// Fewest samples that tell how an arc is bent.
const LEAST_SAMPLES: usize = 8;

/// A ray that meets the surface at a sine below this grazes it: its position along the axis hangs on the limb.
const LEAST_SINE: f64 = 0.25;

/// Standard deviation of the radius of an end circle about that of the body, as a part of it, in a mask of a whole object: lids
/// are a few per cent wider.
const WIDTH_DEVIATION: f64 = 0.05;

/// Both rims must tell that radius to this standard deviation, and agree with the body within so many of them.
const LARGEST_OF_WIDTH: f64 = 0.03;
const WIDER: f64 = 2.0;

/// Rounds of reweighting.
const REWEIGHTINGS: usize = 5;

/// Most rounds of arcs and minimum: the first tilt may be off by degrees, and the arcs are looked for where it says. Most
/// frames settle in two, short cans in three.
pub(super) const ARC_ROUNDS: usize = 5;

/// An axis that turned by less than this, in radians, leaves the arcs where they were found: at a radius of 25
/// pixels it moves them by a tenth of a pixel.
pub(super) const SETTLED_TURN: f64 = 0.004;

/// A minimum contradicts the lines that constrain it where it leaves them by this many standard deviations, root mean
/// square.
const LEFT_LINES: f64 = 3.0;

/// Locates the arcs of the ends from a minimum and iterates on with them, until the axis settles. Arcs that
/// contradict the points or the limbs are something else and are dropped.
pub(super) fn fit_with_arcs(data: &Data<'_>, located: Located, run: &mut Run<'_>) -> Result<Located> {
    // With a radius that no limb holds the arcs bend otherwise.
    if located.constraints.limbs_located() == 0 {
        return Ok(located);
    }
    let scale = located.minimum.scale();
    let without = located.constraints.clone();
    let Located { mut minimum, mut constraints } = located;
    for _ in 0..ARC_ROUNDS {
        let before = *minimum.cylinder();
        let known =
            constraints.views.iter().map(|view| KnownEnds { whole: view.is_whole(), ..KnownEnds::default() });
        constraints = with_arcs(data, &without, &known.collect::<List<_>>(), &before, run)?;
        if constraints.views.iter().all(|view| view.arcs.ends.is_empty()) {
            break;
        }
        let after = data.minimise_again(&constraints, &minimum, Precision::Rough, run)?;
        if contradicts(data, &constraints, &after, scale) {
            constraints = without;
            break;
        }
        minimum = after;
        if before.axis.angle(&minimum.cylinder().axis) < SETTLED_TURN {
            break;
        }
    }
    Ok(Located { minimum, constraints })
}

/// Whether a minimum with arcs contradicts the points, whose `scale` without arcs is known, or the lines. Points that scatter less
/// with the arcs side with them: then it is a line that is wrong.
pub(super) fn contradicts(data: &Data<'_>, constraints: &Constraints, minimum: &Minimum, scale: f64) -> bool {
    let is_left = |(view, constraints): (&ViewData<'_>, &ViewConstraints)| {
        let squares = constraints.lines.as_ref()?.mean_square(&view.seen(minimum.cylinder()))?;
        Some(squares > (LEFT_LINES * view.noise.endpoint).powi(2))
    };
    let mut views = data.views.iter().zip(&constraints.views);
    minimum.scale() > SCALE_CONTRADICTION * scale
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

/// The arcs of the ends that the images show, each sample weighed by how well it agrees with its neighbours.
pub(super) fn with_arcs(
    data: &Data<'_>,
    constraints: &Constraints,
    known: &[KnownEnds],
    cylinder: &Cylinder,
    run: &mut Run<'_>,
) -> Result<Constraints> {
    let views = data.views.iter().zip(&constraints.views).zip(known).map(|((view, constraints), known)| {
        let found = arcs(view, constraints, known, &view.seen(cylinder), run)?;
        let (arcs, ends) = found.unwrap_or_default();
        Ok(ViewConstraints {
            arcs,
            ends: ends.map(|end| end.map(|end| EndPosition::new(&end, cylinder))),
            ..constraints.clone()
        })
    });
    Ok(Constraints { views: views.collect::<Result<_>>()?, ..constraints.clone() })
}

/// The arcs that one view shows, and where they are; `None` when it shows none.
fn arcs(
    view: &ViewData<'_>,
    constraints: &ViewConstraints,
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
        mask: view.view.for_ends(mask),
        content: match known.whole {
            _ if view.view.is_body => MaskContent::Region,
            true => MaskContent::Body,
            false => MaskContent::Anything,
        },
        drawn: view.view.mask_is_drawn(),
        depth: view.view.depth(),
        image: Some(image),
        tolerance: depth_tolerance(&view.view.cloud, cylinder),
        limbs_known: constraints.given + constraints.located > 0,
        noise: view.noise,
        blur: constraints.limbs.as_ref().and_then(blur_of),
        last: known.last,
    };
    let ControlFlow::Continue(ends) = locate_ends(&search, cylinder, &mut || run.poll_cancel()) else {
        return Err(run.cancelled());
    };
    let Some(ends) = ends else { return Ok(None) };
    let endpoint = view.noise.endpoint;
    // A mask that goes on beyond an end is that of a whole object. A lid or rim may be at either end of it, and the circle
    // of one that is wider by a part of the radius looks like a tilt by that part. Where both rims are seen, they tell its radius.
    let whole_object = ends.iter().any(|end| end.rim);
    let last = ends.each_ref().map(|end| end.arc);
    let widening = if whole_object { WIDTH_DEVIATION * cylinder.radius / endpoint } else { 0.0 };
    let of_end = |end: &End| {
        let mut found = on_rims(camera, cylinder, end);
        if is_of_body(cylinder, &found) {
            return weighted_samples(found, endpoint, widening);
        }
        found.retain(|sample| sample.ray.rim == Rim::Near);
        (!whole_object).then(|| weighted_samples(found, endpoint, 0.0))?
    };
    Ok(Some((ArcTerm { ends: ends.iter().filter_map(of_end).collect() }, last)))
}

/// A sample on a rim of an end.
struct Sample {
    ray: ArcRay,
    /// Where it says that the end is, along the axis.
    position: f64,
    /// How that changes with the end, with a tilt of the axis towards the camera and sideways, and with the radius of the circle.
    shape: Vector4<f64>,
}

/// The samples of one end with their weights, in units of the standard deviation of an endpoint; `None` where they do not tell how
/// the arc is bent. `widening` is the standard deviation of the radius of the end circle in the same units.
fn weighted_samples(found: List<Sample>, endpoint: f64, widening: f64) -> Option<List<ArcRay>> {
    let Circle { weights, scale, independent, .. } = Circle::<3>::through(&found)?;
    // Neighbours share pixels, and what the model of the profile leaves out.
    let factor = independent * (endpoint / scale).powi(2);
    let weighted = |(Sample { ray, shape, .. }, weight): (Sample, f64)| ArcRay {
        weight: ray.weight * weight * factor,
        widening: widening * shape[3],
        ..ray
    };
    Some(found.into_iter().zip(weights).map(weighted).collect())
}

/// Whether both rims of an end are seen, and on a circle of the radius of the body, not on that of a wider lid.
fn is_of_body(cylinder: &Cylinder, found: &[Sample]) -> bool {
    if found.iter().all(|sample| sample.ray.rim == Rim::Near) {
        return false;
    }
    let Some(Circle { solution, covariance, scale, independent, .. }) = Circle::<4>::through(found) else {
        return false;
    };
    let wider = solution[3] / cylinder.radius;
    let deviation = (covariance[(3, 3)] / independent).sqrt() * scale / cylinder.radius;
    deviation <= LARGEST_OF_WIDTH && wider.abs() <= WIDER * deviation
}

/// The samples on both rims of an end.
fn on_rims(camera: &Camera, cylinder: &Cylinder, end: &End) -> List<Sample> {
    let away = cylinder.axis.nearest_to_origin().normalize();
    let sideways = cylinder.axis.direction.cross(&away);
    let on_rim = |(rim, sample): (Rim, &ArcSample)| {
        let ray = camera.unproject(&sample.pixel)?;
        let (position, normal) = on_wall(cylinder, &ray, rim)?;
        let sine = normal.dot(&ray);
        let grazing = sine.abs() < LEAST_SINE * ray.norm();
        let lean = cylinder.axis.direction.dot(&ray) / sine;
        let shape = Vector4::new(1.0, normal.dot(&away), normal.dot(&sideways), lean);
        let ray =
            ArcRay { ray, rim, across: sample.across, weight: sample.deviation.powi(-2), widening: 0.0 };
        (!grazing).then_some(Sample { ray, position, shape })
    };
    let rims = [(Rim::Near, &end.samples), (Rim::Far, &end.far_rim)];
    rims.into_iter()
        .flat_map(|(rim, samples)| samples.iter().map(move |sample| (rim, sample)))
        .filter_map(on_rim)
        .collect()
}

/// A circle through the samples of an end, by the first N of what moves them.
struct Circle<const N: usize> {
    solution: SVector<f64, N>,
    /// Its covariance, where the deviations of the samples are what they say and all are independent.
    covariance: SMatrix<f64, N, N>,
    weights: List<f64>,
    /// How much more the samples scatter than their deviations explain.
    scale: f64,
    /// The part of them that is independent.
    independent: f64,
}

impl<const N: usize> Circle<N> {
    fn through(found: &[Sample]) -> Option<Self> {
        if found.len() < LEAST_SAMPLES {
            return None;
        }
        let driver = Reweighting { rounds: REWEIGHTINGS, scale: Scale::AtLeast(1.0) };
        let mut left = List::filled(0.0, found.len());
        let (mut solution, mut covariance) = (SVector::zeros(), SMatrix::zeros());
        let Reweighted { weights, scale } = driver.fit(found.len(), |weights, residuals| {
            let (mut square, mut right) = (SMatrix::<f64, N, N>::zeros(), SVector::<f64, N>::zeros());
            for (Sample { ray, position, shape }, weight) in found.iter().zip(weights) {
                let (w, shape) = (weight * ray.weight * ray.across * ray.across, shape.fixed_rows::<N>(0));
                square += shape * shape.transpose() * w;
                right += shape * (w * position);
            }
            covariance = square.try_inverse()?;
            solution = covariance * right;
            for (Sample { ray, position, shape }, residual) in found.iter().zip(residuals.iter_mut()) {
                let left = position - shape.fixed_rows::<N>(0).dot(&solution);
                *residual = left * ray.across * ray.weight.sqrt();
            }
            left.copy_from_slice(residuals);
            Some(Progress::Moved)
        })?;
        left.iter_mut().zip(&weights).for_each(|(residual, weight)| *residual *= weight.sqrt());
        Some(Self { solution, covariance, weights, scale, independent: independent_part(&left) })
    }
}
