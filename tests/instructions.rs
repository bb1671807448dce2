//! How many instructions whole fits and detections take, by valgrind's callgrind, against the numbers in
//! `tests/data/instructions.txt`.
//! A clock can't tell a change of 3 % on a shared machine; this can.
//!
//! The numbers belong to a compiler, a C library and a processor with AVX2, up to which valgrind follows the choice of
//! vector instructions. Elsewhere the test says so and passes. After a change that is meant:
//! `CYLFUSE_WRITE_INSTRUCTIONS=1 cargo test --release --features bench --test instructions`.
#![allow(clippy::unwrap_used)]

#[path = "support/fits.rs"]
mod fits;
#[path = "support/frames.rs"]
mod frames;
mod support;

use cylfuse::fitter::{Fitter, Options, StartKind};
use cylfuse::observations::{DepthRange, DepthView, MaskView, PointsView};
use std::hint::black_box;
use std::path::Path;
use std::process::Command;

/// A part by which all counts together may rise.
const RISE: f64 = 0.03;

/// A part by which one count may rise: what the compiler inlines depends on the folder of the sources and on the features,
/// which made 7 % of the smallest count and 0.3 % of all others.
const RISE_OF_ONE: f64 = 0.1;

/// The variable with the name of the case that the test program runs below valgrind.
const CASE: &str = "CYLFUSE_INSTRUCTIONS_OF";

type Case = (&'static str, fn());

const CASES: [Case; 14] = [
    ("robust, image and edges", || repeated(fits::framed(true, true))),
    ("robust, image and mask", || repeated(fits::framed(true, false))),
    ("robust, edges", || repeated(fits::framed(false, true))),
    ("robust, mask", || repeated(fits::framed(false, false))),
    ("robust, image and edges, from the last fit", || repeated(fits::followed(true))),
    ("robust, image and mask, from the last fit", || repeated(fits::followed(false))),
    ("robust, 5,000 points and edges", || repeated(fits::noisy(5_000, true, Options::default()))),
    ("robust, 5,000 points alone", || {
        let mut fitter = fits::noisy(5_000, false, Options::default());
        fitter.set_start(None);
        repeated(fitter);
    }),
    ("paper, 5,000 points", || repeated(fits::noisy(5_000, true, fits::paper(StartKind::Auto)))),
    ("paper, 5,000 points, from a model", || {
        repeated(fits::noisy(5_000, true, fits::paper(StartKind::Model)));
    }),
    ("depth image with mask pushed", pushed),
    ("scene with image", || detected(true)),
    ("scene without image", || detected(false)),
    ("scene as a cloud", || {
        let (detector, points) = (fits::detector(), fits::cloud_of_scene());
        let points = PointsView::from_f64(&points);
        counted_by_callgrind(|| {
            black_box(detector.detect_points(&points).unwrap());
        });
    }),
];

/// What callgrind counts.
#[inline(never)]
fn counted_by_callgrind(mut work: impl FnMut()) {
    black_box(&mut work)();
}

/// The second fit: what the first one has to set up once does not count.
fn repeated(mut fitter: Fitter) {
    fitter.fit().unwrap();
    counted_by_callgrind(|| {
        black_box(fitter.fit().unwrap());
    });
}

fn pushed() {
    let inputs = fits::frame();
    let mut fitter = inputs.fitter();
    let depth = DepthView::from_u16(&inputs.depth, inputs.size, inputs.depth_scale).unwrap();
    let mask = MaskView::from_u8(&inputs.mask, inputs.size).unwrap();
    counted_by_callgrind(|| {
        fitter.push_depth(&depth, Some(&mask), &DepthRange::default()).unwrap();
    });
}

fn detected(image: bool) {
    let (detector, frame) = (fits::detector(), fits::scene(image));
    counted_by_callgrind(|| {
        black_box(detector.detect(&frame).unwrap());
    });
}

#[test]
#[ignore = "runs below valgrind"]
fn one_case() {
    let name = std::env::var(CASE).unwrap();
    let (_, run) = CASES.iter().find(|case| case.0 == name).unwrap();
    run();
}

/// The instructions of a case.
fn instructions(name: &str) -> u64 {
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null", "--collect-atstart=no"])
        .arg("--toggle-collect=*counted_by_callgrind*")
        .arg(std::env::current_exe().unwrap())
        .args(["--exact", "one_case", "--ignored", "--test-threads=1"])
        .env(CASE, name)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    let counted = said.lines().find_map(|line| line.split_once("Collected :")?.1.trim().parse().ok());
    counted.filter(|_| output.status.success()).unwrap_or_else(|| panic!("{name}: {said}"))
}

/// What a program says of itself, its first line.
fn said_by(program: &str, argument: &str) -> Option<String> {
    let output = Command::new(program).arg(argument).output().ok()?;
    Some(String::from_utf8_lossy(&output.stdout).lines().next()?.trim().to_string())
}

/// What the numbers belong to; `None` where there is no valgrind or no AVX2.
fn place() -> Option<String> {
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".into());
    let (compiler, library) = (said_by(&rustc, "--version")?, said_by("ldd", "--version")?);
    said_by("valgrind", "--version")?;
    #[cfg(target_arch = "x86_64")]
    let wide = std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma");
    #[cfg(not(target_arch = "x86_64"))]
    let wide = false;
    wide.then(|| format!("{compiler}; {library}; x86_64 with AVX2"))
}

#[test]
fn fits_take_no_more_instructions_than_before() {
    let Some(place) = place() else {
        eprintln!("skipped: needs valgrind, ldd and a processor with AVX2");
        return;
    };
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/instructions.txt");
    let write = std::env::var_os("CYLFUSE_WRITE_INSTRUCTIONS").is_some();
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    let mut lines = committed.lines();
    if !write && lines.next() != Some(&place) {
        eprintln!("skipped: no counts for {place}");
        return;
    }
    let mut text = format!("{place}\n");
    let mut rises = String::new();
    let mut sums = [0.0; 2];
    for (name, _) in CASES {
        let count = instructions(name);
        println!("{:10.3} million  {name}", count as f64 / 1e6);
        text += &format!("{count}\t{name}\n");
        let before = lines.clone().find_map(|line| line.split_once('\t').filter(|row| row.1 == name));
        let before: Option<u64> = before.map(|row| row.0.parse().unwrap());
        if before.is_none_or(|before| count as f64 > before as f64 * (1.0 + RISE_OF_ONE)) {
            rises += &format!("{name}: {before:?} -> {count}\n");
        }
        sums[0] += before.unwrap_or_default() as f64;
        sums[1] += count as f64;
    }
    if write {
        std::fs::write(&path, text).unwrap();
        return;
    }
    if sums[1] > sums[0] * (1.0 + RISE) {
        rises += &format!("all together: {} -> {}\n", sums[0], sums[1]);
    }
    assert!(rises.is_empty(), "more instructions than in tests/data/instructions.txt:\n{rises}");
}
