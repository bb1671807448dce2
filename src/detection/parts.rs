//! One cylinder in several parts, and several cylinders in one.

use super::DetectionOptions;
use super::candidate::{Candidate, Marks, Scene};
use super::search::{Judged, same};
use super::surface::{REACH, Surface};
use crate::geometry::Cylinder;
use crate::memory::List;
use nalgebra::Vector3;

constants! {
    /// What a second cylinder has to bring besides the penalty for its numbers, in the measure of a logarithm of odds.
    SECOND = 4.0, "log odds";

    /// The part of what the smaller of two parts explains that a cylinder in place of both may fall short: each part has
    /// errors of depth in common, which a cylinder of its own takes up.
    SHARED_PART = 0.4, "";

    /// Scores that differ by less, as a part of the larger, say the same.
    ALIKE = 0.9, "";

    /// So far below what a second cylinder has to bring no cut between two others is looked at.
    FAR = 3.0, "log odds";

    /// Axes of parts of one cylinder differ by less: short parts know their direction badly.
    MOST_TURN = 0.35, "rad";

    /// The narrower of two parts has this part of the radius of the wider one at least.
    LEAST_WIDTH = 0.6, "";

    /// The axes of parts pass each other within this.
    MOST_ASIDE = 1.0, "radius";

    /// The middle of a part is at most this far from the axis of the other.
    MOST_BESIDE = 1.5, "radius";

    /// Two candidates are parts of one cylinder where so much of their cells is of one of them alone, and this much where both are
    /// nearly the same cylinder: each goes on over another groove. Others explain the same cells in two ways, which is for the choice to decide.
    APART = 0.9, "";
    OVERLAP = 0.65, "";

    /// What the five numbers of a second cylinder would have to bring to be worth having.
    NUMBERS = 3.0, "log odds";

    /// Through a cylinder in place of two less than this part is seen.
    MOST_THROUGH = 0.3, "";

    /// What is shorter is not cut in two: each part should be about as long as wide to tell its own radius.
    LEAST_LENGTH = 2.0, "radius";

    /// A part is a cylinder by this score.
    GOOD = 0.5, "";
}

/// Where a cylinder is cut in two, in eighths of its cells: some first, and those between them.
const CUTS: [usize; 5] = [2, 4, 6, 3, 5];
const COARSE: usize = 3;

/// Joins parts of one cylinder that something in front divides.
pub(super) fn join(
    scene: &Scene<'_>,
    found: &mut Vec<Judged>,
    options: &DetectionOptions,
    marks: &mut Marks,
) {
    found.sort_by(|a, b| b.candidate.gain.total_cmp(&a.candidate.gain));
    let mut first = 0;
    while first < found.len() && !scene.effort.is_spent() {
        let mut second = first + 1;
        while second < found.len() {
            if let Some(joint) = joined(scene, &found[first], &found[second], options, marks) {
                found[first] = joint;
                found.remove(second);
                second = first + 1;
            } else {
                second += 1;
            }
        }
        first += 1;
    }
}

/// One cylinder in place of two, where that explains the cells of both no worse.
fn joined(
    scene: &Scene<'_>,
    a: &Judged,
    b: &Judged,
    options: &DetectionOptions,
    marks: &mut Marks,
) -> Option<Judged> {
    let (first, second) = (&a.candidate, &b.candidate);
    let (Surface::Cylinder(one, _), Surface::Cylinder(other, _)) = (&first.surface, &second.surface) else {
        return None;
    };
    if !are_in_line(scene, [one, other], &second.cells) {
        return None;
    }
    marks.next();
    let cells = first.cells.iter().chain(&second.cells).copied();
    let cells: List<usize> = cells.filter(|&k| marks.set(k)).collect();
    let of_both = first.cells.len() + second.cells.len();
    let are_apart = cells.len() as f64 >= APART.get() * of_both as f64;
    let overlap = same(one, other) && cells.len() as f64 >= OVERLAP.get() * of_both as f64;
    if !are_apart && !overlap {
        return None;
    }
    let again = scene.refit(&first.surface, &cells, first.sides, marks);
    let look_at = |surface: Surface| {
        let misfits = scene.misfits(&surface, &cells);
        let on = cells.iter().zip(&misfits).filter(|(_, misfit)| **misfit <= REACH.get() * REACH.get());
        let on: List<usize> = on.map(|(&k, _)| k).collect();
        let look = scene.look(&surface, &on, marks);
        (Candidate { surface, cells: on, gain: look.worth, sides: first.sides }, look)
    };
    let looks = again.into_iter().chain([first.surface, second.surface]).map(look_at);
    let joint = looks.reduce(|best, next| if next.0.gain > best.0.gain { next } else { best })?;
    let (smaller, larger) = if first.gain < second.gain { (first, second) } else { (second, first) };
    // What both explain counts once, and leaves nothing to fall short of.
    let (own, most_short) = match are_apart {
        true => (1.0, SHARED_PART.get() * smaller.gain),
        false => (1.0 - (of_both - cells.len()) as f64 / smaller.cells.len() as f64, 0.0),
    };
    let short = own * smaller.gain + larger.gain - NUMBERS.get() - joint.0.gain;
    if short > most_short {
        return None;
    }
    // One that explains less must be a cylinder as surely as the less sure of both, but for a little.
    let least = if short > 0.0 { ALIKE.get() * f64::min(a.score, b.score) } else { 0.0 };
    Judged::new(scene, joint, options, marks)
        .filter(|judged| judged.evidence.seen_through < MOST_THROUGH.get() && judged.score >= least)
}

/// Whether two cylinders may be parts of one, by where they and the cells of the second one are.
fn are_in_line(scene: &Scene<'_>, [one, other]: [&Cylinder; 2], cells_of_other: &[usize]) -> bool {
    let change = one.compare(other);
    let (narrower, wider) = (one.radius.min(other.radius), one.radius.max(other.radius));
    let points = cells_of_other.iter().map(|&k| scene.grid.cells[k].point);
    let middle = || points.sum::<Vector3<f64>>() / cells_of_other.len() as f64;
    change.angle <= MOST_TURN.get()
        && narrower >= LEAST_WIDTH.get() * wider
        && change.axis_distance <= MOST_ASIDE.get() * wider
        && one.axis.distance(&middle()) <= MOST_BESIDE.get() * wider
}

/// A surface and its cells.
type Part = (Surface, List<usize>);

/// The parts of a candidate that is two cylinders one after the other, stacked cans, a bottle and its neck: where two explain its
/// cells better than one.
pub(super) fn divided(
    scene: &Scene<'_>,
    judged: &Judged,
    options: &DetectionOptions,
    marks: &mut Marks,
) -> Option<Vec<Judged>> {
    let Candidate { surface, cells, gain, .. } = &judged.candidate;
    if judged.evidence.length < LEAST_LENGTH.get() || scene.effort.is_spent() {
        return None;
    }
    let mut order: List<(f64, usize)> =
        cells.iter().map(|&k| (surface.project(&scene.grid.cells[k].point).along, k)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let sorted: List<usize> = order.iter().map(|&(_, k)| k).collect();
    let mut best: Option<(f64, [Part; 2])> = None;
    for (tried, eighths) in CUTS.into_iter().enumerate() {
        // Between cuts that bring far too little there is none that brings enough.
        if tried == COARSE && best.as_ref().is_some_and(|(most, _)| *most < gain + SECOND.get() - FAR.get()) {
            return None;
        }
        let (low, high) = sorted.split_at(sorted.len() * eighths / 8);
        let fitted = |part: &[usize], marks: &mut Marks| {
            let surface = scene.refit(surface, part, judged.candidate.sides, marks)?;
            Some((scene.look(&surface, part, marks).worth, (surface, List::from(part))))
        };
        let (Some((one, first)), Some((other, second))) = (fitted(low, marks), fitted(high, marks)) else {
            continue;
        };
        if best.as_ref().is_none_or(|(most, _)| one + other > *most) {
            best = Some((one + other, [first, second]));
        }
    }
    let (both, parts) = best?;
    if both < gain + SECOND.get() {
        return None;
    }
    let mut found = Vec::new();
    for (surface, cells) in parts {
        let Some(grown) = scene.grow(&surface, &cells, judged.candidate.sides, marks) else {
            continue;
        };
        if grown.0.cells.len() < judged.candidate.cells.len() {
            found.extend(Judged::new(scene, grown, options, marks));
        }
    }
    let good = found.iter().filter(|part| part.score > GOOD.get()).count();
    // A cylinder and a remainder are no better than the whole, unless the whole was none.
    (good == 2 || good == 1 && judged.score < GOOD.get()).then_some(found)
}
