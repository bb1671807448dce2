//! What one short block of a limb says about its line.

use super::consensus::BLOCK_RUNS;
use super::profile::{Profile, ProfileRow};
use super::strip::Strip;
use nalgebra::{Matrix2, Matrix4, SMatrix, Vector2, Vector4};
use std::ops::Range;

/// How far the profile reaches outside the limb, in pixels: more meets other things in the background.
pub(super) const OUTSIDE: f64 = 4.0;

/// How far the profile reaches inside the limb, in pixels: more meets labels, and shading turns from what two
/// coefficients describe.
pub(super) const INSIDE: f64 = 3.5;

/// Standard deviation by which the limb in one block may be off for reasons other than noise, in pixels.
const BLOCK_FLOOR: f64 = 0.05;

/// Fewest pixels of a block: a few per unknown.
const LEAST_PIXELS: usize = 20;

/// A line across a strip: u = offset + slope · s.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct StripLine {
    pub offset: f64,
    pub slope: f64,
}

impl StripLine {
    pub fn at(&self, s: f64) -> f64 {
        self.offset + self.slope * s
    }

    /// (offset, slope).
    pub fn vector(&self) -> Vector2<f64> {
        Vector2::new(self.offset, self.slope)
    }
}

/// A limb line and the shading inside it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LimbState {
    pub line: StripLine,
    /// Coefficients of sin θ and 1 − cos θ, relative to the level inside: what is not as expected.
    pub shading: Vector2<f64>,
}

/// What one block says about the line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block {
    /// Mean position along the strip.
    pub s: f64,
    /// Where the block sees the limb, relative to the line, in pixels.
    pub shift: f64,
    /// Standard deviation of `shift` in pixels, at the shading and blur of all blocks together.
    pub sigma: f64,
    /// What is left of the block in the fit of the line, 0 to 1.
    pub weight: f64,
    /// `JᵀJ` and `Jᵀr` over the variance of a pixel, in (line, blur, shading), levels eliminated.
    pub information: Matrix4<f64>,
    pub gradient: Vector4<f64>,
}

impl Block {
    /// Variance of `shift` with everything that is not noise.
    pub fn variance(&self) -> f64 {
        self.sigma * self.sigma + BLOCK_FLOOR * BLOCK_FLOOR
    }
}

/// The blocks of a limb in some state, from the pixels between `OUTSIDE` and `INSIDE` of `window`: the costs of
/// different states can be compared over the same window only. `noise` is the standard deviation of a pixel.
pub(super) fn fit_blocks(
    strip: &Strip,
    noise: f64,
    profile: &Profile,
    state: &LimbState,
    window: &StripLine,
) -> Vec<Block> {
    let pixels = blocks(strip).filter_map(|runs| BlockPixels::new(strip, profile, state, window, runs));
    pixels.map(|pixels| pixels.fit(noise, &state.shading)).collect()
}

/// Count and sum of squared residuals of each of these blocks.
pub(super) fn squares(
    strip: &Strip,
    profile: &Profile,
    state: &LimbState,
    window: &StripLine,
) -> Vec<(f64, f64)> {
    let squares = |pixels: BlockPixels| (pixels.rows.len() as f64, pixels.residuals().map(|e| e * e).sum());
    blocks(strip)
        .filter_map(|runs| BlockPixels::new(strip, profile, state, window, runs))
        .map(squares)
        .collect()
}

/// The runs of each block.
fn blocks(strip: &Strip) -> impl Iterator<Item = Range<usize>> + use<> {
    let count = strip.len();
    (0..count.div_ceil(BLOCK_RUNS)).map(move |k| k * BLOCK_RUNS..((k + 1) * BLOCK_RUNS).min(count))
}

/// The pixels of a block, and its two levels.
struct BlockPixels {
    /// What the profile says at each pixel, its brightness inside with the shading, and the value of the pixel.
    rows: Vec<(ProfileRow, f64, f64)>,
    /// Mean position along the strip.
    s: f64,
    /// Inverse of the normal matrix of the levels.
    inverse: Matrix2<f64>,
    /// Brightness outside and inside.
    levels: Vector2<f64>,
}

impl BlockPixels {
    fn new(
        strip: &Strip,
        profile: &Profile,
        state: &LimbState,
        window: &StripLine,
        runs: Range<usize>,
    ) -> Option<Self> {
        let LimbState { line, shading } = state;
        let mut rows = Vec::with_capacity(128);
        let mut sum_s = 0.0;
        let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
        for pixel in runs.flat_map(|k| strip.run(k)) {
            // Where white was cut off the profile is not what the light was.
            if !pixel.saturated && (-OUTSIDE..=INSIDE).contains(&(pixel.u - window.at(pixel.s))) {
                let row = profile.at(pixel.u - line.at(pixel.s))?;
                let [outer, inner, sine, lean] = row.values;
                let inside = inner + shading[0] * sine + shading[1] * lean;
                let f = Vector2::new(outer, inside);
                normal += f * f.transpose();
                right += f * pixel.value;
                rows.push((row, inside, pixel.value));
                sum_s += pixel.s;
            }
        }
        if rows.len() < LEAST_PIXELS {
            return None;
        }
        let inverse = normal.try_inverse()?;
        Some(Self { s: sum_s / rows.len() as f64, rows, inverse, levels: inverse * right })
    }

    fn residuals(&self) -> impl Iterator<Item = f64> {
        let levels = self.levels;
        self.rows
            .iter()
            .map(move |(row, inside, value)| value - row.values[0] * levels[0] - inside * levels[1])
    }

    fn fit(&self, noise: f64, shading: &Vector2<f64>) -> Block {
        let Self { rows, inverse, levels, .. } = self;
        let count = rows.len() as f64;
        let coefficients = Vector4::new(levels[0], levels[1], levels[1] * shading[0], levels[1] * shading[1]);
        let mut cross = SMatrix::<f64, 2, 4>::zeros();
        let (mut square, mut gradient, mut squares) = (Matrix4::zeros(), Vector4::zeros(), 0.0);
        for ((row, inside, _), residual) in rows.iter().zip(self.residuals()) {
            let [outer, _, sine, lean] = row.values;
            let j = Vector4::new(
                -coefficients.dot(&Vector4::from(row.slopes)),
                coefficients.dot(&Vector4::from(row.blur_slopes)),
                levels[1] * sine,
                levels[1] * lean,
            );
            cross += Vector2::new(outer, *inside) * j.transpose();
            square += j * j.transpose();
            gradient += j * residual;
            squares += residual * residual;
        }
        let variance = (squares / (count - 4.0)).max(noise * noise);
        let information = (square - cross.transpose() * inverse * cross) / variance;
        let gradient = gradient / variance;
        let of_line = information[(0, 0)].max(f64::MIN_POSITIVE);
        Block {
            s: self.s,
            shift: gradient[0] / of_line,
            sigma: (1.0 / of_line).sqrt(),
            weight: 1.0,
            information,
            gradient,
        }
    }
}
