//! The pixels of the blocks of a strip with what a profile says there, and sums over them.

use super::block::{StripLine, Window};
use super::consensus::runs_of_block;
use super::profile::Table;
use super::strip::Strip;
use crate::memory::List;
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

/// The sums of a block.
#[derive(Clone)]
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
    /// Those of no pixels.
    pub fn none() -> Self {
        Self { products: [[0.0; WIDTH]; WIDTH], right: [0.0; WIDTH], squares: 0.0, count: 0.0, s: 0.0 }
    }

    /// Adds those over other pixels of the block.
    pub fn add(&mut self, other: &Self) {
        self.count += other.count;
        self.s += other.s;
        self.squares += other.squares;
        let rows = self.products.iter_mut().zip(&other.products).chain([(&mut self.right, &other.right)]);
        for (row, other) in rows {
            row.iter_mut().zip(other).for_each(|(sum, other)| *sum += other);
        }
    }

    /// Those of each block with a given line, from pixels near it; `None` where the profile does not reach.
    pub fn of_blocks<const COUNT: usize>(
        profile: &Table<[f64; WIDTH]>,
        line: &StripLine,
        near: &Near,
    ) -> impl Iterator<Item = Option<Self>> {
        let most = near.blocks.iter().map(|block| block.pixels.len()).max().unwrap_or_default();
        let (mut rows, mut positions) = (List::filled([0.0; WIDTH], most), List::filled(0.0, most));
        near.blocks.iter().map(move |block| {
            let (rows, positions) = (&mut rows[..], &mut positions[..]);
            let gather = Gather::<WIDTH, COUNT> { profile, line, near, block, rows, positions };
            // Rows of twelve are whole numbers of four alone.
            if WIDTH.is_multiple_of(8) { Arch::new().dispatch(gather) } else { by_fours(gather) }
        })
    }
}

/// The pixels of a strip in a window about a line, block by block: most lines are asked about over the same ones.
#[derive(Default)]
pub(super) struct Near {
    /// The line in the full window that was looked at last.
    line: Option<StripLine>,
    /// Where each of them is along the strip and across it, and its value.
    s: List<f64>,
    u: List<f64>,
    values: List<f64>,
    blocks: List<OfBlock>,
}

/// The pixels of a block, and sums over them of what no line changes: of the positions along the strip, and of the squares of the
/// values.
struct OfBlock {
    pixels: Range<usize>,
    s: f64,
    squares: f64,
}

impl Near {
    pub fn new(strip: &Strip, line: &StripLine, window: Window) -> Self {
        let mut near = Self::default();
        near.fill(strip, line, window);
        near
    }

    /// Looks at the pixels about a line in the full window, unless it has done so.
    pub fn look(&mut self, strip: &Strip, line: &StripLine) {
        if self.line != Some(*line) {
            self.fill(strip, line, Window::full());
            self.line = Some(*line);
        }
    }

    fn fill(&mut self, strip: &Strip, line: &StripLine, window: Window) {
        [&mut self.s, &mut self.u, &mut self.values].into_iter().for_each(|list| list.clear());
        self.blocks.clear();
        for runs in blocks(strip) {
            let first = self.s.len();
            for run in runs {
                let run = strip.run(run);
                let [from, to] = counts_before(run.s, run.u, line, [window.from, window.to]);
                if strip.is_saturated() {
                    // Where white was cut off the profile is not what the light was.
                    for k in (from..to).filter(|k| !run.saturated[*k]) {
                        self.s.push(run.s[k]);
                        self.u.push(run.u[k]);
                        self.values.push(run.values[k]);
                    }
                } else if from < to {
                    self.s.extend_from_slice(&run.s[from..to]);
                    self.u.extend_from_slice(&run.u[from..to]);
                    self.values.extend_from_slice(&run.values[from..to]);
                }
            }
            let pixels = first..self.s.len();
            let (mut s, mut squares) = ([0.0; 4], [0.0; 4]);
            for (some, values) in self.s[pixels.clone()].chunks(4).zip(self.values[pixels.clone()].chunks(4))
            {
                for (k, (position, value)) in some.iter().zip(values).enumerate() {
                    s[k] += position;
                    squares[k] += value * value;
                }
            }
            let [s, squares] = [s, squares].map(|sums| sums.iter().sum());
            self.blocks.push(OfBlock { pixels, s, squares });
        }
    }
}

/// The runs of each block.
pub(super) fn blocks(strip: &Strip) -> impl ExactSizeIterator<Item = Range<usize>> + use<> {
    let count = strip.len();
    let of_block = runs_of_block(count);
    (0..count.div_ceil(of_block)).map(move |k| k * of_block..((k + 1) * of_block).min(count))
}

/// How many of the first pixels of a run, at these positions, are not as far inside a line as either of two distances. The pixels of a
/// run are about evenly spread: a straight line tells the numbers nearly.
#[inline(always)]
fn counts_before(s: &[f64], u: &[f64], line: &StripLine, distances: [f64; 2]) -> [usize; 2] {
    let Some(last) = u.len().checked_sub(1) else { return [0; 2] };
    let s = &s[..=last];
    let position = |k: usize| u[k] - line.at(s[k]);
    let first = position(0);
    let per_step = last as f64 / (position(last) - first);
    let mut counts = [0; 2];
    for (number, distance) in counts.iter_mut().zip(distances) {
        // The conversion holds what is below 0 at 0.
        let mut count = (1.0 + (distance - first) * per_step) as u32 as usize;
        count = count.min(u.len());
        while count > 0 && !(position(count - 1) - distance < 0.0) {
            count -= 1;
        }
        while count < u.len() && position(count) - distance < 0.0 {
            count += 1;
        }
        *number = count;
    }
    counts
}

/// Sums over the pixels of a block with vector instructions, which all round alike. No closure: what is not inlined here does
/// without them.
struct Gather<'a, const WIDTH: usize, const COUNT: usize> {
    /// Its rows have so many functions. The value of a pixel stands behind them where there is room.
    profile: &'a Table<[f64; WIDTH]>,
    line: &'a StripLine,
    near: &'a Near,
    block: &'a OfBlock,
    /// Room for a row and a position a pixel.
    rows: &'a mut [[f64; WIDTH]],
    positions: &'a mut [f64],
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
        let Self { profile, line: StripLine { offset, slope }, near, block, rows, positions } = self;
        let OfBlock { pixels, s, squares } = block;
        let (along, across) = (&near.s[pixels.clone()], &near.u[pixels.clone()]);
        let values = &near.values[pixels.clone()];
        for ((position, s), u) in positions.iter_mut().zip(along).zip(across) {
            *position = profile.steps_to(u - (offset + slope * s));
        }
        for ((row, position), value) in rows.iter_mut().zip(&*positions).zip(values) {
            let (below, above, part) = profile.beside(*position)?;
            let (below, above) = (S::as_simd_f64s(below).0, S::as_simd_f64s(above).0);
            let part = simd.splat_f64s(part);
            for ((number, below), above) in S::as_mut_simd_f64s(row).0.iter_mut().zip(below).zip(above) {
                *number = simd.add_f64s(*below, simd.mul_f64s(simd.sub_f64s(*above, *below), part));
            }
            if COUNT < WIDTH {
                row[COUNT] = *value;
            }
        }
        let rows = &rows[..values.len()];
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
        let mut right = [0.0; WIDTH];
        if COUNT < WIDTH {
            for k in 0..COUNT {
                right[k] = products[k][COUNT];
            }
        } else {
            add_values(simd, rows, values, &mut right);
        }
        Some(Gathered { products, right, squares: *squares, count: values.len() as f64, s: *s })
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
    use crate::limb_location::strip::StripPixel;
    use nalgebra::Vector2;

    /// The sums of each block are to 1e-6 those of its pixels one by one.
    fn compare<const WIDTH: usize, const COUNT: usize>(strip: &Strip, table: &Table<[f64; WIDTH]>) {
        let (line, near) = (StripLine { offset: 0.13, slope: 0.01 }, StripLine { offset: 0.1, slope: 0.01 });
        let near_to = |a: f64, b: f64, size: f64| assert!((a - b).abs() <= 1e-6 * size, "{a} {b}");
        let window = Window::full();
        let looked = Near::new(strip, &near, window);
        let found: Vec<_> = Gathered::of_blocks::<COUNT>(table, &line, &looked).collect();
        assert_eq!(found.len(), blocks(strip).count());
        for (runs, found) in blocks(strip).zip(found) {
            let found = found.unwrap();
            let (mut rows, mut s) = (Vec::new(), 0.0);
            for run in runs.map(|run| strip.run(run)) {
                let position = |k: usize, line: &StripLine| run.u[k] - line.at(run.s[k]);
                let looked_at =
                    |k: &usize| !run.saturated[*k] && (window.from..window.to).contains(&position(*k, &near));
                for k in (0..run.u.len()).filter(looked_at) {
                    let (below, above, part) = table.beside(table.steps_to(position(k, &line))).unwrap();
                    let mut row: Vec<f64> =
                        (0..COUNT).map(|k| below[k] + (above[k] - below[k]) * part).collect();
                    row.push(run.values[k]);
                    rows.push(row);
                    s += run.s[k];
                }
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
        for position in [even, bent, far_off, |_| 2.0] {
            for length in [0, 1, 2, 15] {
                let strip = Strip::of_runs([(0..length).map(|k| pixel(position(k))).collect()].into_iter());
                let run = strip.run(0);
                for limit in [f64::NEG_INFINITY, -7.0, -6.0, -5.5, 0.3, 2.0, 5.0, 1e9] {
                    let found = [0.0, 1.3].map(|far| run.u.partition_point(|u| u - limit - far < 0.0));
                    let line = StripLine { offset: limit, slope: 0.0 };
                    assert_eq!(counts_before(run.s, run.u, &line, [0.0, 1.3]), found);
                }
            }
        }
    }
}
