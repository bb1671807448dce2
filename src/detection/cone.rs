//! Whether the radius of a body changes along its axis: what tapers is no cylinder.

use super::distances::{LANES, ProjectionOf, dot, lanes, project, splat};
use super::normal_equations::{PRODUCTS, add_products, of_products, sums_of_lanes};
use super::surface::{Projection, Surface};
use crate::geometry::{Cylinder, Line, any_orthogonal};
use crate::memory::List;
use nalgebra::{SMatrix, SVector, Vector3};
use pulp::{Arch, Simd, WithSimd};

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

    /// A projection onto the surface and its distance, how that changes with the bias, and the inverse of its variance.
    pub fn add(&mut self, projection: &Projection, distance: f64, shape: f64, weight: f64) {
        let [nu, nv] = self.across.map(|direction| projection.normal.dot(&direction));
        // Tilts and slopes in radii: all numbers are lengths.
        let along = projection.along / self.radius;
        let row = SVector::from([-nu, -nv, -nu * along, -nv * along, -1.0, -shape, -along]);
        self.matrix += row * row.transpose() * weight;
        self.vector += row * (weight * distance);
    }

    /// The same for projections with these sums of [`Pass`].
    fn add_sums(&mut self, sums: [f64; PRODUCTS]) {
        let (matrix, vector) = of_products(&sums);
        for (i, row) in INDICES.into_iter().enumerate() {
            for (j, column) in INDICES.into_iter().enumerate() {
                self.matrix[(row, column)] += matrix[(i.max(j), i.min(j))];
            }
            self.vector[row] += vector[i];
        }
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

/// By how much the radius of a cylinder seems to grow along its axis, and the standard deviation of that, by points about its
/// surface, each with this `weight` where it is on it and with Tukey's within `reach` of it, and by `others` on it, each with the
/// inverse of its variance.
pub(crate) fn slope_by_points(
    cylinder: &Cylinder,
    points: impl Iterator<Item = Vector3<f64>>,
    (weight, reach): (f64, f64),
    others: impl Iterator<Item = (Vector3<f64>, f64)>,
) -> Option<[f64; 2]> {
    // In units of the radius: single precision may not hold the squares of lengths in the caller's unit.
    let unit = cylinder.radius;
    let axis = Line { point: cylinder.axis.point / unit, ..cylinder.axis };
    let cylinder = &Cylinder { axis, radius: 1.0 };
    let (weight, reach) = (weight * unit * unit, reach / unit);
    let surface = Surface::Cylinder(*cylinder, 0.0);
    let mut step = ToCone::new(cylinder);
    let mut groups: List<Group> = List::new();
    for (k, point) in points.enumerate() {
        let point = point / unit;
        let [x, y, z, weight] = [point.x, point.y, point.z, weight].map(|number| number as f32);
        if k % LANES == 0 {
            groups.push([[x; LANES], [y; LANES], [z; LANES], [0.0; LANES]]);
        }
        let last = groups.len() - 1;
        let numbers = [x, y, z, weight];
        groups[last].iter_mut().zip(numbers).for_each(|(group, number)| group[k % LANES] = number);
    }
    step.add_sums(Arch::new().dispatch(Pass { groups: &groups, surface, across: &step.across, reach }));
    for (point, weight) in others {
        let projection = surface.project(&(point / unit));
        step.add(&projection, projection.distance, 0.0, weight * unit * unit);
    }
    // These points have no bias.
    step.expect(0.0, cylinder.radius);
    step.slope()
}

/// Points side by side: their coordinates and weights, 0 for the rest of the last group.
type Group = [[f32; LANES]; 4];

/// The indices of the numbers of [`Pass`] in a row of the step; there is no bias.
const INDICES: [usize; 6] = [0, 1, 2, 3, 4, 6];

/// One pass over points, with the widest vector instructions of the machine. The sums run in [`LANES`] partial sums.
struct Pass<'a> {
    groups: &'a [Group],
    surface: Surface,
    across: &'a [Vector3<f64>; 2],
    reach: f64,
}

impl WithSimd for Pass<'_> {
    type Output = [f64; PRODUCTS];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [f64; PRODUCTS] {
        let Self { groups, surface, across: [u, v], reach } = self;
        let (zero, one) = (simd.splat_f32s(0.0), simd.splat_f32s(1.0));
        let (u, v) = (splat(simd, u), splat(simd, v));
        let (per_reach, per_radius) =
            (simd.splat_f32s((1.0 / reach) as f32), simd.splat_f32s((1.0 / surface.radius()) as f32));
        let mut sums = [[0.0; LANES]; PRODUCTS];
        for part in 0..LANES / S::F32_LANES {
            let mut own = [zero; PRODUCTS];
            for [x, y, z, weight] in groups {
                let point = [lanes(simd, x, part), lanes(simd, y, part), lanes(simd, z, part)];
                let ProjectionOf { distance, normal, along } = project(simd, &surface, point);
                let ratio = simd.mul_f32s(distance, per_reach);
                let left = simd.max_f32s(simd.sub_f32s(one, simd.mul_f32s(ratio, ratio)), zero);
                let weight = simd.mul_f32s(lanes(simd, weight, part), simd.mul_f32s(left, left));
                let (nu, nv) = (dot(simd, normal, u), dot(simd, normal, v));
                // Tilts and slopes in radii: all numbers are lengths.
                let along = simd.mul_f32s(along, per_radius);
                let row = [nu, nv, simd.mul_f32s(nu, along), simd.mul_f32s(nv, along), one, along];
                add_products(simd, &mut own, &row, weight, distance);
            }
            for (sum, own) in sums.iter_mut().zip(own) {
                S::as_mut_simd_f32s(sum).0[part] = own;
            }
        }
        sums_of_lanes(&sums)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
                axis.point + direction * along + (u * angle.cos() + v * angle.sin()) * radius
            });
            let points: Vec<_> = points.collect();
            // Side by side or one by one.
            for some in [400, 203, 0] {
                let (first, others) = points.split_at(some);
                let others = others.iter().map(|point| (*point, 1e6));
                let found = slope_by_points(&cylinder, first.iter().copied(), (1e6, f64::INFINITY), others);
                let [found, deviation] = found.unwrap();
                assert!((found - slope).abs() < 2e-4, "{slope}: {found}");
                // A thousandth of a unit of noise, over lengths of 0.032 about their mean: 1e-3 / (√400 · 0.032).
                assert!((deviation / 1.58e-3 - 1.0).abs() < 0.05, "{deviation}");
            }
        }
    }

    #[test]
    fn the_unit_of_length_does_not_matter() {
        let direction = Vector3::y();
        let slope_in = |unit: f64| {
            let axis = Line { point: Vector3::new(0.02, 0.0, 0.8) * unit, direction };
            let points = (0..400).map(|k| {
                let (angle, along) = (0.017 * f64::from(k), 0.01 * f64::from(k % 11) - 0.05);
                let radius = 0.04 + 0.03 * along;
                axis.point + Vector3::new(radius * angle.cos(), along, radius * angle.sin()) * unit
            });
            let precision = (0.001 * unit).powi(-2);
            let cylinder = Cylinder { axis, radius: 0.04 * unit };
            slope_by_points(&cylinder, points, (precision, 0.02 * unit), std::iter::empty()).unwrap()
        };
        let [slope, deviation] = slope_in(1.0);
        for unit in [1e3, 1e25, 1e-25] {
            let [other, its_deviation] = slope_in(unit);
            assert!((other - slope).abs() < 1e-5 && (its_deviation / deviation - 1.0).abs() < 1e-4, "{unit}");
        }
    }

    #[test]
    fn no_points_tell_no_slope() {
        let axis = Line { point: Vector3::new(0.0, 0.0, 0.8), direction: Vector3::y() };
        let cylinder = Cylinder { axis, radius: 0.04 };
        let nothing = slope_by_points(&cylinder, std::iter::empty(), (1.0, 1.0), std::iter::empty());
        assert_eq!(nothing, None);
    }
}
