//! How residuals count: the plain square, Tukey's biweight, truncated squares; and the one driver of iteratively
//! reweighted fits.

use crate::memory::List;
use crate::statistics::{DEVIATION_OF_MEDIAN, median_absolute};
use pulp::{Scalar, Simd};

/// What residuals count for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Influence<T> {
    /// The loss ρ(e).
    pub loss: T,
    /// The weight ρ′(e) / (2 e) of the square in the normal equations.
    pub weight: T,
    /// The derivative of the influence ψ(e) = ρ′(e) / 2.
    pub slope: T,
}

/// How a residual counts.
pub trait Loss: Copy + Sync {
    /// What residuals count for. `facing` is negative where the outward normal of the surface points towards the observer at
    /// the origin.
    fn influences<S: Simd>(&self, simd: S, residuals: S::f64s, facing: S::f64s) -> Influence<S::f64s>;

    /// The same of one residual.
    #[inline]
    fn influence(&self, residual: f64, facing: f64) -> Influence<f64> {
        self.influences(Scalar::new(), residual, facing)
    }
}

/// The plain square.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Squared;

/// Tukey's biweight, ρ(e) = (c²/3) (1 − (1 − (e/c)²)³), which is e² for small e and constant beyond c: points
/// far off the surface (background, flying pixels) lose all influence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tukey {
    /// The residual c from which on a point has no influence.
    pub cutoff: f64,
    /// The wall that points can be on.
    pub wall: Wall,
}

/// Truncated squares, min(e², c²): inliers count by least squares, and every outlier the same. The score of a random
/// sample (MSAC of Torr and Zisserman 2000) is their mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truncated {
    /// The residual c from which on a point is an outlier.
    pub threshold: f64,
    /// The wall that points can be on.
    pub wall: Wall,
}

/// Another loss with its slopes in place of its weights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BySlopes<L>(pub L);

/// On which wall of the cylinder a point can be. Depths that a sensor smears past the limbs lie on the wall that
/// it cannot see.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wall {
    /// On either: nothing is known of an observer.
    Either,
    /// On the wall that faces the observer outside the cylinder; points on the other have no influence.
    Facing,
    /// On the wall that faces away from the origin: the far one of a pipe with the observer inside.
    Averted,
}

impl Wall {
    /// Whether a point cannot be where it is.
    #[inline(always)]
    #[must_use]
    pub fn hides(self, facing: f64) -> bool {
        ((self == Wall::Facing) & (facing > 0.0)) | ((self == Wall::Averted) & (facing < 0.0))
    }

    /// Where points cannot be where they are: a mask, because a branch would keep sums from vector instructions.
    #[inline(always)]
    pub(super) fn hidden<S: Simd>(self, simd: S, facing: S::f64s) -> S::m64s {
        // Looked up: where it is branched over the loop about it is, too.
        let sign = [0.0, 1.0, -1.0][self as usize];
        simd.greater_than_f64s(simd.mul_f64s(simd.splat_f64s(sign), facing), simd.splat_f64s(0.0))
    }
}

/// c / σ at which the estimate keeps 95 % of the efficiency of least squares under Gaussian noise.
pub const TUKEY_EFFICIENT: f64 = 4.685;

impl Loss for Squared {
    #[inline(always)]
    fn influences<S: Simd>(&self, simd: S, residuals: S::f64s, _facing: S::f64s) -> Influence<S::f64s> {
        let one = simd.splat_f64s(1.0);
        Influence { loss: simd.mul_f64s(residuals, residuals), weight: one, slope: one }
    }
}

impl Loss for Tukey {
    /// ψ = e (1 − (e/c)²)².
    #[inline(always)]
    fn influences<S: Simd>(&self, simd: S, residuals: S::f64s, facing: S::f64s) -> Influence<S::f64s> {
        let (zero, one) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
        // Finite for the smallest cutoff, too.
        let ratio = simd.mul_f64s(residuals, simd.splat_f64s(self.cutoff.recip().min(f64::MAX)));
        let square = simd.mul_f64s(ratio, ratio);
        let rest = simd.max_f64s(simd.sub_f64s(one, square), zero);
        let rest = simd.select_f64s(self.wall.hidden(simd, facing), zero, rest);
        let weight = simd.mul_f64s(rest, rest);
        let most = simd.splat_f64s(self.cutoff * self.cutoff / 3.0);
        // Where nothing is left the other factor is bounded, too: it could be infinite.
        let square = simd.min_f64s(square, one);
        Influence {
            loss: simd.mul_f64s(most, simd.sub_f64s(one, simd.mul_f64s(weight, rest))),
            weight,
            slope: simd.mul_f64s(rest, simd.sub_f64s(one, simd.mul_f64s(simd.splat_f64s(5.0), square))),
        }
    }
}

impl<L: Loss> Loss for BySlopes<L> {
    #[inline(always)]
    fn influences<S: Simd>(&self, simd: S, residuals: S::f64s, facing: S::f64s) -> Influence<S::f64s> {
        let influence = self.0.influences(simd, residuals, facing);
        Influence { weight: influence.slope, ..influence }
    }
}

impl Loss for Truncated {
    #[inline(always)]
    fn influences<S: Simd>(&self, simd: S, residuals: S::f64s, facing: S::f64s) -> Influence<S::f64s> {
        let most = simd.splat_f64s(self.threshold * self.threshold);
        let square = simd.mul_f64s(residuals, residuals);
        let square = simd.select_f64s(self.wall.hidden(simd, facing), most, square);
        let inlier = simd.less_than_f64s(square, most);
        let weight = simd.select_f64s(inlier, simd.splat_f64s(1.0), simd.splat_f64s(0.0));
        Influence { loss: simd.min_f64s(square, most), weight, slope: weight }
    }
}

/// The scale σ of the residuals of a reweighted fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scale {
    /// 1.4826 times the median of their absolute values, and at least this: the deviation that they have anyway (1 for
    /// residuals in units of their standard deviation), or what keeps exact data from dividing by zero.
    AtLeast(f64),
    /// Known beforehand.
    Known(f64),
}

/// What a weighted fit did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Progress {
    /// The next round may move it again.
    Moved,
    /// Another round would change nothing of interest.
    Settled,
}

/// Iteratively reweighted least squares with Tukey's biweight at 95 % efficiency: the scale of the residuals and from it
/// their weights, a weighted fit, new residuals, and so on.
///
/// The fit is a closure `fit(weights, residuals)` that fits with the weights given and then writes the new residuals,
/// all in one unit; it keeps what it found. A residual that is not finite stands for none: it has no weight and is left
/// out of the scale. The closure returns `None` where the weights determine nothing, which ends the whole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reweighting {
    /// Most weighted fits.
    pub rounds: usize,
    /// The scale of the residuals.
    pub scale: Scale,
}

/// Where a reweighted fit ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Reweighted {
    /// The weights, from 0 to 1, that the last residuals have.
    pub weights: List<f64>,
    /// Their scale.
    pub scale: f64,
}

impl Reweighting {
    /// The first fit has all weights 1. `None` when the closure fails.
    #[must_use]
    pub fn fit(
        &self,
        count: usize,
        mut fit: impl FnMut(&[f64], &mut [f64]) -> Option<Progress>,
    ) -> Option<Reweighted> {
        let mut residuals = List::filled(0.0, count);
        fit(&List::filled(1.0, count), &mut residuals)?;
        let rest = Self { rounds: self.rounds.saturating_sub(1), ..*self };
        rest.continue_from(&mut residuals, fit)
    }

    /// The first fit has the weights of the residuals that a start leaves. `None` when the closure fails.
    #[must_use]
    pub fn continue_from(
        &self,
        residuals: &mut [f64],
        mut fit: impl FnMut(&[f64], &mut [f64]) -> Option<Progress>,
    ) -> Option<Reweighted> {
        let mut reweighted = Reweighted { weights: List::filled(0.0, residuals.len()), scale: 0.0 };
        self.weigh(residuals, &mut reweighted);
        for _ in 0..self.rounds {
            let progress = fit(&reweighted.weights, residuals)?;
            self.weigh(residuals, &mut reweighted);
            if progress == Progress::Settled {
                break;
            }
        }
        Some(reweighted)
    }

    fn weigh(&self, residuals: &[f64], reweighted: &mut Reweighted) {
        reweighted.scale = match self.scale {
            Scale::Known(scale) => scale,
            Scale::AtLeast(least) => {
                // Where most are that small no median is needed.
                let mut small = 0;
                for residual in residuals {
                    small += usize::from(DEVIATION_OF_MEDIAN * residual.abs() <= least);
                }
                if 2 * small > residuals.len() {
                    least
                } else {
                    let finite = residuals.iter().copied().filter(|e| e.is_finite());
                    (DEVIATION_OF_MEDIAN * median_absolute(finite)).max(least)
                }
            }
        };
        let loss = Tukey { cutoff: TUKEY_EFFICIENT * reweighted.scale, wall: Wall::Either };
        for (weight, residual) in reweighted.weights.iter_mut().zip(residuals) {
            *weight = if residual.is_finite() { loss.influence(*residual, 0.0).weight } else { 0.0 };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reweighted_mean_forgets_what_lies_apart() {
        let values = [1.0, 1.1, 0.9, 1.05, 0.95, 40.0];
        let mut mean = 0.0;
        let fit = |weights: &[f64], residuals: &mut [f64]| {
            let total: f64 = weights.iter().sum();
            if !(total > 0.0) {
                return None;
            }
            mean = weights.iter().zip(&values).map(|(w, x)| w * x).sum::<f64>() / total;
            residuals.iter_mut().zip(&values).for_each(|(e, x)| *e = x - mean);
            Some(Progress::Moved)
        };
        let driver = Reweighting { rounds: 10, scale: Scale::AtLeast(1e-12) };
        let reweighted = driver.fit(values.len(), fit).unwrap();
        assert!((mean - 1.0).abs() < 0.02 && reweighted.weights[5] == 0.0);
    }

    #[test]
    fn the_weight_is_the_derivative_of_the_loss_over_twice_the_residual() {
        let tukey = Tukey { cutoff: 2.0, wall: Wall::Facing };
        let at = |e: f64| tukey.influence(e, -1.0);
        for e in [-1.9, -0.5, 0.3, 1.0, 1.999, 2.5] {
            let h = 1e-6;
            let slope = (at(e + h).loss - at(e - h).loss) / (2.0 * h);
            assert!((slope - 2.0 * e * at(e).weight).abs() < 1e-8, "{e}");
            let influence = |e: f64| e * at(e).weight;
            let of_influence = (influence(e + h) - influence(e - h)) / (2.0 * h);
            assert!((of_influence - at(e).slope).abs() < 1e-8, "{e}");
        }
        assert_eq!(at(3.0), Influence { loss: 4.0 / 3.0, weight: 0.0, slope: 0.0 });
        assert!((at(1e-4).loss - 1e-8).abs() < 1e-15);
        // A point on the hidden wall counts as one far away.
        assert_eq!(tukey.influence(0.1, 1.0), at(3.0));
    }

    #[test]
    fn truncated_squares_end_at_the_threshold_and_on_the_hidden_wall() {
        let loss = |wall| Truncated { threshold: 0.5, wall };
        for (wall, facing, inlier) in [
            (Wall::Either, 1.0, true),
            (Wall::Facing, 1.0, false),
            (Wall::Facing, -1.0, true),
            (Wall::Averted, 1.0, true),
            (Wall::Averted, -1.0, false),
        ] {
            let expected = if inlier { (0.0625, 1.0) } else { (0.25, 0.0) };
            let of = |e: f64| {
                let Influence { loss, weight, slope } = loss(wall).influence(e, facing);
                assert_eq!(weight, slope);
                (loss, weight)
            };
            assert_eq!(of(-0.25), expected, "{wall:?} {facing}");
            assert_eq!(of(0.6), (0.25, 0.0));
        }
    }

    /// A straight line through points of which some are off by far.
    #[test]
    fn a_reweighted_line_forgets_outliers() {
        let points: Vec<(f64, f64)> = (0..40)
            .map(|k| {
                let x = f64::from(k) / 10.0;
                (x, if k % 4 == 0 { 9.0 } else { 0.5 + 2.0 * x + 0.01 * (7.0 * x).sin() })
            })
            .collect();
        let mut line = (0.0, 0.0);
        let mut rounds = 0;
        let reweighted = Reweighting { rounds: 30, scale: Scale::AtLeast(1e-12) }
            .fit(points.len(), |weights, residuals| {
                rounds += 1;
                let sum = |f: &dyn Fn(f64, f64) -> f64| -> f64 {
                    weights.iter().zip(&points).map(|(w, (x, y))| w * f(*x, *y)).sum()
                };
                let (n, x, y) = (sum(&|_, _| 1.0), sum(&|x, _| x), sum(&|_, y| y));
                let slope = (n * sum(&|x, y| x * y) - x * y) / (n * sum(&|x, _| x * x) - x * x);
                let before = line;
                line = ((y - slope * x) / n, slope);
                for (residual, (x, y)) in residuals.iter_mut().zip(&points) {
                    *residual = y - line.0 - line.1 * x;
                }
                let settled = (line.0 - before.0).hypot(line.1 - before.1) < 1e-9;
                Some(if settled { Progress::Settled } else { Progress::Moved })
            })
            .unwrap();
        assert!((line.0 - 0.5).abs() < 0.01 && (line.1 - 2.0).abs() < 0.01, "{line:?}");
        assert!(rounds < 30, "{rounds}");
        assert!((0..40).step_by(4).filter(|k| *k < 35).all(|k| reweighted.weights[k] == 0.0));
        assert!(reweighted.scale < 0.02, "{}", reweighted.scale);
    }

    #[test]
    fn the_scale_has_its_floor_or_is_known_and_missing_residuals_do_not_count() {
        let weigh = |scale, mut residuals: Vec<f64>| {
            Reweighting { rounds: 0, scale }.continue_from(&mut residuals, |_, _| None).unwrap()
        };
        let missing = f64::INFINITY;
        let exact = weigh(Scale::AtLeast(1.0), vec![0.0, 0.0, missing, missing, missing]);
        assert_eq!((exact.scale, &exact.weights[..]), (1.0, &[1.0, 1.0, 0.0, 0.0, 0.0][..]));
        let median = weigh(Scale::AtLeast(1e-9), vec![1.0, -2.0, 3.0, f64::NAN]);
        assert_eq!(median.scale, DEVIATION_OF_MEDIAN * 2.0);
        let known = weigh(Scale::Known(1.0), vec![5.0, 100.0, 0.0]);
        assert_eq!((known.scale, &known.weights[..]), (1.0, &[0.0, 0.0, 1.0][..]));
    }

    #[test]
    fn a_fit_that_fails_ends_it_and_rounds_are_counted() {
        let mut calls = 0;
        let result = Reweighting { rounds: 5, scale: Scale::AtLeast(1.0) }.fit(3, |_, _| {
            calls += 1;
            (calls < 3).then_some(Progress::Moved)
        });
        assert_eq!((result, calls), (None, 3));
        calls = 0;
        let mut count = |_: &[f64], _: &mut [f64]| {
            calls += 1;
            Some(Progress::Moved)
        };
        assert!(Reweighting { rounds: 4, scale: Scale::AtLeast(1.0) }.fit(3, &mut count).is_some());
        assert_eq!(calls, 4);
    }
}
