//! The pixels of the blocks of a strip with what a profile says there, and sums over them.

use super::block::{StripLine, Window};
use super::consensus::runs_of_block;
use super::profile::Table;
use super::strip::{Strip, StripPixel};
use crate::memory::List;
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

/// The sums of a block.
pub(super) struct Gathered<const WIDTH: usize> {
    /// Of the products of the numbers of a row with each other; the right half is enough.
    pub products: [[f64; WIDTH]; WIDTH],
    /// Of their products with the values of the pixels.
    pub right: [f64; WIDTH],
    /// Of the squares of the values.
    pub squares: f64,
    pub count: f64,
    /// Of the positions along the strip.
    pub s: f64,
}

impl<const WIDTH: usize> Gathered<WIDTH> {
    /// Those of each block; `None` where the profile does not reach.
    pub fn of_blocks<const COUNT: usize>(
        strip: &Strip,
        profile: &Table<[f64; WIDTH]>,
        line: &StripLine,
        near: &StripLine,
        window: Window,
    ) -> impl Iterator<Item = Option<Self>> {
        let pixels = strip.pixels_of_block();
        let (mut rows, mut values) = (List::with_capacity(pixels), List::with_capacity(pixels));
        blocks(strip).map(move |runs| {
            let (rows, values) = (&mut rows, &mut values);
            let gather = Gather::<WIDTH, COUNT> { strip, profile, line, near, window, runs, rows, values };
            // Rows of twelve are whole numbers of four alone.
            if WIDTH.is_multiple_of(8) { Arch::new().dispatch(gather) } else { by_fours(gather) }
        })
    }
}

/// The runs of each block.
pub(super) fn blocks(strip: &Strip) -> impl ExactSizeIterator<Item = Range<usize>> + use<> {
    let count = strip.len();
    let of_block = runs_of_block(count);
    (0..count.div_ceil(of_block)).map(move |k| k * of_block..((k + 1) * of_block).min(count))
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

/// Sums over the pixels of a block with vector instructions, which all round alike. No closure: what is not inlined here does
/// without them.
struct Gather<'a, const WIDTH: usize, const COUNT: usize> {
    strip: &'a Strip,
    /// Its rows have so many functions. The value of a pixel stands behind them where there is room.
    profile: &'a Table<[f64; WIDTH]>,
    line: &'a StripLine,
    /// The line that the pixels are near.
    near: &'a StripLine,
    window: Window,
    runs: Range<usize>,
    /// Room for a row and a value a pixel.
    rows: &'a mut List<[f64; WIDTH]>,
    values: &'a mut List<f64>,
}

/// Works with instructions of four numbers on machines with wider ones, too.
fn by_fours<W: WithSimd>(work: W) -> W::Output {
    match Arch::new() {
        #[cfg(target_arch = "x86_64")]
        Arch::V4(wider) => Simd::vectorize(*wider, work),
        narrower => narrower.dispatch(work),
    }
}

impl<const WIDTH: usize, const COUNT: usize> WithSimd for Gather<'_, WIDTH, COUNT> {
    /// `None` where the profile does not reach.
    type Output = Option<Gathered<WIDTH>>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Self { strip, profile, line, near, window, runs, rows, values } = self;
        let (mut count, mut s) = (0, 0.0);
        for run in runs {
            let run = strip.run(run);
            let run = &run[count_before(run, near, window.from)..];
            // Room for all of them at once: in the loop the call would cost more than the pixels.
            if rows.len() < count + run.len() {
                rows.resize(count + run.len(), [0.0; WIDTH]);
            }
            if COUNT == WIDTH && values.len() < rows.len() {
                values.resize(rows.len(), 0.0);
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
                let (below, above) = (S::as_simd_f64s(below).0, S::as_simd_f64s(above).0);
                let part = simd.splat_f64s(part);
                for ((number, below), above) in S::as_mut_simd_f64s(row).0.iter_mut().zip(below).zip(above) {
                    *number = simd.add_f64s(*below, simd.mul_f64s(simd.sub_f64s(*above, *below), part));
                }
                if COUNT < WIDTH {
                    row[COUNT] = pixel.value;
                } else {
                    values[count] = pixel.value;
                }
                s += pixel.s;
                count += 1;
            }
        }
        let rows = &rows[..count];
        let mut products = [[0.0; WIDTH]; WIDTH];
        if S::F64_LANES > 4 {
            add_products::<S, WIDTH, COUNT, 0, WIDTH>(simd, rows, &mut products);
        } else {
            add_products::<S, WIDTH, COUNT, 0, 4>(simd, rows, &mut products);
            add_products::<S, WIDTH, COUNT, 4, 4>(simd, rows, &mut products);
            if WIDTH > 8 {
                add_products::<S, WIDTH, COUNT, 8, 4>(simd, rows, &mut products);
            }
        }
        let (mut right, mut squares) = ([0.0; WIDTH], 0.0);
        if COUNT < WIDTH {
            for k in 0..COUNT {
                right[k] = products[k][COUNT];
            }
            squares = products[COUNT][COUNT];
        } else {
            let values = &values[..count];
            add_values(simd, rows, values, &mut right);
            for value in values {
                squares += value * value;
            }
        }
        Some(Gathered { products, right, squares, count: count as f64, s })
    }
}

/// The products of the values with the numbers of the rows.
#[inline(always)]
fn add_values<S: Simd, const WIDTH: usize>(
    simd: S,
    rows: &[[f64; WIDTH]],
    values: &[f64],
    right: &mut [f64; WIDTH],
) {
    let mut sums = [simd.splat_f64s(0.0); WIDTH];
    for (row, value) in rows.iter().zip(values) {
        let value = simd.splat_f64s(*value);
        for (sum, number) in sums.iter_mut().zip(S::as_simd_f64s(row).0) {
            *sum = simd.add_f64s(*sum, simd.mul_f64s(value, *number));
        }
    }
    for (right, sum) in S::as_mut_simd_f64s(right).0.iter_mut().zip(sums) {
        *right = sum;
    }
}

/// The products of `FACTORS` numbers of the rows from `FIRST` on with all from there on: as many sums as the processor holds
/// at once. What fills the rows up beyond the functions and the value is no factor.
#[inline(always)]
fn add_products<S: Simd, const WIDTH: usize, const COUNT: usize, const FIRST: usize, const FACTORS: usize>(
    simd: S,
    rows: &[[f64; WIDTH]],
    products: &mut [[f64; WIDTH]; WIDTH],
) {
    // Rows are whole numbers of four.
    assert!((WIDTH - FIRST).is_multiple_of(S::F64_LANES), "instructions that are too wide");
    let mut sums = [[simd.splat_f64s(0.0); WIDTH]; FACTORS];
    for row in rows {
        let numbers = S::as_simd_f64s(&row[FIRST..]).0;
        for (sums, factor) in sums.iter_mut().zip(&row[FIRST..WIDTH.min(COUNT + 1)]) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limb_location::block::Background;
    use crate::limb_location::profile::{FLAT, Kernel, SHADED, ShadedProfile, SharpProfile};
    use crate::limb_location::shading::LimbShading;
    use nalgebra::Vector2;

    /// The sums of each block are to 1e-6 those of its pixels one by one.
    fn compare<const WIDTH: usize, const COUNT: usize>(strip: &Strip, table: &Table<[f64; WIDTH]>) {
        let (line, near) = (StripLine { offset: 0.13, slope: 0.01 }, StripLine { offset: 0.1, slope: 0.01 });
        let near_to = |a: f64, b: f64, size: f64| assert!((a - b).abs() <= 1e-6 * size, "{a} {b}");
        let window = Window::full();
        let found: Vec<_> = Gathered::of_blocks::<COUNT>(strip, table, &line, &near, window).collect();
        assert_eq!(found.len(), blocks(strip).count());
        for (runs, found) in blocks(strip).zip(found) {
            let found = found.unwrap();
            let looked_at = |pixel: &&StripPixel| {
                let place = place(pixel, &near);
                !pixel.saturated && place >= window.from && place < window.to
            };
            let (mut rows, mut s) = (Vec::new(), 0.0);
            for pixel in runs.flat_map(|run| strip.run(run)).filter(looked_at) {
                let (below, above, part) = table.beside(place(pixel, &line)).unwrap();
                let mut row: Vec<f64> = (0..COUNT).map(|k| below[k] + (above[k] - below[k]) * part).collect();
                row.push(pixel.value);
                rows.push(row);
                s += pixel.s;
            }
            assert_eq!(found.count, rows.len() as f64);
            near_to(found.s, s, 1e3);
            let sum = |i: usize, k: usize| rows.iter().map(|row| row[i] * row[k]).sum::<f64>();
            let size = |i: usize, k: usize| (sum(i, i) * sum(k, k)).sqrt();
            for i in 0..COUNT {
                for k in i..COUNT {
                    near_to(found.products[i][k], sum(i, k), size(i, k));
                }
                near_to(found.right[i], sum(i, COUNT), size(i, COUNT));
            }
            near_to(found.squares, sum(COUNT, COUNT), sum(COUNT, COUNT));
        }
    }

    #[test]
    fn sums_are_those_of_single_pixels_for_ordinary_huge_tiny_and_no_values() {
        let sharp = SharpProfile::new(30.0, &LimbShading::plain(0.3), 0.0);
        for size in [1.0, 1e60, 1e-60, 0.0] {
            let pixel = |run: usize, k: usize| StripPixel {
                s: run as f64 - 9.5,
                u: 0.7 * k as f64 - 8.0 + 0.03 * run as f64,
                value: size * ((7 * run + 5 * k) % 13) as f64,
                saturated: (run + k).is_multiple_of(11),
            };
            let strip = Strip::of_runs((0..19).map(|run| (0..24).map(|k| pixel(run, k)).collect()));
            for background in [Background::Flat, Background::Sloped] {
                match sharp.shaded(&Kernel::new(0.8, 0.0), &Vector2::new(0.1, -0.2), background) {
                    ShadedProfile::Flat(table) => compare::<_, { FLAT.len() }>(&strip, &table),
                    ShadedProfile::Sloped(table) => compare::<_, SHADED>(&strip, &table),
                }
            }
        }
    }

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
