//! Collars: lids, rims and beads that are a few per cent wider than the body whose end they close.
//!
//! Along the axis the depth is off the surface of a rough cylinder by a line: a constant where its radius is, a slope where its
//! axis is tilted. A collar adds a step, and so it does to the sides of the mask. Waves in the depth look like
//! steps, too, but not in depth and sides alike.

use super::{Sight, pixel_length};
use crate::camera::Camera;
use crate::geometry::Cylinder;
use crate::memory::List;
use crate::observations::Mask;
use crate::statistics::{at_both_ends, independent_part, median};
use nalgebra::{Matrix3, Vector2, Vector3};
use std::cell::{LazyCell, OnceCell};
use std::ops::Range;

constants! {
    /// Depth and sides farther from the surface are something else.
    NEAR = 0.25, "radius";

    /// A step at least: depth is off by as much beside an end.
    LEAST_STEP = 0.015, "radius";

    /// The step of the depth at least, where the sides show it as well, and where they do not contradict it.
    DEPTH_RATIO = 4.0, "σ";
    ALONE_RATIO = 12.0, "σ";

    /// The step of the sides at least.
    SIDES_RATIO = 4.0, "σ";

    /// The steps of depth and sides differ by this factor at most.
    AGREEMENT = 3.0, "";

    /// The sides show it within this length of where the depth does: the edge of a collar is an ellipse in the image.
    APART = 0.3, "radius";

    /// A step of the sides against that of the depth beyond this contradicts it.
    AGAINST = 2.0, "σ";

    /// What is left out beside an end that is known.
    MARGIN = 0.083, "radius";

    /// Standard deviation of a slice of the depth at least, and of one of a side.
    DEPTH_FLOOR = 0.002, "radius";
    SIDES_FLOOR = 0.2, "px";

    /// The longest collar, as a part of what is seen along the axis.
    LONGEST = 0.5, "";
}

/// How many slices are as long as the radius.
const SLICES_OF_RADIUS: f64 = 24.0;

/// The length of a slice in pixels at least: each has pixels of both sides then.
const LEAST_PIXELS: f64 = 1.5;

/// Fewest sights of a slice, fewest slices, fewest of a collar and of the rest by their weights, and the part of the slices that must be full.
const LEAST_SIGHTS: usize = 4;
const LEAST_SLICES: usize = 8;
const LEAST_OF_COLLAR: f64 = 2.0;
const LEAST_OF_REST: f64 = 4.0;
const LEAST_PART: f64 = 0.4;

/// The part of the sights at either end of the surface that is left out.
const TRIM: f64 = 0.005;

/// A lid or rim that is wider than the body.
#[derive(Debug, Clone, Copy)]
pub struct Collar {
    /// Where it begins, along the axis.
    pub position: f64,
    /// Its radius.
    pub radius: f64,
}

/// The collars at the ends against and along the axis, of what is seen between the ends that are known. Sights are so many pixels
/// apart.
pub(super) fn collars(
    camera: &Camera,
    mask: &Mask,
    (sights, apart): (&[Sight], usize),
    cylinder: &Cylinder,
    ends: [Option<f64>; 2],
) -> [Option<Collar>; 2] {
    let search = Search { camera, mask, cylinder, apart, sides: OnceCell::new() };
    let mut found = [None; 2];
    // One at a time, the clearest first: what a collar at one end leaves shows one at the other.
    while let Some((end, collar)) = search.clearest(sights, ends, &found) {
        found[end] = Some(collar);
    }
    found
}

/// Where collars are looked for.
struct Search<'a> {
    camera: &'a Camera,
    mask: &'a Mask,
    cylinder: &'a Cylinder,
    /// How many pixels the sights are apart.
    apart: usize,
    /// What [`sides_of`] tells, once it is asked for.
    sides: OnceCell<[List<[f64; 2]>; 2]>,
}

impl Search<'_> {
    /// The clearest collar at an end that has none yet, and the number of that end.
    fn clearest(
        &self,
        sights: &[Sight],
        ends: [Option<f64>; 2],
        found: &[Option<Collar>; 2],
    ) -> Option<(usize, Collar)> {
        let Cylinder { axis, radius } = self.cylinder;
        let [low, high] = [0, 1].map(|end| found[end].map(|collar: Collar| collar.position).or(ends[end]));
        // Beside the rim of a cap depth is rounded.
        let margin = MARGIN.get() * radius;
        let inside = |along: f64| {
            low.is_none_or(|end| along > end + margin) && high.is_none_or(|end| along < end - margin)
        };
        let seen = sights.iter().filter(|sight| sight.facing && sight.distance.abs() <= NEAR.get() * radius);
        let depth: List<[f64; 2]> = seen
            .map(|sight| [axis.position_of(&sight.point), sight.distance])
            .filter(|[along, _]| inside(*along))
            .collect();
        let slices = self.slices(&depth)?;
        let depth = Profile::new(&slices, &depth, LEAST_SIGHTS, DEPTH_FLOOR.get() * radius)?;
        // Most bodies have no step that they are asked about.
        let sides = LazyCell::new(|| {
            let seen = self.sides.get_or_init(|| sides_of(self.camera, self.mask, self.cylinder));
            let floor = SIDES_FLOOR.get() * self.camera.pixel_size() * axis.at(slices.middle()).z;
            seen.each_ref().map(|side| Profile::new(&slices, side, 1, floor))
        });
        let longest = (LONGEST.get() * slices.count as f64) as usize;
        let near = (APART.get() * radius / slices.length) as usize;
        let clearest = |(end, places): (usize, Range<usize>)| {
            let places = places.filter_map(|slice| Some((slice, depth.step(end, slice, DEPTH_RATIO.get())?)));
            let steps = places.filter(|(_, step)| step.size >= LEAST_STEP.get() * radius);
            let (slice, step) = steps.max_by(|a, b| a.1.ratio().total_cmp(&b.1.ratio()))?;
            let beside = slice.saturating_sub(near).max(1)..(slice + near + 1).min(slices.count);
            let of_sides = |slice| {
                Step::mean(sides.iter().flatten().filter_map(|side| side.step(end, slice, f64::NEG_INFINITY)))
            };
            let of_sides = beside.filter_map(of_sides).max_by(|a, b| a.ratio().total_cmp(&b.ratio()));
            step.is_confirmed(of_sides).then_some((end, slice, step))
        };
        let places = [(0, 1..longest + 1), (1, slices.count - longest..slices.count)];
        let free = places.into_iter().filter(|(end, _)| found[*end].is_none());
        let (end, slice, step) =
            free.filter_map(clearest).max_by(|a, b| a.2.ratio().total_cmp(&b.2.ratio()))?;
        let position = slices.low + slice as f64 * slices.length;
        Some((end, Collar { position, radius: radius + step.size }))
    }

    /// Slices of the part of the axis along which the depth shows the surface; `None` for too few.
    fn slices(&self, depth: &[[f64; 2]]) -> Option<Slices> {
        let alongs: List<f64> = depth.iter().map(|[along, _]| *along).collect();
        if alongs.len() < LEAST_SIGHTS * LEAST_SLICES {
            return None;
        }
        let [low, high] = at_both_ends(&alongs, (TRIM * alongs.len() as f64) as usize);
        let pixel = pixel_length(self.camera, self.cylinder, f64::midpoint(low, high))?;
        let shortest = LEAST_PIXELS.max(self.apart as f64) * pixel;
        let count = ((high - low) / (self.cylinder.radius / SLICES_OF_RADIUS).max(shortest)) as usize;
        // More slices than the sights can fill are none.
        let most = alongs.len() as f64 / (LEAST_PART * LEAST_SIGHTS as f64);
        let enough = count >= LEAST_SLICES && count as f64 <= most;
        enough.then(|| Slices { low, length: (high - low) / count as f64, count })
    }
}

/// How far the rays of the outline of a mask pass beyond the surface on either side, with where along the axis they do.
fn sides_of(camera: &Camera, mask: &Mask, cylinder: &Cylinder) -> [List<[f64; 2]>; 2] {
    let Cylinder { axis, radius } = cylinder;
    let mut sides: [List<[f64; 2]>; 2] = Default::default();
    for &(column, row) in mask.outline() {
        // Where the border of the image cuts the mask off is no side.
        if column == 0 || row == 0 || column + 1 == mask.width() || row + 1 == mask.height() {
            continue;
        }
        let Some(ray) = camera.unproject(&Vector2::new(column as f64, row as f64)) else { continue };
        let normal = ray.cross(&axis.direction);
        let across = normal.dot(&axis.point) / normal.norm();
        let beyond = across.abs() - radius;
        if beyond.abs() <= NEAR.get() * radius {
            let along = axis.position_of(&(ray * axis.nearest_on_ray(&ray)));
            sides[usize::from(across > 0.0)].push([along, beyond]);
        }
    }
    sides
}

/// Slices of the axis.
struct Slices {
    low: f64,
    length: f64,
    count: usize,
}

impl Slices {
    fn middle(&self) -> f64 {
        self.low + 0.5 * self.length * self.count as f64
    }
}

/// Sums over slices of 1, x, x², y, xy and y², by their weights, of the number x of a slice and what is seen there.
type Sums = [f64; 6];

/// What is seen along the axis: its medians by slice, `None` of those that hold too little, the sums of all slices before
/// each one, and the least deviation of one.
struct Profile {
    medians: List<Option<f64>>,
    sums: List<Sums>,
    floor: f64,
}

impl Profile {
    /// The medians of the slices that hold enough; `None` where too few do.
    fn new(slices: &Slices, seen: &[[f64; 2]], least: usize, floor: f64) -> Option<Self> {
        let mut values: List<List<f64>> = (0..slices.count).map(|_| List::new()).collect();
        for [along, value] in seen {
            let slice = (along - slices.low) / slices.length;
            if (0.0..slices.count as f64).contains(&slice) {
                values[slice as usize].push(*value);
            }
        }
        let is_full = |values: &List<f64>| values.len() >= least;
        let full = values.iter().filter(|values| is_full(values)).count();
        if full < LEAST_SLICES || (full as f64) < LEAST_PART * slices.count as f64 {
            return None;
        }
        let all: usize = values.iter().filter(|values| is_full(values)).map(|values| values.len()).sum();
        let mut sum = Sums::default();
        let (mut medians, mut sums) = (List::new(), List::from([sum]));
        for (slice, values) in values.iter_mut().enumerate() {
            // Weights of 1 in the mean.
            let weight = (values.len() * full) as f64 / all as f64;
            let found = is_full(values).then(|| median(values));
            if let Some(y) = found {
                let x = slice as f64;
                let terms = [1.0, x, x * x, y, x * y, y * y];
                sum = [0, 1, 2, 3, 4, 5].map(|k| sum[k] + weight * terms[k]);
            }
            medians.push(found);
            sums.push(sum);
        }
        Some(Self { medians, sums, floor })
    }

    /// The step before a slice at an end that explains a line with a step best; `None` where too little is on either side of it, or its
    /// ratio is less than so much even if the slices are independent.
    fn step(&self, end: usize, slice: usize, least: f64) -> Option<Step> {
        let all = *self.sums.last()?;
        let before = self.sums[slice];
        let after = [0, 1, 2, 3, 4, 5].map(|k| all[k] - before[k]);
        let [collar, rest] = if end == 0 { [before, after] } else { [after, before] };
        if collar[0] < LEAST_OF_COLLAR || rest[0] < LEAST_OF_REST {
            return None;
        }
        let [n, x, xx, y, xy, yy] = all;
        let [n_c, x_c, _, y_c, _, _] = collar;
        let inverse = Matrix3::new(n, x, n_c, x, xx, x_c, n_c, x_c, n_c).try_inverse()?;
        let right = Vector3::new(y, xy, y_c);
        let solved = inverse * right;
        // Two of the line, the step and its place.
        let variance = ((yy - solved.dot(&right)) / (n - 4.0)).max(self.floor * self.floor);
        let mut step = Step { size: solved[2], deviation: (variance * inverse[(2, 2)]).sqrt() };
        if step.ratio() < least {
            return None;
        }
        let residuals = self.medians.iter().enumerate().filter_map(|(x, median)| {
            let step = if (x < slice) == (end == 0) { solved[2] } else { 0.0 };
            Some((*median)? - (solved[0] + solved[1] * x as f64 + step))
        });
        step.deviation /= independent_part(&residuals.collect::<List<f64>>()).sqrt();
        (step.ratio() >= least).then_some(step)
    }
}

/// A step with its standard deviation.
#[derive(Debug, Clone, Copy)]
struct Step {
    size: f64,
    deviation: f64,
}

impl Step {
    fn ratio(&self) -> f64 {
        self.size / self.deviation
    }

    /// Whether a step of the depth is that of a collar, by the clearest one of the sides near it.
    fn is_confirmed(&self, sides: Option<Self>) -> bool {
        let agrees = |side: Self| {
            let part = side.size / self.size;
            side.ratio() >= SIDES_RATIO.get() && (AGREEMENT.get().recip()..AGREEMENT.get()).contains(&part)
        };
        let alone = self.ratio() >= ALONE_RATIO.get();
        sides.is_some_and(agrees) || alone && sides.is_none_or(|side| side.ratio() > -AGAINST.get())
    }

    /// The weighted mean, at least as uncertain as the steps differ.
    fn mean(steps: impl Iterator<Item = Self>) -> Option<Self> {
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
        Profile::new(&SLICES, &seen, LEAST_SIGHTS, 1e-4).unwrap()
    }

    fn clearest(profile: &Profile, end: usize) -> (usize, Step) {
        let steps = (1..50).filter_map(|slice| Some((slice, profile.step(end, slice, f64::NEG_INFINITY)?)));
        steps.max_by(|a, b| a.1.ratio().total_cmp(&b.1.ratio())).unwrap()
    }

    #[test]
    fn a_step_is_found_where_it_is_whatever_the_line() {
        for slope in [-2e-3, 0.0, 3e-3] {
            for (end, begins) in [(1, 38), (0, 9)] {
                let is_collar = |slice: f64| (slice < f64::from(begins)) == (end == 0);
                let profile = profile(|slice| slope * slice + if is_collar(slice) { 0.03 } else { 0.0 });
                let (slice, step) = clearest(&profile, end);
                assert_eq!(slice, begins as usize);
                assert!((step.size - 0.03).abs() < 4.0 * step.deviation && step.ratio() > 12.0, "{step:?}");
            }
        }
    }

    #[test]
    fn lines_and_waves_have_no_clear_step() {
        for waves in [0.0, 1.5, 2.5, 4.0] {
            let profile =
                profile(|slice| 2e-3 * slice + 0.02 * (waves * slice / 50.0 * std::f64::consts::TAU).sin());
            for end in [0, 1] {
                let (slice, step) = clearest(&profile, end);
                assert!(step.ratio() < ALONE_RATIO.get(), "{waves}, {slice}: {step:?}");
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
        let depth = step(0.03);
        assert!(depth.is_confirmed(None) && !Step { deviation: 0.005, ..depth }.is_confirmed(None));
        assert!(
            Step { deviation: 0.005, ..depth }.is_confirmed(Some(alike))
                && !depth.is_confirmed(Some(step(-0.01)))
        );
    }
}
