use super::super::point_terms::Robust;
use super::super::points::PointTerm;
use super::*;
use crate::geometry::Cylinder;
use crate::observations::{PointCloud, PointsView};

/// Points on the near half of a can whose radius is larger by a part, with a ripple for noise.
fn points(truth: &Cylinder, bent_by: f64) -> Vec<[f64; 3]> {
    let frame = LocalFrame::new(truth, &truth.axis.point, 1.0);
    let away = truth.axis.nearest_to_origin().normalize();
    let aside = truth.axis.direction.cross(&away);
    let middle = frame.cylinder.axis.point + away * bent_by;
    let mut points = Vec::new();
    for i in -20..=20 {
        for j in -10..=10 {
            let (angle, along) = (0.055 * f64::from(i), 0.004 * f64::from(j));
            let ripple = 3e-4 * (f64::from(7 * i + 3 * j)).sin() + if (i + j) % 9 == 0 { 0.004 } else { 0.0 };
            let normal = aside * angle.sin() - away * angle.cos();
            points.push(
                (middle + truth.axis.direction * along + normal * (truth.radius + bent_by + ripple)).into(),
            );
        }
    }
    points
}

fn can() -> Cylinder {
    Cylinder::new(Vector3::new(0.01, -0.02, 0.7), Vector3::new(0.2, 0.95, 0.15), 0.03).unwrap()
}

fn term(cloud: &PointCloud, bend: f64) -> SharingPoints<'_, Robust> {
    let points = Points::new(PointTerm::new(cloud, None), Robust { scale: 5e-4, observed: true }, 200.0);
    let shared = SharedErrors { bend, offset: 7e-4, across: 3e-4, tilt: 0.003 };
    let near = LocalFrame::new(&can(), &can().axis.point, 0.05);
    SharingPoints::new(points, shared, 5e-4_f64.powi(2) / 200.0, true, Known::Nothing, &near).unwrap()
}

fn frame_beside(cylinder: &Cylinder) -> LocalFrame {
    let frame = LocalFrame::new(cylinder, &cylinder.axis.point, 0.05);
    LocalFrame::new(
        &frame.retract(&Tangent::new(0.004, -0.003, 0.01, -0.008, 0.005)),
        &cylinder.axis.point,
        0.05,
    )
}

fn cloud(bent_by: f64) -> PointCloud {
    let mut cloud = PointCloud::default();
    cloud.push_points(&PointsView::from_f64(&points(&can(), bent_by)), None).unwrap();
    cloud
}

#[test]
fn the_gradient_agrees_with_central_differences() {
    let cloud = cloud(1e-3);
    let term = term(&cloud, 1e-3);
    let frame = frame_beside(&can());
    let gradient = term.linearise(&frame).unwrap().gradient;
    let h = 1e-5;
    for k in 0..5 {
        let at = |step: f64| {
            let moved = frame.retract(&Tangent::ith(k, step));
            let moved = LocalFrame::new(&moved, &frame.cylinder.axis.point, frame.unit);
            term.cost(&moved).unwrap()
        };
        let difference = (at(h) - at(-h)) / (4.0 * h);
        assert!(
            (difference - gradient[k]).abs() < 1e-5 * gradient.norm(),
            "{k} {difference} {}",
            gradient[k]
        );
    }
}

#[test]
fn the_cost_is_that_of_the_best_bend() {
    let cloud = cloud(1e-3);
    let term = term(&cloud, 1e-3);
    let frame = frame_beside(&can());
    let least = term.cost(&frame).unwrap();
    let at = |b: f64| {
        let mut bent = frame;
        bent.cylinder.axis.point += term.axis_shift * (b * frame.unit);
        bent.cylinder.radius += b * frame.unit;
        term.points.cost(&bent).unwrap() + term.stiffness() * b * b
    };
    let sampled = (-400..=400).map(|k| at(1e-4 * f64::from(k))).fold(f64::INFINITY, f64::min);
    assert!(least <= sampled && sampled - least < 1e-4 * least, "{least} {sampled}");
}

#[test]
fn rows_are_what_the_normal_equations_sum() {
    let cloud = cloud(1e-3);
    let term = term(&cloud, 1e-3);
    let frame = frame_beside(&can());
    let equations = term.linearise(&frame).unwrap();
    let mut sums = NormalEquations::zero();
    for (residual, jacobian) in term.rows(&frame).unwrap() {
        sums.add_residual(1.0, residual, &jacobian);
    }
    assert!((sums.gradient - equations.gradient).norm() < 1e-9 * equations.gradient.norm());
    assert!((sums.hessian - equations.hessian).norm() < 1e-9 * equations.hessian.norm());
}

#[test]
fn the_variance_of_the_radius_grows_by_that_of_the_bend() {
    let cloud = cloud(0.0);
    let frame = LocalFrame::new(&can(), &can().axis.point, 0.05);
    let variance = |part: SandwichPart| {
        let inverse = part.derivative.try_inverse().unwrap();
        (inverse * part.covariance * inverse)[(4, 4)] * frame.unit * frame.unit
    };
    let term = term(&cloud, 1e-3);
    let own = variance(term.points.sandwich(&frame).unwrap());
    let all = variance(term.sandwich(&frame).unwrap());
    assert!(((all - own) / 1e-6 - 1.0).abs() < 0.01, "{all} {own}");
}

#[test]
fn a_shift_across_the_line_of_sight_adds_its_variance_there() {
    let cloud = cloud(0.0);
    let frame = LocalFrame::new(&can(), &can().axis.point, 0.05);
    let aside = can().axis.direction.cross(&can().axis.point).normalize();
    let aside = Tangent::new(aside.dot(&frame.u), aside.dot(&frame.v), 0.0, 0.0, 0.0);
    let variance = |across: f64| {
        let mut term = term(&cloud, 1e-3);
        term.shared.across = across;
        let part = term.sandwich(&frame).unwrap();
        let inverse = part.derivative.try_inverse().unwrap();
        aside.dot(&(inverse * part.covariance * inverse * aside))
    };
    let added = variance(3e-4) - variance(0.0);
    assert!((added / (3e-4_f64 / 0.05).powi(2) - 1.0).abs() < 0.02, "{added}");
}
