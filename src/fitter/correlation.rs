//! How many of the points are independent: the correlation of their residuals between neighbours.
//!
//! Neighbouring pixels of a depth image share matching windows, filters and interpolation. With the correlation ρ at k
//! pixels along rows and columns, 1 + 2 Σ ρ_k neighbours along either count as one, so that N independent points are left
//! of n: N = n / ((1 + 2 Σ ρ_row) (1 + 2 Σ ρ_column)). Which points are neighbours is told by their pixels, or where
//! these are not known by where they are seen; never by the order in which they were pushed.

use crate::geometry::LocalFrame;
use crate::memory::List;
use crate::observations::{Offsets, PointCloud};
use crate::statistics::at_both_ends;
use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::OnceLock;

/// A correlation below this is taken as the end of the correlated range, and one below so many of its own
/// standard deviations, 1/√n when there is none: what chance gives few points must not count as correlation.
const UNCORRELATED: f64 = 0.1;
const UNCORRELATED_DEVIATIONS: f64 = 3.0;

/// Longest range of correlation that is looked for, in points: matching windows have up to 11 pixels. What is alike
/// farther apart is no noise but lack of fit.
const LONGEST_CORRELATION: usize = 11;

/// Fewest pairs of neighbours that tell a correlation: of fewer even one of 0.5 is chance.
const LEAST_PAIRS: f64 = 36.0;

/// The part of the points that bounds a grid made from where they are: single far points don't widen it.
const CENTRAL_PART: f64 = 0.98;

/// Most cells a point in a grid made from where they are: of points along a slanted line nearly all cells are empty.
const MOST_CELLS: f64 = 64.0;

/// Fewest points a position in the mean where points share their positions.
const SHARED_POSITIONS: usize = 2;

/// A cell of the grid, its column and its row for a point that lies outside.
const OUTSIDE: u32 = u32::MAX;

/// Positions of points on a plane, or columns and rows of their cells: by axis, so that many are looked at side by side.
type Positions = [List<f64>; 2];
type Cells = [List<u32>; 2];

/// How many of them are computed in one go.
const BLOCK: usize = 128;

/// How many products of f32 are added before their sum joins that of all, which is an f64.
const PRODUCTS: usize = 4096;

/// Points on a rectangular grid.
#[derive(Debug, Clone)]
pub(super) struct Lattice {
    /// The cell of each point.
    cells: List<u32>,
    /// One over the number of points in each cell, 0 where there is none.
    shares: List<f32>,
    /// Cells from one row to the next: the columns and, so that rows don't meet, the longest range.
    stride: usize,
    /// How many cells have points, and whether any has several.
    taken: f64,
    shared: bool,
    /// By axis and distance the pairs of cells with points, once they have been counted.
    pairs: [[OnceLock<f64>; LONGEST_CORRELATION]; 2],
}

impl Lattice {
    /// The pixels of the points, or, of points that an observer sees, the directions in which they are seen; `None` for
    /// others, whose grid is that of a surface.
    pub fn of_cloud(cloud: &PointCloud, observed: bool) -> Option<Self> {
        if let Some(pixels) = cloud.pixels() {
            return Self::new([0, 1].map(|axis| pixels.iter().map(|pixel| pixel[axis]).collect()));
        }
        if !observed {
            return None;
        }
        let origin = cloud.origin();
        Self::of_positions(match cloud.offsets() {
            Offsets::F32(axes) => Arch::new().dispatch(Seen { origin, axes }),
            Offsets::F64(axes) => Arch::new().dispatch(Seen { origin, axes }),
        }?)
    }

    /// The positions of points on a cylinder: along the circumference and along the axis.
    pub fn on_surface(cloud: &PointCloud, frame: &LocalFrame) -> Option<Self> {
        let origin = cloud.origin() - frame.cylinder.axis.point;
        Self::of_positions(match cloud.offsets() {
            Offsets::F32(axes) => Arch::new().dispatch(OnSurface { origin, axes, frame }),
            Offsets::F64(axes) => Arch::new().dispatch(OnSurface { origin, axes, frame }),
        })
    }

    /// A grid with about one position a cell. Positions that several points share, as those of a still camera's frames do, count once.
    fn of_positions(positions: Positions) -> Option<Self> {
        let count = positions[0].len();
        if count == 0 {
            return None;
        }
        let outer = ((1.0 - CENTRAL_PART) / 2.0 * count as f64) as usize;
        let bounds = positions.each_ref().map(|positions| at_both_ends(positions, outer));
        let size = bounds.map(|[low, high]| high - low);
        if !(size[0] > 0.0 && size[1] > 0.0 && (size[0] * size[1]).is_finite()) {
            return None;
        }
        let cells =
            |step: f64| Arch::new().dispatch(InCells { positions: &positions, bounds: &bounds, step });
        let occupied = |step: f64| {
            let cells = cells(step);
            let grid = Grid::around(&cells, 0)?;
            let mut taken = List::new();
            taken.try_reserve_exact(grid.size).ok()?;
            taken.resize(grid.size, false);
            let inside = grid.indices(cells).into_iter().filter(|&cell| cell != OUTSIDE);
            inside.for_each(|cell| taken[cell as usize] = true);
            Some(taken.iter().filter(|&&taken| taken).count())
        };
        let mut distinct = count;
        let step = loop {
            // Cells that surely hold several positions tell the area that these cover.
            let area = size[0] * size[1] / distinct as f64;
            // Points in one row, to rounding, have no more cells than there are points either.
            let shortest = size[0].max(size[1]) / distinct as f64;
            let coarse = (2.0 * area.sqrt()).max(shortest);
            let step = coarse * (occupied(coarse)? as f64 / distinct as f64).sqrt();
            let step = step.max((area / MOST_CELLS).sqrt()).max(shortest);
            // Of positions at random 37 of 100 cells are empty.
            let taken = occupied(step)?.max(1);
            // Where smaller cells would part them, it is not that they share positions: a strip that lies aslant has few cells.
            if SHARED_POSITIONS * taken > distinct || 4 * occupied(0.5 * step)? > 5 * taken {
                break step;
            }
            distinct = taken;
        };
        let cells = cells(step);
        // No longer needed, and much memory in a large cloud.
        drop(positions);
        Self::new(cells)
    }

    fn new(cells: Cells) -> Option<Self> {
        let grid = Grid::around(&cells, LONGEST_CORRELATION)?;
        let stride = grid.stride;
        let mut shares = List::new();
        shares.try_reserve_exact(grid.size).ok()?;
        shares.resize(grid.size, 0.0_f32);
        let cells = grid.indices(cells);
        cells.iter().filter(|&&cell| cell != OUTSIDE).for_each(|&cell| shares[cell as usize] += 1.0);
        let taken = shares.iter().filter(|&&count| count > 0.0).count() as f64;
        let shared = shares.iter().any(|&count| count > 1.0);
        shares.iter_mut().for_each(|share| *share = if *share > 1.0 { share.recip() } else { *share });
        Some(Self { cells, shares, stride, taken, shared, pairs: Default::default() })
    }

    /// The number of independent points among those with some residuals; residuals beyond the cutoff are left out.
    pub fn independent_points(&self, residuals: &[f64], cutoff: f64) -> f64 {
        let mut values = List::filled(0.0_f32, self.shares.len());
        let counted = Arch::new().dispatch(Counted { residuals, cutoff });
        for (counted, &cell) in counted.iter().zip(&self.cells) {
            if let Some(value) = values.get_mut(cell as usize) {
                *value += counted;
            }
        }
        if self.shared {
            for (value, share) in values.iter_mut().zip(&self.shares) {
                *value *= *share;
            }
        }
        let variance = dot(&values, &values) / self.taken;
        if !(variance > 0.0) {
            return residuals.len() as f64;
        }
        let range = |axis: usize| -> f64 {
            let step = [1, self.stride][axis];
            let mut range = 1.0;
            for k in 1..=LONGEST_CORRELATION {
                let Some(ahead) = values.get(k * step..) else { break };
                // Most noise is correlated over few neighbours: counted where it is asked for.
                let count = || pairs(&self.shares, &self.shares[k * step..]);
                let pairs = *self.pairs[axis][k - 1].get_or_init(count);
                if pairs < LEAST_PAIRS {
                    break;
                }
                let correlation = dot(&values, ahead) / (pairs * variance);
                if correlation < UNCORRELATED.max(UNCORRELATED_DEVIATIONS / pairs.sqrt()) {
                    break;
                }
                range += 2.0 * correlation;
            }
            range
        };
        // Where points share positions, those of one position have a range of their own.
        let of_position = if SHARED_POSITIONS as f64 * self.taken > residuals.len() as f64 {
            1.0
        } else {
            let [mut sum, mut points] = [0.0, 0.0];
            for (counted, _) in counted.iter().zip(&self.cells).filter(|(_, cell)| **cell != OUTSIDE) {
                sum += f64::from(counted * counted);
                points += 1.0;
            }
            // The variance of the mean of independent residuals is their share of that of one.
            let share = self.shares.iter().map(|&share| f64::from(share)).sum::<f64>() / self.taken;
            (variance / (sum / points * share)).max(1.0)
        };
        (residuals.len() as f64 / (range(0) * range(1) * of_position)).max(1.0)
    }
}

/// The directions in which points are seen from the origin, on the plane z = 1; `None` where one lies behind it.
struct Seen<'a, T> {
    origin: &'a Vector3<f64>,
    axes: [&'a [T]; 3],
}

impl<T: Copy + Into<f64>> WithSimd for Seen<'_, T> {
    type Output = Option<Positions>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Option<Positions> {
        let Self { origin, axes: [x, y, z] } = self;
        let mut behind = 0;
        for z in z {
            behind |= u32::from(!(origin.z + (*z).into() > 0.0));
        }
        if behind != 0 {
            return None;
        }
        let mut positions = [List::with_capacity(z.len()), List::with_capacity(z.len())];
        let mut block = [0.0; BLOCK];
        for ((positions, values), from) in positions.iter_mut().zip([x, y]).zip([origin.x, origin.y]) {
            for (values, z) in values.chunks(BLOCK).zip(z.chunks(BLOCK)) {
                for ((position, value), z) in block.iter_mut().zip(values).zip(z) {
                    *position = (from + (*value).into()) / (origin.z + (*z).into());
                }
                positions.extend_from_slice(&block[..z.len()]);
            }
        }
        Some(positions)
    }
}

/// The positions of points on a cylinder: along the circumference and along the axis.
struct OnSurface<'a, T> {
    /// Where their offsets begin, from the point of the axis.
    origin: Vector3<f64>,
    axes: [&'a [T]; 3],
    frame: &'a LocalFrame,
}

impl<T: Copy + Into<f64>> WithSimd for OnSurface<'_, T> {
    type Output = Positions;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Positions {
        let Self { origin, axes: [x, y, z], frame: LocalFrame { cylinder, u, v, .. } } = self;
        let mut positions = [List::with_capacity(x.len()), List::with_capacity(x.len())];
        let (mut around, mut along) = ([0.0; BLOCK], [0.0; BLOCK]);
        for (x, (y, z)) in x.chunks(BLOCK).zip(y.chunks(BLOCK).zip(z.chunks(BLOCK))) {
            let points = x.iter().zip(y).zip(z);
            for (((x, y), z), (around, along)) in points.zip(around.iter_mut().zip(&mut along)) {
                let q = origin + Vector3::new((*x).into(), (*y).into(), (*z).into());
                *around = cylinder.radius * turn(q.dot(u), q.dot(v));
                *along = q.dot(&cylinder.axis.direction);
            }
            positions[0].extend_from_slice(&around[..x.len()]);
            positions[1].extend_from_slice(&along[..x.len()]);
        }
        positions
    }
}

/// `y.atan2(x)` to 0.0004, by a polynomial for many points side by side. A cell is much wider: of more points than 40,000 a part tells.
#[inline(always)]
fn turn(x: f64, y: f64) -> f64 {
    let (a, b) = (x.abs(), y.abs());
    let t = a.min(b) / a.max(b).max(f64::MIN_POSITIVE);
    let square = t * t;
    let within_octant =
        t * (1.0 + square * (-0.327_622_764 + square * (0.159_314_22 - 0.046_496_474_9 * square)));
    let within_quadrant = if b > a { FRAC_PI_2 - within_octant } else { within_octant };
    let size = if x < 0.0 { PI - within_quadrant } else { within_quadrant };
    size.copysign(y)
}

/// In which cells of a size positions within bounds are.
struct InCells<'a> {
    positions: &'a Positions,
    bounds: &'a [[f64; 2]; 2],
    step: f64,
}

impl WithSimd for InCells<'_> {
    type Output = Cells;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Cells {
        let Self { positions: [x, y], bounds: [[left, right], [top, bottom]], step } = self;
        let per_step = step.recip();
        let mut cells = [List::with_capacity(x.len()), List::with_capacity(x.len())];
        let (mut columns, mut rows) = ([0; BLOCK], [0; BLOCK]);
        for (x, y) in x.chunks(BLOCK).zip(y.chunks(BLOCK)) {
            for (((x, y), column), row) in x.iter().zip(y).zip(&mut columns).zip(&mut rows) {
                let inside = (x >= left) & (x <= right) & (y >= top) & (y <= bottom);
                // There are not more columns or rows than points; an i32 is what vector instructions convert to.
                let at = (((x - left) * per_step) as i32 as u32, ((y - top) * per_step) as i32 as u32);
                (*column, *row) = if inside { at } else { (OUTSIDE, OUTSIDE) };
            }
            cells[0].extend_from_slice(&columns[..x.len()]);
            cells[1].extend_from_slice(&rows[..x.len()]);
        }
        cells
    }
}

/// A rectangle of cells that holds some.
struct Grid {
    low: [u32; 2],
    stride: usize,
    size: usize,
}

impl Grid {
    /// With so many empty cells after each row; `None` for no cells.
    fn around(cells: &Cells, gap: usize) -> Option<Self> {
        let bounds = |cells: &List<u32>| {
            Arch::new().dispatch(|| {
                let (mut low, mut end) = (u32::MAX, 0);
                for cell in cells {
                    low = low.min(*cell);
                    // 0 for what lies outside.
                    end = end.max(cell.wrapping_add(1));
                }
                (low, end)
            })
        };
        let [(left, right), (top, bottom)] = cells.each_ref().map(bounds);
        let (columns, rows) = (right.checked_sub(left)?, bottom.checked_sub(top)?);
        let stride = columns as usize + gap;
        Some(Self { low: [left, top], stride, size: stride * rows as usize })
    }

    /// The positions of cells in the rectangle, row by row.
    fn indices(&self, [mut columns, rows]: Cells) -> List<u32> {
        let ([left, top], stride) = (self.low, self.stride as u32);
        Arch::new().dispatch(|| {
            for (column, row) in columns.iter_mut().zip(&rows) {
                let row = row.wrapping_sub(top).wrapping_mul(stride);
                let index = row.wrapping_add(column.wrapping_sub(left));
                *column = if *column == OUTSIDE { OUTSIDE } else { index };
            }
        });
        columns
    }
}

/// How many numbers of two sequences are both positive, as far as both go.
fn pairs(first: &[f32], second: &[f32]) -> f64 {
    let count = || first.iter().zip(second).map(|(a, b)| u32::from((*a > 0.0) & (*b > 0.0))).sum::<u32>();
    f64::from(Arch::new().dispatch(count))
}

/// Residuals in units of a cutoff, 0 beyond it.
struct Counted<'a> {
    residuals: &'a [f64],
    cutoff: f64,
}

impl WithSimd for Counted<'_> {
    type Output = List<f32>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> List<f32> {
        let Self { residuals, cutoff } = self;
        let unit = cutoff.recip();
        let mut counted = List::with_capacity(residuals.len());
        let mut block = [0.0; BLOCK];
        for residuals in residuals.chunks(BLOCK) {
            for (counted, residual) in block.iter_mut().zip(residuals) {
                let inside = if residual.abs() <= cutoff { *residual } else { 0.0 };
                *counted = (inside * unit) as f32;
            }
            counted.extend_from_slice(&block[..residuals.len()]);
        }
        counted
    }
}

/// The sum of the products of two sequences as far as both go: of blocks, in each of which partial sums run side by side.
fn dot(first: &[f32], second: &[f32]) -> f64 {
    let count = first.len().min(second.len());
    Arch::new().dispatch(Dot { first: &first[..count], second: &second[..count] })
}

/// Two sequences of the same length.
struct Dot<'a> {
    first: &'a [f32],
    second: &'a [f32],
}

impl WithSimd for Dot<'_> {
    type Output = f64;

    /// With the widest instructions of the machine; they all round alike.
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        const LANES: usize = 32;
        let mut sum = 0.0;
        for (first, second) in self.first.chunks(PRODUCTS).zip(self.second.chunks(PRODUCTS)) {
            let ((first, first_rest), (second, second_rest)) =
                (first.as_chunks::<LANES>(), second.as_chunks::<LANES>());
            // As many as there are lanes without vectors.
            let mut sums = [simd.splat_f32s(0.0); LANES];
            for (a, b) in first.iter().zip(second) {
                let pairs = S::as_simd_f32s(a).0.iter().zip(S::as_simd_f32s(b).0);
                for (sum, (a, b)) in sums.iter_mut().zip(pairs) {
                    *sum = simd.add_f32s(*sum, simd.mul_f32s(*a, *b));
                }
            }
            let mut lanes = [0.0; LANES];
            for (lanes, sum) in S::as_mut_simd_f32s(&mut lanes).0.iter_mut().zip(sums) {
                *lanes = sum;
            }
            for (lane, (a, b)) in lanes.iter_mut().zip(first_rest.iter().zip(second_rest)) {
                *lane += a * b;
            }
            for lane in lanes {
                sum += f64::from(lane);
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests;
