//! The paper's objective against an independent program: from the start that `reference.json` states, the
//! program must reach the optimum that it states.
#![cfg(feature = "cli")]

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;

/// Largest relative deviation of the cost.
const COST: f64 = 1e-6;

/// Largest relative deviation of the radius.
const RADIUS: f64 = 1e-5;

/// Largest angle between the axes in radians, and distance of the axes relative to the radius: five times as
/// much as the radius, because the tilt of a short cylinder is less well determined.
const AXIS: f64 = 5e-5;

/// How far the program is from the reference, and where.
#[derive(Default)]
struct Worst {
    solutions: usize,
    cost: (f64, String),
    radius: (f64, String),
    angle: (f64, String),
    shift: (f64, String),
}

#[test]
fn frames_of_the_test_data() {
    let worst = compare(&frames(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/frames").as_path()));
    assert_eq!(worst.solutions, 6);
}

#[test]
fn all_frames() {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/frames");
    let folder = std::env::var_os("CYLFUSE_FRAMES").map_or(beside, PathBuf::from);
    if !folder.is_dir() {
        println!("skipped: {} is not there; name the folder in CYLFUSE_FRAMES", folder.display());
        return;
    }
    let worst = compare(&frames(&folder));
    println!("{} stable solutions, worst deviations:", worst.solutions);
    for (what, (value, place)) in [
        ("cost, relative", &worst.cost),
        ("radius, relative", &worst.radius),
        ("angle of the axes, radians", &worst.angle),
        ("distance of the axes, relative to the radius", &worst.shift),
    ] {
        println!("  {what}: {value:.2e} ({place})");
    }
    assert!(worst.solutions > 150);
}

/// The folders below `folder` that have a reference.json.
fn frames(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    folders.sort();
    for path in folders.iter().filter(|path| path.is_dir()) {
        if path.join("reference.json").is_file() {
            found.push(path.clone());
        } else {
            found.extend(frames(path));
        }
    }
    found
}

fn compare(frames: &[PathBuf]) -> Worst {
    let worst = Mutex::new(Worst::default());
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for share in frames.chunks(frames.len().div_ceil(threads).max(1)) {
            let worst = &worst;
            scope.spawn(move || share.iter().for_each(|frame| compare_frame(frame, worst)));
        }
    });
    worst.into_inner().unwrap()
}

fn compare_frame(frame: &Path, worst: &Mutex<Worst>) {
    let reference: Value =
        serde_json::from_slice(&std::fs::read(frame.join("reference.json")).unwrap()).unwrap();
    for solution in reference["solutions"].as_array().unwrap() {
        if solution["stable"] != true {
            continue;
        }
        let weight = solution["edge_weight"].as_f64().unwrap();
        let place = format!("{} w_L = {weight}", frame.file_name().unwrap().display());
        let fit = run(frame, weight, &reference["start"]);
        let relative = |name: &str, fitted: &Value| {
            let expected = solution[name].as_f64().unwrap();
            (fitted.as_f64().unwrap() - expected).abs() / expected
        };
        let radius = solution["radius"].as_f64().unwrap();
        let cost = relative("cost", &fit["result"]["cost"]);
        let radius_error = relative("radius", &fit["cylinder"]["radius"]);
        let direction = vector(&fit["cylinder"]["direction"]);
        let expected = vector(&solution["direction"]);
        let angle = norm(cross(direction, expected));
        let point = vector(&fit["cylinder"]["point"]);
        let nearest = vector(&solution["point_nearest_origin"]);
        // The reference's point is far from the data, where a tiny angle is a long way: compare at the data.
        let from_reference: [f64; 3] = std::array::from_fn(|k| point[k] - nearest[k]);
        let shift = norm(cross(from_reference, expected)) / norm(expected) / radius;
        assert!(cost < COST, "{place}: cost deviates by {cost:e}");
        assert!(radius_error < RADIUS, "{place}: radius deviates by {radius_error:e}");
        assert!(angle < AXIS, "{place}: axes are {angle:e} apart");
        assert!(shift < AXIS, "{place}: axis is {shift:e} radii off");
        assert_eq!(fit["result"]["points_used"], reference["points"], "{place}");
        assert_eq!(fit["result"]["edge_weight"], weight, "{place}");
        for (name, tolerance) in [("energy_points", 1e-4), ("energy_edges", 1e-3)] {
            // The energies apart are flat in no direction of their own: only their sum is at a minimum.
            let error = relative(name, &fit["result"][name]);
            assert!(error < tolerance, "{place}: {name} deviates by {error:e}");
        }
        let mut worst = worst.lock().unwrap();
        worst.solutions += 1;
        let record = |entry: &mut (f64, String), value: f64| {
            if value > entry.0 {
                *entry = (value, place.clone());
            }
        };
        record(&mut worst.cost, cost);
        record(&mut worst.radius, radius_error);
        record(&mut worst.angle, angle);
        record(&mut worst.shift, shift);
    }
}

/// The JSON object of a fit from the start of the reference.
fn run(frame: &Path, weight: f64, start: &Value) -> Value {
    let numbers: Vec<String> = ["point", "direction"]
        .iter()
        .flat_map(|name| start[name].as_array().unwrap())
        .chain([&start["radius"]])
        .map(ToString::to_string)
        .collect();
    let output = Command::new(env!("CARGO_BIN_EXE_cylfuse"))
        .args(["fit", "--json", "--objective", "paper", "--edge-weight", &weight.to_string()])
        .arg(format!("--start={}", numbers.join(",")))
        .arg(frame.join("frame.json"))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}: {}", frame.display(), String::from_utf8_lossy(&output.stdout));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn vector(value: &Value) -> [f64; 3] {
    std::array::from_fn(|k| value[k].as_f64().unwrap())
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn norm(a: [f64; 3]) -> f64 {
    a.iter().map(|x| x * x).sum::<f64>().sqrt()
}
