//! The fitter behind the opaque handle: one call at a time, a message for each failure.

use super::constants::cylfuse_log_level;
use super::guard::guard;
use super::setup::{cylfuse_log_fn, cylfuse_progress_fn};
use super::status::{Failure, cylfuse_status};
use crate::fitter::Fitter;
use std::cell::{RefCell, UnsafeCell};
use std::ffi::{c_char, c_void};
use std::sync::atomic::{AtomicBool, Ordering};

/// Estimates one cylinder: holds options, camera, data and the last result. Opaque; made by
/// `cylfuse_fitter_create`.
///
/// A fitter may move between threads, but runs one call at a time: a second one, from another thread or from a
/// callback, returns `CYLFUSE_STATUS_BUSY`. Different fitters run in parallel.
pub struct cylfuse_fitter {
    /// Whether a call is running: who sets it from false to true may touch `content`.
    busy: AtomicBool,
    poisoned: AtomicBool,
    cancelled: AtomicBool,
    content: UnsafeCell<Content>,
}

/// What a call works on.
#[derive(Default)]
pub(super) struct Content {
    pub fitter: Fitter,
    pub progress: Callback<cylfuse_progress_fn>,
    pub log: Log,
    message: Text,
}

/// A function of the caller and what it gets back.
#[derive(Clone, Copy)]
pub(super) struct Callback<F> {
    pub function: F,
    pub user_data: *mut c_void,
}

impl<F> Default for Callback<Option<F>> {
    fn default() -> Self {
        Self { function: None, user_data: std::ptr::null_mut() }
    }
}

/// Where log lines go.
#[derive(Clone, Copy, Default)]
pub(super) struct Log {
    /// The number of the most talkative level that is wanted.
    pub level: i32,
    pub callback: Callback<cylfuse_log_fn>,
}

impl Log {
    /// Whether lines of a level are wanted.
    pub fn wants(&self, level: cylfuse_log_level) -> bool {
        self.callback.function.is_some() && level.0 <= self.level
    }

    /// Hands a line over; `line` is called when the level is wanted.
    pub fn write(&self, level: cylfuse_log_level, line: impl FnOnce() -> String) {
        let Some(function) = self.callback.function.filter(|_| self.wants(level)) else { return };
        let text = Text::new(&line());
        // SAFETY: the caller gave the function for this use; the text is NUL-terminated and lives until it
        // returns.
        unsafe { function(level, text.as_ptr(), self.callback.user_data) };
    }
}

/// A NUL-terminated text of limited length, so that a message never needs memory.
pub(super) struct Text([u8; 512]);

thread_local! {
    /// Why the last call without a fitter failed on this thread.
    static WITHOUT_FITTER: RefCell<Text> = const { RefCell::new(Text::EMPTY) };
}

impl Default for Text {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl Text {
    const EMPTY: Self = Self([0; 512]);

    fn new(text: &str) -> Self {
        let mut copy = Self::default();
        let mut end = text.len().min(copy.0.len() - 1);
        while !text.is_char_boundary(end) {
            end -= 1;
        }
        copy.0[..end].copy_from_slice(&text.as_bytes()[..end]);
        copy
    }

    fn as_ptr(&self) -> *const c_char {
        self.0.as_ptr().cast()
    }
}

impl cylfuse_fitter {
    pub(super) fn new() -> Self {
        Self {
            busy: AtomicBool::new(false),
            poisoned: AtomicBool::new(false),
            cancelled: AtomicBool::new(false),
            content: UnsafeCell::default(),
        }
    }

    /// Asks the running fit, or the next one, to stop.
    pub(super) fn cancel(&self) -> cylfuse_status {
        if self.poisoned.load(Ordering::Acquire) {
            return cylfuse_status::PANIC;
        }
        self.cancelled.store(true, Ordering::Release);
        cylfuse_status::OK
    }

    /// Takes the busy flag; false when another call has it.
    pub(super) fn try_enter(&self) -> bool {
        !self.busy.swap(true, Ordering::Acquire)
    }

    fn leave(&self) {
        self.busy.store(false, Ordering::Release);
    }

    /// The text of the last failure.
    pub(super) fn last_error(&self) -> *const c_char {
        if !self.try_enter() {
            return c"the fitter is busy in another call; ask when that has returned".as_ptr();
        }
        // SAFETY: the busy flag is ours, so no other call has a reference to the content.
        let text = unsafe { (*self.content.get()).message.as_ptr() };
        self.leave();
        text
    }
}

/// Runs a call on a fitter: takes the busy flag, catches panics, keeps the message. `call` also gets the flag
/// that a request to cancel sets.
///
/// # Safety
/// `fitter` is NULL or a fitter that was created and not destroyed.
pub(super) unsafe fn enter(
    fitter: *const cylfuse_fitter,
    call: impl FnOnce(&mut Content, &AtomicBool) -> Result<(), Failure>,
) -> cylfuse_status {
    // SAFETY: the caller's obligation. All fields that other threads reach are atomic or inside the cell.
    let Some(handle) = (unsafe { fitter.as_ref() }) else {
        return stateless(|| Err(Failure::NullPointer { name: "fitter" }));
    };
    if !handle.try_enter() {
        return cylfuse_status::BUSY;
    }
    let status = if handle.poisoned.load(Ordering::Acquire) {
        cylfuse_status::PANIC
    } else {
        // SAFETY: the busy flag is ours until `leave`, so this is the only reference to the content.
        let content = unsafe { &mut *handle.content.get() };
        run(handle, content, call)
    };
    handle.leave();
    status
}

fn run(
    handle: &cylfuse_fitter,
    content: &mut Content,
    call: impl FnOnce(&mut Content, &AtomicBool) -> Result<(), Failure>,
) -> cylfuse_status {
    let outcome = guard(|| {
        let outcome = call(content, &handle.cancelled);
        content.message = match &outcome {
            Ok(()) => Text::default(),
            Err(failure) => Text::new(&failure.to_string()),
        };
        if let Err(failure) = &outcome {
            // Without any room it was a question how much is needed.
            let asked = matches!(failure, Failure::BufferTooSmall { capacity: 0, .. });
            let level = if asked { cylfuse_log_level::DEBUG } else { cylfuse_log_level::ERROR };
            content.log.write(level, || failure.to_string());
        }
        outcome.map_or_else(|failure| failure.status(), |()| cylfuse_status::OK)
    });
    outcome.unwrap_or_else(|panic| {
        handle.poisoned.store(true, Ordering::Release);
        content.message = Text::new(&format!("defect of the library, destroy the fitter: {panic}"));
        cylfuse_status::PANIC
    })
}

/// Runs a call without a fitter, and keeps its message for the thread.
pub(super) fn stateless(call: impl FnOnce() -> Result<(), Failure>) -> cylfuse_status {
    let (status, message) = match guard(call) {
        Ok(Ok(())) => (cylfuse_status::OK, Text::default()),
        Ok(Err(failure)) => (failure.status(), Text::new(&failure.to_string())),
        Err(panic) => (cylfuse_status::PANIC, Text::new(&format!("defect of the library: {panic}"))),
    };
    WITHOUT_FITTER.with(|kept| kept.replace(message));
    status
}

/// The text of the last failure without a fitter on this thread.
pub(super) fn last_error_without_fitter() -> *const c_char {
    WITHOUT_FITTER.with(|kept| kept.borrow().as_ptr())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ffi::CStr;

    #[test]
    fn long_texts_are_cut_between_characters() {
        let text = Text::new(&"é".repeat(400));
        let kept = CStr::from_bytes_until_nul(&text.0).unwrap().to_str().unwrap();
        assert_eq!(kept, "é".repeat(255));
    }
}
