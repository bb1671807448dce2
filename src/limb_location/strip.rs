//! The pixels of the original image around an expected limb line, with their ideal positions.
//!
//! The image is never resampled: every pixel keeps its value, and its position relative to the line is that of
//! its ideal pixel. Interpolation would blur the image by an amount that changes with the position between
//! pixel centres, and the location of an edge to a few hundredths of a pixel hangs on the blur.

use crate::camera::Camera;
use crate::memory::List;
use crate::noise::ImageNoise;
use crate::observations::ReducedImage;
use crate::statistics::{DEVIATION_OF_MEDIAN, lower_quartile_absolute, median_absolute, min_max};
use nalgebra::Vector2;
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

constants! {
    /// How far apart the expected line is projected through the lens, in pixels: a lens bends it by less than a
    /// hundredth of a pixel in between.
    POLYLINE_STEP = 8.0, "px";
}

/// An image on one grid of pixels.
#[derive(Clone, Copy)]
pub(super) struct Grid<'a> {
    pub image: ReducedImage<'a>,
    pub camera: &'a Camera,
    pub noise: ImageNoise,
    /// Standard deviation of a pixel that differences of neighbours do not show.
    pub least_noise: f64,
}

/// A stretch of the expected limb line in ideal pixels and the coordinates about it: s along the line from its
/// middle, u across it, positive towards the inside of the cylinder.
#[derive(Debug, Clone, Copy)]
pub(super) struct Baseline {
    pub middle: Vector2<f64>,
    pub along: Vector2<f64>,
    pub inward: Vector2<f64>,
    pub half_length: f64,
}

impl Baseline {
    /// From the ends of the stretch and any point on the inner side.
    pub fn new(ends: &[Vector2<f64>; 2], inner: &Vector2<f64>) -> Option<Self> {
        let middle = (ends[0] + ends[1]) / 2.0;
        let length = (ends[1] - ends[0]).norm();
        if !(length > 0.0 && length.is_finite()) {
            return None;
        }
        let along = (ends[1] - ends[0]) / length;
        let across = Vector2::new(-along.y, along.x);
        let inward = if across.dot(&(inner - middle)) < 0.0 { -across } else { across };
        Some(Self { middle, along, inward, half_length: length / 2.0 })
    }

    /// The part within `radius` of a point; `None` when there is none.
    pub fn clipped(&self, center: &Vector2<f64>, radius: f64) -> Option<Self> {
        let (s, u) = self.coordinates(center);
        let half = (radius * radius - u * u).max(0.0).sqrt();
        self.between((s - half).max(-self.half_length), (s + half).min(self.half_length))
    }

    /// The part between two s.
    pub fn between(&self, low: f64, high: f64) -> Option<Self> {
        let middle = self.position(f64::midpoint(low, high), 0.0);
        (high > low).then_some(Self { middle, half_length: (high - low) / 2.0, ..*self })
    }

    /// (s, u) of an ideal pixel.
    pub fn coordinates(&self, ideal: &Vector2<f64>) -> (f64, f64) {
        let from_middle = ideal - self.middle;
        (from_middle.dot(&self.along), from_middle.dot(&self.inward))
    }

    /// The ideal pixel at (s, u).
    pub fn position(&self, s: f64, u: f64) -> Vector2<f64> {
        self.middle + self.along * s + self.inward * u
    }
}

/// One pixel of a strip.
#[cfg(test)]
#[derive(Debug, Clone, Copy)]
pub(super) struct StripPixel {
    pub s: f64,
    pub u: f64,
    pub value: f64,
    pub saturated: bool,
}

/// The pixels of a run.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pixels<'a> {
    pub s: &'a [f64],
    pub u: &'a [f64],
    pub values: &'a [f64],
    /// Whether the light may be any from the value on.
    pub saturated: &'a [bool],
}

/// The pixels within some distance of a baseline, in runs across it: pieces of image rows where the line is
/// steep, pieces of columns where it is flat. Runs are ordered along the line, their pixels by rising u.
#[derive(Debug, Clone, Default)]
pub(super) struct Strip {
    s: List<f64>,
    u: List<f64>,
    values: List<f64>,
    marked: List<bool>,
    /// Where each run ends in these lists.
    ends: List<usize>,
    /// Whether any pixel is saturated.
    saturated: bool,
}

impl Strip {
    /// Gathers the pixels with |s| up to the half length of the baseline and |u| up to `half_width`.
    pub fn gather(grid: &Grid<'_>, baseline: &Baseline, half_width: f64) -> Self {
        let runs = runs(grid, baseline, half_width);
        let count = runs.iter().map(|run| run.pixels.len()).sum();
        let mut strip = Self {
            s: List::with_capacity(count),
            u: List::with_capacity(count),
            values: List::with_capacity(count),
            marked: List::with_capacity(count),
            ends: List::with_capacity(runs.len()),
            saturated: false,
        };
        for run in &runs {
            let begin = strip.values.len();
            Arch::new().dispatch(Read { run, image: &grid.image, strip: &mut strip });
            if run.is_reversed() {
                for list in [&mut strip.s, &mut strip.u, &mut strip.values] {
                    list[begin..].reverse();
                }
                strip.marked[begin..].reverse();
            }
            strip.ends.push(strip.values.len());
        }
        strip.saturated = strip.marked.iter().fold(false, |any, marked| any | marked);
        strip
    }

    /// The smallest and the largest s of any pixel that [`Strip::gather`] would gather; `None` without pixels.
    pub fn extent_of(grid: &Grid<'_>, baseline: &Baseline, half_width: f64) -> Option<[f64; 2]> {
        // Along a run s rises or falls, but for what is less than a hundredth of a pixel.
        let ends =
            |run: &Run| [run.pixels.start, run.pixels.end - 1].map(|cross| run.position(cross as f64).0);
        let runs = runs(grid, baseline, half_width);
        let s = || runs.iter().flat_map(ends);
        let extent = [s().fold(f64::INFINITY, f64::min), s().fold(f64::NEG_INFINITY, f64::max)];
        (!runs.is_empty()).then_some(extent)
    }

    /// Of runs that are given.
    #[cfg(test)]
    pub fn of_runs(runs: impl Iterator<Item = Vec<StripPixel>>) -> Self {
        let mut strip = Self::default();
        for run in runs {
            strip.saturated |= run.iter().any(|pixel| pixel.saturated);
            strip.s.extend(run.iter().map(|pixel| pixel.s));
            strip.u.extend(run.iter().map(|pixel| pixel.u));
            strip.values.extend(run.iter().map(|pixel| pixel.value));
            strip.marked.extend(run.iter().map(|pixel| pixel.saturated));
            strip.ends.push(strip.values.len());
        }
        strip
    }

    /// The runs in order along the line.
    pub fn runs(&self) -> impl Iterator<Item = Pixels<'_>> {
        (0..self.ends.len()).map(|k| self.run(k))
    }

    /// Whether any pixel is saturated.
    pub fn is_saturated(&self) -> bool {
        self.saturated
    }

    /// How many runs there are.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// One run.
    pub fn run(&self, k: usize) -> Pixels<'_> {
        let begin = if k == 0 { 0 } else { self.ends[k - 1] };
        let pixels = begin..self.ends[k];
        Pixels {
            s: &self.s[pixels.clone()],
            u: &self.u[pixels.clone()],
            values: &self.values[pixels.clone()],
            saturated: &self.marked[pixels],
        }
    }

    /// Standard deviation of the noise of a pixel, from second differences within the runs (their median, so
    /// that edges do not count; saturated pixels have no noise), and not below a thousandth of the range of the
    /// values: images are quantised.
    ///
    /// Interpolation makes neighbours alike, and their differences small. By how much, differences over two pixels show
    /// where there is least to be seen: the lower quartile.
    pub fn noise(&self, grid: &Grid<'_>) -> f64 {
        if grid.noise.value > 0.0 {
            return grid.noise.value;
        }
        let floor = (1e-3 * self.contrast()).max(f64::MIN_POSITIVE).max(grid.least_noise);
        let own = DEVIATION_OF_MEDIAN * median_absolute(self.second_differences(1).iter().copied())
            / 6.0_f64.sqrt();
        if grid.image.factor() == 1 {
            return own.max(floor);
        }
        // On a reduced grid neighbours are correlated.
        let [near, far] =
            [1, 2].map(|step| lower_quartile_absolute(self.second_differences(step).iter().copied()));
        let alike = (far / near).max(1.0);
        let alike = if alike.is_finite() { alike } else { 1.0 };
        (own * alike).max(floor)
    }

    /// Second differences between pixels `step` apart in a run.
    fn second_differences(&self, step: usize) -> List<f64> {
        let mut differences = List::with_capacity(self.values.len());
        // Loops, as an iterator over iterators is slow to be asked one by one.
        for Pixels { values, saturated, .. } in self.runs() {
            let last = values.get(2 * step..).unwrap_or_default();
            let values = values.iter().zip(values.get(step..).unwrap_or_default()).zip(last);
            let difference = |((a, b), c): ((&f64, &f64), &f64)| a - 2.0 * b + c;
            if self.saturated {
                let cut_off = |k: usize| saturated[k] | saturated[k + step] | saturated[k + 2 * step];
                differences.extend(
                    values.map(difference).enumerate().filter(|(k, _)| !cut_off(*k)).map(|(_, value)| value),
                );
            } else {
                differences.extend(values.map(difference));
            }
        }
        differences
    }

    /// Range of the values.
    pub fn contrast(&self) -> f64 {
        let [least, most] = min_max(&self.values);
        most - least
    }
}

/// A piece of a row or a column of an image across a baseline.
struct Run {
    /// Whether it is one of a row, and which.
    steep: bool,
    line: usize,
    /// Where on it the baseline is, how far it reaches from there, and which of its pixels are within.
    center: f64,
    reach: f64,
    pixels: Range<usize>,
    /// (s, u) at its ends and in the middle.
    positions: [(f64, f64); 3],
}

/// The runs about a baseline in their order along it, each with at least one pixel.
fn runs(grid: &Grid<'_>, baseline: &Baseline, half_width: f64) -> List<Run> {
    let Grid { image, camera, .. } = grid;
    let pieces = (2.0 * baseline.half_length / POLYLINE_STEP.get()).ceil().max(1.0) as usize;
    let vertex = |k: usize| {
        let s = baseline.half_length * (2.0 * k as f64 / pieces as f64 - 1.0);
        camera.project(&camera.ideal_ray(&baseline.position(s, 0.0)))
    };
    let ends = (vertex(0), vertex(pieces));
    let middle = vertex(pieces / 2);
    let chord = ends.0.zip(ends.1).map(|(a, b)| b - a).or_else(|| Some(middle? - ends.0.or(ends.1)?));
    let Some(chord) = chord else { return List::new() };
    let steep = chord.y.abs() >= chord.x.abs();
    // The image axis along which runs follow each other, and the one within a run.
    let split = |p: &Vector2<f64>| if steep { (p.y, p.x) } else { (p.x, p.y) };
    let (_, slant) = split(&chord.normalize());
    let reach = half_width / (1.0 - slant * slant).sqrt();
    let count = if steep { image.height() } else { image.width() };
    let mut runs = List::with_capacity((2.0 * baseline.half_length + 2.0).min(count as f64) as usize);
    for k in 0..pieces {
        let (Some(a), Some(b)) = (vertex(k), vertex(k + 1)) else { continue };
        let ((a_run, a_cross), (b_run, b_cross)) = (split(&a), split(&b));
        let (low, high) = (a_run.min(b_run), a_run.max(b_run));
        // From the first run at or after the lower vertex to the last one before the upper.
        let lines = low.ceil().max(0.0) as usize..(high.ceil().max(0.0) as usize).min(count);
        let reversed = b_run < a_run;
        for k in 0..lines.len() {
            let line = if reversed { lines.end - 1 - k } else { lines.start + k };
            let part = (line as f64 - a_run) / (b_run - a_run);
            runs.extend(Run::new(grid, baseline, (steep, line), a_cross + part * (b_cross - a_cross), reach));
        }
    }
    runs
}

impl Run {
    fn new(
        Grid { image, camera, .. }: &Grid<'_>,
        baseline: &Baseline,
        (steep, line): (bool, usize),
        center: f64,
        reach: f64,
    ) -> Option<Self> {
        let at = |cross: f64| {
            let pixel =
                if steep { Vector2::new(cross, line as f64) } else { Vector2::new(line as f64, cross) };
            let ideal = camera.ideal_pixel(&camera.unproject(&pixel)?)?;
            Some(baseline.coordinates(&ideal))
        };
        let positions = [at(center - reach)?, at(center)?, at(center + reach)?];
        let count = if steep { image.width() } else { image.height() };
        let first = (center - reach).ceil().max(0.0) as usize;
        let end = (((center + reach).floor() + 1.0).max(0.0) as usize).min(count);
        (first < end).then_some(Self { steep, line, center, reach, pixels: first..end, positions })
    }

    /// Whether u falls along it.
    fn is_reversed(&self) -> bool {
        self.positions[2].1 < self.positions[0].1
    }

    /// (s, u) of a pixel. Through the lens the coordinates change smoothly along a run: a parabola through three of them is
    /// exact to 1e-3 pixels.
    #[inline(always)]
    fn position(&self, cross: f64) -> (f64, f64) {
        let [before, here, after] = self.positions;
        let x = (cross - self.center) / self.reach;
        let parabola = |a: f64, b: f64, c: f64| b + (c - a) / 2.0 * x + ((a + c) / 2.0 - b) * x * x;
        (parabola(before.0, here.0, after.0), parabola(before.1, here.1, after.1))
    }
}

/// Positions that are computed in one go.
const BLOCK: usize = 32;

/// Appends the pixels of a run. Plain loops, of a known length for their positions, which the compiler makes the widest instructions of
/// the machine of; they all round alike.
struct Read<'a> {
    run: &'a Run,
    image: &'a ReducedImage<'a>,
    strip: &'a mut Strip,
}

impl WithSimd for Read<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { run, image, strip: Strip { s, u, values, marked, .. } } = self;
        let (mut some_s, mut some_u) = ([0.0; BLOCK], [0.0; BLOCK]);
        for first in run.pixels.clone().step_by(BLOCK) {
            for k in 0..BLOCK {
                (some_s[k], some_u[k]) = run.position(first as f64 + f64::from(k as u32));
            }
            let count = BLOCK.min(run.pixels.end - first);
            s.extend_from_slice(&some_s[..count]);
            u.extend_from_slice(&some_u[..count]);
        }
        image.read_line(run.steep, run.line, run.pixels.clone(), values, marked);
    }
}
