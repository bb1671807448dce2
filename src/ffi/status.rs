//! The numbers that calls return, and the failures behind them.

use super::library::CYLFUSE_ABI_VERSION;
use crate::error::Error;
use std::ffi::CStr;

/// What a call returns: 0 when it did what it was asked to, else a negative number that says why not.
///
/// A failed call changes nothing and writes no output unless its text says so; the handle stays usable, but for
/// `CYLFUSE_STATUS_PANIC`. The numbers never change and new ones may be added: treat an unknown negative number
/// as a failure.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_status(pub i32);

impl cylfuse_status {
    /// The call did what it was asked to.
    pub const OK: cylfuse_status = cylfuse_status(0);
    /// An argument or field has a value outside its documented range.
    pub const INVALID_ARGUMENT: cylfuse_status = cylfuse_status(-1);
    /// A pointer that is needed is NULL.
    pub const NULL_POINTER: cylfuse_status = cylfuse_status(-2);
    /// A `struct_size` or `element_size` is smaller than the first version of the struct or larger than 4096, or a
    /// struct to be read is larger than this library knows it and uses fields that this library does not know.
    pub const STRUCT_SIZE: cylfuse_status = cylfuse_status(-3);
    /// The program was compiled for another, incompatible version of the library.
    pub const ABI_MISMATCH: cylfuse_status = cylfuse_status(-4);
    /// The call came before something that it needs.
    pub const BAD_STATE: cylfuse_status = cylfuse_status(-5);
    /// Another call on the same handle is running, in another thread or around a callback, and one of the two may
    /// change it.
    pub const BUSY: cylfuse_status = cylfuse_status(-6);
    /// The buffer for the output is too small; the call says how much it needs and writes nothing else.
    pub const BUFFER_TOO_SMALL: cylfuse_status = cylfuse_status(-7);
    /// Memory could not be allocated: pass less data at once, or free memory.
    pub const OUT_OF_MEMORY: cylfuse_status = cylfuse_status(-8);
    /// Not supported with these options or data.
    pub const UNSUPPORTED: cylfuse_status = cylfuse_status(-9);
    /// Images on one pixel grid have different sizes.
    pub const SIZE_MISMATCH: cylfuse_status = cylfuse_status(-10);
    /// No camera works with these intrinsics.
    pub const INVALID_INTRINSICS: cylfuse_status = cylfuse_status(-11);
    /// Too few usable points. A fit needs 5, as many as a cylinder has degrees of freedom; a plan needs 8 points with
    /// independent noise.
    pub const TOO_FEW_POINTS: cylfuse_status = cylfuse_status(-20);
    /// The points are as flat as a plane.
    pub const PLANAR_POINTS: cylfuse_status = cylfuse_status(-21);
    /// The points lie on one straight line.
    pub const COLLINEAR_POINTS: cylfuse_status = cylfuse_status(-22);
    /// No pixel of the mask is set.
    pub const EMPTY_MASK: cylfuse_status = cylfuse_status(-23);
    /// No pixel in the region has a usable depth.
    pub const NO_DEPTH: cylfuse_status = cylfuse_status(-24);
    /// No start for the iteration could be found.
    pub const NO_START: cylfuse_status = cylfuse_status(-25);
    /// The camera sees no limbs of the cylinder where they are needed, or nothing that was given meets it.
    pub const EDGE_GEOMETRY: cylfuse_status = cylfuse_status(-26);
    /// The arithmetic left the range of numbers.
    pub const NUMERICAL: cylfuse_status = cylfuse_status(-27);
    /// A progress callback, `cylfuse_fitter_cancel` or `cylfuse_detector_cancel` asked to stop.
    pub const CANCELLED: cylfuse_status = cylfuse_status(-40);
    /// A defect of the library. The handle can only be destroyed after it; others are not affected.
    pub const PANIC: cylfuse_status = cylfuse_status(-99);
}

/// Every status with its name and meaning.
pub const STATUSES: &[(cylfuse_status, &CStr)] = &[
    (cylfuse_status::OK, c"OK: success"),
    (cylfuse_status::INVALID_ARGUMENT, c"INVALID_ARGUMENT: an argument is outside its documented range"),
    (cylfuse_status::NULL_POINTER, c"NULL_POINTER: a pointer that is needed is NULL"),
    (cylfuse_status::STRUCT_SIZE, c"STRUCT_SIZE: the size given for a struct is wrong"),
    (cylfuse_status::ABI_MISMATCH, c"ABI_MISMATCH: program and library do not go together"),
    (cylfuse_status::BAD_STATE, c"BAD_STATE: the call came before something that it needs"),
    (cylfuse_status::BUSY, c"BUSY: another call on the same handle is running"),
    (cylfuse_status::BUFFER_TOO_SMALL, c"BUFFER_TOO_SMALL: the buffer for the output is too small"),
    (cylfuse_status::OUT_OF_MEMORY, c"OUT_OF_MEMORY: memory could not be allocated"),
    (cylfuse_status::UNSUPPORTED, c"UNSUPPORTED: not supported with these options or data"),
    (cylfuse_status::SIZE_MISMATCH, c"SIZE_MISMATCH: images on one pixel grid have different sizes"),
    (cylfuse_status::INVALID_INTRINSICS, c"INVALID_INTRINSICS: no camera works with these intrinsics"),
    (cylfuse_status::TOO_FEW_POINTS, c"TOO_FEW_POINTS: fewer usable points than a cylinder needs"),
    (cylfuse_status::PLANAR_POINTS, c"PLANAR_POINTS: the points are as flat as a plane"),
    (cylfuse_status::COLLINEAR_POINTS, c"COLLINEAR_POINTS: the points lie on one straight line"),
    (cylfuse_status::EMPTY_MASK, c"EMPTY_MASK: no pixel of the mask is set"),
    (cylfuse_status::NO_DEPTH, c"NO_DEPTH: no pixel in the region has a usable depth"),
    (cylfuse_status::NO_START, c"NO_START: no start for the iteration could be found"),
    (
        cylfuse_status::EDGE_GEOMETRY,
        c"EDGE_GEOMETRY: the camera sees no limbs of the cylinder, or nothing meets it",
    ),
    (cylfuse_status::NUMERICAL, c"NUMERICAL: the arithmetic left the range of numbers"),
    (cylfuse_status::CANCELLED, c"CANCELLED: the caller asked to stop"),
    (cylfuse_status::PANIC, c"PANIC: a defect of the library; destroy the handle"),
];

/// The name and meaning of a status.
pub(super) fn describe(status: cylfuse_status) -> &'static CStr {
    let known = STATUSES.iter().find(|(known, _)| *known == status);
    known
        .map_or(c"unknown status: the library is newer than the program, or the number is no status", |k| k.1)
}

/// Why a call failed.
#[derive(Debug, thiserror::Error)]
pub(super) enum Failure {
    #[error(transparent)]
    Library(#[from] Error),
    #[error("{name} is NULL; give a pointer")]
    NullPointer { name: &'static str },
    #[error("{name}.struct_size is {given}; it must {requirement}")]
    StructSize { name: &'static str, given: usize, requirement: String },
    #[error("element_size is {given}; it must {requirement}")]
    ElementSize { given: usize, requirement: String },
    #[error("{name} holds {capacity} but {needed} are needed; give a larger buffer")]
    BufferTooSmall { name: &'static str, capacity: usize, needed: usize },
    #[error("the frame is busy in another call, or met a defect; wait until the call has returned")]
    Frame { status: cylfuse_status },
    #[error(
        "abi_version is {given}; this library has {CYLFUSE_ABI_VERSION}; use header and library of one release"
    )]
    AbiMismatch { given: u32 },
}

impl Failure {
    /// An argument or field outside its range.
    pub fn argument(
        name: impl Into<String>,
        value: impl std::fmt::Display,
        requirement: impl Into<String>,
    ) -> Self {
        Self::Library(Error::argument(name, value, requirement))
    }

    pub fn status(&self) -> cylfuse_status {
        match self {
            Failure::Library(error) => cylfuse_status(error.code()),
            Failure::NullPointer { .. } => cylfuse_status::NULL_POINTER,
            Failure::StructSize { .. } | Failure::ElementSize { .. } => cylfuse_status::STRUCT_SIZE,
            Failure::BufferTooSmall { .. } => cylfuse_status::BUFFER_TOO_SMALL,
            Failure::Frame { status } => *status,
            Failure::AbiMismatch { .. } => cylfuse_status::ABI_MISMATCH,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_begin_with_the_name_of_the_status() {
        let of = |status| describe(status).to_str().unwrap();
        assert!(of(cylfuse_status::OK).starts_with("OK: "));
        for error in [
            Error::argument("radius", 0, "be greater than 0"),
            Error::Unsupported { what: String::new(), remedy: "" },
            Error::Cancelled { iterations: 0 },
        ] {
            let failure = Failure::Library(error.clone());
            assert!(of(failure.status()).starts_with(&format!("{}: ", error.name())), "{error:?}");
        }
        assert!(of(cylfuse_status(-1000)).starts_with("unknown status"));
    }

    #[test]
    fn no_number_is_used_twice() {
        let mut numbers: Vec<i32> = STATUSES.iter().map(|(status, _)| status.0).collect();
        numbers.sort_unstable();
        numbers.dedup();
        assert_eq!(numbers.len(), STATUSES.len());
    }
}
