//! The bodies among the points of a view: what a search finds, and what lies beside a plane.

use super::body::limits_in;
use super::plane_beside::PlaneBeside;
use super::run::Run;
use super::view::View;
use super::{FitResult, Fitted, Fitter, Flags, MadeWith, Options, StartKind};
use crate::detection::{
    Detection, DetectionOptions, Looks, detect_points_until, grown, is_round, least_before_fit, widened,
};
use crate::error::{Result, unless_cancelled};
use crate::geometry::{Cylinder, LocalFrame};
use crate::memory::List;
use crate::observations::{ENOUGH_POINTS_TO_FIT, PointsView, spread};
use crate::residuals::TUKEY_EFFICIENT;
use crate::statistics::median_absolute;
use nalgebra::{Matrix2, Vector2, Vector3};
use std::cell::RefCell;

constants! {
    /// The points of a body contradict a cylinder that is so many squared standard deviations away: 3 of one number, for five.
    CHI_SQUARED_CONTRADICTION = 18.2, "σ²";

    /// They scatter about that by so many times what is left of them, in the median, at least.
    FARTHER = 1.05, "";

    /// Where this part of the points is within `NEAR_FIRST` radii of the first cylinder, and the other part of those beyond a body
    /// within `NEAR_BODY` radii of that, all are one body that is no cylinder, such as an oval one. So they are where they lie all about
    /// the axis: by this variance of their directions from it, in that in which they vary least. All around it is a half.
    OF_FIRST = 0.8, "";
    NEAR_FIRST = 0.15, "radius";
    BESIDE_BODY = 0.5, "";
    NEAR_BODY = 0.25, "radius";
    ALL_ABOUT = 0.25, "";
}

/// Cylinders of one look that are fitted, at most: the body that is meant has many of the points.
const MOST_OF_LOOK: usize = 3;

/// Fewer points tell neither bodies nor background.
pub(super) const FEWEST: usize = 50;

/// One body among the points of a view.
pub(super) struct Body {
    pub fit: Fitted,
    /// Its points, by their numbers.
    pub points: List<usize>,
    /// The probability that it is a cylinder, by the search; 1 where that was not asked.
    score: f64,
    /// What it was found beside.
    plane: Option<PlaneBeside>,
}

impl Fitter {
    /// The body that a search finds among the points: a likely one with the most of them, or with the most on the cylinder that is
    /// known.
    #[inline(never)] // Not inlined: its locals would enlarge the caller's stack frame.
    pub(super) fn likely_body(&self, view: &View, run: &mut Run<'_>) -> Result<Option<Body>> {
        // Of very many a part tells where the body is.
        let chosen = spread(view.cloud.len(), ENOUGH_POINTS_TO_FIT);
        let points: List<[f64; 3]> = chosen.iter().map(|&k| view.cloud.point(k).into()).collect();
        let points = PointsView::from_f64(&points);
        let default = DetectionOptions::default();
        let limits = widened(&limits_in(view, &self.options));
        let min_score = least_before_fit(default.min_score, false);
        let search = DetectionOptions { limits, min_score, ..default };
        let mut looks = Looks::default();
        let mut best: Option<Body> = None;
        let near_known = |cylinder: &Cylinder| self.near_known(view, cylinder).map_or(0.0, |[both, _]| both);
        let worth = |body: &Body| {
            let cylinder = view.seen(&body.fit.result.cylinder);
            let weight = weight(view, body.points.iter().copied());
            [near_known(&cylinder), weight].map(|of| body.score * of)
        };
        let known_is_there = self.known_is_among(view, chosen.len());
        loop {
            let asked = RefCell::new(&mut *run);
            let stopped = || asked.borrow_mut().report_again().is_break();
            let seen = detect_points_until(&points, &mut looks, &search, &stopped)?;
            let Some(seen) = seen else { break };
            let whole = seen.whole && chosen.len() == view.cloud.len();
            let mut found: List<usize> = (0..seen.cylinders.len()).collect();
            if known_is_there {
                let near = |k: &usize| near_known(&seen.cylinders[*k].cylinder);
                found.sort_by(|a, b| near(b).total_cmp(&near(a)));
            }
            for &k in found.iter().take(MOST_OF_LOOK) {
                let (detection, label) = (&seen.cylinders[k], k as u16 + 1);
                let numbered = seen.labels.iter().zip(0..).filter(|(of, _)| **of == label);
                let region = numbered.map(|(_, k)| chosen[looks.given(looks.in_all(k))]).collect();
                let body = self.body_of(view, region, (detection, whole), run)?;
                let is_better = |body: &Body| best.as_ref().is_none_or(|best| worth(body) > worth(best));
                if body.as_ref().is_some_and(is_better) {
                    best = body;
                }
            }
            let is_found =
                |body: &Body| body.is_likely() && (!known_is_there || self.is_known(view, &body.fit));
            if best.as_ref().is_some_and(is_found) || !looks.go_on(false, false) || !looks.at_all() {
                break;
            }
        }
        Ok(best)
    }

    /// The cylinder that is known, in the coordinates of a view.
    fn known_in(&self, view: &View) -> Option<Cylinder> {
        self.known_cylinder().map(|known| view.seen(known))
    }

    /// The weight of the points of a view that are near a cylinder and near the one that is known, and of all that are near it, as parts
    /// of that of all points, some of very many; `None` where none is known.
    fn near_known(&self, view: &View, cylinder: &Cylinder) -> Option<[f64; 2]> {
        let known = self.known_in(view)?;
        let is_near =
            |of: &Cylinder, k: usize| of.distance(&view.cloud.point(k)).abs() <= NEAR_BODY.get() * of.radius;
        let [mut both, mut near, mut all] = [0.0; 3];
        for &k in &spread(view.cloud.len(), ENOUGH_POINTS_TO_FIT) {
            let weight = view.cloud.weight(k);
            all += weight;
            if is_near(cylinder, k) {
                near += weight;
                both += if is_near(&known, k) { weight } else { 0.0 };
            }
        }
        Some([both / all, near / all])
    }

    /// Whether enough of so many points of a view to tell a body are near the cylinder that is known, if one is.
    pub(super) fn known_is_among(&self, view: &View, count: usize) -> bool {
        let near = |known: Cylinder| self.near_known(view, &known).map_or(0.0, |[both, _]| both);
        self.known_in(view).is_some_and(|known| near(known) * count as f64 >= FEWEST as f64)
    }

    /// Whether most of the points of a view that are near a cylinder in its coordinates are near the one that is known.
    pub(super) fn is_near_known(&self, view: &View, cylinder: &Cylinder) -> bool {
        self.near_known(view, cylinder).is_some_and(|[both, near]| 2.0 * both >= near)
    }

    /// The same of the cylinder of a fit.
    fn is_known(&self, view: &View, fit: &Fitted) -> bool {
        self.is_near_known(view, &view.seen(&fit.result.cylinder))
    }

    /// Whether a body is meant and not a first fit to all points, which it contradicts: not one beside the cylinder that is known where
    /// the first fit is to that. And where it is to another, the one that is known is meant.
    pub(super) fn is_meant(&self, body: &Body, first: &Fitted, view: &View) -> bool {
        match [&body.fit, first].map(|fit| self.is_known(view, fit)) {
            [true, false] => contradict(&body.fit.result, &first.result),
            [false, true] => false,
            _ => body.contradicts(first, view),
        }
    }

    /// The body of a region that was found, grown over all points unless it has `whole` of it; `None` where that is not round.
    #[inline(never)] // Not inlined: its locals would enlarge the caller's stack frame.
    fn body_of(
        &self,
        view: &View,
        mut region: List<usize>,
        (detection, whole): (&Detection, bool),
        run: &mut Run<'_>,
    ) -> Result<Option<Body>> {
        let point_of = |&k: &usize| view.cloud.point(k);
        let fit = |region: &[usize], cylinder: &Cylinder, run: &mut Run<'_>| {
            unless_cancelled(self.fit_of_points(view, region, Some(cylinder), run)).map(Result::ok)
        };
        let Some(mut fitted) = fit(&region, &detection.cylinder, run)? else { return Ok(None) };
        if !whole {
            let cylinder = view.seen(&fitted.result.cylinder);
            let grown = grown(&cylinder, region.iter().map(point_of), |_| (0..).zip(view.cloud.points()));
            let grown: List<usize> = grown.into_iter().map(|k| k as usize).collect();
            let again = if grown.len() < FEWEST { None } else { fit(&grown, &cylinder, run)? };
            // What else lies near the surface draws the fit away.
            if let Some(again) = again.filter(|again| !contradict(&fitted.result, &again.result)) {
                (region, fitted) = (grown, again);
            }
        }
        let cylinder = view.seen(&fitted.result.cylinder);
        let is_one = !fitted.result.flags.contains(Flags::POOR_FIT)
            && is_round(&cylinder, region.iter().map(point_of));
        Ok(is_one.then_some(Body { fit: fitted, points: region, score: detection.score, plane: None }))
    }

    /// The body beside a plane that a quarter of the points lie on, and scatter less about it than about the first cylinder.
    #[inline(never)] // Not inlined: its locals would enlarge the caller's stack frame.
    pub(super) fn body_beside_plane(
        &self,
        view: &View,
        first: &Fitted,
        run: &mut Run<'_>,
    ) -> Result<Option<Body>> {
        let some = spread(view.cloud.len(), ENOUGH_POINTS_TO_FIT);
        let some: List<Vector3<f64>> = some.iter().map(|&k| view.cloud.point(k)).collect();
        let Some(plane) = PlaneBeside::among(&some, first.result.point_scale) else { return Ok(None) };
        let points: List<usize> =
            (0..view.cloud.len()).filter(|&k| !plane.holds(&view.cloud.point(k))).collect();
        if points.len() < FEWEST {
            return Ok(None);
        }
        let fit = unless_cancelled(self.fit_of_points(view, &points, None, run))?;
        let is_told = |fit: &Fitted| !fit.result.flags.intersects(Flags::POOR_FIT | Flags::WEAK_RADIUS);
        let body = |fit| Body { fit, points, score: 1.0, plane: Some(plane) };
        Ok(fit.ok().filter(is_told).map(body))
    }

    /// The fit to some points of a view, from a cylinder in its coordinates where one is known.
    #[inline(never)] // Not inlined: its locals would enlarge the caller's stack frame.
    pub(super) fn fit_of_points(
        &self,
        view: &View,
        points: &[usize],
        cylinder: Option<&Cylinder>,
        run: &mut Run<'_>,
    ) -> Result<Fitted> {
        let mut body = view.with_points(view.cloud.listed(points), None);
        body.is_body = true;
        let fit = self.fitter_to(&body, cylinder).fit_views(List::new(), run)?;
        let made_with = MadeWith { bodies: std::iter::once(Some(body)).collect(), ..fit.made_with };
        Ok(Fitted { made_with, ..fit })
    }

    /// A fitter with the same options to a body alone, from a cylinder in the coordinates of its view where one is known.
    pub(super) fn fitter_to(&self, body: &View, cylinder: Option<&Cylinder>) -> Self {
        let start = if cylinder.is_some() { StartKind::Model } else { StartKind::Auto };
        Self {
            options: Options { start, ..self.options },
            start: cylinder.map(|cylinder| body.pose().cylinder(cylinder)),
            views: vec![body.clone()],
            ..Self::default()
        }
    }
}

/// Which points of a view lie on the cylinder of a fit.
pub(super) struct On<'a> {
    view: &'a View,
    cylinder: Cylinder,
    reach: f64,
}

impl<'a> On<'a> {
    pub fn new(view: &'a View, fit: &FitResult) -> Self {
        let cylinder = view.seen(&fit.cylinder);
        Self { view, cylinder, reach: TUKEY_EFFICIENT * fit.point_scale }
    }

    pub fn holds(&self, index: usize) -> bool {
        self.cylinder.distance(&self.view.cloud.point(index)).abs() <= self.reach
    }
}

/// The weight of points, as a part of that of all points of the view.
pub(super) fn weight(view: &View, points: impl Iterator<Item = usize>) -> f64 {
    let of = |k: usize| view.cloud.weight(k);
    points.map(of).sum::<f64>() / (0..view.cloud.len()).map(of).sum::<f64>()
}

/// Whether the points of a fit contradict the cylinder of another one.
pub(crate) fn contradict(fit: &FitResult, other: &FitResult) -> bool {
    let stated = fit.uncertainty.as_ref();
    stated.is_some_and(|stated| stated.squared_distance(&other.cylinder) > CHI_SQUARED_CONTRADICTION.get())
}

impl Body {
    /// Whether the search would return it.
    pub fn is_likely(&self) -> bool {
        self.score >= DetectionOptions::default().min_score
    }

    /// Whether its points contradict a first fit to all points of the view, and those beyond it belong to something else.
    #[inline(never)] // Not inlined: its locals would enlarge the caller's stack frame.
    pub fn contradicts(&self, first: &Fitted, view: &View) -> bool {
        let [first_cylinder, cylinder] = [first, &self.fit].map(|fit| view.seen(&fit.result.cylinder));
        let scatter =
            |of: &Cylinder| median_absolute(self.points.iter().map(|&k| of.distance(&view.cloud.point(k))));
        if !contradict(&self.fit.result, &first.result)
            || scatter(&first_cylinder) <= FARTHER.get() * scatter(&cylinder)
        {
            return false;
        }
        // What a plane explains better is no part of the first cylinder.
        let is_plane = |plane: &PlaneBeside| {
            let own = || view.cloud.points().filter(|point| plane.holds(point));
            plane.median_distance(own()) < median_absolute(own().map(|point| first_cylinder.distance(&point)))
        };
        let plane = self.plane.filter(is_plane);
        let mut beyond = List::filled(true, view.cloud.len());
        self.points.iter().for_each(|&k| beyond[k] = false);
        let reach = TUKEY_EFFICIENT * self.fit.result.point_scale;
        // All points near the first cylinder; those beyond the body, that are near it, that lie on the first cylinder.
        let [mut all, mut of_first, mut others, mut of_body, mut on_first] = [0.0; 5];
        let about_axis = LocalFrame::new(&first_cylinder, &first_cylinder.axis.point, 1.0);
        let (mut direction, mut squares) = (Vector2::zeros(), Matrix2::zeros());
        for (k, point) in view.cloud.points().enumerate() {
            let weight = view.cloud.weight(k);
            let [from_first, from_body] =
                [&first_cylinder, &cylinder].map(|cylinder| cylinder.distance(&point).abs());
            let within = |is_within: bool| if is_within { weight } else { 0.0 };
            all += weight;
            let from_axis = point - first_cylinder.axis.point;
            let across = Vector2::new(about_axis.u.dot(&from_axis), about_axis.v.dot(&from_axis));
            let across = across.try_normalize(0.0).unwrap_or_default();
            direction += across * weight;
            squares += across * across.transpose() * weight;
            of_first += within(from_first <= NEAR_FIRST.get() * first_cylinder.radius);
            others += within(beyond[k]);
            of_body += within(beyond[k] && from_body <= NEAR_BODY.get() * cylinder.radius);
            let is_of_plane = plane.is_some_and(|plane| plane.holds(&point));
            on_first += within(beyond[k] && from_first <= reach && !is_of_plane);
        }
        let mean = direction / all;
        let variances = (squares / all - mean * mean.transpose()).symmetric_eigenvalues();
        let are_all_about = variances.min() >= ALL_ABOUT.get();
        let is_one =
            of_first >= OF_FIRST.get() * all && (are_all_about || of_body >= BESIDE_BODY.get() * others);
        !is_one && all - others > on_first
    }
}
