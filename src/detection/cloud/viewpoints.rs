//! From where a cloud is looked at.

use super::{Asked, BETWEEN_QUESTIONS, Cloud, is_in_front};
use crate::error::Result;
use crate::statistics::median;
use nalgebra::{Matrix3, Vector3};
use pulp::Arch;

/// The rays of a cloud lie within this slope about the z axis where its origin is that of a camera.
const WIDEST: f64 = 3.0;

/// What a place sees all around it is cut into the faces of a cube, five degrees wider to each side.
const WIDEST_OF_FACE: f64 = 1.19;

/// Nearly all points.
const NEARLY_ALL: f64 = 0.98;

/// What a viewpoint is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// The origin, nearly all points being in front of a camera there.
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
    /// From a place along a direction.
    fn new(origin: Vector3<f64>, z: &Vector3<f64>, widest: f64, kind: Kind) -> Self {
        let (x, y) = crate::geometry::any_orthogonal(z);
        Self {
            rotation: Matrix3::from_rows(&[x.transpose(), y.transpose(), z.transpose()]),
            origin,
            widest,
            kind,
        }
    }

    /// Whether it is the origin.
    pub fn is_origin(&self) -> bool {
        self.kind != Kind::Elsewhere
    }

    /// Whether the points are in its frame of reference already.
    pub fn is_sensor(&self) -> bool {
        self.kind == Kind::Sensor
    }

    /// The coordinates of a point for it.
    pub fn turn(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * (point - self.origin)
    }
}

/// From the origin: along the z axis where nearly all points lie in front of a camera there, else towards the points where they lie about one
/// direction, else to all sides.
pub(super) fn of_origin(points: &Cloud) -> Vec<Viewpoint> {
    let origin = Vector3::zeros();
    let enough = |count: u32| f64::from(count) >= NEARLY_ALL * points.usable as f64;
    let [x, y, z] = &points.axes;
    let in_front = || {
        let rays = x.iter().zip(y).zip(z);
        rays.map(|((x, y), z)| u32::from(is_in_front(*x, *y, *z, WIDEST))).sum::<u32>()
    };
    if enough(Arch::new().dispatch(in_front)) {
        let rotation = Matrix3::identity();
        return vec![Viewpoint { rotation, origin, widest: WIDEST, kind: Kind::Sensor }];
    }
    let towards = points.usable().filter_map(|p| p.try_normalize(0.0)).sum::<Vector3<f64>>();
    if let Some(towards) = towards.try_normalize(0.0) {
        let viewpoint = Viewpoint::new(origin, &towards, WIDEST, Kind::Origin);
        let in_front = points.usable().map(|p| {
            let p = viewpoint.turn(&p);
            u32::from(is_in_front(p.x, p.y, p.z, WIDEST))
        });
        if enough(in_front.sum()) {
            return vec![viewpoint];
        }
    }
    let direction = |k: usize| Vector3::ith(k / 2, if k.is_multiple_of(2) { 1.0 } else { -1.0 });
    (0..6).map(|k| Viewpoint::new(origin, &direction(k), WIDEST_OF_FACE, Kind::Origin)).collect()
}

/// From far away along the principal directions of the spread of the points, that of the least first, from both sides.
pub(super) fn from_all_sides(points: &Cloud, asked: &Asked<'_>) -> Result<Vec<Viewpoint>> {
    let mut middle = Vector3::zeros();
    for axis in 0..3 {
        let mut values: Vec<f64> = points.usable().map(|p| p[axis]).collect();
        asked()?;
        middle[axis] = median(&mut values);
        asked()?;
    }
    let mut spread = Matrix3::zeros();
    let mut distances: Vec<f64> = Vec::with_capacity(points.usable);
    for (k, point) in points.usable().enumerate() {
        if k % BETWEEN_QUESTIONS == 0 {
            asked()?;
        }
        let offset = point - middle;
        // Far points count as near ones: directions alone.
        let norm = offset.norm();
        distances.push(norm);
        if norm > 0.0 {
            spread += offset * offset.transpose() / norm;
        }
    }
    asked()?;
    let size = median(&mut distances);
    if size <= 0.0 {
        return Ok(Vec::new());
    }
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
    Ok(viewpoints)
}
