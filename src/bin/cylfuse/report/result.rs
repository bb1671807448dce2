//! What is said about the course of a fit.

use super::CylinderValues;
use cylfuse::fitter::Termination;
use cylfuse::fitter::{
    FitResult, ImageShift, Method, ObjectiveKind, Options, RadiusComparison, StartKind, Taper,
};
use cylfuse::geometry::CylinderLimits;
use cylfuse::observations::Dropped;
use serde::Serialize;

/// The fields of [`FitResult`], and the method.
#[derive(Debug, Serialize)]
pub struct ResultValues {
    method: &'static str,
    /// The objective of the fused method.
    pub objective: Option<&'static str>,
    cost: f64,
    energy_points: f64,
    energy_edges: Option<f64>,
    edge_weight: Option<f64>,
    /// Linear solves.
    pub iterations: usize,
    termination: Option<&'static str>,
    rejected_steps: Option<usize>,
    initial_cost: Option<f64>,
    /// Points that took part.
    pub points_used: usize,
    points_given: usize,
    dropped: DroppedValues,
    /// Segments that took part.
    pub segments_used: usize,
    segments_given: usize,
    /// Limbs that were located in the image.
    pub limbs_located: usize,
    point_rms: f64,
    /// Standard deviation of the points from the surface, by the median.
    pub point_scale: f64,
    independent_points: f64,
    /// Root mean square distance of the endpoints from the limb lines.
    pub edge_rms_pixels: Option<f64>,
    near_wall_fraction: Option<f64>,
    condition: f64,
    lambda: Option<f64>,
    gradient_norm: f64,
    step_norm: Option<f64>,
    radii: Option<RadiiValues>,
    shift: Option<ShiftValues>,
    taper: Option<TaperValues>,
    /// What the cylinder keeps; none without limits.
    limits: Option<LimitsValues>,
    start: CylinderValues,
    start_kind: &'static str,
    flags: Vec<String>,
}

/// Limits of radius and axis; an infinite radius is null.
#[derive(Debug, Serialize)]
struct LimitsValues {
    radius_min: f64,
    radius_max: f64,
    axis: Option<[f64; 3]>,
    axis_max_angle_degrees: Option<f64>,
}

impl LimitsValues {
    fn new(limits: &CylinderLimits) -> Option<Self> {
        (*limits != CylinderLimits::default()).then(|| Self {
            radius_min: limits.radius_min,
            radius_max: limits.radius_max,
            axis: limits.axis.map(|cone| cone.direction.into()),
            axis_max_angle_degrees: limits.axis.map(|cone| cone.max_angle.to_degrees()),
        })
    }
}

#[derive(Debug, Serialize)]
struct DroppedValues {
    not_finite: usize,
    zero_weight: usize,
    outside_mask: usize,
    no_depth: usize,
    out_of_range: usize,
    outside_camera: usize,
    hidden: usize,
}

/// By how much the radius grows along the axis, in parts of the length.
#[derive(Debug, Serialize)]
struct TaperValues {
    slope: f64,
    deviation: f64,
}

impl From<&Taper> for TaperValues {
    fn from(&Taper { slope, deviation }: &Taper) -> Self {
        Self { slope, deviation }
    }
}

/// The shift between depth and image across the axis, in pixels.
#[derive(Debug, Serialize)]
struct ShiftValues {
    pixels: f64,
    deviation: f64,
}

impl From<&ImageShift> for ShiftValues {
    fn from(&ImageShift { pixels, deviation }: &ImageShift) -> Self {
        Self { pixels, deviation }
    }
}

/// The radius by the points and by the limbs, each with its standard deviation.
#[derive(Debug, Serialize)]
struct RadiiValues {
    from_points: f64,
    from_points_deviation: f64,
    from_limbs: f64,
    from_limbs_deviation: f64,
    z_score: f64,
}

impl From<&RadiusComparison> for RadiiValues {
    fn from(radii: &RadiusComparison) -> Self {
        let RadiusComparison { from_points, from_points_deviation, from_limbs, from_limbs_deviation } =
            *radii;
        let z_score = radii.z_score();
        Self { from_points, from_points_deviation, from_limbs, from_limbs_deviation, z_score }
    }
}

impl ResultValues {
    /// What a fit with some options gives.
    pub fn new(options: &Options, result: &FitResult) -> Self {
        let fused = options.method == Method::Fused;
        // Methods without iterations have nothing to say about them.
        let iterated = result.termination.is_some();
        let Dropped { not_finite, zero_weight, outside_mask, no_depth, out_of_range, outside_camera, hidden } =
            result.dropped;
        Self {
            method: match options.method {
                Method::Fused => "fused",
                Method::Points => "points",
                Method::Ransac => "ransac",
                Method::Eberly => "eberly",
            },
            objective: fused.then_some(match options.objective {
                ObjectiveKind::Robust => "robust",
                ObjectiveKind::Paper => "paper",
            }),
            cost: result.cost,
            energy_points: result.energy_points,
            energy_edges: result.energy_edges,
            edge_weight: result.edge_weight,
            iterations: result.iterations,
            termination: result.termination.map(|termination| match termination {
                Termination::Cost => "cost",
                Termination::Gradient => "gradient",
                Termination::Step => "step",
                Termination::Stalled => "stalled",
                Termination::MaxIterations => "max_iterations",
                Termination::RadiusRanAway => "radius_ran_away",
            }),
            rejected_steps: iterated.then_some(result.rejected_steps),
            initial_cost: iterated.then_some(result.initial_cost),
            points_used: result.points_used,
            points_given: result.points_given,
            dropped: DroppedValues {
                not_finite,
                zero_weight,
                outside_mask,
                no_depth,
                out_of_range,
                outside_camera,
                hidden,
            },
            segments_used: result.segments_used,
            segments_given: result.segments_given,
            limbs_located: result.limbs_located,
            point_rms: result.point_rms,
            point_scale: result.point_scale,
            independent_points: result.independent_points,
            edge_rms_pixels: result.edge_rms_pixels,
            near_wall_fraction: result.near_wall_fraction,
            condition: result.condition,
            lambda: iterated.then_some(result.lambda),
            gradient_norm: result.gradient_norm,
            step_norm: iterated.then_some(result.step_norm),
            radii: result.radii.as_ref().map(RadiiValues::from),
            shift: result.shift.as_ref().map(ShiftValues::from),
            taper: result.taper.as_ref().map(TaperValues::from),
            limits: LimitsValues::new(&options.cylinder_limits),
            start: (&result.start).into(),
            start_kind: match result.start_kind {
                StartKind::Auto => "auto",
                StartKind::Limbs => "limbs",
                StartKind::Moments => "moments",
                StartKind::Ransac => "ransac",
                StartKind::Model => "model",
                StartKind::Last => "last",
            },
            flags: result.flags.iter_names().map(|(name, _)| name.to_lowercase()).collect(),
        }
    }
}
