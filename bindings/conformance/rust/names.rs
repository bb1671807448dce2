//! The names of the C enumerations, in the order of their numbers from 0 on.

use cylfuse::fitter::{ChartChoice, EdgeUse, ExtentRule, Inputs, Method, NearWall, ObjectiveKind, StartKind};
use serde_json::Value;

/// The value of a name.
pub fn named<T: Copy>(value: &Value, names: &[(&str, T)]) -> T {
    let name = value.as_str().unwrap();
    names.iter().find(|(known, _)| *known == name).unwrap_or_else(|| panic!("unknown name {name}")).1
}

/// The number of a value.
pub fn position<T: PartialEq>(value: &T, names: &[(&str, T)]) -> f64 {
    names.iter().position(|(_, known)| known == value).unwrap() as f64
}

pub const METHODS: &[(&str, Method)] = &[
    ("FUSED", Method::Fused),
    ("POINTS", Method::Points),
    ("RANSAC", Method::Ransac),
    ("EBERLY", Method::Eberly),
];
pub const OBJECTIVES: &[(&str, ObjectiveKind)] =
    &[("ROBUST", ObjectiveKind::Robust), ("PAPER", ObjectiveKind::Paper)];
pub const STARTS: &[(&str, StartKind)] = &[
    ("AUTO", StartKind::Auto),
    ("LIMBS", StartKind::Limbs),
    ("MOMENTS", StartKind::Moments),
    ("RANSAC", StartKind::Ransac),
    ("MODEL", StartKind::Model),
    ("LAST", StartKind::Last),
];
pub const NEAR_WALLS: &[(&str, NearWall)] =
    &[("AUTO", NearWall::Auto), ("ON", NearWall::On), ("OFF", NearWall::Off)];
pub const CHARTS: &[(&str, ChartChoice)] =
    &[("AUTO", ChartChoice::Auto), ("LOCAL", ChartChoice::Local), ("ORTHONORMAL", ChartChoice::Orthonormal)];
pub const EDGE_USES: &[(&str, EdgeUse)] = &[("REFINE", EdgeUse::Refine), ("AS_GIVEN", EdgeUse::AsGiven)];
pub const EXTENT_RULES: &[(&str, ExtentRule)] =
    &[("AUTO", ExtentRule::Auto), ("EXTREMES", ExtentRule::Extremes), ("LOCATED", ExtentRule::Located)];
pub const IMAGE_USES: &[(&str, bool)] = &[("AUTO", true), ("IGNORE", false)];
pub const INPUTS: &[(&str, Inputs)] = &[
    ("POINTS", Inputs::POINTS),
    ("DEPTH", Inputs::DEPTH),
    ("EDGES", Inputs::EDGES),
    ("IMAGE", Inputs::IMAGE),
];
