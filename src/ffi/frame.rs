//! What a camera delivered at one time, for any number of fits.

use super::data::optional_mask;
use super::handle::{Handle, Logs, cylfuse_fitter, enter_to_change, stateless};
use super::handle::{change, read as look};
use super::library::create;
use super::sized::read;
use super::status::{Failure, cylfuse_status};
use super::structs::{cylfuse_depth_view, cylfuse_image_view, cylfuse_intrinsics, cylfuse_mask_view};
use super::views;
use crate::camera::Camera;
use std::ffi::c_char;

/// What one camera delivered at one time: intrinsics, pose, depth image, image. Any number of fitters use one frame
/// without a copy, such as one for each cylinder of a scene. Opaque; made by `cylfuse_frame_create`.
///
/// A frame is filled first and used then: once a fitter uses it, it stays as it is. It may be destroyed while fitters
/// use it, which keep what they need. Calls that fill it run one at a time; any number of threads may use it at once.
pub struct cylfuse_frame(Handle<Content>);

#[derive(Default)]
struct Content {}

impl Logs for Content {}

/// Runs a call that fills a frame.
///
/// # Safety
/// `frame` is NULL or a frame that was created and not destroyed.
unsafe fn enter(
    frame: *mut cylfuse_frame,
    call: impl FnOnce(&mut Content) -> Result<(), Failure>,
) -> cylfuse_status {
    // SAFETY: the caller's obligation.
    match unsafe { frame.as_ref() } {
        Some(frame) => change(&frame.0, |content, _| call(content)),
        None => stateless(|| Err(Failure::NullPointer { name: "frame" })),
    }
}

fn not_yet() -> Failure {
    Failure::unsupported("frames are not used yet", "push the data into the fitter")
}

/// Makes a frame at the identity, without a camera and data.
///
/// @param abi_version `CYLFUSE_ABI_VERSION`
/// @param out_frame where the frame goes, for `cylfuse_frame_destroy` in the end; set to NULL when the call fails
/// @return ABI_MISMATCH when the program was compiled for another version of the interface, OUT_OF_MEMORY
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_frame_create(
    abi_version: u32,
    out_frame: *mut *mut cylfuse_frame,
) -> cylfuse_status {
    // SAFETY: the contract of the header.
    unsafe { create(abi_version, out_frame, "out_frame", || cylfuse_frame(Handle::default())) }
}

/// Destroys a frame. Fitters that use it go on with what they need of it. No other call on it may be running or
/// follow.
///
/// @param frame the frame; NULL does nothing
/// @return BUSY when a call on the frame is running; nothing is destroyed then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_frame_destroy(frame: *mut cylfuse_frame) -> cylfuse_status {
    // SAFETY: NULL or a living frame, by the contract of the header.
    let Some(handle) = (unsafe { frame.as_ref() }) else { return stateless(|| Ok(())) };
    if !handle.0.close() {
        return cylfuse_status::BUSY;
    }
    stateless(|| {
        // SAFETY: it came from `create`, no call uses it, and the caller says that none follows.
        drop(unsafe { Box::from_raw(frame) });
        Ok(())
    })
}

/// Why the last call on a frame failed; see `cylfuse_fitter_last_error`, whose rules hold here too. The text of
/// `cylfuse_fitter_use_frame` is with the fitter.
///
/// @param frame the frame; NULL asks for the last call of this thread, whatever it was on
/// @return a text that is valid until the next call of this thread into the library; never NULL
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_frame_last_error(frame: *const cylfuse_frame) -> *const c_char {
    // SAFETY: NULL or a living frame, by the contract of the header.
    match unsafe { frame.as_ref() } {
        Some(frame) => frame.0.last_error(),
        None => super::texts::last_of_thread(),
    }
}

/// Sets the colour camera of a frame; it comes before depth and image.
///
/// @param frame the frame
/// @param intrinsics copied
/// @return INVALID_INTRINSICS, INVALID_ARGUMENT for an unknown model, STRUCT_SIZE; BAD_STATE when the frame is in use
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_frame_set_intrinsics(
    frame: *mut cylfuse_frame,
    intrinsics: *const cylfuse_intrinsics,
) -> cylfuse_status {
    // SAFETY: the contract of the header.
    unsafe {
        enter(frame, |_| {
            let _camera = Camera::new(views::intrinsics(&read(intrinsics, "intrinsics")?)?)?;
            Err(not_yet())
        })
    }
}

/// Sets the pose of a frame: x_reference = rotation * x_camera + translation. The identity at first.
///
/// @param frame the frame
/// @param rotation 9 doubles, a rotation matrix row by row, to 1e-6; rounding is mended
/// @param translation 3 doubles, in the unit of length
/// @return INVALID_ARGUMENT when a number is not finite or the matrix is no rotation; BAD_STATE when the frame is in
///   use
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_frame_set_pose(
    frame: *mut cylfuse_frame,
    rotation: *const f64,
    translation: *const f64,
) -> cylfuse_status {
    // SAFETY: the contract of the header.
    unsafe {
        enter(frame, |_| {
            let _motion = views::motion(rotation, translation)?;
            Err(not_yet())
        })
    }
}

/// Gives the depth of a frame a camera of its own; it comes before the depth. See `cylfuse_fitter_set_depth_camera`.
///
/// @param frame the frame
/// @param intrinsics those of the depth camera, copied; NULL takes the depth camera away, and what follows is not read
/// @param rotation 9 doubles, row by row: x_colour = rotation * x_depth + translation
/// @param translation 3 doubles, in the unit of length
/// @return INVALID_INTRINSICS, INVALID_ARGUMENT, STRUCT_SIZE; BAD_STATE when the frame is in use
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_frame_set_depth_camera(
    frame: *mut cylfuse_frame,
    intrinsics: *const cylfuse_intrinsics,
    rotation: *const f64,
    translation: *const f64,
) -> cylfuse_status {
    // SAFETY: the contract of the header.
    unsafe {
        enter(frame, |_| {
            if !intrinsics.is_null() {
                let _camera = Camera::new(views::intrinsics(&read(intrinsics, "intrinsics")?)?)?;
                let _motion = views::motion(rotation, translation)?;
            }
            Err(not_yet())
        })
    }
}

/// Sets the depth image of a frame.
///
/// @param frame the frame, with intrinsics
/// @param depth copied
/// @return BAD_STATE without intrinsics and when the frame is in use, SIZE_MISMATCH, NO_DEPTH when no pixel is usable,
///   INVALID_ARGUMENT for a bad scale, range or stride, OUT_OF_MEMORY
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_frame_set_depth(
    frame: *mut cylfuse_frame,
    depth: *const cylfuse_depth_view,
) -> cylfuse_status {
    // SAFETY: the contract of the header.
    unsafe {
        enter(frame, |_| {
            let _depth = views::depth_view(&read(depth, "depth")?)?;
            Err(not_yet())
        })
    }
}

/// Sets the image of a frame, grey or in colour.
///
/// @param frame the frame, with intrinsics
/// @param image copied
/// @return BAD_STATE without intrinsics and when the frame is in use, SIZE_MISMATCH, INVALID_ARGUMENT for a bad stride
///   or gamma, or a value that is not finite or that the gamma forbids, OUT_OF_MEMORY
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_frame_set_image(
    frame: *mut cylfuse_frame,
    image: *const cylfuse_image_view,
) -> cylfuse_status {
    // SAFETY: the contract of the header.
    unsafe {
        enter(frame, |_| {
            let _image = views::image_view(&read(image, "image")?)?;
            Err(not_yet())
        })
    }
}

/// Lets the selected view of a fitter take its camera, its pose, its image and the points of the depth inside a mask
/// from a frame, in place of what the view had of these. Clouds and edge segments of the view stay.
///
/// @param fitter the fitter
/// @param frame the frame, with intrinsics: it can no longer be changed, and nothing of it is copied
/// @param mask in the pixels of the colour image, copied; NULL = all pixels
/// @return BAD_STATE without intrinsics, SIZE_MISMATCH, EMPTY_MASK, NO_DEPTH when no pixel in the mask is usable, BUSY
///   when the frame is being filled, OUT_OF_MEMORY; the view stays as it was then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_use_frame(
    fitter: *mut cylfuse_fitter,
    frame: *const cylfuse_frame,
    mask: *const cylfuse_mask_view,
) -> cylfuse_status {
    // SAFETY: the contract of the header.
    unsafe {
        enter_to_change(fitter, |_, _| {
            let Some(frame) = frame.as_ref() else { return Err(Failure::NullPointer { name: "frame" }) };
            let _mask = optional_mask(mask)?;
            let _ = look(&frame.0, |_, _| Ok(()));
            Err(not_yet())
        })
    }
}
