//! `cylfuse detect`: all cylinders of a frame, each fitted by the full method.

use crate::cloud::Cloud;
use crate::failure::Failure;
use crate::fit::{create_folder, write_file};
use crate::frame::{Frame, View};
use crate::inputs::Input;
use crate::report::{Fitted, Measurement, ViewValues};
use crate::scene_picture::ScenePicture;
use cylfuse::detection::{Detection, DetectionOptions, Detections, detect, detect_points};
use cylfuse::fitter::{FitResult, Fitter, Options, StartKind};
use cylfuse::geometry::{Cylinder, Line, RigidMotion};
use cylfuse::observations::{self, MaskView};
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
    let [view] = <[View; 1]>::try_from(Frame::read(path, settings.image)?.views).map_err(|views| {
        let reason = format!(
            "views: has {} views, and detect takes one; give each view a frame file of its own",
            views.len()
        );
        Failure::bad_frame(path, reason)
    })?;
    let read = clock.elapsed().as_secs_f64();
    let mut frame = view.observed()?;
    // Everything here is in the frame of the camera, the limits of the axis included.
    frame.set_pose(RigidMotion::identity());
    let depth = frame.depth_on_image().ok_or_else(|| Failure::bad_frame(path, "depth: there is none"))?;
    let started = Instant::now();
    let mut options = settings.detection;
    if frame.image().is_some() {
        // The image may raise a low score.
        options.max_count = usize::MAX;
    }
    let mut found = detect(&view.camera, depth, frame.image(), &options)?;
    let detected = started.elapsed().as_secs_f64();
    let started = Instant::now();
    let mut cylinders = Vec::new();
    for (index, detection) in found.cylinders.iter().enumerate() {
        let mask: Vec<u8> =
            found.labels.iter().map(|&label| u8::from(usize::from(label) == index + 1)).collect();
        // A region without any measured pixel of its own cannot be fitted.
        let Ok(measurement) = fit_region(&frame, &mask, view.size(), &found, detection, settings) else {
            continue;
        };
        let located = measurement.result.limbs_located;
        let score = 0.0;
        cylinders.push((index as u16 + 1, Found { score, pixels: detection.pixels, measurement }));
    }
    cylinders.retain(|(_, found)| found.score >= settings.detection.min_score);
    cylinders.sort_by(|a, b| b.1.score.total_cmp(&a.1.score));
    cylinders.truncate(settings.detection.max_count);
    renumber(&mut found.labels, cylinders.iter().map(|(label, _)| *label));
    let cylinders: Vec<Found> = cylinders.into_iter().map(|(_, found)| found).collect();
    let fit = started.elapsed().as_secs_f64();
    let total = clock.elapsed().as_secs_f64();
    if let Some(folder) = folder {
        create_folder(folder)?;
        let picture = ScenePicture { view: &view, depth, labels: &found.labels, cylinders: &cylinders };
        picture.write(&folder.join("overlay.png"))?;
        write_labels(&folder.join("labels.png"), view.size(), &found)?;
    }
    let out = folder.map(|folder| folder.display().to_string());
    Ok(Scene { cylinders, out, seconds: SceneSeconds { read, detect: detected, fit, total } })
}

/// Gives labels the numbers in a new order; those that are not in it become 0.
fn renumber(labels: &mut [u16], order: impl Iterator<Item = u16>) {
    let mut new = vec![0; usize::from(u16::MAX) + 1];
    for (number, label) in (1..).zip(order) {
        new[usize::from(label)] = number;
    }
    labels.iter_mut().for_each(|label| *label = new[usize::from(*label)]);
}

/// Fits the region of a detection, from the cylinder that was found.
fn fit_region(
    frame: &observations::Frame,
    mask: &[u8],
    size: (usize, usize),
    found: &Detections,
    detection: &Detection,
    settings: &Settings,
) -> Result<Measurement, Failure> {
    let mut fitter = Fitter::new();
    let options =
        Options { start: StartKind::Model, cylinder_limits: settings.detection.limits, ..Options::default() };
    fitter.set_options(options)?;
    fitter.set_start(Some(detection.cylinder));
    fitter.use_frame(frame, Some(&MaskView::from_u8(mask, size)?))?;
    let result = fit_or_keep(&mut fitter, found, detection)?;
    let mut measurement = Measurement::new(&options, &result);
    let extent = fitter.extent_and_arcs(Some(&result.cylinder), None);
    measurement.set_views(vec![ViewValues {
        limbs: fitter.limbs().map(|limbs| limbs.each_ref().map(Into::into)),
        arc_samples: extent.as_ref().ok().and_then(|(_, arcs)| Some(arcs.first()?.each_ref().map(Vec::len))),
        ..ViewValues::new(Fitted::Mask)
    }]);
    match extent {
        Ok((extent, _)) => measurement.set_extent(&extent),
        Err(error) => measurement.notes.push(format!("no extent: {error}")),
    }
    Ok(measurement)
}

/// Radii to start from, by the radius that was found: depth next to limbs may be off by this much, which is more than
/// the search for limbs in the image reaches.
const RADII: [f64; 3] = [1.0, 0.9, 1.1];

/// The fit whose limbs the edges of the image cover best, or the detected cylinder where that is covered better: depth
/// alone is off next to the limbs, which the detection allows for and a fit of all points does not.
fn fit_or_keep(fitter: &mut Fitter, found: &Detections, detection: &Detection) -> Result<FitResult, Failure> {
    let cylinder = detection.cylinder;
    let covered = |cylinder: &Cylinder| found.covered(detection, cylinder).iter().sum::<f64>();
    let mut best: Option<(f64, Cylinder)> = None;
    for factor in if fitter.image().is_some() { &RADII[..] } else { &[] } {
        let radius = factor * cylinder.radius;
        // The wall that is seen stays where it is.
        let away = cylinder.axis.nearest_to_origin().normalize() * (radius - cylinder.radius);
        let start = Cylinder { axis: Line { point: cylinder.axis.point + away, ..cylinder.axis }, radius };
        fitter.set_start(Some(start));
        let Ok(result) = fitter.fit() else { continue };
        let change = cylinder.compare(&result.cylinder);
        let pixel = fitter.camera().map_or(0.0, |camera| 1.0 / camera.intrinsics().fx);
        let reach = f64::max(0.15, 3.0 * pixel * cylinder.axis.point.z / cylinder.radius);
        let same = change.radius_relative.abs() < reach
            && change.angle < 0.3
            && change.axis_distance < cylinder.radius;
        if !same || result.limbs_located == 0 {
            continue;
        }
        let part = covered(&result.cylinder) + 0.5 * result.limbs_located as f64;
        if best.is_none_or(|(most, _)| part > most) {
            best = Some((part, start));
            if part >= 2.0 {
                return Ok(result);
            }
        }
    }
    if let Some((part, start)) = best
        && part >= covered(&cylinder)
    {
        fitter.set_start(Some(start));
        return Ok(fitter.fit()?);
    }
    fitter.set_start(Some(cylinder));
    Ok(fitter.evaluate(&cylinder)?)
}

fn search_cloud(path: &Path, settings: &Settings) -> Result<Scene, Failure> {
    let clock = Instant::now();
    let cloud = Cloud::read(path)?;
    let read = clock.elapsed().as_secs_f64();
    let started = Instant::now();
    let found = detect_points(&cloud.view(), &settings.detection)?;
    let detect = started.elapsed().as_secs_f64();
    let started = Instant::now();
    let mut cylinders = Vec::new();
    for (index, detection) in found.cylinders.iter().enumerate() {
        let mask: Vec<u8> =
            found.labels.iter().map(|&label| u8::from(usize::from(label) == index + 1)).collect();
        let mut fitter = Fitter::new();
        let options = Options { start: StartKind::Model, ..Options::default() };
        fitter.set_options(options)?;
        let mask = MaskView::from_u8(&mask, (found.labels.len(), 1))?;
        if fitter.push_points(&cloud.view(), Some(&mask)).is_err() {
            continue;
        }
        let Ok(result) = fit_or_keep(&mut fitter, &found, detection) else { continue };
        let measurement = Measurement::new(&options, &result);
        cylinders.push(Found { score: detection.score, pixels: detection.pixels, measurement });
    }
    let fit = started.elapsed().as_secs_f64();
    let seconds = SceneSeconds { read, detect, fit, total: clock.elapsed().as_secs_f64() };
    Ok(Scene { cylinders, out: None, seconds })
}

fn write_labels(path: &Path, (width, height): (usize, usize), found: &Detections) -> Result<(), Failure> {
    let image: Option<ImageBuffer<Luma<u16>, _>> =
        ImageBuffer::from_raw(width as u32, height as u32, found.labels.clone());
    let image = image.ok_or_else(|| Failure::not_writable(path, "the picture is too large"))?;
    write_file(path, |to| image.write_to(to, ImageFormat::Png).map_err(std::io::Error::other))
}
