//! What compression adds to the noise of an image.
//!
//! JPEG rounds the cosine transform of every block of 8 × 8 pixels by itself. What is lost is no noise of single
//! pixels: differences of neighbours within a block hardly show it, and it makes edges where there are none. It does show
//! where two blocks meet, because their errors are independent there: the differences across such a border are larger
//! than those within, by E|e₁ − e₂| = 2 σ / √π for errors of standard deviation σ.

use crate::observations::GreyImage;

/// Columns and rows of a block.
const BLOCK: usize = 8;

/// Positions within a block that its border is compared with: at even distances from it, for the patterns of colour
/// filters repeat every two pixels, and not next to it.
const WITHIN: [usize; 3] = [1, 3, 5];

/// Differences beyond this many mean ones are edges of what is seen.
const LARGEST: f64 = 4.0;

/// How many standard deviations above chance the differences at borders must be, along rows and along columns.
const SIGNIFICANT: f64 = 5.0;

constants! {
    /// How many standard deviations of a pixel the error of a block counts in a sum over pixels: it is alike over about
    /// two pixels each way.
    ALIKE = 2.0, "σ";
}

/// The standard deviation of independent noise that does as much to a sum over pixels as the compression does, in the unit
/// of the image; 0 where none is seen. The blocks must begin in the corner of the image.
pub(super) fn noise_of_compression(image: &GreyImage) -> f64 {
    let (width, height) = (image.width(), image.height());
    let excess = image.compression(|| {
        let rows = excess(width, height, |row| image.row(row).iter().copied());
        let columns = excess(height, width, |column| (0..height).map(move |row| image.value(column, row)));
        rows.zip(columns).map_or(0.0, |(rows, columns)| f64::midpoint(rows, columns))
    });
    ALIKE.get() * 0.5 * std::f64::consts::PI.sqrt() * excess
}

/// By how much the differences at borders exceed those within, along one line of pixels a block; `None` where that may be
/// chance.
fn excess<Line: Iterator<Item = f32>>(
    length: usize,
    lines: usize,
    line: impl Fn(usize) -> Line,
) -> Option<f64> {
    if length < 2 {
        return None;
    }
    let chosen = || (BLOCK / 2..lines).step_by(BLOCK);
    let mut differences: Vec<f32> = Vec::with_capacity(chosen().count() * (length - 1));
    for chosen in chosen() {
        let mut values = line(chosen);
        let Some(mut before) = values.next() else { continue };
        differences.extend(values.map(|here| (here - std::mem::replace(&mut before, here)).abs()));
    }
    let sum: f64 = differences.iter().copied().map(f64::from).sum();
    let most = LARGEST * sum / differences.len() as f64;
    // Number, sum and sum of squares by position in a block.
    let mut by_position = [[0.0; BLOCK]; 3];
    for line in differences.chunks_exact(length - 1) {
        let (blocks, rest) = line.as_chunks::<BLOCK>();
        for block in blocks {
            add(&mut by_position, block, most);
        }
        add(&mut by_position, rest, most);
    }
    let by_position: [[f64; 3]; BLOCK] = std::array::from_fn(|k| by_position.map(|sums| sums[k]));
    let mean_and_variance = |[count, sum, squares]: [f64; 3]| {
        let mean = sum / count;
        (mean, (squares / count - mean * mean) / count)
    };
    let within = WITHIN
        .iter()
        .fold([0.0; 3], |sum, &position| std::array::from_fn(|k| sum[k] + by_position[position][k]));
    let ((border, of_border), (inside, of_inside)) =
        (mean_and_variance(by_position[BLOCK - 1]), mean_and_variance(within));
    let excess = border - inside;
    (excess > SIGNIFICANT * (of_border + of_inside).sqrt()).then_some(excess)
}

/// Adds differences, those beyond the largest one as that, to number, sum and sum of squares by position.
#[inline]
fn add(by_position: &mut [[f64; BLOCK]; 3], differences: &[f32], most: f64) {
    for (k, difference) in differences.iter().enumerate() {
        let difference = f64::from(*difference);
        let d = if difference < most { difference } else { most };
        by_position[0][k] += 1.0;
        by_position[1][k] += d;
        by_position[2][k] += d * d;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observations::ImageView;

    /// A ramp with edges and noise, and an error of each block, uniform between ± `error`.
    fn image(error: f64) -> GreyImage {
        let hash = |a: usize, b: usize, salt: u64| {
            let mut x = (a as u64 * 0x9e37_79b9_7f4a_7c15) ^ (b as u64 * 0xc2b2_ae3d_27d4_eb4f) ^ salt;
            x = (x ^ (x >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            x = (x ^ (x >> 32)).wrapping_mul(0x94d0_49bb_1331_11eb);
            (x >> 11) as f64 / (1_u64 << 53) as f64 * 2.0 - 1.0
        };
        let (width, height) = (320, 240);
        let pixel = |k: usize| {
            let (x, y) = (k % width, k / width);
            let tiles = if (x / 37 + y / 29) % 2 == 0 { 60.0 } else { 0.0 };
            let value = 60.0 + 0.2 * x as f64 + tiles + hash(x, y, 1) + error * hash(x / 8, y / 8, 2);
            value.round() as u8
        };
        let values: Vec<u8> = (0..width * height).map(pixel).collect();
        GreyImage::copy(&ImageView::from_u8(&values, (width, height)).unwrap()).unwrap()
    }

    #[test]
    fn errors_of_blocks_are_seen_and_nothing_else() {
        assert_eq!(noise_of_compression(&image(0.0)), 0.0);
        let error = 3.0;
        let expected = ALIKE.get() * error / 3.0_f64.sqrt();
        let found = noise_of_compression(&image(error));
        assert!((found / expected - 1.0).abs() < 0.4, "{found} {expected}");
    }
}
