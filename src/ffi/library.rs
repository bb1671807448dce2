//! Functions about the library itself, and the defaults of its structs.

use super::sized::{SizeTagged, init, zeroed};
use super::status::{cylfuse_status, describe};
use super::structs::{
    cylfuse_depth_out, cylfuse_depth_view, cylfuse_image_view, cylfuse_intrinsics, cylfuse_mask_view,
    cylfuse_options, cylfuse_points_out, cylfuse_points_view, cylfuse_segments_view,
};
use crate::fitter::Options;
use std::ffi::{CStr, c_char};

/// The version of the binary interface that this header describes. It changes only when old programs stop
/// working, and the soname changes with it.
pub const CYLFUSE_ABI_VERSION: u32 = 1;

/// A NUL-terminated constant of the build.
const fn terminated(text: &'static str) -> &'static CStr {
    match CStr::from_bytes_with_nul(text.as_bytes()) {
        Ok(text) => text,
        Err(_) => panic!("the text ends with its only NUL"),
    }
}

const fn number(digits: &str) -> u32 {
    let (mut value, mut index) = (0, 0);
    while index < digits.len() {
        value = 10 * value + (digits.as_bytes()[index] - b'0') as u32;
        index += 1;
    }
    value
}

const VERSION: &CStr = terminated(concat!(env!("CARGO_PKG_VERSION"), "\0"));
const VERSION_NUMBER: u32 = number(env!("CARGO_PKG_VERSION_MAJOR")) << 16
    | number(env!("CARGO_PKG_VERSION_MINOR")) << 8
    | number(env!("CARGO_PKG_VERSION_PATCH"));
const BUILD_INFO: &CStr = terminated(concat!(env!("CYLFUSE_BUILD_INFO"), "\0"));

// The next four functions return constants: there is nothing in them that could panic.

/// The `CYLFUSE_ABI_VERSION` of the loaded library.
#[unsafe(no_mangle)]
pub extern "C" fn cylfuse_abi_version() -> u32 {
    CYLFUSE_ABI_VERSION
}

/// The version of the loaded library as a number, major * 65536 + minor * 256 + patch: compare it with
/// `CYLFUSE_VERSION_NUMBER`, the version that the program was compiled for.
#[unsafe(no_mangle)]
pub extern "C" fn cylfuse_version_number() -> u32 {
    VERSION_NUMBER
}

/// The version of the loaded library as text, such as "0.1.0". Static.
#[unsafe(no_mangle)]
pub extern "C" fn cylfuse_version_string() -> *const c_char {
    VERSION.as_ptr()
}

/// How the library was built: version, target, profile, compiler, features. Static, for reports of defects.
#[unsafe(no_mangle)]
pub extern "C" fn cylfuse_build_info() -> *const c_char {
    BUILD_INFO.as_ptr()
}

/// The name of a status without its prefix, a colon, and what it means in a few words. Static; a text for
/// unknown numbers too.
#[unsafe(no_mangle)]
pub extern "C" fn cylfuse_status_string(status: cylfuse_status) -> *const c_char {
    describe(status).as_ptr()
}

/// Fills a struct that the caller goes on to fill.
///
/// # Safety
/// As [`init`].
unsafe fn fill<T: SizeTagged>(
    pointer: *mut T,
    name: &'static str,
    struct_size: usize,
    defaults: impl FnOnce() -> T,
) -> cylfuse_status {
    super::handle::stateless(|| {
        // SAFETY: the caller's obligation.
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
    // SAFETY: the contract of the header.
    unsafe { fill(options, "options", struct_size, || (&Options::default()).into()) }
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
    // SAFETY: the contract of the header.
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
    // SAFETY: the contract of the header.
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
    // SAFETY: the contract of the header.
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
    // SAFETY: the contract of the header.
    unsafe { fill(mask, "mask", struct_size, zeroed) }
}

/// Fills a view of a grey image with zeros and a gamma of 1: packed, linear in light; the caller sets format, data
/// and size.
///
/// @param image what to fill
/// @param struct_size `sizeof(cylfuse_image_view)`
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_image_view_init(
    image: *mut cylfuse_image_view,
    struct_size: usize,
) -> cylfuse_status {
    // SAFETY: the contract of the header.
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
    // SAFETY: the contract of the header.
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
    // SAFETY: the contract of the header.
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
    // SAFETY: the contract of the header.
    unsafe { fill(out, "out", struct_size, || cylfuse_depth_out { scale: 1.0, ..zeroed() }) }
}
