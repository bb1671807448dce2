//! Collars: lids, rims, rings, clamps and flanges that are wider than the body about which they lie.
//!
//! Along the axis the depth is off the surface of a rough cylinder by a line: a constant where its radius is, a slope where its
//! axis is tilted. A collar is a stretch that lies above that line, in the depth and in the sides of the mask. Waves in the depth look
//! like that, too, but not in depth and sides alike.

use super::{Sight, pixel_length};
use crate::camera::Camera;
use crate::geometry::Cylinder;
use crate::memory::List;
use crate::observations::Mask;
use crate::statistics::{at_both_ends, independent_part, median};
use nalgebra::Vector2;
use std::ops::Range;

constants! {
    /// Depth and sides farther within the surface are something else, and so are those farther beyond it.
    NEAR = 0.25, "radius";
    WIDEST = 0.8, "radius";

    /// A step at least: depth is off by as much beside an end.
    LEAST_STEP = 0.015, "radius";

    /// The step of the depth at least, where the sides show it as well, and at an end where they do not contradict it.
    DEPTH_RATIO = 4.0, "σ";
    ALONE_RATIO = 13.0, "σ";

    /// The step of the sides at least, and that of both together.
    SIDES_RATIO = 4.0, "σ";
    BOTH_RATIO = 8.0, "σ";

    /// The steps of depth and sides differ by this factor at most.
    AGREEMENT = 2.0, "";

    /// A collar so near to an end closes it.
    BESIDE_END = 0.3, "radius";

    /// Steps of depth and sides that differ by more contradict each other.
    AGAINST = 3.0, "σ";

    /// What is left out beside an end that is known, and beside collars, of these whole slices only.
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

/// A stretch along the axis that is wider than the body.
#[derive(Debug, Clone, Copy)]
pub struct Collar {
    /// Where it begins and ends along the axis; infinite where an end of the body is within it.
    pub stretch: [f64; 2],
    /// Its radius.
    pub radius: f64,
}

/// The collars of what is seen between the ends that are known. Sights are so many pixels apart.
pub(super) fn collars(
    camera: &Camera,
    mask: &Mask,
    (sights, apart): (&[Sight], usize),
    cylinder: &Cylinder,
    ends: [Option<f64>; 2],
) -> Option<List<Collar>> {
    let Cylinder { axis, radius } = cylinder;
    let [low, high] = ends;
    // Beside the rim of a cap depth is rounded.
    let margin = MARGIN.get() * radius;
    let inside = |along: f64| {
        low.is_none_or(|end| along > end + margin) && high.is_none_or(|end| along < end - margin)
    };
    let depth: List<[f64; 2]> = sights
        .iter()
        .filter(|sight| sight.facing && is_near(sight.distance, *radius))
        .map(|sight| [axis.position_of(&sight.point), sight.distance])
        .filter(|[along, _]| inside(*along))
        .collect();
    let slices = Slices::new(camera, cylinder, apart, &depth)?;
    let depth = Profile::new(&slices, &depth, LEAST_SIGHTS, DEPTH_FLOOR.get() * radius)?;
    let least = LEAST_STEP.get() * radius;
    let [margin, near] = [(margin / slices.length) as usize, slices.near_end(*radius)];
    let stretches = depth.raised(slices.longest(), least, margin);
    if stretches.is_empty() {
        return None;
    }
    // Most bodies have no step that they are asked about.
    let middle = axis.at(slices.middle());
    let floor = SIDES_FLOOR.get() * camera.pixel_size() * middle.z;
    let sides = sides_of(camera, mask, cylinder).map(|side| Profile::new(&slices, &side, 1, floor));
    let lean =
        axis.direction.dot(&middle).abs() / axis.direction.cross(&middle).norm().max(f64::MIN_POSITIVE);
    let found = stretches.iter().enumerate().filter_map(|(k, stretch)| {
        let step = depth.without(&stretches, Some(k), margin)?.step(stretch)?;
        if stretch.len() > slices.longest() || step.size < least || step.ratio() < DEPTH_RATIO.get() {
            return None;
        }
        // The edge of a collar is an ellipse in the image, which begins elsewhere at the sides than in the middle.
        let wider = step.size / radius;
        let moved = radius * (MARGIN.get() + lean * (wider * (2.0 + wider)).sqrt());
        let moved = ((moved / slices.length) as usize).min(slices.count);
        let sides: List<Profile> =
            sides.iter().flatten().filter_map(|side| side.without(&stretches, Some(k), moved)).collect();
        let of_sides = step_of_sides(&sides, &slices, stretch, moved);
        let collar = Collar { stretch: slices.along(stretch, near), radius: radius + step.size };
        let at_end = collar.stretch.iter().any(|place| place.is_infinite());
        step.is_confirmed(of_sides, at_end).then_some(collar)
    });
    Some(found.collect())
}

/// The clearest step of the sides in a stretch that begins and ends so near to another.
fn step_of_sides(sides: &[Profile], slices: &Slices, stretch: &Range<usize>, near: usize) -> Option<Step> {
    let mean = |step: fn(&Profile, &Range<usize>) -> Option<Step>, stretch: &Range<usize>| {
        Step::mean(sides.iter().filter_map(|side| step(side, stretch)))
    };
    let stretches = slices
        .beside(stretch.start, near)
        .flat_map(|start| slices.beside(stretch.end, near).map(move |end| start..end));
    let (_, clearest) = stretches
        .filter_map(|stretch| Some((mean(Profile::rough_step, &stretch)?.ratio(), stretch)))
        .max_by(|a, b| a.0.total_cmp(&b.0))?;
    mean(Profile::step, &clearest)
}

/// Whether what is so far from the surface belongs to the body or a collar.
fn is_near(distance: f64, radius: f64) -> bool {
    (-NEAR.get() * radius..=WIDEST.get() * radius).contains(&distance)
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
        if is_near(beyond, *radius) {
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
    /// Slices of the part of the axis along which the depth shows the surface; `None` for too few.
    fn new(camera: &Camera, cylinder: &Cylinder, apart: usize, depth: &[[f64; 2]]) -> Option<Self> {
        let alongs: List<f64> = depth.iter().map(|[along, _]| *along).collect();
        if alongs.len() < LEAST_SIGHTS * LEAST_SLICES {
            return None;
        }
        let [low, high] = at_both_ends(&alongs, (TRIM * alongs.len() as f64) as usize);
        let pixel = pixel_length(camera, cylinder, f64::midpoint(low, high))?;
        let shortest = LEAST_PIXELS.max(apart as f64) * pixel;
        let count = ((high - low) / (cylinder.radius / SLICES_OF_RADIUS).max(shortest)) as usize;
        // More slices than the sights can fill are none.
        let most = alongs.len() as f64 / (LEAST_PART * LEAST_SIGHTS as f64);
        let enough = count >= LEAST_SLICES && count as f64 <= most;
        enough.then(|| Self { low, length: (high - low) / count as f64, count })
    }

    /// How many slices a collar has at most.
    fn longest(&self) -> usize {
        (LONGEST.get() * self.count as f64) as usize
    }

    fn middle(&self) -> f64 {
        self.low + 0.5 * self.length * self.count as f64
    }

    /// The places so near to one; what is at an end stays there.
    fn beside(&self, place: usize, near: usize) -> Range<usize> {
        if place == 0 || place == self.count {
            return place..place + 1;
        }
        place.saturating_sub(near).max(1)..(place + near + 1).min(self.count)
    }

    /// How near to an end a collar closes it: of a short body an eighth.
    fn near_end(&self, radius: f64) -> usize {
        ((BESIDE_END.get() * radius / self.length) as usize).min(self.count / 8)
    }

    /// Where a stretch of them begins and ends along the axis; infinite beside an end.
    fn along(&self, stretch: &Range<usize>, near: usize) -> [f64; 2] {
        let at = |place: usize| self.low + place as f64 * self.length;
        let begin = if stretch.start <= near { f64::NEG_INFINITY } else { at(stretch.start) };
        let end = if stretch.end + near >= self.count { f64::INFINITY } else { at(stretch.end) };
        [begin, end]
    }
}

/// What is seen along the axis, off a line of it.
#[derive(Clone)]
struct Profile {
    /// The weight and the median of each slice; no weight where it holds too little.
    slices: List<[f64; 2]>,
    /// The weights of all slices before each one, and their sums with the place of a slice, from the mean place, and with how far it is off the line.
    sums: List<[f64; 3]>,
    /// The sums with the squares of these.
    squares: [f64; 2],
    /// The mean place.
    place: f64,
    /// The least deviation of a slice.
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
        if (full as f64) < LEAST_PART * slices.count as f64 {
            return None;
        }
        let all: usize = values.iter().filter(|values| is_full(values)).map(|values| values.len()).sum();
        // Weights of 1 in the mean.
        let slice = |values: &mut List<f64>| match is_full(values) {
            true => [(values.len() * full) as f64 / all as f64, median(values)],
            false => [0.0; 2],
        };
        Self::off_a_line(values.iter_mut().map(slice).collect(), floor)
    }

    /// The same without stretches, but that of one number, and so many slices beside them.
    fn without(&self, stretches: &[Range<usize>], but: Option<usize>, margin: usize) -> Option<Self> {
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
        let [place, level] = [weighted(|x, _| x) / n, weighted(|_, y| y) / n];
        let squares = weighted(|x, _| x * x) - n * place * place;
        let slope = (weighted(|x, y| x * y) - n * place * level) / squares;
        let mut profile =
            Self { sums: List::from([[0.0; 3]]), squares: [squares, 0.0], place, floor, slices };
        let mut sum = [0.0; 3];
        for (x, [weight, y]) in profile.slices.iter().enumerate() {
            let x = x as f64 - place;
            let off = y - level - slope * x;
            let terms = [1.0, x, off];
            sum = [0, 1, 2].map(|k| sum[k] + weight * terms[k]);
            profile.sums.push(sum);
            profile.squares[1] += weight * off * off;
        }
        Some(profile)
    }

    /// The stretches that may be above a line, farther apart than a margin.
    fn raised(&self, longest: usize, least: f64, margin: usize) -> List<Range<usize>> {
        let mut stretches: List<Range<usize>> = List::new();
        let mut rest = Some(self.clone());
        // The clearest first: what one leaves shows another.
        while let Some(mut stretch) = rest.as_ref().and_then(|rest| rest.clearest(longest, least)) {
            // What is beside one belongs to it.
            stretches.retain(|other| {
                let apart = stretch.end + margin < other.start || other.end + margin < stretch.start;
                if !apart {
                    stretch = stretch.start.min(other.start)..stretch.end.max(other.end);
                }
                apart
            });
            stretches.push(stretch);
            rest = self.without(&stretches, None, margin);
        }
        stretches
    }

    /// The stretch whose step up from a line beside it explains most, if it has a step of this size; `None` where its ratio is
    /// too small even if the slices are independent.
    fn clearest(&self, longest: usize, least: f64) -> Option<Range<usize>> {
        // It begins and ends with slices that are above the line.
        let above = |slice: &usize| self.sums[slice + 1][2] > self.sums[*slice][2];
        let (mut best, mut most) = (None, 0.0);
        for start in (0..self.slices.len()).filter(above) {
            for last in (start..self.slices.len().min(start + longest)).filter(above) {
                if let Some([up, freedom]) = self.lever(&(start..last + 1))
                    && up >= least * freedom
                    && up * up > most * freedom
                {
                    most = up * up / freedom;
                    best = Some(start..last + 1);
                }
            }
        }
        best.filter(|stretch| self.rough_step(stretch).is_some_and(|step| step.ratio() >= DEPTH_RATIO.get()))
    }

    /// The sum of what is off the line in a stretch, and how much of a step the line cannot take: their ratio is the step.
    /// `None` where too little is in it or beside it, as in one that ends before it begins.
    fn lever(&self, stretch: &Range<usize>) -> Option<[f64; 2]> {
        let [n, _, _] = *self.sums.last()?;
        let [before, after] = [self.sums[stretch.start], self.sums[stretch.end]];
        let [n_in, x_in, up] = [0, 1, 2].map(|k| after[k] - before[k]);
        let enough = n_in >= LEAST_OF_COLLAR && n - n_in >= LEAST_OF_REST;
        enough.then(|| [up, n_in - n_in * n_in / n - x_in * x_in / self.squares[0]])
    }

    /// The step of a stretch as if slices were independent.
    fn rough_step(&self, stretch: &Range<usize>) -> Option<Step> {
        let [up, freedom] = self.lever(stretch)?;
        let [n, _, _] = *self.sums.last()?;
        // Two of the line, the step and its two places.
        let variance = ((self.squares[1] - up * up / freedom) / (n - 5.0)).max(self.floor * self.floor);
        Some(Step { size: up / freedom, deviation: (variance / freedom).sqrt() })
    }

    /// The step of a stretch, with neighbours that are alike.
    fn step(&self, stretch: &Range<usize>) -> Option<Step> {
        let mut step = self.rough_step(stretch)?;
        let [n, _, _] = *self.sums.last()?;
        let [before, after] = [self.sums[stretch.start], self.sums[stretch.end]];
        let [n_in, x_in] = [0, 1].map(|k| after[k] - before[k]);
        let full = self.slices.iter().enumerate().filter(|(_, [weight, _])| *weight > 0.0);
        let residuals = full.map(|(slice, [weight, _])| {
            let off = (self.sums[slice + 1][2] - self.sums[slice][2]) / weight;
            let inside = if stretch.contains(&slice) { 1.0 } else { 0.0 };
            let x = slice as f64 - self.place;
            off - step.size * (inside - n_in / n - x * x_in / self.squares[0])
        });
        step.deviation /= independent_part(&residuals.collect::<List<f64>>()).sqrt();
        Some(step)
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

    /// Whether a step of the depth, at an end or not, is that of a collar, by the clearest one of the sides near it.
    fn is_confirmed(&self, sides: Option<Self>, at_end: bool) -> bool {
        let agrees = |side: Self| {
            let part = side.size / self.size;
            side.ratio() >= SIDES_RATIO.get()
                && self.ratio().hypot(side.ratio()) >= BOTH_RATIO.get()
                && (AGREEMENT.get().recip()..AGREEMENT.get()).contains(&part)
        };
        let contradicts =
            |side: Self| (side.size - self.size).abs() > AGAINST.get() * self.deviation.hypot(side.deviation);
        let alone = at_end && self.ratio() >= ALONE_RATIO.get();
        sides.is_some_and(agrees) || alone && !sides.is_some_and(contradicts)
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

    fn raised(profile: &Profile) -> Vec<(Range<usize>, Step)> {
        let stretches = profile.raised(25, 0.015, 2);
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
                assert!(step.ratio() < ALONE_RATIO.get(), "{waves}, {stretch:?}: {step:?}");
            }
        }
    }

    /// The ring in the middle of a short body was taken for a lid at both of its ends.
    #[test]
    fn a_collar_closes_the_end_that_it_is_at() {
        let slices = Slices { low: 0.0, length: 1.0, count: 20 };
        let near = slices.near_end(SLICES_OF_RADIUS);
        assert_eq!(slices.along(&(7..14), near), [7.0, 14.0]);
        assert_eq!(slices.along(&(1..9), near), [f64::NEG_INFINITY, 9.0]);
        assert_eq!(slices.along(&(12..19), near), [12.0, f64::INFINITY]);
    }

    #[test]
    fn steps_of_two_sides_that_differ_are_uncertain() {
        let step = |size: f64| Step { size, deviation: 0.001 };
        let alike = Step::mean([step(0.03), step(0.03)].into_iter()).unwrap();
        let unlike = Step::mean([step(0.0), step(0.06)].into_iter()).unwrap();
        assert!(alike.ratio() > 40.0 && unlike.ratio() < 1.1, "{alike:?} {unlike:?}");
        assert!(Step::mean([].into_iter()).is_none());
        let depth = step(0.03);
        assert!(
            depth.is_confirmed(None, true) && !Step { deviation: 0.005, ..depth }.is_confirmed(None, true)
        );
        assert!(
            Step { deviation: 0.005, ..depth }.is_confirmed(Some(alike), false)
                && !depth.is_confirmed(Some(step(-0.01)), true)
                && !depth.is_confirmed(None, false)
        );
    }
}
