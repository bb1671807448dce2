//! Whether the radius changes along the axis: a body that tapers is no cylinder.

use super::Fitter;
use crate::geometry::{Cylinder, any_orthogonal};
use nalgebra::{SMatrix, SVector, Vector3};

/// Points farther from the surface than this many standard deviations do not count.
const REACH: f64 = 3.0;

impl Fitter {
    /// By how much the radius grows along the axis of the last fit, and the standard deviation of that, by the points of the selected
    /// view and both limbs in its image; `None` where they were not located. Two lines tell it far better than depth does.
    pub(crate) fn taper(&self) -> Option<[f64; 2]> {
        let result = self.result.as_ref()?;
        let (camera, view) = (self.camera()?, self.view());
        let cylinder = view.pose().inverse().cylinder(&result.cylinder);
        let [Ok(a), Ok(b)] = self.limbs()?.each_ref().map(|limb| limb.line) else { return None };
        let mut step = ToCone::new(&cylinder);
        let scale = result.point_scale;
        let weight = result.independent_points / (result.points_used as f64 * scale * scale);
        for p in view.cloud.points() {
            let part = 1.0 - (cylinder.distance(&p) / (REACH * scale)).powi(2);
            if part > 0.0 {
                step.add(&p, weight * part * part);
            }
        }
        for line in [a, b] {
            for end in &line.ends {
                let ray = camera.ideal_ray(end);
                let p = ray * cylinder.axis.nearest_on_ray(&ray);
                let sigma = line.sigma * p.z / camera.intrinsics().fx;
                step.add(&p, 1.0 / (sigma * sigma));
            }
        }
        step.taper()
    }
}

/// One Gauss–Newton step from a cylinder to the cone that explains points on its surface best: two shifts and two tilts of the axis,
/// the radius, and by how much it grows along the axis, ε = ‖x − a − (x − a)·d̂ d̂‖ − r.
struct ToCone<'a> {
    cylinder: &'a Cylinder,
    across: [Vector3<f64>; 2],
    matrix: SMatrix<f64, 6, 6>,
    gradient: SVector<f64, 6>,
}

impl<'a> ToCone<'a> {
    fn new(cylinder: &'a Cylinder) -> Self {
        let (u, v) = any_orthogonal(&cylinder.axis.direction);
        Self { cylinder, across: [u, v], matrix: SMatrix::zeros(), gradient: SVector::zeros() }
    }

    /// A point on the surface, measured or where a ray touches it, with the inverse of its variance.
    fn add(&mut self, p: &Vector3<f64>, weight: f64) {
        let Cylinder { axis, radius } = self.cylinder;
        let offset = p - axis.point;
        let along = offset.dot(&axis.direction);
        let Some(normal) = (offset - axis.direction * along).try_normalize(0.0) else { return };
        // Tilts and tapers in radii: all numbers are lengths.
        let along = along / radius;
        let [nu, nv] = self.across.map(|direction| normal.dot(&direction));
        let row = SVector::from([-nu, -nv, -nu * along, -nv * along, -1.0, -along]);
        self.matrix += row * row.transpose() * weight;
        self.gradient += row * (weight * self.cylinder.distance(p));
    }

    fn taper(&self) -> Option<[f64; 2]> {
        let inverse = self.matrix.cholesky()?.inverse();
        let step = -(inverse * self.gradient);
        Some([step[5], inverse[(5, 5)].sqrt()].map(|taper| taper / self.cylinder.radius))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Line;

    /// Points on a cone about an axis that is a little off the one that is asked about.
    #[test]
    fn a_step_finds_by_how_much_a_cone_tapers() {
        let direction = Vector3::new(0.1, 1.0, -0.2).normalize();
        let axis = Line { point: Vector3::new(0.02, -0.01, 0.8), direction };
        let (u, v) = any_orthogonal(&direction);
        let off = Line { point: axis.point + 1e-4 * u, direction: (direction + 1e-3 * v).normalize() };
        let cylinder = Cylinder { axis: off, radius: 0.0399 };
        for taper in [-0.02, 0.0, 0.05] {
            let mut step = ToCone::new(&cylinder);
            for k in 0..400 {
                let (angle, along) = (0.017 * f64::from(k), 0.01 * f64::from(k % 11) - 0.05);
                let radius = 0.04 + taper * along;
                let p = axis.point + direction * along + (u * angle.cos() + v * angle.sin()) * radius;
                step.add(&p, 1e6);
            }
            let [found, deviation] = step.taper().unwrap();
            assert!((found - taper).abs() < 2e-4, "{taper}: {found}");
            // A thousandth of a unit of noise, over lengths of 0.032 about their mean: 1e-3 / (√400 · 0.032).
            assert!((deviation / 1.58e-3 - 1.0).abs() < 0.05, "{deviation}");
        }
    }
}
