//! The defaults of the structs. Every struct with `struct_size` has a function here.

use super::handle::stateless;
use super::results::{
    cylfuse_completion, cylfuse_counts, cylfuse_cylinder_diagnosis, cylfuse_cylinder_estimate,
    cylfuse_extent, cylfuse_result,
};
use super::sized::{SizeTagged, init, zeroed};
use super::status::cylfuse_status;
use super::structs::{
    cylfuse_depth_out, cylfuse_depth_view, cylfuse_detector_options, cylfuse_image_view, cylfuse_intrinsics,
    cylfuse_mask_view, cylfuse_options, cylfuse_points_out, cylfuse_points_view, cylfuse_segments_view,
};
use crate::fitter::Options;
use crate::scene::DetectorOptions;

/// Fills a struct with defaults.
///
/// # Safety
/// As [`init`].
unsafe fn fill<T: SizeTagged>(
    pointer: *mut T,
    name: &'static str,
    struct_size: usize,
    defaults: impl FnOnce() -> T,
) -> cylfuse_status {
    stateless(|| {
        // SAFETY: the caller promises NULL or room for `struct_size` bytes.
        unsafe { init(pointer, name, struct_size, &defaults()) }
    })
}

/// Fills options with the defaults.
///
/// @param options what to fill
/// @param struct_size `sizeof(cylfuse_options)`
/// @return STRUCT_SIZE for a size that cannot be, and then nothing is written
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_options_init(
    options: *mut cylfuse_options,
    struct_size: usize,
) -> cylfuse_status {
    // SAFETY: as the header asks, `options` is NULL or room for `struct_size` bytes.
    unsafe { fill(options, "options", struct_size, || (&Options::default()).into()) }
}

/// Fills options of a detector with the defaults.
///
/// @param options what to fill
/// @param struct_size `sizeof(cylfuse_detector_options)`
/// @return STRUCT_SIZE for a size that cannot be, and then nothing is written
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_detector_options_init(
    options: *mut cylfuse_detector_options,
    struct_size: usize,
) -> cylfuse_status {
    // SAFETY: as the header asks, `options` is NULL or room for `struct_size` bytes.
    unsafe { fill(options, "options", struct_size, || (&DetectorOptions::default()).into()) }
}

/// Fills intrinsics with zeros: a pinhole, whose size, focal lengths and principal point the caller sets.
///
/// @param intrinsics what to fill
/// @param struct_size `sizeof(cylfuse_intrinsics)`
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_intrinsics_init(
    intrinsics: *mut cylfuse_intrinsics,
    struct_size: usize,
) -> cylfuse_status {
    // SAFETY: as the header asks, `intrinsics` is NULL or room for `struct_size` bytes.
    unsafe { fill(intrinsics, "intrinsics", struct_size, zeroed) }
}

/// Fills a view of points with zeros and a height of 1: packed points without weights, whose scalar, data and
/// width the caller sets.
///
/// @param points what to fill
/// @param struct_size `sizeof(cylfuse_points_view)`
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_points_view_init(
    points: *mut cylfuse_points_view,
    struct_size: usize,
) -> cylfuse_status {
    // SAFETY: as the header asks, `points` is NULL or room for `struct_size` bytes.
    unsafe { fill(points, "points", struct_size, || cylfuse_points_view { height: 1, ..zeroed() }) }
}

/// Fills a view of a depth image with zeros and a scale of 1: packed, without limits of the depth; the caller
/// sets format, data and size.
///
/// @param depth what to fill
/// @param struct_size `sizeof(cylfuse_depth_view)`
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_depth_view_init(
    depth: *mut cylfuse_depth_view,
    struct_size: usize,
) -> cylfuse_status {
    // SAFETY: as the header asks, `depth` is NULL or room for `struct_size` bytes.
    unsafe { fill(depth, "depth", struct_size, || cylfuse_depth_view { scale: 1.0, ..zeroed() }) }
}

/// Fills a view of a mask with zeros: packed; the caller sets data and size.
///
/// @param mask what to fill
/// @param struct_size `sizeof(cylfuse_mask_view)`
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_mask_view_init(
    mask: *mut cylfuse_mask_view,
    struct_size: usize,
) -> cylfuse_status {
    // SAFETY: as the header asks, `mask` is NULL or room for `struct_size` bytes.
    unsafe { fill(mask, "mask", struct_size, zeroed) }
}

/// Fills a view of an image with zeros and a gamma of 1: packed, linear in light; the caller sets format, data
/// and size.
///
/// @param image what to fill
/// @param struct_size `sizeof(cylfuse_image_view)`
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_image_view_init(
    image: *mut cylfuse_image_view,
    struct_size: usize,
) -> cylfuse_status {
    // SAFETY: as the header asks, `image` is NULL or room for `struct_size` bytes.
    unsafe { fill(image, "image", struct_size, || cylfuse_image_view { gamma: 1.0, ..zeroed() }) }
}

/// Fills a view of segments with zeros: packed, without weights; the caller sets scalar, data and count.
///
/// @param segments what to fill
/// @param struct_size `sizeof(cylfuse_segments_view)`
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_segments_view_init(
    segments: *mut cylfuse_segments_view,
    struct_size: usize,
) -> cylfuse_status {
    // SAFETY: as the header asks, `segments` is NULL or room for `struct_size` bytes.
    unsafe { fill(segments, "segments", struct_size, zeroed) }
}

/// Fills a buffer for points with zeros: packed points; the caller sets scalar, data and capacity.
///
/// @param out what to fill
/// @param struct_size `sizeof(cylfuse_points_out)`
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_points_out_init(
    out: *mut cylfuse_points_out,
    struct_size: usize,
) -> cylfuse_status {
    // SAFETY: as the header asks, `out` is NULL or room for `struct_size` bytes.
    unsafe { fill(out, "out", struct_size, zeroed) }
}

/// Fills a buffer for a depth image with zeros and a scale of 1: packed; the caller sets format, data and size.
///
/// @param out what to fill
/// @param struct_size `sizeof(cylfuse_depth_out)`
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_depth_out_init(
    out: *mut cylfuse_depth_out,
    struct_size: usize,
) -> cylfuse_status {
    // SAFETY: as the header asks, `out` is NULL or room for `struct_size` bytes.
    unsafe { fill(out, "out", struct_size, || cylfuse_depth_out { scale: 1.0, ..zeroed() }) }
}

/// Fills counts with zeros and the size: room for an output.
///
/// @param counts what to fill
/// @param struct_size `sizeof(cylfuse_counts)`
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_counts_init(
    counts: *mut cylfuse_counts,
    struct_size: usize,
) -> cylfuse_status {
    // SAFETY: as the header asks, `counts` is NULL or room for `struct_size` bytes.
    unsafe { fill(counts, "counts", struct_size, zeroed) }
}

/// Fills a result with zeros and the size: room for an output.
///
/// @param result what to fill
/// @param struct_size `sizeof(cylfuse_result)`
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_result_init(
    result: *mut cylfuse_result,
    struct_size: usize,
) -> cylfuse_status {
    // SAFETY: as the header asks, `result` is NULL or room for `struct_size` bytes.
    unsafe { fill(result, "result", struct_size, zeroed) }
}

/// Fills an estimate with zeros and the size: room for an output.
///
/// @param estimate what to fill
/// @param struct_size `sizeof(cylfuse_cylinder_estimate)`
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_cylinder_estimate_init(
    estimate: *mut cylfuse_cylinder_estimate,
    struct_size: usize,
) -> cylfuse_status {
    // SAFETY: as the header asks, `estimate` is NULL or room for `struct_size` bytes.
    unsafe { fill(estimate, "estimate", struct_size, zeroed) }
}

/// Fills a diagnosis with zeros and the size: room for an output.
///
/// @param diagnosis what to fill
/// @param struct_size `sizeof(cylfuse_cylinder_diagnosis)`
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_cylinder_diagnosis_init(
    diagnosis: *mut cylfuse_cylinder_diagnosis,
    struct_size: usize,
) -> cylfuse_status {
    // SAFETY: as the header asks, `diagnosis` is NULL or room for `struct_size` bytes.
    unsafe { fill(diagnosis, "diagnosis", struct_size, zeroed) }
}

/// Fills the counts of a completion with zeros and the size: room for an output.
///
/// @param completion what to fill
/// @param struct_size `sizeof(cylfuse_completion)`
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_completion_init(
    completion: *mut cylfuse_completion,
    struct_size: usize,
) -> cylfuse_status {
    // SAFETY: as the header asks, `completion` is NULL or room for `struct_size` bytes.
    unsafe { fill(completion, "completion", struct_size, zeroed) }
}

/// Fills an extent with zeros and the size: room for an output.
///
/// @param extent what to fill
/// @param struct_size `sizeof(cylfuse_extent)`
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_extent_init(
    extent: *mut cylfuse_extent,
    struct_size: usize,
) -> cylfuse_status {
    // SAFETY: as the header asks, `extent` is NULL or room for `struct_size` bytes.
    unsafe { fill(extent, "extent", struct_size, zeroed) }
}
