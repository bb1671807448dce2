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
        Self::new(match threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            count => count,
        })
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

    /// The same, and tells the calling thread whenever a slot is done how many are.
    pub fn fill_and_tell<T: Send>(
        &self,
        slots: &mut [T],
        compute: impl Fn(usize) -> T + Sync,
        mut tell: impl FnMut(usize),
    ) {
        let Some(pool) = &self.pool else {
            for (index, slot) in slots.iter_mut().enumerate() {
                *slot = compute(index);
                tell(index + 1);
            }
            return;
        };
        let (sender, receiver) = channel();
        let compute = &compute;
        pool.in_place_scope(|scope| {
            for (index, slot) in slots.iter_mut().enumerate() {
                let sender = sender.clone();
                scope.spawn(move |_| {
                    *slot = compute(index);
                    // The receiver is there until the last sender is gone.
                    let _ = sender.send(());
                });
            }
            drop(sender);
            (1..).zip(&receiver).for_each(|(done, ())| tell(done));
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
    fn the_calling_thread_is_told_of_every_slot() {
        for threads in [1, 3] {
            let mut slots = [0; 100];
            let (mut told, caller) = (Vec::new(), std::thread::current().id());
            Workers::new(threads).fill_and_tell(
                &mut slots,
                |index| index + 1,
                |done| {
                    assert_eq!(std::thread::current().id(), caller);
                    told.push(done);
                },
            );
            assert_eq!(told, (1..=100).collect::<Vec<_>>());
            assert!(slots.iter().enumerate().all(|(index, slot)| *slot == index + 1));
        }
    }
}
