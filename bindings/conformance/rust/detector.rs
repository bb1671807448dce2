//! The calls on a detector.

use super::read::{self, count};
use super::write::{self, Fields, Output};
use super::{Points, Runner};
use cylfuse::error::{Error, Result};
use cylfuse::scene::{Found, Scene};
use serde_json::Value;

impl Runner<'_> {
    /// Runs a call on the detector.
    pub fn run_detector(&mut self, call: &str, step: &Value) -> Result<Fields> {
        let options = *self.detector.options();
        match call {
            "detector_set_options" => {
                self.detector.set_options(read::detector_options(&step["options"], options.fit))?;
            }
            "detector_get_options" => return Ok(write::detector_options(&options)),
            "detector_set_fit_options" => {
                let fit = read::options(&step["options"]);
                self.detector.set_options(cylfuse::scene::DetectorOptions { fit, ..options })?;
            }
            "detector_get_fit_options" => return Ok(write::options(&options.fit)),
            // Of a call that is running, and none is.
            "detector_cancel" => (),
            "detect" => {
                self.scene = Some(self.detector.detect(&self.frame)?);
                return self.detections();
            }
            "detect_points" => {
                let points = Points::read(self.file, &step["points"]);
                self.scene = Some(self.detector.detect_points(&points.view())?);
                return self.detections();
            }
            "detections" => return self.detections(),
            "detector_get_result" => return Ok(write::result(&self.found(step)?.result).0),
            "detector_get_cylinder" => return Ok(write::estimate(&self.found(step)?.result).0),
            "detector_get_extent" => {
                return Ok(write::extent(self.found(step)?.extent.as_ref().map_err(Clone::clone)?));
            }
            "labels" => {
                let labels: Vec<f64> = self.scene()?.labels.iter().map(|&label| label.into()).collect();
                return Ok(Output::default().list("labels", &labels).0);
            }
            "indices" => {
                self.found(step)?;
                let indices = self.scene()?.indices(count(&step["index"])).map(|k| k as f64);
                return Ok(Output::default().list("indices", &indices.collect::<Vec<_>>()).0);
            }
            "make_fitter" => self.fitter = self.scene()?.fitter(count(&step["index"]))?,
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
        let (scene, index) = (self.scene()?, count(&step["index"]));
        // Says so when there is no such cylinder.
        scene.fitter(index)?;
        Ok(&scene.cylinders[index])
    }

    fn detections(&self) -> Result<Fields> {
        let cylinders = &self.scene()?.cylinders;
        let (mut scores, mut pixels, mut radii) = (vec![], vec![], vec![]);
        let (mut points, mut directions) = (vec![], vec![]);
        for found in cylinders {
            let model = &found.result.cylinder;
            scores.push(found.score);
            pixels.push(found.pixels as f64);
            points.extend_from_slice(model.axis.point.as_slice());
            directions.extend_from_slice(model.axis.direction.as_slice());
            radii.push(model.radius);
        }
        Ok(Output::default()
            .list("score", &scores)
            .list("pixels", &pixels)
            .list("model.point", &points)
            .list("model.direction", &directions)
            .list("model.radius", &radii)
            .0)
    }
}
