//! The depth image in cells: means of a few pixels on one surface, what everything else here works on.
//!
//! A plane is linear in (x/z, y/z) ↦ 1/z, and so is every straight line in space along its image. Positions in a cell
//! are therefore (x, y) on the plane z = 1 and w = 1/z.

use super::row::Points;
use crate::memory::List;
use crate::statistics::median;
use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};

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
    /// The positions of the cells on the plane z = 1, axis by axis.
    pub rays: [Vec<f64>; 2],
}

/// Sums over pixels of a cell.
#[derive(Debug, Clone, Copy)]
struct Sums {
    /// Of x/z, y/z and 1/z.
    place: [f64; 3],
    count: f64,
    near: f64,
    far: f64,
}

impl Sums {
    const NONE: Self = Self { place: [0.0; 3], count: 0.0, near: f64::INFINITY, far: f64::NEG_INFINITY };

    /// The mean, where a third of all pixels were measured.
    fn mean(&self, full: usize) -> Cell {
        if 3.0 * self.count < full as f64 {
            return Cell::EMPTY;
        }
        let [x, y, w] = self.place.map(|sum| sum / self.count);
        let point = Vector3::new(x, y, 1.0) / w;
        Cell { x, y, w, point, sigma: 0.0, fill: self.count / full as f64 }
    }
}

/// How far depths about one in the middle may differ from it.
fn reach_at(middle: f64, spacing: f64) -> f64 {
    0.5 * STEEPEST * spacing * middle
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
            sums.place = [sums.place[0] + x * w, sums.place[1] + y * w, sums.place[2] + w];
            sums.count += 1.0;
        }
    }
    sums
}

/// One pass over a row of pixels, for the sums of the cells that it goes through.
struct Line<'a> {
    points: &'a [List<f64>; 3],
    side: usize,
    /// Room for x/z, y/z, 1/z and the depth of every pixel, the last infinite where nothing was measured.
    numbers: &'a mut [List<f64>; 4],
    sums: &'a mut [Sums],
}

impl WithSimd for Line<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { points: [px, py, pz], side, numbers: [x, y, w, z], sums } = self;
        let places = x.iter_mut().zip(y.iter_mut()).zip(w.iter_mut()).zip(z.iter_mut());
        for ((((x, y), w), z), ((px, py), pz)) in places.zip(px.iter().zip(py).zip(pz)) {
            let inverse = 1.0 / pz;
            let seen = *pz > 0.0;
            // What nothing is added to keeps its bits.
            *x = if seen { px * inverse } else { 0.0 };
            *y = if seen { py * inverse } else { 0.0 };
            *w = if seen { inverse } else { 0.0 };
            *z = if seen { *pz } else { f64::INFINITY };
        }
        let parts = x.chunks_exact(side).zip(y.chunks_exact(side)).zip(w.chunks_exact(side));
        let depths = z.chunks_exact(side).zip(pz.chunks_exact(side));
        for ((sums, ((x, y), w)), (near, far)) in sums.iter_mut().zip(parts).zip(depths) {
            let mut own = *sums;
            for ((((x, y), w), near), far) in x.iter().zip(y).zip(w).zip(near).zip(far) {
                own.place = [own.place[0] + x, own.place[1] + y, own.place[2] + w];
                own.count += if *far > 0.0 { 1.0 } else { 0.0 };
                own.near = if *near < own.near { *near } else { own.near };
                own.far = if *far > own.far { *far } else { own.far };
            }
            *sums = own;
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
        let mut numbers = [(); 4].map(|()| List::filled(0.0, columns * side));
        let mut all = List::with_capacity(columns);
        let (mut pixels, mut depths) = (List::with_capacity(side * side), List::with_capacity(side * side));
        for row in 0..rows {
            all.clear();
            all.resize(columns, Sums::NONE);
            for (y, points) in lines.iter_mut().enumerate() {
                read_points(row * side + y, 0..columns * side, points);
                Arch::new().dispatch(Line { points, side, numbers: &mut numbers, sums: &mut all });
            }
            for (column, sums) in all.iter().enumerate() {
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
        Self { columns, rows, side, spacing, cells, rays }
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
