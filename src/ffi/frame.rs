//! What a camera delivered at one time, for any number of fits.

use super::data::{log_points, optional_mask};
use super::handle::{self, Handle, Opaque, borrow, cylfuse_fitter, enter_to_change, last_error};
use super::library::{create, destroy};
use super::sized::read;
use super::status::{Failure, cylfuse_status};
use super::structs::{cylfuse_depth_view, cylfuse_image_view, cylfuse_intrinsics, cylfuse_mask_view};
use super::views;
use crate::camera::Camera;
use crate::error::Error;
use crate::observations::{DepthCamera, Frame};
use std::ffi::c_char;

/// What one camera delivered at one time: intrinsics, pose, depth image, image. Any number of fitters use one frame
/// without a copy, such as one for each cylinder of a scene. Opaque; made by `cylfuse_frame_create`.
///
/// A fitter takes what the frame holds at that time: what is set later, and its destruction, change nothing in fitters.
/// Calls that fill a frame run one at a time; any number of threads may use it at once.
#[derive(Default)]
pub struct cylfuse_frame(Handle<Frame>);

impl Opaque for cylfuse_frame {
    type Content = Frame;
    const NAME: &'static str = "frame";

    fn handle(&self) -> &Handle<Frame> {
        &self.0
    }
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
    // SAFETY: as the header asks, `out_frame` is NULL or writable.
    unsafe { create(abi_version, out_frame, "out_frame") }
}

/// Destroys a frame. Fitters that use it go on with what they need of it. No other call on it may be running or
/// follow.
///
/// @param frame the frame; NULL does nothing
/// @return BUSY when a call on the frame is running; nothing is destroyed then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_frame_destroy(frame: *mut cylfuse_frame) -> cylfuse_status {
    // SAFETY: as the header asks, `frame` is NULL or alive, and no other call on it runs or follows.
    unsafe { destroy(frame) }
}

/// Why the last call on a frame failed; see `cylfuse_fitter_last_error`, whose rules hold here too. The text of
/// `cylfuse_fitter_use_frame` is with the fitter.
///
/// @param frame the frame; NULL asks for the last call of this thread, whatever it was on
/// @return a text that is valid until the next call of this thread that returns a status or asks for such a text; never
///   NULL
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_frame_last_error(frame: *const cylfuse_frame) -> *const c_char {
    // SAFETY: as the header asks, `frame` is NULL or alive.
    unsafe { last_error(frame) }
}

/// Sets the colour camera of a frame; it comes before depth and image, which must have its size.
///
/// @param frame the frame
/// @param intrinsics copied
/// @return INVALID_INTRINSICS, INVALID_ARGUMENT for an unknown model, STRUCT_SIZE; SIZE_MISMATCH with an image that the
///   frame has, OUT_OF_MEMORY; the old camera stays then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_frame_set_intrinsics(
    frame: *mut cylfuse_frame,
    intrinsics: *const cylfuse_intrinsics,
) -> cylfuse_status {
    // SAFETY: as the header asks, `frame` is NULL or alive.
    let frame = unsafe { frame.as_ref() };
    enter_to_change(frame, |frame, _| {
        // SAFETY: as the header asks, `intrinsics` is NULL or a struct of its `struct_size`.
        let intrinsics = unsafe { read(intrinsics, "intrinsics") }?;
        let camera = Camera::new(views::intrinsics(&intrinsics)?)?;
        Ok(frame.set_camera(camera)?)
    })
}

/// Sets the pose of a frame: x_reference = rotation * x_camera + translation. The identity at first.
///
/// @param frame the frame
/// @param rotation 9 doubles, a rotation matrix row by row, to 1e-4; small rounding errors are corrected
/// @param translation 3 doubles, in the unit of length
/// @return INVALID_ARGUMENT when a number is not finite or the matrix is no rotation; the old pose stays then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_frame_set_pose(
    frame: *mut cylfuse_frame,
    rotation: *const f64,
    translation: *const f64,
) -> cylfuse_status {
    // SAFETY: as the header asks, `frame` is NULL or alive.
    let frame = unsafe { frame.as_ref() };
    enter_to_change(frame, |frame, _| {
        // SAFETY: as the header asks, `rotation` is NULL or 9 doubles and `translation` NULL or 3 doubles.
        let pose = unsafe { views::motion(rotation, translation) }?;
        frame.set_pose(pose);
        Ok(())
    })
}

/// Gives the depth of a frame a camera of its own, whose size the depth image must have. See
/// `cylfuse_fitter_set_depth_camera`.
///
/// @param frame the frame
/// @param intrinsics those of the depth camera, copied; NULL takes the depth camera away, and what follows is not read
/// @param rotation 9 doubles, row by row: x_colour = rotation * x_depth + translation
/// @param translation 3 doubles, in the unit of length
/// @return INVALID_INTRINSICS, INVALID_ARGUMENT, STRUCT_SIZE; SIZE_MISMATCH with the depth image that the frame has,
///   OUT_OF_MEMORY; the old depth camera stays then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_frame_set_depth_camera(
    frame: *mut cylfuse_frame,
    intrinsics: *const cylfuse_intrinsics,
    rotation: *const f64,
    translation: *const f64,
) -> cylfuse_status {
    // SAFETY: as the header asks, `frame` is NULL or alive.
    let frame = unsafe { frame.as_ref() };
    enter_to_change(frame, |frame, _| {
        // SAFETY: as the header asks, `intrinsics` is NULL or a struct of its `struct_size`, `rotation` NULL or 9
        // doubles and `translation` NULL or 3 doubles.
        let camera = unsafe { depth_camera(intrinsics, rotation, translation) }?;
        Ok(frame.set_depth_camera(camera)?)
    })
}

/// Sets the depth image of a frame, in place of an earlier one.
///
/// @param frame the frame, with intrinsics
/// @param depth copied
/// @return BAD_STATE without intrinsics, SIZE_MISMATCH, INVALID_ARGUMENT for a bad scale, range or stride,
///   OUT_OF_MEMORY; the earlier image stays then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_frame_set_depth(
    frame: *mut cylfuse_frame,
    depth: *const cylfuse_depth_view,
) -> cylfuse_status {
    // SAFETY: as the header asks, `frame` is NULL or alive.
    let frame = unsafe { frame.as_ref() };
    enter_to_change(frame, |frame, _| {
        // SAFETY: as the header asks, `depth` is NULL or a depth image that can be read.
        let view = unsafe { read(depth, "depth") }?;
        // SAFETY: as the header asks, what the view leads to can be read.
        let (depth, range) = unsafe { views::depth_view(&view) }?;
        Ok(frame.set_depth(&depth, &range)?)
    })
}

/// Sets the image of a frame, grey or in colour, in place of an earlier one.
///
/// @param frame the frame, with intrinsics
/// @param image copied
/// @return BAD_STATE without intrinsics, SIZE_MISMATCH, INVALID_ARGUMENT for a bad stride or gamma, or a value that is
///   not finite or that the gamma forbids, OUT_OF_MEMORY; the earlier image stays then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_frame_set_image(
    frame: *mut cylfuse_frame,
    image: *const cylfuse_image_view,
) -> cylfuse_status {
    // SAFETY: as the header asks, `frame` is NULL or alive.
    let frame = unsafe { frame.as_ref() };
    enter_to_change(frame, |frame, _| {
        // SAFETY: as the header asks, `image` is NULL or an image that can be read.
        let view = unsafe { read(image, "image") }?;
        // SAFETY: as the header asks, what the view leads to can be read.
        let image = unsafe { views::image_view(&view) }?;
        Ok(frame.set_image(&image)?)
    })
}

/// Lets the selected view of a fitter take camera, depth camera, pose and images from a frame, in place of its own, and
/// adds the points of the depth image, if there is one. Points and edge segments that were pushed stay
/// (`cylfuse_fitter_clear_input`). The images are shared and not copied.
///
/// @param fitter the fitter
/// @param frame the frame, with intrinsics; it may be changed or destroyed afterwards, of which the fitter sees nothing
/// @param mask in the pixels of the colour image, copied; NULL = all pixels
/// @return BAD_STATE without intrinsics, SIZE_MISMATCH, EMPTY_MASK, NO_DEPTH when no pixel of the depth image in the
///   mask is usable, BUSY when the frame is being filled, OUT_OF_MEMORY; the view stays as it was then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_fitter_use_frame(
    fitter: *mut cylfuse_fitter,
    frame: *const cylfuse_frame,
    mask: *const cylfuse_mask_view,
) -> cylfuse_status {
    // SAFETY: as the header asks, `fitter` is NULL or alive.
    let fitter = unsafe { fitter.as_ref() };
    enter_to_change(fitter, |content, _| {
        // SAFETY: as the header asks, `frame` is NULL or alive.
        let frame = unsafe { borrow(frame) }?;
        // SAFETY: as the header asks, `mask` is NULL or a mask that can be read.
        let mask = unsafe { optional_mask(mask) }?;
        let frame = content_of(frame)?;
        if frame.camera().is_none() {
            let remedy = "set the intrinsics of the frame first";
            return Err(Error::BadState { call: "using a frame", missing: "intrinsics", remedy }.into());
        }
        content.fitter.use_frame(&frame, mask.as_ref())?;
        log_points(content, "frame");
        Ok(())
    })
}

/// What a frame holds; its images are shared.
pub(super) fn content_of(frame: &cylfuse_frame) -> Result<Frame, Failure> {
    let mut content = None;
    let status = handle::read(frame, |frame, _| {
        content = Some(frame.clone());
        Ok(())
    });
    content.ok_or(Failure::Frame { status })
}

/// A depth camera of its own, or none where `intrinsics` is NULL.
///
/// # Safety
/// `intrinsics` is NULL or intrinsics, and `rotation` and `translation` are as [`views::motion`] needs them then.
pub(super) unsafe fn depth_camera(
    intrinsics: *const cylfuse_intrinsics,
    rotation: *const f64,
    translation: *const f64,
) -> Result<Option<DepthCamera>, Failure> {
    if intrinsics.is_null() {
        return Ok(None);
    }
    // SAFETY: not NULL, so the caller promises intrinsics.
    let intrinsics = unsafe { read(intrinsics, "intrinsics") }?;
    let camera = Camera::new(views::intrinsics(&intrinsics)?)?;
    // SAFETY: the intrinsics are not NULL, so the caller promises what `motion` needs.
    let to_color = unsafe { views::motion(rotation, translation) }?;
    Ok(Some(DepthCamera { camera, to_color }))
}
