//! The score of a cylinder, its local optimisation, and whether it is a plane.

use super::{Candidate, Check, cancelled};
use crate::error::{Result, unless_cancelled};
use crate::geometry::{Chart, Cylinder, CylinderLimits, LocalFrame, Plane};
use crate::memory::List;
use crate::residuals::{NormalEquations, Objective, PointRows, PointTerm, Truncated, Wall};
use crate::solver::{Domain, IterationLimits, minimise};
use crate::statistics::{median_absolute, median_point};
use nalgebra::Vector3;

/// Threshold of the first part of the local optimisation, in units of the final one: wide enough for the
/// error of a hypothesis from few noisy points.
const WIDE: f64 = 3.0;

/// Limit of steps in each part of the local optimisation.
const STEPS: usize = 16;

/// An improvement of the score by less than this part ends the local optimisation: it is a start only.
const SMALL_GAIN: f64 = 1e-4;

/// Points that are counted between two looks at whether the caller wants to stop.
const COUNTED: usize = 1 << 16;

/// An arc is flat at most where its radius is this many times the deviation of its points across axis and normal: it
/// spans 40° and less (evenly filled, an arc of the width w has the deviation w/√12).
const FLAT_RADIUS: f64 = 5.0;

/// A plane explains such an arc as well where it has at least this part of its points within the threshold t. Of a
/// parabola of the sagitta s a band of 2 t holds √(2 t / s): the sagitta is less than three thresholds then. More
/// than two, which is where the plane begins to lose points, because sensors bend planes.
const FLAT_PART: f64 = 0.8;

/// Rounds in which the plane is fitted to the inliers near it.
const PLANE_ROUNDS: usize = 4;

/// Measures cylinders against the scored points.
#[derive(Clone, Copy)]
pub(super) struct Scorer<'a> {
    pub points: &'a [Vector3<f64>],
    /// The same points for sums over them.
    pub term: PointTerm<'a>,
    /// Every so many of them, which tell most bad cylinders.
    pub few: PointTerm<'a>,
    /// About as many as a median distance needs.
    pub judges: PointTerm<'a>,
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

/// A cylinder with what does not depend on the point.
struct Surface {
    rows: PointRows,
    wall: Wall,
    unit: f64,
}

impl Surface {
    /// Distance from the surface; infinite on the hidden wall.
    fn distance(&self, p: &Vector3<f64>) -> f64 {
        let (residual, facing) = self.rows.residual(p);
        if self.wall.hides(facing) { f64::INFINITY } else { residual.abs() * self.unit }
    }
}

impl Scorer<'_> {
    fn frame(&self, cylinder: &Cylinder) -> LocalFrame {
        LocalFrame::new(cylinder, &self.center, self.size)
    }

    fn surface(&self, cylinder: &Cylinder) -> Surface {
        let rows = PointRows::new(&self.frame(cylinder));
        Surface { rows, wall: self.loss(cylinder).wall, unit: self.size }
    }

    /// How the points count for a cylinder, in units of the size of the data.
    fn loss(&self, cylinder: &Cylinder) -> Truncated {
        let wall = match self.observer_at_origin {
            false => Wall::Either,
            true if cylinder.contains_origin() => Wall::Averted,
            true => Wall::Facing,
        };
        Truncated { threshold: self.threshold / self.size, wall }
    }

    /// The mean of min(e², threshold²) / threshold².
    pub fn score(&self, cylinder: &Cylinder) -> f64 {
        let loss = self.loss(cylinder);
        self.term.cost(&self.frame(cylinder), loss) / (loss.threshold * loss.threshold)
    }

    /// The score where it is below a limit; `None` where a part of the points shows that it is not.
    pub fn score_below(&self, cylinder: &Cylinder, limit: f64) -> Option<f64> {
        /// The part is that far off in so many cases at most: four standard deviations of the mean of numbers between 0
        /// and 1.
        const DEVIATIONS: f64 = 4.0;
        let rough = Self { term: self.few, ..*self }.score(cylinder);
        let margin = DEVIATIONS * 0.5 / (self.few.count() as f64).sqrt();
        if rough - margin >= limit {
            return None;
        }
        Some(self.score(cylinder)).filter(|score| *score < limit)
    }

    /// The number of points within the threshold.
    pub fn inliers(&self, cylinder: &Cylinder, points: &[Vector3<f64>], check: Check<'_>) -> Result<usize> {
        let surface = self.surface(cylinder);
        let mut inliers = 0;
        for points in points.chunks(COUNTED) {
            if check().is_break() {
                return Err(cancelled(0));
            }
            inliers += points.iter().filter(|p| surface.distance(p) < self.threshold).count();
        }
        Ok(inliers)
    }

    /// The distances of points from the surface, in units of the size; infinite on the hidden wall.
    fn distances(&self, points: &PointTerm<'_>, cylinder: &Cylinder) -> List<f64> {
        let mut distances = points.distances_on(self.loss(cylinder).wall, &self.frame(cylinder));
        distances.iter_mut().for_each(|distance| *distance = distance.abs());
        distances
    }

    /// The part of the scored points within the threshold.
    pub fn inlier_fraction(&self, cylinder: &Cylinder) -> f64 {
        let distances = self.distances(&self.term, cylinder);
        let inliers = distances.iter().filter(|e| **e * self.size < self.threshold).count();
        inliers as f64 / self.points.len() as f64
    }

    /// The median distance over some of the points where it is below `limit`.
    pub fn median_distance_below(&self, cylinder: &Cylinder, limit: f64) -> Option<f64> {
        let distances = self.distances(&self.judges, cylinder);
        // Most samples are worse, which a count tells: no order.
        let below = distances.iter().filter(|e| **e * self.size < limit).count();
        (below > distances.len() / 2).then(|| median_absolute(distances.iter().copied()) * self.size)
    }

    /// The median distance of the points within the threshold, if any.
    pub fn median_inlier_distance(&self, cylinder: &Cylinder) -> Option<f64> {
        let mut distances = self.distances(&self.term, cylinder);
        distances.retain(|e| *e * self.size < self.threshold);
        (!distances.is_empty()).then(|| median_absolute(distances.iter().copied()) * self.size)
    }

    /// The cylinder moved into the limits; `None` when its radius is not positive or not finite.
    pub fn within_limits(&self, cylinder: &Cylinder) -> Option<Cylinder> {
        let moved = self.limits.nearest(cylinder, &self.center);
        (moved.radius > 0.0 && moved.radius.is_finite()).then_some(moved)
    }

    /// Whether a plane through most of the inliers explains as many points, where no limit keeps the radius from
    /// running away.
    pub fn is_flat(&self, cylinder: &Cylinder) -> bool {
        self.is_plane(cylinder, |inliers| Plane::nearest(inliers.iter()))
    }

    /// The same by the plane that touches the cylinder at the median of the inliers: where some of them are far away, on the other
    /// side of a cylinder that is no body, no plane is near all.
    pub fn is_flat_in_the_middle(&self, cylinder: &Cylinder) -> bool {
        self.is_plane(cylinder, |inliers| {
            (!inliers.is_empty()).then(|| Plane::tangent(cylinder, median_point(inliers)))
        })
    }

    /// Whether a plane, found from a first one about the inliers, explains as many points.
    fn is_plane(&self, cylinder: &Cylinder, first: impl FnOnce(&[Vector3<f64>]) -> Option<Plane>) -> bool {
        if self.limits.radius_max < f64::INFINITY {
            return false;
        }
        let distances = self.distances(&self.term, cylinder);
        let is_inlier = |distance: &f64| distance * self.size < self.threshold;
        let pairs = self.points.iter().zip(&distances);
        let inliers: List<Vector3<f64>> =
            pairs.filter(|(_, distance)| is_inlier(distance)).map(|(p, _)| *p).collect();
        let Some(mut plane) = first(&inliers) else { return false };
        let mut near: List<Vector3<f64>> = List::new();
        for _ in 0..PLANE_ROUNDS {
            near.clear();
            near.extend(inliers.iter().filter(|p| plane.distance(p) < self.threshold));
            let Some(next) = Plane::nearest(near.iter()) else { return false };
            plane = next;
        }
        let across = cylinder.axis.direction.cross(&plane.normal);
        let spread = across.dot(&(plane.covariance * across)).max(0.0).sqrt();
        let few_degrees = cylinder.radius > FLAT_RADIUS * spread;
        let explained = self.points.iter().filter(|p| plane.distance(p) < self.threshold).count();
        few_degrees && 2 * near.len() > inliers.len() && explained as f64 >= FLAT_PART * inliers.len() as f64
    }

    /// Local optimisation, first with a wide threshold and then with the final one.
    pub fn improve(&self, cylinder: &Cylinder, check: Check<'_>) -> Result<Candidate> {
        let wide = Self { threshold: WIDE * self.threshold, ..*self };
        let near = wide.descend(cylinder, check)?;
        let cylinder = self.descend(&near, check)?;
        Ok(Candidate { cylinder, score: self.score(&cylinder) })
    }

    /// Levenberg–Marquardt on the score: where no point crosses the threshold its linearisation is that of the
    /// inliers.
    fn descend(&self, cylinder: &Cylinder, check: Check<'_>) -> Result<Cylinder> {
        let limits = IterationLimits {
            max_iterations: STEPS,
            cost_tolerance: SMALL_GAIN,
            ..IterationLimits::default()
        };
        let domain =
            Domain { data_center: self.center, unit: self.size, chart: Chart::Local, limits: &self.limits };
        let convergence = minimise(self, cylinder, &domain, &limits, &mut |_| check());
        // A hypothesis whose cost is not finite stays what it is.
        Ok(unless_cancelled(convergence)?.map_or(*cylinder, |convergence| convergence.cylinder))
    }
}

impl Objective for Scorer<'_> {
    fn linearise(&self, frame: &LocalFrame) -> Option<NormalEquations> {
        let radius = frame.cylinder.radius;
        (radius > 0.0 && radius.is_finite())
            .then(|| self.term.linearise(frame, self.loss(&frame.cylinder)))
            .filter(|equations| equations.cost.is_finite())
    }

    fn cost(&self, frame: &LocalFrame) -> Option<f64> {
        let radius = frame.cylinder.radius;
        (radius > 0.0 && radius.is_finite())
            .then(|| self.term.cost(frame, self.loss(&frame.cylinder)))
            .filter(|cost| cost.is_finite())
    }
}
