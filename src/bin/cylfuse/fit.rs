//! From a file to a measurement and the files about it.

use crate::arguments::FitArguments;
use crate::cloud::{self, CloudFile};
use crate::failure::Failure;
use crate::frame::{Frame, View};
use crate::inputs::Input;
use crate::overlay::Overlay;
use crate::page::{Illustration, PICTURE_WIDTH, POINTS_OF_CYLINDER};
use crate::remarks;
use crate::report::{Fitted, Measurement, Report, ViewValues};
use cylfuse::completion::CompletionCounts;
use cylfuse::extent::ArcSample;
use cylfuse::fitter::{Fitter, Options};
use cylfuse::geometry::Cylinder;
use cylfuse::observations::MaskView;
use rayon::prelude::*;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::time::Instant;

/// What holds for all frames of a run.
#[derive(Debug, Clone, Copy)]
pub struct Settings {
    /// The library's options.
    pub options: Options,
    /// The model to start from.
    pub start: Option<Cylinder>,
    /// Whether the edge segments count.
    pub edges: bool,
    /// Whether the image file is opened.
    pub image: bool,
    /// Whether a page will show the inputs.
    pub illustrate: bool,
    /// Most threads for inputs side by side; 0 = as many as the machine has.
    pub threads: usize,
}

impl Settings {
    /// The settings that a command line asks for.
    pub fn new(arguments: &FitArguments) -> cylfuse::error::Result<Self> {
        Ok(Self {
            options: arguments.options()?,
            start: arguments.start_model()?,
            edges: !arguments.no_edges,
            image: !arguments.common.no_image,
            illustrate: arguments.common.report.is_some(),
            threads: arguments.threads.unwrap_or(0),
        })
    }

    fn fitter(&self) -> Result<Fitter, Failure> {
        let mut fitter = Fitter::new();
        fitter.set_options(self.options)?;
        fitter.set_start(self.start);
        Ok(fitter)
    }
}

/// Fits all inputs, several at a time, and hands over the reports in the order of the inputs, each as soon as
/// it and those before it are there. With each goes the folder for the files about it, where these are wanted.
pub fn run_all(
    inputs: &[(Input, Option<PathBuf>)],
    mut settings: Settings,
    take: &mut dyn FnMut(Report),
) -> Result<(), rayon::ThreadPoolBuildError> {
    if inputs.len() > 1 {
        // Frames side by side use the cores better than the sums within one.
        settings.options.threads = 1;
    }
    let fit = |(input, folder): &(Input, Option<PathBuf>)| run(input, &settings, folder.as_deref());
    in_order(inputs, settings.threads, &fit, take)
}

/// Does something with all inputs, several at a time, and hands over the outcomes in the order of the inputs, each as
/// soon as it and those before it are there.
pub fn in_order<I: Sync, T: Send>(
    inputs: &[I],
    threads: usize,
    run: &(dyn Fn(&I) -> T + Sync),
    take: &mut dyn FnMut(T),
) -> Result<(), rayon::ThreadPoolBuildError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let (sender, receiver) = mpsc::channel();
    std::thread::scope(|scope| {
        let pool = &pool;
        scope.spawn(move || {
            pool.install(|| {
                // A bridge hands the inputs out one by one, so that the first reports come first.
                inputs.iter().enumerate().par_bridge().for_each_with(sender, |sender, (index, input)| {
                    // The receiver lives as long as this scope.
                    let _ = sender.send((index, run(input)));
                });
            });
        });
        let mut waiting: Vec<Option<T>> = inputs.iter().map(|_| None).collect();
        let mut next = 0;
        for (index, report) in receiver {
            waiting[index] = Some(report);
            while let Some(report) = waiting.get_mut(next).and_then(Option::take) {
                take(report);
                next += 1;
            }
        }
    });
    Ok(())
}

/// Fits one input and writes the files about it.
pub fn run(input: &Input, settings: &Settings, folder: Option<&Path>) -> Report {
    let measure = || match input {
        Input::Frame(path) => fit_frame(path, settings, folder),
        Input::Cloud(path) => fit_cloud(path, settings),
        Input::Nothing(_, failure) => Err(failure.clone()),
    };
    // One bad frame of a thousand must not lose the others, whatever it met.
    let mut outcome =
        catch_unwind(AssertUnwindSafe(measure)).unwrap_or_else(|panic| Err(Failure::panic(&*panic)));
    if let (Ok(measurement), Some(folder)) = (&mut outcome, folder) {
        measurement.out = Some(folder.display().to_string());
    }
    let mut report = Report::new(input.path(), outcome);
    if let Some(Err(failure)) = folder.map(|folder| write_json(folder, &report)) {
        report = Report::new(input.path(), Err(failure));
    }
    report
}

fn fit_cloud(path: &Path, settings: &Settings) -> Result<Measurement, Failure> {
    let clock = Instant::now();
    let cloud = CloudFile::read(path)?;
    let read = clock.elapsed().as_secs_f64();
    let mut fitter = settings.fitter()?;
    fitter.push_points(&cloud.view()?, None)?;
    let result = fitter.fit()?;
    let mut measurement = Measurement::new(&settings.options, &result);
    match fitter.extent(None, None) {
        Ok(extent) => measurement.set_extent(&extent),
        Err(error) => measurement.no_extent(&error),
    }
    measurement.seconds.read = read;
    measurement.seconds.total = clock.elapsed().as_secs_f64();
    measurement.illustration =
        settings.illustrate.then(|| Illustration::new(None, &cloud.points.to_f64(), POINTS_OF_CYLINDER));
    Ok(measurement)
}

fn fit_frame(path: &Path, settings: &Settings, folder: Option<&Path>) -> Result<Measurement, Failure> {
    let clock = Instant::now();
    let views = Frame::read(path, settings.image)?.views;
    let read = clock.elapsed().as_secs_f64();
    let mut fitter = settings.fitter()?;
    for (index, view) in views.iter().enumerate() {
        push(&mut fitter, index, view, settings.edges).map_err(|error| {
            let failure = Failure::from(error);
            if views.len() > 1 { failure.in_frame(path, &format!("views[{index}]")) } else { failure }
        })?;
    }
    let remarks = remarks::of_frame(&views, settings.options.cylinder_limits.radius_min);
    let result = fitter.fit().map_err(|error| Failure::from(error).with(&remarks))?;
    let mut measurement = Measurement::new(&settings.options, &result);
    let mut arcs = vec![<[Vec<ArcSample>; 2]>::default(); views.len()];
    match fitter.extent_and_arcs(None, None) {
        Ok((extent, found)) => {
            measurement.set_extent(&extent);
            arcs = found;
        }
        Err(error) => measurement.no_extent(&error),
    }
    let mut values = Vec::new();
    let mut completed = Completed::default();
    for (index, (view, arcs)) in views.iter().zip(&arcs).enumerate() {
        fitter.select_view(index)?;
        let masked = view.mask.is_some();
        let fitted = if masked { Fitted::Mask } else { Fitted::AllMeasuredPixels };
        completed.pixels.push(Vec::new());
        let completion = masked.then(|| completed.add_view(&fitter)).transpose()?;
        values.push(ViewValues {
            limbs: fitter.limbs().map(|limbs| limbs.each_ref().map(Into::into)),
            arc_samples: measurement.extent.is_some().then(|| arcs.each_ref().map(Vec::len)),
            completion: completion.as_ref().map(Into::into),
            ..ViewValues::new(fitted)
        });
    }
    measurement.set_views(values);
    measurement.notes.extend(remarks);
    measurement.seconds.read = read;
    measurement.seconds.total = clock.elapsed().as_secs_f64();
    if settings.illustrate {
        measurement.illustration = Some(illustrate(&mut fitter, &views, &measurement, &arcs, &completed)?);
    }
    if let Some(folder) = folder {
        create_folder(folder)?;
        write_overlays(folder, &mut fitter, &views, &measurement, &arcs, &completed)?;
        if views.iter().any(|view| view.mask.is_some()) {
            write_file(&folder.join("completed.ply"), |to| cloud::write_ply(&completed.points, to))?;
            write_file(&folder.join("completed.pcd"), |to| cloud::write_pcd(&completed.points, to))?;
        }
    }
    Ok(measurement)
}

/// Gives a view to a fitter.
fn push(fitter: &mut Fitter, index: usize, view: &View, edges: bool) -> cylfuse::error::Result<()> {
    fitter.select_view(index)?;
    let mask = view.mask.as_deref().map(|mask| MaskView::from_u8(mask, view.size())).transpose()?;
    fitter.use_frame(&view.observed()?, mask.as_ref())?;
    if edges {
        fitter.push_edges(&view.edges)?;
    }
    Ok(())
}

/// What is drawn of the selected view, which has an index.
fn overlay<'a>(
    fitter: &'a Fitter,
    index: usize,
    view: &'a View,
    measurement: &'a Measurement,
    arcs: &'a [[Vec<ArcSample>; 2]],
    completed: &'a Completed,
) -> Overlay<'a> {
    Overlay {
        fitter,
        image: view.image.as_ref(),
        camera: &view.camera,
        measurement,
        arcs: &arcs[index],
        completed: &completed.pixels[index],
    }
}

/// What a page shows: the picture of the first view, and the points of all.
fn illustrate(
    fitter: &mut Fitter,
    views: &[View],
    measurement: &Measurement,
    arcs: &[[Vec<ArcSample>; 2]],
    completed: &Completed,
) -> Result<Illustration, Failure> {
    let mut points = Vec::new();
    for index in 0..views.len() {
        fitter.select_view(index)?;
        let pose = fitter.pose();
        points.extend(fitter.cloud().points().map(|p| <[f64; 3]>::from(pose.point(&p))));
    }
    fitter.select_view(0)?;
    let picture = overlay(fitter, 0, &views[0], measurement, arcs, completed).illustrate(PICTURE_WIDTH);
    Ok(Illustration::new(picture, &points, POINTS_OF_CYLINDER))
}

/// A picture of each view, and overlay.png, that of the first.
fn write_overlays(
    folder: &Path,
    fitter: &mut Fitter,
    views: &[View],
    measurement: &Measurement,
    arcs: &[[Vec<ArcSample>; 2]],
    completed: &Completed,
) -> Result<(), Failure> {
    for (index, view) in views.iter().enumerate() {
        fitter.select_view(index)?;
        let picture = overlay(fitter, index, view, measurement, arcs, completed).draw();
        let write = |name: &str| {
            let path = folder.join(name);
            let picture =
                picture.as_ref().ok_or_else(|| Failure::not_writable(&path, "the picture is too large"))?;
            write_file(&path, |to| picture.write_png(to))
        };
        if index == 0 {
            write("overlay.png")?;
        }
        if views.len() > 1 {
            write(&format!("overlay-{index}.png"))?;
        }
    }
    Ok(())
}

/// The points on the fitted surface in the frame of reference, and by view the pixels that see them.
#[derive(Default)]
struct Completed {
    pixels: Vec<Vec<(u32, u32)>>,
    points: Vec<[f32; 3]>,
}

impl Completed {
    /// Adds those of the selected view, whose pixels are the last.
    fn add_view(&mut self, fitter: &Fitter) -> cylfuse::error::Result<CompletionCounts> {
        fitter.complete(None, None, &mut |column, row, point| {
            if let (Some(point), Some(pixels)) = (point, self.pixels.last_mut()) {
                pixels.push((column as u32, row as u32));
                self.points.push([point.x as f32, point.y as f32, point.z as f32]);
            }
        })
    }
}

fn write_json(folder: &Path, report: &Report) -> Result<(), Failure> {
    create_folder(folder)?;
    let path = folder.join("result.json");
    let text = serde_json::to_string_pretty(report).map_err(|error| Failure::not_writable(&path, error))?;
    write_file(&path, |to| writeln!(to, "{text}"))
}

/// Makes a folder and those above it.
pub fn create_folder(folder: &Path) -> Result<(), Failure> {
    fs::create_dir_all(folder).map_err(|error| Failure::not_writable(folder, error))
}

/// Makes sure that a file can be written before there is work to lose. What is in it stays.
pub fn check_writable(path: &Path) -> Result<(), Failure> {
    let opened = File::options().append(true).create(true).open(path);
    opened.map(|_| ()).map_err(|error| Failure::not_writable(path, error))
}

/// Writes a file through a buffer.
pub fn write_file(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> std::io::Result<()>,
) -> Result<(), Failure> {
    let fill = || {
        let mut file = BufWriter::new(File::create(path)?);
        write(&mut file)?;
        file.flush()
    };
    fill().map_err(|error| Failure::not_writable(path, error))
}
