//! The Brown–Conrady model with rational radial terms on the plane z = 1.
//!
//! With v = (p2, p1), s = v · x, u = x · x and f(u) the quotient of the radial polynomials:
//!
//! F(x) = f x + 2 s x + u v,  J = ∂F/∂x = (f + 2 s) I + 2 f′ x xᵀ + 2 (x vᵀ + v xᵀ).
//!
//! J is symmetric: F is the gradient of a potential. Where J is positive definite the potential is convex, and
//! the gradient of a convex function on a convex region takes no value twice. The valid field is therefore a
//! circle in which J is positive definite: there F is one to one, not only locally.

use super::radial::{LAST_STEP, MAX_STRETCH, MIN_STRETCH, end_of_field, solve_increasing};
use nalgebra::{Matrix2, Vector2};

/// Limit on the steps of the two-dimensional Newton method; 2 to 4 are usual.
const MAX_STEPS: usize = 50;

/// The smallest fraction of a step of Newton's method that is tried.
const MIN_FRACTION: f64 = 1e-3;

/// Brown–Conrady coefficients and the valid field.
///
/// Invariant: up to `max_radius` the denominator is positive and both eigenvalues of J are between
/// [`MIN_STRETCH`] and [`MAX_STRETCH`].
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
    /// No ‖F(x)‖ of the valid field is greater.
    max_distorted: f64,
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
            max_distorted: 0.0,
        };
        lens.max_radius = end_of_field(|angle| lens.is_regular(angle.tan())).tan();
        // f r increases up to there, and ‖2 s x + u v‖ ≤ 3 u ‖v‖.
        let u = lens.max_radius * lens.max_radius;
        let bound = lens.radial_profile(lens.max_radius).0 + 3.0 * u * lens.tangential.norm();
        // The margin covers the rounding of pixels on the very end.
        lens.max_distorted = bound + 1e-9 * bound.max(1.0);
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

    /// ‖F‖ at a radius of the valid field without the tangential terms, f r, and its derivative.
    fn radial_profile(&self, radius: f64) -> (f64, f64) {
        let u = radius * radius;
        let (f, slope) = self.radial(u).unwrap_or((f64::NAN, f64::NAN));
        (radius * f, f + 2.0 * u * slope)
    }

    /// Whether both eigenvalues of J are between [`MIN_STRETCH`] and [`MAX_STRETCH`] everywhere at this
    /// distance from the axis.
    ///
    /// At the angle ψ from v, in the basis along and across the radius, and with a = r ‖v‖,
    /// J = [[f + 2 u f′ + 6 a cos ψ, 2 a sin ψ], [2 a sin ψ, f + 2 a cos ψ]].
    fn is_regular(&self, radius: f64) -> bool {
        let u = radius * radius;
        let Some((f, slope)) = self.radial(u) else { return false };
        let (along, across) = (f + 2.0 * u * slope, f);
        let a = radius * self.tangential.norm();
        // J − min I and max I − J: the sign of a has no meaning over all ψ.
        is_positive(along - MIN_STRETCH, across - MIN_STRETCH, a)
            && is_positive(MAX_STRETCH - along, MAX_STRETCH - across, a)
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

    /// The x of the valid field with F(x) = `distorted`. When there is none, `None` or some point of the field.
    pub(super) fn undistort(&self, distorted: &Vector2<f64>) -> Option<Vector2<f64>> {
        let target = distorted.norm();
        if target == 0.0 {
            return Some(Vector2::zeros());
        }
        // Saves the search for most pixels outside the field.
        if target > self.max_distorted {
            return None;
        }
        // Without the small tangential terms the problem has one dimension, where it can be solved safely.
        let radius = solve_increasing(|radius| self.radial_profile(radius), target, self.max_radius);
        let start = self.nearest_in_field(distorted * (radius / target));
        Some(self.newton(start, distorted))
    }

    /// Newton's method for F(x) = `distorted` in the valid field. A step is shortened until it reduces the
    /// distance of F(x) from its goal, and ends where no step does.
    fn newton(&self, start: Vector2<f64>, distorted: &Vector2<f64>) -> Vector2<f64> {
        let mut x = start;
        let Some((value, mut jacobian)) = self.evaluate(&x) else { return x };
        let mut residual = distorted - value;
        for _ in 0..MAX_STEPS {
            let Some(inverse) = jacobian.try_inverse() else { break };
            let step = inverse * residual;
            if step.norm() <= LAST_STEP * x.norm() {
                return self.nearest_in_field(x + step);
            }
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

/// Whether [[along + 6 a c, 2 a s], [2 a s, across + 2 a c]] is positive definite for all c = cos ψ and
/// s = sin ψ, a ≥ 0.
fn is_positive(along: f64, across: f64, a: f64) -> bool {
    // The determinant is quadratic in c, with its minimum in closed form.
    let linear = along + 3.0 * across;
    let c = if a > 0.0 { (-linear / (16.0 * a)).clamp(-1.0, 1.0) } else { 0.0 };
    let determinant = along * across - 4.0 * a * a + 2.0 * a * linear * c + 16.0 * a * a * c * c;
    // Where no determinant vanishes, no eigenvalue changes its sign on the way around: c = 0 speaks for all.
    along > 0.0 && across > 0.0 && determinant > 0.0
}

/// 1 + c₀ u + c₁ u² + c₂ u³ and its derivative.
fn polynomial(coefficients: &[f64; 3], u: f64) -> (f64, f64) {
    let [a, b, c] = *coefficients;
    (1.0 + u * (a + u * (b + u * c)), a + u * (2.0 * b + u * 3.0 * c))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::tests::{camera, check_reference, check_round_trips};
    use crate::camera::{Camera, Distortion};
    use nalgebra::Vector3;

    /// The first four have reference values.
    const LENSES: [[f64; 8]; 10] = [
        // Strong barrel, wide angle, and two rational sets as depth cameras have them.
        [-0.4, 0.15, 0.001, -0.0005, 0.0, 0.0, 0.0, 0.0],
        [-0.28, 0.08, 0.0012, -0.0007, -0.01, 0.0, 0.0, 0.0],
        [0.5, -2.7, 0.0007, -0.0002, 1.6, 0.38, -2.5, 1.5],
        [5.4387, 3.6021, -2.4e-5, 1.1e-4, 0.1853, 5.7655, 5.5873, 0.9761],
        // Pincushion.
        [0.3, 0.1, -0.002, 0.001, 0.05, 0.0, 0.0, 0.0],
        // Barrel that folds over well inside the image.
        [-0.4, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [-0.6, 0.1, 0.004, 0.003, 0.0, 0.0, 0.0, 0.0],
        // Tangential terms only, far beyond any lens.
        [0.0, 0.0, 0.05, -0.08, 0.0, 0.0, 0.0, 0.0],
        // A denominator that vanishes at r = 1.
        [0.1, 0.0, 0.001, 0.0, 0.0, -1.0, 0.0, 0.0],
        // Flattens out without folding over.
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.4, 0.0, 0.0],
    ];

    fn distorted(coefficients: [f64; 8]) -> Camera {
        camera(Distortion::BrownConrady(coefficients))
    }

    fn point(radius: f64, angle: f64) -> Vector2<f64> {
        Vector2::new(radius * angle.cos(), radius * angle.sin())
    }

    #[test]
    fn pixels_agree_with_opencv() {
        let references: [[(f64, f64); 5]; 4] = [
            [
                (749.889981909602, 282.7015324178201),
                (316.5149977946433, 558.3202758388142),
                (655.8001655636001, 371.7165743410367),
                (879.2607511910401, 555.71877332928),
                (640.5, 360.25),
            ],
            [
                (750.5201325424957, 282.2564700045415),
                (299.07016924430604, 568.9993050286855),
                (655.8018003971239, 371.7180085590906),
                (887.5998277648438, 562.6079794985691),
                (640.5, 360.25),
            ],
            [
                (752.7186802867056, 280.6930443955958),
                (233.89500079065215, 608.7285306223699),
                (655.8081692696082, 371.7222585769563),
                (916.2189899919367, 585.8247917671488),
                (640.5, 360.25),
            ],
            [
                (750.3194491345284, 282.37891795755536),
                (308.06631557837875, 563.2530186829058),
                (655.8014998797242, 371.7166891948279),
                (883.6374676500917, 558.9956568622948),
                (640.5, 360.25),
            ],
        ];
        for (lens, reference) in LENSES.iter().zip(&references) {
            check_reference(&distorted(*lens), reference);
        }
    }

    #[test]
    fn project_and_unproject_are_inverse_in_the_whole_field() {
        for lens in LENSES {
            check_round_trips(&distorted(lens), BrownConrady::new(&lens).max_radius);
        }
    }

    #[test]
    fn jacobian_agrees_with_differences() {
        for lens in LENSES.map(|lens| BrownConrady::new(&lens)) {
            for k in 0..20 {
                let x = point(0.045 * f64::from(k), 2.4 * f64::from(k));
                let (_, jacobian) = lens.evaluate(&x).unwrap();
                for axis in [Vector2::x(), Vector2::y()] {
                    let h = 1e-6;
                    let value = |t: f64| lens.evaluate(&(x + axis * t)).unwrap().0;
                    let difference = (value(h) - value(-h)) / (2.0 * h);
                    assert!((jacobian * axis - difference).norm() < 1e-8 * jacobian.norm().max(1.0).powi(3));
                }
            }
        }
    }

    #[test]
    fn the_field_is_the_largest_circle_of_regular_points() {
        for lens in LENSES.map(|lens| BrownConrady::new(&lens)) {
            let regular = |radius: f64, tolerance: f64| {
                (0..720).all(|k| {
                    let x = point(radius, f64::from(k) * std::f64::consts::TAU / 720.0);
                    let Some((_, jacobian)) = lens.evaluate(&x) else { return false };
                    let stretch = jacobian.symmetric_eigenvalues();
                    stretch.min() > MIN_STRETCH - tolerance && stretch.max() < MAX_STRETCH + tolerance
                })
            };
            let end = lens.max_radius;
            for k in 0..=1000 {
                assert!(regular(end * f64::from(k) / 1000.0, 1e-9), "{lens:?} {k}");
            }
            if end < 57.0 {
                assert!(!regular(end * 1.0001, 0.0), "{lens:?}");
            }
        }
    }

    #[test]
    fn pixels_beyond_the_fold_have_no_ray() {
        // F(r) = r − 0.4 r³ has the slope 0.01 at the end of the field and turns back just beyond.
        let camera = distorted(LENSES[5]);
        let end = (0.99_f64 / 1.2).sqrt();
        assert!((BrownConrady::new(&LENSES[5]).max_radius - end).abs() < 1e-14);
        let edge = 612.25 * (end - 0.4 * end.powi(3));
        let fold = 612.25 * (2.0 / 3.0) / 1.2_f64.sqrt();
        assert!(fold - edge < 0.02);
        for (distance, valid) in [(edge - 1e-6, true), (edge + 1e-6, false), (fold, false), (500.0, false)] {
            let pixel = Vector2::new(640.5 + distance, 360.25);
            assert_eq!(camera.unproject(&pixel).is_some(), valid, "{distance}");
        }
        // Beyond the fold the formula comes back to pixels that nearer rays have.
        for x in [1.0, 1.3, 1.5, 2.0, 10.0] {
            assert_eq!(camera.project(&Vector3::new(x, 0.0, 1.0)), None);
        }
    }

    #[test]
    fn the_field_ends_before_the_denominator_vanishes() {
        let lens = BrownConrady::new(&LENSES[8]);
        assert!(lens.max_radius < 1.0 && lens.max_radius > 0.9, "{}", lens.max_radius);
        let camera = distorted(LENSES[8]);
        assert_eq!(camera.project(&Vector3::new(1.0, 0.0, 1.0)), None);
        assert_eq!(camera.project(&Vector3::new(1.2, 0.0, 1.0)), None);
    }

    #[test]
    fn depth_cameras_lose_no_pixel() {
        for (lens, f) in [(LENSES[2], 612.25), (LENSES[3], 504.0)] {
            let mut intrinsics = *distorted(lens).intrinsics();
            (intrinsics.fx, intrinsics.fy) = (f, f);
            assert_eq!(check_round_trips(&Camera::new(intrinsics).unwrap(), 0.5), 0);
        }
    }

    #[test]
    fn extreme_coefficients_leave_a_small_field_but_no_wrong_answer() {
        for value in [1e6, -1e6, 1e300, -1e300, f64::MAX] {
            for i in 0..8 {
                let mut lens = [0.0; 8];
                lens[i] = value;
                check_round_trips(&distorted(lens), BrownConrady::new(&lens).max_radius);
            }
        }
    }

    #[test]
    fn random_lenses_are_inverted_up_to_the_end_of_the_field() {
        // A linear congruential generator, numbers in [-1, 1).
        let mut state = 1_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            f64::from((state >> 33) as u32) / f64::from(1_u32 << 30) - 1.0
        };
        for _ in 0..500 {
            // From weak lenses to a hundred times beyond real ones, half of them with a denominator.
            let radial = 100_f64.powf(random());
            let tangential = 100_f64.powf(random() - 1.0);
            let rational = if random() > 0.0 { radial } else { 0.0 };
            let scales = [radial, radial, tangential, tangential, radial, rational, rational, rational];
            let coefficients = scales.map(|scale| scale * random());
            let camera = distorted(coefficients);
            let end = BrownConrady::new(&coefficients).max_radius;
            for i in 0..60 {
                // Everywhere in the field, close to its end, and on its end.
                let inward = [1.0, 1e-3, 1e-6, 1e-15][i % 4] * random().abs();
                let ray = point(end * (1.0 - inward - 1e-15), 4.0 * random()).push(1.0);
                let again = camera.unproject(&camera.project(&ray).unwrap());
                let again = again.unwrap_or_else(|| panic!("{coefficients:?} {ray}"));
                let angle = ray.cross(&again).norm() / ray.norm_squared();
                assert!(angle * 612.25 <= 1e-9, "{coefficients:?} {ray} {again}");
            }
        }
    }
}
