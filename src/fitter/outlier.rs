//! Outliers among the located lines: how likely one is the edge of something else than its limb, by the sides of the mask.
//!
//! The edge of a shadow, a lit strip of the background or a print may look like a limb, a few pixels beside it. The line alone
//! does not tell; where the mask has the limb does, though only to a pixel or two. So each line is a mixture: it is the limb, or
//! it is off by an error that the sides of the mask estimate. It is moved by the mean of that, and its variance grows by as much
//! as the two differ. The spread within the second is left out: it would double the stated deviations of lines that are right,
//! for a case that has some hundredths of the weight. A line that the mask does not speak against stays as it is.

use super::guides::{Guides, outside};
use crate::limb_location::{LimbLine, LimbObservation, NotVisible};
use crate::noise::ImageNoise;
use nalgebra::{Matrix2, Vector2};

/// The rate of outliers among located lines, rounded down: on objects of the twin 46 of 642 are off by more than three
/// deviations and a quarter of a pixel.
const OUTLIERS: f64 = 0.05;

/// The same of lines that few blocks carry: 9 of 27 are off by more than 0.4 pixels.
const OUTLIERS_OF_FEW: f64 = 0.3;

/// What is more likely something else is no limb.
const REFUSED: f64 = 0.5;

/// The variance of what is not known, in square pixels.
const UNKNOWN: f64 = 1e12;

/// A located line and its side of the mask.
struct Compared {
    line: LimbLine,
    /// Whether few blocks carry it.
    of_few: bool,
    /// How far it lies outside of the side, in pixels.
    outside: f64,
    /// A point on the inner side.
    inner: Vector2<f64>,
}

/// What a line may be besides its limb.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Outlier {
    /// The probability that it is one.
    probability: f64,
    /// By how many pixels it lies too far outside then.
    error: f64,
}

/// Weighs located lines against the sides of a mask; returns whether a line has changed. Given segments tell more than a mask.
pub(super) fn weigh(limbs: &mut [LimbObservation; 2], guides: &Guides, noise: &ImageNoise) -> bool {
    let mut compared = match guides.given.is_empty() {
        true => [0, 1].map(|limb| Compared::new(&limbs[limb], limb, guides)),
        false => [None, None],
    };
    let mut of_lines = outliers(&compared, noise);
    let refused = [0, 1].map(|k| {
        of_lines[k].probability > REFUSED && compared[k].as_ref().is_some_and(|compared| compared.of_few)
    });
    if refused.contains(&true) {
        // Nothing but a refused line of few blocks would speak against the other one.
        (0..2).filter(|&k| refused[k]).for_each(|k| compared[k] = None);
        of_lines = outliers(&compared, noise);
    }
    let mut changed = false;
    for ((limb, compared), outlier) in limbs.iter_mut().zip(&compared).zip(of_lines) {
        let Some(compared) = compared else { continue };
        let line = compared.weighed(&outlier);
        changed |= line != limb.line;
        limb.line = line;
    }
    changed
}

impl Compared {
    /// `None` where there is no line, or the limb has no side.
    fn new(seen: &LimbObservation, limb: usize, guides: &Guides) -> Option<Self> {
        let line = seen.line.ok().or(seen.of_few)?;
        let side = guides.sides.iter().find(|side| side.limb == Some(limb))?;
        let inner = guides.sides.iter().chain(&guides.cut).find(|side| side.limb == Some(1 - limb))?.middle();
        let outside = outside(&line.ends, side, &inner);
        Some(Self { line, of_few: seen.line.is_err(), outside, inner })
    }

    /// The probability that it is something else before the mask is asked.
    fn prior(&self) -> f64 {
        if self.of_few { OUTLIERS_OF_FEW } else { OUTLIERS }
    }

    /// The line as far as it is believed.
    fn weighed(&self, outlier: &Outlier) -> Result<LimbLine, NotVisible> {
        if outlier.probability > REFUSED {
            return Err(if self.of_few { NotVisible::Patchy } else { NotVisible::OutOfReach });
        }
        // Stated deviations of lines hold but for the outliers of that rate: only what the mask adds to it counts.
        let known = if self.of_few { 0.0 } else { OUTLIERS };
        let wrong = (outlier.probability - known) / (1.0 - known);
        if wrong <= 0.0 {
            return Ok(self.line);
        }
        let LimbLine { ends, sigma } = self.line;
        let along = (ends[1] - ends[0]).normalize();
        let across = Vector2::new(-along.y, along.x);
        let inward = across * (self.inner - ends[0]).dot(&across).signum();
        // The errors of the ends are independent, so that the middle has half the variance of an end.
        let enlarged = (sigma * sigma + 2.0 * wrong * (1.0 - wrong) * outlier.error * outlier.error).sqrt();
        // What is beside a limb is parallel to it: farther apart, the ends tell the angle as before. That of few blocks may be
        // anything.
        let apart = if self.of_few { 1.0 } else { enlarged / sigma };
        let middle = (ends[0] + ends[1]) / 2.0;
        let ends = ends.map(|q| middle + (q - middle) * apart + inward * (wrong * outlier.error));
        Ok(LimbLine { ends, sigma: enlarged })
    }
}

/// What may be wrong with two lines. Right ones lie beside their sides by the growth of the mask, which both share, and by its
/// unevenness; a wrong one besides by as much as a side is off.
fn outliers(lines: &[Option<Compared>; 2], noise: &ImageNoise) -> [Outlier; 2] {
    let uneven = noise.unevenness.powi(2);
    let variance = |line: &Compared| uneven / 2.0 + line.line.sigma.powi(2) / 2.0;
    let own = lines.each_ref().map(|line| line.as_ref().map_or(UNKNOWN, variance));
    let off = Vector2::from(lines.each_ref().map(|line| line.as_ref().map_or(0.0, |line| line.outside)));
    let prior = lines.each_ref().map(|line| line.as_ref().map_or(0.0, Compared::prior));
    let growth = (noise.side.powi(2) - uneven).max(0.0);
    let far = noise.side.powi(2);
    let cases = [[true, true], [true, false], [false, true], [false, false]].map(|is_wrong| {
        let diagonal = [0, 1].map(|k| own[k] + if is_wrong[k] { far } else { 0.0 });
        let covariance = Matrix2::from_element(growth) + Matrix2::from_diagonal(&Vector2::from(diagonal));
        let solved: Vector2<f64> = covariance.try_inverse().unwrap_or_default() * off;
        let priors = [0, 1].map(|k| if is_wrong[k] { prior[k] } else { 1.0 - prior[k] });
        (is_wrong, solved, priors[0] * priors[1] / covariance.determinant().sqrt())
    });
    // The first covariance is the largest and so its exponent, too: without it all of them may vanish.
    let largest = off.dot(&cases[0].1);
    let mut sum = 0.0;
    let mut wrong: Vector2<f64> = Vector2::zeros();
    let mut errors: Vector2<f64> = Vector2::zeros();
    for (is_wrong, solved, factor) in cases {
        let weight = factor * ((largest - off.dot(&solved)) / 2.0).exp();
        sum += weight;
        for k in [0, 1].into_iter().filter(|&k| is_wrong[k]) {
            wrong[k] += weight;
            errors[k] += weight * far * solved[k];
        }
    }
    [0, 1].map(|k| Outlier {
        probability: if sum > 0.0 { wrong[k] / sum } else { 0.0 },
        error: if wrong[k] > 0.0 { errors[k] / wrong[k] } else { 0.0 },
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::List;
    use crate::noise::NoiseModel;
    use crate::residuals::PixelSegment;

    const SIGMA: f64 = 0.1;

    fn upright(x: f64) -> [Vector2<f64>; 2] {
        [Vector2::new(x, 100.0), Vector2::new(x, 200.0)]
    }

    fn seen(x: f64, of_few: bool) -> LimbObservation {
        let line = LimbLine { ends: upright(x), sigma: SIGMA };
        let (line, of_few) = if of_few { (Err(NotVisible::Patchy), Some(line)) } else { (Ok(line), None) };
        LimbObservation { line, of_few, samples: List::new(), blur: None }
    }

    /// Those of the sides of a mask at 300 and 340.
    fn guides() -> Guides {
        let side = |x: f64, limb: usize| PixelSegment {
            endpoints: upright(x),
            weight: 1.0,
            limb: Some(limb),
            growth: 0.0,
        };
        Guides { sides: [side(300.0, 0), side(340.0, 1)].into(), ..Guides::default() }
    }

    /// What is left of two limbs between these sides.
    fn weighed(mut limbs: [LimbObservation; 2]) -> [Result<LimbLine, NotVisible>; 2] {
        let (noise, guides) = (NoiseModel::default().in_image((640, 480)), guides());
        let before = limbs.clone();
        assert_eq!(weigh(&mut limbs, &guides, &noise), before != limbs);
        limbs.map(|limb| limb.line)
    }

    #[test]
    fn lines_that_a_mask_does_not_speak_against_stay_as_they_are() {
        for [first, second] in [[300.0, 340.0], [300.5, 339.3], [298.0, 342.0]] {
            let limbs = [seen(first, false), seen(second, false)];
            assert_eq!(weighed(limbs.clone()), limbs.map(|limb| limb.line));
        }
    }

    #[test]
    fn a_line_beside_the_mask_is_less_certain_and_the_other_one_is_not() {
        let [first, second] = weighed([seen(300.0, false), seen(342.5, false)]).map(Result::unwrap);
        assert!(second.sigma > 0.5 && second.ends[0].x < 342.5 && second.ends[0].x > 340.0, "{second:?}");
        assert!(first.sigma < 0.4 * second.sigma && (first.ends[0].x - 300.0).abs() < 0.1, "{first:?}");
        // It is as sure of the angle as it was.
        let angle = |line: &LimbLine| line.covariance()[(1, 1)];
        assert!((angle(&second) / (2.0 * SIGMA * SIGMA / 1e4) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn a_line_far_beside_the_mask_is_no_limb() {
        let [first, second] = weighed([seen(300.0, false), seen(346.0, false)]);
        assert!(first.is_ok());
        assert_eq!(second, Err(NotVisible::OutOfReach));
    }

    #[test]
    fn a_line_of_few_blocks_counts_where_the_mask_has_the_limb() {
        let [_, second] = weighed([seen(300.0, false), seen(340.8, true)]);
        assert!(second.is_ok_and(|line| line.sigma > SIGMA), "{second:?}");
        let [_, second] = weighed([seen(300.0, false), seen(344.0, true)]);
        assert_eq!(second, Err(NotVisible::Patchy));
    }

    #[test]
    fn a_refused_line_of_few_blocks_says_nothing_of_the_other_one() {
        for far in [347.0, 348.0, 334.0] {
            let [first, second] = weighed([seen(300.0, false), seen(far, true)]);
            assert_eq!((first, second), (seen(300.0, false).line, Err(NotVisible::Patchy)), "{far}");
        }
    }

    /// All weights vanish in doubles where the mask is said to be drawn that exactly.
    #[test]
    fn a_line_beside_a_mask_that_is_known_exactly_is_no_limb() {
        let model = NoiseModel { mask_side: 0.1, mask_unevenness: 0.06, ..NoiseModel::default() };
        let mut limbs = [seen(300.0, false), seen(350.0, false)];
        weigh(&mut limbs, &guides(), &model.in_image((640, 480)));
        assert_eq!(limbs[1].line, Err(NotVisible::OutOfReach));
    }

    #[test]
    fn beside_given_segments_no_mask_is_asked() {
        let noise = NoiseModel::default().in_image((640, 480));
        let line = |limb: usize| PixelSegment {
            endpoints: upright(300.0),
            weight: 1.0,
            limb: Some(limb),
            growth: 0.0,
        };
        let guides =
            Guides { given: [line(0)].into(), sides: [line(0), line(1)].into(), ..Guides::default() };
        assert!(!weigh(&mut [seen(303.0, false), seen(343.0, true)], &guides, &noise));
    }
}
