//! What one short block of a limb says about its line.

use super::consensus::BLOCK_RUNS;
use super::profile::{FUNCTIONS, Functions, SHADED, ShadedRow, Table};
use super::strip::{Strip, StripPixel};
use nalgebra::{Matrix2, Matrix4, SMatrix, SVector, Vector2, Vector3, Vector4};
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

constants! {
    /// How far the profile reaches outside the limb, in pixels: more meets other things in the background.
    pub(super) OUTSIDE = 4.0, "px";

    /// How far the profile reaches inside the limb, in pixels: more meets labels, and shading turns from what two
    /// coefficients describe.
    pub(super) INSIDE = 3.5, "px";

    /// The part of the reach of the profile that a smaller window has.
    NEAR_PART = 0.5, "";

    /// Standard deviation by which the limb in one block may be off for reasons other than noise, in pixels.
    BLOCK_FLOOR = 0.05, "px";

    /// Fewest pixels of a block: a few per unknown.
    LEAST_PIXELS = 20.0, "px";

    /// Standard deviation of the slope of the background relative to its brightness, per pixel, where it has one: soft
    /// shadows beside a limb fade over some ten pixels or more.
    SLOPE = 0.03, "/px";
}

/// Unknowns of the brightness of a block: the levels outside and inside, and the slope outside.
pub(super) const LEVELS: usize = 3;

/// What the background beside a limb is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Background {
    /// Of one brightness in each block.
    Flat,
    /// With a slope of its own in each block: the edge of a shadow.
    Sloped,
}

impl Background {
    /// What is expected of the slope, as a number to add to its entry of the normal equations: `count` pixels of a
    /// background with the brightness `sum` together, and noise of standard deviation `noise`.
    fn stiffness(self, count: f64, sum: f64, noise: f64) -> f64 {
        match self {
            Self::Flat => 1e12,
            Self::Sloped => (noise / (SLOPE.get() * (sum / count).abs().max(noise))).powi(2),
        }
    }
}

/// How far from a line its pixels are looked at, in pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Window {
    pub outside: f64,
    pub inside: f64,
}

impl Window {
    /// As far as the profile reaches.
    pub fn full() -> Self {
        Self { outside: OUTSIDE.get(), inside: INSIDE.get() }
    }

    /// Windows that leave out the outer part of the background, the inner part of the surface, and both.
    pub fn smaller() -> [Self; 3] {
        let Self { outside, inside } = Self::full();
        let [near_outside, near_inside] = [outside, inside].map(|reach| NEAR_PART.get() * reach);
        [(near_outside, inside), (outside, near_inside), (near_outside, near_inside)]
            .map(|(outside, inside)| Self { outside, inside })
    }
}

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
        self.sigma * self.sigma + BLOCK_FLOOR.get() * BLOCK_FLOOR.get()
    }
}

/// The blocks of a limb with a given line, from the pixels in a window about it. `noise` is the standard deviation of a
/// pixel.
pub(super) fn fit_blocks(
    strip: &Strip,
    noise: f64,
    background: Background,
    profile: &Table<ShadedRow>,
    line: &StripLine,
    window: Window,
) -> Vec<Block> {
    let sums = blocks(strip).filter_map(|runs| ShadedSums::new(strip, profile, line, window, runs));
    sums.filter_map(|sums| sums.fit(noise, background)).collect()
}

/// What the blocks say about levels and shading with a given line, from the pixels between `OUTSIDE` and `INSIDE` of
/// `window`: the costs of different lines can be compared over the same window only.
pub(super) fn sums_of_blocks(
    strip: &Strip,
    profile: &Table<Functions>,
    line: &StripLine,
    window: &StripLine,
) -> Vec<BlockSums> {
    blocks(strip).filter_map(|runs| BlockSums::new(strip, profile, line, window, runs)).collect()
}

/// The runs of each block.
fn blocks(strip: &Strip) -> impl Iterator<Item = Range<usize>> + use<> {
    let count = strip.len();
    (0..count.div_ceil(BLOCK_RUNS.count()))
        .map(move |k| k * BLOCK_RUNS.count()..((k + 1) * BLOCK_RUNS.count()).min(count))
}

/// The pixels of a run in a window about a line. Where white was cut off the profile is not what the light was.
fn pixels_about<'a>(
    run: &'a [StripPixel],
    line: &StripLine,
    window: Window,
) -> impl Iterator<Item = &'a StripPixel> {
    let first = run.partition_point(|pixel| pixel.u - line.at(pixel.s) < -window.outside);
    let run = &run[first..];
    let about = &run[..run.partition_point(|pixel| pixel.u - line.at(pixel.s) <= window.inside)];
    about.iter().filter(|pixel| !pixel.saturated)
}

/// Sums over the pixels of a block of the products of what the profile says there, and of that with the values: they
/// tell everything about levels, line, blur and shading.
struct ShadedSums {
    count: f64,
    /// Of the positions along the strip.
    s: f64,
    /// The products; each stands once, in the upper right half.
    products: [ShadedRow; SHADED],
    right: ShadedRow,
    squares: f64,
}

impl ShadedSums {
    fn new(
        strip: &Strip,
        profile: &Table<ShadedRow>,
        line: &StripLine,
        window: Window,
        runs: Range<usize>,
    ) -> Option<Self> {
        let mut sums = Self {
            count: 0.0,
            s: 0.0,
            products: [[0.0; SHADED]; SHADED],
            right: [0.0; SHADED],
            squares: 0.0,
        };
        Arch::new().dispatch(Gather { sums: &mut sums, strip, profile, line, window, runs })?;
        (sums.count >= LEAST_PIXELS.count() as f64).then_some(sums)
    }

    #[inline(always)]
    #[allow(clippy::needless_range_loop, reason = "i and k are rows and columns")]
    fn add(&mut self, row: &ShadedRow, value: f64) {
        for i in 0..SHADED {
            for k in i..SHADED {
                self.products[i][k] += row[i] * row[k];
            }
        }
        for k in 0..SHADED {
            self.right[k] += row[k] * value;
        }
        self.squares += value * value;
        self.count += 1.0;
    }

    /// `None` where the levels are not determined.
    fn fit(&self, noise: f64, background: Background) -> Option<Block> {
        let products = SMatrix::<f64, SHADED, SHADED>::from_fn(|i, k| self.products[i.min(k)][i.max(k)]);
        let stiffness = background.stiffness(products[(0, 0)], self.right[0], noise);
        let right = SVector::<f64, SHADED>::from(self.right);
        let of_levels = right.fixed_rows::<LEVELS>(0);
        let mut between_levels = products.fixed_view::<LEVELS, LEVELS>(0, 0).into_owned();
        between_levels[(1, 1)] += stiffness;
        let inverse = between_levels.try_inverse()?;
        let levels: Vector3<f64> = inverse * of_levels;
        let [outside, slope, inside] = [levels[0], levels[1], levels[2]];
        // The derivatives of the brightness in (line, blur, shading) as combinations of what the profile says.
        let mut parts = SMatrix::<f64, SHADED, 4>::zeros();
        (parts[(3, 0)], parts[(4, 0)], parts[(5, 0)]) = (-outside, -slope, -inside);
        (parts[(6, 1)], parts[(7, 1)], parts[(8, 1)]) = (outside, slope, inside);
        (parts[(9, 2)], parts[(10, 3)]) = (inside, inside);
        let by_parts = products * parts;
        let cross = by_parts.fixed_rows::<LEVELS>(0);
        let square: Matrix4<f64> = parts.tr_mul(&by_parts);
        let gradient: Vector4<f64> = parts.tr_mul(&right) - cross.tr_mul(&levels);
        let squares = (self.squares - of_levels.dot(&levels)).max(0.0);
        let variance = (squares / (self.count - (LEVELS + 2) as f64)).max(noise * noise);
        let information = (square - cross.tr_mul(&(inverse * cross))) / variance;
        let gradient = gradient / variance;
        let of_line = information[(0, 0)].max(f64::MIN_POSITIVE);
        Some(Block {
            s: self.s / self.count,
            shift: gradient[0] / of_line,
            sigma: (1.0 / of_line).sqrt(),
            weight: 1.0,
            information,
            gradient,
        })
    }
}

/// Adds the pixels of a block to its sums with the widest instructions of the machine; they all round alike. No closure:
/// what is not inlined here does without them.
struct Gather<'a> {
    sums: &'a mut ShadedSums,
    strip: &'a Strip,
    profile: &'a Table<ShadedRow>,
    line: &'a StripLine,
    window: Window,
    runs: Range<usize>,
}

impl WithSimd for Gather<'_> {
    type Output = Option<()>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Option<()> {
        let Self { sums, strip, profile, line, window, runs } = self;
        for run in runs {
            for pixel in pixels_about(strip.run(run), line, window) {
                let row = profile.at(pixel.u - line.at(pixel.s))?;
                sums.add(&row, pixel.value);
                sums.s += pixel.s;
            }
        }
        Some(())
    }
}

/// Sums over the pixels of a block, which tell everything about levels and shading.
pub(super) struct BlockSums {
    /// How many pixels there are.
    pub count: f64,
    /// Sums of the products of the functions with each other, of the functions with the values, and of the squared
    /// values.
    functions: SMatrix<f64, FUNCTIONS, FUNCTIONS>,
    right: Functions,
    squares: f64,
}

impl BlockSums {
    fn new(
        strip: &Strip,
        profile: &Table<Functions>,
        line: &StripLine,
        window: &StripLine,
        runs: Range<usize>,
    ) -> Option<Self> {
        let mut sums =
            Self { count: 0.0, functions: SMatrix::zeros(), right: Functions::zeros(), squares: 0.0 };
        for run in runs.map(|k| strip.run(k)) {
            for pixel in pixels_about(run, window, Window::full()) {
                let f = profile.at(pixel.u - line.at(pixel.s))?;
                sums.count += 1.0;
                sums.functions += f * f.transpose();
                sums.right += f * pixel.value;
                sums.squares += pixel.value * pixel.value;
            }
        }
        (sums.count >= LEAST_PIXELS.count() as f64).then_some(sums)
    }

    /// Sum of squared residuals with the best levels for a shading; `None` where the levels are not determined.
    pub fn squared_residuals(
        &self,
        shading: &Vector2<f64>,
        noise: f64,
        background: Background,
    ) -> Option<f64> {
        // The levels as combinations of the functions.
        let mut parts = SMatrix::<f64, FUNCTIONS, LEVELS>::zeros();
        (parts[(0, 0)], parts[(1, 1)], parts[(2, 2)]) = (1.0, 1.0, 1.0);
        (parts[(3, 2)], parts[(4, 2)]) = (shading[0], shading[1]);
        let right = parts.tr_mul(&self.right);
        let mut normal = parts.tr_mul(&(self.functions * parts));
        normal[(1, 1)] += background.stiffness(self.functions[(0, 0)], self.right[0], noise);
        let levels = normal.try_inverse()? * right;
        Some((self.squares - right.dot(&levels)).max(0.0))
    }

    /// `JᵀJ` and `Jᵀr` over the variance of a pixel in the shading, at no shading, levels eliminated; `None` where the
    /// levels are not determined. `noise` is the standard deviation of a pixel.
    pub fn of_shading(&self, noise: f64, background: Background) -> Option<(Matrix2<f64>, Vector2<f64>)> {
        let mut of_levels = self.functions.fixed_view::<LEVELS, LEVELS>(0, 0).into_owned();
        of_levels[(1, 1)] += background.stiffness(self.functions[(0, 0)], self.right[0], noise);
        let inverse = of_levels.try_inverse()?;
        let levels = inverse * self.right.fixed_rows::<LEVELS>(0);
        let squares = (self.squares - self.right.fixed_rows::<LEVELS>(0).dot(&levels)).max(0.0);
        let variance = (squares / (self.count - (LEVELS + 2) as f64)).max(noise * noise);
        let cross = self.functions.fixed_view::<2, LEVELS>(LEVELS, 0).into_owned();
        let information: Matrix2<f64> = self.functions.fixed_view::<2, 2>(LEVELS, LEVELS).into_owned()
            - cross * inverse * cross.transpose();
        let gradient = self.right.fixed_rows::<2>(LEVELS) - cross * levels;
        Some((information * (levels[2] * levels[2] / variance), gradient * (levels[2] / variance)))
    }
}
