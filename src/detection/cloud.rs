//! Bare clouds: seen again as an image from where they were measured.

mod cubes;
mod hidden;
mod looks;
mod members;
mod tiles;
mod viewpoints;

use super::effort::Effort;
use super::grid::Grid;
use super::labels::{count_pixels, label};
use super::search::{Limbs, search};
use super::{DetectionOptions, Detections, row};
use crate::error::{Error, Result, cancelled_if};
use crate::geometry::{Cylinder, Line};
use crate::memory::List;
use crate::observations::PointsView;
use crate::statistics::at_both_ends;
pub(crate) use looks::Looks;
pub(crate) use members::reach;
use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

/// Pixels of the image of a cloud, at most.
const MOST_PIXELS: f64 = 2e6;

/// A part of the points that may lie anywhere: single ones far away must not make the image wide.
const STRAY: f64 = 0.002;

/// Where less than this part of the points is seen, there is another wall behind, and the image has a pixel to each of those that are.
const MOSTLY_SEEN: f64 = 0.75;

/// Fewest points of a cloud.
const FEWEST: usize = 50;

/// Points that are gone through between two questions whether to go on: some milliseconds.
const BETWEEN_QUESTIONS: usize = 1 << 18;

/// An error when the search is to stop.
type Asked<'a> = dyn Fn() -> Result<()> + 'a;

/// The pixel of a point that has none.
const OUTSIDE: u32 = u32::MAX;

/// Finds all cylinders by the present look at the points of a cloud that are not `taken`, until `stopped` says so; labels are by point of the
/// part that is looked at. None where there is nothing to look at.
///
/// # Errors
/// `InvalidArgument`, `OutOfMemory`, `Cancelled`.
pub(crate) fn detect_points_until(
    view: &PointsView<'_>,
    taken: &[u16],
    looks: &mut Looks,
    options: &DetectionOptions,
    stopped: &dyn Fn() -> bool,
) -> Result<Option<Detections>> {
    options.check()?;
    let cancelled = || cancelled_if(stopped());
    if !looks.prepare(view, &cancelled)? {
        return Ok(None);
    }
    let mut points = Cloud::read(view, looks.part(), taken, &cancelled)?;
    cancelled()?;
    let Some(viewpoint) = looks.viewpoint(&points, &cancelled)? else { return Ok(None) };
    if !viewpoint.is_sensor() {
        points.turn(|p| viewpoint.turn(&p));
    }
    cancelled()?;
    let Some(image) = Image::of(&points, viewpoint.widest, &cancelled)? else { return Ok(None) };
    let cone = options
        .limits
        .axis
        .map(|cone| crate::geometry::AxisCone { direction: viewpoint.rotation * cone.direction, ..cone });
    let mut turned = *options;
    turned.limits.axis = cone;
    let size = (image.width, image.height);
    let read_points = |row: usize, columns: Range<usize>, list: &mut [List<f64>; 3]| {
        let first = row * image.width;
        let nearest = &image.nearest[first + columns.start..first + columns.end];
        for (list, axis) in list.iter_mut().zip(&points.axes) {
            list.clear();
            list.extend(nearest.iter().map(|&k| axis[k as usize]));
        }
    };
    cancelled()?;
    let mut grid = Grid::new(size, image.spacing, looks.side_of_cells(size), &read_points);
    cancelled()?;
    let effort = Effort::new(stopped);
    let found = search(&mut grid, image.spacing, &Limbs::None, &turned, &effort)?.cylinders;
    let read_rays = |row: usize, columns: Range<usize>, list: &mut [List<f64>; 2]| {
        let place = |k: usize, low: f64| low + (k as f64 + 0.5) * image.spacing;
        row::write(columns, list, |column| [place(column, image.low[0]), place(row, image.low[1])]);
    };
    let seen = label(&grid, &found, size, image.spacing, &read_points, &read_rays, &effort);
    let labels = members::labels(&points, &image, &seen, &cancelled)?;
    let mut cylinders = seen.cylinders;
    for detection in &mut cylinders {
        let Cylinder { axis, radius } = detection.cylinder;
        let back = viewpoint.rotation.transpose();
        let axis = Line { point: back * axis.point + viewpoint.origin, direction: back * axis.direction };
        detection.cylinder = Cylinder { axis, radius };
    }
    count_pixels(&mut cylinders, &labels);
    looks.note(size, image.closed, &points, &cancelled)?;
    let from_origin = viewpoint.is_origin() && !image.closed;
    let whole = viewpoint.is_sensor() && !image.closed;
    if !whole && !cylinders.is_empty() {
        looks.place(view, &cancelled)?;
    }
    Ok(Some(Detections { cylinders, labels, from_origin, whole, ..seen }))
}

/// The coordinates of points, axis by axis: not numbers for those of no use, and at the end a point of zeros, which stands for none.
struct Cloud {
    axes: [Vec<f64>; 3],
    usable: usize,
}

impl Cloud {
    /// The points of a part, of all without one, that are not taken.
    fn read(view: &PointsView<'_>, part: Option<&[u32]>, taken: &[u16], asked: &Asked<'_>) -> Result<Self> {
        let mut cloud = Self { axes: Default::default(), usable: 0 };
        let count = part.map_or(view.width() * view.height(), <[u32]>::len);
        for axis in &mut cloud.axes {
            let bytes = (count + 1) * size_of::<Vector3<f64>>();
            axis.try_reserve_exact(count + 1)
                .map_err(|_| Error::OutOfMemory { what: "the points", bytes })?;
        }
        for first in (0..count).step_by(BETWEEN_QUESTIONS) {
            for k in first..count.min(first + BETWEEN_QUESTIONS) {
                let number = part.map_or(k, |part| part[k] as usize);
                let (column, row) = (number % view.width(), number / view.width());
                let mut point = view.points.at(column, row);
                if taken[number] == 0 && point.iter().all(|x| x.is_finite()) && view.weight(column, row) > 0.0
                {
                    cloud.usable += 1;
                } else {
                    point.fill(f64::NAN);
                }
                cloud.push(&point);
            }
            asked()?;
        }
        cloud.push(&Vector3::zeros());
        Ok(cloud)
    }

    fn push(&mut self, point: &Vector3<f64>) {
        self.axes.iter_mut().zip(point).for_each(|(axis, x)| axis.push(*x));
    }

    /// All but the last.
    fn len(&self) -> usize {
        self.axes[0].len() - 1
    }

    fn at(&self, k: usize) -> Vector3<f64> {
        Vector3::from_fn(|axis, _| self.axes[axis][k])
    }

    fn points(&self) -> impl Iterator<Item = Vector3<f64>> {
        (0..self.len()).map(|k| self.at(k))
    }

    /// Those of use.
    fn usable(&self) -> impl Iterator<Item = Vector3<f64>> {
        self.points().filter(|p| !p.z.is_nan())
    }

    fn turn(&mut self, turned: impl Fn(Vector3<f64>) -> Vector3<f64>) {
        for k in 0..self.len() {
            let point = turned(self.at(k));
            self.axes.iter_mut().zip(&point).for_each(|(axis, x)| axis[k] = *x);
        }
    }
}

/// Whether a point lies within a slope about the z axis; one that is no number does not.
#[inline(always)]
fn is_in_front(x: f64, y: f64, z: f64, widest: f64) -> bool {
    (z > 0.0) & (x.abs() <= widest * z) & (y.abs() <= widest * z)
}

/// The slopes of the rays of points in front of the plane z = 0.
struct Slopes {
    /// Along x and y, but for single ones far away.
    range: [[f64; 2]; 2],
    /// How many points lie within the widest.
    in_front: usize,
}

impl Slopes {
    /// Those up to a widest; `None` for too few.
    fn of(points: &Cloud, widest: f64, asked: &Asked<'_>) -> Result<Option<Self>> {
        let [x, y, z] = points.axes.each_ref().map(|axis| &axis[..points.len()]);
        let mut range = [[0.0; 2]; 2];
        let mut slopes = Vec::new();
        for (own, (axis, other)) in range.iter_mut().zip([(x, y), (y, x)]) {
            slopes.clear();
            slopes.resize(points.len(), 0.0);
            for (part, slopes) in slopes.chunks_mut(BETWEEN_QUESTIONS).enumerate() {
                asked()?;
                let axes = [axis, other, z].map(|axis| part_of(axis, part));
                Arch::new().dispatch(SlopesOfPoints { axes, widest, slopes });
            }
            slopes.retain(|slope| !slope.is_nan());
            if slopes.len() < FEWEST {
                return Ok(None);
            }
            asked()?;
            *own = at_both_ends(&slopes, (STRAY * slopes.len() as f64) as usize);
            asked()?;
        }
        Ok(Some(Self { range, in_front: slopes.len() }))
    }
}

/// For each pixel on the plane z = 1 the point that is seen there.
struct Image {
    width: usize,
    height: usize,
    spacing: f64,
    low: [f64; 2],
    /// The pixel of each point, [`OUTSIDE`] for those that have none.
    pixels: Vec<u32>,
    /// The number of the point at each pixel, that of the last where there is none.
    nearest: Vec<u32>,
    /// Whether there is another wall behind what is seen: no sensor has seen all of it from here.
    closed: bool,
}

impl Image {
    /// As many pixels as points that are seen, over the part of the image that has any.
    fn of(points: &Cloud, widest: f64, asked: &Asked<'_>) -> Result<Option<Self>> {
        let depths = &points.axes[2];
        let Some(slopes) = Slopes::of(points, widest, asked)? else { return Ok(None) };
        let Some(image) = Self::new(points, slopes.in_front, &slopes, asked)? else { return Ok(None) };
        let seen = image.seen(depths);
        if seen as f64 >= MOSTLY_SEEN * slopes.in_front as f64 {
            return Ok(Some(image));
        }
        // Much memory in a large cloud.
        drop(image);
        let mut image = Self::new(points, seen, &slopes, asked)?;
        if let Some(image) = &mut image {
            image.close(depths);
        }
        Ok(image)
    }

    /// With so many pixels.
    fn new(points: &Cloud, pixels: usize, slopes: &Slopes, asked: &Asked<'_>) -> Result<Option<Self>> {
        let [x, y, z] = points.axes.each_ref().map(|axis| &axis[..points.len()]);
        let range = slopes.range;
        let [width, height] = range.map(|[low, high]| high - low);
        let pixels = (pixels as f64).min(MOST_PIXELS);
        let spacing = (width * height / pixels).sqrt();
        if !(spacing > 0.0 && spacing.is_finite() && width.max(height) / spacing < 1e4) {
            return Ok(None);
        }
        let mut image = Self {
            width: (width / spacing) as usize + 1,
            height: (height / spacing) as usize + 1,
            spacing,
            low: [range[0][0], range[1][0]],
            pixels: Vec::new(),
            nearest: Vec::new(),
            closed: false,
        };
        let mut of_points = vec![OUTSIDE; points.len()];
        for (part, pixels) in of_points.chunks_mut(BETWEEN_QUESTIONS).enumerate() {
            asked()?;
            let axes = [x, y, z].map(|axis| part_of(axis, part));
            Arch::new().dispatch(PixelsOfPoints { image: &image, axes, pixels });
        }
        let none = points.len() as u32;
        image.nearest = vec![none; image.width * image.height];
        for (part, pixels) in of_points.chunks(BETWEEN_QUESTIONS).enumerate() {
            asked()?;
            let first = part * BETWEEN_QUESTIONS;
            for (k, (&pixel, z)) in pixels.iter().zip(part_of(z, part)).enumerate() {
                if let Some(nearest) = image.nearest.get_mut(pixel as usize)
                    && (*nearest == none || *z < points.axes[2][*nearest as usize])
                {
                    *nearest = (first + k) as u32;
                }
            }
        }
        image.pixels = of_points;
        Ok(Some(image))
    }
}

/// The coordinates that are gone through from one question whether to go on to the next.
fn part_of(axis: &[f64], part: usize) -> &[f64] {
    let first = part * BETWEEN_QUESTIONS;
    &axis[first..axis.len().min(first + BETWEEN_QUESTIONS)]
}

/// One pass over points for the slopes of their rays along the first of some axes, no numbers where they are not in front; the last
/// axis is z.
struct SlopesOfPoints<'a> {
    axes: [&'a [f64]; 3],
    widest: f64,
    slopes: &'a mut [f64],
}

impl WithSimd for SlopesOfPoints<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { axes: [x, other, z], widest, slopes } = self;
        for (slope, ((x, other), z)) in slopes.iter_mut().zip(x.iter().zip(other).zip(z)) {
            let front = is_in_front(*x, *other, *z, widest);
            *slope = if front { x / z } else { f64::NAN };
        }
    }
}

/// One pass over points for their pixels, in place of [`OUTSIDE`].
struct PixelsOfPoints<'a> {
    image: &'a Image,
    axes: [&'a [f64]; 3],
    pixels: &'a mut [u32],
}

impl WithSimd for PixelsOfPoints<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { image: Image { width, height, spacing, low, .. }, axes: [x, y, z], pixels } = self;
        let (right, bottom) = (*width as f64, *height as f64);
        for (pixel, ((x, y), z)) in pixels.iter_mut().zip(x.iter().zip(y).zip(z)) {
            let x = (x / z - low[0]) / spacing;
            let y = (y / z - low[1]) / spacing;
            let inside = (*z > 0.0) & (x >= 0.0) & (y >= 0.0) & (x < right) & (y < bottom);
            // An i32, of which an image has far fewer pixels, is what vector instructions convert to.
            let number = (y as i32 as u32).wrapping_mul(*width as u32).wrapping_add(x as i32 as u32);
            *pixel = if inside { number } else { OUTSIDE };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_large_cloud_asks_all_along_and_ends_at_once() {
        let count = 2 * BETWEEN_QUESTIONS + 5;
        let points: Vec<[f32; 3]> =
            (0..count).map(|k| [(k % 1009) as f32 * 1e-3, (k / 1009) as f32 * 1e-3, 1.0]).collect();
        let view = PointsView::from_f32(&points);
        let asked = std::cell::Cell::new(0);
        let end = std::cell::Cell::new(usize::MAX);
        let question = || {
            asked.set(asked.get() + 1);
            cancelled_if(asked.get() >= end.get())
        };
        let cloud = Cloud::read(&view, None, &vec![0; count], &question).unwrap();
        assert_eq!(asked.replace(0), 3);
        assert!(Image::of(&cloud, 3.0, &question).unwrap().is_some());
        // Of both axes the slopes by parts, before and after their range, then the pixels and what is nearest there by parts.
        let all = asked.replace(0);
        assert_eq!(all, 2 * (3 + 2) + 3 + 3);
        for last in [1, 4, 6, 11, 14, all] {
            end.set(last);
            assert!(matches!(Image::of(&cloud, 3.0, &question), Err(Error::Cancelled { .. })));
            assert_eq!(asked.replace(0), last);
        }
    }

    #[test]
    fn slopes_and_pixels_are_those_of_one_point_after_the_other() {
        let numbers = [0.0, 1.0, -1.0, 0.3, 2.5, 1e-300, 1e300, -1e300, f64::NAN];
        let points: Vec<[f64; 3]> =
            (0..729).map(|k| [numbers[k % 9], numbers[k / 9 % 9], numbers[k / 81]]).collect();
        let axes = [0, 1, 2].map(|axis| points.iter().map(|point| point[axis]).collect::<Vec<f64>>());
        let axes = axes.each_ref().map(|axis| &axis[..]);
        let mut slopes = vec![0.0; points.len()];
        SlopesOfPoints { axes, widest: 3.0, slopes: &mut slopes }.with_simd(pulp::Scalar);
        let mut wide = vec![0.0; points.len()];
        Arch::new().dispatch(SlopesOfPoints { axes, widest: 3.0, slopes: &mut wide });
        let (pixels, nearest) = (Vec::new(), Vec::new());
        let low = [-1.5, -1.0];
        let image = Image { width: 30, height: 20, spacing: 0.1, low, pixels, nearest, closed: false };
        let mut pixels = vec![OUTSIDE; points.len()];
        Arch::new().dispatch(PixelsOfPoints { image: &image, axes, pixels: &mut pixels });
        let mut within = 0;
        for (k, [x, y, z]) in points.into_iter().enumerate() {
            let front = z > 0.0 && x.abs() <= 3.0 * z && y.abs() <= 3.0 * z;
            within += usize::from(front);
            assert_eq!(slopes[k].to_bits(), wide[k].to_bits());
            assert!(if front { slopes[k] == x / z } else { slopes[k].is_nan() }, "{x} {y} {z}");
            let place = [(x / z + 1.5) / 0.1, (y / z + 1.0) / 0.1];
            let inside = z > 0.0 && (0.0..30.0).contains(&place[0]) && (0.0..20.0).contains(&place[1]);
            let pixel = if inside { place[1] as u32 * 30 + place[0] as u32 } else { OUTSIDE };
            assert_eq!(pixels[k], pixel, "{x} {y} {z}");
        }
        assert_eq!(within, slopes.iter().filter(|slope| !slope.is_nan()).count());
    }
}
