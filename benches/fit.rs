//! Time of whole fits: `cargo bench --bench fit`. Figures depend on the machine; compare rows of one run.
#![allow(clippy::unwrap_used)] // A benchmark that can't run should stop.

#[path = "../tests/support/fits.rs"]
mod fits;
#[path = "../tests/support/frames.rs"]
mod frames;
#[path = "../tests/support/mod.rs"]
mod support;

use cylfuse::camera::{Distortion, Intrinsics};
use cylfuse::fitter::{Fitter, Inputs, Method, Options, StartKind};
use cylfuse::observations::{DepthRange, DepthView, MaskView};
use fits::{followed, framed, noisy, paper};
use support::intrinsics;

fn main() {
    divan::main();
}

/// The paper's objective from a given start: the iteration alone.
#[divan::bench(args = [1_000, 5_000, 100_000])]
fn paper_from_a_model(bencher: divan::Bencher, points: usize) {
    let mut fitter = noisy(points, true, paper(StartKind::Model));
    bencher.bench_local(move || fitter.fit().unwrap());
}

/// The paper's objective from its own start.
#[divan::bench(args = [5_000])]
fn paper_from_its_own_start(bencher: divan::Bencher, points: usize) {
    let mut fitter = noisy(points, true, paper(StartKind::Auto));
    bencher.bench_local(move || fitter.fit().unwrap());
}

/// The robust objective from its own start.
#[divan::bench(args = [5_000])]
fn robust_from_its_own_start(bencher: divan::Bencher, points: usize) {
    let mut fitter = noisy(points, true, Options::default());
    bencher.bench_local(move || fitter.fit().unwrap());
}

/// The robust objective on a frame of 4,211 points, with its edges or without: the limbs and the ends are located in the
/// image.
#[divan::bench(args = [true, false])]
fn robust_with_image(bencher: divan::Bencher, edges: bool) {
    let mut fitter = framed(true, edges);
    bencher.bench_local(move || fitter.fit().unwrap());
}

/// The same from the last fit, of the same frame.
#[divan::bench(args = [true, false])]
fn robust_with_image_from_the_last_fit(bencher: divan::Bencher, edges: bool) {
    let mut fitter = followed(edges);
    bencher.bench_local(move || fitter.fit().unwrap());
}

/// A depth image of 640 × 480 with a mask of 20,000 pixels, every 23rd without depth; the rays of a lens with distortion are
/// known from the push before.
#[divan::bench(args = [false, true])]
fn push_of_depth(bencher: divan::Bencher, distorted: bool) {
    const SIZE: (usize, usize) = (640, 480);
    let distortion = match distorted {
        true => Distortion::BrownConrady([0.1, -0.2, 1e-3, -5e-4, 0.05, 0.0, 0.0, 0.0]),
        false => Distortion::None,
    };
    let depth: Vec<u16> = (0..SIZE.0 * SIZE.1).map(|k| if k % 23 == 0 { 0 } else { 800 }).collect();
    let masked = |k: usize| (240..400).contains(&(k % SIZE.0)) && (170..300).contains(&(k / SIZE.0));
    let mask: Vec<u8> = (0..SIZE.0 * SIZE.1).map(|k| u8::from(masked(k))).collect();
    let mut fitter = Fitter::new();
    fitter.set_intrinsics(Intrinsics { distortion, ..intrinsics() }).unwrap();
    let depth = DepthView::from_u16(&depth, SIZE, 1e-3).unwrap();
    let mask = MaskView::from_u8(&mask, SIZE).unwrap();
    bencher.bench_local(|| {
        fitter.clear_inputs(Inputs::POINTS);
        fitter.push_depth(&depth, Some(&mask), &DepthRange::default()).unwrap();
    });
}

/// All five cylinders of a depth image of 640 × 480, with its image or without, fitted.
#[divan::bench(args = [true, false])]
fn scene(bencher: divan::Bencher, image: bool) {
    let (detector, frame) = (fits::detector(), fits::scene(image));
    bencher.bench_local(move || detector.detect(&frame).unwrap());
}

/// The baselines.
#[divan::bench(args = [Method::Points, Method::Eberly, Method::Ransac])]
fn baseline_on_5000_points(bencher: divan::Bencher, method: Method) {
    let mut fitter = noisy(5_000, true, Options { method, ..Options::default() });
    bencher.bench_local(move || fitter.fit().unwrap());
}
