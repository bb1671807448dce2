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
use super::point_terms::{LossInFrame, Points, Robust};
use super::points::PointTerm;
use super::shared::{Known, SharedErrors, SharingPoints};
use super::terms::{AnyTerm, Sum, Summand};
use crate::geometry::{LocalFrame, RigidMotion};
use smallvec::SmallVec;

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
    /// The errors that they share, as the observer sees them; `None` where nothing is known of an observer.
    pub shared: Option<SharedErrors>,
    /// What is known of them.
    pub known: Known<'a>,
    /// The frame at a cylinder near those at which the objective is asked for, in the coordinates of the view.
    pub near: LocalFrame,
    /// Its scales.
    pub scales: RobustScales,
    /// The lines that the limbs are held to.
    pub lines: Option<&'a PixelTerm>,
    /// The arcs of the ends.
    pub arcs: &'a ArcTerm,
    /// Standard deviation τ of a line of weight 1 at its endpoints, and of a sample of an arc of weight 1, in pixels.
    pub endpoint: f64,
}

/// The robust objective of some views at fixed scales; `contested` says whether lines tell of the radius, against which
/// the errors that points share count. A new term takes a line here.
#[must_use]
pub fn robust_objective<'a>(views: &[RobustView<'a>], contested: bool) -> Sum<'a> {
    let information = |view: &RobustView<'_>| match view.points.count() {
        0 => 0.0,
        _ => view.scales.independent_points / (view.scales.point * view.scales.point),
    };
    let total: f64 = views.iter().map(information).sum();
    let mut sum = Sum { summands: SmallVec::new() };
    for view in views {
        let RobustView { into_view, points, observed, shared, known, near, scales, lines, arcs, endpoint } =
            *view;
        let scale = PixelScale { deviation: endpoint, length: total.sqrt().recip() };
        let mut add = |factor: f64, term: AnyTerm<'a>| {
            sum.summands.push(Summand { factor, into_view, term });
        };
        let in_pixels = |residuals: &'a dyn PixelResiduals| AnyTerm::Pixels(InPixels { residuals, scale });
        if points.count() > 0 {
            let loss = Robust { scale: scales.point, observed };
            let points = points.with_curvature(&near, loss.at(&near));
            let RobustScales { independent_points, .. } = scales;
            let points = Points::new(points, loss, independent_points);
            let variance = information(view).recip();
            let sharing = shared.and_then(|shared| {
                SharingPoints::new(points.clone(), shared, variance, contested, known, &near)
            });
            let term = match sharing {
                Some(sharing) => AnyTerm::Sharing(sharing),
                None => AnyTerm::Robust(points),
            };
            add(information(view) / total, term);
        }
        if let Some(lines) = lines {
            add(1.0, in_pixels(lines));
        }
        if !arcs.ends.is_empty() {
            add(1.0, in_pixels(arcs));
        }
    }
    sum
}
