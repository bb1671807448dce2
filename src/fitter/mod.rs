//! The fitter: takes observations, finds a start, minimises, and says how far to trust the result.

mod arcs;
mod edges;
mod guides;
mod limbs;
mod minimum;
mod options;
mod problem;
mod report;
mod result;
mod rough;
mod selection;
mod solve;
mod starts;
mod uncertainty;

pub use options::{ChartChoice, EdgeUse, ExtentRule, Method, NearWall, ObjectiveKind, Options, StartKind};
pub(crate) use problem::image_noise;
pub use report::{Diagnosis, ResidualKind};
pub use result::{FitResult, Flags, Seconds};
pub use uncertainty::{RadiusComparison, Uncertainty};

use crate::camera::{Camera, Intrinsics};
use crate::error::{Error, Result};
use crate::geometry::Cylinder;
#[cfg(doc)]
use crate::geometry::LimbFrame;
use crate::limb_location::{LimbObservation, blur_of};
use crate::observations::{
    DepthImage, DepthRange, DepthView, EdgeSegment, GreyImage, ImageView, Mask, MaskView, PointCloud,
    PointsView, check_same_size, check_segments,
};
use crate::residuals::ArcTerm;
use crate::solver::Iteration;
use limbs::Lines;
use starts::Candidate;
use std::ops::ControlFlow;
use std::time::Instant;

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
        // Lines and arcs were those in the image of the old one.
        self.forget_held();
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
                    // With a radius that no limb holds the arcs bend otherwise.
                    if lines.located > 0 {
                        let blur = limbs.as_ref().and_then(blur_of);
                        convergence = self.fit_to_arcs(&mut problem, convergence, blur, report)?;
                    }
                    problem.passing = false;
                    convergence = problem.minimise_again(&convergence, report)?;
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
}
