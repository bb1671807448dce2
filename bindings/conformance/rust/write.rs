//! What a call gives, as numbers under the names of the C fields.

use super::names::*;
use cylfuse::extent::{EndSource, EndState, Extent};
use cylfuse::fitter::{FitResult, Fitter, Options, RadiusComparison, Termination, Uncertainty};
use cylfuse::geometry::Cylinder;
use cylfuse::noise::NoiseModel;
use nalgebra::{Matrix3, Vector3};

/// The numbers of every output.
pub type Fields = Vec<(String, Vec<f64>)>;

/// Outputs under their names.
#[derive(Default)]
pub struct Output(pub Fields);

impl Output {
    pub fn number(mut self, name: &str, value: impl Into<f64>) -> Self {
        self.0.push((name.into(), vec![value.into()]));
        self
    }

    pub fn count(self, name: &str, value: usize) -> Self {
        self.number(name, value as f64)
    }

    pub fn optional(self, name: &str, value: Option<f64>) -> Self {
        self.number(name, value.unwrap_or(f64::NAN))
    }

    pub fn list(mut self, name: &str, values: &[f64]) -> Self {
        self.0.push((name.into(), values.to_vec()));
        self
    }

    pub fn model(self, name: &str, cylinder: &Cylinder) -> Self {
        self.list(&format!("{name}.point"), cylinder.axis.point.as_slice())
            .list(&format!("{name}.direction"), cylinder.axis.direction.as_slice())
            .number(&format!("{name}.radius"), cylinder.radius)
    }
}

/// What a fit gives: the fields of both structs.
pub fn outcome(outcome: &FitResult) -> Fields {
    let mut fields = result(outcome).0;
    fields.extend(estimate(outcome).0);
    fields
}

fn termination(termination: Termination) -> f64 {
    match termination {
        Termination::Cost => 1.0,
        Termination::Stalled => 2.0,
        Termination::MaxIterations => 3.0,
        Termination::RadiusRanAway => 4.0,
        Termination::Gradient => 5.0,
        Termination::Step => 6.0,
    }
}

pub fn result(result: &FitResult) -> Output {
    Output::default()
        .number("flags", result.flags.bits())
        .number("termination", result.termination.map_or(0.0, termination))
        .count("iterations", result.iterations)
        .count("rejected_steps", result.rejected_steps)
        .count("limbs_located", result.limbs_located)
        .count("segments_given", result.segments_given)
        .count("segments_used", result.segments_used)
        .count("points_given", result.points_given)
        .count("points_used", result.points_used)
        .number("independent_points", result.independent_points)
        .number("point_deviation", result.point_scale)
        .number("point_rms", result.point_rms)
        .optional("edge_rms_pixels", result.edge_rms_pixels)
        .optional("near_wall_fraction", result.near_wall_fraction)
        .number("initial_cost", result.initial_cost)
        .number("cost", result.cost)
        .number("energy_points", result.energy_points)
        .optional("energy_edges", result.energy_edges)
        .optional("edge_weight", result.edge_weight)
        .number("condition", result.condition)
        .number("gradient_norm", result.gradient_norm)
        .number("step_norm", result.step_norm)
        .number("lambda", result.lambda)
}

pub fn estimate(result: &FitResult) -> Output {
    let uncertainty = result.uncertainty.as_ref();
    let radii = result.radii.as_ref();
    let covariance = uncertainty.map_or_else(|| vec![f64::NAN; 49], |u| u.covariance().as_slice().to_vec());
    Output::default()
        .number("start_kind", position(&result.start_kind, STARTS))
        .model("model", &result.cylinder)
        .model("start_model", &result.start)
        .optional("radius_deviation", uncertainty.map(Uncertainty::radius))
        .optional("direction_deviation", uncertainty.map(Uncertainty::direction))
        .optional("position_deviation", uncertainty.map(Uncertainty::position))
        .optional("radius_from_points", radii.map(|r| r.from_points))
        .optional("radius_from_points_deviation", radii.map(|r| r.from_points_deviation))
        .optional("radius_from_limbs", radii.map(|r| r.from_limbs))
        .optional("radius_from_limbs_deviation", radii.map(|r| r.from_limbs_deviation))
        .optional("radius_z_score", radii.map(RadiusComparison::z_score))
        .list("covariance", &covariance)
}

fn end_source(source: EndSource) -> f64 {
    match source {
        EndSource::Extreme => 0.0,
        EndSource::Mask => 1.0,
        EndSource::Image => 2.0,
        EndSource::Border => 3.0,
        EndSource::Points => 4.0,
    }
}

fn end_state(state: EndState) -> f64 {
    match state {
        EndState::Unknown => 0.0,
        EndState::Seen => 1.0,
        EndState::Cut => 2.0,
        EndState::Hidden => 3.0,
    }
}

pub fn extent(extent: &Extent) -> Fields {
    let uncertainty = extent.uncertainty.as_ref();
    let entries =
        |matrix: Option<&Matrix3<f64>>| matrix.map_or_else(|| vec![f64::NAN; 9], |m| m.as_slice().to_vec());
    Output::default()
        .number("start_state", end_state(extent.start_state))
        .number("end_state", end_state(extent.end_state))
        .number("start_source", end_source(extent.start_source))
        .number("end_source", end_source(extent.end_source))
        .count("start_view", extent.start_view)
        .count("end_view", extent.end_view)
        .number("limbs_known", extent.limbs_known)
        .list("start", extent.start.as_slice())
        .list("end", extent.end.as_slice())
        .list("center", extent.center.as_slice())
        .number("length", extent.length)
        .optional("start_deviation", extent.start_deviation)
        .optional("end_deviation", extent.end_deviation)
        .optional("length_deviation", uncertainty.map(|u| u.length))
        .list("start_covariance", &entries(uncertainty.map(|u| &u.start)))
        .list("end_covariance", &entries(uncertainty.map(|u| &u.end)))
        .list("center_covariance", &entries(uncertainty.map(|u| &u.center)))
        .0
}

pub fn options(options: &Options) -> Fields {
    let limits = &options.cylinder_limits;
    let (noise, usual) = (&options.noise, NoiseModel::default());
    let unless = |told: f64, usual: f64| if told == usual { 0.0 } else { told };
    let largest = if limits.radius_max.is_finite() { limits.radius_max } else { 0.0 };
    Output::default()
        .number("method", position(&options.method, METHODS))
        .number("objective", position(&options.objective, OBJECTIVES))
        .number("start", position(&options.start, STARTS))
        .number("near_wall", position(&options.near_wall, NEAR_WALLS))
        .number("chart", position(&options.chart, CHARTS))
        .count("max_iterations", options.limits.max_iterations)
        .count("max_threads", options.threads)
        .number("edge_weight", options.edge_weight)
        .number("initial_lambda", options.limits.initial_lambda)
        .number("lambda_factor", options.limits.lambda_factor)
        .number("max_lambda", options.limits.max_lambda)
        .number("cost_tolerance", options.limits.cost_tolerance)
        .number("gradient_tolerance", options.limits.gradient_tolerance)
        .number("step_tolerance", options.limits.step_tolerance)
        .number("independent_points", options.independent_points)
        .number("depth_noise", noise.depth)
        .number("image_noise", noise.image)
        .number("edge_noise", unless(noise.edge_endpoint, usual.edge_endpoint))
        .number("mask_noise", unless(noise.mask_side, usual.mask_side))
        .number("image_blur", noise.blur)
        .number("drawn_pixel", noise.drawn_pixel)
        .number(
            "depth_shared",
            match noise.depth_shared {
                0.0 => -1.0,
                told => unless(told, usual.depth_shared),
            },
        )
        .number("ransac_threshold", options.ransac_threshold)
        .number("seed", options.seed as f64)
        .count("ransac_max_iterations", options.ransac_iterations)
        .number("edge_use", position(&options.edge_use, EDGE_USES))
        .number("extent_rule", position(&options.extent_rule, EXTENT_RULES))
        .number("radius_min", limits.radius_min)
        .number("radius_max", largest)
        .list("axis", limits.axis.map_or(Vector3::zeros(), |cone| cone.direction).as_slice())
        .number("axis_max_angle", limits.axis.map_or(0.0, |cone| cone.max_angle))
        .0
}

pub fn counts(fitter: &Fitter) -> Fields {
    let cloud = fitter.cloud();
    let dropped = cloud.dropped();
    Output::default()
        .count("view", fitter.selected_view())
        .count("points_given", cloud.given())
        .count("points_used", cloud.len())
        .count("dropped_not_finite", dropped.not_finite)
        .count("dropped_zero_weight", dropped.zero_weight)
        .count("dropped_outside_mask", dropped.outside_mask)
        .count("dropped_no_depth", dropped.no_depth)
        .count("dropped_out_of_range", dropped.out_of_range)
        .count("dropped_outside_camera", dropped.outside_camera)
        .count("dropped_hidden", dropped.hidden)
        .count("segments_given", fitter.segments().len())
        .0
}
