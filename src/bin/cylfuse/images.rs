//! Image files: checked by their header before any pixel is decoded or memory is taken for it.

use crate::failure::Failure;
use cylfuse::observations::{Frame, ImageFormat, ImageView};
use png::{BitDepth, ColorType};
use std::fmt::Display;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, Write};
use std::path::Path;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// The largest image in pixels, that of the library's cameras.
const MAX_PIXELS: u64 = 1 << 28;

/// Bytes of the largest pixel: four channels of 16 bits.
const MAX_PIXEL_BYTES: u64 = 8;

/// The most that a JPEG file may have: bytes of a pixel, which is more than without any compression, and what describes the image.
const JPEG_PIXEL_BYTES: u64 = 4;
const JPEG_EXTRA_BYTES: u64 = 16 << 20;

/// What a JPEG file starts with.
const JPEG: [u8; 3] = [0xff, 0xd8, 0xff];

/// An image as it is in its file, but for alpha, which never counts, and for palettes and fewer than 8 bits, which are expanded.
#[derive(Debug, Clone)]
pub struct Image {
    /// Columns and rows.
    pub size: (u32, u32),
    /// The pixels, row by row.
    pub pixels: Pixels,
}

/// Pixels by the kind of their channels; colours are red, green, blue.
#[derive(Debug, Clone)]
pub enum Pixels {
    /// Grey, 8 bits.
    Grey8(Vec<u8>),
    /// Grey, 16 bits.
    Grey16(Vec<u16>),
    /// Colours, 8 bits each.
    Rgb8(Vec<u8>),
    /// Colours, 16 bits each.
    Rgb16(Vec<u16>),
}

/// What an image is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// The grey or colour image.
    Image,
    /// The depth image.
    Depth,
    /// The mask.
    Mask,
}

impl Role {
    fn name(self) -> &'static str {
        match self {
            Role::Image => "image",
            Role::Depth => "depth image",
            Role::Mask => "mask",
        }
    }

    /// What to do about a file that is no such image.
    fn file(self) -> &'static str {
        match self {
            Role::Image => "give a PNG or JPEG file",
            Role::Depth => "give a PNG file of one 16-bit channel (grey), such as depth in millimetres",
            Role::Mask => "give a PNG file of one 8-bit channel (grey)",
        }
    }

    /// What to do about an image of another size than the camera.
    fn size(self) -> &'static str {
        match self {
            Role::Image => "intrinsics belong to one resolution: give those of this image",
            Role::Depth => "register the depth to the image, or describe its own camera as depth_camera",
            Role::Mask => "scale the mask to the image",
        }
    }
}

/// Reads an image that must have the size of the camera. The content tells the format, not the name.
pub fn read(path: &Path, role: Role, camera: (u32, u32)) -> Result<Image, Failure> {
    let not_readable = |error| Failure::not_readable(path, &error);
    let mut file = BufReader::new(File::open(path).map_err(not_readable)?);
    let is_jpeg = file.fill_buf().map_err(not_readable)?.starts_with(&JPEG);
    let asked = Asked { path, role, camera };
    if is_jpeg { asked.jpeg(file) } else { asked.png(file) }
}

/// What is asked for, to check what a file promises.
struct Asked<'a> {
    path: &'a Path,
    role: Role,
    camera: (u32, u32),
}

impl Asked<'_> {
    fn png(&self, file: impl BufRead + Seek) -> Result<Image, Failure> {
        let damaged = |error: png::DecodingError| self.damaged(error);
        let limits = png::Limits { bytes: (MAX_PIXELS * MAX_PIXEL_BYTES) as usize };
        let mut decoder = png::Decoder::new_with_limits(file, limits);
        // Nothing in these counts here.
        decoder.set_ignore_text_chunk(true);
        decoder.set_ignore_iccp_chunk(true);
        decoder.set_transformations(png::Transformations::EXPAND);
        let size = decoder.read_header_info().map_err(damaged)?.size();
        self.check_size(size)?;
        let mut reader = decoder.read_info().map_err(damaged)?;
        let (color, depth) = reader.output_color_type();
        self.check_kind(color, depth)?;
        let bytes = reader.output_buffer_size().ok_or_else(|| self.damaged("it is too large"))?;
        let mut data = vec![0; bytes];
        reader.next_frame(&mut data).map_err(damaged)?;
        let words =
            || -> Vec<u16> { data.as_chunks().0.iter().map(|word| u16::from_be_bytes(*word)).collect() };
        let pixels = match (color, depth) {
            (ColorType::Grayscale, BitDepth::Sixteen) => Pixels::Grey16(words()),
            (ColorType::GrayscaleAlpha, BitDepth::Sixteen) => Pixels::Grey16(without_alpha(&words(), 2)),
            (ColorType::Rgb, BitDepth::Sixteen) => Pixels::Rgb16(words()),
            (ColorType::Rgba, BitDepth::Sixteen) => Pixels::Rgb16(without_alpha(&words(), 4)),
            (ColorType::Grayscale, _) => Pixels::Grey8(data),
            (ColorType::GrayscaleAlpha, _) => Pixels::Grey8(without_alpha(&data, 2)),
            (ColorType::Rgba, _) => Pixels::Rgb8(without_alpha(&data, 4)),
            // Palettes were expanded.
            (ColorType::Rgb | ColorType::Indexed, _) => Pixels::Rgb8(data),
        };
        Ok(Image { size, pixels })
    }

    fn jpeg(&self, file: impl Read) -> Result<Image, Failure> {
        let (width, height) = self.camera;
        let most = u64::from(width) * u64::from(height) * JPEG_PIXEL_BYTES + JPEG_EXTRA_BYTES;
        let mut data = Vec::new();
        file.take(most + 1)
            .read_to_end(&mut data)
            .map_err(|error| Failure::not_readable(self.path, &error))?;
        if data.len() as u64 > most {
            let reason = format!(
                "the {} has more than {most} bytes, too many for {width} x {height} pixels; save it anew",
                self.role.name()
            );
            return Err(Failure::image_too_large(self.path, reason));
        }
        // Larger than what the decoder takes by itself: the size is checked here.
        let options = DecoderOptions::default()
            .set_strict_mode(false)
            .set_max_width(usize::MAX)
            .set_max_height(usize::MAX);
        let decoder = |options| JpegDecoder::new_with_options(ZCursor::new(&data), options);
        let mut header = decoder(options);
        header.decode_headers().map_err(|error| self.damaged(error))?;
        let (width, height) = header.dimensions().unwrap_or_default();
        let size = (width as u32, height as u32);
        self.check_size(size)?;
        let grey = header.input_colorspace() == Some(ColorSpace::Luma);
        if header.info().is_some_and(|info| info.components == 2) {
            return Err(self.damaged("it has two channels"));
        }
        self.check_kind(if grey { ColorType::Grayscale } else { ColorType::Rgb }, BitDepth::Eight)?;
        let channels = if grey { ColorSpace::Luma } else { ColorSpace::RGB };
        let decoded = decoder(options.jpeg_set_out_colorspace(channels)).decode();
        let pixels = decoded.map_err(|error| self.damaged(error))?;
        Ok(Image { size, pixels: if grey { Pixels::Grey8(pixels) } else { Pixels::Rgb8(pixels) } })
    }

    fn damaged(&self, error: impl Display) -> Failure {
        let reason = format!("the {} cannot be decoded: {error}; {}", self.role.name(), self.role.file());
        Failure::bad_image(self.path, reason)
    }

    fn check_size(&self, size: (u32, u32)) -> Result<(), Failure> {
        let (name, (width, height)) = (self.role.name(), size);
        if u64::from(width) * u64::from(height) > MAX_PIXELS {
            let reason = format!(
                "the {name} claims {width} x {height} pixels; at most {MAX_PIXELS} are read, so crop or scale it"
            );
            return Err(Failure::image_too_large(self.path, reason));
        }
        if size != self.camera {
            let (camera_width, camera_height) = self.camera;
            let reason = format!(
                "the {name} is {width} x {height} but its camera is {camera_width} x {camera_height}; {}",
                self.role.size()
            );
            return Err(Failure::size_mismatch(self.path, reason));
        }
        Ok(())
    }

    fn check_kind(&self, color: ColorType, depth: BitDepth) -> Result<(), Failure> {
        if self.role != Role::Depth || (color, depth) == (ColorType::Grayscale, BitDepth::Sixteen) {
            return Ok(());
        }
        let channels = match color {
            ColorType::Grayscale => "grey",
            ColorType::GrayscaleAlpha => "grey and alpha",
            ColorType::Rgb | ColorType::Indexed => "RGB",
            ColorType::Rgba => "RGBA",
        };
        let (bits, remedy) = (depth as u8, self.role.file());
        let reason = format!("the depth image has {bits}-bit {channels} pixels; {remedy}");
        Err(Failure::bad_image(self.path, reason))
    }
}

/// The channels but the last of each pixel.
fn without_alpha<T: Copy>(values: &[T], channels: usize) -> Vec<T> {
    values.chunks_exact(channels).flat_map(|pixel| &pixel[..channels - 1]).copied().collect()
}

impl Image {
    /// From its size and pixels.
    pub fn new((width, height): (usize, usize), pixels: Pixels) -> Self {
        Self { size: (width as u32, height as u32), pixels }
    }

    /// Writes a PNG file.
    ///
    /// # Errors
    /// What the writer says; sizes that do not belong to the pixels.
    pub fn write_png(&self, to: impl Write) -> io::Result<()> {
        let words;
        let (color, depth, data) = match &self.pixels {
            Pixels::Grey8(values) => (ColorType::Grayscale, BitDepth::Eight, values),
            Pixels::Rgb8(values) => (ColorType::Rgb, BitDepth::Eight, values),
            Pixels::Grey16(values) | Pixels::Rgb16(values) => {
                words = values.iter().flat_map(|value| value.to_be_bytes()).collect();
                let color = if matches!(self.pixels, Pixels::Grey16(_)) {
                    ColorType::Grayscale
                } else {
                    ColorType::Rgb
                };
                (color, BitDepth::Sixteen, &words)
            }
        };
        let mut encoder = png::Encoder::new(to, self.size.0, self.size.1);
        encoder.set_color(color);
        encoder.set_depth(depth);
        encoder.set_compression(png::Compression::Fast);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(data)?;
        Ok(writer.finish()?)
    }

    /// Writes a JPEG file, of 8-bit pixels.
    ///
    /// # Errors
    /// What the writer says; sizes that do not belong to the pixels or are too large for the format.
    pub fn write_jpeg(&self, to: impl Write, quality: u8) -> io::Result<()> {
        let (color, data) = match &self.pixels {
            Pixels::Grey8(values) => (jpeg_encoder::ColorType::Luma, values),
            Pixels::Rgb8(values) => (jpeg_encoder::ColorType::Rgb, values),
            Pixels::Grey16(_) | Pixels::Rgb16(_) => return Err(io::ErrorKind::Unsupported.into()),
        };
        let (Ok(width), Ok(height)) = (u16::try_from(self.size.0), u16::try_from(self.size.1)) else {
            return Err(io::Error::other("a JPEG file has at most 65535 columns and rows"));
        };
        let mut encoder = jpeg_encoder::Encoder::new(to, quality);
        // Thin lines keep their colours.
        encoder.set_sampling_factor(jpeg_encoder::SamplingFactor::F_1_1);
        encoder.encode(data, width, height, color).map_err(io::Error::other)
    }
}

/// A mask byte for each pixel: non-zero where any channel is.
pub fn mask_bytes(image: &Image) -> Vec<u8> {
    match &image.pixels {
        Pixels::Grey8(values) => values.clone(),
        Pixels::Grey16(values) => values.iter().map(|value| u8::from(*value != 0)).collect(),
        Pixels::Rgb8(values) => values.chunks_exact(3).map(|pixel| u8::from(pixel != [0; 3])).collect(),
        Pixels::Rgb16(values) => values.chunks_exact(3).map(|pixel| u8::from(pixel != [0; 3])).collect(),
    }
}

/// Gives an image to a frame with its pixels as they are, so that the library knows gamma and saturation by channel.
pub fn give(image: &Image, gamma: f64, frame: &mut Frame) -> cylfuse::error::Result<()> {
    let size = (image.size.0 as usize, image.size.1 as usize);
    let mut set = |view: ImageView<'_>| frame.set_image(&view.with_gamma(gamma)?);
    match &image.pixels {
        Pixels::Grey8(values) => set(ImageView::from_u8(values, size)?),
        Pixels::Grey16(values) => set(ImageView::from_u16(values, size)?),
        Pixels::Rgb8(values) => set(ImageView::from_bytes(values, size, ImageFormat::Rgb8)?),
        Pixels::Rgb16(values) => set(ImageView::from_bytes(&eight_bits(values), size, ImageFormat::Rgb8)?),
    }
}

/// The values of 16-bit channels in 8 bits, the most that the library takes of a colour. Sensors fill 10 or 12 of the 16
/// bits: the largest value of those in use, and no other, becomes the largest of 8 bits.
pub fn eight_bits(values: &[u16]) -> Vec<u8> {
    let largest = values.iter().copied().max().unwrap_or(0);
    let white = (u32::from(largest) + 1).next_power_of_two().max(256) - 1;
    values.iter().map(|&value| (u32::from(value) * 255 / white) as u8).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deep_colours_keep_their_saturation() {
        assert_eq!(eight_bits(&[0, 65535, 65534, 257 * 80, 257 * 79 - 1]), [0, 255, 254, 80, 78]);
        // 12 bits.
        assert_eq!(eight_bits(&[4095, 4094, 2048]), [255, 254, 127]);
        assert_eq!(eight_bits(&[200, 3]), [200, 3]);
        assert!(eight_bits(&[]).is_empty());
    }

    #[test]
    fn a_jpeg_file_is_not_read_beyond_what_its_camera_may_take() {
        let asked = Asked { path: Path::new("endless.jpg"), role: Role::Image, camera: (2, 2) };
        let failure = asked.jpeg(io::repeat(JPEG[0])).unwrap_err();
        assert_eq!(failure.status, "IMAGE_TOO_LARGE");
        let reason = "the image has more than 16777232 bytes, too many for 2 x 2 pixels; save it anew";
        assert!(failure.message.ends_with(reason), "{}", failure.message);
    }

    #[test]
    fn any_colour_channel_makes_a_mask_pixel() {
        let mask = |pixels| mask_bytes(&Image { size: (3, 1), pixels });
        assert_eq!(mask(Pixels::Rgb8(vec![0, 0, 1, 0, 0, 0, 9, 0, 0])), [1, 0, 1]);
        assert_eq!(mask(Pixels::Rgb16(vec![0, 256, 0, 0, 0, 0, 0, 0, 1])), [1, 0, 1]);
        assert_eq!(mask(Pixels::Grey16(vec![1, 0, 256])), [1, 0, 1]);
    }
}
