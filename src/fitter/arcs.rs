//! The arcs of the ends, located in the image for the tilt of the axis.

use super::Fitter;
use super::problem::Problem;
use super::rough::CONTRADICTION;
use super::solve::Report;
use crate::camera::Camera;
use crate::end_location::{ArcSample, EndSearch, depth_tolerance, locate_ends};
use crate::error::Result;
use crate::geometry::Cylinder;
use crate::residuals::{ArcRay, ArcTerm, Loss, TUKEY_EFFICIENT, Tukey, Wall, near_wall};
use crate::solver::Convergence;
use crate::statistics::{DEVIATION_OF_MEDIAN, median};
use nalgebra::{Matrix3, Vector3};

/// Fewest places that tell how an arc is bent.
const LEAST_PLACES: usize = 8;

/// A ray that meets the surface at a sine below this grazes it: its position along the axis hangs on the limb.
const LEAST_SINE: f64 = 0.25;

/// Rounds of reweighting.
const REWEIGHTINGS: usize = 5;

/// Most rounds of arcs and minimum: the first tilt may be off by degrees, and the arcs are looked for where it says. Most
/// frames settle in two, short cans in three.
const ARC_ROUNDS: usize = 5;

/// An axis that turned by less than this, in radians, leaves the arcs where they were found: at a radius of 25
/// pixels it moves them by a tenth of a pixel.
const SETTLED_TURN: f64 = 0.004;

impl Fitter {
    /// Locates the arcs of the ends from a minimum and iterates on with them, until the axis settles. Arcs that
    /// contradict the points are something else and are dropped.
    pub(super) fn fit_to_arcs(
        &self,
        problem: &mut Problem<'_>,
        mut convergence: Convergence,
        blur: Option<f64>,
        report: Report<'_>,
    ) -> Result<Convergence> {
        let scale = problem.point_scale(&convergence.cylinder);
        for _ in 0..ARC_ROUNDS {
            let before = convergence.cylinder;
            problem.arcs = self.locate_arcs(problem, &before, blur);
            if problem.arcs.ends.is_empty() {
                break;
            }
            let after = problem.minimise_again(&convergence, report)?;
            if problem.point_scale(&after.cylinder) > CONTRADICTION * scale {
                problem.arcs = ArcTerm::default();
                break;
            }
            convergence = after;
            if before.axis.angle(&convergence.cylinder.axis) < SETTLED_TURN {
                break;
            }
        }
        Ok(convergence)
    }

    /// The arcs of the ends that the image shows, each place weighed by how well it agrees with its neighbours.
    fn locate_arcs(&self, problem: &Problem<'_>, cylinder: &Cylinder, blur: Option<f64>) -> ArcTerm {
        let (Some(image), Some(mask), Some(camera)) = (&self.image, &self.mask, &self.camera) else {
            return ArcTerm::default();
        };
        if cylinder.contains_origin() {
            return ArcTerm::default();
        }
        let search = EndSearch {
            camera,
            mask,
            depth: self.depth.as_ref(),
            image: Some(image),
            tolerance: depth_tolerance(&self.cloud, cylinder),
            limbs_known: problem.has_limbs(),
            noise: problem.noise,
            blur,
        };
        let Some(ends) = locate_ends(&search, cylinder) else { return ArcTerm::default() };
        ArcTerm {
            ends: ends
                .iter()
                .filter_map(|end| places(camera, cylinder, &end.samples, problem.noise.endpoint))
                .collect(),
        }
    }
}

/// The places of one end with their weights; `None` where they do not tell how the arc is bent.
fn places(camera: &Camera, cylinder: &Cylinder, samples: &[ArcSample], endpoint: f64) -> Option<Vec<ArcRay>> {
    let away = cylinder.axis.nearest_to_origin().normalize();
    let sideways = cylinder.axis.direction.cross(&away);
    let mut found: Vec<(ArcRay, f64, Vector3<f64>)> = samples
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
    let variances: Vec<f64> = found.iter().map(|(place, ..)| 1.0 / place.weight).collect();
    // How much more the places scatter than their deviations explain.
    let mut scatter: f64 = 1.0;
    for _ in 0..REWEIGHTINGS {
        let (mut square, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for (place, position, shape) in &found {
            let w = place.weight * place.across * place.across;
            square += shape * shape.transpose() * w;
            right += shape * (w * position);
        }
        let solution = square.try_inverse()? * right;
        let residuals: Vec<f64> = found
            .iter()
            .zip(&variances)
            .map(|((place, position, shape), variance)| {
                (position - shape.dot(&solution)) * place.across / variance.sqrt()
            })
            .collect();
        let mut sizes: Vec<f64> = residuals.iter().map(|residual| residual.abs()).collect();
        scatter = (DEVIATION_OF_MEDIAN * median(&mut sizes)).max(1.0);
        let loss = Tukey { cutoff: TUKEY_EFFICIENT * scatter, wall: Wall::Either };
        for ((place, residual), variance) in found.iter_mut().zip(residuals).zip(&variances) {
            place.0.weight = loss.loss_and_weight(residual, 0.0).1 / variance;
        }
    }
    let factor = (endpoint / scatter).powi(2);
    Some(found.into_iter().map(|(place, ..)| ArcRay { weight: place.weight * factor, ..place }).collect())
}
