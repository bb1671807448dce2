//! How long fits and searches take of frames that are no cylinder, and how soon they end when asked to: processor time
//! of one thread, in milliseconds. `docs/trust.md` has the figures.
//!
//! `cargo run --release --example bounded_time [PART_OF_A_NAME]`

#[path = "../tests/support/hostile_inputs.rs"]
mod hostile_inputs;

use cylfuse::observations::PointsView;
use cylfuse::scene::{Detector, Observer};
use hostile_inputs::{Hostile, hostile};
use std::cell::Cell;
use std::ops::ControlFlow;

/// Processor time of this thread in milliseconds.
#[cfg(target_os = "linux")]
fn clock() -> f64 {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: room for a time.
    unsafe { libc::clock_gettime(libc::CLOCK_THREAD_CPUTIME_ID, &raw mut time) };
    time.tv_sec as f64 * 1e3 + time.tv_nsec as f64 * 1e-6
}

#[cfg(not(target_os = "linux"))]
fn clock() -> f64 {
    std::time::UNIX_EPOCH.elapsed().map_or(0.0, |time| time.as_secs_f64() * 1e3)
}

/// What one call took.
struct Cost {
    total: f64,
    /// The longest that it did not ask whether to go on.
    latency: f64,
    /// How often it asked.
    asked: usize,
    outcome: String,
}

/// Measures a call that calls what it is given where it asks whether to go on.
fn measured(call: impl FnOnce(&dyn Fn()) -> String) -> Cost {
    let start = clock();
    let (last, latency, asked) = (Cell::new(start), Cell::new(0.0), Cell::new(0));
    let ask = || {
        let now = clock();
        latency.set(f64::max(latency.get(), now - last.get()));
        last.set(now);
        asked.set(asked.get() + 1);
    };
    let outcome = call(&ask);
    ask();
    Cost { total: clock() - start, latency: latency.get(), asked: asked.get(), outcome }
}

fn fit(input: &Hostile) -> Cost {
    let mut fitter = input.fitter();
    measured(|ask| {
        let result = fitter.fit_with(&mut |_| {
            ask();
            ControlFlow::Continue(())
        });
        match result {
            Ok(result) => format!("radius {:.4}", result.cylinder.radius),
            Err(error) => error.to_string().chars().take(40).collect(),
        }
    })
}

/// A cell that the thread which searches alone looks into.
struct OneThread<T>(T);
// SAFETY: a detector with one thread calls back on the thread of its caller.
unsafe impl<T> Sync for OneThread<T> {}

impl<T> OneThread<T> {
    fn get(&self) -> &T {
        &self.0
    }
}

fn searched(search: impl FnOnce(&mut Observer<'_>) -> cylfuse::error::Result<cylfuse::scene::Scene>) -> Cost {
    measured(|ask| {
        let ask = OneThread(ask);
        let stopped = || {
            ask.get()();
            false
        };
        let mut observer = Observer { progress: &mut |_| ControlFlow::Continue(()), stopped: &stopped };
        match search(&mut observer) {
            Ok(scene) => format!("{} cylinders", scene.cylinders.len()),
            Err(error) => error.to_string(),
        }
    })
}

fn main() {
    let part = std::env::args().nth(1).unwrap_or_default();
    println!("{:>8} {:>8} {:>6}  call, frame, outcome", "ms", "latency", "asked");
    let mut most = [0.0_f64; 2];
    for input in hostile().iter().filter(|input| input.name.contains(&part)) {
        let detector = Detector::new();
        let points = input.points();
        for (call, cost) in [
            ("fit", fit(input)),
            ("search", searched(|observer| detector.detect_with(&input.frame(), observer))),
            (
                "cloud",
                searched(|observer| detector.detect_points_with(&PointsView::from_f64(&points), observer)),
            ),
        ] {
            let Cost { total, latency, asked, outcome } = cost;
            println!("{total:8.0} {latency:8.1} {asked:6}  {call}, {}, {outcome}", input.name);
            most = [most[0].max(total), most[1].max(latency)];
        }
    }
    println!("{:8.0} {:8.1}         at most", most[0], most[1]);
}
