//! The robust objective: points by Tukey's loss, endpoints by their pixel distance, each in units of its own
//! scale, so that neither can swamp the other.
//!
//! F = mean ρ(e_i) + (σ² / N_eff) Σ w_k (ε_k / τ)²: the negative log-likelihood times 2 σ² / N_eff, with the
//! scale σ of the point residuals, the number N_eff of independent points, and the standard deviation τ of an
//! endpoint in pixels. Like the energies of the paper it is a length squared.

use super::arcs::ArcTerm;
use super::pixels::PixelTerm;
use super::points::{Loss, PointRows, PointTerm};
use super::{NormalEquations, Objective, Sandwich, SandwichPart};
use crate::geometry::{LocalFrame, Tangent};
use crate::observations::PointCloud;

/// Tukey's biweight, ρ(e) = (c²/3) (1 − (1 − (e/c)²)³), which is e² for small e and constant beyond c: points
/// far off the surface (background, flying pixels) lose all influence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tukey {
    /// The residual c from which on a point has no influence.
    pub cutoff: f64,
    /// The wall that points can be on.
    pub wall: Wall,
}

/// On which wall of the cylinder a point can be. Depths that a sensor smears past the limbs lie on the wall that
/// it cannot see.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wall {
    /// On either: nothing is known of an observer.
    Either,
    /// On the wall that faces the observer outside the cylinder; points on the other have no influence.
    Facing,
}

/// c / σ at which the estimate keeps 95 % of the efficiency of least squares under Gaussian noise.
pub const TUKEY_EFFICIENT: f64 = 4.685;

impl Loss for Tukey {
    #[inline(always)]
    fn loss_and_weight(&self, residual: f64, facing: f64) -> (f64, f64) {
        let ratio = residual / self.cutoff;
        let hidden = self.wall == Wall::Facing && facing > 0.0;
        let rest = if hidden { 0.0 } else { (1.0 - ratio * ratio).max(0.0) };
        let weight = rest * rest;
        (self.cutoff * self.cutoff / 3.0 * (1.0 - weight * rest), weight)
    }

    fn influence_slope(&self, residual: f64, facing: f64) -> f64 {
        // ψ = e (1 − (e/c)²)².
        let square = (residual / self.cutoff).powi(2);
        let hidden = self.wall == Wall::Facing && facing > 0.0;
        if hidden || square >= 1.0 { 0.0 } else { (1.0 - square) * (1.0 - 5.0 * square) }
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weight_is_the_derivative_of_the_loss_over_twice_the_residual() {
        let tukey = Tukey { cutoff: 2.0, wall: Wall::Facing };
        let at = |e: f64| tukey.loss_and_weight(e, -1.0);
        for e in [-1.9, -0.5, 0.3, 1.0, 1.999, 2.5] {
            let h = 1e-6;
            let slope = (at(e + h).0 - at(e - h).0) / (2.0 * h);
            assert!((slope - 2.0 * e * at(e).1).abs() < 1e-8, "{e}");
            let influence = |e: f64| e * at(e).1;
            let of_influence = (influence(e + h) - influence(e - h)) / (2.0 * h);
            assert!((of_influence - tukey.influence_slope(e, -1.0)).abs() < 1e-8, "{e}");
        }
        assert_eq!(at(3.0), (4.0 / 3.0, 0.0));
        assert!((at(1e-4).0 - 1e-8).abs() < 1e-15);
        // A point on the hidden wall counts as one far away.
        assert_eq!(tukey.loss_and_weight(0.1, 1.0), at(3.0));
        assert_eq!(tukey.influence_slope(0.1, 1.0), 0.0);
    }
}
