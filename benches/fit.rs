//! Time of whole fits: `cargo bench --bench fit`. Figures depend on the machine; compare rows of one run.
#![allow(clippy::unwrap_used)] // A benchmark that can't run should stop.

#[path = "../tests/support/fits.rs"]
mod fits;
#[path = "../tests/support/frames.rs"]
mod frames;
#[path = "../tests/support/mod.rs"]
mod support;

use cylfuse::fitter::{Method, Options, StartKind};
use fits::{framed, noisy, paper};

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

/// The baselines.
#[divan::bench(args = [Method::Points, Method::Eberly, Method::Ransac])]
fn baseline_on_5000_points(bencher: divan::Bencher, method: Method) {
    let mut fitter = noisy(5_000, true, Options { method, ..Options::default() });
    bencher.bench_local(move || fitter.fit().unwrap());
}
