//! What many fits and large clouds take: processor time, and the most memory that is held at a time, in parts of the input.
//! `docs/performance.md` has the figures.
//!
//! `cargo run --release --example large [fits|points|cloud]`
#![allow(clippy::unwrap_used)] // A measurement that can't run should stop.

#[path = "../tests/support/fits.rs"]
mod fits;
#[path = "../tests/support/frames.rs"]
mod frames;
#[path = "../tests/support/mod.rs"]
mod support;

use cylfuse::fitter::{Fitter, Options, StartKind, fit_all};
use cylfuse::observations::PointsView;
use nalgebra::Vector2;
use std::ops::ControlFlow;
use std::time::Instant;

/// Makes large blocks go back to the system when they are given back, so that the most memory that is held can be told.
#[cfg(target_os = "linux")]
fn give_back() {
    // SAFETY: a setting of the allocator, made before there is any other thread.
    unsafe { libc::mallopt(libc::M_MMAP_THRESHOLD, 1 << 20) };
}

#[cfg(not(target_os = "linux"))]
fn give_back() {}

/// A size of this process in bytes, by its name in `/proc/self/status`; 0 where there is none.
fn size(name: &str) -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(':'));
    let kilobytes = line.and_then(|line| line.split_whitespace().next()?.parse().ok());
    1024.0 * kilobytes.unwrap_or(0.0)
}

/// Processor time of all threads in milliseconds.
#[cfg(target_os = "linux")]
fn processor() -> f64 {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: room for a time.
    unsafe { libc::clock_gettime(libc::CLOCK_PROCESS_CPUTIME_ID, &raw mut time) };
    time.tv_sec as f64 * 1e3 + time.tv_nsec as f64 * 1e-6
}

#[cfg(not(target_os = "linux"))]
fn processor() -> f64 {
    std::time::UNIX_EPOCH.elapsed().map_or(0.0, |time| time.as_secs_f64() * 1e3)
}

/// What a call took.
struct Cost {
    /// Processor time in milliseconds.
    time: f64,
    /// The most bytes that it held at a time, beside what was held before.
    memory: f64,
}

fn measured<T>(call: impl FnOnce() -> T) -> (T, Cost) {
    // The most that is held is counted anew.
    let _ = std::fs::write("/proc/self/clear_refs", "5");
    let (before, start) = (size("VmRSS"), processor());
    let outcome = call();
    (outcome, Cost { time: processor() - start, memory: size("VmHWM") - before })
}

/// A thousand fits of 5,000 points and edges, on one core and on all.
fn many_fits() {
    const COUNT: usize = 1000;
    let fitter = fits::noisy(5_000, true, Options::default());
    let mut rates = [0.0; 2];
    for (threads, rate) in [1, 0].into_iter().zip(&mut rates) {
        let mut fitters: Vec<Fitter> = vec![fitter.clone(); COUNT];
        let clock = Instant::now();
        let (results, cost) =
            measured(|| fit_all(&mut fitters, threads, &mut |_, _| ControlFlow::Continue(())));
        assert!(results.iter().all(Result::is_ok));
        let seconds = clock.elapsed().as_secs_f64();
        *rate = COUNT as f64 / seconds;
        println!(
            "{COUNT} fits, {} : {:7.0} a second, {:5.0} a second of processor time",
            if threads == 1 { "one core " } else { "all cores" },
            *rate,
            COUNT as f64 / (cost.time * 1e-3)
        );
    }
    let cores = std::thread::available_parallelism().unwrap().get() as f64;
    println!("all cores against {cores} times one: {:.2}", rates[1] / (cores * rates[0]));
}

/// One fit of so many points and two edges.
fn points(count: usize, narrow: bool, options: Options) -> (Cost, Cost) {
    // The noise, the edges and the start of the other fits that are measured.
    let template = fits::noisy(5, true, fits::on_one_core(options));
    let cloud = fits::noisy_points(count);
    let narrowed: Vec<[f32; 3]> =
        if narrow { cloud.iter().map(|p| p.map(|x| x as f32)).collect() } else { Vec::new() };
    let cloud = if narrow { Vec::new() } else { cloud };
    let view = if narrow { PointsView::from_f32(&narrowed) } else { PointsView::from_f64(&cloud) };
    let mut fitter = template.clone();
    fitter.clear_inputs(cylfuse::fitter::Inputs::POINTS);
    let (outcome, push) = measured(|| fitter.push_points(&view, None));
    outcome.unwrap();
    let held = size("VmRSS");
    let (result, mut fit) = measured(|| fitter.fit());
    result.unwrap();
    drop(fitter);
    // With the points that the fitter keeps.
    fit.memory += held - size("VmRSS");
    (push, fit)
}

fn many_points() {
    let paper = fits::paper(StartKind::Model);
    for (name, options) in [("robust", Options::default()), ("paper, from a model", paper)] {
        for narrow in [true, false] {
            let mut first = None;
            for count in [5_000, 1_000_000, 10_000_000] {
                let (push, fit) = points(count, narrow, options);
                let bytes = (count * if narrow { 12 } else { 24 }) as f64;
                let per_point = fit.time / count as f64;
                let first = *first.get_or_insert(per_point);
                println!(
                    "{name}, {}, {count:8} points: push {:7.2} ms, fit {:8.2} ms, a point {:4.2} of that of 5,000; memory push {:.2}, fit {:.2} of the input",
                    if narrow { "f32" } else { "f64" },
                    push.time,
                    fit.time,
                    per_point / first,
                    push.memory / bytes,
                    fit.memory / bytes,
                );
            }
        }
    }
}

/// Points of `tests/data/scene` between its pixels, in no order.
fn cloud_of_scene(count: usize) -> Vec<[f64; 3]> {
    let frame = fits::scene(false);
    let (camera, depth) = (frame.camera().unwrap(), frame.depth().unwrap());
    let (width, height) = depth.size();
    let mut cloud = Vec::with_capacity(count);
    let mut k = 0.0_f64;
    while cloud.len() < count {
        k += 1.0;
        // Two irrational steps cover the image evenly and without order.
        let x = (k * 0.618_033_988_75).fract() * (width - 1) as f64;
        let y = (k * 0.414_213_562_37).fract() * (height - 1) as f64;
        let (column, row) = (x as usize, y as usize);
        let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(a, b)| depth.depth(column + a, row + b));
        let [Some(a), Some(b), Some(c), Some(d)] = corners else { continue };
        let (nearest, farthest) = (a.min(b).min(c).min(d), a.max(b).max(c).max(d));
        let (s, t) = (x.fract(), y.fract());
        let between = (a * (1.0 - s) + b * s) * (1.0 - t) + (c * (1.0 - s) + d * s) * t;
        // Nothing lies between what is near and what is behind it.
        let z = if farthest < 1.01 * nearest { between } else { a };
        let Some(ray) = camera.unproject(&Vector2::new(x, y)) else { continue };
        cloud.push((ray * z).into());
    }
    cloud
}

/// An unorganised cloud of a million points, by the detector.
fn large_cloud() {
    const COUNT: usize = 1_000_000;
    let cloud = cloud_of_scene(COUNT);
    let narrow: Vec<[f32; 3]> = cloud.iter().map(|p| p.map(|x| x as f32)).collect();
    let detector = fits::detector();
    let views = [("f32", PointsView::from_f32(&narrow), 12), ("f64", PointsView::from_f64(&cloud), 24)];
    for (name, view, bytes) in views {
        let (scene, Cost { time, memory }) = measured(|| detector.detect_points(&view));
        println!(
            "{name}, {COUNT} points of a scene: {} cylinders, {time:.0} ms, memory {:.2} of the input",
            scene.unwrap().cylinders.len(),
            memory / (COUNT * bytes) as f64
        );
    }
}

fn main() {
    give_back();
    let wanted = std::env::args().nth(1);
    let asked = |name: &str| wanted.as_deref().is_none_or(|wanted| wanted == name);
    if asked("fits") {
        many_fits();
    }
    if asked("points") {
        many_points();
    }
    if asked("cloud") {
        large_cloud();
    }
}
