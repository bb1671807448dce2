//! From a file to a measurement and the files about it.

use crate::arguments::FitArguments;
use crate::cloud::{self, Cloud};
use crate::failure::Failure;
use crate::frame::Frame;
use crate::inputs::Input;
use crate::overlay::Overlay;
use crate::report::{Fitted, Measurement, Report};
use cylfuse::extent::ExtentOptions;
use cylfuse::fitter::{Fitter, Options};
use cylfuse::geometry::Cylinder;
use cylfuse::observations::{DepthRange, DepthView, ImageView, MaskView};
use nalgebra::Vector3;
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
}

impl Settings {
    /// The settings that a command line asks for.
    pub fn new(arguments: &FitArguments) -> cylfuse::error::Result<Self> {
        Ok(Self {
            options: arguments.options()?,
            start: arguments.start_model()?,
            edges: !arguments.no_edges,
            image: !arguments.no_image,
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
/// it and those before it are there. `folders` has one for each input, or is empty when no files are wanted.
pub fn run_all(
    inputs: &[Input],
    folders: &[PathBuf],
    mut settings: Settings,
    take: &mut dyn FnMut(Report),
) -> Result<(), rayon::ThreadPoolBuildError> {
    let threads = settings.options.threads;
    if inputs.len() > 1 {
        // Frames side by side use the cores better than the sums within one.
        settings.options.threads = 1;
    }
    let settings = &settings;
    in_order(
        inputs,
        threads,
        &|index, input| run(input, settings, folders.get(index).map(PathBuf::as_path)),
        take,
    )
}

/// Does something with all inputs, several at a time, and hands over the outcomes in the order of the inputs, each as
/// soon as it and those before it are there.
pub fn in_order<T: Send>(
    inputs: &[Input],
    threads: usize,
    run: &(dyn Fn(usize, &Input) -> T + Sync),
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
                    let _ = sender.send((index, run(index, input)));
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
    let cloud = Cloud::read(path)?;
    let read = clock.elapsed().as_secs_f64();
    let mut fitter = settings.fitter()?;
    fitter.push_points(&cloud.view(), None)?;
    let result = fitter.fit()?;
    let mut measurement = Measurement::new(Fitted::Cloud, &settings.options, &result);
    measurement.seconds.read = read;
    measurement.seconds.total = clock.elapsed().as_secs_f64();
    Ok(measurement)
}

fn fit_frame(path: &Path, settings: &Settings, folder: Option<&Path>) -> Result<Measurement, Failure> {
    let clock = Instant::now();
    let frame = Frame::read(path, settings.image)?;
    let read = clock.elapsed().as_secs_f64();
    let mut fitter = settings.fitter()?;
    fitter.set_intrinsics(*frame.camera.intrinsics())?;
    let depth = DepthView::from_u16(&frame.depth, frame.size(), frame.depth_scale)?;
    let mask = frame.mask.as_deref().map(|mask| MaskView::from_u8(mask, frame.size())).transpose()?;
    fitter.push_depth(&depth, mask.as_ref(), &DepthRange::default())?;
    if settings.edges {
        fitter.push_edges(&frame.edges)?;
    }
    if let Some(image) = &frame.image {
        let grey = image.to_luma16();
        let view = ImageView::from_u16(&grey, frame.size())?;
        fitter.push_image(&view.with_gamma(frame.image_gamma)?)?;
    }
    let result = fitter.fit()?;
    let fitted = if frame.mask.is_some() { Fitted::Mask } else { Fitted::AllMeasuredPixels };
    let mut measurement = Measurement::new(fitted, &settings.options, &result);
    measurement.limbs = fitter.limbs().map(|limbs| limbs.each_ref().map(Into::into));
    let mut completed = Completed::default();
    let mut arcs = Vec::new();
    if frame.mask.is_some() {
        let options = ExtentOptions { image: fitter.image(), limbs_known: None };
        match fitter.extent_and_arcs(None, None, &options) {
            Ok((extent, found)) => {
                measurement.set_extent(&extent);
                arcs = found.concat();
            }
            Err(error) => measurement.notes.push(format!("no extent: {error}")),
        }
        let counts =
            fitter.complete(None, None, &mut |column, row, point| completed.add(column, row, point))?;
        measurement.set_completion(&counts);
    }
    measurement.seconds.read = read;
    measurement.seconds.total = clock.elapsed().as_secs_f64();
    if let Some(folder) = folder {
        create_folder(folder)?;
        let overlay = Overlay {
            frame: &frame,
            edges: fitter.segments(),
            cylinder: &result.cylinder,
            measurement: &measurement,
            limbs: fitter.limbs(),
            arcs: &arcs,
            completed: &completed.pixels,
        };
        overlay.write(&folder.join("overlay.png"))?;
        if frame.mask.is_some() {
            write_file(&folder.join("completed.ply"), |to| cloud::write_ply(&completed.points, to))?;
            write_file(&folder.join("completed.pcd"), |to| cloud::write_pcd(&completed.points, to))?;
        }
    }
    Ok(measurement)
}

/// The points on the fitted surface, and the pixels that see them.
#[derive(Default)]
struct Completed {
    pixels: Vec<(u32, u32)>,
    points: Vec<[f32; 3]>,
}

impl Completed {
    fn add(&mut self, column: usize, row: usize, point: Option<Vector3<f64>>) {
        if let Some(point) = point {
            self.pixels.push((column as u32, row as u32));
            self.points.push([point.x as f32, point.y as f32, point.z as f32]);
        }
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
