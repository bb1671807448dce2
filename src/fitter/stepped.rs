//! The fit of a body whose radius changes in a step, as that of a shaft does: to one of the two parts.
//!
//! A cylinder through both is tipped, by degrees where the step is a few per cent of the radius. It lies within a few per cent of all points,
//! so that they do not look like several surfaces; and what was known before a fit may be too rough to tell.

use super::among_points::FEWEST;
use super::body::body;
use super::points_alone::is_as_good;
use super::run::Run;
use super::view::View;
use super::{Fitted, Fitter, Flags};
use crate::error::{Result, unless_cancelled};
use crate::geometry::Cylinder;
use crate::memory::List;
use crate::observations::spread;
use crate::parts::other_radius;

/// About how many points tell a step.
const SAMPLE: usize = 1000;

/// Most steps of a body that are looked for.
const MOST_STEPS: usize = 4;

impl Fitter {
    /// The fit to the longest part of the points of a single view that has one radius, after one to all of them.
    #[inline(never)] // Not inlined: its locals would enlarge the caller's stack frame.
    pub(super) fn fit_to_one_radius(&self, mut fit: Fitted, run: &mut Run<'_>) -> Result<Fitted> {
        for _ in 0..MOST_STEPS {
            if fit.result.flags.contains(Flags::POOR_FIT) {
                break;
            }
            let bodies = fit.made_with.bodies.clone();
            let mut views = self.views_or(&bodies);
            let (Some(view), None) = (views.next(), views.next()) else { break };
            run.check()?;
            let cylinder = view.seen(&fit.result.cylinder);
            let Some([from, to]) = step(view, &cylinder) else { break };
            let along = |k: usize| cylinder.axis.position_of(&view.cloud.point(k));
            let of_body = |k: &usize| !(from..=to).contains(&along(*k));
            let of_body: List<usize> = (0..view.cloud.len()).filter(of_body).collect();
            if of_body.len() < FEWEST {
                break;
            }
            let again = unless_cancelled(self.fit_of_points(view, &of_body, Some(&cylinder), run))?;
            let is_better = |again: &Fitted| is_as_good(&fit.result, &again.result);
            let Some(again) = again.ok().filter(is_better) else { break };
            fit = again;
        }
        Ok(fit)
    }

    /// The same for masks that seemed to hold the body alone, where their sides confirm the step.
    #[inline(never)] // Not inlined: its locals would enlarge the caller's stack frame.
    pub(super) fn fit_to_one_radius_in_masks(&self, fit: Fitted, run: &mut Run<'_>) -> Result<Fitted> {
        let bodies = &fit.made_with.bodies;
        let is_told = |index: usize| bodies.get(index).is_some_and(Option::is_some);
        let of_step = |(index, view): (usize, &View)| {
            if !self.options.is_robust() || view.mask.is_none() || view.is_body || is_told(index) {
                return None;
            }
            let cylinder = view.seen(&fit.result.cylinder);
            step(view, &cylinder)?;
            body(view, &self.options, &cylinder)
        };
        let drawn: List<_> = self.views.iter().enumerate().map(of_step).collect();
        if drawn.iter().all(Option::is_none) {
            return Ok(fit);
        }
        run.check()?;
        let again = unless_cancelled(self.fit_views(drawn, run))?;
        Ok(again.ok().filter(|again| is_as_good(&fit.result, &again.result)).unwrap_or(fit))
    }
}

/// The smaller part of the points of a view along a cylinder where a clear step divides them.
fn step(view: &View, cylinder: &Cylinder) -> Option<[f64; 2]> {
    let some = spread(view.cloud.len(), SAMPLE);
    other_radius(cylinder, some.iter().map(|&k| view.cloud.point(k)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Distortion, Intrinsics};
    use crate::observations::PointsView;
    use crate::statistics::random_number as number;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    /// The axis was off by 0.4 to 2 degrees, stated to 0.03 to 0.2, without a warning.
    #[test]
    fn a_step_of_some_per_cent_does_not_tip_the_axis() {
        let (width, height, distortion) = (640, 480, Distortion::None);
        let intrinsics = Intrinsics { width, height, fx: 400.0, fy: 400.0, cx: 319.5, cy: 239.5, distortion };
        for (arc, part, share) in
            [(70.0, 0.98, 0.55), (70.0, 0.95, 0.3), (55.0, 0.95, 0.7), (55.0, 0.9, 0.4), (40.0, 1.04, 0.6)]
        {
            let rng = &mut ChaCha8Rng::seed_from_u64(1);
            // Along y before the camera, of radius 1 up to the step.
            let point = |_| {
                let along = 2.5 * (number(rng) + 1.0);
                let angle = f64::to_radians(arc) * number(rng);
                let radius = if along < 5.0 * share { 1.0 } else { part };
                let noise = 0.005 * (number(rng) + number(rng));
                let radius = radius + noise;
                [radius * angle.sin(), along, 8.0 - radius * angle.cos()]
            };
            let points: Vec<[f64; 3]> = (0..8000).map(point).collect();
            for seen in [false, true] {
                let mut fitter = Fitter::new();
                if seen {
                    fitter.set_intrinsics(intrinsics).unwrap();
                }
                fitter.push_points(&PointsView::from_f64(&points), None).unwrap();
                let fit = fitter.fit().unwrap();
                let tipped = fit.cylinder.axis.direction.y.abs().acos();
                assert!(tipped < 2e-3, "{arc}° {part} {share} {seen}: {}°", tipped.to_degrees());
                let longest = if share > 0.5 { 1.0 } else { part };
                let (off, stated) =
                    ((fit.cylinder.radius - longest).abs(), fit.uncertainty.unwrap().radius());
                assert!(off < 4.0 * stated, "{arc}° {part} {share} {seen}: {off} {stated}");
            }
        }
    }
}
