//! The depth image in cells: means of a few pixels on one surface, what everything else here works on.
//!
//! A plane is linear in (x/z, y/z) ↦ 1/z, and so is every straight line in space along its image. Positions in a cell
//! are therefore (x, y) on the plane z = 1 and w = 1/z.

use crate::statistics::median;
use nalgebra::Vector3;

/// The steepest surface that counts as one piece from cell to cell, as change of depth over the width across the line
/// of sight: a cylinder is this steep at 0.96 r from the middle of its image. What is steeper is a step.
pub(super) const STEEPEST: f64 = 3.5;

/// Cells across the longer side of an image: structured light averages over 7 to 11 pixels of 640, so that cells of 3
/// pixels lose nothing.
const CELLS_ACROSS: usize = 214;

/// Cells to a radian, at most: as many as 3 pixels are at a focal length of 570, the usual one for 640 pixels. A part cut out
/// of an image, and a narrow view whose depth was enlarged to the image, have no finer depth for their fewer cells.
const CELLS_TO_A_RADIAN: f64 = 190.0;

/// So much coarser than by the size of the image at most: a camera for small things may be narrow and fine.
const MOST_COARSER: f64 = 2.0;

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
    let of_image = width.max(height) as f64 / CELLS_ACROSS as f64;
    let of_angle = 1.0 / (CELLS_TO_A_RADIAN * pixel);
    of_image.max(of_angle.min(MOST_COARSER * of_image.max(1.0))).round().max(1.0) as usize
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
}

impl Grid {
    /// Cells from the points of an image grid, `None` where nothing was measured.
    pub fn new(
        (width, height): (usize, usize),
        spacing: f64,
        side: usize,
        point: &impl Fn(usize, usize) -> Option<Vector3<f64>>,
    ) -> Self {
        let (columns, rows) = (width / side, height / side);
        let spacing = spacing * side as f64;
        let mut cells = Vec::with_capacity(columns * rows);
        let mut pixels: Vec<Vector3<f64>> = Vec::with_capacity(side * side);
        let mut depths = Vec::with_capacity(side * side);
        for row in 0..rows {
            for column in 0..columns {
                pixels.clear();
                for y in row * side..(row + 1) * side {
                    pixels.extend((column * side..(column + 1) * side).filter_map(|x| point(x, y)));
                }
                cells.push(Self::cell(&pixels, spacing, side * side, &mut depths));
            }
        }
        Self { columns, rows, side, spacing, cells }
    }

    /// The mean of the pixels on the surface in the middle of their depths.
    fn cell(pixels: &[Vector3<f64>], spacing: f64, full: usize, depths: &mut Vec<f64>) -> Cell {
        if 3 * pixels.len() < full {
            return Cell::EMPTY;
        }
        let (mut near, mut far) = (f64::INFINITY, f64::NEG_INFINITY);
        for p in pixels {
            near = if p.z < near { p.z } else { near };
            far = if p.z > far { p.z } else { far };
        }
        let reach_at = |middle: f64| 0.5 * STEEPEST * spacing * middle;
        // Most cells see one surface: what is within reach of the nearest of them is within that of the middle one, too.
        let (middle, reach) = if far - near <= reach_at(near) {
            (near, reach_at(near))
        } else {
            depths.clear();
            depths.extend(pixels.iter().map(|p| p.z));
            let middle = median(depths);
            (middle, reach_at(middle))
        };
        let (mut sum, mut count) = (Vector3::zeros(), 0.0);
        for p in pixels {
            if (p.z - middle).abs() <= reach {
                let w = 1.0 / p.z;
                sum += Vector3::new(p.x * w, p.y * w, w);
                count += 1.0;
            }
        }
        if 3.0 * count < full as f64 {
            return Cell::EMPTY;
        }
        let mean = sum / count;
        let point = Vector3::new(mean.x, mean.y, 1.0) / mean.z;
        Cell { x: mean.x, y: mean.y, w: mean.z, point, sigma: 0.0, fill: count / full as f64 }
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
        let (step, noise) = ((a.point.z - b.point.z).abs(), 3.0 * (a.sigma + b.sigma));
        // Most are, and nothing need be known of how far apart they are.
        if step <= STEEPEST * self.spacing * depth + noise {
            return true;
        }
        let (right, down) = (a.x - b.x, a.y - b.y);
        step <= STEEPEST * (right * right + down * down).sqrt() * depth + noise
    }

    /// The neighbours of a cell left, right, above and below; beyond the border the cell itself.
    #[inline]
    pub fn neighbours(&self, index: usize) -> [usize; 4] {
        let (column, row) = (index % self.columns, index / self.columns);
        let columns = self.columns;
        [
            if column > 0 { index - 1 } else { index },
            if column + 1 < columns { index + 1 } else { index },
            if row > 0 { index - columns } else { index },
            if row + 1 < self.rows { index + columns } else { index },
        ]
    }
}
