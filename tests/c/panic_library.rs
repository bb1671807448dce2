//! The shared library with one more export, a defect on demand: `tests/c_api.rs` has C call it.

use cylfuse::ffi::{cylfuse_fitter, cylfuse_status, panic_in_a_call};

/// Panics inside a call on the fitter.
///
/// # Safety
/// As any call on a fitter.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_test_panic(fitter: *mut cylfuse_fitter) -> cylfuse_status {
    // SAFETY: the contract of this function.
    unsafe { panic_in_a_call(fitter) }
}
