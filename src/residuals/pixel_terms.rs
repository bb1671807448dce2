//! Residuals in pixels as a term: squares in units of their own variance, as lengths.

use super::terms::{Row, Source, Term};
use super::{NormalEquations, SandwichPart};
use crate::geometry::{LocalFrame, Tangent};
use crate::memory::List;
use crate::noise::{MASK_COMMON, MASK_COMMON_STATED};

/// A residual in pixels with its weight and its Jacobian in the tangent of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelRow {
    /// How much its square counts: 1 for the standard deviation of the [`PixelScale`].
    pub weight: f64,
    /// The residual in pixels.
    pub residual: f64,
    /// Its Jacobian.
    pub jacobian: Tangent,
    /// By how much one standard deviation of the error that all rows share moves it, in pixels.
    pub shared: f64,
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
        if rows.iter().any(|row| row.shared != 0.0) {
            whiten(&mut rows, self.scale.deviation);
        }
        for row in &mut rows {
            row.residual *= factor;
            row.jacobian *= factor;
        }
        Some(rows)
    }
}

/// Makes rows independent that share an error, with weights of 1. With u, what one standard deviation of that error makes of
/// the weighed residuals, their covariance is I + u uᵀ, whose inverse has the root I − (1 − 1 / √(1 + uᵀu)) u uᵀ / uᵀu.
fn whiten(rows: &mut [PixelRow], deviation: f64) {
    for row in rows.iter_mut() {
        let root = row.weight.sqrt();
        row.residual *= root;
        row.jacobian *= root;
        row.shared *= root / deviation;
        row.weight = 1.0;
    }
    let square: f64 = rows.iter().map(|row| row.shared * row.shared).sum();
    if !(square > 0.0) {
        return;
    }
    let part = (1.0 - 1.0 / (1.0 + square).sqrt()) / square;
    let residual: f64 = rows.iter().map(|row| row.shared * row.residual).sum();
    let jacobian: Tangent = rows.iter().map(|row| row.jacobian * row.shared).sum();
    for row in rows {
        row.residual -= part * residual * row.shared;
        row.jacobian -= jacobian * (part * row.shared);
        row.shared /= (1.0 + square).sqrt();
    }
}

fn equations(rows: &[PixelRow]) -> NormalEquations {
    let mut equations = NormalEquations::zero();
    for PixelRow { weight, residual, jacobian, .. } in rows {
        equations.add_residual(*weight, *residual, jacobian);
    }
    equations
}

impl Term for InPixels<'_> {
    fn source(&self) -> Source {
        Source::Image
    }

    fn cost(&self, frame: &LocalFrame) -> Option<f64> {
        Some(self.scaled(frame)?.iter().map(|row| row.weight * row.residual * row.residual).sum())
    }

    fn linearise(&self, frame: &LocalFrame) -> Option<NormalEquations> {
        Some(equations(&self.scaled(frame)?))
    }

    fn rows(&self, frame: &LocalFrame) -> Option<Vec<Row>> {
        let root = |row: &PixelRow| (row.residual * row.weight.sqrt(), row.jacobian * row.weight.sqrt());
        Some(self.scaled(frame)?.iter().map(root).collect())
    }

    /// Every residual is weighed by its own variance, so that the cost is a negative log-likelihood times 2 ℓ², and the
    /// covariance of its gradient is its second derivative times ℓ². An error that rows share is stated as larger than it weighs.
    fn sandwich(&self, frame: &LocalFrame) -> Option<SandwichPart> {
        let rows = self.scaled(frame)?;
        let NormalEquations { gradient, hessian, .. } = equations(&rows);
        let shared: Tangent = rows.iter().map(|row| row.jacobian * row.shared).sum();
        let stated = MASK_COMMON_STATED.get() / MASK_COMMON.get();
        let beyond = shared * shared.transpose() * (stated * stated - 1.0);
        let covariance = (hessian + beyond) * (self.scale.length / frame.unit).powi(2);
        Some(SandwichPart { gradient, derivative: hessian, covariance })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};

    #[test]
    fn rows_that_share_an_error_cost_what_their_covariance_says() {
        let row = |k: usize| PixelRow {
            weight: 0.3 + 0.2 * k as f64,
            residual: 1.7 - 0.9 * k as f64,
            jacobian: Tangent::from_fn(|i, _| ((3 * k + 2 * i) as f64).sin()),
            shared: [0.4, -0.4, 0.0, 0.9][k % 4],
        };
        let before: Vec<PixelRow> = (0..6).map(row).collect();
        let deviation = 0.5;
        // What one standard deviation of a row is in pixels is deviation / √w.
        let covariance = DMatrix::from_fn(6, 6, |i, j| {
            let own = if i == j { deviation * deviation / before[i].weight } else { 0.0 };
            own + before[i].shared * before[j].shared
        });
        let inverse = covariance.try_inverse().unwrap() * (deviation * deviation);
        let residuals = DVector::from_iterator(6, before.iter().map(|row| row.residual));
        let jacobian = DMatrix::from_fn(6, 5, |i, j| before[i].jacobian[j]);
        let mut after = before;
        whiten(&mut after, deviation);
        let cost: f64 = after.iter().map(|row| row.residual * row.residual).sum();
        let gradient: Tangent = after.iter().map(|row| row.jacobian * row.residual).sum();
        assert!((cost - residuals.dot(&(&inverse * &residuals))).abs() < 1e-12 * cost);
        let expected = jacobian.transpose() * &inverse * residuals;
        assert!(after.iter().all(|row| row.weight == 1.0) && (gradient - expected).norm() < 1e-12 * cost);
        // What the shared error does to the gradient: Jᵀ V⁻¹ s.
        let of_shared: Tangent = after.iter().map(|row| row.jacobian * row.shared).sum();
        let shared = DVector::from_iterator(6, (0..6).map(|k| row(k).shared));
        let expected = jacobian.transpose() * inverse * shared / deviation;
        assert!((of_shared - expected).norm() < 1e-12 * of_shared.norm());
    }
}
