//! What a detector found.

use super::detector::cylfuse_detector;
use super::handle::{Content, Handle, cylfuse_fitter, enter_to_read};
use super::library::allocate;
use super::lists::write_numbers;
use super::results::{cylfuse_cylinder_estimate, cylfuse_detection, cylfuse_extent, cylfuse_result};
use super::sized::{Output, OutputArray};
use super::status::cylfuse_status;
use super::views::Slot;

/// Says how many cylinders the last scene has.
///
/// @param detector the detector
/// @param out_count where the number goes
/// @return BAD_STATE when no scene was searched
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_detector_count(
    detector: *const cylfuse_detector,
    out_count: *mut usize,
) -> cylfuse_status {
    // SAFETY: as the header asks, `detector` is NULL or alive.
    let detector = unsafe { detector.as_ref() };
    enter_to_read(detector, |content, _| {
        // SAFETY: as the header asks, `out_count` is NULL or writable.
        let out = unsafe { Slot::new(out_count, "out_count") }?;
        out.write(content.scene()?.cylinders.len());
        Ok(())
    })
}

/// Says whether the last scene was looked at as a whole. The work of a search with its fits is bounded, so that no input
/// takes much longer than any other of its size. A scene that has more in it than that is searched by falling score until
/// the work is done: cylinders may be missing. One for whose fit there was no work left is what the search found, with
/// `CYLFUSE_RESULT_FLAGS_NOT_CONVERGED`.
///
/// @param detector the detector
/// @param out_complete 1, or 0 when cylinders may be missing
/// @return BAD_STATE when no scene was searched
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_detector_is_complete(
    detector: *const cylfuse_detector,
    out_complete: *mut i32,
) -> cylfuse_status {
    // SAFETY: as the header asks, `detector` is NULL or alive.
    let detector = unsafe { detector.as_ref() };
    enter_to_read(detector, |content, _| {
        // SAFETY: as the header asks, `out_complete` is NULL or writable.
        let out = unsafe { Slot::new(out_complete, "out_complete") }?;
        out.write(i32::from(content.scene()?.complete));
        Ok(())
    })
}

/// Says by how many pixels the depth of the last frame was moved to where the image shows the same bodies. Where registration
/// is off by pixels, edges beside limbs would be taken for these. Each result then has
/// `CYLFUSE_RESULT_FLAGS_DEPTH_SHIFTED`; labels and indices are those of the depth as it was given.
///
/// @param detector the detector
/// @param out_columns how far to the right; negative to the left, 0 where it was not moved
/// @param out_rows how far down; negative is up, 0 where it was not moved
/// @return BAD_STATE when no scene was searched
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_detector_depth_moved(
    detector: *const cylfuse_detector,
    out_columns: *mut i32,
    out_rows: *mut i32,
) -> cylfuse_status {
    // SAFETY: as the header asks, `detector` is NULL or alive.
    let detector = unsafe { detector.as_ref() };
    enter_to_read(detector, |content, _| {
        // SAFETY: as the header asks, `out_columns` is NULL or writable.
        let columns = unsafe { Slot::new(out_columns, "out_columns") }?;
        // SAFETY: as the header asks, `out_rows` is NULL or writable.
        let rows = unsafe { Slot::new(out_rows, "out_rows") }?;
        let moved = content.scene()?.depth_moved;
        columns.write(moved[0]);
        rows.write(moved[1]);
        Ok(())
    })
}

/// Lists the cylinders of the last scene by falling score. Their order numbers them from 0 in the calls that ask for one.
///
/// @param detector the detector
/// @param out room for `capacity` elements of `element_size` bytes, of any alignment; may be NULL when `capacity`
///   is 0
/// @param element_size `sizeof(cylfuse_detection)`
/// @param capacity how many elements `out` holds
/// @param out_count how many there are; set after BUFFER_TOO_SMALL too
/// @return BAD_STATE when no scene was searched, STRUCT_SIZE, BUFFER_TOO_SMALL
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_detector_detections(
    detector: *const cylfuse_detector,
    out: *mut cylfuse_detection,
    element_size: usize,
    capacity: usize,
    out_count: *mut usize,
) -> cylfuse_status {
    // SAFETY: as the header asks, `detector` is NULL or alive.
    let detector = unsafe { detector.as_ref() };
    enter_to_read(detector, |content, _| {
        // SAFETY: as the header asks, `out` is NULL or room for `capacity` elements of `element_size` bytes and
        // `out_count` NULL or writable.
        let out = unsafe { OutputArray::new(out, element_size, capacity, out_count) }?;
        out.write(content.scene()?.cylinders.iter().map(|found| cylfuse_detection {
            score: found.score,
            pixels: found.pixels as u64,
            model: (&found.result.cylinder).into(),
        }))
    })
}

/// Reads the outcome of the fit of one cylinder.
///
/// @param detector the detector
/// @param index the cylinder, from 0
/// @param out_result where the result goes; `cylfuse_result_init` comes before
/// @return BAD_STATE when no scene was searched, INVALID_ARGUMENT when there is no such cylinder
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_detector_get_result(
    detector: *const cylfuse_detector,
    index: usize,
    out_result: *mut cylfuse_result,
) -> cylfuse_status {
    // SAFETY: as the header asks, `detector` is NULL or alive.
    let detector = unsafe { detector.as_ref() };
    enter_to_read(detector, |content, _| {
        // SAFETY: as the header asks, `out_result` is NULL or room for its `struct_size`.
        let out = unsafe { Output::new(out_result, "out_result") }?;
        out.write(&(&content.cylinder(index)?.result).into());
        Ok(())
    })
}

/// Reads one cylinder with its deviations.
///
/// @param detector the detector
/// @param index the cylinder, from 0
/// @param out_estimate where the cylinder goes; `cylfuse_cylinder_estimate_init` comes before
/// @return BAD_STATE when no scene was searched, INVALID_ARGUMENT when there is no such cylinder
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_detector_get_cylinder(
    detector: *const cylfuse_detector,
    index: usize,
    out_estimate: *mut cylfuse_cylinder_estimate,
) -> cylfuse_status {
    // SAFETY: as the header asks, `detector` is NULL or alive.
    let detector = unsafe { detector.as_ref() };
    enter_to_read(detector, |content, _| {
        // SAFETY: as the header asks, `out_estimate` is NULL or room for its `struct_size`.
        let out = unsafe { Output::new(out_estimate, "out_estimate") }?;
        out.write(&(&content.cylinder(index)?.result).into());
        Ok(())
    })
}

/// Reads the visible piece of one cylinder. Those of a cloud end with their points.
///
/// @param detector the detector
/// @param index the cylinder, from 0
/// @param out_extent where the extent goes; `cylfuse_extent_init` comes before
/// @return BAD_STATE when no scene was searched, INVALID_ARGUMENT when there is no such cylinder, EDGE_GEOMETRY when no ray
///   of its region meets it and no points lie along it
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_detector_get_extent(
    detector: *const cylfuse_detector,
    index: usize,
    out_extent: *mut cylfuse_extent,
) -> cylfuse_status {
    // SAFETY: as the header asks, `detector` is NULL or alive.
    let detector = unsafe { detector.as_ref() };
    enter_to_read(detector, |content, _| {
        // SAFETY: as the header asks, `out_extent` is NULL or room for its `struct_size`.
        let out = unsafe { Output::new(out_extent, "out_extent") }?;
        let extent = content.cylinder(index)?.extent.as_ref().map_err(Clone::clone)?;
        out.write(&extent.into());
        Ok(())
    })
}

/// Writes for each pixel of the colour image, or each point of the cloud, row by row, the number of its cylinder from 1 on:
/// 1 for the cylinder of index 0. 0 = none.
///
/// @param detector the detector
/// @param out room for `capacity` numbers, of any alignment; may be NULL when `capacity` is 0
/// @param capacity width * height of the frame or of the cloud
/// @param out_count how many there are; set after BUFFER_TOO_SMALL too
/// @return BAD_STATE when no scene was searched, BUFFER_TOO_SMALL
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_detector_labels(
    detector: *const cylfuse_detector,
    out: *mut u16,
    capacity: usize,
    out_count: *mut usize,
) -> cylfuse_status {
    // SAFETY: as the header asks, `detector` is NULL or alive.
    let detector = unsafe { detector.as_ref() };
    enter_to_read(detector, |content, _| {
        // SAFETY: as the header asks, `out_count` is NULL or writable.
        let count = unsafe { Slot::new(out_count, "out_count") }?;
        // SAFETY: as the header asks, `out` is NULL or room for `capacity` numbers.
        unsafe { write_numbers(content.scene()?.labels.iter().copied(), out, capacity, &count) }
    })
}

/// Lists the pixels or points of one cylinder, counted from 0 row by row, in rising order.
///
/// @param detector the detector
/// @param index the cylinder, from 0
/// @param out room for `capacity` indices, of any alignment; may be NULL when `capacity` is 0
/// @param capacity `pixels` of its `cylfuse_detection` is enough
/// @param out_count how many there are; set after BUFFER_TOO_SMALL too
/// @return BAD_STATE when no scene was searched, INVALID_ARGUMENT when there is no such cylinder, BUFFER_TOO_SMALL
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_detector_indices(
    detector: *const cylfuse_detector,
    index: usize,
    out: *mut u32,
    capacity: usize,
    out_count: *mut usize,
) -> cylfuse_status {
    // SAFETY: as the header asks, `detector` is NULL or alive.
    let detector = unsafe { detector.as_ref() };
    enter_to_read(detector, |content, _| {
        // SAFETY: as the header asks, `out_count` is NULL or writable.
        let count = unsafe { Slot::new(out_count, "out_count") }?;
        content.cylinder(index)?;
        // There are never more of them than an index of 32 bits counts.
        let indices = content.scene()?.indices(index).map(|k| k as u32);
        // SAFETY: as the header asks, `out` is NULL or room for `capacity` indices.
        unsafe { write_numbers(indices, out, capacity, &count) }
    })
}

/// Makes a fitter of one cylinder as its fit left it, with options, frame or points, region as mask, start model and
/// result: for residuals, completion, limbs and all else that can be asked of a fit, or for another fit. It shares the
/// images of the frame and does not depend on the detector. That of a cloud has no mask: completion asks for intrinsics and
/// one.
///
/// @param detector the detector
/// @param index the cylinder, from 0
/// @param out_fitter where the fitter goes, for `cylfuse_fitter_destroy` in the end; set to NULL when the call fails
/// @return BAD_STATE when no scene was searched, INVALID_ARGUMENT when there is no such cylinder, OUT_OF_MEMORY
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_detector_make_fitter(
    detector: *const cylfuse_detector,
    index: usize,
    out_fitter: *mut *mut cylfuse_fitter,
) -> cylfuse_status {
    // SAFETY: as the header asks, `detector` is NULL or alive.
    let detector = unsafe { detector.as_ref() };
    enter_to_read(detector, |content, _| {
        // SAFETY: as the header asks, `out_fitter` is NULL or writable.
        let out = unsafe { Slot::new(out_fitter, "out_fitter") }?;
        out.write(std::ptr::null_mut());
        content.cylinder(index)?;
        let fitter = content.scene()?.fitter(index)?;
        let content = Content { fitter, ..Content::default() };
        out.write(allocate(cylfuse_fitter(Handle::new(content)))?);
        Ok(())
    })
}
