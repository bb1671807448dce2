//! Functions about the library itself.

use super::handle::{Opaque, stateless};
use super::status::{Failure, cylfuse_status, describe};
use super::views::Slot;
use crate::error::Error;
use std::alloc::{Layout, alloc};
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

/// The version of the loaded library as text, such as "0.2.0". Static.
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

/// Makes what is behind a handle.
///
/// # Safety
/// `out` is NULL or writable.
pub(super) unsafe fn create<H: Default>(
    abi_version: u32,
    out: *mut *mut H,
    name: &'static str,
) -> cylfuse_status {
    stateless(|| {
        // SAFETY: the caller promises NULL or room for a pointer.
        let out = unsafe { Slot::new(out, name) }?;
        out.write(std::ptr::null_mut());
        if abi_version != CYLFUSE_ABI_VERSION {
            return Err(Failure::AbiMismatch { given: abi_version });
        }
        out.write(allocate(H::default())?);
        Ok(())
    })
}

/// A handle on the heap. As Box::new does it, which would abort the program when memory is short.
pub(super) fn allocate<H>(value: H) -> Result<*mut H, Failure> {
    const { assert!(size_of::<H>() > 0, "there is something to allocate") };
    // SAFETY: the size is not zero.
    let handle = unsafe { alloc(Layout::new::<H>()) }.cast::<H>();
    if handle.is_null() {
        return Err(Error::OutOfMemory { what: "the handle", bytes: size_of::<H>() }.into());
    }
    // SAFETY: the memory has the size and alignment of the value.
    unsafe { handle.write(value) };
    Ok(handle)
}

/// Frees what is behind a handle, unless it cannot be closed because a call on it is running.
///
/// # Safety
/// `handle` is NULL or came from [`allocate`], and no other call on it follows.
pub(super) unsafe fn destroy<H: Opaque>(handle: *mut H) -> cylfuse_status {
    // SAFETY: the caller promises NULL or a living handle.
    let Some(living) = (unsafe { handle.as_ref() }) else { return stateless(|| Ok(())) };
    if !living.handle().close() {
        return cylfuse_status::BUSY;
    }
    stateless(|| {
        // SAFETY: it came from `allocate`, which uses the allocator of Box; no call uses it, and none follows.
        drop(unsafe { Box::from_raw(handle) });
        Ok(())
    })
}
