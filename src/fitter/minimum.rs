//! Which minimum is the right one: the candidates for the start one by one, and the near-wall rule.

use super::constraints::Constraints;
use super::data::Data;
use super::objective::{Minimum, Precision};
use super::run::Run;
use super::start::Candidate;
use crate::error::{Error, Result, unless_cancelled};
use crate::geometry::Cylinder;

/// The part of the points on the visible wall from which on a minimum is beyond doubt: noise near the limbs
/// puts a few on the other side.
const MOSTLY_VISIBLE: f64 = 0.8;

impl Data<'_> {
    /// The minimum that the first good candidate leads to. A candidate is good when its cost is finite, the radius
    /// does not run away and the points lie on the visible wall; the next one is tried only when it is not.
    pub fn best_minimum(
        &self,
        constraints: &Constraints,
        candidates: &[Candidate],
        precision: Precision,
        run: &mut Run<'_>,
    ) -> Result<(Candidate, Minimum)> {
        let mut hidden: Option<(Candidate, Minimum)> = None;
        let mut failure = None;
        for candidate in candidates {
            match unless_cancelled(self.minimum_on_visible_wall(
                constraints,
                &candidate.cylinder,
                precision,
                run,
            ))? {
                Ok((minimum, true)) => return Ok((*candidate, minimum)),
                Ok((minimum, false)) => {
                    let cost = |minimum: &Minimum| minimum.convergence.cost;
                    if hidden.as_ref().is_none_or(|(_, best)| cost(&minimum) < cost(best)) {
                        hidden = Some((*candidate, minimum));
                    }
                }
                Err(error) => failure = failure.or(Some(error)),
            }
        }
        let nothing = || Error::NoStart { reason: "no candidate was given".into() };
        hidden.ok_or_else(|| failure.unwrap_or_else(nothing))
    }

    /// The near-wall rule: when many points of a minimum lie on the wall that the camera cannot see, its mirror
    /// image is tried too. Of the two, the one with most of its points on the visible wall wins, then the lower
    /// cost. Besides the mirror image, with all points on the hidden wall, there are minima that cross the surface
    /// at a slant with half of them there.
    fn minimum_on_visible_wall(
        &self,
        constraints: &Constraints,
        start: &Cylinder,
        precision: Precision,
        run: &mut Run<'_>,
    ) -> Result<(Minimum, bool)> {
        let near_wall = self.near_wall();
        let mut solve = |start: &Cylinder| -> Result<(Minimum, f64)> {
            let minimum = self.minimise(constraints, start, precision, run)?;
            self.check_radius(minimum.cylinder())?;
            let fraction =
                if near_wall { self.walls_and_energy(minimum.cylinder()).0.fraction() } else { 1.0 };
            Ok((minimum, fraction))
        };
        let (first, fraction) = match solve(start) {
            // Points on the hidden wall have the wrong curvature: the radius may run away from there.
            Err(Error::PlanarPoints { .. }) if near_wall => solve(&self.mirrored_away(start))?,
            other => other?,
        };
        let visible = fraction >= 0.5;
        // A radius on its way out of all bounds has swallowed the camera; the end is not worth mirroring then.
        let swallowed = near_wall && self.observer_inside(first.cylinder()) && !self.observer_inside(start);
        if fraction >= MOSTLY_VISIBLE && !swallowed {
            return Ok((first, visible));
        }
        let other_side = self.mirrored_away(if swallowed { start } else { first.cylinder() });
        let Ok((second, other)) = unless_cancelled(solve(&other_side))? else { return Ok((first, visible)) };
        let second_visible = other >= 0.5;
        let lower = second.convergence.cost < first.convergence.cost;
        let better = if second_visible == visible { lower } else { second_visible };
        Ok(if better { (second, second_visible) } else { (first, visible) })
    }
}
