//! How much a scene may take: what bounds its time, whatever it shows.

use super::fits::Poll;
use std::cell::Cell;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};

/// Visits that a scene of [`PIXELS`] may take, search and fits together, 20 to 25 ns each: the hardest of ../shared/scenes, five
/// pipes across all of the image, takes 26 million. The search has a limit of its own besides, ten million.
const VISITS: u64 = 30_000_000;

/// Larger scenes may take more, in proportion.
const PIXELS: usize = 640 * 480;

/// What a fit takes however often it asks whether to go on, in visits: so many, more for each pixel of its region, and more for
/// each pixel of the length of its limbs, where they are located in an image. By regression over the fits of ../shared/scenes,
/// nine of ten of which are within a factor of two of it, and of scenes with too many bodies.
const VISITS_OF_FIT: u64 = 50_000;
const VISITS_OF_PIXEL: u64 = 16;
const VISITS_OF_LIMB: u64 = 800;

/// What a fit does from one question whether to go on to the next: so many visits, and two for so many pixels of its region.
const VISITS_OF_QUESTION: u64 = 120;
const PIXELS_OF_TWO_VISITS: u64 = 7;

/// The work of the fits of a scene. Cylinders are fitted by falling score until those before them have left nothing, which
/// is the same for any number of threads.
pub(super) struct Work {
    limit: u64,
    /// The visits of each fit.
    visits: Vec<AtomicU64>,
}

impl Work {
    /// What a search of so many visits leaves to the fits of what it found.
    pub fn after_search(visits: u64, pixels: usize, fits: usize) -> Self {
        let limit = (VISITS as f64 * (pixels as f64 / PIXELS as f64).max(1.0)) as u64;
        Self::new(limit.saturating_sub(visits), fits)
    }

    /// What these fits leave to others.
    pub fn left(&self, fits: usize) -> Self {
        Self::new(self.limit.saturating_sub(self.done(self.visits.len())), fits)
    }

    fn new(limit: u64, fits: usize) -> Self {
        Self { limit, visits: (0..fits).map(|_| AtomicU64::new(0)).collect() }
    }

    /// The visits of the first fits.
    fn done(&self, fits: usize) -> u64 {
        self.visits[..fits].iter().map(|visits| visits.load(Ordering::Relaxed)).sum()
    }

    /// The budget of a fit, which is what is left; `None` where nothing is. Fits before it that other threads are at may yet leave
    /// less.
    pub fn budget<'a>(&'a self, fit: usize, poll: &'a Poll<'a>) -> Option<WorkBudget<'a>> {
        let limit = self.limit.saturating_sub(self.done(fit));
        let budget = WorkBudget {
            visits: &self.visits[fit],
            limit,
            of_fit: Cell::new(VISITS_OF_FIT),
            of_question: Cell::new(VISITS_OF_QUESTION),
            poll,
        };
        (limit > 0).then_some(budget)
    }

    /// The first fit, of all that are done, with which the work was at an end; `None` where there was enough for all.
    pub fn last(&self) -> Option<usize> {
        let sums = self.visits.iter().scan(0_u64, |sum, visits| {
            *sum = sum.saturating_add(visits.load(Ordering::Relaxed));
            Some(*sum)
        });
        sums.enumerate().find(|&(_, sum)| sum >= self.limit).map(|(fit, _)| fit)
    }
}

/// What the fits to one region may do, and have done.
pub(super) struct WorkBudget<'a> {
    visits: &'a AtomicU64,
    limit: u64,
    of_fit: Cell<u64>,
    of_question: Cell<u64>,
    poll: &'a Poll<'a>,
}

impl WorkBudget<'_> {
    /// Sets the pixels of the region, and the length of its limbs in an image in pixels, and counts what its ends take.
    pub fn set_region(&self, pixels: usize, limb: f64) {
        let (pixels, limb) = (pixels as u64, limb as u64);
        self.of_fit.set(
            (VISITS_OF_FIT + VISITS_OF_PIXEL * pixels).saturating_add(VISITS_OF_LIMB.saturating_mul(limb)),
        );
        self.of_question.set(VISITS_OF_QUESTION + 2 * pixels / PIXELS_OF_TWO_VISITS);
        self.begin();
    }

    /// Counts a fit.
    pub fn begin(&self) {
        self.visits.fetch_add(self.of_fit.get(), Ordering::Relaxed);
    }

    /// Counts a question, and asks whether to go on: before each linear solve of a fit, and as often in all else.
    pub fn ask(&self) -> ControlFlow<()> {
        let before = self.visits.fetch_add(self.of_question.get(), Ordering::Relaxed);
        if before >= self.limit { ControlFlow::Break(()) } else { (self.poll)() }
    }

    /// Asks whether to go on, where that is no measure of the work.
    pub fn poll_cancel(&self) -> ControlFlow<()> {
        (self.poll)()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fits_get_what_those_before_them_leave() {
        let poll = || ControlFlow::Continue(());
        let work = Work::after_search(VISITS - 16_000_000, PIXELS, 4);
        for fit in 0..3 {
            let budget = work.budget(fit, &poll).unwrap();
            budget.set_region(70_000, 300.0);
            budget.begin();
            let of_fits = 2 * (50_000 + 16 * 70_000 + 800 * 300);
            let left = 16_000_000 - fit as u64 * 6_000_000 - of_fits;
            let asked = (0..if fit == 2 { u64::MAX } else { 0 }).take_while(|_| budget.ask().is_continue());
            assert_eq!(asked.count() as u64, if fit == 2 { left.div_ceil(20_120) } else { 0 });
            if fit < 2 {
                budget.visits.store(6_000_000, Ordering::Relaxed);
                assert_eq!(work.last(), None);
            }
        }
        assert!(work.budget(3, &poll).is_none());
        assert_eq!(work.last(), Some(2));
        assert!(work.left(1).budget(0, &poll).is_none());
        work.visits[2].store(1_000_000, Ordering::Relaxed);
        assert_eq!(work.left(5).limit, 3_000_000);
    }

    #[test]
    fn larger_scenes_may_take_more_and_a_poll_is_heard() {
        let poll = || ControlFlow::Break(());
        let work = Work::after_search(0, 4 * PIXELS, 1);
        assert_eq!(work.limit, 4 * VISITS);
        let budget = work.budget(0, &poll).unwrap();
        assert!(budget.ask().is_break());
        assert_eq!(work.last(), None);
    }
}
