//! How the brightness runs around the cylinder, seen where there is plenty of it: between the limbs.
//!
//! For a matt surface and distant lamps the brightness is a function of the angle φ of the normal about the axis
//! (0 towards the camera, ± 90° at the limbs): a + b cos φ + c sin φ for all lamps that the whole visible surface
//! sees, and d max(0, cos(φ − φ₀)) for a lamp that part of it turns away from, with its mirror image
//! g cosⁿ(φ − φ₀/2) on a glossy surface. This is fitted to the inner part
//! of the surface, over medians along the axis so that labels, gloss and occluders have little influence, and
//! tells what the limbs look like just inside: whether the surface darkens towards them, and how steeply.

use super::block::INSIDE;
use super::consensus::BLOCK_RUNS;
use super::lamps::{Fit, Lamp, fits};
use super::strip::{Pixels, Strip};
use crate::memory::List;
use crate::statistics::{DEVIATION_OF_MEDIAN, median};
use nalgebra::{Matrix5, Vector5};
use pulp::{Arch, Simd, WithSimd};
use std::f64::consts::FRAC_PI_2;

constants! {
    /// Fewest blocks that have a median.
    LEAST_BLOCKS = 3.0, "";

    /// The visible half circle is divided into that many bins at most, and into bins of 1.5 pixels at least.
    MOST_BINS = 24.0, "";
    LEAST_BIN_PIXELS = 1.5, "px";

    /// Fewest bins that determine the unknowns.
    LEAST_BINS = 7.0, "";

    /// Standard deviation of a median for reasons other than its scatter along the axis, relative to the brightness:
    /// 8 bits.
    FLOOR = 0.005, "";

    /// Largest deviation of a block from the medians, relative to that of the median block.
    MOST_ODDNESS = 3.0, "";

    /// Standard deviation of what the brightness does near a limb for reasons that the inner part does not show, in
    /// units of the brightness there: dust, coats of paint, several lamps at once.
    NEAR_LIMB = 0.05, "";

    /// Brightness near a limb relative to that of the inner part below which it is taken as this: in deep shadow ratios
    /// mean little.
    DARKEST = 0.05, "";
}

/// The brightness around a cylinder, 1 on the median of the inner part.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shading {
    coefficients: Vector5<f64>,
    lamp: Lamp,
    covariance: Matrix5<f64>,
    /// How far the brightness at the limbs at φ = −90° and 90° varies with φ₀, a variance.
    spread: [f64; 2],
}

/// What one limb looks like from 0 to `INSIDE` pixels within it.
#[derive(Debug, Clone)]
pub(super) struct LimbShading {
    /// The brightness all around and the angle of this limb in units of 90°; `None` for the same brightness everywhere.
    shading: Option<(Shading, f64)>,
    /// Mean of the brightness within the window.
    mean: f64,
    /// Standard deviation of the part that is not expected, relative to the mean.
    pub deviation: f64,
}

impl LimbShading {
    /// The same brightness everywhere, with some standard deviation.
    pub fn plain(deviation: f64) -> Self {
        Self { shading: None, mean: 1.0, deviation }
    }

    /// Brightness at the distance w inside the limb in units of the radius, 1 on the mean of the window.
    pub fn at(&self, w: f64) -> f64 {
        let Some((shading, side)) = &self.shading else { return 1.0 };
        shading.at(&Angle::within(*side, w)).max(0.0) / self.mean
    }
}

/// An angle with its cosine and sine.
#[derive(Debug, Clone, Copy)]
pub(super) struct Angle {
    pub cos: f64,
    pub sin: f64,
}

impl Angle {
    pub fn new(angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self { cos, sin }
    }

    /// That of the position at the distance `w` inside the limb at ± 90°, in units of the radius.
    fn within(side: f64, w: f64) -> Self {
        let across = 1.0 - w.clamp(0.0, 1.0);
        Self { cos: ((1.0 - across) * (1.0 + across)).sqrt(), sin: side * across }
    }
}

impl Shading {
    fn at(&self, angle: &Angle) -> f64 {
        self.lamp.functions(angle).dot(&self.coefficients)
    }

    /// What to expect of the limb at φ = ± 90° of a cylinder of some radius in pixels.
    pub fn near_limb(&self, side: f64, radius: f64) -> LimbShading {
        let samples = 16;
        let angle = |k: usize| Angle::within(side, INSIDE.get() / radius * (k as f64 + 0.5) / samples as f64);
        let mean = (0..samples).map(|k| self.at(&angle(k)).max(0.0)).sum::<f64>() / samples as f64;
        let mean = mean.max(DARKEST.get());
        let at_limb = self.lamp.functions(&Angle::new(side * FRAC_PI_2));
        let spread = self.spread[usize::from(side > 0.0)];
        let variance = at_limb.dot(&(self.covariance * at_limb)) + spread;
        LimbShading {
            shading: Some((*self, side)),
            mean,
            deviation: (variance + NEAR_LIMB.get() * NEAR_LIMB.get()).sqrt() / mean,
        }
    }

    /// From the pixels about the middle line, in runs across it. `limbs` are the two limbs as u = offset +
    /// slope · s, the one with the smaller u first, and `radius` their mean distance from the middle. `noise` is that of a
    /// pixel.
    pub fn observe(strip: &Strip, noise: f64, limbs: [(f64, f64); 2], radius: f64) -> Option<Self> {
        let widest = (1.0 - INSIDE.get() / radius).max(0.0).asin();
        let bins = MOST_BINS
            .count()
            .min(((2.0 * (radius - INSIDE.get())) / LEAST_BIN_PIXELS.get()).max(0.0) as usize);
        if bins < LEAST_BINS.count() {
            return None;
        }
        // Bins of equal angles by the sines of their limits: an arcsine takes far longer than a comparison.
        let limits: List<f64> =
            (0..=bins).map(|k| (widest * (2.0 * k as f64 / bins as f64 - 1.0)).sin()).collect();
        let mut blocks: List<List<Option<f64>>> = List::new();
        let mut across = List::new();
        for first in (0..strip.len()).step_by(BLOCK_RUNS.count()) {
            let mut sums = List::filled(Sums::default(), bins);
            for run in first..(first + BLOCK_RUNS.count()).min(strip.len()) {
                let run = strip.run(run);
                Arch::new().dispatch(Across { run, limbs: &limbs, across: &mut across });
                add_to_bins(&across, run, &limits, &mut sums);
            }
            // Where most of it was cut off at white the light is not known.
            let mean = |Sums { values, count, white }: &Sums| {
                (*count > 2.0 && 2.0 * white < *count).then(|| values / count)
            };
            let mut known: List<f64> = sums.iter().filter_map(mean).collect();
            if known.len() >= LEAST_BINS.count() {
                let gain = median(&mut known);
                if gain > 3.0 * noise {
                    blocks.push(sums.iter().map(|sum| mean(sum).map(|mean| mean / gain)).collect());
                }
            }
        }
        drop_odd(&mut blocks);
        let angle = |k: usize| widest * (2.0 * (k as f64 + 0.5) / bins as f64 - 1.0);
        let rows: List<Median> = (0..bins).filter_map(|k| Median::of(&blocks, k, angle(k))).collect();
        if rows.len() < LEAST_BINS.count() {
            return None;
        }
        let fits = fits(&rows);
        let best = fits.iter().min_by(|a, b| a.cost.total_cmp(&b.cost))?;
        let weights: List<f64> = fits.iter().map(|fit| ((best.cost - fit.cost) / 2.0).exp()).collect();
        let sum: f64 = weights.iter().sum();
        let spread = [-FRAC_PI_2, FRAC_PI_2].map(|limb| {
            let limb = Angle::new(limb);
            let square = |other: &Fit| (other.at(&limb) - best.at(&limb)).powi(2);
            let squares = weights.iter().zip(&fits).map(|(weight, other)| weight * square(other));
            squares.sum::<f64>() / sum
        });
        let Fit { coefficients, lamp, .. } = *best;
        Some(Self { coefficients, lamp, covariance: best.covariance(), spread })
    }
}

/// Where the pixels of a run are across the cylinder, from −1 at the first limb to 1 at the second. A plain loop, which the compiler
/// makes the widest instructions of the machine of; they all round alike.
struct Across<'a> {
    run: Pixels<'a>,
    limbs: &'a [(f64, f64); 2],
    across: &'a mut List<f64>,
}

impl WithSimd for Across<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { run: Pixels { s, u, .. }, limbs: [first, second], across } = self;
        across.resize(s.len(), 0.0);
        for ((across, s), u) in across.iter_mut().zip(s).zip(u) {
            let (low, high) = (first.0 + first.1 * s, second.0 + second.1 * s);
            *across = (2.0 * u - low - high) / (high - low);
        }
    }
}

/// The values of the pixels of a bin, how many they are, and how many of them were cut off at white.
#[derive(Clone, Default)]
struct Sums {
    values: f64,
    count: f64,
    white: f64,
}

/// Adds the pixels of a run, which are at some positions across the cylinder, to bins that begin and end at some limits.
fn add_to_bins(across: &[f64], run: Pixels<'_>, limits: &[f64], sums: &mut [Sums]) {
    let mut bin = 0;
    for ((&across, value), &saturated) in across.iter().zip(run.values).zip(run.saturated) {
        // The pixels of a run go one way.
        while bin + 1 < sums.len() && across >= limits[bin + 1] {
            bin += 1;
        }
        if limits[bin] <= across && across < limits[bin + 1] {
            let Sums { values, count, white } = &mut sums[bin];
            *values += value;
            *count += 1.0;
            *white += f64::from(u8::from(saturated));
        }
    }
}

/// The median brightness at an angle.
pub(super) struct Median {
    pub angle: Angle,
    pub value: f64,
    pub deviation: f64,
}

impl Median {
    /// Of one bin over the blocks.
    fn of(blocks: &[List<Option<f64>>], bin: usize, angle: f64) -> Option<Self> {
        let mut values: List<f64> = blocks.iter().filter_map(|block| block[bin]).collect();
        if values.len() < LEAST_BLOCKS.count() {
            return None;
        }
        let value = median(&mut values);
        let mut sizes: List<f64> = values.iter().map(|x| (x - value).abs()).collect();
        // The standard error of a median is √(π/2) times that of a mean.
        let scatter = DEVIATION_OF_MEDIAN * median(&mut sizes) * (FRAC_PI_2 / values.len() as f64).sqrt();
        Some(Self { angle: Angle::new(angle), value, deviation: scatter.hypot(FLOOR.get()) })
    }
}

/// Drops blocks that differ from the medians much more than most do: an occluder is flat all across, and would draw
/// every median the same way.
fn drop_odd(blocks: &mut List<List<Option<f64>>>) {
    let Some(bins) = blocks.first().map(|block| block.len()) else { return };
    let medians: List<Option<Median>> = (0..bins).map(|k| Median::of(blocks, k, 0.0)).collect();
    let oddness = |block: &List<Option<f64>>| {
        let pairs = block.iter().zip(&medians);
        let mut sizes: List<f64> =
            pairs.filter_map(|(x, row)| Some((x.as_ref()? - row.as_ref()?.value).abs())).collect();
        if sizes.is_empty() { f64::INFINITY } else { median(&mut sizes) }
    };
    let all: List<f64> = blocks.iter().map(oddness).collect();
    let limit = MOST_ODDNESS.get() * median(&mut all.clone()).max(FLOOR.get());
    let mut each = all.iter();
    blocks.retain(|_| each.next().is_some_and(|oddness| *oddness <= limit));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limb_location::strip::StripPixel;

    /// Medians of a + b cos φ + d max(0, cos(φ − φ₀)) between ± 60°.
    fn rows(light: f64) -> Vec<Median> {
        let angles = (-12..=12).map(|k| f64::from(k) * 5.0_f64.to_radians());
        let value = |angle: f64| 0.4 + 0.05 * angle.cos() + 0.7 * (angle - light).cos().max(0.0);
        let median = |angle| Median { angle: Angle::new(angle), value: value(angle), deviation: FLOOR.get() };
        angles.map(median).collect()
    }

    #[test]
    fn one_lamp_is_found_and_continued_to_the_limbs() {
        for light in [-0.9_f64, 0.0, 0.5, 1.2] {
            let rows = rows(light);
            let fits = fits(&rows);
            let best = *fits.iter().min_by(|a, b| a.cost.total_cmp(&b.cost)).unwrap();
            let Fit { lamp, coefficients, .. } = best;
            let shading = Shading { lamp, coefficients, covariance: best.covariance(), spread: [0.0; 2] };
            for side in [-FRAC_PI_2, FRAC_PI_2] {
                let expected = 0.4 + 0.7 * (side - light).cos().max(0.0);
                let found = shading.at(&Angle::new(side));
                assert!((found - expected).abs() < 0.05, "{light} {side} {found}");
            }
            // The window of a limb has the mean 1.
            let near = shading.near_limb(1.0, 30.0);
            let mean =
                (0..50).map(|k| near.at(INSIDE.get() / 30.0 * (f64::from(k) + 0.5) / 50.0)).sum::<f64>()
                    / 50.0;
            assert!((mean - 1.0).abs() < 0.01, "{mean}");
        }
    }

    #[test]
    fn an_occluder_does_not_flatten_the_medians() {
        let shaded: List<Option<f64>> = rows(0.5).iter().map(|row| Some(row.value)).collect();
        let mut blocks = List::filled(shaded.clone(), 8);
        blocks.extend(vec![List::filled(Some(1.0), shaded.len()); 3]);
        drop_odd(&mut blocks);
        assert_eq!(blocks, List::filled(shaded, 8));
    }
    #[test]
    fn what_is_cut_off_at_white_tells_nothing_of_the_limbs() {
        let (radius, light) = (30.0, 0.3_f64);
        let brightness = |angle: f64| 300.0 * (0.3 + 0.7 * (angle - light).cos().max(0.0));
        let pixel = |run: usize, k: usize| {
            let u = k as f64 - radius + 0.5;
            let value = brightness((u / radius).asin());
            StripPixel { s: run as f64, u, value: value.min(255.0), saturated: value >= 255.0 }
        };
        let strip = Strip::of_runs((0..40).map(|run| (0..60).map(|k| pixel(run, k)).collect()));
        let shading = Shading::observe(&strip, 1.0, [(-radius, 0.0), (radius, 0.0)], radius).unwrap();
        for side in [-1.0, 1.0] {
            let near = shading.near_limb(side, radius);
            let within = INSIDE.get() / radius;
            let angle = side * (1.0 - within).asin();
            let expected = brightness(side * FRAC_PI_2) / brightness(angle);
            let found = near.at(0.0) / near.at(within);
            assert!((found - expected).abs() < 0.1, "{side}: {found}, {expected}");
        }
    }
}
