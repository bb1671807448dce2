//! The brightness of the image along a generator.

use super::SAMPLE_PIXELS;
use crate::end_location::surface::Generator;
use crate::memory::List;
use crate::observations::ReducedImage;
use pulp::{Arch, Simd, WithSimd};

/// Room for the places of the samples of one generator, and for their pixels, which the next one has again.
#[derive(Default)]
pub(super) struct Room {
    places: List<f64>,
    x: List<f64>,
    y: List<f64>,
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

/// What [`Sampled::take`] does. Places and pixels are plain loops, which the compiler makes the widest instructions of the machine
/// of; they all round alike.
struct Take<'a> {
    sampled: &'a Sampled<'a>,
    room: &'a mut Room,
}

impl WithSimd for Take<'_> {
    type Output = Option<(List<f64>, List<usize>)>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Self::Output {
        let Self { sampled, room: Room { places, x, y } } = self;
        let &Sampled { image, generator, position, outward, across, reach } = sampled;
        let count = 2 * reach as usize + 1;
        for list in [&mut *places, x, y] {
            list.resize(count, 0.0);
        }
        let step = SAMPLE_PIXELS.get();
        for (place, k) in places.iter_mut().zip(-reach..=reach) {
            *place = position + outward * (step * f64::from(k)) / across;
        }
        generator.pixels(places, x, y);
        let (right, bottom) = (image.width() as f64 - 1.0, image.height() as f64 - 1.0);
        // Without branches; false for a pixel that is no number.
        let mut inside = true;
        for (x, y) in x.iter().zip(&y[..]) {
            inside &= (*x >= 0.0) & (*y >= 0.0) & (*x < right) & (*y < bottom);
        }
        if !inside {
            return None;
        }
        let (mut samples, mut cut_off) = (List::with_capacity(count), List::new());
        for (k, (x, y)) in x.iter().zip(&y[..]).enumerate() {
            let (value, saturated) = interpolate(image, *x, *y);
            samples.push(value);
            if saturated {
                cut_off.push(k);
            }
        }
        Some((samples, cut_off))
    }
}

/// The brightness between pixels, bilinear, and whether the light of one of them may be any from its value on.
#[inline(always)]
fn interpolate(image: &ReducedImage<'_>, x: f64, y: f64) -> (f64, bool) {
    // Not negative, numbers become those below them; `f64::floor` is a call.
    let (column, row) = (x as u32, y as u32);
    let (right, down) = (x - f64::from(column), y - f64::from(row));
    let ([above, below], saturated) = image.square(column as usize, row as usize);
    let line = |[a, b]: [f32; 2]| f64::from(a) * (1.0 - right) + f64::from(b) * right;
    (line(above) * (1.0 - down) + line(below) * down, saturated)
}
