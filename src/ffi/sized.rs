//! Structs whose first field is their size: how a program and a library of different versions understand each
//! other.

use super::status::Failure;
use super::structs::{
    cylfuse_completion, cylfuse_counts, cylfuse_depth_out, cylfuse_depth_view, cylfuse_diagnosis,
    cylfuse_extent, cylfuse_image_view, cylfuse_intrinsics, cylfuse_mask_view, cylfuse_options,
    cylfuse_points_out, cylfuse_points_view, cylfuse_result, cylfuse_segments_view,
};
use std::mem::{MaybeUninit, offset_of, size_of};

/// A `struct_size` above this is taken for a field that was never set.
const LARGEST: usize = 4096;

/// A struct whose first field is `struct_size: u32`.
///
/// `unsafe` code in this file relies on it: implementors are `repr(C)` and consist of integers, floats and raw
/// pointers, for which any bits are a value, without padding (the layout test adds the fields up). All
/// implementations are below.
pub(super) trait SizeTagged: Copy {
    /// Size of the first published version. Fields that are appended later leave it as it is.
    const FIRST_SIZE: usize;
}

impl SizeTagged for cylfuse_intrinsics {
    const FIRST_SIZE: usize = offset_of!(Self, distortion) + size_of::<[f64; 8]>();
}

impl SizeTagged for cylfuse_points_view {
    const FIRST_SIZE: usize = offset_of!(Self, normal_row_stride) + size_of::<isize>();
}

impl SizeTagged for cylfuse_points_out {
    const FIRST_SIZE: usize = offset_of!(Self, reserved) + size_of::<u32>();
}

impl SizeTagged for cylfuse_depth_view {
    const FIRST_SIZE: usize = offset_of!(Self, max_depth) + size_of::<f64>();
}

impl SizeTagged for cylfuse_depth_out {
    const FIRST_SIZE: usize = offset_of!(Self, scale) + size_of::<f64>();
}

impl SizeTagged for cylfuse_mask_view {
    const FIRST_SIZE: usize = offset_of!(Self, pixel_stride) + size_of::<isize>();
}

impl SizeTagged for cylfuse_image_view {
    const FIRST_SIZE: usize = offset_of!(Self, pixel_stride) + size_of::<isize>();
}

impl SizeTagged for cylfuse_segments_view {
    const FIRST_SIZE: usize = offset_of!(Self, weights) + size_of::<*const f64>();
}

impl SizeTagged for cylfuse_options {
    const FIRST_SIZE: usize = offset_of!(Self, reserved) + size_of::<u32>();
}

impl SizeTagged for cylfuse_counts {
    const FIRST_SIZE: usize = offset_of!(Self, segments_given) + size_of::<u64>();
}

impl SizeTagged for cylfuse_result {
    const FIRST_SIZE: usize = offset_of!(Self, seconds_total) + size_of::<f64>();
}

impl SizeTagged for cylfuse_diagnosis {
    const FIRST_SIZE: usize = offset_of!(Self, weakest_radius) + size_of::<f64>();
}

impl SizeTagged for cylfuse_completion {
    const FIRST_SIZE: usize = offset_of!(Self, out_of_range) + size_of::<u64>();
}

impl SizeTagged for cylfuse_extent {
    const FIRST_SIZE: usize = offset_of!(Self, length) + size_of::<f64>();
}

fn check_size<T: SizeTagged>(name: &'static str, given: usize) -> Result<(), Failure> {
    if (T::FIRST_SIZE..=LARGEST).contains(&given) {
        return Ok(());
    }
    let requirement = format!("be sizeof of the struct, {} to {LARGEST}", T::FIRST_SIZE);
    Err(Failure::StructSize { name, given, requirement })
}

/// The size that the caller set.
///
/// # Safety
/// `pointer` is NULL or points to a readable `u32` first field.
unsafe fn given_size<T: SizeTagged>(pointer: *const T, name: &'static str) -> Result<usize, Failure> {
    if pointer.is_null() {
        return Err(Failure::NullPointer { name });
    }
    // SAFETY: not NULL, so the first field can be read; no alignment is assumed.
    let given = unsafe { pointer.cast::<u32>().read_unaligned() } as usize;
    check_size::<T>(name, given).map(|()| given)
}

/// Reads a struct of any version: fields that an older program does not have are 0, fields of a newer one must
/// be 0.
///
/// # Safety
/// `pointer` is NULL or points to `struct_size` readable bytes.
pub(super) unsafe fn read<T: SizeTagged>(pointer: *const T, name: &'static str) -> Result<T, Failure> {
    // SAFETY: the caller's obligation.
    let given = unsafe { given_size(pointer, name) }?;
    let bytes = pointer.cast::<u8>();
    let known = size_of::<T>();
    for offset in known..given {
        // SAFETY: `offset` is below the size that the caller set.
        if unsafe { bytes.add(offset).read() } != 0 {
            let requirement = format!(
                "be at most {known} here, or the rest be zero: byte {offset} is not; update the library"
            );
            return Err(Failure::StructSize { name, given, requirement });
        }
    }
    let mut value = MaybeUninit::<T>::zeroed();
    // SAFETY: both sides hold that many bytes and do not overlap, since one is a local variable.
    unsafe { std::ptr::copy_nonoverlapping(bytes, value.as_mut_ptr().cast(), given.min(known)) };
    // SAFETY: every byte is set, and any bits are a value of such a struct.
    Ok(unsafe { value.assume_init() })
}

/// The same where NULL means none.
///
/// # Safety
/// As [`read`].
pub(super) unsafe fn read_optional<T: SizeTagged>(
    pointer: *const T,
    name: &'static str,
) -> Result<Option<T>, Failure> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: the caller's obligation.
    unsafe { read(pointer, name) }.map(Some)
}

/// A struct of the caller to be written, checked before the work is done.
pub(super) struct Output<T> {
    pointer: *mut T,
    given: usize,
}

impl<T: SizeTagged> Output<T> {
    /// Checks pointer and size.
    ///
    /// # Safety
    /// `pointer` is NULL or points to `struct_size` writable bytes, of which the first field is initialised, as
    /// long as this value lives.
    pub unsafe fn new(pointer: *mut T, name: &'static str) -> Result<Self, Failure> {
        // SAFETY: the caller's obligation.
        let given = unsafe { given_size(pointer, name) }?;
        Ok(Self { pointer, given })
    }

    /// Writes the fields that the caller's version has. Its `struct_size` stays.
    pub fn write(self, value: &T) {
        const TAG: usize = size_of::<u32>();
        let from = std::ptr::from_ref(value).cast::<u8>();
        let to = self.pointer.cast::<u8>();
        // SAFETY: both sides hold at least min(given, known) bytes, `given` is at least the first size, and the
        // value has no padding.
        unsafe {
            std::ptr::copy_nonoverlapping(from.add(TAG), to.add(TAG), self.given.min(size_of::<T>()) - TAG);
        }
    }
}

/// Fills a struct of any version with defaults; fields that this library does not know become 0.
///
/// # Safety
/// `pointer` is NULL or points to `given` writable bytes.
pub(super) unsafe fn init<T: SizeTagged>(
    pointer: *mut T,
    name: &'static str,
    given: usize,
    defaults: &T,
) -> Result<(), Failure> {
    if pointer.is_null() {
        return Err(Failure::NullPointer { name });
    }
    check_size::<T>(name, given)?;
    // SAFETY: the caller's obligation.
    unsafe { pointer.cast::<u8>().write_bytes(0, given) };
    // SAFETY: as above; `given` was just found to fit a u32.
    unsafe { pointer.cast::<u32>().write_unaligned(given as u32) };
    // SAFETY: the size was just set and checked.
    unsafe { Output::new(pointer, name) }?.write(defaults);
    Ok(())
}

/// A struct with every field 0 or NULL.
pub(super) fn zeroed<T: SizeTagged>() -> T {
    // SAFETY: any bits are a value of such a struct.
    unsafe { MaybeUninit::zeroed().assume_init() }
}

/// The one value that the reserved field of an input may have.
pub(super) fn check_reserved(field: &str, value: u32) -> Result<(), Failure> {
    if value == 0 {
        return Ok(());
    }
    Err(Failure::argument(field, value, "be 0: it is reserved"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A struct as a newer program might have it: options and 8 more bytes.
    #[repr(C)]
    #[derive(Clone, Copy)]
    struct Newer {
        options: cylfuse_options,
        added: u64,
    }

    fn newer() -> Newer {
        let options = cylfuse_options { struct_size: size_of::<Newer>() as u32, seed: 7, ..zeroed() };
        Newer { options, added: 0 }
    }

    #[test]
    fn larger_inputs_pass_while_the_rest_is_zero() {
        let mut newer = newer();
        let read_it = |newer: &Newer| {
            // SAFETY: the size is that of the whole struct.
            unsafe { read(std::ptr::from_ref(newer).cast::<cylfuse_options>(), "options") }
        };
        assert_eq!(read_it(&newer).unwrap().seed, 7);
        newer.added = 1 << 40;
        let text = read_it(&newer).unwrap_err().to_string();
        let size = size_of::<cylfuse_options>();
        let (whole, byte) = (format!("options.struct_size is {}", size + 8), format!("byte {}", size + 5));
        assert!(text.contains(&whole) && text.contains(&byte), "{text}");
    }

    #[test]
    fn sizes_that_cannot_be_are_refused() {
        let mut options = newer().options;
        for size in [0, 4, cylfuse_options::FIRST_SIZE as u32 - 1, 4097, u32::MAX] {
            options.struct_size = size;
            // SAFETY: the size is refused before anything else is read.
            let failure = unsafe { read(&raw const options, "options") }.unwrap_err();
            assert!(matches!(failure, Failure::StructSize { .. }), "{size}");
        }
        // SAFETY: NULL is allowed.
        let failure = unsafe { read(std::ptr::null::<cylfuse_options>(), "options") }.unwrap_err();
        assert_eq!(failure.to_string(), "options is NULL; give a pointer");
    }

    #[test]
    fn fields_that_an_older_program_does_not_have_are_zero() {
        let mut older = newer().options;
        older.struct_size = cylfuse_options::FIRST_SIZE as u32;
        older.extent_rule.0 = 77;
        // SAFETY: the size is less than that of the struct.
        let read = unsafe { read(&raw const older, "options") }.unwrap();
        assert_eq!((read.seed, read.extent_rule.0), (7, 0));
    }

    #[test]
    fn outputs_leave_what_they_do_not_know() {
        let mut newer = newer();
        newer.added = 5;
        let pointer = (&raw mut newer).cast::<cylfuse_options>();
        let value = cylfuse_options { seed: 9, ..newer.options };
        // SAFETY: the size is that of the whole struct.
        unsafe { Output::new(pointer, "options") }.unwrap().write(&value);
        assert_eq!((newer.options.seed, newer.added), (9, 5));
        assert_eq!(newer.options.struct_size as usize, size_of::<Newer>());
        // SAFETY: as above.
        unsafe { init(pointer, "options", size_of::<Newer>(), &value) }.unwrap();
        assert_eq!((newer.options.seed, newer.added), (9, 0));
        assert_eq!(newer.options.struct_size as usize, size_of::<Newer>());
    }
}
