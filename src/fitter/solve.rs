//! From a start to the minimum of the chosen objective.

use super::options::{ChartChoice, Method, ObjectiveKind};
use super::problem::Problem;
use crate::error::{Error, Result};
use crate::geometry::{Chart, Cylinder, LocalFrame};
use crate::residuals::{
    NormalEquations, Objective, PaperObjective, RobustObjective, RobustScales, Sandwich, TUKEY_EFFICIENT,
};
use crate::solver::{Convergence, Domain, Iteration, IterationLimits, Termination, minimise};
use crate::statistics::{DEVIATION_OF_MEDIAN, median_size};
use std::ops::ControlFlow;

/// Hears of every linear solve and may stop the fit.
pub(super) type Report<'a> = &'a mut dyn FnMut(&Iteration) -> ControlFlow<()>;

/// The scale of the point residuals is settled when it changes by less than this part.
const SCALE_TOLERANCE: f64 = 1e-4;

/// The same, and the part by which the cost changes in a step, for a minimum on the way to another one: far below
/// what the image adds.
const PASSING_TOLERANCE: f64 = 1e-2;
const PASSING_COST_TOLERANCE: f64 = 1e-5;

/// Most rounds of scale and minimum. The scale settles in three or four; without a limit it could alternate.
const SCALE_ROUNDS: usize = 20;

/// Solves of one fit after which a minimum gets no more than ordinary ones need. The hardest frames, whose minima are
/// flat, take half as many; without the limit a hundred guides that contradict the points would each be followed to
/// the end.
const MANY_SOLVES: usize = 2000;
const ORDINARY_SOLVES: usize = 40;

/// A residual correlation below this is taken as the end of the correlated range, and one below so many of its own
/// standard deviations, 1/√N when there is none: what chance gives few points must not count as correlation.
const UNCORRELATED: f64 = 0.1;
const UNCORRELATED_DEVIATIONS: f64 = 3.0;

/// Longest range of correlation that is looked for, in points: matching windows have up to 11 pixels. What is alike
/// farther apart is no noise but a misfit.
const LONGEST_CORRELATION: usize = 11;

impl Problem<'_> {
    /// Whether the objective is the robust one.
    pub fn is_robust(&self) -> bool {
        self.options.method == Method::Fused && self.options.objective == ObjectiveKind::Robust
    }

    /// Whether the objective is that of the paper (or its points alone).
    fn is_paper(&self) -> bool {
        self.options.method == Method::Points || self.options.objective == ObjectiveKind::Paper
    }

    /// The objective at scales that fit the residuals of `cylinder`.
    fn with_objective<T>(&self, cylinder: &Cylinder, run: impl FnOnce(&dyn Objective) -> T) -> T {
        if self.is_paper() {
            run(&self.paper_objective(cylinder))
        } else {
            run(&RobustObjective::new(
                self.points,
                self.pixels.as_ref(),
                &self.arcs,
                self.scales(cylinder),
                self.near_wall,
            ))
        }
    }

    fn paper_objective(&self, start: &Cylinder) -> PaperObjective<'_> {
        match self.limbs {
            Some(limbs) if self.edge_weight > 0.0 => {
                let distance = start.distance_of_axis_from_origin();
                PaperObjective::new(self.points, limbs, self.edge_weight, distance)
            }
            _ => PaperObjective::points_only(self.points),
        }
    }

    /// The linearisation at a cylinder in the frame of the data; `None` where the cost is infinite.
    pub fn linearise(&self, cylinder: &Cylinder) -> Option<NormalEquations> {
        let frame = LocalFrame::new(cylinder, &self.center, self.unit);
        self.with_objective(cylinder, |objective| objective.linearise(&frame))
    }

    /// Whether the edges have a finite cost at a cylinder. The points always have.
    pub fn edges_are_finite(&self, cylinder: &Cylinder) -> bool {
        let frame = LocalFrame::new(cylinder, &self.center, self.unit);
        if self.is_paper() {
            let limbs = self.limbs.filter(|_| self.edge_weight > 0.0);
            return limbs.is_none_or(|limbs| limbs.linearise(&frame).is_some());
        }
        self.pixels.as_ref().is_none_or(|pixels| pixels.linearise(&frame).is_some())
    }

    /// What the covariance of a minimum at a cylinder follows from, in the tangent of a frame there; `None` where there
    /// is none.
    pub fn sandwich(&self, cylinder: &Cylinder, frame: &LocalFrame) -> Option<Sandwich> {
        let minimises = matches!(self.options.method, Method::Fused | Method::Points);
        if self.cloud.is_empty() || !minimises {
            return None;
        }
        let scales = self.scales(cylinder);
        if self.is_paper() {
            return self.paper_objective(cylinder).sandwich(frame, scales.independent_points, scales.pixel);
        }
        RobustObjective::new(self.points, self.pixels.as_ref(), &self.arcs, scales, self.near_wall)
            .sandwich(frame)
    }

    /// The rows Ω^½ e, Ω^½ J at a cylinder in the frame of the data.
    pub fn stacked_rows(&self, cylinder: &Cylinder) -> Option<Vec<(f64, crate::geometry::Tangent)>> {
        let frame = LocalFrame::new(cylinder, &self.center, self.unit);
        self.with_objective(cylinder, |objective| objective.stacked_rows(self.cloud, &frame))
    }

    /// Iterates from a start. The near-wall rule is not applied.
    pub fn minimise(&self, start: &Cylinder, report: Report<'_>) -> Result<Convergence> {
        let most_solves = match self.options.limits.max_iterations {
            most if self.solves.get() > MANY_SOLVES => most.min(ORDINARY_SOLVES),
            most => most,
        };
        if self.is_paper() {
            let objective = self.paper_objective(start);
            let mut convergence = self.run(&objective, start, self.chart(start), most_solves, report)?;
            if convergence.termination == Termination::MaxIterations {
                // Algorithm 2 creeps where there is no minimum, too: the local chart gets to the bottom of it.
                let bottom =
                    self.run(&objective, &convergence.cylinder, Chart::Local, most_solves, report)?;
                self.check_radius(&bottom.cylinder)?;
            }
            if self.edge_weight == 1.0 {
                // Every scale costs the same: that of the start, or the nearest with a radius that is allowed.
                let Cylinder { radius, axis } = &mut convergence.cylinder;
                let drift = start.distance_of_axis_from_origin() / axis.nearest_to_origin().norm();
                let limits = &self.options.cylinder_limits;
                let scaled = (*radius * drift).clamp(limits.radius_min, limits.radius_max);
                let scale = if scaled == *radius * drift { drift } else { scaled / *radius };
                axis.point *= scale;
                *radius = scaled;
            }
            return Ok(convergence);
        }
        let mut cylinder = *start;
        let mut scales = self.scales(&cylinder);
        let mut total: Option<Convergence> = None;
        let tolerance = if self.passing { PASSING_TOLERANCE } else { SCALE_TOLERANCE };
        for _ in 0..SCALE_ROUNDS {
            let objective =
                RobustObjective::new(self.points, self.pixels.as_ref(), &self.arcs, scales, self.near_wall);
            // The rounds share the solves: where the scale alternates each could take all of them.
            let left = most_solves - total.as_ref().map_or(0, |before| before.iterations);
            let mut round = self.run(&objective, &cylinder, self.chart(&cylinder), left, &mut *report)?;
            if let Some(before) = &total {
                round.add_work_of(before);
            }
            cylinder = round.cylinder;
            let ended = matches!(round.termination, Termination::RadiusRanAway | Termination::MaxIterations);
            total = Some(round);
            let next = self.scales(&cylinder);
            let settled = (next.point - scales.point).abs() <= tolerance * scales.point;
            scales = next;
            if settled || ended {
                break;
            }
        }
        total.ok_or(Error::Numerical { what: "no round of the robust fit was run" })
    }

    /// Iterates on from a minimum, after something was added to the problem.
    pub fn minimise_again(&self, before: &Convergence, report: Report<'_>) -> Result<Convergence> {
        let mut after = self.minimise(&before.cylinder, report)?;
        self.check_radius(&after.cylinder)?;
        after.add_work_of(before);
        Ok(after)
    }

    fn chart(&self, start: &Cylinder) -> Chart {
        match self.options.chart {
            _ if !self.options.cylinder_limits.is_none() => Chart::Local,
            ChartChoice::Local => Chart::Local,
            ChartChoice::Orthonormal => Chart::Orthonormal,
            ChartChoice::Auto if self.is_paper() && self.camera.is_some() && !start.contains_origin() => {
                Chart::Orthonormal
            }
            ChartChoice::Auto => Chart::Local,
        }
    }

    fn run(
        &self,
        objective: &impl Objective,
        start: &Cylinder,
        chart: Chart,
        most_solves: usize,
        report: Report<'_>,
    ) -> Result<Convergence> {
        let mut limits = IterationLimits { max_iterations: most_solves, ..self.options.limits };
        if self.passing {
            limits.cost_tolerance = limits.cost_tolerance.max(PASSING_COST_TOLERANCE);
        }
        let kept = &self.limits_of_iteration();
        let domain = Domain { data_center: self.center, unit: self.unit, chart, limits: kept };
        let convergence = minimise(objective, &kept.nearest(start, &self.center), &domain, &limits, report)?;
        self.solves.set(self.solves.get() + convergence.iterations);
        Ok(convergence)
    }

    /// Scale of the point residuals of a cylinder.
    pub fn point_scale(&self, cylinder: &Cylinder) -> f64 {
        self.scales(cylinder).point
    }

    /// Scale of the point residuals by their median absolute deviation, and the number of independent points
    /// by their correlation along the order in which they were pushed: neighbours in a row of a depth image
    /// share matching windows and interpolation. In a cloud without order the correlation vanishes.
    fn scales(&self, cylinder: &Cylinder) -> RobustScales {
        // The end of one minimisation is the start of the next.
        if let Some((last, scales)) = self.last_scales.get()
            && last == *cylinder
        {
            return scales;
        }
        let scales = self.new_scales(cylinder);
        self.last_scales.set(Some((*cylinder, scales)));
        scales
    }

    fn new_scales(&self, cylinder: &Cylinder) -> RobustScales {
        let residuals = self.points.distances(&LocalFrame::new(cylinder, &self.center, 1.0));
        // Exact data have no scale: what rounding leaves keeps the loss away from 0 / 0.
        let floor = 64.0 * f64::EPSILON * self.center.amax().max(self.unit);
        let point = (DEVIATION_OF_MEDIAN * median_size(residuals.iter().copied())).max(floor);
        let range = correlated_range(&residuals, TUKEY_EFFICIENT * point);
        // A row of the image repeats the correlation of a column.
        let independent_points = (residuals.len() as f64 / (range * range)).max(1.0);
        RobustScales { point, independent_points, pixel: self.noise.endpoint }
    }
}

/// How many neighbours in the sequence count as one, 1 + 2 Σ ρ_k over the correlated range; residuals beyond
/// the cutoff are left out.
fn correlated_range(residuals: &[f64], cutoff: f64) -> f64 {
    let clipped = |e: &f64| if e.abs() <= cutoff { *e } else { 0.0 };
    let values: Vec<f64> = residuals.iter().map(clipped).collect();
    let variance = dot(&values, &values);
    if variance == 0.0 {
        return 1.0;
    }
    let limit = UNCORRELATED.max(UNCORRELATED_DEVIATIONS / (values.len() as f64).sqrt());
    let mut range = 1.0;
    for lag in 1..=LONGEST_CORRELATION.min(values.len() / 4) {
        let correlation = dot(&values, &values[lag..]) / variance;
        if correlation < limit {
            break;
        }
        range += 2.0 * correlation;
    }
    range
}

/// The sum of the products of two sequences as far as both go, in partial sums side by side, so that one addition need
/// not wait for another.
fn dot(first: &[f64], second: &[f64]) -> f64 {
    const LANES: usize = 8;
    let count = first.len().min(second.len());
    let ((first, first_rest), (second, second_rest)) =
        (first[..count].as_chunks::<LANES>(), second[..count].as_chunks::<LANES>());
    let mut lanes = [0.0; LANES];
    for (a, b) in first.iter().zip(second) {
        for (lane, (a, b)) in lanes.iter_mut().zip(a.iter().zip(b)) {
            *lane += a * b;
        }
    }
    let rest = first_rest.iter().zip(second_rest).map(|(a, b)| a * b);
    lanes.into_iter().chain(rest).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Evenly distributed numbers without correlation, the same at every run.
    fn noise(count: usize, seed: u64) -> Vec<f64> {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        (0..count).map(|_| next()).collect()
    }

    #[test]
    fn independent_noise_has_the_range_one_for_any_number_of_points() {
        for count in [50, 500, 5000] {
            let mean =
                (0..400).map(|seed| correlated_range(&noise(count, seed), 1.0).powi(2)).sum::<f64>() / 400.0;
            assert!((1.0..1.01).contains(&mean), "{count}: {mean}");
        }
    }

    #[test]
    fn the_range_is_that_of_a_moving_average() {
        // The mean of 5 neighbours has the correlation 1 − k / 5, so that 1 + 2 Σ ρ is 5.
        let raw = noise(20_000, 1);
        let smooth: Vec<f64> = raw.windows(5).map(|five| five.iter().sum()).collect();
        assert!((correlated_range(&smooth, 10.0) - 5.0).abs() < 0.2);
    }
}
