//! What stays from frame to frame: options, camera, start model, callbacks.

use super::constants::cylfuse_log_level;
use super::handle::{Callback, Log, cylfuse_fitter, enter};
use super::sized::{Output, read};
use super::status::cylfuse_status;
use super::structs::{cylfuse_cylinder, cylfuse_intrinsics, cylfuse_options, cylfuse_progress};
use super::views;
use std::ffi::{c_char, c_void};

/// Hears of every linear solve of a fit, on the thread that called `cylfuse_fitter_fit`.
///
/// It must not throw, unwind or longjmp. Of the functions on the same fitter it may only call
/// `cylfuse_fitter_cancel`: all others return BUSY. Other fitters are free.
///
/// @param progress valid until the callback returns
/// @param user_data what was given with the callback
/// @return 0 to go on; anything else stops the fit, which returns CANCELLED
pub type cylfuse_progress_fn =
    Option<unsafe extern "C" fn(progress: *const cylfuse_progress, user_data: *mut c_void) -> i32>;

/// Takes a log line, on the thread that called the function. The rules of `cylfuse_progress_fn` hold here too.
///
/// @param level how much it matters
/// @param message one line without a line break, valid until the callback returns
/// @param user_data what was given with the callback
pub type cylfuse_log_fn =
    Option<unsafe extern "C" fn(level: cylfuse_log_level, message: *const c_char, user_data: *mut c_void)>;

/// Replaces the options.
///
/// @param fitter the fitter
/// @param options copied
/// @return INVALID_ARGUMENT for a value out of range, STRUCT_SIZE; the old options stay then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_set_options(
    fitter: *mut cylfuse_fitter,
    options: *const cylfuse_options,
) -> cylfuse_status {
    // SAFETY: the contract of the header.
    unsafe { enter(fitter, |content, _| Ok(content.fitter.set_options(read(options, "options")?.read()?)?)) }
}

/// Reads the options.
///
/// @param fitter the fitter
/// @param out_options where they go; set its `struct_size` before
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_get_options(
    fitter: *const cylfuse_fitter,
    out_options: *mut cylfuse_options,
) -> cylfuse_status {
    // SAFETY: the contract of the header.
    unsafe {
        enter(fitter, |content, _| {
            Output::new(out_options, "out_options")?.write(&content.fitter.options().into());
            Ok(())
        })
    }
}

/// Sets the camera, which depth images and edges need. Points that were pushed before stay as they are.
///
/// @param fitter the fitter
/// @param intrinsics copied
/// @return INVALID_INTRINSICS, INVALID_ARGUMENT for an unknown model, STRUCT_SIZE; the old camera stays then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_set_intrinsics(
    fitter: *mut cylfuse_fitter,
    intrinsics: *const cylfuse_intrinsics,
) -> cylfuse_status {
    // SAFETY: the contract of the header.
    unsafe {
        enter(fitter, |content, _| {
            let intrinsics = views::intrinsics(&read(intrinsics, "intrinsics")?)?;
            Ok(content.fitter.set_intrinsics(intrinsics)?)
        })
    }
}

/// Sets a start model: a candidate for the start AUTO, the start of MODEL.
///
/// @param fitter the fitter
/// @param model copied; NULL takes the start model away
/// @return INVALID_ARGUMENT when a number is not finite, the direction 0 or the radius not positive; the old
///   start model stays then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_set_start_model(
    fitter: *mut cylfuse_fitter,
    model: *const cylfuse_cylinder,
) -> cylfuse_status {
    // SAFETY: the contract of the header.
    unsafe {
        enter(fitter, |content, _| {
            content.fitter.set_start(views::optional_cylinder(model)?);
            Ok(())
        })
    }
}

/// Sets or takes away the progress callback.
///
/// @param fitter the fitter
/// @param callback NULL for none
/// @param user_data handed to the callback, kept until the callback is replaced; may be NULL
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_set_progress(
    fitter: *mut cylfuse_fitter,
    callback: cylfuse_progress_fn,
    user_data: *mut c_void,
) -> cylfuse_status {
    // SAFETY: the contract of the header.
    unsafe {
        enter(fitter, |content, _| {
            content.progress = Callback { function: callback, user_data };
            Ok(())
        })
    }
}

/// Sets or takes away the log callback. There is none at first, and the library never prints.
///
/// @param fitter the fitter
/// @param max_level lines up to this level are handed over
/// @param callback NULL for none
/// @param user_data handed to the callback, kept until the callback is replaced; may be NULL
/// @return INVALID_ARGUMENT for an unknown level
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_set_log(
    fitter: *mut cylfuse_fitter,
    max_level: cylfuse_log_level,
    callback: cylfuse_log_fn,
    user_data: *mut c_void,
) -> cylfuse_status {
    // SAFETY: the contract of the header.
    unsafe {
        enter(fitter, |content, _| {
            max_level.check("max_level")?;
            content.log = Log { level: max_level.0, callback: Callback { function: callback, user_data } };
            Ok(())
        })
    }
}
