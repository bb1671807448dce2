//! Collars: lids, rims, rings, clamps and flanges that are wider than the body about which they lie.
//!
//! Along the axis the depth is off the surface of a rough cylinder by a line: a constant where its radius is, a slope where its
//! axis is tilted. A collar is a stretch that lies above that line, in the depth and in the sides of the mask. Waves in the depth look
//! like that, too, but not in depth and sides alike.

use super::Sight;
use super::profile::{LEAST_SIGHTS, Profile, Slices, Step};
use crate::camera::Camera;
use crate::geometry::Cylinder;
use crate::memory::List;
use crate::observations::Mask;
use crate::statistics::median;
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
    pub(super) ALONE_RATIO = 13.0, "σ";

    /// The step of the sides at least, and that of both together.
    SIDES_RATIO = 4.0, "σ";
    BOTH_RATIO = 8.0, "σ";

    /// The steps of depth and sides differ by this factor at most.
    AGREEMENT = 2.0, "";

    /// Something narrower that follows the body is so long at least: beside an end depth and masks are rounded.
    NARROWER = 0.5, "radius";

    /// A collar so near to an end closes it.
    BESIDE_END = 0.3, "radius";

    /// Steps of depth and sides that differ by more contradict each other.
    AGAINST = 3.0, "σ";

    /// What is left out beside an end that is known, and beside collars, of these whole slices only.
    MARGIN = 0.083, "radius";

    /// Standard deviation of a slice of the depth at least, and of one of a side.
    pub(super) DEPTH_FLOOR = 0.002, "radius";
    SIDES_FLOOR = 0.2, "px";

    /// The longest collar, as a part of what is seen along the axis.
    LONGEST = 0.5, "";
}

/// A stretch along the axis that is wider than the body.
#[derive(Debug, Clone, Copy)]
pub struct Collar {
    /// Where it begins and ends along the axis; infinite where an end of the body is within it.
    pub stretch: [f64; 2],
    /// Its radius.
    pub radius: f64,
}

impl Collar {
    /// Whether it closes an end: 0 the one against the axis, 1 the one along it.
    #[must_use]
    pub fn closes(&self, end: usize) -> bool {
        self.stretch[end].is_infinite()
    }
}

/// The collars of what is seen between the ends that are known, and these ends: where the body is followed by something narrower
/// in line with it, such as the cap of a spray can, it ends there. Sights are so many pixels apart.
pub(super) fn collars(
    camera: &Camera,
    mask: &Mask,
    (sights, apart): (&[Sight], usize),
    cylinder: &Cylinder,
    ends: [Option<f64>; 2],
) -> Option<(List<Collar>, [Option<f64>; 2])> {
    let radius = cylinder.radius;
    let depth = depth_between(ends, sights, cylinder);
    let slices = Slices::new(camera, cylinder, apart, &depth)?;
    let depth = Profile::new(&slices, &depth, (LEAST_SIGHTS, median), DEPTH_FLOOR.get() * radius)?;
    let stretches = depth.raised(longest(&slices), least_step(radius), margin(&slices, radius));
    let negated = depth.clone().negated();
    let lowered = lowered_at_end(&slices, [&depth, &negated], &stretches, radius);
    if stretches.is_empty() && lowered.is_none() {
        return None;
    }
    // Most bodies have no step that they are asked about.
    let steps = Steps::new(camera, mask, cylinder, slices, depth);
    if let Some(lowered) = lowered
        && let Some(ends) = steps.ends_beside_narrower(&negated, &lowered, ends)
    {
        let of_body = collars(camera, mask, (sights, apart), cylinder, ends);
        return of_body.or_else(|| Some((List::new(), ends)));
    }
    let found = (0..stretches.len()).filter_map(|k| steps.collar(&stretches, k));
    Some((found.collect(), ends))
}

/// How far the depth between the ends that are known is from the surface, with where along the axis it is.
fn depth_between([low, high]: [Option<f64>; 2], sights: &[Sight], cylinder: &Cylinder) -> List<[f64; 2]> {
    let Cylinder { axis, radius } = cylinder;
    // Beside the rim of a cap depth is rounded.
    let margin = MARGIN.get() * radius;
    let inside = |along: f64| {
        low.is_none_or(|end| along > end + margin) && high.is_none_or(|end| along < end - margin)
    };
    sights
        .iter()
        .filter(|sight| sight.facing && is_near(sight.distance, *radius))
        .map(|sight| [axis.position_of(&sight.point), sight.distance])
        .filter(|[along, _]| inside(*along))
        .collect()
}

/// The stretch at an end that may be narrower than the body, if that explains more of the depth than any collar between the ends; the
/// depth is given as it is and negated.
fn lowered_at_end(
    slices: &Slices,
    [depth, negated]: [&Profile; 2],
    stretches: &[Range<usize>],
    radius: f64,
) -> Option<Range<usize>> {
    // A coupling in the middle of a pipe makes its ends look narrower.
    let near = near_end(slices, radius);
    let is_inside = |stretch: &&Range<usize>| slices.along(stretch, near).iter().all(|at| at.is_finite());
    let raised =
        stretches.iter().filter(is_inside).map(|stretch| depth.explained(stretch)).fold(0.0, f64::max);
    let shortest = (NARROWER.get() * radius / slices.length) as usize + 1;
    let lowered = negated.raised_at_end(shortest..longest(slices) + 1, least_step(radius));
    lowered.filter(|stretch| negated.explained(stretch) > raised)
}

/// What tells whether a step of the depth is one of the body.
struct Steps<'a> {
    cylinder: &'a Cylinder,
    slices: Slices,
    depth: Profile,
    /// How far the sides of the mask are beyond the surface; `None` for one that shows too little.
    sides: [Option<Profile>; 2],
    /// By how much the axis leads away from the camera for each unit of length across the line of sight.
    lean: f64,
}

impl<'a> Steps<'a> {
    fn new(camera: &Camera, mask: &Mask, cylinder: &'a Cylinder, slices: Slices, depth: Profile) -> Self {
        let axis = &cylinder.axis;
        let middle = axis.at(slices.middle());
        let floor = SIDES_FLOOR.get() * camera.pixel_size() * middle.z;
        let sides =
            sides_of(camera, mask, cylinder).map(|side| Profile::new(&slices, &side, (1, outermost), floor));
        let lean =
            axis.direction.dot(&middle).abs() / axis.direction.cross(&middle).norm().max(f64::MIN_POSITIVE);
        Self { cylinder, slices, depth, sides, lean }
    }

    /// So many slices before or after it a step of the depth may begin at the sides: the edge of a collar is an ellipse in the image,
    /// which begins elsewhere there than in the middle.
    fn moved(&self, step: Step) -> usize {
        let radius = self.cylinder.radius;
        let wider = step.size / radius;
        let moved = radius * (MARGIN.get() + self.lean * (wider * (2.0 + wider)).sqrt());
        ((moved / self.slices.length) as usize).min(self.slices.count)
    }

    /// The ends of the body where a stretch at one end is narrower than it, by the negated depth; `None` where it is not.
    fn ends_beside_narrower(
        &self,
        negated: &Profile,
        lowered: &Range<usize>,
        [low, high]: [Option<f64>; 2],
    ) -> Option<[Option<f64>; 2]> {
        let step = negated.step(lowered)?;
        let sides: List<Profile> = self.sides.iter().flatten().map(|side| side.clone().negated()).collect();
        let of_sides = step_of_sides(&sides, &self.slices, lowered, self.moved(step));
        let is_narrower = step.ratio() >= DEPTH_RATIO.get() && is_confirmed(step, of_sides, true);
        let [begin, end] = self.slices.along(lowered, 0);
        let at_start = begin.is_infinite();
        is_narrower.then_some(if at_start { [Some(end), high] } else { [low, Some(begin)] })
    }

    /// The collar at one of the stretches that are raised; `None` where it is none.
    fn collar(&self, stretches: &[Range<usize>], k: usize) -> Option<Collar> {
        let Self { slices, .. } = self;
        let (radius, stretch) = (self.cylinder.radius, &stretches[k]);
        let depth = self.depth.without(stretches, Some(k), margin(slices, radius))?;
        let step = depth.step(stretch)?;
        let [least_size, least_ratio] = least_step(radius);
        if stretch.len() > longest(slices) || step.size < least_size || step.ratio() < least_ratio {
            return None;
        }
        let moved = self.moved(step);
        let sides = self.sides.iter().flatten();
        let sides: List<Profile> = sides.filter_map(|side| side.without(stretches, Some(k), moved)).collect();
        let of_sides = step_of_sides(&sides, slices, stretch, moved);
        // Of a thin collar the depth shows the face more than the rim.
        let of_rim = of_sides.filter(|side| agrees(step, *side)).map_or(0.0, |side| side.size);
        let wider = of_rim.max(step.size + depth.upper_part(stretch, step));
        let along = slices.along(stretch, near_end(slices, radius));
        let collar = Collar { stretch: along, radius: radius + wider };
        let at_end = [0, 1].iter().any(|end| collar.closes(*end));
        is_confirmed(step, of_sides, at_end).then_some(collar)
    }
}

/// The size and the ratio of a step of the depth at least.
pub(super) fn least_step(radius: f64) -> [f64; 2] {
    [LEAST_STEP.get() * radius, DEPTH_RATIO.get()]
}

/// How many whole slices are left out beside collars.
fn margin(slices: &Slices, radius: f64) -> usize {
    (MARGIN.get() * radius / slices.length) as usize
}

/// How many slices a collar has at most.
fn longest(slices: &Slices) -> usize {
    (LONGEST.get() * slices.count as f64) as usize
}

/// How near to an end a collar closes it, in slices: of a short body an eighth.
fn near_end(slices: &Slices, radius: f64) -> usize {
    ((BESIDE_END.get() * radius / slices.length) as usize).min(slices.count / 8)
}

/// Whether a step of a side is that of the depth.
fn agrees(depth: Step, side: Step) -> bool {
    let part = side.size / depth.size;
    side.ratio() >= SIDES_RATIO.get()
        && depth.ratio().hypot(side.ratio()) >= BOTH_RATIO.get()
        && (AGREEMENT.get().recip()..AGREEMENT.get()).contains(&part)
}

/// Whether a step of the depth, at an end or not, is that of a collar, by the clearest one of the sides near it.
fn is_confirmed(depth: Step, sides: Option<Step>, at_end: bool) -> bool {
    let contradicts =
        |side: Step| (side.size - depth.size).abs() > AGAINST.get() * depth.deviation.hypot(side.deviation);
    let alone = at_end && depth.ratio() >= ALONE_RATIO.get();
    sides.is_some_and(|side| agrees(depth, side)) || alone && !sides.is_some_and(contradicts)
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

/// The outline of a mask inside of its sides is that of a face or a hole.
fn outermost(beyond: &mut [f64]) -> f64 {
    beyond.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

/// Whether what is so far from the surface belongs to the body or a collar.
pub(super) fn is_near(distance: f64, radius: f64) -> bool {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The ring in the middle of a short body was taken for a lid at both of its ends.
    #[test]
    fn a_collar_closes_the_end_that_it_is_at() {
        let slices = Slices { low: 0.0, length: 1.0, count: 20 };
        let near = near_end(&slices, 24.0);
        assert_eq!(slices.along(&(7..14), near), [7.0, 14.0]);
        assert_eq!(slices.along(&(1..9), near), [f64::NEG_INFINITY, 9.0]);
        assert_eq!(slices.along(&(12..19), near), [12.0, f64::INFINITY]);
    }

    #[test]
    fn the_sides_confirm_a_step_or_contradict_it() {
        let step = |size: f64| Step { size, deviation: 0.001 };
        let depth = step(0.03);
        let unclear = Step { deviation: 0.005, ..depth };
        assert!(is_confirmed(depth, None, true) && !is_confirmed(unclear, None, true));
        assert!(is_confirmed(unclear, Some(step(0.03)), false));
        assert!(!is_confirmed(depth, Some(step(-0.01)), true) && !is_confirmed(depth, None, false));
    }
}
