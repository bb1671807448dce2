//! The normal equations of the fit of a surface, with the widest vector instructions of the machine.
//!
//! As in the sums over points, the sums run in [`LANES`] partial sums, and multiplications and additions are never fused:
//! every machine gets the same bits.

use super::distances::{self, LANES, Numbers, ProjectionOf, ResidualOf, dot, gather, lanes, residual, splat};
use super::surface::{Optics, Surface};
use crate::memory::List;
use nalgebra::{SMatrix, SVector, Vector3};
use pulp::{Arch, Simd, WithSimd};

/// The numbers of the lower half of a symmetric matrix of six columns.
const MATRIX: usize = 21;

/// The sums of [`add_products`]: these, and six numbers of a vector.
pub(super) const PRODUCTS: usize = MATRIX + 6;

/// These, and how many cells there are.
const SUMS: usize = PRODUCTS + 1;

/// Cells side by side: points, positions on the plane z = 1, standard deviations of the depths, and 1, or 0 for the rest
/// of the last group.
type Group = distances::Group<7>;

/// The cells that a surface is fitted to.
pub(super) struct Cells {
    groups: List<Group>,
    /// How many there are.
    count: usize,
    optics: Optics,
}

/// The normal equations of one step.
pub(super) struct NormalEquations {
    /// Jᵀ W J with the derivatives J of the distances and the weights W: its lower half.
    pub matrix: SMatrix<f64, 6, 6>,
    /// Jᵀ W d with the distances d.
    pub vector: SVector<f64, 6>,
    /// Cells within reach.
    pub count: usize,
}

impl Cells {
    /// The cells `which`.
    pub fn new(cells: &[Numbers], which: &[usize], optics: Optics) -> Self {
        // What fills the last group up is a cell, too: of no weight, but with numbers that can be divided by.
        let mut groups = List::filled([[0.0; LANES]; 7], which.len().div_ceil(LANES));
        for (group, which) in groups.iter_mut().zip(which.chunks(LANES)) {
            gather(cells, which, group);
            group[6][which.len()..].fill(0.0);
        }
        Self { groups, count: which.len(), optics }
    }

    /// The mean of their points.
    pub fn middle(&self) -> Vector3<f64> {
        // Four sums side by side: none waits for another.
        let mut sums = [[0.0; 4]; 3];
        let (whole, rest) = self.groups.split_at(self.count / LANES);
        for [x, y, z, ..] in whole {
            for (sums, axis) in sums.iter_mut().zip([x, y, z]) {
                for k in 0..LANES {
                    sums[k % 4] += f64::from(axis[k]);
                }
            }
        }
        for [x, y, z, ..] in rest {
            for (sums, axis) in sums.iter_mut().zip([x, y, z]) {
                for k in 0..self.count % LANES {
                    sums[k % 4] += f64::from(axis[k]);
                }
            }
        }
        Vector3::from(sums.map(|sums| sums.iter().sum())) / self.count as f64
    }

    /// The normal equations at a surface, with Tukey's weights: cells beyond `reach` standard deviations do not count.
    /// `across` are the directions in which it shifts and tilts.
    pub fn normal_equations(
        &self,
        surface: &Surface,
        across: (&Vector3<f64>, &Vector3<f64>),
        reach: f64,
    ) -> NormalEquations {
        let sums = Arch::new().dispatch(Pass { cells: self, surface, across, reach });
        let (matrix, vector) = of_products(&sums);
        NormalEquations { matrix, vector, count: sums[PRODUCTS] as usize }
    }
}

/// Adds the products of the numbers of a row, six at most, with each other, the lower half, and with the distance, all times a
/// weight.
#[inline(always)]
pub(super) fn add_products<S: Simd>(
    simd: S,
    sums: &mut [S::f32s],
    row: &[S::f32s],
    weight: S::f32s,
    distance: S::f32s,
) {
    let mut k = 0;
    for i in 0..row.len() {
        let weighted = simd.mul_f32s(weight, row[i]);
        for other in &row[..=i] {
            sums[k] = simd.add_f32s(sums[k], simd.mul_f32s(weighted, *other));
            k += 1;
        }
    }
    let weighted = simd.mul_f32s(weight, distance);
    for (sum, part) in sums[MATRIX..].iter_mut().zip(row) {
        *sum = simd.add_f32s(*sum, simd.mul_f32s(weighted, *part));
    }
}

/// The sums of what the lanes hold, halves of them side by side.
#[inline(always)]
pub(super) fn sums_of_lanes<const COUNT: usize>(sums: &[[f32; LANES]; COUNT]) -> [f64; COUNT] {
    let mut found = [0.0; COUNT];
    for (found, sums) in found.iter_mut().zip(sums) {
        let mut half = [0.0; LANES / 2];
        for k in 0..LANES / 2 {
            half[k] = sums[k] + sums[k + LANES / 2];
        }
        let mut quarter = [0.0; LANES / 4];
        for k in 0..LANES / 4 {
            quarter[k] = half[k] + half[k + LANES / 4];
        }
        *found = f64::from((quarter[0] + quarter[2]) + (quarter[1] + quarter[3]));
    }
    found
}

/// The lower half of Jᵀ W J and Jᵀ W d of these sums. The distance falls where the surface moves outwards.
pub(super) fn of_products(sums: &[f64]) -> (SMatrix<f64, 6, 6>, SVector<f64, 6>) {
    let mut sums = sums.iter();
    let mut next = || sums.next().copied().unwrap_or_default();
    let mut matrix = SMatrix::zeros();
    for i in 0..6 {
        for j in 0..=i {
            matrix[(i, j)] = next();
        }
    }
    (matrix, SVector::from_fn(|_, _| -next()))
}

/// One pass over the cells.
struct Pass<'a> {
    cells: &'a Cells,
    surface: &'a Surface,
    across: (&'a Vector3<f64>, &'a Vector3<f64>),
    reach: f64,
}

impl WithSimd for Pass<'_> {
    type Output = [f64; SUMS];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [f64; SUMS] {
        // A loop of its own for each kind of surface: within it nothing asks which one it is.
        match *self.surface {
            Surface::Cylinder(cylinder, bias) => self.sums(simd, &Surface::Cylinder(cylinder, bias)),
            Surface::Cone(cylinder, taper) => self.sums(simd, &Surface::Cone(cylinder, taper)),
            Surface::Sphere(center, radius) => self.sums(simd, &Surface::Sphere(center, radius)),
        }
    }
}

impl Pass<'_> {
    /// The sums over the cells.
    #[inline(always)]
    fn sums<S: Simd>(&self, simd: S, surface: &Surface) -> [f64; SUMS] {
        let Self { cells: Cells { groups, optics, .. }, across, reach, .. } = *self;
        let (zero, one) = (simd.splat_f32s(0.0), simd.splat_f32s(1.0));
        let (u, v) = (splat(simd, across.0), splat(simd, across.1));
        let part_of_sample = simd.splat_f32s((1.0 / optics.cells_per_sample) as f32);
        let (most, per_most) =
            (simd.splat_f32s((reach * reach) as f32), simd.splat_f32s((1.0 / (reach * reach)) as f32));
        let mut sums = [[0.0; LANES]; SUMS];
        for part in 0..LANES / S::F32_LANES {
            let mut own = [zero; SUMS];
            for group in groups {
                let [px, py, pz, x, y, sigma, given] = [
                    lanes(simd, &group[0], part),
                    lanes(simd, &group[1], part),
                    lanes(simd, &group[2], part),
                    lanes(simd, &group[3], part),
                    lanes(simd, &group[4], part),
                    lanes(simd, &group[5], part),
                    lanes(simd, &group[6], part),
                ];
                let residual = residual(simd, surface, optics.pixel, [px, py, pz], [x, y], sigma);
                let ResidualOf {
                    projection: ProjectionOf { normal, along, .. },
                    distance,
                    information,
                    shape,
                } = residual;
                let square = simd.mul_f32s(simd.mul_f32s(distance, distance), information);
                let given = simd.select_f32s(simd.less_than_or_equal_f32s(square, most), given, zero);
                // Tukey's weight: what is nearly out counts little.
                let left = simd.sub_f32s(one, simd.mul_f32s(square, per_most));
                let weight = simd.mul_f32s(simd.mul_f32s(left, left), information);
                let weight = simd.mul_f32s(simd.mul_f32s(given, part_of_sample), weight);
                match surface {
                    Surface::Sphere(..) => {
                        let row = [normal[0], normal[1], normal[2], one];
                        add_products(simd, &mut own, &row, weight, distance);
                    }
                    Surface::Cylinder(..) | Surface::Cone(..) => {
                        let (nu, nv) = (dot(simd, normal, u), dot(simd, normal, v));
                        let last = if matches!(surface, Surface::Cone(..)) { along } else { shape };
                        let row = [nu, nv, simd.mul_f32s(nu, along), simd.mul_f32s(nv, along), one, last];
                        add_products(simd, &mut own, &row, weight, distance);
                    }
                }
                own[PRODUCTS] = simd.add_f32s(own[PRODUCTS], given);
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
    use crate::detection::distances::numbers;
    use crate::detection::distances::tests::{cells, residual_of};
    use crate::geometry::{Cylinder, any_orthogonal};

    #[test]
    fn sums_are_those_of_one_cell_after_the_other() {
        let cylinder =
            Cylinder::new(Vector3::new(0.1, -0.05, 0.8), Vector3::new(0.3, 0.9, 0.2), 0.06).unwrap();
        let cells = cells(&cylinder);
        let optics = Optics { pixel: 1.0 / 570.0, cells_per_sample: 2.0 };
        let reach = 3.0;
        let (u, v) = any_orthogonal(&cylinder.axis.direction);
        for surface in [
            Surface::Cylinder(cylinder, 0.001),
            Surface::Cone(cylinder, 0.02),
            Surface::Sphere(cylinder.axis.point, 0.065),
        ] {
            let (mut matrix, mut vector) = (SMatrix::<f64, 6, 6>::zeros(), SVector::<f64, 6>::zeros());
            let mut count = 0;
            for cell in &cells {
                let (projection, distance, information) = residual_of(&surface, cell, optics.pixel);
                let ratio = distance * information.sqrt();
                if ratio.abs() > reach {
                    continue;
                }
                count += 1;
                let part = 1.0 - (ratio / reach).powi(2);
                let weight = part * part * information / optics.cells_per_sample;
                let (n, h) = (projection.normal, projection.along);
                let row = match surface {
                    Surface::Sphere(..) => SVector::from([-n.x, -n.y, -n.z, -1.0, 0.0, 0.0]),
                    _ => {
                        let (nu, nv) = (n.dot(&u), n.dot(&v));
                        let last = if let Surface::Cylinder(_, bias) = surface {
                            (projection.distance - distance) / bias
                        } else {
                            h
                        };
                        -SVector::from([nu, nv, nu * h, nv * h, 1.0, last])
                    }
                };
                matrix += row * row.transpose() * weight;
                vector += row * (weight * distance);
            }
            assert!(count > 2 && count < cells.len(), "{count}");
            let all: Vec<usize> = (0..cells.len()).collect();
            let found =
                Cells::new(&numbers(&cells), &all, optics).normal_equations(&surface, (&u, &v), reach);
            assert_eq!(found.count, count);
            assert!((found.vector - vector).amax() <= 1e-5 * vector.amax(), "{} {vector}", found.vector);
            let difference = (found.matrix - matrix).lower_triangle();
            assert!(difference.amax() <= 1e-5 * matrix.amax(), "{} {matrix}", found.matrix);
        }
    }
}
