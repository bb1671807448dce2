//! The fits to points alone, without mask, edges and limbs, after a first one: the points may lie on several surfaces, and on the
//! cylinder by chance.

use super::background::Surface;
use super::body::limits_in;
use super::run::Run;
use super::view::View;
use super::{Fitted, Fitter, Flags, MadeWith, Options, StartKind};
use crate::detection::{
    Detection, DetectionOptions, Looks, detect_points_until, grown, is_round, least_before_fit, reach_of,
    widened,
};
use crate::error::{Result, unless_cancelled};
use crate::geometry::Cylinder;
use crate::memory::List;
use crate::observations::{ENOUGH, PointsView, spread};
use crate::residuals::TUKEY_EFFICIENT;
use crate::statistics::median_size;
use std::cell::RefCell;
use std::time::Instant;

/// Most fits without points that lie on the cylinder before by chance.
const ROUNDS_OF_SURFACE: usize = 5;

/// How points scatter about a cylinder is known to some percent.
const NO_WORSE: f64 = 1.05;

/// Points may lie on more than one surface where this part of them is not on the cylinder,
const ELSEWHERE: f64 = 0.05;

/// or where they scatter about it by this part of its radius.
const WIDE: f64 = 0.1;

/// The points of a body contradict a cylinder that is so many squared standard deviations away: 3 of one number, for five.
const CONTRADICTION: f64 = 18.2;

/// They scatter about that by so many times what is left of them, in the median, at least.
const FARTHER: f64 = 1.05;

/// Where this part of the points is within `NEAR_FIRST` radii of the first cylinder, and the other part of those beyond a body within
/// `NEAR_BODY` radii of that, all are one body that is no cylinder, such as an oval one.
const OF_FIRST: f64 = 0.8;
const NEAR_FIRST: f64 = 0.15;
const BESIDE_BODY: f64 = 0.5;
const NEAR_BODY: f64 = 0.25;

/// Cylinders of one look that are fitted, at most: the body that is meant has many of the points.
const MOST_OF_LOOK: usize = 3;

/// Fewer points tell neither bodies nor background.
const FEWEST: usize = 50;

/// One body among the points of a view.
struct Body {
    fit: Fitted,
    /// Its points, by their numbers.
    points: List<usize>,
    /// The probability that it is a cylinder, by the search.
    score: f64,
}

impl Fitter {
    /// The fit to the points of the body alone where these contradict the first one, which was to all of them.
    #[inline(never)] // Frames of ways that are not taken need no stack.
    pub(super) fn fit_to_body(&self, first: Fitted, run: &mut Run<'_>, clock: &Instant) -> Result<Fitted> {
        // Masks and detectors have told the background.
        let tells = |view: &View| view.mask.is_some() || view.is_body;
        let is_told = self.views.iter().any(tells) || first.0.held.has_lines();
        if !self.options.is_robust() || is_told || first.1.points_used < FEWEST {
            return Ok(first);
        }
        let is_chosen = self.start.is_some() || self.options.start != StartKind::Auto;
        match &self.views[..] {
            [view] if !is_chosen && may_hold_more(view, &first) => {
                let body = self.likely_body(view, run, clock)?;
                match body.filter(|body| body.contradicts(&first, view)) {
                    Some(mut body) => {
                        // Most points do not lie on it.
                        let poor = body.part(view) < 0.5;
                        body.fit.1.flags.set(Flags::POOR_FIT, poor);
                        Ok(body.fit)
                    }
                    None => self.fit_to_surface(first, run, clock),
                }
            }
            _ => self.fit_to_surface(first, run, clock),
        }
    }

    /// The body that a search finds among the points, a likely one with the most of them.
    #[inline(never)] // Frames of ways that are not taken need no stack.
    fn likely_body(&self, view: &View, run: &mut Run<'_>, clock: &Instant) -> Result<Option<Body>> {
        // Of very many a part tells where the body is.
        let chosen = spread(view.cloud.len(), ENOUGH);
        let points: List<[f64; 3]> = chosen.iter().map(|&k| view.cloud.point(k).into()).collect();
        let points = PointsView::from_f64(&points);
        let default = DetectionOptions::default();
        let limits = widened(&limits_in(view, &self.options));
        let min_score = least_before_fit(default.min_score, false);
        let search = DetectionOptions { limits, min_score, ..default };
        let mut looks = Looks::default();
        let mut best: Option<Body> = None;
        let worth = |body: &Body| body.score * body.part(view);
        loop {
            let asked = RefCell::new(&mut *run);
            let stopped = || asked.borrow_mut().report_again().is_break();
            // Limits may be so wide that none are wider: then nothing is found.
            let seen = unless_cancelled(detect_points_until(&points, &mut looks, &search, &stopped))?;
            let Ok(Some(seen)) = seen else { break };
            let whole = seen.whole && chosen.len() == view.cloud.len();
            for (detection, label) in seen.cylinders.iter().zip(1..).take(MOST_OF_LOOK) {
                let numbered = seen.labels.iter().zip(0..).filter(|(of, _)| **of == label);
                let region = numbered.map(|(_, k)| chosen[looks.given(looks.in_all(k))]).collect();
                let body = self.body_of(view, region, (detection, whole), run, clock)?;
                let is_better = |body: &Body| best.as_ref().is_none_or(|best| worth(body) > worth(best));
                if body.as_ref().is_some_and(is_better) {
                    best = body;
                }
            }
            let is_likely = best.as_ref().is_some_and(|best| best.score >= default.min_score);
            if is_likely || !looks.go_on(false, false) || !looks.at_all() {
                break;
            }
        }
        Ok(best)
    }

    /// The body of a region that was found, grown over all points unless it has `whole` of it; `None` where that is not round.
    #[inline(never)] // Frames of ways that are not taken need no stack.
    fn body_of(
        &self,
        view: &View,
        mut region: List<usize>,
        (detection, whole): (&Detection, bool),
        run: &mut Run<'_>,
        clock: &Instant,
    ) -> Result<Option<Body>> {
        let place = |&k: &usize| view.cloud.point(k);
        let fit = |region: &[usize], cylinder: &Cylinder, run: &mut Run<'_>| {
            unless_cancelled(self.fit_of_points(view, region, cylinder, run, clock)).map(Result::ok)
        };
        let Some(mut fitted) = fit(&region, &detection.cylinder, run)? else { return Ok(None) };
        let into_view = view.pose().inverse();
        if !whole {
            let cylinder = into_view.cylinder(&fitted.1.cylinder);
            let reach = reach_of(&cylinder, region.iter().map(place));
            let all = (0..).zip(view.cloud.points());
            let grown = grown(&cylinder, reach, region.iter().map(place), all);
            let grown: List<usize> = grown.into_iter().map(|k| k as usize).collect();
            let again = if grown.len() < FEWEST { None } else { fit(&grown, &cylinder, run)? };
            // What else lies near the surface draws the fit away.
            if let Some(again) = again.filter(|again| !contradict(&fitted, again)) {
                (region, fitted) = (grown, again);
            }
        }
        let cylinder = into_view.cylinder(&fitted.1.cylinder);
        let is_one =
            !fitted.1.flags.contains(Flags::POOR_FIT) && is_round(&cylinder, region.iter().map(place));
        Ok(is_one.then_some(Body { fit: fitted, points: region, score: detection.score }))
    }

    /// The fit to some points of a view, from a cylinder in its coordinates.
    #[inline(never)] // Frames of ways that are not taken need no stack.
    fn fit_of_points(
        &self,
        view: &View,
        points: &[usize],
        cylinder: &Cylinder,
        run: &mut Run<'_>,
        clock: &Instant,
    ) -> Result<Fitted> {
        let mut body = view.with_points(view.cloud.listed(points), None);
        body.is_body = true;
        let fitter = Self {
            options: Options { start: StartKind::Model, ..self.options },
            start: Some(view.pose().cylinder(cylinder)),
            views: vec![body.clone()],
            ..Self::default()
        };
        let (made_with, result, last) = fitter.fit_views(List::new(), run, clock)?;
        Ok((MadeWith { bodies: std::iter::once(Some(body)).collect(), ..made_with }, result, last))
    }

    /// The fits after a first one without points that lie on the cylinder before by chance.
    #[inline(never)] // Frames of ways that are not taken need no stack.
    fn fit_to_surface(&self, mut fit: Fitted, run: &mut Run<'_>, clock: &Instant) -> Result<Fitted> {
        let bodies = fit.0.bodies.clone();
        let views = self.views_or(&bodies);
        let mut before = None;
        for _ in 0..ROUNDS_OF_SURFACE {
            run.check()?;
            let surface = Surface::about(&views, &fit.1.cylinder, fit.1.point_scale);
            let Some(surface) = surface.filter(|surface| before != Some(surface.holds)) else { break };
            let drawn = views.clone().map(|view| Some(surface.of(view))).collect();
            let again = unless_cancelled(self.fit_views(drawn, run, clock))?;
            // Without background the points lie on the cylinder as well as before at least.
            let is_as_good = |again: &Fitted| {
                let poor = [&fit, again].map(|fit| fit.1.flags.contains(Flags::POOR_FIT));
                again.1.point_scale <= NO_WORSE * fit.1.point_scale && poor != [false, true]
            };
            let Some(again) = again.ok().filter(is_as_good) else { break };
            (fit, before) = (again, Some(surface.holds));
        }
        Ok(fit)
    }
}

/// Whether the points of a fit contradict the cylinder of another one.
fn contradict((_, fit, _): &Fitted, (_, other, _): &Fitted) -> bool {
    let stated = fit.uncertainty.as_ref();
    stated.is_some_and(|stated| stated.squared_distance(&other.cylinder) > CONTRADICTION)
}

impl Body {
    /// Its points by weight, as a part of those of the view.
    fn part(&self, view: &View) -> f64 {
        let weight = |k: usize| view.cloud.weight(k);
        let of_body: f64 = self.points.iter().map(|&k| weight(k)).sum();
        of_body / (0..view.cloud.len()).map(weight).sum::<f64>()
    }

    /// Whether its points contradict a first fit to all points of the view, and those beyond it belong to something else.
    #[inline(never)] // Frames of ways that are not taken need no stack.
    fn contradicts(&self, first: &Fitted, view: &View) -> bool {
        let into_view = view.pose().inverse();
        let [first_cylinder, cylinder] = [&first.1, &self.fit.1].map(|fit| into_view.cylinder(&fit.cylinder));
        let scatter =
            |of: &Cylinder| median_size(self.points.iter().map(|&k| of.distance(&view.cloud.point(k))));
        if !contradict(&self.fit, first) || scatter(&first_cylinder) <= FARTHER * scatter(&cylinder) {
            return false;
        }
        let mut beyond = List::filled(true, view.cloud.len());
        self.points.iter().for_each(|&k| beyond[k] = false);
        let reach = TUKEY_EFFICIENT * self.fit.1.point_scale;
        // All points near the first cylinder; those beyond the body, that are near it, that lie on the first cylinder.
        let [mut all, mut of_first, mut others, mut of_body, mut on_first] = [0.0; 5];
        for (k, point) in view.cloud.points().enumerate() {
            let weight = view.cloud.weight(k);
            let [from_first, from_body] =
                [&first_cylinder, &cylinder].map(|cylinder| cylinder.distance(&point).abs());
            let within = |is_within: bool| if is_within { weight } else { 0.0 };
            all += weight;
            of_first += within(from_first <= NEAR_FIRST * first_cylinder.radius);
            others += within(beyond[k]);
            of_body += within(beyond[k] && from_body <= NEAR_BODY * cylinder.radius);
            on_first += within(beyond[k] && from_first <= reach);
        }
        let is_one = of_first >= OF_FIRST * all && of_body >= BESIDE_BODY * others;
        !is_one && all - others > on_first
    }
}

/// Whether points may lie on more than one surface, by a first fit to them.
fn may_hold_more(view: &View, (_, fit, _): &Fitted) -> bool {
    let cylinder = view.pose().inverse().cylinder(&fit.cylinder);
    if fit.flags.intersects(Flags::POOR_FIT | Flags::WEAK_RADIUS) || fit.point_scale > WIDE * cylinder.radius
    {
        return true;
    }
    let some = spread(view.cloud.len(), ENOUGH);
    let reach = TUKEY_EFFICIENT * fit.point_scale;
    let elsewhere = some.iter().filter(|&&k| cylinder.distance(&view.cloud.point(k)).abs() > reach);
    elsewhere.count() as f64 > ELSEWHERE * some.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{AxisCone, CylinderLimits, RigidMotion, any_orthogonal};
    use nalgebra::{Matrix3, Vector3};
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};

    /// A number between −1 and 1.
    fn number(rng: &mut ChaCha8Rng) -> f64 {
        f64::from(rng.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0
    }

    /// 1,500 points on an arc of a cylinder of radius 1 about z, seen from the origin, with noise.
    fn arc(seed: u64, degrees: f64) -> Vec<[f64; 3]> {
        let rng = &mut ChaCha8Rng::seed_from_u64(seed);
        let noise = |rng: &mut ChaCha8Rng| 0.01 * (0..3).map(|_| number(rng)).sum::<f64>();
        let point = |_| {
            let angle = degrees.to_radians() * number(rng) / 2.0;
            let radius = 1.0 + noise(rng);
            [radius * angle.sin(), 2.0 * number(rng), 6.0 - radius * angle.cos()]
        };
        (0..1500).map(point).collect()
    }

    /// As many on a wall behind the cylinder, on one beside it, on the ground at its foot, or on a second one.
    fn beside(seed: u64, kind: &str, degrees: f64) -> Vec<[f64; 3]> {
        let rng = &mut ChaCha8Rng::seed_from_u64(100 + seed);
        let noise = |rng: &mut ChaCha8Rng| 0.01 * (0..3).map(|_| number(rng)).sum::<f64>();
        let second = arc(200 + seed, degrees).into_iter().map(|[x, y, z]| [x + 2.2, y, z]);
        let point = |_| match kind {
            "behind" => [3.0 * number(rng), 2.0 * number(rng), 7.2 + noise(rng)],
            "beside" => [1.2 + noise(rng), 2.0 * number(rng), 6.0 + 1.5 * number(rng)],
            _ => {
                let (angle, radius) = (1.5 * number(rng), 2.0 + number(rng));
                [radius * angle.sin(), 2.0 + noise(rng), 6.0 - radius * angle.cos()]
            }
        };
        if kind == "second" { second.collect() } else { (0..1500).map(point).collect() }
    }

    fn of(points: &[[f64; 3]]) -> Fitter {
        let mut fitter = Fitter::new();
        fitter.push_points(&PointsView::from_f64(points), None).unwrap();
        fitter
    }

    #[test]
    fn of_points_half_of_which_are_elsewhere_the_body_is_fitted() {
        for degrees in [60.0, 150.0] {
            for kind in ["behind", "beside", "foot", "second"] {
                let alone = of(&arc(1, degrees)).fit().unwrap();
                let fit = of(&[arc(1, degrees), beside(1, kind, degrees)].concat()).fit().unwrap();
                let stated = fit.uncertainty.unwrap().radius();
                let off = (fit.cylinder.radius - 1.0).abs();
                assert!(off < 3.0 * stated, "{degrees}° {kind}: {off} {stated}");
                assert!(stated < 3.0 * alone.uncertainty.unwrap().radius(), "{degrees}° {kind}: {stated}");
                assert!(fit.points_used < 2000, "{degrees}° {kind}: {}", fit.points_used);
            }
        }
    }

    #[test]
    fn limits_beyond_which_a_search_has_none_are_no_error() {
        let mut fitter = of(&[arc(1, 150.0), beside(1, "beside", 150.0)].concat());
        let cylinder_limits = CylinderLimits { radius_max: 1e100, ..CylinderLimits::default() };
        fitter.set_options(Options { cylinder_limits, ..Options::default() }).unwrap();
        assert!(fitter.fit().is_ok());
    }

    #[test]
    fn a_pose_turns_the_limits_of_the_search() {
        let points = [arc(1, 150.0), beside(1, "beside", 150.0)].concat();
        let mut fitter = of(&points);
        let axis = Vector3::new(0.3, 0.5, 0.8).normalize();
        let across = any_orthogonal(&axis).0;
        let rotation = Matrix3::from_columns(&[across, axis, across.cross(&axis)]);
        let pose = RigidMotion::new(rotation, Vector3::new(1.0, 2.0, 3.0)).unwrap();
        fitter.set_pose(pose);
        let axis = Some(AxisCone { direction: axis, max_angle: 0.1 });
        let cylinder_limits = CylinderLimits { axis, ..CylinderLimits::default() };
        fitter.set_options(Options { cylinder_limits, ..Options::default() }).unwrap();
        let fit = fitter.fit().unwrap();
        assert!((fit.cylinder.radius - 1.0).abs() < 0.01, "{:?}", fit.cylinder);
    }
}
