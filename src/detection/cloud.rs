//! Bare clouds: seen again as an image from where they were measured.

use super::effort::Effort;
use super::grid::{Grid, side_of_cells};
use super::labels::{count_pixels, label};
use super::search::search;
use super::{DetectionOptions, Detections, row};
use crate::error::{Error, Result};
use crate::geometry::{Cylinder, Line};
use crate::memory::List;
use crate::observations::PointsView;
use crate::statistics::median;
use nalgebra::{Matrix3, Vector3};
use std::ops::Range;

/// Pixels of the image of a cloud, at most.
const MOST_PIXELS: f64 = 2e6;

/// The rays of a cloud lie within this slope about the z axis where its origin is that of a camera.
const WIDEST: f64 = 3.0;

/// Cells of a cloud take this many pixels to each side at least: with a point to a pixel, one in three is empty.
const LEAST_SIDE: usize = 3;

/// A part of the points that may lie anywhere: single ones far away must not make the image wide.
const STRAY: f64 = 0.002;

/// The camera that a cloud is seen from: x_camera = R (x − origin).
struct Viewpoint {
    rotation: Matrix3<f64>,
    origin: Vector3<f64>,
    /// Whether it is that of the sensor.
    of_sensor: bool,
}

/// Finds all cylinders in a cloud; labels are by point, row by row.
///
/// # Errors
/// `InvalidArgument`, `OutOfMemory`.
pub fn detect_points(view: &PointsView<'_>, options: &DetectionOptions) -> Result<Detections> {
    detect_points_until(view, options, &|| false)
}

/// The same, until `stopped` says so.
///
/// # Errors
/// Those of [`detect_points`], and `Cancelled`.
pub(crate) fn detect_points_until(
    view: &PointsView<'_>,
    options: &DetectionOptions,
    stopped: &dyn Fn() -> bool,
) -> Result<Detections> {
    options.check()?;
    let count = view.width() * view.height();
    let mut points: Vec<Vector3<f64>> = Vec::new();
    let bytes = count * size_of::<Vector3<f64>>();
    points.try_reserve_exact(count).map_err(|_| Error::OutOfMemory { what: "the points", bytes })?;
    let mut usable = Vec::new();
    for row in 0..view.height() {
        for column in 0..view.width() {
            let point = view.points.at(column, row);
            let known = point.iter().all(|x| x.is_finite()) && view.weight(column, row) > 0.0;
            if known {
                usable.push(points.len());
            }
            points.push(point);
        }
    }
    let nothing = || Detections { labels: vec![0; count], ..Detections::default() };
    let cancelled = || if stopped() { Err(Error::Cancelled { iterations: 0 }) } else { Ok(()) };
    cancelled()?;
    let Some(viewpoint) = viewpoint(&points, &usable) else { return Ok(nothing()) };
    if !viewpoint.of_sensor {
        for &k in &usable {
            points[k] = viewpoint.rotation * (points[k] - viewpoint.origin);
        }
    }
    cancelled()?;
    let Some(image) = Image::new(&points, &usable) else { return Ok(nothing()) };
    let cone = options
        .limits
        .axis
        .map(|cone| crate::geometry::AxisCone { direction: viewpoint.rotation * cone.direction, ..cone });
    let mut turned = *options;
    turned.limits.axis = cone;
    let size = (image.width, image.height);
    let read_points = |row: usize, columns: Range<usize>, list: &mut [List<f64>; 3]| {
        row::write(columns, list, |column| {
            let k = image.nearest[row * image.width + column];
            if k == u32::MAX { [0.0; 3] } else { points[k as usize].into() }
        });
    };
    let side = side_of_cells(size, f64::INFINITY).max(LEAST_SIDE);
    cancelled()?;
    let mut grid = Grid::new(size, image.spacing, side, &read_points);
    cancelled()?;
    let effort = Effort::new(stopped);
    let found = search(&mut grid, image.spacing, None, &turned, &effort)?;
    let read_rays = |row: usize, columns: Range<usize>, list: &mut [List<f64>; 2]| {
        let place = |k: usize, low: f64| low + (k as f64 + 0.5) * image.spacing;
        row::write(columns, list, |column| [place(column, image.low[0]), place(row, image.low[1])]);
    };
    let seen = label(&grid, &found, size, image.spacing, &read_points, &read_rays, &effort);
    let mut labels = vec![0; count];
    for &k in &usable {
        let Some(pixel) = image.pixel(&points[k]) else { continue };
        let near = image.nearest[pixel];
        // Points behind the one that is seen belong to something else, unless they are as near as a pixel is wide.
        let depth = points[near as usize].z;
        if points[k].z - depth <= 2.0 * image.spacing * depth {
            labels[k] = seen.labels[pixel];
        }
    }
    let mut cylinders = seen.cylinders;
    for detection in &mut cylinders {
        let Cylinder { axis, radius } = detection.cylinder;
        let back = viewpoint.rotation.transpose();
        let axis = Line { point: back * axis.point + viewpoint.origin, direction: back * axis.direction };
        detection.cylinder = Cylinder { axis, radius };
    }
    count_pixels(&mut cylinders, &labels);
    Ok(Detections { cylinders, labels, from_origin: viewpoint.of_sensor, ..seen })
}

/// The origin and the z axis, where nearly all points lie in front of a camera there; else a place far from the points
/// in the direction in which they spread least.
fn viewpoint(points: &[Vector3<f64>], usable: &[usize]) -> Option<Viewpoint> {
    if usable.len() < 50 {
        return None;
    }
    let seen = |p: &Vector3<f64>| p.z > 0.0 && p.x.abs().max(p.y.abs()) <= WIDEST * p.z;
    let front = usable.iter().filter(|&&k| seen(&points[k])).count();
    if front as f64 >= 0.98 * usable.len() as f64 {
        return Some(Viewpoint { rotation: Matrix3::identity(), origin: Vector3::zeros(), of_sensor: true });
    }
    let middle = Vector3::from_fn(|axis, _| {
        let mut values: Vec<f64> = usable.iter().map(|&k| points[k][axis]).collect();
        median(&mut values)
    });
    let mut spread = Matrix3::zeros();
    let mut distances: Vec<f64> = Vec::with_capacity(usable.len());
    for &k in usable {
        let offset = points[k] - middle;
        // Far points count as near ones: directions alone.
        let norm = offset.norm();
        distances.push(norm);
        if norm > 0.0 {
            spread += offset * offset.transpose() / norm;
        }
    }
    let size = median(&mut distances);
    let eigen = spread.symmetric_eigen();
    let least = eigen.eigenvalues.imin();
    let mut z: Vector3<f64> = eigen.eigenvectors.column(least).into();
    // Of the two sides that of the origin, where the sensor most likely is.
    if z.dot(&middle) < 0.0 {
        z = -z;
    }
    let (x, y) = crate::geometry::any_orthogonal(&z);
    let rotation = Matrix3::from_rows(&[x.transpose(), y.transpose(), z.transpose()]);
    (size > 0.0).then(|| Viewpoint { rotation, origin: middle - z * (10.0 * size), of_sensor: false })
}

/// The numbers at two places of the order of many that are spread over some orders of magnitude.
fn in_order(numbers: &[f64], places: [usize; 2]) -> [f64; 2] {
    // They are ordered as their bits are, those below zero the other way round: counted by the upper quarter of these, then
    // looked for among those that share it.
    let upper = |number: &f64| {
        let bits = number.to_bits();
        let turned = if bits >> 63 == 0 { bits | 1 << 63 } else { !bits };
        (turned >> 48) as usize
    };
    let mut counts = vec![0_u32; 1 << 16];
    numbers.iter().for_each(|number| counts[upper(number)] += 1);
    places.map(|mut place| {
        let mut own = 0;
        while place >= counts[own] as usize {
            place -= counts[own] as usize;
            own += 1;
        }
        let mut alike = Vec::with_capacity(counts[own] as usize);
        alike.extend(numbers.iter().copied().filter(|number| upper(number) == own));
        *alike.select_nth_unstable_by(place, f64::total_cmp).1
    })
}

/// For each pixel on the plane z = 1 the point that is seen there.
struct Image {
    width: usize,
    height: usize,
    spacing: f64,
    low: [f64; 2],
    nearest: Vec<u32>,
}

impl Image {
    fn new(points: &[Vector3<f64>], usable: &[usize]) -> Option<Self> {
        let mut range = [[0.0; 2]; 2];
        for (axis, range) in range.iter_mut().enumerate() {
            let mut values = Vec::with_capacity(usable.len());
            for &k in usable {
                let p = &points[k];
                if p.z > 0.0 && p.x.abs().max(p.y.abs()) <= WIDEST * p.z {
                    values.push(p[axis] / p.z);
                }
            }
            if values.len() < 50 {
                return None;
            }
            let stray = (STRAY * values.len() as f64) as usize;
            *range = in_order(&values, [stray, values.len() - 1 - stray]);
        }
        let [width, height] = range.map(|[low, high]| high - low);
        // As many pixels as points, over the part of the image that has any.
        let pixels = (usable.len() as f64).min(MOST_PIXELS);
        let spacing = (width * height / pixels).sqrt();
        if !(spacing > 0.0 && spacing.is_finite() && width.max(height) / spacing < 1e4) {
            return None;
        }
        let mut image = Self {
            width: (width / spacing) as usize + 1,
            height: (height / spacing) as usize + 1,
            spacing,
            low: [range[0][0], range[1][0]],
            nearest: Vec::new(),
        };
        image.nearest = vec![u32::MAX; image.width * image.height];
        for &k in usable {
            if let Some(pixel) = image.pixel(&points[k]) {
                let before = image.nearest[pixel];
                if before == u32::MAX || points[k].z < points[before as usize].z {
                    image.nearest[pixel] = k as u32;
                }
            }
        }
        Some(image)
    }

    fn pixel(&self, p: &Vector3<f64>) -> Option<usize> {
        if p.z <= 0.0 {
            return None;
        }
        let x = (p.x / p.z - self.low[0]) / self.spacing;
        let y = (p.y / p.z - self.low[1]) / self.spacing;
        let inside = x >= 0.0 && y >= 0.0 && x < self.width as f64 && y < self.height as f64;
        inside.then(|| y as usize * self.width + x as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_found_by_their_place() {
        let numbers: Vec<f64> = (0..1000).map(|k| f64::from(k * 7919 % 1009) * 0.003 - 1.5).collect();
        let mut sorted = numbers.clone();
        sorted.sort_by(f64::total_cmp);
        for places in [[0, 999], [2, 997], [499, 501], [505, 505]] {
            assert_eq!(in_order(&numbers, places), places.map(|place| sorted[place]));
        }
    }
}
