//! A defect on demand, for the tests: nothing that the library exports.

use super::handle::{cylfuse_fitter, enter_to_change};
use super::status::cylfuse_status;

/// Panics inside a call on the fitter; the guard turns it into the status.
///
/// # Safety
/// As any call on a fitter: NULL, or one that `cylfuse_fitter_create` has made and nobody has freed.
#[doc(hidden)]
#[must_use]
pub unsafe fn panic_in_a_call(fitter: *mut cylfuse_fitter) -> cylfuse_status {
    // SAFETY: the caller promises NULL or a living fitter.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_change(fitter, |_, _| panic!("provoked by cylfuse_test_panic"))
}
