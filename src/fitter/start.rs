//! First stage: candidates for the start, and the choice among them.

use super::constraints::Constraints;
use super::data::{Data, ViewData};
use super::options::StartKind;
use super::run::Run;
use crate::error::{Error, Result, unless_cancelled};
use crate::geometry::Cylinder;
use crate::memory::List;
use crate::start::moments::Moments;
use crate::start::ransac::{RansacOptions, explained, ransac};
use crate::statistics::{DEVIATION_OF_MEDIAN, median_absolute};
use nalgebra::Vector3;

/// Points that starts are judged on: a start needs no more.
pub(super) const SAMPLE: usize = 500;

/// Points that tell whether a guess leaves random samples anything to find.
const TELLING: usize = 1000;

/// A start explains the points when their median distance is at most this part of its radius: depth noise on
/// the smallest cylinders that can be measured is half of it.
pub(super) const EXPLAINED: f64 = 0.1;

/// A start and how it was found.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    pub kind: StartKind,
    pub cylinder: Cylinder,
}

impl Data<'_> {
    /// The starts that the options ask for, the most promising first.
    pub fn candidates(&self, run: &mut Run<'_>) -> Result<List<Candidate>> {
        let given = self.start.map(|cylinder| self.within_limits(cylinder));
        let of_model = given.map(|cylinder| Candidate { kind: StartKind::Model, cylinder });
        let found = |kind: StartKind, cylinder: Option<Cylinder>| {
            cylinder.map(|cylinder| List::from([Candidate { kind, cylinder }]))
        };
        match self.options.start {
            StartKind::Model => found(StartKind::Model, given).ok_or(Error::BadState {
                call: "fit from a given model",
                missing: "a start model",
                remedy: "set one or choose another kind of start",
            }),
            StartKind::Limbs => {
                let starts = self.limbs_starts();
                let none = || Error::EdgeGeometry {
                    reason: "the edges and points do not give a cylinder".to_string(),
                    remedy: "push two segments on the two limbs, or choose another kind of start",
                };
                if starts.is_empty() { Err(none()) } else { Ok(starts) }
            }
            StartKind::Moments => found(StartKind::Moments, self.moments_start()).ok_or_else(|| {
                Error::NoStart { reason: "the moments of the points give no cylinder".into() }
            }),
            StartKind::Ransac => {
                Ok(List::from([Candidate { kind: StartKind::Ransac, cylinder: self.ransac(run)? }]))
            }
            StartKind::Auto => self.choose(of_model, run),
            StartKind::Last => self.choose(self.last.map(|last| self.start_of(last)).or(of_model), run),
        }
    }

    /// Eberly's algebraic fit with a direction that is allowed, its radius moved into the limits.
    pub fn moments_start(&self) -> Option<Cylinder> {
        self.moments_start_of(self.weighted_points())
    }

    fn moments_start_of(
        &self,
        points: impl Iterator<Item = (Vector3<f64>, f64)> + Clone,
    ) -> Option<Cylinder> {
        let fit = Moments::new(points)?.best(self.options.cylinder_limits.cone())?;
        Some(self.within_limits(&fit.cylinder))
    }

    /// The best of random samples. The points of several views have no common observer.
    pub fn ransac(&self, run: &mut Run<'_>) -> Result<Cylinder> {
        let points: List<Vector3<f64>> = self.points().collect();
        let normals = self.normals();
        let (normals, observed) = (normals.as_ref().map(|normals| &normals[..]), self.is_observed());
        ransac(&points, normals, observed, &self.ransac_options(), &mut || run.report_again())
    }

    /// The same, but where a guess explains some of the points the cylinder next to it.
    pub fn ransac_unless_explained(&self, guess: Option<Cylinder>, run: &mut Run<'_>) -> Result<Cylinder> {
        let options = self.ransac_options();
        let sample = self.sample(TELLING);
        let near =
            |guess| explained(&sample, self.is_observed(), &options, &guess, &mut || run.report_again());
        match guess.map(near).transpose()?.flatten() {
            Some(cylinder) => Ok(cylinder),
            None => self.ransac(run),
        }
    }

    fn ransac_options(&self) -> RansacOptions {
        RansacOptions {
            max_iterations: self.options.ransac_iterations,
            threshold: self.options.ransac_threshold,
            seed: self.options.seed,
            limits: self.limits_of_iteration(),
        }
    }

    /// Whether the points are what an observer at the origin sees.
    fn is_observed(&self) -> bool {
        self.views.len() == 1 && self.near_wall()
    }

    /// The normals of the points in the reference frame, where all have one.
    fn normals(&self) -> Option<List<Vector3<f64>>> {
        let mut all = List::new();
        for view in &self.views {
            let to_reference = view.into_view.inverse();
            let normals = view.view.cloud.normals()?;
            all.extend(normals.iter().map(|normal| to_reference.direction(&normal.cast())));
        }
        Some(all)
    }

    /// The starts from the two longest segments of each view.
    fn limbs_starts(&self) -> List<Candidate> {
        let start = |view: &ViewData<'_>| {
            let sample = || view.view.cloud.sampled(SAMPLE).collect::<List<_>>();
            let found = view.of_limbs.or_else(|| view.edges.cylinder(&sample()))?;
            let cylinder = self.within_limits(&view.into_view.inverse().cylinder(&found));
            Some(Candidate { kind: StartKind::Limbs, cylinder })
        };
        self.views.iter().filter_map(start).collect()
    }

    /// All candidates, the one that explains the sample best first.
    fn choose(&self, given: Option<Candidate>, run: &mut Run<'_>) -> Result<List<Candidate>> {
        let by_view = self.samples(SAMPLE);
        let sample = self.in_reference(&by_view);
        let judge = |candidate: Candidate| (median_distance(&candidate.cylinder, &sample), candidate);
        let mut candidates: List<(f64, Candidate)> = self.limbs_starts().into_iter().map(judge).collect();
        // Random samples take longer than all the rest: only where the limbs do not explain the points.
        let explained = candidates.iter().any(|(median, start)| *median <= EXPLAINED * start.cylinder.radius);
        candidates.splice(0..0, given.map(judge));
        // Of some points: as good for a start.
        let moments = self.moments_start_of(sample.iter().map(|p| (*p, 1.0)));
        candidates.extend(moments.map(|cylinder| judge(Candidate { kind: StartKind::Moments, cylinder })));
        let mut failure = None;
        if !explained {
            match unless_cancelled(self.ransac_unless_explained(moments, run))? {
                Ok(cylinder) => candidates.push(judge(Candidate { kind: StartKind::Ransac, cylinder })),
                Err(error) => failure = Some(error),
            }
        }
        let smallest = candidates.iter().map(|(median, _)| *median).min_by(f64::total_cmp);
        let smallest = smallest.ok_or_else(|| nothing_found(failure))?;
        // Three standard deviations of the noise around the best candidate.
        let scale = (3.0 * DEVIATION_OF_MEDIAN * smallest).max(f64::MIN_POSITIVE);
        let constraints = Constraints::as_given(self);
        let cost = |cylinder: &Cylinder| {
            cost_of_points(cylinder, &sample, scale) + self.cost_of_views(&constraints, cylinder, &by_view)
        };
        let mut judged: List<(f64, Candidate)> =
            candidates.into_iter().map(|(_, candidate)| (cost(&candidate.cylinder), candidate)).collect();
        judged.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok(judged.into_iter().map(|(_, candidate)| candidate).collect())
    }

    /// For each view the mean of truncated squares of endpoints, in [0, 1]; 1 more when most of its points are on the wall that
    /// the camera cannot see.
    fn cost_of_views(
        &self,
        constraints: &Constraints,
        cylinder: &Cylinder,
        samples: &[List<Vector3<f64>>],
    ) -> f64 {
        let mut cost = 0.0;
        for ((view, constraints), sample) in self.views.iter().zip(&constraints.views).zip(samples) {
            let seen = view.seen(cylinder);
            if view.observed && seen.visible_wall(sample.iter().copied()).fraction() < 0.5 {
                cost += 1.0;
            }
            let Some(lines) = &constraints.lines else { continue };
            let contradiction = view.noise.gross();
            cost += lines.distances(&seen).map_or(1.0, |distances| {
                let count = 2 * distances.len();
                distances.iter().flatten().map(|d| truncated(d / contradiction)).sum::<f64>() / count as f64
            });
        }
        cost
    }
}

/// The mean of truncated squares of points, in [0, 1]; 0 for none.
fn cost_of_points(cylinder: &Cylinder, sample: &[Vector3<f64>], scale: f64) -> f64 {
    let sum: f64 = sample.iter().map(|p| truncated(cylinder.distance(p) / scale)).sum();
    sum / sample.len().max(1) as f64
}

/// The square of a ratio, at most 1.
fn truncated(ratio: f64) -> f64 {
    (ratio * ratio).min(1.0)
}

/// Median distance of points from a surface, 0 for no points.
pub(super) fn median_distance(cylinder: &Cylinder, points: &[Vector3<f64>]) -> f64 {
    median_absolute(points.iter().map(|p| cylinder.distance(p)))
}

/// Why no start was found: what random samples failed by, which is a failure of its own with its own remedy.
fn nothing_found(failure: Option<Error>) -> Error {
    let reason = "limbs, moments and random samples of the points give no cylinder";
    failure.unwrap_or_else(|| Error::NoStart { reason: reason.into() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_random_samples_failed_by_is_said_once() {
        let failure = Error::NoStart { reason: "the points lie in one plane or on one line".into() };
        let text = nothing_found(Some(failure)).to_string();
        assert_eq!(
            text,
            "no start was found: the points lie in one plane or on one line; give a start model"
        );
        assert!(nothing_found(None).to_string().starts_with("no start was found: limbs, moments"));
    }
}
