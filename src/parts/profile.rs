//! What is seen along the axis, slice by slice, off a line of it, and the stretches that are a step above that line.

use super::bins::Bins;
use super::ends::pixel_length;
use crate::camera::Camera;
use crate::geometry::Cylinder;
use crate::memory::List;
use crate::statistics::{at_both_ends, independent_part};
use std::ops::Range;

/// How many slices are as long as the radius.
const SLICES_OF_RADIUS: f64 = 24.0;

/// The length of a slice in pixels at least: each has pixels of both sides then.
const LEAST_PIXELS: f64 = 1.5;

/// Fewest sights of a slice of the depth that is full.
pub(super) const LEAST_SIGHTS: usize = 4;

/// Fewest slices, and fewest that are full.
const LEAST_SLICES: usize = 8;

/// The least part of the slices that is full.
const LEAST_FULL: f64 = 0.4;

/// Fewest slices of a stretch and of the rest, by their weights.
const LEAST_OF_STRETCH: f64 = 2.0;
const LEAST_OF_REST: f64 = 4.0;

/// The part of the sights at either end of the surface that is left out.
const TRIM: f64 = 0.005;

/// Slices of the axis.
pub(super) struct Slices {
    pub(super) low: f64,
    pub(super) length: f64,
    pub(super) count: usize,
}

impl Slices {
    /// Slices of the part of the axis along which the depth shows the surface; `None` for too few.
    pub(super) fn new(
        camera: &Camera,
        cylinder: &Cylinder,
        apart: usize,
        depth: &[[f64; 2]],
    ) -> Option<Self> {
        let [low, high] = ends_of(depth)?;
        let pixel = pixel_length(camera, cylinder, f64::midpoint(low, high))?;
        Self::between([low, high], cylinder.radius, LEAST_PIXELS.max(apart as f64) * pixel, depth.len())
    }

    /// The same of points alone.
    pub(super) fn of_points(cylinder: &Cylinder, points: &[[f64; 2]]) -> Option<Self> {
        Self::between(ends_of(points)?, cylinder.radius, 0.0, points.len())
    }

    fn between([low, high]: [f64; 2], radius: f64, shortest: f64, seen: usize) -> Option<Self> {
        let count = ((high - low) / (radius / SLICES_OF_RADIUS).max(shortest)) as usize;
        // More slices than the sights can fill are none.
        let most = seen as f64 / (LEAST_FULL * LEAST_SIGHTS as f64);
        let enough = count >= LEAST_SLICES && count as f64 <= most;
        enough.then(|| Self { low, length: (high - low) / count as f64, count })
    }

    pub(super) fn middle(&self) -> f64 {
        self.low + 0.5 * self.length * self.count as f64
    }

    /// The indices so near to one; what is at an end stays there.
    pub(super) fn beside(&self, index: usize, near: usize) -> Range<usize> {
        if index == 0 || index == self.count {
            return index..index + 1;
        }
        index.saturating_sub(near).max(1)..(index + near + 1).min(self.count)
    }

    /// Where a stretch of them begins and ends along the axis; infinite beside an end.
    pub(super) fn along(&self, stretch: &Range<usize>, near: usize) -> [f64; 2] {
        let at = |index: usize| self.low + index as f64 * self.length;
        let begin = if stretch.start <= near { f64::NEG_INFINITY } else { at(stretch.start) };
        let end = if stretch.end + near >= self.count { f64::INFINITY } else { at(stretch.end) };
        [begin, end]
    }
}

/// Where along the axis what is seen begins and ends; `None` for too little.
fn ends_of(seen: &[[f64; 2]]) -> Option<[f64; 2]> {
    let alongs: List<f64> = seen.iter().map(|[along, _]| *along).collect();
    let enough = alongs.len() >= LEAST_SIGHTS * LEAST_SLICES;
    enough.then(|| at_both_ends(&alongs, (TRIM * alongs.len() as f64) as usize))
}

/// What is seen along the axis, off a line of it.
#[derive(Clone)]
pub(super) struct Profile {
    /// The weight and the median of each slice; no weight where it holds too little.
    slices: List<[f64; 2]>,
    /// The weights of all slices before each one, and their sums with the index of a slice, from the mean index, and with how far it is off the line.
    sums: List<[f64; 3]>,
    /// The sums with the squares of these.
    squares: [f64; 2],
    /// The mean index.
    mean: f64,
    /// The least deviation of a slice.
    floor: f64,
}

impl Profile {
    /// What `of` makes of the slices that hold enough; `None` where too few do.
    pub(super) fn new(
        slices: &Slices,
        seen: &[[f64; 2]],
        (least, of): (usize, fn(&mut [f64]) -> f64),
        floor: f64,
    ) -> Option<Self> {
        let count = slices.count;
        let slice_of = |along: f64| {
            let slice = (along - slices.low) / slices.length;
            (0.0..count as f64).contains(&slice).then_some(slice as usize)
        };
        let by_slice = seen.iter().filter_map(|[along, value]| Some((slice_of(*along)?, *value)));
        let mut bins = Bins::new(count, by_slice);
        let full: List<usize> = (0..count).filter(|slice| bins.len_of(*slice) >= least).collect();
        if (full.len() as f64) < LEAST_FULL * count as f64 {
            return None;
        }
        let all: usize = full.iter().map(|slice| bins.len_of(*slice)).sum();
        let mut weighted = List::filled([0.0; 2], count);
        for &slice in &full {
            // Weights of 1 in the mean.
            let weight = (bins.len_of(slice) * full.len()) as f64 / all as f64;
            weighted[slice] = [weight, of(bins.of(slice))];
        }
        Self::off_a_line(weighted, floor)
    }

    /// The same without stretches, but that of one number, and so many slices beside them.
    pub(super) fn without(
        &self,
        stretches: &[Range<usize>],
        but: Option<usize>,
        margin: usize,
    ) -> Option<Self> {
        let mut slices = self.slices.clone();
        for (_, stretch) in stretches.iter().enumerate().filter(|(k, _)| Some(*k) != but) {
            let end = (stretch.end + margin).min(slices.len());
            slices[stretch.start.saturating_sub(margin)..end].fill([0.0; 2]);
        }
        Self::off_a_line(slices, self.floor)
    }

    /// `None` for too few slices with a weight.
    fn off_a_line(slices: List<[f64; 2]>, floor: f64) -> Option<Self> {
        let weighted = |term: fn(f64, f64) -> f64| -> f64 {
            slices.iter().enumerate().map(|(x, [weight, y])| weight * term(x as f64, *y)).sum()
        };
        let n = weighted(|_, _| 1.0);
        let full = slices.iter().filter(|[weight, _]| *weight > 0.0).count();
        if full < LEAST_SLICES {
            return None;
        }
        let [mean, level] = [weighted(|x, _| x) / n, weighted(|_, y| y) / n];
        let squares = weighted(|x, _| x * x) - n * mean * mean;
        let slope = (weighted(|x, y| x * y) - n * mean * level) / squares;
        let mut profile = Self { sums: List::from([[0.0; 3]]), squares: [squares, 0.0], mean, floor, slices };
        let mut sum = [0.0; 3];
        for (x, [weight, y]) in profile.slices.iter().enumerate() {
            let x = x as f64 - mean;
            let off = y - level - slope * x;
            let terms = [1.0, x, off];
            sum = [0, 1, 2].map(|k| sum[k] + weight * terms[k]);
            profile.sums.push(sum);
            profile.squares[1] += weight * off * off;
        }
        Some(profile)
    }

    /// The same with the other sign: what is lowered is raised.
    pub(super) fn negated(mut self) -> Self {
        self.slices.iter_mut().for_each(|[_, value]| *value = -*value);
        self.sums.iter_mut().for_each(|[.., off]| *off = -*off);
        self
    }

    /// What a step of a stretch explains of the squares about the line.
    pub(super) fn explained(&self, stretch: &Range<usize>) -> f64 {
        self.lever(stretch).map_or(0.0, |[up, freedom]| up * up / freedom)
    }

    /// The stretch of such a length that reaches an end and may be above a line by a step of this size and this ratio.
    pub(super) fn raised_at_end(&self, lengths: Range<usize>, least: [f64; 2]) -> Option<Range<usize>> {
        let count = self.slices.len();
        self.clearest(lengths.flat_map(|length| [0..length, count - length..count]), least)
    }

    /// The stretches that may be above a line by a step of this size and this ratio, farther apart than a margin.
    pub(super) fn raised(&self, longest: usize, least: [f64; 2], margin: usize) -> List<Range<usize>> {
        // A stretch begins and ends with slices that are above the line.
        let clearest = |profile: &Self| {
            let above = |slice: &usize| profile.sums[slice + 1][2] > profile.sums[*slice][2];
            let count = profile.slices.len();
            let stretches = (0..count).filter(above).flat_map(|start| {
                (start..count.min(start + longest)).filter(above).map(move |last| start..last + 1)
            });
            profile.clearest(stretches, least)
        };
        let (mut stretches, mut looked_at): (List<Range<usize>>, List<Range<usize>>) = Default::default();
        let mut rest = Some(self.clone());
        // The clearest first: what one leaves shows another.
        while let Some(stretch) = rest.as_ref().and_then(clearest) {
            let beside = |other: &&mut Range<usize>| {
                stretch.start <= other.end + margin && other.start <= stretch.end + margin
            };
            // What is beside one belongs to it where one step explains both: waves of the depth beside a flange are nothing.
            match stretches.iter_mut().find(beside) {
                Some(other) => {
                    let both = stretch.start.min(other.start)..stretch.end.max(other.end);
                    if self.explained(&both) >= self.explained(other) {
                        *other = both;
                    }
                }
                None => stretches.push(stretch.clone()),
            }
            looked_at.push(stretch);
            rest = self.without(&looked_at, None, margin);
        }
        stretches
    }

    /// The one of some stretches whose step up from a line beside it explains most, if it has a step of this size; `None` where its
    /// ratio is too small even if the slices are independent.
    fn clearest(
        &self,
        stretches: impl Iterator<Item = Range<usize>>,
        [size, ratio]: [f64; 2],
    ) -> Option<Range<usize>> {
        let (mut best, mut most) = (None, 0.0);
        for stretch in stretches {
            if let Some([up, freedom]) = self.lever(&stretch)
                && up >= size * freedom
                && up * up > most * freedom
            {
                most = up * up / freedom;
                best = Some(stretch);
            }
        }
        best.filter(|stretch| self.rough_step(stretch).is_some_and(|step| step.ratio() >= ratio))
    }

    /// The sum of what is off the line in a stretch, and how much of a step the line cannot take: their ratio is the step.
    /// `None` where too little is in it or beside it, as in one that ends before it begins.
    fn lever(&self, stretch: &Range<usize>) -> Option<[f64; 2]> {
        let [n, _, _] = *self.sums.last()?;
        let [before, after] = [self.sums[stretch.start], self.sums[stretch.end]];
        let [n_in, x_in, up] = [0, 1, 2].map(|k| after[k] - before[k]);
        let enough = n_in >= LEAST_OF_STRETCH && n - n_in >= LEAST_OF_REST;
        enough.then(|| [up, n_in - n_in * n_in / n - x_in * x_in / self.squares[0]])
    }

    /// The step of a stretch as if slices were independent.
    pub(super) fn rough_step(&self, stretch: &Range<usize>) -> Option<Step> {
        let [up, freedom] = self.lever(stretch)?;
        let [n, _, _] = *self.sums.last()?;
        // Two of the line, the step and its two positions.
        let variance = ((self.squares[1] - up * up / freedom) / (n - 5.0)).max(self.floor * self.floor);
        Some(Step { size: up / freedom, deviation: (variance / freedom).sqrt() })
    }

    /// The step of a stretch, with neighbours that are alike.
    pub(super) fn step(&self, stretch: &Range<usize>) -> Option<Step> {
        let mut step = self.rough_step(stretch)?;
        let residuals: List<f64> = self.residuals(stretch, step.size).map(|(_, residual)| residual).collect();
        step.deviation /= independent_part(&residuals).sqrt();
        Some(step)
    }

    /// How far the upper quartile of a stretch is above its step: the face that leads up to the wide part of a collar is lower than it.
    pub(super) fn upper_part(&self, stretch: &Range<usize>, step: Step) -> f64 {
        let residuals = self.residuals(stretch, step.size).filter(|(slice, _)| stretch.contains(slice));
        let mut inside: List<f64> = residuals.map(|(_, residual)| residual).collect();
        let rank = inside.len().saturating_sub(1) * 3 / 4;
        if inside.is_empty() { 0.0 } else { *inside.select_nth_unstable_by(rank, f64::total_cmp).1 }
    }

    /// What is left of the slices that have a weight beside a line with a step, with their numbers.
    fn residuals(&self, stretch: &Range<usize>, step: f64) -> impl Iterator<Item = (usize, f64)> {
        let total = self.sums[self.slices.len()][0];
        let [before, after] = [self.sums[stretch.start], self.sums[stretch.end]];
        let [n_in, x_in] = [0, 1].map(|k| after[k] - before[k]);
        let full = self.slices.iter().enumerate().filter(|(_, [weight, _])| *weight > 0.0);
        full.map(move |(slice, [weight, _])| {
            let off = (self.sums[slice + 1][2] - self.sums[slice][2]) / weight;
            let inside = if stretch.contains(&slice) { 1.0 } else { 0.0 };
            let x = slice as f64 - self.mean;
            (slice, off - step * (inside - n_in / total - x * x_in / self.squares[0]))
        })
    }
}

/// A step with its standard deviation.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step {
    pub(super) size: f64,
    pub(super) deviation: f64,
}

impl Step {
    pub(super) fn ratio(&self) -> f64 {
        self.size / self.deviation
    }

    /// The weighted mean, at least as uncertain as the steps differ.
    pub(super) fn mean(steps: impl Iterator<Item = Self>) -> Option<Self> {
        let steps: List<Self> = steps.collect();
        let weight: f64 = steps.iter().map(|step| step.deviation.powi(-2)).sum();
        let sum: f64 = steps.iter().map(|step| step.size * step.deviation.powi(-2)).sum();
        let size = sum / weight;
        let differ = steps.iter().map(|step| (step.size - size).abs()).fold(0.0, f64::max);
        (!steps.is_empty()).then(|| Self { size, deviation: weight.sqrt().recip().max(differ) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::median;

    const SLICES: Slices = Slices { low: 0.0, length: 0.04, count: 50 };

    /// What is seen of a surface of radius 1 that is off by a function of the slice, with noise that slices do not share.
    fn profile(off: impl Fn(f64) -> f64) -> Profile {
        let noise = |k: usize| 0.004 * ((k * 7919 % 101) as f64 / 50.0 - 1.0);
        let seen: Vec<[f64; 2]> = (0..1000)
            .map(|k| {
                let slice = (k / 20) as f64;
                [(slice + 0.5) * SLICES.length, off(slice) + noise(k)]
            })
            .collect();
        Profile::new(&SLICES, &seen, (LEAST_SIGHTS, median), 1e-4).unwrap()
    }

    fn raised(profile: &Profile) -> Vec<(Range<usize>, Step)> {
        let stretches = profile.raised(25, [0.015, 4.0], 2);
        let step = |(k, stretch): (usize, &Range<usize>)| {
            Some((stretch.clone(), profile.without(&stretches, Some(k), 2)?.step(stretch)?))
        };
        let mut found: Vec<_> = stretches.iter().enumerate().filter_map(step).collect();
        found.sort_by_key(|(stretch, _)| stretch.start);
        found
    }

    #[test]
    fn steps_are_found_where_they_are_whatever_the_line() {
        for slope in [-2e-3, 0.0, 3e-3] {
            for collars in [
                &[[38_usize, 50]] as &[[usize; 2]],
                &[[0, 9]],
                &[[20, 27]],
                &[[8, 14], [30, 36]],
                &[[0, 5], [20, 26]],
            ] {
                let is_collar = |slice: f64| {
                    collars.iter().any(|[begin, end]| (*begin..*end).contains(&(slice as usize)))
                };
                let profile = profile(|slice| slope * slice + if is_collar(slice) { 0.03 } else { 0.0 });
                let found = raised(&profile);
                let stretches: Vec<_> =
                    found.iter().map(|(stretch, _)| [stretch.start, stretch.end]).collect();
                assert_eq!(stretches, collars);
                for (_, step) in found {
                    assert!(
                        (step.size - 0.03).abs() < 4.0 * step.deviation && step.ratio() > 12.0,
                        "{step:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn lines_and_waves_have_no_clear_step() {
        for waves in [0.0, 1.5, 2.5, 4.0] {
            let profile =
                profile(|slice| 2e-3 * slice + 0.02 * (waves * slice / 50.0 * std::f64::consts::TAU).sin());
            let found = raised(&profile);
            assert!(waves > 0.0 || found.is_empty(), "{found:?}");
            for (stretch, step) in found {
                assert!(step.ratio() < 13.0, "{waves}, {stretch:?}: {step:?}");
            }
        }
    }

    #[test]
    fn steps_of_two_sides_that_differ_are_uncertain() {
        let step = |size: f64| Step { size, deviation: 0.001 };
        let alike = Step::mean([step(0.03), step(0.03)].into_iter()).unwrap();
        let unlike = Step::mean([step(0.0), step(0.06)].into_iter()).unwrap();
        assert!(alike.ratio() > 40.0 && unlike.ratio() < 1.1, "{alike:?} {unlike:?}");
        assert!(Step::mean([].into_iter()).is_none());
    }
}
