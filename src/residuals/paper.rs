//! The objective of the paper: F = (1 − w_L) E_P + w_L E_L (15), with the stacked weights (28).

use super::limbs::LimbTerm;
use super::loss::Squared;
use super::points::{PointRows, PointTerm};
use super::{NormalEquations, Objective, Sandwich, SandwichPart};
use crate::geometry::{LocalFrame, Tangent};
use crate::observations::PointCloud;

/// F of the paper. Infinite (`None`) for r ≤ 0, and while edges count also for r ≥ ‖c‖ and where an
/// endpoint's ray meets the reference plane behind the camera.
#[derive(Debug, Clone, Copy)]
pub struct PaperObjective<'a> {
    points: PointTerm<'a>,
    /// The edges with w_L; `None` where they do not count.
    limbs: Option<(LimbTerm, f64)>,
    /// For w_L = 1 the distance of the start's axis from the camera, which stands for the scale that the edges
    /// cannot see.
    held_distance: Option<f64>,
}

impl<'a> PaperObjective<'a> {
    /// Points alone: w_L = 0.
    #[must_use]
    pub fn points_only(points: PointTerm<'a>) -> Self {
        Self { points, limbs: None, held_distance: None }
    }

    /// Points and edges, or for `edge_weight` 1 the edges alone at the distance of `start`.
    #[must_use]
    pub fn new(points: PointTerm<'a>, limbs: LimbTerm, edge_weight: f64, start_distance: f64) -> Self {
        if edge_weight == 0.0 {
            return Self::points_only(points);
        }
        let held_distance = (edge_weight == 1.0).then_some(start_distance);
        Self { points, limbs: Some((limbs, edge_weight)), held_distance }
    }

    /// w_L, 0 where no edges count.
    #[must_use]
    pub fn edge_weight(&self) -> f64 {
        self.limbs.map_or(0.0, |(_, weight)| weight)
    }

    /// The edge term, where edges count.
    #[must_use]
    pub fn limbs(&self) -> Option<&LimbTerm> {
        self.limbs.as_ref().map(|(term, _)| term)
    }

    /// What the covariance of the minimum follows from; `None` where the cost is infinite, and for w_L = 1, which
    /// leaves the scale open. The variance of the points is that of their residuals, of which `independent_points`
    /// are independent; four endpoints are too few to tell theirs, so it is given by their standard deviation in
    /// pixels.
    #[must_use]
    pub fn sandwich(&self, frame: &LocalFrame, independent_points: f64, pixel: f64) -> Option<Sandwich> {
        let edge_weight = self.edge_weight();
        if edge_weight == 1.0 {
            return None;
        }
        let mut points = self.points.sandwich(frame, Squared, independent_points);
        points.scale(1.0 - edge_weight);
        let mut edges = SandwichPart::zero();
        if let Some((term, weight)) = &self.limbs {
            edges = term.sandwich(frame, pixel)?;
            edges.scale(*weight);
        }
        Some(Sandwich { points, edges })
    }
}

impl Objective for PaperObjective<'_> {
    fn linearise(&self, frame: &LocalFrame) -> Option<NormalEquations> {
        let radius = frame.cylinder.radius;
        if !(radius > 0.0 && radius.is_finite()) {
            return None;
        }
        let mut equations = NormalEquations::zero();
        let edge_weight = self.edge_weight();
        if let Some((limbs, weight)) = &self.limbs {
            let part = match self.held_distance {
                None => limbs.linearise(frame)?,
                Some(distance) => limbs.linearise_at_scale(frame, distance)?,
            };
            equations.add_scaled(*weight, &part);
        }
        if edge_weight < 1.0 {
            equations.add_scaled(1.0 - edge_weight, &self.points.linearise(frame, Squared));
        }
        equations.cost.is_finite().then_some(equations)
    }

    fn stacked_rows(&self, cloud: &PointCloud, frame: &LocalFrame) -> Option<Vec<(f64, Tangent)>> {
        let edge_weight = self.edge_weight();
        let mut rows = Vec::with_capacity(cloud.len() + 4);
        if edge_weight < 1.0 {
            let total: f64 = (0..cloud.len()).map(|index| cloud.weight(index)).sum();
            let of_points = PointRows::new(frame);
            for (index, point) in cloud.points().enumerate() {
                let root = ((1.0 - edge_weight) * cloud.weight(index) / total).sqrt();
                let (residual, jacobian, _) = of_points.row(&point);
                rows.push((residual * root, jacobian * root));
            }
        }
        if let Some((limbs, weight)) = &self.limbs {
            let root = (weight / 4.0).sqrt();
            rows.extend(limbs.rows(frame)?.iter().flatten().map(|(e, j)| (e * root, j * root)));
        }
        Some(rows)
    }
}

#[cfg(test)]
mod tests {
    use super::super::limbs::LimbPair;
    use super::*;
    use crate::geometry::{Cylinder, LimbFrame};
    use crate::observations::PointsView;
    use nalgebra::{Matrix3, Vector2, Vector3};

    const FX: f64 = 570.0;
    const FY: f64 = 560.0;
    const CX: f64 = 319.5;
    const CY: f64 = 239.5;

    fn line_projection() -> Matrix3<f64> {
        Matrix3::new(FY, 0.0, 0.0, 0.0, FX, 0.0, -FY * CX, -FX * CY, FX * FY)
    }

    fn limb_term(pixels: [[[f64; 2]; 2]; 2]) -> LimbTerm {
        let pixels = pixels.map(|segment| segment.map(Vector2::from));
        let ray = |q: Vector2<f64>| Vector3::new((q.x - CX) / FX, (q.y - CY) / FY, 1.0);
        LimbTerm::new(LimbPair { rays: pixels.map(|s| s.map(ray)), pixels }, line_projection())
    }

    fn scene() -> (Cylinder, LimbTerm) {
        let cylinder =
            Cylinder::new(Vector3::new(0.01, -0.02, 0.7), Vector3::new(0.2, 0.95, 0.15), 0.03).unwrap();
        let term = limb_term([[[287.5, 212.5], [303.9, 287.9]], [[350.9, 204.9], [372.0, 282.8]]]);
        (cylinder, term)
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

    const PIXELS: [[[f64; 2]; 2]; 2] = [[[287.5, 212.5], [303.9, 287.9]], [[350.9, 204.9], [372.0, 282.8]]];

    #[test]
    fn a_pixel_has_the_length_that_takes_distances_to_residuals() {
        let (cylinder, term) = scene();
        let frame = LocalFrame::new(&cylinder, &cylinder.axis.point, 1.0);
        // One pixel of noise, and each of the four residuals by its own pixel distance.
        let covariance = term.sandwich(&frame, 1.0).unwrap().covariance;
        let mut expected = crate::geometry::TangentMap::zeros();
        let distances = term.pixel_distances(&cylinder).unwrap();
        for (rows, distances) in term.rows(&frame).unwrap().iter().zip(distances) {
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
        let rows = term.rows(&frame).unwrap();
        let h = 1e-6;
        for k in 0..5 {
            let at = |sign: f64| {
                let moved = frame.retract(&Tangent::ith(k, sign * h));
                term.rows(&LocalFrame { cylinder: moved, ..frame }).unwrap()
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
        let cost = |cylinder: Cylinder| {
            term.linearise_at_scale(&LocalFrame { cylinder, ..frame }, start).unwrap().cost
        };
        let equations = term.linearise_at_scale(&frame, start).unwrap();
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

    #[test]
    fn stacked_rows_give_the_normal_equations() {
        let (cylinder, term) = scene();
        let frame = LocalFrame::new(&cylinder, &Vector3::new(0.0, 0.0, 0.68), 0.05);
        let points: Vec<[f64; 3]> =
            (0..40).map(|k| [0.02 * f64::from(k).sin(), 0.002 * f64::from(k), 0.67]).collect();
        let mut cloud = PointCloud::default();
        cloud.push_points(&PointsView::from_f64(&points), None).unwrap();
        for edge_weight in [0.0, 0.6, 1.0] {
            let objective = PaperObjective {
                held_distance: None,
                ..PaperObjective::new(PointTerm::new(&cloud, 1), term, edge_weight, 0.0)
            };
            let mut expected = NormalEquations::zero();
            for (residual, jacobian) in objective.stacked_rows(&cloud, &frame).unwrap() {
                expected.add_residual(1.0, residual, &jacobian);
            }
            let equations = objective.linearise(&frame).unwrap();
            assert!((equations.cost - expected.cost).abs() < 1e-13 * expected.cost);
            assert!((equations.gradient - expected.gradient).norm() < 1e-12 * expected.gradient.norm());
            assert!((equations.hessian - expected.hessian).norm() < 1e-12 * expected.hessian.norm());
        }
        let negative = Cylinder { radius: -0.01, ..cylinder };
        let objective = PaperObjective::points_only(PointTerm::new(&cloud, 1));
        assert!(objective.linearise(&LocalFrame { cylinder: negative, ..frame }).is_none());
    }
}
