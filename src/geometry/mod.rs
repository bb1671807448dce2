//! Lines, rotations and cylinders in space: no camera, no data.
//!
//! Notation of the paper and its words here:
//!
//! | paper | here |
//! |---|---|
//! | d̂, direction of the axis | `direction` |
//! | c, axis point nearest the origin | [`Line::nearest_to_origin`] |
//! | m = c × d̂, moment (5) | `PluckerLine::moment` |
//! | {U, W}, orthonormal representation (6) | `OrthonormalLine` |
//! | r | `radius` |
//! | γ, half the angle between the limb planes (11) | [`LimbFrame`] |

mod chart;
mod cylinder;
mod limbs;
mod limits;
mod line;
mod motion;
mod plane;
mod rotation;

pub(crate) use chart::{Chart, LocalFrame, Tangent, TangentMap};
pub use cylinder::{Cylinder, CylinderComparison, Walls};
pub use limbs::LimbFrame;
pub use limits::{AxisCone, CylinderLimits};
pub use line::Line;
pub(crate) use line::{across, rejection};
pub use motion::RigidMotion;
pub(crate) use plane::Plane;
#[cfg(test)]
pub(crate) use rotation::exp_so3;
pub use rotation::{any_orthogonal, rotate_direction};
