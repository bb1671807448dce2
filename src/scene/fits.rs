//! The fit of one region.

use super::contests::Piece;
use super::labels::{indices_of, mask_of};
use super::work::Share;
use super::{DetectorOptions, Found};
use crate::detection::{
    Band, Detection, DetectionOptions, Detections, Evidence, Looks, grown, is_round, reach_of,
    with_odds_divided,
};
use crate::error::{Error, Result, unless_cancelled};
use crate::fitter::{FitResult, Fitter, Flags, Options, StartKind, Uncertainty};
use crate::geometry::{Cylinder, Line, RigidMotion};
use crate::memory::apart;
use crate::observations::{Frame, MaskView, PointsView};
use crate::statistics::{ends_of, median};
use nalgebra::Vector3;
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
    options: &'a DetectorOptions,
    pub seen: Detections,
    pub size: (usize, usize),
    /// The odds that what was found is none add up over so many looks.
    tries: f64,
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
    pub fn of_frame(&self, frame: &Frame, task: &Task, share: Option<&Share<'_>>) -> Result<Box<Found>> {
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
        let result = self.fit_within(&mut fitter, detection, frame.pose(), share, limb)?;
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

    /// The fit of a region of a cloud; without a share the cylinder that was found. Where a region may be a part of its body it grows
    /// over the points that belong to no other yet.
    pub fn of_points(
        &self,
        points: &PointsView<'_>,
        looks: &Looks,
        task: &Task,
        share: Option<&Share<'_>>,
    ) -> Result<Box<Found>> {
        let mut detection = self.seen.cylinders[task.cylinder];
        let of_look = indices_of(&self.seen.labels, task.cylinder);
        let mut region: Vec<u32> = of_look.map(|k| looks.in_all(k)).collect();
        // With very many points each step takes as long as several of a fit.
        let check = |iterations| match share {
            Some(share) if share.poll_cancel().is_break() => Err(Error::Cancelled { iterations }),
            _ => Ok(()),
        };
        let rounds = if self.seen.whole || share.is_none() { 0 } else { ROUNDS };
        let mut last = None;
        for _ in 0..rounds {
            let few = thinned(&region);
            let seen = Detection { pixels: few.len(), ..detection };
            let fit = self.of_region(points, looks, &few, &seen, share)?;
            let cylinder = fit.1.cylinder;
            last = Some(fit);
            // A body may have many points, for which no memory is kept.
            let next = apart(|| {
                let reach = reach_of(&cylinder, places_of(looks, &region));
                grown(&cylinder, reach, places_of(looks, &region), looks.near(&cylinder, reach))
            });
            check(0)?;
            detection.cylinder = cylinder;
            if next.len() < FEWEST {
                break;
            }
            let settled = next.len().abs_diff(region.len()) as f64 <= SETTLED * region.len() as f64;
            region = next;
            detection.pixels = region.len();
            if settled {
                break;
            }
        }
        let mut is_one =
            self.seen.whole || apart(|| is_round(&detection.cylinder, places_of(looks, &region)));
        // Errors that neighbours share look like a surface that is not round.
        let is_lenient = self.seen.whole && !self.seen.independent;
        check(0)?;
        let mut body = Vec::new();
        if rounds > 0
            && !is_one
            && let Some((piece, cylinder)) = self.round_piece(points, looks, (&region, &detection), share)?
        {
            body = std::mem::replace(&mut region, piece);
            is_one = true;
            detection = Detection { cylinder, pixels: region.len(), ..detection };
        }
        // What is none has a score of 0. It needs no fit to all of its points but where that is enough to be returned.
        let is_returned = is_one || self.options.search.min_score == 0.0;
        if let Some((fitter, result)) = last
            && !is_returned
        {
            let mut none = found(fitter, detection.evidence, &detection, &result);
            none.score = 0.0;
            return Ok(none);
        }
        let (fitter, result) = self.of_region(points, looks, &region, &detection, share)?;
        check(result.iterations)?;
        // The score asks how well all points of the region determine the radius.
        let mut whole = self.fitter()?;
        whole.push_numbered(points, region.iter().map(|&k| looks.given(k)))?;
        let deviation = radius_deviation(&whole.evaluate(&result.cylinder)?);
        let evidence = self.seen.evidence_of_fit(&detection, &result.cylinder, deviation, None);
        let mut found = found(fitter, evidence, &detection, &result);
        // A box within the reach of a cylinder is none.
        let is_poor = || found.result.flags.contains(Flags::POOR_FIT);
        let fits = || apart(|| is_round(&found.result.cylinder, places_of(looks, &region)));
        let is_one = is_one && (is_lenient || !is_poor() && (!self.seen.whole || fits()));
        found.score = if is_one { with_odds_divided(found.score, self.tries) } else { 0.0 };
        (found.region, found.body) = (region, body);
        Ok(found)
    }

    /// A piece of a long body that bends or tapers, such as a trunk, for which it is a cylinder: half of it about the middle of its points,
    /// half of that, and so on. `None` where none is.
    #[inline(never)] // Frames of ways that are not taken need no stack.
    fn round_piece(
        &self,
        points: &PointsView<'_>,
        looks: &Looks,
        (region, detection): (&[u32], &Detection),
        share: Option<&Share<'_>>,
    ) -> Result<Option<(Vec<u32>, Cylinder)>> {
        let (mut piece, mut cylinder) = (region.to_vec(), detection.cylinder);
        loop {
            let positions: Vec<f64> =
                places_of(looks, &piece).map(|point| cylinder.axis.position_of(&point)).collect();
            let [first, last] = ends_of(&positions);
            let half = 0.25 * (last - first);
            let middle = median(&mut positions.clone());
            let mut inside = positions.iter().map(|position| (position - middle).abs() <= half);
            piece.retain(|_| inside.next().unwrap_or(false));
            if 2.0 * half < LONG * cylinder.radius || piece.len() < FEWEST {
                return Ok(None);
            }
            let few = thinned(&piece);
            let seen = Detection { cylinder, pixels: few.len(), ..*detection };
            cylinder = self.of_region(points, looks, &few, &seen, share)?.1.cylinder;
            if apart(|| is_round(&cylinder, places_of(looks, &piece))) {
                return Ok(Some((piece, cylinder)));
            }
        }
    }

    /// The fit of a region of a cloud, by the numbers of its points.
    fn of_region(
        &self,
        points: &PointsView<'_>,
        looks: &Looks,
        region: &[u32],
        detection: &Detection,
        share: Option<&Share<'_>>,
    ) -> Result<(Box<Fitter>, Box<FitResult>)> {
        let fit = |chosen: &[u32]| {
            let mut fitter = self.fitter()?;
            fitter.push_numbered(points, chosen.iter().map(|&k| looks.given(k)))?;
            fitter.know_as_body();
            let result = self.fit_within(&mut fitter, detection, &RigidMotion::identity(), share, 0.0)?;
            Ok((fitter, result))
        };
        let middle = |cylinder: &Cylinder| self.middle(looks, region, cylinder);
        let mut chosen = middle(&detection.cylinder);
        let (mut fitter, mut result) = fit(chosen.as_deref().unwrap_or(region))?;
        // Which points lie in the middle follows from the radius.
        for _ in 1..share.map_or(1, |_| ROUNDS.min(self.attempts())) {
            let next = middle(&result.cylinder);
            if next.is_none() || next == chosen {
                break;
            }
            chosen = next;
            (fitter, result) = fit(chosen.as_deref().unwrap_or(region))?;
        }
        Ok((fitter, result))
    }

    /// The points of a region, by their numbers, between the parts next to the limbs, which structured light and
    /// stereo draw out; `None` where they were seen from more than one place, or from inside, where there are no limbs, and where
    /// little or less than half of the region would be left.
    fn middle(&self, looks: &Looks, region: &[u32], cylinder: &Cylinder) -> Option<Vec<u32>> {
        let place = self.seen.seen_from?;
        let axis = Line { point: cylinder.axis.point - place, ..cylinder.axis };
        let seen = Cylinder { axis, ..*cylinder };
        if seen.contains_origin() {
            return None;
        }
        let band = Band::new(&seen, MIDDLE);
        let inner = region.iter().copied().filter(|&k| band.contains(&(looks.place(k) - place)));
        let middle: Vec<u32> = inner.collect();
        (middle.len() >= FEWEST && 2 * middle.len() > region.len()).then_some(middle)
    }

    /// The fit by a share, limbs in an image being so many pixels long; without one the cylinder that was found.
    fn fit_within(
        &self,
        fitter: &mut Fitter,
        detection: &Detection,
        pose: &RigidMotion,
        share: Option<&Share<'_>>,
        limb: f64,
    ) -> Result<Box<FitResult>> {
        if let Some(share) = share {
            share.set_region(detection.pixels, limb);
            return self.fit_or_keep(fitter, detection, pose, share).map(Box::new);
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
        share: &Share<'_>,
    ) -> Result<FitResult> {
        let seen = &detection.cylinder;
        let found = pose.cylinder(seen);
        let covered = |cylinder: &Cylinder| self.seen.covered(detection, cylinder).iter().sum::<f64>();
        let before = covered(seen);
        let held = before >= COVERED;
        let radii = match (fitter.image(), fitter.depth()) {
            // Depth images are drawn out next to limbs, and clouds may be anything: a fit tells.
            (None, Some(_)) => &[],
            (Some(_), _) if !held => &RADII[..],
            _ => &RADII[..1],
        };
        let pixel = fitter.camera().map_or(0.0, |camera| 1.0 / camera.intrinsics().fx);
        let reach = f64::max(RADIUS_CHANGE, RADIUS_PIXELS * pixel * seen.axis.point.z / seen.radius);
        let attempts = self.attempts();
        // The best so far, and that from the cylinder itself: the fitter as it left it, and its result.
        let mut best: Option<(f64, Box<(Fitter, FitResult)>)> = None;
        let mut plain = None;
        let mut known = Vec::new();
        for factor in radii.iter().take(attempts) {
            let start = pose.cylinder(&with_radius(seen, factor * seen.radius));
            let fit = fit_from(fitter, &start, share, &mut known);
            let Ok(result) = unless_cancelled(fit)? else { continue };
            let change = found.compare(&result.cylinder);
            let same = (change.radius_relative.abs() < reach || told_twice(&result))
                && change.angle < 0.3
                && change.axis_distance < found.radius;
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
            if after + 0.5 * (result.limbs_located as f64) < before {
                continue;
            }
            let quality = after + 0.5 * result.limbs_located as f64;
            if quality > best.as_ref().map_or(0.0, |(most, ..)| *most) {
                if held || quality >= COVERED + 1.0 {
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
        kept(fitter, &found, plain, share)
    }

    /// How many fits a cylinder may take.
    fn attempts(&self) -> usize {
        (MOST_FITS / self.seen.cylinders.len().max(1)).max(1)
    }

    #[inline(never)] // It is on the stack here alone.
    fn fitter(&self) -> Result<Box<Fitter>> {
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
            radii.z_score().abs() < AGREEMENT
                && radii.from_points_deviation < RADIUS_CHANGE * result.cylinder.radius
        })
}

/// Points of a region, spread over all of it, that lead to its body.
fn thinned(region: &[u32]) -> Vec<u32> {
    region.iter().copied().step_by(region.len().div_ceil(ENOUGH).max(1)).collect()
}

/// Where the points of a region lie.
fn places_of(looks: &Looks, region: &[u32]) -> impl ExactSizeIterator<Item = Vector3<f64>> + Clone {
    region.iter().map(|&k| looks.place(k))
}

/// Standard deviation of the radius as a part of it, infinite where it is not known.
fn radius_deviation(result: &FitResult) -> f64 {
    let deviation = result.uncertainty.as_ref().map_or(f64::INFINITY, Uncertainty::radius);
    deviation / result.cylinder.radius
}

// Apart and boxed, so that what it holds takes no stack below the fits.
#[inline(never)]
fn found(
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

/// How far from the axis points of a cloud are fitted, in radii. On ../shared/scenes, fits to the true regions between 1, 0.85 and
/// 0.7 radii find pipes 5.9, 2.0 and −0.9 % too wide, cylinders on tables 3.3, 1.1 and −0.8 %.
const MIDDLE: f64 = 0.7;

/// Fewest points in the middle of a region that are fitted alone.
const FEWEST: usize = 50;

/// Fits to the middle of a region, at most: the radius settles in three or four.
const ROUNDS: usize = 4;

/// Points that are enough to grow a region by.
const ENOUGH: usize = 10_000;

/// A piece of a body that bends or tapers is at least so many radii long: shorter ones of what is no cylinder may pass for one.
const LONG: f64 = 6.0;

/// A region has settled where its points change by this part.
const SETTLED: f64 = 0.02;

/// Fits of a scene, beyond which each cylinder gets one alone: a bound on the time.
const MOST_FITS: usize = 40;

/// The parts of both limbs together that edges of the image cover where they hold the radius.
const COVERED: f64 = 1.0;

/// How far the radius of a fit may be from that which was found: a part of it, or pixels of the image, whichever is more.
/// What is farther off is another pair of edges.
const RADIUS_CHANGE: f64 = 0.15;
const RADIUS_PIXELS: f64 = 3.0;

/// Radii that differ by less than this many standard deviations agree.
const AGREEMENT: f64 = 2.0;

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
    share: &Share<'_>,
) -> Result<FitResult> {
    // The search allows for errors at the limits; what is returned keeps them.
    if !fitter.options().cylinder_limits.contain(found) {
        return fit_from(fitter, found, share, &mut Vec::new());
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
    share: &Share<'_>,
    known: &mut Vec<Cylinder>,
) -> Result<FitResult> {
    share.begin();
    fitter.set_start(Some(*start));
    fitter.fit_counted(&mut |_| share.ask(), &|| share.poll_cancel(), known)
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
