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
use nalgebra::{Vector2, Vector4};
use pulp::{Arch, Simd, WithSimd};

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
    /// Cell k is about u = k · `STEP`.
    cells: List<Vector4<f64>>,
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
            cells.push(sharp((low, high), radius, shading, [sine, mean_sine]));
        }
        Self { cells }
    }

    /// The functions over the window widened by `margin` on both sides, for a blur (standard deviation in pixels).
    pub fn blurred(&self, blur: f64, margin: f64) -> Table<Functions> {
        let kernel = kernel(blur).into_iter().map(|[g, slope, _]| [[g; 4], [slope; 4]]);
        let cells = self.cells.iter().map(|cell| [(*cell).into(); 2]);
        table(cells, &kernel.collect::<List<_>>(), margin, |u, [values, slopes]| {
            let [outside, distance] = background(u, blur, values[0], slopes[0]);
            [outside, distance, values[1], values[2], values[3], 0.0, 0.0, 0.0]
        })
    }

    /// The profile over the window, for a blur, a shading and a background.
    pub fn shaded(&self, blur: f64, shading: &Vector2<f64>, background: Background) -> ShadedProfile {
        match background {
            Background::Flat => ShadedProfile::Flat(self.shaded_table(
                blur,
                shading,
                |[outside, _, inside],
                 [outside_by_u, _, by_u],
                 [outside_by_blur, _, by_blur],
                 [sine, lean]| {
                    [outside, inside, outside_by_u, by_u, outside_by_blur, by_blur, sine, lean]
                },
            )),
            Background::Sloped => ShadedProfile::Sloped(self.shaded_table(
                blur,
                shading,
                |[a, b, c], [d, e, f], [g, h, i], [sine, lean]| [a, b, c, d, e, f, g, h, i, sine, lean, 0.0],
            )),
        }
    }

    /// With rows of the levels, their derivatives in u and in the blur, and sin θ and 1 − cos θ.
    fn shaded_table<Row: Send + 'static>(
        &self,
        blur: f64,
        shading: &Vector2<f64>,
        row: impl Fn([f64; 3], [f64; 3], [f64; 3], [f64; 2]) -> Row,
    ) -> Table<Row> {
        let kernel =
            kernel(blur).into_iter().map(|[g, slope, by_blur]| [[g; 4], [slope, slope, by_blur, by_blur]]);
        let cells = self.cells.iter().map(|cell| {
            let (one, sine, lean) = (cell[0], cell[2], cell[3]);
            let inside = cell[1] + shading[0] * sine + shading[1] * lean;
            [[one, inside, sine, lean], [one, inside, one, inside]]
        });
        table(cells, &kernel.collect::<List<_>>(), 0.0, |u, [values, slopes]| {
            let [one, inside, sine, lean] = values;
            let [one_by_u, inside_by_u, one_by_blur, inside_by_blur] = slopes;
            let [outside, distance] = background(u, blur, one, one_by_u);
            let levels = [outside, distance, inside];
            let by_u = [-one_by_u, -outside, inside_by_u];
            let by_blur = [-one_by_blur, blur * one_by_u, inside_by_blur];
            row(levels, by_u, by_blur, [sine, lean])
        })
    }
}

/// Two times four numbers: of a cell, or what they are multiplied by.
type Pair = [[f64; 4]; 2];

/// Rows whose sums run side by side: none waits for another, and what the cells are multiplied by is read once.
const ROWS: usize = 4;

/// A table over the window widened by `margin`: `row` of u and of the sums of the cells by a kernel.
fn table<Row: Send + 'static>(
    cells: impl Iterator<Item = Pair>,
    kernel: &[Pair],
    margin: f64,
    row: impl Fn(f64, Pair) -> Row,
) -> Table<Row> {
    // Some rows reach beyond the cells there are.
    let mut padded = List::filled([[0.0; 4]; 2], ROWS - 1);
    padded.extend(cells);
    padded.extend([[[0.0; 4]; 2]; ROWS - 1]);
    let taps = (kernel.len() / 2) as i32;
    let (first_index, last_index) = window(margin);
    let mut rows = List::with_capacity((last_index - first_index) as usize + ROWS);
    for first in (first_index..=last_index).step_by(ROWS) {
        // Where the kernel about the last of the rows meets the first cell.
        let left = first + ROWS as i32 - 1 - taps;
        let weights = &kernel[(-left).clamp(0, 2 * taps + 1) as usize..];
        let sums = Arch::new().dispatch(WeightedSums { weights, cells: &padded[left.max(0) as usize..] });
        rows.extend((first..=last_index).zip(sums).map(|(k, sums)| row(f64::from(k) * STEP.get(), sums)));
    }
    Table { first: f64::from(first_index) * STEP.get(), rows }
}

/// 1 and the distance from the limb outside of it, blurred, where 1 inside of it is `inside` and rises by `slope` per
/// pixel: with Φ and φ of the normal distribution, Φ(−u/σ) and σ φ(u/σ) − u Φ(−u/σ).
fn background(u: f64, blur: f64, inside: f64, slope: f64) -> [f64; 2] {
    let outside = 1.0 - inside;
    [outside, blur * blur * slope - u * outside]
}

/// g, −g′ and ∂g/∂σ of a Gaussian, each normalised by the sum of g so that constants stay constants.
fn kernel(blur: f64) -> List<[f64; 3]> {
    let taps = (TAIL.get() * blur / STEP.get()).ceil() as i32;
    let place = |k: i32| f64::from(k) * STEP.get() / blur;
    // The same on both sides.
    let half: List<f64> = (0..=taps).map(place).map(|x| (-x * x / 2.0).exp()).collect();
    let kernel: List<[f64; 3]> = (-taps..=taps)
        .map(|k| {
            let (x, g) = (place(k), half[k.unsigned_abs() as usize]);
            [g, x / blur * g, (x * x - 1.0) / blur * g]
        })
        .collect();
    let sum: f64 = kernel.iter().map(|k| k[0]).sum();
    let drift: f64 = kernel.iter().map(|k| k[2]).sum::<f64>() / sum;
    kernel.iter().map(|k| [k[0] / sum, k[1] / sum, (k[2] - drift * k[0]) / sum]).collect()
}

/// The sums of cells times weights, from each of the first cells on.
struct WeightedSums<'a> {
    weights: &'a [Pair],
    cells: &'a [Pair],
}

impl WithSimd for WeightedSums<'_> {
    type Output = [Pair; ROWS];

    /// With the widest instructions of the machine; they all round alike.
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [Pair; ROWS] {
        // As many as eight numbers are without vectors.
        let mut sums = [[simd.splat_f64s(0.0); 8]; ROWS];
        for (weights, cells) in self.weights.iter().zip(self.cells.windows(ROWS)) {
            let weights = S::as_simd_f64s(weights.as_flattened()).0;
            for (sums, cell) in sums.iter_mut().zip(cells) {
                let cell = S::as_simd_f64s(cell.as_flattened()).0;
                for ((sum, weight), x) in sums.iter_mut().zip(weights).zip(cell) {
                    *sum = simd.add_f64s(*sum, simd.mul_f64s(*x, *weight));
                }
            }
        }
        let mut found = [[[0.0; 4]; 2]; ROWS];
        for (found, sums) in found.iter_mut().zip(sums) {
            let found = S::as_mut_simd_f64s(found.as_flattened_mut()).0;
            found.iter_mut().zip(sums).for_each(|(found, sum)| *found = sum);
        }
        found
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
    /// The two rows beside u, and the part of the way from the first to the second; `None` outside the table.
    #[inline(always)]
    pub fn beside(&self, u: f64) -> Option<(&Row, &Row, f64)> {
        let x = (u - self.first) / STEP.get();
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

/// The functions without blur, averaged over a cell by its inner part: θ has an infinite slope at the limb. The mean of sin θ in
/// the cell and over the window are known.
fn sharp(
    (low, high): (f64, f64),
    radius: f64,
    shading: &LimbShading,
    [sine, mean_sine]: [f64; 2],
) -> Vector4<f64> {
    let inner = (high - low) / STEP.get();
    let lean = f64::midpoint(low, high) / radius * inner;
    // Less their means over the window, so that the level inside is the mean brightness there.
    let mean_lean = INSIDE.get() / (2.0 * radius);
    // The expected brightness has an infinite slope there, too.
    let places = 8;
    let place = |j: usize| low + (high - low) * (j as f64 + 0.5) / places as f64;
    let expected = if inner > 0.0 {
        inner * (0..places).map(|j| shading.at(place(j) / radius)).sum::<f64>() / places as f64
    } else {
        0.0
    };
    Vector4::new(inner, expected, sine - mean_sine * inner, lean - mean_lean * inner)
}
