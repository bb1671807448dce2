//! Image files: checked by their header before any pixel is decoded or memory is taken for it.

use crate::failure::Failure;
use cylfuse::observations::{Frame, ImageFormat, ImageView};
use image::{ColorType, DynamicImage, ImageDecoder, ImageReader, Limits};
use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, Read, Seek};
use std::path::Path;

/// The largest image in pixels, that of the library's cameras.
const MAX_PIXELS: u64 = 1 << 28;

/// Bytes of the largest pixel: four channels of 16 bits.
const MAX_PIXEL_BYTES: u64 = 8;

/// Bytes at the start of a file that are looked at for the size of the image.
const HEAD: u64 = 1 << 16;

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

/// Reads an image that must have the size of the camera.
pub fn read(path: &Path, role: Role, camera: (u32, u32)) -> Result<DynamicImage, Failure> {
    let not_readable = |error| Failure::not_readable(path, &error);
    let mut file = File::open(path).map_err(not_readable)?;
    let mut head = Vec::new();
    file.by_ref().take(HEAD).read_to_end(&mut head).map_err(not_readable)?;
    file.rewind().map_err(not_readable)?;
    // The limits below stop a decoder of a huge image before it can tell the size. If the head is not enough
    // for the size, what is wrong shows below.
    if let Ok(Ok(size)) = reader(Cursor::new(head)).map(ImageReader::into_dimensions) {
        check_size(path, role, size, camera)?;
    }
    let mut reader = reader(BufReader::new(file)).map_err(not_readable)?;
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(MAX_PIXELS * MAX_PIXEL_BYTES);
    reader.limits(limits);
    let damaged = |error| {
        Failure::bad_image(path, format!("the {} cannot be decoded: {error}; {}", role.name(), role.file()))
    };
    let decoder = reader.into_decoder().map_err(damaged)?;
    check_size(path, role, decoder.dimensions(), camera)?;
    let color = decoder.color_type();
    if role == Role::Depth && color != ColorType::L16 {
        let reason = format!("the depth image has {} pixels; {}", color_name(color), role.file());
        return Err(Failure::bad_image(path, reason));
    }
    DynamicImage::from_decoder(decoder).map_err(damaged)
}

/// A reader that goes by the content, not by the name, and knows no limits.
fn reader<R: BufRead + Seek>(source: R) -> std::io::Result<ImageReader<R>> {
    let mut reader = ImageReader::new(source).with_guessed_format()?;
    reader.no_limits();
    Ok(reader)
}

fn check_size(path: &Path, role: Role, size: (u32, u32), camera: (u32, u32)) -> Result<(), Failure> {
    let (name, (width, height)) = (role.name(), size);
    if u64::from(width) * u64::from(height) > MAX_PIXELS {
        let reason = format!(
            "the {name} claims {width} x {height} pixels; at most {MAX_PIXELS} are read, so crop or scale it"
        );
        return Err(Failure::image_too_large(path, reason));
    }
    if size != camera {
        let (camera_width, camera_height) = camera;
        let reason = format!(
            "the {name} is {width} x {height} but its camera is {camera_width} x {camera_height}; {}",
            role.size()
        );
        return Err(Failure::size_mismatch(path, reason));
    }
    Ok(())
}

fn color_name(color: ColorType) -> String {
    let channels = match color.channel_count() {
        1 => "grey",
        2 => "grey and alpha",
        3 => "RGB",
        _ => "RGBA",
    };
    let bits = 8 * u16::from(color.bytes_per_pixel()) / u16::from(color.channel_count());
    format!("{bits}-bit {channels}")
}

/// A mask byte for each pixel: non-zero where any colour channel is. Alpha does not count.
pub fn mask_bytes(image: DynamicImage) -> Vec<u8> {
    match image {
        DynamicImage::ImageLuma8(grey) => grey.into_raw(),
        // 16 bits a channel, because rounding to fewer would lose small values.
        other => other.into_rgb16().pixels().map(|pixel| u8::from(pixel.0 != [0; 3])).collect(),
    }
}

/// Gives an image to a frame with its pixels as they are, so that the library knows gamma and saturation by channel.
pub fn give(image: &DynamicImage, gamma: f64, frame: &mut Frame) -> cylfuse::error::Result<()> {
    let size = (image.width() as usize, image.height() as usize);
    let mut set = |view: ImageView<'_>| frame.set_image(&view.with_gamma(gamma)?);
    match image {
        DynamicImage::ImageLuma8(grey) => set(ImageView::from_u8(grey, size)?),
        DynamicImage::ImageLuma16(grey) => set(ImageView::from_u16(grey, size)?),
        DynamicImage::ImageLumaA8(_) => set(ImageView::from_u8(&image.to_luma8(), size)?),
        DynamicImage::ImageLumaA16(_) => set(ImageView::from_u16(&image.to_luma16(), size)?),
        DynamicImage::ImageRgb8(color) => set(ImageView::from_bytes(color, size, ImageFormat::Rgb8)?),
        DynamicImage::ImageRgba8(color) => set(ImageView::from_bytes(color, size, ImageFormat::Rgba8)?),
        deep => set(ImageView::from_bytes(&eight_bits(&deep.to_rgb16()), size, ImageFormat::Rgb8)?),
    }
}

/// The values of 16-bit channels in 8 bits, the most that the library takes of a colour. Sensors fill 10 or 12 of the 16
/// bits: the largest value of those in use, and no other, becomes the largest of 8 bits.
fn eight_bits(values: &[u16]) -> Vec<u8> {
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
    fn any_colour_channel_makes_a_mask_pixel_but_alpha_does_not() {
        let colour = image::RgbaImage::from_raw(3, 1, vec![0, 0, 1, 0, 0, 0, 0, 255, 9, 0, 0, 255]);
        assert_eq!(mask_bytes(DynamicImage::ImageRgba8(colour.unwrap())), [1, 0, 1]);
        let grey = image::ImageBuffer::from_raw(2, 1, vec![1_u16, 0]).unwrap();
        assert_eq!(mask_bytes(DynamicImage::ImageLuma16(grey)), [1, 0]);
    }
}
