//! Distances of cells from a surface, and the normal equations of its fit, with the widest vector instructions of the
//! machine.
//!
//! As in the sums over points, the sums run in [`LANES`] partial sums, and multiplications and additions are never fused:
//! every machine gets the same bits. The mathematics stands here once, for one cell ([`Scalar`](pulp::Scalar)) and for as
//! many as an instruction takes.

use super::grid::Cell;
use super::surface::{LATERAL_PIXELS, Optics, Surface};
use crate::memory::List;
use nalgebra::{SMatrix, SVector, Vector3};
use pulp::{Arch, Simd, WithSimd};

/// Partial sums that run side by side.
const LANES: usize = 8;

/// The lower half of a symmetric matrix of six columns, six numbers of a vector, and how many cells there are.
const SUMS: usize = 28;

/// Where a point is relative to a surface: signed distance, outward normal, position along the axis.
pub(super) struct PlaceOf<T> {
    pub distance: T,
    pub normal: [T; 3],
    pub along: T,
}

/// The place of a cell with its distance from where the surface is measured, the variance of that, and the share of the
/// bias in it.
pub(super) struct ResidualOf<T> {
    pub place: PlaceOf<T>,
    pub distance: T,
    pub variance: T,
    pub shape: T,
}

#[inline(always)]
fn dot<S: Simd>(simd: S, a: [S::f64s; 3], b: [S::f64s; 3]) -> S::f64s {
    let (x, y, z) = (simd.mul_f64s(a[0], b[0]), simd.mul_f64s(a[1], b[1]), simd.mul_f64s(a[2], b[2]));
    simd.add_f64s(simd.add_f64s(x, y), z)
}

#[inline(always)]
fn splat<S: Simd>(simd: S, v: &Vector3<f64>) -> [S::f64s; 3] {
    [simd.splat_f64s(v.x), simd.splat_f64s(v.y), simd.splat_f64s(v.z)]
}

#[inline(always)]
fn difference<S: Simd>(simd: S, a: [S::f64s; 3], b: [S::f64s; 3]) -> [S::f64s; 3] {
    [simd.sub_f64s(a[0], b[0]), simd.sub_f64s(a[1], b[1]), simd.sub_f64s(a[2], b[2])]
}

/// Where points are relative to a surface.
#[inline(always)]
pub(super) fn place<S: Simd>(simd: S, surface: &Surface, point: [S::f64s; 3]) -> PlaceOf<S::f64s> {
    let (offset, along, radius) = match surface {
        Surface::Cylinder(cylinder, _) | Surface::Cone(cylinder, _) => {
            let taper = if let Surface::Cone(_, taper) = surface { *taper } else { 0.0 };
            let offset = difference(simd, point, splat(simd, &cylinder.axis.point));
            let d = splat(simd, &cylinder.axis.direction);
            let along = dot(simd, offset, d);
            let on_axis =
                [simd.mul_f64s(d[0], along), simd.mul_f64s(d[1], along), simd.mul_f64s(d[2], along)];
            let wider = simd.mul_f64s(simd.splat_f64s(taper), along);
            (difference(simd, offset, on_axis), along, (cylinder.radius, wider))
        }
        Surface::Sphere(center, radius) => {
            let none = simd.splat_f64s(0.0);
            (difference(simd, point, splat(simd, center)), none, (*radius, none))
        }
    };
    let norm = simd.sqrt_f64s(dot(simd, offset, offset));
    let norm = simd.max_f64s(norm, simd.splat_f64s(f64::MIN_POSITIVE));
    let distance = simd.sub_f64s(simd.sub_f64s(norm, simd.splat_f64s(radius.0)), radius.1);
    let normal =
        [simd.div_f64s(offset[0], norm), simd.div_f64s(offset[1], norm), simd.div_f64s(offset[2], norm)];
    PlaceOf { distance, normal, along }
}

/// The residuals of cells with their points, their positions on the plane z = 1 and the standard deviations of their
/// depths.
#[inline(always)]
pub(super) fn residual<S: Simd>(
    simd: S,
    surface: &Surface,
    pixel: f64,
    point: [S::f64s; 3],
    [x, y]: [S::f64s; 2],
    sigma: S::f64s,
) -> ResidualOf<S::f64s> {
    let (zero, one) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
    let place = place(simd, surface, point);
    let ray = [x, y, one];
    let along = dot(simd, place.normal, ray);
    let square = simd.mul_f64s(along, along);
    let length = dot(simd, ray, ray);
    let lateral = simd.mul_f64s(simd.splat_f64s(LATERAL_PIXELS * pixel), point[2]);
    let across = simd.max_f64s(simd.div_f64s(simd.sub_f64s(length, square), length), zero);
    let of_depth = simd.mul_f64s(simd.mul_f64s(square, sigma), sigma);
    let of_lateral = simd.mul_f64s(simd.mul_f64s(lateral, lateral), across);
    let variance = simd.add_f64s(of_depth, of_lateral);
    // How a bias at the limbs shows: the sixth power of the position across, which vanishes in the middle, and is 0.1 at
    // 0.7 radii.
    let (shape, bias) = match surface {
        Surface::Cylinder(cylinder, bias) => {
            let along_axis = dot(simd, ray, splat(simd, &cylinder.axis.direction));
            let flat = simd.sub_f64s(length, simd.mul_f64s(along_axis, along_axis));
            let flat = simd.max_f64s(flat, simd.splat_f64s(f64::MIN_POSITIVE));
            let squared = simd.max_f64s(simd.sub_f64s(one, simd.div_f64s(square, flat)), zero);
            (simd.mul_f64s(simd.mul_f64s(squared, squared), squared), *bias)
        }
        _ => (zero, 0.0),
    };
    let distance = simd.sub_f64s(place.distance, simd.mul_f64s(simd.splat_f64s(bias), shape));
    ResidualOf { place, distance, variance, shape }
}

/// The points of cells, their positions on the plane z = 1 and the standard deviations of their depths, side by side.
#[inline(always)]
#[allow(clippy::needless_range_loop, reason = "closures are not inlined for sure")]
fn side_by_side<'a>(cell: impl Fn(usize) -> &'a Cell) -> [[f64; LANES]; 6] {
    let mut numbers = [[0.0; LANES]; 6];
    for k in 0..LANES {
        let Cell { x, y, point, sigma, .. } = cell(k);
        numbers[0][k] = point.x;
        numbers[1][k] = point.y;
        numbers[2][k] = point.z;
        numbers[3][k] = *x;
        numbers[4][k] = *y;
        numbers[5][k] = *sigma;
    }
    numbers
}

/// The squared distances of the cells `which` from a surface in standard deviations, infinite on the wall that is not seen.
/// They take the place of what is in `misfits`. `pixel` is the side of a pixel on the plane z = 1.
pub(super) fn misfits(
    surface: &Surface,
    pixel: f64,
    cells: &[Cell],
    which: &[usize],
    misfits: &mut Vec<f64>,
) {
    misfits.clear();
    misfits.reserve(which.len());
    // The observer sees the near wall from outside, the far one from inside.
    let inside = surface.contains_origin();
    Arch::new().dispatch(Misfits { surface, pixel, inside, cells, which, misfits });
}

/// One pass over cells for their distances.
struct Misfits<'a> {
    surface: &'a Surface,
    pixel: f64,
    inside: bool,
    cells: &'a [Cell],
    which: &'a [usize],
    misfits: &'a mut Vec<f64>,
}

impl WithSimd for Misfits<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { surface, pixel, inside, cells, which, misfits } = self;
        let (zero, hidden) = (simd.splat_f64s(0.0), simd.splat_f64s(f64::INFINITY));
        for chunk in which.chunks(LANES) {
            // The last one is repeated to the end of the group.
            let last = chunk.len() - 1;
            let [px, py, pz, x, y, sigma] = side_by_side(|k| &cells[chunk[k.min(last)]]);
            let mut squares = [0.0; LANES];
            for part in 0..LANES / S::F64_LANES {
                let point = [lanes(simd, &px, part), lanes(simd, &py, part), lanes(simd, &pz, part)];
                let position = [lanes(simd, &x, part), lanes(simd, &y, part)];
                let sigma = lanes(simd, &sigma, part);
                let residual = residual(simd, surface, pixel, point, position, sigma);
                let distance = residual.distance;
                let square = simd.div_f64s(simd.mul_f64s(distance, distance), residual.variance);
                let from_outside = simd.less_than_f64s(dot(simd, residual.place.normal, point), zero);
                let (near, far) = if inside { (hidden, square) } else { (square, hidden) };
                S::as_mut_simd_f64s(&mut squares).0[part] = simd.select_f64s(from_outside, near, far);
            }
            misfits.extend_from_slice(&squares[..chunk.len()]);
        }
    }
}

/// Cells side by side: points, positions on the plane z = 1, standard deviations of the depths, and 1, or 0 for the rest
/// of the last group.
type Group = [[f64; LANES]; 7];

/// The cells that a surface is fitted to.
pub(super) struct Cells {
    groups: List<Group>,
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
    pub fn new(cells: &[Cell], which: &[usize], optics: Optics) -> Self {
        let group = |which: &[usize]| {
            let [px, py, pz, x, y, sigma] = side_by_side(|k| &cells[*which.get(k).unwrap_or(&which[0])]);
            let given = std::array::from_fn(|k| if k < which.len() { 1.0 } else { 0.0 });
            [px, py, pz, x, y, sigma, given]
        };
        let chunks = which.chunks_exact(LANES);
        // What fills the last group up is a cell, too: of no weight, but with numbers that can be divided by.
        let rest = Some(chunks.remainder()).filter(|rest| !rest.is_empty()).map(group);
        let mut groups = List::with_capacity(which.len().div_ceil(LANES));
        groups.extend(chunks.map(|which| {
            let [px, py, pz, x, y, sigma] = side_by_side(|k| &cells[which[k]]);
            [px, py, pz, x, y, sigma, [1.0; LANES]]
        }));
        groups.extend(rest);
        Self { groups, optics }
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
        let mut matrix = SMatrix::<f64, 6, 6>::zeros();
        let mut sums = sums.into_iter();
        let mut next = || sums.next().unwrap_or_default();
        for i in 0..6 {
            for j in 0..=i {
                matrix[(i, j)] = next();
            }
        }
        // The distance falls where the surface moves outwards.
        let vector = SVector::from_fn(|_, _| -next());
        NormalEquations { matrix, vector, count: next() as usize }
    }
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
        let Self { cells: Cells { groups, optics }, surface, across, reach } = self;
        let (zero, one) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
        let (u, v) = (splat(simd, across.0), splat(simd, across.1));
        let part_of_sample = simd.splat_f64s(1.0 / optics.cells_per_sample);
        let (most, per_most) = (simd.splat_f64s(reach * reach), simd.splat_f64s(1.0 / (reach * reach)));
        let mut sums = [[0.0; LANES]; SUMS];
        for part in 0..LANES / S::F64_LANES {
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
                let ResidualOf { place: PlaceOf { normal, along, .. }, distance, variance, shape } = residual;
                let information = simd.div_f64s(one, variance);
                let square = simd.mul_f64s(simd.mul_f64s(distance, distance), information);
                let given = simd.select_f64s(simd.less_than_or_equal_f64s(square, most), given, zero);
                // Tukey's weight: what is nearly out counts little.
                let left = simd.sub_f64s(one, simd.mul_f64s(square, per_most));
                let weight = simd.mul_f64s(simd.mul_f64s(left, left), information);
                let weight = simd.mul_f64s(simd.mul_f64s(given, part_of_sample), weight);
                let row = match surface {
                    Surface::Sphere(..) => [normal[0], normal[1], normal[2], one, zero, zero],
                    Surface::Cylinder(..) | Surface::Cone(..) => {
                        let (nu, nv) = (dot(simd, normal, u), dot(simd, normal, v));
                        let last = if matches!(surface, Surface::Cone(..)) { along } else { shape };
                        [nu, nv, simd.mul_f64s(nu, along), simd.mul_f64s(nv, along), one, last]
                    }
                };
                let mut k = 0;
                for i in 0..6 {
                    let weighted = simd.mul_f64s(weight, row[i]);
                    for other in &row[..=i] {
                        own[k] = simd.add_f64s(own[k], simd.mul_f64s(weighted, *other));
                        k += 1;
                    }
                }
                let weighted = simd.mul_f64s(weight, distance);
                for part in &row {
                    own[k] = simd.add_f64s(own[k], simd.mul_f64s(weighted, *part));
                    k += 1;
                }
                own[k] = simd.add_f64s(own[k], given);
            }
            for (sum, own) in sums.iter_mut().zip(own) {
                S::as_mut_simd_f64s(sum).0[part] = own;
            }
        }
        sums.map(|sums| sums.iter().sum())
    }
}

/// As many of a group as an instruction takes.
#[inline(always)]
fn lanes<S: Simd>(_simd: S, group: &[f64; LANES], part: usize) -> S::f64s {
    S::as_simd_f64s(group).0[part]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Cylinder, any_orthogonal};

    /// Cells about a cylinder, a group and a part of the next, one of them out of reach.
    fn cells(cylinder: &Cylinder) -> Vec<Cell> {
        let (u, v) = any_orthogonal(&cylinder.axis.direction);
        let cell = |k: usize| {
            let (angle, along) = (0.4 * (k as f64) - 2.0, 0.01 * (k % 5) as f64);
            let off = if k == 6 { 0.1 } else { 0.001 * ((k * k) % 7) as f64 };
            let normal = u * angle.cos() + v * angle.sin();
            let axis = cylinder.axis.point + cylinder.axis.direction * along;
            let point = axis + normal * (cylinder.radius + off);
            let (x, y, w) = (point.x / point.z, point.y / point.z, 1.0 / point.z);
            Cell { x, y, w, point, sigma: 0.002 + 1e-4 * k as f64, fill: 1.0 }
        };
        (0..11).map(cell).collect()
    }

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
                let (place, distance, variance) = surface.residual(cell, optics.pixel);
                let ratio = distance / variance.sqrt();
                if ratio.abs() > reach {
                    continue;
                }
                count += 1;
                let part = 1.0 - (ratio / reach).powi(2);
                let weight = part * part / (variance * optics.cells_per_sample);
                let (n, h) = (place.normal, place.along);
                let row = match surface {
                    Surface::Sphere(..) => SVector::from([-n.x, -n.y, -n.z, -1.0, 0.0, 0.0]),
                    _ => {
                        let (nu, nv) = (n.dot(&u), n.dot(&v));
                        let last = if let Surface::Cylinder(_, bias) = surface {
                            (place.distance - distance) / bias
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
            let found = Cells::new(&cells, &all, optics).normal_equations(&surface, (&u, &v), reach);
            assert_eq!(found.count, count);
            assert!((found.vector - vector).amax() <= 1e-9 * vector.amax(), "{} {vector}", found.vector);
            let difference = (found.matrix - matrix).lower_triangle();
            assert!(difference.amax() <= 1e-9 * matrix.amax(), "{} {matrix}", found.matrix);
        }
    }

    #[test]
    fn misfits_are_those_of_one_cell_after_the_other() {
        let cylinder =
            Cylinder::new(Vector3::new(0.1, -0.05, 0.8), Vector3::new(0.3, 0.9, 0.2), 0.06).unwrap();
        let around = Cylinder::new(Vector3::new(0.0, 0.0, 0.1), Vector3::z(), 0.3).unwrap();
        let (cells, pixel) = (cells(&cylinder), 1.0 / 570.0);
        // More than a group, in any order.
        let which = [4, 0, 7, 10, 2, 1, 3, 9, 8, 5, 4];
        let mut found = vec![1.0; 3];
        for surface in [
            Surface::Cylinder(cylinder, 0.001),
            Surface::Cylinder(around, 0.0),
            Surface::Cone(cylinder, 0.02),
            Surface::Sphere(cylinder.axis.point, 0.065),
        ] {
            let plain = which.map(|k| {
                let (place, distance, variance) = surface.residual(&cells[k], pixel);
                let outside = place.normal.dot(&cells[k].point) < 0.0;
                let seen = outside != surface.contains_origin();
                if seen { distance * distance / variance } else { f64::INFINITY }
            });
            misfits(&surface, pixel, &cells, &which, &mut found);
            assert_eq!(found, plain);
        }
    }
}
