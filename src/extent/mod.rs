//! The finite extent of the visible cylinder (the paper's section 4.5.2) and what its ends look like.
//!
//! The paper takes the extreme points completed over the mask, so that one stray pixel of the mask moves an end.
//! Here the ends are located from all generators together, see `src/end_location`. Where there is no mask, points tell them.

mod uncertainty;

#[cfg(test)]
mod scene;
#[cfg(test)]
mod tests;

use crate::camera::Camera;
use crate::completion::Region;
pub use crate::end_location::{ArcSample, EndSource, EndState};
use crate::end_location::{
    End, EndSearch, MaskContent, contains, depth_tolerance, ends_of_points, extreme_ends, locate_ends,
};
use crate::error::{Error, Result};
#[cfg(doc)]
use crate::fitter::ExtentRule;
use crate::fitter::{FitResult, Fitter, View};
use crate::geometry::{Cylinder, RigidMotion};
use crate::limb_location::blur_of;
use crate::memory::List;
use crate::observations::{Mask, MaskView};
use nalgebra::Vector3;
use std::ops::ControlFlow;
pub use uncertainty::ExtentUncertainty;

const CALL: &str = "finding the extent";

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
    /// Standard deviation of the position of the end along the axis, for a model without error; `None` for an extreme.
    pub end_deviation: Option<f64>,
    /// The view that tells most of the start.
    pub start_view: usize,
    /// The view that tells most of the end.
    pub end_view: usize,
    /// Whether the limbs of the model were taken as known in these views, so that the bias of the mask was read off at
    /// them.
    pub limbs_known: bool,
    /// The uncertainty of ends, centre and length together with that of the fit. It is that of the visible piece: of
    /// an end that is not [`EndState::Seen`] the cylinder may well go on. `None` for extremes, for a model that the caller
    /// gave, and when the fit has none.
    pub uncertainty: Option<ExtentUncertainty>,
}

/// The ends of one view, and what that view is.
struct EndsOfView {
    view: usize,
    into_view: RigidMotion,
    limbs_known: bool,
    ends: [End; 2],
}

impl Fitter {
    /// The ends of the visible cylinder in all views. In a view with a camera and a mask, the [`ExtentRule`] of the options finds them. A fit
    /// without a mask may have made an outline of the points; it then serves as the mask. In other views, and from inside a pipe, the
    /// points on the surface tell them. `model` stands in for the last fit, `mask` for the mask of the last
    /// depth image of the selected view; the depth image also tells what the ends are. An end that several views show is their mean by
    /// their variances; one that none shows is the outermost of where they lose it, by views with a mask if there are any.
    ///
    /// # Errors
    /// `BadState` without a model, without points or a mask, and for a mask that is given without intrinsics; `SizeMismatch`, `EmptyMask`;
    /// `EdgeGeometry` when no ray of a mask meets the cylinder and no points lie along it.
    pub fn extent(&self, model: Option<&Cylinder>, mask: Option<&MaskView<'_>>) -> Result<Extent> {
        self.memory().lend(|| Ok(self.find_extent(model, mask, None)?.0))
    }

    /// The ends of the visible cylinder in all views, as [`Fitter::extent`] gives them, and by view the samples of the arcs of
    /// start and end in its image. They are empty for an end that the image did not show.
    ///
    /// # Errors
    /// Those of [`Fitter::extent`].
    pub fn extent_and_arcs(
        &self,
        model: Option<&Cylinder>,
        mask: Option<&MaskView<'_>>,
    ) -> Result<(Extent, Vec<[Vec<ArcSample>; 2]>)> {
        self.memory().lend(|| {
            let (extent, views) = self.find_extent(model, mask, None)?;
            let mut arcs = vec![<[Vec<ArcSample>; 2]>::default(); self.view_count()];
            for EndsOfView { view, ends, .. } in &views {
                arcs[*view] = ends.each_ref().map(|end| end.samples.to_vec());
            }
            Ok((extent, arcs))
        })
    }

    /// The extent, and the ends that it was made of, by view.
    fn find_extent(
        &self,
        model: Option<&Cylinder>,
        mask: Option<&MaskView<'_>>,
        limbs_known: Option<bool>,
    ) -> Result<(Extent, List<EndsOfView>)> {
        let cylinder = self.model_or_result(CALL, model)?;
        let region = mask.map(|mask| Region::new(CALL, self, Some(mask))).transpose()?;
        let mut views = List::new();
        for index in 0..self.view_count() {
            let view = &self.views()[index];
            if let Some((camera, mask)) = view.camera().zip(view.mask.as_ref()) {
                mask.check_size("the image of the intrinsics", camera.size())?;
            }
            let own = region.as_ref().filter(|_| index == self.selected_view()).map(|region| &*region.mask);
            views.extend(self.ends_of(index, own, &cylinder, limbs_known));
        }
        if views.is_empty() {
            return Err(self.no_ends(mask.is_some()));
        }
        let [start, end] = [0, 1].map(|side| combine(&views, side));
        // The error of a given model is not known.
        let fit = model.is_none().then(|| self.result()?.uncertainty).flatten();
        let of_views = [&start, &end].map(|(end, of_view)| (end, of_view.into_view));
        let uncertainty = fit.and_then(|fit| uncertainty::of_ends(&cylinder, &fit, of_views));
        let axis = &cylinder.axis;
        let ((start, start_view), (end, end_view)) = (start, end);
        let extent = Extent {
            center: axis.at(0.5 * (start.position + end.position)),
            length: end.position - start.position,
            start: axis.at(start.position),
            end: axis.at(end.position),
            start_state: start.state,
            end_state: end.state,
            start_source: start.source,
            end_source: end.source,
            start_deviation: start.deviation,
            end_deviation: end.deviation,
            start_view: start_view.view,
            end_view: end_view.view,
            limbs_known: start_view.limbs_known && end_view.limbs_known,
            uncertainty,
        };
        Ok((extent, views))
    }

    /// Why no view has an end; a mask may have been given with the call.
    fn no_ends(&self, mask_given: bool) -> Error {
        let tells = |view: &View| view.mask.is_some() || !view.cloud.is_empty();
        if mask_given || self.views().iter().any(tells) {
            let reason = "no ray of a mask meets the cylinder, and no points lie along it".into();
            return Error::EdgeGeometry {
                reason,
                remedy: "check that model and data belong to the same view",
            };
        }
        Error::BadState { call: CALL, missing: "points or a mask", remedy: "push points, or give a mask" }
    }

    /// How many points in a row have errors that are alike, by the last fit or else by the points on this cylinder.
    fn alike(&self, cylinder: &Cylinder) -> f64 {
        let fit = self.result().copied().or_else(|| self.evaluate(cylinder).ok());
        fit.map_or(1.0, |fit| (fit.points_used as f64 / fit.independent_points).sqrt().max(1.0))
    }

    /// The ends of one view in a mask of its own, in that of the view as it was fitted, or else as its points show them.
    fn ends_of(
        &self,
        index: usize,
        own: Option<&Mask>,
        cylinder: &Cylinder,
        limbs_known: Option<bool>,
    ) -> Option<EndsOfView> {
        let (pushed, fitted) = (&self.views()[index], self.fitted_view(index));
        // A mask that was made of points has a frame of its own.
        let view = if own.is_none() && fitted.mask_of_points { fitted } else { pushed };
        let into_view = view.pose().inverse();
        let seen = into_view.cylinder(cylinder);
        let tolerance = depth_tolerance(&view.cloud, &seen);
        let masked = view.camera().zip(own.or(fitted.mask.as_ref()));
        // Rays along a pipe meet its wall anywhere.
        if masked.is_none() || seen.contains_origin() {
            let is_in_mask = |point: &Vector3<f64>| {
                let sees = |(camera, mask): (&Camera, &Mask)| {
                    camera.project(point).is_some_and(|pixel| contains(mask, &pixel))
                };
                masked.is_none_or(sees)
            };
            let points = view.cloud.points().filter(is_in_mask);
            if let Some(ends) = ends_of_points(points, &seen, tolerance, self.alike(cylinder)) {
                return Some(EndsOfView { view: index, into_view, limbs_known: false, ends });
            }
        }
        let (camera, mask) = masked?;
        let is_region = own.is_none() && view.is_body;
        let content = if is_region { MaskContent::Region } else { MaskContent::Anything };
        let noise = self.options().noise.in_image(camera.size());
        // Limbs that pass that near to the segments are taken as known.
        let near =
            |result: &FitResult| result.edge_rms_pixels.is_some_and(|rms| rms <= noise.limb_of_segments());
        let locates_ends = self.options().locates_ends();
        let search = EndSearch {
            camera,
            mask: if locates_ends { view.for_ends(mask) } else { mask },
            content,
            drawn: view.mask_is_drawn(),
            depth: view.depth(),
            image: view.image(),
            tolerance,
            limbs_known: limbs_known
                .unwrap_or_else(|| self.limbs_known(index) || self.result().is_some_and(near)),
            noise,
            blur: self.limbs_of(index).and_then(blur_of),
            last: [None; 2],
        };
        let ends = if locates_ends {
            locate_ends(&search, &seen, &mut || ControlFlow::Continue(())).continue_value().flatten()
        } else {
            extreme_ends(&search, &seen)
        };
        Some(EndsOfView { view: index, into_view, limbs_known: search.limbs_known, ends: ends? })
    }
}

/// One end by all views, and the view that tells most of it.
fn combine(views: &[EndsOfView], side: usize) -> (End, &EndsOfView) {
    let outward = [-1.0, 1.0][side];
    let end = |of_view: &EndsOfView| of_view.ends[side].clone();
    let seen = |of_view: &EndsOfView| of_view.ends[side].state == EndState::Seen;
    // Without depth beyond it, the image still shows an end.
    let shown = |of_view: &EndsOfView| {
        let end = &of_view.ends[side];
        seen(of_view) || end.state == EndState::Unknown && end.source == EndSource::Image
    };
    let showing = || views.iter().filter(|of_view| shown(of_view));
    let deviation = |of_view: &EndsOfView| of_view.ends[side].deviation.unwrap_or(f64::INFINITY);
    let best = showing().min_by(|a, b| {
        // What is seen says more about the state than what is shown.
        seen(b).cmp(&seen(a)).then(deviation(a).total_cmp(&deviation(b)))
    });
    let outermost = |a: &&EndsOfView, b: &&EndsOfView| {
        (outward * a.ends[side].position).total_cmp(&(outward * b.ends[side].position))
    };
    let Some(best) = best else {
        // Points are sparser than a mask. There is at least one view.
        let of_masks = views.iter().filter(|of_view| of_view.ends[side].source != EndSource::Points);
        let last = of_masks.max_by(outermost).or_else(|| views.iter().max_by(outermost)).unwrap_or(&views[0]);
        return (end(last), last);
    };
    let (mut information, mut sum) = (0.0, 0.0);
    for of_view in showing() {
        let weight = deviation(of_view).powi(-2);
        information += weight;
        sum += weight * of_view.ends[side].position;
    }
    if showing().count() == 1 || !(information > 0.0) {
        return (end(best), best);
    }
    let mean = End { position: sum / information, deviation: Some(information.sqrt().recip()), ..end(best) };
    (mean, best)
}
