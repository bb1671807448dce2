//! The fit of one region.

use super::{DetectorOptions, Found, mask_of, score};
use crate::detection::Detection;
use crate::error::{Error, Result};
use crate::fitter::{FitResult, Fitter, Options, StartKind};
use crate::geometry::{Cylinder, Line, RigidMotion};
use crate::observations::{Frame, MaskView, PointsView};
use std::ops::ControlFlow;

/// Tells whether to go on; asked before each linear solve.
pub(super) type Poll<'a> = dyn Fn() -> ControlFlow<()> + Sync + 'a;

/// What all fits of a scene share.
pub(super) struct Fits<'a> {
    options: &'a DetectorOptions,
    pub labels: Vec<u16>,
    pub size: (usize, usize),
}

impl<'a> Fits<'a> {
    pub fn new(options: &'a DetectorOptions, labels: Vec<u16>, size: (usize, usize)) -> Self {
        Self { options, labels, size }
    }

    /// The fit of a region of a frame, from the cylinder that was found, which is in the coordinates of the camera.
    pub fn of_frame(
        &self,
        frame: &Frame,
        index: usize,
        detection: &Detection,
        poll: &Poll<'_>,
    ) -> Result<Found> {
        let mut fitter = self.fitter()?;
        let mask = mask_of(&self.labels, index);
        fitter.use_frame(frame, Some(&MaskView::from_u8(&mask, self.size)?))?;
        let result = fit_or_keep(&mut fitter, &detection.cylinder, frame.pose(), poll)?;
        let score = match frame.image() {
            Some(_) => score::with_limbs(detection.score, result.limbs_located),
            None => detection.score,
        };
        Ok(found(fitter, score, detection, result))
    }

    /// The fit of a region of a cloud.
    pub fn of_points(
        &self,
        points: &PointsView<'_>,
        index: usize,
        detection: &Detection,
        poll: &Poll<'_>,
    ) -> Result<Found> {
        let mut fitter = self.fitter()?;
        let mask = mask_of(&self.labels, index);
        fitter.push_points(points, Some(&MaskView::from_u8(&mask, self.size)?))?;
        let result = fit_or_keep(&mut fitter, &detection.cylinder, &RigidMotion::identity(), poll)?;
        Ok(found(fitter, detection.score, detection, result))
    }

    fn fitter(&self) -> Result<Fitter> {
        let cylinder_limits = self.options.search.limits;
        let mut fitter = Fitter::new();
        fitter.set_options(Options { start: StartKind::Model, cylinder_limits, ..self.options.fit })?;
        Ok(fitter)
    }
}

fn found(mut fitter: Fitter, score: f64, detection: &Detection, result: FitResult) -> Found {
    let (extent, arcs) = match fitter.extent_and_arcs(None, None) {
        Ok((extent, mut arcs)) => (Ok(extent), arcs.pop().unwrap_or_default()),
        Err(error) => (Err(error), Default::default()),
    };
    fitter.swap_mask(None);
    Found { score, pixels: detection.pixels, result, extent, arcs, fitter }
}

/// Radii to start from, by the radius that was found: depth next to limbs may be off by this much, which is more than
/// the search for limbs in the image reaches.
const RADII: [f64; 3] = [1.0, 0.9, 1.1];

/// The fit that locates most limbs, or the detected cylinder where none locates any: depth alone is off next to the
/// limbs, which the detection allows for and a fit of all points does not.
fn fit_or_keep(
    fitter: &mut Fitter,
    seen: &Cylinder,
    pose: &RigidMotion,
    poll: &Poll<'_>,
) -> Result<FitResult> {
    let found = pose.cylinder(seen);
    let mut best: Option<(usize, Cylinder)> = None;
    for factor in if fitter.image().is_some() { &RADII[..] } else { &[] } {
        let radius = factor * found.radius;
        // The wall that is seen stays where it is.
        let away = seen.axis.nearest_to_origin().normalize() * (radius - found.radius);
        let axis = Line { point: seen.axis.point + away, ..seen.axis };
        let start = pose.cylinder(&Cylinder { axis, radius });
        let result = match fit_from(fitter, &start, poll) {
            Err(error @ Error::Cancelled { .. }) => return Err(error),
            Err(_) => continue,
            Ok(result) => result,
        };
        let change = found.compare(&result.cylinder);
        let same =
            change.radius_relative.abs() < 0.4 && change.angle < 0.3 && change.axis_distance < found.radius;
        if same && result.limbs_located > best.map_or(0, |(most, _)| most) {
            best = Some((result.limbs_located, start));
            if result.limbs_located == 2 {
                return Ok(result);
            }
        }
    }
    if let Some((_, start)) = best {
        return fit_from(fitter, &start, poll);
    }
    // The search allows for errors at the limits; what is returned keeps them.
    if !fitter.options().cylinder_limits.contain(&found) {
        return fit_from(fitter, &found, poll);
    }
    fitter.set_start(Some(found));
    fitter.keep(&found)
}

fn fit_from(fitter: &mut Fitter, start: &Cylinder, poll: &Poll<'_>) -> Result<FitResult> {
    fitter.set_start(Some(*start));
    fitter.fit_with(&mut |_| poll())
}
