//! The grey image that limbs and ends are located in, owned.

use super::reduced::Squares;
use super::views::{ImageFormat, ImageView};
use crate::error::{Error, Result, with_room};
use std::ops::Range;
use std::sync::OnceLock;

/// A grey image. Values are linear in light; their unit has no meaning.
#[derive(Debug, Clone)]
pub struct GreyImage {
    width: usize,
    height: usize,
    values: Vec<f32>,
    saturation: Saturation,
    /// What was found out about its compression: many fits may share an image.
    compression: OnceLock<f64>,
}

/// Which pixels are as bright as their format allows, and stand for any light from there on.
#[derive(Debug, Clone)]
enum Saturation {
    /// Those from this value on; infinity where nothing says so.
    From(f32),
    /// Those that are marked, whose green is: it is most of the luminance. Red alone, which lamps and bodies of warm colours
    /// cut off far and wide, leaves the luminance nearly right.
    Marked(Vec<bool>),
}

/// What red, green and blue count in the luminance of Recommendation ITU-R BT.709-6 (section 3, E'_Y; the same
/// primaries as those of sRGB, IEC 61966-2-1).
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

impl GreyImage {
    /// Copies an image, and takes its gamma away. Colours become their luminance: the sum of the three channels, each
    /// linear in light, with the weights of Recommendation ITU-R BT.709.
    ///
    /// # Errors
    /// `OutOfMemory`; `InvalidArgument` when a value is not finite, or negative though coded with a gamma, naming the
    /// pixel.
    pub fn copy(view: &ImageView<'_>) -> Result<Self> {
        let (width, height) = (view.width(), view.height());
        let mut values = with_room(width * height, "the image")?;
        // Rows of no pixels are as many as the caller likes.
        let rows = if width == 0 { 0 } else { height };
        if view.format().is_color() {
            let mut marked = with_room(width * height, "the image")?;
            let light: [f32; 256] = std::array::from_fn(|value| light(value as f32, 255.0, view.gamma()));
            for row in 0..rows {
                for color in (0..width).map(|column| view.color(column, row)) {
                    let channels = color.map(|channel| f64::from(light[usize::from(channel)]));
                    let sum = channels.iter().zip(LUMINANCE).map(|(channel, weight)| channel * weight);
                    values.push(sum.sum::<f64>() as f32);
                    marked.push(color[1] == u8::MAX);
                }
            }
            return Ok(Self::new(width, height, values, Saturation::Marked(marked)));
        }
        for row in 0..rows {
            view.read_row(row, &mut values);
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
            decode(&mut values, view)?;
        }
        let white = if cut { largest(&values) } else { f32::INFINITY };
        Ok(Self::new(width, height, values, Saturation::From(white)))
    }

    fn new(width: usize, height: usize, values: Vec<f32>, saturation: Saturation) -> Self {
        Self { width, height, values, saturation, compression: OnceLock::new() }
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

    /// Whether a pixel stands for any light from its value on: it, or the green of a colour, is the largest value that
    /// some number of bits, 8 or more, can hold. None of a floating-point image is.
    ///
    /// # Panics
    /// When the pixel lies outside the image.
    #[inline]
    #[must_use]
    pub fn is_saturated(&self, column: usize, row: usize) -> bool {
        self.pixel(column, row).1
    }

    /// The value of a pixel, and whether it stands for any light from there on.
    #[inline]
    pub(super) fn pixel(&self, column: usize, row: usize) -> (f32, bool) {
        assert!(column < self.width, "column {column} of {}", self.width);
        let index = row * self.width + column;
        let value = self.values[index];
        let saturated = match &self.saturation {
            Saturation::From(white) => value >= *white,
            Saturation::Marked(marked) => marked[index],
        };
        (value, saturated)
    }

    /// Appends the values of some pixels of a row, or else of a column, and whether each stands for any light from there on.
    #[inline(always)]
    pub(super) fn read_line(
        &self,
        is_row: bool,
        line: usize,
        pixels: Range<usize>,
        values: &mut Vec<f64>,
        saturated: &mut Vec<bool>,
    ) {
        let (first, step) = if is_row { (line * self.width, 1) } else { (line, self.width) };
        let first = first + step * pixels.start;
        let indices = || (first..).step_by(step).take(pixels.len());
        match is_row {
            true => values.extend(self.row(line)[pixels.clone()].iter().map(|value| f64::from(*value))),
            false => values.extend(indices().map(|index| f64::from(self.values[index]))),
        }
        match &self.saturation {
            Saturation::From(white) => {
                let own = &values[values.len() - pixels.len()..];
                saturated.extend(own.iter().map(|value| *value >= f64::from(*white)));
            }
            Saturation::Marked(marked) => saturated.extend(indices().map(|index| marked[index])),
        }
    }

    /// The squares of pixels that some positions x, y are in. All of them must be inside the image.
    #[inline(always)]
    pub(super) fn read_squares(&self, x: &[f64], y: &[f64], squares: &mut Squares) {
        squares.resize(x.len());
        let Squares { above, below, saturated } = squares;
        // Not negative, numbers become those below them.
        let index = |(x, y): (&f64, &f64)| *y as u32 as usize * self.width + *x as u32 as usize;
        for ((index, above), below) in x.iter().zip(y).map(index).zip(above.iter_mut()).zip(below.iter_mut())
        {
            let pixels = &self.values[index..index + self.width + 2];
            (*above, *below) = ([pixels[0], pixels[1]], [pixels[self.width], pixels[self.width + 1]]);
        }
        match &self.saturation {
            Saturation::From(white) => {
                for ((saturated, [a, b]), [c, d]) in saturated.iter_mut().zip(&above[..]).zip(&below[..]) {
                    *saturated = (a >= white) | (b >= white) | (c >= white) | (d >= white);
                }
            }
            Saturation::Marked(marked) => {
                for (saturated, index) in saturated.iter_mut().zip(x.iter().zip(y).map(index)) {
                    let below = index + self.width;
                    *saturated = marked[index] | marked[index + 1] | marked[below] | marked[below + 1];
                }
            }
        }
    }

    /// What `find` finds out about the compression of the image, which is asked once.
    pub(crate) fn compression(&self, find: impl FnOnce() -> f64) -> f64 {
        *self.compression.get_or_init(find)
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

/// The light of a coded value; that of `end` is `end`.
fn light(value: f32, end: f32, gamma: f64) -> f32 {
    if gamma == 1.0 { value } else { end * f64::from(value / end).powf(gamma) as f32 }
}

/// Makes light of the coded values of a grey image; the largest that the format can hold stays what it is.
fn decode(values: &mut [f32], view: &ImageView<'_>) -> Result<()> {
    if view.format() == ImageFormat::F32 {
        let end = largest(values).max(f32::MIN_POSITIVE);
        values.iter_mut().for_each(|value| *value = light(*value, end, view.gamma()));
        return Ok(());
    }
    let end = if view.format() == ImageFormat::U16 { u16::MAX } else { u16::from(u8::MAX) };
    // A power takes far longer than a look into a table.
    let mut table = with_room(usize::from(end) + 1, "the image")?;
    table.extend((0..=end).map(|value| light(f32::from(value), f32::from(end), view.gamma())));
    values.iter_mut().for_each(|value| *value = table[*value as usize]);
    Ok(())
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
    fn what_was_found_about_the_compression_is_not_asked_again() {
        let image = GreyImage::copy(&ImageView::from_u8(&[1; 6], (3, 2)).unwrap()).unwrap();
        assert_eq!(image.compression(|| 3.0), 3.0);
        assert_eq!(image.compression(|| unreachable!()), 3.0);
        // Another image has another compression.
        let other = GreyImage::copy(&ImageView::from_u8(&[1; 6], (3, 2)).unwrap()).unwrap();
        assert_eq!(other.compression(|| 4.0), 4.0);
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
            [0, 1].map(|column| image.is_saturated(column, 0))
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
