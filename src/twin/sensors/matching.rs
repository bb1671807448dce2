//! Block matching along rows: for each pixel of one image the disparity at which the other one looks alike.

/// How two images are matched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Matching {
    /// Half of the side of a window in pixels, without its middle.
    pub half: usize,
    /// The least disparity in pixels.
    pub least: usize,
    /// How many disparities are tried.
    pub count: usize,
    /// The least correlation.
    pub least_score: f32,
    /// The second best position must correlate less than this share of the best one, else neither counts.
    pub uniqueness: f32,
    /// Whether the best position of the other image must lead back.
    pub both_ways: bool,
    /// Disparities are multiples of 1 / `steps` pixels.
    pub steps: f64,
}

/// The least disparity, and one more than the largest, of a range of depths: `strength` / z.
pub fn range(strength: f64, [nearest, farthest]: [f64; 2]) -> [usize; 2] {
    [libm::floor(strength / farthest) as usize, libm::ceil(strength / nearest) as usize + 1]
}

/// The depths of disparities, 0 where there is none, after what sensors do to these: small islands are taken away, and each becomes
/// the median about it.
pub fn depths(
    mut disparity: Vec<f32>,
    size: (usize, usize),
    least_island: usize,
    half_median: usize,
    strength: f64,
) -> Vec<f32> {
    remove_islands(&mut disparity, size, least_island);
    let depth = |d: f32| if d > 0.0 { (strength / f64::from(d)) as f32 } else { 0.0 };
    median(&disparity, size, half_median).into_iter().map(depth).collect()
}

/// The disparity of each pixel of the first image, row by row; NaN where none was found.
///
/// A pixel x of the first image is compared with the pixels x − d + `margin` of the second, whose rows are longer by
/// `margin`, by the normalised correlation of windows with their means taken away. Sums are of integers, exact in any
/// order. The peak is placed by a parabola through three values and rounded to the steps.
pub fn disparities(
    first: &[u8],
    second: &[u8],
    (width, height): (usize, usize),
    margin: usize,
    matching: &Matching,
) -> Vec<f32> {
    let mut out = vec![f32::NAN; width * height];
    let side = 2 * matching.half + 1;
    let long = width + margin;
    if width < side || height < side || matching.count == 0 {
        return out;
    }
    let own = Spread::of(first, (width, height), matching.half);
    let other = Spread::of(second, (long, height), matching.half);
    let mut search = RowSearch::new(width, matching);
    let mut columns = vec![0_i32; matching.count * width];
    for row in 0..height {
        // Products of the columns of the window that ends in this row.
        for (index, sums) in columns.chunks_exact_mut(width).enumerate() {
            let Some(shift) = margin.checked_sub(matching.least + index) else { continue };
            add_products(sums, &first[row * width..], &second[row * long + shift..], 1);
            if let Some(old) = row.checked_sub(side) {
                add_products(sums, &first[old * width..], &second[old * long + shift..], -1);
            }
        }
        if row + 1 < side {
            continue;
        }
        let middle = row - matching.half;
        search.correlate(&columns, &own.row(middle), &other.row(middle), margin);
        search.choose(&mut out[middle * width..][..width]);
    }
    out
}

fn add_products(sums: &mut [i32], a: &[u8], b: &[u8], sign: i32) {
    for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
        *sum += sign * i32::from(*a) * i32::from(*b);
    }
}

/// Sums over windows and the inverse of their spread; 0 where a window has no texture or does not fit.
struct Spread {
    width: usize,
    sums: Vec<i32>,
    inverse: Vec<f32>,
}

struct SpreadRow<'a> {
    sums: &'a [i32],
    inverse: &'a [f32],
}

impl Spread {
    fn of(image: &[u8], (width, height): (usize, usize), half: usize) -> Self {
        let side = 2 * half + 1;
        let count = (side * side) as i32;
        let (mut sums, mut inverse) = (vec![0; width * height], vec![0.0; width * height]);
        for y in half..height - half {
            for x in half..width - half {
                let (mut sum, mut squares) = (0, 0);
                for v in y - half..=y + half {
                    for value in &image[v * width + x - half..=v * width + x + half] {
                        sum += i32::from(*value);
                        squares += i32::from(*value) * i32::from(*value);
                    }
                }
                let spread = count * squares - sum * sum;
                sums[y * width + x] = sum;
                // Less than one grey level of deviation is quantisation.
                inverse[y * width + x] =
                    if spread > count * count { 1.0 / (spread as f32).sqrt() } else { 0.0 };
            }
        }
        Self { width, sums, inverse }
    }

    fn row(&self, row: usize) -> SpreadRow<'_> {
        let range = row * self.width..(row + 1) * self.width;
        SpreadRow { sums: &self.sums[range.clone()], inverse: &self.inverse[range] }
    }
}

/// The correlations of a row, and the choice among them.
struct RowSearch<'a> {
    width: usize,
    matching: &'a Matching,
    /// By disparity, then by column.
    scores: Vec<f32>,
    best: Vec<f32>,
    at: Vec<i32>,
    second: Vec<f32>,
}

impl<'a> RowSearch<'a> {
    fn new(width: usize, matching: &'a Matching) -> Self {
        Self {
            width,
            matching,
            scores: vec![0.0; matching.count * width],
            best: vec![0.0; width],
            at: vec![0; width],
            second: vec![0.0; width],
        }
    }

    fn correlate(&mut self, columns: &[i32], own: &SpreadRow, other: &SpreadRow, margin: usize) {
        let half = self.matching.half;
        let count = ((2 * half + 1) * (2 * half + 1)) as i32;
        let lines = self.scores.chunks_exact_mut(self.width).zip(columns.chunks_exact(self.width));
        for (index, (scores, columns)) in lines.enumerate() {
            scores.fill(0.0);
            let Some(shift) = margin.checked_sub(self.matching.least + index) else { continue };
            let mut sum: i32 = columns[..2 * half].iter().sum();
            for x in half..self.width - half {
                sum += columns[x + half];
                let covariance = count * sum - own.sums[x] * other.sums[x + shift];
                scores[x] = covariance as f32 * own.inverse[x] * other.inverse[x + shift];
                sum -= columns[x - half];
            }
        }
    }

    fn choose(&mut self, out: &mut [f32]) {
        let Matching { count, least, least_score, uniqueness, steps, both_ways, .. } = *self.matching;
        self.best.fill(f32::MIN);
        for (index, scores) in self.scores.chunks_exact(self.width).enumerate() {
            for ((best, at), score) in self.best.iter_mut().zip(&mut self.at).zip(scores) {
                let better = score > best;
                *best = if better { *score } else { *best };
                *at = if better { index as i32 } else { *at };
            }
        }
        self.second.fill(f32::MIN);
        for (index, scores) in self.scores.chunks_exact(self.width).enumerate() {
            for ((second, at), score) in self.second.iter_mut().zip(&self.at).zip(scores) {
                let rival = (index as i32 - at).abs() > 2 && score > second;
                *second = if rival { *score } else { *second };
            }
        }
        for (x, out) in out.iter_mut().enumerate() {
            let (best, at) = (self.best[x], self.at[x] as usize);
            let clear = best >= least_score && self.second[x] < uniqueness * best;
            if !clear || at == 0 || at + 1 >= count || (both_ways && !self.leads_back(x, at)) {
                continue;
            }
            let [before, after] = [at - 1, at + 1].map(|index| self.scores[index * self.width + x]);
            let bend = before - 2.0 * best + after;
            let offset = if bend < 0.0 { 0.5 * f64::from((before - after) / bend) } else { 0.0 };
            let exact = (least + at) as f64 + offset;
            *out = (libm::round(exact * steps) / steps) as f32;
        }
    }

    /// Whether what the other image sees there finds the same disparity, to one pixel.
    fn leads_back(&self, x: usize, at: usize) -> bool {
        let best = self.best[x];
        (0..self.matching.count).all(|index| {
            let column = x as isize + index as isize - at as isize;
            let near = index.abs_diff(at) <= 1;
            near || column < 0
                || column >= self.width as isize
                || self.scores[index * self.width + column as usize] <= best
        })
    }
}

/// Neighbours in an island differ by no more than this, in pixels.
const ISLAND_STEP: f32 = 1.0;

/// Takes away small islands: pixels that hang together through neighbours of nearly the same disparity, fewer than
/// `least` of them (as the speckle filter of OpenCV's block matching).
fn remove_islands(disparity: &mut [f32], (width, height): (usize, usize), least: usize) {
    let mut seen = vec![false; disparity.len()];
    let mut island = Vec::new();
    for start in 0..disparity.len() {
        if seen[start] || disparity[start].is_nan() {
            continue;
        }
        island.clear();
        island.push(start);
        seen[start] = true;
        let mut next = 0;
        while let Some(&k) = island.get(next) {
            next += 1;
            let (x, y) = (k % width, k / width);
            let around = [
                (x > 0).then(|| k - 1),
                (x + 1 < width).then_some(k + 1),
                (y > 0).then(|| k - width),
                (y + 1 < height).then_some(k + width),
            ];
            for other in around.into_iter().flatten() {
                if !seen[other] && (disparity[other] - disparity[k]).abs() <= ISLAND_STEP {
                    seen[other] = true;
                    island.push(other);
                }
            }
        }
        if island.len() < least {
            island.iter().for_each(|&k| disparity[k] = f32::NAN);
        }
    }
}

/// The median over windows of 2 `half` + 1 pixels; pixels without a value stay so, and do not count.
fn median(disparity: &[f32], (width, height): (usize, usize), half: usize) -> Vec<f32> {
    let mut values = Vec::new();
    let mut out = disparity.to_vec();
    for y in 0..height {
        for x in 0..width {
            if disparity[y * width + x].is_nan() {
                continue;
            }
            values.clear();
            for v in y.saturating_sub(half)..(y + half + 1).min(height) {
                let row = &disparity[v * width..][x.saturating_sub(half)..(x + half + 1).min(width)];
                values.extend(row.iter().filter(|value| !value.is_nan()));
            }
            let middle = values.len() / 2;
            out[y * width + x] = *values.select_nth_unstable_by(middle, f32::total_cmp).1;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::twin::random::hash;

    const MATCHING: Matching = Matching {
        half: 3,
        least: 2,
        count: 20,
        least_score: 0.5,
        uniqueness: 0.95,
        both_ways: false,
        steps: 8.0,
    };

    #[test]
    fn a_shifted_image_is_found_at_its_shift() {
        let (width, height, margin) = (60, 20, 24);
        let noise = |x: i64, y: i64| (255.0 * hash(3, x, y)) as u8;
        let pixel = |k: usize, width: usize| ((k % width) as i64, (k / width) as i64);
        let long = width + margin;
        let second: Vec<u8> =
            (0..long * height).map(|k| pixel(k, long)).map(|(x, y)| noise(x - margin as i64, y)).collect();
        let first: Vec<u8> =
            (0..width * height).map(|k| pixel(k, width)).map(|(x, y)| noise(x - 9, y)).collect();
        for both_ways in [false, true] {
            let matching = Matching { both_ways, ..MATCHING };
            let found = disparities(&first, &second, (width, height), margin, &matching);
            assert!(
                (10..50).all(|x| (found[10 * width + x] - 9.0).abs() <= 0.125),
                "{:?}",
                &found[10 * width..11 * width]
            );
            assert!(found[..width].iter().all(|d| d.is_nan()));
        }
    }

    #[test]
    fn what_repeats_is_not_unique() {
        let (width, height, margin) = (60, 20, 24);
        let stripes = |k: usize, width: usize| if (k % width) % 6 < 3 { 40 } else { 200 };
        let first: Vec<u8> = (0..width * height).map(|k| stripes(k, width)).collect();
        let second: Vec<u8> = (0..(width + margin) * height).map(|k| stripes(k, width + margin)).collect();
        let found = disparities(&first, &second, (width, height), margin, &MATCHING);
        assert!(found.iter().all(|d| d.is_nan()));
    }

    #[test]
    fn islands_go_and_coasts_stay() {
        let mut disparity = vec![5.0; 100];
        disparity[44] = 9.0;
        remove_islands(&mut disparity, (10, 10), 4);
        assert!(disparity[44].is_nan() && disparity.iter().filter(|d| d.is_nan()).count() == 1);
        disparity[45] = 7.0;
        assert_eq!(median(&disparity, (10, 10), 1)[45], 5.0);
    }
}
