//! Bare clouds: seen again as an image from where they were measured.

use super::grid::{Grid, side_of_cells};
use super::search::{label, search};
use super::{DetectionOptions, Detections};
use crate::error::{Error, Result};
use crate::geometry::{Cylinder, Line};
use crate::observations::PointsView;
use crate::statistics::median;
use nalgebra::{Matrix3, Matrix3x4, SMatrix, SVector, Vector3};

/// Pixels of the image of a cloud, at most.
const MOST_PIXELS: f64 = 2e6;

/// The rays of a cloud lie within this slope about the z axis where its origin is that of a camera.
const WIDEST: f64 = 3.0;

/// Cells of a cloud take this many pixels to each side at least: with a point to a pixel, one in three is empty.
const LEAST_SIDE: usize = 3;

/// Fewest points.
const FEWEST: usize = 50;

/// What stands for a point that is not known.
const UNKNOWN: Vector3<f64> = Vector3::new(f64::NAN, f64::NAN, f64::NAN);

/// A part of the points that may lie anywhere: single ones far away must not make the image wide.
const STRAY: f64 = 0.002;

/// Points that the camera of an organised cloud is computed from, at most.
const RESECTED: usize = 5000;

/// How far a point of an organised cloud is from its pixel as the camera sees it, root mean square in pixels: single
/// precision leaves a hundredth.
const RESECTION_ERROR: f64 = 0.5;

/// The part of the points that lie behind others as seen from a sensor: next to steps only.
const BEHIND: f64 = 0.1;

/// The camera that a cloud is seen from: x_camera = R (x − origin).
struct Viewpoint {
    rotation: Matrix3<f64>,
    origin: Vector3<f64>,
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
    for row in 0..view.height() {
        for column in 0..view.width() {
            let point = view.points.at(column, row);
            let known = point.iter().all(|x| x.is_finite()) && view.weight(column, row) > 0.0;
            points.push(if known { point } else { UNKNOWN });
        }
    }
    let nothing = || Detections { labels: vec![0; count], ..Detections::default() };
    let Some((viewpoint, image)) = seen(&mut points, (view.width(), view.height())) else {
        return Ok(nothing());
    };
    let cone = options
        .limits
        .axis
        .map(|cone| crate::geometry::AxisCone { direction: viewpoint.rotation * cone.direction, ..cone });
    let mut turned = *options;
    turned.limits.axis = cone;
    let size = (image.width, image.height);
    let point = |x: usize, y: usize| {
        let k = image.nearest[y * image.width + x];
        (k != u32::MAX).then(|| points[k as usize])
    };
    let side = side_of_cells(size).max(LEAST_SIDE);
    let mut grid = Grid::new(size, image.spacing, side, &point);
    let found = search(&mut grid, image.spacing, None, &turned, stopped)?;
    let ray = |x: usize, y: usize| {
        let place = |k: usize, low: f64| low + (k as f64 + 0.5) * image.spacing;
        Some(Vector3::new(place(x, image.low[0]), place(y, image.low[1]), 1.0))
    };
    let seen = label(&grid, &found, size, image.spacing, &point, &ray);
    let mut labels = vec![0; count];
    for (label, point) in labels.iter_mut().zip(&points) {
        let Some(pixel) = image.pixel(point) else { continue };
        // Points behind the one that is seen belong to something else.
        if !image.hides(pixel, point, &points) {
            *label = seen.labels[pixel];
        }
    }
    let mut cylinders = seen.cylinders;
    for (index, detection) in cylinders.iter_mut().enumerate() {
        let Cylinder { axis, radius } = detection.cylinder;
        let back = viewpoint.rotation.transpose();
        let axis = Line { point: back * axis.point + viewpoint.origin, direction: back * axis.direction };
        detection.cylinder = Cylinder { axis, radius };
        detection.pixels = labels.iter().filter(|&&label| usize::from(label) == index + 1).count();
    }
    Ok(Detections { cylinders, labels, image: None })
}

/// Moves points into the frame of the camera that they are seen from, and makes an image of them.
fn seen(points: &mut [Vector3<f64>], size: (usize, usize)) -> Option<(Viewpoint, Image)> {
    if usable(points).count() < FEWEST {
        return None;
    }
    let sure = resection(points, size).or_else(|| along_z(points));
    if let Some(viewpoint) = sure {
        viewpoint.turn(points);
        return Some((viewpoint, Image::new(points)?));
    }
    if let Some(viewpoint) = about_origin(points) {
        viewpoint.turn(points);
        match Image::new(points) {
            Some(image) if image.hidden(points) < BEHIND => return Some((viewpoint, image)),
            _ => points.iter_mut().for_each(|p| *p = viewpoint.rotation.transpose() * *p),
        }
    }
    let viewpoint = from_afar(points)?;
    viewpoint.turn(points);
    Some((viewpoint, Image::new(points)?))
}

fn usable(points: &[Vector3<f64>]) -> impl Iterator<Item = &Vector3<f64>> + Clone {
    points.iter().filter(|p| !p.x.is_nan())
}

/// Axes with this direction of z.
fn axes(z: &Vector3<f64>) -> Matrix3<f64> {
    let (x, y) = crate::geometry::any_orthogonal(z);
    Matrix3::from_rows(&[x.transpose(), y.transpose(), z.transpose()])
}

impl Viewpoint {
    fn turn(&self, points: &mut [Vector3<f64>]) {
        points.iter_mut().for_each(|p| *p = self.rotation * (*p - self.origin));
    }
}

/// Whether a camera at the origin that looks along z has nearly all points in front of it.
fn in_front<'a>(points: impl Iterator<Item = &'a Vector3<f64>> + Clone) -> bool {
    let seen = |p: &&Vector3<f64>| p.z > 0.0 && p.x.abs().max(p.y.abs()) <= WIDEST * p.z;
    points.clone().filter(seen).count() as f64 >= 0.98 * points.count() as f64
}

/// The camera of an organised cloud, by the direct linear transform (Hartley and Zisserman, "Multiple View Geometry in
/// Computer Vision", 2nd ed., 7.1): `None` where its columns and rows are not the pixels of one.
fn resection(points: &[Vector3<f64>], (width, height): (usize, usize)) -> Option<Viewpoint> {
    if width < 2 || height < 2 {
        return None;
    }
    let stride = (usable(points).count() / RESECTED).max(1);
    let known = points.iter().enumerate().filter(|(_, p)| !p.x.is_nan());
    let chosen: Vec<(usize, &Vector3<f64>)> = known.step_by(stride).collect();
    let count = chosen.len() as f64;
    let middle = chosen.iter().map(|(_, p)| *p).sum::<Vector3<f64>>() / count;
    let size = (chosen.iter().map(|(_, p)| (*p - middle).norm_squared()).sum::<f64>() / count).sqrt();
    // Pixels and points in units of about one.
    let place = |k: usize| {
        let half = 0.5 * width as f64;
        [(k % width) as f64 / half - 1.0, ((k / width) as f64 - 0.5 * height as f64) / half]
    };
    let mut matrix = SMatrix::<f64, 12, 12>::zeros();
    let homogeneous = |p: &Vector3<f64>| ((p - middle) / size).push(1.0);
    for (k, p) in &chosen {
        let x = homogeneous(p);
        for (axis, value) in place(*k).into_iter().enumerate() {
            let mut row = SVector::<f64, 12>::zeros();
            row.fixed_rows_mut::<4>(4 * axis).copy_from(&x);
            row.fixed_rows_mut::<4>(8).copy_from(&(-value * x));
            matrix += row * row.transpose();
        }
    }
    let eigen = matrix.symmetric_eigen();
    let least = eigen.eigenvectors.column(eigen.eigenvalues.imin());
    let camera = Matrix3x4::from_fn(|row, column| least[4 * row + column]);
    let mut squares = 0.0;
    for (k, p) in &chosen {
        let seen = camera * homogeneous(p);
        let [u, v] = place(*k);
        squares += (seen.x / seen.z - u).powi(2) + (seen.y / seen.z - v).powi(2);
    }
    // False where it is not finite.
    let fits = (squares / count).sqrt() * 0.5 * width as f64 <= RESECTION_ERROR;
    let turn: Matrix3<f64> = camera.fixed_columns::<3>(0).into_owned();
    let origin = middle - turn.try_inverse()? * camera.column(3) * size;
    let z = turn.row(2).transpose().normalize();
    let z = if z.dot(&(middle - origin)) < 0.0 { -z } else { z };
    let x = turn.row(0).transpose();
    let x = (x - z * z.dot(&x)).try_normalize(0.0)?;
    let rotation = Matrix3::from_rows(&[x.transpose(), z.cross(&x).transpose(), z.transpose()]);
    let moved: Vec<Vector3<f64>> = chosen.iter().map(|(_, p)| rotation * (*p - origin)).collect();
    (fits && in_front(moved.iter())).then_some(Viewpoint { rotation, origin })
}

/// The origin and the z axis, where nearly all points lie in front of a camera there.
fn along_z(points: &[Vector3<f64>]) -> Option<Viewpoint> {
    let viewpoint = Viewpoint { rotation: Matrix3::identity(), origin: Vector3::zeros() };
    in_front(usable(points)).then_some(viewpoint)
}

/// The origin and the direction to the points, where nearly all lie in front of a camera there.
fn about_origin(points: &[Vector3<f64>]) -> Option<Viewpoint> {
    let z = usable(points).filter_map(|p| p.try_normalize(0.0)).sum::<Vector3<f64>>().try_normalize(0.0)?;
    let rotation = axes(&z);
    let moved: Vec<Vector3<f64>> =
        usable(points).step_by((points.len() / RESECTED).max(1)).map(|p| rotation * p).collect();
    in_front(moved.iter()).then_some(Viewpoint { rotation, origin: Vector3::zeros() })
}

/// A place far from the points in the direction in which they spread least.
fn from_afar(points: &[Vector3<f64>]) -> Option<Viewpoint> {
    let middle = Vector3::from_fn(|axis, _| {
        let mut values: Vec<f64> = usable(points).map(|p| p[axis]).collect();
        median(&mut values)
    });
    let mut spread = Matrix3::zeros();
    let mut distances: Vec<f64> = Vec::new();
    for p in usable(points) {
        let offset = p - middle;
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
    (size > 0.0).then(|| Viewpoint { rotation: axes(&z), origin: middle - z * (10.0 * size) })
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
    fn new(points: &[Vector3<f64>]) -> Option<Self> {
        let count = usable(points).count();
        let mut range = [[0.0; 2]; 2];
        for (axis, range) in range.iter_mut().enumerate() {
            let mut values: Vec<f64> = Vec::new();
            values.try_reserve_exact(count).ok()?;
            values.extend(
                usable(points)
                    .filter(|p| p.z > 0.0 && p.x.abs().max(p.y.abs()) <= WIDEST * p.z)
                    .map(|p| p[axis] / p.z),
            );
            if values.len() < FEWEST {
                return None;
            }
            let stray = (STRAY * values.len() as f64) as usize;
            let last = values.len() - 1 - stray;
            let low = *values.select_nth_unstable_by(stray, f64::total_cmp).1;
            let high = *values.select_nth_unstable_by(last, f64::total_cmp).1;
            *range = [low, high];
        }
        let [width, height] = range.map(|[low, high]| high - low);
        // As many pixels as points, over the part of the image that has any.
        let pixels = (count as f64).min(MOST_PIXELS);
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
        for (k, p) in points.iter().enumerate() {
            if let Some(pixel) = image.pixel(p) {
                let before = image.nearest[pixel];
                if before == u32::MAX || p.z < points[before as usize].z {
                    image.nearest[pixel] = k as u32;
                }
            }
        }
        Some(image)
    }

    /// Whether a point in a pixel lies behind the one that is seen there, by more than a pixel is wide.
    fn hides(&self, pixel: usize, p: &Vector3<f64>, points: &[Vector3<f64>]) -> bool {
        let depth = points[self.nearest[pixel] as usize].z;
        p.z - depth > 2.0 * self.spacing * depth
    }

    /// The part of the points that is hidden by others.
    fn hidden(&self, points: &[Vector3<f64>]) -> f64 {
        let hidden = |p: &&Vector3<f64>| self.pixel(p).is_some_and(|pixel| self.hides(pixel, p, points));
        usable(points).filter(hidden).count() as f64 / usable(points).count() as f64
    }

    fn pixel(&self, p: &Vector3<f64>) -> Option<usize> {
        // False for what is not known.
        if !(p.z > 0.0) {
            return None;
        }
        let x = ((p.x / p.z - self.low[0]) / self.spacing).floor();
        let y = ((p.y / p.z - self.low[1]) / self.spacing).floor();
        let inside = x >= 0.0 && y >= 0.0 && x < self.width as f64 && y < self.height as f64;
        inside.then(|| y as usize * self.width + x as usize)
    }
}
