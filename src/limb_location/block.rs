//! What one short block of a limb says about its line.

use super::consensus::BLOCK_RUNS;
use super::profile::{FUNCTIONS, Functions, SHADED, ShadedRow, Table};
use super::strip::{Strip, StripPixel};
use crate::memory::List;
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

/// From where to where across a line its pixels are looked at, in pixels inside it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Window {
    from: f64,
    to: f64,
}

impl Window {
    /// As far as the profile reaches.
    pub fn full() -> Self {
        Self { from: -OUTSIDE.get(), to: INSIDE.get() }
    }

    /// The outer part of the background, what is about the line, and the inner part of the surface.
    pub fn parts() -> [Self; 3] {
        let Self { from, to } = Self::full();
        let [near_from, near_to] = [from, to].map(|reach| NEAR_PART.get() * reach);
        [(from, near_from), (near_from, near_to), (near_to, to)].map(|(from, to)| Self { from, to })
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
    /// Variance of a pixel about the profile.
    pub variance_of_pixel: f64,
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

/// What the blocks of a limb say with a given line, from the pixels in a window about the line `near`, which is within
/// [`super::profile::MARGIN`] of it.
pub(super) fn shaded_sums(
    strip: &Strip,
    profile: &Table<ShadedRow>,
    line: &StripLine,
    near: &StripLine,
    window: Window,
) -> List<ShadedSums> {
    let mut rows = List::with_capacity(strip.pixels_of_block());
    let mut of_blocks = List::with_capacity(strip.len().div_ceil(BLOCK_RUNS.count()));
    of_blocks.extend(
        blocks(strip).map(|runs| {
            ShadedSums::new(Gather { strip, profile, line, near, window, runs, rows: &mut rows })
        }),
    );
    of_blocks
}

/// The blocks that have enough pixels. `noise` is the standard deviation of a pixel.
pub(super) fn fit_blocks(sums: &[ShadedSums], noise: f64, background: Background) -> List<Block> {
    let enough = sums.iter().filter(|sums| sums.count >= LEAST_PIXELS.count() as f64);
    enough.filter_map(|sums| sums.fit(noise, background)).collect()
}

/// What the blocks say about levels and shading with a given line, from the pixels about the line `near`: the
/// costs of different lines can be compared over the same pixels only.
pub(super) fn sums_of_blocks(
    strip: &Strip,
    profile: &Table<Functions>,
    line: &StripLine,
    near: &StripLine,
) -> List<BlockSums> {
    let mut rows = List::with_capacity(strip.pixels_of_block());
    let sums = |runs| {
        BlockSums::new(Gather { strip, profile, line, near, window: Window::full(), runs, rows: &mut rows })
    };
    let mut of_blocks = List::with_capacity(strip.len().div_ceil(BLOCK_RUNS.count()));
    of_blocks.extend(blocks(strip).filter_map(sums));
    of_blocks
}

/// The runs of each block.
fn blocks(strip: &Strip) -> impl Iterator<Item = Range<usize>> + use<> {
    let count = strip.len();
    (0..count.div_ceil(BLOCK_RUNS.count()))
        .map(move |k| k * BLOCK_RUNS.count()..((k + 1) * BLOCK_RUNS.count()).min(count))
}

/// How far a pixel is inside a line.
#[inline(always)]
fn place(pixel: &StripPixel, line: &StripLine) -> f64 {
    pixel.u - line.at(pixel.s)
}

/// How many of the first pixels of a run are not as far inside a line as a distance. The pixels of a run are about evenly
/// spread: a straight line tells the number nearly.
#[inline(always)]
fn count_before(run: &[StripPixel], line: &StripLine, distance: f64) -> usize {
    let (Some(first), Some(last)) = (run.first(), run.last()) else { return 0 };
    let (first, last) = (place(first, line) - distance, place(last, line) - distance);
    // The conversion holds what is below 0 at 0.
    let mut count = (1.0 + (run.len() - 1) as f64 * first / (first - last)) as u32 as usize;
    count = count.min(run.len());
    while count > 0 && !(place(&run[count - 1], line) - distance < 0.0) {
        count -= 1;
    }
    while count < run.len() && place(&run[count], line) - distance < 0.0 {
        count += 1;
    }
    count
}

/// Sums over the pixels of a block of the products of what the profile says there, and of that with the values: they
/// tell everything about levels, line, blur and shading.
#[derive(Clone, Default)]
pub(super) struct ShadedSums {
    count: f64,
    /// Of the positions along the strip.
    s: f64,
    /// The products; each stands once, in the upper right half. The last row and column are those of the values.
    products: [ShadedRow; SHADED + 1],
}

impl ShadedSums {
    /// Of no pixels where the profile does not reach: the lines that are asked about lie next to each other, so that it reaches all
    /// parts of a window or none.
    fn new(gather: Gather<'_, 12>) -> Self {
        let gathered = Arch::new().dispatch(gather);
        gathered.map_or_else(Self::default, |Gathered { products, count, s }| Self { count, s, products })
    }

    /// Adds those over other pixels of the block.
    pub fn add(&mut self, other: &Self) {
        self.count += other.count;
        self.s += other.s;
        for (row, other) in self.products.iter_mut().zip(&other.products) {
            for (product, other) in row.iter_mut().zip(other) {
                *product += other;
            }
        }
    }

    /// `None` where the levels are not determined.
    fn fit(&self, noise: f64, background: Background) -> Option<Block> {
        let products = SMatrix::<f64, SHADED, SHADED>::from_fn(|i, k| self.products[i.min(k)][i.max(k)]);
        let stiffness = background.stiffness(products[(0, 0)], self.products[0][SHADED], noise);
        let right = SVector::<f64, SHADED>::from_fn(|i, _| self.products[i][SHADED]);
        let of_levels = right.fixed_rows::<LEVELS>(0);
        let mut between_levels = products.fixed_view::<LEVELS, LEVELS>(0, 0).into_owned();
        between_levels[(1, 1)] += stiffness;
        let inverse = between_levels.try_inverse()?;
        let levels: Vector3<f64> = inverse * of_levels;
        let by_unknowns = of_unknowns(&levels, &products).transpose();
        let cross = by_unknowns.fixed_rows::<LEVELS>(0);
        let square: Matrix4<f64> = of_unknowns(&levels, &by_unknowns);
        let gradient: Vector4<f64> = of_unknowns(&levels, &right) - cross.tr_mul(&levels);
        let squares = (self.products[SHADED][SHADED] - of_levels.dot(&levels)).max(0.0);
        let variance_of_pixel = squares / (self.count - (LEVELS + 2) as f64);
        let variance = variance_of_pixel.max(noise * noise);
        let information = (square - cross.tr_mul(&(inverse * cross))) / variance;
        let gradient = gradient / variance;
        let of_line = information[(0, 0)].max(f64::MIN_POSITIVE);
        Some(Block {
            s: self.s / self.count,
            shift: gradient[0] / of_line,
            sigma: (1.0 / of_line).sqrt(),
            weight: 1.0,
            variance_of_pixel,
            information,
            gradient,
        })
    }
}

/// What sums over what the profile says become in (line, blur, shading): the derivatives of the brightness are combinations
/// of what the profile says.
fn of_unknowns<const COLUMNS: usize>(
    levels: &Vector3<f64>,
    sums: &SMatrix<f64, SHADED, COLUMNS>,
) -> SMatrix<f64, 4, COLUMNS> {
    let [outside, slope, inside] = [levels[0], levels[1], levels[2]];
    SMatrix::from_fn(|unknown, k| match unknown {
        0 => -outside * sums[(3, k)] - slope * sums[(4, k)] - inside * sums[(5, k)],
        1 => outside * sums[(6, k)] + slope * sums[(7, k)] + inside * sums[(8, k)],
        2 => inside * sums[(9, k)],
        _ => inside * sums[(10, k)],
    })
}

/// Sums over the pixels of a block, with the widest instructions of the machine; they all round alike. No closure: what is
/// not inlined here does without them.
struct Gather<'a, const WIDTH: usize> {
    strip: &'a Strip,
    profile: &'a Table<[f64; WIDTH]>,
    line: &'a StripLine,
    /// The line that the pixels are near.
    near: &'a StripLine,
    window: Window,
    runs: Range<usize>,
    /// Room for a row a pixel.
    rows: &'a mut List<[f64; WIDTH]>,
}

/// The sums of a block.
struct Gathered<const WIDTH: usize> {
    /// Of the products of the numbers of a row with each other; the right half is enough. The last number that is not
    /// always 0 is the value of the pixel.
    products: [[f64; WIDTH]; WIDTH],
    count: f64,
    /// Of the positions along the strip.
    s: f64,
}

impl<const WIDTH: usize> WithSimd for Gather<'_, WIDTH> {
    /// `None` where the profile does not reach.
    type Output = Option<Gathered<WIDTH>>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Self { strip, profile, line, near, window, runs, rows } = self;
        let of_value = if WIDTH == SHADED + 1 { SHADED } else { FUNCTIONS };
        let (mut count, mut s) = (0, 0.0);
        for run in runs {
            let run = strip.run(run);
            let run = &run[count_before(run, near, window.from)..];
            // Room for all of them at once: in the loop the call would cost more than the pixels.
            if rows.len() < count + run.len() {
                rows.resize(count + run.len(), [0.0; WIDTH]);
            }
            let mut room = rows[count..].iter_mut();
            for pixel in run {
                if place(pixel, near) >= window.to {
                    break;
                }
                // Where white was cut off the profile is not what the light was.
                if pixel.saturated {
                    continue;
                }
                let Some(row) = room.next() else { break };
                let (below, above, part) = profile.beside(place(pixel, line))?;
                let mut numbers = *below;
                for (number, above) in numbers.iter_mut().zip(above) {
                    *number += (above - *number) * part;
                }
                numbers[of_value] = pixel.value;
                *row = numbers;
                s += pixel.s;
                count += 1;
            }
        }
        let rows = &rows[..count];
        let mut products = [[0.0; WIDTH]; WIDTH];
        add_products::<S, WIDTH, 0>(simd, rows, &mut products);
        add_products::<S, WIDTH, 4>(simd, rows, &mut products);
        if WIDTH > 8 {
            add_products::<S, WIDTH, 8>(simd, rows, &mut products);
        }
        Some(Gathered { products, count: count as f64, s })
    }
}

/// The products of four numbers of the rows from `FIRST` on with all from there on: as many sums as the processor holds
/// at once.
#[inline(always)]
fn add_products<S: Simd, const WIDTH: usize, const FIRST: usize>(
    simd: S,
    rows: &[[f64; WIDTH]],
    products: &mut [[f64; WIDTH]; WIDTH],
) {
    let vectors = (WIDTH - FIRST) / S::F64_LANES;
    if vectors * S::F64_LANES != WIDTH - FIRST {
        // No vectors, or too wide ones.
        for row in rows {
            for (products, factor) in products[FIRST..FIRST + 4].iter_mut().zip(&row[FIRST..]) {
                for (product, number) in products[FIRST..].iter_mut().zip(&row[FIRST..]) {
                    *product += factor * number;
                }
            }
        }
        return;
    }
    let mut sums = [[simd.splat_f64s(0.0); WIDTH]; 4];
    for row in rows {
        let numbers = S::as_simd_f64s(&row[FIRST..]).0;
        for (sums, factor) in sums.iter_mut().zip(&row[FIRST..]) {
            let factor = simd.splat_f64s(*factor);
            for (sum, number) in sums.iter_mut().zip(numbers) {
                *sum = simd.add_f64s(*sum, simd.mul_f64s(factor, *number));
            }
        }
    }
    for (products, sums) in products[FIRST..].iter_mut().zip(sums) {
        for (product, sum) in S::as_mut_simd_f64s(&mut products[FIRST..]).0.iter_mut().zip(sums) {
            *product = sum;
        }
    }
}

/// Sums over the pixels of a block, which tell everything about levels and shading.
pub(super) struct BlockSums {
    /// How many pixels there are.
    pub count: f64,
    /// Sums of the products of the functions with each other, of the functions with the values, and of the squared
    /// values.
    functions: SMatrix<f64, FUNCTIONS, FUNCTIONS>,
    right: SVector<f64, FUNCTIONS>,
    squares: f64,
}

impl BlockSums {
    fn new(gather: Gather<'_, 8>) -> Option<Self> {
        let Gathered { products, count, .. } = Arch::new().dispatch(gather)?;
        (count >= LEAST_PIXELS.count() as f64).then(|| Self {
            count,
            functions: SMatrix::from_fn(|i, k| products[i.min(k)][i.max(k)]),
            right: SVector::from_fn(|i, _| products[i][FUNCTIONS]),
            squares: products[FUNCTIONS][FUNCTIONS],
        })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pixels_before_a_line_are_those_that_a_search_finds() {
        let pixel = |u: f64| StripPixel { u, s: 0.3, value: 1.0, saturated: false };
        let even = |k: usize| -6.0 + 0.9 * k as f64;
        let bent = |k: usize| -6.0 + 0.05 * (k * k) as f64;
        let far_off = |k: usize| if k < 12 { -6.0 + 1e-3 * k as f64 } else { 1e6 };
        for place in [even, bent, far_off, |_| 2.0] {
            for length in [0, 1, 2, 15] {
                let run: List<StripPixel> = (0..length).map(|k| pixel(place(k))).collect();
                for limit in [f64::NEG_INFINITY, -7.0, -6.0, -5.5, 0.3, 2.0, 5.0, 1e9] {
                    let found = run.partition_point(|pixel| pixel.u - limit < 0.0);
                    let line = StripLine { offset: limit, slope: 0.0 };
                    assert_eq!(count_before(&run, &line, 0.0), found);
                }
            }
        }
    }
}
