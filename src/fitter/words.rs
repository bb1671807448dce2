//! Warnings in words.

use super::result::Flags;
use std::ffi::CStr;

/// Every warning with its name and what it means in a few words, ready for the C interface.
const TEXTS: &[(Flags, &CStr)] = &[
    (Flags::EDGES_IGNORED, c"EDGES_IGNORED: none of the edge segments was used"),
    (
        Flags::SEGMENTS_UNUSABLE,
        c"SEGMENTS_UNUSABLE: some edge segments have no length or lie outside the field of the camera",
    ),
    (
        Flags::EDGES_CROSS,
        c"EDGES_CROSS: the two edge segments cross each other, so they are not the two limbs",
    ),
    (Flags::EDGES_COINCIDE, c"EDGES_COINCIDE: the two edge segments lie on the same limb"),
    (Flags::EDGES_BEHIND, c"EDGES_BEHIND: the edge segments do not meet the cylinder in front of the camera"),
    (
        Flags::SCALE_HELD,
        c"SCALE_HELD: edges alone do not determine the scale; that of the start was kept",
    ),
    (Flags::WEAK_RADIUS, c"WEAK_RADIUS: the data hardly determine the radius"),
    (
        Flags::RESOLUTION_LOST,
        c"RESOLUTION_LOST: the coordinates are coarser than 0.01 % of the radius; store them as doubles",
    ),
    (
        Flags::NOT_CONVERGED,
        c"NOT_CONVERGED: the fit did not converge, or there was none and the cylinder is as a search found it",
    ),
    (Flags::HIDDEN_WALL, c"HIDDEN_WALL: most points lie on the wall that the camera cannot see"),
    (Flags::CAMERA_INSIDE, c"CAMERA_INSIDE: the camera is inside the cylinder, which has no limbs then"),
    (Flags::POINTS_NOT_FINITE, c"POINTS_NOT_FINITE: points that are not finite were left out"),
    (
        Flags::POINTS_AND_LIMBS_DISAGREE,
        c"POINTS_AND_LIMBS_DISAGREE: the points and the limbs disagree",
    ),
    (
        Flags::RADIUS_AT_LIMIT,
        c"RADIUS_AT_LIMIT: the radius is at its limit; the data fit better beyond it",
    ),
    (
        Flags::AXIS_AT_LIMIT,
        c"AXIS_AT_LIMIT: the axis is on the border of its cone; the data fit better beyond it",
    ),
    (
        Flags::UNCERTAINTY_UNKNOWN,
        c"UNCERTAINTY_UNKNOWN: the data do not determine the uncertainty of the result",
    ),
    (
        Flags::DEPTH_SHIFTED,
        c"DEPTH_SHIFTED: depth and image are shifted against each other across the axis",
    ),
    (
        Flags::MASK_ENDS_WITH_DEPTH,
        c"MASK_ENDS_WITH_DEPTH: the mask ends where the depth does; its sides are no hint where the limbs are",
    ),
    (Flags::POOR_FIT, c"POOR_FIT: the points do not lie on the cylinder"),
    (
        Flags::BODY_TAPERS,
        c"BODY_TAPERS: the body tapers, or one limb is something else; the radius changes along the axis",
    ),
    (Flags::MASK_DISAGREES, c"MASK_DISAGREES: the mask ends far beside a limb of the cylinder, or holds another body"),
];

impl Flags {
    /// The name of a warning, a colon, and what it means in a few words; a text for what is not one warning, too.
    #[must_use]
    pub fn describe(self) -> &'static CStr {
        let known = TEXTS.iter().find(|(flag, _)| *flag == self);
        known.map_or(c"unknown flag: not one of the warnings that this library knows", |known| known.1)
    }

    /// What a warning means in a few words.
    #[must_use]
    pub fn meaning(self) -> &'static str {
        let text = self.describe().to_str().unwrap_or_default();
        text.split_once(": ").map_or(text, |(_, meaning)| meaning)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_flag_has_its_name_and_words() {
        for (name, flag) in Flags::all().iter_names() {
            let text = flag.describe().to_str().unwrap();
            assert!(text.starts_with(&format!("{name}: ")), "{name}: {text}");
            assert!(text.is_ascii() && !text.ends_with('.'), "{text}");
            assert_eq!(text, format!("{name}: {}", flag.meaning()));
        }
        for flags in [Flags::empty(), Flags::all(), Flags::from_bits_retain(1 << 31)] {
            assert!(flags.describe().to_str().unwrap().starts_with("unknown flag: "), "{flags:?}");
        }
    }
}
