//! What stays from frame to frame: options, views with camera and pose, start model, callbacks.

use super::callbacks::{Callback, Log, cylfuse_log_fn, cylfuse_progress_fn};
use super::constants::cylfuse_log_level;
use super::frame::depth_camera;
use super::handle::{cylfuse_fitter, enter_to_change, enter_to_read};
use super::sized::{Output, read};
use super::status::{Failure, cylfuse_status};
use super::structs::{cylfuse_cylinder, cylfuse_intrinsics, cylfuse_options};
use super::views::{self, Slot};
use crate::error::Error;
use std::ffi::c_void;

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
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_change(fitter, |content, _| {
        // SAFETY: as the header asks, `options` is NULL or a struct of its `struct_size`.
        let options = unsafe { read(options, "options") }?;
        Ok(content.fitter.set_options(options.read()?)?)
    })
}

/// Reads the options.
///
/// @param fitter the fitter
/// @param out_options where they go; `cylfuse_options_init` comes before
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_get_options(
    fitter: *const cylfuse_fitter,
    out_options: *mut cylfuse_options,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_read(fitter, |content, _| {
        // SAFETY: as the header asks, `out_options` is NULL or room for its `struct_size`.
        let out = unsafe { Output::new(out_options, "out_options") }?;
        out.write(&content.fitter.options().into());
        Ok(())
    })
}

/// Selects a view, so that the calls that set or push something, and those whose text says so, concern that view. There
/// is one view at first, number 0, and it is selected: with one view this function is not needed.
///
/// All views see the same cylinder. A fit uses the data of all of them; models, results and extents are in the
/// reference frame, in which the poses of the views are given. With one view at the identity that is the camera frame.
///
/// @param fitter the fitter
/// @param index the view, from 0; the number of views adds one, at the identity and without a camera
/// @return INVALID_ARGUMENT for a larger index, OUT_OF_MEMORY
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_select_view(
    fitter: *mut cylfuse_fitter,
    index: usize,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_change(fitter, |content, _| {
        let count = content.fitter.view_count();
        if index > count || u32::try_from(index).is_err() {
            let requirement = format!("be at most the number of views, {count}, which adds one");
            return Err(Failure::argument("index", index, requirement));
        }
        Ok(content.fitter.select_view(index)?)
    })
}

/// Says how many views there are, at least 1.
///
/// @param fitter the fitter
/// @param out_count where the number goes
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_view_count(
    fitter: *const cylfuse_fitter,
    out_count: *mut usize,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_read(fitter, |content, _| {
        // SAFETY: as the header asks, `out_count` is NULL or writable.
        let out = unsafe { Slot::new(out_count, "out_count") }?;
        out.write(content.fitter.view_count());
        Ok(())
    })
}

/// Sets the pose of the selected view: x_reference = rotation * x_camera + translation. The identity at first.
///
/// @param fitter the fitter
/// @param rotation 9 doubles, a rotation matrix row by row, to 1e-4; small rounding errors are corrected
/// @param translation 3 doubles, the position of the camera in the reference frame, in the unit of length
/// @return INVALID_ARGUMENT when a number is not finite or the matrix is no rotation; the old pose stays then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_set_pose(
    fitter: *mut cylfuse_fitter,
    rotation: *const f64,
    translation: *const f64,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_change(fitter, |content, _| {
        // SAFETY: as the header asks, `rotation` is NULL or 9 doubles and `translation` NULL or 3 doubles.
        let pose = unsafe { views::motion(rotation, translation) }?;
        content.fitter.set_pose(pose);
        Ok(())
    })
}

/// Gives the depth of the selected view a camera of its own, for depth that is not registered to the colour image:
/// depth images that are pushed later are then in its pixels; mask, image and edges stay in those of the colour
/// camera, which `cylfuse_fitter_set_intrinsics` sets. A mask selects the depth pixels that the colour camera sees in
/// it.
///
/// @param fitter the fitter
/// @param intrinsics those of the depth camera, copied; NULL takes the depth camera away, and what follows is not read
/// @param rotation 9 doubles, row by row: x_colour = rotation * x_depth + translation
/// @param translation 3 doubles, in the unit of length
/// @return INVALID_INTRINSICS, INVALID_ARGUMENT, STRUCT_SIZE; SIZE_MISMATCH with a depth image that was pushed
///   (`cylfuse_fitter_clear_input`), OUT_OF_MEMORY; the old depth camera stays then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_set_depth_camera(
    fitter: *mut cylfuse_fitter,
    intrinsics: *const cylfuse_intrinsics,
    rotation: *const f64,
    translation: *const f64,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_change(fitter, |content, _| {
        // SAFETY: as the header asks, `intrinsics` is NULL or a struct of its `struct_size`, `rotation` NULL or 9
        // doubles and `translation` NULL or 3 doubles.
        let camera = unsafe { depth_camera(intrinsics, rotation, translation) }?;
        Ok(content.fitter.set_depth_camera(camera)?)
    })
}

/// Sets the colour camera of the selected view, which depth images, images and edges need. Points that were pushed
/// before stay as they are.
///
/// @param fitter the fitter
/// @param intrinsics copied
/// @return INVALID_INTRINSICS, INVALID_ARGUMENT for an unknown model, STRUCT_SIZE; SIZE_MISMATCH with an image that was
///   pushed (`cylfuse_fitter_clear_input`), OUT_OF_MEMORY; the old camera stays then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_set_intrinsics(
    fitter: *mut cylfuse_fitter,
    intrinsics: *const cylfuse_intrinsics,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_change(fitter, |content, _| {
        // SAFETY: as the header asks, `intrinsics` is NULL or a struct of its `struct_size`.
        let intrinsics = unsafe { read(intrinsics, "intrinsics") }?;
        let intrinsics = views::intrinsics(&intrinsics)?;
        Ok(content.fitter.set_intrinsics(intrinsics)?)
    })
}

/// Reads the intrinsics of the colour camera of the selected view: those that were set, or those of its frame.
///
/// @param fitter the fitter
/// @param out_intrinsics where they go; `cylfuse_intrinsics_init` comes before
/// @return BAD_STATE when the view has no colour camera
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_get_intrinsics(
    fitter: *const cylfuse_fitter,
    out_intrinsics: *mut cylfuse_intrinsics,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_read(fitter, |content, _| {
        // SAFETY: as the header asks, `out_intrinsics` is NULL or room for its `struct_size`.
        let out = unsafe { Output::new(out_intrinsics, "out_intrinsics") }?;
        let camera = content.fitter.camera().ok_or(Error::BadState {
            call: "reading the intrinsics",
            missing: "a colour camera in the selected view",
            remedy: "set its intrinsics or use a frame first",
        })?;
        out.write(&camera.intrinsics().into());
        Ok(())
    })
}

/// Sets a start model: a candidate for the start AUTO, the start of MODEL. Of points alone that hold several bodies AUTO and
/// LAST fit the one near it.
///
/// @param fitter the fitter
/// @param model in the reference frame, copied; NULL takes the start model away
/// @return INVALID_ARGUMENT when a number is not finite, the direction 0 or the radius not positive; the old
///   start model stays then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_set_start_model(
    fitter: *mut cylfuse_fitter,
    model: *const cylfuse_cylinder,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_change(fitter, |content, _| {
        // SAFETY: as the header asks, `model` is NULL or a cylinder.
        let model = unsafe { views::optional_cylinder(model) }?;
        content.fitter.set_start(model);
        Ok(())
    })
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
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_change(fitter, |content, _| {
        content.progress = Callback { function: callback, user_data };
        Ok(())
    })
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
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_change(fitter, |content, _| {
        max_level.check("max_level")?;
        content.log = Log { level: max_level.0, callback: Callback { function: callback, user_data } };
        Ok(())
    })
}
