//! Algorithm 2 of the paper: Levenberg–Marquardt on the five degrees of freedom (26)–(29).

use crate::error::{Error, Result};
use crate::geometry::{Chart, Cylinder, CylinderLimits, LocalFrame, Tangent, TangentMap};
use crate::residuals::{NormalEquations, Objective};
use nalgebra::Vector3;
use std::ops::ControlFlow;

/// The constants of the iteration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IterationLimits {
    /// Most linear solves.
    pub max_iterations: usize,
    /// Damping λ₀ of the first step.
    pub initial_lambda: f64,
    /// Factor ν by which the damping falls after an accepted step and grows after a rejected one.
    pub lambda_factor: f64,
    /// Damping at which no smaller step is tried any more.
    pub max_lambda: f64,
    /// Smallest relative decrease of the cost that counts as progress.
    pub cost_tolerance: f64,
    /// The gradient JᵀΩe counts as 0 where it is at most this part of ‖Ω^½ J‖ ‖Ω^½ e‖: the cosine of the angle between
    /// the residuals and what a step can change of them. The default is the rounding of that cosine.
    pub gradient_tolerance: f64,
    /// A step that moves the surface where the data are by at most this part of their largest coordinate (and of their
    /// size) is the last. The default is what the numbers of the result resolve: a smaller step leaves their bits.
    pub step_tolerance: f64,
}

impl Default for IterationLimits {
    fn default() -> Self {
        Self {
            max_iterations: 400,
            initial_lambda: 1e-3,
            lambda_factor: 10.0,
            max_lambda: 1e12,
            cost_tolerance: 1e-12,
            gradient_tolerance: f64::EPSILON,
            step_tolerance: f64::EPSILON,
        }
    }
}

/// Why an iteration ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Termination {
    /// The cost no longer falls by more than the tolerance, as the last step showed or the linearisation predicts, or
    /// it reached the rounding error of the data.
    Cost,
    /// The gradient fell below its tolerance.
    Gradient,
    /// The step fell below its tolerance.
    Step,
    /// No step down to the largest damping lowered the cost: a minimum to rounding.
    Stalled,
    /// The limit of iterations was reached.
    MaxIterations,
    /// The radius left all proportion to the data: they are flat.
    RadiusRanAway,
}

/// One linear solve, for progress reports.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Iteration {
    /// Solves so far.
    pub iteration: usize,
    /// The lowest cost so far, in the caller's unit squared.
    pub cost: f64,
    /// The damping of the next step.
    pub lambda: f64,
    /// The best cylinder so far; what a fit reports has the largest component of its direction positive.
    pub cylinder: Cylinder,
}

impl Iteration {
    /// What is known before the first solve: nothing.
    #[must_use]
    pub fn before_start() -> Self {
        let axis = crate::geometry::Line { point: Vector3::zeros(), direction: Vector3::z() };
        Self { iteration: 0, cost: f64::INFINITY, lambda: 0.0, cylinder: Cylinder { axis, radius: 0.0 } }
    }
}

/// Where an iteration ended.
#[derive(Debug, Clone, Copy)]
pub struct Convergence {
    /// The minimum.
    pub cylinder: Cylinder,
    /// Its cost, in the caller's unit squared.
    pub cost: f64,
    /// The cost of the start.
    pub initial_cost: f64,
    /// Linear solves.
    pub iterations: usize,
    /// Solves whose step was rejected.
    pub rejected_steps: usize,
    /// Why it ended.
    pub termination: Termination,
    /// The last damping.
    pub lambda: f64,
    /// Norm of the last accepted step, in units of the frame.
    pub step_norm: f64,
}

impl Convergence {
    /// Counts the work of an iteration that this one went on from, and takes its start as the common one.
    pub fn add_work_of(&mut self, before: &Self) {
        self.iterations += before.iterations;
        self.rejected_steps += before.rejected_steps;
        self.initial_cost = before.initial_cost;
    }
}

/// Solves after which JᵀΩJ is replaced by the whole second derivative of the cost. Ordinary frames need a dozen;
/// where residuals are large and the minimum is flat the omitted part of the second derivative rules, and the
/// iteration of the paper creeps for thousands of steps.
const GAUSS_NEWTON_ITERATIONS: usize = 40;

/// Step of the differences of gradients for the second derivative, in units of the frame: some times the root of the
/// rounding error, which balances it against the truncation error. A matrix that steps are found with need not be better.
const DIFFERENCE_STEP: f64 = 1e-7;

/// The radius, in units of the size of the data, at which the iteration is given up.
const LARGEST_RADIUS: f64 = 1e4;

/// Where an iteration moves.
#[derive(Debug, Clone, Copy)]
pub struct Domain<'a> {
    /// The middle of the data.
    pub data_center: Vector3<f64>,
    /// The size of the data.
    pub unit: f64,
    /// The coordinates of the steps. Limits need the local ones, which are taken then.
    pub chart: Chart,
    /// What every cylinder keeps. The start must keep it.
    pub limits: &'a CylinderLimits,
}

/// Minimises an objective from a start. In the orthonormal chart this is Algorithm 2 as it is printed, but for the last step:
/// where the linearisation promises no more progress it is taken without a look, and the cost is that which was promised. In
/// the local chart the second derivative is completed where the iteration creeps. The orthonormal chart takes the caller's
/// unit of length, as the paper does, and not that of the data. `report` is called after every solve and may stop the iteration.
///
/// # Errors
/// `NoStart` when the cost of the start is infinite, `Cancelled` when `report` breaks.
pub fn minimise(
    objective: &(impl Objective + ?Sized),
    start: &Cylinder,
    domain: &Domain<'_>,
    limits: &IterationLimits,
    report: &mut dyn FnMut(&Iteration) -> ControlFlow<()>,
) -> Result<Convergence> {
    let mut descent = Descent::new(objective, start, domain, limits)?;
    let initial_cost = descent.cost();
    let termination = loop {
        if report(&descent.iteration()).is_break() {
            return Err(Error::Cancelled { iterations: descent.iterations });
        }
        if let Some(reason) = descent.ends_here() {
            break reason;
        }
        if let Some(reason) = descent.advance() {
            break reason;
        }
    };
    Ok(Convergence {
        cylinder: descent.frame.cylinder,
        cost: descent.cost(),
        initial_cost,
        iterations: descent.iterations,
        rejected_steps: descent.rejected_steps,
        termination,
        lambda: descent.lambda,
        step_norm: descent.step_norm,
    })
}

/// Where an iteration has come to.
struct Descent<'a, O: ?Sized> {
    objective: &'a O,
    limits: &'a IterationLimits,
    /// With the chart that is taken.
    domain: Domain<'a>,
    /// The unit of the frames.
    unit: f64,
    /// How large the coordinates of the data are.
    extent: f64,
    /// The cost of exact data, whose residuals are rounding errors of the coordinates: nothing is gained below.
    floor: f64,
    frame: LocalFrame,
    equations: NormalEquations,
    /// Known where the iteration creeps.
    second_derivative: Option<TangentMap>,
    lambda: f64,
    step_norm: f64,
    /// Whether a step from here that promised progress failed.
    disappointed: bool,
    iterations: usize,
    rejected_steps: usize,
}

impl<'a, O: Objective + ?Sized> Descent<'a, O> {
    /// At the start.
    fn new(
        objective: &'a O,
        start: &Cylinder,
        domain: &Domain<'a>,
        limits: &'a IterationLimits,
    ) -> Result<Self> {
        let chart = if domain.limits.is_none() { domain.chart } else { Chart::Local };
        let unit = match chart {
            Chart::Local => domain.unit,
            Chart::Orthonormal => 1.0,
        };
        let frame = LocalFrame::new(start, &domain.data_center, unit);
        let Some(equations) = objective.linearise(&frame) else {
            let reason = "the camera sees no limbs of the cylinder to start from, which is around or behind it; check the intrinsics, and the mask if there is one";
            return Err(Error::NoStart { reason: reason.into() });
        };
        let extent = domain.data_center.amax().max(domain.unit);
        Ok(Self {
            objective,
            limits,
            domain: Domain { chart, ..*domain },
            unit,
            extent,
            floor: (4.0 * f64::EPSILON * extent / unit).powi(2),
            frame,
            equations,
            second_derivative: None,
            lambda: limits.initial_lambda,
            step_norm: 0.0,
            disappointed: false,
            iterations: 0,
            rejected_steps: 0,
        })
    }

    /// The cost in the caller's unit.
    fn cost(&self) -> f64 {
        self.equations.cost * (self.unit * self.unit)
    }

    fn iteration(&self) -> Iteration {
        Iteration {
            iteration: self.iterations,
            cost: self.cost(),
            lambda: self.lambda,
            cylinder: self.frame.cylinder,
        }
    }

    /// Why no step from here is looked for.
    fn ends_here(&self) -> Option<Termination> {
        let Self { limits, domain, frame, equations, .. } = self;
        if equations.cost <= self.floor {
            return Some(Termination::Cost);
        }
        if frame.cylinder.radius > LARGEST_RADIUS * domain.unit {
            return Some(Termination::RadiusRanAway);
        }
        let largest = (equations.hessian.trace() * equations.cost).sqrt();
        let gradient = domain.limits.free_gradient(frame, &equations.gradient);
        if gradient.norm() <= limits.gradient_tolerance * largest {
            return Some(Termination::Gradient);
        }
        (self.iterations == limits.max_iterations).then_some(Termination::MaxIterations)
    }

    /// Finds a step, and takes it where it lowers the cost; else the damping grows. Says why, where that is the end.
    fn advance(&mut self) -> Option<Termination> {
        self.iterations += 1;
        let step = self.find_step();
        let promises = |part: f64| step.is_none_or(|step| !(step.decrease <= part * self.equations.cost));
        if !promises(ROUNDING) {
            return Some(if self.disappointed { Termination::Stalled } else { Termination::Cost });
        }
        let promising = promises(self.limits.cost_tolerance);
        // The last step is taken without a look: its decrease would not count as progress.
        if let (Some(step), false, false) = (step, promising, self.disappointed) {
            self.frame = self.frame_at(&step.cylinder);
            self.equations.cost -= step.decrease;
            self.step_norm = step.tangent.norm();
            return Some(Termination::Cost);
        }
        let small = step.is_some_and(|step| {
            moved_by(&self.frame, &step.cylinder, self.domain.unit)
                <= self.limits.step_tolerance * self.extent
        });
        let trial = step.and_then(|step| {
            let frame = self.frame_at(&step.cylinder);
            let equations = lower(self.objective, &frame, self.equations.cost, self.disappointed)?;
            Some((step, frame, equations))
        });
        let end = match trial {
            Some((step, frame, equations)) => self.take(&step, frame, equations),
            None => self.refuse(promising),
        };
        end.or(small.then_some(Termination::Step))
    }

    /// The step from here; `None` where there is none.
    fn find_step(&mut self) -> Option<Step> {
        let creeping = self.domain.chart == Chart::Local && self.iterations > GAUSS_NEWTON_ITERATIONS;
        if creeping && self.second_derivative.is_none() {
            self.second_derivative = self.differentiate_gradient();
        }
        let Self { frame, lambda, equations, .. } = self;
        let hessian = self.second_derivative.unwrap_or(equations.curvature);
        let step = match self.domain.chart {
            Chart::Local => Step::local(frame, &hessian, &equations.gradient, *lambda, self.domain.limits),
            Chart::Orthonormal => Step::orthonormal(frame, &hessian, &equations.gradient, *lambda),
        };
        step.filter(|step| step.tangent.iter().all(|x| x.is_finite()))
    }

    /// Goes where a step leads. Ends where the cost no longer falls.
    fn take(&mut self, step: &Step, frame: LocalFrame, equations: NormalEquations) -> Option<Termination> {
        let decrease = self.equations.cost - equations.cost;
        let converged = decrease < self.limits.cost_tolerance * self.equations.cost;
        (self.frame, self.equations) = (frame, equations);
        (self.second_derivative, self.disappointed) = (None, false);
        self.step_norm = step.tangent.norm();
        // Never 0, from which it could not grow again.
        self.lambda = (self.lambda / self.limits.lambda_factor).max(f64::MIN_POSITIVE);
        converged.then_some(Termination::Cost)
    }

    /// Stays, with more damping. Ends where that gains nothing.
    fn refuse(&mut self, promising: bool) -> Option<Termination> {
        self.rejected_steps += 1;
        // A larger damping promises less still.
        let raised = self.lambda * self.limits.lambda_factor;
        if !promising && !self.disappointed {
            return Some(Termination::Cost);
        }
        if !promising || raised > self.limits.max_lambda {
            return Some(Termination::Stalled);
        }
        (self.lambda, self.disappointed) = (raised, true);
        None
    }

    /// Half the second derivative of the cost in the tangent of the frame, by differences to the gradient; `None` next
    /// to where the cost is infinite.
    fn differentiate_gradient(&self) -> Option<TangentMap> {
        let mut derivative = TangentMap::zeros();
        for k in 0..5 {
            let ahead = self.frame.retract(&Tangent::ith(k, DIFFERENCE_STEP));
            let ahead = self.objective.linearise(&self.frame_at(&ahead))?;
            derivative.set_column(k, &((ahead.gradient - self.equations.gradient) / DIFFERENCE_STEP));
        }
        Some((derivative + derivative.transpose()) * 0.5)
    }

    fn frame_at(&self, cylinder: &Cylinder) -> LocalFrame {
        LocalFrame::new(cylinder, &self.domain.data_center, self.unit)
    }
}

/// The decrease of the cost, as a part of it, that its rounding hides: a mean of squares that are all positive.
const ROUNDING: f64 = f64::EPSILON;

/// A step of the damped normal equations.
#[derive(Clone, Copy)]
struct Step {
    /// In the coordinates of the chart.
    tangent: Tangent,
    /// Where it leads.
    cylinder: Cylinder,
    /// By how much the cost falls if the linearisation holds: −2 gᵀδ − δᵀHδ.
    decrease: f64,
}

impl Step {
    fn new(tangent: Tangent, cylinder: Cylinder, hessian: &TangentMap, gradient: &Tangent) -> Self {
        let decrease = -(gradient * 2.0 + hessian * tangent).dot(&tangent);
        Self { tangent, cylinder, decrease }
    }

    /// In the local chart, within limits; `None` where the matrix is singular.
    fn local(
        frame: &LocalFrame,
        hessian: &TangentMap,
        gradient: &Tangent,
        lambda: f64,
        limits: &CylinderLimits,
    ) -> Option<Self> {
        let (step, cylinder) = limits.step(frame, &damped(hessian, lambda), gradient)?;
        Some(Self::new(step, cylinder, hessian, gradient))
    }

    /// In the orthonormal chart; `None` where the matrix is singular.
    fn orthonormal(
        frame: &LocalFrame,
        hessian: &TangentMap,
        gradient: &Tangent,
        lambda: f64,
    ) -> Option<Self> {
        let map = frame.orthonormal_tangent_map();
        let hessian = map.transpose() * hessian * map;
        let gradient = map.transpose() * gradient;
        let step = -damped(&hessian, lambda).cholesky()?.solve(&gradient);
        Some(Self::new(step, frame.retract_orthonormal(&step), &hessian, &gradient))
    }
}

/// The normal equations of a frame where the cost is lower than `cost`. The first step from a position is nearly always
/// taken, so it is linearised at once; after a rejection the cost alone comes first.
fn lower(
    objective: &(impl Objective + ?Sized),
    frame: &LocalFrame,
    cost: f64,
    rejected: bool,
) -> Option<NormalEquations> {
    if rejected {
        objective.cost(frame).filter(|trial| *trial < cost)?;
    }
    objective.linearise(frame).filter(|equations| equations.cost < cost)
}

/// How far a step moves the surface near the data, as a length.
fn moved_by(frame: &LocalFrame, cylinder: &Cylinder, data_unit: f64) -> f64 {
    let step = frame.difference(cylinder);
    let lengths = Tangent::new(frame.unit, frame.unit, data_unit, data_unit, frame.unit);
    step.component_mul(&lengths).norm()
}

/// The matrix of (29), JᵀΩJ + λI.
fn damped(hessian: &TangentMap, lambda: f64) -> TangentMap {
    hessian + TangentMap::identity() * lambda
}

#[cfg(test)]
mod tests;
