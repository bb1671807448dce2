//! The depth image in cells: means of a few pixels on one surface, what everything else here works on.
//!
//! A plane is linear in (x/z, y/z) ↦ 1/z, and so is every straight line in space along its image. Positions in a cell
//! are therefore (x, y) on the plane z = 1 and w = 1/z.

use super::distances::LANES;
use super::row::Points;
use crate::memory::List;
use crate::statistics::median;
use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

constants! {
    /// The steepest surface that counts as one piece from cell to cell, as change of depth over the width across the line
    /// of sight: a cylinder is this steep at 0.96 r from the middle of its image. What is steeper is a step.
    pub(super) STEEPEST = 3.5, "";

    /// Cells across the longer side of an image: structured light averages over 7 to 11 pixels of 640, so that cells of 3
    /// pixels lose nothing.
    CELLS_ACROSS = 214.0, "cells";

    /// Cells to a radian, at most: as many as 3 pixels are at a focal length of 570, the usual one for 640 pixels. A part cut out
    /// of an image, and a narrow view whose depth was enlarged to the image, have no finer depth for their fewer cells.
    CELLS_TO_A_RADIAN = 190.0, "cells";

    /// So much coarser than by the size of the image at most: a camera for small things may be narrow and fine.
    MOST_COARSER = 2.0, "";

    /// The part of the pixels of a cell that must be measured on one surface.
    LEAST_MEASURED = 1.0 / 3.0, "";

    /// How much of a step between neighbouring cells may be noise.
    STEP_NOISE = 3.0, "σ";
}

/// The least and the largest of no numbers.
const NO_BOUNDS: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

/// A mean of pixels that see one surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell {
    /// The position on the plane z = 1.
    pub x: f64,
    /// The position on the plane z = 1.
    pub y: f64,
    /// 1/z; 0 where too little was measured.
    pub w: f64,
    /// The point in space.
    pub point: Vector3<f64>,
    /// Standard deviation of the depth.
    pub sigma: f64,
    /// The part of its pixels that were measured.
    pub fill: f64,
}

impl Cell {
    const EMPTY: Self =
        Self { x: 0.0, y: 0.0, w: 0.0, point: Vector3::new(0.0, 0.0, 0.0), sigma: 0.0, fill: 0.0 };

    pub fn measured(&self) -> bool {
        self.w > 0.0
    }
}

/// Pixels along the side of a cell of an image whose pixels have this side on the plane z = 1, infinite where that does not tell how fine the depth is.
pub(super) fn side_of_cells((width, height): (usize, usize), pixel: f64) -> usize {
    let of_image = width.max(height) as f64 / CELLS_ACROSS.get();
    let of_angle = 1.0 / (CELLS_TO_A_RADIAN.get() * pixel);
    of_image.max(of_angle.min(MOST_COARSER.get() * of_image.max(1.0))).round().max(1.0) as usize
}

/// The cells of a depth image, row by row.
#[derive(Debug, Clone)]
pub(super) struct Grid {
    pub columns: usize,
    pub rows: usize,
    /// Pixels along the side of a cell.
    pub side: usize,
    /// The side of a cell on the plane z = 1.
    pub spacing: f64,
    pub cells: Vec<Cell>,
    /// The positions of the cells on the plane z = 1, axis by axis.
    pub rays: [Vec<f64>; 2],
    /// By column and by row: the least and the largest position of its measured cells, of columns the first and of rows the
    /// second on that plane.
    pub bounds: [Vec<[f64; 2]>; 2],
    /// Whether a cell has neighbours on all sides.
    pub inner: Vec<bool>,
}

/// Sums over pixels of a cell.
#[derive(Debug, Clone, Copy)]
struct Sums {
    /// Of x/z, y/z and 1/z.
    position: [f64; 3],
    count: f64,
    near: f64,
    far: f64,
}

impl Sums {
    const NONE: Self = Self { position: [0.0; 3], count: 0.0, near: f64::INFINITY, far: f64::NEG_INFINITY };

    fn numbers(&self) -> [f64; 6] {
        let [x, y, w] = self.position;
        [x, y, w, self.count, self.near, self.far]
    }

    /// The sums over some columns.
    #[inline]
    fn across([x, y, w, count, near, far]: [&[f64]; 6]) -> Self {
        let mut sums = Self::NONE;
        let numbers = x.iter().zip(y).zip(w).zip(count.iter().zip(near).zip(far));
        for (((x, y), w), ((count, near), far)) in numbers {
            sums.position = [sums.position[0] + x, sums.position[1] + y, sums.position[2] + w];
            sums.count += count;
            sums.near = if *near < sums.near { *near } else { sums.near };
            sums.far = if *far > sums.far { *far } else { sums.far };
        }
        sums
    }

    /// The mean, where enough of all pixels were measured.
    fn mean(&self, full: usize) -> Cell {
        if self.count < LEAST_MEASURED.get() * full as f64 {
            return Cell::EMPTY;
        }
        let [x, y, w] = self.position.map(|sum| sum / self.count);
        let point = Vector3::new(x, y, 1.0) / w;
        Cell { x, y, w, point, sigma: 0.0, fill: self.count / full as f64 }
    }
}

/// How far depths about one in the middle may differ from it.
fn reach_at(middle: f64, spacing: f64) -> f64 {
    0.5 * STEEPEST.get() * spacing * middle
}

/// The sums over pixels on the surface in the middle of their depths.
fn about_the_middle(pixels: &[[f64; 3]], spacing: f64, depths: &mut Vec<f64>) -> Sums {
    let mut sums = Sums::NONE;
    if pixels.is_empty() {
        return sums;
    }
    depths.clear();
    depths.extend(pixels.iter().map(|p| p[2]));
    let middle = median(depths);
    let reach = reach_at(middle, spacing);
    for [x, y, z] in pixels {
        if (z - middle).abs() <= reach {
            let w = 1.0 / z;
            sums.position = [sums.position[0] + x * w, sums.position[1] + y * w, sums.position[2] + w];
            sums.count += 1.0;
        }
    }
    sums
}

/// Sums down columns of pixels, those of [`Sums`] in their order.
type OfColumns = [List<f64>; 6];

/// One pass over a row of pixels, which adds it to the sums down the columns. All lists are of the same length, some groups of
/// [`LANES`].
struct Line<'a> {
    points: &'a [List<f64>; 3],
    sums: &'a mut OfColumns,
}

impl WithSimd for Line<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { points: [px, py, pz], sums: [x, y, w, count, near, far] } = self;
        let (zero, one) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
        let infinite = simd.splat_f64s(f64::INFINITY);
        let (px, py, pz) = (S::as_simd_f64s(px).0, S::as_simd_f64s(py).0, S::as_simd_f64s(pz).0);
        let (x, y, w) = (S::as_mut_simd_f64s(x).0, S::as_mut_simd_f64s(y).0, S::as_mut_simd_f64s(w).0);
        let count = S::as_mut_simd_f64s(count).0;
        let (near, far) = (S::as_mut_simd_f64s(near).0, S::as_mut_simd_f64s(far).0);
        let sums = x.iter_mut().zip(y).zip(w).zip(count.iter_mut().zip(near).zip(far));
        for ((((x, y), w), ((count, near), far)), ((px, py), pz)) in sums.zip(px.iter().zip(py).zip(pz)) {
            let inverse = simd.div_f64s(one, *pz);
            let seen = simd.greater_than_f64s(*pz, zero);
            *x = simd.add_f64s(*x, simd.select_f64s(seen, simd.mul_f64s(*px, inverse), zero));
            *y = simd.add_f64s(*y, simd.select_f64s(seen, simd.mul_f64s(*py, inverse), zero));
            *w = simd.add_f64s(*w, simd.select_f64s(seen, inverse, zero));
            *count = simd.add_f64s(*count, simd.select_f64s(seen, one, zero));
            *near = simd.min_f64s(*near, simd.select_f64s(seen, *pz, infinite));
            *far = simd.max_f64s(*far, *pz);
        }
    }
}

impl Grid {
    /// Cells from the points of an image.
    pub fn new((width, height): (usize, usize), spacing: f64, side: usize, read_points: &Points<'_>) -> Self {
        let (columns, rows) = (width / side, height / side);
        let spacing = spacing * side as f64;
        let mut cells = Vec::with_capacity(columns * rows);
        let mut lines: Vec<[List<f64>; 3]> = (0..side).map(|_| Default::default()).collect();
        let padded = (columns * side).next_multiple_of(LANES);
        let mut of_columns = OfColumns::default();
        let (mut pixels, mut depths) = (List::with_capacity(side * side), List::with_capacity(side * side));
        for row in 0..rows {
            for (list, none) in of_columns.iter_mut().zip(Sums::NONE.numbers()) {
                list.clear();
                list.resize(padded, none);
            }
            for (y, points) in lines.iter_mut().enumerate() {
                read_points(row * side + y, 0..columns * side, points);
                points.iter_mut().for_each(|list| list.resize(padded, 0.0));
                Arch::new().dispatch(Line { points, sums: &mut of_columns });
            }
            let [x, y, w, count, near, far] = of_columns.each_ref().map(|list| list.chunks_exact(side));
            let of_cells = x.zip(y).zip(w).zip(count.zip(near).zip(far)).take(columns);
            for (column, (((x, y), w), ((count, near), far))) in of_cells.enumerate() {
                let sums = Sums::across([x, y, w, count, near, far]);
                // Most cells see one surface: what is within reach of the nearest of them is within that of the middle one, too.
                let alike = sums.far - sums.near <= reach_at(sums.near, spacing);
                cells.push(if alike {
                    sums.mean(side * side)
                } else {
                    pixels.clear();
                    for [px, py, pz] in &lines {
                        let own = column * side..(column + 1) * side;
                        pixels.extend(own.map(|k| [px[k], py[k], pz[k]]).filter(|p| p[2] > 0.0));
                    }
                    about_the_middle(&pixels, spacing, &mut depths).mean(side * side)
                });
            }
        }
        let rays = [|cell: &Cell| cell.x, |cell: &Cell| cell.y].map(|of| cells.iter().map(of).collect());
        let within = |k: usize, count: usize| k > 0 && k + 1 < count;
        let row = |y: usize| (0..columns).map(move |x| within(x, columns) && within(y, rows));
        let inner = (0..rows).flat_map(row).collect();
        // Row by row, as the cells lie in memory.
        let mut bounds = [vec![NO_BOUNDS; columns], vec![NO_BOUNDS; rows]];
        let [of_columns, of_rows] = &mut bounds;
        for (cells, of_row) in cells.chunks_exact(columns.max(1)).zip(of_rows) {
            for (cell, of_column) in cells.iter().zip(&mut *of_columns).filter(|(cell, _)| cell.measured()) {
                *of_column = [of_column[0].min(cell.x), of_column[1].max(cell.x)];
                *of_row = [of_row[0].min(cell.y), of_row[1].max(cell.y)];
            }
        }
        Self { columns, rows, side, spacing, cells, rays, bounds, inner }
    }

    /// Columns and rows of some cells with a margin, which may go over the grid.
    pub fn around(&self, cells: &[usize], margin: usize) -> [Range<usize>; 2] {
        let (mut low, mut high) = ([usize::MAX; 2], [0; 2]);
        for &k in cells {
            let (x, y) = (k % self.columns, k / self.columns);
            low = [low[0].min(x), low[1].min(y)];
            high = [high[0].max(x), high[1].max(y)];
        }
        [0, 1].map(|axis| low[axis].saturating_sub(margin)..high[axis] + margin + 1)
    }

    /// Of some columns (axis 0) or rows (axis 1) those from the first to the last with a measured cell between two positions.
    pub fn within(&self, axis: usize, some: Range<usize>, low: f64, high: f64) -> Range<usize> {
        let some = some.start..some.end.min(self.bounds[axis].len());
        let meets = |k: &usize| self.bounds[axis][*k][0] <= high && self.bounds[axis][*k][1] >= low;
        let end = some.clone().rev().find(meets).map_or(some.start, |last| last + 1);
        some.clone().find(meets).map_or(end..end, |first| first..end)
    }

    pub fn at(&self, column: usize, row: usize) -> &Cell {
        &self.cells[row * self.columns + column]
    }

    /// Whether two neighbouring cells lie on one surface: no step between them.
    pub fn connected(&self, a: usize, b: usize) -> bool {
        let (a, b) = (&self.cells[a], &self.cells[b]);
        if !(a.measured() && b.measured()) {
            return false;
        }
        let depth = a.point.z.min(b.point.z);
        let (step, noise) = ((a.point.z - b.point.z).abs(), STEP_NOISE.get() * (a.sigma + b.sigma));
        // Most are, and nothing need be known of how far apart they are.
        if step <= STEEPEST.get() * self.spacing * depth + noise {
            return true;
        }
        let (right, down) = (a.x - b.x, a.y - b.y);
        step <= STEEPEST.get() * (right * right + down * down).sqrt() * depth + noise
    }

    /// The neighbours of a cell left, right, above and below; beyond the border the cell itself.
    #[inline]
    pub fn neighbours(&self, index: usize) -> [usize; 4] {
        let columns = self.columns;
        // Most lie within, which is told without a division.
        if self.inner[index] {
            return [index - 1, index + 1, index - columns, index + columns];
        }
        let (column, row) = (index % columns, index / columns);
        [
            if column > 0 { index - 1 } else { index },
            if column + 1 < columns { index + 1 } else { index },
            if row > 0 { index - columns } else { index },
            if row + 1 < self.rows { index + columns } else { index },
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_means_of_their_pixels_one_after_the_other() {
        let (size, side, spacing) = ((20, 9), 3, 0.002);
        for scale in [1e-9, 1.0, 1e9] {
            let point = |row: usize, column: usize| {
                let seen = (row * 7 + column * 5) % 11 > 2;
                let z = if seen { scale * (1.0 + 0.001 * ((row * column) % 5) as f64) } else { 0.0 };
                [0.002 * column as f64 * z, 0.002 * row as f64 * z, z]
            };
            let read = |row: usize, columns: Range<usize>, points: &mut [List<f64>; 3]| {
                super::super::row::write(columns, points, |column| point(row, column));
            };
            let grid = Grid::new(size, spacing, side, &read);
            assert_eq!((grid.columns, grid.rows), (6, 3));
            for (k, cell) in grid.cells.iter().enumerate() {
                let (row, column) = (k / 6 * side, k % 6 * side);
                let pixels = (0..9).map(|k| point(row + k / 3, column + k % 3)).filter(|p| p[2] > 0.0);
                let (mut sums, mut count) = ([0.0; 3], 0.0);
                for [x, y, z] in pixels {
                    sums = [sums[0] + x / z, sums[1] + y / z, sums[2] + 1.0 / z];
                    count += 1.0;
                }
                let [x, y, w] = sums.map(|sum| sum / count);
                assert_eq!(cell.fill, count / 9.0);
                let off = [cell.x / x, cell.y / y, cell.w / w].map(|ratio| (ratio - 1.0).abs());
                // The first of all lies on an axis of the image.
                assert!(off.iter().all(|off| *off < 1e-12 || off.is_nan()), "{k}: {off:?}");
                assert_eq!(grid.inner[k], k == 7 || k == 8 || k == 9 || k == 10);
            }
        }
    }

    #[test]
    fn neighbours_end_at_the_border() {
        let read = |_: usize, columns: Range<usize>, points: &mut [List<f64>; 3]| {
            super::super::row::write(columns, points, |_| [0.0, 0.0, 1.0]);
        };
        let grid = Grid::new((4, 3), 0.002, 1, &read);
        assert_eq!(grid.neighbours(0), [0, 1, 0, 4]);
        assert_eq!(grid.neighbours(5), [4, 6, 1, 9]);
        assert_eq!(grid.neighbours(11), [10, 11, 7, 11]);
    }
}
