//! The score of a cylinder and its local optimisation.

use super::Candidate;
use crate::geometry::{Cylinder, CylinderLimits, LocalFrame, Tangent, TangentMap};
use crate::statistics::median;
use nalgebra::Vector3;

/// Points between two looks at whether a score is lost.
const STRIDE: usize = 64;

/// Threshold of the first part of the local optimisation, in units of the final one: wide enough for the
/// error of a hypothesis from few noisy points.
const WIDE: f64 = 3.0;

/// Limit of steps in each part of the local optimisation.
const STEPS: usize = 16;

/// An improvement of the score by less than this part ends the local optimisation: it is a start only.
const SMALL_GAIN: f64 = 1e-4;

/// Measures cylinders against the scored points.
#[derive(Clone, Copy)]
pub(super) struct Scorer<'a> {
    pub points: &'a [Vector3<f64>],
    /// Whether a point on the hidden wall is an outlier.
    pub observer_at_origin: bool,
    /// Largest distance of an inlier from the surface.
    pub threshold: f64,
    /// Mean of the points.
    pub center: Vector3<f64>,
    /// Root mean square distance of the points from their mean.
    pub size: f64,
    /// What every cylinder keeps.
    pub limits: CylinderLimits,
}

/// Where a point lies in relation to a cylinder.
struct Placed {
    /// Signed distance from the surface.
    distance: f64,
    /// From the axis to the point.
    radial: Vector3<f64>,
    /// Coordinate along the axis, from its point.
    along: f64,
    /// Whether the point lies on the wall that the observer cannot see.
    hidden: bool,
}

/// A cylinder with what does not depend on the point.
struct Surface {
    cylinder: Cylinder,
    /// Whether the observer is inside; `None` without an observer.
    inside: Option<bool>,
}

impl Surface {
    fn place(&self, p: &Vector3<f64>) -> Placed {
        let Cylinder { axis, radius } = &self.cylinder;
        let offset = p - axis.point;
        let along = offset.dot(&axis.direction);
        let radial = offset - axis.direction * along;
        let hidden = self.inside.is_some_and(|inside| (radial.dot(p) < 0.0) == inside);
        Placed { distance: radial.norm() - radius, radial, along, hidden }
    }

    /// Distance from the surface; infinite on the hidden wall.
    fn distance(&self, p: &Vector3<f64>) -> f64 {
        let placed = self.place(p);
        if placed.hidden { f64::INFINITY } else { placed.distance.abs() }
    }
}

impl Scorer<'_> {
    fn surface(&self, cylinder: &Cylinder) -> Surface {
        let inside = self.observer_at_origin.then(|| cylinder.contains_origin());
        Surface { cylinder: *cylinder, inside }
    }

    /// The mean of min(e², threshold²) / threshold², if it is less than `limit`.
    pub fn score(&self, cylinder: &Cylinder, limit: f64) -> Option<f64> {
        let surface = self.surface(cylinder);
        let most = self.threshold * self.threshold;
        let lost = limit * most * self.points.len() as f64;
        let mut sum = 0.0;
        for points in self.points.chunks(STRIDE) {
            sum += points.iter().map(|p| surface.distance(p).powi(2).min(most)).sum::<f64>();
            if sum >= lost {
                return None;
            }
        }
        Some(sum / (most * self.points.len() as f64))
    }

    /// The number of points within the threshold.
    pub fn inliers(&self, cylinder: &Cylinder, points: &[Vector3<f64>]) -> usize {
        let surface = self.surface(cylinder);
        points.iter().filter(|p| surface.distance(p) < self.threshold).count()
    }

    /// The median distance over some of the points; infinite when half of them are on the hidden wall.
    pub fn median_distance(&self, cylinder: &Cylinder) -> f64 {
        /// The median of so many points is good to 8 % of the noise.
        const ENOUGH: usize = 250;
        let surface = self.surface(cylinder);
        let stride = self.points.len().div_ceil(ENOUGH);
        median_of(self.points.iter().step_by(stride).map(|p| surface.distance(p)).collect())
            .unwrap_or(f64::INFINITY)
    }

    /// The median distance of the points within the threshold, if any.
    pub fn median_inlier_distance(&self, cylinder: &Cylinder) -> Option<f64> {
        let surface = self.surface(cylinder);
        median_of(self.points.iter().map(|p| surface.distance(p)).filter(|e| *e < self.threshold).collect())
    }

    /// The cylinder moved into the limits; `None` when its radius is not positive or not finite.
    pub fn within_limits(&self, cylinder: &Cylinder) -> Option<Cylinder> {
        let moved = self.limits.nearest(cylinder, &self.center);
        (moved.radius > 0.0 && moved.radius.is_finite()).then_some(moved)
    }

    /// Local optimisation, first with a wide threshold and then with the final one.
    pub fn improve(&self, cylinder: &Cylinder) -> Candidate {
        let wide = Self { threshold: WIDE * self.threshold, ..*self };
        self.descend(&wide.descend(cylinder).cylinder)
    }

    /// Levenberg–Marquardt steps on the inliers, each accepted when it lowers the score: where no point
    /// crosses the threshold this is the gradient of the score.
    fn descend(&self, cylinder: &Cylinder) -> Candidate {
        let score = self.score(cylinder, f64::INFINITY).unwrap_or(f64::INFINITY);
        let mut best = Candidate { cylinder: *cylinder, score };
        let mut damping = 1e-3;
        let mut frame = LocalFrame::new(&best.cylinder, &self.center, self.size);
        let mut equations = self.normal_equations(&frame);
        for _ in 0..STEPS {
            let (mut matrix, gradient) = equations;
            // The part of the trace keeps the matrix regular when the inliers leave a direction free.
            let floor = 1e-12 * matrix.trace();
            for i in 0..5 {
                matrix[(i, i)] += damping * matrix[(i, i)] + floor;
            }
            let Some((_, moved)) = self.limits.step(&frame, &matrix, &gradient) else { break };
            let trial = self.within_limits(&moved).and_then(|cylinder| {
                self.score(&cylinder, best.score).map(|score| Candidate { cylinder, score })
            });
            let Some(trial) = trial else {
                damping *= 10.0;
                continue;
            };
            let gain = best.score - trial.score;
            best = trial;
            if gain < SMALL_GAIN * best.score {
                break;
            }
            damping *= 0.1;
            frame = LocalFrame::new(&best.cylinder, &self.center, self.size);
            equations = self.normal_equations(&frame);
        }
        best
    }

    /// Jᵀ J and Jᵀ e of the inliers for e = ‖(p − c) × d̂‖ − r, both lengths in units of the frame:
    /// J = −(n·u, n·v, h n·u, h n·v, 1) with the outward normal n and the coordinate h along the axis.
    fn normal_equations(&self, frame: &LocalFrame) -> (TangentMap, Tangent) {
        let surface = self.surface(&frame.cylinder);
        let mut matrix = TangentMap::zeros();
        let mut gradient = Tangent::zeros();
        for p in self.points {
            let Placed { distance, radial, along, hidden } = surface.place(p);
            let from_axis = distance + frame.cylinder.radius;
            // A point on the axis has no normal.
            if hidden || distance.abs() >= self.threshold || from_axis <= 0.0 {
                continue;
            }
            let (across_u, across_v) = (radial.dot(&frame.u) / from_axis, radial.dot(&frame.v) / from_axis);
            let h = along / frame.unit;
            let row = -Tangent::new(across_u, across_v, h * across_u, h * across_v, 1.0);
            matrix.ger(1.0, &row, &row, 1.0);
            gradient += row * (distance / frame.unit);
        }
        (matrix, gradient)
    }
}

/// The median, if there are any values.
fn median_of(mut values: Vec<f64>) -> Option<f64> {
    (!values.is_empty()).then(|| median(&mut values))
}
