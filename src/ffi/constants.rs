//! The constants of the interface: integers, because an unknown value in a Rust `enum` is undefined behaviour.

use super::status::Failure;
use crate::fitter::{
    ChartChoice, EdgeUse, ExtentRule, Inputs, Method, NearWall, ObjectiveKind, ResidualKind, StartKind,
};
use crate::observations::{ImageFormat, Pixels, Scalar};

/// Refuses a number with the ones that are known and their names.
fn unknown<T>(field: &str, value: i32, known: &[(i32, &str)]) -> Result<T, Failure> {
    let mut requirement = String::from("be");
    for (index, (number, name)) in known.iter().enumerate() {
        let joint = match index {
            0 => " ",
            _ if index + 1 < known.len() => ", ",
            _ => " or ",
        };
        requirement += &format!("{joint}{number} ({name})");
    }
    Err(Failure::argument(field, value, requirement))
}

/// Reads constants as what they stand for in the library.
macro_rules! reads {
    ($constant:ident, $kind:ident { $($name:ident = $value:ident),+ }) => {
        impl $constant {
            pub(super) fn read(self, field: &str) -> Result<$kind, Failure> {
                match self {
                    $(Self::$name => Ok($kind::$value),)+
                    _ => unknown(field, self.0, &[$((Self::$name.0, stringify!($name))),+]),
                }
            }
        }
    };
}

/// The same, and the other way round.
macro_rules! stands_for {
    ($constant:ident, $kind:ident { $($name:ident = $value:ident),+ }) => {
        reads!($constant, $kind { $($name = $value),+ });

        impl From<$kind> for $constant {
            fn from(value: $kind) -> Self {
                match value {
                    $($kind::$value => Self::$name,)+
                }
            }
        }
    };
}

/// The type of a coordinate.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_scalar(pub i32);

impl cylfuse_scalar {
    /// `float`.
    pub const F32: cylfuse_scalar = cylfuse_scalar(1);
    /// `double`.
    pub const F64: cylfuse_scalar = cylfuse_scalar(2);
}

reads!(cylfuse_scalar, Scalar { F32 = F32, F64 = F64 });

/// How a depth is stored in a pixel.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_depth_format(pub i32);

impl cylfuse_depth_format {
    /// `uint16_t`; 0 and 65535 (too far) = no measurement.
    pub const U16: cylfuse_depth_format = cylfuse_depth_format(1);
    /// `float`; 0, negative or not finite = no measurement.
    pub const F32: cylfuse_depth_format = cylfuse_depth_format(2);
}

reads!(cylfuse_depth_format, Pixels { U16 = U16, F32 = F32 });

/// How a pixel of an image is stored: one grey value, or three colours and perhaps a fourth byte (alpha), which is
/// ignored.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_image_format(pub i32);

impl cylfuse_image_format {
    /// `uint8_t`.
    pub const U8: cylfuse_image_format = cylfuse_image_format(1);
    /// `uint16_t`.
    pub const U16: cylfuse_image_format = cylfuse_image_format(2);
    /// `float`, finite.
    pub const F32: cylfuse_image_format = cylfuse_image_format(3);
    /// Red, green, blue, each `uint8_t`.
    pub const RGB8: cylfuse_image_format = cylfuse_image_format(4);
    /// Blue, green, red, each `uint8_t`, as OpenCV reads image files.
    pub const BGR8: cylfuse_image_format = cylfuse_image_format(5);
    /// Red, green, blue, alpha, each `uint8_t`.
    pub const RGBA8: cylfuse_image_format = cylfuse_image_format(6);
    /// Blue, green, red, alpha, each `uint8_t`.
    pub const BGRA8: cylfuse_image_format = cylfuse_image_format(7);
}

reads!(
    cylfuse_image_format,
    ImageFormat { U8 = U8, U16 = U16, F32 = F32, RGB8 = Rgb8, BGR8 = Bgr8, RGBA8 = Rgba8, BGRA8 = Bgra8 }
);

/// The distortion of the lens. What the numbers in `cylfuse_intrinsics::distortion` mean.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_distortion(pub i32);

impl cylfuse_distortion {
    /// A pinhole; all coefficients are 0.
    pub const NONE: cylfuse_distortion = cylfuse_distortion(0);
    /// Brown and Conrady: k1 k2 p1 p2 k3 k4 k5 k6 in the order of OpenCV; the missing ones of a shorter list are
    /// 0.
    pub const BROWN_CONRADY: cylfuse_distortion = cylfuse_distortion(1);
    /// Kannala and Brandt, the fisheye model of OpenCV: k1 k2 k3 k4; the other coefficients are 0. Rays less than
    /// 89 degrees from the axis.
    pub const KANNALA_BRANDT: cylfuse_distortion = cylfuse_distortion(2);
}

/// How the points of an output buffer are arranged.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_layout(pub i32);

impl cylfuse_layout {
    /// Only the points that exist, one after the other, row by row of the image.
    pub const PACKED: cylfuse_layout = cylfuse_layout(0);
    /// One point for each pixel of the image, NaN where there is none.
    pub const ORGANISED: cylfuse_layout = cylfuse_layout(1);

    /// Whether organised.
    pub(super) fn read(self, field: &str) -> Result<bool, Failure> {
        match self {
            Self::PACKED => Ok(false),
            Self::ORGANISED => Ok(true),
            _ => unknown(field, self.0, &[(0, "PACKED"), (1, "ORGANISED")]),
        }
    }
}

/// How the cylinder is estimated.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_method(pub i32);

impl cylfuse_method {
    /// Points and edges together, by the chosen `cylfuse_objective`.
    pub const FUSED: cylfuse_method = cylfuse_method(0);
    /// Points alone by plain least squares; edges are ignored.
    pub const POINTS: cylfuse_method = cylfuse_method(1);
    /// Random sample consensus over the points with local optimisation; no fit to all points follows.
    pub const RANSAC: cylfuse_method = cylfuse_method(2);
    /// Eberly's algebraic fit by the moments of the points, without a final iteration.
    pub const EBERLY: cylfuse_method = cylfuse_method(3);
}

stands_for!(cylfuse_method, Method { FUSED = Fused, POINTS = Points, RANSAC = Ransac, EBERLY = Eberly });

/// What `CYLFUSE_METHOD_FUSED` minimises.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_objective(pub i32);

impl cylfuse_objective {
    /// Robust points and the distances of the segment endpoints in pixels, each weighted by its own scale. Takes
    /// any number of segments, none included.
    pub const ROBUST: cylfuse_objective = cylfuse_objective(0);
    /// F = (1 - w) E_P + w E_L of Zhang, Liu and Wang (Sensors 2026, 26(5), 1687), exactly, with the weight
    /// w = `edge_weight`. Takes exactly two segments, or w = 0.
    pub const PAPER: cylfuse_objective = cylfuse_objective(1);
}

stands_for!(cylfuse_objective, ObjectiveKind { ROBUST = Robust, PAPER = Paper });

/// Where the iteration starts.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_start(pub i32);

impl cylfuse_start {
    /// The candidate of the kinds below that explains the data best. Never in a result.
    pub const AUTO: cylfuse_start = cylfuse_start(0);
    /// From two limb segments, scaled by the points.
    pub const LIMBS: cylfuse_start = cylfuse_start(1);
    /// Eberly's algebraic fit by the moments of the points.
    pub const MOMENTS: cylfuse_start = cylfuse_start(2);
    /// Random sample consensus over the points.
    pub const RANSAC: cylfuse_start = cylfuse_start(3);
    /// The model given by `cylfuse_fitter_set_start_model`.
    pub const MODEL: cylfuse_start = cylfuse_start(4);
    /// The cylinder of the last successful fit of the fitter, for frames of a sequence, also after `cylfuse_fitter_clear`.
    /// Where its limbs are about where it or the points have them, and look in the image as they did, they are not searched: the
    /// search, a great part of the time, is left out, and the result depends on the fits before. Where not, and before the first
    /// fit, as AUTO, with that cylinder or the start model one of the candidates. Of points alone that hold several bodies
    /// the one near that cylinder is fitted.
    pub const LAST: cylfuse_start = cylfuse_start(5);
}

stands_for!(
    cylfuse_start,
    StartKind { AUTO = Auto, LIMBS = Limbs, MOMENTS = Moments, RANSAC = Ransac, MODEL = Model, LAST = Last }
);

/// Whether the points must lie on the wall of the cylinder that a camera at the origin sees. There is often a
/// second minimum with the cylinder between camera and surface; this rule refuses it.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_near_wall(pub i32);

impl cylfuse_near_wall {
    /// On when intrinsics are set: only then is the origin known to be a camera.
    pub const AUTO: cylfuse_near_wall = cylfuse_near_wall(0);
    /// On: the origin is the observer.
    pub const ON: cylfuse_near_wall = cylfuse_near_wall(1);
    /// Off: the minimum nearest to the start stays.
    pub const OFF: cylfuse_near_wall = cylfuse_near_wall(2);
}

stands_for!(cylfuse_near_wall, NearWall { AUTO = Auto, ON = On, OFF = Off });

/// The coordinates in which the iteration steps. All reach the same optima.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_chart(pub i32);

impl cylfuse_chart {
    /// ORTHONORMAL for the paper's objective where a camera stands outside the cylinder, else LOCAL.
    pub const AUTO: cylfuse_chart = cylfuse_chart(0);
    /// Shift and tilt of the axis at the data: regular wherever the axis runs.
    pub const LOCAL: cylfuse_chart = cylfuse_chart(1);
    /// The orthonormal representation about the origin of coordinates, as in the paper: singular for an axis
    /// through the origin.
    pub const ORTHONORMAL: cylfuse_chart = cylfuse_chart(2);
}

stands_for!(cylfuse_chart, ChartChoice { AUTO = Auto, LOCAL = Local, ORTHONORMAL = Orthonormal });

/// What given edge segments are for the objective ROBUST. No other looks for limbs in the image.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_edge_use(pub i32);

impl cylfuse_edge_use {
    /// A start: where there is an image, the limbs are located in it and join the fit.
    pub const REFINE: cylfuse_edge_use = cylfuse_edge_use(0);
    /// The measurement: no limbs are looked for in the image. The arcs of the ends are.
    pub const AS_GIVEN: cylfuse_edge_use = cylfuse_edge_use(1);
}

stands_for!(cylfuse_edge_use, EdgeUse { REFINE = Refine, AS_GIVEN = AsGiven });

/// Whether a detector looks at the image of a frame.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_image_use(pub i32);

impl cylfuse_image_use {
    /// Where there is one.
    pub const AUTO: cylfuse_image_use = cylfuse_image_use(0);
    /// Never: by depth alone.
    pub const IGNORE: cylfuse_image_use = cylfuse_image_use(1);

    /// Whether it looks.
    pub(super) fn read(self, field: &str) -> Result<bool, Failure> {
        match self {
            Self::AUTO => Ok(true),
            Self::IGNORE => Ok(false),
            _ => unknown(field, self.0, &[(0, "AUTO"), (1, "IGNORE")]),
        }
    }
}

/// How the ends of the visible cylinder are found in a mask. Without one, and from inside a pipe, the points on the surface
/// tell them.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_extent_rule(pub i32);

impl cylfuse_extent_rule {
    /// LOCATED for the method FUSED with the objective ROBUST, EXTREMES otherwise.
    pub const AUTO: cylfuse_extent_rule = cylfuse_extent_rule(0);
    /// The rule of the paper: the extreme positions along the axis of the points completed over the mask.
    pub const EXTREMES: cylfuse_extent_rule = cylfuse_extent_rule(1);
    /// From all lines along the surface together, in the mask and, when there is one, in the image.
    pub const LOCATED: cylfuse_extent_rule = cylfuse_extent_rule(2);
}

stands_for!(cylfuse_extent_rule, ExtentRule { AUTO = Auto, EXTREMES = Extremes, LOCATED = Located });

/// Data of a view, one bit each.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_input(pub u32);

impl cylfuse_input {
    /// All points: those of clouds and those that were made of depth images.
    pub const POINTS: cylfuse_input = cylfuse_input(1);
    /// The depth image and its mask, which completion and extent look at; the points that were made of it stay.
    pub const DEPTH: cylfuse_input = cylfuse_input(2);
    /// Edge segments, of `cylfuse_fitter_push_edges`.
    pub const EDGES: cylfuse_input = cylfuse_input(4);
    /// The image, of `cylfuse_fitter_push_image` and of a frame.
    pub const IMAGE: cylfuse_input = cylfuse_input(8);

    pub(super) fn read(self, name: &str) -> Result<Inputs, Failure> {
        let requirement = "be a sum of 1 (POINTS), 2 (DEPTH), 4 (EDGES) and 8 (IMAGE)";
        Inputs::from_bits(self.0).ok_or_else(|| Failure::argument(name, self.0, requirement))
    }
}

/// Which residuals to list.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_residual_kind(pub i32);

impl cylfuse_residual_kind {
    /// Signed distance of every used point from the surface, in the unit of length, negative inside; in the order
    /// in which the points were pushed, without the dropped ones.
    pub const POINTS: cylfuse_residual_kind = cylfuse_residual_kind(1);
    /// Signed distance of both endpoints of every used segment from its limb line, in ideal pixels.
    pub const EDGES: cylfuse_residual_kind = cylfuse_residual_kind(2);
}

reads!(cylfuse_residual_kind, ResidualKind { POINTS = Points, EDGES = Edges });

/// How much a log line matters.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_log_level(pub i32);

impl cylfuse_log_level {
    /// No lines.
    pub const OFF: cylfuse_log_level = cylfuse_log_level(0);
    /// Calls that failed, with the text of `cylfuse_fitter_last_error`.
    pub const ERROR: cylfuse_log_level = cylfuse_log_level(1);
    /// Warnings about a result, such as ignored edges.
    pub const WARNING: cylfuse_log_level = cylfuse_log_level(2);
    /// What was pushed, which start was taken, how a fit ended.
    pub const INFO: cylfuse_log_level = cylfuse_log_level(3);
    /// Every iteration.
    pub const DEBUG: cylfuse_log_level = cylfuse_log_level(4);

    pub(super) fn check(self, field: &str) -> Result<(), Failure> {
        match self.0 {
            0..=4 => Ok(()),
            _ => {
                unknown(field, self.0, &[(0, "OFF"), (1, "ERROR"), (2, "WARNING"), (3, "INFO"), (4, "DEBUG")])
            }
        }
    }
}

#[cfg(test)]
mod tests;
