//! How many of the points are independent: the correlation of their residuals between neighbours.
//!
//! Neighbouring pixels of a depth image share matching windows, filters and interpolation. With the correlation ρ at k
//! pixels along rows and columns, 1 + 2 Σ ρ_k neighbours along either count as one, so that N independent points are left
//! of n: N = n / ((1 + 2 Σ ρ_row) (1 + 2 Σ ρ_column)). Which points are neighbours is told by their pixels, or where
//! these are not known by where they are seen; never by the order in which they were pushed.

use crate::geometry::{Cylinder, LocalFrame};
use crate::observations::PointCloud;
use crate::statistics::at_places;
use nalgebra::Vector2;
use pulp::Arch;
use std::sync::OnceLock;

/// A correlation below this is taken as the end of the correlated range, and one below so many of its own
/// standard deviations, 1/√n when there is none: what chance gives few points must not count as correlation.
const UNCORRELATED: f64 = 0.1;
const UNCORRELATED_DEVIATIONS: f64 = 3.0;

/// Longest range of correlation that is looked for, in points: matching windows have up to 11 pixels. What is alike
/// farther apart is no noise but a misfit.
const LONGEST_CORRELATION: usize = 11;

/// Fewest pairs of neighbours that tell a correlation: of fewer even one of 0.5 is chance.
const LEAST_PAIRS: f64 = 36.0;

/// The part of the points that bounds a grid made from where they are: single far points don't widen it.
const CENTRAL_PART: f64 = 0.98;

/// Most cells a point in a grid made from where they are: of points along a slanted line nearly all cells are empty.
const MOST_CELLS: f64 = 64.0;

/// A cell of the grid for a point that lies outside.
const OUTSIDE: u32 = u32::MAX;

/// A column and a row; none of a grid that lies outside.
type Cell = [u32; 2];
const NO_CELL: Cell = [u32::MAX; 2];

/// Points on a rectangular grid.
#[derive(Debug, Clone)]
pub(super) struct Lattice {
    /// The cell of each point.
    cells: Vec<u32>,
    /// One over the number of points in each cell.
    shares: Vec<f32>,
    /// Cells from one row to the next: the columns and, so that rows don't meet, the longest range.
    stride: usize,
    /// 1 for each cell with points, 0 for the others.
    occupied: Vec<f64>,
    /// How many cells have points.
    taken: f64,
    /// By axis and distance the pairs of cells with points, once they have been counted.
    pairs: [[OnceLock<f64>; LONGEST_CORRELATION]; 2],
}

impl Lattice {
    /// The pixels of the points, or, of points that an observer sees, the directions in which they are seen; `None` for
    /// others, whose grid is that of a surface.
    pub fn of_cloud(cloud: &PointCloud, observed: bool) -> Option<Self> {
        if let Some(pixels) = cloud.pixels() {
            return Self::new(pixels);
        }
        if !observed {
            return None;
        }
        let mut positions = Vec::with_capacity(cloud.len());
        for p in cloud.points() {
            if !(p.z > 0.0) {
                return None;
            }
            positions.push(Vector2::new(p.x, p.y) / p.z);
        }
        Self::of_positions(&positions)
    }

    /// The places of points on a cylinder: along the circumference and along the axis.
    pub fn on_surface(cloud: &PointCloud, frame: &LocalFrame) -> Option<Self> {
        let Cylinder { axis, radius } = frame.cylinder;
        let place = |p: nalgebra::Vector3<f64>| {
            let q = p - axis.point;
            Vector2::new(q.dot(&frame.v).atan2(q.dot(&frame.u)) * radius, q.dot(&axis.direction))
        };
        Self::of_positions(&cloud.points().map(place).collect::<Vec<_>>())
    }

    /// A grid with about one position a cell.
    fn of_positions(positions: &[Vector2<f64>]) -> Option<Self> {
        let count = positions.len();
        if count == 0 {
            return None;
        }
        let bounds = [0, 1].map(|axis| {
            let outer = ((1.0 - CENTRAL_PART) / 2.0 * count as f64) as usize;
            let [low, high] = at_places(positions.iter().map(|p| p[axis]), [outer, count - 1 - outer]);
            (low, high)
        });
        let size = bounds.map(|(low, high)| high - low);
        if !(size[0] > 0.0 && size[1] > 0.0 && (size[0] * size[1]).is_finite()) {
            return None;
        }
        let cells = |step: f64| -> Vec<Cell> {
            let per_step = step.recip();
            let cell = |p: &Vector2<f64>| {
                let inside = (0..2).all(|axis| p[axis] >= bounds[axis].0 && p[axis] <= bounds[axis].1);
                let cell = [0, 1].map(|axis| ((p[axis] - bounds[axis].0) * per_step) as u32);
                if inside { cell } else { NO_CELL }
            };
            positions.iter().map(cell).collect()
        };
        // Cells that surely hold several positions tell the area that these cover.
        let area = size[0] * size[1] / count as f64;
        // Points in one row, to rounding, have no more cells than there are points either.
        let shortest = size[0].max(size[1]) / count as f64;
        let coarse = (2.0 * area.sqrt()).max(shortest);
        let in_coarse = cells(coarse);
        let grid = Grid::around(&in_coarse, 0)?;
        let mut taken = Vec::new();
        taken.try_reserve_exact(grid.size).ok()?;
        taken.resize(grid.size, false);
        let inside = in_coarse.iter().filter(|&&cell| cell != NO_CELL);
        inside.for_each(|cell| taken[grid.index(cell)] = true);
        let occupied = taken.iter().filter(|&&taken| taken).count();
        let step = coarse * (occupied as f64 / count as f64).sqrt();
        Self::new(&cells(step.max((area / MOST_CELLS).sqrt()).max(shortest)))
    }

    fn new(cells: &[Cell]) -> Option<Self> {
        let grid = Grid::around(cells, LONGEST_CORRELATION)?;
        let stride = grid.stride;
        let mut shares = Vec::new();
        shares.try_reserve_exact(grid.size).ok()?;
        shares.resize(grid.size, 0.0_f32);
        let index = |cell: &Cell| if *cell == NO_CELL { OUTSIDE } else { grid.index(cell) as u32 };
        let cells: Vec<u32> = cells.iter().map(index).collect();
        cells.iter().filter(|&&cell| cell != OUTSIDE).for_each(|&cell| shares[cell as usize] += 1.0);
        let occupied: Vec<f64> = shares.iter().map(|&count| f64::from(count.min(1.0))).collect();
        let taken = occupied.iter().sum();
        shares.iter_mut().filter(|share| **share > 1.0).for_each(|share| *share = share.recip());
        Some(Self { cells, shares, stride, occupied, taken, pairs: Default::default() })
    }

    /// The number of independent points among those with some residuals; residuals beyond the cutoff are left out.
    pub fn independent_points(&self, residuals: &[f64], cutoff: f64) -> f64 {
        let mut values = vec![0.0; self.shares.len()];
        for (residual, &cell) in residuals.iter().zip(&self.cells) {
            if cell != OUTSIDE && residual.abs() <= cutoff {
                values[cell as usize] += residual * f64::from(self.shares[cell as usize]);
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
                let count = || dot(&self.occupied, &self.occupied[k * step..]);
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
        (residuals.len() as f64 / (range(0) * range(1))).max(1.0)
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
    fn around(cells: &[Cell], gap: usize) -> Option<Self> {
        let (mut low, mut high) = ([u32::MAX; 2], [0; 2]);
        for cell in cells.iter().filter(|&&cell| cell != NO_CELL) {
            for axis in 0..2 {
                low[axis] = low[axis].min(cell[axis]);
                high[axis] = high[axis].max(cell[axis]);
            }
        }
        let [columns, rows] = [0, 1].map(|axis| high[axis].checked_sub(low[axis]));
        let stride = columns? as usize + 1 + gap;
        Some(Self { low, stride, size: stride * (rows? as usize + 1) })
    }

    fn index(&self, [column, row]: &Cell) -> usize {
        (row - self.low[1]) as usize * self.stride + (column - self.low[0]) as usize
    }
}

/// The sum of the products of two sequences as far as both go, in partial sums side by side, so that one addition need
/// not wait for another.
fn dot(first: &[f64], second: &[f64]) -> f64 {
    const LANES: usize = 8;
    let count = first.len().min(second.len());
    let ((first, first_rest), (second, second_rest)) =
        (first[..count].as_chunks::<LANES>(), second[..count].as_chunks::<LANES>());
    // The widest instructions of the machine; they all round alike.
    let lanes = Arch::new().dispatch(|| {
        let mut lanes = [0.0; LANES];
        for (a, b) in first.iter().zip(second) {
            for (lane, (a, b)) in lanes.iter_mut().zip(a.iter().zip(b)) {
                *lane += a * b;
            }
        }
        lanes
    });
    let rest = first_rest.iter().zip(second_rest).map(|(a, b)| a * b);
    lanes.into_iter().chain(rest).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};

    fn noise(count: usize, seed: u64) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        (0..count).map(|_| f64::from(rng.next_u32()) / f64::from(u32::MAX) - 0.5).collect()
    }

    fn grid(columns: usize, rows: usize) -> Vec<[usize; 2]> {
        (0..columns * rows).map(|k| [k % columns, k / columns]).collect()
    }

    fn lattice(cells: &[[usize; 2]]) -> Lattice {
        Lattice::new(&cells.iter().map(|cell| cell.map(|x| x as u32)).collect::<Vec<_>>()).unwrap()
    }

    /// Means over windows of pixels by pixels.
    fn smooth(columns: usize, rows: usize, window: [usize; 2]) -> Vec<f64> {
        let (wide, high) = (columns + window[0], rows + window[1]);
        let raw = noise(wide * high, 1);
        let mean = |cell: &[usize; 2]| -> f64 {
            let inside = (0..window[1]).flat_map(|y| (0..window[0]).map(move |x| [x, y]));
            inside.map(|[x, y]| raw[(cell[1] + y) * wide + cell[0] + x]).sum()
        };
        grid(columns, rows).iter().map(mean).collect()
    }

    #[test]
    fn independent_noise_has_as_many_independent_points_as_points() {
        for (columns, rows) in [(10, 5), (25, 20), (80, 60)] {
            let lattice = lattice(&grid(columns, rows));
            let count = columns * rows;
            let part = |seed: u64| lattice.independent_points(&noise(count, seed), 1.0) / count as f64;
            let mean = (0..200).map(part).sum::<f64>() / 200.0;
            assert!((0.98..=1.0).contains(&mean), "{count}: {mean}");
        }
    }

    #[test]
    fn the_ranges_are_those_of_a_moving_average() {
        // The mean of 5 neighbours has the correlation 1 − k / 5, so that 1 + 2 Σ ρ is 5.
        let residuals = smooth(200, 150, [5, 3]);
        let found = lattice(&grid(200, 150)).independent_points(&residuals, 100.0);
        assert!((found * 15.0 / 30_000.0 - 1.0).abs() < 0.05, "{found}");
    }

    #[test]
    fn points_along_a_line_make_no_large_grid() {
        let count = 10_000;
        for (slope, scatter) in [(1.0, 0.0), (0.0, 1e-6), (0.0, 1e-12), (1e-3, 1e-9)] {
            let along = noise(count, 4).into_iter().zip(noise(count, 5));
            let places: Vec<Vector2<f64>> =
                along.map(|(t, jitter)| Vector2::new(slope * t + scatter * jitter, t)).collect();
            let cells = Lattice::of_positions(&places).map_or(0, |lattice| lattice.shares.len());
            assert!(cells < 100 * count, "{slope} {scatter}: {cells} cells");
        }
    }

    #[test]
    fn the_order_of_the_points_and_the_shape_of_the_region_do_not_matter() {
        let inside = |cell: &[usize; 2]| (cell[0] as f64 - 60.0).hypot(cell[1] as f64 - 50.0) < 45.0;
        let residuals = smooth(120, 100, [4, 4]);
        let points: Vec<([usize; 2], f64)> =
            grid(120, 100).into_iter().zip(residuals).filter(|(cell, _)| inside(cell)).collect();
        let count = |points: &[([usize; 2], f64)]| {
            let cells: Vec<[usize; 2]> = points.iter().map(|point| point.0).collect();
            let residuals: Vec<f64> = points.iter().map(|point| point.1).collect();
            let by_pixels = lattice(&cells).independent_points(&residuals, 100.0);
            let places: Vec<Vector2<f64>> =
                cells.iter().map(|[x, y]| Vector2::new(*x as f64, *y as f64) / 570.0).collect();
            (by_pixels, Lattice::of_positions(&places).unwrap().independent_points(&residuals, 100.0))
        };
        let (by_pixels, by_places) = count(&points);
        assert!((by_pixels * 16.0 / points.len() as f64 - 1.0).abs() < 0.15, "{by_pixels}");
        assert!((by_places / by_pixels - 1.0).abs() < 0.2, "{by_places} {by_pixels}");
        let mut shuffled = points.clone();
        let mut keys = noise(points.len(), 3).into_iter();
        shuffled.sort_by_cached_key(|_| keys.next().map(|key| (key * 1e9) as i64));
        let (a, b) = count(&shuffled);
        assert!((a / by_pixels - 1.0).abs() < 1e-9 && (b / by_places - 1.0).abs() < 1e-9);
    }
}
