//! All cylinders of a scene: from a depth image or from a bare cloud.

mod candidate;
mod cloud;
mod evidence;
mod grid;
mod noise;
mod outline;
mod parts;
mod patch;
mod planes;
mod region;
mod search;
mod surface;

pub use cloud::detect_points;
pub use evidence::Evidence;
pub(crate) use region::detect_in_mask;

use crate::camera::Camera;
use crate::error::{Error, Result};
use crate::geometry::{Cylinder, CylinderLimits};
use crate::observations::DepthImage;
use grid::{Grid, side_of_cells};
use nalgebra::{Vector2, Vector3};

/// The settings of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DetectionOptions {
    /// Limits of the radius and the direction of the axis.
    pub limits: CylinderLimits,
    /// Most cylinders.
    pub max_count: usize,
    /// Fewest pixels of a cylinder.
    pub min_pixels: usize,
    /// The least score.
    pub min_score: f64,
}

impl Default for DetectionOptions {
    fn default() -> Self {
        Self { limits: CylinderLimits::default(), max_count: usize::MAX, min_pixels: 100, min_score: 0.5 }
    }
}

impl DetectionOptions {
    /// Checks the values.
    ///
    /// # Errors
    /// `InvalidArgument`.
    pub fn check(&self) -> Result<()> {
        self.limits.check()?;
        if !(0.0..=1.0).contains(&self.min_score) {
            return Err(Error::argument("minimal score", self.min_score, "lie in [0, 1]"));
        }
        Ok(())
    }
}

/// One cylinder that was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detection {
    /// The cylinder.
    pub cylinder: Cylinder,
    /// The probability that there is a cylinder.
    pub score: f64,
    /// Pixels of its region.
    pub pixels: usize,
    /// What speaks for it.
    pub evidence: Evidence,
}

/// What was found in a scene.
#[derive(Debug, Clone, Default)]
pub struct Detections {
    /// The cylinders by falling score.
    pub cylinders: Vec<Detection>,
    /// For each pixel, row by row, the number of its cylinder in the order of `cylinders` from 1 on, or 0.
    pub labels: Vec<u16>,
}

/// Finds all cylinders in a depth image.
///
/// # Errors
/// `InvalidArgument`.
pub fn detect(camera: &Camera, depth: &DepthImage, options: &DetectionOptions) -> Result<Detections> {
    options.check()?;
    let (width, height) = camera.size();
    let intrinsics = camera.intrinsics();
    let pixel = 0.5 * (1.0 / intrinsics.fx + 1.0 / intrinsics.fy);
    let mut points: Vec<Vector3<f32>> = Vec::with_capacity(width * height);
    for row in 0..height {
        for column in 0..width {
            let point = depth.depth(column, row).and_then(|z| {
                camera.unproject(&Vector2::new(column as f64, row as f64)).map(|ray| (ray * z).cast::<f32>())
            });
            points.push(point.unwrap_or_default());
        }
    }
    let point = |x: usize, y: usize| {
        let p = points[y * width + x];
        (p.z > 0.0).then(|| p.cast::<f64>())
    };
    let mut grid = Grid::new((width, height), pixel, side_of_cells((width, height)), &point);
    let found = search::search(&mut grid, pixel, options);
    let ray = |x: usize, y: usize| camera.unproject(&Vector2::new(x as f64, y as f64));
    Ok(search::label(&grid, &found, (width, height), pixel, &point, &ray))
}

#[cfg(test)]
mod tests;
