//! How often a repeated fit of the same size asks for memory, and that it keeps none of it.
#![allow(clippy::unwrap_used)]

#[path = "support/fits.rs"]
mod fits;
#[path = "support/frames.rs"]
mod frames;
mod support;

use cylfuse::fitter::{Fitter, Options, StartKind};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

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

/// How often the third fit asks for memory. It must hold as much at its end as the second one.
fn asked_by(mut fitter: Fitter) -> usize {
    fitter.fit().unwrap();
    fitter.fit().unwrap();
    let (asked, held) = (ASKED.get(), HELD.get());
    fitter.fit().unwrap();
    let asked = ASKED.get() - asked;
    assert_eq!(HELD.get(), held, "a fit keeps memory");
    asked
}

#[test]
fn repeated_fits_ask_for_memory_no_more_often_than_before_and_keep_none() {
    let cases = [
        ("paper, 5,000 points, from a model", fits::noisy(5_000, true, fits::paper(StartKind::Model)), 40),
        ("robust, 5,000 points and edges", fits::noisy(5_000, true, Options::default()), 265),
        ("robust, image and edges", fits::framed(true, true), 3700),
        ("robust, image and mask", fits::framed(true, false), 5500),
    ];
    let mut rises = String::new();
    for (name, fitter, most) in cases {
        let asked = asked_by(fitter);
        println!("{asked:6}  {name}");
        if asked > most {
            rises += &format!("{name}: {most} -> {asked}\n");
        }
    }
    assert!(rises.is_empty(), "memory is asked for more often:\n{rises}");
}
