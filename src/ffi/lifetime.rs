//! From creating a fitter to destroying it.

use super::handle::{cylfuse_fitter, enter, last_error_without_fitter, stateless};
use super::library::CYLFUSE_ABI_VERSION;
use super::status::{Failure, cylfuse_status};
use super::views::Slot;
use std::ffi::c_char;
use std::sync::atomic::Ordering;

/// Makes a fitter with default options and no data.
///
/// @param abi_version `CYLFUSE_ABI_VERSION`
/// @param out_fitter where the fitter goes, for `cylfuse_fitter_destroy` in the end; set to NULL when the call
///   fails
/// @return ABI_MISMATCH when the program was compiled for another version of the interface
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_create(
    abi_version: u32,
    out_fitter: *mut *mut cylfuse_fitter,
) -> cylfuse_status {
    stateless(|| {
        // SAFETY: the contract of the header.
        let out = unsafe { Slot::new(out_fitter, "out_fitter") }?;
        out.write(std::ptr::null_mut());
        if abi_version != CYLFUSE_ABI_VERSION {
            return Err(Failure::AbiMismatch { given: abi_version });
        }
        out.write(Box::into_raw(Box::new(cylfuse_fitter::new())));
        Ok(())
    })
}

/// Destroys a fitter and frees what it holds. No other call on it may be running or follow.
///
/// @param fitter the fitter; NULL does nothing
/// @return BUSY when a call on the fitter is running, which a call from one of its callbacks always finds;
///   nothing is destroyed then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_destroy(fitter: *mut cylfuse_fitter) -> cylfuse_status {
    // SAFETY: NULL or a living fitter, by the contract of the header.
    let Some(handle) = (unsafe { fitter.as_ref() }) else { return cylfuse_status::OK };
    if !handle.try_enter() {
        return cylfuse_status::BUSY;
    }
    stateless(|| {
        // SAFETY: it came from Box::into_raw, the busy flag says that no call uses it, and the caller that none
        // follows.
        drop(unsafe { Box::from_raw(fitter) });
        Ok(())
    })
}

/// Makes room, so that pushing that many more points and segments needs no memory.
///
/// @param fitter the fitter
/// @param points how many points
/// @param segments how many edge segments
/// @return OUT_OF_MEMORY
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_reserve(
    fitter: *mut cylfuse_fitter,
    points: usize,
    segments: usize,
) -> cylfuse_status {
    // SAFETY: the contract of the header.
    unsafe { enter(fitter, |content, _| Ok(content.fitter.reserve(points, segments)?)) }
}

/// Forgets data, result and a pending request to cancel; keeps options, camera, start model, callbacks and
/// memory: the way from one frame to the next.
///
/// @param fitter the fitter
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_clear(fitter: *mut cylfuse_fitter) -> cylfuse_status {
    let call = |content: &mut super::handle::Content, cancelled: &std::sync::atomic::AtomicBool| {
        content.fitter.clear();
        cancelled.store(false, Ordering::Release);
        Ok(())
    };
    // SAFETY: the contract of the header.
    unsafe { enter(fitter, call) }
}

/// Why the last call on the fitter failed: what was wrong, the value, the limit and the remedy, in ASCII. Empty
/// when it succeeded.
///
/// @param fitter the fitter; NULL asks for the last call of this thread that had none
/// @return a text that is valid until the next call on the fitter, or the next one without a fitter on this thread;
///   never NULL. While another call is running it is a fixed text that says so.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_last_error(fitter: *const cylfuse_fitter) -> *const c_char {
    // SAFETY: NULL or a living fitter, by the contract of the header.
    match unsafe { fitter.as_ref() } {
        Some(handle) => handle.last_error(),
        None => last_error_without_fitter(),
    }
}

/// Asks the running fit to stop: it returns CANCELLED before its next linear solve. When no fit is running, the
/// next one stops at once, unless `cylfuse_fitter_clear` comes before it. May be called from any thread and from
/// callbacks while another call is running.
///
/// @param fitter the fitter
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_cancel(fitter: *mut cylfuse_fitter) -> cylfuse_status {
    // SAFETY: NULL or a living fitter, by the contract of the header.
    match unsafe { fitter.as_ref() } {
        Some(handle) => handle.cancel(),
        None => stateless(|| Err(Failure::NullPointer { name: "fitter" })),
    }
}
