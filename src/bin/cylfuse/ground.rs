//! What pictures are drawn on: the image, or the depth where there is none.

use crate::canvas::opaque;
use crate::images::{Image, Pixels, eight_bits};
use tiny_skia::Pixmap;

/// The image, or the depth as grey levels when there is none. `None` where it would be too large.
pub fn draw(
    image: Option<&Image>,
    (width, height): (usize, usize),
    depth: impl Fn(usize, usize) -> Option<f64> + Copy,
) -> Option<Pixmap> {
    let colors = match image {
        Some(image) => colors(image),
        None => grey_levels((0..height).flat_map(|y| (0..width).map(move |x| depth(x, y))), true),
    };
    let mut ground = Pixmap::new(width as u32, height as u32)?;
    for (pixel, color) in ground.pixels_mut().iter_mut().zip(colors) {
        *pixel = opaque(color);
    }
    Some(ground)
}

/// The image as grey levels.
#[cfg(feature = "bench")]
pub fn grey(image: &Image) -> Vec<u8> {
    let light =
        |[r, g, b]: [u8; 3]| (2126 * u32::from(r) + 7152 * u32::from(g) + 722 * u32::from(b)) / 10_000;
    colors(image).into_iter().map(|color| light(color) as u8).collect()
}

fn colors(image: &Image) -> Vec<[u8; 3]> {
    match &image.pixels {
        Pixels::Grey8(values) => values.iter().map(|&value| [value; 3]).collect(),
        Pixels::Grey16(values) => grey_levels(values.iter().map(|&value| Some(f64::from(value))), false),
        Pixels::Rgb8(values) => values.as_chunks().0.to_vec(),
        Pixels::Rgb16(values) => eight_bits(values).as_chunks().0.to_vec(),
    }
}

/// Grey levels of values, spread over the range that is in use: sensors fill 10 or 12 of 16 bits, and depths a part of
/// theirs. What was not measured is black.
fn grey_levels(values: impl Iterator<Item = Option<f64>> + Clone, depth: bool) -> Vec<[u8; 3]> {
    let mut sorted: Vec<f64> = values.clone().flatten().collect();
    sorted.sort_unstable_by(f64::total_cmp);
    // One value in fifty at either side may be an outlier.
    let quantile =
        |part: usize| sorted.get(sorted.len().saturating_sub(1) * part / 50).copied().unwrap_or(0.0);
    let (low, high) = if depth { (quantile(1), quantile(49)) } else { (0.0, quantile(50)) };
    let part = |value: f64| if high > low { ((value - low) / (high - low)).clamp(0.0, 1.0) } else { 0.0 };
    let level = |value: Option<f64>| {
        value.map_or(0.0, |value| match depth {
            // Near is bright.
            true => 235.0 - 190.0 * part(value),
            false => 255.0 * part(value),
        })
    };
    values.map(|value| [level(value) as u8; 3]).collect()
}
