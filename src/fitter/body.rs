//! Before a fit: what in the mask of each view is the body of the cylinder. The rest is left out of the fit.

use super::options::Options;
use super::view::View;
use crate::detection::detect_in_mask;

/// Fewest points of a body, as a part of those in the mask: with less the cylinder that was found is hardly the one that
/// was meant.
const LEAST_PART: f64 = 0.1;

/// The view with the points and the pixels of the body alone; `None` where all of them are, or nobody can tell.
pub(super) fn separate(view: &View, options: &Options) -> Option<View> {
    let (camera, depth, mask) = (view.camera()?, view.depth()?, view.mask.as_ref()?);
    let cylinder = detect_in_mask(camera, depth, mask, &options.cylinder_limits)?;
    let parts = view.parts(&cylinder, &options.noise)?;
    if parts.all_body() {
        return None;
    }
    let cloud = view.cloud.chosen(|index| parts.within(&view.cloud.point(index)));
    if (cloud.len() as f64) < LEAST_PART * view.cloud.len() as f64 {
        return None;
    }
    let body = parts.body(camera, mask)?;
    Some(View {
        frame: view.frame.clone(),
        mask: view.mask.clone(),
        body: Some(body),
        cloud,
        segments: view.segments.clone(),
    })
}
