//! An image on a coarser grid, for what its blur leaves nothing to see on the finer one.

use super::image::GreyImage;
use crate::memory::List;
use std::ops::Range;

/// A grey image in boxes of some columns and rows each, whose mean is a pixel. Boxes that the border cuts are left out.
/// Nothing is copied.
#[derive(Debug, Clone, Copy)]
pub struct ReducedImage<'a> {
    image: &'a GreyImage,
    factor: usize,
}

/// Squares of 2 × 2 pixels.
#[derive(Default)]
pub(crate) struct Squares {
    /// The values of the pixels in their upper row and in their lower one.
    pub above: List<[f32; 2]>,
    pub below: List<[f32; 2]>,
    /// Whether the light of any of their pixels may be any from its value on.
    pub saturated: List<bool>,
}

impl Squares {
    /// Makes them so many.
    pub(super) fn resize(&mut self, count: usize) {
        self.above.resize(count, [0.0; 2]);
        self.below.resize(count, [0.0; 2]);
        self.saturated.resize(count, false);
    }
}

impl<'a> ReducedImage<'a> {
    /// In boxes of `factor` columns and rows; 1 and 0 leave the image as it is.
    #[must_use]
    pub fn new(image: &'a GreyImage, factor: usize) -> Self {
        Self { image, factor: factor.max(1) }
    }

    /// Columns and rows of a box.
    #[must_use]
    pub fn factor(&self) -> usize {
        self.factor
    }

    /// Columns.
    #[must_use]
    pub fn width(&self) -> usize {
        self.image.width() / self.factor
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> usize {
        self.image.height() / self.factor
    }

    /// The value of a pixel.
    ///
    /// # Panics
    /// When the pixel lies outside the image.
    #[inline]
    #[must_use]
    pub fn value(&self, column: usize, row: usize) -> f32 {
        if self.factor == 1 {
            return self.image.value(column, row);
        }
        self.values(column, row).sum::<f32>() / (self.factor * self.factor) as f32
    }

    /// Whether the light of a pixel may be any from its value on.
    ///
    /// # Panics
    /// When the pixel lies outside the image.
    #[inline]
    #[must_use]
    pub fn is_saturated(&self, column: usize, row: usize) -> bool {
        if self.factor == 1 {
            return self.image.is_saturated(column, row);
        }
        self.pixels(column, row).any(|(column, row)| self.image.is_saturated(column, row))
    }

    /// The value of a pixel, and whether its light may be any from there on.
    #[inline]
    pub(crate) fn pixel(&self, column: usize, row: usize) -> (f32, bool) {
        if self.factor == 1 {
            return self.image.pixel(column, row);
        }
        (self.value(column, row), self.is_saturated(column, row))
    }

    /// Appends the values of some pixels of a row, or else of a column, and whether the light of each may be any from there on.
    #[inline(always)]
    pub(crate) fn read_line(
        &self,
        is_row: bool,
        line: usize,
        pixels: Range<usize>,
        values: &mut Vec<f64>,
        saturated: &mut Vec<bool>,
    ) {
        if self.factor == 1 {
            self.image.read_line(is_row, line, pixels, values, saturated);
            return;
        }
        for cross in pixels {
            let (column, row) = if is_row { (cross, line) } else { (line, cross) };
            values.push(f64::from(self.value(column, row)));
            saturated.push(self.is_saturated(column, row));
        }
    }

    /// The squares of pixels that some positions x, y are in. All of them must be inside the image.
    #[inline(always)]
    pub(crate) fn read_squares(&self, x: &[f64], y: &[f64], squares: &mut Squares) {
        if self.factor == 1 {
            self.image.read_squares(x, y, squares);
            return;
        }
        squares.resize(x.len());
        let Squares { above, below, saturated } = squares;
        for (k, (x, y)) in x.iter().zip(y).enumerate() {
            let (column, row) = (*x as usize, *y as usize);
            let line = |row: usize| [column, column + 1].map(|column| self.pixel(column, row));
            let pixels = [line(row), line(row + 1)];
            [above[k], below[k]] = pixels.map(|line| line.map(|pixel| pixel.0));
            saturated[k] = pixels.as_flattened().iter().any(|pixel| pixel.1);
        }
    }

    /// The values of a box.
    #[inline]
    fn values(&self, column: usize, row: usize) -> impl Iterator<Item = f32> {
        let Self { image, factor } = *self;
        let columns = column * factor..(column + 1) * factor;
        (row * factor..(row + 1) * factor)
            .flat_map(move |row| image.row(row)[columns.clone()].iter().copied())
    }

    /// The pixels of a box.
    fn pixels(&self, column: usize, row: usize) -> impl Iterator<Item = (usize, usize)> {
        let factor = self.factor;
        let columns = column * factor..(column + 1) * factor;
        let rows = row * factor..(row + 1) * factor;
        rows.flat_map(move |row| columns.clone().map(move |column| (column, row)))
    }
}

/// The position on the grid of an image of a position on that of boxes of `factor` pixels each.
#[must_use]
pub fn from_reduced(position: f64, factor: usize) -> f64 {
    factor as f64 * (position + 0.5) - 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observations::ImageView;

    #[test]
    fn a_pixel_is_the_mean_of_its_box() {
        let values: Vec<u8> = vec![1, 2, 3, 4, 9, 5, 6, 7, 8, 9, 9, 9, 9, 255, 9];
        let image = GreyImage::copy(&ImageView::from_u8(&values, (5, 3)).unwrap()).unwrap();
        let half = ReducedImage::new(&image, 2);
        assert_eq!((half.width(), half.height(), half.factor()), (2, 1, 2));
        assert_eq!((half.value(0, 0), half.value(1, 0)), (3.5, 5.5));
        assert!(!half.is_saturated(0, 0));
        let same = ReducedImage::new(&image, 0);
        assert_eq!((same.width(), same.height(), same.value(3, 2)), (5, 3, 255.0));
        assert!(same.is_saturated(3, 2) && !same.is_saturated(0, 0));
    }

    #[test]
    fn positions_are_those_of_pixel_centres() {
        assert_eq!(from_reduced(0.0, 2), 0.5);
        assert_eq!(from_reduced(-0.5, 4), -0.5);
        assert_eq!(from_reduced(3.25, 1), 3.25);
    }
}
