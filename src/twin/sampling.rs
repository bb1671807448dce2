//! Means over the area of pixels: one ray where a pixel sees one smooth surface, many where it sees an edge.

use super::random::hash;
use super::shape::Part;

/// Rays through a pixel with an edge in it, and the Fibonacci number before.
const RAYS: usize = 34;
const STRIDE: usize = 21;

/// A difference of the albedo of neighbours that is an edge.
const ALBEDO_STEP: f32 = 0.03;

/// What one ray saw.
#[derive(Debug, Clone, Copy)]
pub struct Sample<const N: usize> {
    /// What tells an edge.
    pub key: Key,
    /// What is averaged.
    pub values: [f64; N],
}

/// Neighbours with different keys have an edge between them.
#[derive(Debug, Clone, Copy, Default)]
pub struct Key {
    /// The body and its part, if any was met.
    pub surface: Option<(usize, Part)>,
    /// Whether the lamp reaches it.
    pub lit: bool,
    /// The albedo.
    pub albedo: f32,
}

impl Key {
    fn differs(&self, other: &Self) -> bool {
        self.surface != other.surface
            || self.lit != other.lit
            || (self.albedo - other.albedo).abs() > ALBEDO_STEP
    }
}

/// The mean over each pixel, row by row; `look` is asked for positions in pixels, whose centres are integers.
pub fn mean_over_pixels<const N: usize>(
    (width, height): (usize, usize),
    look: impl Fn(f64, f64) -> Sample<N>,
) -> Vec<[f64; N]> {
    let centre = |k: usize| look((k % width) as f64, (k / width) as f64);
    let samples: Vec<Sample<N>> = (0..width * height).map(centre).collect();
    let edge = |x: usize, y: usize| {
        let key = &samples[y * width + x].key;
        let rows = y.saturating_sub(1)..(y + 2).min(height);
        let columns = x.saturating_sub(1)..(x + 2).min(width);
        rows.into_iter().any(|v| columns.clone().any(|u| samples[v * width + u].key.differs(key)))
    };
    let mean = |k: usize| {
        let (x, y) = (k % width, k / width);
        if !edge(x, y) {
            return samples[k].values;
        }
        let mut sum = [0.0; N];
        for offset in offsets(x as i64, y as i64) {
            let values = look(x as f64 + offset[0], y as f64 + offset[1]).values;
            sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
        }
        sum.map(|sum| sum / RAYS as f64)
    };
    (0..width * height).map(mean).collect()
}

/// Samples that cover a pixel evenly, shifted by another amount in each pixel so that what is left of their error averages
/// out along an edge: a Fibonacci lattice (Niederreiter, Random number generation and quasi-Monte Carlo methods, 1992).
fn offsets(x: i64, y: i64) -> impl Iterator<Item = [f64; 2]> {
    let shift = [hash(0, x, y), hash(1, x, y)];
    let sample = move |k: usize| {
        let lattice = [k, k * STRIDE % RAYS].map(|index| index as f64 / RAYS as f64);
        [0, 1].map(|axis| wrapped(lattice[axis] + shift[axis]))
    };
    (0..RAYS).map(sample)
}

/// Into [−1/2, 1/2).
fn wrapped(coordinate: f64) -> f64 {
    coordinate - libm::floor(coordinate + 0.5)
}

/// Blurs an image by a Gaussian of a standard deviation in pixels; beyond the border the image goes on as it ends.
pub fn blur<const N: usize>(image: &mut [[f64; N]], (width, height): (usize, usize), sigma: f64) {
    if !(sigma > 0.0) {
        return;
    }
    let reach = libm::ceil(4.0 * sigma) as usize;
    let weights: Vec<f64> = (0..=2 * reach)
        .map(|k| k as f64 - reach as f64)
        .map(|x| libm::exp(-0.5 * x * x / (sigma * sigma)))
        .collect();
    let total: f64 = weights.iter().sum();
    let weights: Vec<f64> = weights.iter().map(|w| w / total).collect();
    let mut line = vec![[0.0; N]; width.max(height) + 2 * reach];
    let mut blur_line = |start: usize, step: usize, count: usize| {
        for (k, value) in line[..count + 2 * reach].iter_mut().enumerate() {
            *value = image[start + step * k.saturating_sub(reach).min(count - 1)];
        }
        for k in 0..count {
            let mut sum = [0.0; N];
            for (weight, value) in weights.iter().zip(&line[k..]) {
                sum.iter_mut().zip(value).for_each(|(sum, value)| *sum += weight * value);
            }
            image[start + step * k] = sum;
        }
    };
    (0..height).for_each(|y| blur_line(y * width, 1, width));
    (0..width).for_each(|x| blur_line(x, width, height));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_over_a_pixel_is_the_share_of_a_half_plane() {
        let (width, height) = (8, 60);
        for border in [3.1, 3.25, 3.5] {
            let look = |x: f64, _: f64| Sample {
                key: Key { lit: x < border, ..Key::default() },
                values: [f64::from(u8::from(x < border))],
            };
            let image = mean_over_pixels((width, height), look);
            let share: f64 =
                (0..height).map(|y| (0..width).map(|x| image[y * width + x][0]).sum::<f64>()).sum();
            // Pixels cover from -1/2 on.
            assert!((share / height as f64 - border - 0.5).abs() < 0.005, "{border}: {share}");
        }
    }

    #[test]
    fn a_blur_keeps_the_sum_and_has_its_width() {
        let mut image = vec![[0.0]; 41 * 41];
        image[20 * 41 + 20] = [1.0];
        blur(&mut image, (41, 41), 1.5);
        let sum: f64 = image.iter().map(|v| v[0]).sum();
        let spread: f64 =
            image.iter().enumerate().map(|(k, v)| v[0] * ((k % 41) as f64 - 20.0).powi(2)).sum();
        assert!((sum - 1.0).abs() < 1e-12 && (spread - 2.25).abs() < 0.01, "{sum} {spread}");
    }
}
