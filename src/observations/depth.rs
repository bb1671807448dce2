//! Depth images: from pixels to points.

use super::mask::Mask;
use super::points::{Batch, PointCloud};
use super::size::check_same_size;
use super::views::{DepthView, Scalar};
use crate::camera::Camera;
use crate::error::{Error, Result};
use nalgebra::Vector2;

/// Which depths count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthRange {
    /// The nearest depth that counts.
    pub min: f64,
    /// The farthest depth that counts; infinity for no limit.
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
        if !(self.min >= 0.0 && self.min.is_finite()) {
            return Err(Error::argument("minimal depth", self.min, "be finite and at least 0"));
        }
        if !(self.max > self.min) {
            let requirement = format!("be greater than the minimal depth {}", self.min);
            return Err(Error::argument("maximal depth", self.max, requirement));
        }
        Ok(())
    }
}

/// A depth image, owned: what lies around the ends of the cylinder is read from it after the fit.
#[derive(Debug, Clone)]
pub struct DepthImage {
    width: usize,
    height: usize,
    depths: Vec<f32>,
}

impl DepthImage {
    /// Copies a depth image.
    ///
    /// # Errors
    /// `OutOfMemory`.
    pub fn copy(view: &DepthView<'_>) -> Result<Self> {
        let (width, height) = (view.width(), view.height());
        let mut depths = Vec::new();
        let bytes = width * height * 4;
        let out_of_memory = |_| Error::OutOfMemory { what: "the depth image", bytes };
        depths.try_reserve_exact(width * height).map_err(out_of_memory)?;
        for row in 0..height {
            depths.extend((0..width).map(|column| view.depth(column, row).unwrap_or(0.0) as f32));
        }
        Ok(Self { width, height, depths })
    }

    /// The depth z at a pixel; `None` outside the image and where nothing was measured.
    #[must_use]
    pub fn depth(&self, column: usize, row: usize) -> Option<f64> {
        let inside = column < self.width && row < self.height;
        inside.then(|| f64::from(self.depths[row * self.width + column])).filter(|&z| z > 0.0)
    }
}

impl PointCloud {
    /// Back-projects the measured pixels of a depth image, p = D(u) K⁻¹ ũ (3), through the distortion of the
    /// camera. A mask selects pixels.
    ///
    /// # Errors
    /// `SizeMismatch` when image, mask and camera differ in size, `InvalidArgument` for a bad range, `NoDepth`
    /// when no pixel is usable, `OutOfMemory`. Nothing is added then.
    pub fn push_depth(
        &mut self,
        camera: &Camera,
        view: &DepthView<'_>,
        mask: Option<&Mask>,
        range: &DepthRange,
    ) -> Result<()> {
        range.check()?;
        let (width, height) = (view.width(), view.height());
        if let Some(mask) = mask {
            mask.check_size("depth image", (width, height))?;
        }
        check_same_size("depth image", (width, height), "the image of the intrinsics", camera.size())?;
        let mut batch = Batch { given: width * height, ..Batch::default() };
        for row in 0..height {
            for column in 0..width {
                if mask.is_some_and(|mask| !mask.contains(column, row)) {
                    batch.dropped.outside_mask += 1;
                    continue;
                }
                let Some(depth) = view.depth(column, row) else {
                    batch.dropped.no_depth += 1;
                    continue;
                };
                if !(range.min <= depth && depth <= range.max) {
                    batch.dropped.out_of_range += 1;
                    continue;
                }
                match camera.unproject(&Vector2::new(column as f64, row as f64)) {
                    Some(ray) => batch.push(ray * depth, 1.0)?,
                    None => batch.dropped.outside_camera += 1,
                }
            }
        }
        if batch.points.is_empty() {
            return Err(Error::NoDepth {
                pixels: batch.given - batch.dropped.outside_mask,
                missing: batch.dropped.no_depth,
                out_of_range: batch.dropped.out_of_range + batch.dropped.outside_camera,
            });
        }
        self.append(&batch, Scalar::F32)
    }
}
