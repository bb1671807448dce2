//! The constants of results as text.

use super::constants::cylfuse_start;
use super::outcomes::{
    cylfuse_conformity, cylfuse_end_source, cylfuse_end_state, cylfuse_limb_status, cylfuse_part,
    cylfuse_result_flags, cylfuse_termination,
};
use crate::fitter::Flags;
use std::ffi::{CStr, c_char};

const TERMINATIONS: &[(cylfuse_termination, &CStr)] = &[
    (cylfuse_termination::NONE, c"NONE: there was no iteration"),
    (cylfuse_termination::COST, c"COST: the cost no longer fell"),
    (cylfuse_termination::STALLED, c"STALLED: no step lowered the cost; a minimum to rounding"),
    (cylfuse_termination::MAX_ITERATIONS, c"MAX_ITERATIONS: the limit of iterations was reached"),
    (cylfuse_termination::RADIUS_RAN_AWAY, c"RADIUS_RAN_AWAY: the radius left all proportion to the data"),
    (cylfuse_termination::GRADIENT, c"GRADIENT: the gradient fell below its tolerance"),
    (cylfuse_termination::STEP, c"STEP: the step fell below its tolerance"),
];

const STARTS: &[(cylfuse_start, &CStr)] = &[
    (cylfuse_start::AUTO, c"AUTO: the candidate that explains the data best"),
    (cylfuse_start::LIMBS, c"LIMBS: two limb segments, scaled by the points"),
    (cylfuse_start::MOMENTS, c"MOMENTS: Eberly's algebraic fit by the moments of the points"),
    (cylfuse_start::RANSAC, c"RANSAC: random sample consensus over the points"),
    (cylfuse_start::MODEL, c"MODEL: the start model that was set"),
    (cylfuse_start::LAST, c"LAST: the cylinder of the last successful fit"),
];

const END_STATES: &[(cylfuse_end_state, &CStr)] = &[
    (cylfuse_end_state::UNKNOWN, c"UNKNOWN: nothing tells what lies beyond the end"),
    (cylfuse_end_state::SEEN, c"SEEN: the surface ends there"),
    (cylfuse_end_state::CUT, c"CUT: the border of the image cuts the cylinder off"),
    (cylfuse_end_state::HIDDEN, c"HIDDEN: something nearer covers what lies beyond"),
];

const END_SOURCES: &[(cylfuse_end_source, &CStr)] = &[
    (cylfuse_end_source::EXTREME, c"EXTREME: the extreme point completed over the mask"),
    (cylfuse_end_source::MASK, c"MASK: where the surface leaves the mask, or where the depth shows its end"),
    (cylfuse_end_source::IMAGE, c"IMAGE: the arc of the end circle in the image"),
    (cylfuse_end_source::BORDER, c"BORDER: the last of the surface inside the border of the image"),
    (cylfuse_end_source::POINTS, c"POINTS: the points on the surface"),
];

const LIMB_STATUSES: &[(cylfuse_limb_status, &CStr)] = &[
    (cylfuse_limb_status::LOCATED, c"LOCATED: the limb was located in the image"),
    (cylfuse_limb_status::NOT_SEARCHED, c"NOT_SEARCHED: the image was not searched"),
    (cylfuse_limb_status::NO_LIMBS, c"NO_LIMBS: the cylinder has no limbs in front of the camera"),
    (
        cylfuse_limb_status::TOO_SHORT,
        c"TOO_SHORT: too few rows or columns of the image show the limb, or something covers it",
    ),
    (
        cylfuse_limb_status::NO_EDGE,
        c"NO_EDGE: no line near the expected position has more of an edge than noise gives",
    ),
    (
        cylfuse_limb_status::OUT_OF_REACH,
        c"OUT_OF_REACH: the line left the expected position while it was refined, or lies beside the mask",
    ),
    (
        cylfuse_limb_status::UNCERTAIN,
        c"UNCERTAIN: the line would be less certain than one set by hand, or is softer than any limb",
    ),
    (cylfuse_limb_status::PATCHY, c"PATCHY: a small part of the line carries it all"),
    (
        cylfuse_limb_status::SAME_LINE,
        c"SAME_LINE: the other limb was found at the same position, and more certainly",
    ),
];

const PARTS: &[(cylfuse_part, &CStr)] = &[
    (cylfuse_part::BODY, c"BODY: the lateral surface"),
    (cylfuse_part::CAP, c"CAP: a cap, in the plane across the axis at an end"),
    (cylfuse_part::INNER_WALL, c"INNER_WALL: the inside of the cylinder, seen through an open end"),
    (cylfuse_part::OTHER, c"OTHER: something nearer than the surface"),
    (cylfuse_part::BEHIND, c"BEHIND: something farther away than the cylinder"),
];

const CONFORMITIES: &[(cylfuse_conformity, &CStr)] = &[
    (cylfuse_conformity::UNDECIDED, c"UNDECIDED: the measurement does not tell"),
    (cylfuse_conformity::CONFORMING, c"CONFORMING: within the limits with all of its uncertainty"),
    (cylfuse_conformity::NOT_CONFORMING, c"NOT_CONFORMING: outside the limits with all of its uncertainty"),
];

/// The text of a constant in its list.
fn text<T: Copy + PartialEq>(list: &[(T, &'static CStr)], value: T) -> *const c_char {
    let known = list.iter().find(|(known, _)| *known == value);
    known.map_or(c"unknown: this library has no constant of that number", |known| known.1).as_ptr()
}

// The functions return constants: there is nothing in them that could panic.

/// A warning as text: its name without its prefix, a colon, and what it means in a few words. Static; a text for
/// unknown bits and for none or several of them, too. Of several, ask for each bit that is set.
#[unsafe(no_mangle)]
pub extern "C" fn cylfuse_flag_string(flag: cylfuse_result_flags) -> *const c_char {
    Flags::from_bits_retain(flag.0).describe().as_ptr()
}

/// Why an iteration ended, as text: the name of the constant without its prefix, a colon, and what it means in a few
/// words. Static; a text for unknown numbers too.
#[unsafe(no_mangle)]
pub extern "C" fn cylfuse_termination_string(termination: cylfuse_termination) -> *const c_char {
    text(TERMINATIONS, termination)
}

/// Where an iteration started, as text: the name of the constant without its prefix, a colon, and what it means in a few
/// words. Static; a text for unknown numbers too.
#[unsafe(no_mangle)]
pub extern "C" fn cylfuse_start_string(start: cylfuse_start) -> *const c_char {
    text(STARTS, start)
}

/// What an end of the visible cylinder is, as text: the name of the constant without its prefix, a colon, and what it
/// means in a few words. Static; a text for unknown numbers too.
#[unsafe(no_mangle)]
pub extern "C" fn cylfuse_end_state_string(state: cylfuse_end_state) -> *const c_char {
    text(END_STATES, state)
}

/// What the position of an end was taken from, as text: the name of the constant without its prefix, a colon, and what
/// it means in a few words. Static; a text for unknown numbers too.
#[unsafe(no_mangle)]
pub extern "C" fn cylfuse_end_source_string(source: cylfuse_end_source) -> *const c_char {
    text(END_SOURCES, source)
}

/// Whether a limb was located in the image, or why not, as text: the name of the constant without its prefix, a colon,
/// and what it means in a few words. Static; a text for unknown numbers too.
#[unsafe(no_mangle)]
pub extern "C" fn cylfuse_limb_status_string(status: cylfuse_limb_status) -> *const c_char {
    text(LIMB_STATUSES, status)
}

/// What a point in the mask belongs to, as text: the name of the constant without its prefix, a colon, and what it
/// means in a few words. Static; a text for unknown numbers too.
#[unsafe(no_mangle)]
pub extern "C" fn cylfuse_part_string(part: cylfuse_part) -> *const c_char {
    text(PARTS, part)
}

/// What a measurement says about a tolerance, as text: the name of the constant without its prefix, a colon, and what it
/// means in a few words. Static; a text for unknown numbers too.
#[unsafe(no_mangle)]
pub extern "C" fn cylfuse_conformity_string(conformity: cylfuse_conformity) -> *const c_char {
    text(CONFORMITIES, conformity)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The texts of the constants from `first` on, and of the number after them.
    fn texts<T>(first: i32, count: usize, of: impl Fn(i32) -> *const c_char, all: &[(T, &CStr)]) {
        assert_eq!(all.len(), count);
        let read = |number| {
            // SAFETY: the functions return constants that end with a NUL.
            unsafe { CStr::from_ptr(of(number)) }.to_str().unwrap()
        };
        for (number, (_, text)) in (first..).zip(all) {
            assert_eq!(read(number), text.to_str().unwrap());
            let name = read(number).split(": ").next().unwrap();
            assert!(name.chars().all(|c| c.is_ascii_uppercase() || c == '_'), "{name}");
        }
        for unknown in [first + i32::try_from(count).unwrap(), 200] {
            assert!(read(unknown).starts_with("unknown: "), "{unknown}");
        }
    }

    #[test]
    fn every_constant_of_a_result_has_a_text() {
        texts(0, 7, |n| cylfuse_termination_string(cylfuse_termination(n)), TERMINATIONS);
        texts(0, 6, |n| cylfuse_start_string(cylfuse_start(n)), STARTS);
        texts(0, 4, |n| cylfuse_end_state_string(cylfuse_end_state(n)), END_STATES);
        texts(0, 5, |n| cylfuse_end_source_string(cylfuse_end_source(n)), END_SOURCES);
        texts(0, 9, |n| cylfuse_limb_status_string(cylfuse_limb_status(n)), LIMB_STATUSES);
        texts(1, 5, |n| cylfuse_part_string(cylfuse_part(u8::try_from(n).unwrap())), PARTS);
        texts(0, 3, |n| cylfuse_conformity_string(cylfuse_conformity(n)), CONFORMITIES);
    }
}
