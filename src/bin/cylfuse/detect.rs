//! `cylfuse detect`: all cylinders of a frame, each fitted by the full method.

use crate::cloud::Cloud;
use crate::failure::Failure;
use crate::fit::{create_folder, write_file};
use crate::frame::Frame;
use crate::inputs::Input;
use crate::report::{Fitted, Measurement};
use crate::scene_picture::ScenePicture;
use cylfuse::detection::{Detection, DetectionOptions, Detections, detect};
use cylfuse::extent::ExtentOptions;
use cylfuse::fitter::{FitResult, Fitter, Options, StartKind};
use cylfuse::observations::{DepthImage, DepthRange, DepthView, GreyImage, ImageView, MaskView, PointsView};
use image::{ImageBuffer, ImageFormat, Luma};
use serde::Serialize;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::Instant;

/// What holds for all frames of a run.
#[derive(Debug, Clone, Copy)]
pub struct Settings {
    /// The search.
    pub detection: DetectionOptions,
    /// Whether the image file is opened.
    pub image: bool,
}

/// One object of the JSON output.
#[derive(Debug, Serialize)]
pub struct SceneReport {
    /// The path of the input.
    pub frame: String,
    /// How it went.
    #[serde(flatten)]
    pub outcome: SceneOutcome,
}

/// The cylinders of a frame, or why there is no answer.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub enum SceneOutcome {
    /// It went well.
    Searched(Scene),
    /// It did not.
    Failed {
        /// Why.
        error: Failure,
    },
}

/// What was found in a frame.
#[derive(Debug, Serialize)]
pub struct Scene {
    /// The cylinders by falling score.
    pub cylinders: Vec<Found>,
    /// The folder of the files about it.
    pub out: Option<String>,
    /// Time spent.
    pub seconds: SceneSeconds,
}

/// One cylinder with its fit.
#[derive(Debug, Serialize)]
pub struct Found {
    /// The probability that there is a cylinder.
    pub score: f64,
    /// Pixels of its region; points for a bare cloud.
    pub pixels: usize,
    /// The fit.
    #[serde(flatten)]
    pub measurement: Measurement,
}

/// Wall-clock seconds by phase.
#[derive(Debug, Default, Serialize)]
pub struct SceneSeconds {
    /// Reading and decoding the files.
    pub read: f64,
    /// Finding the cylinders.
    pub detect: f64,
    /// Fitting them.
    pub fit: f64,
    /// All of it, the output files excepted.
    pub total: f64,
}

/// Searches one input and writes the files about it.
pub fn run(input: &Input, settings: &Settings, folder: Option<&Path>) -> SceneReport {
    let search = || match input {
        Input::Frame(path) => search_frame(path, settings, folder),
        Input::Cloud(path) => search_cloud(path, settings),
        Input::Nothing(_, failure) => Err(failure.clone()),
    };
    // One bad frame of a thousand must not lose the others, whatever it met.
    let outcome = catch_unwind(AssertUnwindSafe(search)).unwrap_or_else(|panic| Err(Failure::panic(&*panic)));
    let outcome = match outcome {
        Ok(scene) => SceneOutcome::Searched(scene),
        Err(error) => SceneOutcome::Failed { error },
    };
    SceneReport { frame: input.path().display().to_string(), outcome }
}

fn search_frame(path: &Path, settings: &Settings, folder: Option<&Path>) -> Result<Scene, Failure> {
    let clock = Instant::now();
    let frame = Frame::read(path, settings.image)?;
    let read = clock.elapsed().as_secs_f64();
    let size = frame.size();
    let view = DepthView::from_u16(&frame.depth, size, frame.depth_scale)?;
    let depth = DepthImage::copy(&view)?;
    let light = frame.image.as_ref().map(|image| image.to_luma16());
    let image = light
        .as_ref()
        .map(|light| ImageView::from_u16(light, size)?.with_gamma(frame.image_gamma))
        .transpose()?;
    let grey = image.as_ref().map(GreyImage::copy).transpose()?;
    let started = Instant::now();
    let found = detect(&frame.camera, &depth, grey.as_ref(), &settings.detection)?;
    let detected = started.elapsed().as_secs_f64();
    let started = Instant::now();
    let mut cylinders = Vec::new();
    for (index, detection) in found.cylinders.iter().enumerate() {
        let mask: Vec<u8> =
            found.labels.iter().map(|&label| u8::from(usize::from(label) == index + 1)).collect();
        let measurement = fit_region(&frame, &view, image.as_ref(), &mask, detection, settings)?;
        cylinders.push(Found { score: detection.score, pixels: detection.pixels, measurement });
    }
    let fit = started.elapsed().as_secs_f64();
    let total = clock.elapsed().as_secs_f64();
    if let Some(folder) = folder {
        create_folder(folder)?;
        let picture = ScenePicture { frame: &frame, labels: &found.labels, cylinders: &cylinders };
        picture.write(&folder.join("overlay.png"))?;
        write_labels(&folder.join("labels.png"), size, &found)?;
    }
    let out = folder.map(|folder| folder.display().to_string());
    Ok(Scene { cylinders, out, seconds: SceneSeconds { read, detect: detected, fit, total } })
}

/// Fits the region of a detection, from the cylinder that was found.
fn fit_region(
    frame: &Frame,
    depth: &DepthView<'_>,
    image: Option<&ImageView<'_>>,
    mask: &[u8],
    detection: &Detection,
    settings: &Settings,
) -> Result<Measurement, Failure> {
    let mut fitter = Fitter::new();
    let options = Options {
        start: StartKind::Model,
        threads: 1,
        cylinder_limits: settings.detection.limits,
        ..Options::default()
    };
    fitter.set_options(options)?;
    fitter.set_start(Some(detection.cylinder));
    fitter.set_intrinsics(*frame.camera.intrinsics())?;
    let mask = MaskView::from_u8(mask, frame.size())?;
    fitter.push_depth(depth, Some(&mask), &DepthRange::default())?;
    if let Some(image) = image {
        fitter.push_image(image)?;
    }
    let result = fit_or_keep(&mut fitter, detection)?;
    let mut measurement = Measurement::new(Fitted::Mask, &options, &result);
    measurement.limbs = fitter.limbs().map(|limbs| limbs.each_ref().map(Into::into));
    let options = ExtentOptions { image: fitter.image(), limbs_known: None };
    match fitter.extent_and_arcs(Some(&result.cylinder), None, &options) {
        Ok((extent, _)) => measurement.set_extent(&extent),
        Err(error) => measurement.notes.push(format!("no extent: {error}")),
    }
    Ok(measurement)
}

/// The fit, or the detected cylinder where the fit leads to another one: within twice the radius, a radian and half a
/// radius it is the same.
fn fit_or_keep(fitter: &mut Fitter, detection: &Detection) -> Result<FitResult, Failure> {
    // Depth alone is off next to the limbs, which the detection allows for and a fit of all points does not.
    if let (true, Ok(result)) = (fitter.image().is_some(), fitter.fit()) {
        let change = detection.cylinder.compare(&result.cylinder);
        if change.radius_relative.abs() < 0.5
            && change.angle < 0.3
            && change.axis_distance < detection.cylinder.radius
        {
            return Ok(result);
        }
    }
    Ok(fitter.evaluate(&detection.cylinder)?)
}

fn search_cloud(path: &Path, _settings: &Settings) -> Result<Scene, Failure> {
    let cloud = Cloud::read(path)?;
    let _: PointsView<'_> = cloud.view();
    Err(Failure::bad_cloud(path, "clouds are not searched yet"))
}

fn write_labels(path: &Path, (width, height): (usize, usize), found: &Detections) -> Result<(), Failure> {
    let image: Option<ImageBuffer<Luma<u16>, _>> =
        ImageBuffer::from_raw(width as u32, height as u32, found.labels.clone());
    let image = image.ok_or_else(|| Failure::not_writable(path, "the picture is too large"))?;
    write_file(path, |to| image.write_to(to, ImageFormat::Png).map_err(std::io::Error::other))
}
