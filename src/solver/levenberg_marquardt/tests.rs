use super::*;
use nalgebra::SMatrix;
use std::cell::Cell;

/// The residuals of some function of the difference δ to a cylinder, with its Jacobian, and how often they were asked.
struct Made<const N: usize, F: Fn(&Tangent) -> (SMatrix<f64, N, 1>, SMatrix<f64, N, 5>)> {
    goal: Cylinder,
    function: F,
    linearised: Cell<usize>,
    costs: Cell<usize>,
}

impl<const N: usize, F: Fn(&Tangent) -> (SMatrix<f64, N, 1>, SMatrix<f64, N, 5>)> Made<N, F> {
    fn new(goal: Cylinder, function: F) -> Self {
        Self { goal, function, linearised: Cell::new(0), costs: Cell::new(0) }
    }

    fn difference(&self, cylinder: &Cylinder) -> Tangent {
        let unit = 0.1;
        LocalFrame::new(&self.goal, &self.goal.axis.point, unit).difference(cylinder)
    }
}

impl<const N: usize, F: Fn(&Tangent) -> (SMatrix<f64, N, 1>, SMatrix<f64, N, 5>)> Objective for Made<N, F> {
    fn linearise(&self, frame: &LocalFrame) -> Option<NormalEquations> {
        self.linearised.set(self.linearised.get() + 1);
        let here = self.difference(&frame.cylinder);
        let (e, jacobian) = (self.function)(&here);
        // The chain rule through the retraction.
        let h = 1e-6;
        let mut map = TangentMap::zeros();
        for k in 0..5 {
            let at = |sign: f64| self.difference(&frame.retract(&Tangent::ith(k, sign * h)));
            map.set_column(k, &((at(1.0) - at(-1.0)) / (2.0 * h)));
        }
        let jacobian = jacobian * map;
        Some(NormalEquations {
            cost: e.norm_squared(),
            gradient: jacobian.transpose() * e,
            hessian: jacobian.transpose() * jacobian,
            curvature: jacobian.transpose() * jacobian,
        })
    }

    fn cost(&self, frame: &LocalFrame) -> Option<f64> {
        self.costs.set(self.costs.get() + 1);
        Some((self.function)(&self.difference(&frame.cylinder)).0.norm_squared())
    }
}

fn goal() -> Cylinder {
    Cylinder::new(Vector3::new(0.05, -0.03, 0.7), Vector3::new(0.35, 0.9, 0.2), 0.05).unwrap()
}

fn start() -> Cylinder {
    Cylinder::new(Vector3::new(0.06, -0.01, 0.72), Vector3::new(0.45, 0.9, 0.1), 0.06).unwrap()
}

fn run(objective: &impl Objective, limits: &IterationLimits) -> Convergence {
    let none = CylinderLimits::default();
    let domain = Domain { data_center: goal().axis.point, unit: 0.1, chart: Chart::Local, limits: &none };
    minimise(objective, &start(), &domain, limits, &mut |_| ControlFlow::Continue(())).unwrap()
}

/// Six residuals of which one no step changes: the minimum has a cost.
fn linear(delta: &Tangent) -> (SMatrix<f64, 6, 1>, SMatrix<f64, 6, 5>) {
    let mut jacobian = SMatrix::<f64, 6, 5>::zeros();
    for k in 0..5 {
        jacobian[(k, k)] = 1.0 + k as f64;
        jacobian[(k, (k + 1) % 5)] = 0.3;
    }
    let mut e = jacobian * delta;
    e[5] = 0.01;
    (e, jacobian)
}

/// Rosenbrock's valley along two of the coordinates.
fn valley(delta: &Tangent) -> (SMatrix<f64, 6, 1>, SMatrix<f64, 6, 5>) {
    let (mut e, mut jacobian) = (SMatrix::<f64, 6, 1>::zeros(), SMatrix::<f64, 6, 5>::zeros());
    for k in 2..5 {
        e[k] = delta[k];
        jacobian[(k, k)] = 1.0;
    }
    (e[0], e[1], e[5]) = (10.0 * (delta[1] - delta[0] * delta[0]), delta[0], 1e-3);
    (jacobian[(0, 0)], jacobian[(0, 1)], jacobian[(1, 0)]) = (-20.0 * delta[0], 10.0, 1.0);
    (e, jacobian)
}

#[test]
fn a_quadratic_and_a_valley_end_at_their_minimum_without_a_climb() {
    fn check<const N: usize>(
        function: impl Fn(&Tangent) -> (SMatrix<f64, N, 1>, SMatrix<f64, N, 5>),
        cost: f64,
        most: usize,
    ) {
        let objective = Made::new(goal(), function);
        let end = run(&objective, &IterationLimits::default());
        assert!((end.cost / (0.01 * cost) - 1.0).abs() < 1e-9, "{end:?}");
        assert!(goal().compare(&end.cylinder).angle < 1e-6, "{end:?}");
        assert!(matches!(end.termination, Termination::Cost | Termination::Gradient | Termination::Step));
        assert!(end.iterations <= most && end.lambda < 1.0, "{end:?}");
        // Trials cost no linearisation, only accepted steps do.
        assert!(objective.costs.get() <= end.iterations);
        assert!(objective.linearised.get() <= 1 + end.iterations - end.rejected_steps);
    }
    check(linear, 1e-4, 8);
    check(valley, 1e-6, 30);
}

#[test]
fn at_a_minimum_it_ends_at_once() {
    let objective = Made::new(goal(), linear);
    let first = run(&objective, &IterationLimits::default());
    let again = {
        let none = CylinderLimits::default();
        let domain = Domain { data_center: goal().axis.point, unit: 0.1, chart: Chart::Local, limits: &none };
        let limits = IterationLimits::default();
        minimise(&objective, &first.cylinder, &domain, &limits, &mut |_| ControlFlow::Continue(())).unwrap()
    };
    assert!(again.iterations <= 2 && again.rejected_steps <= 1, "{again:?}");
    assert_ne!(again.termination, Termination::Stalled);
}

#[test]
fn the_tolerances_end_it_by_their_names() {
    let objective = Made::new(goal(), valley);
    let none = IterationLimits { cost_tolerance: 0.0, ..IterationLimits::default() };
    let by_gradient = run(&objective, &IterationLimits { gradient_tolerance: 0.1, ..none });
    assert_eq!(by_gradient.termination, Termination::Gradient);
    let by_step = run(&objective, &IterationLimits { step_tolerance: 1e-3, ..none });
    assert_eq!(by_step.termination, Termination::Step);
    let by_cost = run(&objective, &IterationLimits { cost_tolerance: 0.1, ..none });
    assert_eq!(by_cost.termination, Termination::Cost);
    let full = run(&objective, &none);
    assert!(full.iterations >= by_gradient.iterations && full.iterations >= by_step.iterations);
    assert_eq!(run(&objective, &IterationLimits { max_iterations: 1, ..none }).iterations, 1);
}

#[test]
fn the_damping_stays_finite() {
    // Not a descent direction anywhere: every step is rejected.
    let uphill = |delta: &Tangent| {
        let (e, jacobian) = linear(delta);
        (e, -jacobian)
    };
    for lambda_factor in [10.0, 1e200, 1e308] {
        for max_lambda in [1e12, f64::MAX] {
            let limits = IterationLimits { lambda_factor, max_lambda, ..IterationLimits::default() };
            let stalled = run(&Made::new(goal(), uphill), &limits);
            assert_eq!(stalled.cylinder.radius, start().radius);
            assert!(stalled.lambda.is_finite(), "{stalled:?}");
            let downhill = run(&Made::new(goal(), linear), &limits);
            assert!(downhill.lambda > 0.0 && downhill.lambda.is_finite(), "{downhill:?}");
        }
    }
}
