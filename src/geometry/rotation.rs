//! Exponential maps on SO(3), SO(2) and the unit sphere.

use nalgebra::{Matrix2, Matrix3, Vector3};

/// The skew-symmetric matrix of a vector: `hat(a) * b == a.cross(&b)`.
#[must_use]
pub fn hat(a: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -a.z, a.y, a.z, 0.0, -a.x, -a.y, a.x, 0.0)
}

/// Rotation by the angle ‖θ‖ about the axis θ (Rodrigues), exact for θ → 0.
#[must_use]
pub fn exp_so3(theta: &Vector3<f64>) -> Matrix3<f64> {
    let angle = theta.norm();
    let k = hat(theta);
    // sin x / x and (1 − cos x) / x² keep full precision through sinc(x/2)² / 2.
    let a = sinc(angle);
    let b = 0.5 * sinc(0.5 * angle).powi(2);
    Matrix3::identity() + k * a + k * k * b
}

/// Rotation of the plane by an angle.
#[must_use]
pub fn exp_so2(angle: f64) -> Matrix2<f64> {
    let (s, c) = angle.sin_cos();
    Matrix2::new(c, -s, s, c)
}

/// Moves a unit vector along the great circle whose tangent is `tangent` (orthogonal to `direction`), by
/// the angle ‖tangent‖: the exponential map of the sphere, that is Exp(direction × tangent) · direction.
#[must_use]
pub fn rotate_direction(direction: &Vector3<f64>, tangent: &Vector3<f64>) -> Vector3<f64> {
    let angle = tangent.norm();
    // Rounding is removed at every step so that it can't add up over an iteration.
    (direction * angle.cos() + tangent * sinc(angle)).normalize()
}

/// A right-handed pair (u, v) with u × v = `direction`, chosen by a fixed rule.
#[must_use]
pub fn any_orthogonal(direction: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let smallest = direction.iamin();
    let u = direction.cross(&Vector3::ith(smallest, 1.0)).normalize();
    (u, direction.cross(&u))
}

fn sinc(x: f64) -> f64 {
    // Below this the next term of the series, x⁴/120, is under the rounding error.
    if x.abs() < 1e-3 { 1.0 - x * x / 6.0 } else { x.sin() / x }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    #[test]
    fn exponential_of_so3_is_a_rotation_with_the_right_generator() {
        for theta in [
            Vector3::new(1e-9, -2e-9, 0.5e-9),
            Vector3::new(2e-4, 5e-4, -7e-4),
            Vector3::new(0.3, -1.2, 0.7),
            Vector3::new(3.0, 0.2, -0.1),
        ] {
            let r = exp_so3(&theta);
            assert!((r.transpose() * r - Matrix3::identity()).norm() < 1e-14);
            assert!((r.determinant() - 1.0).abs() < 1e-14);
            assert!((r * theta - theta).norm() < 1e-14);
            let reference = nalgebra::Rotation3::new(theta).into_inner();
            assert!((r - reference).norm() < 1e-14, "{theta}");
        }
        let w = Vector3::new(0.4, -0.2, 0.9);
        let h = 1e-6;
        let derivative = (exp_so3(&(w * h)) - exp_so3(&(-w * h))) / (2.0 * h);
        assert!((derivative - hat(&w)).norm() < 1e-10);
    }

    #[test]
    fn exponential_of_so2_adds_angles() {
        assert!((exp_so2(0.4) * exp_so2(-1.1) - exp_so2(-0.7)).norm() < 1e-15);
        let unit = |angle: f64| Vector2::new(angle.cos(), angle.sin());
        assert!((exp_so2(0.3) * unit(0.2) - unit(0.5)).norm() < 1e-15);
    }

    #[test]
    fn directions_move_as_the_rotation_about_direction_cross_tangent() {
        let d = Vector3::new(0.2, -0.5, 0.8).normalize();
        let (u, v) = any_orthogonal(&d);
        assert!((u.cross(&v) - d).norm() < 1e-15);
        for (a, b) in [(0.3, -0.8), (1e-7, 2e-7), (2.0, 1.0)] {
            let t = u * a + v * b;
            let expected = exp_so3(&d.cross(&t)) * d;
            assert!((rotate_direction(&d, &t) - expected).norm() < 1e-15);
        }
    }
}
