//! Depth images: from pixels to points.

use super::batch::Batch;
use super::dropped::Dropped;
use super::frame::Frame;
use super::mask::Mask;
use super::points::PointCloud;
use super::registration::{Registration, Sight};
use super::strided::Scalar;
use super::views::DepthView;
use crate::camera::Camera;
use crate::error::{Error, Result, not_negative, with_room};
use crate::geometry::RigidMotion;
use crate::memory::List;
use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

/// Which depths become points, and are searched by a detector. The extent is found with all depths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthRange {
    /// The nearest depth that becomes a point.
    pub min: f64,
    /// The farthest depth that becomes a point; infinity for no limit.
    pub max: f64,
}

impl Default for DepthRange {
    fn default() -> Self {
        Self { min: 0.0, max: f64::INFINITY }
    }
}

impl DepthRange {
    /// Checks the limits.
    ///
    /// # Errors
    /// `InvalidArgument` when `min` is negative or not below `max`.
    pub fn check(&self) -> Result<()> {
        not_negative("minimal depth", self.min)?;
        if !(self.max > self.min) {
            let requirement = format!("be greater than the minimal depth {}", self.min);
            return Err(Error::argument("maximal depth", self.max, requirement));
        }
        Ok(())
    }
}

/// A depth image, owned.
#[derive(Debug, Clone)]
pub struct DepthImage {
    width: usize,
    height: usize,
    /// As they were stored, 0 = no measurement: an f32 holds any number of 16 bits.
    values: Vec<f32>,
    /// Length of one unit.
    scale: f64,
    /// See [`Self::pixel`].
    pixel: f64,
}

impl DepthImage {
    /// Copies a depth image.
    ///
    /// # Errors
    /// `OutOfMemory`.
    pub fn copy(view: &DepthView<'_>) -> Result<Self> {
        let (width, height) = (view.width(), view.height());
        let values = Arch::new().dispatch(Copied { view, values: room_for(width, height)? });
        Ok(Self { width, height, values, scale: view.scale, pixel: 1.0 })
    }

    /// An image in which nothing was measured, for depth that was measured in pixels of a size.
    pub(super) fn empty((width, height): (usize, usize), scale: f64, pixel: f64) -> Result<Self> {
        let mut values = room_for(width, height)?;
        values.resize(width * height, 0.0);
        Ok(Self { width, height, values, scale, pixel })
    }

    /// The image without the depths that a range leaves out.
    ///
    /// # Errors
    /// `OutOfMemory`.
    pub(crate) fn within(&self, range: &DepthRange) -> Result<Self> {
        let mut image = Self::empty(self.size(), self.scale, self.pixel)?;
        for (index, value) in image.values.iter_mut().enumerate() {
            if self.depth_at(index).is_some_and(|depth| (range.min..=range.max).contains(&depth)) {
                *value = self.values[index];
            }
        }
        Ok(image)
    }

    /// The image moved by some columns and rows; what comes in from outside was not measured.
    ///
    /// # Errors
    /// `OutOfMemory`.
    pub(super) fn moved(&self, by: [i32; 2]) -> Result<Self> {
        let values = moved(&self.values, (self.width, self.height), by)?;
        Ok(Self { values, ..*self })
    }

    /// Columns.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// Columns and rows.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// The size of the pixels that were measured, in pixels of this image: 1 unless its depth was carried to the grid of an image with
    /// other ones.
    #[must_use]
    pub(crate) fn pixel(&self) -> f64 {
        self.pixel
    }

    /// The depth z at a pixel; `None` outside the image and where nothing was measured.
    #[inline]
    #[must_use]
    pub fn depth(&self, column: usize, row: usize) -> Option<f64> {
        let inside = column < self.width && row < self.height;
        inside.then(|| self.depth_at(row * self.width + column)).flatten()
    }

    /// The stored values of a row, 0 = no measurement.
    pub(crate) fn values_of_row(&self, row: usize) -> &[f32] {
        &self.values[row * self.width..(row + 1) * self.width]
    }

    pub(super) fn values_of_row_mut(&mut self, row: usize) -> &mut [f32] {
        &mut self.values[row * self.width..(row + 1) * self.width]
    }

    /// The depth z at a pixel that is counted row by row.
    #[inline]
    pub(super) fn depth_at(&self, index: usize) -> Option<f64> {
        let value = self.values[index];
        (value > 0.0).then(|| f64::from(value) * self.scale)
    }

    /// The four stored values around the upper left corner of a pixel, 0 = no measurement; `None` at the border.
    #[inline]
    pub(super) fn block(&self, column: usize, row: usize) -> Option<[f32; 4]> {
        if column == 0 || row == 0 || column >= self.width || row >= self.height {
            return None;
        }
        let first = (row - 1) * self.width + column - 1;
        let (above, below) = (&self.values[first..first + 2], &self.values[first + self.width..][..2]);
        Some([above[0], above[1], below[0], below[1]])
    }

    /// Length of one unit of the stored values.
    pub(crate) fn scale(&self) -> f64 {
        self.scale
    }

    /// Puts a depth where there is none or a greater one.
    #[inline]
    pub(super) fn put_nearest(&mut self, index: usize, depth: f32) {
        let value = &mut self.values[index];
        if *value == 0.0 || depth < *value {
            *value = depth;
        }
    }
}

/// Copies the values of an image with the widest instructions of the machine.
struct Copied<'a, 'b> {
    view: &'a DepthView<'b>,
    /// Room for them.
    values: Vec<f32>,
}

impl WithSimd for Copied<'_, '_> {
    type Output = Vec<f32>;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _simd: S) -> Vec<f32> {
        // Rows of no pixels are as many as the caller likes.
        for row in 0..if self.view.width() == 0 { 0 } else { self.view.height() } {
            self.view.read_row(row, &mut self.values);
        }
        self.values
    }
}

/// Pixels of a row that are looked at in one go.
const RUN: usize = 32;

/// Which of some pixels side by side have a usable depth.
struct Run {
    /// Their offsets from the first pixel and their depths, as many as there are.
    offsets: [usize; RUN],
    depths: [f64; RUN],
    count: usize,
    no_depth: usize,
    out_of_range: usize,
}

impl Run {
    /// Of stored values, of which a mask may select some. Without branches: nobody could predict where a depth is missing.
    #[inline(always)]
    fn new(values: &[f32], set: Option<&[bool]>, scale: f64, range: &DepthRange) -> Self {
        let (mut offsets, mut depths) = ([0; RUN], [0.0; RUN]);
        let (mut count, mut measured, mut selected) = (0, 0, 0);
        for (k, (value, set)) in values.iter().zip(set.unwrap_or(&[true; RUN])).enumerate() {
            let depth = f64::from(*value) * scale;
            let has_depth = set & (*value > 0.0);
            // There are never more than a run has; the compiler can't know it.
            (offsets[count % RUN], depths[count % RUN]) = (k, depth);
            selected += usize::from(*set);
            measured += usize::from(has_depth);
            count += usize::from(has_depth & (range.min <= depth) & (depth <= range.max));
        }
        Self { offsets, depths, count, no_depth: selected - measured, out_of_range: measured - count }
    }

    /// Their offsets from the first pixel and their depths.
    fn usable(&self) -> (&[usize], &[f64]) {
        (&self.offsets[..self.count], &self.depths[..self.count])
    }
}

/// Columns in runs.
fn runs(columns: Range<usize>) -> impl Iterator<Item = Range<usize>> {
    columns.clone().step_by(RUN).map(move |start| start..columns.end.min(start + RUN))
}

/// The values of a grid moved by some columns and rows; zeros come in from outside.
///
/// # Errors
/// `OutOfMemory`.
pub(crate) fn moved<T: Copy + Default>(
    values: &[T],
    (width, height): (usize, usize),
    [columns, rows]: [i32; 2],
) -> Result<Vec<T>> {
    let mut all = with_room(values.len(), "what is moved")?;
    all.resize(values.len(), T::default());
    let by = (columns.unsigned_abs() as usize).min(width);
    let (from, to) = if columns < 0 { (by, 0) } else { (0, by) };
    for row in 0..height {
        let old = row.checked_add_signed(-rows as isize).filter(|old| *old < height);
        if let Some(old) = old {
            let pixels = &values[old * width + from..][..width - by];
            all[row * width + to..][..width - by].copy_from_slice(pixels);
        }
    }
    Ok(all)
}

/// Room for the values of a depth image.
fn room_for(width: usize, height: usize) -> Result<Vec<f32>> {
    with_room(width * height, "the depth image")
}

impl PointCloud {
    /// Back-projects the measured pixels of the depth image of a frame, p = D(u) K⁻¹ ũ (3), through the distortion of
    /// the camera that measured them, into the frame of the colour camera.
    ///
    /// A mask on the grid of the colour image selects pixels. With a depth camera of its own it selects what the colour
    /// camera sees there: a measured pixel goes by where the colour camera sees it (outside the image is outside the
    /// mask), and what lies hidden behind something nearer is left out. Without a mask every measured pixel counts.
    ///
    /// # Errors
    /// `BadState` without camera or depth image, `SizeMismatch` when the mask has another size than the colour image,
    /// `NoDepth` when no pixel is usable, `OutOfMemory`, and those of [`PointCloud::push_points`] for coordinates too
    /// far apart. Nothing is added then.
    pub fn push_frame(&mut self, frame: &Frame, mask: Option<&Mask>) -> Result<()> {
        let (Some(camera), Some(depth)) = (frame.camera(), frame.depth()) else {
            return Err(Error::BadState {
                call: "making points of a frame",
                missing: "intrinsics and a depth image",
                remedy: "set both first",
            });
        };
        if let Some(mask) = mask {
            let grid =
                if frame.depth_camera().is_some() { "the image of the intrinsics" } else { "depth image" };
            mask.check_size(grid, camera.size())?;
        }
        let projection = BackProjection::new(frame, camera, depth);
        let (width, height) = depth.size();
        let mut batch = Batch::grid(width, height);
        match (mask, frame.registration()) {
            (None, _) => projection.add_all(&mut batch)?,
            (Some(mask), None) => projection.add_in_mask(&mut batch, mask)?,
            (Some(mask), Some(registration)) => projection.add_registered(&mut batch, mask, registration)?,
        }
        if batch.len() == 0 {
            let Dropped { no_depth: missing, out_of_range, outside_mask, .. } = batch.dropped;
            let range = frame.depth_range();
            let (pixels, range) = (batch.given - outside_mask, (range.min, range.max));
            return Err(Error::NoDepth { pixels, missing, out_of_range, range });
        }
        self.append(batch, Scalar::F32)
    }
}

/// Makes points of the pixels of a depth image.
struct BackProjection<'a> {
    depth: &'a DepthImage,
    range: &'a DepthRange,
    /// The camera that measured them.
    sensor: &'a Camera,
    /// Where the sensor has rays by columns and rows, their x and y at z = 1.
    rays: Option<(List<f64>, List<f64>)>,
    /// From a sensor of its own into the frame of the colour camera.
    to_color: Option<RigidMotion>,
}

impl<'a> BackProjection<'a> {
    fn new(frame: &'a Frame, camera: &'a Camera, depth: &'a DepthImage) -> Self {
        let own = frame.depth_camera();
        let sensor = own.map_or(camera, |own| &own.camera);
        let rays = sensor.rays_by_column_and_row();
        Self { depth, range: frame.depth_range(), sensor, rays, to_color: own.map(|own| own.to_color) }
    }

    /// Every pixel.
    fn add_all(&self, batch: &mut Batch<f64>) -> Result<()> {
        let (width, height) = self.depth.size();
        for row in 0..height {
            batch.reserve(width)?;
            runs(0..width).for_each(|columns| self.add_run(batch, columns, row, None));
        }
        Ok(())
    }

    /// The pixels of a mask that is on their own grid.
    fn add_in_mask(&self, batch: &mut Batch<f64>, mask: &Mask) -> Result<()> {
        let count = mask.count();
        batch.dropped.outside_mask = batch.given - count;
        batch.reserve(count)?;
        let (columns, rows) = mask.bounds();
        for row in rows {
            runs(columns.clone()).for_each(|columns| self.add_run(batch, columns, row, Some(mask)));
        }
        Ok(())
    }

    /// The pixels that the colour camera sees in a mask on the grid of its image.
    fn add_registered(&self, batch: &mut Batch<f64>, mask: &Mask, registration: &Registration) -> Result<()> {
        let (width, height) = self.depth.size();
        for row in 0..height {
            batch.reserve(width)?;
            for column in 0..width {
                match registration.sight(row * width + column, mask) {
                    Sight::Outside => batch.dropped.outside_mask += 1,
                    sight => self.add_pixel(batch, column, row, sight == Sight::Hidden),
                }
            }
        }
        Ok(())
    }

    /// A pixel, unless it has no depth that counts or lies hidden.
    fn add_pixel(&self, batch: &mut Batch<f64>, column: usize, row: usize, hidden: bool) {
        let Some(depth) = self.depth.depth_at(row * self.depth.size().0 + column) else {
            batch.dropped.no_depth += 1;
            return;
        };
        if !(self.range.min <= depth && depth <= self.range.max) {
            batch.dropped.out_of_range += 1;
        } else if hidden {
            batch.dropped.hidden += 1;
        } else {
            self.add_point(batch, column, row, depth);
        }
    }

    /// The pixels of a run, or those that a mask on their grid selects.
    fn add_run(&self, batch: &mut Batch<f64>, columns: Range<usize>, row: usize, mask: Option<&Mask>) {
        let first = row * self.depth.size().0;
        let pixels = first + columns.start..first + columns.end;
        let set = mask.map(|mask| mask.pixels_by_index(pixels.clone()));
        let run = Run::new(&self.depth.values[pixels], set, self.depth.scale, self.range);
        batch.dropped.no_depth += run.no_depth;
        batch.dropped.out_of_range += run.out_of_range;
        let (offsets, depths) = run.usable();
        let (mut of_x, mut of_y) = ([0.0; RUN], [0.0; RUN]);
        let known = match &self.rays {
            _ if self.to_color.is_some() => false,
            Some((of_columns, of_rows)) => {
                let rays = &of_columns[columns.clone()];
                of_x.iter_mut().zip(offsets).for_each(|(ray, k)| *ray = rays[*k]);
                of_y = [of_rows[row]; RUN];
                true
            }
            None => self.sensor.take_known_rays((columns.start, row), offsets, &mut of_x, &mut of_y),
        };
        if !known {
            let measured = offsets.iter().zip(depths);
            measured.for_each(|(k, depth)| self.add_point(batch, columns.start + k, row, *depth));
            return;
        }
        let [x, y, z] = &mut batch.axes;
        x.extend(of_x.iter().zip(depths).map(|(ray, depth)| ray * depth));
        y.extend(of_y.iter().zip(depths).map(|(ray, depth)| ray * depth));
        z.extend_from_slice(depths);
        batch.pixels.extend(offsets.iter().map(|k| [(columns.start + k) as u32, row as u32]));
    }

    /// The point at a depth, unless the sensor has no ray there.
    fn add_point(&self, batch: &mut Batch<f64>, column: usize, row: usize, depth: f64) {
        let ray = match &self.rays {
            Some((of_columns, of_rows)) => Some(Vector3::new(of_columns[column], of_rows[row], 1.0)),
            None => self.sensor.ray_of_pixel(column, row),
        };
        let Some(ray) = ray else {
            batch.dropped.outside_camera += 1;
            return;
        };
        let point = ray * depth;
        let point = self.to_color.as_ref().map_or(point, |to_color| to_color.point(&point));
        batch.push(point.into(), column, row);
    }
}
