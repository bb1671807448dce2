//! The fit of one region of a frame, and what fits of regions of frames and clouds share.

use super::contests::Piece;
use super::labels::mask_of;
use super::work::WorkBudget;
use super::{DetectorOptions, Found};
use crate::detection::{Detection, DetectionOptions, Detections, Evidence, ONE_LIMB, with_odds_divided};
use crate::error::{Error, Result, unless_cancelled};
use crate::fitter::{FitResult, Fitter, Options, StartKind, Uncertainty};
use crate::geometry::{Cylinder, Line, RigidMotion};
use crate::observations::{Frame, MaskView};
use std::ops::ControlFlow;

/// Tells whether to go on; asked before each linear solve.
pub(super) type Poll<'a> = dyn Fn() -> ControlFlow<()> + Sync + 'a;

/// A fit to make.
pub(super) struct Task {
    /// The number of the cylinder that was found.
    pub cylinder: usize,
    /// Limbs of other cylinders, where there is none of its own.
    pub limbs_of_others: Vec<Piece>,
}

impl Task {
    /// Of a cylinder by itself.
    pub fn new(cylinder: usize) -> Self {
        Self { cylinder, limbs_of_others: Vec::new() }
    }
}

/// What all fits of a scene share.
pub(super) struct Fits<'a> {
    pub options: &'a DetectorOptions,
    pub seen: Detections,
    pub size: (usize, usize),
    /// The odds that what was found is none add up over so many looks.
    pub tries: f64,
}

impl<'a> Fits<'a> {
    pub fn new(options: &'a DetectorOptions, seen: Detections, size: (usize, usize)) -> Self {
        Self { options, seen, size, tries: 1.0 }
    }

    /// After other looks at the same scene.
    pub fn after(self, tries: f64) -> Self {
        Self { tries, ..self }
    }

    /// Whether a cylinder may be returned, whatever its fit comes to. The search counts the pixels of cells, measured or not.
    pub fn may_stay(&self, cylinder: usize) -> bool {
        let Detection { pixels, evidence, .. } = &self.seen.cylinders[cylinder];
        let DetectionOptions { min_score, min_pixels, .. } = self.options.search;
        *pixels >= min_pixels
            && evidence.may_reach(min_score)
            && with_odds_divided(evidence.highest_after_fit(), self.tries) >= min_score
    }

    /// The fit of a region of a frame, from the cylinder that was found, which is in the coordinates of the camera; without a
    /// share that cylinder.
    pub fn of_frame(
        &self,
        frame: &Frame,
        task: &Task,
        budget: Option<&WorkBudget<'_>>,
    ) -> Result<Box<Found>> {
        let detection = &self.seen.cylinders[task.cylinder];
        let mut fitter = self.fitter()?;
        let mask = mask_of(&self.seen.labels, task.cylinder);
        fitter.use_frame(frame, Some(&MaskView::from_u8(&mask, self.size)?))?;
        // A region has the pixels that see the surface alone.
        fitter.know_as_body();
        fitter.know_limbs_of_others(&task.limbs_of_others);
        let limb = frame.image().and(frame.camera()).map_or(0.0, |camera| {
            let [first, last] = detection.along;
            (last - first) * camera.intrinsics().fx / detection.cylinder.axis.point.z
        });
        let result = self.fit_within(&mut fitter, detection, frame.pose(), budget, limb)?;
        let fitted = frame.pose().inverse().cylinder(&result.cylinder);
        // Of a cylinder that was kept the limbs are those of a fit that was refused.
        let taper = result.termination.and(result.taper);
        let slope = taper.map(|taper| [taper.slope, taper.deviation]);
        // The score asks how well the data determine a radius, not how far they are from one that was kept.
        let deviation = match result.termination {
            Some(_) => radius_deviation(&result),
            None => radius_deviation(&fitter.evaluate(&result.cylinder)?),
        };
        let evidence = self.seen.evidence_of_fit(detection, &fitted, deviation, slope);
        Ok(found(fitter, evidence, detection, &result))
    }

    /// The fit within a budget, limbs in an image being so many pixels long; without one the cylinder that was found.
    pub(super) fn fit_within(
        &self,
        fitter: &mut Fitter,
        detection: &Detection,
        pose: &RigidMotion,
        budget: Option<&WorkBudget<'_>>,
        limb: f64,
    ) -> Result<Box<FitResult>> {
        if let Some(budget) = budget {
            budget.set_region(detection.pixels, limb);
            return self.fit_or_keep(fitter, detection, pose, budget).map(Box::new);
        }
        let found = pose.cylinder(&detection.cylinder);
        if !fitter.options().cylinder_limits.contain(&found) {
            let reason = "the cylinder that the search found is not within the limits".into();
            return Err(Error::NoStart { reason });
        }
        fitter.set_start(Some(found));
        fitter.keep(&found).map(Box::new)
    }

    /// The fit with the best covered limbs, or the detected cylinder where that is covered better, or no limb is
    /// located: depth alone is off next to the limbs, which the detection allows for and a fit of all points does not.
    fn fit_or_keep(
        &self,
        fitter: &mut Fitter,
        detection: &Detection,
        pose: &RigidMotion,
        budget: &WorkBudget<'_>,
    ) -> Result<FitResult> {
        let seen = &detection.cylinder;
        let found = pose.cylinder(seen);
        let covered = |cylinder: &Cylinder| self.seen.covered(detection, cylinder).iter().sum::<f64>();
        let before = covered(seen);
        let held = before >= ONE_LIMB.get();
        let radii = match (fitter.image(), fitter.depth()) {
            // Depth images are drawn out next to limbs, and clouds may be anything: a fit tells.
            (None, Some(_)) => &[],
            (Some(_), _) if !held => &RADII[..],
            _ => &RADII[..1],
        };
        let pixel = fitter.camera().map_or(0.0, |camera| 1.0 / camera.intrinsics().fx);
        let reach =
            f64::max(RADIUS_CHANGE.get(), RADIUS_PIXELS.get() * pixel * seen.axis.point.z / seen.radius);
        let attempts = self.attempts();
        // The best so far, and that from the cylinder itself: the fitter as it left it, and its result.
        let mut best: Option<(f64, Box<(Fitter, FitResult)>)> = None;
        let mut plain = None;
        let mut known = Vec::new();
        for factor in radii.iter().take(attempts) {
            let start = pose.cylinder(&with_radius(seen, factor * seen.radius));
            let fit = fit_from(fitter, &start, budget, &mut known);
            let Ok(result) = unless_cancelled(fit)? else { continue };
            let change = found.compare(&result.cylinder);
            let same = (change.radius_relative.abs() < reach || told_twice(&result))
                && change.angle < DIRECTION_CHANGE.get()
                && change.axis_distance < AXIS_CHANGE.get() * found.radius;
            let after = covered(&pose.inverse().cylinder(&result.cylinder));
            if fitter.image().is_none() && same {
                return Ok(result);
            }
            if !same || result.limbs_located == 0 {
                continue;
            }
            if *factor == 1.0 {
                plain = Some(copied(fitter, result));
            }
            if after + LOCATED.get() * (result.limbs_located as f64) < before {
                continue;
            }
            let quality = after + LOCATED.get() * result.limbs_located as f64;
            if quality > best.as_ref().map_or(0.0, |(most, ..)| *most) {
                if held || quality >= GOOD.get() {
                    return Ok(result);
                }
                best = Some((quality, copied(fitter, result)));
            }
        }
        if let Some((_, best)) = best {
            let (of_best, result) = *best;
            *fitter = of_best;
            return Ok(result);
        }
        kept(fitter, &found, plain, budget)
    }

    /// How many fits a cylinder may take.
    pub(super) fn attempts(&self) -> usize {
        (MOST_FITS / self.seen.cylinders.len().max(1)).max(1)
    }

    #[inline(never)] // It is on the stack here alone.
    pub(super) fn fitter(&self) -> Result<Box<Fitter>> {
        let cylinder_limits = self.options.search.limits;
        let mut fitter = Box::new(Fitter::new());
        fitter.set_options(Options { start: StartKind::Model, cylinder_limits, ..self.options.fit })?;
        Ok(fitter)
    }
}

/// A cylinder with another radius. The wall that is seen stays where it is; where the axis goes through the origin, the axis does.
fn with_radius(seen: &Cylinder, radius: f64) -> Cylinder {
    let away = seen.axis.nearest_to_origin().try_normalize(0.0).unwrap_or_default();
    let away = away * (radius - seen.radius);
    Cylinder { axis: Line { point: seen.axis.point + away, ..seen.axis }, radius }
}

/// Whether points and both limbs tell the radius alike, the points alone better than that of the search is known.
fn told_twice(result: &FitResult) -> bool {
    result.limbs_located == 2
        && result.radii.is_some_and(|radii| {
            radii.z_score().abs() < AGREEMENT.get()
                && radii.from_points_deviation < RADIUS_CHANGE.get() * result.cylinder.radius
        })
}

/// Standard deviation of the radius as a part of it, infinite where it is not known.
pub(super) fn radius_deviation(result: &FitResult) -> f64 {
    let deviation = result.uncertainty.as_ref().map_or(f64::INFINITY, Uncertainty::radius);
    deviation / result.cylinder.radius
}

// Apart and boxed, so that what it holds takes no stack below the fits.
#[inline(never)]
pub(super) fn found(
    mut fitter: Box<Fitter>,
    evidence: Evidence,
    detection: &Detection,
    result: &FitResult,
) -> Box<Found> {
    let (extent, arcs) = match fitter.extent_and_arcs(None, None) {
        Ok((extent, mut arcs)) => (Ok(extent), arcs.pop().unwrap_or_default()),
        Err(error) => (Err(error), Default::default()),
    };
    fitter.swap_mask(None);
    fitter.free_memory();
    let (score, pixels) = (evidence.score(), detection.pixels);
    Box::new(Found {
        score,
        evidence,
        pixels,
        result: *result,
        extent,
        arcs,
        fitter: *fitter,
        region: Vec::new(),
        body: Vec::new(),
    })
}

/// Radii to start from, by the radius that was found: depth next to limbs may be off by this much, which is more than
/// the search for limbs in the image reaches.
const RADII: [f64; 3] = [1.0, 0.9, 1.1];

/// Fits of a scene, beyond which each cylinder gets one alone: a bound on the time.
const MOST_FITS: usize = 40;

constants! {
    /// How far the radius of a fit may be from that which was found: a part of it, or pixels of the image, whichever is more.
    /// What is farther off is another pair of edges.
    RADIUS_CHANGE = 0.15, "radius";
    RADIUS_PIXELS = 3.0, "px";

    /// Radii that differ by less than this many standard deviations agree.
    AGREEMENT = 2.0, "σ";

    /// How far the fit may turn from the cylinder that was found, and move off its axis.
    DIRECTION_CHANGE = 0.3, "rad";
    AXIS_CHANGE = 1.0, "radius";

    /// What a located limb counts, where edges that cover one whole count 1.
    LOCATED = 0.5, "limb";

    /// A fit is good where limbs count as much.
    GOOD = 2.0, "limb";
}

/// A fitter as it is and its result. They are on the stack here alone, not while the next fit runs.
#[inline(never)]
fn copied(fitter: &Fitter, result: FitResult) -> Box<(Fitter, FitResult)> {
    Box::new((fitter.clone(), result))
}

/// What is returned where no fit covers the limbs better: the detected cylinder, or the `plain` fit from it where limbs are
/// located at the detected one.
fn kept(
    fitter: &mut Fitter,
    found: &Cylinder,
    plain: Option<Box<(Fitter, FitResult)>>,
    budget: &WorkBudget<'_>,
) -> Result<FitResult> {
    // The search allows for errors at the limits; what is returned keeps them.
    if !fitter.options().cylinder_limits.contain(found) {
        return fit_from(fitter, found, budget, &mut Vec::new());
    }
    fitter.set_start(Some(*found));
    let kept = fitter.keep(found)?;
    match plain {
        // Limbs that are located at the cylinder itself draw it away.
        Some(plain) if kept.limbs_located > 0 => {
            let (of_plain, result) = *plain;
            *fitter = of_plain;
            Ok(result)
        }
        _ => Ok(kept),
    }
}

fn fit_from(
    fitter: &mut Fitter,
    start: &Cylinder,
    budget: &WorkBudget<'_>,
    known: &mut Vec<Cylinder>,
) -> Result<FitResult> {
    budget.begin();
    fitter.set_start(Some(*start));
    fitter.fit_counted(&mut |_| budget.ask(), &|| budget.poll_cancel(), known)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn another_radius_keeps_the_wall_that_is_seen_or_an_axis_through_the_origin() {
        let seen = |z: f64| Cylinder::new(Vector3::new(0.0, 0.0, z), Vector3::y(), 0.1).unwrap();
        assert_eq!(with_radius(&seen(1.0), 0.3).axis.point, Vector3::new(0.0, 0.0, 1.2));
        assert_eq!(with_radius(&seen(0.0), 0.3), Cylinder { radius: 0.3, ..seen(0.0) });
    }
}
