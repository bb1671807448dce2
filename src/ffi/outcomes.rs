//! The constants of results: integers, as in `constants`.

use crate::extent::{EndSource, EndState};
use crate::fitter::{Conformity, Part};
use crate::limb_location::NotVisible;
use crate::solver::Termination;

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
    /// The gradient fell below its tolerance.
    pub const GRADIENT: cylfuse_termination = cylfuse_termination(5);
    /// The step fell below its tolerance.
    pub const STEP: cylfuse_termination = cylfuse_termination(6);
}

impl From<Option<Termination>> for cylfuse_termination {
    fn from(termination: Option<Termination>) -> Self {
        match termination {
            None => Self::NONE,
            Some(Termination::Cost) => Self::COST,
            Some(Termination::Gradient) => Self::GRADIENT,
            Some(Termination::Step) => Self::STEP,
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
    /// No depth was measured beyond the end, or nothing tells what lies beyond, or no depth image was pushed.
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

/// What the position of an end was taken from.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_end_source(pub i32);

impl cylfuse_end_source {
    /// The extreme point completed over the mask: by the extent rule EXTREMES, or where no line along the surface ends in
    /// the mask.
    pub const EXTREME: cylfuse_end_source = cylfuse_end_source(0);
    /// Where the lines along the surface leave the mask, or where within the mask the depth shows that the body ends: at a cap,
    /// an opening, a shoulder or a narrower part. Also where the image shows an arc that is less certain than that.
    pub const MASK: cylfuse_end_source = cylfuse_end_source(1);
    /// Mostly the arc of the end circle in the image: it is joined with mask and depth by the variances, and is the more
    /// certain.
    pub const IMAGE: cylfuse_end_source = cylfuse_end_source(2);
    /// The last of the surface inside the border of the image.
    pub const BORDER: cylfuse_end_source = cylfuse_end_source(3);
    /// The points on the surface, where there is no mask, and from inside a pipe.
    pub const POINTS: cylfuse_end_source = cylfuse_end_source(4);
}

impl From<EndSource> for cylfuse_end_source {
    fn from(source: EndSource) -> Self {
        match source {
            EndSource::Extreme => Self::EXTREME,
            EndSource::Mask => Self::MASK,
            EndSource::Image => Self::IMAGE,
            EndSource::Border => Self::BORDER,
            EndSource::Points => Self::POINTS,
        }
    }
}

/// Whether a limb was located in the image, or why not.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_limb_status(pub i32);

impl cylfuse_limb_status {
    /// It was located.
    pub const LOCATED: cylfuse_limb_status = cylfuse_limb_status(0);
    /// The image was not searched: there is none, the edges were taken as given, or the objective does not look.
    pub const NOT_SEARCHED: cylfuse_limb_status = cylfuse_limb_status(1);
    /// The cylinder has no limbs in front of the camera: the camera is inside it, or it lies behind.
    pub const NO_LIMBS: cylfuse_limb_status = cylfuse_limb_status(2);
    /// Fewer than 12 rows or columns of the image show the limb, or something in front covers it.
    pub const TOO_SHORT: cylfuse_limb_status = cylfuse_limb_status(3);
    /// No line near the expected position has more of an edge than noise gives.
    pub const NO_EDGE: cylfuse_limb_status = cylfuse_limb_status(4);
    /// The line left the expected position while it was refined, or lies beside the mask.
    pub const OUT_OF_REACH: cylfuse_limb_status = cylfuse_limb_status(5);
    /// The line would be less certain than one set by hand, or what is there is softer than any limb.
    pub const UNCERTAIN: cylfuse_limb_status = cylfuse_limb_status(6);
    /// A small part of the line carries it all.
    pub const PATCHY: cylfuse_limb_status = cylfuse_limb_status(7);
    /// The other limb was found at the same position, and more certainly.
    pub const SAME_LINE: cylfuse_limb_status = cylfuse_limb_status(8);
}

impl From<NotVisible> for cylfuse_limb_status {
    fn from(reason: NotVisible) -> Self {
        match reason {
            NotVisible::NoLimbs => Self::NO_LIMBS,
            NotVisible::TooShort => Self::TOO_SHORT,
            NotVisible::NoEdge => Self::NO_EDGE,
            NotVisible::OutOfReach => Self::OUT_OF_REACH,
            NotVisible::Uncertain => Self::UNCERTAIN,
            NotVisible::Patchy => Self::PATCHY,
            NotVisible::SameLine => Self::SAME_LINE,
        }
    }
}

/// What a point in the mask belongs to.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_part(pub u8);

impl cylfuse_part {
    /// The lateral surface.
    pub const BODY: cylfuse_part = cylfuse_part(1);
    /// A cap: it lies in the plane across the axis at an end.
    pub const CAP: cylfuse_part = cylfuse_part(2);
    /// The inside of the cylinder, seen through an open end: its inner wall or its bottom.
    pub const INNER_WALL: cylfuse_part = cylfuse_part(3);
    /// Something nearer than the surface: a lid or a rim that is wider, a handle, what stands in front.
    pub const OTHER: cylfuse_part = cylfuse_part(4);
    /// Something farther away than the cylinder: the background.
    pub const BEHIND: cylfuse_part = cylfuse_part(5);
}

impl From<Part> for cylfuse_part {
    fn from(part: Part) -> Self {
        match part {
            Part::Body => Self::BODY,
            Part::Cap => Self::CAP,
            Part::InnerWall => Self::INNER_WALL,
            Part::Other => Self::OTHER,
            Part::Behind => Self::BEHIND,
        }
    }
}

/// What a measurement says about a tolerance.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_conformity(pub i32);

impl cylfuse_conformity {
    /// The measurement does not tell: its uncertainty reaches over a limit or is not known, or a warning puts it in
    /// doubt.
    pub const UNDECIDED: cylfuse_conformity = cylfuse_conformity(0);
    /// The value is within the limits with all of its uncertainty.
    pub const CONFORMING: cylfuse_conformity = cylfuse_conformity(1);
    /// The value is outside the limits with all of its uncertainty.
    pub const NOT_CONFORMING: cylfuse_conformity = cylfuse_conformity(2);
}

impl From<Conformity> for cylfuse_conformity {
    fn from(conformity: Conformity) -> Self {
        match conformity {
            Conformity::Undecided => Self::UNDECIDED,
            Conformity::Conforming => Self::CONFORMING,
            Conformity::NotConforming => Self::NOT_CONFORMING,
        }
    }
}

/// What a fit is doing.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_phase(pub i32);

impl cylfuse_phase {
    /// It is about to look for a start, or looks for one and asks whether to go on.
    pub const START: cylfuse_phase = cylfuse_phase(1);
    /// It iterates, or asks after an iteration whether to go on: the last state is reported again then.
    pub const SOLVE: cylfuse_phase = cylfuse_phase(2);
}

/// What a detector is doing.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct cylfuse_detection_phase(pub i32);

impl cylfuse_detection_phase {
    /// It is about to look for cylinders.
    pub const SEARCH: cylfuse_detection_phase = cylfuse_detection_phase(1);
    /// It fits those that were found.
    pub const FIT: cylfuse_detection_phase = cylfuse_detection_phase(2);
}

/// Warnings about a result, one bit each. None of them is an error: the numbers of the result say how much it matters.
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
    /// The data hardly determine the radius: see `radius_deviation`.
    pub const WEAK_RADIUS: cylfuse_result_flags = cylfuse_result_flags(64);
    /// The coordinates are coarser than 0.01 % of the radius: a float cloud far from the origin.
    pub const RESOLUTION_LOST: cylfuse_result_flags = cylfuse_result_flags(128);
    /// The limit of iterations came before convergence. Of a cylinder of a scene also: its depth came without an image,
    /// no work was left for its fit (see `cylfuse_detector_is_complete`), or no fit was as good, and it is what the search found.
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
    /// as given, would be another cylinder: one 1.5 times nearer to them, or surely 1.5 times as large or as small. Or a
    /// line that was located as a limb lies beside that of the result, by more than 4 of its standard deviations and a
    /// pixel. Or located limbs would raise the scale of the points 1.5 times, given edges 3 times, and were not followed.
    pub const POINTS_AND_LIMBS_DISAGREE: cylfuse_result_flags = cylfuse_result_flags(4096);
    /// The radius is at its limit, and the data fit better beyond it. Of a radius that is known: the data contradict it by
    /// more than 4 standard deviations.
    pub const RADIUS_AT_LIMIT: cylfuse_result_flags = cylfuse_result_flags(8192);
    /// The axis is on the border of its cone, and the data fit better beyond it. Of a known direction: the data contradict
    /// it by more than 4 standard deviations.
    pub const AXIS_AT_LIMIT: cylfuse_result_flags = cylfuse_result_flags(16384);
    /// The data do not tell how uncertain the result is, and deviations and covariance are NaN: fewer than eight points
    /// are independent, some degree of freedom is not determined, the coordinates are coarser than the noise of the points
    /// (RESOLUTION_LOST), or most points lie on the cylinder to the last digit and more than a tenth do not, as of a few
    /// pixels of depth in coarse steps. Only with the methods FUSED and POINTS: the others never state an uncertainty.
    pub const UNCERTAINTY_UNKNOWN: cylfuse_result_flags = cylfuse_result_flags(32768);
    /// Depth and image are shifted against each other across the axis, by a wrong registration or wrong principal points:
    /// the points lie beside the middle of the limbs by more than 3 standard deviations. Or one of the limbs is the edge of
    /// something else, such as a neighbour that touches, and the radius is wrong. From a detector also: the whole depth image
    /// was shifted, and has been moved to where the image shows the same bodies.
    pub const DEPTH_SHIFTED: cylfuse_result_flags = cylfuse_result_flags(65536);
    /// A mask holds the pixels that have depth and no others, although depth is missing around it, as it is beside the limbs
    /// of a curved surface: its sides are no hint where the limbs are. With an image they were drawn again about the
    /// cylinder of a first fit; a mask of the whole surface is more certain.
    pub const MASK_ENDS_WITH_DEPTH: cylfuse_result_flags = cylfuse_result_flags(131072);
    /// The points do not lie on the cylinder, so its numbers mean nothing: `point_deviation` is more than 1 % of their
    /// distance from the camera, and more than three times `depth_noise` of the options where that is set; without a
    /// camera, more than a quarter of the radius. A mask that holds much else than the cylinder does that, or wrong poses.
    /// Or what they leave has a shape along the axis that no cylinder has, as a bent pipe or a sphere does. Or they lie on two
    /// planes, as the sides of a box do. Or points without a mask lie on several surfaces: the cylinder has less than half
    /// of those that are on no plane or less than a quarter of all, or a plane holds a quarter of its own. Or they are off the
    /// cylinder together by a twentieth of the radius: fewer than a fiftieth of them are independent.
    pub const POOR_FIT: cylfuse_result_flags = cylfuse_result_flags(262144);
    /// The lines that the image shows of both limbs turn against each other, so that the radius changes along the axis: by more
    /// than 3 standard deviations with 0.3 % of the length added for the lens. The body is no cylinder, or one of the lines
    /// is no limb. Or, where fewer than two limbs of a view were located or given, the sides of the mask converge: by more
    /// than 3 standard deviations, and by a slope of the radius of more than 0.05. Or points without a camera tell it, as the limbs do:
    /// seen from one side, their axis may tilt by as much as the radius changes, which is in its stated deviation.
    pub const BODY_TAPERS: cylfuse_result_flags = cylfuse_result_flags(524288);
    /// The mask ends beside a limb of the cylinder along most of the axis: by more than masks are off (5 pixels of an
    /// image of 640 x 480, or three times `mask_noise` where that is more), by more than 3 standard deviations of the radius,
    /// and not because something in front or the border of the image ends it. Depth and image are misaligned, the depth is
    /// smeared beyond the body, or the mask holds something else. Only where fewer than two limbs of a view were located or
    /// given. Or no limb was seen, and the radius by the sides of the mask and that by the points differ by more than 2.5
    /// standard deviations, or the points would scatter 3 times as much if the sides were followed. Or the mask holds another
    /// body: more than a tenth of its pixels, without those beside its outline, have points outside of the cylinder and of its
    /// lids and rings. Where an image but no mask was pushed, that is said of the points. The sides are not checked of a mask
    /// that ends where the depth does (MASK_ENDS_WITH_DEPTH) or was made of the points. Nothing is checked of the region of a
    /// detector, nor where the camera is inside the cylinder.
    pub const MASK_DISAGREES: cylfuse_result_flags = cylfuse_result_flags(1048576);
}
