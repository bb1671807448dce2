//! Many fits at once.

use super::{FitResult, Fitter};
use crate::error::{Result, cancelled_if};
use crate::workers::Workers;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

/// Fits many fitters, several at once, each as [`Fitter::fit`] does, and gives their results in order. One that fails
/// has its error there, and the others go on.
///
/// `threads` is how many fits run at the same time, 0 for as many as the machine has processors; 1 starts no thread. Each
/// fit takes as many as its options say beside that. The results have the same bits for any number. `ended` is called
/// after each fit, on the calling thread and in the order in which they end, with its position and its result. It may stop the
/// rest, whose error is `Cancelled` then and for which it is not called.
pub fn fit_all(
    fitters: &mut [Fitter],
    threads: usize,
    ended: &mut dyn FnMut(usize, &Result<FitResult>) -> ControlFlow<()>,
) -> Vec<Result<FitResult>> {
    let fit = |fitter: &mut Fitter, stopped: &dyn Fn() -> bool| fitter.fit_until(stopped);
    each(fitters, threads, fit, ended)
}

impl Fitter {
    /// Estimates the cylinder, unless it is stopped.
    pub(crate) fn fit_until(&mut self, stopped: &dyn Fn() -> bool) -> Result<FitResult> {
        cancelled_if(stopped())?;
        self.fit_with(&mut |_| if stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
    }
}

/// Does something with each item, several at once, and gives the outcomes in order. `ended` is called with each on the
/// calling thread, and may stop the rest: `one` is told so, and `ended` is not called again.
pub(crate) fn each<T: Send, R: Send>(
    items: &mut [T],
    threads: usize,
    one: impl Fn(&mut T, &dyn Fn() -> bool) -> R + Sync,
    ended: &mut dyn FnMut(usize, &R) -> ControlFlow<()>,
) -> Vec<R> {
    let stop = AtomicBool::new(false);
    let mut outcomes: Vec<Option<R>> = items.iter().map(|_| None).collect();
    let tell = |index: usize, outcome: R| {
        if !stop.load(Ordering::Relaxed) && ended(index, &outcome).is_break() {
            stop.store(true, Ordering::Relaxed);
        }
        outcomes[index] = Some(outcome);
    };
    let one = |_: usize, item: &mut T| one(item, &|| stop.load(Ordering::Relaxed));
    Workers::asked(threads).map_mut(items, one, tell);
    outcomes.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;
    use crate::observations::PointsView;

    /// A piece of a pipe, larger for each; the fourth is flat.
    fn fitters(count: usize) -> Vec<Fitter> {
        let fitter = |k: usize| {
            let radius = 0.3 + 0.1 * k as f64;
            let point = |n: usize| {
                let (angle, y) = (0.01 * n as f64, 0.1 * (n % 7) as f64);
                let noise = 1e-3 * ((n * 7919 + k) % 101) as f64 / 101.0;
                let depth = if k == 3 { 0.0 } else { (radius + noise) * angle.sin() };
                [(radius + noise) * angle.cos(), y, 2.0 - depth]
            };
            let points: Vec<[f64; 3]> = (0..150).map(point).collect();
            let mut fitter = Fitter::new();
            fitter.push_points(&PointsView::from_f64(&points), None).unwrap();
            fitter
        };
        (0..count).map(fitter).collect()
    }

    #[test]
    fn fits_are_those_of_single_calls_for_any_number_of_threads() {
        let alone: Vec<_> =
            fitters(9).iter_mut().map(|fitter| fitter.fit().map(|fit| fit.cylinder)).collect();
        assert!(alone[3].is_err() && alone.iter().filter(|fit| fit.is_ok()).count() == 8);
        for threads in [0, 1, 2, 5, 50] {
            let mut fitters = fitters(9);
            let mut told = Vec::new();
            let caller = std::thread::current().id();
            let results = fit_all(&mut fitters, threads, &mut |index, result| {
                assert_eq!(std::thread::current().id(), caller);
                told.push((index, result.clone().map(|fit| fit.cylinder)));
                ControlFlow::Continue(())
            });
            let cylinders: Vec<_> =
                results.iter().map(|result| result.clone().map(|fit| fit.cylinder)).collect();
            assert_eq!(cylinders, alone);
            told.sort_by_key(|(index, _)| *index);
            assert!(told.into_iter().eq(alone.iter().cloned().enumerate()));
            assert!(
                fitters
                    .iter()
                    .zip(&results)
                    .all(|(fitter, result)| fitter.result().is_some() == result.is_ok())
            );
        }
        assert!(fit_all(&mut [], 2, &mut |_, _| ControlFlow::Continue(())).is_empty());
    }

    #[test]
    fn the_rest_can_be_stopped() {
        for threads in [1, 3] {
            let mut ended = 0;
            let mut fitters = fitters(60);
            let results = fit_all(&mut fitters, threads, &mut |_, _| {
                ended += 1;
                if ended < 5 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
            });
            let cancelled = |result: &&Result<FitResult>| matches!(result, Err(Error::Cancelled { .. }));
            let count = results.iter().filter(cancelled).count();
            assert_eq!((results.len(), ended), (60, 5));
            // Threads may be ahead of the calls on this one.
            assert!(count <= 55 && (threads > 1 || count == 55), "{count}");
            // They can be fitted later.
            let after = fit_all(&mut fitters, threads, &mut |_, _| ControlFlow::Continue(()));
            assert_eq!(after.iter().filter(|result| result.is_ok()).count(), 59);
        }
    }
}
