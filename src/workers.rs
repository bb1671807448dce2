//! Threads for work that is divided into parts: none unless asked for.

use crate::memory::Memory;
use std::sync::mpsc::channel;
use std::sync::{Mutex, PoisonError};
use std::thread::{self, Builder, Scope};

/// The fewest parts for which a thread is started: to start one takes as long as one or two parts of the points do.
const PARTS_OF_A_THREAD: usize = 4;

/// From so many items a thread on they share memory: what the first of them asks for is little beside the work on all.
const ITEMS_THAT_SHARE: usize = 4;

/// No more threads than these work on something, whatever was asked for: of more, none finds a processor, and each takes memory.
const MOST_THREADS: usize = 256;

/// How many threads work on something: that of the caller alone unless more are asked for.
///
/// They start and end within the call. A library inside someone's process leaves no thread behind that a fork, an
/// unloading of the library or the end of the process could meet. Where the system does not give that many threads
/// there are fewer, or none.
///
/// Results must not depend on the number of threads: [`Workers::fill`] computes parts, and who called it adds them up
/// in their order.
#[derive(Debug, Clone, Copy)]
pub struct Workers {
    threads: usize,
}

impl Workers {
    /// So many threads, 256 at most, or as many as the machine has for 0.
    #[must_use]
    pub fn asked(threads: usize) -> Self {
        let machine = || thread::available_parallelism().map_or(1, usize::from);
        Self { threads: if threads == 0 { machine() } else { threads }.min(MOST_THREADS) }
    }

    /// Computes every slot from its index.
    pub fn fill<T: Send>(self, slots: &mut [T], compute: impl Fn(usize) -> T + Sync) {
        let threads = self.threads.min(slots.len() / PARTS_OF_A_THREAD);
        let queue = Mutex::new(slots.iter_mut().enumerate());
        let work = || {
            while let Some((index, slot)) = next(&queue) {
                *slot = compute(index);
            }
        };
        if threads <= 1 {
            return work();
        }
        side_by_side(threads, &work);
    }

    /// Computes something from every item and its index, changing it, and gives the calling thread each outcome with its
    /// index as soon as it is there. Where there are many items for each thread they share the memory for lists that it has
    /// meanwhile: it is warm from one to the next, which that of each item would not be.
    pub fn map_mut<T: Send, R: Send>(
        self,
        items: &mut [T],
        compute: impl Fn(usize, &mut T) -> R + Sync,
        mut on_result: impl FnMut(usize, R),
    ) {
        let threads = self.threads.min(items.len());
        let many = items.len() >= ITEMS_THAT_SHARE * threads;
        let with_memory = |work: &mut dyn FnMut()| match many {
            true => Memory::default().lend(work),
            false => work(),
        };
        let queue = Mutex::new(items.iter_mut().enumerate());
        let one = || next(&queue).map(|(index, item)| (index, compute(index, item)));
        let one = &one;
        if threads > 1 {
            thread::scope(|scope| {
                let (sender, receiver) = channel();
                start(scope, threads, || {
                    let sender = sender.clone();
                    move || {
                        with_memory(&mut || {
                            while let Some(outcome) = one() {
                                // The receiver is there until the last sender is gone.
                                let _ = sender.send(outcome);
                            }
                        });
                    }
                });
                drop(sender);
                // The caller does no work of its own, so that it gets each outcome at once.
                receiver.iter().for_each(|(index, outcome)| on_result(index, outcome));
            });
        }
        // All, where there are no threads.
        with_memory(&mut || {
            while let Some((index, outcome)) = one() {
                on_result(index, outcome);
            }
        });
    }
}

/// Does the same on so many threads, that of the caller among them. Not generic: a thread takes the compiler long.
fn side_by_side(threads: usize, work: &(dyn Fn() + Sync)) {
    thread::scope(|scope| {
        start(scope, threads - 1, || work);
        work();
    });
}

/// The next of a queue that several threads empty.
fn next<I: Iterator>(queue: &Mutex<I>) -> Option<I::Item> {
    queue.lock().unwrap_or_else(PoisonError::into_inner).next()
}

/// Starts so many threads, or as many as the system gives.
fn start<'scope, W: FnOnce() + Send + 'scope>(
    scope: &'scope Scope<'scope, '_>,
    threads: usize,
    mut work: impl FnMut() -> W,
) {
    for index in 0..threads {
        if Builder::new().name(format!("cylfuse-{index}")).spawn_scoped(scope, work()).is_err() {
            break;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn any_number_of_threads_fills_all_slots() {
        for threads in [0, 1, 2, 5] {
            for count in [0, 1, 10, 1000] {
                let mut slots = vec![usize::MAX; count];
                Workers::asked(threads).fill(&mut slots, |index| index * index);
                assert!(slots.iter().enumerate().all(|(index, slot)| *slot == index * index));
            }
        }
    }

    #[test]
    #[cfg_attr(miri, ignore = "hundreds of threads")]
    fn no_more_threads_are_started_than_can_be_of_use() {
        let count = 2 * MOST_THREADS;
        let (ids, here) = (Mutex::new(HashSet::new()), std::sync::Condvar::new());
        let mut items = vec![(); count];
        // Each thread waits for the others, as long as there may be more.
        let compute = |_, (): &mut ()| {
            let mut ids = ids.lock().unwrap();
            ids.insert(thread::current().id());
            here.notify_all();
            let patience = std::time::Duration::from_millis(100);
            drop(here.wait_timeout_while(ids, patience, |ids| ids.len() < MOST_THREADS).unwrap());
        };
        Workers::asked(4_000_000_000).map_mut(&mut items, compute, |_, ()| {});
        let started = ids.into_inner().unwrap().len();
        assert!(started <= MOST_THREADS, "{started} threads");
    }

    #[test]
    fn the_calling_thread_is_told_of_every_item() {
        for (threads, count) in [(1, 100), (3, 100), (5, 2), (4, 0)] {
            let mut items = vec![0; count];
            let (mut told, caller) = (Vec::new(), thread::current().id());
            let ids = Mutex::new(HashSet::new());
            let compute = |index: usize, item: &mut usize| {
                *item = index + 1;
                ids.lock().unwrap().insert(thread::current().id());
                2 * index
            };
            Workers::asked(threads).map_mut(&mut items, compute, |index, outcome| {
                assert_eq!(thread::current().id(), caller);
                assert_eq!(outcome, 2 * index);
                told.push(index);
            });
            told.sort_unstable();
            assert!(told.into_iter().eq(0..count));
            assert!(items.iter().enumerate().all(|(index, item)| *item == index + 1));
            // No more than there are items or were asked for; the caller itself where that is one.
            let ids = ids.into_inner().unwrap();
            assert!(ids.len() <= threads.min(count), "{} threads", ids.len());
            assert_eq!(ids.contains(&caller), threads.min(count) == 1);
        }
    }
}
