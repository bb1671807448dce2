//! The noise of the depth, from the image itself.

use super::grid::Grid;
use crate::memory::List;
use crate::statistics::{DEVIATION_OF_MEDIAN, LOWER_QUARTILE, lower_quartile_absolute, median_absolute};
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

/// How far the cells of a second difference are apart: structured light averages over up to 11 pixels, so that
/// nearer cells share their error. 4 cells of 3 pixels do not. [`DIRECTIONS`] are as long.
const LAG: usize = 4;

constants! {
    /// Where fewer cells than this share an error no window has matched them.
    SHARED = 2.0, "cells";

    /// Fewest second differences that tell something.
    FEWEST = 50.0, "";

    /// The part of the second differences of one sign from which on the image bends to one side: of a plane it is half, of a cylinder along
    /// rows or columns three quarters, of one aslant all.
    BENT = 0.8, "";

    /// Most cells that share an error.
    MOST_SHARED = 16.0, "cells";

    /// Over twice the distance the second differences of errors that wander slowly grow fourfold, those of others stay as they are. From
    /// this factor on the former are more than the latter. Measured: docs/measurements-detection-depth.md, "Depth of networks".
    WANDERS = 2.0, "";

    /// The largest slow error of a surface, in distances: the rest is shape.
    MOST_SLOW = 0.005, "";

    /// Waves bend to both sides alike: where a larger part of the image bends to one side, that is shape.
    BOTH_WAYS = 0.7, "";
}

/// How far the cells of a second difference are apart that shows errors which wander slowly: about the width of a body.
const SLOW: usize = 16;

/// What is known of the noise.
#[derive(Debug, Clone, Copy)]
pub(super) struct Noise {
    /// Standard deviation of 1/z of a cell: constant for structured light, nearly so for time of flight, whose
    /// errors grow as the light that comes back fades.
    pub deviation: f64,
    /// How many cells share one error.
    pub cells_per_sample: f64,
}

/// The directions of second differences where the image bends to one side, in cells: about [`LAG`] long each, and at most 13 degrees
/// from any other.
const DIRECTIONS: [[isize; 2]; 8] = [[4, 0], [4, 2], [3, 3], [2, 4], [0, 4], [-2, 4], [-3, 3], [-4, 2]];

/// Second differences of w, in every other row and in every other column: zero on planes but for noise. Curved surfaces add to
/// the larger ones; the lower quartile, which half of the image may contradict, does not see them.
fn differences(grid: &Grid, w: &[f64], lag: usize) -> List<f64> {
    let (columns, [x, y]) = (grid.columns, &grid.rays);
    let mut found = List::with_capacity(w.len());
    let mut sizes = List::filled(0.0, columns);
    let inner = columns.saturating_sub(2 * lag);
    let three = |first: usize, stride: usize, count: usize| {
        [0, lag * stride, 2 * lag * stride].map(|start| first + start..first + start + count)
    };
    let mut add = |of: [Range<usize>; 3], along: &[f64], step: usize| {
        let sizes = &mut sizes[..of[0].len()];
        let [positions, w] = [along, w].map(|numbers| of.clone().map(|range| &numbers[range]));
        Arch::new().dispatch(Differences { positions, w, sizes });
        found.extend(sizes.iter().step_by(step).copied().filter(|size| !size.is_nan()));
    };
    for row in (0..grid.rows).step_by(2).filter(|_| inner > 0) {
        add(three(row * columns, 1, inner), x, 1);
    }
    for row in 0..grid.rows.saturating_sub(2 * lag) {
        add(three(row * columns, columns, columns), y, 2);
    }
    found
}

/// One pass over cells by three, side by side: their second differences of w, which are no numbers where a cell was not measured.
struct Differences<'a> {
    /// Where they lie in the direction in which they follow each other.
    positions: [&'a [f64]; 3],
    w: [&'a [f64]; 3],
    sizes: &'a mut [f64],
}

impl WithSimd for Differences<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { positions: [pa, pb, pc], w: [wa, wb, wc], sizes } = self;
        let positions = pa.iter().zip(pb).zip(pc);
        for ((size, ((pa, pb), pc)), ((a, b), c)) in
            sizes.iter_mut().zip(positions).zip(wa.iter().zip(wb).zip(wc))
        {
            let measured = (*a > 0.0) & (*b > 0.0) & (*c > 0.0);
            *size = if measured { second_difference([*pa, *pb, *pc], [*a, *b, *c]) } else { f64::NAN };
        }
    }
}

/// The second difference of three values at positions, with the variance of one of them.
#[inline(always)]
pub(super) fn second_difference([pa, pb, pc]: [f64; 3], [a, b, c]: [f64; 3]) -> f64 {
    // The cells are not exactly in the middle of each other.
    let t = (pb - pa) / (pc - pa);
    let weights = (1.0 + t * t + (1.0 - t) * (1.0 - t)).sqrt();
    (b - a - t * (c - a)) / weights
}

/// The least of the lower quartiles of the second differences along [`DIRECTIONS`]. Along the axis a cylinder does not bend, and where it
/// lies aslant neither rows nor columns are along it.
fn least_along(grid: &Grid, w: &[f64]) -> f64 {
    let mut least = f64::INFINITY;
    for [right, down] in DIRECTIONS {
        let stride = down * grid.columns as isize + right;
        let mut found = List::new();
        for row in 0..grid.rows {
            for column in 0..grid.columns {
                let inside = |steps: isize| {
                    let (x, y) = (column as isize + steps * right, row as isize + steps * down);
                    (0..grid.columns as isize).contains(&x) && (0..grid.rows as isize).contains(&y)
                };
                if !(inside(-1) && inside(1)) {
                    continue;
                }
                let middle = row * grid.columns + column;
                let [a, b, c] = [-stride, 0, stride].map(|step| middle.wrapping_add_signed(step));
                if w[a] > 0.0 && w[b] > 0.0 && w[c] > 0.0 {
                    let position = |k: usize| grid.rays[0][k] * right as f64 + grid.rays[1][k] * down as f64;
                    found.push(second_difference([a, b, c].map(position), [a, b, c].map(|k| w[k])));
                }
            }
        }
        if found.len() >= FEWEST.count() {
            least = least.min(lower_quartile_absolute(found.iter().copied()));
        }
    }
    least
}

/// The part of the second differences that have the sign which most have.
fn part_of_one_sign(differences: &[f64]) -> f64 {
    let positive = differences.iter().filter(|difference| **difference > 0.0).count() as f64;
    let count = differences.len() as f64;
    positive.max(count - positive) / count
}

/// The standard deviation of errors that are alike for neighbours but differ over the width of a body, as those of networks and
/// filters; 0 where the second differences do not grow with the distance as those of such errors do, or most bend to one side, as a
/// surface does. Were these errors not noise, each wave would be a surface of its own and end a body.
fn slow_deviation(grid: &Grid, w: &[f64], deviation: f64) -> f64 {
    let scale = |found: &[f64]| lower_quartile_absolute(found.iter().copied()) / LOWER_QUARTILE;
    let near = differences(grid, w, 2 * LAG);
    if near.len() < FEWEST.count() || scale(&near) <= WANDERS.get() * deviation {
        return 0.0;
    }
    let far = differences(grid, w, SLOW);
    if far.len() < FEWEST.count() || part_of_one_sign(&far) > BOTH_WAYS.get() {
        return 0.0;
    }
    scale(&far).min(MOST_SLOW.get() * median_absolute(w.iter().copied().filter(|w| *w > 0.0)))
}

impl Noise {
    /// The noise of a scene, and that of each cell; `None` where too little was measured.
    pub fn of_scene(grid: &mut Grid) -> Option<Self> {
        Self::estimate(grid, slow_deviation)
    }

    /// The same of a body, whose shape is all that changes slowly.
    pub fn of_body(grid: &mut Grid) -> Option<Self> {
        Self::estimate(grid, |_, _, _| 0.0)
    }

    fn estimate(grid: &mut Grid, slow: impl Fn(&Grid, &[f64], f64) -> f64) -> Option<Self> {
        let w: List<f64> = grid.cells.iter().map(|cell| cell.w).collect();
        let far = differences(grid, &w, LAG);
        if far.len() < FEWEST.count() {
            return None;
        }
        let along = if part_of_one_sign(&far) > BENT.get() { least_along(grid, &w) } else { f64::INFINITY };
        let deviation = lower_quartile_absolute(far.iter().copied()).min(along) / LOWER_QUARTILE;
        let deviation = deviation.max(slow(grid, &w, deviation));
        let nearest = median_absolute(differences(grid, &w, 1).iter().copied()) * DEVIATION_OF_MEDIAN;
        // Depth is stored in steps; no estimate is finer than rounding to f32 of the coordinates.
        let deviation = deviation.max(1e-6 * median_absolute(w.iter().copied().filter(|w| *w > 0.0)));
        // Variance of a second difference: σ² (1.5 − 2 ρ₁ + 0.5 ρ₂) / 1.5 with ρ₂ = ρ₁² for errors that fade
        // exponentially: = σ² (1 − ρ₁) (3 − ρ₁) / 3.
        let ratio = (nearest / deviation).powi(2).min(1.0);
        let rho = 2.0 - (1.0 + 3.0 * ratio).sqrt();
        let along = (1.0 + rho) / (1.0 - rho).max(0.1);
        for cell in &mut grid.cells {
            if cell.measured() {
                cell.sigma = deviation / (cell.w * cell.w);
            }
        }
        Some(Self { deviation, cells_per_sample: (along * along).clamp(1.0, MOST_SHARED.get()) })
    }

    /// Whether neighbouring cells share their errors.
    pub fn is_shared(&self) -> bool {
        self.cells_per_sample >= SHARED.get()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detection::grid::Cell;
    use nalgebra::Vector3;

    /// Cells of 3 pixels, 570 to a right angle, by their 1/z at a place of the image.
    fn seen(w: impl Fn(f64, f64) -> f64) -> Grid {
        let (columns, rows, spacing) = (213, 160, 3.0 / 570.0);
        let cell = |k: usize| {
            let x = spacing * ((k % columns) as f64 - 106.0);
            let y = spacing * ((k / columns) as f64 - 80.0);
            let w = w(x, y) * (1.0 + 3e-4 * (((k * 7919) % 101) as f64 / 50.0 - 1.0));
            Cell { x, y, w, point: Vector3::zeros(), sigma: 0.0, fill: 1.0 }
        };
        let cells: Vec<Cell> = (0..columns * rows).map(cell).collect();
        let rays = [|cell: &Cell| cell.x, |cell: &Cell| cell.y].map(|of| cells.iter().map(of).collect());
        Grid { columns, rows, side: 3, spacing, cells, rays, bounds: Default::default(), inner: Vec::new() }
    }

    #[test]
    fn waves_are_noise_and_a_tank_aslant_is_shape() {
        let both = |w: &dyn Fn(f64, f64) -> f64| {
            [Noise::of_scene, Noise::of_body].map(|noise| noise(&mut seen(w)).unwrap().deviation)
        };
        // 0.3 % of the distance over 60 pixels.
        let [scene, body] =
            both(&|x, y| 1.0 + 0.003 * ((60.0 * x).sin() * (55.0 * y).cos() + (40.0 * x - 50.0 * y).sin()));
        assert!(scene > 3.0 * body && scene < 0.006, "{scene} {body}");
        // A radius of 0.3 at 0.8, before a wall and filling the image.
        for wall in [1.0, f64::INFINITY] {
            let [scene, body] = both(&|x, y| {
                let across = 0.5 * x + 0.75_f64.sqrt() * y;
                let (a, b) = (1.0 + across * across, 1.1);
                let square: f64 = b * b - a * (b * b - 0.09);
                let z = if square > 0.0 { (b - square.sqrt()) / a } else { wall.min(3.0) };
                1.0 / z
            });
            assert!(scene < 1.5 * body, "{scene} {body} before {wall}");
        }
    }

    #[test]
    fn differences_are_those_of_one_cell_after_the_other() {
        let (columns, rows) = (13, 11);
        for scale in [0.0, 1e-9, 1.0, 1e9] {
            let cell = |k: usize| {
                let (x, y) = (0.01 * (k % columns) as f64, 0.01 * (k / columns) as f64);
                let w = if k % 17 == 3 { 0.0 } else { scale * (1.0 + 0.001 * ((k * k) % 19) as f64) };
                Cell { x, y: y + 1e-4 * (k % 3) as f64, w, point: Vector3::zeros(), sigma: 0.0, fill: 1.0 }
            };
            let cells: Vec<Cell> = (0..columns * rows).map(cell).collect();
            let rays = [|cell: &Cell| cell.x, |cell: &Cell| cell.y].map(|of| cells.iter().map(of).collect());
            let w: Vec<f64> = cells.iter().map(|cell| cell.w).collect();
            let bounds = Default::default();
            let grid = Grid { columns, rows, side: 3, spacing: 0.01, cells, rays, bounds, inner: Vec::new() };
            for lag in [1, LAG, 6] {
                let mut plain = Vec::new();
                let mut add = |positions: [f64; 3], which: [usize; 3]| {
                    let [a, b, c] = which.map(|k| w[k]);
                    if a > 0.0 && b > 0.0 && c > 0.0 {
                        let t = (positions[1] - positions[0]) / (positions[2] - positions[0]);
                        let weights = (1.0 + t * t + (1.0 - t) * (1.0 - t)).sqrt();
                        plain.push((b - a - t * (c - a)) / weights);
                    }
                };
                for row in (0..rows).step_by(2) {
                    for column in lag..columns.saturating_sub(lag) {
                        let k = row * columns + column;
                        let which = [k - lag, k, k + lag];
                        add(which.map(|k| grid.cells[k].x), which);
                    }
                }
                for row in lag..rows.saturating_sub(lag) {
                    for column in (0..columns).step_by(2) {
                        let k = row * columns + column;
                        let which = [k - lag * columns, k, k + lag * columns];
                        add(which.map(|k| grid.cells[k].y), which);
                    }
                }
                assert_eq!(differences(&grid, &w, lag).to_vec(), plain);
            }
        }
    }
}
