//! A start from points with outliers: RANSAC with a truncated score and local optimisation.
//!
//! Hypotheses come from small samples: two points with normals, or six points fitted by
//! [`Moments`]. Each is scored by the truncated squares of its orthogonal distances (MSAC), and every new
//! best one is improved by Levenberg–Marquardt steps on its inliers. Samples are drawn until one without an
//! outlier has come up with high confidence.
//!
//! Measured on partial arcs with up to 75 % outliers and on frames of a depth camera: six points need far
//! fewer draws than eight and are as good after the local optimisation; drawing half of the samples from a
//! neighbourhood is a little better than all of them from anywhere, or none.
//!
//! When the observer is known, a point on the wall that it cannot see counts as an outlier. That separates
//! the cylinder from the second one that fits the same points almost as well, between observer and surface,
//! and keeps depths that smear past the limbs from widening it: on frames of a depth camera it halves the
//! mean error of the radius.
//!
//! Where no limit holds the radius, a plane is a cylinder too, and in a room the one with the best support. So a
//! hypothesis that spans few degrees is no candidate when the plane through its inliers explains about as many points:
//! its sagitta is lost in the noise. It is the answer only where no sample gives another, or a largest radius is set.
//!
//! Where a guess explains nearly all points with little noise no sample need be drawn: [`explained`].
//!
//! The work does not depend on the number of points beyond one pass to choose [`SCORED_POINTS`] of them and
//! one to count the inliers. It is done in one order with a generator of its own, so equal input gives equal
//! bits.

mod sample;
mod score;

use super::moments::Spread;
use crate::error::{Error, Result, not_negative, short};
use crate::geometry::{Cylinder, CylinderLimits};
use crate::memory::List;
use crate::observations::{PointCloud, PointsView};
use crate::residuals::PointTerm;
use crate::statistics::DEVIATION_OF_MEDIAN;
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
pub(crate) use sample::below;
use sample::{PLAIN_SAMPLE, Sampler};
use score::Scorer;
use std::ops::ControlFlow;

/// Points that hypotheses are drawn from and scored on, at most: evenly spaced in the order of the input.
pub const SCORED_POINTS: usize = 2000;

/// Every so many of them tell most bad hypotheses.
const FEW: usize = 4;

/// Limit of [`RansacOptions::max_iterations`], some tens of seconds.
pub const LARGEST_MAX_ITERATIONS: usize = 1_000_000;

/// The median distance of so many points is good to 8 % of the noise.
const JUDGES: usize = 250;

/// Fewer points than this within the threshold determine no cylinder.
const FEWEST_POINTS: usize = 5;

/// Samples without an outlier can still be bad ones because of the noise, so some are always drawn.
const FEWEST_ITERATIONS: usize = 50;

/// The same for oriented samples, which are cheaper, and worse where normals are noisy.
const FEWEST_ORIENTED_ITERATIONS: usize = 200;

/// The part of the points that are inliers of a cylinder that needs no samples. Of normal noise it is 99 %.
const EXPLAINED_PART: f64 = 0.9;

/// The largest threshold of such a cylinder in parts of its radius: in more noise a handle or an edge beside it may look like
/// a part of one that is several times as large.
const CLEAR_PART: f64 = 0.1;

/// Probability that a sample without outliers has been drawn when the search stops before the largest number of samples.
const CONFIDENCE: f64 = 0.99;

/// Threshold in standard deviations of the noise, when it comes from the data: 1 % of the normal
/// distribution is outside.
const THRESHOLD_DEVIATIONS: f64 = 2.5;

/// The smallest threshold that comes from the data, in units of the size of the cloud: above the rounding of
/// a fit to points without noise.
const SMALLEST_THRESHOLD: f64 = 1e-7;

/// Settings of [`ransac`].
#[derive(Debug, Clone, PartialEq)]
pub struct RansacOptions {
    /// The largest number of samples, 1 to [`LARGEST_MAX_ITERATIONS`].
    pub max_iterations: usize,
    /// Largest distance from the surface of an inlier, in the unit of length of the data. Zero: chosen from
    /// the data, which needs more than half of the points on the cylinder. Of the first samples the cylinder
    /// with the least median distance gives a scale (least median of squares), and this is narrowed on its
    /// inliers until it is 2.5 standard deviations of their noise.
    pub threshold: f64,
    /// Seed of the random numbers.
    pub seed: u64,
    /// What the cylinder keeps. With a largest radius a plane may be the cylinder of that radius.
    pub limits: CylinderLimits,
}

impl Default for RansacOptions {
    fn default() -> Self {
        Self { max_iterations: 1000, threshold: 0.0, seed: 0, limits: CylinderLimits::default() }
    }
}

/// Finds the cylinder with the best support among the points; its axis point is near them.
///
/// `normals` are directions across the surface at the points, of any length and sign. `observer_at_origin`
/// says that the points are what an observer at the origin of coordinates sees. Points that are not finite
/// are left out. `check` is called at every sample and every step of the local optimisation; where it breaks the search
/// ends.
///
/// # Errors
/// `Cancelled` when `check` breaks;
/// `InvalidArgument` when an option is out of its range or there are not as many normals as points;
/// `TooFewPoints` when fewer than five points are finite; `NoStart` when the points lie in one plane or on
/// one line, or no cylinder within the limits comes near enough to five of them.
pub fn ransac(
    points: &[Vector3<f64>],
    normals: Option<&[Vector3<f64>]>,
    observer_at_origin: bool,
    options: &RansacOptions,
    check: Check<'_>,
) -> Result<Cylinder> {
    check_arguments(points, normals, options)?;
    searching(points, normals, observer_at_origin, options, check, |mut search| {
        let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
        let iterations = search.by_samples(&mut rng)?;
        let Search { scorer, best, check, samples, .. } = search;
        let nothing = || {
            no_start(format!(
                "none of {iterations} samples gave a cylinder with {FEWEST_POINTS} points within {}",
                short(scorer.threshold)
            ))
        };
        let cylinder = best.ok_or_else(nothing)?.cylinder;
        let inliers = scorer.inliers(&cylinder, points, check).map_err(|_| cancelled(samples))?;
        if inliers < FEWEST_POINTS {
            return Err(nothing());
        }
        Ok(cylinder)
    })
}

/// The cylinder next to a guess that explains points without outliers, so that there is little for samples to find; `None` where it
/// does not: the threshold comes from the data, and after the local optimisation nine tenths of the points are its inliers and the
/// threshold is at most a tenth of its radius.
///
/// # Errors
/// Those of [`ransac`].
pub fn explained(
    points: &[Vector3<f64>],
    observer_at_origin: bool,
    options: &RansacOptions,
    guess: &Cylinder,
    check: Check<'_>,
) -> Result<Option<Cylinder>> {
    check_arguments(points, None, options)?;
    searching(points, None, observer_at_origin, options, check, |mut search| search.explained_by(guess))
}

/// Does something with a search among points.
fn searching<T>(
    points: &[Vector3<f64>],
    normals: Option<&[Vector3<f64>]>,
    observer_at_origin: bool,
    options: &RansacOptions,
    check: Check<'_>,
    work: impl FnOnce(Search<'_>) -> Result<T>,
) -> Result<T> {
    let chosen = choose(points, check)?;
    let chosen_points: List<_> = chosen.iter().map(|&i| points[i]).collect();
    let chosen_normals: Option<List<_>> = normals.map(|n| chosen.iter().map(|&i| n[i]).collect());
    let Some(spread) = Spread::new(chosen_points.iter().map(|p| (*p, 1.0))) else {
        return Err(no_start("the points lie in one plane or on one line".into()));
    };
    let coordinates: List<[f64; 3]> = chosen_points.iter().map(|p| (*p).into()).collect();
    let mut cloud = PointCloud::default();
    cloud.push_points(&PointsView::from_f64(&coordinates), None)?;
    let [few, judges] = [FEW, chosen.len().div_ceil(JUDGES)]
        .map(|stride| cloud.listed(&(0..cloud.len()).step_by(stride).collect::<List<_>>()));

    let sampler = Sampler {
        points: &chosen_points,
        normals: chosen_normals.as_ref().map(|normals| &normals[..]),
        size: spread.size,
        observer_at_origin,
        cone: options.limits.cone(),
    };
    let scorer = Scorer {
        points: &chosen_points,
        term: PointTerm::new(&cloud, None),
        few: PointTerm::new(&few, None),
        judges: PointTerm::new(&judges, None),
        observer_at_origin,
        threshold: options.threshold,
        center: spread.center,
        size: spread.size,
        limits: options.limits,
    };
    work(Search { sampler, scorer, options, check, samples: 0, best: None, flat: None })
}

/// Whether to go on.
pub type Check<'a> = &'a mut dyn FnMut() -> ControlFlow<()>;

fn cancelled(samples: usize) -> Error {
    Error::Cancelled { iterations: samples }
}

/// A cylinder with its score at the threshold of the search.
#[derive(Clone, Copy)]
struct Candidate {
    cylinder: Cylinder,
    score: f64,
}

/// The state of a search.
struct Search<'a> {
    sampler: Sampler<'a>,
    scorer: Scorer<'a>,
    options: &'a RansacOptions,
    check: Check<'a>,
    /// Samples that were drawn, all in all.
    samples: usize,
    /// The best cylinder.
    best: Option<Candidate>,
    /// The best of those that are planes.
    flat: Option<Candidate>,
}

impl Search<'_> {
    /// [`explained`].
    fn explained_by(&mut self, guess: &Cylinder) -> Result<Option<Cylinder>> {
        if self.options.threshold > 0.0 {
            return Ok(None);
        }
        let Some(guess) = self.scorer.within_limits(guess) else { return Ok(None) };
        let Some(median) = self.scorer.median_distance_below(&guess, f64::INFINITY) else { return Ok(None) };
        self.start_from((guess, median))?;
        Ok(self.best.filter(|_| self.is_clear()).map(|best| best.cylinder))
    }

    /// Whether the best cylinder is no plane, has little noise and nearly all points.
    fn is_clear(&self) -> bool {
        self.best.is_some_and(|Candidate { cylinder, .. }| {
            self.scorer.threshold <= CLEAR_PART * cylinder.radius
                && self.scorer.inlier_fraction(&cylinder) >= EXPLAINED_PART
                && !self.scorer.is_flat_in_the_middle(&cylinder)
        })
    }

    /// Takes the best of random samples; returns how many were drawn once the threshold was known.
    fn by_samples(&mut self, rng: &mut ChaCha8Rng) -> Result<usize> {
        if self.options.threshold == 0.0 {
            self.choose_threshold(rng)?;
        }
        let iterations = self.run(rng)?;
        self.best = self.best.or(self.flat);
        if self.options.threshold == 0.0 {
            self.narrow_threshold()?;
        }
        Ok(iterations)
    }

    /// Draws samples until the best cylinder leaves enough confidence; returns their number.
    fn run(&mut self, rng: &mut ChaCha8Rng) -> Result<usize> {
        let mut needed = self.needed_iterations();
        let mut iterations = 0;
        while iterations < needed {
            iterations += 1;
            for hypothesis in self.draw(rng)? {
                if self.consider(&hypothesis)? {
                    needed = self.needed_iterations();
                }
            }
        }
        Ok(iterations)
    }

    /// The cylinders of the next sample.
    fn draw(&mut self, rng: &mut ChaCha8Rng) -> Result<List<Cylinder>> {
        if (self.check)().is_break() {
            return Err(cancelled(self.samples));
        }
        self.samples += 1;
        Ok(self.sampler.draw(rng))
    }

    /// Takes a hypothesis that scores better than the best one so far, and improves it.
    fn consider(&mut self, hypothesis: &Cylinder) -> Result<bool> {
        let Some(cylinder) = self.scorer.within_limits(hypothesis) else { return Ok(false) };
        let so_far = |other: &Option<Candidate>| other.map_or(f64::INFINITY, |other| other.score);
        let Some(score) = self.scorer.score_below(&cylinder, so_far(&self.best)) else { return Ok(false) };
        let given = Candidate { cylinder, score };
        if self.scorer.is_flat(&cylinder) {
            // Only the answer while there is no other, which is improved then.
            if score < so_far(&self.flat) {
                let improved = self.improve(&cylinder)?;
                self.take(improved);
            }
            return Ok(false);
        }
        let improved = self.improve(&cylinder)?;
        let better = improved.score < score && !self.scorer.is_flat(&improved.cylinder);
        self.best = Some(if better { improved } else { given });
        Ok(true)
    }

    fn improve(&mut self, cylinder: &Cylinder) -> Result<Candidate> {
        self.scorer.improve(cylinder, self.check).map_err(|error| match error {
            Error::Cancelled { .. } => cancelled(self.samples),
            other => other,
        })
    }

    /// Takes a candidate as the best of its kind.
    fn take(&mut self, candidate: Candidate) {
        let flat = self.scorer.is_flat(&candidate.cylinder);
        let best = if flat { &mut self.flat } else { &mut self.best };
        if best.is_none_or(|best| candidate.score < best.score) {
            *best = Some(candidate);
        }
    }

    /// log(1 − [`CONFIDENCE`]) / log(1 − wᵐ) samples of m points hold one without outliers, for the part w of
    /// the points that the best cylinder explains.
    fn needed_iterations(&self) -> usize {
        let most = self.options.max_iterations;
        let Some(best) = self.best else { return most };
        let (size, fewest) = if self.sampler.normals.is_some() {
            (2, FEWEST_ORIENTED_ITERATIONS)
        } else {
            (PLAIN_SAMPLE as i32, FEWEST_ITERATIONS)
        };
        let inliers = self.scorer.inlier_fraction(&best.cylinder);
        let needed = (1.0 - CONFIDENCE).ln() / (-inliers.powi(size)).ln_1p();
        // Without inliers this is infinite, with no outliers 0: the cast saturates.
        (needed.ceil() as usize).max(fewest).min(most)
    }

    /// Sets the threshold from the hypothesis with the least median distance.
    fn choose_threshold(&mut self, rng: &mut ChaCha8Rng) -> Result<()> {
        let draws =
            if self.sampler.normals.is_some() { FEWEST_ORIENTED_ITERATIONS } else { FEWEST_ITERATIONS };
        let mut least: Option<(Cylinder, f64)> = None;
        for _ in 0..draws.min(self.options.max_iterations) {
            for hypothesis in self.draw(rng)? {
                let Some(cylinder) = self.scorer.within_limits(&hypothesis) else { continue };
                let so_far = least.map_or(f64::INFINITY, |(_, so_far)| so_far);
                if let Some(median) = self.scorer.median_distance_below(&cylinder, so_far) {
                    least = Some((cylinder, median));
                }
            }
        }
        self.scorer.threshold = SMALLEST_THRESHOLD * self.scorer.size;
        // There is none where the observer sees less than half of the points.
        if let Some(least) = least {
            // The noise of a plane is that of the cylinder beside it.
            self.start_from(least)?;
            if let Some(best) = self.best.take() {
                self.take(best);
            }
        }
        Ok(())
    }

    /// Takes a cylinder, improved, and the threshold from the median distance of the points from it.
    fn start_from(&mut self, (cylinder, median): (Cylinder, f64)) -> Result<()> {
        let threshold = THRESHOLD_DEVIATIONS * DEVIATION_OF_MEDIAN * median;
        self.scorer.threshold = threshold.max(SMALLEST_THRESHOLD * self.scorer.size);
        self.best = Some(self.improve(&cylinder)?);
        self.narrow_threshold()
    }

    /// Narrows the threshold on the inliers of the best cylinder until it no longer shrinks.
    fn narrow_threshold(&mut self) -> Result<()> {
        /// With half of the points outliers the first threshold is too wide by a factor of about three.
        const ROUNDS: usize = 10;
        for _ in 0..ROUNDS {
            let Some(Candidate { cylinder, .. }) = self.best else { return Ok(()) };
            let Some(median) = self.scorer.median_inlier_distance(&cylinder) else { return Ok(()) };
            let threshold = THRESHOLD_DEVIATIONS * DEVIATION_OF_MEDIAN * median;
            let threshold = threshold.max(SMALLEST_THRESHOLD * self.scorer.size);
            if threshold > 0.99 * self.scorer.threshold {
                return Ok(());
            }
            self.scorer.threshold = threshold;
            self.best = Some(self.improve(&cylinder)?);
        }
        Ok(())
    }
}

/// Refuses options out of their range.
fn check_arguments(
    points: &[Vector3<f64>],
    normals: Option<&[Vector3<f64>]>,
    options: &RansacOptions,
) -> Result<()> {
    let RansacOptions { max_iterations, threshold, limits, .. } = *options;
    if let Some(normals) = normals.filter(|normals| normals.len() != points.len()) {
        let requirement = format!("be {}, the number of points", points.len());
        return Err(Error::argument("number of normals", normals.len(), requirement));
    }
    check_max_iterations("ransac_max_iterations", max_iterations as u64)?;
    not_negative("threshold", threshold)?;
    limits.check()
}

/// Refuses a largest number of samples out of its range. It has 64 bits, as in the C interface, where `usize` may have fewer.
pub(crate) fn check_max_iterations(name: &str, count: u64) -> Result<()> {
    if (1..=LARGEST_MAX_ITERATIONS as u64).contains(&count) {
        return Ok(());
    }
    Err(Error::argument(name, count, format!("lie in [1, {LARGEST_MAX_ITERATIONS}]")))
}

/// Indices of at most [`SCORED_POINTS`] finite points, evenly spaced among these.
fn choose(points: &[Vector3<f64>], check: Check<'_>) -> Result<List<usize>> {
    /// Points between two looks at whether to go on.
    const LOOKED_AT: usize = 1 << 16;
    let finite = |i: &usize| points[*i].iter().all(|x| x.is_finite());
    let parts =
        || (0..points.len()).step_by(LOOKED_AT).map(|first| first..(first + LOOKED_AT).min(points.len()));
    let mut usable = 0;
    for part in parts() {
        if check().is_break() {
            return Err(cancelled(0));
        }
        usable += part.filter(finite).count();
    }
    if usable < FEWEST_POINTS {
        return Err(Error::TooFewPoints {
            usable,
            given: points.len(),
            left_out: match points.len() - usable {
                0 => String::new(),
                bad => format!(" ({bad} not finite)"),
            },
            needed: FEWEST_POINTS,
            remedy: "give more points with finite coordinates",
        });
    }
    let wanted = usable.min(SCORED_POINTS) as u64;
    let before = |rank: usize| rank as u64 * wanted / usable as u64;
    let (mut chosen, mut rank) = (List::new(), 0);
    for part in parts() {
        if check().is_break() {
            return Err(cancelled(0));
        }
        for index in part.filter(finite) {
            if before(rank) < before(rank + 1) {
                chosen.push(index);
            }
            rank += 1;
        }
    }
    Ok(chosen)
}

fn no_start(reason: String) -> Error {
    Error::NoStart { reason }
}

#[cfg(test)]
mod tests;
