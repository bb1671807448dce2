//! From where and how finely a cloud is looked at.

use super::super::grid::side_of_cells;
use super::{Cloud, FEWEST, is_in_front};
use crate::statistics::median;
use nalgebra::{Matrix3, Vector3};
use pulp::Arch;

/// Cells of a cloud take this many pixels to each side at least: with a point to a pixel, one in three is empty.
pub(super) const LEAST_SIDE: usize = 3;

/// Where an image has fewer cells than this, a body may have too few to be seen as one, and finer ones are looked at, too.
const FEW_CELLS: usize = 4_000;

/// One look at a cloud. Of a sparse one, and of one that no sensor in the origin has seen, there are several; a later one is for clouds in
/// which those before find nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Look {
    /// The principal direction of the spread of the points along which they are seen, that of the least is 0.
    pub(super) direction: usize,
    /// Pixels along the side of a cell at least.
    side: usize,
}

impl Look {
    /// The look that each cloud has.
    pub const FIRST: Self = Self { direction: 0, side: LEAST_SIDE };

    /// Pixels along the side of a cell of an image of some size.
    pub(super) fn side_of_cells(self, size: (usize, usize)) -> usize {
        if self.side < LEAST_SIDE { self.side } else { side_of_cells(size, f64::INFINITY).max(LEAST_SIDE) }
    }

    /// The look after this one, which shows an image of some size: at finer cells, where these are few, or from elsewhere.
    pub(super) fn next(self, (width, height): (usize, usize), viewpoint: &Viewpoint) -> Option<Self> {
        let finer = self.side > 1 && width * height < FEW_CELLS * self.side * self.side;
        if finer { Some(Self { side: self.side - 1, ..self }) } else { self.elsewhere(viewpoint) }
    }

    /// The first look along the next direction; `None` where a sensor has seen the cloud, or there is no other direction.
    pub(super) fn elsewhere(self, viewpoint: &Viewpoint) -> Option<Self> {
        let direction = self.direction + 1;
        (direction < 3 && !viewpoint.of_sensor).then_some(Self { direction, ..Self::FIRST })
    }
}

/// The camera that a cloud is seen from: x_camera = R (x − origin).
pub(super) struct Viewpoint {
    pub rotation: Matrix3<f64>,
    pub origin: Vector3<f64>,
    /// Whether it is that of the sensor.
    pub of_sensor: bool,
}

/// The origin and the z axis, where nearly all points lie in front of a camera there; else a place far from the points in one of the
/// principal directions of their spread, that of the least first. `None` for too few points.
pub(super) fn viewpoint(points: &Cloud, direction: usize) -> Option<Viewpoint> {
    if points.usable < FEWEST {
        return None;
    }
    let [x, y, z] = &points.axes;
    let seen = || {
        let rays = x.iter().zip(y).zip(z);
        rays.map(|((x, y), z)| u32::from(is_in_front(*x, *y, *z))).sum::<u32>()
    };
    if f64::from(Arch::new().dispatch(seen)) >= 0.98 * points.usable as f64 {
        let of_sensor =
            Viewpoint { rotation: Matrix3::identity(), origin: Vector3::zeros(), of_sensor: true };
        return (direction == 0).then_some(of_sensor);
    }
    let middle = Vector3::from_fn(|axis, _| {
        let mut values: Vec<f64> = points.usable().map(|p| p[axis]).collect();
        median(&mut values)
    });
    let mut spread = Matrix3::zeros();
    let mut distances: Vec<f64> = Vec::with_capacity(points.usable);
    for point in points.usable() {
        let offset = point - middle;
        // Far points count as near ones: directions alone.
        let norm = offset.norm();
        distances.push(norm);
        if norm > 0.0 {
            spread += offset * offset.transpose() / norm;
        }
    }
    let size = median(&mut distances);
    let eigen = spread.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
    let mut z: Vector3<f64> = eigen.eigenvectors.column(order[direction]).into();
    // Of the two sides that of the origin, where the sensor most likely is.
    if z.dot(&middle) < 0.0 {
        z = -z;
    }
    let (x, y) = crate::geometry::any_orthogonal(&z);
    let rotation = Matrix3::from_rows(&[x.transpose(), y.transpose(), z.transpose()]);
    (size > 0.0).then(|| Viewpoint { rotation, origin: middle - z * (10.0 * size), of_sensor: false })
}
