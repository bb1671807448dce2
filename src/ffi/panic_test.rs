//! A defect on demand, for the tests: never part of a shipped library.

use super::handle::{cylfuse_fitter, enter_to_change};
use super::status::cylfuse_status;

/// Panics inside a call on the fitter.
///
/// # Panics
/// Always; the guard turns it into the status.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_test_panic(fitter: *mut cylfuse_fitter) -> cylfuse_status {
    // SAFETY: the contract of the header.
    unsafe { enter_to_change(fitter, |_, _| panic!("provoked by cylfuse_test_panic")) }
}
