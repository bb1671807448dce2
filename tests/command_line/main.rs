//! The program `cylfuse` from outside: what it prints, what it writes, what it refuses.
#![cfg(feature = "cli")]
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod bad_input;
#[cfg(feature = "bench")]
mod bench;
mod clouds;
mod detect;
mod formats;
mod options;
mod output;
mod plan;
mod report;
#[path = "../support/scene.rs"]
mod scene;
mod support;
#[cfg(feature = "twin")]
mod twin;
mod views;
