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
    let Domain { data_center, unit: data_unit, limits: cylinder_limits, .. } = *domain;
    let chart = if cylinder_limits.is_none() { domain.chart } else { Chart::Local };
    let unit = match chart {
        Chart::Local => data_unit,
        Chart::Orthonormal => 1.0,
    };
    let squared = unit * unit;
    let linearise = |cylinder: &Cylinder| {
        let frame = LocalFrame::new(cylinder, &data_center, unit);
        objective.linearise(&frame).map(|equations| (frame, equations))
    };
    let Some((mut frame, mut equations)) = linearise(start) else {
        let reason =
            "the camera sees no limbs of the start model, which is around or behind it; check the intrinsics";
        return Err(Error::NoStart { reason: reason.into() });
    };
    let initial_cost = equations.cost * squared;
    // The residuals of exact data are rounding errors of the coordinates: nothing is gained below.
    let extent = data_center.amax().max(data_unit);
    let floor = (4.0 * f64::EPSILON * extent / unit).powi(2);

    let mut lambda = limits.initial_lambda;
    let mut step_norm = 0.0;
    let mut second_derivative = None;
    // Whether a step from here that promised progress failed.
    let mut disappointed = false;
    let (mut iterations, mut rejected_steps) = (0, 0);
    let termination = loop {
        let iteration = Iteration {
            iteration: iterations,
            cost: equations.cost * squared,
            lambda,
            cylinder: frame.cylinder,
        };
        if report(&iteration).is_break() {
            return Err(Error::Cancelled { iterations });
        }
        if equations.cost <= floor {
            break Termination::Cost;
        }
        if frame.cylinder.radius > LARGEST_RADIUS * data_unit {
            break Termination::RadiusRanAway;
        }
        let largest = (equations.hessian.trace() * equations.cost).sqrt();
        let gradient = cylinder_limits.free_gradient(&frame, &equations.gradient);
        if gradient.norm() <= limits.gradient_tolerance * largest {
            break Termination::Gradient;
        }
        if iterations == limits.max_iterations {
            break Termination::MaxIterations;
        }
        iterations += 1;
        let creeping = chart == Chart::Local && iterations > GAUSS_NEWTON_ITERATIONS;
        if creeping && second_derivative.is_none() {
            second_derivative = differentiate_gradient(&frame, &equations.gradient, linearise);
        }
        let hessian = second_derivative.unwrap_or(equations.curvature);
        let step = match chart {
            Chart::Local => Step::local(&frame, &hessian, &equations.gradient, lambda, cylinder_limits),
            Chart::Orthonormal => Step::orthonormal(&frame, &hessian, &equations.gradient, lambda),
        };
        let step = step.filter(|step| step.tangent.iter().all(|x| x.is_finite()));
        let promises = |part: f64| step.is_none_or(|step| !(step.decrease <= part * equations.cost));
        if !promises(ROUNDING) {
            break if disappointed { Termination::Stalled } else { Termination::Cost };
        }
        // The last step is taken without a look: its decrease would not count as progress.
        if let (Some(step), false, false) = (step, promises(limits.cost_tolerance), disappointed) {
            frame = LocalFrame::new(&step.cylinder, &data_center, unit);
            equations.cost -= step.decrease;
            step_norm = step.tangent.norm();
            break Termination::Cost;
        }
        let small = step.is_some_and(|step| {
            moved_by(&frame, &step.cylinder, data_unit) <= limits.step_tolerance * extent
        });
        let trial = step.and_then(|step| {
            let trial_frame = LocalFrame::new(&step.cylinder, &data_center, unit);
            let trial_equations = lower(objective, &trial_frame, equations.cost, disappointed)?;
            Some((step, trial_frame, trial_equations))
        });
        if let Some((step, trial_frame, trial_equations)) = trial {
            let decrease = equations.cost - trial_equations.cost;
            let converged = decrease < limits.cost_tolerance * equations.cost;
            (frame, equations) = (trial_frame, trial_equations);
            (second_derivative, disappointed) = (None, false);
            step_norm = step.tangent.norm();
            // Never 0, from which it could not grow again.
            lambda = (lambda / limits.lambda_factor).max(f64::MIN_POSITIVE);
            if converged {
                break Termination::Cost;
            }
        } else {
            rejected_steps += 1;
            // A larger damping promises less still.
            let promised = promises(limits.cost_tolerance);
            let raised = lambda * limits.lambda_factor;
            if !promised && !disappointed {
                break Termination::Cost;
            }
            if !promised || raised > limits.max_lambda {
                break Termination::Stalled;
            }
            (lambda, disappointed) = (raised, true);
        }
        if small {
            break Termination::Step;
        }
    };
    Ok(Convergence {
        cylinder: frame.cylinder,
        cost: equations.cost * squared,
        initial_cost,
        iterations,
        rejected_steps,
        termination,
        lambda,
        step_norm,
    })
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

/// The normal equations of a frame where the cost is lower than `cost`. The first step from a place is nearly always
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

/// Half the second derivative of the cost in the tangent of a frame, by differences to the gradient there; `None` next
/// to where the cost is infinite.
fn differentiate_gradient(
    frame: &LocalFrame,
    gradient: &Tangent,
    linearise: impl Fn(&Cylinder) -> Option<(LocalFrame, NormalEquations)>,
) -> Option<TangentMap> {
    let mut derivative = TangentMap::zeros();
    for k in 0..5 {
        let (_, ahead) = linearise(&frame.retract(&Tangent::ith(k, DIFFERENCE_STEP)))?;
        derivative.set_column(k, &((ahead.gradient - gradient) / DIFFERENCE_STEP));
    }
    Some((derivative + derivative.transpose()) * 0.5)
}

/// The matrix of (29), JᵀΩJ + λI.
fn damped(hessian: &TangentMap, lambda: f64) -> TangentMap {
    hessian + TangentMap::identity() * lambda
}

#[cfg(test)]
mod tests;
