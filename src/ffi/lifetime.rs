//! From creating a fitter to destroying it.

use super::constants::cylfuse_input;
use super::handle::{Content, Handle, cancel, cylfuse_fitter, enter_to_change, enter_to_read, last_error};
use super::library::{allocate, create, destroy};
use super::status::cylfuse_status;
use super::views::Slot;
use std::ffi::c_char;

/// Makes a fitter with default options, one view at the identity, and no data.
///
/// Use one fitter for many fits. The memory that a call needs is not freed after it but kept in the fitter, so that a later
/// call with as many data allocates none. It is about as much memory as the data themselves take.
///
/// @param abi_version `CYLFUSE_ABI_VERSION`
/// @param out_fitter where the fitter goes, for `cylfuse_fitter_destroy` in the end; set to NULL when the call
///   fails
/// @return ABI_MISMATCH when the program was compiled for another version of the interface, OUT_OF_MEMORY
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_create(
    abi_version: u32,
    out_fitter: *mut *mut cylfuse_fitter,
) -> cylfuse_status {
    // SAFETY: as the header asks, `out_fitter` is NULL or writable.
    unsafe { create(abi_version, out_fitter, "out_fitter") }
}

/// Makes another fitter with all that one holds: options, cameras, poses and data of all views, start model, the last
/// result and what the start LAST goes on from. Callbacks stay behind. Images are shared and not copied, but points are:
/// set up one fitter, and clone it for each thread before data are pushed.
///
/// @param fitter the fitter, which stays as it is
/// @param out_fitter where the new one goes, for `cylfuse_fitter_destroy` in the end; set to NULL when the call fails
/// @return OUT_OF_MEMORY
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_clone(
    fitter: *const cylfuse_fitter,
    out_fitter: *mut *mut cylfuse_fitter,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_read(fitter, |content, _| {
        // SAFETY: as the header asks, `out_fitter` is NULL or writable.
        let out = unsafe { Slot::new(out_fitter, "out_fitter") }?;
        out.write(std::ptr::null_mut());
        let content = Content { fitter: content.fitter.try_clone()?, ..Content::default() };
        out.write(allocate(cylfuse_fitter(Handle::new(content)))?);
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
    // SAFETY: as the header asks, `fitter` is NULL or alive, and no other call on it runs or follows.
    unsafe { destroy(fitter) }
}

/// Makes room for the coordinates of that many more points and for that many more segments in the selected view.
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
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_change(fitter, |content, _| Ok(content.fitter.reserve(points, segments)?))
}

/// Forgets the data, all views but the first, its pose and the result; keeps options, the cameras of the first view,
/// start model, what the start LAST goes on from, callbacks and memory: the way from one frame to the next.
///
/// @param fitter the fitter
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_clear(fitter: *mut cylfuse_fitter) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_change(fitter, |content, _| {
        content.fitter.clear();
        Ok(())
    })
}

/// Forgets some of the data of the selected view, and keeps the rest and the last result.
///
/// @param fitter the fitter
/// @param inputs which data, `CYLFUSE_INPUT_...` by bit
/// @return INVALID_ARGUMENT for an unknown bit
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_clear_input(
    fitter: *mut cylfuse_fitter,
    inputs: cylfuse_input,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_change(fitter, |content, _| {
        content.fitter.clear_inputs(inputs.read("inputs")?);
        Ok(())
    })
}

/// Why the last call on a fitter failed: what was wrong, the value, the limit and the remedy, one line of ASCII. Empty
/// when the call succeeded.
///
/// Ask right after the call, on the same thread: the text is then about that call, even where other threads use the
/// fitter too. Where the last call of this thread was not on this fitter, the text is about the call on the fitter that
/// finished last, on any thread. So it is found, too, by a program whose tasks move between threads.
///
/// @param fitter the fitter, which may be busy; NULL asks for the last call of this thread, whatever it was on, which
///   is where calls without a fitter leave their text
/// @return a text that is valid until the next call of this thread that returns a status or asks for such a text; never
///   NULL
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_last_error(fitter: *const cylfuse_fitter) -> *const c_char {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    unsafe { last_error(fitter) }
}

/// Asks the calls that are running on a fitter to stop: a fit returns CANCELLED before its next iteration or random
/// sample. When no call is running it does nothing. May be called from any thread and from callbacks.
///
/// @param fitter the fitter
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_cancel(fitter: *mut cylfuse_fitter) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    unsafe { cancel(fitter) }
}
