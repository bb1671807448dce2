//! The robust objective: points by Tukey's loss, endpoints by their pixel distance, each in units of its own
//! scale, so that neither can swamp the other.
//!
//! F = mean ρ(e_i) + (σ² / N_eff) Σ w_k (ε_k / τ)²: the negative log-likelihood times 2 σ² / N_eff, with the
//! scale σ of the point residuals, the number N_eff of independent points, and the standard deviation τ of an
//! endpoint in pixels. Like the energies of the paper it is a length squared.

use super::arcs::ArcTerm;
use super::loss::{Loss, TUKEY_EFFICIENT, Tukey, Wall};
use super::pixels::PixelTerm;
use super::points::{PointRows, PointTerm};
use super::{NormalEquations, Objective, Sandwich, SandwichPart};
use crate::geometry::{LocalFrame, Tangent};
use crate::observations::PointCloud;

/// The scales that weigh the two terms against each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RobustScales {
    /// Standard deviation σ of the distances of good points, in the caller's unit.
    pub point: f64,
    /// The number N_eff of independent points.
    pub independent_points: f64,
    /// Standard deviation τ of an endpoint across its limb, in pixels.
    pub pixel: f64,
}

/// The robust objective at fixed scales.
#[derive(Debug, Clone, Copy)]
pub struct RobustObjective<'a> {
    points: PointTerm<'a>,
    pixels: Option<&'a PixelTerm>,
    arcs: &'a ArcTerm,
    scales: RobustScales,
    observed: bool,
}

impl<'a> RobustObjective<'a> {
    /// Points, and segments and arcs where there are any. `observed` says that the points are what an observer at the
    /// origin sees.
    #[must_use]
    pub fn new(
        points: PointTerm<'a>,
        pixels: Option<&'a PixelTerm>,
        arcs: &'a ArcTerm,
        scales: RobustScales,
        observed: bool,
    ) -> Self {
        Self { points, pixels, arcs, scales, observed }
    }

    /// The loss of the points in a frame. From inside a pipe every point of its surface is visible.
    fn loss(&self, frame: &LocalFrame) -> Tukey {
        let facing = self.observed && !frame.cylinder.contains_origin();
        let wall = if facing { Wall::Facing } else { Wall::Either };
        Tukey { cutoff: TUKEY_EFFICIENT * self.scales.point / frame.unit, wall }
    }

    /// What a squared pixel counts: σ² / (N_eff τ²), in the unit of the frame.
    fn pixel_factor(&self, frame: &LocalFrame) -> f64 {
        let RobustScales { point, independent_points, pixel } = self.scales;
        (point / (frame.unit * pixel)).powi(2) / independent_points
    }

    /// What the covariance of the minimum follows from; `None` where the cost is infinite. The scales must fit the
    /// residuals in the frame.
    #[must_use]
    pub fn sandwich(&self, frame: &LocalFrame) -> Option<Sandwich> {
        let RobustScales { point, independent_points, .. } = self.scales;
        let edges = self.edges(frame)?;
        // Every residual of the edges is weighed by its own variance, so that F is their negative log-likelihood times
        // 2 σ² / N_eff, and the covariance of its gradient is its second derivative times σ² / N_eff.
        let edges = SandwichPart {
            gradient: edges.gradient,
            derivative: edges.hessian,
            covariance: edges.hessian * ((point / frame.unit).powi(2) / independent_points),
        };
        Some(Sandwich { points: self.points.sandwich(frame, self.loss(frame), independent_points), edges })
    }

    /// What the pixels and the arcs add; `None` where their cost is infinite.
    fn edges(&self, frame: &LocalFrame) -> Option<NormalEquations> {
        let mut equations = NormalEquations::zero();
        if let Some(pixels) = self.pixels {
            equations.add_scaled(self.pixel_factor(frame), &pixels.linearise(frame)?);
        }
        equations.add_scaled(self.pixel_factor(frame), &self.arcs.linearise(frame));
        Some(equations)
    }
}

impl Objective for RobustObjective<'_> {
    fn linearise(&self, frame: &LocalFrame) -> Option<NormalEquations> {
        let radius = frame.cylinder.radius;
        if !(radius > 0.0 && radius.is_finite()) {
            return None;
        }
        let mut equations = self.edges(frame)?;
        equations.add_scaled(1.0, &self.points.linearise(frame, self.loss(frame)));
        equations.cost.is_finite().then_some(equations)
    }

    fn stacked_rows(&self, cloud: &PointCloud, frame: &LocalFrame) -> Option<Vec<(f64, Tangent)>> {
        let loss = self.loss(frame);
        let total: f64 = (0..cloud.len()).map(|index| cloud.weight(index)).sum();
        let mut rows = Vec::with_capacity(cloud.len());
        let of_points = PointRows::new(frame);
        for (index, point) in cloud.points().enumerate() {
            let (residual, jacobian, facing) = of_points.row(&point);
            let root = (cloud.weight(index) / total * loss.loss_and_weight(residual, facing).1).sqrt();
            rows.push((residual * root, jacobian * root));
        }
        if let Some(pixels) = self.pixels {
            let factor = self.pixel_factor(frame);
            for (segment, both) in pixels.segments().iter().zip(pixels.rows(frame)?) {
                let root = (factor * segment.weight).sqrt();
                rows.extend(both.iter().map(|(e, j)| (e * root, j * root)));
            }
        }
        for (weight, residual, jacobian) in self.arcs.rows(frame) {
            let root = (self.pixel_factor(frame) * weight).sqrt();
            rows.push((residual * root, jacobian * root));
        }
        Some(rows)
    }
}
