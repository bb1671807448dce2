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
