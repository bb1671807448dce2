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

    /// Something narrower that follows the body is so long at least: beside an end depth and masks are rounded.
    NARROWER = 0.5, "radius";

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
    let least = [LEAST_STEP.get() * radius, DEPTH_RATIO.get()];
    let longest = longest(&slices);
    let [margin, near] = [(margin / slices.length) as usize, near_end(&slices, *radius)];
    let narrower = depth.clone().negated();
    let shortest = (NARROWER.get() * radius / slices.length) as usize + 1;
    let stretches = depth.raised(longest, least, margin);
    // A coupling in the middle of a pipe makes its ends look narrower.
    let is_inside = |stretch: &&Range<usize>| slices.along(stretch, near).iter().all(|at| at.is_finite());
    let raised =
        stretches.iter().filter(is_inside).map(|stretch| depth.explained(stretch)).fold(0.0, f64::max);
    let lowered = narrower.raised_at_end(shortest..longest + 1, least);
    let lowered = lowered.filter(|stretch| narrower.explained(stretch) > raised);
    if stretches.is_empty() && lowered.is_none() {
        return None;
    }
    // Most bodies have no step that they are asked about.
    let middle = axis.at(slices.middle());
    let floor = SIDES_FLOOR.get() * camera.pixel_size() * middle.z;
    let sides = sides_of(camera, mask, cylinder).map(|side| Profile::new(&slices, &side, 1, floor));
    let lean =
        axis.direction.dot(&middle).abs() / axis.direction.cross(&middle).norm().max(f64::MIN_POSITIVE);
    // The edge of a collar is an ellipse in the image, which begins elsewhere at the sides than in the middle.
    let moved = |step: Step| {
        let wider = step.size / radius;
        let moved = radius * (MARGIN.get() + lean * (wider * (2.0 + wider)).sqrt());
        ((moved / slices.length) as usize).min(slices.count)
    };
    if let Some(lowered) = lowered {
        let step = narrower.step(&lowered)?;
        let moved = moved(step);
        let sides: List<Profile> = sides.iter().flatten().map(|side| side.clone().negated()).collect();
        let of_sides = step_of_sides(&sides, &slices, &lowered, moved);
        if step.ratio() >= DEPTH_RATIO.get() && is_confirmed(step, of_sides, true) {
            let [begin, end] = slices.along(&lowered, 0);
            let at_start = begin.is_infinite();
            let ends = if at_start { [Some(end), high] } else { [low, Some(begin)] };
            let of_body = collars(camera, mask, (sights, apart), cylinder, ends);
            return of_body.or_else(|| Some((List::new(), ends)));
        }
    }
    let found = stretches.iter().enumerate().filter_map(|(k, stretch)| {
        let depth = depth.without(&stretches, Some(k), margin)?;
        let step = depth.step(stretch)?;
        if stretch.len() > longest || step.size < least[0] || step.ratio() < DEPTH_RATIO.get() {
            return None;
        }
        let moved = moved(step);
        let sides: List<Profile> =
            sides.iter().flatten().filter_map(|side| side.without(&stretches, Some(k), moved)).collect();
        let of_sides = step_of_sides(&sides, &slices, stretch, moved);
        // Of a thin collar the depth shows the face more than the rim.
        let of_rim = of_sides.filter(|side| agrees(step, *side)).map_or(0.0, |side| side.size);
        let wider = of_rim.max(step.size + depth.upper_part(stretch, step));
        let collar = Collar { stretch: slices.along(stretch, near), radius: radius + wider };
        let at_end = [0, 1].iter().any(|end| collar.closes(*end));
        is_confirmed(step, of_sides, at_end).then_some(collar)
    });
    Some((found.collect(), ends))
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
