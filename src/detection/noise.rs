//! The noise of the depth, from the image itself.

use super::grid::Grid;
use crate::statistics::{DEVIATION_OF_MEDIAN, median};

/// How far the cells of a second difference are apart: structured light averages over up to 11 pixels, so that
/// nearer cells share their error. 4 cells of 3 pixels do not.
const LAG: usize = 4;

/// The lower quartile of absolute normal errors in standard deviations: 0.3186.
const QUARTILE: f64 = 0.3186;

/// Fewest second differences that tell something.
const FEWEST: usize = 50;

/// What is known of the noise.
#[derive(Debug, Clone, Copy)]
pub(super) struct Noise {
    /// Standard deviation of 1/z of a cell: constant for structured light, nearly so for time of flight, whose
    /// errors grow as the light that comes back fades.
    pub deviation: f64,
    /// How many cells share one error.
    pub cells_per_sample: f64,
}

/// Second differences of w over cells without a step between: zero on planes but for noise. Curved surfaces add to the
/// larger ones; the lower quartile, which half of the image may contradict, does not see them.
fn differences(grid: &Grid, lag: usize) -> Vec<f64> {
    let mut found = Vec::new();
    let strides = [(1, grid.columns, grid.rows), (grid.columns, grid.rows, grid.columns)];
    for (stride, along, lines) in strides {
        let across = if stride == 1 { grid.columns } else { 1 };
        for line in (0..lines).step_by(2) {
            for k in lag..along.saturating_sub(lag) {
                let middle = line * across + k * stride;
                let [a, b, c] =
                    [middle - lag * stride, middle, middle + lag * stride].map(|i| &grid.cells[i]);
                if !(a.measured() && b.measured() && c.measured()) {
                    continue;
                }
                // The cells are not exactly in the middle of each other.
                let t = if stride == 1 { (b.x - a.x) / (c.x - a.x) } else { (b.y - a.y) / (c.y - a.y) };
                let weights = (1.0 + t * t + (1.0 - t) * (1.0 - t)).sqrt();
                found.push(((b.w - a.w - t * (c.w - a.w)) / weights).abs());
            }
        }
    }
    found
}

fn lower_quartile(values: &mut [f64]) -> f64 {
    let quarter = values.len() / 4;
    *values.select_nth_unstable_by(quarter, f64::total_cmp).1
}

impl Noise {
    /// The noise of an image, and that of each cell; `None` where too little was measured.
    pub fn estimate(grid: &mut Grid) -> Option<Self> {
        let mut far = differences(grid, LAG);
        if far.len() < FEWEST {
            return None;
        }
        let deviation = lower_quartile(&mut far) / QUARTILE;
        let mut near = differences(grid, 1);
        let nearest = median(&mut near) * DEVIATION_OF_MEDIAN;
        // Depth is stored in steps; no estimate is finer than rounding to f32 of the coordinates.
        let deviation = deviation.max(1e-6 * median_w(grid));
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
        Some(Self { deviation, cells_per_sample: (along * along).clamp(1.0, 16.0) })
    }
}

fn median_w(grid: &Grid) -> f64 {
    let mut w: Vec<f64> = grid.cells.iter().filter(|c| c.measured()).map(|c| c.w).collect();
    median(&mut w)
}
