//! From a start to the minimum of the chosen objective.

use super::correlation::Lattice;
use super::data::{Data, ViewData};
use super::held::Held;
use super::options::ChartChoice;
use crate::error::{Error, Result};
use crate::geometry::{Chart, Cylinder, LocalFrame};
use crate::residuals::{
    NormalEquations, Objective, RobustScales, RobustView, Sandwich, Sum, TUKEY_EFFICIENT, paper_objective,
    robust_objective,
};
use crate::solver::{Convergence, Domain, Iteration, IterationLimits, Termination, minimise};
use crate::statistics::{DEVIATION_OF_MEDIAN, median_size};
use std::ops::ControlFlow;

/// The scale of the point residuals is settled when it changes by less than this part.
const SCALE_TOLERANCE: f64 = 1e-4;

/// The same, and the part by which the cost changes in a step, for a minimum on the way to another one: far below
/// what the image adds.
const ROUGH_TOLERANCE: f64 = 1e-2;
const ROUGH_COST_TOLERANCE: f64 = 1e-5;

/// Most rounds of scale and minimum. The scale settles in three or four; without a limit it could alternate.
const SCALE_ROUNDS: usize = 20;

/// Solves of one fit after which a minimum gets no more than ordinary ones need. The hardest frames, whose minima are
/// flat, take half as many; without the limit a hundred guides that contradict the points would each be followed to
/// the end.
const MANY_SOLVES: usize = 2000;
const ORDINARY_SOLVES: usize = 40;

/// How exactly a minimum is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Precision {
    /// On the way: what is located in the image from there moves it again.
    Rough,
    /// To the tolerances of the options.
    Full,
}

/// A fit under way: who hears of every linear solve and may stop it, and how many there were.
pub(super) struct Run<'a> {
    pub report: &'a mut dyn FnMut(&Iteration) -> ControlFlow<()>,
    pub solves: usize,
}

impl Run<'_> {
    /// Asks whether to go on while there is no iteration to report.
    pub fn poll(&mut self) -> ControlFlow<()> {
        (self.report)(&Iteration::before_start())
    }
}

/// A minimum.
#[derive(Clone, Copy)]
pub(super) struct Minimum {
    pub convergence: Convergence,
    /// Scale of the point residuals, of all views together.
    pub scale: f64,
}

impl Minimum {
    pub fn cylinder(&self) -> &Cylinder {
        &self.convergence.cylinder
    }
}

/// The scales of the point residuals.
struct Scales {
    views: Vec<RobustScales>,
    /// Of all views together.
    all: f64,
}

impl Data<'_> {
    /// Iterates from a start. The near-wall rule is not applied.
    pub fn minimise(
        &self,
        held: &Held,
        start: &Cylinder,
        precision: Precision,
        run: &mut Run<'_>,
    ) -> Result<Minimum> {
        if self.is_paper() {
            self.minimise_paper(held, start, run)
        } else {
            self.minimise_robust(held, start, precision, run)
        }
    }

    /// Iterates on from a minimum, with something else to hold to.
    pub fn minimise_again(
        &self,
        held: &Held,
        before: &Minimum,
        precision: Precision,
        run: &mut Run<'_>,
    ) -> Result<Minimum> {
        let mut after = self.minimise(held, before.cylinder(), precision, run)?;
        self.check_radius(after.cylinder())?;
        after.convergence.add_work_of(&before.convergence);
        Ok(after)
    }

    fn minimise_paper(&self, held: &Held, start: &Cylinder, run: &mut Run<'_>) -> Result<Minimum> {
        let objective = self.paper_objective(held, start);
        let mut convergence = self.iterate(&objective, start, Precision::Full, usize::MAX, run)?;
        if convergence.termination == Termination::MaxIterations {
            // Algorithm 2 creeps where there is no minimum, too: the local chart gets to the bottom of it.
            let bottom = self.iterate_in(
                Chart::Local,
                &objective,
                &convergence.cylinder,
                Precision::Full,
                usize::MAX,
                run,
            )?;
            self.check_radius(&bottom.cylinder)?;
        }
        if held.edge_weight == 1.0 {
            // Every scale costs the same: that of the start, or the nearest with a radius that is allowed.
            let Cylinder { radius, axis } = &mut convergence.cylinder;
            let drift = start.distance_of_axis_from_origin() / axis.nearest_to_origin().norm();
            let limits = &self.options.cylinder_limits;
            let scaled = (*radius * drift).clamp(limits.radius_min, limits.radius_max);
            let scale = if scaled == *radius * drift { drift } else { scaled / *radius };
            axis.point *= scale;
            *radius = scaled;
        }
        let scale = self.point_scale(&convergence.cylinder);
        Ok(Minimum { convergence, scale })
    }

    /// Alternates between the minimum at fixed scales and the scales of its residuals.
    fn minimise_robust(
        &self,
        held: &Held,
        start: &Cylinder,
        precision: Precision,
        run: &mut Run<'_>,
    ) -> Result<Minimum> {
        let tolerance = match precision {
            Precision::Rough => ROUGH_TOLERANCE,
            Precision::Full => SCALE_TOLERANCE,
        };
        let (mut cylinder, mut scales) = (*start, self.scales(start));
        let mut total: Option<Convergence> = None;
        for _ in 0..SCALE_ROUNDS {
            let objective = self.robust_objective(held, &scales.views);
            // The rounds share the solves: where the scale alternates each could take all of them.
            let before = total.as_ref().map_or(0, |before| before.iterations);
            let mut round = self.iterate(&objective, &cylinder, precision, before, run)?;
            if let Some(before) = &total {
                round.add_work_of(before);
            }
            cylinder = round.cylinder;
            let ended = matches!(round.termination, Termination::RadiusRanAway | Termination::MaxIterations);
            total = Some(round);
            let next = self.scales(&cylinder);
            let changes = next.views.iter().zip(&scales.views);
            let settled = changes
                .map(|(next, before)| (next.point - before.point).abs() <= tolerance * before.point)
                .all(|settled| settled);
            scales = next;
            if settled || ended {
                break;
            }
        }
        let convergence = total.ok_or(Error::Numerical { what: "no round of the robust fit was run" })?;
        Ok(Minimum { convergence, scale: scales.all })
    }

    fn paper_objective(&self, held: &Held, start: &Cylinder) -> Sum<'_> {
        let points: Vec<_> = self
            .views
            .iter()
            .filter(|view| view.points.count() > 0)
            .map(|view| (view.points, view.into_view, self.view_scales(view, start).independent_points))
            .collect();
        let limbs: Vec<_> = self
            .views
            .iter()
            .zip(held.limb_terms(self))
            .filter_map(|(view, term)| {
                let held_at = |distance| term.map(|term| term.held_at(distance));
                let term = match held.edge_weight == 1.0 {
                    true => held_at(view.seen(start).distance_of_axis_from_origin()),
                    false => term,
                };
                Some((term?, view.into_view))
            })
            .collect();
        paper_objective(&points, &limbs, held.edge_weight)
    }

    fn robust_objective<'a>(&'a self, held: &'a Held, scales: &[RobustScales]) -> Sum<'a> {
        let views: Vec<RobustView<'a>> = self
            .views
            .iter()
            .zip(&held.views)
            .zip(scales)
            .map(|((view, held), scales)| RobustView {
                into_view: view.into_view,
                points: view.points,
                observed: view.observed,
                scales: *scales,
                lines: held.lines.as_ref(),
                arcs: &held.arcs,
                endpoint: view.noise.endpoint,
            })
            .collect();
        robust_objective(&views)
    }

    /// The objective at scales that fit the residuals of a cylinder.
    fn objective<'a>(&'a self, held: &'a Held, cylinder: &Cylinder) -> Sum<'a> {
        match self.is_paper() {
            true => self.paper_objective(held, cylinder),
            false => self.robust_objective(held, &self.scales(cylinder).views),
        }
    }

    /// The linearisation at a cylinder in the frame of the data; `None` where the cost is infinite.
    pub fn linearise(&self, held: &Held, cylinder: &Cylinder) -> Option<NormalEquations> {
        self.objective(held, cylinder).linearise(&self.frame(cylinder))
    }

    /// The rows Ω^½ e, Ω^½ J at a cylinder in the frame of the data.
    pub fn rows(&self, held: &Held, cylinder: &Cylinder) -> Option<Vec<(f64, crate::geometry::Tangent)>> {
        self.objective(held, cylinder).rows(&self.frame(cylinder))
    }

    /// What the covariance of a minimum at a cylinder follows from, in the tangent of a frame there; `None` where there
    /// is none.
    pub fn sandwich(&self, held: &Held, cylinder: &Cylinder, frame: &LocalFrame) -> Option<Sandwich> {
        if self.count() == 0 || !self.options.method.minimises() {
            return None;
        }
        self.objective(held, cylinder).sandwich(frame)
    }

    /// Whether the edges have a finite cost at a cylinder. The points always have.
    pub fn edges_are_finite(&self, held: &Held, cylinder: &Cylinder) -> bool {
        let frame = self.frame(cylinder);
        let finite = |sum: Sum<'_>| {
            let image = sum
                .summands
                .iter()
                .filter(|summand| summand.term.source() == crate::residuals::Source::Image);
            image
                .map(|summand| summand.term.cost(&frame.moved(&summand.into_view)))
                .all(|cost| cost.is_some())
        };
        finite(self.objective(held, cylinder))
    }

    fn iterate(
        &self,
        objective: &Sum<'_>,
        start: &Cylinder,
        precision: Precision,
        solves_before: usize,
        run: &mut Run<'_>,
    ) -> Result<Convergence> {
        let solves_before = if solves_before == usize::MAX { 0 } else { solves_before };
        self.iterate_in(self.chart(start), objective, start, precision, solves_before, run)
    }

    fn iterate_in(
        &self,
        chart: Chart,
        objective: &Sum<'_>,
        start: &Cylinder,
        precision: Precision,
        solves_before: usize,
        run: &mut Run<'_>,
    ) -> Result<Convergence> {
        let most = match self.options.limits.max_iterations {
            most if run.solves > MANY_SOLVES => most.min(ORDINARY_SOLVES),
            most => most,
        };
        let max_iterations = most.saturating_sub(solves_before);
        let mut limits = IterationLimits { max_iterations, ..self.options.limits };
        if precision == Precision::Rough {
            limits.cost_tolerance = limits.cost_tolerance.max(ROUGH_COST_TOLERANCE);
        }
        let kept = &self.limits_of_iteration();
        let domain = Domain { data_center: self.center, unit: self.unit, chart, limits: kept };
        let convergence = minimise(objective, &self.within_limits(start), &domain, &limits, run.report)?;
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

    /// Scale of the point residuals of a cylinder.
    pub fn point_scale(&self, cylinder: &Cylinder) -> f64 {
        let distances = self.views.iter().flat_map(|view| view.distances(cylinder, &self.center));
        self.scale_of(distances)
    }

    /// By the median absolute deviation. Exact data have no scale: what rounding leaves keeps the loss away from 0 / 0.
    fn scale_of(&self, residuals: impl Iterator<Item = f64>) -> f64 {
        let floor = 64.0 * f64::EPSILON * self.center.amax().max(self.unit);
        (DEVIATION_OF_MEDIAN * median_size(residuals)).max(floor)
    }

    fn scales(&self, cylinder: &Cylinder) -> Scales {
        let views: Vec<RobustScales> =
            self.views.iter().map(|view| self.view_scales(view, cylinder)).collect();
        let all = match views[..] {
            [one] => one.point,
            _ => self.point_scale(cylinder),
        };
        Scales { views, all }
    }

    /// Scale and number of independent points of one view, unless the caller told them.
    pub fn view_scales(&self, view: &ViewData<'_>, cylinder: &Cylinder) -> RobustScales {
        let residuals = view.distances(cylinder, &self.center);
        let noise = &self.options.noise;
        let point = if noise.depth > 0.0 { noise.depth } else { self.scale_of(residuals.iter().copied()) };
        let count = residuals.len() as f64;
        let cutoff = TUKEY_EFFICIENT * point;
        let independent_points = match (self.options.independent_points, &view.lattice) {
            (told, _) if told > 0.0 => told.min(count),
            _ if residuals.is_empty() => 1.0,
            (_, Some(lattice)) => lattice.independent_points(&residuals, cutoff),
            (_, None) => {
                let frame = self.frame(cylinder).moved(&view.into_view);
                let lattice = Lattice::on_surface(&view.view.cloud, &frame);
                lattice.map_or(count, |lattice| lattice.independent_points(&residuals, cutoff))
            }
        };
        RobustScales { point, independent_points: independent_points.max(1.0) }
    }
}
