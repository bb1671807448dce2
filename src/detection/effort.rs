//! How much a search does: what bounds its time, and when it asks whether to go on.

use std::cell::Cell;

/// Visits between two cancellation checks: less than a millisecond.
const BETWEEN_QUESTIONS: u64 = 10_000;

/// The work of a search, in visits: one is a surface compared with one cell, or an edge with one limb. A limit on the number
/// of visits bounds the time, and unlike a clock gives the same result at every run.
pub(super) struct Effort<'a> {
    limit: Cell<u64>,
    visits: Cell<u64>,
    next_question: Cell<u64>,
    stopped: Cell<bool>,
    cut_short: Cell<bool>,
    asked: &'a dyn Fn() -> bool,
}

impl<'a> Effort<'a> {
    /// An effort without any visits that asks whether it shall stop.
    pub fn new(asked: &'a dyn Fn() -> bool) -> Self {
        Self {
            limit: Cell::new(u64::MAX),
            visits: Cell::new(0),
            next_question: Cell::new(0),
            stopped: Cell::new(false),
            cut_short: Cell::new(false),
            asked,
        }
    }

    /// Sets the number of visits, from the first on, up to which what follows may go.
    pub fn limit(&self, visits: u64) {
        self.limit.set(visits);
    }

    /// Counts visits, and asks when it is time to.
    pub fn spend(&self, visits: usize) {
        let sum = self.visits.get().saturating_add(visits as u64);
        self.visits.set(sum);
        if sum >= self.next_question.get() {
            self.next_question.set(sum + BETWEEN_QUESTIONS);
            self.ask();
        }
    }

    /// Asks at once, in steps that are not counted; whether to stop.
    pub fn ask(&self) -> bool {
        self.stopped.set(self.stopped.get() || (self.asked)());
        self.stopped.get()
    }

    /// Whether the search was stopped: what it has found by then is of no use.
    pub fn is_stopped(&self) -> bool {
        self.stopped.get()
    }

    /// Whether the search was stopped or has done all that it may.
    pub fn is_spent(&self) -> bool {
        let at_limit = self.visits.get() >= self.limit.get();
        self.cut_short.set(self.cut_short.get() || at_limit);
        self.stopped.get() || at_limit
    }

    /// Whether something was left because of a limit.
    pub fn is_cut_short(&self) -> bool {
        self.cut_short.get()
    }

    /// All visits so far.
    pub fn visits(&self) -> u64 {
        self.visits.get()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn asks_in_steps_of_visits_and_ends_at_the_limit() {
        let asked = Cell::new(0);
        let question = || {
            asked.set(asked.get() + 1);
            asked.get() > 3
        };
        let effort = Effort::new(&question);
        effort.limit(15_000);
        effort.spend(100);
        assert_eq!((asked.get(), effort.is_spent()), (1, false));
        (0..99).for_each(|_| effort.spend(100));
        assert_eq!((asked.get(), effort.is_spent()), (1, false));
        effort.spend(5_000);
        assert_eq!((asked.get(), effort.is_spent(), effort.is_stopped()), (2, true, false));
        assert!(effort.is_cut_short());
        effort.limit(30_000);
        assert!(!effort.is_spent());
        assert!(!effort.ask() && effort.ask());
        assert!(effort.is_spent() && effort.is_stopped());
        // Nobody is asked twice after a yes.
        effort.spend(50_000);
        assert_eq!(asked.get(), 4);
    }
}
