//! Options between the interface and the library.

use super::sized::check_reserved;
use super::status::Failure;
use super::structs::cylfuse_options;
use crate::fitter::Options;
use crate::geometry::{AxisCone, CylinderLimits};
use crate::solver::IterationLimits;

impl cylfuse_options {
    /// The options of the library; those that may be left 0 become the default.
    pub(super) fn read(&self) -> Result<Options, Failure> {
        check_reserved("options.reserved", self.reserved)?;
        let default = Options::default();
        let number = |value: f64, default: f64| if value == 0.0 { default } else { value };
        let count = |value: u32, default: usize| if value == 0 { default } else { value as usize };
        Ok(Options {
            method: self.method.read("options.method")?,
            objective: self.objective.read("options.objective")?,
            edge_weight: self.edge_weight,
            start: self.start.read("options.start")?,
            near_wall: self.near_wall.read("options.near_wall")?,
            limits: IterationLimits {
                max_iterations: count(self.max_iterations, default.limits.max_iterations),
                initial_lambda: number(self.initial_lambda, default.limits.initial_lambda),
                lambda_factor: number(self.lambda_factor, default.limits.lambda_factor),
                max_lambda: number(self.max_lambda, default.limits.max_lambda),
                cost_tolerance: self.cost_tolerance,
                ..default.limits
            },
            chart: self.chart.read("options.chart")?,
            threads: self.max_threads as usize,
            seed: self.seed,
            ransac_iterations: count(self.ransac_max_iterations, default.ransac_iterations),
            ransac_threshold: self.ransac_threshold,
            cylinder_limits: CylinderLimits {
                radius_min: self.radius_min,
                radius_max: number(self.radius_max, f64::INFINITY),
                axis: self.read_axis()?,
            },
            edge_use: self.edge_use.read("options.edge_use")?,
            extent_rule: self.extent_rule.read("options.extent_rule")?,
            ..default
        })
    }

    fn read_axis(&self) -> Result<Option<AxisCone>, Failure> {
        let cone = AxisCone { direction: self.axis.into(), max_angle: self.axis_max_angle };
        if self.axis != [0.0; 3] {
            return Ok(Some(cone));
        }
        if cone.max_angle != 0.0 {
            let requirement = "be 0 without options.axis: give the direction that the angle is from";
            return Err(Failure::argument("options.axis_max_angle", cone.max_angle, requirement));
        }
        Ok(None)
    }
}

impl From<&Options> for cylfuse_options {
    fn from(options: &Options) -> Self {
        let Options { limits, cylinder_limits, .. } = options;
        Self {
            struct_size: size_of::<Self>() as u32,
            method: options.method.into(),
            objective: options.objective.into(),
            start: options.start.into(),
            near_wall: options.near_wall.into(),
            chart: options.chart.into(),
            max_iterations: saturated(limits.max_iterations),
            max_threads: saturated(options.threads),
            edge_weight: options.edge_weight,
            initial_lambda: limits.initial_lambda,
            lambda_factor: limits.lambda_factor,
            max_lambda: limits.max_lambda,
            cost_tolerance: limits.cost_tolerance,
            ransac_threshold: options.ransac_threshold,
            seed: options.seed,
            ransac_max_iterations: saturated(options.ransac_iterations),
            reserved: 0,
            edge_use: options.edge_use.into(),
            extent_rule: options.extent_rule.into(),
            radius_min: cylinder_limits.radius_min,
            radius_max: if cylinder_limits.radius_max < f64::INFINITY {
                cylinder_limits.radius_max
            } else {
                0.0
            },
            axis: cylinder_limits.axis.map_or([0.0; 3], |cone| cone.direction.into()),
            axis_max_angle: cylinder_limits.axis.map_or(0.0, |cone| cone.max_angle),
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
                ..IterationLimits::default()
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
            ..Options::default()
        }
    }

    #[test]
    fn options_come_back_the_same() {
        for options in [distinct(), Options::default()] {
            assert_eq!(cylfuse_options::from(&options).read().unwrap(), options);
        }
    }

    #[test]
    fn zeros_are_the_default_except_for_weight_and_tolerance() {
        let mut zeros = cylfuse_options::from(&Options::default());
        (zeros.max_iterations, zeros.ransac_max_iterations) = (0, 0);
        (zeros.initial_lambda, zeros.lambda_factor, zeros.max_lambda) = (0.0, 0.0, 0.0);
        assert_eq!(zeros.read().unwrap(), Options::default());
        (zeros.edge_weight, zeros.cost_tolerance) = (0.0, 0.0);
        let options = zeros.read().unwrap();
        assert_eq!((options.edge_weight, options.limits.cost_tolerance), (0.0, 0.0));
    }
}
