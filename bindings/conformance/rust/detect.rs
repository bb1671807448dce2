//! The calls on detectors.

use super::names::IMAGE_USES;
use super::read::{self, count, number, numbers};
use super::write::{self, Fields, Output};
use super::{Points, Runner, names};
use cylfuse::error::{Error, Result};
use cylfuse::geometry::AxisCone;
use cylfuse::scene::{DetectorOptions, Found, Scene};
use nalgebra::Vector3;
use serde_json::Value;

impl Runner<'_> {
    pub fn detector(&mut self, call: &str, step: &Value) -> Result<Fields> {
        match call {
            "detector_set_options" => {
                let fit = self.detector.options().fit;
                let options = DetectorOptions { fit, ..options(&step["options"]) };
                self.detector.set_options(options)?;
            }
            "detector_get_options" => return Ok(fields(self.detector.options())),
            "detector_set_fit_options" => {
                let fit = read::options(&step["options"]);
                let options = DetectorOptions { fit, ..*self.detector.options() };
                self.detector.set_options(options)?;
            }
            "detector_get_fit_options" => return Ok(write::options(&self.detector.options().fit)),
            // Of a call that is running, and none is.
            "detector_cancel" => (),
            "detect" => self.scene = Some(self.detector.detect(&self.frame)?),
            "detect_points" => {
                let points = Points::read(self.file, &step["points"]);
                self.scene = Some(self.detector.detect_points(&points.view())?);
            }
            "detector_count" => {
                return Ok(Output::default().count("count", self.scene()?.cylinders.len()).0);
            }
            "detector_detections" => {
                let cylinders = &self.scene()?.cylinders;
                let column = |of: fn(&Found) -> Vec<f64>| cylinders.iter().flat_map(of).collect::<Vec<f64>>();
                return Ok(Output::default()
                    .list("score", &column(|found| vec![found.score]))
                    .list("pixels", &column(|found| vec![found.pixels as f64]))
                    .list("model.point", &column(|found| found.result.cylinder.axis.point.as_slice().into()))
                    .list(
                        "model.direction",
                        &column(|found| found.result.cylinder.axis.direction.as_slice().into()),
                    )
                    .list("model.radius", &column(|found| vec![found.result.cylinder.radius]))
                    .0);
            }
            "detector_get_result" => return Ok(write::result(&self.found(step)?.result).0),
            "detector_get_cylinder" => return Ok(write::estimate(&self.found(step)?.result).0),
            "detector_get_extent" => {
                return Ok(write::extent(self.found(step)?.extent.as_ref().map_err(Clone::clone)?));
            }
            "detector_labels" => {
                let labels: Vec<f64> = self.scene()?.labels.iter().map(|&label| label.into()).collect();
                return Ok(Output::default().list("labels", &labels).0);
            }
            "detector_indices" => {
                self.found(step)?;
                let indices = self.scene()?.indices(count(&step["index"]));
                return Ok(Output::default()
                    .list("indices", &indices.map(|k| k as f64).collect::<Vec<_>>())
                    .0);
            }
            "detector_make_fitter" => {
                self.found(step)?;
                self.fitter = self.scene()?.fitter(count(&step["index"]))?;
            }
            other => panic!("unknown call {other}"),
        }
        Ok(Fields::new())
    }

    fn scene(&self) -> Result<&Scene> {
        self.scene.as_ref().ok_or(Error::BadState {
            call: "asking for cylinders",
            missing: "a scene",
            remedy: "search a frame or points first",
        })
    }

    fn found(&self, step: &Value) -> Result<&Found> {
        let (cylinders, index) = (&self.scene()?.cylinders, count(&step["index"]));
        cylinders.get(index).ok_or_else(|| Error::InvalidArgument {
            name: "index".into(),
            value: index.to_string(),
            requirement: format!("be less than the number of cylinders, {}", cylinders.len()),
        })
    }
}

fn options(value: &Value) -> DetectorOptions {
    let mut options = DetectorOptions::default();
    let mut axis = AxisCone { direction: Vector3::zeros(), max_angle: 0.0 };
    let search = &mut options.search;
    for (key, value) in value.as_object().unwrap() {
        match key.as_str() {
            "image_use" => options.use_image = names::named(value, IMAGE_USES),
            "max_threads" => options.threads = count(value),
            "max_count" => search.max_count = count(value),
            "min_pixels" => search.min_pixels = count(value),
            "min_score" => search.min_score = number(value),
            "radius_min" => search.limits.radius_min = number(value),
            "radius_max" => search.limits.radius_max = number(value),
            "axis" => axis.direction = numbers::<3>(value).into(),
            "axis_max_angle" => axis.max_angle = number(value),
            other => panic!("unknown option {other}"),
        }
    }
    search.limits.axis = (axis.direction != Vector3::zeros()).then_some(axis);
    options
}

fn fields(options: &DetectorOptions) -> Fields {
    let (search, limits) = (&options.search, &options.search.limits);
    let or_zero = |value: f64| if value.is_finite() { value } else { 0.0 };
    Output::default()
        .number("image_use", names::position(&options.use_image, IMAGE_USES))
        .count("max_threads", options.threads)
        .number("max_count", u32::try_from(search.max_count).unwrap_or(0))
        .count("min_pixels", search.min_pixels)
        .number("min_score", search.min_score)
        .number("radius_min", limits.radius_min)
        .number("radius_max", or_zero(limits.radius_max))
        .list("axis", limits.axis.map_or(Vector3::zeros(), |cone| cone.direction).as_slice())
        .number("axis_max_angle", limits.axis.map_or(0.0, |cone| cone.max_angle))
        .0
}
