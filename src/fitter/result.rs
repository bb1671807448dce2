//! What a fit returns.

use super::options::StartKind;
use super::taper::Taper;
use super::uncertainty::{ImageShift, RadiusComparison, Uncertainty};
use crate::geometry::Cylinder;
use crate::observations::Dropped;
use crate::solver::Termination;

bitflags::bitflags! {
    /// Warnings about a result. None of them is an error.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub struct Flags: u32 {
        /// Segments were given but none of them counts; the other flags and counts say why.
        const EDGES_IGNORED = 1;
        /// Some segments have no length or lie outside the field of the camera model.
        const SEGMENTS_UNUSABLE = 1 << 1;
        /// Two segments cross each other: they can't be the two limbs.
        const EDGES_CROSS = 1 << 2;
        /// Two segments lie on one line to within 2 px: they are the same limb.
        const EDGES_COINCIDE = 1 << 3;
        /// The rays of the endpoints do not meet the plane of the limbs in front of the camera.
        const EDGES_BEHIND = 1 << 4;
        /// The edges alone (w_L = 1) do not tell the scale: that of the start was kept.
        const SCALE_HELD = 1 << 5;
        /// The data hardly determine the radius: its standard deviation would be more than 5 % of it if all errors were independent, or
        /// is at least a quarter of it as stated, or the scale was held.
        const WEAK_RADIUS = 1 << 6;
        /// The coordinates are coarser than 0.01 % of the radius: an f32 cloud far from the origin.
        const RESOLUTION_LOST = 1 << 7;
        /// The limit of iterations came before convergence. Of a cylinder of a scene also: its depth came without an image,
        /// there was no work left for its fit, or no fit was as good, and it is what the search found.
        const NOT_CONVERGED = 1 << 8;
        /// Most points lie on the wall that the camera cannot see.
        const HIDDEN_WALL = 1 << 9;
        /// The camera is inside the cylinder: there are no limbs.
        const CAMERA_INSIDE = 1 << 10;
        /// Points with coordinates that are not finite were left out.
        const POINTS_NOT_FINITE = 1 << 11;
        /// The radius by the points alone and the radius by the limbs differ by more than 4 standard deviations: see
        /// [`FitResult::radii`]. Or the points alone, far from edges that were taken as given, would be another cylinder:
        /// one 1.5 times nearer to them, or surely 1.5 times as large or as small. Or a line that was located as a limb lies beside
        /// that of the result, by more than 4 of its standard deviations and a pixel. Or located limbs would raise the scale of the
        /// points 1.5 times, given edges 3 times, and were not followed.
        const POINTS_AND_LIMBS_DISAGREE = 1 << 12;
        /// The radius is at its limit, and the data fit better beyond it. Of a known radius: the data contradict it by more than 4
        /// standard deviations.
        const RADIUS_AT_LIMIT = 1 << 13;
        /// The axis is on the border of its cone, and the data fit better beyond it. Of a known direction: the data contradict it by
        /// more than 4 standard deviations.
        const AXIS_AT_LIMIT = 1 << 14;
        /// The data do not tell how uncertain the result is: fewer than eight points are independent, some degree of
        /// freedom is not determined, the coordinates are coarser than the noise of the points, or most points lie on the
        /// cylinder to the last digit and more than a tenth do not, as of a few pixels of depth in coarse steps. Only with the
        /// methods fused and points: the others never state an uncertainty.
        const UNCERTAINTY_UNKNOWN = 1 << 15;
        /// Depth and image are shifted against each other across the axis by more than 3 standard deviations: see
        /// [`FitResult::shift`]. Or one of the limbs is the edge of something else, and the radius is wrong. From a detector also: the
        /// whole depth image was shifted, and has been moved: its scene says by how much.
        const DEPTH_SHIFTED = 1 << 16;
        /// A mask holds the pixels that have depth and no others, although depth is missing around it: its sides are no hint
        /// where the limbs are. With an image they were drawn again about the cylinder of a first fit.
        const MASK_ENDS_WITH_DEPTH = 1 << 17;
        /// The points do not lie on the cylinder: they scatter about its surface ([`FitResult::point_scale`]) by more than
        /// 1 % of their distance from the camera, which no depth camera does, and by more than three times the noise of
        /// depth where the caller states it; without a camera, by more than a quarter of the radius. Or what they leave has a shape
        /// along the axis that no cylinder has: that of a pipe that is bent or a sphere, with 2 % of the radius and more
        /// and more than all that is left beside it. Or two planes, as of the sides of a box, leave at most half of the
        /// variance that a cylinder leaves. Or points without a mask lie on several surfaces, and the cylinder has less than half of
        /// those on no plane or less than a quarter of all, or a plane holds a quarter of its own. Or they are off the cylinder together
        /// by a twentieth of the radius: fewer than a fiftieth of them are independent.
        const POOR_FIT = 1 << 18;
        /// The lines of both limbs turn against each other, so that the radius changes along the axis: by more than 3 standard
        /// deviations of [`FitResult::taper`] with 0.3 % of the length added for the lens. The body is no cylinder, or one
        /// of the lines is no limb. Or, where fewer than two limbs were located or given, the sides of the mask converge: by more
        /// than 3 standard deviations, and by a slope of the radius of more than 0.05. Or points without a camera tell a taper, by as
        /// much as limbs: seen from one side, their axis may tilt by as much as the radius changes, which is in its stated deviation.
        const BODY_TAPERS = 1 << 19;
        /// The mask ends beside a limb of the cylinder along most of the axis: by more than masks are off (5 pixels of 640 × 480,
        /// or three times the noise of masks where that is more), by more than 3 standard deviations of the radius, and not because
        /// something in front or the border of the image ends it. Only where fewer than two limbs were located or given. Or no limb was
        /// seen, and the radius by the sides of the mask and that by the points differ by more than 2.5 standard deviations, or the
        /// points would scatter 3 times as much if the sides were followed. Or the mask holds another body: more than a tenth of its
        /// pixels, without those beside its outline, have points outside of the cylinder and of its lids and rings. Where an image but
        /// no mask was pushed, that is said of the points. The sides are not checked of a mask that ends where the depth does or was
        /// made of the points. Nothing is checked of the region of a detector, nor where the camera is inside the cylinder.
        const MASK_DISAGREES = 1 << 20;
    }
}

/// Wall-clock seconds by phase.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Seconds {
    /// Finding the start.
    pub start: f64,
    /// Iterating.
    pub solve: f64,
    /// Everything, checks included.
    pub total: f64,
}

/// The outcome of a fit, with the numbers to judge it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct FitResult {
    /// The cylinder. Its axis point is the one nearest to the middle of the points; the largest component of
    /// its direction is positive.
    pub cylinder: Cylinder,
    /// Standard deviations and covariance of the cylinder; `None` where none is known: for RANSAC and Eberly's fit,
    /// which minimise nothing, for w_L = 1, and where the data do not determine a cylinder.
    pub uncertainty: Option<Uncertainty>,
    /// The radius by the points and by the limbs; `None` without an uncertainty, where the points alone determine no
    /// cylinder, and where limbs add nothing.
    pub radii: Option<RadiusComparison>,
    /// The shift between depth and image across the axis; `None` unless both limbs of a single view were located.
    pub shift: Option<ImageShift>,
    /// By how much the radius grows along the axis; `None` unless a line was found at each limb of a single view, where one that
    /// the fit refused counts, or points of a single view without a camera tell it by more than 3 standard deviations: theirs comes
    /// out up to a tenth too small.
    pub taper: Option<Taper>,
    /// The model that the iteration started from, moved into the limits; the largest component of its direction is
    /// positive.
    pub start: Cylinder,
    /// How that start was found; never `Auto`. `Model` also where points alone were searched for the body.
    pub start_kind: StartKind,
    /// Why the iteration ended; `None` for the methods that do not iterate.
    pub termination: Option<Termination>,
    /// Iterations: linear systems that were solved.
    pub iterations: usize,
    /// Solves whose step was rejected.
    pub rejected_steps: usize,
    /// The cost F of the start, in the unit of length squared.
    pub initial_cost: f64,
    /// The cost F of the cylinder, in the unit of length squared.
    pub cost: f64,
    /// E_P: mean squared distance of the points (16).
    pub energy_points: f64,
    /// E_L: mean squared distance of the back-projected endpoints (25); `None` without two usable segments.
    pub energy_edges: Option<f64>,
    /// The w_L that was used: 0 when no edges count. `None` where the objective has no such weight.
    pub edge_weight: Option<f64>,
    /// Points that took part.
    pub points_used: usize,
    /// Points that were pushed.
    pub points_given: usize,
    /// Points that were left out, by reason.
    pub dropped: Dropped,
    /// Segments that took part.
    pub segments_used: usize,
    /// Segments that were pushed.
    pub segments_given: usize,
    /// Limb lines that were located in the image and took part.
    pub limbs_located: usize,
    /// Root of E_P.
    pub point_rms: f64,
    /// Standard deviation σ of the distances of good points by their median, in the unit of length: the noise of the
    /// points across the surface.
    pub point_scale: f64,
    /// The number of points whose noise is independent, estimated or as the options say, over all views.
    pub independent_points: f64,
    /// Root mean square distance in pixels of the given endpoints from the limb lines; `None` without edges.
    pub edge_rms_pixels: Option<f64>,
    /// The part of the points on the wall that the camera sees; `None` when the origin is no camera.
    pub near_wall_fraction: Option<f64>,
    /// Condition number of the Jacobian at the cylinder, in units of the size of the data.
    pub condition: f64,
    /// The last damping.
    pub lambda: f64,
    /// Norm of half the gradient of the cost at the end, as far as the limits leave it free, in units of the size of
    /// the data.
    pub gradient_norm: f64,
    /// Norm of the last accepted step, in units of the size of the data.
    pub step_norm: f64,
    /// Warnings: reasons to look twice.
    pub flags: Flags,
    /// Time spent.
    pub seconds: Seconds,
}
