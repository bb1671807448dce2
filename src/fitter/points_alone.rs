//! The fits to points alone, without mask, edges and limbs, after a first one: the points may lie on several surfaces, and on the
//! cylinder by chance.

use super::among_pixels::LEAST_ON;
use super::among_points::{Body, FEWEST, On, weight};
use super::background::Surface;
use super::fit::AS_WELL;
use super::plane_beside::{PlaneBeside, off_planes};
use super::run::Run;
use super::view::View;
use super::{FitResult, Fitted, Fitter, Flags};
use crate::error::{Error, Result, unless_cancelled};
use crate::memory::List;
use crate::observations::{ENOUGH_POINTS_TO_FIT, spread};
use nalgebra::Vector3;

/// Most fits without points that lie on the cylinder before by chance.
const ROUNDS_OF_SURFACE: usize = 5;

constants! {
    /// Points may lie on more than one surface where this part of them is not on the cylinder,
    ELSEWHERE = 0.05, "";

    /// or where they scatter about it by this part of its radius,
    WIDE = 0.1, "radius";

    /// or by this part of it where they are off it together: so few of them are independent.
    ROUGH = 0.015, "radius";
    TOGETHER = 0.02, "";

    /// Where they scatter by this part of it then, the body is no cylinder: waves of depth have 1.9 % of the radius at most.
    NONE = 0.05, "radius";

    /// Points that a plane holds a quarter of, which scatter about it by this part of their scatter about a cylinder, have flat sides.
    FLATTER = 0.5, "";
}

impl Fitter {
    /// The fit to the points of the body alone where these contradict the first one, which was to all of them, or where that failed.
    #[inline(never)] // Not inlined: its locals would enlarge the caller's stack frame.
    pub(super) fn fit_to_body(&self, first: Result<Fitted>, run: &mut Run<'_>) -> Result<Fitted> {
        let is_told = !self.options.is_robust() || self.views.iter().any(View::tells_background);
        let searched = self.searched_view();
        let first = match (first, searched) {
            (Ok(first), _) => first,
            // Two bodies may be explained best by something flat, a whole scene by something around the camera.
            (Err(error @ (Error::PlanarPoints { .. } | Error::NoStart { .. })), Some(view))
                if view.segments.is_empty() =>
            {
                return self.fit_among_surfaces(view, None, run)?.ok_or(error);
            }
            (Err(error), _) => return Err(error),
        };
        if is_told || first.made_with.constraints.has_lines() || first.result.points_used < FEWEST {
            return Ok(first);
        }
        let first = match searched {
            Some(view) => self.fit_to_one_wall(view, first, run)?,
            None => first,
        };
        let fit = match searched {
            Some(view) if may_hold_more(view, &first) => {
                self.fit_among_surfaces(view, Some(&first), run)?.unwrap_or(first)
            }
            _ => self.fit_to_surface(first, run)?,
        };
        self.fit_to_one_radius(fit, run)
    }

    /// The same for points of a view that may lie on several surfaces; `None` where neither a first fit nor a body is there.
    #[inline(never)] // Not inlined: its locals would enlarge the caller's stack frame.
    fn fit_among_surfaces(
        &self,
        view: &View,
        first: Option<&Fitted>,
        run: &mut Run<'_>,
    ) -> Result<Option<Fitted>> {
        let is_meant =
            |body: &Body| first.map_or_else(|| body.is_likely(), |first| self.is_meant(body, first, view));
        let mut body = self.likely_body(view, run)?.filter(is_meant);
        if let (None, Some(first)) = (&body, first) {
            body = self.body_beside_plane(view, first, run)?.filter(is_meant);
        }
        let is_found = body.is_some();
        let (fit, points) = match (body, first) {
            (Some(body), _) => (body.fit, body.points),
            (None, Some(first)) => (first.clone(), (0..view.cloud.len()).collect()),
            (None, None) => return Ok(None),
        };
        let (mut fit, mut points, planes) = self.fit_off_planes(view, (fit, points), run)?;
        let is_chosen = is_found || points.len() < view.cloud.len();
        if !is_found {
            fit = self.fit_to_surface(fit, run)?;
        }
        let on = On::new(view, &fit.result);
        points.retain(|&k| on.holds(k));
        let is_on_plane = |&k: &usize| planes.iter().any(|plane| plane.holds(&view.cloud.point(k)));
        let on_planes = weight(view, (0..view.cloud.len()).filter(is_on_plane));
        // Most of the points that are on no plane are not on the cylinder either.
        let on_body = weight(view, points.iter().copied());
        let is_little = is_chosen && (on_body < 0.5 * (1.0 - on_planes) || on_body < LEAST_ON);
        let some = spread(points.len(), ENOUGH_POINTS_TO_FIT);
        let some: List<Vector3<f64>> = some.iter().map(|&k| view.cloud.point(points[k])).collect();
        // A part of a cylinder is nowhere flatter than round.
        let has_side = PlaneBeside::among(&some, FLATTER.get() * fit.result.point_scale).is_some();
        if is_little || has_side || are_off_together(&fit.result, NONE.get()) {
            fit.result.flags |= Flags::POOR_FIT;
        }
        Ok(Some(fit))
    }

    /// The fit to some points of a view without those of planes that touch the cylinder or cross it, what is left of them, and all planes
    /// among the others.
    #[inline(never)] // Not inlined: its locals would enlarge the caller's stack frame.
    fn fit_off_planes(
        &self,
        view: &View,
        fit: (Fitted, List<usize>),
        run: &mut Run<'_>,
    ) -> Result<(Fitted, List<usize>, List<PlaneBeside>)> {
        let in_view = |fit: &Fitted| view.seen(&fit.result.cylinder);
        let some = spread(view.cloud.len(), ENOUGH_POINTS_TO_FIT);
        let refit = |before: &Fitted, rest: &[usize]| {
            let again = self.fit_of_points(view, rest, Some(&in_view(before)), run);
            Ok(unless_cancelled(again)?.ok().filter(|again| is_as_good(&before.result, &again.result)))
        };
        off_planes(
            fit,
            |fit| (in_view(fit), fit.result.point_scale),
            |k| view.cloud.point(k),
            |_| some.iter().map(|&k| view.cloud.point(k)).collect(),
            refit,
        )
    }

    /// The fits after a first one without points that lie on the cylinder before by chance.
    #[inline(never)] // Not inlined: its locals would enlarge the caller's stack frame.
    fn fit_to_surface(&self, mut fit: Fitted, run: &mut Run<'_>) -> Result<Fitted> {
        let bodies = fit.made_with.bodies.clone();
        let views = self.views_or(&bodies);
        let mut before = None;
        for _ in 0..ROUNDS_OF_SURFACE {
            run.check()?;
            let surface = Surface::about(&views, &fit.result.cylinder, fit.result.point_scale);
            let Some(surface) = surface.filter(|surface| before != Some(surface.holds)) else { break };
            let drawn = views.clone().map(|view| Some(surface.of(view))).collect();
            let again = unless_cancelled(self.fit_views(drawn, run))?;
            let Some(again) = again.ok().filter(|again| is_as_good(&fit.result, &again.result)) else {
                break;
            };
            (fit, before) = (again, Some(surface.holds));
        }
        Ok(fit)
    }
}

/// Whether fewer of the points lie on a cylinder as well as those of a fit before at least.
pub(crate) fn is_as_good(before: &FitResult, again: &FitResult) -> bool {
    let poor = [before, again].map(|fit| fit.flags.contains(Flags::POOR_FIT));
    again.point_scale <= AS_WELL * before.point_scale && poor != [false, true]
}

/// Whether points are off the cylinder of their fit together, by this part of its radius.
fn are_off_together(fit: &FitResult, part: f64) -> bool {
    fit.point_scale > part * fit.cylinder.radius
        && fit.independent_points < TOGETHER.get() * fit.points_used as f64
}

/// Whether points may lie on more than one surface, by a first fit to them.
fn may_hold_more(view: &View, fit: &Fitted) -> bool {
    if fit.result.flags.intersects(Flags::POOR_FIT | Flags::WEAK_RADIUS)
        || fit.result.point_scale > WIDE.get() * fit.result.cylinder.radius
        || are_off_together(&fit.result, ROUGH.get())
    {
        return true;
    }
    let (some, on) = (spread(view.cloud.len(), ENOUGH_POINTS_TO_FIT), On::new(view, &fit.result));
    some.iter().filter(|&&k| !on.holds(k)).count() as f64 > ELSEWHERE.get() * some.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fitter::{Options, StartKind};
    use crate::geometry::{AxisCone, Cylinder, CylinderLimits, RigidMotion, any_orthogonal};
    use crate::observations::PointsView;
    use crate::statistics::random_number as number;
    use nalgebra::Matrix3;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};
    use std::ops::ControlFlow;

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
            "floor" => [1.0 + noise(rng), 2.0 * number(rng), 6.0 + 1.5 * number(rng)],
            "flange" => {
                let (angle, radius) = (degrees.to_radians() * number(rng) / 2.0, 1.3 + 0.3 * number(rng));
                [radius * angle.sin(), 2.0 + noise(rng), 6.0 - radius * angle.cos()]
            }
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

    /// A cylinder three to five times as wide passed through both.
    #[test]
    fn a_strip_far_behind_the_body_does_not_widen_it() {
        for degrees in [90.0, 110.0, 130.0] {
            for seed in 0..4 {
                let rng = &mut ChaCha8Rng::seed_from_u64(300 + seed);
                let of_strip = |_| {
                    let [x, y] = [3.0 + 0.6 * number(rng), 3.0 * number(rng)];
                    [x, y, 14.0 + 0.3 * x + 0.01 * number(rng)]
                };
                let strip: Vec<[f64; 3]> = (0..600).map(of_strip).collect();
                let fit = of(&[arc(seed, degrees), strip].concat()).fit().unwrap();
                let off = (fit.cylinder.radius - 1.0).abs();
                assert!(off < 3.0 * fit.uncertainty.unwrap().radius(), "{degrees}° {seed}: {off}");
            }
        }
    }

    /// Half of the points were dropped, and the radius was up to 20 % off, without a warning.
    #[test]
    fn an_oval_tube_is_one_body() {
        for seed in 0..12 {
            let rng = &mut ChaCha8Rng::seed_from_u64(seed);
            let point = |_| {
                let (angle, along) = (std::f64::consts::PI * number(rng), 4.0 * number(rng));
                let noise = 0.005 * number(rng);
                [(1.1 + noise) * angle.cos(), (0.9 + noise) * angle.sin(), along]
            };
            let points: Vec<[f64; 3]> = (0..6000).map(point).collect();
            let fit = of(&points).fit().unwrap();
            assert!((fit.cylinder.radius - 1.0).abs() < 0.02, "{seed}: {}", fit.cylinder.radius);
            assert!(fit.points_used > 5000, "{seed}: {}", fit.points_used);
        }
    }

    /// A start model, or a fit before, made the first fit the last: it was up to twice as wide.
    #[test]
    fn a_known_cylinder_hides_no_other_surface() {
        let cylinder = Cylinder::new(Vector3::new(0.0, 0.0, 6.0), Vector3::y(), 1.0).unwrap();
        for seed in 0..5 {
            let points = [arc(seed, 60.0), beside(seed, "behind", 60.0)].concat();
            for start in [StartKind::Auto, StartKind::Last] {
                for model in [None, Some(cylinder)] {
                    let mut fitter = of(&points);
                    fitter.set_options(Options { start, ..Options::default() }).unwrap();
                    fitter.set_start(model);
                    // The second goes on from the first.
                    for fit in [fitter.fit().unwrap(), fitter.fit().unwrap()] {
                        let off = (fit.cylinder.radius - 1.0).abs();
                        assert!(off < 3.0 * fit.uncertainty.unwrap().radius(), "{seed} {start:?}: {off}");
                    }
                }
            }
        }
    }

    #[test]
    fn of_two_bodies_the_known_one_is_meant() {
        let few = |points: Vec<[f64; 3]>| points.into_iter().step_by(2);
        for seed in 0..5 {
            let moved = |by: f64| {
                let second = few(beside(seed, "second", 150.0)).map(move |[x, y, z]| [x, y, z + by]);
                arc(seed, 150.0).into_iter().chain(second).collect::<Vec<_>>()
            };
            let mut fitter = of(&moved(0.0));
            fitter.set_options(Options { start: StartKind::Last, ..Options::default() }).unwrap();
            let second = Cylinder::new(Vector3::new(2.2, 0.0, 6.0), Vector3::y(), 1.0).unwrap();
            fitter.set_start(Some(second));
            for by in [0.0, 0.1, 0.2] {
                fitter.clear();
                fitter.push_points(&PointsView::from_f64(&moved(by)), None).unwrap();
                let axis = fitter.fit().unwrap().cylinder.axis;
                let off = axis.distance(&Vector3::new(2.2, 0.0, 6.0 + by));
                assert!(off < 0.05, "{seed} {by}: {off}");
            }
        }
    }

    /// The one beside it was, as only three of those that were found were looked at.
    #[test]
    fn of_five_bodies_the_known_one_is_meant() {
        for (seed, known) in (0..3).flat_map(|seed| [(seed, 0.0), (seed, 2.0), (seed, 3.0)]) {
            let of_body = |k: u64| {
                arc(5 * seed + k, 150.0).into_iter().map(move |[x, y, z]| [x + 2.2 * k as f64, y, z])
            };
            let mut fitter = of(&(0..5).flat_map(of_body).collect::<Vec<_>>());
            let point = Vector3::new(2.2 * known, 0.0, 6.0);
            fitter.set_start(Some(Cylinder::new(point, Vector3::y(), 1.0).unwrap()));
            let off = fitter.fit().unwrap().cylinder.axis.distance(&point);
            assert!(off < 0.05, "{seed} {known}: {off}");
        }
    }

    #[test]
    fn planes_that_touch_the_body_or_hold_most_points_do_not_draw_it() {
        for degrees in [60.0, 150.0] {
            for kind in ["floor", "flange"] {
                let alone = of(&arc(1, degrees)).fit().unwrap();
                let of_plane = [1, 2].map(|seed| beside(seed, kind, degrees)).concat();
                let fit = of(&[arc(1, degrees), of_plane].concat()).fit().unwrap();
                let stated = fit.uncertainty.unwrap().radius();
                let off = (fit.cylinder.radius - 1.0).abs();
                assert!(off < 3.0 * stated, "{degrees}° {kind}: {off} {stated}");
                assert!(stated < 3.0 * alone.uncertainty.unwrap().radius(), "{degrees}° {kind}: {stated}");
                assert_eq!(fit.flags, Flags::empty(), "{degrees}° {kind}");
            }
        }
    }

    #[test]
    fn bodies_are_found_where_a_first_fit_has_no_radius() {
        let clouds = (0..60).map(|seed| [arc(seed, 60.0), beside(seed, "second", 60.0)].concat());
        let first = |points: &[[f64; 3]]| {
            let run = &mut |_: &_| ControlFlow::Continue(());
            of(points).fit_views(List::new(), &mut Run::new(run))
        };
        let is_flat = |points: &Vec<_>| matches!(first(points), Err(Error::PlanarPoints { .. }));
        let mut flat = clouds.filter(is_flat).peekable();
        assert!(flat.peek().is_some());
        for points in flat {
            let fit = of(&points).fit().unwrap();
            assert!((fit.cylinder.radius - 1.0).abs() < 0.03, "{:?}", fit.cylinder);
        }
    }

    #[test]
    fn what_has_flat_sides_is_a_poor_fit() {
        let rng = &mut ChaCha8Rng::seed_from_u64(1);
        let of_prism = |_| {
            let (side, along) = (rng.next_u32() % 3, number(rng));
            let angle = f64::from(side) * std::f64::consts::TAU / 3.0;
            let [x, z] = [along * f64::sqrt(3.0), 1.0 + 0.01 * number(rng)];
            [x * angle.cos() - z * angle.sin(), 2.0 * number(rng), 6.0 + x * angle.sin() + z * angle.cos()]
        };
        let points: Vec<[f64; 3]> = (0..3000).map(of_prism).collect();
        assert!(of(&points).fit().unwrap().flags.contains(Flags::POOR_FIT));
    }

    /// Of a box of six sides every second one had no warning.
    #[test]
    fn a_closed_box_is_a_poor_fit() {
        for seed in 0..10 {
            let rng = &mut ChaCha8Rng::seed_from_u64(seed);
            let half: [f64; 3] = std::array::from_fn(|_| 0.65 + 0.35 * number(rng));
            let of_box = |k: usize| {
                let mut point: [f64; 3] = std::array::from_fn(|k| half[k] * number(rng));
                point[k % 3] = half[k % 3].copysign(point[k % 3]) + 0.003 * number(rng);
                [point[0], point[1], point[2] + 5.0]
            };
            let points: Vec<[f64; 3]> = (0..4000).map(of_box).collect();
            assert!(of(&points).fit().unwrap().flags.contains(Flags::POOR_FIT), "{seed}");
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
