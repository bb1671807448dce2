//! Which minimum is the right one: the candidates for the start one by one, and the near-wall rule.

use super::problem::Problem;
use super::solve::Report;
use super::starts::Candidate;
use crate::error::{Error, Result};
use crate::geometry::Cylinder;
use crate::solver::Convergence;

/// The part of the points on the visible wall from which on a minimum is beyond doubt: noise near the limbs
/// puts a few on the other side.
const MOSTLY_VISIBLE: f64 = 0.8;

/// The minimum that the first good candidate leads to. A candidate is good when its cost is finite, the radius
/// does not run away and the points lie on the visible wall; the next one is tried only when it is not.
pub(super) fn best_minimum(
    problem: &Problem<'_>,
    candidates: &[Candidate],
    report: Report<'_>,
) -> Result<(Candidate, Convergence)> {
    let mut hidden: Option<(Candidate, Convergence)> = None;
    let mut failure = None;
    for candidate in candidates {
        match minimum_on_visible_wall(problem, &candidate.cylinder, report) {
            Ok((convergence, true)) => return Ok((*candidate, convergence)),
            Ok((convergence, false)) => {
                if hidden.as_ref().is_none_or(|(_, best)| convergence.cost < best.cost) {
                    hidden = Some((*candidate, convergence));
                }
            }
            Err(error @ Error::Cancelled { .. }) => return Err(error),
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
    problem: &Problem<'_>,
    start: &Cylinder,
    report: Report<'_>,
) -> Result<(Convergence, bool)> {
    let mut solve = |start: &Cylinder| -> Result<(Convergence, f64)> {
        let convergence = problem.minimise(start, &mut *report)?;
        problem.check_radius(&convergence.cylinder)?;
        let fraction = if problem.near_wall {
            convergence.cylinder.visible_wall(problem.cloud.points()).fraction()
        } else {
            1.0
        };
        Ok((convergence, fraction))
    };
    let (first, fraction) = match solve(start) {
        // Points on the hidden wall have the wrong curvature: the radius may run away from there.
        Err(Error::PlanarPoints { .. }) if problem.near_wall => solve(&start.mirrored_away())?,
        other => other?,
    };
    let visible = fraction >= 0.5;
    // A radius on its way out of all bounds has swallowed the camera; the end is not worth mirroring then.
    let swallowed = problem.near_wall && first.cylinder.contains_origin() && !start.contains_origin();
    if fraction >= MOSTLY_VISIBLE && !swallowed {
        return Ok((first, visible));
    }
    let other_side = if swallowed { start.mirrored_away() } else { first.cylinder.mirrored_away() };
    match solve(&other_side) {
        Ok((second, other)) => {
            let second_visible = other >= 0.5;
            let better = if second_visible == visible { second.cost < first.cost } else { second_visible };
            Ok(if better { (second, second_visible) } else { (first, visible) })
        }
        Err(error @ Error::Cancelled { .. }) => Err(error),
        Err(_) => Ok((first, visible)),
    }
}
