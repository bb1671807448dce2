//! A fit under way: who hears of it, and the bound on its work.

use super::data::Data;
use super::objective::Precision;
use crate::error::{Error, Result};
use crate::solver::Iteration;
use std::ops::ControlFlow;

/// Solves of one fit after which a minimum gets no more than ordinary ones need. The hardest frames, whose minima are
/// flat, take two thirds as many; without the limit a hundred guides that contradict the points would each be followed to
/// the end.
const MANY_SOLVES: usize = 1500;
const ORDINARY_SOLVES: usize = 30;

/// Points times solves that count as many, because a solve takes as long as there are points. Frames of depth cameras take up
/// to 6.3 million, for which a hundred solves are always allowed.
const MANY_VISITS: usize = 30_000_000;
const ALWAYS_ALLOWED: usize = 100;

/// Solves that a rough minimum gets after twice as many: enough to tell it from a better one.
const FEW_SOLVES: usize = 5;

/// A fit under way: who hears of every linear solve and may stop it, and how many there were.
pub(super) struct Run<'a> {
    report: &'a mut dyn FnMut(&Iteration) -> ControlFlow<()>,
    hear: Option<&'a dyn Fn() -> ControlFlow<()>>,
    /// The last iteration that was reported.
    last: Iteration,
    solves: usize,
}

impl<'a> Run<'a> {
    /// A caller who takes the reports for a measure of the work is asked by `hear` where there is nothing to report.
    pub fn new(
        report: &'a mut dyn FnMut(&Iteration) -> ControlFlow<()>,
        hear: Option<&'a dyn Fn() -> ControlFlow<()>>,
    ) -> Self {
        Self { report, hear, last: Iteration::before_start(), solves: 0 }
    }

    /// Asks whether to go on within something that is no measure of the work.
    pub fn hear(&mut self) -> ControlFlow<()> {
        self.hear.map_or_else(|| (self.report)(&self.last), |hear| hear())
    }

    /// The same, as an error when the answer is no.
    pub fn check(&mut self) -> Result<()> {
        if self.hear().is_break() { Err(self.cancelled()) } else { Ok(()) }
    }

    /// What a fit that was stopped returns.
    pub fn cancelled(&self) -> Error {
        Error::Cancelled { iterations: self.last.iteration }
    }

    /// Asks whether to go on while there is no new iteration to report.
    pub fn poll(&mut self) -> ControlFlow<()> {
        (self.report)(&self.last)
    }

    /// Tells of an iteration, and asks whether to go on.
    pub fn tell(&mut self, iteration: &Iteration) -> ControlFlow<()> {
        self.last = *iteration;
        (self.report)(iteration)
    }

    /// How many linear solves there were.
    pub fn solves(&self) -> usize {
        self.solves
    }

    /// Counts on from an earlier number of them.
    pub fn count_from(&mut self, solves: usize) {
        self.solves = solves;
    }

    /// Counts linear solves.
    pub fn count(&mut self, solves: usize) {
        self.solves += solves;
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
    (MANY_VISITS / points).clamp(ALWAYS_ALLOWED, MANY_SOLVES)
}
