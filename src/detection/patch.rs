//! From a patch of cells to a first cylinder: a quadratic surface in the image.
//!
//! Along the image of a generator w = 1/z is linear, so that the direction in which the second derivative of w
//! vanishes is that of the axis in the image, exactly, for any camera.

use super::candidate::Marks;
use super::grid::Grid;
use crate::geometry::{Cylinder, Line};
use nalgebra::{Matrix2, Matrix3, SMatrix, SVector, Vector2, Vector3, Vector4};

/// The second derivative must be this many standard deviations from zero.
const SIGNIFICANT: f64 = 3.0;

/// The open cells connected with a seed within a window of `half` cells to each side.
pub(super) fn collect(
    grid: &Grid,
    seed: usize,
    half: usize,
    open: &[bool],
    mark: &mut Marks,
    cells: &mut Vec<usize>,
) {
    let (column, row) = (seed % grid.columns, seed / grid.columns);
    cells.clear();
    cells.push(seed);
    mark.next();
    mark.set(seed);
    let mut next = 0;
    while next < cells.len() {
        let k = cells[next];
        next += 1;
        for neighbour in grid.neighbours(k) {
            let (x, y) = (neighbour % grid.columns, neighbour / grid.columns);
            if !mark.has(neighbour)
                && x.abs_diff(column) <= half
                && y.abs_diff(row) <= half
                && open[neighbour]
                && grid.connected(k, neighbour)
            {
                mark.set(neighbour);
                cells.push(neighbour);
            }
        }
    }
}

/// A cylinder by the quadratic surface through cells; `None` where they are flat within their noise, or no cylinder.
pub(super) fn hypothesis(
    grid: &Grid,
    cells: &[usize],
    deviation: f64,
    cells_per_sample: f64,
) -> Option<Cylinder> {
    let count = cells.len() as f64;
    let mut middle = Vector2::zeros();
    for &k in cells {
        middle += Vector2::new(grid.cells[k].x, grid.cells[k].y) / count;
    }
    let mut size: f64 = 0.0;
    for &k in cells {
        size += (Vector2::new(grid.cells[k].x, grid.cells[k].y) - middle).norm_squared() / count;
    }
    let size = size.sqrt();
    let mut matrix = SMatrix::<f64, 6, 6>::zeros();
    let mut vector = SVector::<f64, 6>::zeros();
    for &k in cells {
        let cell = &grid.cells[k];
        let (s, t) = ((cell.x - middle.x) / size, (cell.y - middle.y) / size);
        let row = [1.0, s, t, 0.5 * s * s, s * t, 0.5 * t * t];
        for i in 0..6 {
            for j in 0..=i {
                matrix[(i, j)] += row[i] * row[j];
            }
            vector[i] += row[i] * cell.w;
        }
    }
    for i in 0..6 {
        for j in 0..i {
            matrix[(j, i)] = matrix[(i, j)];
        }
    }
    let inverse = matrix.cholesky()?.inverse();
    let a = inverse * vector;
    let eigen = Matrix2::new(a[3], a[4], a[4], a[5]).symmetric_eigen();
    let strong = if eigen.eigenvalues[0].abs() > eigen.eigenvalues[1].abs() { 0 } else { 1 };
    let bend = eigen.eigenvalues[strong];
    let across: Vector2<f64> = eigen.eigenvectors.column(strong).into();
    let along = Vector2::new(-across.y, across.x);
    let row = SVector::<f64, 6>::from([
        0.0,
        0.0,
        0.0,
        across.x * across.x,
        2.0 * across.x * across.y,
        across.y * across.y,
    ]);
    let uncertainty = deviation * (cells_per_sample * row.dot(&(inverse * row))).sqrt();
    if bend.abs() < SIGNIFICANT * uncertainty {
        return None;
    }
    // Value, position and normal of the quadratic surface at a place.
    let surface = |place: Vector2<f64>| {
        let (s, t) = (place.x, place.y);
        let w = a[0] + a[1] * s + a[2] * t + 0.5 * a[3] * s * s + a[4] * s * t + 0.5 * a[5] * t * t;
        let wx = (a[1] + a[3] * s + a[4] * t) / size;
        let wy = (a[2] + a[4] * s + a[5] * t) / size;
        let (x, y) = (middle.x + size * s, middle.y + size * t);
        let away = Vector3::new(wx, wy, w - x * wx - y * wy).normalize();
        let point = Vector3::new(x, y, 1.0) / w;
        // The change of the point along the image of the generator.
        let slope = along.x * wx + along.y * wy;
        let generator = Vector3::new(along.x, along.y, 0.0) / w - Vector3::new(x, y, 1.0) * (slope / (w * w));
        (w, point, away, generator)
    };
    let (w, point, _, generator) = surface(Vector2::zeros());
    if w <= 0.0 {
        return None;
    }
    let direction = generator.normalize();
    // p + r n = c in the plane across the axis, for normals n that point away from the observer.
    let mut matrix = nalgebra::Matrix4::zeros();
    let mut vector = Vector4::zeros();
    let flat = Matrix3::identity() - direction * direction.transpose();
    for step in [-1.0, -0.5, 0.0, 0.5, 1.0] {
        let (w, place, away, _) = surface(across * step);
        if w <= 0.0 {
            continue;
        }
        let normal = (flat * away).normalize();
        let offset = flat * (place - point);
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
    let radius = solution[3].abs();
    (radius > 0.0 && radius.is_finite() && center.iter().all(|x| x.is_finite()))
        .then_some(Cylinder { axis: Line { point: center, direction }, radius })
}
