//! The grey image that limbs and ends are located in, owned.

use super::views::{ImageFormat, ImageView};
use crate::error::{Error, Result};

/// A grey image. Values are linear in the stored ones; their unit has no meaning.
#[derive(Debug, Clone)]
pub struct GreyImage {
    width: usize,
    height: usize,
    values: Vec<f32>,
}

impl GreyImage {
    /// Copies an image.
    ///
    /// # Errors
    /// `OutOfMemory`; `InvalidArgument` when a value is not finite, naming the pixel.
    pub fn copy(view: &ImageView<'_>) -> Result<Self> {
        let (width, height) = (view.width(), view.height());
        let mut values = Vec::new();
        let bytes = width * height * 4;
        let out_of_memory = |_| Error::OutOfMemory { what: "the image", bytes };
        values.try_reserve_exact(width * height).map_err(out_of_memory)?;
        for row in 0..height {
            values.extend((0..width).map(|column| view.value(column, row)));
        }
        if let (ImageFormat::F32, Some(index)) = (view.format(), values.iter().position(|v| !v.is_finite())) {
            let name = format!("image value at column {}, row {}", index % width, index / width);
            return Err(Error::argument(name, values[index], "be finite"));
        }
        Ok(Self { width, height, values })
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

    /// The value of a pixel.
    ///
    /// # Panics
    /// When the pixel lies outside the image.
    #[inline]
    #[must_use]
    pub fn value(&self, column: usize, row: usize) -> f32 {
        assert!(column < self.width, "column {column} of {}", self.width);
        self.values[row * self.width + column]
    }

    /// One row.
    #[must_use]
    pub fn row(&self, row: usize) -> &[f32] {
        &self.values[row * self.width..(row + 1) * self.width]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_copied_and_bad_ones_named() {
        let image = GreyImage::copy(&ImageView::from_u8(&[1, 2, 3, 4, 5, 6], (3, 2)).unwrap()).unwrap();
        assert_eq!((image.width(), image.height(), image.value(2, 1)), (3, 2, 6.0));
        assert_eq!(image.row(1), [4.0, 5.0, 6.0]);
        let view = ImageView::from_f32(&[0.0, 1.0, f32::NAN, 2.0], (2, 2)).unwrap();
        let error = GreyImage::copy(&view).unwrap_err();
        assert_eq!(error.to_string(), "image value at column 0, row 1 is NaN; it must be finite");
    }
}
