//! Time of whole fits: `cargo bench --bench fit`. Figures depend on the machine; compare rows of one run.
#![allow(clippy::unwrap_used)] // A benchmark that can't run should stop.

#[path = "../tests/support/frames.rs"]
mod frames;
#[path = "../tests/support/mod.rs"]
mod support;

use cylfuse::fitter::{Fitter, Method, ObjectiveKind, Options, StartKind};
use cylfuse::geometry::Cylinder;
use nalgebra::Vector3;
use support::{Noise, camera, can, fitter_with, intrinsics, limb_segments, visible_points};

fn main() {
    divan::main();
}

/// A noisy can: 1 mm along the ray, half a pixel on the edges.
fn noisy(points: usize, options: Options) -> Fitter {
    let truth = can();
    let mut noise = Noise::new(1);
    let mut cloud = visible_points(&truth, &Vector3::zeros(), points);
    for point in &mut cloud {
        let stretch = 1.0 + 0.0015 * noise.normal();
        point.iter_mut().for_each(|x| *x *= stretch);
    }
    let mut segments = limb_segments(&truth, &camera());
    for q in segments.iter_mut().flat_map(|segment| &mut segment.endpoints) {
        *q += noise.vector().xy() * 0.5;
    }
    let mut fitter = fitter_with(&cloud);
    fitter.set_intrinsics(intrinsics()).unwrap();
    fitter.push_edges(&segments).unwrap();
    fitter.set_start(Some(
        Cylinder::new(truth.axis.point * 1.01, Vector3::new(0.25, 0.9, 0.25), truth.radius * 1.1).unwrap(),
    ));
    fitter.set_options(Options { threads: 1, ..options }).unwrap();
    fitter
}

const PAPER: ObjectiveKind = ObjectiveKind::Paper;

/// The paper's objective from a given start: the iteration alone.
#[divan::bench(args = [1_000, 5_000, 100_000])]
fn paper_from_a_model(bencher: divan::Bencher, points: usize) {
    let options = Options { objective: PAPER, start: StartKind::Model, ..Options::default() };
    let mut fitter = noisy(points, options);
    bencher.bench_local(move || fitter.fit().unwrap());
}

/// The paper's objective from its own start.
#[divan::bench(args = [5_000])]
fn paper_from_its_own_start(bencher: divan::Bencher, points: usize) {
    let mut fitter = noisy(points, Options { objective: PAPER, ..Options::default() });
    bencher.bench_local(move || fitter.fit().unwrap());
}

/// The robust objective from its own start.
#[divan::bench(args = [5_000])]
fn robust_from_its_own_start(bencher: divan::Bencher, points: usize) {
    let mut fitter = noisy(points, Options::default());
    bencher.bench_local(move || fitter.fit().unwrap());
}

/// The robust objective on a frame of 4,211 points, with its edges or without: the limbs and the ends are located in the
/// image.
#[divan::bench(args = [true, false])]
fn robust_with_image(bencher: divan::Bencher, edges: bool) {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/frames/r40_a20_f0");
    let mut fitter = frames::fitter_with_edges(&folder, edges);
    frames::push_image(&mut fitter, &folder);
    fitter.set_options(Options { threads: 1, ..Options::default() }).unwrap();
    bencher.bench_local(move || fitter.fit().unwrap());
}

/// The baselines.
#[divan::bench(args = [Method::Points, Method::Eberly, Method::Ransac])]
fn baseline_on_5000_points(bencher: divan::Bencher, method: Method) {
    let mut fitter = noisy(5_000, Options { method, ..Options::default() });
    bencher.bench_local(move || fitter.fit().unwrap());
}
