//! From a start to the minimum of the chosen objective.

use super::constraints::{Constraints, ViewConstraints};
use super::data::{Data, ViewData};
use super::options::ChartChoice;
use super::run::Run;
use super::scales::Scales;
use crate::error::{Error, Result};
use crate::geometry::{Chart, Cylinder, LocalFrame, Tangent};
use crate::memory::{ByView, List};
use crate::residuals::{
    Bend, Known, PixelResiduals, RobustScales, RobustView, SharedErrors, Sum, Term, paper_objective,
    robust_objective,
};
use crate::solver::{Convergence, Domain, IterationLimits, Termination, minimise};
use std::cell::Cell;

/// The scale of the point residuals is settled when it changes by less than this part.
const SCALE_TOLERANCE: f64 = 1e-4;

/// The same, and the part by which the cost changes in a step, for a minimum on the way to another one: far below
/// what the image adds.
const ROUGH_TOLERANCE: f64 = 1e-2;
const ROUGH_COST_TOLERANCE: f64 = 1e-5;

/// The part by which the cost changes in a step that is taken without a look from next to a minimum, where others follow with
/// scales that are nearer: some times what a part of very many points leaves, and far below what makes a step uncertain.
const NEAR_COST_TOLERANCE: f64 = 1e-3;

/// Damping of the first step from next to a minimum that is wanted in full: far below the curvature along what the data
/// tell least, so that it shortens no step. With the damping of a start an iteration creeps until that has fallen. On the
/// way to a minimum that is as well: along what nothing tells yet the cylinder should stay.
const LAMBDA_NEAR_MINIMUM: f64 = 1e-9;

/// Most rounds of scale and minimum. The scale settles in three or four; without a limit it could alternate.
const SCALE_ROUNDS: usize = 20;

/// Most of what points share, in units of their noise: exact data share nothing, and depth that a filter has smoothed
/// three times its noise.
const MOST_SHARED: f64 = 10.0;

/// How exactly a minimum is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Precision {
    /// On the way: what is located in the image from there moves it again.
    Rough,
    /// By one step, from next to it.
    Near,
    /// To the tolerances of the options.
    Full,
}

/// What an objective is for.
#[derive(Clone, Copy)]
enum Purpose<'a> {
    /// Errors that points share count where lines contest what the points say. What one objective finds out about them the
    /// next one knows, by view.
    Minimum(&'a [Cell<Option<Bend>>]),
    /// They always count.
    Covariance,
}

/// A minimum.
#[derive(Clone)]
pub(super) struct Minimum {
    pub convergence: Convergence,
    /// The scales of the point residuals there; unknown for the paper's objective.
    pub scales: Scales,
}

impl Minimum {
    pub fn cylinder(&self) -> &Cylinder {
        &self.convergence.cylinder
    }

    /// Scale of the point residuals of all views together.
    pub fn scale(&self) -> f64 {
        self.scales.all
    }
}

impl Precision {
    /// The part by which a settled scale may still change.
    fn scale_tolerance(self) -> f64 {
        match self {
            Precision::Rough => ROUGH_TOLERANCE,
            Precision::Near | Precision::Full => SCALE_TOLERANCE,
        }
    }
}

impl Data<'_> {
    /// Iterates from a start. The near-wall rule is not applied.
    pub fn minimise(
        &self,
        constraints: &Constraints,
        start: &Cylinder,
        precision: Precision,
        run: &mut Run<'_>,
    ) -> Result<Minimum> {
        match self.is_paper() {
            true => self.minimise_paper(constraints, start, run),
            false => self.minimise_robust(
                constraints,
                start,
                self.scales(start),
                [Precision::Rough, precision],
                run,
            ),
        }
    }

    /// Iterates on from a minimum, with something else to hold to.
    pub fn minimise_again(
        &self,
        constraints: &Constraints,
        before: &Minimum,
        precision: Precision,
        run: &mut Run<'_>,
    ) -> Result<Minimum> {
        let mut after =
            self.minimise_near(constraints, before.cylinder(), before.scales.clone(), precision, run)?;
        after.convergence.add_work_of(&before.convergence);
        Ok(after)
    }

    /// Ends, with all points, what a part of them has begun.
    pub fn minimise_with_all(
        &self,
        constraints: &Constraints,
        of_subsample: &Minimum,
        run: &mut Run<'_>,
    ) -> Result<Minimum> {
        let scales = self.scales_near(of_subsample.cylinder(), Some(&of_subsample.scales));
        let precisions = [Precision::Near, Precision::Full];
        let mut minimum =
            self.minimise_robust(constraints, of_subsample.cylinder(), scales, precisions, run)?;
        self.check_radius(minimum.cylinder())?;
        minimum.convergence.add_work_of(&of_subsample.convergence);
        Ok(minimum)
    }

    /// Iterates with the robust objective from a cylinder whose scales are about known.
    pub fn minimise_near(
        &self,
        constraints: &Constraints,
        start: &Cylinder,
        scales: Scales,
        precision: Precision,
        run: &mut Run<'_>,
    ) -> Result<Minimum> {
        let minimum = self.minimise_robust(constraints, start, scales, [Precision::Rough, precision], run)?;
        self.check_radius(minimum.cylinder())?;
        Ok(minimum)
    }

    #[inline(never)] // Not inlined: its locals would enlarge the caller's stack frame.
    fn minimise_paper(
        &self,
        constraints: &Constraints,
        start: &Cylinder,
        run: &mut Run<'_>,
    ) -> Result<Minimum> {
        // The numbers of independent points matter for the covariance only.
        let objective = self.paper_objective(constraints, start, None);
        let limits = self.limits([Precision::Full; 2], None, run);
        let mut convergence = self.iterate(self.chart(start), &objective, start, &limits, run)?;
        if convergence.termination == Termination::MaxIterations {
            // Algorithm 2 creeps where there is no minimum, too: the local chart gets to the bottom of it.
            let limits = self.limits([Precision::Full; 2], None, run);
            let bottom = self.iterate(Chart::Local, &objective, &convergence.cylinder, &limits, run)?;
            self.check_radius(&bottom.cylinder)?;
        }
        if constraints.edge_weight == 1.0 {
            // Every scale costs the same: that of the start, or the nearest with a radius that is allowed.
            let Cylinder { radius, axis } = &mut convergence.cylinder;
            let drift = start.distance_of_axis_from_origin() / axis.nearest_to_origin().norm();
            let limits = &self.options.cylinder_limits;
            let scaled = (*radius * drift).clamp(limits.radius_min, limits.radius_max);
            let scale = if scaled == *radius * drift { drift } else { scaled / *radius };
            axis.point *= scale;
            *radius = scaled;
        }
        // They weigh nothing here: the description measures them once.
        Ok(Minimum { convergence, scales: Scales { views: List::new(), all: f64::NAN } })
    }

    /// Alternates between the minimum at fixed scales and the scales of its residuals. While the scales still change the
    /// first precision is enough.
    fn minimise_robust(
        &self,
        constraints: &Constraints,
        start: &Cylinder,
        mut scales: Scales,
        [first, precision]: [Precision; 2],
        run: &mut Run<'_>,
    ) -> Result<Minimum> {
        let mut cylinder = *start;
        let mut total: Option<Convergence> = None;
        let mut current = first;
        let mut counted = None;
        let memory = List::filled(Cell::new(None), self.views.len());
        for _ in 0..SCALE_ROUNDS {
            let objective =
                self.robust_objective(constraints, &cylinder, &scales.views, Purpose::Minimum(&memory));
            let limits = self.limits([current, precision], total.as_ref(), run);
            let mut round = self.iterate(self.chart(&cylinder), &objective, &cylinder, &limits, run)?;
            if let Some(before) = &total {
                round.add_work_of(before);
            }
            cylinder = round.cylinder;
            let ended = matches!(round.termination, Termination::RadiusRanAway | Termination::MaxIterations);
            total = Some(round);
            let residuals = self.residuals(&cylinder, Some(&scales));
            let next = residuals.scales_with_counts_of(&scales);
            let settled = next.differ_by_less_than(precision.scale_tolerance(), &scales);
            scales = next;
            if ended || settled && current == precision {
                // The correlation changes far less than the scale: it is looked at where that has settled.
                let all = self.scales_of(&cylinder, &residuals);
                let same = all.same_information(&scales);
                scales = all.clone();
                counted = Some(all);
                if ended || same {
                    break;
                }
            } else if settled {
                current = precision;
            }
        }
        let convergence = total.ok_or(Error::Numerical { what: "no round of the robust fit was run" })?;
        let scales = counted.unwrap_or_else(|| self.scales(&cylinder));
        Ok(Minimum { convergence, scales })
    }

    #[inline(never)] // Not inlined: its locals would enlarge the caller's stack frame.
    fn paper_objective(
        &self,
        constraints: &Constraints,
        start: &Cylinder,
        scales: Option<&Scales>,
    ) -> Sum<'_> {
        let independent = |k: usize| scales.map_or(1.0, |scales| scales.views[k].independent_points);
        let points: ByView<_> = (self.views.iter().enumerate())
            .filter(|(_, view)| view.points.count() > 0)
            .map(|(k, view)| (view.points, view.into_view, independent(k)))
            .collect();
        let limbs: ByView<_> = self
            .views
            .iter()
            .zip(constraints.limb_terms(self))
            .filter_map(|(view, term)| {
                let held_at = |distance| term.map(|term| term.held_at(distance));
                let term = match constraints.edge_weight == 1.0 {
                    true => held_at(view.seen(start).distance_of_axis_from_origin()),
                    false => term,
                };
                Some((term?, view.into_view))
            })
            .collect();
        paper_objective(&points, &limbs, constraints.edge_weight)
    }

    #[inline(never)] // Not inlined: its locals would enlarge the caller's stack frame.
    fn robust_objective<'a>(
        &'a self,
        constraints: &'a Constraints,
        cylinder: &Cylinder,
        scales: &[RobustScales],
        purpose: Purpose<'a>,
    ) -> Sum<'a> {
        let contested = constraints.settled && constraints.has_lines();
        let shared_matter = contested || matches!(purpose, Purpose::Covariance);
        let frame = self.frame(cylinder);
        let views: ByView<RobustView<'a>> = self
            .views
            .iter()
            .zip(&constraints.views)
            .zip(scales)
            .enumerate()
            .map(|(k, ((view, constraints), scales))| {
                let near = frame.moved(&view.into_view);
                let shared =
                    shared_matter.then(|| self.shared_errors(view, constraints, &near, scales)).flatten();
                RobustView {
                    into_view: view.into_view,
                    points: view.points,
                    observed: view.observed,
                    shared,
                    known: match purpose {
                        Purpose::Minimum(memory) => Known::Iteration(&memory[k]),
                        Purpose::Covariance => Known::Nothing,
                    },
                    near,
                    scales: *scales,
                    lines: constraints.lines.as_ref(),
                    arcs: &constraints.arcs,
                    endpoint: view.noise.endpoint,
                }
            })
            .collect();
        robust_objective(&views, contested)
    }

    /// The errors that the points of a view share; `None` where they are not what an observer outside sees.
    pub fn shared_errors(
        &self,
        view: &ViewData<'_>,
        constraints: &ViewConstraints,
        near: &LocalFrame,
        scales: &RobustScales,
    ) -> Option<SharedErrors> {
        if !view.observed || near.cylinder.contains_origin() {
            return None;
        }
        // Lines that contest them raise the scale.
        let scale = constraints.point_scale.map_or(scales.point, |alone| alone.min(scales.point));
        let size = self.shared_size(view, scale).filter(|&size| size > 0.0)?;
        let distance = view.into_view.point(&self.center).norm();
        Some(SharedErrors::of_offset(size, distance, self.unit))
    }

    /// The standard deviation of an offset that all points of a view share, whose noise is `scale`.
    fn shared_size(&self, view: &ViewData<'_>, scale: f64) -> Option<f64> {
        let distance = view.into_view.point(&self.center).norm();
        let size = (self.options.noise.depth_shared * distance).min(MOST_SHARED * scale);
        view.observed.then_some(size)
    }

    /// The largest standard deviation of a bend that the points of a view share.
    pub fn largest_bend(&self, minimum: &Minimum) -> f64 {
        let of_view = |(view, scales): (&ViewData<'_>, &RobustScales)| self.shared_size(view, scales.point);
        self.views.iter().zip(&minimum.scales.views).filter_map(of_view).fold(0.0, f64::max)
    }

    /// The objective at a cylinder and its scales, with all that its covariance takes.
    pub fn objective<'a>(
        &'a self,
        constraints: &'a Constraints,
        cylinder: &Cylinder,
        scales: &Scales,
    ) -> Sum<'a> {
        match self.is_paper() {
            true => self.paper_objective(constraints, cylinder, Some(scales)),
            false => self.robust_objective(constraints, cylinder, &scales.views, Purpose::Covariance),
        }
    }

    /// The rows Ω^½ e, Ω^½ J at a cylinder in the frame of the data.
    pub fn rows(&self, constraints: &Constraints, cylinder: &Cylinder) -> Option<Vec<(f64, Tangent)>> {
        self.objective(constraints, cylinder, &self.scales(cylinder)).rows(&self.frame(cylinder))
    }

    /// Whether the edges have a finite cost at a cylinder. The points always have.
    pub fn edges_are_finite(&self, constraints: &Constraints, cylinder: &Cylinder) -> bool {
        let frame = self.frame(cylinder);
        let limbs = constraints.limb_terms(self);
        (self.views.iter().zip(&constraints.views).zip(limbs)).all(|((view, constraints), limbs)| {
            let frame = frame.moved(&view.into_view);
            match (self.is_paper(), limbs, &constraints.lines) {
                (true, Some(limbs), _) => limbs.cost(&frame).is_some(),
                (false, _, Some(lines)) => lines.pixel_rows(&frame).is_some(),
                _ => true,
            }
        })
    }

    /// The limits of a round of some precision after others, on the way to a minimum of another.
    fn limits(
        &self,
        [current, wanted]: [Precision; 2],
        before: Option<&Convergence>,
        run: &Run<'_>,
    ) -> IterationLimits {
        let mut limits = self.options.limits;
        // The rounds share the solves: where the scale alternates each could take all of them.
        let solves = before.map_or(0, |before| before.iterations);
        limits.max_iterations = run.most_solves(self, current).saturating_sub(solves);
        let least = match current {
            Precision::Rough => ROUGH_COST_TOLERANCE,
            Precision::Near => NEAR_COST_TOLERANCE,
            Precision::Full => 0.0,
        };
        limits.cost_tolerance = limits.cost_tolerance.max(least);
        if wanted == Precision::Full && self.is_robust() {
            limits.initial_lambda = before.map_or(LAMBDA_NEAR_MINIMUM, |before| before.lambda);
        }
        limits
    }

    fn iterate(
        &self,
        chart: Chart,
        objective: &Sum<'_>,
        start: &Cylinder,
        limits: &IterationLimits,
        run: &mut Run<'_>,
    ) -> Result<Convergence> {
        let kept = &self.limits_of_iteration();
        let domain = Domain { data_center: self.center, unit: self.unit, chart, limits: kept };
        let convergence =
            minimise(objective, &self.within_limits(start), &domain, limits, &mut |iteration| {
                run.report(iteration)
            })?;
        run.solves += convergence.iterations;
        Ok(convergence)
    }

    fn chart(&self, start: &Cylinder) -> Chart {
        let seen = self.views.iter().any(|view| view.camera().is_some());
        match self.options.chart {
            _ if !self.options.cylinder_limits.is_none() => Chart::Local,
            ChartChoice::Local => Chart::Local,
            ChartChoice::Orthonormal => Chart::Orthonormal,
            ChartChoice::Auto if self.is_paper() && seen && !start.contains_origin() => Chart::Orthonormal,
            ChartChoice::Auto => Chart::Local,
        }
    }
}
