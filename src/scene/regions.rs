//! The fits of regions of clouds.

use super::fits::{Fits, Task, found, radius_deviation};
use super::labels::indices_of;
use super::results::Found;
use super::work::WorkBudget;
use crate::detection::{Band, Detection, Looks, SETTLED, grown, is_round, with_odds_divided};
use crate::error::{Error, Result, unless_cancelled};
use crate::fitter::{FitResult, Fitter, Flags, contradict, is_as_good, off_planes};
use crate::geometry::{Cylinder, Line, RigidMotion};
use crate::memory::apart;
use crate::observations::PointsView;
use crate::statistics::{median, min_max};
use nalgebra::Vector3;

constants! {
    /// How far from the axis points of a cloud are fitted, in radii. On ../shared/scenes, fits to the true regions between 1, 0.85 and
    /// 0.7 radii find pipes 5.9, 2.0 and −0.9 % too wide, cylinders on tables 3.3, 1.1 and −0.8 %.
    MIDDLE = 0.7, "radius";

    /// Where this part of the points in the middle is independent no window has matched them, and none are drawn out.
    INDEPENDENT = 0.5, "";

    /// Fewest points in the middle of a region that are fitted alone.
    FEWEST = 50.0, "points";

    /// A piece of a body that bends or tapers is at least so many radii long: shorter ones of what is no cylinder may pass for one.
    LONG = 6.0, "radius";

    /// What is nearer to the surface of a body than this part of its radius may belong to it: it may taper, bend or have bark.
    UNEVEN = 0.15, "radius";
}

/// Fits to the middle of a region, at most: the radius settles in three or four.
const ROUNDS: usize = 4;

/// Points that are enough to grow a region by.
const ENOUGH_POINTS_TO_GROW: usize = 10_000;

/// A fit: the fitter as it left it, and its result.
type Fit = (Box<Fitter>, Box<FitResult>);

/// A region that grows over its body.
struct Growth {
    /// Its points, by their numbers.
    region: Vec<u32>,
    /// Its cylinder.
    detection: Detection,
    /// The fit by which it has grown.
    last: Option<Fit>,
}

impl Fits<'_> {
    /// The fit of a region of a cloud; without a budget the cylinder that was found. Where a region may be a part of its body it grows
    /// over the points that belong to no other yet.
    pub fn of_points(
        &self,
        points: &PointsView<'_>,
        looks: &Looks,
        task: &Task,
        budget: Option<&WorkBudget<'_>>,
    ) -> Result<Box<Found>> {
        let of_look = indices_of(&self.seen.labels, task.cylinder);
        let seen = Growth {
            region: of_look.map(|k| looks.in_all(k)).collect(),
            detection: self.seen.cylinders[task.cylinder],
            last: None,
        };
        let rounds = if self.seen.whole || budget.is_none() { 0 } else { ROUNDS };
        let Growth { mut region, mut detection, last } = self.grow(points, looks, seen, rounds, budget)?;
        let mut is_one =
            self.seen.whole || apart(|| is_round(&detection.cylinder, points_of(looks, &region)));
        // Errors that neighbours share look like a surface that is not round.
        let is_lenient = self.seen.whole && !self.seen.independent;
        go_on(budget, 0)?;
        let mut body = Vec::new();
        if rounds > 0
            && !is_one
            && let Some((piece, cylinder)) = self.round_piece(points, looks, (&region, &detection), budget)?
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
        let fit = self.of_region(points, looks, &region, &detection, budget)?;
        go_on(budget, fit.1.iterations)?;
        let (fitter, result);
        ((fitter, result), region) = self.off_planes(points, looks, (fit, region), &detection, budget)?;
        go_on(budget, result.iterations)?;
        // The score asks how well all points of the region determine the radius.
        let mut whole = self.fitter()?;
        whole.push_numbered(points, region.iter().map(|&k| looks.given(k)))?;
        let deviation = radius_deviation(&whole.evaluate(&result.cylinder)?);
        let evidence = self.seen.evidence_of_fit(&detection, &result.cylinder, deviation, None);
        let mut found = found(fitter, evidence, &detection, &result);
        // A box within the reach of a cylinder is none.
        let is_poor = || found.result.flags.contains(Flags::POOR_FIT);
        let fits = || apart(|| is_round(&found.result.cylinder, points_of(looks, &region)));
        let is_one = is_one && (is_lenient || !is_poor() && (!self.seen.whole || fits()));
        found.score = if is_one { with_odds_divided(found.score, self.tries) } else { 0.0 };
        (found.region, found.body) = (region, body);
        Ok(found)
    }

    /// Lets a region grow over its body, by a fit to what it has, until it settles.
    fn grow(
        &self,
        points: &PointsView<'_>,
        looks: &Looks,
        mut growth: Growth,
        rounds: usize,
        budget: Option<&WorkBudget<'_>>,
    ) -> Result<Growth> {
        let Growth { region, detection, last } = &mut growth;
        for _ in 0..rounds {
            let few = thinned(region);
            let seen = Detection { pixels: few.len(), ..*detection };
            let fit = self.of_region(points, looks, &few, &seen, budget)?;
            let cylinder = fit.1.cylinder;
            *last = Some(fit);
            // A body may have many points, for which no memory is kept.
            let next =
                apart(|| grown(&cylinder, points_of(looks, region), |reach| looks.near(&cylinder, reach)));
            go_on(budget, 0)?;
            detection.cylinder = cylinder;
            if next.len() < FEWEST.count() {
                break;
            }
            let settled = next.len().abs_diff(region.len()) as f64 <= SETTLED.get() * region.len() as f64;
            *region = next;
            detection.pixels = region.len();
            if settled {
                break;
            }
        }
        Ok(growth)
    }

    /// A piece of a long body that bends or tapers, such as a trunk, for which it is a cylinder: half of it about the middle of its points,
    /// half of that, and so on. `None` where none is.
    #[inline(never)] // Not inlined: its locals would enlarge the caller's stack frame.
    fn round_piece(
        &self,
        points: &PointsView<'_>,
        looks: &Looks,
        (region, detection): (&[u32], &Detection),
        budget: Option<&WorkBudget<'_>>,
    ) -> Result<Option<(Vec<u32>, Cylinder)>> {
        let (mut piece, mut cylinder) = (region.to_vec(), detection.cylinder);
        loop {
            let positions: Vec<f64> =
                points_of(looks, &piece).map(|point| cylinder.axis.position_of(&point)).collect();
            let [first, last] = min_max(&positions);
            let half = 0.25 * (last - first);
            let middle = median(&mut positions.clone());
            let mut inside = positions.iter().map(|position| (position - middle).abs() <= half);
            piece.retain(|_| inside.next().unwrap_or(false));
            if 2.0 * half < LONG.get() * cylinder.radius || piece.len() < FEWEST.count() {
                return Ok(None);
            }
            let few = thinned(&piece);
            let seen = Detection { cylinder, pixels: few.len(), ..*detection };
            cylinder = self.of_region(points, looks, &few, &seen, budget)?.1.cylinder;
            if apart(|| is_round(&cylinder, points_of(looks, &piece))) {
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
        budget: Option<&WorkBudget<'_>>,
    ) -> Result<Fit> {
        let fit = |chosen: &[u32]| {
            let mut fitter = self.fitter()?;
            fitter.push_numbered(points, chosen.iter().map(|&k| looks.given(k)))?;
            fitter.know_as_body();
            let result = self.fit_within(&mut fitter, detection, &RigidMotion::identity(), budget, 0.0)?;
            Ok((fitter, result))
        };
        let middle = |cylinder: &Cylinder| self.middle(looks, region, cylinder);
        let mut chosen = middle(&detection.cylinder);
        let (mut fitter, mut result) = fit(chosen.as_deref().unwrap_or(region))?;
        if chosen.is_some() && result.independent_points >= INDEPENDENT.get() * result.points_used as f64 {
            return fit(region);
        }
        // Which points lie in the middle follows from the radius.
        for _ in 1..budget.map_or(1, |_| ROUNDS.min(self.attempts())) {
            let next = middle(&result.cylinder);
            if next.is_none() || next == chosen {
                break;
            }
            chosen = next;
            (fitter, result) = fit(chosen.as_deref().unwrap_or(region))?;
        }
        Ok((fitter, result))
    }

    /// A fit without points of planes that touch the body or cross it, such as a floor on which it lies, and what is left of its region.
    /// Where a sensor that draws points out next to limbs has seen the cloud, these errors outweigh such points.
    #[inline(never)] // Not inlined: its locals would enlarge the caller's stack frame.
    fn off_planes(
        &self,
        points: &PointsView<'_>,
        looks: &Looks,
        (fit, region): (Fit, Vec<u32>),
        detection: &Detection,
        budget: Option<&WorkBudget<'_>>,
    ) -> Result<(Fit, Vec<u32>)> {
        if self.seen.seen_from.is_some() || budget.is_none() {
            return Ok((fit, region));
        }
        let surface = |(_, result): &Fit| (result.cylinder, result.point_scale);
        let axis = &fit.1.cylinder.axis;
        let [first, last] =
            min_max(&points_of(looks, &region).map(|point| axis.position_of(&point)).collect::<Vec<f64>>());
        let around = |(_, result): &Fit| {
            let cylinder = &result.cylinder;
            let along = first - cylinder.radius..last + cylinder.radius;
            // There may be many, for which no memory is kept.
            let mut near = apart(|| looks.some_near(cylinder, cylinder.radius));
            let is_apart =
                |point: &Vector3<f64>| cylinder.distance(point).abs() > UNEVEN.get() * cylinder.radius;
            near.retain(|point| is_apart(point) && along.contains(&cylinder.axis.position_of(point)));
            near
        };
        let refit = |before: &Fit, rest: &[u32]| {
            if rest.len() < FEWEST.count() {
                return Ok(None);
            }
            let seen = Detection { cylinder: before.1.cylinder, pixels: rest.len(), ..*detection };
            let again = unless_cancelled(self.of_region(points, looks, rest, &seen, budget))?.ok();
            let is_better = |again: &Fit| is_as_good(&before.1, &again.1) && contradict(&before.1, &again.1);
            Ok(again.filter(is_better))
        };
        let own = apart(|| region.iter().copied().collect());
        let (fit, left, _) = off_planes((fit, own), surface, |k| looks.point(k), around, refit)?;
        Ok((fit, left.to_vec()))
    }

    /// The points of a region, by their numbers, between the parts next to the limbs, which structured light and
    /// stereo draw out; `None` where they were seen from more than one position, or from inside, where there are no limbs, and where
    /// little or less than half of the region would be left.
    fn middle(&self, looks: &Looks, region: &[u32], cylinder: &Cylinder) -> Option<Vec<u32>> {
        let observer = self.seen.seen_from?;
        let axis = Line { point: cylinder.axis.point - observer, ..cylinder.axis };
        let seen = Cylinder { axis, ..*cylinder };
        if seen.contains_origin() {
            return None;
        }
        let band = Band::new(&seen, MIDDLE.get());
        let inner = region.iter().copied().filter(|&k| band.contains(&(looks.point(k) - observer)));
        let middle: Vec<u32> = inner.collect();
        (middle.len() >= FEWEST.count() && 2 * middle.len() > region.len()).then_some(middle)
    }
}

/// Refuses to go on where the call is cancelled. With very many points each step takes as long as several of a fit.
fn go_on(budget: Option<&WorkBudget<'_>>, iterations: usize) -> Result<()> {
    match budget {
        Some(budget) if budget.poll_cancel().is_break() => Err(Error::Cancelled { iterations }),
        _ => Ok(()),
    }
}

/// Points of a region, spread over all of it, that lead to its body.
fn thinned(region: &[u32]) -> Vec<u32> {
    region.iter().copied().step_by(region.len().div_ceil(ENOUGH_POINTS_TO_GROW).max(1)).collect()
}

/// Where the points of a region lie.
fn points_of(looks: &Looks, region: &[u32]) -> impl ExactSizeIterator<Item = Vector3<f64>> + Clone {
    region.iter().map(|&k| looks.point(k))
}
