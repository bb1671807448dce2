//! Functions of the caller.

use super::constants::cylfuse_log_level;
use super::results::{cylfuse_detection_progress, cylfuse_progress};
use super::status::cylfuse_status;
use super::texts::Text;
use std::ffi::{c_char, c_void};

/// Called before every iteration of a fit, on the thread that called `cylfuse_fitter_fit`, and with the last one again
/// between the other steps of the fit.
///
/// It must not throw, unwind or longjmp. Of the functions on the same fitter it may only call
/// `cylfuse_fitter_cancel` and `cylfuse_fitter_last_error`: all others return BUSY. Other fitters are free.
///
/// @param progress valid until the callback returns
/// @param user_data what was given with the callback
/// @return 0 to go on; anything else stops the fit, which returns CANCELLED
pub type cylfuse_progress_fn =
    Option<unsafe extern "C" fn(progress: *const cylfuse_progress, user_data: *mut c_void) -> i32>;

/// Is called with the progress of a detector: before the search, after it, and after each fit, on the thread that
/// called `cylfuse_detector_detect` or `cylfuse_detector_detect_points`. A cloud that was not seen from its origin is
/// searched from many places, and phase and counts begin again with each.
///
/// It must not throw, unwind or longjmp. Of the functions on the same detector it may only call
/// `cylfuse_detector_cancel` and `cylfuse_detector_last_error`: all others return BUSY. Other detectors and all fitters
/// are free.
///
/// @param progress valid until the callback returns
/// @param user_data what was given with the callback
/// @return 0 to go on; anything else stops the search, which returns CANCELLED
pub type cylfuse_detection_progress_fn =
    Option<unsafe extern "C" fn(progress: *const cylfuse_detection_progress, user_data: *mut c_void) -> i32>;

/// Is called after each fit of `cylfuse_fit_all`, in the order in which they end, on the thread that called it.
///
/// It must not throw, unwind or longjmp. It may call functions on fitters whose fit has ended, such as
/// `cylfuse_fitter_get_result` on this one; the others may be BUSY.
///
/// @param index the index of the fitter
/// @param status what `cylfuse_fitter_fit` would have returned for it
/// @param user_data what was given with the callback
/// @return 0 to go on; anything else stops the fits that run, and no other begins
pub type cylfuse_fit_all_fn =
    Option<unsafe extern "C" fn(index: usize, status: cylfuse_status, user_data: *mut c_void) -> i32>;

/// Takes a log line, on the thread that called the function: on several at once when several threads make calls with
/// a `const cylfuse_fitter *`. It must not throw, unwind or longjmp, nor call functions on the same fitter but
/// `cylfuse_fitter_cancel` and `cylfuse_fitter_last_error`.
///
/// @param level how much it matters
/// @param message one line without a line break, valid until the callback returns
/// @param user_data what was given with the callback
pub type cylfuse_log_fn =
    Option<unsafe extern "C" fn(level: cylfuse_log_level, message: *const c_char, user_data: *mut c_void)>;

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
    /// Hands a line over; `line` is called when the level is wanted.
    pub fn write(&self, level: cylfuse_log_level, line: impl FnOnce() -> String) {
        let Some(function) = self.callback.function.filter(|_| level.0 <= self.level) else { return };
        let text = Text::new(&line());
        // SAFETY: the caller gave the function for this use; the text is NUL-terminated and lives until it
        // returns.
        unsafe { function(level, text.as_ptr(), self.callback.user_data) };
    }
}
