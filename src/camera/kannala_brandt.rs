//! The Kannala–Brandt model on the plane z = 1.

use super::radial::{MAX_STRETCH, MIN_STRETCH, end_of_field, solve_increasing};
use nalgebra::Vector2;

/// Kannala–Brandt coefficients and the valid field.
///
/// Invariant: from the axis to `max_angle` the derivative of θ′ is between [`MIN_STRETCH`] and
/// [`MAX_STRETCH`].
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
        lens.max_angle =
            end_of_field(|angle| (MIN_STRETCH..=MAX_STRETCH).contains(&lens.distorted_angle(angle).1));
        lens
    }

    /// θ′ = θ (1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸) and its derivative.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::tests::{camera, check_reference, check_round_trips};
    use crate::camera::{Camera, Distortion};
    use nalgebra::Vector3;

    const LENSES: [[f64; 4]; 5] = [
        [0.0, 0.0, 0.0, 0.0],
        [-0.0131, 0.0092, -0.0084, 0.0016],
        [0.15, -0.08, 0.03, -0.004],
        // Folds over at 57°: θ′ ends at 2/3, 408 pixels from the centre.
        [-1.0 / 3.0, 0.0, 0.0, 0.0],
        [0.3, 0.2, 0.1, 0.1],
    ];

    fn fisheye(coefficients: [f64; 4]) -> Camera {
        camera(Distortion::KannalaBrandt(coefficients))
    }

    #[test]
    fn pixels_agree_with_opencv() {
        let references: [[(f64, f64); 6]; 3] = [
            [
                (750.3387320428006, 282.36359079028796),
                (303.1881602737873, 566.2166709747848),
                (655.8012704141454, 371.71658086058),
                (885.4551614511707, 560.5041861479317),
                (640.5, 360.25),
                (1332.166693445241, -158.07637776454817),
            ],
            [
                (750.2713605711331, 282.4113637562879),
                (304.67995689326347, 565.3057619959174),
                (655.8010749267727, 371.7164343647854),
                (884.721314262126, 559.9042560597943),
                (640.5, 360.25),
                (1310.8298931590646, -142.08684623118552),
            ],
            [
                (751.1158653499881, 281.8125272296624),
                (286.092372286067, 576.65556497382),
                (655.8035091875782, 371.71825856941734),
                (894.0098289162687, 567.4977435028392),
                (640.5, 360.25),
                (1439.8155988180765, -238.7471223890874),
            ],
        ];
        for (lens, reference) in LENSES.iter().zip(&references) {
            check_reference(&fisheye(*lens), reference);
        }
    }

    #[test]
    fn project_and_unproject_are_inverse_in_the_whole_field() {
        for lens in LENSES {
            let end = KannalaBrandt::new(&lens).max_angle.tan();
            check_round_trips(&fisheye(lens), end);
        }
    }

    #[test]
    fn pixels_beyond_the_fold_have_no_ray() {
        let camera = fisheye(LENSES[3]);
        // dθ′/dθ = 1 − θ² is 0.01 at the end of the field.
        let end = 0.99_f64.sqrt();
        let lens = KannalaBrandt::new(&LENSES[3]);
        assert!((lens.max_angle - end).abs() < 1e-14);
        let edge = 612.25 * (end - end.powi(3) / 3.0);
        assert!(612.25 * 2.0 / 3.0 - edge < 0.02);
        for (distance, valid) in [(edge - 1e-6, true), (edge + 1e-6, false), (410.0, false), (1e5, false)] {
            let pixel = Vector2::new(640.5 + distance, 360.25);
            assert_eq!(camera.unproject(&pixel).is_some(), valid, "{distance}");
        }
        // The formula takes this ray to a pixel that a nearer ray already has.
        assert_eq!(camera.project(&Vector3::new(1.2_f64.tan(), 0.0, 1.0)), None);
    }

    #[test]
    fn the_field_ends_at_89_degrees() {
        let camera = fisheye(LENSES[0]);
        for (degrees, valid) in [(88.999_f64, true), (89.001, false), (89.999, false)] {
            let angle = degrees.to_radians();
            let ray = Vector3::new(0.0, angle.sin(), angle.cos());
            assert_eq!(camera.project(&ray).is_some(), valid);
            let pixel = Vector2::new(640.5, 360.25 + 611.75 * angle);
            assert_eq!(camera.unproject(&pixel).is_some(), valid);
        }
    }

    #[test]
    fn the_axis_is_exact() {
        for lens in LENSES {
            let camera = fisheye(lens);
            let centre = Vector2::new(640.5, 360.25);
            assert_eq!(camera.project(&Vector3::new(0.0, 0.0, 0.3)), Some(centre));
            assert_eq!(camera.unproject(&centre), Some(Vector3::z()));
            // So near the axis F is the identity, whether or not squares vanish in rounding.
            for x in [1e-300, 1e-160, 1e-9] {
                let lens = KannalaBrandt::new(&lens);
                let distorted = lens.distort(&Vector2::new(x, -x)).unwrap();
                assert!((distorted / x - Vector2::new(1.0, -1.0)).norm() < 1e-15);
                let back = lens.undistort(&Vector2::new(x, -x));
                assert!((back / x - Vector2::new(1.0, -1.0)).norm() < 1e-15);
            }
        }
    }
}
