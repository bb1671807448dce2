//! From where a cloud is looked at.

use super::image::count_in_front;
use super::points::{Points, Pose};
use crate::statistics::{median_absolute, median_point};
use nalgebra::{Matrix3, Vector3};

/// The rays of a cloud lie within this slope about the z axis where its origin is that of a camera.
const WIDEST: f64 = 3.0;

/// What a position sees all around it is cut into the faces of a cube, five degrees wider to each side.
const WIDEST_OF_FACE: f64 = 1.19;

/// Clouds that look smaller than this from their origin, by the tangent of half the angle, were not seen from there. Single precision
/// tells 10⁻⁷ of a distance, less than the noise of what was.
const NARROWEST: f64 = 1e-3;

constants! {
    /// Nearly all points.
    NEARLY_ALL = 0.98, "";
}

/// Points that tell in which directions others are spread.
const ENOUGH_DIRECTIONS: usize = 1024;

/// What a viewpoint is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// The position of a sensor, nearly all points being in front of a camera there.
    Sensor,
    /// The origin, in whatever direction.
    Origin,
    Elsewhere,
}

/// The camera that a cloud is seen from: x_camera = R (x − origin).
#[derive(Debug, Clone, Copy)]
pub(super) struct Viewpoint {
    pub rotation: Matrix3<f64>,
    pub origin: Vector3<f64>,
    /// The largest slope of its rays about the z axis.
    pub widest: f64,
    kind: Kind,
}

impl Viewpoint {
    /// The origin, along the z axis.
    const SENSOR: Self = Self {
        rotation: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        origin: Vector3::new(0.0, 0.0, 0.0),
        widest: WIDEST,
        kind: Kind::Sensor,
    };

    /// From a position along a direction.
    fn new(origin: Vector3<f64>, z: &Vector3<f64>, widest: f64, kind: Kind) -> Self {
        let (x, y) = crate::geometry::any_orthogonal(z);
        Self {
            rotation: Matrix3::from_rows(&[x.transpose(), y.transpose(), z.transpose()]),
            origin,
            widest,
            kind,
        }
    }

    /// Whether a sensor may have been there: in the origin, or where the points tell.
    pub fn may_be_sensor(&self) -> bool {
        self.kind != Kind::Elsewhere
    }

    /// Whether nearly all points lie in front of a camera there, which may have seen them all.
    pub fn is_sensor(&self) -> bool {
        self.kind == Kind::Sensor
    }

    /// Whether nearly all of some points lie in front of a camera there.
    fn has_before_it(&self, points: &Points) -> bool {
        let in_front = count_in_front(points, &self.pose(points), WIDEST);
        in_front as f64 >= NEARLY_ALL.get() * points.usable as f64
    }

    /// The pose of the camera at points.
    pub fn pose(&self, points: &Points) -> Pose {
        Pose { rotation: self.rotation, offset: self.rotation * (points.origin - self.origin) }
    }
}

/// The origin along the z axis, where nearly all points lie in front of a camera there.
pub(super) fn of_sensor(points: &Points) -> Option<Viewpoint> {
    Some(Viewpoint::SENSOR).filter(|sensor| sensor.has_before_it(points))
}

/// From the position of a sensor towards points with some middle, where nearly all lie in front of a camera there.
pub(super) fn of_sensor_at(
    position: &Vector3<f64>,
    points: &Points,
    middle: &Vector3<f64>,
) -> Option<Viewpoint> {
    let towards = (middle - position).try_normalize(0.0)?;
    Some(Viewpoint::new(*position, &towards, WIDEST, Kind::Sensor))
        .filter(|sensor| sensor.has_before_it(points))
}

/// From the origin: towards the points, some of which are given, where they lie about one direction, else to all sides.
pub(super) fn of_origin(points: &Points) -> Vec<Viewpoint> {
    let origin = Vector3::zeros();
    let usable = points.all_usable().map(|p| p + points.origin);
    let towards = usable.filter_map(|p| p.try_normalize(0.0)).sum::<Vector3<f64>>();
    if let Some(towards) = towards.try_normalize(0.0) {
        let viewpoint = Viewpoint::new(origin, &towards, WIDEST, Kind::Origin);
        if viewpoint.has_before_it(points) {
            return vec![viewpoint];
        }
    }
    let direction = |k: usize| Vector3::ith(k / 2, if k.is_multiple_of(2) { 1.0 } else { -1.0 });
    (0..6).map(|k| Viewpoint::new(origin, &direction(k), WIDEST_OF_FACE, Kind::Origin)).collect()
}

/// Some points, their middle, and how far from that they lie.
pub(super) fn middle_of_some(points: &Points) -> (Vec<Vector3<f64>>, Vector3<f64>, f64) {
    let step = points.usable.div_ceil(ENOUGH_DIRECTIONS).max(1);
    let some: Vec<Vector3<f64>> = points.all_usable().step_by(step).collect();
    let middle = median_point(&some);
    let size = median_absolute(some.iter().map(|point| (point - middle).norm()));
    (some, middle, size)
}

/// Whether points are so far from the origin of their cloud that nothing there has seen them, as in coordinates of a map: single
/// precision would not tell their rays apart.
pub(super) fn are_far(points: &Points) -> bool {
    let sample = points.sample();
    let (_, middle, size) = middle_of_some(sample.as_ref().unwrap_or(points));
    size < NARROWEST * (points.origin + middle).norm()
}

/// From far away along the principal directions of the spread of points, some of which are given, that of the least first, from both
/// sides.
pub(super) fn from_all_sides(points: &Points) -> Vec<Viewpoint> {
    let (some, middle, size) = middle_of_some(points);
    if size <= 0.0 {
        return Vec::new();
    }
    let mut spread = Matrix3::zeros();
    for offset in some.iter().map(|point| point - middle) {
        // Far points count as near ones: directions alone.
        let norm = offset.norm();
        if norm > 0.0 {
            spread += offset * offset.transpose() / norm;
        }
    }
    let middle = points.origin + middle;
    let eigen = spread.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
    let mut viewpoints = Vec::new();
    for axis in order {
        let z: Vector3<f64> = eigen.eigenvectors.column(axis).into();
        // Of the two sides that of the origin first, where the sensor most likely is.
        let z = if z.dot(&middle) < 0.0 { -z } else { z };
        for z in [z, -z] {
            viewpoints.push(Viewpoint::new(middle - z * (10.0 * size), &z, WIDEST, Kind::Elsewhere));
        }
    }
    viewpoints
}
