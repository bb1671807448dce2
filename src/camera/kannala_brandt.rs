//! The Kannala–Brandt model on the plane z = 1.

use super::radial::{MIN_STRETCH, end_of_field, solve_increasing};
use nalgebra::Vector2;

/// Kannala–Brandt coefficients and the valid field.
///
/// Invariant: θ_d increases from the axis to `max_angle`, by at least [`MIN_STRETCH`] per radian.
#[derive(Clone, Debug)]
pub(super) struct KannalaBrandt {
    /// k1 to k4.
    coefficients: [f64; 4],
    /// The greatest angle from the axis in the valid field.
    max_angle: f64,
}

impl KannalaBrandt {
    /// The model with k1 k2 k3 k4.
    pub(super) fn new(coefficients: &[f64; 4]) -> Self {
        let mut lens = Self { coefficients: *coefficients, max_angle: 0.0 };
        lens.max_angle = end_of_field(|angle| lens.distorted_angle(angle).1 >= MIN_STRETCH);
        lens
    }

    /// θ_d = θ (1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸) and its derivative.
    fn distorted_angle(&self, angle: f64) -> (f64, f64) {
        let [k1, k2, k3, k4] = self.coefficients;
        let q = angle * angle;
        let value = angle * (1.0 + q * (k1 + q * (k2 + q * (k3 + q * k4))));
        let slope = 1.0 + q * (3.0 * k1 + q * (5.0 * k2 + q * (7.0 * k3 + q * 9.0 * k4)));
        (value, slope)
    }

    /// F(x), or `None` outside the valid field.
    pub(super) fn distort(&self, x: &Vector2<f64>) -> Option<Vector2<f64>> {
        let radius = x.x.hypot(x.y);
        let angle = radius.atan();
        // The comparison is false for what is not a number.
        let valid = angle <= self.max_angle;
        valid.then(|| if radius > 0.0 { x * (self.distorted_angle(angle).0 / radius) } else { *x })
    }

    /// The x of the valid field with F(x) = `distorted`, or a point on the end of the field when there is none.
    pub(super) fn undistort(&self, distorted: &Vector2<f64>) -> Vector2<f64> {
        let radius = distorted.x.hypot(distorted.y);
        if radius == 0.0 {
            return *distorted;
        }
        // Rounding must not carry the end of the field out of it.
        let end = self.max_angle * (1.0 - 4.0 * f64::EPSILON);
        let angle = solve_increasing(|angle| self.distorted_angle(angle), radius, end);
        distorted * (angle.tan() / radius)
    }
}
