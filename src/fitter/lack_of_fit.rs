//! Whether the points lie on a body that is no cylinder: one that is bent, bulges as a sphere does, or widens, or a box.
//!
//! The scale of the points tells it only where the body is wrong by more than depth cameras scatter. What such a body leaves
//! is small, but no noise: it changes smoothly along the axis. So distances from the cylinder are explained twice by least
//! squares, along the position x on the axis and the angle φ about it: by what a cylinder near by leaves, 1, cos φ, sin φ,
//! x cos φ and x sin φ, and by x, x², x² cos φ and x² sin φ besides, which are a cone, a bulge and a bend. What changes
//! across the axis may be the depth beside limbs, so there the points are asked whether two planes explain them better.

use super::data::{Data, ViewData};
use super::scales::Scales;
use super::two_planes::{TwoPlanes, Weighted};
use crate::geometry::{Cylinder, LocalFrame};
use crate::memory::List;
use crate::observations::{PointCloud, spread};
use crate::residuals::{RobustScales, TUKEY_EFFICIENT};
use nalgebra::{SMatrix, SVector, Vector3};

/// Points of a view that tell it.
const SAMPLE: usize = 160;

/// Terms, and how many of them, the first ones, another cylinder explains.
const TERMS: usize = 9;
const OF_CYLINDER: usize = 5;

/// What the shape explains must have this part of the variance that is left at least: the waves of time of flight on right
/// cylinders explain as much now and then. Two planes must explain as much, too: docs/measurements-shapes.md, "Boxes".
const LEAST_GAIN: f64 = 1.0;

/// The root mean square of what the shape explains as a part of the radius. Those waves have 1.9 % of it at most, bent pipes
/// 2.6 % and more, spheres 3.9 %.
const LEAST_PART: f64 = 0.02;

/// The statistic of the F-test by independent points beyond which a shape is no chance, and the fewest of these.
const SIGNIFICANT: f64 = 10.0;
const LEAST_INDEPENDENT: f64 = 20.0;

/// The part of the weight that every term has beside its points: those of a narrow arc tell some terms apart hardly.
const RIDGE: f64 = 1e-6;

type Terms = SVector<f64, TERMS>;

/// The distance of a point from the surface, and the terms there. The frame is that of the view.
fn terms(frame: &LocalFrame, point: &Vector3<f64>) -> (f64, Terms) {
    let Cylinder { axis, radius } = frame.cylinder;
    let from_axis = point - axis.point;
    let x = from_axis.dot(&axis.direction) / frame.unit;
    let (u, v) = (from_axis.dot(&frame.u), from_axis.dot(&frame.v));
    let from_middle = (u * u + v * v).sqrt();
    // On the axis every direction is as good.
    let (cos, sin) = if from_middle > 0.0 { (u / from_middle, v / from_middle) } else { (1.0, 0.0) };
    let square = x * x;
    (
        from_middle - radius,
        Terms::from([1.0, cos, sin, x * cos, x * sin, x, square, square * cos, square * sin]),
    )
}

/// Points of a cloud with their weights about a cylinder: Tukey's with a cutoff.
fn sample(cloud: &PointCloud, cylinder: &Cylinder, cutoff: f64) -> List<(f64, Vector3<f64>)> {
    let weighted = |&index: &usize| {
        let point = cloud.point(index);
        let part = cylinder.distance(&point) / cutoff;
        let root = (1.0 - part * part).max(0.0);
        (cloud.weight(index) * root * root, point)
    };
    // Of a column of an image any noise of depth lies in a plane.
    let points = spread(cloud.len(), SAMPLE);
    points.iter().map(weighted).filter(|(weight, _)| *weight > 0.0).collect()
}

/// A body that explains the distances of points from a cylinder.
struct Shape {
    coefficients: Terms,
    /// The variance that it explains and another cylinder does not, and what is left.
    explained: f64,
    left: f64,
}

impl Shape {
    /// By points with weights; `None` where they do not determine it.
    fn new(points: &[(f64, Vector3<f64>)], frame: &LocalFrame) -> Option<Self> {
        let mut normal = SMatrix::<f64, TERMS, TERMS>::zeros();
        let mut right = Terms::zeros();
        let (mut square, mut total) = (0.0, 0.0);
        for (weight, point) in points {
            let (distance, terms) = terms(frame, point);
            let weighted = terms * *weight;
            normal.ger(1.0, &weighted, &terms, 1.0);
            right += weighted * distance;
            square += weight * distance * distance;
            total += weight;
        }
        let lower = (normal + SMatrix::identity() * (RIDGE * total)).cholesky()?.unpack();
        // The squares of these are what one term after the other explains.
        let by_terms = lower.solve_lower_triangular(&right)?;
        let explained: f64 = by_terms.iter().skip(OF_CYLINDER).map(|part| part * part).sum();
        let left = (square - by_terms.norm_squared()).max(0.0);
        let coefficients = lower.tr_solve_lower_triangular(&by_terms)?;
        (total > 0.0).then(|| Self { coefficients, explained: explained / total, left: left / total })
    }
}

impl Data<'_> {
    /// Whether the points of a view lie on a body that is no cylinder.
    pub fn has_lack_of_fit(&self, frame: &LocalFrame, scales: &Scales) -> bool {
        let mut views = self.views.iter().zip(&scales.views);
        self.is_robust()
            && views.any(|(view, scales)| has_lack_of_fit(view, &frame.moved(&view.into_view), scales))
    }
}

fn has_lack_of_fit(view: &ViewData<'_>, frame: &LocalFrame, scales: &RobustScales) -> bool {
    let points = sample(&view.view.cloud, &frame.cylinder, TUKEY_EFFICIENT * scales.point);
    let Some(shape) = Shape::new(&points, frame) else { return false };
    let of_shape = Rival { explained: shape.explained, left: shape.left, numbers: TERMS as f64 };
    let beside_shape = |point: &Vector3<f64>| {
        let (distance, terms) = terms(frame, point);
        distance - terms.dot(&shape.coefficients)
    };
    of_shape.wins(view, frame, beside_shape) || is_box(view, frame, &points, shape.explained + shape.left)
}

/// Whether two planes along the axis explain the points better than the best cylinder near by, which leaves `variance`.
fn is_box(view: &ViewData<'_>, frame: &LocalFrame, points: &[(f64, Vector3<f64>)], variance: f64) -> bool {
    // Most cylinders leave less.
    if !(variance >= least_explained(frame)) {
        return false;
    }
    let axis = frame.cylinder.axis;
    let towards: Vector3<f64> =
        points.iter().map(|(weight, point)| (point - axis.nearest_to(point)) * *weight).sum();
    let Some(towards) = towards.try_normalize(0.0) else { return false };
    let across = axis.direction.cross(&towards);
    let in_frame = |point: &Vector3<f64>| {
        let offset = point - axis.point;
        Vector3::new(offset.dot(&axis.direction), offset.dot(&across), offset.dot(&towards))
    };
    let weighted: List<Weighted> = points
        .iter()
        .map(|(weight, point)| Weighted { weight: *weight, position: in_frame(point) })
        .collect();
    let Some((planes, left)) = TwoPlanes::new(&weighted) else { return false };
    let rival = Rival { explained: variance - left, left, numbers: TwoPlanes::NUMBERS };
    rival.wins(view, frame, |point| planes.distance(&in_frame(point)))
}

/// The variance that another body explains at least.
fn least_explained(frame: &LocalFrame) -> f64 {
    (LEAST_PART * frame.cylinder.radius).powi(2)
}

/// Another body than a cylinder.
struct Rival {
    /// The variance that it explains and a cylinder does not, and what is left.
    explained: f64,
    left: f64,
    /// How many numbers the points determine.
    numbers: f64,
}

impl Rival {
    /// Whether it explains the points of a view better, by much and by no chance: an F-test. `beside` is the distance of a point from it.
    fn wins(&self, view: &ViewData<'_>, frame: &LocalFrame, beside: impl Fn(&Vector3<f64>) -> f64) -> bool {
        let Self { explained, left, numbers } = *self;
        if !(explained >= LEAST_GAIN * left && explained >= least_explained(frame)) {
            return false;
        }
        // Where a cylinder is wrong, what it leaves passes for correlated noise: what is left beside the other body tells how
        // many points are independent.
        let residuals: List<f64> = view.neighbours.cloud(view).points().map(|point| beside(&point)).collect();
        let cutoff = TUKEY_EFFICIENT * left.sqrt();
        let independent = view.neighbours.independent_points(view, frame, &residuals, cutoff);
        let [freed, freedom] = [numbers - OF_CYLINDER as f64, independent - numbers];
        independent >= LEAST_INDEPENDENT && explained / freed > SIGNIFICANT * left / freedom
    }
}
