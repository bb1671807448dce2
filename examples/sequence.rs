//! Fits of a sequence that go on from the last one against fits from scratch, as tables:
//! `cargo run --release --features twin --example sequence`.
//!
//! The captures of ../shared/frames/repeat, of which nothing moves, and frames of the twin, whose camera turns and moves from
//! frame to frame. With the feature `sensitivity`, words of names of constants as arguments (`-- continued:: again::`) print after that how
//! the mean of E_r changes when each of them is 20 % smaller or larger.
#![allow(clippy::unwrap_used)] // A measurement that can't run should stop.

#[path = "../tests/support/frames.rs"]
mod frames;
#[path = "../tests/support/parallel.rs"]
mod parallel;
#[cfg(feature = "sensitivity")]
mod scaled;

use cylfuse::camera::{Camera, Distortion, Intrinsics};
#[cfg(feature = "sensitivity")]
use cylfuse::constant::Constant;
use cylfuse::fitter::{Fitter, Options, StartKind};
use cylfuse::geometry::{Cylinder, RigidMotion};
use cylfuse::observations::{DepthRange, DepthView, EdgeSegment, ImageView, MaskView};
use cylfuse::twin::{
    CaptureOptions, DEPTH_UNIT, DepthSensor, Kind, PictureOptions, Scene, StructuredLight, TimeOfFlight,
    capture, drawn_mask, random_scene,
};
use frames::{Inputs, cylinder, json, shared_frames};
use nalgebra::{Rotation3, Vector3};
use parallel::map;

/// Frames of a sequence of the twin.
const FRAMES: usize = 6;

/// Random scenes of each sensor.
const SCENES: u64 = 20;

/// A frame and its truth.
struct Seen {
    inputs: Inputs,
    truth: Cylinder,
}

/// Frames that follow each other.
type Sequence = Vec<Seen>;

/// The sequences of the captures of each scene.
fn captures() -> Vec<Sequence> {
    let mut sequences: Vec<(String, Sequence)> = Vec::new();
    for folder in shared_frames("frames/repeat") {
        let name = folder.file_name().unwrap().to_string_lossy().into_owned();
        let scene = name.split_once("_c").unwrap().0.to_string();
        let truth = cylinder(&json(&folder.join("truth.json")), "center", "axis");
        let seen = Seen { inputs: Inputs::read(&folder), truth };
        match sequences.last_mut().filter(|last| last.0 == scene) {
            Some(last) => last.1.push(seen),
            None => sequences.push((scene, vec![seen])),
        }
    }
    sequences.into_iter().map(|sequence| sequence.1).collect()
}

/// A scene as a camera sees it that has moved.
fn moved(scene: &Scene, motion: &RigidMotion) -> Scene {
    let mut scene = scene.clone();
    for body in &mut scene.bodies {
        let pose = &body.pose;
        let rotation = motion.rotation() * pose.rotation();
        body.pose = RigidMotion::new(rotation, motion.point(pose.translation())).unwrap();
    }
    for truth in &mut scene.cylinders {
        truth.center = motion.point(&truth.center);
        truth.cylinder = motion.cylinder(&truth.cylinder);
    }
    scene.lamp = motion.point(&scene.lamp);
    scene
}

/// A sequence of the twin whose camera moves by about so many pixels from frame to frame.
fn of_twin(sensor: &DepthSensor, seed: u64, pixels: f64) -> Sequence {
    let intrinsics = Intrinsics {
        width: 640,
        height: 480,
        fx: 570.0,
        fy: 570.0,
        cx: 319.5,
        cy: 239.5,
        distortion: Distortion::None,
    };
    let scene = random_scene(Kind::Single, seed).unwrap();
    let options = CaptureOptions {
        camera: Camera::new(intrinsics).unwrap(),
        picture: PictureOptions::default(),
        sensor: *sensor,
        registered: true,
    };
    let frame = |k: usize| {
        let angle = pixels / intrinsics.fx * (k as f64 - 0.5 * (FRAMES - 1) as f64);
        let rotation = Rotation3::new(Vector3::new(0.6, 0.8, 0.5) * angle).into_inner();
        let motion = RigidMotion::new(rotation, Vector3::new(0.1, -0.1, 0.3) * angle).unwrap();
        let seed = 100 * seed + k as u64;
        let taken = capture(&moved(&scene, &motion), &options, seed).unwrap();
        let [seen] = &taken.cylinders[..] else { return None };
        let inputs = Inputs {
            intrinsics,
            size: (640, 480),
            mask: drawn_mask(&taken.body, (640, 480), seed),
            depth: taken.depth,
            depth_scale: DEPTH_UNIT,
            image: taken.image,
            edges: Vec::new(),
        };
        seen.countable.then_some(Seen { inputs, truth: seen.truth.cylinder })
    };
    (0..FRAMES).filter_map(frame).collect()
}

/// Of fits of sequences: E_r (%) and E_o (degrees) of each, and the scatter of the radius within each sequence (%).
#[derive(Default)]
struct Errors {
    radius: Vec<f64>,
    direction: Vec<f64>,
    scatter: Vec<f64>,
}

impl Errors {
    fn new(sequences: &[Sequence], start: StartKind, edges: bool) -> Self {
        let mut errors = Self::default();
        for of_sequence in map(sequences, |sequence| fits(sequence, start, edges)) {
            let mut ratios = Vec::new();
            for (fit, truth) in of_sequence {
                let difference = truth.compare(&fit);
                errors.radius.push((fit.radius / truth.radius - 1.0).abs() * 100.0);
                errors.direction.push(difference.angle.to_degrees());
                ratios.push(fit.radius / truth.radius);
            }
            let count = ratios.len() as f64;
            let mean = ratios.iter().sum::<f64>() / count;
            let squares: f64 = ratios.iter().map(|ratio| (ratio - mean).powi(2)).sum();
            errors.scatter.push((squares / (count - 1.0)).sqrt() * 100.0);
        }
        errors
    }
}

/// The fits of a sequence by one fitter, all but the first, which has nothing to go on from.
fn fits(sequence: &Sequence, start: StartKind, edges: bool) -> Vec<(Cylinder, Cylinder)> {
    let mut fitter = Fitter::new();
    fitter.set_options(Options { start, threads: 1, ..Options::default() }).unwrap();
    let mut all = Vec::new();
    for Seen { inputs, truth } in sequence {
        fitter.clear();
        let given: &[EdgeSegment] = if edges { &inputs.edges } else { &[] };
        fitter.set_intrinsics(inputs.intrinsics).unwrap();
        let depth = DepthView::from_u16(&inputs.depth, inputs.size, inputs.depth_scale).unwrap();
        let mask = MaskView::from_u8(&inputs.mask, inputs.size).unwrap();
        fitter.push_depth(&depth, Some(&mask), &DepthRange::default()).unwrap();
        fitter.push_image(&ImageView::from_u8(&inputs.image, inputs.size).unwrap()).unwrap();
        fitter.push_edges(given).unwrap();
        all.push((fitter.fit().unwrap().cylinder, *truth));
    }
    all.split_off(1)
}

/// Sequences of one kind, and whether the fits are given their edges.
struct Set {
    name: String,
    sequences: Vec<Sequence>,
    edges: bool,
}

impl Set {
    fn errors(&self, start: StartKind) -> Errors {
        Errors::new(&self.sequences, start, self.edges)
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn print(set: &Set) {
    for (how, start) in [("from scratch", StartKind::Auto), ("from the last fit", StartKind::Last)] {
        let Errors { mut radius, mut direction, scatter } = set.errors(start);
        let ninety = |values: &mut Vec<f64>| {
            values.sort_by(f64::total_cmp);
            values[(0.9 * (values.len() - 1) as f64).round() as usize]
        };
        let rms = mean(&scatter.iter().map(|x| x * x).collect::<Vec<_>>()).sqrt();
        println!(
            "| {} | {how} | {} | {:.3} | {:.3} | {:.3} | {:.3} | {rms:.3} |",
            set.name,
            radius.len(),
            mean(&radius),
            ninety(&mut radius),
            mean(&direction),
            ninety(&mut direction),
        );
    }
}

/// The constants that the arguments ask for: none without them.
#[cfg(feature = "sensitivity")]
fn constants() -> Vec<Constant> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let all = [
        cylfuse::fitter::constants(),
        cylfuse::limb_location::constants(),
        cylfuse::end_location::constants(),
    ];
    if words.is_empty() { Vec::new() } else { scaled::constants(all.concat(), &words) }
}

/// How the mean of E_r changes with each of some constants, in percent by set.
#[cfg(feature = "sensitivity")]
fn print_changes(sets: &[Set], constants: &[Constant]) {
    let radius = |set: &Set| mean(&set.errors(StartKind::Last).radius);
    let before: Vec<f64> = sets.iter().map(radius).collect();
    let names: Vec<&str> = sets.iter().map(|set| &set.name[..]).collect();
    println!("\n| constant | value | unit | {} |", names.join(" | "));
    println!("|---|---|---|{}", "---|".repeat(sets.len()));
    for constant in constants {
        let [less, more] = [0.8, 1.2].map(|factor| {
            scaled::with_scaled(*constant, factor, || sets.iter().map(radius).collect::<Vec<f64>>())
        });
        let change = |k: usize, after: f64| match after == before[k] {
            true => "·".to_string(),
            false => format!("{:+.0}", (after / before[k] - 1.0) * 100.0),
        };
        let columns: Vec<String> =
            (0..sets.len()).map(|k| format!("{} / {}", change(k, less[k]), change(k, more[k]))).collect();
        println!("{}", scaled::row(constant, &columns));
    }
}

/// All sequences there are.
fn sets() -> Vec<Set> {
    let mut sets = Vec::new();
    for (name, edges) in [("frames/repeat, edges", true), ("frames/repeat, mask", false)] {
        sets.push(Set { name: name.into(), sequences: captures(), edges });
    }
    sets.retain(|set| !set.sequences.is_empty());
    let sensors = [
        ("structured light", DepthSensor::StructuredLight(StructuredLight::default())),
        ("time of flight", DepthSensor::TimeOfFlight(TimeOfFlight::default())),
    ];
    let seeds: Vec<u64> = (1..=SCENES).collect();
    for (name, sensor) in sensors {
        for pixels in [0.0, 1.0, 5.0, 20.0] {
            let mut sequences = map(&seeds, |&seed| of_twin(&sensor, seed, pixels));
            sequences.retain(|sequence| sequence.len() == FRAMES);
            sets.push(Set { name: format!("{name}, {pixels} px a frame"), sequences, edges: false });
        }
    }
    sets
}

fn main() {
    #[cfg(feature = "sensitivity")]
    let constants = constants();
    let sets = sets();
    println!(
        "| sequences | fits | frames | E_r mean (%) | 90 % | E_o mean (°) | 90 % | scatter of the radius (%) |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    sets.iter().for_each(print);
    #[cfg(feature = "sensitivity")]
    if !constants.is_empty() {
        print_changes(&sets, &constants);
    }
}
