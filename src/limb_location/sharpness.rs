//! How blurred an image is across the limbs, by all that is to be seen near them: it was out of focus, or something moved.
//!
//! The steps of brightness of a sharp image rise from one pixel to the next, those of a blurred one over several. So the
//! differences of neighbours are compared with those some pixels farther: Sₖ is the sum of the products of differences k
//! pixels apart. The strongest steps count most, by the square of their height. Of noise that is independent in each pixel S₀ + 2 S₁ and S₃ have
//! hardly anything. Shading and the fading edges of shadows leave much at all distances, and S₆ takes most of that off.

use super::strip::Strip;
use crate::memory::List;
use crate::statistics::dot;

constants! {
    /// From here on the limbs are looked for on a coarser grid. A Gaussian of 1.8 pixels has as much, and an even smear of five
    /// pixels with the blur of a lens; sharp images of bodies that are not small have less.
    pub(super) BLURRED = 0.5, "";

    /// The same on a grid that was made coarser for it: an even smear of 3.8 pixels. The step filter sees none that is wider.
    pub(super) STILL_BLURRED = 0.25, "";
}

/// How many pixels apart the differences are that are compared.
const APART: [usize; 4] = [0, 1, 3, 6];

/// The part of the square of a rise that is left three pixels away, 3 (S₃ − S₆) / (S₀ + 2 S₁ − 3 S₆), in some strips: about 0 in a sharp
/// image, more than a half where rises last far longer.
pub(super) fn blurred_part<'a>(strips: impl Iterator<Item = &'a Strip>) -> f64 {
    let mut sums = [0.0; APART.len()];
    let mut differences = List::new();
    for run in strips.flat_map(Strip::runs) {
        differences.clear();
        differences.extend(run.values.windows(2).map(|pair| pair[1] - pair[0]));
        for (sum, apart) in sums.iter_mut().zip(APART) {
            let others = differences.get(apart..).unwrap_or_default();
            *sum += dot(&differences[..others.len()], others);
        }
    }
    let [own, next, third, far] = sums;
    let all = own + 2.0 * next - 3.0 * far;
    if all > 0.0 { 3.0 * (third - far) / all } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limb_location::strip::StripPixel;

    /// The part in rows with a step that is smeared evenly over some pixels, on a slope, with noise.
    fn part(smear: f64, slope: f64, noise: f64) -> f64 {
        let mut state = 1_u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let runs: Vec<Vec<StripPixel>> = (0..100)
            .map(|row| {
                let s = f64::from(row);
                let mut pixel = |column: i32| {
                    let u = f64::from(column) + 0.01 * s;
                    let step = (u / smear + 0.5).clamp(0.0, 1.0);
                    let value = step + slope * u + noise * 12.0_f64.sqrt() * uniform();
                    StripPixel { s, u, value, saturated: false }
                };
                (-15..=15).map(&mut pixel).collect()
            })
            .collect();
        blurred_part([&Strip::of_runs(runs.into_iter())].into_iter())
    }

    #[test]
    fn smears_are_told_from_sharp_steps_with_shading_and_noise() {
        for noise in [0.0, 0.1] {
            for slope in [0.0, 0.01] {
                assert!(part(1.0, slope, noise) < 0.2);
                assert!(part(3.0, slope, noise) < STILL_BLURRED.get());
                let five = part(5.0, slope, noise);
                assert!(five > 0.35 && five < 0.65, "{five}");
                assert!(part(9.0, slope, noise) > STILL_BLURRED.get());
            }
        }
    }
}
