//! What an image looks like across a limb: brightness outside and inside, blurred.
//!
//! Outside, the background is a constant, or fades along a slope: a shadow. Inside, the brightness of a convex body is a smooth
//! function of the direction of its normal, and so of the angle θ between the sight line and the tangent
//! plane: 1 − cos θ = u / ρ at the distance u inside the limb of a cylinder of radius ρ pixels. Near the limb
//! sin θ grows as √u, which is why the strongest gradient is not at the limb. For a matt surface and any lights
//! that none of it turns away from, brightness is a + b sin θ + c (1 − cos θ). What is expected of it comes from the
//! inner part of the surface; the two functions correct it. Both sides are blurred by the same Gaussian.

use super::block::{Background, INSIDE, OUTSIDE};
use super::refine::MOST_BLUR;
use super::shading::LimbShading;
use crate::memory::List;
use nalgebra::Vector2;
use pulp::{Arch, Simd, WithSimd};
use std::ops::RangeInclusive;

constants! {
    /// Spacing of the tables in pixels.
    STEP = 0.1, "px";

    /// How far the Gaussian is followed, in units of its standard deviation.
    TAIL = 4.0, "σ";
}

/// How far from their line, in pixels, the pixels in its window may be looked up: the tables reach a cell beyond it.
pub(super) const MARGIN: f64 = 0.09;

pub(super) const FUNCTIONS: usize = 5;

/// The functions of a profile at one u: 1 and the distance from the limb outside; the expected brightness, sin θ and
/// 1 − cos θ inside. The rest is 0, to a whole number of vectors.
pub(super) type Functions = [f64; 8];

pub(super) const SHADED: usize = 11;

/// The profile of a given shading at one u: 1 and the distance from the limb outside, and the brightness inside, with the
/// shading; their derivatives in u; their derivatives in the blur; sin θ and 1 − cos θ inside. The rest is 0, to a whole
/// number of vectors.
pub(super) type ShadedRow = [f64; 12];

/// Which of these there are where the background has one brightness, and no distance counts.
pub(super) const FLAT: [usize; 8] = [0, 2, 3, 5, 6, 8, 9, 10];

/// The profile of a limb with its shading.
pub(super) enum ShadedProfile {
    /// Beside a background of one brightness.
    Flat(Table<[f64; FLAT.len()]>),
    /// Beside one with a slope.
    Sloped(Table<ShadedRow>),
}

/// What a profile is made of, tabulated over u.
#[derive(Debug, Clone)]
pub(super) struct Table<Row: Send + 'static> {
    first: f64,
    rows: List<Row>,
}

/// The functions of one limb without blur, on the inner side: 1, the expected brightness, sin θ and 1 − cos θ. On the
/// outer side they are 0, and the function of the background is 1 less the first one everywhere.
#[derive(Debug, Clone)]
pub(super) struct SharpProfile {
    /// The expected brightness and sin θ; cell k is about u = k · `STEP`.
    cells: List<[f64; 2]>,
    /// One over the radius of the cylinder, in pixels.
    curvature: f64,
}

impl SharpProfile {
    /// For a radius of the cylinder in the image and what the limb is expected to look like; the window may be
    /// widened by `margin` pixels on both sides later.
    pub fn new(radius: f64, shading: &LimbShading, margin: f64) -> Self {
        let taps = (TAIL.get() * MOST_BLUR.get() / STEP.get()).ceil() as i32;
        let (_, last) = window(margin);
        let mut cells = List::with_capacity((last + taps + 1) as usize);
        let mean_sine = sine_up_to(INSIDE.get(), radius) / INSIDE.get();
        let mut before = 0.0;
        for k in 0..=last + taps {
            let (low, high) = cell(k);
            let through = sine_up_to(high, radius);
            let sine = (through - before) / STEP.get();
            before = through;
            // Less its mean over the window, so that the level inside is the mean brightness there.
            let inner = (high - low) / STEP.get();
            cells.push([expected((low, high), radius, shading), sine - mean_sine * inner]);
        }
        Self { cells, curvature: 1.0 / radius }
    }

    /// The functions over the window of a kernel.
    pub fn blurred(&self, kernel: &Kernel) -> Table<Functions> {
        let weights = kernel.weights.iter().map(|[g, ..]| [*g; 4]);
        let cells = self.cells.iter().map(|[expected, sine]| [*expected, *sine, 0.0, 0.0]);
        self.table(cells, (kernel, weights), |[expected, sine, ..], u, inside| {
            let [outside, distance] = background(u, kernel.blur, inside);
            let lean = self.curvature * inside.lean;
            [outside, distance, expected, sine, lean, 0.0, 0.0, 0.0]
        })
    }

    /// The profile over the window, for a blur, a shading and a background.
    pub fn shaded(&self, kernel: &Kernel, shading: &Vector2<f64>, background: Background) -> ShadedProfile {
        match background {
            Background::Flat => ShadedProfile::Flat(self.shaded_table(
                kernel,
                shading,
                |[outside, _, inside],
                 [outside_by_u, _, by_u],
                 [outside_by_blur, _, by_blur],
                 [sine, lean]| {
                    [outside, inside, outside_by_u, by_u, outside_by_blur, by_blur, sine, lean]
                },
            )),
            Background::Sloped => ShadedProfile::Sloped(self.shaded_table(
                kernel,
                shading,
                |[a, b, c], [d, e, f], [g, h, i], [sine, lean]| [a, b, c, d, e, f, g, h, i, sine, lean, 0.0],
            )),
        }
    }

    /// With rows of the levels, their derivatives in u and in the blur, and sin θ and 1 − cos θ.
    fn shaded_table<Row: Send + 'static>(
        &self,
        kernel: &Kernel,
        shading: &Vector2<f64>,
        row: impl Fn([f64; 3], [f64; 3], [f64; 3], [f64; 2]) -> Row,
    ) -> Table<Row> {
        let weights = kernel.weights.iter().map(|[g, slope, by_blur]| [*g, *slope, *by_blur, *g]);
        // That of 1 − cos θ is added to what is blurred.
        let cells = self.cells.iter().map(|[expected, sine]| {
            let inside = expected + shading[0] * sine;
            [inside, inside, inside, *sine]
        });
        let leaning = shading[1] * self.curvature;
        self.table(cells, (kernel, weights), |[level, by_u, by_blur, sine], u, inside| {
            let [outside, distance] = background(u, kernel.blur, inside);
            let levels = [outside, distance, level + leaning * inside.lean];
            let by_u = [-inside.by_u, -outside, by_u + leaning * inside.lean_by_u];
            let by_blur = by_blur + leaning * inside.lean_by_blur;
            let by_blur = [-inside.by_blur, kernel.blur * inside.by_u, by_blur];
            row(levels, by_u, by_blur, [sine, self.curvature * inside.lean])
        })
    }

    /// A table over the window of a kernel: `row` of the sums of the cells by some weights, of u, and of what is known without
    /// them.
    fn table<Row: Send + 'static>(
        &self,
        cells: impl Iterator<Item = Four>,
        (kernel, weights): (&Kernel, impl Iterator<Item = Four>),
        row: impl Fn(Four, f64, &Inside) -> Row,
    ) -> Table<Row> {
        // Some rows reach beyond the cells there are, and the number of weights is odd.
        let mut padded = List::with_capacity(self.cells.len() + 2 * ROWS);
        padded.extend([[0.0; 4]; ROWS - 1]);
        padded.extend(cells);
        padded.extend([[0.0; 4]; ROWS]);
        let mut all_weights = List::with_capacity(kernel.weights.len() + 1);
        all_weights.extend(weights);
        all_weights.push([0.0; 4]);
        let (taps, first_index) = (kernel.taps, kernel.first);
        let mut rows = List::with_capacity(kernel.inside.len());
        for (inside, first) in kernel.inside.chunks(ROWS).zip((first_index..).step_by(ROWS)) {
            // Where the kernel about the last of the rows meets the first cell.
            let left = first + ROWS as i32 - 1 - taps;
            let weights = &all_weights[(-left).clamp(0, 2 * taps + 1) as usize..];
            let sums = Arch::new().dispatch(WeightedSums { weights, cells: &padded[left.max(0) as usize..] });
            let some = inside.iter().zip(sums).zip(first..);
            rows.extend(some.map(|((inside, sums), k)| row(sums, f64::from(k) * STEP.get(), inside)));
        }
        Table { first: f64::from(first_index) * STEP.get(), rows }
    }
}

/// Four numbers: of a cell, or what they are multiplied by.
type Four = [f64; 4];

/// Rows whose sums run side by side: none waits for another, and what the cells are multiplied by is read once.
const ROWS: usize = 4;

/// 1 and the distance from the limb outside of it, blurred: with Φ and φ of the normal distribution, Φ(−u/σ) and
/// σ φ(u/σ) − u Φ(−u/σ).
fn background(u: f64, blur: f64, inside: &Inside) -> [f64; 2] {
    let outside = 1.0 - inside.one;
    [outside, blur * blur * inside.by_u - u * outside]
}

/// A blur: a Gaussian, and what it makes of what all limbs have in common over a window.
pub(super) struct Kernel {
    /// Its standard deviation in pixels.
    blur: f64,
    /// Cells on either side of the middle.
    taps: i32,
    /// g, −g′ and ∂g/∂σ, each normalised by the sum of g so that constants stay constants.
    weights: List<[f64; 3]>,
    /// The first cell of the window, and from there on
    first: i32,
    /// what is linear on the inner side, blurred.
    inside: List<Inside>,
}

/// 1 on the inner side, and 1 − cos θ there for a radius of 1 pixel, blurred, and their derivatives in u and in the blur.
struct Inside {
    one: f64,
    by_u: f64,
    by_blur: f64,
    lean: f64,
    lean_by_u: f64,
    lean_by_blur: f64,
}

impl Kernel {
    /// A blur by its standard deviation in pixels, with a window that is widened by `margin` on both sides.
    pub fn new(blur: f64, margin: f64) -> Self {
        let taps = (TAIL.get() * blur / STEP.get()).ceil() as i32;
        let position = |k: i32| f64::from(k) * STEP.get() / blur;
        // The same on both sides.
        let half: List<f64> = (0..=taps).map(position).map(|x| (-x * x / 2.0).exp()).collect();
        let mut weights = List::with_capacity(2 * taps as usize + 1);
        weights.extend((-taps..=taps).map(|k| {
            let (x, g) = (position(k), half[k.unsigned_abs() as usize]);
            [g, x / blur * g, (x * x - 1.0) / blur * g]
        }));
        let sum: f64 = weights.iter().map(|k| k[0]).sum();
        let drift: f64 = weights.iter().map(|k| k[2]).sum::<f64>() / sum;
        for k in &mut weights {
            *k = [k[0] / sum, k[1] / sum, (k[2] - drift * k[0]) / sum];
        }
        let (first, last) = window(margin);
        let inside = inside(&weights, taps, first..=last);
        Self { blur, taps, weights, first, inside }
    }
}

/// What is linear on the inner side, and 0 outside, blurred by the weights of cells, in some rows: the sums of the cells change
/// by little from row to row.
fn inside(weights: &[[f64; 3]], taps: i32, rows: RangeInclusive<i32>) -> List<Inside> {
    // Of the cells that are on the inner side as a whole: of their weights, and of the weights times how many cells they are from
    // the middle.
    let (mut sums, mut moments) = ([0.0; 3], [0.0; 3]);
    let mut found = List::with_capacity(rows.clone().count());
    for row in (-taps).min(*rows.start())..=*rows.end() {
        let limb = weights.get((taps - row) as usize).copied().unwrap_or_default();
        if rows.contains(&row) {
            // The cell about the limb is half inside, and that half a quarter of a cell from it in the mean.
            let one: [f64; 3] = std::array::from_fn(|i| sums[i] + 0.5 * limb[i]);
            let [lean, lean_by_u, lean_by_blur] = std::array::from_fn(|i| {
                let cells = f64::from(row) * sums[i] + moments[i] + 0.125 * limb[i];
                // Less its mean over the window.
                STEP.get() * cells - 0.5 * INSIDE.get() * one[i]
            });
            let [one, by_u, by_blur] = one;
            found.push(Inside { one, by_u, by_blur, lean, lean_by_u, lean_by_blur });
        }
        for (i, weight) in limb.into_iter().enumerate() {
            sums[i] += weight;
            moments[i] -= f64::from(row) * weight;
        }
    }
    found
}

/// The sums of cells times weights, from each of the first cells on.
struct WeightedSums<'a> {
    /// An odd last one is left out: it is 0.
    weights: &'a [Four],
    cells: &'a [Four],
}

impl WithSimd for WeightedSums<'_> {
    type Output = [Four; ROWS];

    /// With the widest instructions of the machine, two cells side by side; they all round alike.
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [Four; ROWS] {
        // As many as eight numbers are without vectors.
        let mut sums = [[simd.splat_f64s(0.0); 8]; ROWS];
        let [first, second, third, fourth] = [0, 1, 2, 3].map(|row| self.cells[row..].as_chunks::<2>().0);
        let cells = first.iter().zip(second).zip(third.iter().zip(fourth));
        for (weights, ((first, second), (third, fourth))) in self.weights.as_chunks::<2>().0.iter().zip(cells)
        {
            let weights = S::as_simd_f64s(weights.as_flattened()).0;
            for (sums, cells) in sums.iter_mut().zip([first, second, third, fourth]) {
                let cells = S::as_simd_f64s(cells.as_flattened()).0;
                for ((sum, weight), x) in sums.iter_mut().zip(weights).zip(cells) {
                    *sum = simd.add_f64s(*sum, simd.mul_f64s(*x, *weight));
                }
            }
        }
        sums.map(|sums| {
            let mut both = [[0.0; 4]; 2];
            let room = S::as_mut_simd_f64s(both.as_flattened_mut()).0;
            room.iter_mut().zip(sums).for_each(|(both, sum)| *both = sum);
            std::array::from_fn(|k| both[0][k] + both[1][k])
        })
    }
}

/// First and last cell of the window.
fn window(margin: f64) -> (i32, i32) {
    (
        -((OUTSIDE.get() + margin) / STEP.get()).ceil() as i32 - 1,
        ((INSIDE.get() + margin) / STEP.get()).ceil() as i32 + 1,
    )
}

impl<Row: Send + 'static> Table<Row> {
    /// How many rows u is from the first one.
    #[inline(always)]
    pub fn steps_to(&self, u: f64) -> f64 {
        (u - self.first) / STEP.get()
    }

    /// The two rows beside a position so many rows from the first one, and the part of the way from the first to the second; `None`
    /// outside the table.
    #[inline(always)]
    pub fn beside(&self, x: f64) -> Option<(&Row, &Row, f64)> {
        // Rounds towards zero: a negative x is off by its sign alone.
        let k = x as u32;
        let [below, above] = self.rows.get(k as usize..k as usize + 2)? else { return None };
        (x >= 0.0).then_some((below, above, x - f64::from(k)))
    }
}

/// From where to where the part of the cell of index k on the inner side reaches.
fn cell(k: i32) -> (f64, f64) {
    let u = f64::from(k) * STEP.get();
    ((u - STEP.get() / 2.0).max(0.0), (u + STEP.get() / 2.0).max(0.0))
}

/// The integral of sin θ = √(1 − (1 − w)²) with w = u / ρ from 0 to u: ρ/2 (θ − sin θ cos θ).
fn sine_up_to(u: f64, radius: f64) -> f64 {
    let cos = 1.0 - (u / radius).min(1.0);
    let sine = ((1.0 - cos) * (1.0 + cos)).sqrt();
    radius / 2.0 * (cos.acos() - sine * cos)
}

/// The expected brightness without blur, averaged over a cell by its inner part: it has an infinite slope at the limb, as θ has.
fn expected((low, high): (f64, f64), radius: f64, shading: &LimbShading) -> f64 {
    let samples = 8;
    let position = |j: usize| low + (high - low) * (j as f64 + 0.5) / samples as f64;
    let inner = (high - low) / STEP.get();
    if inner > 0.0 {
        inner * (0..samples).map(|j| shading.at(position(j) / radius)).sum::<f64>() / samples as f64
    } else {
        0.0
    }
}
