//! The grey image that limbs and ends are located in, owned.

use super::views::{ImageFormat, ImageView};
use crate::error::{Error, Result};

/// A grey image. Values are linear in light; their unit has no meaning.
#[derive(Debug, Clone)]
pub struct GreyImage {
    width: usize,
    height: usize,
    values: Vec<f32>,
    /// The value at which the sensor or the file cut brighter light off; infinity where nothing says so.
    white: f32,
}

impl GreyImage {
    /// Copies an image, and takes its gamma away.
    ///
    /// # Errors
    /// `OutOfMemory`; `InvalidArgument` when a value is not finite, or negative though coded with a gamma, naming the
    /// pixel.
    pub fn copy(view: &ImageView<'_>) -> Result<Self> {
        let (width, height) = (view.width(), view.height());
        let mut values = Vec::new();
        let bytes = width * height * 4;
        let out_of_memory = |_| Error::OutOfMemory { what: "the image", bytes };
        values.try_reserve_exact(width * height).map_err(out_of_memory)?;
        for row in 0..height {
            values.extend((0..width).map(|column| view.value(column, row)));
        }
        let coded = view.gamma() != 1.0;
        let bad = |value: &f32| !value.is_finite() || coded && *value < 0.0;
        if let (ImageFormat::F32, Some(index)) = (view.format(), values.iter().position(bad)) {
            let name = format!("image value at column {}, row {}", index % width, index / width);
            let requirement = if coded { "be finite, and not negative with a gamma" } else { "be finite" };
            return Err(Error::argument(name, values[index], requirement));
        }
        // A flat background may well be the largest value of a floating-point image.
        let cut = view.format() != ImageFormat::F32 && ends_numbers(largest(&values));
        if coded {
            decode(&mut values, view);
        }
        let white = if cut { largest(&values) } else { f32::INFINITY };
        Ok(Self { width, height, values, white })
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

    /// Whether a value of the image stands for any light from there on: it is the largest that some number of bits, 8
    /// or more, can hold. No value of a floating-point image is.
    #[inline]
    #[must_use]
    pub fn is_saturated(&self, value: f32) -> bool {
        value >= self.white
    }

    /// One row.
    #[must_use]
    pub fn row(&self, row: usize) -> &[f32] {
        &self.values[row * self.width..(row + 1) * self.width]
    }
}

/// The largest value, at least 0.
fn largest(values: &[f32]) -> f32 {
    values.iter().copied().fold(0.0, f32::max)
}

/// Whether an integer is one at which numbers of 8 bits or more end: sensors of 10 or 12 bits come as 16.
fn ends_numbers(value: f32) -> bool {
    value >= 255.0 && (value as u32 + 1).is_power_of_two()
}

/// Makes light of coded values; the largest that the format can hold stays what it is.
fn decode(values: &mut [f32], view: &ImageView<'_>) {
    let end = match view.format() {
        ImageFormat::U8 => f32::from(u8::MAX),
        ImageFormat::U16 => f32::from(u16::MAX),
        ImageFormat::F32 => largest(values).max(f32::MIN_POSITIVE),
    };
    let light = |value: f32| end * f64::from(value / end).powf(view.gamma()) as f32;
    match view.format() {
        ImageFormat::F32 => values.iter_mut().for_each(|value| *value = light(*value)),
        // A power takes far longer than a look into a table.
        ImageFormat::U8 | ImageFormat::U16 => {
            let table: Vec<f32> = (0..=end as u32).map(|value| light(value as f32)).collect();
            values.iter_mut().for_each(|value| *value = table[*value as usize]);
        }
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

    #[test]
    fn a_gamma_is_taken_away_in_every_format() {
        let light = |view: Result<ImageView<'_>>| {
            let image = GreyImage::copy(&view.unwrap().with_gamma(2.0).unwrap()).unwrap();
            [0, 1, 2].map(|column| image.value(column, 0))
        };
        let near = |light: [f32; 3], white: f32| {
            let expected = [0.0, 0.04, 1.0].map(|part| part * white);
            for (value, expected) in light.into_iter().zip(expected) {
                assert!((value - expected).abs() <= 1e-5 * white, "{light:?}");
            }
        };
        near(light(ImageView::from_u8(&[0, 51, 255], (3, 1))), 255.0);
        near(light(ImageView::from_u16(&[0, 13107, 65535], (3, 1))), 65535.0);
        near(light(ImageView::from_f32(&[0.0, 0.6, 3.0], (3, 1))), 3.0);
        let black = ImageView::from_f32(&[0.0; 3], (3, 1));
        near(light(black), 0.0);
    }

    #[test]
    fn what_is_as_bright_as_the_bits_allow_is_saturated() {
        let saturated = |view: Result<ImageView<'_>>, gamma: f64| {
            let image = GreyImage::copy(&view.unwrap().with_gamma(gamma).unwrap()).unwrap();
            [0, 1].map(|column| image.is_saturated(image.value(column, 0)))
        };
        for gamma in [1.0, 2.2] {
            assert_eq!(saturated(ImageView::from_u8(&[254, 255], (2, 1)), gamma), [false, true]);
            assert_eq!(saturated(ImageView::from_u8(&[127, 254], (2, 1)), gamma), [false; 2]);
            assert_eq!(saturated(ImageView::from_u16(&[255, 4095], (2, 1)), gamma), [false, true]);
            assert_eq!(saturated(ImageView::from_u16(&[4095, 4096], (2, 1)), gamma), [false; 2]);
            assert_eq!(saturated(ImageView::from_u16(&[65535, 65534], (2, 1)), gamma), [true, false]);
            assert_eq!(saturated(ImageView::from_f32(&[1.0, 255.0], (2, 1)), gamma), [false; 2]);
        }
    }

    #[test]
    fn a_bad_gamma_and_what_it_makes_bad_are_refused() {
        let values = [0.5, -0.25];
        let view = ImageView::from_f32(&values, (2, 1)).unwrap();
        assert!(GreyImage::copy(&view).is_ok());
        let error = GreyImage::copy(&view.with_gamma(2.2).unwrap()).unwrap_err().to_string();
        assert!(
            error.starts_with("image value at column 1, row 0 is -0.25; it must be finite, and not"),
            "{error}"
        );
        for gamma in [0.0, -2.2, 11.0, f64::NAN, f64::INFINITY] {
            let error = view.with_gamma(gamma).unwrap_err().to_string();
            let expected =
                format!("gamma of the image is {gamma}; it must lie in [0.1, 10]; 1 = linear in light");
            assert!(error.starts_with(&expected), "{error}");
        }
    }
}
