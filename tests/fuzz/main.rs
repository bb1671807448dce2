//! Input at random: sequences of calls on the C interface with hostile values, and damaged files for the readers of the
//! command line.
//!
//! Every case follows from its number, which is printed when a case fails, crashes or takes too long:
//!
//! - `tests/fuzz.sh 10000000 1000000` makes that many calls and reads that many files,
//! - `CYLFUSE_FUZZ_CASE=1234 cargo test --release --features cli --test fuzz calls` runs one case alone.
//!
//! What is checked: no crash, no panic, no case beyond [`watch::LIMIT`], no byte read or written beyond a buffer (there is a
//! page without access behind or before each), no memory kept, no status that the header does not name for the call, no
//! number in the outcome of a call that succeeded that the header does not allow.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "a test program")]
#![allow(
    clippy::undocumented_unsafe_blocks,
    clippy::macro_metavars_in_unsafe,
    reason = "all are calls of the interface with memory that `memory` laid out"
)]

mod calls;
mod checks;
mod completion;
mod detector;
mod files;
mod fitter;
mod found;
mod grids;
mod inputs;
mod lists;
mod memory;
mod statuses;
mod values;
mod watch;
mod without_handle;

#[path = "../support/random_views.rs"]
mod random_views;

// The readers of the command line, which is no library.
#[allow(dead_code)]
#[path = "../../src/bin/cylfuse/canvas.rs"]
mod canvas;
#[allow(dead_code, unused_imports)]
#[path = "../../src/bin/cylfuse/cloud/mod.rs"]
mod cloud;
#[allow(dead_code)]
#[path = "../../src/bin/cylfuse/failure.rs"]
mod failure;
#[allow(dead_code)]
#[path = "../../src/bin/cylfuse/frame.rs"]
mod frame;
#[allow(dead_code)]
#[path = "../../src/bin/cylfuse/images.rs"]
mod images;

#[global_allocator]
static ALLOCATOR: memory::Counting = memory::Counting;

/// A number from the environment.
fn setting(name: &str) -> Option<u64> {
    let text = std::env::var(name).ok()?;
    Some(text.parse().unwrap_or_else(|_| panic!("{name} is {text}; it must be a whole number")))
}
