//! Threads for work that is divided into parts: none unless asked for.

use rayon::iter::{IndexedParallelIterator, IntoParallelRefMutIterator, ParallelIterator};
use std::sync::Arc;

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
}
