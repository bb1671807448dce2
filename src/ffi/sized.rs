//! Structs whose first field is their size: how a program and a library of different versions understand each
//! other.

use super::results::{
    cylfuse_completion, cylfuse_counts, cylfuse_cylinder_diagnosis, cylfuse_cylinder_estimate,
    cylfuse_detection, cylfuse_end_sample, cylfuse_extent, cylfuse_limb, cylfuse_limb_sample, cylfuse_result,
};
use super::status::Failure;
use super::structs::{
    cylfuse_depth_out, cylfuse_depth_view, cylfuse_detector_options, cylfuse_image_view, cylfuse_intrinsics,
    cylfuse_mask_view, cylfuse_options, cylfuse_points_out, cylfuse_points_view, cylfuse_segments_view,
};
use std::mem::{MaybeUninit, offset_of};

/// A size above this is taken for a field that was never set.
const LARGEST: usize = 4096;

/// A struct that only ever grows at its end.
///
/// `unsafe` code in this file relies on it: implementors are `repr(C)` and consist of integers, floats and raw
/// pointers, for which any bits are a value, without padding (the layout test adds the fields up). All
/// implementations are below.
pub(super) trait Growing: Copy {
    /// Size of the first published version: once a field has been appended, that without it.
    const FIRST_SIZE: usize = size_of::<Self>();
}

/// A growing struct whose first field is `struct_size: u32`.
pub(super) trait SizeTagged: Growing {
    /// The function that comes before everything else.
    const INIT: &'static str;
}

macro_rules! size_tagged {
    ($($name:ident),* $(,)?) => {
        $(impl Growing for $name {}
        impl SizeTagged for $name {
            const INIT: &'static str = concat!(stringify!($name), "_init");
        })*
    };
}

size_tagged! {
    cylfuse_intrinsics, cylfuse_points_view, cylfuse_points_out, cylfuse_depth_view, cylfuse_depth_out,
    cylfuse_mask_view, cylfuse_image_view, cylfuse_segments_view, cylfuse_counts, cylfuse_result,
    cylfuse_cylinder_estimate, cylfuse_cylinder_diagnosis, cylfuse_completion, cylfuse_extent,
    cylfuse_detector_options,
}

impl Growing for cylfuse_options {
    const FIRST_SIZE: usize = offset_of!(cylfuse_options, depth_shared);
}
impl SizeTagged for cylfuse_options {
    const INIT: &'static str = "cylfuse_options_init";
}

// Elements of arrays, whose size is an argument of the call.
impl Growing for cylfuse_limb {}
impl Growing for cylfuse_limb_sample {}
impl Growing for cylfuse_end_sample {}
impl Growing for cylfuse_detection {}

fn check_size<T: Growing>(name: &'static str, given: usize, init: Option<&str>) -> Result<(), Failure> {
    if (T::FIRST_SIZE..=LARGEST).contains(&given) {
        return Ok(());
    }
    let remedy = init.map_or_else(String::new, |init| format!(": call {init} before everything else"));
    let requirement = format!("be sizeof of the struct, {} to {LARGEST}{remedy}", T::FIRST_SIZE);
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
    check_size::<T>(name, given, Some(T::INIT)).map(|()| given)
}

/// Reads a struct of any version: fields that an older program does not have are 0, fields of a newer one must
/// be 0.
///
/// # Safety
/// `pointer` is NULL or points to `struct_size` readable bytes.
pub(super) unsafe fn read<T: SizeTagged>(pointer: *const T, name: &'static str) -> Result<T, Failure> {
    // SAFETY: the caller promises NULL or a struct that begins with its size.
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
    // SAFETY: not NULL, so the caller promises a struct of its `struct_size`.
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
        // SAFETY: the caller promises NULL or a struct that begins with its size.
        let given = unsafe { given_size(pointer, name) }?;
        Ok(Self { pointer, given })
    }

    /// The same where NULL means that the output is not wanted.
    ///
    /// # Safety
    /// As [`Output::new`].
    pub unsafe fn optional(pointer: *mut T, name: &'static str) -> Result<Option<Self>, Failure> {
        if pointer.is_null() {
            return Ok(None);
        }
        // SAFETY: not NULL, so the caller promises room for its `struct_size`.
        unsafe { Self::new(pointer, name) }.map(Some)
    }

    /// Writes the fields that both sides know, zeros to what only the caller knows, and to `struct_size` how many
    /// bytes were filled.
    pub fn write(self, value: &T) {
        let filled = self.given.min(size_of::<T>());
        let to = self.pointer.cast::<u8>();
        // SAFETY: both sides hold at least `filled` bytes, and the value has no padding.
        unsafe { std::ptr::copy_nonoverlapping(std::ptr::from_ref(value).cast::<u8>(), to, filled) };
        // SAFETY: the caller's side holds `given` bytes.
        unsafe { to.add(filled).write_bytes(0, self.given - filled) };
        // SAFETY: it holds at least the first size, which is more than a u32; no alignment is assumed.
        unsafe { to.cast::<u32>().write_unaligned(filled as u32) };
    }
}

/// An array of the caller to be written, of elements of any version.
pub(super) struct OutputArray<T> {
    first: *mut T,
    element_size: usize,
    capacity: usize,
    count: *mut usize,
}

impl<T: Growing> OutputArray<T> {
    /// Checks the size of an element and the pointer to the count.
    ///
    /// # Safety
    /// `first` is NULL or points to `capacity` elements of `element_size` writable bytes, and `count` is NULL or
    /// writable, as long as this value lives.
    pub unsafe fn new(
        first: *mut T,
        element_size: usize,
        capacity: usize,
        count: *mut usize,
    ) -> Result<Self, Failure> {
        if count.is_null() {
            return Err(Failure::NullPointer { name: "out_count" });
        }
        if !(T::FIRST_SIZE..=LARGEST).contains(&element_size) {
            let requirement = format!("be sizeof of an element, {} to {LARGEST}", T::FIRST_SIZE);
            return Err(Failure::ElementSize { given: element_size, requirement });
        }
        Ok(Self { first, element_size, capacity, count })
    }

    /// Writes all values and their number, or when they are too many their number only.
    pub fn write(self, values: impl Iterator<Item = T> + Clone) -> Result<(), Failure> {
        let needed = values.clone().count();
        if needed > 0 && needed <= self.capacity && self.first.is_null() {
            return Err(Failure::NullPointer { name: "out" });
        }
        // SAFETY: not NULL, and the obligation of `new`; no alignment is assumed.
        unsafe { self.count.write_unaligned(needed) };
        if needed > self.capacity {
            return Err(Failure::BufferTooSmall { name: "out", capacity: self.capacity, needed });
        }
        let filled = self.element_size.min(size_of::<T>());
        for (index, value) in values.enumerate().take(needed) {
            let from = std::ptr::from_ref(&value).cast::<u8>();
            // SAFETY: the index is below the capacity, so that the element lies in the caller's array.
            let to = unsafe { self.first.cast::<u8>().add(index * self.element_size) };
            // SAFETY: both sides hold `filled` bytes.
            unsafe { std::ptr::copy_nonoverlapping(from, to, filled) };
            // SAFETY: the element of the caller's array holds `element_size` bytes.
            unsafe { to.add(filled).write_bytes(0, self.element_size - filled) };
        }
        Ok(())
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
    check_size::<T>(name, given, None)?;
    let bytes = pointer.cast::<u8>();
    let known = given.min(size_of::<T>());
    // SAFETY: not NULL, so the caller promises room for `given` bytes.
    unsafe { bytes.write_bytes(0, given) };
    // SAFETY: both sides hold `known` bytes, and the defaults have no padding.
    unsafe { std::ptr::copy_nonoverlapping(std::ptr::from_ref(defaults).cast::<u8>(), bytes, known) };
    // SAFETY: `given` is at least the first size and thus more than a u32; no alignment is assumed.
    unsafe { bytes.cast::<u32>().write_unaligned(given as u32) };
    Ok(())
}

/// A struct with every field 0 or NULL.
pub(super) fn zeroed<T: SizeTagged>() -> T {
    // SAFETY: any bits are a value of such a struct.
    unsafe { MaybeUninit::zeroed().assume_init() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A struct in its first version, as an older library or program knows it.
    #[repr(C)]
    #[derive(Debug, Clone, Copy, PartialEq)]
    struct First {
        struct_size: u32,
        number: u32,
        value: f64,
    }

    /// The same after a field was appended.
    #[repr(C)]
    #[derive(Debug, Clone, Copy, PartialEq)]
    struct Second {
        first: First,
        added: u64,
    }

    impl Growing for First {}
    impl SizeTagged for First {
        const INIT: &'static str = "first_init";
    }
    impl Growing for Second {
        const FIRST_SIZE: usize = size_of::<First>();
    }
    impl SizeTagged for Second {
        const INIT: &'static str = "second_init";
    }

    fn second(struct_size: usize) -> Second {
        Second { first: First { struct_size: struct_size as u32, number: 7, value: 0.5 }, added: 0 }
    }

    #[test]
    fn larger_inputs_pass_while_the_rest_is_zero() {
        let mut newer = second(24);
        let read_it = |newer: &Second| {
            // SAFETY: the size is that of the whole struct.
            unsafe { read(std::ptr::from_ref(newer).cast::<First>(), "options") }
        };
        assert_eq!(read_it(&newer).unwrap().number, 7);
        newer.added = 1 << 40;
        let text = read_it(&newer).unwrap_err().to_string();
        assert!(text.contains("options.struct_size is 24") && text.contains("byte 21"), "{text}");
    }

    #[test]
    fn sizes_that_cannot_be_are_refused() {
        for size in [0, 4, 15, 4097, u32::MAX] {
            let given = second(size as usize);
            // SAFETY: the size is refused before anything else is read.
            let failure = unsafe { read(&raw const given, "options") }.unwrap_err();
            assert!(matches!(failure, Failure::StructSize { .. }), "{size}");
            assert!(failure.to_string().ends_with(": call second_init before everything else"), "{failure}");
        }
        // SAFETY: NULL is allowed.
        let failure = unsafe { read(std::ptr::null::<Second>(), "options") }.unwrap_err();
        assert_eq!(failure.to_string(), "options is NULL; give a pointer");
    }

    #[test]
    fn fields_that_an_older_program_does_not_have_are_zero() {
        for size in 16..24 {
            let mut older = second(size);
            older.added = u64::MAX;
            // SAFETY: the size is less than that of the struct.
            let read = unsafe { read(&raw const older, "options") }.unwrap();
            assert_eq!((read.first.number, read.added >> (8 * (size - 16))), (7, 0));
        }
    }

    #[test]
    fn outputs_say_what_was_filled_and_leave_nothing_as_it_was() {
        // A newer program and an older library.
        let mut newer = second(24);
        newer.added = 5;
        let pointer = (&raw mut newer).cast::<First>();
        let value = First { struct_size: 99, number: 8, value: 2.0 };
        // SAFETY: the size is that of the whole struct.
        unsafe { Output::new(pointer, "result") }.unwrap().write(&value);
        assert_eq!(newer, Second { first: First { struct_size: 16, ..value }, added: 0 });
        // An older program and a newer library: what lies behind the older struct is not touched.
        let mut older = second(16);
        older.added = 5;
        let value = Second { first: value, added: 6 };
        // SAFETY: as above.
        unsafe { Output::new(&raw mut older, "result") }.unwrap().write(&value);
        assert_eq!(older, Second { first: First { struct_size: 16, ..value.first }, added: 5 });
    }

    #[test]
    fn defaults_keep_the_size_and_zero_what_is_unknown() {
        let mut newer = second(0);
        newer.added = 5;
        let value = First { struct_size: 99, number: 8, value: 2.0 };
        // SAFETY: the size is that of the whole struct.
        unsafe { init((&raw mut newer).cast::<First>(), "options", 24, &value) }.unwrap();
        assert_eq!(newer, Second { first: First { struct_size: 24, ..value }, added: 0 });
    }

    #[test]
    fn arrays_have_elements_of_any_version() {
        let mut newer = [second(1); 3];
        newer[1].added = 5;
        newer[2].added = 6;
        let mut count = 0;
        let values = [First { struct_size: 1, number: 8, value: 2.0 }; 2];
        let mut write = |element_size, capacity| {
            let first = newer.as_mut_ptr().cast::<First>();
            // SAFETY: three elements of 24 bytes are there.
            let array = unsafe { OutputArray::new(first, element_size, capacity, &raw mut count) };
            array?.write(values.iter().copied())
        };
        assert!(matches!(write(24, 1), Err(Failure::BufferTooSmall { needed: 2, .. })));
        assert!(matches!(write(15, 3), Err(Failure::ElementSize { given: 15, .. })));
        write(24, 3).unwrap();
        assert_eq!((count, newer[1], newer[2].added), (2, Second { first: values[1], added: 0 }, 6));
    }
}
