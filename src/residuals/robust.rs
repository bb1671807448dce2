//! The robust objective: points by Tukey's loss, endpoints by their pixel distance, each in units of its own
//! scale, so that neither can swamp the other.
//!
//! F = Σ_v α_v mean ρ(e_i) + ℓ² Σ w_k (ε_k / τ)² over the views v, with α_v = ℓ² N_v / σ_v² and
//! 1 / ℓ² = Σ_v N_v / σ_v²: the negative log-likelihood times 2 ℓ², with the scale σ_v of the point residuals of a view,
//! the number N_v of its independent points, and the standard deviation τ of an endpoint in pixels. For one view
//! α = 1 and ℓ² = σ² / N. Like the energies of the paper it is a length squared.

use super::arcs::ArcTerm;
use super::pixel_terms::{InPixels, PixelResiduals, PixelScale};
use super::pixels::PixelTerm;
use super::point_terms::{Points, Robust};
use super::points::{Loss, PointTerm};
use super::terms::{Sum, Summand, Term};
use crate::geometry::RigidMotion;

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

/// The scales that weigh the terms of one view against each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RobustScales {
    /// Standard deviation σ of the distances of good points, in the caller's unit.
    pub point: f64,
    /// The number N of independent points.
    pub independent_points: f64,
}

/// What the robust objective takes of one view.
#[derive(Debug, Clone, Copy)]
pub struct RobustView<'a> {
    /// From the reference frame to the view.
    pub into_view: RigidMotion,
    /// Its points.
    pub points: PointTerm<'a>,
    /// Whether an observer at the origin of the view sees them.
    pub observed: bool,
    /// Its scales.
    pub scales: RobustScales,
    /// The lines that the limbs are held to.
    pub lines: Option<&'a PixelTerm>,
    /// The arcs of the ends.
    pub arcs: &'a ArcTerm,
    /// Standard deviation τ of a line of weight 1 at its endpoints, and of a place of an arc of weight 1, in pixels.
    pub endpoint: f64,
}

/// The robust objective of some views at fixed scales. A new term takes a line here.
#[must_use]
pub fn robust_objective<'a>(views: &[RobustView<'a>]) -> Sum<'a> {
    let information = |view: &RobustView<'_>| match view.points.count() {
        0 => 0.0,
        _ => view.scales.independent_points / (view.scales.point * view.scales.point),
    };
    let total: f64 = views.iter().map(information).sum();
    let mut summands = Vec::new();
    for view in views {
        let RobustView { into_view, points, observed, scales, lines, arcs, endpoint } = *view;
        let scale = PixelScale { deviation: endpoint, length: total.sqrt().recip() };
        let mut add = |factor: f64, term: Box<dyn Term + 'a>| {
            summands.push(Summand { factor, into_view, term });
        };
        let in_pixels = |residuals: &'a dyn PixelResiduals| Box::new(InPixels { residuals, scale });
        if points.count() > 0 {
            let loss = Robust { scale: scales.point, observed };
            let RobustScales { independent_points, .. } = scales;
            add(information(view) / total, Box::new(Points { points, loss, independent_points }));
        }
        if let Some(lines) = lines {
            add(1.0, in_pixels(lines));
        }
        if !arcs.ends.is_empty() {
            add(1.0, in_pixels(arcs));
        }
    }
    Sum { summands }
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
