//! What the fits of all regions of a scene come to: those that its work reaches, side by side, and again where two claim one limb.

use super::contests;
use super::fits::{Fits, Poll, Task};
use super::results::Found;
use super::work::{Work, WorkBudget};
use crate::error::{Error, Result};
use crate::workers::Workers;

/// What the fit of a region came to; `None` where it was not made.
pub(super) type Outcome = Option<Result<Box<Found>>>;

/// Fits a region; without a budget what the search found is the result.
pub(super) type FitRegion<'a> = dyn Fn(&Task, Option<&WorkBudget<'_>>) -> Result<Box<Found>> + Sync + 'a;

/// The regions of a scene that are to be fitted.
pub(super) struct Regions<'a> {
    pub fits: &'a Fits<'a>,
    pub fit: &'a FitRegion<'a>,
    /// Tells whether to go on.
    pub poll: &'a Poll<'a>,
}

impl Regions<'_> {
    /// What the fits come to, up to the one with which the work is at an end, and whether there was enough for all. `tell` learns how many
    /// are done.
    pub fn outcomes(&self, tell: &mut dyn FnMut(usize)) -> (Vec<Outcome>, bool) {
        let seen = &self.fits.seen;
        let count = seen.cylinders.len();
        let tasks: Vec<Task> = (0..count).map(Task::new).collect();
        let mut work = Work::after_search(seen.visits, seen.labels.len(), count);
        tell(0);
        let mut outcomes = self.run(&tasks, &work, tell);
        let last = work.last();
        if let Some(last) = last.filter(|_| (self.poll)().is_continue()) {
            // It is what the search found, whatever its fit came to.
            outcomes.push(Some((self.fit)(&tasks[last], None)));
        }
        let mut all = last.is_none();
        contests::settle(&mut outcomes, |tasks| {
            work = work.left(tasks.len());
            let outcomes = self.run(tasks, &work, &mut |_| ());
            all &= work.last().is_none();
            outcomes
        });
        (outcomes, all)
    }

    /// What each task comes to, up to the one with which the work is at an end.
    fn run(&self, tasks: &[Task], work: &Work, tell: &mut dyn FnMut(usize)) -> Vec<Outcome> {
        let Self { fits, fit, poll } = *self;
        let mut outcomes: Vec<Outcome> = tasks.iter().map(|_| None).collect();
        let compute = |index: usize, outcome: &mut Outcome| {
            let task = &tasks[index];
            if poll().is_break() {
                *outcome = Some(Err(Error::Cancelled { iterations: 0 }));
            } else if fits.may_stay(task.cylinder)
                && let Some(budget) = work.budget(index, poll)
            {
                // What would be dropped whatever its fit came to has none.
                *outcome = Some(fit(task, Some(&budget)));
            }
        };
        let mut done = 0;
        Workers::asked(fits.options.threads).map_mut(&mut outcomes, compute, |_, ()| {
            done += 1;
            tell(done);
        });
        // With threads, those from there on may have been at work yet.
        outcomes.truncate(work.last().unwrap_or(tasks.len()));
        outcomes
    }
}
