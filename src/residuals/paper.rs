//! The objective of the paper: F = (1 − w_L) E_P + w_L E_L (15), with the stacked weights (28).

use super::limbs::LimbTerm;
use super::point_terms::{Plain, Points};
use super::points::PointTerm;
use super::terms::{AnyTerm, Sum, Summand};
use crate::geometry::RigidMotion;
use smallvec::SmallVec;

/// F of the paper. Infinite for r ≤ 0, and while edges count also for r ≥ ‖c‖ and where an endpoint's ray meets the
/// reference plane behind the camera.
///
/// `points` are those of each view with the motion into it and how many of them are independent; E_P is the mean over
/// all. `limbs` are the edge terms with the motions into their views; E_L is the mean over them. For `edge_weight` 1 the
/// points do not count.
#[must_use]
pub fn paper_objective<'a>(
    points: &[(PointTerm<'a>, RigidMotion, f64)],
    limbs: &[(LimbTerm, RigidMotion)],
    edge_weight: f64,
) -> Sum<'a> {
    let mut summands = SmallVec::new();
    for &(term, into_view) in limbs {
        let factor = edge_weight / limbs.len() as f64;
        summands.push(Summand { factor, into_view, term: AnyTerm::Limbs(term) });
    }
    let total: f64 = points.iter().map(|(points, ..)| points.total_weight()).sum();
    for &(points, into_view, independent_points) in points {
        let factor = (1.0 - edge_weight) * points.total_weight() / total;
        if factor > 0.0 {
            let term = AnyTerm::Plain(Points::new(points, Plain, independent_points));
            summands.push(Summand { factor, into_view, term });
        }
    }
    Sum { summands }
}

#[cfg(test)]
mod tests {
    use super::super::limbs::LimbPair;
    use super::super::{NormalEquations, Objective, Term};
    use super::*;
    use crate::geometry::{Cylinder, LimbFrame, LocalFrame, Tangent, TangentMap};
    use crate::observations::{PointCloud, PointsView};
    use nalgebra::{Matrix3, Vector2, Vector3};

    const FX: f64 = 570.0;
    const FY: f64 = 560.0;
    const CX: f64 = 319.5;
    const CY: f64 = 239.5;
    const PIXELS: [[[f64; 2]; 2]; 2] = [[[287.5, 212.5], [303.9, 287.9]], [[350.9, 204.9], [372.0, 282.8]]];

    fn line_projection() -> Matrix3<f64> {
        Matrix3::new(FY, 0.0, 0.0, 0.0, FX, 0.0, -FY * CX, -FX * CY, FX * FY)
    }

    fn limb_term(pixels: [[[f64; 2]; 2]; 2]) -> LimbTerm {
        let pixels = pixels.map(|segment| segment.map(Vector2::from));
        let ray = |q: Vector2<f64>| Vector3::new((q.x - CX) / FX, (q.y - CY) / FY, 1.0);
        LimbTerm::new(LimbPair { rays: pixels.map(|s| s.map(ray)), pixels }, line_projection(), 1.0)
    }

    fn scene() -> (Cylinder, LimbTerm) {
        let cylinder =
            Cylinder::new(Vector3::new(0.01, -0.02, 0.7), Vector3::new(0.2, 0.95, 0.15), 0.03).unwrap();
        (cylinder, limb_term(PIXELS))
    }

    /// The edge energy word for word as the paper defines it, by planes, intersections and Plücker lines.
    fn energy_by_the_paper(cylinder: &Cylinder, term: &LimbTerm, pixels: [[[f64; 2]; 2]; 2]) -> f64 {
        let limbs = LimbFrame::new(cylinder).unwrap();
        let direct = term.associate(&limbs);
        let [l1, l2] = limbs.limb_lines();
        let d = cylinder.axis.direction;
        let normal = (l2.point - l1.point).cross(&d);
        let offset = -normal.dot(&l1.point);
        let mut sum = 0.0;
        for (segment, endpoints) in pixels.iter().enumerate() {
            let line = if (segment == 0) == direct { &l1 } else { &l2 };
            for q in endpoints {
                let ray = Vector3::new((q[0] - CX) / FX, (q[1] - CY) / FY, 1.0);
                let hit = ray * (-offset / normal.dot(&ray));
                sum += line.distance(&hit).powi(2);
            }
        }
        sum / 4.0
    }

    /// Distances in pixels of the endpoints from the projected limb lines they go with, by segment.
    fn pixel_distances(cylinder: &Cylinder, term: &LimbTerm) -> [[f64; 2]; 2] {
        let limbs = LimbFrame::new(cylinder).unwrap();
        let direct = term.associate(&limbs);
        let lines = limbs.limb_plane_normals().map(|moment| line_projection() * moment);
        [0, 1].map(|segment: usize| {
            let line = lines[if direct { segment } else { 1 - segment }];
            PIXELS[segment].map(|q| line.dot(&Vector2::from(q).push(1.0)) / line.x.hypot(line.y))
        })
    }

    #[test]
    fn a_pixel_has_the_length_that_takes_distances_to_residuals() {
        let (cylinder, term) = scene();
        let frame = LocalFrame::new(&cylinder, &cylinder.axis.point, 1.0);
        // One pixel of noise, and each of the four residuals by its own pixel distance.
        let covariance = term.sandwich(&frame).unwrap().covariance;
        let mut expected = TangentMap::zeros();
        let distances = pixel_distances(&cylinder, &term);
        for (rows, distances) in term.endpoints(&frame).unwrap().iter().zip(distances) {
            for ((residual, jacobian), distance) in rows.iter().zip(distances) {
                expected += jacobian * jacobian.transpose() * (residual / distance / 4.0).powi(2);
            }
        }
        assert!((covariance - expected).norm() < 1e-9 * expected.norm(), "{covariance} {expected}");
    }

    #[test]
    fn the_edge_energy_is_that_of_the_definition() {
        let (cylinder, term) = scene();
        let expected = energy_by_the_paper(&cylinder, &term, PIXELS);
        assert!((term.energy(&cylinder).unwrap() - expected).abs() < 1e-13 * expected);
        // Swapped segments are associated anew and give the same energy.
        let swapped = limb_term([PIXELS[1], PIXELS[0]]);
        assert!((swapped.energy(&cylinder).unwrap() - expected).abs() < 1e-13 * expected);
        assert_ne!(
            term.associate(&LimbFrame::new(&cylinder).unwrap()),
            swapped.associate(&LimbFrame::new(&cylinder).unwrap())
        );
    }

    #[test]
    fn edge_jacobians_agree_with_central_differences() {
        let (cylinder, term) = scene();
        let frame = LocalFrame::new(&cylinder, &Vector3::new(0.03, 0.06, 0.66), 0.05);
        let rows = term.endpoints(&frame).unwrap();
        let h = 1e-6;
        for k in 0..5 {
            let at = |sign: f64| {
                let moved = frame.retract(&Tangent::ith(k, sign * h));
                term.endpoints(&LocalFrame { cylinder: moved, ..frame }).unwrap()
            };
            let (ahead, behind) = (at(1.0), at(-1.0));
            for segment in 0..2 {
                for end in 0..2 {
                    let difference = (ahead[segment][end].0 - behind[segment][end].0) / (2.0 * h);
                    let analytic = rows[segment][end].1[k];
                    assert!((difference - analytic).abs() < 1e-7, "{k} {difference} {analytic}");
                }
            }
        }
    }

    #[test]
    fn the_objective_without_scale_has_the_right_gradient_and_none_along_the_scale() {
        let (cylinder, term) = scene();
        let frame = LocalFrame::new(&cylinder, &Vector3::new(0.03, 0.06, 0.66), 0.05);
        let start = cylinder.distance_of_axis_from_origin();
        let cost = |cylinder: Cylinder| term.held_at(start).cost(&LocalFrame { cylinder, ..frame }).unwrap();
        let equations = term.held_at(start).linearise(&frame).unwrap();
        let h = 1e-6;
        for k in 0..5 {
            let step = Tangent::ith(k, h);
            let difference = (cost(frame.retract(&step)) - cost(frame.retract(&-step))) / (2.0 * h);
            assert!((difference - 2.0 * equations.gradient[k]).abs() < 1e-8, "{k}");
        }
        // The scale moves c and r alike.
        let c = frame.cylinder.axis.point;
        let scale = Tangent::new(c.dot(&frame.u), c.dot(&frame.v), 0.0, 0.0, cylinder.radius) / frame.unit;
        assert!((equations.hessian * scale).norm() < 1e-12 * equations.hessian.norm() * scale.norm());
    }

    #[test]
    fn the_energy_is_infinite_where_the_paper_leaves_it_open() {
        let (cylinder, term) = scene();
        let inside = Cylinder { radius: cylinder.distance_of_axis_from_origin() * 1.01, ..cylinder };
        assert!(term.energy(&inside).is_none());
        let behind = limb_term([[[287.5, 212.5], [303.9, 287.9]], [[350.9, 204.9], [372.0, 1e7]]]);
        // The last ray is nearly the y axis; with the axis tilted it meets the plane behind the camera.
        let tilted = Cylinder::new(Vector3::new(0.0, 0.0, 0.7), Vector3::new(0.0, 0.5, 0.8), 0.03).unwrap();
        assert!(behind.energy(&tilted).is_none());
    }

    fn cloud() -> PointCloud {
        let points: Vec<[f64; 3]> =
            (0..40).map(|k| [0.02 * f64::from(k).sin(), 0.002 * f64::from(k), 0.67]).collect();
        let mut cloud = PointCloud::default();
        cloud.push_points(&PointsView::from_f64(&points), None).unwrap();
        cloud
    }

    #[test]
    fn stacked_rows_give_the_normal_equations() {
        let (cylinder, term) = scene();
        let frame = LocalFrame::new(&cylinder, &Vector3::new(0.0, 0.0, 0.68), 0.05);
        let (cloud, here) = (cloud(), RigidMotion::identity());
        let points = PointTerm::new(&cloud, None);
        for edge_weight in [0.0, 0.6, 1.0] {
            let objective = paper_objective(&[(points, here, 40.0)], &[(term, here)], edge_weight);
            let mut expected = NormalEquations::zero();
            for (residual, jacobian) in objective.rows(&frame).unwrap() {
                expected.add_residual(1.0, residual, &jacobian);
            }
            let equations = objective.linearise(&frame).unwrap();
            assert!((equations.cost - expected.cost).abs() < 1e-13 * expected.cost);
            assert!((equations.gradient - expected.gradient).norm() < 1e-12 * expected.gradient.norm());
            assert!((equations.hessian - expected.hessian).norm() < 1e-12 * expected.hessian.norm());
            assert_eq!(objective.cost(&frame), Some(equations.cost));
        }
        let negative = Cylinder { radius: -0.01, ..cylinder };
        let objective = paper_objective(&[(points, here, 40.0)], &[], 0.0);
        assert!(objective.linearise(&LocalFrame { cylinder: negative, ..frame }).is_none());
    }

    #[test]
    fn a_view_elsewhere_has_the_same_tangent() {
        let (cylinder, term) = scene();
        let frame = LocalFrame::new(&cylinder, &Vector3::new(0.0, 0.0, 0.68), 0.05);
        let cloud = cloud();
        let points = PointTerm::new(&cloud, None);
        let rotation = crate::geometry::exp_so3(&Vector3::new(0.3, -0.7, 1.1));
        let pose = RigidMotion::new(rotation, Vector3::new(0.4, -0.1, 2.0)).unwrap();
        let at_identity = RigidMotion::identity();
        let here = paper_objective(&[(points, at_identity, 40.0)], &[(term, at_identity)], 0.6);
        let there = paper_objective(&[(points, pose.inverse(), 40.0)], &[(term, pose.inverse())], 0.6);
        let (a, b) = (here.linearise(&frame).unwrap(), there.linearise(&frame.moved(&pose)).unwrap());
        assert!((a.cost - b.cost).abs() < 1e-12 * a.cost);
        assert!((a.gradient - b.gradient).norm() < 1e-12 * a.gradient.norm());
        // Two views, one elsewhere, against central differences.
        let both =
            paper_objective(&[(points, at_identity, 40.0), (points, pose, 40.0)], &[(term, pose)], 0.6);
        let back = pose.inverse();
        let off = LocalFrame::new(&back.cylinder(&cylinder), &back.point(&Vector3::z()), 0.05);
        let equations = both.linearise(&off).unwrap();
        let h = 1e-6;
        for k in 0..5 {
            let at = |size: f64| {
                let cylinder = off.retract(&Tangent::ith(k, size));
                both.cost(&LocalFrame::new(&cylinder, &off.cylinder.axis.point, 0.05)).unwrap()
            };
            let difference = (at(h) - at(-h)) / (2.0 * h);
            let expected = 2.0 * equations.gradient[k];
            assert!(
                (difference - expected).abs() < 1e-6 * (1.0 + expected.abs()),
                "{k} {difference} {expected}"
            );
        }
    }
}
