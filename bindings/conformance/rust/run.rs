//! Runs golden cases by the Rust API. The format is that of bindings/conformance/README.md.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a file that is not as described should stop"
)]

#[path = "base64.rs"]
pub mod base64;
#[path = "names.rs"]
mod names;
#[path = "read.rs"]
mod read;
#[path = "write.rs"]
mod write;

use cylfuse::camera::{Camera, Intrinsics};
use cylfuse::error::{Error, Result};
use cylfuse::fitter::{Fitter, ResidualKind};
use cylfuse::geometry::Cylinder;
use cylfuse::observations::{
    DepthRange, DepthView, EdgeSegment, ImageFormat, ImageView, MaskView, Pixels, PointsView, VectorsView,
};
use nalgebra::Vector2;
use read::{Array, count, cylinder, number, optional_cylinder};
use serde_json::Value;
use std::ops::ControlFlow;
use write::{Fields, Output};

/// What a step gave: its outputs, or the name of the status and the message.
pub type Outcome = std::result::Result<Fields, (String, String)>;

/// One case in progress.
pub struct Runner<'a> {
    file: &'a Value,
    fitter: Fitter,
    cancelled: bool,
}

impl<'a> Runner<'a> {
    /// A new fitter; `file` has the arrays and cameras.
    pub fn new(file: &'a Value) -> Self {
        Self { file, fitter: Fitter::new(), cancelled: false }
    }

    /// Runs the next step.
    pub fn step(&mut self, step: &Value) -> Outcome {
        let call = step["call"].as_str().unwrap();
        self.run(call, step).map_err(|error| (error.name().into(), error.to_string()))
    }

    fn run(&mut self, call: &str, step: &Value) -> Result<Fields> {
        let model = optional_cylinder(&step["model"]);
        match call {
            "set_options" => self.fitter.set_options(read::options(&step["options"]))?,
            "get_options" => return Ok(write::options(self.fitter.options())),
            "set_intrinsics" => self.fitter.set_intrinsics(self.camera(step))?,
            "set_start_model" => self.fitter.set_start(model?),
            "reserve" => self.fitter.reserve(count(&step["points"]), count(&step["segments"]))?,
            "clear" => {
                self.fitter.clear();
                self.cancelled = false;
            }
            "cancel" => self.cancelled = true,
            "push_points" => {
                let (points, mask) = (Points::read(self.file, &step["points"]), self.mask(step));
                self.fitter.push_points(&points.view(), mask.as_ref().map(mask_view).as_ref())?;
            }
            "push_depth" => self.push_depth(step)?,
            "push_image" => {
                let image = Array::read(self.file, &step["image"]);
                let format = match image.element.as_str() {
                    "u8" => ImageFormat::U8,
                    "u16" => ImageFormat::U16,
                    _ => ImageFormat::F32,
                };
                self.fitter.push_image(&ImageView::new(image.image(), format))?;
            }
            "push_edges" => self.fitter.push_edges(&self.segments(step))?,
            "select_edges" => return self.select_edges(step, model?.as_ref()),
            "counts" => return Ok(write::counts(&self.fitter)),
            "fit" => return self.fit(),
            "get_result" => {
                let last = self.fitter.result().ok_or(Error::BadState {
                    call: "reading the result",
                    missing: "a result",
                    remedy: "fit first",
                })?;
                return Ok(write::result(last));
            }
            "evaluate" => return Ok(write::result(&self.fitter.evaluate(&cylinder(&step["model"])?)?)),
            "residuals" => {
                let kinds = [("POINTS", ResidualKind::Points), ("EDGES", ResidualKind::Edges)];
                let kind = names::named(&step["kind"], &kinds);
                let residuals = self.fitter.residuals(model?.as_ref(), kind)?;
                return Ok(Output::default().list("residuals", &residuals).0);
            }
            "limb_samples" => return self.limb_samples(),
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
            other => panic!("unknown call {other}"),
        }
        Ok(Fields::new())
    }

    /// A camera by its name.
    fn camera(&self, step: &Value) -> Intrinsics {
        read::intrinsics(&self.file["cameras"][step["camera"].as_str().unwrap()])
    }

    fn mask(&self, step: &Value) -> Option<Array> {
        let name = &step["mask"];
        (!name.is_null()).then(|| Array::read(self.file, name))
    }

    fn push_depth(&mut self, step: &Value) -> Result<()> {
        let (depth, mask) = (Array::read(self.file, &step["depth"]), self.mask(step));
        let format = if depth.element == "u16" { Pixels::U16 } else { Pixels::F32 };
        let view = DepthView::new(depth.image(), format, number(&step["scale"]))?;
        let range = DepthRange {
            min: step["min_depth"].as_f64().unwrap_or(0.0),
            max: step["max_depth"].as_f64().unwrap_or(f64::INFINITY),
        };
        self.fitter.push_depth(&view, mask.as_ref().map(mask_view).as_ref(), &range)
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

    fn fit(&mut self) -> Result<Fields> {
        let stop = std::mem::take(&mut self.cancelled);
        let mut report = |_: &_| if stop { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        Ok(write::result(&self.fitter.fit_with(&mut report)?))
    }

    fn limb_samples(&self) -> Result<Fields> {
        if self.fitter.result().is_none() {
            let (call, missing) = ("listing limb samples", "a result");
            return Err(Error::BadState { call, missing, remedy: "fit first" });
        }
        let (mut pixels, mut sigmas, mut weights, mut limbs) = (vec![], vec![], vec![], vec![]);
        if let (Some(seen), Some(camera)) = (self.fitter.limbs(), self.fitter.camera()) {
            for (limb, observation) in seen.iter().enumerate() {
                for sample in &observation.samples {
                    let Some(pixel) = camera.project(&camera.ideal_ray(&sample.position)) else { continue };
                    pixels.extend([pixel.x, pixel.y]);
                    sigmas.push(sample.sigma);
                    weights.push(if observation.uses(sample) { sample.weight } else { 0.0 });
                    limbs.push(limb as f64);
                }
            }
        }
        Ok(Output::default()
            .list("pixel", &pixels)
            .list("sigma", &sigmas)
            .list("weight", &weights)
            .list("limb", &limbs)
            .0)
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
        let counts =
            self.fitter.complete(model, mask.as_ref().map(mask_view).as_ref(), &mut |_, _, point| {
                let value = point.map_or(0.0, |p| p.z / scale);
                let stored = if whole { value.round() } else { f64::from(value as f32) };
                let stored = if stored <= largest { stored } else { 0.0 };
                count += usize::from(stored > 0.0);
                out_of_range += usize::from(point.is_some() && stored <= 0.0);
                pixels.push(stored);
            })?;
        Ok(Output::default()
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
        let view = points.view();
        let mut distances = Vec::new();
        for row in 0..view.height() {
            for column in 0..view.width() {
                let point = view.points.at(column, row);
                let finite = point.iter().all(|x| x.is_finite());
                distances.push(if finite { model.distance(&point) } else { f64::NAN });
            }
        }
        Ok(Output::default().list("distances", &distances).0)
    }
}

fn mask_view(mask: &Array) -> MaskView<'_> {
    MaskView::new(mask.image())
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
