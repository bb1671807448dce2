//! The Brown–Conrady model with rational radial terms on the plane z = 1.
//!
//! With v = (p2, p1), s = v · x, u = x · x and f(u) the quotient of the radial polynomials:
//!
//! F(x) = f x + 2 s x + u v,  J = ∂F/∂x = (f + 2 s) I + 2 f′ x xᵀ + 2 (x vᵀ + v xᵀ).
//!
//! J is symmetric: F is the gradient of a potential. Where J is positive definite the potential is convex, and
//! the gradient of a convex function on a convex region takes no value twice. The valid field is therefore a
//! circle in which J is positive definite: there F is one to one, not only locally.

use super::radial::{MIN_STRETCH, end_of_field, solve_increasing};
use nalgebra::{Matrix2, Vector2};

/// Limit on the steps of the two-dimensional Newton method; 2 to 4 are usual.
const MAX_STEPS: usize = 50;

/// The smallest fraction of a step of Newton's method that is tried.
const MIN_FRACTION: f64 = 1e-3;

/// Brown–Conrady coefficients and the valid field.
///
/// Invariant: up to `max_radius` the denominator is positive and no eigenvalue of J is below [`MIN_STRETCH`].
#[derive(Clone, Debug)]
pub(super) struct BrownConrady {
    /// k1, k2, k3.
    numerator: [f64; 3],
    /// k4, k5, k6.
    denominator: [f64; 3],
    /// (p2, p1).
    tangential: Vector2<f64>,
    /// The radius of the valid field on the plane z = 1.
    max_radius: f64,
}

impl BrownConrady {
    /// The model with k1 k2 p1 p2 k3 k4 k5 k6.
    pub(super) fn new(coefficients: &[f64; 8]) -> Self {
        let [k1, k2, p1, p2, k3, k4, k5, k6] = *coefficients;
        let mut lens = Self {
            numerator: [k1, k2, k3],
            denominator: [k4, k5, k6],
            tangential: Vector2::new(p2, p1),
            max_radius: 0.0,
        };
        lens.max_radius = end_of_field(|angle| lens.is_regular(angle.tan())).tan();
        lens
    }

    /// f(u) and f′(u), or `None` when the denominator is not positive.
    fn radial(&self, u: f64) -> Option<(f64, f64)> {
        let (numerator, numerator_slope) = polynomial(&self.numerator, u);
        let (denominator, denominator_slope) = polynomial(&self.denominator, u);
        let value = numerator / denominator;
        let slope = (numerator_slope - value * denominator_slope) / denominator;
        (denominator > 0.0).then_some((value, slope))
    }

    /// Whether no eigenvalue of J is below [`MIN_STRETCH`] anywhere at this distance from the axis.
    ///
    /// At the angle ψ from v, in the basis along and across the radius, and with a = r ‖v‖,
    /// J = [[f + 2 u f′ + 6 a cos ψ, 2 a sin ψ], [2 a sin ψ, f + 2 a cos ψ]], and so the determinant is
    /// quadratic in cos ψ with its minimum in closed form.
    fn is_regular(&self, radius: f64) -> bool {
        let u = radius * radius;
        let Some((f, slope)) = self.radial(u) else { return false };
        let along = f + 2.0 * u * slope - MIN_STRETCH;
        let across = f - MIN_STRETCH;
        let a = radius * self.tangential.norm();
        let linear = along + 3.0 * across;
        let cosine = if a > 0.0 { (-linear / (16.0 * a)).clamp(-1.0, 1.0) } else { 0.0 };
        let determinant =
            along * across - 4.0 * a * a + 2.0 * a * linear * cosine + 16.0 * a * a * cosine * cosine;
        // Both signs: a positive determinant everywhere and one positive definite J make all of them so.
        along > 0.0 && across > 0.0 && determinant > 0.0
    }

    /// F(x) and J, or `None` when the denominator is not positive.
    fn evaluate(&self, x: &Vector2<f64>) -> Option<(Vector2<f64>, Matrix2<f64>)> {
        let u = x.norm_squared();
        let (f, slope) = self.radial(u)?;
        let v = self.tangential;
        let factor = f + 2.0 * v.dot(x);
        let mixed = x * v.transpose() * 2.0;
        let jacobian =
            Matrix2::identity() * factor + x * x.transpose() * (2.0 * slope) + mixed + mixed.transpose();
        Some((x * factor + v * u, jacobian))
    }

    /// F(x), or `None` outside the valid field.
    pub(super) fn distort(&self, x: &Vector2<f64>) -> Option<Vector2<f64>> {
        // The comparison is false for what is not a number.
        if x.norm() <= self.max_radius { self.evaluate(x).map(|(distorted, _)| distorted) } else { None }
    }

    /// The x of the valid field with F(x) = `distorted`, or some point of the field when there is none.
    pub(super) fn undistort(&self, distorted: &Vector2<f64>) -> Vector2<f64> {
        // Without the small tangential terms the problem has one dimension, where it can be solved safely.
        let target = distorted.norm();
        if target == 0.0 {
            return Vector2::zeros();
        }
        let profile = |radius: f64| {
            let u = radius * radius;
            let (f, slope) = self.radial(u).unwrap_or((f64::NAN, f64::NAN));
            (radius * f, f + 2.0 * u * slope)
        };
        let radius = solve_increasing(profile, target, self.max_radius);
        let start = self.nearest_in_field(distorted * (radius / target));
        self.newton(start, distorted)
    }

    /// Newton's method for F(x) = `distorted` in the valid field. A step is shortened until it reduces the
    /// distance of F(x) from its goal, and ends where no step does.
    fn newton(&self, start: Vector2<f64>, distorted: &Vector2<f64>) -> Vector2<f64> {
        let mut x = start;
        let Some((value, mut jacobian)) = self.evaluate(&x) else { return x };
        let mut residual = distorted - value;
        for _ in 0..MAX_STEPS {
            // Rounding of F itself.
            if residual.norm() <= 2.0 * f64::EPSILON * distorted.norm() {
                break;
            }
            let Some(inverse) = jacobian.try_inverse() else { break };
            let step = inverse * residual;
            let mut fraction = 1.0;
            let accepted = loop {
                let trial = self.nearest_in_field(x + step * fraction);
                if let Some((value, jacobian)) = self.evaluate(&trial)
                    && (distorted - value).norm() < residual.norm()
                {
                    break Some((trial, distorted - value, jacobian));
                }
                fraction *= 0.5;
                if fraction < MIN_FRACTION {
                    break None;
                }
            };
            let Some(better) = accepted else { break };
            (x, residual, jacobian) = better;
        }
        x
    }

    /// The point of the valid field nearest to `x`.
    fn nearest_in_field(&self, x: Vector2<f64>) -> Vector2<f64> {
        let radius = x.norm();
        // Rounding must not carry the result out of the field.
        let end = self.max_radius * (1.0 - 4.0 * f64::EPSILON);
        if radius > end { x * (end / radius) } else { x }
    }
}

/// 1 + c₀ u + c₁ u² + c₂ u³ and its derivative.
fn polynomial(coefficients: &[f64; 3], u: f64) -> (f64, f64) {
    let [a, b, c] = *coefficients;
    (1.0 + u * (a + u * (b + u * c)), a + u * (2.0 * b + u * 3.0 * c))
}
