//! Options between the interface and the library.

use super::constants::cylfuse_image_use;
use super::status::Failure;
use super::structs::{cylfuse_detector_options, cylfuse_options};
use crate::detection::DetectionOptions;
use crate::error::not_negative;
use crate::fitter::Options;
use crate::geometry::{AxisCone, CylinderLimits};
use crate::noise::NoiseModel;
use crate::scene::DetectorOptions;
use crate::solver::IterationLimits;
use crate::start::ransac::check_max_iterations;

impl cylfuse_options {
    /// The options of the library.
    pub(super) fn read(&self) -> Result<Options, Failure> {
        // The library counts samples in `usize`, to which a number out of range need not go.
        check_max_iterations("options.ransac_max_iterations", self.ransac_max_iterations)?;
        Ok(Options {
            method: self.method.read("options.method")?,
            objective: self.objective.read("options.objective")?,
            edge_weight: self.edge_weight,
            start: self.start.read("options.start")?,
            near_wall: self.near_wall.read("options.near_wall")?,
            limits: IterationLimits {
                max_iterations: self.max_iterations as usize,
                initial_lambda: self.initial_lambda,
                lambda_factor: self.lambda_factor,
                max_lambda: self.max_lambda,
                cost_tolerance: self.cost_tolerance,
                gradient_tolerance: self.gradient_tolerance,
                step_tolerance: self.step_tolerance,
            },
            chart: self.chart.read("options.chart")?,
            threads: self.max_threads.max(1) as usize,
            seed: self.seed,
            ransac_iterations: usize::try_from(self.ransac_max_iterations).unwrap_or(usize::MAX),
            ransac_threshold: self.ransac_threshold,
            cylinder_limits: read_limits(
                (self.radius_min, self.radius_max),
                (self.axis, self.axis_max_angle),
            )?,
            edge_use: self.edge_use.read("options.edge_use")?,
            extent_rule: self.extent_rule.read("options.extent_rule")?,
            noise: self.read_noise()?,
            independent_points: self.independent_points,
        })
    }

    /// The standard deviations that a user may know, 0 where not.
    fn read_noise(&self) -> Result<NoiseModel, Failure> {
        let stated = [
            ("options.depth_noise", self.depth_noise),
            ("options.image_noise", self.image_noise),
            ("options.edge_noise", self.edge_noise),
            ("options.mask_noise", self.mask_noise),
            ("options.image_blur", self.image_blur),
            ("options.drawn_pixel", self.drawn_pixel),
        ];
        for (name, value) in stated {
            not_negative(name, value)?;
        }
        if !self.depth_shared.is_finite() {
            let requirement = "be finite; less than 0 = none";
            return Err(Failure::argument("options.depth_shared", self.depth_shared, requirement));
        }
        let default = NoiseModel::default();
        let or_default = |value: f64, default: f64| if value > 0.0 { value } else { default };
        Ok(NoiseModel {
            drawn_pixel: self.drawn_pixel,
            edge_endpoint: or_default(self.edge_noise, default.edge_endpoint),
            mask_side: or_default(self.mask_noise, default.mask_side),
            depth: self.depth_noise,
            depth_shared: if self.depth_shared < 0.0 {
                0.0
            } else {
                or_default(self.depth_shared, default.depth_shared)
            },
            image: self.image_noise,
            blur: self.image_blur,
            ..default
        })
    }
}

/// Limits of radius and axis, 0 where there is none.
fn read_limits(
    (radius_min, radius_max): (f64, f64),
    (axis, max_angle): ([f64; 3], f64),
) -> Result<CylinderLimits, Failure> {
    let axis = (axis != [0.0; 3]).then_some(AxisCone { direction: axis.into(), max_angle });
    if axis.is_none() && max_angle != 0.0 {
        let requirement = "be 0 without options.axis: give the direction that the angle is from";
        return Err(Failure::argument("options.axis_max_angle", max_angle, requirement));
    }
    let radius_max = if radius_max == 0.0 { f64::INFINITY } else { radius_max };
    Ok(CylinderLimits { radius_min, radius_max, axis })
}

/// The largest radius, 0 where there is none.
fn or_zero(radius_max: f64) -> f64 {
    if radius_max < f64::INFINITY { radius_max } else { 0.0 }
}

impl cylfuse_detector_options {
    /// The options of the library, with those of the fits.
    pub(super) fn read(&self, fit: &Options) -> Result<DetectorOptions, Failure> {
        let count = |given: u64| usize::try_from(given).unwrap_or(usize::MAX);
        Ok(DetectorOptions {
            search: DetectionOptions {
                limits: read_limits((self.radius_min, self.radius_max), (self.axis, self.axis_max_angle))?,
                max_count: if self.max_count == 0 { usize::MAX } else { count(self.max_count.into()) },
                min_pixels: count(self.min_pixels),
                min_score: self.min_score,
            },
            fit: *fit,
            use_image: self.image_use.read("options.image_use")?,
            threads: self.max_threads.max(1) as usize,
        })
    }
}

impl From<&DetectorOptions> for cylfuse_detector_options {
    fn from(options: &DetectorOptions) -> Self {
        let DetectionOptions { limits, max_count, min_pixels, min_score } = options.search;
        Self {
            struct_size: size_of::<Self>() as u32,
            image_use: match options.use_image {
                true => cylfuse_image_use::AUTO,
                false => cylfuse_image_use::IGNORE,
            },
            max_threads: saturated(options.threads.max(1)),
            max_count: u32::try_from(max_count).unwrap_or(0),
            min_pixels: min_pixels as u64,
            min_score,
            radius_min: limits.radius_min,
            radius_max: or_zero(limits.radius_max),
            axis: limits.axis.map_or([0.0; 3], |cone| cone.direction.into()),
            axis_max_angle: limits.axis.map_or(0.0, |cone| cone.max_angle),
        }
    }
}

impl From<&Options> for cylfuse_options {
    fn from(options: &Options) -> Self {
        let Options { limits, cylinder_limits, noise, .. } = options;
        let default = NoiseModel::default();
        let zero_if_default = |value: f64, default: f64| if value == default { 0.0 } else { value };
        Self {
            struct_size: size_of::<Self>() as u32,
            method: options.method.into(),
            objective: options.objective.into(),
            start: options.start.into(),
            near_wall: options.near_wall.into(),
            chart: options.chart.into(),
            edge_use: options.edge_use.into(),
            extent_rule: options.extent_rule.into(),
            max_threads: saturated(options.threads.max(1)),
            max_iterations: saturated(limits.max_iterations),
            cost_tolerance: limits.cost_tolerance,
            gradient_tolerance: limits.gradient_tolerance,
            step_tolerance: limits.step_tolerance,
            initial_lambda: limits.initial_lambda,
            lambda_factor: limits.lambda_factor,
            max_lambda: limits.max_lambda,
            edge_weight: options.edge_weight,
            seed: options.seed,
            ransac_max_iterations: options.ransac_iterations as u64,
            ransac_threshold: options.ransac_threshold,
            independent_points: options.independent_points,
            depth_noise: noise.depth,
            image_noise: noise.image,
            edge_noise: zero_if_default(noise.edge_endpoint, default.edge_endpoint),
            mask_noise: zero_if_default(noise.mask_side, default.mask_side),
            radius_min: cylinder_limits.radius_min,
            radius_max: or_zero(cylinder_limits.radius_max),
            axis: cylinder_limits.axis.map_or([0.0; 3], |cone| cone.direction.into()),
            axis_max_angle: cylinder_limits.axis.map_or(0.0, |cone| cone.max_angle),
            image_blur: noise.blur,
            drawn_pixel: noise.drawn_pixel,
            depth_shared: match noise.depth_shared {
                0.0 => -1.0,
                value => zero_if_default(value, default.depth_shared),
            },
        }
    }
}

/// A count that in practice always fits.
pub(super) fn saturated(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fitter::{ChartChoice, EdgeUse, ExtentRule, Method, NearWall, ObjectiveKind, StartKind};
    use nalgebra::Vector3;

    /// Every field with a value of its own, so that no two can be mixed up.
    fn distinct() -> Options {
        Options {
            method: Method::Eberly,
            objective: ObjectiveKind::Paper,
            edge_weight: 0.25,
            start: StartKind::Model,
            near_wall: NearWall::Off,
            limits: IterationLimits {
                max_iterations: 11,
                initial_lambda: 0.125,
                lambda_factor: 3.0,
                max_lambda: 1e6,
                cost_tolerance: 1e-9,
                gradient_tolerance: 1e-8,
                step_tolerance: 1e-7,
            },
            chart: ChartChoice::Orthonormal,
            threads: 5,
            seed: 1 << 40,
            ransac_iterations: 77,
            ransac_threshold: 0.5,
            cylinder_limits: CylinderLimits {
                radius_min: 0.25,
                radius_max: 4.0,
                axis: Some(AxisCone { direction: Vector3::new(5.0, 6.0, 7.0), max_angle: 0.75 }),
            },
            edge_use: EdgeUse::AsGiven,
            extent_rule: ExtentRule::Located,
            noise: NoiseModel {
                drawn_pixel: 2.0,
                edge_endpoint: 0.6,
                mask_side: 1.7,
                depth: 0.01,
                depth_shared: 0.004,
                image: 0.02,
                blur: 0.8,
                ..NoiseModel::default()
            },
            independent_points: 99.0,
        }
    }

    #[test]
    fn options_come_back_the_same() {
        let sharing_nothing = Options {
            noise: NoiseModel { depth_shared: 0.0, ..NoiseModel::default() },
            ..Options::default()
        };
        for options in [distinct(), Options { threads: 1, ..Options::default() }, sharing_nothing] {
            assert_eq!(cylfuse_options::from(&options).read().unwrap(), options);
        }
    }

    #[test]
    fn options_of_a_detector_come_back_the_same() {
        let distinct = DetectorOptions {
            search: DetectionOptions {
                limits: distinct().cylinder_limits,
                max_count: 7,
                min_pixels: 11,
                min_score: 0.125,
            },
            fit: Options { seed: 5, ..Options::default() },
            use_image: false,
            threads: 3,
        };
        for options in [distinct, DetectorOptions::default()] {
            assert_eq!(cylfuse_detector_options::from(&options).read(&options.fit).unwrap(), options);
        }
    }

    #[test]
    fn no_threads_are_one_thread() {
        let options = cylfuse_options { max_threads: 0, ..(&Options::default()).into() };
        assert_eq!(options.read().unwrap().threads, 1);
        assert_eq!(cylfuse_options::from(&Options::default()).max_threads, 1);
    }

    #[test]
    fn samples_of_ransac_are_limited_where_they_are_set() {
        let mut options = cylfuse_options::from(&Options::default());
        options.ransac_max_iterations = 2_000_000;
        let text = options.read().unwrap_err().to_string();
        assert_eq!(text, "options.ransac_max_iterations is 2000000; it must lie in [1, 1000000]");
    }
}
