//! Completion of the point cloud by the fitted model (the paper's section 4.5.1).

use crate::camera::Camera;
use crate::error::{Error, Result};
use crate::fitter::Fitter;
use crate::geometry::Cylinder;
use crate::observations::{Mask, MaskView};
use nalgebra::Vector3;
use std::borrow::Cow;

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
    /// Casts the ray of every pixel of a mask of the selected view and takes its first meeting with the cylinder: the near
    /// wall from outside, the far one from inside a pipe. `model` and `mask` stand in for the last fit and the mask of the
    /// last depth image. `emit` gets every pixel of the image, row by row, as (column, row, point in the reference frame),
    /// with `None` outside the mask and where no surface is met.
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
        let pose = *self.pose();
        let emit = &mut |column, row, point: Option<Vector3<f64>>| {
            emit(column, row, point.map(|point| pose.point(&point)));
        };
        self.memory().lend(|| self.cast("completing the points", model, mask, emit))
    }

    /// Casts the rays of a mask as [`Fitter::complete`] does, and completes the depth image of the selected view: `emit` gets
    /// every pixel of the image, row by row, as (column, row, depth z along the axis of its camera), with `None` outside the
    /// mask and where no surface is met.
    ///
    /// # Errors
    /// Those of [`Fitter::complete`].
    pub fn complete_depth(
        &self,
        model: Option<&Cylinder>,
        mask: Option<&MaskView<'_>>,
        emit: &mut dyn FnMut(usize, usize, Option<f64>),
    ) -> Result<CompletionCounts> {
        let emit = &mut |column, row, point: Option<Vector3<f64>>| {
            emit(column, row, point.map(|point| point.z));
        };
        self.memory().lend(|| self.cast("completing the depth image", model, mask, emit))
    }

    /// Points in the coordinates of the view.
    fn cast(
        &self,
        call: &'static str,
        model: Option<&Cylinder>,
        mask: Option<&MaskView<'_>>,
        emit: &mut dyn FnMut(usize, usize, Option<Vector3<f64>>),
    ) -> Result<CompletionCounts> {
        let seen = self.view().seen(&self.model_or_result(call, model)?);
        let region = Region::new(call, self, mask)?;
        let mut counts = CompletionCounts::default();
        for row in 0..region.mask.height() {
            for column in 0..region.mask.width() {
                let inside = region.mask.contains(column, row);
                emit(column, row, inside.then(|| region.cast(&seen, column, row, &mut counts)).flatten());
            }
        }
        Ok(counts)
    }
}

/// A camera and a mask on its image: what completion and extent look at.
pub(crate) struct Region<'a> {
    pub camera: &'a Camera,
    pub mask: Cow<'a, Mask>,
}

impl<'a> Region<'a> {
    pub fn new(call: &'static str, fitter: &'a Fitter, mask: Option<&MaskView<'_>>) -> Result<Self> {
        let (missing, remedy) = match mask.is_some() || fitter.mask().is_some() {
            true => ("intrinsics", "set the intrinsics first"),
            false => ("intrinsics and a mask", "set the intrinsics and give a mask"),
        };
        let camera = fitter.camera().ok_or(Error::BadState { call, missing, remedy })?;
        let given = mask.map(Mask::copy).transpose()?.map(Cow::Owned);
        let mask = given.or_else(|| fitter.mask().map(Cow::Borrowed)).ok_or(Error::BadState {
            call,
            missing: "a mask",
            remedy: "give one, or push the depth image with one",
        })?;
        mask.check_size("the image of the intrinsics", camera.size())?;
        Ok(Self { camera, mask })
    }

    /// Where the ray of a pixel first meets a cylinder.
    fn cast(
        &self,
        cylinder: &Cylinder,
        column: usize,
        row: usize,
        counts: &mut CompletionCounts,
    ) -> Option<Vector3<f64>> {
        let Some(ray) = self.camera.ray_of_pixel(column, row) else {
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
}
