//! Frames that show no cylinder, or far too many: the work of fits and searches is bounded, and all along they ask whether to
//! go on. Counted in questions, which follow the work and not the clock; `examples/bounded_time.rs` prints times.
#![allow(clippy::unwrap_used)]

#[path = "support/hostile_inputs.rs"]
mod hostile_inputs;

use cylfuse::error::Error;
use cylfuse::fitter::{Flags, Options, StartKind};
use cylfuse::scene::{Detector, DetectorOptions, Found, Observer};
use hostile_inputs::{Hostile, hostile};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

fn input(name: &str) -> Hostile {
    hostile().into_iter().find(|input| input.name == name).unwrap()
}

/// How often a fit asked, and whether it was cancelled when it was told to end at a question.
fn fit(input: &Hostile, start: StartKind, end: usize) -> (usize, bool) {
    let mut fitter = input.fitter();
    fitter.set_options(Options { start, ..Options::default() }).unwrap();
    let mut asked = 0;
    let outcome = fitter.fit_with(&mut |_| {
        asked += 1;
        if asked >= end { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    (asked, matches!(outcome, Err(Error::Cancelled { .. })))
}

/// The same of a search.
fn search(input: &Hostile, end: usize) -> (usize, bool) {
    let asked = AtomicUsize::new(0);
    let mut observer = Observer {
        progress: &mut |_| ControlFlow::Continue(()),
        stopped: &|| asked.fetch_add(1, Ordering::Relaxed) + 1 >= end,
    };
    let outcome = Detector::new().detect_with(&input.frame(), &mut observer);
    (asked.into_inner(), matches!(outcome, Err(Error::Cancelled { .. })))
}

const NEVER: usize = usize::MAX;

#[test]
fn the_search_for_the_body_in_a_mask_asks_and_ends() {
    let input = input("bumps every 12 pixels");
    // With moments for a start there are no random samples that ask.
    let (asked, _) = fit(&input, StartKind::Moments, NEVER);
    assert!((150..1000).contains(&asked), "{asked}");
    for end in [1, 2, 100, 150] {
        assert_eq!(fit(&input, StartKind::Moments, end), (end, true));
    }
}

#[test]
fn a_fit_to_dense_depth_that_is_no_cylinder_ends() {
    for name in ["half cylinders 24 wide and 60 long", "1000 segments", "noise of 0.001"] {
        let (asked, _) = fit(&input(name), StartKind::Auto, NEVER);
        // Twice 1500, of a part of the points each, and what ends the fit.
        assert!(asked < 3500, "{name}: {asked}");
    }
}

/// How often a fit asks with nothing to report: with the iteration that it told of before.
fn asked_between_iterations(input: &Hostile, end: usize) -> (usize, bool) {
    let mut fitter = input.fitter();
    let (mut asked, mut last) = (0, (0, f64::INFINITY, 0.0));
    let outcome = fitter.fit_with(&mut |iteration| {
        let told = (iteration.iteration, iteration.cost, iteration.lambda);
        asked += usize::from(told == last && told.1.is_finite());
        last = told;
        if asked >= end { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    (asked, matches!(outcome, Err(Error::Cancelled { .. })))
}

/// A can of radius 0.04 that stands at 0.7, bright before dark.
fn can() -> Hostile {
    let (mut depth, mut mask, mut image) = (Vec::new(), Vec::new(), Vec::new());
    for k in 0..640 * 480 {
        let [x, y] = [(f64::from(k % 640) - 319.5) / 525.0, (f64::from(k / 640) - 239.5) / 525.0];
        let root: f64 = 0.49 - (1.0 + x * x) * (0.49 - 0.04 * 0.04);
        let z = (0.7 - root.max(0.0).sqrt()) / (1.0 + x * x);
        let seen = root > 0.0 && (y * z).abs() < 0.06;
        depth.push(if seen { z as f32 } else { 1.0 });
        mask.push(u8::from(seen));
        image.push(if seen { 190 } else { 60 });
    }
    Hostile { name: "can".into(), depth, mask, image: Some(image), segments: Vec::new() }
}

#[test]
fn the_location_of_limbs_and_ends_asks() {
    let can = can();
    let (asked, cancelled) = asked_between_iterations(&can, NEVER);
    // Once about the limbs and four times about the ends, in each round.
    assert!(asked >= 5 && !cancelled, "{asked}");
    for end in 1..=asked {
        assert_eq!(asked_between_iterations(&can, end), (end, true));
    }
}

/// The can in an image that moved evenly over some columns while it was taken.
fn moved(columns: usize) -> Hostile {
    let can = can();
    let image = can.image.unwrap();
    let value = |k: usize| {
        let row = &image[k / 640 * 640..][..640];
        let sum: usize = (0..columns).map(|d| usize::from(row[(k % 640 + d).min(639)])).sum();
        (sum / columns) as u8
    };
    Hostile { name: "moved".into(), image: Some((0..image.len()).map(value).collect()), ..can }
}

#[test]
fn the_location_of_limbs_asks_before_each_grid() {
    let (sharp, _) = asked_between_iterations(&can(), NEVER);
    let moved = moved(12);
    let (asked, _) = asked_between_iterations(&moved, NEVER);
    assert!(asked > sharp + 1, "{asked}, {sharp} of a sharp image");
    for end in 1..=asked {
        assert_eq!(asked_between_iterations(&moved, end), (end, true));
    }
}

#[test]
fn a_search_ends_and_hears_that_it_shall() {
    let input = input("bumps every 12 pixels");
    let (asked, cancelled) = search(&input, NEVER);
    assert!((150..1000).contains(&asked) && !cancelled, "{asked}");
    for end in [1, 3, 10, 150, asked - 20] {
        let (asked, cancelled) = search(&input, end);
        // Those that end it may ask again, but do no more.
        assert!(cancelled && asked < end + 10, "{end}: {asked}");
    }
}

#[test]
fn a_search_with_all_its_fits_ends_and_says_that_it_was_cut_short() {
    // Without a bound on the fits these ask 42,000, 24,000, 12,000 and 4,900 times.
    for name in ["24 wide and 60", "40 wide and 120", "80 wide and 200", "40 wide and 1000000000"] {
        let name = format!("half cylinders {name} long, with an image");
        let asked = AtomicUsize::new(0);
        let mut observer = Observer {
            progress: &mut |_| ControlFlow::Continue(()),
            stopped: &|| asked.fetch_add(1, Ordering::Relaxed) == usize::MAX,
        };
        let scene = Detector::new().detect_with(&input(&name).frame(), &mut observer).unwrap();
        let asked = asked.into_inner();
        assert!(asked < 20_000 && !scene.complete && !scene.cylinders.is_empty(), "{name}: {asked}");
        // The last one that the work reached is what the search found, if that is good enough: no fit looked for its limbs.
        let left = |found: &&Found| {
            let not_converged = found.result.flags.contains(Flags::NOT_CONVERGED);
            found.result.iterations == 0 && not_converged && found.limbs().is_none()
        };
        assert!(scene.cylinders.iter().filter(left).count() <= 1, "{name}");
    }
}

#[test]
fn pairs_of_edges_are_work() {
    // Squares have thousands of edges, and these millions of pairs. Asked once an edge it was 3,100 times.
    let (asked, _) = search(&input("huge cylinder, image of squares of 16 pixels"), NEVER);
    assert!(asked < 1_500, "{asked}");
}

#[test]
fn a_search_that_is_cut_short_gives_the_same_bits_for_any_number_of_threads() {
    let input = input("half cylinders 24 wide and 60 long, with an image");
    let scenes = [1, 2, 3].map(|threads| {
        let mut detector = Detector::new();
        detector.set_options(DetectorOptions { threads, ..DetectorOptions::default() }).unwrap();
        detector.detect(&input.frame()).unwrap()
    });
    let cylinders = scenes.each_ref().map(|scene| {
        scene.cylinders.iter().map(|found| (found.score, found.result.cylinder)).collect::<Vec<_>>()
    });
    assert!(cylinders[0].len() > 20 && !scenes[0].complete);
    for threads in [1, 2] {
        assert_eq!(cylinders[0], cylinders[threads]);
        assert_eq!(scenes[0].labels, scenes[threads].labels);
    }
}
