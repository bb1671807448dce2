//! Reads what the file of the cases holds: arrays, numbers, options, cameras.

use super::base64;
use super::names::*;
use cylfuse::camera::{Distortion, Intrinsics};
use cylfuse::error::Result;
use cylfuse::fitter::Options;
use cylfuse::geometry::{AxisCone, Cylinder};
use cylfuse::observations::{Scalar, Strided};
use nalgebra::Vector3;
use serde_json::Value;

/// An array of the file: packed, row by row, little-endian.
pub struct Array {
    pub element: String,
    /// As a mask: the pixels of this value are meant, 0 for all that are not 0.
    pub label: u8,
    shape: Vec<usize>,
    bytes: Vec<u8>,
}

impl Array {
    pub fn read(file: &Value, name: &Value) -> Self {
        let array = &file["arrays"][name.as_str().unwrap()];
        let shape = array["shape"].as_array().unwrap().iter().map(|n| n.as_u64().unwrap() as usize).collect();
        let bytes = base64::decode(array["data"].as_str().unwrap());
        Self { element: array["type"].as_str().unwrap().into(), label: 0, shape, bytes }
    }

    pub fn element_size(&self) -> usize {
        match self.element.as_str() {
            "u8" => 1,
            "u16" => 2,
            "f32" => 4,
            "f64" => 8,
            other => panic!("unknown type {other}"),
        }
    }

    pub fn scalar(&self) -> Scalar {
        if self.element == "f32" { Scalar::F32 } else { Scalar::F64 }
    }

    /// Width and height of an image.
    pub fn size(&self) -> (usize, usize) {
        (self.shape[1], self.shape[0])
    }

    /// Values of a pixel.
    pub fn channels(&self) -> usize {
        self.shape.get(2).copied().unwrap_or(1)
    }

    /// An image of so many values a pixel.
    pub fn image(&self, channels: usize) -> Strided<'_> {
        let (width, height) = self.size();
        let size = channels * self.element_size();
        let strides = (size as isize, (width * size) as isize);
        Strided::new(&self.bytes, 0, (width, height), size, strides).unwrap()
    }

    /// `count` columns from a column on, of an array of rows or of rows of rows.
    pub fn columns(&self, column: usize, count: usize) -> Strided<'_> {
        let (size, channels) = (self.element_size(), *self.shape.last().unwrap());
        let (height, width) =
            if self.shape.len() == 3 { (self.shape[0], self.shape[1]) } else { (1, self.shape[0]) };
        let strides = ((channels * size) as isize, (width * channels * size) as isize);
        Strided::new(&self.bytes, column * size, (width, height), count * size, strides).unwrap()
    }
}

/// A number; null stands for NaN.
pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

pub fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    std::array::from_fn(|k| number(&value[k]))
}

pub fn count(value: &Value) -> usize {
    value.as_u64().unwrap() as usize
}

pub fn cylinder(value: &Value) -> Result<Cylinder> {
    let vector = |key: &str| Vector3::from(numbers::<3>(&value[key]));
    Cylinder::new(vector("point"), vector("direction"), number(&value["radius"]))
}

pub fn optional_cylinder(value: &Value) -> Result<Option<Cylinder>> {
    if value.is_null() { Ok(None) } else { cylinder(value).map(Some) }
}

pub fn options(value: &Value) -> Options {
    let mut options = Options::default();
    let mut axis = AxisCone { direction: Vector3::zeros(), max_angle: 0.0 };
    for (key, value) in value.as_object().unwrap() {
        match key.as_str() {
            "method" => options.method = named(value, METHODS),
            "objective" => options.objective = named(value, OBJECTIVES),
            "start" => options.start = named(value, STARTS),
            "near_wall" => options.near_wall = named(value, NEAR_WALLS),
            "chart" => options.chart = named(value, CHARTS),
            "edge_use" => options.edge_use = named(value, EDGE_USES),
            "extent_rule" => options.extent_rule = named(value, EXTENT_RULES),
            "max_iterations" => options.limits.max_iterations = count(value),
            "max_threads" => options.threads = count(value),
            "edge_weight" => options.edge_weight = number(value),
            "initial_lambda" => options.limits.initial_lambda = number(value),
            "lambda_factor" => options.limits.lambda_factor = number(value),
            "max_lambda" => options.limits.max_lambda = number(value),
            "cost_tolerance" => options.limits.cost_tolerance = number(value),
            "gradient_tolerance" => options.limits.gradient_tolerance = number(value),
            "step_tolerance" => options.limits.step_tolerance = number(value),
            "independent_points" => options.independent_points = number(value),
            "depth_noise" => options.noise.depth = number(value),
            "image_noise" => options.noise.image = number(value),
            "edge_noise" => options.noise.edge_endpoint = number(value),
            "mask_noise" => options.noise.mask_side = number(value),
            "image_blur" => options.noise.blur = number(value),
            "drawn_pixel" => options.noise.drawn_pixel = number(value),
            "depth_shared" => options.noise.depth_shared = number(value).max(0.0),
            "ransac_threshold" => options.ransac_threshold = number(value),
            "ransac_max_iterations" => options.ransac_iterations = count(value),
            "seed" => options.seed = value.as_u64().unwrap(),
            "radius_min" => options.cylinder_limits.radius_min = number(value),
            "radius_max" => options.cylinder_limits.radius_max = number(value),
            "axis" => axis.direction = numbers::<3>(value).into(),
            "axis_max_angle" => axis.max_angle = number(value),
            other => panic!("unknown option {other}"),
        }
    }
    if axis.direction != Vector3::zeros() {
        options.cylinder_limits.axis = Some(axis);
    }
    options
}

pub fn intrinsics(value: &Value) -> Intrinsics {
    let given: [f64; 8] = numbers(&value["distortion"]);
    Intrinsics {
        width: count(&value["width"]) as u32,
        height: count(&value["height"]) as u32,
        fx: number(&value["fx"]),
        fy: number(&value["fy"]),
        cx: number(&value["cx"]),
        cy: number(&value["cy"]),
        distortion: match value["distortion_model"].as_str().unwrap() {
            "NONE" => Distortion::None,
            "BROWN_CONRADY" => Distortion::BrownConrady(given),
            "KANNALA_BRANDT" => Distortion::KannalaBrandt([given[0], given[1], given[2], given[3]]),
            other => panic!("unknown distortion model {other}"),
        },
    }
}
