//! Whether the radius of a body changes along its axis: what tapers is no cylinder.

use super::surface::{Place, Surface};
use crate::geometry::{Cylinder, any_orthogonal};
use nalgebra::{SMatrix, SVector, Vector3};

/// One Gauss–Newton step from a cylinder to the cone that explains what is measured on its surface best: two shifts and two tilts
/// of the axis, the radius, the bias next to the limbs, and by how much the radius grows along the axis. What is minimised are the
/// distances from the surface, ε = ‖x − a − (x − a)·d̂ d̂‖ − r.
pub(super) struct ToCone {
    across: [Vector3<f64>; 2],
    radius: f64,
    matrix: SMatrix<f64, 7, 7>,
    vector: SVector<f64, 7>,
}

impl ToCone {
    pub fn new(cylinder: &Cylinder) -> Self {
        let (u, v) = any_orthogonal(&cylinder.axis.direction);
        let radius = cylinder.radius;
        Self { across: [u, v], radius, matrix: SMatrix::zeros(), vector: SVector::zeros() }
    }

    /// A place on the surface and its distance, how that changes with the bias, and the inverse of its variance.
    pub fn add(&mut self, place: &Place, distance: f64, shape: f64, weight: f64) {
        let [nu, nv] = self.across.map(|direction| place.normal.dot(&direction));
        // Tilts and slopes in radii: all numbers are lengths.
        let along = place.along / self.radius;
        let row = SVector::from([-nu, -nv, -nu * along, -nv * along, -1.0, -shape, -along]);
        self.matrix += row * row.transpose() * weight;
        self.vector += row * (weight * distance);
    }

    /// How large the bias is expected to be, at the `bias` that distances were taken with.
    pub fn expect(&mut self, bias: f64, sigma: f64) {
        self.matrix[(5, 5)] += 1.0 / (sigma * sigma);
        self.vector[5] += bias / (sigma * sigma);
    }

    /// By how much the radius grows along the axis, and the standard deviation of that; `None` where it is not determined.
    pub fn slope(&self) -> Option<[f64; 2]> {
        let inverse = self.matrix.cholesky()?.inverse();
        let step = -(inverse * self.vector);
        let slope = [step[6], inverse[(6, 6)].sqrt()].map(|slope| slope / self.radius);
        slope.iter().all(|number| number.is_finite()).then_some(slope)
    }
}

/// By how much the radius of a cylinder seems to grow along its axis, and the standard deviation of that, by points on its
/// surface, each with the inverse of its variance.
pub(crate) fn slope_by_points(
    cylinder: &Cylinder,
    points: impl Iterator<Item = (Vector3<f64>, f64)>,
) -> Option<[f64; 2]> {
    let surface = Surface::Cylinder(*cylinder, 0.0);
    let mut step = ToCone::new(cylinder);
    for (point, weight) in points {
        let place = surface.place(&point);
        step.add(&place, place.distance, 0.0, weight);
    }
    // These points have no bias.
    step.expect(0.0, cylinder.radius);
    step.slope()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Line;

    /// Points on a cone about an axis that is a little off the one that is asked about.
    #[test]
    fn a_step_finds_the_slope_of_a_cone() {
        let direction = Vector3::new(0.1, 1.0, -0.2).normalize();
        let axis = Line { point: Vector3::new(0.02, -0.01, 0.8), direction };
        let (u, v) = any_orthogonal(&direction);
        let off = Line { point: axis.point + 1e-4 * u, direction: (direction + 1e-3 * v).normalize() };
        let cylinder = Cylinder { axis: off, radius: 0.0399 };
        for slope in [-0.02, 0.0, 0.05] {
            let points = (0..400).map(|k| {
                let (angle, along) = (0.017 * f64::from(k), 0.01 * f64::from(k % 11) - 0.05);
                let radius = 0.04 + slope * along;
                (axis.point + direction * along + (u * angle.cos() + v * angle.sin()) * radius, 1e6)
            });
            let [found, deviation] = slope_by_points(&cylinder, points).unwrap();
            assert!((found - slope).abs() < 2e-4, "{slope}: {found}");
            // A thousandth of a unit of noise, over lengths of 0.032 about their mean: 1e-3 / (√400 · 0.032).
            assert!((deviation / 1.58e-3 - 1.0).abs() < 0.05, "{deviation}");
        }
    }

    #[test]
    fn no_points_tell_no_slope() {
        let axis = Line { point: Vector3::new(0.0, 0.0, 0.8), direction: Vector3::y() };
        let cylinder = Cylinder { axis, radius: 0.04 };
        assert_eq!(slope_by_points(&cylinder, std::iter::empty()), None);
    }
}
