//! Checked views of the caller's memory.

use super::strided::{PlainNumber, Scalar, Strided, bytes_of};
use crate::error::{Error, Result, positive};
use nalgebra::Vector3;

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
        Self { elements: Strided::packed(slice), scalar }
    }

    /// One vector, widened to f64.
    #[inline]
    #[must_use]
    pub fn at(&self, column: usize, row: usize) -> Vector3<f64> {
        self.elements.vector(self.scalar, column, row).into()
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

    /// These points as an organised cloud of `width` columns, row by row.
    ///
    /// # Errors
    /// `InvalidArgument` when the points do not fill such rows.
    pub fn organised(self, width: usize) -> Result<Self> {
        let grid = |strided: Strided<'a>| {
            let requirement = format!("divide the {} points into whole rows", self.width());
            strided.in_rows(width).ok_or_else(|| Error::argument("columns of a cloud", width, requirement))
        };
        let vectors =
            |view: VectorsView<'a>| Ok::<_, Error>(VectorsView { elements: grid(view.elements)?, ..view });
        Ok(Self {
            points: vectors(self.points)?,
            weights: self.weights.map(grid).transpose()?,
            normals: self.normals.map(vectors).transpose()?,
        })
    }

    /// Columns of an organised cloud, or the number of points.
    #[must_use]
    pub fn width(&self) -> usize {
        self.points.elements.width()
    }

    /// Rows of an organised cloud, or 1.
    #[must_use]
    pub fn height(&self) -> usize {
        self.points.elements.height()
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
    /// 16-bit unsigned integer; 0, and 65535, which is too far to tell, = no measurement.
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
        positive("depth scale", scale)?;
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
        self.pixels.width()
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> usize {
        self.pixels.height()
    }

    /// The depth z of a pixel; `None` where nothing was measured.
    #[inline]
    #[must_use]
    pub fn depth(&self, column: usize, row: usize) -> Option<f64> {
        self.value(column, row).map(|value| f64::from(value) * self.scale)
    }

    /// The stored value of a pixel; `None` where nothing was measured.
    #[inline]
    fn value(&self, column: usize, row: usize) -> Option<f32> {
        let value = match self.format {
            Pixels::U16 => of_integer(self.pixels.u16(column, row)),
            Pixels::F32 => f32::from_ne_bytes(self.pixels.read(column, row, 0)),
        };
        is_measured(value).then_some(value)
    }

    /// Appends the stored values of a row, 0 where nothing was measured.
    #[inline(always)]
    pub(super) fn read_row(&self, row: usize, values: &mut Vec<f32>) {
        let packed = match self.format {
            Pixels::U16 => self.pixels.packed_row(row).map(|stored| {
                values.extend(stored.iter().map(|stored| of_integer(u16::from_ne_bytes(*stored))));
            }),
            Pixels::F32 => self.pixels.packed_row(row).map(|stored| {
                let value = |stored: f32| if is_measured(stored) { stored } else { 0.0 };
                values.extend(stored.iter().map(|stored| value(f32::from_ne_bytes(*stored))));
            }),
        };
        if packed.is_none() {
            values.extend((0..self.width()).map(|column| self.value(column, row).unwrap_or(0.0)));
        }
    }
}

/// The largest depth that 16 bits hold: all of them set stand for what is farther.
pub(crate) const LARGEST_STORED_DEPTH: u16 = u16::MAX - 1;

/// A depth that is stored as an integer, 0 where it is more than the largest.
#[inline(always)]
fn of_integer(stored: u16) -> f32 {
    // A comparison would take more instructions.
    f32::from(stored.wrapping_add(1).saturating_sub(1))
}

/// Whether a stored depth is one.
#[inline(always)]
fn is_measured(value: f32) -> bool {
    // One after the other they would branch.
    (value > 0.0) & (value < f32::INFINITY)
}

/// How a pixel of an image is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ImageFormat {
    /// Grey, 8-bit unsigned integer.
    U8,
    /// Grey, 16-bit unsigned integer.
    U16,
    /// Grey, 32-bit float.
    F32,
    /// Red, green, blue, 8-bit unsigned integers.
    Rgb8,
    /// Blue, green, red, 8-bit unsigned integers.
    Bgr8,
    /// Red, green, blue and a byte that does not count, 8-bit unsigned integers.
    Rgba8,
    /// Blue, green, red and a byte that does not count, 8-bit unsigned integers.
    Bgra8,
}

impl ImageFormat {
    /// Bytes of a pixel.
    #[must_use]
    pub const fn pixel_bytes(self) -> usize {
        match self {
            ImageFormat::U8 => 1,
            ImageFormat::U16 => 2,
            ImageFormat::Rgb8 | ImageFormat::Bgr8 => 3,
            ImageFormat::F32 | ImageFormat::Rgba8 | ImageFormat::Bgra8 => 4,
        }
    }

    /// Whether a pixel has several channels.
    #[must_use]
    pub const fn is_color(self) -> bool {
        !matches!(self, ImageFormat::U8 | ImageFormat::U16 | ImageFormat::F32)
    }
}

/// The gammas that an image may have, far beyond those in use (0.45 to 2.8).
const GAMMAS: std::ops::RangeInclusive<f64> = 0.1..=10.0;

/// A grey or colour image in memory.
#[derive(Debug, Clone, Copy)]
pub struct ImageView<'a> {
    pixels: Strided<'a>,
    format: ImageFormat,
    gamma: f64,
}

impl<'a> ImageView<'a> {
    /// An image at the elements of a grid of [`ImageFormat::pixel_bytes`] each, its values linear in light.
    #[must_use]
    pub fn new(pixels: Strided<'a>, format: ImageFormat) -> Self {
        Self { pixels, format, gamma: 1.0 }
    }

    /// This image with values that are coded with a gamma: light is the value to the power of `gamma`, and 0 is
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

    /// Packed pixels of any format as bytes, row by row.
    ///
    /// # Errors
    /// `InvalidArgument` when the slice is too short.
    pub fn from_bytes(bytes: &'a [u8], (width, height): (usize, usize), format: ImageFormat) -> Result<Self> {
        let size = format.pixel_bytes();
        let strides = (size as isize, (width * size) as isize);
        Ok(Self::new(Strided::new(bytes, 0, (width, height), size, strides)?, format))
    }

    /// Columns.
    #[must_use]
    pub fn width(&self) -> usize {
        self.pixels.width()
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> usize {
        self.pixels.height()
    }

    /// How a pixel is stored.
    #[must_use]
    pub fn format(&self) -> ImageFormat {
        self.format
    }

    /// The power that makes light of a value.
    #[must_use]
    pub fn gamma(&self) -> f64 {
        self.gamma
    }

    /// One value of a grey image.
    #[inline]
    fn value(&self, column: usize, row: usize) -> f32 {
        match self.format {
            ImageFormat::U16 => f32::from(self.pixels.u16(column, row)),
            ImageFormat::F32 => f32::from_ne_bytes(self.pixels.read(column, row, 0)),
            _ => f32::from(self.pixels.u8(column, row)),
        }
    }

    /// Appends the values of a row of a grey image.
    pub(super) fn read_row(&self, row: usize, values: &mut Vec<f32>) {
        let bytes = || self.pixels.packed_row::<1>(row);
        let pairs = || self.pixels.packed_row::<2>(row);
        let quadruples = || self.pixels.packed_row::<4>(row);
        let packed = match self.format {
            ImageFormat::U16 => {
                pairs().map(|stored| values.extend(stored.iter().map(|x| f32::from(u16::from_ne_bytes(*x)))))
            }
            ImageFormat::F32 => {
                quadruples().map(|stored| values.extend(stored.iter().map(|x| f32::from_ne_bytes(*x))))
            }
            _ => bytes().map(|stored| values.extend(stored.iter().map(|[x]| f32::from(*x)))),
        };
        if packed.is_none() {
            values.extend((0..self.width()).map(|column| self.value(column, row)));
        }
    }

    /// Red, green and blue of a pixel; three times the byte of an 8-bit grey one.
    #[inline]
    pub(super) fn color(&self, column: usize, row: usize) -> [u8; 3] {
        let channels = || self.pixels.read::<3>(column, row, 0);
        match self.format {
            ImageFormat::Rgb8 | ImageFormat::Rgba8 => channels(),
            ImageFormat::Bgr8 | ImageFormat::Bgra8 => {
                let [blue, green, red] = channels();
                [red, green, blue]
            }
            _ => [self.pixels.u8(column, row); 3],
        }
    }
}

/// A mask in memory: non-zero = cylinder, or one value of an image of labels. It may hold the lateral surface alone, or the
/// whole object with caps, lids and handles: a fit with the robust objective leaves out what the depth image shows to be no
/// part of the lateral surface.
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
        self.pixels.width()
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> usize {
        self.pixels.height()
    }

    /// Whether a pixel belongs to the cylinder.
    #[inline]
    #[must_use]
    pub fn contains(&self, column: usize, row: usize) -> bool {
        let value = self.pixels.u8(column, row);
        self.label.map_or(value != 0, |label| value == label)
    }

    /// Appends to `pixels` whether those of a row belong to the cylinder.
    #[inline(always)]
    pub(super) fn read_row(&self, row: usize, pixels: &mut Vec<bool>) {
        match (self.pixels.packed_row::<1>(row), self.label) {
            (Some(values), None) => pixels.extend(values.iter().map(|[value]| *value != 0)),
            (Some(values), Some(label)) => pixels.extend(values.iter().map(|[value]| *value == label)),
            (None, _) => pixels.extend((0..self.width()).map(|column| self.contains(column, row))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depth_without_a_measurement_is_none() {
        let image = [0.0_f32, -1.0, f32::NAN, f32::INFINITY, 2.0];
        let view = DepthView::from_f32(&image, (5, 1), 0.5).unwrap();
        let depths: Vec<_> = (0..5).map(|column| view.depth(column, 0)).collect();
        assert_eq!(depths, [None, None, None, None, Some(1.0)]);
        assert!(DepthView::from_f32(&image, (5, 1), 0.0).is_err());
        assert!(DepthView::from_f32(&image, (5, 1), f64::NAN).is_err());
    }

    #[test]
    fn the_least_and_the_largest_integer_are_no_depth() {
        let image = [0_u16, 1, 65534, 65535];
        let measured = [None, Some(0.5), Some(32767.0), None];
        let view = DepthView::from_u16(&image, (4, 1), 0.5).unwrap();
        let backwards = Strided::new(bytes_of(&image), 6, (4, 1), 2, (-2, 8)).unwrap();
        for (view, order) in
            [(view, [0, 1, 2, 3]), (DepthView::new(backwards, Pixels::U16, 0.5).unwrap(), [3, 2, 1, 0])]
        {
            assert_eq!(order.map(|column| view.depth(column, 0)), measured);
            let mut row = Vec::new();
            view.read_row(0, &mut row);
            assert_eq!(order.map(|column| row[column]), [0.0, 1.0, 65534.0, 0.0]);
        }
    }
}
