//! Candidates for the start, and the choice among them.

use super::options::StartKind;
use super::problem::Problem;
use crate::error::{Error, Result};
use crate::geometry::Cylinder;
use crate::start::limbs::from_limbs;
use crate::start::moments::Moments;
use crate::start::ransac::{RansacFit, RansacOptions, ransac};
use crate::statistics::{DEVIATION_OF_MEDIAN, median};
use nalgebra::Vector3;

/// Points that starts are judged on: a start needs no more.
const SAMPLE: usize = 500;

/// A start explains the points when their median distance is at most this part of its radius: depth noise on
/// the smallest cylinders that can be measured is half of it.
const EXPLAINED: f64 = 0.1;

/// A start and how it was found.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    pub kind: StartKind,
    pub cylinder: Cylinder,
}

impl Problem<'_> {
    /// The starts that the options ask for, the most promising first.
    pub fn candidates(&self, given: Option<&Cylinder>) -> Result<Vec<Candidate>> {
        let given = given.map(|cylinder| self.within_limits(cylinder));
        let given = given.as_ref();
        let found = |kind: StartKind, cylinder: Option<Cylinder>| {
            cylinder.map(|cylinder| vec![Candidate { kind, cylinder }])
        };
        let sample = self.start_sample();
        match self.options.start {
            StartKind::Model => found(StartKind::Model, given.copied()).ok_or(Error::BadState {
                call: "fit from a given model",
                missing: "a start model",
                remedy: "set one or choose another kind of start",
            }),
            StartKind::Limbs => found(StartKind::Limbs, self.limbs_start(&sample)).ok_or_else(|| {
                let reason = "the edges and points do not give a cylinder".to_string();
                let remedy = "push two segments on the two limbs, or choose another kind of start";
                Error::EdgeGeometry { reason, remedy }
            }),
            StartKind::Moments => found(StartKind::Moments, self.moments_start()).ok_or_else(|| {
                Error::NoStart { reason: "the moments of the points give no cylinder".into() }
            }),
            StartKind::Ransac => {
                Ok(vec![Candidate { kind: StartKind::Ransac, cylinder: self.ransac()?.cylinder }])
            }
            StartKind::Auto => self.choose(given, &sample),
        }
    }

    /// The points that starts are found from and judged on.
    pub fn start_sample(&self) -> Vec<Vector3<f64>> {
        self.cloud.sample(SAMPLE)
    }

    /// The cylinder moved into the limits of the iteration.
    fn within_limits(&self, cylinder: &Cylinder) -> Cylinder {
        self.limits_of_iteration().nearest(cylinder, &self.center)
    }

    /// Eberly's algebraic fit with a direction that is allowed, its radius moved into the limits.
    pub fn moments_start(&self) -> Option<Cylinder> {
        let weighted = (0..self.cloud.len()).map(|k| (self.cloud.point(k), self.cloud.weight(k)));
        let fit = Moments::new(weighted)?.best(self.options.cylinder_limits.cone())?;
        Some(self.within_limits(&fit.cylinder))
    }

    pub fn ransac(&self) -> Result<RansacFit> {
        let points: Vec<Vector3<f64>> = self.cloud.points().collect();
        let options = RansacOptions {
            max_iterations: self.options.ransac_iterations,
            threshold: self.options.ransac_threshold,
            seed: self.options.seed,
            limits: self.limits_of_iteration(),
            ..RansacOptions::default()
        };
        let normals: Option<Vec<Vector3<f64>>> =
            self.cloud.normals().map(|normals| normals.iter().map(|n| n.cast()).collect());
        ransac(&points, normals.as_deref(), self.near_wall, &options)
    }

    fn limbs_start(&self, sample: &[Vector3<f64>]) -> Option<Cylinder> {
        // The two longest segments say most about the limbs.
        let mut order: Vec<usize> = (0..self.edges.segments.len()).collect();
        let length = |k: &usize| {
            let [a, b] = self.edges.segments[*k].endpoints;
            (a - b).norm()
        };
        order.sort_by(|a, b| length(b).total_cmp(&length(a)));
        let [first, second, ..] = order[..] else { return None };
        from_limbs(&self.edges.rays[first], &self.edges.rays[second], sample)
            .map(|start| self.within_limits(&start))
    }

    /// All candidates, the one that explains the sample best first.
    fn choose(&self, given: Option<&Cylinder>, sample: &[Vector3<f64>]) -> Result<Vec<Candidate>> {
        let mut candidates: Vec<Candidate> = Vec::new();
        let mut add = |kind, cylinder: Option<Cylinder>| {
            candidates.extend(cylinder.map(|cylinder| Candidate { kind, cylinder }));
        };
        let from_limbs = self.limbs_start(sample);
        add(StartKind::Model, given.copied());
        add(StartKind::Limbs, from_limbs);
        add(StartKind::Moments, self.moments_start());
        let mut failure = "limbs, moments and random samples of the points give no cylinder".to_string();
        // Random samples take longer than all the rest: only where the limbs do not explain the points.
        let explained = |start: &Cylinder| median_distance(start, sample) <= EXPLAINED * start.radius;
        if !from_limbs.as_ref().is_some_and(explained) {
            match self.ransac() {
                Ok(fit) => add(StartKind::Ransac, Some(fit.cylinder)),
                Err(error) => failure = error.to_string(),
            }
        }
        if candidates.is_empty() {
            return Err(Error::NoStart { reason: failure });
        }
        let smallest =
            candidates.iter().map(|c| median_distance(&c.cylinder, sample)).fold(f64::INFINITY, f64::min);
        // Three standard deviations of the noise around the best candidate.
        let scale = (3.0 * DEVIATION_OF_MEDIAN * smallest).max(f64::MIN_POSITIVE);
        let cost = |candidate: &Candidate| self.robust_cost(&candidate.cylinder, sample, scale);
        let mut judged: Vec<(f64, Candidate)> = candidates.into_iter().map(|c| (cost(&c), c)).collect();
        judged.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok(judged.into_iter().map(|(_, candidate)| candidate).collect())
    }

    /// Truncated squares of points and endpoints, each part in [0, 1]; 1 more when most points are on the wall
    /// that the camera cannot see.
    fn robust_cost(&self, cylinder: &Cylinder, sample: &[Vector3<f64>], scale: f64) -> f64 {
        let truncated = |ratio: f64| (ratio * ratio).min(1.0);
        let mut cost = 0.0;
        if !sample.is_empty() {
            let sum: f64 = sample.iter().map(|p| truncated(cylinder.distance(p) / scale)).sum();
            cost += sum / sample.len() as f64;
            let walls = cylinder.visible_wall(sample.iter().copied());
            if self.near_wall && walls.fraction() < 0.5 {
                cost += 1.0;
            }
        }
        if let Some(pixels) = &self.pixels {
            cost += pixels.distances(cylinder).map_or(1.0, |distances| {
                let count = 2 * distances.len();
                let all = distances.iter().flatten();
                all.map(|d| truncated(d / self.noise.gross())).sum::<f64>() / count as f64
            });
        }
        cost
    }
}

/// Median distance of points from a surface, 0 for no points.
fn median_distance(cylinder: &Cylinder, points: &[Vector3<f64>]) -> f64 {
    let mut distances: Vec<f64> = points.iter().map(|p| cylinder.distance(p).abs()).collect();
    median(&mut distances)
}
