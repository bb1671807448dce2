//! The finite extent of the visible cylinder (the paper's section 4.5.2) and what its ends look like.
//!
//! The paper takes the extreme points completed over the mask, so that one stray pixel of the mask moves an end.
//! Here the ends are located from all generators together, see [`crate::end_location`].

mod uncertainty;

#[cfg(test)]
mod scene;
#[cfg(test)]
mod tests;

use crate::completion::Region;
pub use crate::end_location::{ArcSample, EndSource, EndState};
use crate::end_location::{EndSearch, depth_tolerance, extreme_ends, locate_ends};
use crate::error::{Error, Result};
#[cfg(doc)]
use crate::fitter::ExtentRule;
use crate::fitter::image_noise;
use crate::fitter::{FitResult, Fitter};
use crate::geometry::Cylinder;
use crate::limb_location::blur_of;
use crate::observations::{GreyImage, MaskView};
use nalgebra::Vector3;
pub use uncertainty::ExtentUncertainty;

/// The settings of the extent.
#[derive(Debug, Clone, Copy, Default)]
pub struct ExtentOptions<'a> {
    /// The grey image, on the grid of the mask.
    pub image: Option<&'a GreyImage>,
    /// Whether the limbs of the model are good to a fraction of a pixel, so that the bias of the mask may be
    /// read off at them. `None`: when the last fit located a limb in the image, or passes within a pixel of the given
    /// segments.
    pub limbs_known: Option<bool>,
}

/// The visible piece of the cylinder: `end` = `start` + `length` · direction of the model. Lengths are in the
/// unit of the data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// c₀, the middle of the ends.
    pub center: Vector3<f64>,
    /// l_c, the distance of the ends.
    pub length: f64,
    /// The end against the direction.
    pub start: Vector3<f64>,
    /// The end along the direction.
    pub end: Vector3<f64>,
    /// What the start is.
    pub start_state: EndState,
    /// What the end is.
    pub end_state: EndState,
    /// What the position of the start was taken from.
    pub start_source: EndSource,
    /// What the position of the end was taken from.
    pub end_source: EndSource,
    /// Standard deviation of the position of the start along the axis, for a model without error; `None` for an
    /// extreme.
    pub start_deviation: Option<f64>,
    /// The same for the end.
    pub end_deviation: Option<f64>,
    /// The uncertainty of ends, centre and length together with that of the fit. It is that of the visible piece: of
    /// an end that is not [`EndState::Seen`] the cylinder may well go on. `None` for extremes, from inside a pipe, for
    /// a model that the caller gave, and when the fit has none.
    pub uncertainty: Option<ExtentUncertainty>,
}

impl Fitter {
    /// The extent in the image that was pushed. See [`Fitter::extent_with`].
    ///
    /// # Errors
    /// Those of [`Fitter::extent_with`].
    pub fn extent(&self, model: Option<&Cylinder>, mask: Option<&MaskView<'_>>) -> Result<Extent> {
        let options = ExtentOptions { image: self.image(), limbs_known: None };
        self.extent_with(model, mask, &options)
    }

    /// The ends of the visible cylinder, found by the [`ExtentRule`] of the options of the fitter. `model` and `mask` stand in for the last fit and the mask of the last
    /// depth image, which also tells what the ends are.
    ///
    /// # Errors
    /// `BadState` without a model, intrinsics or mask; `SizeMismatch`, `EmptyMask`; `EdgeGeometry` when no ray of
    /// the mask meets the cylinder.
    pub fn extent_with(
        &self,
        model: Option<&Cylinder>,
        mask: Option<&MaskView<'_>>,
        options: &ExtentOptions<'_>,
    ) -> Result<Extent> {
        Ok(self.extent_and_arcs(model, mask, options)?.0)
    }

    /// The same, and the places of the arcs of start and end in the grey image. They are empty for an end that the
    /// image did not show.
    ///
    /// # Errors
    /// Those of [`Fitter::extent_with`].
    pub fn extent_and_arcs(
        &self,
        model: Option<&Cylinder>,
        mask: Option<&MaskView<'_>>,
        options: &ExtentOptions<'_>,
    ) -> Result<(Extent, [Vec<ArcSample>; 2])> {
        let cylinder = self.model_or_result("finding the extent", model)?;
        let region = Region::new("finding the extent", self, mask)?;
        if let Some(image) = options.image {
            region.mask().check_size("grey image", (image.width(), image.height()))?;
        }
        let noise = image_noise(Some(region.camera));
        let search = EndSearch {
            camera: region.camera,
            mask: region.mask(),
            depth: self.depth(),
            image: options.image,
            tolerance: depth_tolerance(self.cloud(), &cylinder),
            limbs_known: options.limbs_known.unwrap_or_else(|| {
                // Limbs that pass that near to the segments are taken as known.
                let near = |rms: f64| rms <= noise.limb_of_segments();
                let known =
                    |result: &FitResult| result.limbs_located > 0 || result.edge_rms_pixels.is_some_and(near);
                self.result().is_some_and(known)
            }),
            noise,
            blur: self.limbs().and_then(blur_of),
        };
        let locates_ends = self.options().locates_ends();
        let ends =
            if locates_ends { locate_ends(&search, &cylinder) } else { extreme_ends(&search, &cylinder) };
        let ends = ends.ok_or_else(|| Error::EdgeGeometry {
            reason: "no ray of the mask meets the cylinder".into(),
            remedy: "check that mask and model belong to the same image",
        })?;
        // The error of a given model is not known.
        let fit = model.is_none().then(|| self.result()?.uncertainty).flatten();
        let uncertainty = fit.and_then(|fit| uncertainty::of_ends(&cylinder, &fit, &ends));
        let [start, end] = ends;
        let arcs = [start.samples, end.samples];
        let at = |position: f64| cylinder.axis.point + cylinder.axis.direction * position;
        let extent = Extent {
            center: at(0.5 * (start.position + end.position)),
            length: end.position - start.position,
            start: at(start.position),
            end: at(end.position),
            start_state: start.state,
            end_state: end.state,
            start_source: start.source,
            end_source: end.source,
            start_deviation: start.deviation,
            end_deviation: end.deviation,
            uncertainty,
        };
        Ok((extent, arcs))
    }
}
