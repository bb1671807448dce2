//! Residuals in pixels as a term: squares in units of their own variance, as lengths.

use super::terms::{Row, Source, Term};
use super::{NormalEquations, SandwichPart};
use crate::geometry::{LocalFrame, Tangent};
use crate::memory::List;

/// A residual in pixels with its weight and its Jacobian in the tangent of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelRow {
    /// How much its square counts: 1 for the standard deviation of the [`PixelScale`].
    pub weight: f64,
    /// The residual in pixels.
    pub residual: f64,
    /// Its Jacobian.
    pub jacobian: Tangent,
}

/// Residuals that the image tells.
pub trait PixelResiduals {
    /// The residuals at the cylinder of a frame; `None` where their cost is infinite.
    fn pixel_rows(&self, frame: &LocalFrame) -> Option<List<PixelRow>>;
}

/// What a pixel counts beside a length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelScale {
    /// Standard deviation τ of a residual of weight 1, in pixels.
    pub deviation: f64,
    /// What one standard deviation counts, in the caller's unit of length.
    pub length: f64,
}

/// Residuals in pixels at a scale: Σ w (ε ℓ / τ)².
pub struct InPixels<'a> {
    /// The residuals.
    pub residuals: &'a dyn PixelResiduals,
    /// Their scale.
    pub scale: PixelScale,
}

impl InPixels<'_> {
    /// Residuals and Jacobians in units of the frame.
    fn scaled(&self, frame: &LocalFrame) -> Option<List<PixelRow>> {
        let factor = self.scale.length / (self.scale.deviation * frame.unit);
        let mut rows = self.residuals.pixel_rows(frame)?;
        for row in &mut rows {
            row.residual *= factor;
            row.jacobian *= factor;
        }
        Some(rows)
    }
}

impl Term for InPixels<'_> {
    fn source(&self) -> Source {
        Source::Image
    }

    fn cost(&self, frame: &LocalFrame) -> Option<f64> {
        Some(self.scaled(frame)?.iter().map(|row| row.weight * row.residual * row.residual).sum())
    }

    fn linearise(&self, frame: &LocalFrame) -> Option<NormalEquations> {
        let mut equations = NormalEquations::zero();
        for PixelRow { weight, residual, jacobian } in &self.scaled(frame)? {
            equations.add_residual(*weight, *residual, jacobian);
        }
        Some(equations)
    }

    fn rows(&self, frame: &LocalFrame) -> Option<Vec<Row>> {
        let root = |row: &PixelRow| (row.residual * row.weight.sqrt(), row.jacobian * row.weight.sqrt());
        Some(self.scaled(frame)?.iter().map(root).collect())
    }

    /// Every residual is weighed by its own variance, so that the cost is a negative log-likelihood times 2 ℓ², and the
    /// covariance of its gradient is its second derivative times ℓ².
    fn sandwich(&self, frame: &LocalFrame) -> Option<SandwichPart> {
        let NormalEquations { gradient, hessian, .. } = self.linearise(frame)?;
        let covariance = hessian * (self.scale.length / frame.unit).powi(2);
        Some(SandwichPart { gradient, derivative: hessian, covariance })
    }
}
