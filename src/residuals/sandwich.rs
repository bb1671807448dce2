//! How uncertain the minimum of an objective is.
//!
//! To first order the minimum moves by −A⁻¹ g, with half the gradient g of the objective at the true cylinder and its
//! expected derivative A. With the covariance B of g the covariance of the minimum is A⁻¹ B A⁻¹: the sandwich formula
//! of M-estimators (Huber, Robust Statistics, 1981, section 6.3). It holds whatever the weights are, good or bad:
//! they only have to be the ones that were used.

use crate::geometry::{Tangent, TangentMap};

/// What one kind of residuals adds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SandwichPart {
    /// Half the gradient of its part of the objective, g.
    pub gradient: Tangent,
    /// The expected derivative of that, A.
    pub derivative: TangentMap,
    /// Its covariance, B.
    pub covariance: TangentMap,
}

/// Gradient, its expected derivative and its covariance, in the tangent of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sandwich {
    /// What the points add.
    pub points: SandwichPart,
    /// What the image adds: given segments, located limb lines and arcs of the ends. Zero where none count.
    pub image: SandwichPart,
}

impl SandwichPart {
    /// No residuals.
    #[must_use]
    pub fn zero() -> Self {
        Self { gradient: Tangent::zeros(), derivative: TangentMap::zeros(), covariance: TangentMap::zeros() }
    }

    /// Adds a part that the objective takes `factor` times.
    pub(super) fn add_scaled(&mut self, factor: f64, part: &Self) {
        self.gradient += part.gradient * factor;
        self.derivative += part.derivative * factor;
        self.covariance += part.covariance * (factor * factor);
    }
}

impl Sandwich {
    /// A of everything.
    #[must_use]
    pub fn derivative(&self) -> TangentMap {
        self.points.derivative + self.image.derivative
    }

    /// The covariance of the minimum, A⁻¹ B A⁻¹, over the degrees of freedom that are not `known`; these have none.
    /// `None` where the data do not determine the others.
    #[must_use]
    pub fn covariance(&self, known: &[bool; 5]) -> Option<TangentMap> {
        let (mut derivative, mut of_gradient) =
            (self.derivative(), self.points.covariance + self.image.covariance);
        for k in (0..5).filter(|&k| known[k]) {
            for matrix in [&mut derivative, &mut of_gradient] {
                matrix.fill_row(k, 0.0);
                matrix.fill_column(k, 0.0);
            }
            derivative[(k, k)] = 1.0;
        }
        let inverse = derivative.cholesky()?.inverse();
        let covariance = inverse * of_gradient * inverse;
        let covariance = (covariance + covariance.transpose()) * 0.5;
        covariance.iter().all(|x| x.is_finite()).then_some(covariance)
    }
}
