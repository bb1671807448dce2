//! Straight edges of the image, after the region growing of von Gioi, Jakubowicz, Morel and Randall, "LSD: a line
//! segment detector", IPOL 2012.

use crate::camera::Camera;
use crate::memory::List;
use crate::observations::GreyImage;
use crate::statistics::min_max_of;
use nalgebra::{Matrix2, Vector2};
use pulp::{Arch, Simd, WithSimd};

constants! {
    /// Pixels across the longer side of the image in which edges are looked for: larger ones are averaged in boxes.
    PIXELS_ACROSS = 640.0, "px";

    /// Gradients that count, in standard deviations of their noise: one in 3,000 of noise alone.
    SIGNIFICANT = 3.0, "σ";

    /// Gradients of one edge differ in direction by up to 22.5 degrees (von Gioi et al.): its cosine.
    ALIKE = 0.9239, "";

    /// The shortest edge in pixels: what is shorter is noise, or has no direction.
    SHORTEST = 8.0, "px";

    /// The standard deviation across an edge in pixels: a step blurred by up to this much.
    WIDEST = 2.0, "px";

    /// An edge pixel's gradient times this is at least any gradient beside it across the edge.
    STANDS_OUT = 2.0, "";
}

/// Gradients that are less than this part of the largest do not count: images without noise have no quartile.
const LEAST_STRENGTH: f32 = 0.01;

/// The lower quartile of the magnitude of a gradient of noise (Rayleigh) in standard deviations of one component.
const QUARTILE: f64 = 0.7585;

/// Where beside an edge its blur may be, in pixels across it.
const BESIDE: [f32; 6] = [-3.0, -2.0, -1.0, 1.0, 2.0, 3.0];

/// A straight edge by its ends on the plane z = 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct Edge {
    pub ends: [Vector2<f64>; 2],
}

impl Edge {
    pub fn length(&self) -> f64 {
        (self.ends[1] - self.ends[0]).norm()
    }

    pub fn middle(&self) -> Vector2<f64> {
        0.5 * (self.ends[0] + self.ends[1])
    }

    pub fn direction(&self) -> Vector2<f64> {
        (self.ends[1] - self.ends[0]).normalize()
    }
}

/// The gradient of an image: its parts along rows and columns, and its magnitudes.
struct Gradient {
    width: usize,
    height: usize,
    x: Vec<f32>,
    y: Vec<f32>,
    magnitudes: Vec<f32>,
}

impl Gradient {
    /// Whether a gradient is at least half as strong as any next to it across the edge: the shading beside a limb has its
    /// direction, but is weaker, and would make a broad region of the edge.
    #[inline(always)]
    fn stands_out(&self, [column, row]: [usize; 2]) -> bool {
        let k = row * self.width + column;
        let unit = self.unit(k);
        for step in BESIDE {
            let x = nearest(column as f32 + unit.x * step, self.width);
            let y = nearest(row as f32 + unit.y * step, self.height);
            if !(STANDS_OUT.get() as f32 * self.magnitudes[k] >= self.magnitudes[y * self.width + x]) {
                return false;
            }
        }
        true
    }

    fn lists(&mut self) -> [&mut Vec<f32>; 3] {
        [&mut self.x, &mut self.y, &mut self.magnitudes]
    }

    /// The direction of a gradient.
    #[inline]
    fn unit(&self, k: usize) -> Vector2<f32> {
        Vector2::new(self.x[k], self.y[k]) / self.magnitudes[k]
    }
}

/// The whole number nearest to a coordinate, from 0 on and below a limit. [`f32::round`] is a call.
#[inline(always)]
fn nearest(t: f32, below: usize) -> usize {
    /// 2²³: a number from here on is a whole one, and ends with what was added. An image has fewer rows and columns.
    const WHOLE: f32 = 8_388_608.0;
    let t = if t > 0.0 { t } else { 0.0 };
    (((t + WHOLE).to_bits() ^ WHOLE.to_bits()) as usize).min(below - 1)
}

/// Pixels that are looked at in one go.
const BLOCK: usize = 32;

/// The gradients above a threshold that stand out, by the widest instructions of the machine.
struct Standing<'a> {
    gradient: &'a Gradient,
    threshold: f32,
}

impl WithSimd for Standing<'_> {
    type Output = Vec<u32>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Vec<u32> {
        let Self { gradient, threshold } = self;
        let mut found = Vec::new();
        for (row, magnitudes) in gradient.magnitudes.chunks_exact(gradient.width).enumerate() {
            for (block, some) in magnitudes.chunks(BLOCK).enumerate() {
                // Most of an image is no edge.
                let mut any = false;
                for magnitude in some {
                    any |= *magnitude > threshold;
                }
                if !any {
                    continue;
                }
                for (column, magnitude) in (block * BLOCK..).zip(some) {
                    if *magnitude > threshold && gradient.stands_out([column, row]) {
                        found.push((row * gradient.width + column) as u32);
                    }
                }
            }
        }
        found
    }
}

/// The straight edges of an image.
pub(super) fn edges(image: &GreyImage, camera: &Camera) -> Vec<Edge> {
    let factor = (image.width().max(image.height()) as f64 / PIXELS_ACROSS.get()).round().max(1.0) as usize;
    let gradient = gradient(&reduced(image, factor), image.width() / factor, image.height() / factor);
    let mut found = Vec::new();
    let Some(threshold) = threshold(&gradient.magnitudes) else { return found };
    let mut free = vec![false; gradient.magnitudes.len()];
    let order = Arch::new().dispatch(Standing { gradient: &gradient, threshold });
    order.iter().for_each(|&k| free[k as usize] = true);
    let mut region = Vec::new();
    for seed in strongest_first(order, &gradient.magnitudes).into_iter().map(|k| k as usize) {
        if !free[seed] {
            continue;
        }
        grow(&gradient, seed, &mut free, &mut region);
        let Some(ends) = line(&gradient, &region) else { continue };
        let rays = ends.map(|end| {
            camera.unproject(&(end * factor as f64).add_scalar(0.5 * (factor - 1) as f64)).map(|ray| ray.xy())
        });
        if let [Some(a), Some(b)] = rays {
            found.push(Edge { ends: [a, b] });
        }
    }
    found
}

/// Pixels by falling magnitude, those alike in their order: by the digits of the bits of the magnitudes, the last first. Numbers
/// without sign are ordered as their bits are.
fn strongest_first(mut order: Vec<u32>, magnitudes: &[f32]) -> Vec<u32> {
    const BITS: u32 = 11;
    let mut ordered = vec![0; order.len()];
    for shift in [0, BITS, 2 * BITS] {
        let digit = |k: u32| (!magnitudes[k as usize].to_bits() >> shift) as usize & ((1 << BITS) - 1);
        let mut starts = [0_u32; 1 << BITS];
        order.iter().for_each(|&k| starts[digit(k)] += 1);
        let mut first = 0;
        for start in &mut starts {
            (*start, first) = (first, first + *start);
        }
        for &k in &order {
            let start = &mut starts[digit(k)];
            ordered[*start as usize] = k;
            *start += 1;
        }
        std::mem::swap(&mut order, &mut ordered);
    }
    order
}

/// Means of boxes, as square roots: noise of light grows about as its root does.
fn reduced(image: &GreyImage, factor: usize) -> Vec<f32> {
    let (width, height) = (image.width() / factor, image.height() / factor);
    let root = |value: f32| value.max(0.0).sqrt();
    // Most images are as wide as that.
    if factor == 1 {
        let mut values = Vec::with_capacity(width * height);
        let rows = || (0..height).for_each(|y| values.extend(image.row(y).iter().map(|value| root(*value))));
        Arch::new().dispatch(rows);
        return values;
    }
    let mut values = vec![0.0; width * height];
    for y in 0..height * factor {
        let row = &image.row(y)[..width * factor];
        let sums = &mut values[y / factor * width..][..width];
        for (sum, pixels) in sums.iter_mut().zip(row.chunks_exact(factor)) {
            *sum += pixels.iter().sum::<f32>();
        }
    }
    let area = (factor * factor) as f32;
    let roots = || values.iter_mut().for_each(|value| *value = root(*value / area));
    Arch::new().dispatch(roots);
    values
}

/// Scharr's derivatives; zero along the border.
fn gradient(values: &[f32], width: usize, height: usize) -> Gradient {
    let room = || Vec::with_capacity(values.len());
    let mut gradient = Gradient { width, height, x: room(), y: room(), magnitudes: room() };
    if width > 2 {
        Arch::new().dispatch(Derivatives { values, gradient: &mut gradient });
    }
    gradient.lists().into_iter().for_each(|list| list.resize(values.len(), 0.0));
    gradient
}

/// Derivatives that are computed in one go.
const DERIVATIVES: usize = 128;

/// The derivatives of all rows but the last, with the widest vector instructions of the machine.
struct Derivatives<'a> {
    values: &'a [f32],
    gradient: &'a mut Gradient,
}

impl WithSimd for Derivatives<'_> {
    type Output = ();

    #[inline(always)]
    #[allow(clippy::needless_range_loop, reason = "eight pixels of the image and three of the gradient")]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { values, gradient } = self;
        let width = gradient.width;
        let mut some = [[0.0; DERIVATIVES]; 3];
        for row in 1..gradient.height.saturating_sub(1) {
            // The last columns of the rows before, and the first one of this.
            gradient.lists().into_iter().for_each(|list| list.resize(row * width + 1, 0.0));
            for first in (0..width - 2).step_by(DERIVATIVES) {
                let count = DERIVATIVES.min(width - 2 - first);
                let line = |row: usize| {
                    let line = &values[row * width + first..][..count + 2];
                    [0, 1, 2].map(|first| &line[first..first + count])
                };
                let ([a, b, c], [d, _, f], [g, h, i]) = (line(row - 1), line(row), line(row + 1));
                let [x, y, magnitudes] = some.each_mut().map(|some| &mut some[..count]);
                for k in 0..count {
                    let gx = 3.0 * (c[k] - a[k] + i[k] - g[k]) + 10.0 * (f[k] - d[k]);
                    let gy = 3.0 * (g[k] - a[k] + i[k] - c[k]) + 10.0 * (h[k] - b[k]);
                    // Roots of what an image holds are far from where squares overflow.
                    (x[k], y[k], magnitudes[k]) = (gx, gy, (gx * gx + gy * gy).sqrt());
                }
                for (list, some) in gradient.lists().into_iter().zip(&some) {
                    list.extend_from_slice(&some[..count]);
                }
            }
        }
    }
}

/// From where on a gradient is none of noise; `None` where the image is flat.
fn threshold(magnitudes: &[f32]) -> Option<f32> {
    let quartile = lower_quartile(magnitudes)?;
    // Numbers without sign are ordered as their bits are, and so many side by side.
    let largest = || magnitudes.iter().map(|size| size.to_bits()).max();
    let largest = f32::from_bits(Arch::new().dispatch(largest)?);
    let threshold = (SIGNIFICANT.get() / QUARTILE) as f32 * quartile;
    (largest > 0.0).then_some(threshold.max(LEAST_STRENGTH * largest))
}

/// The number without sign that a quarter of those in a list lie below; `None` of no numbers.
fn lower_quartile(numbers: &[f32]) -> Option<f32> {
    // They are ordered as their bits are: counted by the upper half of these, then looked for among those that share it.
    let upper = |number: &f32| (number.to_bits() >> 16) as usize;
    // Two counts of each, in turn: many neighbours are alike, and one that is counted up waits for its store. The sign is none.
    let mut counts = vec![[0_u32; 2]; 1 << 15];
    let (pairs, rest) = numbers.as_chunks::<2>();
    for [first, second] in pairs {
        counts[upper(first)][0] += 1;
        counts[upper(second)][1] += 1;
    }
    rest.iter().for_each(|number| counts[upper(number)][0] += 1);
    let mut rank = numbers.len() / 4;
    let of_quartile = counts.iter().position(|[first, second]| {
        let count = (first + second) as usize;
        let there = rank < count;
        rank -= if there { 0 } else { count };
        there
    })?;
    let mut alike = Arch::new().dispatch(Alike { numbers, upper: of_quartile as u32 });
    Some(f32::from_bits(*alike.select_nth_unstable(rank).1))
}

/// The bits of the numbers whose upper half is a given one.
struct Alike<'a> {
    numbers: &'a [f32],
    upper: u32,
}

impl WithSimd for Alike<'_> {
    type Output = Vec<u32>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Vec<u32> {
        let Self { numbers, upper } = self;
        let mut found = Vec::new();
        for some in numbers.chunks(BLOCK) {
            // Most have none.
            let mut any = false;
            for number in some {
                any |= number.to_bits() >> 16 == upper;
            }
            if !any {
                continue;
            }
            found.extend(some.iter().map(|number| number.to_bits()).filter(|bits| bits >> 16 == upper));
        }
        found
    }
}

/// The pixels around a seed with gradients of one direction.
fn grow(gradient: &Gradient, seed: usize, free: &mut [bool], region: &mut Vec<usize>) {
    let unit = |k: usize| gradient.unit(k);
    region.clear();
    region.push(seed);
    free[seed] = false;
    let mut sum = unit(seed);
    let mut next = 0;
    while next < region.len() {
        let k = region[next];
        next += 1;
        let mut length = sum.norm();
        // Gradients are zero along the border, so that every neighbour exists.
        for row in [k - gradient.width, k, k + gradient.width] {
            for neighbour in [row - 1, row, row + 1] {
                if !free[neighbour] {
                    continue;
                }
                let direction = unit(neighbour);
                if direction.dot(&sum) > ALIKE.get() as f32 * length {
                    free[neighbour] = false;
                    region.push(neighbour);
                    sum += direction;
                    length = sum.norm();
                }
            }
        }
    }
}

/// The ends of the line through a region, where it is long and narrow.
fn line(gradient: &Gradient, region: &[usize]) -> Option<[Vector2<f64>; 2]> {
    if (region.len() as f64) < SHORTEST.get() {
        return None;
    }
    // Each position takes a division, and is asked for three times. An image has fewer pixels than 2³².
    let width = gradient.width as u32;
    let position = |&k: &usize| Vector2::new(f64::from(k as u32 % width), f64::from(k as u32 / width));
    let positions: List<Vector2<f64>> = region.iter().map(position).collect();
    let (mut weights, mut middle) = (0.0, Vector2::zeros());
    for (&k, position) in region.iter().zip(&*positions) {
        let weight = f64::from(gradient.magnitudes[k]);
        weights += weight;
        middle += position * weight;
    }
    middle /= weights;
    let mut spread = Matrix2::zeros();
    for (&k, position) in region.iter().zip(&*positions) {
        let offset = position - middle;
        spread += offset * offset.transpose() * (f64::from(gradient.magnitudes[k]) / weights);
    }
    let eigen = spread.symmetric_eigen();
    let least = eigen.eigenvalues.imin();
    let direction: Vector2<f64> = eigen.eigenvectors.column(1 - least).into();
    let along = positions.iter().map(|position| (position - middle).dot(&direction));
    let [low, high] = min_max_of(along);
    (high - low >= SHORTEST.get() && eigen.eigenvalues[least] <= WIDEST.get() * WIDEST.get())
        .then(|| [middle + direction * low, middle + direction * high])
}

#[cfg(test)]
mod tests;
