//! The body among the pixels of a view without a mask, where the points are dense in the image: what a search finds there.

use super::among_points::weight;
use super::body::limits_in;
use super::run::Run;
use super::view::View;
use super::{Fitted, Fitter, Flags, MadeWith, StartKind};
use crate::detection::{DetectionOptions, detect_until, widened};
use crate::error::{Result, unless_cancelled};
use crate::geometry::Cylinder;
use crate::memory::List;
use std::cell::RefCell;

/// A body has this part of the points at least: in a whole scene it may be any of what is there.
pub(super) const LEAST_ON: f64 = 0.25;

/// All points are of the body where the search finds this part of them, which leaves out some beside the limbs: docs/measurements-masks.md,
/// "What lies about a body".
const ALL: f64 = 0.9;

/// A region of pixels that a search found.
struct Region {
    cylinder: Cylinder,
    /// Its points, by their numbers.
    points: List<usize>,
}

impl Fitter {
    /// The fit to the body that a search finds in the image grid of a view without mask and edges; `None` where it finds none.
    #[inline(never)] // Not inlined: its locals would enlarge the caller's stack frame.
    pub(super) fn fit_among_pixels(&self, run: &mut Run<'_>) -> Result<Option<Fitted>> {
        let Some(view) = self.searched_view() else { return Ok(None) };
        let Some(masked) = view.with_pixels_of_points() else { return Ok(None) };
        let Some(region) = self.likely_region(&masked, run)? else { return Ok(None) };
        let part = weight(&masked, region.points.iter().copied());
        if part >= ALL {
            return Ok(None);
        }
        let body = view.with_points(view.cloud.listed(&region.points), None);
        let fitter = self.fitter_to(&body, Some(&region.cylinder));
        let Ok(mut fit) = unless_cancelled(fitter.fit_as_pushed(false, run))? else { return Ok(None) };
        if part < LEAST_ON {
            fit.result.flags |= Flags::POOR_FIT;
        }
        let fitted = fit.made_with.bodies.first_mut().and_then(Option::take).unwrap_or(body);
        let made_with = MadeWith { bodies: std::iter::once(Some(fitted)).collect(), ..fit.made_with };
        Ok(Some(Fitted { made_with, ..fit }))
    }

    /// The only view, where a search may look for the body among its points: neither a mask or a detector has told the background, nor a
    /// start the body.
    pub(super) fn searched_view(&self) -> Option<&View> {
        let is_chosen = !matches!(self.options.start, StartKind::Auto | StartKind::Last);
        let [view] = &self.views[..] else { return None };
        let is_searched = self.options.is_robust() && !is_chosen && !view.tells_background();
        is_searched.then_some(view)
    }

    /// The region of the likely cylinder with most of the points, or of the one that is known.
    fn likely_region(&self, view: &View, run: &mut Run<'_>) -> Result<Option<Region>> {
        let (Some(camera), Some(depth)) = (view.camera(), view.depth()) else { return Ok(None) };
        let limits = widened(&limits_in(view, &self.options));
        let options = DetectionOptions { limits, ..DetectionOptions::default() };
        let run = RefCell::new(run);
        let stopped = || run.borrow_mut().report_again().is_break();
        let search = || {
            let depth = depth.within(view.frame.depth_range())?;
            let filled = depth.without_gaps()?;
            let found_by =
                |image| detect_until(camera, filled.as_ref().unwrap_or(&depth), image, &options, &stopped);
            // Edges of textures draw the search by the image; it finds what the depth alone does not tell.
            let found = found_by(None)?;
            if found.cylinders.is_empty() && view.image().is_some() {
                found_by(view.image())
            } else {
                Ok(found)
            }
        };
        let found = unless_cancelled(search())?.unwrap_or_default();
        let label_of = |pixel: &Option<usize>| pixel.and_then(|pixel| found.labels.get(pixel).copied());
        let pixels = view.pixels_of_points(camera);
        let labels: List<u16> = pixels.iter().map(|pixel| label_of(pixel).unwrap_or(0)).collect();
        let labels = &labels;
        let points_of = |label: u16| (0..labels.len()).filter(move |&k| labels[k] == label);
        // Of a cylinder that is known the region that is that, if it is among the points.
        let is_searched = self.known_is_among(view, labels.len());
        let may_be_meant =
            |&index: &usize| !is_searched || self.is_near_known(view, &found.cylinders[index].cylinder);
        let worth = |index: usize| found.cylinders[index].score * weight(view, points_of(index as u16 + 1));
        let best =
            (0..found.cylinders.len()).filter(may_be_meant).max_by(|&a, &b| worth(a).total_cmp(&worth(b)));
        Ok(best.map(|best| Region {
            cylinder: found.cylinders[best].cylinder,
            points: points_of(best as u16 + 1).collect(),
        }))
    }
}
