//! What cameras and files do to an image that is linear in light, before it is rounded to 8 bits again.

use crate::support::Noise;
use image::codecs::jpeg::{JpegDecoder, JpegEncoder};
use image::{ExtendedColorType, ImageDecoder};

/// One kind of it.
#[derive(Clone, Copy, PartialEq)]
pub enum Disturbance {
    None,
    /// Brightness from 0 to 1 to this power.
    Power(f64),
    /// The curve of sRGB (IEC 61966-2-1).
    Srgb,
    /// sRGB, then sharpened, then JPEG: what telephones deliver.
    Telephone,
    /// Darker by this part in the corners, with the square of the distance from the middle.
    Vignetting(f64),
    /// Brighter by this factor, cut at white.
    Exposed(f64),
    /// Seen through a Bayer pattern with 2 grey levels of noise, interpolated bilinearly and converted to grey.
    Bayer,
    /// Sharpened: this much of the difference to a Gaussian blur of 1 px added.
    Sharpened(f64),
    /// Compressed as JPEG of this quality and read again.
    Jpeg(u8),
    /// Made smaller by 2 (mean of 2 × 2 pixels), and larger again bilinearly.
    Halved,
}

impl Disturbance {
    /// The image as it is delivered.
    pub fn applied(self, image: &[u8], size: (usize, usize)) -> Vec<u8> {
        let each = |curve: &dyn Fn(f64) -> f64| -> Vec<u8> {
            image.iter().map(|&v| byte(255.0 * curve(f64::from(v) / 255.0))).collect()
        };
        match self {
            Self::None => image.to_vec(),
            Self::Power(power) => each(&|x| x.powf(power)),
            Self::Srgb => {
                each(&|x| if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 })
            }
            Self::Telephone => {
                let sharpened = Self::Sharpened(1.0).applied(&Self::Srgb.applied(image, size), size);
                Self::Jpeg(80).applied(&sharpened, size)
            }
            Self::Vignetting(part) => {
                let middle = (size.0 as f64 / 2.0, size.1 as f64 / 2.0);
                from_pixels(size, |x, y| {
                    let square = (x as f64 - middle.0).powi(2) + (y as f64 - middle.1).powi(2);
                    let corner = middle.0.powi(2) + middle.1.powi(2);
                    f64::from(image[y * size.0 + x]) * (1.0 - part * square / corner)
                })
            }
            Self::Exposed(factor) => each(&|x| factor * x),
            Self::Bayer => bayer(image, size),
            Self::Sharpened(amount) => {
                let weights = [-3, -2, -1, 0, 1, 2, 3].map(|d: i32| (d, (-0.5 * f64::from(d * d)).exp()));
                let sum: f64 = weights.iter().map(|(_, weight)| weight).sum();
                let mean = |value: &dyn Fn(i32) -> f64| -> f64 {
                    weights.iter().map(|&(d, weight)| weight / sum * value(d)).sum()
                };
                let rows: Vec<f64> = (0..image.len())
                    .map(|k| mean(&|d| at(image, size, (k % size.0) as i32 + d, (k / size.0) as i32)))
                    .collect();
                from_pixels(size, |x, y| {
                    let row = |d: i32| (y as i32 + d).clamp(0, size.1 as i32 - 1) as usize;
                    let blurred = mean(&|d| rows[row(d) * size.0 + x]);
                    let value = f64::from(image[y * size.0 + x]);
                    value + amount * (value - blurred)
                })
            }
            Self::Jpeg(quality) => {
                let mut file = Vec::new();
                let mut encoder = JpegEncoder::new_with_quality(&mut file, quality);
                encoder.encode(image, size.0 as u32, size.1 as u32, ExtendedColorType::L8).unwrap();
                let mut values = vec![0; image.len()];
                let decoder = JpegDecoder::new(std::io::Cursor::new(file)).unwrap();
                decoder.read_image(&mut values).unwrap();
                values
            }
            Self::Halved => {
                let small = |x: i32, y: i32| {
                    let (x, y) = (x.clamp(0, size.0 as i32 / 2 - 1), y.clamp(0, size.1 as i32 / 2 - 1));
                    let four = [(0, 0), (1, 0), (0, 1), (1, 1)];
                    four.map(|(dx, dy)| at(image, size, 2 * x + dx, 2 * y + dy)).iter().sum::<f64>() / 4.0
                };
                from_pixels(size, |x, y| {
                    // A pixel lies 1/4 of a small one from the middle of its own, towards the neighbour.
                    let (x, y) = (x as i32, y as i32);
                    let (own, beside) = ((x / 2, y / 2), (x / 2 + x % 2 * 2 - 1, y / 2 + y % 2 * 2 - 1));
                    let along = |y| 0.75 * small(own.0, y) + 0.25 * small(beside.0, y);
                    0.75 * along(own.1) + 0.25 * along(beside.1)
                })
            }
        }
    }
}

fn byte(value: f64) -> u8 {
    value.round().clamp(0.0, 255.0) as u8
}

/// The value of a pixel, beyond the border that of the nearest one.
fn at(image: &[u8], (width, height): (usize, usize), x: i32, y: i32) -> f64 {
    let (x, y) = (x.clamp(0, width as i32 - 1) as usize, y.clamp(0, height as i32 - 1) as usize);
    f64::from(image[y * width + x])
}

fn from_pixels((width, height): (usize, usize), value: impl Fn(usize, usize) -> f64) -> Vec<u8> {
    (0..width * height).map(|k| byte(value(k % width, k / width))).collect()
}

/// Red, green and blue of a grey scene in the light of a lamp, each seen by its own pixels, in the rows RGRG, GBGB.
fn bayer(image: &[u8], size: (usize, usize)) -> Vec<u8> {
    const LAMP: [f64; 3] = [1.0, 0.8, 0.5];
    const GREY: [f64; 3] = [0.299, 0.587, 0.114];
    let mut noise = Noise::new(1);
    let channel = |x: i32, y: i32| (x.rem_euclid(2) + y.rem_euclid(2)) as usize;
    let raw: Vec<u8> = (0..image.len())
        .map(|k| {
            let own = channel((k % size.0) as i32, (k / size.0) as i32);
            byte(LAMP[own] * f64::from(image[k]) + 2.0 * noise.normal())
        })
        .collect();
    from_pixels(size, |x, y| {
        let (x, y) = (x as i32, y as i32);
        let mean = |wanted: usize| {
            let (mut sum, mut weights) = (0.0, 0.0);
            for (dx, dy) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))) {
                if channel(x + dx, y + dy) == wanted {
                    let weight = f64::from((2 - i32::abs(dx)) * (2 - i32::abs(dy)));
                    sum += weight * at(&raw, size, x + dx, y + dy);
                    weights += weight;
                }
            }
            sum / weights
        };
        let own = channel(x, y);
        let value = |k: usize| if k == own { at(&raw, size, x, y) } else { mean(k) };
        (0..3).map(|k| GREY[k] * value(k)).sum::<f64>() / (0..3).map(|k| GREY[k] * LAMP[k]).sum::<f64>()
    })
}
