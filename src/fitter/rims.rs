//! Lines that were located as limbs and are drawn to rims.
//!
//! Where the axis of a cylinder leads away from the camera its limbs are short, and the circle of an end leaves them slowly: of a radius
//! of 40 pixels by one pixel in nine. The clear edge of a cap draws the line away from a faint limb then, and the line is as sharp as
//! that edge, so that its stated deviation does not tell.

use super::data::{Data, ViewData};
use super::fit::AS_WELL;
use super::guided::Guided;
use super::located::{Located, fit_to, lines_of_view};
use super::run::Run;
use super::uncertainty::DISAGREEMENT;
use crate::error::Result;
use crate::geometry::Cylinder;
use crate::limb_location::{LimbLine, LimbObservation, LimbSample, NotVisible};
use nalgebra::Vector2;

/// A rim may be this many standard deviations from where the points end, as points tell an outline.
const DEVIATIONS: f64 = 2.0;

/// The fit to a single view without the line of one limb, where the fit to both leaves it and it is drawn to a rim. `None` where there is
/// none, and where the points do not lie on that cylinder as well.
#[inline(never)] // Not inlined: its locals would enlarge the caller's stack frame.
pub(super) fn without_rim(
    data: &Data<'_>,
    guided: &Guided,
    located: &Located,
    run: &mut Run<'_>,
) -> Result<Option<Located>> {
    let Located { minimum, constraints } = located;
    let ([view], [of_view]) = (&data.views[..], &constraints.views[..]) else { return Ok(None) };
    let Some(limbs) = of_view.limbs.as_ref().filter(|_| of_view.located == 2) else { return Ok(None) };
    let cylinder = view.seen(minimum.cylinder());
    let left = limbs.each_ref().map(|limb| limb.line.is_ok_and(|line| view.leaves(&line, &cylinder)));
    // Of two lines that are left either may be wrong.
    let drawn = (0..2).find(|&k| left[k] && !left[1 - k] && view.is_drawn_to_rim(&limbs[k], &cylinder));
    let Some(drawn) = drawn else { return Ok(None) };
    let mut limbs = limbs.clone();
    limbs[drawn].line = Err(NotVisible::OutOfReach);
    let found = fit_to(data, guided, &[lines_of_view(view, &limbs)], || 0.0, run)?;
    let as_well = found.filter(|found| found.minimum.scale() <= AS_WELL * minimum.scale());
    Ok(as_well.map(|mut found| {
        found.constraints.views[0].limbs = Some(limbs);
        found.constraints.settle(&found.minimum.scales);
        found
    }))
}

impl ViewData<'_> {
    /// Whether a cylinder, in the coordinates of the view, has no limb where a line was located for one, by more than its error and a
    /// pixel of the drawing.
    pub fn leaves(&self, line: &LimbLine, cylinder: &Cylinder) -> bool {
        let limit = (DISAGREEMENT * line.sigma).max(self.noise.pixel);
        let distances = self.camera().and_then(|camera| camera.distances_from_limbs(cylinder, &line.ends));
        distances.is_some_and(|of_limbs| of_limbs.iter().all(|distances| distances.amax() > limit))
    }

    /// Whether all pieces of a line that are beside the limbs of a cylinder are on the circle of one of its ends, or have it beside them
    /// on the surface.
    fn is_drawn_to_rim(&self, limb: &LimbObservation, cylinder: &Cylinder) -> bool {
        let Some(camera) = self.camera() else { return false };
        let Cylinder { axis, .. } = cylinder;
        let ends = self.range_of_points_on(cylinder);
        let pixel = camera.pixel_size();
        let [reach, beside] = [self.noise.limb_of_points, self.noise.pixel / 2.0];
        let is_beside = |sample: &&LimbSample| {
            let distances = camera.distances_from_limbs(cylinder, &[sample.position; 2]);
            distances.is_some_and(|of_limbs| of_limbs.iter().all(|distances| distances.amax() > beside))
        };
        // The point of the surface that is seen at a position.
        let seen = |at: Vector2<f64>| cylinder.first_hit(&camera.ideal_ray(&at));
        let has_rim = |sample: &LimbSample| {
            let hit = seen(sample.position)?;
            let middle = camera.ideal_pixel(&axis.at(axis.position_of(&hit)))?;
            let inward = (middle - sample.position).normalize();
            let positions = [hit, seen(sample.position + inward * reach)?].map(|hit| axis.position_of(&hit));
            let along = axis.direction.cross(&hit).norm() / hit.norm_squared();
            let tolerance = DEVIATIONS * reach * pixel / along;
            let [low, high] = [positions[0].min(positions[1]), positions[0].max(positions[1])];
            Some(ends.iter().any(|end| (low - tolerance..=high + tolerance).contains(end)))
        };
        let used = limb.samples.iter().filter(|sample| limb.uses(sample));
        let mut beside = used.filter(is_beside).peekable();
        beside.peek().is_some() && beside.all(|sample| has_rim(sample) == Some(true))
    }
}
