//! A fit under way: to whom it is reported, and the bound on its work.

use super::data::Data;
use super::objective::Precision;
use crate::error::{Error, Result};
use crate::geometry::Cylinder;
use crate::solver::Iteration;
use std::ops::ControlFlow;
use std::time::Instant;

/// Solves of one fit after which a minimum gets no more than ordinary ones need. The hardest frames, whose minima are
/// flat, take two thirds as many; without the limit a hundred guides that contradict the points would each be followed to
/// the end.
const MANY_SOLVES: usize = 1500;
const ORDINARY_SOLVES: usize = 30;

/// Points times solves that count as many, because a solve takes as long as there are points. Frames of depth cameras take up
/// to 6.3 million, for which a hundred solves are always allowed.
const MANY_POINT_SOLVES: usize = 30_000_000;
const ALWAYS_ALLOWED: usize = 100;

/// Most solves of a rough minimum once twice as many are spent: enough to tell it from a better one.
const FEW_SOLVES: usize = 5;

/// First fits whose axes and radii differ by less than this part of the radius are the same.
const SAME: f64 = 1e-3;

/// A fit under way: to whom every linear solve is reported, who may stop it, and how many there were.
pub(super) struct Run<'a> {
    report: &'a mut dyn FnMut(&Iteration) -> ControlFlow<()>,
    poll_cancel: Option<&'a dyn Fn() -> ControlFlow<()>>,
    /// The first fits from other starts, for a caller who tries several.
    known: Option<&'a mut Vec<Cylinder>>,
    /// The last iteration that was reported.
    last: Iteration,
    /// How many linear solves there were.
    pub solves: usize,
    /// When the call began.
    began: Instant,
}

impl<'a> Run<'a> {
    pub fn new(report: &'a mut dyn FnMut(&Iteration) -> ControlFlow<()>) -> Self {
        Self {
            report,
            poll_cancel: None,
            known: None,
            last: Iteration::before_start(),
            solves: 0,
            began: Instant::now(),
        }
    }

    /// The same for a caller who takes the reports for a measure of the work, and is asked by `poll_cancel` where there is nothing to
    /// report; and who tries several starts: see [`Run::is_known`].
    pub fn counted(
        report: &'a mut dyn FnMut(&Iteration) -> ControlFlow<()>,
        poll_cancel: &'a dyn Fn() -> ControlFlow<()>,
        known: &'a mut Vec<Cylinder>,
    ) -> Self {
        Self { poll_cancel: Some(poll_cancel), known: Some(known), ..Self::new(report) }
    }

    /// Wall-clock seconds since the call began.
    pub fn seconds(&self) -> f64 {
        self.began.elapsed().as_secs_f64()
    }

    /// Whether the first fit is that from another start, from which all else would follow as it did there. It is known from
    /// here on.
    pub fn is_known(&mut self, first: &Cylinder) -> bool {
        let Some(known) = self.known.take() else { return false };
        let same = |other: &Cylinder| {
            let change = other.compare(first);
            let offset = change.axis_distance.max(change.angle * other.radius) / other.radius;
            change.radius_relative.abs().max(offset) <= SAME
        };
        let is_known = known.iter().any(same);
        known.push(*first);
        is_known
    }

    /// Asks whether to go on within something that is no measure of the work.
    pub fn poll_cancel(&mut self) -> ControlFlow<()> {
        self.poll_cancel.map_or_else(|| (self.report)(&self.last), |poll_cancel| poll_cancel())
    }

    /// The same, as an error when the answer is no.
    pub fn check(&mut self) -> Result<()> {
        if self.poll_cancel().is_break() { Err(self.cancelled()) } else { Ok(()) }
    }

    /// What a fit that was stopped returns.
    pub fn cancelled(&self) -> Error {
        Error::Cancelled { iterations: self.last.iteration }
    }

    /// Reports the last iteration again, to ask whether to go on.
    pub fn report_again(&mut self) -> ControlFlow<()> {
        (self.report)(&self.last)
    }

    /// Reports an iteration, and asks whether to go on.
    pub fn report(&mut self, iteration: &Iteration) -> ControlFlow<()> {
        self.last = Iteration { cylinder: iteration.cylinder.with_canonical_direction(), ..*iteration };
        (self.report)(&self.last)
    }

    /// Most solves of the next minimum.
    pub fn most_solves(&self, data: &Data<'_>, precision: Precision) -> usize {
        let (all, many) = (data.options.limits.max_iterations, many_solves(data));
        match self.solves {
            solves if solves > 2 * many && precision == Precision::Rough => all.min(FEW_SOLVES),
            solves if solves > many => all.min(ORDINARY_SOLVES),
            _ => all,
        }
    }

    /// Whether a fit has taken so long that no more ways to guide it are tried.
    pub fn is_long(&self, data: &Data<'_>) -> bool {
        self.solves > 2 * many_solves(data)
    }
}

/// Solves of one fit that are many.
fn many_solves(data: &Data<'_>) -> usize {
    let points = data.views.iter().map(|view| view.points.count()).sum::<usize>().max(1);
    (MANY_POINT_SOLVES / points).clamp(ALWAYS_ALLOWED, MANY_SOLVES)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn a_first_fit_is_known_from_the_second_start_on_but_not_within_one_fit() {
        let cylinder = |x: f64, radius: f64| {
            Cylinder::new(Vector3::new(x, 0.0, 1.0), Vector3::new(0.1, 1.0, 0.2), radius).unwrap()
        };
        let mut report = |_: &Iteration| ControlFlow::Continue(());
        let mut known = Vec::new();
        let poll_cancel = || ControlFlow::Continue(());
        let mut is_known =
            |first: &Cylinder| Run::counted(&mut report, &poll_cancel, &mut known).is_known(first);
        assert!(!is_known(&cylinder(0.0, 0.05)));
        assert!(is_known(&cylinder(0.00002, 0.05)));
        assert!(!is_known(&cylinder(0.0005, 0.05)));
        assert!(!is_known(&cylinder(0.0, 0.0505)));
        assert!(is_known(&cylinder(0.0, 0.05051)));
        let mut run = Run::counted(&mut report, &poll_cancel, &mut known);
        assert!(!run.is_known(&cylinder(0.1, 0.05)) && !run.is_known(&cylinder(0.1, 0.05)));
        assert_eq!(known.len(), 6);
    }
}
