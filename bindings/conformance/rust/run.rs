//! Runs golden cases by the Rust API. The format is that of bindings/conformance/README.md.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a file that is not as described should stop"
)]

#[path = "base64.rs"]
pub mod base64;
#[path = "detect.rs"]
mod detect;
#[path = "lists.rs"]
mod lists;
#[path = "names.rs"]
mod names;
#[path = "read.rs"]
mod read;
#[path = "write.rs"]
mod write;

use cylfuse::camera::{Camera, Intrinsics};
use cylfuse::error::{Error, Result};
use cylfuse::fitter::{Fitter, ResidualKind};
use cylfuse::geometry::{Cylinder, RigidMotion};
use cylfuse::observations::{
    DepthCamera, DepthRange, DepthView, EdgeSegment, Frame, ImageFormat, ImageView, MaskView, Pixels,
    PointsView, VectorsView,
};
use cylfuse::scene::{Detector, Scene};
use nalgebra::{Matrix3, Vector2, Vector3};
use names::INPUTS;
use read::{Array, count, cylinder, number, optional_cylinder};
use serde_json::Value;
use write::{Fields, Output};

/// What a step gave: its outputs, or the name of the status and the message.
pub type Outcome = std::result::Result<Fields, (String, String)>;

/// One case in progress.
pub struct Runner<'a> {
    file: &'a Value,
    fitter: Fitter,
    frame: Frame,
    detector: Detector,
    scene: Option<Scene>,
}

impl<'a> Runner<'a> {
    /// A new fitter, a new frame and a new detector; `file` has the arrays and cameras.
    pub fn new(file: &'a Value) -> Self {
        let (fitter, frame, detector) = (Fitter::new(), Frame::default(), Detector::new());
        Self { file, fitter, frame, detector, scene: None }
    }

    /// Runs the next step.
    pub fn step(&mut self, step: &Value) -> Outcome {
        let call = step["call"].as_str().unwrap();
        self.run(call, step).map_err(|error| (error.name().into(), error.to_string()))
    }

    fn run(&mut self, call: &str, step: &Value) -> Result<Fields> {
        let model = optional_cylinder(&step["model"]);
        match call {
            "new_fitter" => self.fitter = Fitter::new(),
            "new_frame" => self.frame = Frame::default(),
            "new_detector" => (self.detector, self.scene) = (Detector::new(), None),
            "set_options" => self.fitter.set_options(read::options(&step["options"]))?,
            "get_options" => return Ok(write::options(self.fitter.options())),
            "select_view" => self.fitter.select_view(count(&step["index"]))?,
            "view_count" => return Ok(Output::default().count("count", self.fitter.view_count()).0),
            "set_pose" => self.fitter.set_pose(pose(step)?),
            "frame_set_pose" => self.frame.set_pose(pose(step)?),
            "set_intrinsics" => self.fitter.set_intrinsics(self.camera(step))?,
            "frame_set_intrinsics" => self.frame.set_camera(Camera::new(self.camera(step))?)?,
            "set_depth_camera" => self.fitter.set_depth_camera(self.depth_camera(step)?)?,
            "frame_set_depth_camera" => self.frame.set_depth_camera(self.depth_camera(step)?)?,
            "set_start_model" => self.fitter.set_start(model?),
            "reserve" => self.fitter.reserve(count(&step["points"]), count(&step["segments"]))?,
            "clear" => self.fitter.clear(),
            "clear_input" => {
                let names = step["inputs"].as_array().unwrap();
                self.fitter.clear_inputs(names.iter().map(|name| names::named(name, INPUTS)).collect());
            }
            // Of a call that is running, and none is.
            "cancel" => (),
            "push_points" => {
                let (points, mask) = (Points::read(self.file, &step["points"]), self.mask(step));
                self.fitter.push_points(&points.view(), mask.as_ref().map(mask_view).as_ref())?;
            }
            "push_depth" => {
                let (depth, mask) = (Array::read(self.file, &step["depth"]), self.mask(step));
                let (view, range) = depth_view(&depth, step)?;
                self.fitter.push_depth(&view, mask.as_ref().map(mask_view).as_ref(), &range)?;
            }
            "frame_set_depth" => {
                let depth = Array::read(self.file, &step["depth"]);
                let (view, range) = depth_view(&depth, step)?;
                self.frame.set_depth(&view, &range)?;
            }
            "push_image" => {
                self.fitter.push_image(&image_view(&Array::read(self.file, &step["image"]), step)?)?;
            }
            "frame_set_image" => {
                self.frame.set_image(&image_view(&Array::read(self.file, &step["image"]), step)?)?;
            }
            "use_frame" => {
                let mask = self.mask(step);
                self.fitter.use_frame(&self.frame, mask.as_ref().map(mask_view).as_ref())?;
            }
            "push_edges" => self.fitter.push_edges(&self.segments(step))?,
            "select_edges" => return self.select_edges(step, model?.as_ref()),
            "counts" => return Ok(write::counts(&self.fitter)),
            "fit" => return Ok(write::outcome(&self.fitter.fit()?)),
            "get_result" | "get_cylinder" => {
                let reading = call == "get_result";
                let last = self.fitter.result().ok_or(Error::BadState {
                    call: if reading { "reading the result" } else { "reading the cylinder" },
                    missing: "a result",
                    remedy: "fit first",
                })?;
                return Ok(if reading { write::result(last).0 } else { write::estimate(last).0 });
            }
            "evaluate" => return Ok(write::outcome(&self.fitter.evaluate(&cylinder(&step["model"])?)?)),
            "residuals" => {
                let kinds = [("POINTS", ResidualKind::Points), ("EDGES", ResidualKind::Edges)];
                let kind = names::named(&step["kind"], &kinds);
                let residuals = self.fitter.residuals(model?.as_ref(), kind)?;
                return Ok(Output::default().list("residuals", &residuals).0);
            }
            "point_weights" => return self.point_weights(),
            "point_parts" => return self.point_parts(model?.as_ref()),
            "limbs" => return self.limbs(),
            "limb_samples" => return self.limb_samples(),
            "end_samples" => return self.end_samples(step, self.mask(step).as_ref()),
            "diagnose" => {
                let diagnosis = self.fitter.diagnose(model?.as_ref())?;
                return Ok(Output::default()
                    .count("rank", diagnosis.rank.rank)
                    .list("singular_values", &diagnosis.rank.singular_values)
                    .number("condition", diagnosis.rank.condition)
                    .list("weakest_shift", diagnosis.weakest_shift.as_slice())
                    .list("weakest_tilt", diagnosis.weakest_tilt.as_slice())
                    .number("weakest_radius", diagnosis.weakest_radius)
                    .0);
            }
            "complete" => return self.complete(step, model?.as_ref()),
            "complete_depth" => return self.complete_depth(step, model?.as_ref()),
            "extent" => {
                let mask = self.mask(step);
                let mask = mask.as_ref().map(mask_view);
                return Ok(write::extent(&self.fitter.extent(model?.as_ref(), mask.as_ref())?));
            }
            "distances" => return self.distances(step),
            "project" => {
                let lines = Camera::new(self.camera(step))?.limb_lines(&cylinder(&step["model"])?)?;
                return Ok(Output::default()
                    .list("lines", &lines.iter().flatten().copied().collect::<Vec<f64>>())
                    .0);
            }
            "compare" => {
                let difference = cylinder(&step["a"])?.compare(&cylinder(&step["b"])?);
                return Ok(Output::default()
                    .number("angle", difference.angle)
                    .number("axis_distance", difference.axis_distance)
                    .number("radius_relative", difference.radius_relative)
                    .0);
            }
            "intrinsics_project" => return self.pixels(step),
            "intrinsics_unproject" => return self.rays(step),
            other => return self.detector(other, step),
        }
        Ok(Fields::new())
    }

    /// A camera by its name.
    fn camera(&self, step: &Value) -> Intrinsics {
        read::intrinsics(&self.file["cameras"][step["camera"].as_str().unwrap()])
    }

    /// A depth camera of its own, or none.
    fn depth_camera(&self, step: &Value) -> Result<Option<DepthCamera>> {
        if step["camera"].is_null() {
            return Ok(None);
        }
        let camera = Camera::new(self.camera(step))?;
        Ok(Some(DepthCamera { camera, to_color: pose(step)? }))
    }

    fn mask(&self, step: &Value) -> Option<Array> {
        if step["mask"].is_null() {
            return None;
        }
        let mut mask = Array::read(self.file, &step["mask"]);
        mask.label = step["label"].as_u64().unwrap_or(0) as u8;
        Some(mask)
    }

    fn segments(&self, step: &Value) -> Vec<EdgeSegment> {
        let rows = step["segments"].as_array().unwrap();
        let end = |row: &Value, k: usize| Vector2::new(number(&row[k]), number(&row[k + 1]));
        let weight = |k: usize| step["weights"].as_array().map_or(1.0, |weights| number(&weights[k]));
        let segment = |(k, row)| EdgeSegment { endpoints: [end(row, 0), end(row, 2)], weight: weight(k) };
        rows.iter().enumerate().map(segment).collect()
    }

    fn select_edges(&self, step: &Value, model: Option<&Cylinder>) -> Result<Fields> {
        let segments = self.segments(step);
        let limbs = self.fitter.select_edges(&segments, model, step["reach"].as_f64().unwrap_or(0.0))?;
        let mut selected = vec![0.0; segments.len()];
        for (limb, indices) in (1..).zip(&limbs) {
            indices.iter().for_each(|&index| selected[index] = f64::from(limb));
        }
        Ok(Output::default().list("selected", &selected).0)
    }

    fn complete(&self, step: &Value, model: Option<&Cylinder>) -> Result<Fields> {
        let organised = step["layout"] == "ORGANISED";
        let stored = |x: f64| if step["scalar"] == "F32" { f64::from(x as f32) } else { x };
        let (mut points, mask) = (Vec::new(), self.mask(step));
        let counts =
            self.fitter.complete(model, mask.as_ref().map(mask_view).as_ref(), &mut |_, _, point| {
                if organised || point.is_some() {
                    points.extend(point.map_or([f64::NAN; 3], |p| [stored(p.x), stored(p.y), stored(p.z)]));
                }
            })?;
        Ok(Output::default()
            .count("view", self.fitter.selected_view())
            .count("count", points.len() / 3)
            .count("hits", counts.hits)
            .count("misses", counts.misses)
            .count("outside_camera", counts.outside_camera)
            .number("out_of_range", 0)
            .list("points", &points)
            .0)
    }

    fn complete_depth(&self, step: &Value, model: Option<&Cylinder>) -> Result<Fields> {
        let (largest, whole) =
            if step["format"] == "U16" { (65535.0, true) } else { (f64::from(f32::MAX), false) };
        let scale = number(&step["scale"]);
        let (mut pixels, mut count, mut out_of_range, mask) = (Vec::new(), 0, 0, self.mask(step));
        let counts = self.fitter.complete_depth(
            model,
            mask.as_ref().map(mask_view).as_ref(),
            &mut |_, _, depth| {
                let value = depth.map_or(0.0, |z| z / scale);
                let stored = if whole { value.round() } else { f64::from(value as f32) };
                let stored = if stored <= largest { stored } else { 0.0 };
                count += usize::from(stored > 0.0);
                out_of_range += usize::from(depth.is_some() && stored <= 0.0);
                pixels.push(stored);
            },
        )?;
        Ok(Output::default()
            .count("view", self.fitter.selected_view())
            .count("count", count)
            .count("hits", counts.hits)
            .count("misses", counts.misses)
            .count("outside_camera", counts.outside_camera)
            .count("out_of_range", out_of_range)
            .list("depth", &pixels)
            .0)
    }

    fn distances(&self, step: &Value) -> Result<Fields> {
        let (model, points) = (cylinder(&step["model"])?, Points::read(self.file, &step["points"]));
        let distance = |point: &Vector3<f64>| {
            if point.iter().all(|x| x.is_finite()) { model.distance(point) } else { f64::NAN }
        };
        let distances: Vec<f64> = points.all().iter().map(distance).collect();
        Ok(Output::default().list("distances", &distances).0)
    }

    fn pixels(&self, step: &Value) -> Result<Fields> {
        let (camera, points) = (Camera::new(self.camera(step))?, Points::read(self.file, &step["points"]));
        let pixel = |point: &Vector3<f64>| camera.project(point).map_or([f64::NAN; 2], Into::into);
        let pixels: Vec<f64> = points.all().iter().flat_map(pixel).collect();
        Ok(Output::default().list("pixels", &pixels).0)
    }

    fn rays(&self, step: &Value) -> Result<Fields> {
        let camera = Camera::new(self.camera(step))?;
        let ray = |pixel: &Value| {
            camera.unproject(&read::numbers::<2>(pixel).into()).map_or([f64::NAN; 3], Into::into)
        };
        let rays: Vec<f64> = step["pixels"].as_array().unwrap().iter().flat_map(ray).collect();
        Ok(Output::default().list("rays", &rays).0)
    }
}

fn mask_view(mask: &Array) -> MaskView<'_> {
    let view = MaskView::new(mask.image(1));
    if mask.label == 0 { view } else { view.of_label(mask.label) }
}

fn depth_view<'a>(depth: &'a Array, step: &Value) -> Result<(DepthView<'a>, DepthRange)> {
    let format = if depth.element == "u16" { Pixels::U16 } else { Pixels::F32 };
    let view = DepthView::new(depth.image(1), format, number(&step["scale"]))?;
    let range = DepthRange {
        min: step["min_depth"].as_f64().unwrap_or(0.0),
        max: step["max_depth"].as_f64().unwrap_or(f64::INFINITY),
    };
    Ok((view, range))
}

fn image_view<'a>(image: &'a Array, step: &Value) -> Result<ImageView<'a>> {
    let format = match (step["format"].as_str(), image.channels(), image.element.as_str()) {
        (Some("RGB8"), ..) | (None, 3, _) => ImageFormat::Rgb8,
        (Some("BGR8"), ..) => ImageFormat::Bgr8,
        (Some("RGBA8"), ..) | (None, 4, _) => ImageFormat::Rgba8,
        (Some("BGRA8"), ..) => ImageFormat::Bgra8,
        (None, _, "u8") => ImageFormat::U8,
        (None, _, "u16") => ImageFormat::U16,
        (None, _, "f32") => ImageFormat::F32,
        (other, ..) => panic!("unknown format {other:?}"),
    };
    ImageView::new(image.image(image.channels()), format).with_gamma(step["gamma"].as_f64().unwrap_or(1.0))
}

fn pose(step: &Value) -> Result<RigidMotion> {
    let pose = &step["pose"];
    let rotation = Matrix3::from_row_slice(&read::numbers::<9>(&pose["rotation"]));
    RigidMotion::new(rotation, read::numbers::<3>(&pose["translation"]).into())
}

/// A cloud with what belongs to it.
struct Points {
    points: (Array, usize),
    weights: Option<(Array, usize)>,
    normals: Option<(Array, usize)>,
}

impl Points {
    fn read(file: &Value, given: &Value) -> Self {
        let columns =
            |of: &Value| (Array::read(file, &of["array"]), of["column"].as_u64().unwrap_or(0) as usize);
        let optional = |of: &Value| (!of.is_null()).then(|| columns(of));
        Self {
            points: columns(given),
            weights: optional(&given["weights"]),
            normals: optional(&given["normals"]),
        }
    }

    /// All points, row by row.
    fn all(&self) -> Vec<Vector3<f64>> {
        let view = self.view();
        let places = (0..view.height()).flat_map(|row| (0..view.width()).map(move |column| (column, row)));
        places.map(|(column, row)| view.points.at(column, row)).collect()
    }

    fn view<'a>(&'a self) -> PointsView<'a> {
        let (points, column) = &self.points;
        let normals =
            |(array, column): &'a (Array, usize)| VectorsView::new(array.columns(*column, 3), array.scalar());
        PointsView {
            points: VectorsView::new(points.columns(*column, 3), points.scalar()),
            weights: self.weights.as_ref().map(|(array, column)| array.columns(*column, 1)),
            normals: self.normals.as_ref().map(normals),
        }
    }
}

/// All cases as lines of bits.
#[allow(dead_code, reason = "the test compares numbers")]
pub fn report(file: &Value) -> String {
    let mut lines = String::new();
    for case in file["cases"].as_array().unwrap() {
        let (name, mut runner) = (case["name"].as_str().unwrap(), Runner::new(file));
        for (index, step) in case["steps"].as_array().unwrap().iter().enumerate() {
            let start = format!("{name}\t{index}");
            match runner.step(step) {
                Ok(fields) => {
                    lines += &format!("{start}\tok\n");
                    for (field, values) in fields {
                        let bits: Vec<String> = values.iter().map(bits).collect();
                        lines += &format!("{start}\t{field}\t{}\n", bits.join(" "));
                    }
                }
                Err((status, message)) => lines += &format!("{start}\terror\t{status}\t{message}\n"),
            }
        }
    }
    lines
}

/// The sign and the payload of a NaN say nothing.
#[allow(dead_code, reason = "as above")]
fn bits(value: &f64) -> String {
    if value.is_nan() { "nan".into() } else { format!("{:016x}", value.to_bits()) }
}
