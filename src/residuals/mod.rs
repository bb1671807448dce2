//! Residuals, their analytic Jacobians and their weighted sums.
//!
//! Every residual is divided by the unit of the [`LocalFrame`] it is linearised
//! in, and every Jacobian is taken in the tangent of that frame; a term hands over its part of the normal
//! equations and a solver adds the parts up. An objective is a choice of terms and weights.

mod arcs;
mod kernel;
mod limbs;
mod loss;
mod paper;
mod pixel_terms;
mod pixels;
mod point_terms;
mod points;
mod robust;
mod sandwich;
mod shared;
mod terms;

pub use arcs::{ArcRay, ArcTerm, Rim, on_wall};
pub use limbs::{LimbPair, LimbTerm};
pub use loss::{
    Loss, Progress, Reweighted, Reweighting, Scale, Squared, TUKEY_EFFICIENT, Truncated, Tukey, Wall,
};
pub use paper::paper_objective;
pub use pixel_terms::PixelResiduals;
pub use pixels::{PixelSegment, PixelTerm};
pub use point_terms::{LossInFrame, Robust};
pub(crate) use points::PointRows;
pub use points::PointTerm;
pub use robust::{RobustScales, RobustView, robust_objective};
pub(crate) use sandwich::root;
pub use sandwich::{Sandwich, SandwichPart};
pub use shared::{Bend, Known, SharedErrors};
pub use terms::{Sum, Term};

use crate::geometry::{LocalFrame, Tangent, TangentMap};

/// What a solver minimises.
pub trait Objective {
    /// The cost and its linearisation at the cylinder of a frame; `None` where the cost is infinite.
    fn linearise(&self, frame: &LocalFrame) -> Option<NormalEquations>;

    /// The cost alone: what a trial step needs.
    fn cost(&self, frame: &LocalFrame) -> Option<f64> {
        self.linearise(frame).map(|equations| equations.cost)
    }
}

/// The sums of one linearisation: with residuals e, weights Ω and Jacobian J,
/// `cost` = eᵀΩe, `gradient` = JᵀΩe and `hessian` = JᵀΩJ (so that the gradient of the cost is twice
/// `gradient`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NormalEquations {
    /// eᵀΩe.
    pub cost: f64,
    /// JᵀΩe.
    pub gradient: Tangent,
    /// JᵀΩJ.
    pub hessian: TangentMap,
    /// Half the second derivative of the cost without the bend of the residuals: JᵀΩJ where residuals count by their
    /// squares. Of points with another loss it is JᵀΩJ times the mean slope of their influence over their mean weight, which
    /// is what a step to the minimum takes: with JᵀΩJ itself, too large, steps fall short of it.
    pub curvature: TangentMap,
}

impl NormalEquations {
    /// No residuals.
    #[must_use]
    pub fn zero() -> Self {
        Self {
            cost: 0.0,
            gradient: Tangent::zeros(),
            hessian: TangentMap::zeros(),
            curvature: TangentMap::zeros(),
        }
    }

    /// Adds one residual.
    pub fn add_residual(&mut self, weight: f64, residual: f64, jacobian: &Tangent) {
        self.cost += weight * residual * residual;
        self.gradient += jacobian * (weight * residual);
        let square = jacobian * jacobian.transpose() * weight;
        self.hessian += square;
        self.curvature += square;
    }

    /// Adds the sums of a term times a factor.
    pub fn add_scaled(&mut self, factor: f64, other: &NormalEquations) {
        self.cost += factor * other.cost;
        self.gradient += other.gradient * factor;
        self.hessian += other.hessian * factor;
        self.curvature += other.curvature * factor;
    }
}
