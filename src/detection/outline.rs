//! How a surface ends at its two sides.

use super::candidate::{Marks, Scene};
use super::grid::Cell;
use super::rays::passes;
use super::surface::Surface;
use crate::geometry::Cylinder;
use crate::memory::List;
use nalgebra::Vector3;
use std::cell::OnceCell;

/// What follows the outermost cell of a line across the axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Beyond {
    /// The surface goes on without an edge.
    Smooth,
    /// Something farther away.
    Farther,
    /// Nothing measured.
    Missing,
    /// Something nearer, the border of the image, or an edge where another surface begins.
    Hidden,
}

/// The normals at the cells of a grid, each once it is asked for.
pub(super) struct Normals(Vec<OnceCell<Option<Vector3<f64>>>>);

impl Normals {
    pub fn new(cells: usize) -> Self {
        Self(vec![OnceCell::new(); cells])
    }

    fn at(&self, k: usize, compute: impl FnOnce() -> Option<Vector3<f64>>) -> Option<Vector3<f64>> {
        *self.0[k].get_or_init(compute)
    }
}

/// The end of a line across the axis at one side.
#[derive(Debug, Clone, Copy)]
pub(super) struct Side {
    pub beyond: Beyond,
    /// Which side: −1 or 1.
    pub sign: f64,
    /// The ray along the border of the outermost cell.
    pub ray: Vector3<f64>,
}

impl Side {
    /// The ray, where it should touch the limb.
    pub fn limb(&self) -> Option<Vector3<f64>> {
        matches!(self.beyond, Beyond::Farther | Beyond::Missing).then_some(self.ray)
    }
}

/// The ends of lines across the axis at either side of the cells of a cylinder, line by line; the rays of the cells pass, and their
/// points lie, at the places `across` and `along` the axis.
pub(super) fn outline(
    scene: &Scene<'_>,
    cylinder: &Cylinder,
    cells: &[usize],
    (across, along): (&[f64], &[f64]),
    mark: &mut Marks,
) -> List<Side> {
    let grid = scene.grid;
    scene.effort.spend(2 * cells.len());
    mark.next();
    let (mut depth, mut first, mut last) = (0.0, f64::INFINITY, f64::NEG_INFINITY);
    for (&k, &along) in cells.iter().zip(along) {
        mark.set(k);
        depth += grid.cells[k].point.z;
        (first, last) = (first.min(along), last.max(along));
    }
    let width = (last - first).max(f64::MIN_POSITIVE);
    let step = 1.5 * grid.spacing * depth / cells.len() as f64;
    let count = ((width / step) as usize).clamp(1, 1000);
    let per_width = count as f64 / width;
    // The outermost cell of each line on each side, and how far out it is.
    let mut outermost: List<[(f64, usize); 2]> = List::filled([(f64::NEG_INFINITY, 0); 2], count);
    for ((&k, &across), along) in cells.iter().zip(across).zip(along) {
        // Comparisons with NaN are false, so NaN is never outermost.
        let line = &mut outermost[(((along - first) * per_width) as usize).min(count - 1)];
        if -across > line[0].0 {
            line[0] = (-across, k);
        }
        if across > line[1].0 {
            line[1] = (across, k);
        }
    }
    let mut sides = List::with_capacity(2 * count);
    for line in &outermost {
        for ((across, k), sign) in line.iter().zip([-1.0, 1.0]) {
            if *across > f64::NEG_INFINITY {
                sides.push(scene.beyond(cylinder, *k, sign, mark));
            }
        }
    }
    sides
}

/// The numbers nearest to two coordinates, below limits. [`f64::round`] is a call.
fn nearest(place: [f64; 2], below: [usize; 2]) -> Option<[usize; 2]> {
    if !(place[0] > -0.5 && place[1] > -0.5) {
        return None;
    }
    // The conversion holds what is below 0 at 0.
    let nearest = place.map(|t| t as usize + usize::from(t - (t as usize) as f64 >= 0.5));
    (nearest[0] < below[0] && nearest[1] < below[1]).then_some(nearest)
}

impl Scene<'_> {
    /// What follows the outermost cell of a line across the axis.
    fn beyond(&self, cylinder: &Cylinder, k: usize, sign: f64, mark: &Marks) -> Side {
        let grid = self.grid;
        let cell = &grid.cells[k];
        // The direction across the axis in the image: that in which the position across grows.
        let here = passes(cylinder, cell.x, cell.y).unwrap_or(0.0);
        let step = grid.spacing;
        let slope = |x: f64, y: f64| passes(cylinder, x, y).unwrap_or(0.0) - here;
        let (mut dx, mut dy) = (slope(cell.x + step, cell.y), slope(cell.x, cell.y + step));
        let norm = (dx * dx + dy * dy).sqrt().max(f64::MIN_POSITIVE);
        (dx, dy) = (sign * dx / norm, sign * dy / norm);
        let ray = |cell: &Cell| {
            let half = 0.5 * step * cell.fill;
            Vector3::new(cell.x + half * dx, cell.y + half * dy, 1.0)
        };
        let end = |beyond: Beyond, before: usize| Side { beyond, sign, ray: ray(&grid.cells[before]) };
        let (column, row) = ((k % grid.columns) as f64, (k / grid.columns) as f64);
        let mut before = k;
        let mut smooth = 0;
        for distance in 1..=4 {
            let place = [column + dx * f64::from(distance), row + dy * f64::from(distance)];
            let Some([x, y]) = nearest(place, [grid.columns, grid.rows]) else {
                return end(Beyond::Hidden, before);
            };
            let next = y * grid.columns + x;
            if next == before || mark.has(next) {
                before = next;
                continue;
            }
            let cell = &grid.cells[next];
            if !cell.measured() {
                return end(Beyond::Missing, before);
            }
            if !grid.connected(before, next) {
                let farther = cell.point.z > grid.cells[before].point.z;
                return end(if farther { Beyond::Farther } else { Beyond::Hidden }, before);
            }
            let Some(normal) = self.normals.at(next, || self.normal(next)) else {
                before = next;
                continue;
            };
            let place = Surface::Cylinder(*cylinder, 0.0).place(&cell.point);
            // Steep ramps between an outline and the background are no surface.
            let steep = normal.dot(&cell.point.normalize()).abs() < 0.3;
            if place.distance > 0.0 && !steep && -normal.dot(&place.normal) > 0.3 {
                // A single cell within the outline may be the last of the cylinder itself.
                let past = passes(cylinder, cell.x, cell.y).is_some_and(|across| across.abs() > 1.0);
                smooth += if past { 2 } else { 1 };
                if smooth >= 2 {
                    return end(Beyond::Smooth, k);
                }
            }
            before = next;
        }
        end(Beyond::Hidden, before)
    }

    /// The normal at a cell, away from the observer, by the plane through its connected neighbours.
    fn normal(&self, k: usize) -> Option<Vector3<f64>> {
        let grid = self.grid;
        let (column, row) = (k % grid.columns, k / grid.columns);
        let mut matrix = nalgebra::Matrix3::zeros();
        let mut vector = Vector3::zeros();
        let mut count = 0;
        for y in row.saturating_sub(1)..(row + 2).min(grid.rows) {
            for x in column.saturating_sub(1)..(column + 2).min(grid.columns) {
                let other = y * grid.columns + x;
                if grid.connected(k, other) {
                    let (cell, here) = (&grid.cells[other], &grid.cells[k]);
                    let row =
                        Vector3::new(1.0, (cell.x - here.x) / grid.spacing, (cell.y - here.y) / grid.spacing);
                    matrix += row * row.transpose();
                    vector += row * cell.w;
                    count += 1;
                }
            }
        }
        if count < 5 {
            return None;
        }
        let plane = matrix.cholesky()?.solve(&vector);
        let here = &grid.cells[k];
        let (wx, wy) = (plane[1] / grid.spacing, plane[2] / grid.spacing);
        Some(Vector3::new(wx, wy, plane[0] - here.x * wx - here.y * wy).normalize())
    }
}
