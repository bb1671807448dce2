use super::super::loss::{Squared, Truncated, Tukey, Wall};
use super::*;
use crate::geometry::Cylinder;
use crate::observations::PointsView;

fn scene(count: usize) -> (Vec<[f64; 3]>, LocalFrame) {
    let cylinder = Cylinder::new(Vector3::new(0.1, -0.2, 0.9), Vector3::new(0.4, 0.8, 0.3), 0.07).unwrap();
    let points = (0..count)
        .map(|k| {
            let t = k as f64;
            [0.1 + 0.09 * (t * 0.37).sin(), -0.2 + 0.1 * (t * 0.11).cos(), 0.85 + 0.03 * (t * 1.7).sin()]
        })
        .collect();
    (points, LocalFrame::new(&cylinder, &Vector3::new(0.1, -0.1, 0.8), 0.05))
}

#[test]
fn the_jacobian_agrees_with_central_differences() {
    let (points, frame) = scene(50);
    let h = 1e-6;
    for point in points {
        let point = Vector3::from(point);
        let (residual, jacobian, _) = PointRows::new(&frame).row(&point);
        assert!((residual - frame.cylinder.distance(&point) / frame.unit).abs() < 1e-13);
        for k in 0..5 {
            let moved = |sign: f64| frame.retract(&Tangent::ith(k, sign * h)).distance(&point);
            let difference = (moved(1.0) - moved(-1.0)) / (2.0 * h * frame.unit);
            assert!((difference - jacobian[k]).abs() < 1e-8, "{k}: {difference} {}", jacobian[k]);
        }
    }
}

#[test]
fn the_sums_are_those_of_the_rows_and_the_same_for_any_number_of_threads() {
    let (points, frame) = scene(150_003);
    let mut cloud = PointCloud::default();
    cloud.push_points(&PointsView::from_f64(&points), None).unwrap();
    let mut expected = NormalEquations::zero();
    for point in &points {
        let (residual, jacobian, _) = PointRows::new(&frame).row(&Vector3::from(*point));
        expected.add_residual(1.0 / points.len() as f64, residual, &jacobian);
    }
    let one = PointTerm::new(&cloud, None).linearise(&frame, Squared);
    assert!((one.cost - expected.cost).abs() < 1e-12 * expected.cost);
    assert!((one.gradient - expected.gradient).norm() < 1e-12 * expected.gradient.norm());
    assert!((one.hessian - expected.hessian).norm() < 1e-12 * expected.hessian.norm());
    assert_eq!(PointTerm::new(&cloud, None).cost(&frame, Squared), one.cost);
    for threads in [2, 3, 8] {
        let workers = Workers::asked(threads);
        let term = PointTerm::new(&cloud, Some(workers));
        assert_eq!(term.linearise(&frame, Squared), one);
        assert_eq!(term.cost(&frame, Squared), one.cost);
    }
}

#[test]
fn the_points_on_the_visible_wall_are_those_that_the_cylinder_counts() {
    let (points, frame) = scene(4_999);
    let around = LocalFrame::new(
        &Cylinder::new(Vector3::new(0.015, -0.37, 0.0), Vector3::new(0.1, 0.2, 1.0), 0.4).unwrap(),
        &Vector3::new(0.1, -0.1, 0.8),
        0.05,
    );
    let mut cloud = PointCloud::default();
    cloud.push_points(&PointsView::from_f64(&points), None).unwrap();
    for frame in [frame, around] {
        let (walls, energy) = PointTerm::new(&cloud, None).walls_and_energy(&frame);
        let cost = PointTerm::new(&cloud, None).cost(&frame, Squared);
        assert_eq!(energy, cost * frame.unit * frame.unit);
        assert_eq!(walls, frame.cylinder.visible_wall(cloud.points()));
        assert!(walls.visible > 500 && walls.visible < walls.total, "{walls:?}");
    }
}

#[test]
fn distances_on_a_wall_are_those_of_single_points_and_infinite_on_the_other() {
    for size in [1.0, 1e60, 1e-60] {
        let (points, frame) = scene(1_003);
        let points: Vec<[f64; 3]> = points.iter().map(|point| point.map(|x| x * size)).collect();
        let Cylinder { axis, radius } = frame.cylinder;
        let cylinder = Cylinder::new(axis.point * size, axis.direction, radius * size).unwrap();
        let frame = LocalFrame::new(&cylinder, &Vector3::zeros(), 0.05 * size);
        let mut cloud = PointCloud::default();
        cloud.push_points(&PointsView::from_f64(&points), None).unwrap();
        let rows = PointRows::new(&frame);
        for wall in [Wall::Either, Wall::Facing, Wall::Averted] {
            let found = PointTerm::new(&cloud, None).distances_on(wall, &frame);
            for (point, found) in points.iter().zip(&found) {
                let (residual, facing) = rows.residual(&Vector3::from(*point));
                let expected = if wall.hides(facing) { f64::INFINITY } else { residual };
                assert!(*found == expected || (found - expected).abs() < 1e-12, "{found} {expected}");
            }
        }
    }
}

#[test]
fn the_cost_alone_and_the_rows_are_those_of_the_linearisation() {
    let (points, frame) = scene(4_999);
    let mut cloud = PointCloud::default();
    cloud.push_points(&PointsView::from_f64(&points), None).unwrap();
    let term = PointTerm::new(&cloud, None);
    let check = |equations: NormalEquations, cost: f64, rows: &mut dyn Iterator<Item = (f64, Tangent)>| {
        assert_eq!(equations.cost, cost);
        let mut expected = NormalEquations::zero();
        rows.for_each(|(e, j)| expected.add_residual(1.0, e, &j));
        let difference = (expected.gradient - equations.gradient).norm();
        assert!(difference < 1e-13 * equations.hessian.norm(), "{difference}");
        let difference = (expected.hessian - equations.hessian).norm();
        assert!(difference < 1e-12 * equations.hessian.norm(), "{difference}");
    };
    for wall in [Wall::Either, Wall::Facing, Wall::Averted] {
        let tukey = Tukey { cutoff: 0.5, wall };
        let truncated = Truncated { threshold: 0.3, wall };
        let rows = &mut term.rows(&frame, tukey);
        check(term.linearise(&frame, tukey), term.cost(&frame, tukey), rows);
        let rows = &mut term.rows(&frame, truncated);
        check(term.linearise(&frame, truncated), term.cost(&frame, truncated), rows);
    }
}

#[test]
fn weights_count_as_repeated_points() {
    let (mut points, frame) = scene(20);
    let mut weighted = PointCloud::default();
    let memory: Vec<u8> = (0..20).flat_map(|k| if k == 3 { 3.0_f64 } else { 1.0 }.to_ne_bytes()).collect();
    let weights = crate::observations::Strided::new(&memory, 0, (20, 1), 8, (8, 0)).unwrap();
    let view = PointsView { weights: Some(weights), ..PointsView::from_f64(&points) };
    weighted.push_points(&view, None).unwrap();
    points.extend([points[3]; 2]);
    let mut repeated = PointCloud::default();
    repeated.push_points(&PointsView::from_f64(&points), None).unwrap();
    let a = PointTerm::new(&weighted, None).linearise(&frame, Squared);
    let b = PointTerm::new(&repeated, None).linearise(&frame, Squared);
    assert!((a.cost - b.cost).abs() < 1e-14 * b.cost);
    assert!((a.hessian - b.hessian).norm() < 1e-13 * b.hessian.norm());
}

#[test]
fn the_covariance_is_that_of_single_points() {
    let (points, frame) = scene(4_999);
    let mut cloud = PointCloud::default();
    cloud.push_points(&PointsView::from_f64(&points), None).unwrap();
    let term = PointTerm::new(&cloud, None);
    let independent = 800.0;
    for wall in [Wall::Either, Wall::Facing] {
        let loss = Tukey { cutoff: 0.5, wall };
        let NormalEquations { gradient, hessian, .. } = term.linearise(&frame, loss);
        let factor = hessian.cholesky().unwrap();
        let (to_minimum, copies) = (-factor.solve(&gradient), points.len() as f64 / independent);
        let leverages = factor.inverse() * copies;
        let mut covariance = TangentMap::zeros();
        let (mut weights, mut slopes, mut squares) = (0.0, 0.0, 0.0);
        let part = 1.0 / points.len() as f64;
        for point in &points {
            let (residual, jacobian, facing) = PointRows::new(&frame).row(&Vector3::from(*point));
            let influence = loss.influence(residual, facing);
            let weight = part * influence.weight;
            let slope = influence.slope;
            let leverage = weight * jacobian.dot(&(leverages * jacobian));
            let noise = (residual + jacobian.dot(&to_minimum)) / (1.0 - leverage.min(LARGEST_LEVERAGE));
            covariance += jacobian * jacobian.transpose() * (weight * noise).powi(2);
            weights += weight;
            slopes += part * slope;
            squares += part * slope * slope;
        }
        let correction = 1.0 + 5.0 / independent * (squares / (slopes * slopes) - 1.0);
        let student = (independent - 5.0) / (independent - 7.0);
        let expected = covariance * (copies * correction * correction * student);
        let found = term.sandwich(&frame, loss, independent, &term.linearise(&frame, loss));
        assert!((found.covariance - expected).norm() < 1e-10 * expected.norm());
        let derivative = hessian * (slopes / weights);
        assert!((found.derivative - derivative).norm() < 1e-10 * derivative.norm());
    }
}

#[test]
fn a_part_of_points_tells_their_curvature() {
    // Far less noise on one side of the cylinder than on the other.
    let (_, frame) = scene(0);
    let LocalFrame { cylinder, u, v, .. } = frame;
    let point = |k: usize| {
        let t = k as f64;
        let angle = 1.3 * (t * 0.37).sin();
        let noise = 0.0009 * (1.1 + (t * 0.37).sin()) * (t * 1.9).sin();
        let across = (u * angle.sin() + v * angle.cos()) * (cylinder.radius + noise);
        (cylinder.axis.point + across + cylinder.axis.direction * (0.1 * (t * 0.11).cos())).into()
    };
    let points: Vec<[f64; 3]> = (0..5_000).map(point).collect();
    let mut cloud = PointCloud::default();
    cloud.push_points(&PointsView::from_f64(&points), None).unwrap();
    let loss = Tukey { cutoff: 0.08, wall: Wall::Either };
    let plain = PointTerm::new(&cloud, None);
    // Nothing but what is left out is tested: how like all of them a part is belongs to its points.
    let told = plain.with_part(Some(&cloud)).with_curvature(&frame, loss);
    let gradient = |k, step: f64| {
        let ahead = frame.retract(&Tangent::ith(k, step));
        plain.linearise(&LocalFrame::new(&ahead, &Vector3::new(0.1, -0.1, 0.8), frame.unit), loss).gradient
    };
    let columns: [Tangent; 5] = std::array::from_fn(|k| (gradient(k, 1e-6) - gradient(k, -1e-6)) / 2e-6);
    let exact = TangentMap::from_columns(&columns);
    let [by_mean, by_part] =
        [plain, told].map(|term| (term.linearise(&frame, loss).curvature - exact).norm() / exact.norm());
    assert!(by_part < 1e-3 && by_mean > 0.05, "{by_part} {by_mean}");
    // Nothing else changes.
    let [plain, told] = [plain, told].map(|term| term.linearise(&frame, loss));
    assert_eq!(NormalEquations { curvature: plain.curvature, ..told }, plain);
}
