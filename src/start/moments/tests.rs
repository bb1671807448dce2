use super::*;
use crate::start::clouds::{Arc, oblique};

/// The direction scaled to unit length; `None` when it vanishes or is not finite.
fn unit_direction(direction: &Vector3<f64>) -> Option<Vector3<f64>> {
    // By the largest component first, so that squares neither overflow nor vanish.
    let scaled = direction / direction.amax();
    let unit = scaled.normalize();
    unit.iter().all(|x| x.is_finite()).then_some(unit)
}

impl Moments {
    /// The best cylinder with the axis along `direction`, which need not have unit length.
    ///
    /// `None` when the direction vanishes or is not finite.
    fn evaluate(&self, direction: &Vector3<f64>) -> Option<AlgebraicFit> {
        Some(self.fit(&self.slice(&unit_direction(direction)?)?))
    }

    /// The minimum of G that Newton's method reaches from `direction`, which need not have unit length.
    ///
    /// `None` when the direction vanishes or is not finite.
    fn refine(&self, direction: &Vector3<f64>) -> Option<AlgebraicFit> {
        Some(self.fit(&self.newton(self.slice(&unit_direction(direction)?)?, CONVERGED)))
    }
}

fn moments_of(points: &[Vector3<f64>]) -> Option<Moments> {
    Moments::new(points.iter().map(|p| (*p, 1.0)))
}

#[test]
fn g_is_the_mean_over_the_points_and_its_minimum_in_the_other_unknowns() {
    let (points, _) = Arc { noise: 1e-3, points: 200, ..Arc::default() }.sample(1);
    let weight = |i: usize| 1.0 + (i % 3) as f64;
    let weighted = points.iter().enumerate().map(|(i, p)| (*p, weight(i)));
    let moments = Moments::new(weighted.clone()).unwrap();
    let mean_square = |cylinder: &Cylinder| {
        let sum: f64 = weighted
            .clone()
            .map(|(p, w)| w * (cylinder.axis.distance(&p).powi(2) - cylinder.radius.powi(2)).powi(2))
            .sum();
        sum / weighted.clone().map(|(_, w)| w).sum::<f64>()
    };
    for direction in [Vector3::x(), Vector3::new(0.3, -4.0, 0.2), oblique().axis.direction] {
        let fit = moments.evaluate(&direction).unwrap();
        let direct = mean_square(&fit.cylinder);
        assert!((fit.mean_square - direct).abs() < 1e-10 * direct);
        assert!(fit.cylinder.axis.direction.cross(&direction).norm() < 1e-14 * direction.norm());
        let (u, v) = any_orthogonal(&fit.cylinder.axis.direction);
        for (shift, growth) in [(u, 0.0), (-u, 0.0), (v, 0.0), (-v, 0.0), (u, 1.0), (u, -1.0)] {
            let mut other = fit.cylinder;
            other.axis.point += shift * 1e-5;
            other.radius += growth * 1e-5;
            assert!(mean_square(&other) > direct);
        }
    }
}

#[test]
fn gradient_and_hessian_agree_with_central_differences_of_g() {
    let (points, _) = Arc { noise: 2e-3, points: 300, outliers: 0.1, ..Arc::default() }.sample(2);
    let moments = moments_of(&points).unwrap();
    for direction in half_sphere(20) {
        let slice = moments.slice(&direction).unwrap();
        let (gradient, hessian) = moments.derivatives(&slice).unwrap();
        let half_g = |a: f64, b: f64| {
            let moved = rotate_direction(&direction, &(slice.u * a + slice.v * b));
            0.5 * moments.slice(&moved).unwrap().mean_square
        };
        let h = 1e-3;
        // Fourth-order differences: the truncation error of the second order would hide the last digits.
        let slope = |g: &dyn Fn(f64) -> f64| (8.0 * (g(h) - g(-h)) - (g(2.0 * h) - g(-2.0 * h))) / (12.0 * h);
        let bend = |g: &dyn Fn(f64) -> f64| {
            (16.0 * (g(h) + g(-h)) - (g(2.0 * h) + g(-2.0 * h)) - 30.0 * g(0.0)) / (12.0 * h * h)
        };
        let numeric = Vector2::new(slope(&|t| half_g(t, 0.0)), slope(&|t| half_g(0.0, t)));
        assert!((numeric - gradient).norm() < 1e-9, "{gradient} {numeric}");
        let (aa, bb) = (bend(&|t| half_g(t, 0.0)), bend(&|t| half_g(0.0, t)));
        let ab = 0.5 * (bend(&|t| half_g(t, t)) - aa - bb);
        let numeric = Matrix2::new(aa, ab, ab, bb);
        assert!((numeric - hessian).norm() < 1e-7 * (1.0 + hessian.norm()), "{hessian} {numeric}");
    }
}

#[test]
fn points_without_noise_give_the_cylinder_whatever_the_arc_the_position_and_the_unit() {
    for half_angle in [20.0_f64, 45.0, 70.0, 180.0] {
        for (scale, offset, tolerance) in [
            (1.0, Vector3::zeros(), 1e-9),
            (1000.0, Vector3::zeros(), 1e-9),
            // Here the coordinates themselves are only good to 2e-12, 1e-10 of the radius.
            (1.0, Vector3::new(6000.0, -7000.0, 4000.0), 1e-9),
        ] {
            let (points, _) =
                Arc { half_angle: half_angle.to_radians(), points: 500, ..Arc::default() }.sample(3);
            let points: Vec<_> = points.iter().map(|p| p * scale + offset).collect();
            let mut expected = oblique();
            expected.axis.point = expected.axis.point * scale + offset;
            expected.radius *= scale;
            let fit = moments_of(&points).unwrap().best(None).unwrap();
            let difference = expected.compare(&fit.cylinder);
            assert!(difference.radius_relative.abs() < tolerance, "{half_angle} {difference:?}");
            assert!(difference.angle < tolerance, "{half_angle} {difference:?}");
            let shift = expected.axis.distance(&fit.cylinder.axis.point);
            assert!(shift < tolerance * expected.radius, "{half_angle} {shift:e}");
            assert!(fit.mean_square >= 0.0 && fit.distance_rms() < 1e-5 * expected.radius);
        }
    }
}

#[test]
fn newton_goes_downhill_from_everywhere_and_ends_in_one_of_the_minima() {
    let (points, _) = Arc { noise: 5e-4, points: 400, ..Arc::default() }.sample(4);
    let moments = moments_of(&points).unwrap();
    let minima = moments.minima(None, DEFAULT_SEEDS, CONVERGED);
    assert!(!minima.is_empty() && minima.is_sorted_by(|a, b| a.distance_rms() <= b.distance_rms()));
    assert_eq!(moments.best(None).unwrap(), minima[0]);
    for direction in half_sphere(50) {
        let start = moments.evaluate(&direction).unwrap();
        let end = moments.refine(&direction).unwrap();
        assert!(end.mean_square <= start.mean_square);
        let known = minima.iter().any(|minimum| {
            minimum.cylinder.axis.angle(&end.cylinder.axis) < 1e-9
                && (minimum.mean_square - end.mean_square).abs() < 1e-12 * end.mean_square
        });
        assert!(known, "{end:?} {minima:?}");
    }
    let difference = oblique().compare(&minima[0].cylinder);
    assert!(difference.angle < 0.02 && difference.radius_relative.abs() < 0.05, "{difference:?}");
}

#[test]
fn newton_leaves_a_saddle() {
    // Three rings: between the mirror planes of the cloud the gradient vanishes by symmetry.
    let points: Vec<_> = (0..36)
        .map(|i| (f64::from(i % 12) / 12.0 * std::f64::consts::TAU, f64::from(i / 12)))
        .map(|(angle, z)| Vector3::new(angle.cos(), angle.sin(), 2.0 * z))
        .collect();
    let moments = moments_of(&points).unwrap();
    let slice = moments.slice(&Vector3::x()).unwrap();
    let (gradient, hessian) = moments.derivatives(&slice).unwrap();
    assert!(gradient.norm() < 1e-14 && hessian.symmetric_eigenvalues().min() < -0.01);
    let end = moments.newton(slice, CONVERGED);
    let (gradient, hessian) = moments.derivatives(&end).unwrap();
    assert!(gradient.norm() < 1e-12 && hessian.symmetric_eigenvalues().min() > 0.01);
    assert!(end.mean_square < slice.mean_square);
    let best = moments.best(None).unwrap();
    assert!(best.cylinder.axis.direction.z.abs() > 1.0 - 1e-12);
    assert!((best.cylinder.radius - 1.0).abs() < 1e-12);
}

#[test]
fn five_points_are_enough_and_fewer_are_not() {
    let (points, _) = Arc { points: 5, ..Arc::default() }.sample(5);
    let best = moments_of(&points).unwrap().best(None).unwrap();
    for p in &points {
        assert!(best.cylinder.distance(p).abs() < 1e-9 * best.cylinder.radius);
    }
    assert!(moments_of(&points[..4]).is_none());
    let mut holed = points.clone();
    holed[2].y = f64::NAN;
    assert!(moments_of(&holed).is_none());
    assert!(Moments::new(points.iter().map(|p| (*p, if p == &points[1] { 0.0 } else { 1.0 }))).is_none());
}

#[test]
fn flat_clouds_are_refused() {
    let offset = Vector3::new(3.0, -2.0, 40.0);
    let (a, b) = (Vector3::new(0.3, 0.1, -0.7), Vector3::new(-0.2, 0.9, 0.4));
    let line: Vec<_> = (0..50).map(|i| offset + a * f64::from(i)).collect();
    let plane: Vec<_> = (0..50).map(|i| offset + a * f64::from(i % 7) + b * f64::from(i / 7)).collect();
    for points in [&line, &plane, &vec![offset; 20], &vec![], &vec![offset * f64::INFINITY; 9]] {
        assert!(moments_of(points).is_none());
    }
    let huge: Vec<_> = plane.iter().map(|p| p * 1e300).collect();
    assert!(moments_of(&huge).is_none());
    let (curved, _) = Arc { points: 50, ..Arc::default() }.sample(6);
    assert!(Moments::new(curved.iter().map(|p| (*p, f64::MAX))).is_none());
}

#[test]
fn directions_without_meaning_are_refused() {
    let (points, _) = Arc { points: 50, ..Arc::default() }.sample(7);
    let moments = moments_of(&points).unwrap();
    for direction in [Vector3::zeros(), Vector3::new(f64::NAN, 1.0, 0.0), Vector3::x() * f64::INFINITY] {
        assert!(moments.evaluate(&direction).is_none() && moments.refine(&direction).is_none());
    }
    let by_size = [1e-300, 1.0, 1e300].map(|s| moments.evaluate(&(Vector3::x() * s)).unwrap());
    assert!(by_size[0] == by_size[1] && by_size[1] == by_size[2]);
    assert!(moments.minima(None, 0, CONVERGED).is_empty());
}

#[test]
fn the_spread_is_that_of_the_moments_and_known_where_they_are() {
    let reference = Vector3::new(3.0, -2.0, 50.0);
    let on_plane = |k: usize| Vector3::new((k % 7) as f64, (k / 7) as f64, 0.0);
    for bend in [0.0, 0.01] {
        for scale in [1.0, 1e60, 1e-60, 0.0] {
            let point = |k| (reference + on_plane(k) + Vector3::z() * bend * (k * k) as f64) * scale;
            for count in [0, 1, 4, 5, 60] {
                let points = (0..count).map(|k| (point(k), 1.0));
                let spread = Spread::new(points.clone()).map(|spread| (spread.center, spread.size));
                let moments = Moments::new(points).map(|moments| (moments.center, moments.unit));
                assert_eq!(spread, moments);
            }
        }
    }
}
