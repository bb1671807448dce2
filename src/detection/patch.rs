//! From a patch of cells to a first cylinder: a quadratic surface in the image.
//!
//! Along the image of a generator w = 1/z is linear, so that the direction in which the second derivative of w
//! vanishes is that of the axis in the image, exactly, for any camera.

use super::candidate::Marks;
use super::grid::Grid;
use super::moments::Moments;
use crate::geometry::{Cylinder, Line, rejection};
use nalgebra::{Matrix2, Matrix3, Matrix4, Vector2, Vector3, Vector4, Vector6};
use std::f64::consts::FRAC_PI_4;

constants! {
    /// The second derivative must be this many standard deviations from zero.
    SIGNIFICANT = 3.0, "σ";

    /// A strip is at least this many cells wide: what is left of a face or an edge may be as wide as two or three. It is at least so many
    /// times as long as wide, and its cells fill this part of that: in noise they hang together by chance.
    NARROWEST = 4.0, "cells";
    LONG = 2.0, "";
    FULL = 0.9, "";
}

/// The open cells connected with a seed within a window of `half` cells to each side.
pub(super) fn collect(grid: &Grid, seed: usize, half: usize, mark: &mut Marks, cells: &mut Vec<usize>) {
    let (column, row) = (seed % grid.columns, seed / grid.columns);
    let (left, right) = (column.saturating_sub(half), (column + half).min(grid.columns - 1));
    let (top, bottom) = (row.saturating_sub(half), (row + half).min(grid.rows - 1));
    cells.clear();
    cells.push(seed);
    mark.next();
    mark.set(seed);
    let mut next = 0;
    while next < cells.len() {
        let k = cells[next];
        next += 1;
        let (x, y) = (k % grid.columns, k / grid.columns);
        let around = [
            (x > left, k.wrapping_sub(1)),
            (x < right, k + 1),
            (y > top, k.wrapping_sub(grid.columns)),
            (y < bottom, k + grid.columns),
        ];
        for (_, neighbour) in around.into_iter().filter(|(within, _)| *within) {
            if mark.is_new(neighbour) && grid.connected(k, neighbour) {
                mark.set(neighbour);
                cells.push(neighbour);
            }
        }
    }
}

/// A cylinder by the quadratic surface through cells; `None` where they are flat within their noise, or no cylinder.
pub(super) fn hypothesis(
    grid: &Grid,
    moments: &Moments,
    deviation: f64,
    cells_per_sample: f64,
) -> Option<Cylinder> {
    let (matrix, vector) = moments.equations();
    let decomposition = matrix.cholesky()?;
    // About the mean, and in units of how far the cells lie from it.
    let size = moments.covariance().trace().sqrt();
    let numbers = about(&moments.mean(), size, decomposition.solve(&vector));
    let bend = Bend::of(&numbers);
    let across = bend.across;
    let row = Vector3::new(across.x * across.x, 2.0 * across.x * across.y, across.y * across.y);
    // The covariance of the last numbers is the inverse of the last block of the factor times its transpose.
    let of_bend = decomposition.l_dirty().fixed_view::<3, 3>(3, 3).solve_lower_triangular(&row)?;
    let uncertainty = deviation * (size * size) * (cells_per_sample * of_bend.norm_squared()).sqrt();
    if bend.size.abs() < SIGNIFICANT.get() * uncertainty {
        return None;
    }
    let middle = moments.on_plane(&moments.mean());
    Quadratic { numbers, middle, size: size * grid.spacing }.cylinder(&across)
}

/// The numbers of a quadratic w = a0 + a1 s + a2 t + a3 s²/2 + a4 s t + a5 t²/2 about another position, and in another unit of length.
fn about(origin: &Vector2<f64>, unit: f64, mut a: Vector6<f64>) -> Vector6<f64> {
    a[0] += a[1] * origin.x
        + a[2] * origin.y
        + 0.5 * a[3] * origin.x * origin.x
        + a[4] * origin.x * origin.y
        + 0.5 * a[5] * origin.y * origin.y;
    a[1] = (a[1] + a[3] * origin.x + a[4] * origin.y) * unit;
    a[2] = (a[2] + a[4] * origin.x + a[5] * origin.y) * unit;
    a.fixed_rows_mut::<3>(3).scale_mut(unit * unit);
    a
}

/// The greatest second derivative of a quadratic.
struct Bend {
    size: f64,
    /// Its direction: across the image of the axis.
    across: Vector2<f64>,
}

impl Bend {
    fn of(numbers: &Vector6<f64>) -> Self {
        let eigen = Matrix2::new(numbers[3], numbers[4], numbers[4], numbers[5]).symmetric_eigen();
        let strong = if eigen.eigenvalues[0].abs() > eigen.eigenvalues[1].abs() { 0 } else { 1 };
        Self { size: eigen.eigenvalues[strong], across: eigen.eigenvectors.column(strong).into() }
    }
}

/// A surface whose w = 1/z is a quadratic of the position in the image.
struct Quadratic {
    numbers: Vector6<f64>,
    /// Where in the image it is about, and the unit of its positions there.
    middle: Vector2<f64>,
    size: f64,
}

/// What a quadratic surface is at a position.
struct OnSurface {
    w: f64,
    point: Vector3<f64>,
    /// The normal, away from the observer.
    away: Vector3<f64>,
    /// The change of the point along the image of the generator.
    generator: Vector3<f64>,
}

impl Quadratic {
    /// At a position, with generators whose image is along a direction.
    fn at(&self, position: Vector2<f64>, along: &Vector2<f64>) -> OnSurface {
        let Self { numbers: a, middle, size } = self;
        let (s, t) = (position.x, position.y);
        let w = a[0] + a[1] * s + a[2] * t + 0.5 * a[3] * s * s + a[4] * s * t + 0.5 * a[5] * t * t;
        let wx = (a[1] + a[3] * s + a[4] * t) / size;
        let wy = (a[2] + a[4] * s + a[5] * t) / size;
        let (x, y) = (middle.x + size * s, middle.y + size * t);
        let away = Vector3::new(wx, wy, w - x * wx - y * wy).normalize();
        let point = Vector3::new(x, y, 1.0) / w;
        let slope = along.x * wx + along.y * wy;
        let generator = Vector3::new(along.x, along.y, 0.0) / w - Vector3::new(x, y, 1.0) * (slope / (w * w));
        OnSurface { w, point, away, generator }
    }

    /// The cylinder along the generator in the middle, by the normals across it.
    fn cylinder(&self, across: &Vector2<f64>) -> Option<Cylinder> {
        let along = Vector2::new(-across.y, across.x);
        let OnSurface { w, point, generator, .. } = self.at(Vector2::zeros(), &along);
        if w <= 0.0 {
            return None;
        }
        let direction = generator.normalize();
        // p + r n = c in the plane across the axis, for normals n that point away from the observer.
        let mut matrix = Matrix4::zeros();
        let mut vector = Vector4::zeros();
        let flat = Matrix3::identity() - direction * direction.transpose();
        for step in [-1.0, -0.5, 0.0, 0.5, 1.0] {
            let OnSurface { w, point: position, away, .. } = self.at(across * step, &along);
            if w <= 0.0 {
                continue;
            }
            let normal = (flat * away).normalize();
            let offset = flat * (position - point);
            // Unknowns (c, r): c − r n = p; the part of c along the axis is held at 0.
            for k in 0..3 {
                let mut row = Vector4::zeros();
                row[k] = 1.0;
                row[3] = -normal[k];
                matrix += row * row.transpose();
                vector += row * offset[k];
            }
        }
        for i in 0..3 {
            for j in 0..3 {
                matrix[(i, j)] += direction[i] * direction[j];
            }
        }
        let solution = matrix.cholesky()?.solve(&vector);
        let center = point + Vector3::new(solution[0], solution[1], solution[2]);
        finite(center, direction, solution[3].abs())
    }
}

/// A cylinder, if its numbers make one.
fn finite(point: Vector3<f64>, direction: Vector3<f64>, radius: f64) -> Option<Cylinder> {
    (radius > 0.0 && radius.is_finite() && point.iter().all(|x| x.is_finite()))
        .then_some(Cylinder { axis: Line { point, direction }, radius })
}

/// A cylinder as wide as the cells of a patch, where these are a strip: a thin pipe bends by less than its noise within any patch.
/// `None` where they are none.
pub(super) fn strip(grid: &Grid, moments: &Moments) -> Option<Cylinder> {
    let extents = moments.covariance().symmetric_eigen();
    let (short, long) = if extents.eigenvalues[0] < extents.eigenvalues[1] { (0, 1) } else { (1, 0) };
    // Those of a uniform stretch.
    let [width, length] = [short, long].map(|k| (12.0 * extents.eigenvalues[k]).sqrt());
    let is_full = moments.count() >= FULL.get() * width * length;
    if !(width >= NARROWEST.get() && length >= LONG.get() * width && is_full) {
        return None;
    }
    let (plane, _) = moments.plane()?;
    let along: Vector2<f64> = extents.eigenvectors.column(long).into();
    let position = moments.on_plane(&moments.mean());
    let ray = Vector3::new(position.x, position.y, 1.0);
    let w = plane.dot(&Vector3::new(1.0, position.x, position.y));
    if w <= 0.0 {
        return None;
    }
    let slope = along.x * plane[1] + along.y * plane[2];
    let direction = (Vector3::new(along.x, along.y, 0.0) / w - ray * (slope / (w * w))).normalize();
    let point = ray / w;
    let radius = 0.5 * width * grid.spacing / w;
    let away = rejection(&point, &direction).try_normalize(0.0)?;
    // So far behind the mean of the front is the axis.
    finite(point + away * (FRAC_PI_4 * radius), direction, radius)
}
