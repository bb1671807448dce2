//! `cylfuse detect`: all cylinders of a frame, each fitted by the full method.

use crate::cloud::{Cloud, CloudFile, write_numbered_ply};
use crate::failure::Failure;
use crate::fit::{create_folder, write_file};
use crate::frame::{Frame, View};
use crate::images::{Image, Pixels};
use crate::inputs::Input;
use crate::overlay::Overlay;
use crate::page::{Illustration, PICTURE_WIDTH, POINTS_OF_SCENE, Picture};
use crate::remarks;
use crate::report::{Fitted, Measurement, ViewValues};
use crate::scene_picture::ScenePicture;
use cylfuse::camera::Camera;
use cylfuse::geometry::RigidMotion;
use cylfuse::observations::DepthImage;
use cylfuse::scene::{self, Detector, DetectorOptions, Observer, Progress};
use nalgebra::{Vector2, Vector3};
use serde::Serialize;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::Instant;

/// What holds for all frames of a run.
#[derive(Debug, Clone, Copy)]
pub struct Settings {
    /// The search and the fits.
    pub options: DetectorOptions,
    /// Whether the image file is opened.
    pub image: bool,
    /// Whether a page will show the frames.
    pub illustrate: bool,
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
    /// Whether all of the frame was looked at: the work of a search is bounded.
    pub complete: bool,
    /// Columns and rows by which the depth was moved to lie where the image shows the same bodies.
    pub depth_moved: [i32; 2],
    /// What may be wrong with the frame, in words.
    pub notes: Vec<String>,
    /// The folder of the files about it.
    pub out: Option<String>,
    /// What a page shows of it.
    #[serde(skip)]
    pub illustration: Option<Illustration>,
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
        Input::Cloud(path) => search_cloud(path, settings, folder),
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
    let views = Frame::read(path, settings.image)?.views;
    let mut notes = remarks::of_frame(&views, settings.options.search.limits.radius_min);
    let [view] = <[View; 1]>::try_from(views).map_err(|views| {
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
    let (scene, seconds) = timed(settings, |detector, observer| detector.detect_with(&frame, observer))?;
    let [columns, rows] = scene.depth_moved;
    if [columns, rows] != [0; 2] {
        notes.push(format!(
            "the depth was moved by {columns} columns and {rows} rows to where the image shows the same bodies, before the shifts of \
             cylinders; check its registration"
        ));
    }
    let depth = frame.depth_on_image().ok_or_else(|| Failure::bad_frame(path, "depth: there is none"))?;
    let mut cylinders: Vec<Found> = scene.cylinders.iter().map(of_frame).collect();
    let total = clock.elapsed().as_secs_f64();
    if settings.illustrate {
        for (index, found) in cylinders.iter_mut().enumerate() {
            let picture = picture(&scene, index, &view, &found.measurement)?;
            found.measurement.illustration = Some(Illustration::new(picture, &[], 0));
        }
    }
    let picture = ScenePicture { view: &view, depth, labels: &scene.labels, cylinders: &cylinders };
    let illustration = settings.illustrate.then(|| {
        let points = measured(&view.camera, depth);
        Illustration::new(picture.illustrate(PICTURE_WIDTH), &points, POINTS_OF_SCENE)
    });
    if let Some(folder) = folder {
        create_folder(folder)?;
        picture.write(&folder.join("overlay.png"))?;
        write_labels(&folder.join("labels.png"), view.size(), &scene.labels)?;
        let (points, numbers) = completed(&scene, &view.camera, depth)?;
        write_points(folder, &points, &numbers)?;
    }
    let out = folder.map(|folder| folder.display().to_string());
    let scene::Scene { complete, depth_moved, .. } = scene;
    let seconds = SceneSeconds { read, total, ..seconds };
    Ok(Scene { cylinders, complete, depth_moved, notes, out, illustration, seconds })
}

fn search_cloud(path: &Path, settings: &Settings, folder: Option<&Path>) -> Result<Scene, Failure> {
    let clock = Instant::now();
    let cloud = CloudFile::read(path)?;
    let read = clock.elapsed().as_secs_f64();
    let view = cloud.view()?;
    let (scene, seconds) =
        timed(settings, |detector, observer| detector.detect_points_with(&view, observer))?;
    let cylinders = scene.cylinders.iter().map(of_cloud).collect();
    let seconds = SceneSeconds { read, total: clock.elapsed().as_secs_f64(), ..seconds };
    let illustration =
        settings.illustrate.then(|| Illustration::new(None, &cloud.points.to_f64(), POINTS_OF_SCENE));
    if let Some(folder) = folder {
        create_folder(folder)?;
        write_points(folder, &cloud.points, &scene.labels)?;
    }
    let out = folder.map(|folder| folder.display().to_string());
    let notes = remarks::of_cloud(&cloud.points).into_iter().collect();
    let scene::Scene { complete, depth_moved, .. } = scene;
    Ok(Scene { cylinders, complete, depth_moved, notes, out, illustration, seconds })
}

/// The picture of one cylinder.
fn picture(
    scene: &scene::Scene,
    index: usize,
    view: &View,
    measurement: &Measurement,
) -> cylfuse::error::Result<Option<Picture>> {
    let fitter = scene.fitter(index)?;
    let mut completed = Vec::new();
    fitter.complete(None, None, &mut |column, row, point| {
        completed.extend(point.map(|_| (column as u32, row as u32)));
    })?;
    let overlay = Overlay {
        fitter: &fitter,
        image: view.image.as_ref(),
        camera: &view.camera,
        measurement,
        arcs: &scene.cylinders[index].arcs,
        completed: &completed,
    };
    Ok(overlay.illustrate(PICTURE_WIDTH))
}

/// The measured points of a frame, of every other row and column.
fn measured(camera: &Camera, depth: &DepthImage) -> Vec<[f64; 3]> {
    let pixels =
        (0..depth.height()).step_by(2).flat_map(|row| (0..depth.width()).step_by(2).map(move |x| (x, row)));
    let point = |(column, row): (usize, usize)| {
        let z = depth.depth(column, row)?;
        let point = camera.unproject(&Vector2::new(column as f64, row as f64))? * z;
        Some(point.into())
    };
    pixels.filter_map(point).collect()
}

/// The points of a frame in the frame of its camera, and the number of the cylinder of each: what the pixels of the
/// cylinders see of their surfaces, and what all other pixels measured.
fn completed(
    scene: &scene::Scene,
    camera: &Camera,
    depth: &DepthImage,
) -> cylfuse::error::Result<(Cloud, Vec<u16>)> {
    let (mut points, mut numbers) = (Vec::new(), Vec::new());
    let mut push = |point: Vector3<f64>, number| {
        points.push([point.x as f32, point.y as f32, point.z as f32]);
        numbers.push(number);
    };
    for row in 0..depth.height() {
        for column in 0..depth.width() {
            let none = scene.labels[row * depth.width() + column] == 0;
            let z = depth.depth(column, row).filter(|_| none);
            let ray = z.and_then(|_| camera.unproject(&Vector2::new(column as f64, row as f64)));
            if let (Some(z), Some(ray)) = (z, ray) {
                push(ray * z, 0);
            }
        }
    }
    for number in 1..=scene.cylinders.len() as u16 {
        scene.fitter(usize::from(number) - 1)?.complete(None, None, &mut |_, _, point| {
            if let Some(point) = point {
                push(point, number);
            }
        })?;
    }
    Ok((Cloud::F32(points), numbers))
}

fn write_points(folder: &Path, points: &Cloud, numbers: &[u16]) -> Result<(), Failure> {
    write_file(&folder.join("completed.ply"), |to| write_numbered_ply(points, numbers, to))
}

/// Searches with the settings of a run, and says how long search and fits take.
fn timed(
    settings: &Settings,
    search: impl FnOnce(&Detector, &mut Observer<'_>) -> cylfuse::error::Result<scene::Scene>,
) -> Result<(scene::Scene, SceneSeconds), Failure> {
    let mut detector = Detector::new();
    detector.set_options(settings.options)?;
    let clock = Instant::now();
    let mut detect = 0.0;
    let mut progress = |progress| {
        if let Progress::Fit { done: 0, .. } = progress {
            detect = clock.elapsed().as_secs_f64();
        }
        ControlFlow::Continue(())
    };
    let scene = search(&detector, &mut Observer { progress: &mut progress, stopped: &|| false })?;
    let fit = clock.elapsed().as_secs_f64() - detect;
    Ok((scene, SceneSeconds { detect, fit, ..SceneSeconds::default() }))
}

/// A cylinder of a frame.
fn of_frame(found: &scene::Found) -> Found {
    let mut cylinder = of_cloud(found);
    cylinder.measurement.set_views(vec![ViewValues {
        limbs: found.limbs().map(|limbs| limbs.each_ref().map(Into::into)),
        arc_samples: found.extent.as_ref().ok().map(|_| found.arcs.each_ref().map(Vec::len)),
        ..ViewValues::new(Fitted::Mask)
    }]);
    cylinder
}

/// A cylinder of a cloud.
fn of_cloud(found: &scene::Found) -> Found {
    let mut measurement = Measurement::new(found.fit_options(), &found.result);
    match &found.extent {
        Ok(extent) => measurement.set_extent(extent),
        Err(error) => measurement.no_extent(error),
    }
    Found { score: found.score, pixels: found.pixels, measurement }
}

fn write_labels(path: &Path, size: (usize, usize), labels: &[u16]) -> Result<(), Failure> {
    let image = Image::new(size, Pixels::Grey16(labels.to_vec()));
    write_file(path, |to| image.write_png(to))
}
