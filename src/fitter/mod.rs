//! The fitter: takes observations, finds a start, minimises, and says how far to trust the result.

mod arcs;
mod edges;
mod guides;
mod limbs;
mod minimum;
mod options;
mod problem;
mod result;
mod rough;
mod selection;
mod solve;
mod starts;
mod uncertainty;

pub use options::{ChartChoice, EdgeUse, ExtentRule, Method, NearWall, ObjectiveKind, Options, StartKind};
pub use result::{FitResult, Flags, Seconds};
pub use uncertainty::{RadiusComparison, Uncertainty};

use crate::camera::{Camera, Intrinsics};
use crate::error::{Error, Result};
#[cfg(doc)]
use crate::geometry::LimbFrame;
use crate::geometry::{Cylinder, LocalFrame};
use crate::limb_location::LimbObservation;
use crate::observations::{
    DepthImage, DepthRange, DepthView, EdgeSegment, GreyImage, ImageView, Mask, MaskView, PointCloud,
    PointsView, check_same_size, check_segments,
};
use crate::residuals::ArcTerm;
use crate::solver::{Convergence, Iteration, LeastSquares, Rank, Termination};
use limbs::Lines;
use nalgebra::Vector3;
use problem::Problem;
use rough::CONTRADICTION;
use starts::Candidate;
use std::ops::ControlFlow;
use std::time::Instant;

/// A radius is called weak when its standard deviation would be more than this part of it, even if the noise
/// of all points were independent.
const WEAK_RADIUS: f64 = 0.05;

/// The input resolution, as a part of the radius, from which on digits are missing.
const COARSE: f64 = 1e-4;

/// Rounds of arcs and minimum: the first tilt may be off by degrees, and the arcs are looked for where it says.
const ARC_ROUNDS: usize = 2;

/// An axis that turned by less than this, in radians, leaves the arcs where they were found: at a radius of 25
/// pixels it moves them by a tenth of a pixel.
const SETTLED_TURN: f64 = 0.004;

/// Which residuals to list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResidualKind {
    /// Signed distance of every used point from the surface, in the unit of length.
    Points,
    /// Signed distance of every endpoint of the used segments from its limb line, in pixels.
    Edges,
}

/// What the data determine at a cylinder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Diagnosis {
    /// Rank, condition and singular values of the Jacobian, in units of the size of the data.
    pub rank: Rank,
    /// The step along which the residuals change least: how it moves the axis at the middle of the points, in
    /// the unit of length,
    pub weakest_shift: Vector3<f64>,
    /// how it tilts the axis, in radians towards this vector,
    pub weakest_tilt: Vector3<f64>,
    /// and how it changes the radius, in the unit of length.
    pub weakest_radius: f64,
}

/// Estimates one cylinder. Set intrinsics, push observations, call [`Fitter::fit`]; whatever fails leaves
/// everything as it was.
#[derive(Debug, Clone, Default)]
pub struct Fitter {
    options: Options,
    camera: Option<Camera>,
    start: Option<Cylinder>,
    cloud: PointCloud,
    segments: Vec<EdgeSegment>,
    mask: Option<Mask>,
    depth: Option<DepthImage>,
    image: Option<GreyImage>,
    /// What the last fit held the limbs to.
    lines: Option<Lines>,
    /// The arcs of the ends that it located in the image.
    arcs: ArcTerm,
    /// What the last fit saw of the limbs in the image.
    limbs: Option<[LimbObservation; 2]>,
    result: Option<FitResult>,
}

impl Fitter {
    /// A fitter with default options and no data.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The options.
    #[must_use]
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// Replaces the options.
    ///
    /// # Errors
    /// `InvalidArgument`; the old options stay then.
    pub fn set_options(&mut self, options: Options) -> Result<()> {
        options.check()?;
        self.options = options;
        self.forget_held();
        Ok(())
    }

    /// Sets the camera. Points that were pushed before stay as they are.
    ///
    /// # Errors
    /// `InvalidIntrinsics`; the old camera stays then.
    pub fn set_intrinsics(&mut self, intrinsics: Intrinsics) -> Result<()> {
        self.camera = Some(Camera::new(intrinsics)?);
        Ok(())
    }

    /// The camera.
    #[must_use]
    pub fn camera(&self) -> Option<&Camera> {
        self.camera.as_ref()
    }

    /// Sets or takes away the start model.
    pub fn set_start(&mut self, start: Option<Cylinder>) {
        self.start = start;
    }

    /// Adds points; a mask selects pixels of an organised cloud.
    ///
    /// # Errors
    /// See [`PointCloud::push_points`]. Nothing is added then.
    pub fn push_points(&mut self, points: &PointsView<'_>, mask: Option<&MaskView<'_>>) -> Result<()> {
        let mask = mask.map(Mask::copy).transpose()?;
        self.cloud.push_points(points, mask.as_ref())
    }

    /// Adds the points of a depth image; a mask selects pixels. Image and mask are kept, in place of earlier
    /// ones, for the extent and the completion.
    ///
    /// # Errors
    /// `BadState` without intrinsics, else see [`PointCloud::push_depth`]. Nothing is added then.
    pub fn push_depth(
        &mut self,
        depth: &DepthView<'_>,
        mask: Option<&MaskView<'_>>,
        range: &DepthRange,
    ) -> Result<()> {
        let camera = self.camera.as_ref().ok_or(Error::BadState {
            call: "pushing a depth image",
            missing: "intrinsics",
            remedy: "set the intrinsics first",
        })?;
        let mask = mask.map(Mask::copy).transpose()?;
        let image = DepthImage::copy(depth)?;
        self.cloud.push_depth(camera, depth, mask.as_ref(), range)?;
        self.depth = Some(image);
        self.mask = mask;
        self.forget_held();
        Ok(())
    }

    /// Adds edge segments in pixels of the (distorted) image.
    ///
    /// # Errors
    /// `InvalidArgument` for a bad number, `OutOfMemory`. Nothing is added then.
    pub fn push_edges(&mut self, segments: &[EdgeSegment]) -> Result<()> {
        check_segments(segments)?;
        let bytes = std::mem::size_of_val(segments);
        let out_of_memory = |_| Error::OutOfMemory { what: "the edge segments", bytes };
        self.segments.try_reserve(segments.len()).map_err(out_of_memory)?;
        self.segments.extend_from_slice(segments);
        self.forget_held();
        Ok(())
    }

    /// Takes a grey image on the grid of the camera, in place of an earlier one. The robust objective locates the
    /// limbs in it from the given edges, and the ends are located in it.
    ///
    /// # Errors
    /// `BadState` without intrinsics, `SizeMismatch` when it has another size than they, else see
    /// [`GreyImage::copy`]. The earlier image stays then.
    pub fn push_image(&mut self, image: &ImageView<'_>) -> Result<()> {
        let camera = self.camera.as_ref().ok_or(Error::BadState {
            call: "pushing an image",
            missing: "intrinsics",
            remedy: "set the intrinsics first",
        })?;
        let size = (image.width(), image.height());
        check_same_size("grey image", size, "the image of the intrinsics", camera.size())?;
        self.image = Some(GreyImage::copy(image)?);
        Ok(())
    }

    /// The grey image.
    #[must_use]
    pub fn image(&self) -> Option<&GreyImage> {
        self.image.as_ref()
    }

    /// Forgets data and result; keeps options, camera, start model and memory.
    pub fn clear(&mut self) {
        self.cloud.clear();
        self.segments.clear();
        self.mask = None;
        self.depth = None;
        self.image = None;
        self.forget_held();
        self.result = None;
    }

    /// Forgets what the last fit held the cylinder to: what it would be held to now is another matter.
    fn forget_held(&mut self) {
        self.lines = None;
        self.arcs = ArcTerm::default();
        self.limbs = None;
    }

    /// Makes room for that many more points and segments.
    ///
    /// # Errors
    /// `OutOfMemory`.
    pub fn reserve(&mut self, points: usize, segments: usize) -> Result<()> {
        self.cloud.reserve(points)?;
        let bytes = segments.saturating_mul(std::mem::size_of::<EdgeSegment>());
        let out_of_memory = |_| Error::OutOfMemory { what: "the edge segments", bytes };
        self.segments.try_reserve(segments).map_err(out_of_memory)
    }

    /// The points that were pushed.
    #[must_use]
    pub fn cloud(&self) -> &PointCloud {
        &self.cloud
    }

    /// The segments that were pushed.
    #[must_use]
    pub fn segments(&self) -> &[EdgeSegment] {
        &self.segments
    }

    /// The mask of the last depth image.
    #[must_use]
    pub fn mask(&self) -> Option<&Mask> {
        self.mask.as_ref()
    }

    /// The last depth image.
    #[must_use]
    pub fn depth(&self) -> Option<&DepthImage> {
        self.depth.as_ref()
    }

    /// The last successful fit.
    #[must_use]
    pub fn result(&self) -> Option<&FitResult> {
        self.result.as_ref()
    }

    /// What the last fit saw of the two limbs in the image, in the order of [`LimbFrame::limb_lines`]: lines, samples
    /// used and refused. `None` when the image was not searched: without an image, for edges as
    /// given, and for other objectives than the robust one.
    #[must_use]
    pub fn limbs(&self) -> Option<&[LimbObservation; 2]> {
        self.limbs.as_ref()
    }

    /// Estimates the cylinder.
    ///
    /// # Errors
    /// The data do not determine a cylinder (`TooFewPoints`, `PlanarPoints`, `CollinearPoints`, `NoStart`), or
    /// do not go with the options (`Unsupported`, `BadState`, `EdgeGeometry`).
    pub fn fit(&mut self) -> Result<FitResult> {
        self.fit_with(&mut |_| ControlFlow::Continue(()))
    }

    /// The same; `report` hears of every linear solve and may stop the fit.
    ///
    /// # Errors
    /// Those of [`Fitter::fit`], and `Cancelled`. The last result stays then.
    pub fn fit_with(&mut self, report: &mut dyn FnMut(&Iteration) -> ControlFlow<()>) -> Result<FitResult> {
        let clock = Instant::now();
        let mut problem = self.problem_of_data()?;
        let mut limbs = None;
        let mut lines = Lines::default();
        if report(&Iteration::before_start()).is_break() {
            return Err(Error::Cancelled { iterations: 0 });
        }
        let mut result = match self.options.method {
            Method::Eberly => {
                let cylinder = problem.moments_start().ok_or_else(|| Error::NoStart {
                    reason: "the moments of the points give no cylinder".into(),
                })?;
                problem.check_radius(&cylinder)?;
                self.describe(&problem, &Candidate { kind: StartKind::Moments, cylinder }, &cylinder)?
            }
            Method::Ransac => {
                let cylinder = problem.ransac()?.cylinder;
                problem.check_radius(&cylinder)?;
                self.describe(&problem, &Candidate { kind: StartKind::Ransac, cylinder }, &cylinder)?
            }
            Method::Fused | Method::Points => {
                problem.passing = self.locates();
                let rough = self.rough_fit(&mut problem, report)?;
                let started = clock.elapsed().as_secs_f64();
                let fit = self.fit_to_located(&mut problem, &rough, report)?;
                let (start, mut convergence) = (rough.start, fit.convergence);
                problem.limbs_located = fit.lines.located;
                lines = fit.lines;
                limbs = fit.observations;
                if problem.passing {
                    let scale = problem.point_scale(&convergence.cylinder);
                    // With a radius that no limb holds the arcs bend otherwise.
                    let rounds = if lines.located > 0 { ARC_ROUNDS } else { 0 };
                    for _ in 0..rounds {
                        let before = convergence.cylinder;
                        problem.arcs = self.locate_arcs(&problem, &before);
                        if problem.arcs.ends.is_empty() {
                            break;
                        }
                        let after = self.minimise_again(&problem, &convergence, report)?;
                        if problem.point_scale(&after.cylinder) > CONTRADICTION * scale {
                            // Something else than the ends.
                            problem.arcs = ArcTerm::default();
                            break;
                        }
                        convergence = after;
                        if before.axis.angle(&convergence.cylinder.axis) < SETTLED_TURN {
                            break;
                        }
                    }
                    problem.passing = false;
                    convergence = self.minimise_again(&problem, &convergence, report)?;
                }
                let mut result = self.describe(&problem, &start, &convergence.cylinder)?;
                result.add_convergence(&convergence);
                result.seconds.start = started;
                result.seconds.solve = clock.elapsed().as_secs_f64() - started;
                result
            }
        };
        result.limbs_located = lines.located;
        result.seconds.total = clock.elapsed().as_secs_f64();
        let arcs = std::mem::take(&mut problem.arcs);
        self.lines = Some(lines);
        self.arcs = arcs;
        self.limbs = limbs;
        self.result = Some(result);
        Ok(result)
    }

    /// Iterates on from a minimum, after something was added to the problem.
    fn minimise_again(
        &self,
        problem: &Problem<'_>,
        before: &Convergence,
        report: &mut dyn FnMut(&Iteration) -> ControlFlow<()>,
    ) -> Result<Convergence> {
        let mut after = problem.minimise(&before.cylinder, report)?;
        problem.check_radius(&after.cylinder)?;
        after.add_work_of(before);
        Ok(after)
    }

    /// What a fit would report for a given model, without iterating.
    ///
    /// # Errors
    /// `TooFewPoints` and the like as in [`Fitter::fit`]; `EdgeGeometry` where the cost is infinite.
    pub fn evaluate(&self, cylinder: &Cylinder) -> Result<FitResult> {
        let problem = self.problem()?;
        self.describe(&problem, &Candidate { kind: StartKind::Model, cylinder: *cylinder }, cylinder)
    }

    /// Residuals of a model, or of the last fit.
    ///
    /// # Errors
    /// `BadState` without a model and a result; `EdgeGeometry` for edges when there are no limbs.
    pub fn residuals(&self, cylinder: Option<&Cylinder>, kind: ResidualKind) -> Result<Vec<f64>> {
        let cylinder = self.model_or_result("listing residuals", cylinder)?;
        match kind {
            ResidualKind::Points => Ok(self.cloud.points().map(|p| cylinder.distance(&p)).collect()),
            ResidualKind::Edges => {
                let problem = self.problem_of_data()?;
                let Some(pixels) = &problem.pixels else { return Ok(Vec::new()) };
                let distances = pixels.distances(&cylinder).ok_or_else(|| Error::EdgeGeometry {
                    reason: "the camera is inside the cylinder, which has no limbs then".into(),
                    remedy: "ask for the residuals of the points",
                })?;
                Ok(distances.into_iter().flatten().collect())
            }
        }
    }

    /// Rank, condition and the weakest direction of the stacked Jacobian at a model, or at the last fit, by
    /// orthogonal factorisation.
    ///
    /// # Errors
    /// `BadState` without a model and a result, `EdgeGeometry` where the cost is infinite, `Numerical`.
    pub fn diagnose(&self, cylinder: Option<&Cylinder>) -> Result<Diagnosis> {
        let cylinder = self.model_or_result("diagnosing", cylinder)?;
        let problem = self.problem()?;
        let rows = problem.stacked_rows(&cylinder).ok_or_else(infinite_cost)?;
        let rank = LeastSquares::new(&rows)?.rank()?;
        let LocalFrame { u, v, unit, .. } = LocalFrame::new(&cylinder, &problem.center, problem.unit);
        let weakest = rank.weakest;
        Ok(Diagnosis {
            rank,
            weakest_shift: (u * weakest[0] + v * weakest[1]) * unit,
            weakest_tilt: u * weakest[2] + v * weakest[3],
            weakest_radius: weakest[4] * unit,
        })
    }

    /// The given model, or that of the last fit.
    pub(crate) fn model_or_result(
        &self,
        call: &'static str,
        cylinder: Option<&Cylinder>,
    ) -> Result<Cylinder> {
        let missing = Error::BadState { call, missing: "a model", remedy: "give one or fit first" };
        cylinder.copied().or(self.result.map(|result| result.cylinder)).ok_or(missing)
    }

    /// What the last fit minimised at its end.
    fn problem(&self) -> Result<Problem<'_>> {
        let mut problem = self.problem_of_data()?;
        if let Some(lines) = &self.lines {
            problem.hold_to(&lines.segments);
            problem.limbs_located = lines.located;
        }
        problem.arcs.clone_from(&self.arcs);
        Ok(problem)
    }

    fn problem_of_data(&self) -> Result<Problem<'_>> {
        let Self { options, cloud, camera, segments, start, .. } = self;
        Problem::new(options, cloud, camera.as_ref(), segments, start.as_ref())
    }

    /// Everything about a cylinder but how it was reached.
    fn describe(&self, problem: &Problem<'_>, start: &Candidate, cylinder: &Cylinder) -> Result<FitResult> {
        let equations = problem.linearise(cylinder).ok_or_else(infinite_cost)?;
        let squared = problem.unit * problem.unit;
        let frame = LocalFrame::new(cylinder, &problem.center, problem.unit);
        let energy_points = if self.cloud.is_empty() { 0.0 } else { problem.points.energy(&frame) };
        let eigenvalues = equations.hessian.symmetric_eigenvalues();
        let weak = {
            // As if the weights were the inverse variances and the noise independent.
            let freedom = self.cloud.len().saturating_sub(problem::LEAST_POINTS).max(1) as f64;
            let variance = equations.hessian.try_inverse().map_or(f64::INFINITY, |inverse| inverse[(4, 4)]);
            let deviation = problem.unit * (equations.cost * variance / freedom).sqrt();
            !problem.has_fixed_radius() && !(deviation <= WEAK_RADIUS * cylinder.radius)
        };
        let scale_held = problem.edge_weight == 1.0 && !problem.has_fixed_radius();
        let limits = &self.options.cylinder_limits;
        let inside = cylinder.contains_origin() && problem.near_wall;
        let walls = problem.near_wall.then(|| cylinder.visible_wall(self.cloud.points()));
        let mut flags = problem.edges.flags;
        flags.set(Flags::SCALE_HELD, scale_held);
        flags.set(Flags::WEAK_RADIUS, weak || scale_held);
        flags.set(Flags::RESOLUTION_LOST, self.cloud.resolution() > COARSE * cylinder.radius);
        flags.set(Flags::HIDDEN_WALL, walls.is_some_and(|walls| walls.fraction() < 0.5));
        flags.set(Flags::CAMERA_INSIDE, inside);
        flags.set(Flags::RADIUS_AT_LIMIT, limits.hold_radius(cylinder));
        flags.set(Flags::AXIS_AT_LIMIT, limits.hold_axis(cylinder));
        flags.set(Flags::POINTS_NOT_FINITE, self.cloud.dropped().not_finite > 0);
        let given = problem.edges.pixel_term(self.camera.as_ref());
        let edge_rms_pixels = given.and_then(|given| given.distances(cylinder)).map(|distances| {
            let sum: f64 = distances.iter().flatten().map(|d| d * d).sum();
            (sum / (2 * distances.len()) as f64).sqrt()
        });
        let canonical = problem.canonical(cylinder);
        let (uncertainty, radii) = problem.uncertainty(&canonical);
        flags.set(Flags::POINTS_AND_LIMBS_DISAGREE, radii.is_some_and(|radii| radii.disagree()));
        Ok(FitResult {
            cylinder: canonical,
            uncertainty,
            radii,
            start: start.cylinder,
            start_kind: start.kind,
            termination: None,
            iterations: 0,
            rejected_steps: 0,
            initial_cost: equations.cost * squared,
            cost: equations.cost * squared,
            energy_points,
            energy_edges: problem.limbs.and_then(|limbs| limbs.energy(cylinder)),
            edge_weight: problem.has_edge_weight().then_some(problem.edge_weight),
            points_used: self.cloud.len(),
            points_given: self.cloud.given(),
            dropped: *self.cloud.dropped(),
            segments_used: problem.segments_used(),
            segments_given: self.segments.len(),
            limbs_located: self.lines.as_ref().map_or(0, |lines| lines.located),
            point_rms: energy_points.sqrt(),
            edge_rms_pixels,
            near_wall_fraction: walls.map(|walls| walls.fraction()),
            condition: (eigenvalues.max() / eigenvalues.min().max(0.0)).sqrt(),
            lambda: 0.0,
            gradient_norm: limits.free_gradient(&frame, &equations.gradient).norm(),
            step_norm: 0.0,
            flags,
            seconds: Seconds::default(),
        })
    }
}

fn infinite_cost() -> Error {
    Error::EdgeGeometry {
        reason: "the cost of the model is infinite: the camera is inside it, or an endpoint lies behind it"
            .into(),
        remedy: "give another model or clear the segments",
    }
}

impl FitResult {
    fn add_convergence(&mut self, convergence: &Convergence) {
        self.termination = Some(convergence.termination);
        self.iterations = convergence.iterations;
        self.rejected_steps = convergence.rejected_steps;
        self.initial_cost = convergence.initial_cost;
        self.lambda = convergence.lambda;
        self.step_norm = convergence.step_norm;
        self.flags.set(Flags::NOT_CONVERGED, convergence.termination == Termination::MaxIterations);
    }
}
