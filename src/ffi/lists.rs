//! Plain numbers of the caller, one after the other and of any alignment.

use super::status::Failure;
use super::views::Slot;

/// Reads `N` numbers.
///
/// # Safety
/// `first` is NULL or points to `N` numbers that can be read.
pub(super) unsafe fn numbers<const N: usize>(
    first: *const f64,
    name: &'static str,
) -> Result<[f64; N], Failure> {
    if first.is_null() {
        return Err(Failure::NullPointer { name });
    }
    // SAFETY: not NULL, so it points to `N` numbers; no alignment is assumed.
    Ok(unsafe { first.cast::<[f64; N]>().read_unaligned() })
}

/// The values of a list, each read when the iterator comes to it.
///
/// # Safety
/// `first` is NULL or points to `count` values, which can be read as long as the iterator lives.
pub(super) unsafe fn list<T: Copy>(
    first: *const T,
    count: usize,
    name: &'static str,
) -> Result<impl Iterator<Item = T>, Failure> {
    if count > 0 && first.is_null() {
        return Err(Failure::NullPointer { name });
    }
    // SAFETY: not NULL where there is an index, which is below the count; no alignment is assumed.
    Ok((0..count).map(move |index| unsafe { first.add(index).read_unaligned() }))
}

/// Room for values, checked before the work is done.
pub(super) struct Room<T> {
    first: *mut T,
    count: usize,
}

impl<T: Copy> Room<T> {
    /// Room for `count` values; refuses a `capacity` that is less.
    ///
    /// # Safety
    /// `first` is NULL or writable for `capacity` values, as long as this value lives.
    pub unsafe fn new(
        first: *mut T,
        count: usize,
        capacity: usize,
        name: &'static str,
    ) -> Result<Self, Failure> {
        if count > capacity {
            return Err(Failure::BufferTooSmall { name, capacity, needed: count });
        }
        if count > 0 && first.is_null() {
            return Err(Failure::NullPointer { name });
        }
        Ok(Self { first, count })
    }

    /// Writes the values from the first place on, at most as many as there is room for.
    pub fn fill(&self, values: impl Iterator<Item = T>) {
        for (index, value) in values.enumerate().take(self.count) {
            // SAFETY: the index is below the count, for which `new` has found room; no alignment is assumed.
            unsafe { self.first.add(index).write_unaligned(value) };
        }
    }

    /// Writes one value.
    pub fn set(&self, index: usize, value: T) {
        assert!(index < self.count, "there is a place for every value");
        // SAFETY: as in `fill`.
        unsafe { self.first.add(index).write_unaligned(value) };
    }
}

/// Writes all values and their number, or when they are too many their number only.
///
/// # Safety
/// `out` is NULL or writable for `capacity` values.
pub(super) unsafe fn write_numbers<T: Copy>(
    values: impl Iterator<Item = T> + Clone,
    out: *mut T,
    capacity: usize,
    count: &Slot<usize>,
) -> Result<(), Failure> {
    let needed = values.clone().count();
    if needed > 0 && needed <= capacity && out.is_null() {
        return Err(Failure::NullPointer { name: "out" });
    }
    count.write(needed);
    // SAFETY: the caller promises NULL or room for `capacity` values.
    unsafe { Room::new(out, needed, capacity, "out") }?.fill(values);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_and_rooms_need_no_alignment_and_none_for_nothing() {
        let mut bytes = [0_u8; 17];
        let first = bytes[1..].as_mut_ptr().cast::<f64>();
        // SAFETY: two numbers lie behind the first byte.
        let room = unsafe { Room::new(first, 2, 2, "out") }.unwrap();
        room.fill([1.0, 2.0, 3.0].into_iter());
        room.set(0, 4.0);
        // SAFETY: as above.
        assert_eq!(unsafe { numbers(first, "in") }.unwrap(), [4.0, 2.0]);
        // SAFETY: as above.
        assert!(unsafe { list(first, 2, "in") }.unwrap().eq([4.0, 2.0]));
        // SAFETY: NULL is allowed.
        let (none, nowhere) = unsafe {
            (list(std::ptr::null::<f64>(), 0, "in"), Room::<u8>::new(std::ptr::null_mut(), 0, 0, "out"))
        };
        assert_eq!(none.unwrap().count(), 0);
        nowhere.unwrap().fill(std::iter::repeat(1));
    }

    #[test]
    fn missing_pointers_and_room_are_told_by_name() {
        // SAFETY: NULL is allowed.
        let (numbers, list) =
            unsafe { (numbers::<3>(std::ptr::null(), "a"), list(std::ptr::null::<u8>(), 1, "b").err()) };
        assert_eq!(numbers.unwrap_err().to_string(), "a is NULL; give a pointer");
        assert_eq!(list.unwrap().to_string(), "b is NULL; give a pointer");
        let room = |count, capacity| {
            // SAFETY: NULL is allowed.
            unsafe { Room::<u8>::new(std::ptr::null_mut(), count, capacity, "c") }.err().unwrap().to_string()
        };
        assert_eq!(room(2, 1), "c holds 1 but 2 are needed; give a larger buffer");
        assert_eq!(room(1, 1), "c is NULL; give a pointer");
    }
}
