//! Threads for work that is divided into parts: none unless asked for.

use rayon::iter::{IndexedParallelIterator, IntoParallelRefMutIterator, ParallelIterator};
use std::sync::Arc;
use std::sync::mpsc::channel;

/// The threads of a library inside someone's process: none by default, else a pool that is kept. Clones share it.
///
/// Results must not depend on the number of threads: [`Workers::fill`] computes parts, and who called it adds them up
/// in their order.
#[derive(Debug, Clone, Default)]
pub struct Workers {
    pool: Option<Arc<rayon::ThreadPool>>,
}

impl Workers {
    /// No threads beside that of the caller for 0 and 1, else a pool of so many. Where the system does not give that
    /// many threads there are fewer, or none.
    #[must_use]
    pub fn new(threads: usize) -> Self {
        let start = |count: usize| {
            rayon::ThreadPoolBuilder::new().num_threads(count).thread_name(|k| format!("cylfuse-{k}")).build()
        };
        let halves = std::iter::successors(Some(threads), |count| Some(count / 2));
        let pool = halves.take_while(|count| *count > 1).find_map(|count| start(count).ok());
        Self { pool: pool.map(Arc::new) }
    }

    /// The same, with as many threads as the machine has for 0.
    #[must_use]
    pub fn asked(threads: usize) -> Self {
        Self::asked_for(threads, usize::MAX)
    }

    /// The same, with no more threads than there are items to work on.
    #[must_use]
    pub fn asked_for(threads: usize, items: usize) -> Self {
        let count = match threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            count => count,
        };
        Self::new(count.min(items))
    }

    /// How many threads work.
    #[cfg(test)]
    pub fn threads(&self) -> usize {
        self.pool.as_ref().map_or(1, |pool| pool.current_num_threads())
    }

    /// Computes every slot from its index.
    pub fn fill<T: Send>(&self, slots: &mut [T], compute: impl Fn(usize) -> T + Sync) {
        match &self.pool {
            None => slots.iter_mut().enumerate().for_each(|(index, slot)| *slot = compute(index)),
            Some(pool) => pool.install(|| {
                slots.par_iter_mut().enumerate().for_each(|(index, slot)| *slot = compute(index));
            }),
        }
    }

    /// Computes something from every item and its index, changing it, and gives the calling thread each outcome with its
    /// index as soon as it is there.
    pub fn change_and_tell<T: Send, R: Send>(
        &self,
        items: &mut [T],
        compute: impl Fn(usize, &mut T) -> R + Sync,
        mut tell: impl FnMut(usize, R),
    ) {
        let Some(pool) = &self.pool else {
            items.iter_mut().enumerate().for_each(|(index, item)| tell(index, compute(index, item)));
            return;
        };
        let (sender, receiver) = channel();
        let compute = &compute;
        pool.in_place_scope(|scope| {
            for (index, item) in items.iter_mut().enumerate() {
                let sender = sender.clone();
                scope.spawn(move |_| {
                    // The receiver is there until the last sender is gone.
                    let _ = sender.send((index, compute(index, item)));
                });
            }
            drop(sender);
            receiver.iter().for_each(|(index, outcome)| tell(index, outcome));
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_number_of_threads_fills_all_slots() {
        for threads in [0, 1, 2, 5] {
            let workers = Workers::new(threads);
            assert_eq!(workers.threads(), threads.max(1));
            let mut slots = [0; 1000];
            workers.fill(&mut slots, |index| index * index);
            assert!(slots.iter().enumerate().all(|(index, slot)| *slot == index * index));
        }
    }

    #[test]
    fn the_calling_thread_is_told_of_every_item() {
        for threads in [1, 3] {
            let mut items = [0; 100];
            let (mut told, caller) = (Vec::new(), std::thread::current().id());
            let compute = |index: usize, item: &mut usize| {
                *item = index + 1;
                2 * index
            };
            Workers::new(threads).change_and_tell(&mut items, compute, |index, outcome| {
                assert_eq!(std::thread::current().id(), caller);
                assert_eq!(outcome, 2 * index);
                told.push(index);
            });
            told.sort_unstable();
            assert!(told.into_iter().eq(0..100));
            assert!(items.iter().enumerate().all(|(index, item)| *item == index + 1));
        }
    }

    #[test]
    fn there_are_no_more_threads_than_items() {
        for (threads, items, count) in [(5, 3, 3), (2, 3, 2), (4, 0, 1)] {
            assert_eq!(Workers::asked_for(threads, items).threads(), count);
        }
    }
}
