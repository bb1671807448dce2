//! The settings of a fit, each with its default, unit and reason.

use crate::error::{Error, Result, not_negative, positive};
use crate::geometry::CylinderLimits;
use crate::noise::NoiseModel;
use crate::solver::IterationLimits;
use crate::start::ransac::check_max_iterations;

/// How the cylinder is estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// Points and edges together, by the chosen [`ObjectiveKind`].
    #[default]
    Fused,
    /// Points alone by plain least squares, w_L = 0: Zhang et al., the paper's strongest baseline.
    Points,
    /// RANSAC with local optimisation, no final iteration.
    Ransac,
    /// Eberly's algebraic fit by moments, no final iteration.
    Eberly,
}

impl Method {
    /// Whether the method minimises an objective, so that its result has an uncertainty.
    pub(super) fn minimises(self) -> bool {
        matches!(self, Method::Fused | Method::Points)
    }
}

/// What the fused method minimises.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ObjectiveKind {
    /// Robust points and the endpoints' pixel distances, each weighted by its own scale. Takes any number of
    /// segments, none included.
    #[default]
    Robust,
    /// The paper's F = (1 − w_L) E_P + w_L E_L, exactly. Takes two segments, or w_L = 0.
    Paper,
}

/// Where the iteration starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum StartKind {
    /// The candidate of the kinds below that explains the data best.
    #[default]
    Auto,
    /// From two limb segments, scaled by the depth points.
    Limbs,
    /// Eberly's algebraic fit.
    Moments,
    /// RANSAC.
    Ransac,
    /// The model that the user gave.
    Model,
    /// The cylinder of the last successful fit of this fitter, for frames of a sequence, also after
    /// [`Fitter::clear`](super::Fitter::clear). Where the limbs are about where that or the points have them, and look in
    /// the image as they did, they are not searched: blur, light and background are those of the last image, and the
    /// result depends on the fits before. Where not, and before the first fit, as `Auto`, with that cylinder or a given
    /// model one of the candidates. Of points alone that hold several bodies the one near that cylinder is fitted.
    Last,
}

/// The coordinates of the steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ChartChoice {
    /// As the paper does for the paper's objective, in the local chart otherwise; also in the local chart where
    /// the orthonormal one has no footing: without a camera at the origin, and around a camera inside the pipe.
    #[default]
    Auto,
    /// Always shift and tilt of the axis at the data.
    Local,
    /// Always the orthonormal representation of the paper (6).
    Orthonormal,
}

/// Whether the points must lie on the wall that the camera sees.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum NearWall {
    /// On when intrinsics are set: only then is the origin known to be a camera.
    #[default]
    Auto,
    /// On: the origin is the observer.
    On,
    /// Off: the minimum nearest to the start stays.
    Off,
}

/// What given edge segments are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum EdgeUse {
    /// A start: where there is a grey image, the limbs are located in it and join the fit.
    #[default]
    Refine,
    /// The measurement: no limbs are looked for in the image. The arcs of the ends are.
    AsGiven,
}

/// How the ends of the visible cylinder are found in a mask. Without one, and from inside a pipe, the points on the surface tell them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ExtentRule {
    /// `Located` for the method `Fused` with the objective `Robust`, `Extremes` otherwise.
    #[default]
    Auto,
    /// The paper's rule: the extreme positions along the axis of the points completed over the mask.
    Extremes,
    /// From all generators together, in the mask and, when there is one, in the grey image.
    Located,
}

/// The settings of a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// How the cylinder is estimated.
    pub method: Method,
    /// What the fused method minimises.
    pub objective: ObjectiveKind,
    /// w_L of the paper's objective, 0.6 by default (its section 5.3).
    pub edge_weight: f64,
    /// Where the iteration starts.
    pub start: StartKind,
    /// Whether the points must lie on the wall that the camera sees.
    pub near_wall: NearWall,
    /// The coordinates of the steps.
    pub chart: ChartChoice,
    /// The constants of the iteration.
    pub limits: IterationLimits,
    /// Most threads for the sums over the points; 1, the default, starts none and 0 as many as the machine has. Small
    /// clouds take one anyway. The result has the same bits for any number.
    pub threads: usize,
    /// Seed of the random samples of RANSAC.
    pub seed: u64,
    /// Most random samples of RANSAC.
    pub ransac_iterations: usize,
    /// Distance within which RANSAC counts a point as an inlier, in the unit of the data; 0 = from the data.
    pub ransac_threshold: f64,
    /// What the returned cylinder keeps, whatever the method and the start: a start outside is moved inside. With
    /// limits the steps are in the local chart.
    pub cylinder_limits: CylinderLimits,
    /// What given edge segments are, for the robust objective; no other looks for limbs in the image.
    pub edge_use: EdgeUse,
    /// How the ends of the visible cylinder are found.
    pub extent_rule: ExtentRule,
    /// What is known of the errors of the data.
    pub noise: NoiseModel,
    /// The number of points of each view whose noise is independent; 0 = from the correlation of the residuals between
    /// neighbouring points. Neighbours in a depth image share matching windows and filters.
    pub independent_points: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            method: Method::Fused,
            objective: ObjectiveKind::Robust,
            edge_weight: 0.6,
            start: StartKind::Auto,
            near_wall: NearWall::Auto,
            chart: ChartChoice::Auto,
            limits: IterationLimits::default(),
            threads: 1,
            seed: 0,
            ransac_iterations: 1000,
            ransac_threshold: 0.0,
            cylinder_limits: CylinderLimits::default(),
            edge_use: EdgeUse::Refine,
            extent_rule: ExtentRule::Auto,
            noise: NoiseModel::default(),
            independent_points: 0.0,
        }
    }
}

impl Options {
    /// Whether the objective is the robust one.
    pub(crate) fn is_robust(&self) -> bool {
        self.method == Method::Fused && self.objective == ObjectiveKind::Robust
    }

    /// Whether the objective has the weight w_L.
    pub(crate) fn has_edge_weight(&self) -> bool {
        self.method == Method::Fused && self.objective == ObjectiveKind::Paper
    }

    /// Whether the ends are located, or the extremes of the mask taken.
    pub(crate) fn locates_ends(&self) -> bool {
        match self.extent_rule {
            ExtentRule::Auto => self.is_robust(),
            ExtentRule::Extremes => false,
            ExtentRule::Located => true,
        }
    }

    /// Checks every value.
    ///
    /// # Errors
    /// `InvalidArgument` that names the option as the other languages have it, its value and its limit.
    pub fn check(&self) -> Result<()> {
        if !(0.0..=1.0).contains(&self.edge_weight) {
            return Err(Error::argument("options.edge_weight", self.edge_weight, "lie in [0, 1]"));
        }
        let IterationLimits {
            max_iterations,
            initial_lambda,
            lambda_factor,
            max_lambda,
            cost_tolerance,
            gradient_tolerance,
            step_tolerance,
        } = self.limits;
        positive("options.initial_lambda", initial_lambda)?;
        if !(lambda_factor > 1.0 && lambda_factor.is_finite()) {
            return Err(Error::argument(
                "options.lambda_factor",
                lambda_factor,
                "be finite and greater than 1",
            ));
        }
        if !(max_lambda >= initial_lambda && max_lambda.is_finite()) {
            let requirement = format!("be finite and at least initial_lambda, {initial_lambda}");
            return Err(Error::argument("options.max_lambda", max_lambda, requirement));
        }
        if !(0.0..1.0).contains(&cost_tolerance) {
            return Err(Error::argument("options.cost_tolerance", cost_tolerance, "lie in [0, 1)"));
        }
        for (name, tolerance) in
            [("options.gradient_tolerance", gradient_tolerance), ("options.step_tolerance", step_tolerance)]
        {
            if !(0.0..1.0).contains(&tolerance) {
                return Err(Error::argument(name, tolerance, "lie in [0, 1)"));
            }
        }
        if max_iterations == 0 {
            return Err(Error::argument("options.max_iterations", max_iterations, "be at least 1"));
        }
        not_negative("options.ransac_threshold", self.ransac_threshold)?;
        check_max_iterations("options.ransac_max_iterations", self.ransac_iterations as u64)?;
        if !(self.independent_points >= 0.0 && self.independent_points.is_finite()) {
            let requirement = "be finite and at least 0; 0 = from the data";
            return Err(Error::argument("options.independent_points", self.independent_points, requirement));
        }
        self.noise.check().map_err(|error| error.in_struct("options.noise"))?;
        self.cylinder_limits.check().map_err(|error| error.in_struct("options"))
    }
}
