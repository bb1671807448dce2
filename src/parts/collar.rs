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

/// Fewest sights of a slice, fewest slices, of a collar and of the rest, and the part of the slices that a side must have.
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

/// The collars at the ends against and along the axis, of what is seen between the ends that are known.
pub(super) fn collars(
    camera: &Camera,
    mask: &Mask,
    sights: &[Sight],
    cylinder: &Cylinder,
    ends: [Option<f64>; 2],
) -> [Option<Collar>; 2] {
    let mut found: [Option<Collar>; 2] = [None; 2];
    // One at a time, the clearest first: what a collar at one end leaves shows one at the other.
    let rest = |found: &[Option<Collar>; 2]| {
        [0, 1].map(|end| found[end].map(|collar| collar.position).or(ends[end]))
    };
    while let Some((end, collar)) = clearest(camera, mask, sights, cylinder, rest(&found))
        && found[end].is_none()
    {
        found[end] = Some(collar);
    }
    found
}

/// The clearest collar, and the number of its end.
fn clearest(
    camera: &Camera,
    mask: &Mask,
    sights: &[Sight],
    cylinder: &Cylinder,
    ends: [Option<f64>; 2],
) -> Option<(usize, Collar)> {
    let Cylinder { axis, radius } = cylinder;
    let margin = 2.0 * radius / SLICES_OF_RADIUS;
    let inside = |along: f64| {
        ends[0].is_none_or(|end| along > end + margin) && ends[1].is_none_or(|end| along < end - margin)
    };
    let seen = sights.iter().filter(|sight| sight.facing && sight.distance.abs() <= NEAR.get() * radius);
    let depth: List<[f64; 2]> = seen
        .map(|sight| [axis.position_of(&sight.point), sight.distance])
        .filter(|[along, _]| inside(*along))
        .collect();
    let alongs: List<f64> = depth.iter().map(|[along, _]| *along).collect();
    if alongs.len() < LEAST_SIGHTS * LEAST_SLICES {
        return None;
    }
    let [low, high] = at_both_ends(&alongs, (TRIM * alongs.len() as f64) as usize);
    let middle = f64::midpoint(low, high);
    let pixel = pixel_length(camera, cylinder, middle)?;
    let across = axis.at(middle).z * camera.pixel_size();
    let count = ((high - low) / (radius / SLICES_OF_RADIUS).max(LEAST_PIXELS * pixel)) as usize;
    if count < LEAST_SLICES {
        return None;
    }
    let slices = Slices { low, length: (high - low) / count as f64, count };
    let depth = Profile::new(&slices, depth.into_iter(), LEAST_SIGHTS, DEPTH_FLOOR.get() * radius)?;
    let floor = SIDES_FLOOR.get() * across;
    let sides = sides(camera, mask, cylinder).map(|side| Profile::new(&slices, side.into_iter(), 1, floor));
    let of_sides = |end: usize, slice: usize| {
        Step::mean(sides.iter().flatten().filter_map(|side| side.step(end, slice)))
    };
    let longest = (LONGEST.get() * count as f64) as usize;
    let places = [(0, 1..longest + 1), (1, count - longest..count)];
    let steps = places.into_iter().flat_map(|(end, slices)| slices.map(move |slice| (end, slice)));
    let steps = steps.filter_map(|(end, slice)| Some((end, slice, depth.step(end, slice)?)));
    let (end, slice, step) = steps.max_by(|a, b| a.2.ratio().total_cmp(&b.2.ratio()))?;
    let apart = (APART.get() * radius / slices.length) as usize;
    let near = slice.saturating_sub(apart).max(1)..(slice + apart + 1).min(count);
    let beside = near.filter_map(|slice| of_sides(end, slice)).max_by(|a, b| a.ratio().total_cmp(&b.ratio()));
    let agrees = |side: Step| {
        let part = side.size / step.size;
        side.ratio() >= SIDES_RATIO.get() && (AGREEMENT.get().recip()..AGREEMENT.get()).contains(&part)
    };
    let is_collar = step.size >= LEAST_STEP.get() * radius
        && (step.ratio() >= DEPTH_RATIO.get() && beside.is_some_and(agrees)
            || step.ratio() >= ALONE_RATIO.get() && beside.is_none_or(|side| side.ratio() > -2.0));
    let collar = Collar { position: low + slice as f64 * slices.length, radius: radius + step.size };
    is_collar.then_some((end, collar))
}

/// How far the rays of the outline of a mask pass beyond the surface on either side, with where along the axis they do.
fn sides(camera: &Camera, mask: &Mask, cylinder: &Cylinder) -> [List<[f64; 2]>; 2] {
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
    fn new(slices: &Slices, seen: impl Iterator<Item = [f64; 2]>, least: usize, floor: f64) -> Option<Self> {
        let mut values: List<List<f64>> = (0..slices.count).map(|_| List::new()).collect();
        for [along, value] in seen {
            let slice = (along - slices.low) / slices.length;
            if (0.0..slices.count as f64).contains(&slice) {
                values[slice as usize].push(value);
            }
        }
        let full = values.iter().filter(|values| values.len() >= least).count();
        if full < LEAST_SLICES || (full as f64) < LEAST_PART * slices.count as f64 {
            return None;
        }
        let all: usize = values.iter().map(|values| values.len()).sum();
        let mut sum = Sums::default();
        let (mut medians, mut sums) = (List::new(), List::from([sum]));
        for (slice, values) in values.iter_mut().enumerate() {
            // Weights of 1 in the mean.
            let weight = (values.len() * full) as f64 / all as f64;
            let found = (values.len() >= least).then(|| median(values));
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

    /// The step before a slice at an end that explains a line with a step best.
    fn step(&self, end: usize, slice: usize) -> Option<Step> {
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
        let residuals = self.medians.iter().enumerate().filter_map(|(x, median)| {
            let step = if (x < slice) == (end == 0) { solved[2] } else { 0.0 };
            Some((*median)? - (solved[0] + solved[1] * x as f64 + step))
        });
        let independent = independent_part(&residuals.collect::<List<f64>>());
        Some(Step { size: solved[2], deviation: (variance * inverse[(2, 2)] / independent).sqrt() })
    }
}

/// A step with its standard deviation.
#[derive(Clone, Copy)]
struct Step {
    size: f64,
    deviation: f64,
}

impl Step {
    fn ratio(&self) -> f64 {
        self.size / self.deviation
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
