//! How often a repeated call of the same size asks for memory, and that it keeps none of it.
#![allow(clippy::unwrap_used)]

#[path = "support/fits.rs"]
mod fits;
#[path = "support/frames.rs"]
mod frames;
mod support;

use cylfuse::fitter::{Fitter, Options, StartKind, fit_all};
use cylfuse::observations::Frame;
use cylfuse::scene::Detector;
use nalgebra::Vector3;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::ops::ControlFlow;

/// The allocator of the system, with counts for each thread.
struct Counting;

thread_local! {
    /// How often memory was asked for, and the bytes that are held.
    static ASKED: Cell<usize> = const { Cell::new(0) };
    static HELD: Cell<isize> = const { Cell::new(0) };
}

fn count(bytes: isize) {
    // A thread that ends has no counts any more.
    let _ = HELD.try_with(|held| held.set(held.get() + bytes));
    let _ = ASKED.try_with(|asked| asked.set(asked.get() + usize::from(bytes > 0)));
}

// SAFETY: every call goes to the allocator of the system as it is; counting asks for no memory.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as isize);
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        count(-(layout.size() as isize));
        // SAFETY: the caller keeps the contract of `dealloc`.
        unsafe { System.dealloc(memory, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// How often a call asks for memory that was made a few times before. At its end it must hold no more than at most those
/// before it did: what is handed out leaves now a larger list behind, now a smaller one.
fn asked_by<T>(mut call: impl FnMut() -> T) -> usize {
    // With each call there is more room for the next one, until there is enough: a few times for a fit, more for a scene.
    for _ in 0..16 {
        call();
    }
    let mut most = 0;
    for _ in 0..4 {
        call();
        most = HELD.get().max(most);
    }
    let asked = ASKED.get();
    drop(call());
    let asked = ASKED.get() - asked;
    assert!(HELD.get() <= most, "a call keeps memory: {most} -> {} bytes", HELD.get());
    asked
}

/// Fails where any of some calls asks for memory more often than it may.
fn check(counts: &[(&str, usize, usize)]) {
    let mut rises = String::new();
    for (name, asked, most) in counts {
        println!("{asked:6}  {name}");
        if asked > most {
            rises += &format!("{name}: {most} -> {asked}\n");
        }
    }
    assert!(rises.is_empty(), "memory is asked for more often:\n{rises}");
}

#[test]
fn repeated_fits_of_points_ask_for_no_memory() {
    let start = |start| Options { start, ..Options::default() };
    let paper = |start| fits::noisy(5_000, true, fits::paper(start));
    let robust = |edges, options| fits::noisy(5_000, edges, options);
    let cases = [
        ("paper, 5,000 points, from a model", paper(StartKind::Model)),
        ("paper, 5,000 points, from limbs", paper(StartKind::Limbs)),
        ("paper, 5,000 points, from moments", paper(StartKind::Moments)),
        ("paper, 5,000 points, from random samples", paper(StartKind::Ransac)),
        ("paper, 5,000 points", paper(StartKind::Auto)),
        ("robust, 5,000 points and edges", robust(true, Options::default())),
        ("robust, 5,000 points and edges, from a model", robust(true, start(StartKind::Model))),
        ("robust, 5,000 points and edges, from limbs", robust(true, start(StartKind::Limbs))),
        ("robust, 5,000 points and edges, from moments", robust(true, start(StartKind::Moments))),
        ("robust, 5,000 points and edges, from random samples", robust(true, start(StartKind::Ransac))),
        ("robust, 5,000 points and edges, from the last fit", robust(true, start(StartKind::Last))),
        ("robust, 5,000 points alone", robust(false, Options::default())),
        ("robust, 5,000 points alone, from a model", robust(false, start(StartKind::Model))),
    ];
    check(&cases.map(|(name, mut fitter)| (name, asked_by(|| fitter.fit().unwrap()), 0)));
}

#[test]
fn what_a_fitter_keeps_ends_with_it() {
    let held_by_fits = |count: usize| {
        let mut fitter = fits::framed(true, false);
        let held = HELD.get();
        for _ in 0..count {
            fitter.fit().unwrap();
        }
        let kept = HELD.get() - held;
        drop(fitter);
        kept
    };
    // Tables that all fits share are made by the first one.
    held_by_fits(1);
    let held = HELD.get();
    let kept = [1, 4].map(held_by_fits);
    // Before anything is printed: what the test's output is collected in is held, too.
    assert_eq!(HELD.get(), held, "memory is held beyond the fitter");
    println!("kept after one fit and after four: {kept:?} bytes");
    // An image of 640 x 480 pixels, its mask and its depth have 2 MB.
    assert!(kept.iter().all(|kept| (1..4_000_000).contains(kept)), "{kept:?}");
}

#[test]
fn many_fits_share_memory() {
    let asked = |count: usize| {
        let mut fitters: Vec<Fitter> = (0..count).map(|_| fits::framed(true, true)).collect();
        let asked = ASKED.get();
        let results = fit_all(&mut fitters, 1, &mut |_, _| ControlFlow::Continue(()));
        assert!(results.iter().all(Result::is_ok));
        ASKED.get() - asked
    };
    asked(1);
    let [few, many] = [8, 24].map(asked);
    println!("{few} times in 8 fits, {many} in 24");
    // Each keeps what belongs to its result and its points; alone it asks some thousand times.
    assert!(many - few < 16 * 20, "{few} {many}");
}

#[test]
fn what_a_detector_keeps_ends_with_it() {
    let frame = fits::scene(true);
    let detect = |detector: &Detector| drop(detector.detect(&frame).unwrap());
    // Tables that all fits share are made by the first one.
    detect(&fits::detector());
    let before = HELD.get();
    let detector = fits::detector();
    (0..3).for_each(|_| detect(&detector));
    let kept = HELD.get() - before;
    drop(detector);
    assert_eq!(HELD.get(), before, "memory is held beyond the detector");
    println!("kept after three scenes: {kept} bytes");
    assert!((1..8_000_000).contains(&kept), "{kept}");
}

#[test]
fn what_a_detector_finds_takes_no_more_room_than_it_needs() {
    let (detector, frame) = (fits::detector(), fits::scene(true));
    // Until the detector has memory for all that it lists.
    (0..8).for_each(|_| drop(detector.detect(&frame).unwrap()));
    let before = HELD.get();
    let scene = detector.detect(&frame).unwrap();
    let found = HELD.get();
    let copy = scene.clone();
    let (found, copied) = (found - before, HELD.get() - found);
    drop((scene, copy));
    println!("a scene takes {found} bytes, a copy {copied}");
    assert!(20 * found <= 21 * copied, "{found} {copied}");
}

#[test]
fn repeated_fits_of_images_ask_for_no_memory() {
    let cases = [
        ("robust, image and edges", fits::framed(true, true)),
        ("robust, image and mask", fits::framed(true, false)),
        ("robust, edges", fits::framed(false, true)),
        ("robust, mask", fits::framed(false, false)),
        ("robust, image and edges, from the last fit", fits::followed(true)),
        ("robust, image and mask, from the last fit", fits::followed(false)),
    ];
    check(&cases.map(|(name, mut fitter)| (name, asked_by(|| fitter.fit().unwrap()), 0)));
}

#[test]
fn what_follows_a_fit_asks_for_no_memory_when_it_is_asked_again() {
    let mut fitter = fits::framed(true, true);
    let cylinder = fitter.fit().unwrap().cylinder;
    let none = &mut |_, _, _: Option<Vector3<f64>>| {};
    let complete = asked_by(|| fitter.complete(None, None, none).unwrap());
    let depth = asked_by(|| fitter.complete_depth(None, None, &mut |_, _, _| {}).unwrap());
    let extent = asked_by(|| fitter.extent(None, None).unwrap());
    let evaluate = asked_by(|| fitter.evaluate(&cylinder).unwrap());
    check(&[
        ("completed points", complete, 0),
        ("completed depth", depth, 0),
        ("extent", extent, 0),
        ("evaluation", evaluate, 0),
    ]);
}

#[test]
fn a_repeated_detection_asks_for_memory_no_more_often_than_before() {
    let detector = fits::detector();
    let count = |frame: &Frame| asked_by(|| detector.detect(frame).unwrap());
    check(&[
        ("scene with image", count(&fits::scene(true)), 430),
        ("scene without image", count(&fits::scene(false)), 280),
    ]);
}
