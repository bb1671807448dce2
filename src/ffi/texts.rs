//! The texts of failed calls.
//!
//! Each thread keeps the text of its last call, and each handle that of the last call on it that finished. A thread
//! is only ever shown memory of its own, so that no other thread can write to what it reads.

use std::cell::{Cell, RefCell};
use std::ffi::c_char;
use std::sync::atomic::{AtomicU64, Ordering};

/// In place of the serial number of a handle, for calls without one.
pub(super) const NO_HANDLE: u64 = 0;

const CAPACITY: usize = 512;

/// A NUL-terminated line of ASCII of limited length, so that a text never needs memory.
#[derive(Clone, Copy)]
pub(super) struct Text([u8; CAPACITY]);

impl Text {
    pub const EMPTY: Self = Self([0; CAPACITY]);

    /// A line break becomes a space, what is not ASCII a question mark.
    pub fn new(text: &str) -> Self {
        let mut copy = Self::EMPTY;
        for (to, character) in copy.0[..CAPACITY - 1].iter_mut().zip(text.chars()) {
            *to = match character {
                ' '..='~' => character as u8,
                control if control.is_ascii_control() => b' ',
                _ => b'?',
            };
        }
        copy
    }

    pub fn as_ptr(&self) -> *const c_char {
        self.0.as_ptr().cast()
    }
}

struct OfThread {
    /// The handle of the last call.
    serial: u64,
    last: Text,
    /// The text of another thread that was asked for.
    shown: Text,
}

thread_local! {
    static TEXTS: RefCell<OfThread> =
        const { RefCell::new(OfThread { serial: NO_HANDLE, last: Text::EMPTY, shown: Text::EMPTY }) };
    static NUMBER: Cell<u64> = const { Cell::new(NO_THREAD) };
}

/// In place of the number of a thread, for none.
pub(super) const NO_THREAD: u64 = 0;

/// The number of this thread, which no other has had or will have.
pub(super) fn this_thread() -> u64 {
    static NUMBERS: AtomicU64 = AtomicU64::new(NO_THREAD + 1);
    NUMBER.with(|number| {
        if number.get() == NO_THREAD {
            number.set(NUMBERS.fetch_add(1, Ordering::Relaxed));
        }
        number.get()
    })
}

/// Keeps the text of a call of this thread.
pub(super) fn keep(serial: u64, text: Text) {
    TEXTS.with_borrow_mut(|texts| {
        texts.serial = serial;
        texts.last = text;
    });
}

/// The text of the last call of this thread if it was on that handle, else the one of the handle.
pub(super) fn last(serial: u64, of_handle: impl FnOnce() -> Text) -> *const c_char {
    TEXTS.with_borrow_mut(|texts| {
        if texts.serial == serial {
            return texts.last.as_ptr();
        }
        texts.shown = of_handle();
        texts.shown.as_ptr()
    })
}

/// The text of the last call of this thread, whatever it was on.
pub(super) fn last_of_thread() -> *const c_char {
    TEXTS.with_borrow(|texts| texts.last.as_ptr())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ffi::CStr;

    fn kept(text: &str) -> String {
        CStr::from_bytes_until_nul(&Text::new(text).0).unwrap().to_str().unwrap().to_string()
    }

    #[test]
    fn texts_are_one_line_of_ascii_that_ends() {
        assert_eq!(kept("a\nb\tc\0d é"), "a b c d ?");
        assert_eq!(kept(&"x".repeat(600)), "x".repeat(511));
    }

    #[test]
    fn a_thread_sees_its_own_last_call_and_else_that_of_the_handle() {
        // SAFETY: texts are NUL-terminated.
        let read = |text| unsafe { CStr::from_ptr(text) }.to_str().unwrap().to_string();
        keep(7, Text::new("mine"));
        assert_eq!(read(last(7, || Text::new("of the handle"))), "mine");
        assert_eq!(read(last(8, || Text::new("of the handle"))), "of the handle");
        assert_eq!(read(last_of_thread()), "mine");
    }
}
