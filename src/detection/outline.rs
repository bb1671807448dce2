//! How a surface ends at its two sides.

use super::candidate::{Marks, Scene};
use super::grid::{Cell, Grid};
use super::noise::second_difference;
use super::rays::passes;
use super::surface::Surface;
use crate::geometry::Cylinder;
use crate::memory::List;
use nalgebra::{Vector2, Vector3};
use std::cell::OnceCell;
use std::hint;

/// Cells to either side of the outermost one of a line, among which a valley is looked for.
const BESIDE: usize = 4;

constants! {
    /// How deep a valley is, in standard deviations of a cell and its neighbours, and by how much the surface turns there, in radians:
    /// where equal cylinders touch it does so by half a turn, but matching windows fill the gap. Measured: docs/measurements-neighbours.md.
    VALLEY = 4.0, "σ";
    TURN = 0.7, "rad";

    /// The pixels beyond the limb over which matching windows draw a body out: half of a window of 11.
    pub(super) DRAWN_OUT = 5.5, "px";

    /// Where filters smoothed the step from a body to what lies behind it, and it leads down by more than `STEP` radii, its foot is a valley
    /// up to `SMOOTHED` radii beyond the limb, and up to [`DRAWN_OUT`] pixels. Measured: docs/measurements-detection.md, "Depth that filters
    /// smoothed".
    SMOOTHED = 0.25, "radius";
    STEP = 0.5, "radius";

    /// How wide a line across the axis is.
    LINE = 1.5, "cells";

    /// How far beyond the outermost cell of a line its end is looked for.
    FARTHEST = 4.0, "cells";

    /// Beyond the limb the surface goes on where the cosine of its normal and that of the cylinder is larger.
    FACING = 0.3, "";

    /// Fewest cells, itself among them, that tell the normal at a cell.
    FEWEST = 5.0, "cells";

    /// The cosine of the angle between ray and normal from which on a surface is none: steep ramps between an outline and the background.
    STEEP = 0.3, "";
}

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

/// The normals at the cells of a grid, each once it is asked for; `None` where the surface is not known or steep.
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
    /// The outermost cell, and the direction in the image that leads out of it.
    cell: usize,
    outward: [f64; 2],
}

impl Side {
    /// The ray, where it should touch the limb.
    pub fn limb(&self) -> Option<Vector3<f64>> {
        matches!(self.beyond, Beyond::Farther | Beyond::Missing).then_some(self.ray)
    }
}

/// The ends of lines across the axis at either side of the cells of a cylinder, line by line; the rays of the cells pass, and their
/// points lie, at the positions `across` and `along` the axis, the latter from `first` to `last`.
pub(super) fn outline(
    scene: &Scene<'_>,
    cylinder: &Cylinder,
    cells: &[usize],
    (across, along, [first, last]): (&[f64], &[f64], [f64; 2]),
    mark: &mut Marks,
) -> List<Side> {
    let grid = scene.grid;
    scene.effort.spend(2 * cells.len());
    mark.next();
    let mut depth = 0.0;
    for &k in cells {
        mark.set(k);
        depth += grid.cells[k].point.z;
    }
    let width = (last - first).max(f64::MIN_POSITIVE);
    let step = LINE.get() * grid.spacing * depth / cells.len() as f64;
    let count = ((width / step) as usize).clamp(1, 1000);
    let per_width = count as f64 / width;
    // The outermost cell of each line on each side, and how far out it is.
    let mut outermost: List<[(f64, usize); 2]> = List::filled([(f64::NEG_INFINITY, 0); 2], count);
    for ((&k, &across), along) in cells.iter().zip(across).zip(along) {
        let line = &mut outermost[(((along - first) * per_width) as u32 as usize).min(count - 1)];
        // Chosen without a branch, as no order of the cells tells which one is outermost. Comparisons with NaN are false, so NaN
        // never is.
        for (outermost, out) in line.iter_mut().zip([-across, across]) {
            let farther = out > outermost.0;
            outermost.0 = hint::select_unpredictable(farther, out, outermost.0);
            outermost.1 = hint::select_unpredictable(farther, k, outermost.1);
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
fn nearest(position: [f64; 2], below: [usize; 2]) -> Option<[usize; 2]> {
    if !(position[0] > -0.5 && position[1] > -0.5) {
        return None;
    }
    // The conversion holds what is below 0 at 0.
    let nearest = position.map(|t| t as usize + usize::from(t - (t as usize) as f64 >= 0.5));
    (nearest[0] < below[0] && nearest[1] < below[1]).then_some(nearest)
}

/// How far a position lies below the straight line through two others: as far as is as probable by the errors of all three as by those of
/// one alone. 0 where it does not lie between them.
fn depth_below(a: &Vector2<f64>, b: &Vector2<f64>, c: &Vector2<f64>) -> f64 {
    if !(a.x < b.x && b.x < c.x) {
        return 0.0;
    }
    -second_difference([a.x, b.x, c.x], [a.y, b.y, c.y])
}

impl Grid {
    /// The column and the row of a cell.
    fn position_of(&self, k: usize) -> [f64; 2] {
        [(k % self.columns) as f64, (k / self.columns) as f64]
    }

    /// The cell so many cells away from the column and the row of one in a direction.
    fn toward(&self, [column, row]: [f64; 2], [dx, dy]: [f64; 2], distance: usize) -> Option<usize> {
        let distance = distance as f64;
        let [x, y] = nearest([column + dx * distance, row + dy * distance], [self.columns, self.rows])?;
        Some(y * self.columns + x)
    }
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
        let end = |beyond: Beyond, before: usize| Side {
            beyond,
            sign,
            ray: ray(&grid.cells[before]),
            cell: k,
            outward: [dx, dy],
        };
        let from = grid.position_of(k);
        let mut before = k;
        let mut smooth = 0;
        for distance in 1..=FARTHEST.count() {
            let Some(next) = grid.toward(from, [dx, dy], distance) else {
                return end(Beyond::Hidden, before);
            };
            if next == before || mark.has(next) {
                before = next;
                continue;
            }
            if let Some(beyond) = self.step(before, next) {
                return end(beyond, before);
            }
            let cell = &grid.cells[next];
            let Some(normal) = self.normals.at(next, || self.normal(next)) else {
                before = next;
                continue;
            };
            let projection = Surface::Cylinder(*cylinder, 0.0).project(&cell.point);
            if projection.distance > 0.0 && -normal.dot(&projection.normal) > FACING.get() {
                // A single cell within the outline may be the last of the cylinder itself.
                let past = passes(cylinder, cell.x, cell.y).is_some_and(|across| across.abs() > 1.0);
                smooth += if past { 2 } else { 1 };
                if smooth >= 2 {
                    let is_strip = self.is_strip(next, [dx, dy]);
                    return end(if is_strip { Beyond::Farther } else { Beyond::Smooth }, k);
                }
            }
            before = next;
        }
        end(Beyond::Hidden, before)
    }

    /// How a surface ends between a cell and the next one; `None` where it goes on.
    fn step(&self, before: usize, next: usize) -> Option<Beyond> {
        let [cell, other] = [before, next].map(|k| &self.grid.cells[k]);
        if !other.measured() {
            return Some(Beyond::Missing);
        }
        let farther = other.point.z > cell.point.z;
        (!self.grid.connected(before, next)).then_some(if farther { Beyond::Farther } else { Beyond::Hidden })
    }

    /// Whether the surface that seems to go on at a cell beside the limb is a strip that a matching window drew out, and a filter
    /// smoothed the edge between the two: such a strip soon ends in something farther.
    fn is_strip(&self, cell: usize, outward: [f64; 2]) -> bool {
        let mut before = cell;
        let from = self.grid.position_of(cell);
        let cells = (DRAWN_OUT.get() / self.grid.side as f64).ceil() as usize;
        for distance in 1..=cells {
            let Some(next) = self.grid.toward(from, outward, distance) else { return false };
            match self.step(before, next) {
                None => before = next,
                end => return end == Some(Beyond::Farther),
            }
        }
        false
    }

    /// Whether the surface falls and rises again on the way out over the limb: whether, in the section across the axis, a cell next to
    /// the limb lies behind the straight line through one on either side of it, and the surface turns there. What goes on
    /// smoothly is convex; behind a valley another body begins. For sides of [`Beyond::Smooth`], whose normals do not tell.
    pub fn valley(&self, cylinder: &Cylinder, side: &Side) -> bool {
        let Side { cell: k, outward: [dx, dy], sign, .. } = *side;
        let grid = self.grid;
        let cell = &grid.cells[k];
        let [column, row] = grid.position_of(k);
        // Along the axis depth may change as well, so that cells to this or that side of the line would make valleys in it.
        let axis = &cylinder.axis.direction;
        let ray = cell.point.normalize();
        let toward = axis * ray.dot(axis) - ray;
        let facing = toward.norm();
        let toward = toward / facing;
        let outward = toward.cross(axis);
        let outward = if outward.x * dx + outward.y * dy > 0.0 { outward } else { -outward };
        let mut profile = [Vector2::zeros(); 2 * BESIDE + 1];
        let mut across = [0.0; 2 * BESIDE + 1];
        let (mut count, mut here) = (0, 0);
        for step in 0..=2 * BESIDE {
            let distance = step as f64 - BESIDE as f64;
            let position = [column + dx * distance, row + dy * distance];
            let cell = nearest(position, [grid.columns, grid.rows]).map(|[x, y]| grid.at(x, y));
            let Some(cell) = cell.filter(|cell| cell.measured()) else {
                if step > BESIDE {
                    break;
                }
                count = 0;
                continue;
            };
            if step == BESIDE {
                here = count;
            }
            profile[count] = Vector2::new(cell.point.dot(&outward), cell.point.dot(&toward));
            across[count] = passes(cylinder, cell.x, cell.y).map_or(f64::INFINITY, |across| sign * across);
            count += 1;
        }
        // The bottom is known to a cell.
        let one_cell = grid.spacing * cell.point.z / cylinder.radius;
        let smoothed = SMOOTHED.get().min(DRAWN_OUT.get() * one_cell / grid.side as f64).max(one_cell);
        let outmost = |fall: f64| 1.0 + if fall > STEP.get() * cylinder.radius { smoothed } else { one_cell };
        let deep = VALLEY.get() * facing * cell.sigma;
        let mut ends = (2..count).flat_map(|last| (0..last - 1).map(move |first| [first, last]));
        ends.any(|[first, last]| {
            let below = |middle: usize| depth_below(&profile[first], &profile[middle], &profile[last]);
            let middles = (first + 1..last).map(|middle| (below(middle), middle));
            let (below, bottom) = middles.fold((0.0, first), |a, b| if b.0 > a.0 { b } else { a });
            let slope = |a: usize, b: usize| (profile[b] - profile[a]).y.atan2((profile[b] - profile[a]).x);
            below > deep
                && bottom + 1 >= here
                && across[bottom] <= outmost(profile[here].y - profile[bottom].y)
                && slope(bottom, last) - slope(first, bottom) > TURN.get()
        })
    }

    /// The normal at a cell, away from the observer, by the plane through its connected neighbours; `None` where they are few, and
    /// where the surface is steep.
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
        if count < FEWEST.count() {
            return None;
        }
        let plane = matrix.cholesky()?.solve(&vector);
        let here = &grid.cells[k];
        let (wx, wy) = (plane[1] / grid.spacing, plane[2] / grid.spacing);
        let normal = Vector3::new(wx, wy, plane[0] - here.x * wx - here.y * wy).normalize();
        (normal.dot(&here.point.normalize()).abs() >= STEEP.get()).then_some(normal)
    }
}
