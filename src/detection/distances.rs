//! Distances of cells from a surface and their positions about a cylinder, with the widest vector instructions of the machine.
//!
//! The mathematics stands here once, for one cell ([`Scalar`](pulp::Scalar)) and for as many as an instruction takes.
//! Multiplications and additions are never fused: every machine gets the same bits. The numbers have 32 bits, so that an
//! instruction takes twice as many: they tell a position to a ten-millionth of its distance, and depth is measured to a thousandth.

use super::grid::Cell;
use super::surface::{LATERAL_PIXELS, Surface};
use crate::geometry::Cylinder;
use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};

/// Products of two that are no less are no 0.
const LEAST: f32 = 1e-37;

/// Numbers side by side.
pub(super) const LANES: usize = 16;

/// Where a point is relative to a surface: signed distance, outward normal, position along the axis.
pub(super) struct ProjectionOf<T> {
    pub distance: T,
    pub normal: [T; 3],
    pub along: T,
}

/// The projection of a cell with its distance from where the surface is measured, one over the variance of that, and the share of
/// the bias in it.
pub(super) struct ResidualOf<T> {
    pub projection: ProjectionOf<T>,
    pub distance: T,
    pub information: T,
    pub shape: T,
}

#[inline(always)]
pub(super) fn dot<S: Simd>(simd: S, a: [S::f32s; 3], b: [S::f32s; 3]) -> S::f32s {
    let (x, y, z) = (simd.mul_f32s(a[0], b[0]), simd.mul_f32s(a[1], b[1]), simd.mul_f32s(a[2], b[2]));
    simd.add_f32s(simd.add_f32s(x, y), z)
}

#[inline(always)]
pub(super) fn cross<S: Simd>(simd: S, a: [S::f32s; 3], b: [S::f32s; 3]) -> [S::f32s; 3] {
    [
        simd.sub_f32s(simd.mul_f32s(a[1], b[2]), simd.mul_f32s(a[2], b[1])),
        simd.sub_f32s(simd.mul_f32s(a[2], b[0]), simd.mul_f32s(a[0], b[2])),
        simd.sub_f32s(simd.mul_f32s(a[0], b[1]), simd.mul_f32s(a[1], b[0])),
    ]
}

#[inline(always)]
pub(super) fn splat<S: Simd>(simd: S, v: &Vector3<f64>) -> [S::f32s; 3] {
    v.map(|number| number as f32).data.0[0].map(|number| simd.splat_f32s(number))
}

#[inline(always)]
pub(super) fn difference<S: Simd>(simd: S, a: [S::f32s; 3], b: [S::f32s; 3]) -> [S::f32s; 3] {
    [simd.sub_f32s(a[0], b[0]), simd.sub_f32s(a[1], b[1]), simd.sub_f32s(a[2], b[2])]
}

#[inline(always)]
pub(super) fn times<S: Simd>(simd: S, a: [S::f32s; 3], factor: S::f32s) -> [S::f32s; 3] {
    [simd.mul_f32s(a[0], factor), simd.mul_f32s(a[1], factor), simd.mul_f32s(a[2], factor)]
}

/// The parts of rays across a direction.
#[inline(always)]
pub(super) fn across<S: Simd>(simd: S, ray: [S::f32s; 3], d: [S::f32s; 3]) -> [S::f32s; 3] {
    difference(simd, ray, times(simd, d, dot(simd, ray, d)))
}

/// Where along rays they first meet a cylinder in front of the observer, 0 where they do not:
/// [`Cylinder::first_hit`], side by side.
#[inline(always)]
pub(super) fn first_hits<S: Simd>(simd: S, cylinder: &Cylinder, ray: [S::f32s; 3]) -> S::f32s {
    let zero = simd.splat_f32s(0.0);
    let nearest = cylinder.axis.nearest_to_origin();
    let product = simd.splat_f32s((nearest.norm_squared() - cylinder.radius * cylinder.radius) as f32);
    let (c, radius) = (splat(simd, &nearest), simd.splat_f32s(cylinder.radius as f32));
    let across = across(simd, ray, splat(simd, &cylinder.axis.direction));
    let (a, b) = (dot(simd, across, across), dot(simd, across, c));
    let moment = cross(simd, across, c);
    let discriminant =
        simd.sub_f32s(simd.mul_f32s(simd.mul_f32s(a, radius), radius), dot(simd, moment, moment));
    let root = simd.sqrt_f32s(simd.max_f32s(discriminant, zero));
    let behind = simd.less_than_f32s(b, zero);
    let large = simd.select_f32s(behind, simd.sub_f32s(b, root), simd.add_f32s(b, root));
    let (one, other) = (simd.div_f32s(large, a), simd.div_f32s(product, large));
    // Both are 0 where the larger one is.
    let other = simd.select_f32s(simd.equal_f32s(large, zero), zero, other);
    let (near, far) = (simd.min_f32s(one, other), simd.max_f32s(one, other));
    let first = simd.select_f32s(simd.greater_than_f32s(near, zero), near, far);
    let first = simd.select_f32s(simd.greater_than_f32s(first, zero), first, zero);
    simd.select_f32s(simd.less_than_f32s(discriminant, zero), zero, first)
}

/// Where points are relative to a surface.
#[inline(always)]
pub(super) fn project<S: Simd>(simd: S, surface: &Surface, point: [S::f32s; 3]) -> ProjectionOf<S::f32s> {
    let (offset, along, radius) = match surface {
        Surface::Cylinder(cylinder, _) | Surface::Cone(cylinder, _) => {
            let taper = if let Surface::Cone(_, taper) = surface { *taper } else { 0.0 };
            let offset = difference(simd, point, splat(simd, &cylinder.axis.point));
            let d = splat(simd, &cylinder.axis.direction);
            let along = dot(simd, offset, d);
            let on_axis = times(simd, d, along);
            let wider = simd.mul_f32s(simd.splat_f32s(taper as f32), along);
            (difference(simd, offset, on_axis), along, (cylinder.radius, wider))
        }
        Surface::Sphere(center, radius) => {
            let none = simd.splat_f32s(0.0);
            (difference(simd, point, splat(simd, center)), none, (*radius, none))
        }
    };
    let norm = simd.sqrt_f32s(dot(simd, offset, offset));
    let norm = simd.max_f32s(norm, simd.splat_f32s(f32::MIN_POSITIVE));
    let distance = simd.sub_f32s(simd.sub_f32s(norm, simd.splat_f32s(radius.0 as f32)), radius.1);
    // One division takes as long as many products.
    let normal = times(simd, offset, simd.div_f32s(simd.splat_f32s(1.0), norm));
    ProjectionOf { distance, normal, along }
}

/// The residuals of cells with their points, their positions on the plane z = 1 and the standard deviations of their
/// depths.
#[inline(always)]
pub(super) fn residual<S: Simd>(
    simd: S,
    surface: &Surface,
    pixel: f64,
    point: [S::f32s; 3],
    [x, y]: [S::f32s; 2],
    sigma: S::f32s,
) -> ResidualOf<S::f32s> {
    let (zero, one) = (simd.splat_f32s(0.0), simd.splat_f32s(1.0));
    let projection = project(simd, surface, point);
    let ray = [x, y, one];
    let along = dot(simd, projection.normal, ray);
    let square = simd.mul_f32s(along, along);
    let length = dot(simd, ray, ray);
    let lateral = simd.mul_f32s(simd.splat_f32s((LATERAL_PIXELS.get() * pixel) as f32), point[2]);
    let across = simd.max_f32s(simd.sub_f32s(length, square), zero);
    let of_depth = simd.mul_f32s(simd.mul_f32s(square, sigma), sigma);
    let of_lateral = simd.mul_f32s(simd.mul_f32s(lateral, lateral), across);
    // The variance times the squared length of the ray.
    let variance = simd.add_f32s(simd.mul_f32s(of_depth, length), of_lateral);
    let variance = simd.max_f32s(variance, simd.splat_f32s(LEAST));
    // How a bias at the limbs shows: the sixth power of the position across, which vanishes in the middle, and is 0.1 at
    // 0.7 radii.
    let (information, shape, bias) = match surface {
        Surface::Cylinder(cylinder, bias) => {
            let along_axis = dot(simd, ray, splat(simd, &cylinder.axis.direction));
            let flat = simd.sub_f32s(length, simd.mul_f32s(along_axis, along_axis));
            let flat = simd.max_f32s(flat, simd.splat_f32s(LEAST));
            // One division takes as long as many products.
            let inverse = simd.div_f32s(one, simd.mul_f32s(variance, flat));
            let across = simd.mul_f32s(simd.mul_f32s(square, variance), inverse);
            let squared = simd.max_f32s(simd.sub_f32s(one, across), zero);
            let shape = simd.mul_f32s(simd.mul_f32s(squared, squared), squared);
            (simd.mul_f32s(simd.mul_f32s(length, flat), inverse), shape, *bias)
        }
        _ => (simd.div_f32s(length, variance), zero, 0.0),
    };
    let distance = simd.sub_f32s(projection.distance, simd.mul_f32s(simd.splat_f32s(bias as f32), shape));
    ResidualOf { projection, distance, information, shape }
}

/// What is asked of a cell again and again, in half of its memory: its point, its position on the plane z = 1, the standard
/// deviation of its depth, and 1.
#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
pub(super) struct Numbers([f32; 8]);

/// Those of all cells.
pub(super) fn numbers(cells: &[Cell]) -> Vec<Numbers> {
    let numbers = |Cell { x, y, point, sigma, .. }: &Cell| {
        Numbers([point.x, point.y, point.z, *x, *y, *sigma, 1.0, 0.0].map(|number| number as f32))
    };
    cells.iter().map(numbers).collect()
}

/// So many of the [`Numbers`] of some cells, side by side.
pub(super) type Group<const COUNT: usize> = [[f32; LANES]; COUNT];

/// Puts cells side by side; the last one is repeated to the end of the group.
#[inline(always)]
pub(super) fn gather<const COUNT: usize>(cells: &[Numbers], which: &[usize], group: &mut Group<COUNT>) {
    // Of a full group nothing is asked.
    match which.first_chunk::<LANES>() {
        Some(which) => gather_each(|k| &cells[which[k]], group),
        None => gather_each(|k| &cells[which[k.min(which.len() - 1)]], group),
    }
}

/// The same of the cells by their indices in the group.
#[inline(always)]
#[allow(clippy::needless_range_loop, reason = "closures are not inlined for sure")]
fn gather_each<'a, const COUNT: usize>(cell: impl Fn(usize) -> &'a Numbers, group: &mut Group<COUNT>) {
    for k in 0..LANES {
        let Numbers(own) = cell(k);
        for i in 0..COUNT {
            group[i][k] = own[i];
        }
    }
}

/// The squared distances of the cells `which` from a surface in standard deviations, infinite on the wall that is not seen.
/// They take the place of what is in `misfits`. `pixel` is the side of a pixel on the plane z = 1.
pub(super) fn misfits(
    surface: &Surface,
    pixel: f64,
    cells: &[Numbers],
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
    cells: &'a [Numbers],
    which: &'a [usize],
    misfits: &'a mut Vec<f64>,
}

impl WithSimd for Misfits<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { surface, pixel, inside, cells, which, misfits } = self;
        let (zero, hidden) = (simd.splat_f32s(0.0), simd.splat_f32s(f32::INFINITY));
        for chunk in which.chunks(LANES) {
            let mut group = [[0.0; LANES]; 6];
            gather(cells, chunk, &mut group);
            let [px, py, pz, x, y, sigma] = &group;
            let mut squares = [0.0; LANES];
            for part in 0..LANES / S::F32_LANES {
                let point = [lanes(simd, px, part), lanes(simd, py, part), lanes(simd, pz, part)];
                let position = [lanes(simd, x, part), lanes(simd, y, part)];
                let sigma = lanes(simd, sigma, part);
                let residual = residual(simd, surface, pixel, point, position, sigma);
                let distance = residual.distance;
                let square = simd.mul_f32s(simd.mul_f32s(distance, distance), residual.information);
                let from_outside = simd.less_than_f32s(dot(simd, residual.projection.normal, point), zero);
                let (near, far) = if inside { (hidden, square) } else { (square, hidden) };
                S::as_mut_simd_f32s(&mut squares).0[part] = simd.select_f32s(from_outside, near, far);
            }
            misfits.extend_from_slice(&squares.map(f64::from)[..chunk.len()]);
        }
    }
}

/// Where the rays of the cells `which` pass a cylinder across its axis, as by [`passes`](super::rays::passes) but not a number
/// for rays along it, and where their points lie along it. Both take the place of what is in the lists.
pub(super) fn across_and_along(
    cylinder: &Cylinder,
    cells: &[Numbers],
    which: &[usize],
    across: &mut Vec<f64>,
    along: &mut Vec<f64>,
) {
    across.clear();
    along.clear();
    across.reserve(which.len());
    along.reserve(which.len());
    Arch::new().dispatch(AcrossAndAlong { cylinder, cells, which, across, along });
}

/// One pass over cells for their positions.
struct AcrossAndAlong<'a> {
    cylinder: &'a Cylinder,
    cells: &'a [Numbers],
    which: &'a [usize],
    across: &'a mut Vec<f64>,
    along: &'a mut Vec<f64>,
}

impl WithSimd for AcrossAndAlong<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { cylinder, cells, which, across, along } = self;
        let (point, direction) = (splat(simd, &cylinder.axis.point), splat(simd, &cylinder.axis.direction));
        let (radius, one) = (simd.splat_f32s(cylinder.radius as f32), simd.splat_f32s(1.0));
        let (least, none) = (simd.splat_f32s(1e-9), simd.splat_f32s(f32::NAN));
        for chunk in which.chunks(LANES) {
            let mut group = [[0.0; LANES]; 5];
            gather(cells, chunk, &mut group);
            let [px, py, pz, x, y] = &group;
            let mut found = [[0.0; LANES]; 2];
            for part in 0..LANES / S::F32_LANES {
                let position = [lanes(simd, px, part), lanes(simd, py, part), lanes(simd, pz, part)];
                let ray = [lanes(simd, x, part), lanes(simd, y, part), one];
                let normal = cross(simd, ray, direction);
                let norm = simd.sqrt_f32s(dot(simd, normal, normal));
                let passing = simd.div_f32s(dot(simd, normal, point), simd.mul_f32s(norm, radius));
                let passing = simd.select_f32s(simd.less_than_f32s(norm, least), none, passing);
                S::as_mut_simd_f32s(&mut found[0]).0[part] = passing;
                let offset = difference(simd, position, point);
                S::as_mut_simd_f32s(&mut found[1]).0[part] = dot(simd, offset, direction);
            }
            across.extend_from_slice(&found[0].map(f64::from)[..chunk.len()]);
            along.extend_from_slice(&found[1].map(f64::from)[..chunk.len()]);
        }
    }
}

/// What a cell sees where its ray meets a cylinder.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sight {
    /// How far behind the surface it lies, across that.
    pub behind: f64,
    /// One over the variance of that.
    pub information: f64,
    /// Where the ray meets the cylinder along the axis; infinite where it does not.
    pub along: f64,
}

/// What the cells `which` see at a cylinder, in place of what is in the list. `pixel` is the side of a pixel on the plane z = 1.
pub(super) fn sights(
    (surface, cylinder): (&Surface, &Cylinder),
    pixel: f64,
    cells: &[Numbers],
    which: &[usize],
    sights: &mut Vec<Sight>,
) {
    sights.clear();
    sights.reserve(which.len());
    Arch::new().dispatch(Sights { surface, cylinder, pixel, cells, which, sights });
}

/// One pass over cells for what they see.
struct Sights<'a> {
    surface: &'a Surface,
    cylinder: &'a Cylinder,
    pixel: f64,
    cells: &'a [Numbers],
    which: &'a [usize],
    sights: &'a mut Vec<Sight>,
}

impl WithSimd for Sights<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { surface, cylinder, pixel, cells, which, sights } = self;
        let (zero, one) = (simd.splat_f32s(0.0), simd.splat_f32s(1.0));
        let none = simd.splat_f32s(f32::INFINITY);
        let (point, direction) = (splat(simd, &cylinder.axis.point), splat(simd, &cylinder.axis.direction));
        for chunk in which.chunks(LANES) {
            let mut group = [[0.0; LANES]; 6];
            gather(cells, chunk, &mut group);
            let [_, _, depth, x, y, sigma] = &group;
            let mut found = [[0.0; LANES]; 3];
            for part in 0..LANES / S::F32_LANES {
                let (x, y) = (lanes(simd, x, part), lanes(simd, y, part));
                let (depth, sigma) = (lanes(simd, depth, part), lanes(simd, sigma, part));
                let ray = [x, y, one];
                let t = first_hits(simd, cylinder, ray);
                let hit = times(simd, ray, t);
                let along = dot(simd, difference(simd, hit, point), direction);
                let along = simd.select_f32s(simd.greater_than_f32s(t, zero), along, none);
                let residual = residual(simd, surface, pixel, hit, [x, y], sigma);
                let facing = simd.abs_f32s(dot(simd, residual.projection.normal, ray));
                let behind = simd.mul_f32s(simd.sub_f32s(depth, hit[2]), facing);
                S::as_mut_simd_f32s(&mut found[0]).0[part] = behind;
                S::as_mut_simd_f32s(&mut found[1]).0[part] = residual.information;
                S::as_mut_simd_f32s(&mut found[2]).0[part] = along;
            }
            let [behind, information, along] = found.map(|numbers| numbers.map(f64::from));
            let found = behind.into_iter().zip(information).zip(along);
            for ((behind, information), along) in found.take(chunk.len()) {
                sights.push(Sight { behind, information, along });
            }
        }
    }
}

/// As many of a group as an instruction takes.
#[inline(always)]
pub(super) fn lanes<S: Simd>(_simd: S, group: &[f32; LANES], part: usize) -> S::f32s {
    S::as_simd_f32s(group).0[part]
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::rays::passes;
    use super::super::surface::Projection;
    use super::*;
    use crate::geometry::any_orthogonal;
    use pulp::Scalar;

    /// The projection of a cell, its distance from where the surface is measured, and one over the variance of that.
    pub fn residual_of(surface: &Surface, cell: &Cell, pixel: f64) -> (Projection, f64, f64) {
        let [x, y, sigma] = [cell.x, cell.y, cell.sigma].map(|number| number as f32);
        let point = cell.point.map(|number| number as f32).into();
        let residual = residual(Scalar, surface, pixel, point, [x, y], sigma);
        (residual.projection.into(), residual.distance.into(), residual.information.into())
    }

    /// Cells about a cylinder, a group and a part of the next, one of them out of reach.
    pub fn cells(cylinder: &Cylinder) -> Vec<Cell> {
        let (u, v) = any_orthogonal(&cylinder.axis.direction);
        let cell = |k: usize| {
            let (angle, along) = (0.4 * (k as f64) - 2.0, 0.01 * (k % 5) as f64);
            let off = if k == 6 { 0.1 } else { 0.001 * ((k * k) % 7) as f64 };
            let normal = u * angle.cos() + v * angle.sin();
            let axis = cylinder.axis.at(along);
            let point = axis + normal * (cylinder.radius + off);
            let (x, y, w) = (point.x / point.z, point.y / point.z, 1.0 / point.z);
            Cell { x, y, w, point, sigma: 0.002 + 1e-4 * k as f64, fill: 1.0 }
        };
        (0..11).map(cell).collect()
    }

    /// Whether numbers of 32 bits may be one.
    fn alike(a: f64, b: f64) -> bool {
        a == b || (a - b).abs() <= 1e-4 * b.abs() + 1e-6
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
                let (projection, distance, information) = residual_of(&surface, &cells[k], pixel);
                let outside = projection.normal.dot(&cells[k].point) < 0.0;
                let seen = outside != surface.contains_origin();
                if seen { distance * distance * information } else { f64::INFINITY }
            });
            misfits(&surface, pixel, &numbers(&cells), &which, &mut found);
            assert!(
                found.iter().zip(plain).all(|(found, plain)| alike(*found, plain)),
                "{found:?} {plain:?}"
            );
        }
    }

    #[test]
    fn projections_and_sights_are_those_of_one_cell_after_the_other() {
        let cylinder =
            Cylinder::new(Vector3::new(0.1, -0.05, 0.8), Vector3::new(0.3, 0.9, 0.2), 0.06).unwrap();
        let (cells, pixel) = (cells(&cylinder), 1.0 / 570.0);
        let which = [4, 0, 7, 10, 2, 1, 3, 9, 8, 5, 4];
        let (mut across, mut along) = (vec![1.0; 3], Vec::new());
        across_and_along(&cylinder, &numbers(&cells), &which, &mut across, &mut along);
        let surface = Surface::Cylinder(cylinder, 0.001);
        for ((k, across), along) in which.into_iter().zip(across).zip(along) {
            assert!(alike(across, passes(&cylinder, cells[k].x, cells[k].y).unwrap()));
            assert!(alike(along, surface.project(&cells[k].point).along));
        }
        let mut found = Vec::new();
        sights((&surface, &cylinder), pixel, &numbers(&cells), &which, &mut found);
        let mut missed = 0;
        for (sight, k) in found.iter().zip(which) {
            let cell = &cells[k];
            let ray = Vector3::new(cell.x, cell.y, 1.0);
            let Some(hit) = cylinder.first_hit(&ray) else {
                assert_eq!(sight.along, f64::INFINITY);
                missed += 1;
                continue;
            };
            let (projection, _, information) = residual_of(&surface, &Cell { point: hit, ..*cell }, pixel);
            assert!(alike(sight.along, projection.along) && alike(sight.information, information));
            assert!(alike(sight.behind, (cell.point.z - hit.z) * projection.normal.dot(&ray).abs()));
        }
        assert!(found.len() == which.len() && missed < which.len(), "{missed}");
    }
}
