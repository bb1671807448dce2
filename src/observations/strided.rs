//! Grids of equal elements in the caller's memory.

use crate::error::{Error, Result};

/// The type of a coordinate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scalar {
    /// 32-bit float.
    F32,
    /// 64-bit float.
    F64,
}

impl Scalar {
    /// Size in bytes.
    #[must_use]
    pub const fn size(self) -> usize {
        match self {
            Scalar::F32 => 4,
            Scalar::F64 => 8,
        }
    }
}

/// A grid of equal elements in memory: element (column, row) starts at byte
/// `first + column · element_stride + row · row_stride`. Strides may be negative or overlap; no alignment is
/// needed.
///
/// Invariant: every element lies inside `bytes`.
#[derive(Debug, Clone, Copy)]
pub struct Strided<'a> {
    bytes: &'a [u8],
    first: usize,
    width: usize,
    height: usize,
    element_stride: isize,
    row_stride: isize,
}

impl<'a> Strided<'a> {
    /// Checks that all `width` × `height` elements of `element_size` bytes lie inside `bytes`.
    ///
    /// # Errors
    /// `InvalidArgument` when one lies outside.
    pub fn new(
        bytes: &'a [u8],
        first: usize,
        (width, height): (usize, usize),
        element_size: usize,
        (element_stride, row_stride): (isize, isize),
    ) -> Result<Self> {
        let view = Self { bytes, first, width, height, element_stride, row_stride };
        let Some((lowest, end)) = Self::reach((width, height), element_size, (element_stride, row_stride))
        else {
            return Err(Error::argument(
                "image size",
                format!("{width} x {height} with strides {element_stride} and {row_stride}"),
                "fit into memory",
            ));
        };
        let low = first as i128 + lowest as i128;
        let high = first as i128 + end as i128;
        if width * height > 0 && (low < 0 || high > bytes.len() as i128) {
            return Err(Error::argument(
                "buffer length",
                format!("{} bytes", bytes.len()),
                format!("hold bytes {low} to {high} for {width} x {height} elements with these strides"),
            ));
        }
        Ok(view)
    }

    /// The elements of a slice, one row.
    pub(super) fn packed<T: PlainNumber>(slice: &'a [T]) -> Self {
        let (bytes, element_stride) = (bytes_of(slice), size_of::<T>() as isize);
        Self { bytes, first: 0, width: slice.len(), height: 1, element_stride, row_stride: 0 }
    }

    /// The same elements in rows of so many; `None` when they do not fill them.
    pub(super) fn in_rows(self, width: usize) -> Option<Self> {
        let rows = self.height == 1 && self.width.checked_rem(width) == Some(0);
        let row_stride = isize::try_from(width).ok()?.checked_mul(self.element_stride)?;
        rows.then(|| Self { width, height: self.width / width, row_stride, ..self })
    }

    /// The byte offsets, relative to the first element, of the lowest byte and of the end of the highest one;
    /// `None` when they do not fit an `isize`.
    #[must_use]
    pub fn reach(
        (width, height): (usize, usize),
        element_size: usize,
        (element_stride, row_stride): (isize, isize),
    ) -> Option<(isize, isize)> {
        width.checked_mul(height)?;
        if width == 0 || height == 0 {
            return Some((0, 0));
        }
        let across = isize::try_from(width - 1).ok()?.checked_mul(element_stride)?;
        let down = isize::try_from(height - 1).ok()?.checked_mul(row_stride)?;
        let lowest = across.min(0).checked_add(down.min(0))?;
        let highest = across.max(0).checked_add(down.max(0))?;
        Some((lowest, highest.checked_add(isize::try_from(element_size).ok()?)?))
    }

    /// Columns.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// The N bytes at `offset` bytes after the start of an element.
    #[inline]
    pub(super) fn read<const N: usize>(&self, column: usize, row: usize, offset: usize) -> [u8; N] {
        let start = self.first as isize
            + column as isize * self.element_stride
            + row as isize * self.row_stride
            + offset as isize;
        let start = start as usize;
        let mut value = [0; N];
        value.copy_from_slice(&self.bytes[start..start + N]);
        value
    }

    /// The elements of a row of N bytes each, where one follows the other: so they can be read many at a time.
    pub(super) fn packed_row<const N: usize>(&self, row: usize) -> Option<&'a [[u8; N]]> {
        if self.element_stride != N as isize || self.width == 0 {
            return None;
        }
        let start = (self.first as isize + row as isize * self.row_stride) as usize;
        Some(self.bytes[start..start + self.width * N].as_chunks().0)
    }

    /// A coordinate, widened to f64.
    #[inline]
    pub(crate) fn scalar(&self, scalar: Scalar, column: usize, row: usize, component: usize) -> f64 {
        match scalar {
            Scalar::F32 => f64::from(f32::from_ne_bytes(self.read(column, row, component * 4))),
            Scalar::F64 => f64::from_ne_bytes(self.read(column, row, component * 8)),
        }
    }

    /// Three coordinates, widened to f64.
    #[inline]
    pub(super) fn vector(&self, scalar: Scalar, column: usize, row: usize) -> [f64; 3] {
        match scalar {
            Scalar::F32 => {
                numbers(&self.read::<12>(column, row, 0), |bytes| f32::from_ne_bytes(bytes).into())
            }
            Scalar::F64 => numbers(&self.read::<24>(column, row, 0), f64::from_ne_bytes),
        }
    }

    #[inline]
    pub(super) fn u16(&self, column: usize, row: usize) -> u16 {
        u16::from_ne_bytes(self.read(column, row, 0))
    }

    #[inline]
    pub(super) fn u8(&self, column: usize, row: usize) -> u8 {
        self.read::<1>(column, row, 0)[0]
    }
}

/// Three numbers of N bytes each.
#[inline]
fn numbers<const N: usize>(bytes: &[u8], number: impl Fn([u8; N]) -> f64) -> [f64; 3] {
    let (bytes, _) = bytes.as_chunks::<N>();
    [number(bytes[0]), number(bytes[1]), number(bytes[2])]
}

/// The memory of a slice of plain numbers.
///
/// Only used with the number types below, which have no padding and no invalid bytes to expose.
#[allow(unsafe_code)]
pub(super) fn bytes_of<T: PlainNumber>(slice: &[T]) -> &[u8] {
    // SAFETY: T is one of the primitive number types or an array of them (sealed trait), so all
    // size_of_val(slice) bytes are initialised; u8 has no alignment; the lifetime is that of the slice.
    unsafe { std::slice::from_raw_parts(slice.as_ptr().cast::<u8>(), std::mem::size_of_val(slice)) }
}

pub(super) trait PlainNumber: Copy {}
impl PlainNumber for u8 {}
impl PlainNumber for u16 {}
impl PlainNumber for f32 {}
impl PlainNumber for f64 {}
impl<T: PlainNumber, const N: usize> PlainNumber for [T; N] {}

#[cfg(test)]
mod tests {
    use super::super::views::VectorsView;
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn strides_of_either_sign_reach_the_right_elements() {
        // Points of 5 floats, rows bottom-up.
        let memory: Vec<f32> = (0..30_u8).map(f32::from).collect();
        let bytes = bytes_of(&memory);
        let grid = Strided::new(bytes, 15 * 4, (3, 2), 12, (20, -60)).unwrap();
        let view = VectorsView::new(grid, Scalar::F32);
        assert_eq!(view.at(0, 0), Vector3::new(15.0, 16.0, 17.0));
        assert_eq!(view.at(2, 1), Vector3::new(10.0, 11.0, 12.0));
    }

    #[test]
    fn views_that_leave_their_memory_are_refused() {
        let memory = [0_u8; 100];
        for (first, size, strides) in [
            (0, (10, 11), (1, 10)),
            (1, (10, 10), (1, 10)),
            (0, (10, 2), (-1, 10)),
            (0, (usize::MAX, 2), (1, 1)),
            (0, (2, 2), (isize::MAX, isize::MAX)),
        ] {
            assert!(Strided::new(&memory, first, size, 1, strides).is_err(), "{first} {size:?} {strides:?}");
        }
        assert!(Strided::new(&memory, 99, (10, 10), 1, (-1, -10)).is_ok());
        assert!(Strided::new(&[], 0, (0, 5), 4, (4, 0)).is_ok());
    }
}
