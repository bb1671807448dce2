//! Completion of the point cloud by the fitted model (the paper's section 4.5.1).

use crate::camera::Camera;
use crate::error::{Error, Result};
use crate::fitter::Fitter;
use crate::geometry::Cylinder;
use crate::observations::{Mask, MaskView};
use nalgebra::{Vector2, Vector3};

/// What became of the pixels of the mask.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CompletionCounts {
    /// Pixels whose ray meets the cylinder: completed points.
    pub hits: usize,
    /// Pixels whose ray passes the cylinder by.
    pub misses: usize,
    /// Pixels for which the camera model has no ray.
    pub outside_camera: usize,
}

impl Fitter {
    /// Casts the ray of every pixel of a mask and takes its first meeting with the cylinder: the near wall from
    /// outside, the far one from inside a pipe. `model` and `mask` stand in for the last fit and the mask of the
    /// last depth image. `emit` gets every pixel of the image, row by row, as (column, row, point), with `None`
    /// outside the mask and where no surface is met.
    ///
    /// # Errors
    /// `BadState` without a model, intrinsics or mask; `SizeMismatch` for a mask of another size than the image;
    /// `EmptyMask`.
    pub fn complete(
        &self,
        model: Option<&Cylinder>,
        mask: Option<&MaskView<'_>>,
        emit: &mut dyn FnMut(usize, usize, Option<Vector3<f64>>),
    ) -> Result<CompletionCounts> {
        let cylinder = self.model_or_result("completing the points", model)?;
        let region = Region::new("completing the points", self, mask)?;
        let mut counts = CompletionCounts::default();
        for row in 0..region.mask().height() {
            for column in 0..region.mask().width() {
                let point = if region.mask().contains(column, row) {
                    cast(region.camera, &cylinder, column, row, &mut counts)
                } else {
                    None
                };
                emit(column, row, point);
            }
        }
        Ok(counts)
    }
}

fn cast(
    camera: &Camera,
    cylinder: &Cylinder,
    column: usize,
    row: usize,
    counts: &mut CompletionCounts,
) -> Option<Vector3<f64>> {
    let Some(ray) = camera.unproject(&Vector2::new(column as f64, row as f64)) else {
        counts.outside_camera += 1;
        return None;
    };
    let hit = cylinder.first_hit(&ray);
    match hit {
        Some(_) => counts.hits += 1,
        None => counts.misses += 1,
    }
    hit
}

/// A camera and a mask on its image: what completion and extent look at.
pub(crate) struct Region<'a> {
    pub camera: &'a Camera,
    given: Option<Mask>,
    kept: Option<&'a Mask>,
}

impl<'a> Region<'a> {
    pub fn new(call: &'static str, fitter: &'a Fitter, mask: Option<&MaskView<'_>>) -> Result<Self> {
        let camera = fitter.camera().ok_or(Error::BadState {
            call,
            missing: "intrinsics",
            remedy: "set the intrinsics first",
        })?;
        let given = mask.map(Mask::copy).transpose()?;
        let kept = fitter.mask();
        if given.is_none() && kept.is_none() {
            let remedy = "give one, or push the depth image with one";
            return Err(Error::BadState { call, missing: "a mask", remedy });
        }
        let region = Self { camera, given, kept };
        region.mask().check_size("the image of the intrinsics", camera.size())?;
        Ok(region)
    }

    pub fn mask(&self) -> &Mask {
        match (&self.given, self.kept) {
            (Some(mask), _) | (None, Some(mask)) => mask,
            (None, None) => unreachable!("checked when the region was made"),
        }
    }
}
