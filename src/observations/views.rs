//! Checked views of the caller's memory.

use crate::error::{Error, Result};
use nalgebra::Vector3;

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
    fn read<const N: usize>(&self, column: usize, row: usize, offset: usize) -> [u8; N] {
        let start = self.first as isize
            + column as isize * self.element_stride
            + row as isize * self.row_stride
            + offset as isize;
        let start = start as usize;
        let mut value = [0; N];
        value.copy_from_slice(&self.bytes[start..start + N]);
        value
    }

    /// A coordinate, widened to f64.
    #[inline]
    pub(crate) fn scalar(&self, scalar: Scalar, column: usize, row: usize, component: usize) -> f64 {
        match scalar {
            Scalar::F32 => f64::from(f32::from_ne_bytes(self.read(column, row, component * 4))),
            Scalar::F64 => f64::from_ne_bytes(self.read(column, row, component * 8)),
        }
    }

    #[inline]
    fn u16(&self, column: usize, row: usize) -> u16 {
        u16::from_ne_bytes(self.read(column, row, 0))
    }

    #[inline]
    fn u8(&self, column: usize, row: usize) -> u8 {
        self.read::<1>(column, row, 0)[0]
    }
}

/// The memory of a slice of plain numbers.
///
/// Only used with the number types below, which have no padding and no invalid bytes to expose.
#[allow(unsafe_code)]
fn bytes_of<T: PlainNumber>(slice: &[T]) -> &[u8] {
    // SAFETY: T is one of the primitive number types or an array of them (sealed trait), so all
    // size_of_val(slice) bytes are initialised; u8 has no alignment; the lifetime is that of the slice.
    unsafe { std::slice::from_raw_parts(slice.as_ptr().cast::<u8>(), std::mem::size_of_val(slice)) }
}

trait PlainNumber: Copy {}
impl PlainNumber for u8 {}
impl PlainNumber for u16 {}
impl PlainNumber for f32 {}
impl PlainNumber for f64 {}
impl<T: PlainNumber, const N: usize> PlainNumber for [T; N] {}

/// Vectors of three coordinates in memory: x, y, z follow each other at the start of each element.
#[derive(Debug, Clone, Copy)]
pub struct VectorsView<'a> {
    elements: Strided<'a>,
    scalar: Scalar,
}

impl<'a> VectorsView<'a> {
    /// Vectors at the elements of a grid whose element size is three scalars.
    #[must_use]
    pub fn new(elements: Strided<'a>, scalar: Scalar) -> Self {
        Self { elements, scalar }
    }

    fn packed<T: PlainNumber>(slice: &'a [[T; 3]], scalar: Scalar) -> Self {
        let stride = 3 * scalar.size() as isize;
        let elements = Strided {
            bytes: bytes_of(slice),
            first: 0,
            width: slice.len(),
            height: 1,
            element_stride: stride,
            row_stride: 0,
        };
        Self { elements, scalar }
    }

    /// One vector, widened to f64.
    #[inline]
    #[must_use]
    pub fn at(&self, column: usize, row: usize) -> Vector3<f64> {
        let component = |k| self.elements.scalar(self.scalar, column, row, k);
        Vector3::new(component(0), component(1), component(2))
    }
}

/// A cloud in memory, organised (`height` > 1) or not.
#[derive(Debug, Clone, Copy)]
pub struct PointsView<'a> {
    /// The coordinates, in the camera frame or any other one.
    pub points: VectorsView<'a>,
    /// One weight a point, in the scalar type of the points; `None` = 1 each. A point of weight 0 is dropped.
    pub weights: Option<Strided<'a>>,
    /// Directions across the surface at the points, of any length and sign; `None` when unknown. Only random
    /// sampling uses them. A normal of zero length or with a component that is not finite counts as unknown.
    pub normals: Option<VectorsView<'a>>,
}

impl<'a> PointsView<'a> {
    /// An unorganised cloud of packed f64 coordinates.
    #[must_use]
    pub fn from_f64(points: &'a [[f64; 3]]) -> Self {
        Self { points: VectorsView::packed(points, Scalar::F64), weights: None, normals: None }
    }

    /// An unorganised cloud of packed f32 coordinates.
    #[must_use]
    pub fn from_f32(points: &'a [[f32; 3]]) -> Self {
        Self { points: VectorsView::packed(points, Scalar::F32), weights: None, normals: None }
    }

    /// Columns of an organised cloud, or the number of points.
    #[must_use]
    pub fn width(&self) -> usize {
        self.points.elements.width
    }

    /// Rows of an organised cloud, or 1.
    #[must_use]
    pub fn height(&self) -> usize {
        self.points.elements.height
    }

    /// The type of the coordinates.
    #[must_use]
    pub fn scalar(&self) -> Scalar {
        self.points.scalar
    }

    /// The weight of one point.
    #[inline]
    #[must_use]
    pub fn weight(&self, column: usize, row: usize) -> f64 {
        self.weights.map_or(1.0, |weights| weights.scalar(self.points.scalar, column, row, 0))
    }
}

/// How a pixel of a depth image is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pixels {
    /// 16-bit unsigned integer, 0 = no measurement.
    U16,
    /// 32-bit float; 0, negative or not finite = no measurement.
    F32,
}

/// A depth image in memory. The value is z, not the distance along the ray.
#[derive(Debug, Clone, Copy)]
pub struct DepthView<'a> {
    pixels: Strided<'a>,
    format: Pixels,
    /// Length of one unit of the stored value.
    pub scale: f64,
}

impl<'a> DepthView<'a> {
    /// A depth image at the elements of a grid.
    ///
    /// # Errors
    /// `InvalidArgument` when the scale is not positive and finite.
    pub fn new(pixels: Strided<'a>, format: Pixels, scale: f64) -> Result<Self> {
        if !(scale > 0.0 && scale.is_finite()) {
            return Err(Error::argument("depth scale", scale, "be finite and greater than 0"));
        }
        Ok(Self { pixels, format, scale })
    }

    /// A packed 16-bit depth image, row by row.
    ///
    /// # Errors
    /// `InvalidArgument` when the slice is too short or the scale is not positive.
    pub fn from_u16(pixels: &'a [u16], (width, height): (usize, usize), scale: f64) -> Result<Self> {
        let rows = Strided::new(bytes_of(pixels), 0, (width, height), 2, (2, 2 * width as isize))?;
        Self::new(rows, Pixels::U16, scale)
    }

    /// A packed f32 depth image, row by row.
    ///
    /// # Errors
    /// `InvalidArgument` when the slice is too short or the scale is not positive.
    pub fn from_f32(pixels: &'a [f32], (width, height): (usize, usize), scale: f64) -> Result<Self> {
        let rows = Strided::new(bytes_of(pixels), 0, (width, height), 4, (4, 4 * width as isize))?;
        Self::new(rows, Pixels::F32, scale)
    }

    /// Columns.
    #[must_use]
    pub fn width(&self) -> usize {
        self.pixels.width
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> usize {
        self.pixels.height
    }

    /// The depth z of a pixel; `None` where nothing was measured.
    #[inline]
    #[must_use]
    pub fn depth(&self, column: usize, row: usize) -> Option<f64> {
        let raw = match self.format {
            Pixels::U16 => f64::from(self.pixels.u16(column, row)),
            Pixels::F32 => self.pixels.scalar(Scalar::F32, column, row, 0),
        };
        (raw > 0.0 && raw.is_finite()).then_some(raw * self.scale)
    }
}

/// How a value of a grey image is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ImageFormat {
    /// 8-bit unsigned integer.
    U8,
    /// 16-bit unsigned integer.
    U16,
    /// 32-bit float.
    F32,
}

/// The gammas that an image may have, far beyond those in use (0.45 to 2.8).
const GAMMAS: std::ops::RangeInclusive<f64> = 0.1..=10.0;

/// A grey image in memory.
#[derive(Debug, Clone, Copy)]
pub struct ImageView<'a> {
    pixels: Strided<'a>,
    format: ImageFormat,
    gamma: f64,
}

impl<'a> ImageView<'a> {
    /// A grey image at the elements of a grid, its values linear in light.
    #[must_use]
    pub fn new(pixels: Strided<'a>, format: ImageFormat) -> Self {
        Self { pixels, format, gamma: 1.0 }
    }

    /// The same image with values that are coded with a gamma: light is the value to the power of `gamma`, and 0 is
    /// black. 1 stands for values linear in light; 2.2 for sRGB, in which cameras and image files usually come.
    ///
    /// # Errors
    /// `InvalidArgument` for a gamma outside 0.1 to 10.
    pub fn with_gamma(self, gamma: f64) -> Result<Self> {
        if !GAMMAS.contains(&gamma) {
            let requirement = "lie in [0.1, 10]; 1 = linear in light, 2.2 = sRGB";
            return Err(Error::argument("gamma of the image", gamma, requirement));
        }
        Ok(Self { gamma, ..self })
    }

    /// A packed 8-bit image, row by row.
    ///
    /// # Errors
    /// `InvalidArgument` when the slice is too short.
    pub fn from_u8(pixels: &'a [u8], (width, height): (usize, usize)) -> Result<Self> {
        Ok(Self::new(Strided::new(pixels, 0, (width, height), 1, (1, width as isize))?, ImageFormat::U8))
    }

    /// A packed 16-bit image, row by row.
    ///
    /// # Errors
    /// `InvalidArgument` when the slice is too short.
    pub fn from_u16(pixels: &'a [u16], (width, height): (usize, usize)) -> Result<Self> {
        let rows = Strided::new(bytes_of(pixels), 0, (width, height), 2, (2, 2 * width as isize))?;
        Ok(Self::new(rows, ImageFormat::U16))
    }

    /// A packed f32 image, row by row.
    ///
    /// # Errors
    /// `InvalidArgument` when the slice is too short.
    pub fn from_f32(pixels: &'a [f32], (width, height): (usize, usize)) -> Result<Self> {
        let rows = Strided::new(bytes_of(pixels), 0, (width, height), 4, (4, 4 * width as isize))?;
        Ok(Self::new(rows, ImageFormat::F32))
    }

    /// Columns.
    #[must_use]
    pub fn width(&self) -> usize {
        self.pixels.width
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> usize {
        self.pixels.height
    }

    /// How a value is stored.
    #[must_use]
    pub fn format(&self) -> ImageFormat {
        self.format
    }

    /// The power that makes light of a value.
    #[must_use]
    pub fn gamma(&self) -> f64 {
        self.gamma
    }

    /// One value.
    #[inline]
    #[must_use]
    pub fn value(&self, column: usize, row: usize) -> f32 {
        match self.format {
            ImageFormat::U8 => f32::from(self.pixels.u8(column, row)),
            ImageFormat::U16 => f32::from(self.pixels.u16(column, row)),
            ImageFormat::F32 => self.pixels.scalar(Scalar::F32, column, row, 0) as f32,
        }
    }
}

/// A mask in memory: non-zero = cylinder, or one value of an image of labels.
#[derive(Debug, Clone, Copy)]
pub struct MaskView<'a> {
    pixels: Strided<'a>,
    label: Option<u8>,
}

impl<'a> MaskView<'a> {
    /// A mask at the elements of a grid of bytes.
    #[must_use]
    pub fn new(pixels: Strided<'a>) -> Self {
        Self { pixels, label: None }
    }

    /// The pixels of one value only.
    #[must_use]
    pub fn of_label(self, label: u8) -> Self {
        Self { label: Some(label), ..self }
    }

    /// A packed mask, row by row.
    ///
    /// # Errors
    /// `InvalidArgument` when the slice is too short.
    pub fn from_u8(pixels: &'a [u8], (width, height): (usize, usize)) -> Result<Self> {
        Ok(Self::new(Strided::new(pixels, 0, (width, height), 1, (1, width as isize))?))
    }

    /// Columns.
    #[must_use]
    pub fn width(&self) -> usize {
        self.pixels.width
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> usize {
        self.pixels.height
    }

    /// Whether a pixel belongs to the cylinder.
    #[inline]
    #[must_use]
    pub fn contains(&self, column: usize, row: usize) -> bool {
        let value = self.pixels.u8(column, row);
        self.label.map_or(value != 0, |label| value == label)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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

    #[test]
    fn depth_without_a_measurement_is_none() {
        let image = [0.0_f32, -1.0, f32::NAN, f32::INFINITY, 2.0];
        let view = DepthView::from_f32(&image, (5, 1), 0.5).unwrap();
        let depths: Vec<_> = (0..5).map(|column| view.depth(column, 0)).collect();
        assert_eq!(depths, [None, None, None, None, Some(1.0)]);
        assert!(DepthView::from_f32(&image, (5, 1), 0.0).is_err());
        assert!(DepthView::from_f32(&image, (5, 1), f64::NAN).is_err());
    }
}
