//! The constants of the interface: integers, because an unknown value in a Rust `enum` is undefined behaviour.

use super::status::Failure;
use crate::extent::EndState;
use crate::fitter::{
    ChartChoice, EdgeUse, ExtentRule, Method, NearWall, ObjectiveKind, ResidualKind, StartKind,
};
use crate::observations::{ImageFormat, Pixels, Scalar};
use crate::solver::Termination;

fn unknown<T>(field: &str, value: i32, known: &str) -> Result<T, Failure> {
    Err(Failure::argument(field, value, format!("be {known}")))
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

    pub(super) fn read(self, field: &str) -> Result<Scalar, Failure> {
        match self {
            Self::F32 => Ok(Scalar::F32),
            Self::F64 => Ok(Scalar::F64),
            _ => unknown(field, self.0, "1 (F32) or 2 (F64)"),
        }
    }
}

/// How a depth is stored in a pixel.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_depth_format(pub i32);

impl cylfuse_depth_format {
    /// `uint16_t`; 0 = no measurement.
    pub const U16: cylfuse_depth_format = cylfuse_depth_format(1);
    /// `float`; 0, negative or not finite = no measurement.
    pub const F32: cylfuse_depth_format = cylfuse_depth_format(2);

    pub(super) fn read(self, field: &str) -> Result<Pixels, Failure> {
        match self {
            Self::U16 => Ok(Pixels::U16),
            Self::F32 => Ok(Pixels::F32),
            _ => unknown(field, self.0, "1 (U16) or 2 (F32)"),
        }
    }
}

/// How a value of a grey image is stored in a pixel.
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

    pub(super) fn read(self, field: &str) -> Result<ImageFormat, Failure> {
        match self {
            Self::U8 => Ok(ImageFormat::U8),
            Self::U16 => Ok(ImageFormat::U16),
            Self::F32 => Ok(ImageFormat::F32),
            _ => unknown(field, self.0, "1 (U8), 2 (U16) or 3 (F32)"),
        }
    }
}

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
            _ => unknown(field, self.0, "0 (PACKED) or 1 (ORGANISED)"),
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
    /// Random sample consensus over the points, without a final iteration.
    pub const RANSAC: cylfuse_method = cylfuse_method(2);
    /// Eberly's algebraic fit by the moments of the points, without a final iteration.
    pub const EBERLY: cylfuse_method = cylfuse_method(3);

    pub(super) fn read(self, field: &str) -> Result<Method, Failure> {
        match self {
            Self::FUSED => Ok(Method::Fused),
            Self::POINTS => Ok(Method::Points),
            Self::RANSAC => Ok(Method::Ransac),
            Self::EBERLY => Ok(Method::Eberly),
            _ => unknown(field, self.0, "0 (FUSED), 1 (POINTS), 2 (RANSAC) or 3 (EBERLY)"),
        }
    }
}

impl From<Method> for cylfuse_method {
    fn from(method: Method) -> Self {
        match method {
            Method::Fused => Self::FUSED,
            Method::Points => Self::POINTS,
            Method::Ransac => Self::RANSAC,
            Method::Eberly => Self::EBERLY,
        }
    }
}

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

    pub(super) fn read(self, field: &str) -> Result<ObjectiveKind, Failure> {
        match self {
            Self::ROBUST => Ok(ObjectiveKind::Robust),
            Self::PAPER => Ok(ObjectiveKind::Paper),
            _ => unknown(field, self.0, "0 (ROBUST) or 1 (PAPER)"),
        }
    }
}

impl From<ObjectiveKind> for cylfuse_objective {
    fn from(objective: ObjectiveKind) -> Self {
        match objective {
            ObjectiveKind::Robust => Self::ROBUST,
            ObjectiveKind::Paper => Self::PAPER,
        }
    }
}

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

    pub(super) fn read(self, field: &str) -> Result<StartKind, Failure> {
        match self {
            Self::AUTO => Ok(StartKind::Auto),
            Self::LIMBS => Ok(StartKind::Limbs),
            Self::MOMENTS => Ok(StartKind::Moments),
            Self::RANSAC => Ok(StartKind::Ransac),
            Self::MODEL => Ok(StartKind::Model),
            _ => unknown(field, self.0, "0 (AUTO), 1 (LIMBS), 2 (MOMENTS), 3 (RANSAC) or 4 (MODEL)"),
        }
    }
}

impl From<StartKind> for cylfuse_start {
    fn from(start: StartKind) -> Self {
        match start {
            StartKind::Auto => Self::AUTO,
            StartKind::Limbs => Self::LIMBS,
            StartKind::Moments => Self::MOMENTS,
            StartKind::Ransac => Self::RANSAC,
            StartKind::Model => Self::MODEL,
        }
    }
}

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

    pub(super) fn read(self, field: &str) -> Result<NearWall, Failure> {
        match self {
            Self::AUTO => Ok(NearWall::Auto),
            Self::ON => Ok(NearWall::On),
            Self::OFF => Ok(NearWall::Off),
            _ => unknown(field, self.0, "0 (AUTO), 1 (ON) or 2 (OFF)"),
        }
    }
}

impl From<NearWall> for cylfuse_near_wall {
    fn from(rule: NearWall) -> Self {
        match rule {
            NearWall::Auto => Self::AUTO,
            NearWall::On => Self::ON,
            NearWall::Off => Self::OFF,
        }
    }
}

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

    pub(super) fn read(self, field: &str) -> Result<ChartChoice, Failure> {
        match self {
            Self::AUTO => Ok(ChartChoice::Auto),
            Self::LOCAL => Ok(ChartChoice::Local),
            Self::ORTHONORMAL => Ok(ChartChoice::Orthonormal),
            _ => unknown(field, self.0, "0 (AUTO), 1 (LOCAL) or 2 (ORTHONORMAL)"),
        }
    }
}

impl From<ChartChoice> for cylfuse_chart {
    fn from(chart: ChartChoice) -> Self {
        match chart {
            ChartChoice::Auto => Self::AUTO,
            ChartChoice::Local => Self::LOCAL,
            ChartChoice::Orthonormal => Self::ORTHONORMAL,
        }
    }
}

/// What given edge segments are for the objective ROBUST. No other looks for limbs in the image.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_edge_use(pub i32);

impl cylfuse_edge_use {
    /// A start: where there is a grey image, the limbs are located in it and join the fit.
    pub const REFINE: cylfuse_edge_use = cylfuse_edge_use(0);
    /// The measurement: no limbs are looked for in the image. The arcs of the ends are.
    pub const AS_GIVEN: cylfuse_edge_use = cylfuse_edge_use(1);

    pub(super) fn read(self, field: &str) -> Result<EdgeUse, Failure> {
        match self {
            Self::REFINE => Ok(EdgeUse::Refine),
            Self::AS_GIVEN => Ok(EdgeUse::AsGiven),
            _ => unknown(field, self.0, "0 (REFINE) or 1 (AS_GIVEN)"),
        }
    }
}

impl From<EdgeUse> for cylfuse_edge_use {
    fn from(edge_use: EdgeUse) -> Self {
        match edge_use {
            EdgeUse::Refine => Self::REFINE,
            EdgeUse::AsGiven => Self::AS_GIVEN,
        }
    }
}

/// How the ends of the visible cylinder are found.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_extent_rule(pub i32);

impl cylfuse_extent_rule {
    /// LOCATED for the objective ROBUST, EXTREMES for PAPER and for the methods other than FUSED.
    pub const AUTO: cylfuse_extent_rule = cylfuse_extent_rule(0);
    /// The rule of the paper: the extreme positions along the axis of the points completed over the mask.
    pub const EXTREMES: cylfuse_extent_rule = cylfuse_extent_rule(1);
    /// From all lines along the surface together, in the mask and, when there is one, in the grey image; from
    /// inside a pipe as EXTREMES.
    pub const LOCATED: cylfuse_extent_rule = cylfuse_extent_rule(2);

    pub(super) fn read(self, field: &str) -> Result<ExtentRule, Failure> {
        match self {
            Self::AUTO => Ok(ExtentRule::Auto),
            Self::EXTREMES => Ok(ExtentRule::Extremes),
            Self::LOCATED => Ok(ExtentRule::Located),
            _ => unknown(field, self.0, "0 (AUTO), 1 (EXTREMES) or 2 (LOCATED)"),
        }
    }
}

impl From<ExtentRule> for cylfuse_extent_rule {
    fn from(rule: ExtentRule) -> Self {
        match rule {
            ExtentRule::Auto => Self::AUTO,
            ExtentRule::Extremes => Self::EXTREMES,
            ExtentRule::Located => Self::LOCATED,
        }
    }
}

/// Why an iteration ended.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_termination(pub i32);

impl cylfuse_termination {
    /// There was no iteration: the method has none, or a given model was evaluated.
    pub const NONE: cylfuse_termination = cylfuse_termination(0);
    /// The cost no longer fell by more than the tolerance, or reached the rounding error of the data.
    pub const COST: cylfuse_termination = cylfuse_termination(1);
    /// No step down to the largest damping lowered the cost: a minimum to rounding.
    pub const STALLED: cylfuse_termination = cylfuse_termination(2);
    /// The limit of iterations was reached; `CYLFUSE_RESULT_FLAGS_NOT_CONVERGED` is set too.
    pub const MAX_ITERATIONS: cylfuse_termination = cylfuse_termination(3);
    /// The radius left all proportion to the data: they are flat.
    pub const RADIUS_RAN_AWAY: cylfuse_termination = cylfuse_termination(4);
}

impl From<Option<Termination>> for cylfuse_termination {
    fn from(termination: Option<Termination>) -> Self {
        match termination {
            None => Self::NONE,
            Some(Termination::Cost | Termination::Gradient | Termination::Step) => Self::COST,
            Some(Termination::Stalled) => Self::STALLED,
            Some(Termination::MaxIterations) => Self::MAX_ITERATIONS,
            Some(Termination::RadiusRanAway) => Self::RADIUS_RAN_AWAY,
        }
    }
}

/// What an end of the visible cylinder is.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_end_state(pub i32);

impl cylfuse_end_state {
    /// No depth was measured beyond the end, or no depth image was pushed.
    pub const UNKNOWN: cylfuse_end_state = cylfuse_end_state(0);
    /// The surface ends there: what lies beyond is farther than the surface would be.
    pub const SEEN: cylfuse_end_state = cylfuse_end_state(1);
    /// The border of the image cuts the cylinder off.
    pub const CUT: cylfuse_end_state = cylfuse_end_state(2);
    /// Something nearer than the surface covers what lies beyond.
    pub const HIDDEN: cylfuse_end_state = cylfuse_end_state(3);
}

impl From<EndState> for cylfuse_end_state {
    fn from(state: EndState) -> Self {
        match state {
            EndState::Unknown => Self::UNKNOWN,
            EndState::Seen => Self::SEEN,
            EndState::Cut => Self::CUT,
            EndState::Hidden => Self::HIDDEN,
        }
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

    pub(super) fn read(self, field: &str) -> Result<ResidualKind, Failure> {
        match self {
            Self::POINTS => Ok(ResidualKind::Points),
            Self::EDGES => Ok(ResidualKind::Edges),
            _ => unknown(field, self.0, "1 (POINTS) or 2 (EDGES)"),
        }
    }
}

/// What a fit is doing.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_phase(pub i32);

impl cylfuse_phase {
    /// It is about to look for a start.
    pub const START: cylfuse_phase = cylfuse_phase(1);
    /// It iterates.
    pub const SOLVE: cylfuse_phase = cylfuse_phase(2);
}

/// How much a log line matters.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_log_level(pub i32);

impl cylfuse_log_level {
    /// No lines.
    pub const OFF: cylfuse_log_level = cylfuse_log_level(0);
    /// Calls that failed, with the text of `cylfuse_fitter_last_error`.
    pub const ERROR: cylfuse_log_level = cylfuse_log_level(1);
    /// Doubts about a result, such as ignored edges.
    pub const WARNING: cylfuse_log_level = cylfuse_log_level(2);
    /// What was pushed, which start was taken, how a fit ended.
    pub const INFO: cylfuse_log_level = cylfuse_log_level(3);
    /// Every iteration.
    pub const DEBUG: cylfuse_log_level = cylfuse_log_level(4);

    pub(super) fn check(self, field: &str) -> Result<(), Failure> {
        match self.0 {
            0..=4 => Ok(()),
            _ => unknown(field, self.0, "0 (OFF), 1 (ERROR), 2 (WARNING), 3 (INFO) or 4 (DEBUG)"),
        }
    }
}

/// Doubts about a result, one bit each. None of them is an error.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_result_flags(pub u32);

impl cylfuse_result_flags {
    /// Segments were given but none of them counts; the other flags and the counts say why.
    pub const EDGES_IGNORED: cylfuse_result_flags = cylfuse_result_flags(1);
    /// Some segments have no length or lie outside the field of the camera model.
    pub const SEGMENTS_UNUSABLE: cylfuse_result_flags = cylfuse_result_flags(2);
    /// Two segments cross each other: they cannot be the two limbs.
    pub const EDGES_CROSS: cylfuse_result_flags = cylfuse_result_flags(4);
    /// Two segments lie on one line to within 2 pixels: they are the same limb.
    pub const EDGES_COINCIDE: cylfuse_result_flags = cylfuse_result_flags(8);
    /// The rays of the endpoints do not meet the plane of the limbs in front of the camera.
    pub const EDGES_BEHIND: cylfuse_result_flags = cylfuse_result_flags(16);
    /// The edges alone (an edge weight of 1) do not tell the scale: that of the start was kept.
    pub const SCALE_HELD: cylfuse_result_flags = cylfuse_result_flags(32);
    /// The data hardly determine the radius: see `condition`.
    pub const WEAK_RADIUS: cylfuse_result_flags = cylfuse_result_flags(64);
    /// The coordinates are coarser than 0.01 % of the radius: a float cloud far from the origin.
    pub const RESOLUTION_LOST: cylfuse_result_flags = cylfuse_result_flags(128);
    /// The limit of iterations came before convergence.
    pub const NOT_CONVERGED: cylfuse_result_flags = cylfuse_result_flags(256);
    /// Most points lie on the wall that the camera cannot see.
    pub const HIDDEN_WALL: cylfuse_result_flags = cylfuse_result_flags(512);
    /// The camera is inside the cylinder: there are no limbs.
    pub const CAMERA_INSIDE: cylfuse_result_flags = cylfuse_result_flags(1024);
    /// Points with coordinates that are not finite were left out.
    pub const POINTS_NOT_FINITE: cylfuse_result_flags = cylfuse_result_flags(2048);
    /// The radius by the points alone and the radius by the limbs differ by more than 4 standard deviations:
    /// `radius_from_points` and `radius_from_limbs` say how. An offset of the depth, depth that is smeared or bent,
    /// wrong intrinsics or edges that are not the limbs do that. Or the points alone, far from edges that were taken
    /// as given, would be another cylinder: one 1.5 times nearer to them, or surely 1.5 times as large or as small.
    pub const POINTS_AND_LIMBS_DISAGREE: cylfuse_result_flags = cylfuse_result_flags(4096);
    /// A limit of the radius holds it: the data want another one. Not for a radius that is known.
    pub const RADIUS_AT_LIMIT: cylfuse_result_flags = cylfuse_result_flags(8192);
    /// The axis is on the border of its cone: the data want another one. Not for a direction that is known.
    pub const AXIS_AT_LIMIT: cylfuse_result_flags = cylfuse_result_flags(16384);
}

#[cfg(test)]
mod tests;
