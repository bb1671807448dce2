//! Many readers or one writer, without waiting.

use std::sync::atomic::{AtomicU32, Ordering};

/// How many readers there are, or [`WRITER`].
#[derive(Default)]
pub(super) struct Access(AtomicU32);

const WRITER: u32 = u32::MAX;

impl Access {
    /// Lets one more reader in; false while there is a writer.
    pub fn try_read(&self) -> bool {
        let one_more = |state| if state < WRITER - 1 { Some(state + 1) } else { None };
        self.0.fetch_update(Ordering::Acquire, Ordering::Relaxed, one_more).is_ok()
    }

    /// Lets a writer in; false while there is anyone else.
    pub fn try_write(&self) -> bool {
        self.0.compare_exchange(0, WRITER, Ordering::Acquire, Ordering::Relaxed).is_ok()
    }

    /// A reader leaves.
    pub fn end_read(&self) {
        self.0.fetch_sub(1, Ordering::Release);
    }

    /// The writer leaves.
    pub fn end_write(&self) {
        self.0.store(0, Ordering::Release);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::UnsafeCell;
    use std::sync::Barrier;
    use std::thread;

    /// What a handle holds, in two parts that only differ while a writer is in.
    #[derive(Default)]
    struct Guarded {
        access: Access,
        numbers: UnsafeCell<[u64; 2]>,
    }

    // SAFETY: the numbers are only touched by those whom `access` lets in.
    unsafe impl Sync for Guarded {}

    impl Guarded {
        fn numbers(&self) -> *mut [u64; 2] {
            self.numbers.get()
        }
    }

    /// Miri and ThreadSanitizer see it when a reader or writer does not wait for the memory of the one before.
    #[test]
    fn threads_see_what_the_writer_before_them_wrote() {
        let guarded = Guarded::default();
        let turns = if cfg!(miri) { 50 } else { 100_000_u64 };
        let all_are_there = Barrier::new(4);
        let write = || {
            all_are_there.wait();
            for _ in 0..turns {
                // A thread that the machine puts aside while it is in keeps the others out for as long.
                while !guarded.access.try_write() {
                    thread::yield_now();
                }
                // SAFETY: nobody else is in.
                unsafe { (*guarded.numbers()).iter_mut().for_each(|number| *number += 1) };
                guarded.access.end_write();
            }
        };
        let read = || {
            all_are_there.wait();
            for _ in 0..turns {
                if guarded.access.try_read() {
                    // SAFETY: no writer is in.
                    let [one, other] = unsafe { *guarded.numbers() };
                    guarded.access.end_read();
                    assert_eq!(one, other);
                }
            }
        };
        thread::scope(|scope| {
            scope.spawn(write);
            scope.spawn(read);
            scope.spawn(read);
            write();
        });
        assert_eq!(guarded.numbers.into_inner(), [2 * turns; 2]);
    }

    #[test]
    fn readers_keep_writers_out_and_a_writer_everyone() {
        let access = Access::default();
        assert!(access.try_read() && access.try_read() && !access.try_write());
        access.end_read();
        assert!(!access.try_write());
        access.end_read();
        assert!(access.try_write() && !access.try_write() && !access.try_read());
        access.end_write();
        assert!(access.try_read());
    }
}
