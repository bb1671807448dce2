//! The brightness of the image along a generator.

use super::SAMPLE_PIXELS;
use crate::end_location::surface::Generator;
use crate::memory::List;
use crate::observations::{ReducedImage, Squares};
use pulp::{Arch, Simd, WithSimd};

/// Room for the positions of the samples of one generator, and for their pixels, which the next one has again.
#[derive(Default)]
pub(super) struct Room {
    positions: List<f64>,
    x: List<f64>,
    y: List<f64>,
    pixels: Squares,
}

/// Where samples are taken.
pub(super) struct Sampled<'a> {
    pub image: &'a ReducedImage<'a>,
    pub generator: &'a Generator<'a>,
    /// The position in the middle of the samples, and ± 1 for outward.
    pub position: f64,
    pub outward: f64,
    /// Pixels across the arc by length along the axis.
    pub across: f64,
    /// How many samples there are on either side of the middle.
    pub reach: i32,
}

impl Sampled<'_> {
    /// The brightness every `SAMPLE_PIXELS` outward, and which of the samples may be any light from their value on; `None` where
    /// one of them is outside the image.
    pub fn take(&self, room: &mut Room) -> Option<(List<f64>, List<usize>)> {
        Arch::new().dispatch(Take { sampled: self, room })
    }
}

/// What [`Sampled::take`] does. Positions and pixels are plain loops, which the compiler makes the widest instructions of the machine
/// of; they all round alike.
struct Take<'a> {
    sampled: &'a Sampled<'a>,
    room: &'a mut Room,
}

impl WithSimd for Take<'_> {
    type Output = Option<(List<f64>, List<usize>)>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Self::Output {
        let Self { sampled, room: Room { positions, x, y, pixels } } = self;
        let &Sampled { image, generator, position, outward, across, reach } = sampled;
        let count = 2 * reach as usize + 1;
        for list in [&mut *positions, x, y] {
            list.resize(count, 0.0);
        }
        let step = SAMPLE_PIXELS.get();
        for (sample, k) in positions.iter_mut().zip(-reach..=reach) {
            *sample = position + outward * (step * f64::from(k)) / across;
        }
        generator.pixels(positions, x, y);
        let (right, bottom) = (image.width() as f64 - 1.0, image.height() as f64 - 1.0);
        // Without branches; false for a pixel that is no number.
        let mut inside = true;
        for (x, y) in x.iter().zip(&y[..]) {
            inside &= (*x >= 0.0) & (*y >= 0.0) & (*x < right) & (*y < bottom);
        }
        if !inside {
            return None;
        }
        image.read_squares(x, y, pixels);
        let mut samples = List::filled(0.0, count);
        let (pairs, above, below) = (x.iter().zip(&y[..]), &pixels.above, &pixels.below);
        for (((sample, (x, y)), above), below) in samples.iter_mut().zip(pairs).zip(above).zip(below) {
            *sample = interpolate(*x, *y, [*above, *below]);
        }
        // Mostly none, and then there is no list.
        if !pixels.saturated.contains(&true) {
            return Some((samples, List::apart()));
        }
        let saturated = pixels.saturated.iter().enumerate().filter(|(_, saturated)| **saturated);
        Some((samples, saturated.map(|(k, _)| k).collect()))
    }
}

/// The brightness between the pixels of a square, bilinear.
#[inline(always)]
fn interpolate(x: f64, y: f64, [above, below]: [[f32; 2]; 2]) -> f64 {
    // Not negative, numbers become those below them; `f64::floor` is a call.
    let (right, down) = (x - f64::from(x as u32), y - f64::from(y as u32));
    let line = |[a, b]: [f32; 2]| f64::from(a) * (1.0 - right) + f64::from(b) * right;
    line(above) * (1.0 - down) + line(below) * down
}
