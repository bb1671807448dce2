//! What one short block of a limb says about its line.

use super::gather::{Gathered, Near};
use super::profile::{FLAT, FUNCTIONS, Functions, SHADED, ShadedProfile, Table};
use crate::memory::List;
use nalgebra::{Matrix2, Matrix3, Matrix4, SMatrix, SVector, Vector2, Vector4};
use std::array;

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
    pub from: f64,
    pub to: f64,
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
#[derive(Debug, Clone, Copy, Default, PartialEq)]
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

/// What the blocks of a limb say with a given line, from the pixels near one that is within [`super::profile::MARGIN`] of it.
pub(super) fn shaded_sums(profile: &ShadedProfile, line: &StripLine, near: &Near) -> ShadedSums {
    // Where the profile does not reach they are of no pixels: the lines that are asked about lie next to each other, so that it
    // reaches all parts of a window or none.
    match profile {
        ShadedProfile::Flat(table) => {
            let sums = Gathered::of_blocks::<{ FLAT.len() }>(table, line, near);
            ShadedSums::Flat(sums.map(|sums| sums.unwrap_or_else(Gathered::none)).collect())
        }
        ShadedProfile::Sloped(table) => {
            let sums = Gathered::of_blocks::<SHADED>(table, line, near);
            ShadedSums::Sloped(sums.map(|sums| sums.unwrap_or_else(Gathered::none)).collect())
        }
    }
}

/// The blocks that have enough pixels. `noise` is the standard deviation of a pixel.
pub(super) fn fit_blocks(sums: &ShadedSums, noise: f64, background: Background) -> List<Block> {
    match sums {
        ShadedSums::Flat(sums) => {
            sums.iter().filter_map(|sums| block::<_, 2>(sums, noise, background)).collect()
        }
        ShadedSums::Sloped(sums) => {
            sums.iter().filter_map(|sums| block::<_, LEVELS>(sums, noise, background)).collect()
        }
    }
}

/// What the blocks say about levels and shading with a given line, from some pixels near it: the costs of different lines can be
/// compared over the same pixels only.
pub(super) fn sums_of_blocks(profile: &Table<Functions>, line: &StripLine, near: &Near) -> List<BlockSums> {
    let sums = Gathered::of_blocks::<FUNCTIONS>(profile, line, near);
    sums.filter_map(|sums| BlockSums::new(&sums?)).collect()
}

/// By block, sums over its pixels of the products of what the profile says there, and of that with the values: they tell everything
/// about levels, line, blur and shading.
#[derive(Clone)]
pub(super) enum ShadedSums {
    /// Without the distance in the background.
    Flat(List<Gathered<{ FLAT.len() }>>),
    Sloped(List<Gathered<12>>),
}

impl ShadedSums {
    /// Adds those over other pixels beside the same background.
    pub fn add(&mut self, other: &Self) {
        match (self, other) {
            (Self::Flat(sums), Self::Flat(other)) => {
                sums.iter_mut().zip(other).for_each(|(sums, other)| sums.add(other));
            }
            (Self::Sloped(sums), Self::Sloped(other)) => {
                sums.iter_mut().zip(other).for_each(|(sums, other)| sums.add(other));
            }
            // A limb has one profile, and so its sums are of one kind.
            _ => {}
        }
    }
}

/// What a block says by the sums over its pixels; `None` where it has too few, or the levels are not determined. Of the levels there
/// are `COUNT`, without the slope outside if that is one less.
fn block<const WIDTH: usize, const COUNT: usize>(
    sums: &Gathered<WIDTH>,
    noise: f64,
    background: Background,
) -> Option<Block> {
    if sums.count < LEAST_PIXELS.count() as f64 {
        return None;
    }
    let product = |i: usize, k: usize| sums.products[i.min(k)][i.max(k)];
    let level = |k: usize| if COUNT < LEVELS { 2 * k } else { k };
    let mut between_levels = Matrix3::zeros();
    for i in 0..COUNT {
        for k in 0..COUNT {
            between_levels[(level(i), level(k))] = product(i, k);
        }
    }
    between_levels[(1, 1)] += background.stiffness(product(0, 0), sums.right[0], noise);
    let inverse = between_levels.try_inverse()?;
    let inverse = SMatrix::<f64, COUNT, COUNT>::from_fn(|i, k| inverse[(level(i), level(k))]);
    let right = SVector::<f64, COUNT>::from_fn(|i, _| sums.right[i]);
    let levels = inverse * right;
    let by_unknowns: [[f64; WIDTH]; 4] = {
        let columns: [[f64; 4]; WIDTH] = array::from_fn(|k| of_unknowns(&levels, |i| product(i, k)));
        array::from_fn(|unknown| columns.map(|column| column[unknown]))
    };
    let cross = SMatrix::<f64, COUNT, 4>::from_fn(|i, unknown| by_unknowns[unknown][i]);
    let square = by_unknowns.map(|row| of_unknowns(&levels, |i| row[i]));
    let square = Matrix4::from_fn(|i, k| square[k][i]);
    let gradient = Vector4::from(of_unknowns(&levels, |i| sums.right[i])) - cross.tr_mul(&levels);
    let squares = (sums.squares - right.dot(&levels)).max(0.0);
    let variance_of_pixel = squares / (sums.count - (LEVELS + 2) as f64);
    let variance = variance_of_pixel.max(noise * noise);
    let information = (square - cross.tr_mul(&(inverse * cross))) / variance;
    let gradient = gradient / variance;
    let of_line = information[(0, 0)].max(f64::MIN_POSITIVE);
    Some(Block {
        s: sums.s / sums.count,
        shift: gradient[0] / of_line,
        sigma: (1.0 / of_line).sqrt(),
        weight: 1.0,
        variance_of_pixel,
        information,
        gradient,
    })
}

/// What numbers of what the profile says become in (line, blur, shading): the derivatives of the brightness are combinations of what
/// the profile says, which stands in the order of the levels, their derivatives in u and in the blur, sin θ and 1 − cos θ.
#[inline(always)]
fn of_unknowns<const COUNT: usize>(levels: &SVector<f64, COUNT>, number: impl Fn(usize) -> f64) -> [f64; 4] {
    let (mut line, mut blur) = (-levels[0] * number(COUNT), levels[0] * number(2 * COUNT));
    for k in 1..COUNT {
        line -= levels[k] * number(COUNT + k);
        blur += levels[k] * number(2 * COUNT + k);
    }
    let inside = levels[COUNT - 1];
    [line, blur, inside * number(3 * COUNT), inside * number(3 * COUNT + 1)]
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
    fn new(Gathered { products, right, squares, count, .. }: &Gathered<8>) -> Option<Self> {
        (*count >= LEAST_PIXELS.count() as f64).then(|| Self {
            count: *count,
            functions: SMatrix::from_fn(|i, k| products[i.min(k)][i.max(k)]),
            right: SVector::from_fn(|i, _| right[i]),
            squares: *squares,
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
