//! What a camera at a cloud sees: the nearest point at each pixel.

use super::points::{Points, Pose};
use super::{BETWEEN_QUESTIONS, CancelCheck, STRAY};
use crate::error::Result;
use crate::statistics::at_both_ends;
use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

/// Pixels of the image of a cloud, at most.
const MOST_PIXELS: f64 = 2e6;

constants! {
    /// Where less than this part of the points is seen, there is another wall behind, and the image has a pixel to each of those that are.
    MOSTLY_SEEN = 0.75, "";

    /// An image of which more than this part has points has as many pixels as these.
    NEARLY_FILLED = 0.8, "";

    /// Fewest points of a cloud.
    pub(super) FEWEST = 50.0, "points";
}

/// Points that are projected at a time.
const BLOCK: usize = 512;

/// What a pixel sees where it sees nothing: infinite depth, and the number of no point.
pub(super) const NOTHING: u64 = at_depth(f32::INFINITY, u32::MAX);

/// A point at a depth: the nearer is less, and of two at the same depth the first.
const fn at_depth(depth: f32, number: u32) -> u64 {
    (depth.to_bits() as u64) << 32 | number as u64
}

pub(super) fn depth_of(seen: u64) -> f32 {
    f32::from_bits((seen >> 32) as u32)
}

/// Whether a point lies within a slope about the z axis; one that is no number does not.
#[inline(always)]
fn is_in_front([x, y, z]: [f32; 3], widest: f32) -> bool {
    (z > 0.0) & (x.abs() <= widest * z) & (y.abs() <= widest * z)
}

/// The coordinates of a point of a camera.
#[inline(always)]
fn turned(pose: &[[f32; 4]; 3], [x, y, z]: [f32; 3]) -> [f32; 3] {
    pose.map(|[a, b, c, t]| a * x + b * y + (c * z + t))
}

/// The coordinates of a range of points.
fn part(points: &Points, range: Range<usize>) -> [&[f32]; 3] {
    points.axes.each_ref().map(|axis| &axis[range.clone()])
}

/// How many points lie in front of a camera.
pub(super) fn count_in_front(points: &Points, pose: &Pose, widest: f64) -> usize {
    let (mut counts, widest) = (0, widest as f32);
    for first in (0..points.len()).step_by(BLOCK) {
        let axes = part(points, first..points.len().min(first + BLOCK));
        counts += Arch::new().dispatch(InFront { axes, pose: &pose.single(), widest });
    }
    counts as usize
}

/// One pass over points for the count of those in front of a camera.
struct InFront<'a> {
    axes: [&'a [f32]; 3],
    pose: &'a [[f32; 4]; 3],
    widest: f32,
}

impl WithSimd for InFront<'_> {
    type Output = u32;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> u32 {
        let Self { axes: [x, y, z], pose, widest } = self;
        let mut count = 0;
        for ((x, y), z) in x.iter().zip(y).zip(z) {
            count += u32::from(is_in_front(turned(pose, [*x, *y, *z]), widest));
        }
        count
    }
}

/// The slopes of the rays of points in front of a camera.
struct Slopes {
    /// Along x and y, but for single ones far away.
    range: [[f64; 2]; 2],
    /// The part of the points of use that lie within the widest.
    in_front: f64,
}

impl Slopes {
    /// Those up to a widest; `None` for too few.
    fn of(points: &Points, pose: &Pose, widest: f64) -> Option<Self> {
        let mut range = [[0.0; 2]; 2];
        let mut slopes = vec![0.0; points.len()];
        let pose = pose.single();
        let mut count = 0;
        for (own, axis) in range.iter_mut().zip([0, 1]) {
            slopes.resize(points.len(), 0.0);
            let axes = part(points, 0..points.len());
            let of_points =
                SlopesOfPoints { axes, pose: &pose, axis, widest: widest as f32, slopes: &mut slopes };
            Arch::new().dispatch(of_points);
            slopes.retain(|slope| !slope.is_nan());
            count = slopes.len();
            if count < FEWEST.count() {
                return None;
            }
            *own = at_both_ends(&slopes, (STRAY.get() * count as f64) as usize);
        }
        Some(Self { range, in_front: count as f64 / points.usable as f64 })
    }
}

/// One pass over points for the slopes of their rays along an axis, no numbers where they are not in front.
struct SlopesOfPoints<'a> {
    axes: [&'a [f32]; 3],
    pose: &'a [[f32; 4]; 3],
    axis: usize,
    widest: f32,
    slopes: &'a mut [f64],
}

impl WithSimd for SlopesOfPoints<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { axes: [x, y, z], pose, axis, widest, slopes } = self;
        for (slope, ((x, y), z)) in slopes.iter_mut().zip(x.iter().zip(y).zip(z)) {
            let point = turned(pose, [*x, *y, *z]);
            let of_axis = if axis == 0 { point[0] } else { point[1] };
            *slope = f64::from(if is_in_front(point, widest) { of_axis / point[2] } else { f32::NAN });
        }
    }
}

/// The pixels of a camera, and the camera itself.
#[derive(Debug, Clone, Copy)]
pub(super) struct Raster {
    pub width: usize,
    pub height: usize,
    pub spacing: f64,
    /// Where the first pixel begins.
    pub low: [f64; 2],
    pub pose: Pose,
}

impl Raster {
    /// With so many pixels.
    fn new(pixels: f64, slopes: &Slopes, pose: &Pose) -> Option<Self> {
        let [width, height] = slopes.range.map(|[low, high]| high - low);
        let spacing = (width * height / pixels.min(MOST_PIXELS)).sqrt();
        if !(spacing > 0.0 && spacing.is_finite() && width.max(height) / spacing < 1e4) {
            return None;
        }
        Some(Self {
            width: (width / spacing) as usize + 1,
            height: (height / spacing) as usize + 1,
            spacing,
            low: slopes.range.map(|[low, _]| low),
            pose: *pose,
        })
    }

    /// The number of the pixel of what lies outside: one beyond all others.
    fn outside(&self) -> usize {
        self.width * self.height
    }

    /// The same in single precision.
    fn single(&self) -> View {
        View {
            pose: self.pose.single(),
            scale: (1.0 / self.spacing) as f32,
            low: self.low.map(|low| (low / self.spacing) as f32),
            size: [self.width as f32, self.height as f32],
            width: self.width as u32,
            outside: self.outside() as u32,
        }
    }

    /// Goes through points by blocks: the number of the first, and the pixel and the depth of each.
    pub fn project(
        &self,
        points: &Points,
        check_cancel: &CancelCheck<'_>,
        mut each: impl FnMut(usize, &[u32], &[f32]),
    ) -> Result<()> {
        let (mut pixels, mut depths) = ([0; BLOCK], [0.0; BLOCK]);
        let view = self.single();
        for first in (0..points.len()).step_by(BLOCK) {
            if first.is_multiple_of(BETWEEN_QUESTIONS) {
                check_cancel()?;
            }
            let axes = part(points, first..points.len().min(first + BLOCK));
            let count = axes[0].len();
            let (pixels, depths) = (&mut pixels[..count], &mut depths[..count]);
            Arch::new().dispatch(Projection { view: &view, axes, pixels, depths });
            each(first, pixels, depths);
        }
        Ok(())
    }
}

/// The whole part of a number from 0 up to the size of an image, without the checks of a conversion, which vector instructions do not have.
#[inline(always)]
fn whole_part(x: f32) -> u32 {
    // From here on numbers of single precision have no fraction, and their last bits count.
    const WHOLE: f32 = 8_388_608.0;
    let rounded = (x + WHOLE) - WHOLE;
    let below = if rounded > x { rounded - 1.0 } else { rounded };
    (below + WHOLE).to_bits() & 0x7f_ffff
}

/// A raster in single precision.
struct View {
    pose: [[f32; 4]; 3],
    /// Pixels to a slope of 1.
    scale: f32,
    /// Where the first pixel begins, in pixels.
    low: [f32; 2],
    size: [f32; 2],
    width: u32,
    outside: u32,
}

/// One pass over points for their pixels and depths.
struct Projection<'a> {
    view: &'a View,
    axes: [&'a [f32]; 3],
    pixels: &'a mut [u32],
    depths: &'a mut [f32],
}

impl WithSimd for Projection<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { view, axes: [x, y, z], pixels, depths } = self;
        let View { pose, scale, low: [left, top], size: [right, bottom], width, outside } = *view;
        let projected = pixels.iter_mut().zip(depths);
        for ((pixel, depth), ((x, y), z)) in projected.zip(x.iter().zip(y).zip(z)) {
            let [x, y, z] = turned(&pose, [*x, *y, *z]);
            let scale = scale / z;
            let (x, y) = (x * scale - left, y * scale - top);
            let inside = (z > 0.0) & (x >= 0.0) & (y >= 0.0) & (x < right) & (y < bottom);
            let (x, y) = (if inside { x } else { 0.0 }, if inside { y } else { 0.0 });
            let number = whole_part(y).wrapping_mul(width).wrapping_add(whole_part(x));
            *pixel = if inside { number } else { outside };
            *depth = z;
        }
    }
}

/// For each pixel the point that is seen there.
#[derive(Debug)]
pub(super) struct Image {
    pub raster: Raster,
    /// What each pixel sees, and at last what lies outside.
    pub nearest: Vec<u64>,
    /// The part of the points in front that no others hide.
    pub seen: f64,
    /// Whether there is another wall behind what is seen: no sensor has seen all of it from here.
    pub closed: bool,
}

impl Image {
    /// As many pixels as points that are seen, over the part of the image that has any, which may be little of it. A sample of the
    /// points, or all, tells the extent, in a memory that is lent.
    pub fn of(
        points: &Points,
        sample: &Points,
        (pose, widest): (&Pose, f64),
        memory: Vec<u64>,
        check_cancel: &CancelCheck<'_>,
    ) -> Result<Option<Self>> {
        let Some(slopes) = Slopes::of(sample, pose, widest) else { return Ok(None) };
        let in_front = slopes.in_front * points.usable as f64;
        let Some(raster) = Raster::new(in_front, &slopes, pose) else { return Ok(None) };
        let mut image = Self::new(points, raster, memory, check_cancel)?;
        let filled = image.filled();
        let in_front = in_front / filled;
        if filled < NEARLY_FILLED.get() {
            let Some(raster) = Raster::new(in_front, &slopes, pose) else { return Ok(None) };
            image = Self::new(points, raster, image.nearest, check_cancel)?;
        }
        let seen = image.count_seen(sample, check_cancel)? as f64 / (slopes.in_front * sample.usable as f64);
        image.seen = seen;
        if seen >= MOSTLY_SEEN.get() {
            return Ok(Some(image));
        }
        let Some(raster) = Raster::new(seen * in_front, &slopes, pose) else { return Ok(None) };
        let mut image = Self { seen, ..Self::new(points, raster, image.nearest, check_cancel)? };
        image.close();
        Ok(Some(image))
    }

    /// The part of the image that has points, by the pixels that have some, with as many pixels as points.
    fn filled(&self) -> f64 {
        let some = self.nearest[..self.raster.outside()].iter().filter(|seen| **seen != NOTHING).count();
        let part = some as f64 / self.raster.outside() as f64;
        // Points at random leave e^(−1/a) of the part a empty.
        (0..30).fold(part, |a, _| part / (1.0 - (-1.0 / a).exp())).min(1.0)
    }

    fn new(
        points: &Points,
        raster: Raster,
        mut nearest: Vec<u64>,
        check_cancel: &CancelCheck<'_>,
    ) -> Result<Self> {
        nearest.clear();
        nearest.resize(raster.outside() + 1, NOTHING);
        raster.project(points, check_cancel, |first, pixels, depths| {
            for (number, (pixel, depth)) in (first as u32..).zip(pixels.iter().zip(depths)) {
                let seen = &mut nearest[*pixel as usize];
                *seen = (*seen).min(at_depth(*depth, number));
            }
        })?;
        Ok(Self { raster, nearest, seen: 1.0, closed: false })
    }

    /// The point that is seen at a pixel.
    #[inline]
    pub fn point_at(&self, pixel: usize) -> Option<usize> {
        let seen = self.nearest[pixel];
        (seen != NOTHING).then_some(seen as u32 as usize)
    }

    /// The depth that is seen at a pixel, infinite for none.
    #[inline]
    pub fn depth_at(&self, pixel: usize) -> f32 {
        depth_of(self.nearest[pixel])
    }

    /// The points that some pixels of a row see, as the camera does; zeros for none.
    pub fn write_row(
        &self,
        points: &Points,
        row: usize,
        columns: Range<usize>,
        lists: &mut [crate::memory::List<f64>; 3],
    ) {
        let first = row * self.raster.width;
        let nearest = &self.nearest[first + columns.start..first + columns.end];
        lists.iter_mut().for_each(|list| list.resize(nearest.len(), 0.0));
        let [x, y, z] = lists;
        let coordinates = x.iter_mut().zip(y.iter_mut()).zip(z.iter_mut());
        for (seen, ((x, y), z)) in nearest.iter().zip(coordinates) {
            let point = match *seen {
                NOTHING => Vector3::zeros(),
                seen => self.raster.pose.turn(&points.at(seen as u32 as usize)),
            };
            (*x, *y, *z) = (point.x, point.y, point.z);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::{Error, cancelled_if};
    use crate::observations::PointsView;
    use nalgebra::Matrix3;

    const AS_GIVEN: Pose = Pose {
        rotation: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        offset: Vector3::new(0.0, 0.0, 0.0),
    };

    fn read(points: &[[f32; 3]]) -> Points {
        Points::read(&PointsView::from_f32(points), Vector3::zeros(), &|| Ok(())).unwrap()
    }

    #[test]
    fn a_large_cloud_asks_all_along_and_ends_at_once() {
        let count = 2 * BETWEEN_QUESTIONS + 5;
        let points: Vec<[f32; 3]> =
            (0..count).map(|k| [(k % 1009) as f32 * 1e-3, (k / 1009) as f32 * 1e-3, 1.0]).collect();
        let checks = std::cell::Cell::new(0);
        let end = std::cell::Cell::new(usize::MAX);
        let question = || {
            checks.set(checks.get() + 1);
            cancelled_if(checks.get() >= end.get())
        };
        let points = Points::read(&PointsView::from_f32(&points), Vector3::zeros(), &question).unwrap();
        assert_eq!(checks.replace(0), 3);
        let image = || Image::of(&points, &points, (&AS_GIVEN, 3.0), Vec::new(), &question);
        assert!(image().unwrap().is_some());
        // What is nearest by parts, and what of that is seen.
        let all = checks.replace(0);
        assert_eq!(all, 3 + 3);
        for last in 1..=all {
            end.set(last);
            assert!(matches!(image(), Err(Error::Cancelled { .. })));
            assert_eq!(checks.replace(0), last);
        }
    }

    #[test]
    fn slopes_and_pixels_are_those_of_one_point_after_the_other() {
        let numbers = [0.0, 1.0, -1.0, 0.3, 2.5, 1e-30, 1e30, -1e30, f32::NAN];
        let points: Vec<[f32; 3]> =
            (0..729).map(|k| [numbers[k % 9], numbers[k / 9 % 9], numbers[k / 81]]).collect();
        let read = read(&points);
        let axes = part(&read, 0..729);
        let mut slopes = vec![0.0; points.len()];
        let pose = &AS_GIVEN.single();
        SlopesOfPoints { axes, pose, axis: 0, widest: 3.0, slopes: &mut slopes }.with_simd(pulp::Scalar);
        let mut wide = vec![0.0; points.len()];
        Arch::new().dispatch(SlopesOfPoints { axes, pose, axis: 0, widest: 3.0, slopes: &mut wide });
        let raster = Raster { width: 30, height: 20, spacing: 0.1, low: [-1.5, -1.0], pose: AS_GIVEN };
        let mut pixels = Vec::new();
        raster.project(&read, &|| Ok(()), |_, some, _| pixels.extend_from_slice(some)).unwrap();
        let mut within = 0;
        for (k, [x, y, z]) in points.into_iter().enumerate() {
            let front = z > 0.0 && x.abs() <= 3.0 * z && y.abs() <= 3.0 * z;
            within += usize::from(front);
            assert_eq!(slopes[k].to_bits(), wide[k].to_bits());
            assert!(if front { slopes[k] == f64::from(x / z) } else { slopes[k].is_nan() }, "{x} {y} {z}");
            let position = [x * (10.0 / z) + 15.0, y * (10.0 / z) + 10.0];
            let inside = z > 0.0 && (0.0..30.0).contains(&position[0]) && (0.0..20.0).contains(&position[1]);
            let pixel = if inside { position[1] as u32 * 30 + position[0] as u32 } else { 600 };
            assert_eq!(pixels[k], pixel, "{x} {y} {z}");
        }
        assert_eq!(within, count_in_front(&read, &AS_GIVEN, 3.0));
        assert_eq!(within, slopes.iter().filter(|slope| !slope.is_nan()).count());
    }

    #[test]
    fn a_pixel_sees_the_nearest_point_and_the_first_of_those_alike() {
        let points = read(&[[0.0, 0.0, 2.0], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [5.0, 0.0, 1.0]]);
        let raster = Raster { width: 3, height: 1, spacing: 1.0, low: [-1.5, -0.5], pose: AS_GIVEN };
        let image = Image::new(&points, raster, Vec::new(), &|| Ok(())).unwrap();
        assert_eq!([0, 1, 2].map(|pixel| image.point_at(pixel)), [None, Some(1), None]);
        assert_eq!((image.depth_at(0), image.depth_at(1)), (f32::INFINITY, 1.0));
    }
}
