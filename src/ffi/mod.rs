//! The C interface, declared in `include/cylfuse/cylfuse.h`, which is generated from this folder: its doc
//! comments are written for readers of the header.
//!
//! This layer only translates: pointers to checked views, structs to options and results, errors to statuses.
//! It is the only part of the crate with `unsafe` code (but for one cast in the views of slices).
//!
//! How a call runs:
//!
//! - [`guard`] catches panics,
//! - [`handle`] takes the busy flag of the fitter, keeps the message of a failure and poisons the fitter after a
//!   panic,
//! - [`sized`] reads and writes the structs whose first field is their size,
//! - [`views`] turns pointers and strides into the views of the safe library,
//! - the files named after the groups of functions do the rest.
//!
//! The contract behind every `unsafe` block here is the header's: a pointer is NULL or points to as many bytes
//! as the parameter or the struct says, and stays valid during the call. Everything else is checked.

// The names are those of the header. The texts are for its readers: what a caller must keep to is said of each
// parameter, and statuses are named without their prefix.
#![allow(non_camel_case_types, clippy::missing_safety_doc, clippy::doc_markdown)]

#[cfg(panic = "abort")]
compile_error!("cylfuse reports panics as CYLFUSE_STATUS_PANIC, which needs panic = \"unwind\"");

mod apply;
mod constants;
mod cylinder;
mod data;
mod guard;
mod handle;
mod library;
mod lifetime;
mod options;
#[cfg(feature = "panic-test")]
mod panic_test;
mod setup;
mod sized;
mod solve;
mod status;
mod structs;
mod views;

pub use apply::*;
pub use constants::*;
pub use cylinder::*;
pub use data::*;
pub use handle::cylfuse_fitter;
pub use library::*;
pub use lifetime::*;
#[cfg(feature = "panic-test")]
pub use panic_test::*;
pub use setup::*;
pub use solve::*;
pub use status::{STATUSES, cylfuse_status};
pub use structs::*;
