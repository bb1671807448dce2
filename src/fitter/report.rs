//! What is said about a cylinder: costs, doubts, residuals, and what the data determine.

use super::Fitter;
use super::options::StartKind;
use super::problem::{self, Problem};
use super::result::{FitResult, Flags, Seconds};
use super::starts::Candidate;
use crate::error::{Error, Result};
use crate::geometry::{Cylinder, LocalFrame};
use crate::solver::{Convergence, LeastSquares, Rank, Termination};
use nalgebra::Vector3;

/// A radius is called weak when its standard deviation would be more than this part of it, even if the noise
/// of all points were independent.
const WEAK_RADIUS: f64 = 0.05;

/// The input resolution, as a part of the radius, from which on digits are missing.
const COARSE: f64 = 1e-4;

/// Which residuals to list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResidualKind {
    /// Signed distance of every used point from the surface, in the unit of length.
    Points,
    /// Signed distance of every endpoint of the used segments from its limb line, in pixels.
    Edges,
}

/// What the data determine at a cylinder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Diagnosis {
    /// Rank, condition and singular values of the Jacobian, in units of the size of the data.
    pub rank: Rank,
    /// The step along which the residuals change least: how it moves the axis at the middle of the points, in
    /// the unit of length,
    pub weakest_shift: Vector3<f64>,
    /// how it tilts the axis, in radians towards this vector,
    pub weakest_tilt: Vector3<f64>,
    /// and how it changes the radius, in the unit of length.
    pub weakest_radius: f64,
}

impl Fitter {
    /// What a fit would report for a given model, without iterating.
    ///
    /// # Errors
    /// `TooFewPoints` and the like as in [`Fitter::fit`]; `EdgeGeometry` where the cost is infinite.
    pub fn evaluate(&self, cylinder: &Cylinder) -> Result<FitResult> {
        let problem = self.problem()?;
        self.describe(&problem, &Candidate { kind: StartKind::Model, cylinder: *cylinder }, cylinder)
    }

    /// Residuals of a model, or of the last fit.
    ///
    /// # Errors
    /// `BadState` without a model and a result; `EdgeGeometry` for edges when there are no limbs.
    pub fn residuals(&self, cylinder: Option<&Cylinder>, kind: ResidualKind) -> Result<Vec<f64>> {
        let cylinder = self.model_or_result("listing residuals", cylinder)?;
        match kind {
            ResidualKind::Points => Ok(self.cloud.points().map(|p| cylinder.distance(&p)).collect()),
            ResidualKind::Edges => {
                let problem = self.problem_of_data()?;
                let Some(pixels) = &problem.pixels else { return Ok(Vec::new()) };
                let distances = pixels.distances(&cylinder).ok_or_else(|| Error::EdgeGeometry {
                    reason: "the camera is inside the cylinder, which has no limbs then".into(),
                    remedy: "ask for the residuals of the points",
                })?;
                Ok(distances.into_iter().flatten().collect())
            }
        }
    }

    /// Rank, condition and the weakest direction of the stacked Jacobian at a model, or at the last fit, by
    /// orthogonal factorisation.
    ///
    /// # Errors
    /// `BadState` without a model and a result, `EdgeGeometry` where the cost is infinite, `Numerical`.
    pub fn diagnose(&self, cylinder: Option<&Cylinder>) -> Result<Diagnosis> {
        let cylinder = self.model_or_result("diagnosing", cylinder)?;
        let problem = self.problem()?;
        let rows = problem.stacked_rows(&cylinder).ok_or_else(infinite_cost)?;
        let rank = LeastSquares::new(&rows)?.rank()?;
        let LocalFrame { u, v, unit, .. } = LocalFrame::new(&cylinder, &problem.center, problem.unit);
        let weakest = rank.weakest;
        Ok(Diagnosis {
            rank,
            weakest_shift: (u * weakest[0] + v * weakest[1]) * unit,
            weakest_tilt: u * weakest[2] + v * weakest[3],
            weakest_radius: weakest[4] * unit,
        })
    }

    /// The given model, or that of the last fit.
    pub(crate) fn model_or_result(
        &self,
        call: &'static str,
        cylinder: Option<&Cylinder>,
    ) -> Result<Cylinder> {
        let missing = Error::BadState { call, missing: "a model", remedy: "give one or fit first" };
        cylinder.copied().or(self.result.map(|result| result.cylinder)).ok_or(missing)
    }

    /// What the last fit minimised at its end.
    pub(super) fn problem(&self) -> Result<Problem<'_>> {
        let mut problem = self.problem_of_data()?;
        if let Some(lines) = &self.lines {
            problem.hold_to(&lines.segments);
            problem.limbs_located = lines.located;
        }
        problem.arcs.clone_from(&self.arcs);
        Ok(problem)
    }

    pub(super) fn problem_of_data(&self) -> Result<Problem<'_>> {
        let Self { options, cloud, camera, segments, start, workers, .. } = self;
        Problem::new(options, cloud, camera.as_ref(), segments, start.as_ref(), workers)
    }

    /// Everything about a cylinder but how it was reached.
    pub(super) fn describe(
        &self,
        problem: &Problem<'_>,
        start: &Candidate,
        cylinder: &Cylinder,
    ) -> Result<FitResult> {
        let equations = problem.linearise(cylinder).ok_or_else(infinite_cost)?;
        let squared = problem.unit * problem.unit;
        let frame = LocalFrame::new(cylinder, &problem.center, problem.unit);
        let energy_points = if self.cloud.is_empty() { 0.0 } else { problem.points.energy(&frame) };
        let eigenvalues = equations.hessian.symmetric_eigenvalues();
        let weak = {
            // As if the weights were the inverse variances and the noise independent.
            let freedom = self.cloud.len().saturating_sub(problem::LEAST_POINTS).max(1) as f64;
            let variance = equations.hessian.try_inverse().map_or(f64::INFINITY, |inverse| inverse[(4, 4)]);
            let deviation = problem.unit * (equations.cost * variance / freedom).sqrt();
            !problem.has_fixed_radius() && !(deviation <= WEAK_RADIUS * cylinder.radius)
        };
        let scale_held = problem.edge_weight == 1.0 && !problem.has_fixed_radius();
        let limits = &self.options.cylinder_limits;
        let inside = cylinder.contains_origin() && problem.near_wall;
        let walls = problem.near_wall.then(|| cylinder.visible_wall(self.cloud.points()));
        let mut flags = problem.edges.flags;
        flags.set(Flags::SCALE_HELD, scale_held);
        flags.set(Flags::WEAK_RADIUS, weak || scale_held);
        flags.set(Flags::RESOLUTION_LOST, self.cloud.resolution() > COARSE * cylinder.radius);
        flags.set(Flags::HIDDEN_WALL, walls.is_some_and(|walls| walls.fraction() < 0.5));
        flags.set(Flags::CAMERA_INSIDE, inside);
        flags.set(Flags::RADIUS_AT_LIMIT, limits.hold_radius(cylinder));
        flags.set(Flags::AXIS_AT_LIMIT, limits.hold_axis(cylinder));
        flags.set(Flags::POINTS_NOT_FINITE, self.cloud.dropped().not_finite > 0);
        let given = problem.edges.pixel_term(self.camera.as_ref());
        let edge_rms_pixels = given.and_then(|given| given.distances(cylinder)).map(|distances| {
            let sum: f64 = distances.iter().flatten().map(|d| d * d).sum();
            (sum / (2 * distances.len()) as f64).sqrt()
        });
        let (uncertainty, radii) = problem.uncertainty(cylinder);
        if radii.is_some_and(|radii| radii.disagree()) {
            flags |= Flags::POINTS_AND_LIMBS_DISAGREE;
        }
        Ok(FitResult {
            cylinder: problem.canonical(cylinder),
            uncertainty,
            radii,
            start: start.cylinder,
            start_kind: start.kind,
            termination: None,
            iterations: 0,
            rejected_steps: 0,
            initial_cost: equations.cost * squared,
            cost: equations.cost * squared,
            energy_points,
            energy_edges: problem.limbs.and_then(|limbs| limbs.energy(cylinder)),
            edge_weight: problem.has_edge_weight().then_some(problem.edge_weight),
            points_used: self.cloud.len(),
            points_given: self.cloud.given(),
            dropped: *self.cloud.dropped(),
            segments_used: problem.segments_used(),
            segments_given: self.segments.len(),
            limbs_located: self.lines.as_ref().map_or(0, |lines| lines.located),
            point_rms: energy_points.sqrt(),
            edge_rms_pixels,
            near_wall_fraction: walls.map(|walls| walls.fraction()),
            condition: (eigenvalues.max() / eigenvalues.min().max(0.0)).sqrt(),
            lambda: 0.0,
            gradient_norm: limits.free_gradient(&frame, &equations.gradient).norm(),
            step_norm: 0.0,
            flags,
            seconds: Seconds::default(),
        })
    }
}

fn infinite_cost() -> Error {
    Error::EdgeGeometry {
        reason: "the cost of the model is infinite: the camera is inside it, or an endpoint lies behind it"
            .into(),
        remedy: "give another model or clear the segments",
    }
}

impl FitResult {
    pub(super) fn add_convergence(&mut self, convergence: &Convergence) {
        self.termination = Some(convergence.termination);
        self.iterations = convergence.iterations;
        self.rejected_steps = convergence.rejected_steps;
        self.initial_cost = convergence.initial_cost;
        self.lambda = convergence.lambda;
        self.step_norm = convergence.step_norm;
        self.flags.set(Flags::NOT_CONVERGED, convergence.termination == Termination::MaxIterations);
    }
}
