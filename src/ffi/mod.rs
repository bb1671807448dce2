//! The C interface, declared in `include/cylfuse/cylfuse.h`, which is generated from this folder: its doc
//! comments are written for readers of the header.
//!
//! This layer only translates: pointers to checked views, structs to options and results, errors to statuses.
//! It is the only part of the crate with `unsafe` code (but for one cast in the views of slices).
//!
//! How a call runs:
//!
//! - `guard` catches panics,
//! - `handle` lets many readers or one writer in (`access`), keeps the text of a failure (`texts`) and poisons the
//!   handle after a panic,
//! - `sized` reads and writes the structs that grow with later versions,
//! - `views` turns pointers and strides into the views of the safe library,
//! - `lists` reads and writes plain numbers,
//! - the files named after the groups of functions do the rest.
//!
//! The contract behind the `unsafe` blocks of the exported functions is the header's, and each block names what it
//! needs of it. A handle is alive from its create function to its destroy function. Any other pointer is NULL or
//! leads to as many bytes as the parameter or the struct says, during the whole call; nobody writes to what is read
//! meanwhile, and nobody touches what is written. Everything else is checked.

// The names are those of the header. The texts are for its readers: what a caller must keep to is said of each
// parameter, and statuses are named without their prefix.
#![allow(non_camel_case_types, clippy::missing_safety_doc, clippy::doc_markdown)]

#[cfg(panic = "abort")]
compile_error!("cylfuse reports panics as CYLFUSE_STATUS_PANIC, which needs panic = \"unwind\"");

mod access;
mod apply;
mod arrays;
mod batch;
mod callbacks;
mod camera;
mod conformity;
mod constants;
mod cylinder;
mod data;
mod defaults;
mod detections;
mod detector;
mod frame;
mod guard;
mod handle;
mod library;
mod lifetime;
mod lists;
mod options;
mod outcomes;
mod panic_test;
mod results;
mod setup;
mod sized;
mod solve;
mod status;
mod strings;
mod structs;
mod texts;
#[cfg(test)]
mod thread_tests;
mod views;

pub use apply::*;
pub use arrays::*;
pub use batch::*;
pub use callbacks::{cylfuse_detection_progress_fn, cylfuse_fit_all_fn, cylfuse_log_fn, cylfuse_progress_fn};
pub use camera::*;
pub use conformity::*;
pub use constants::*;
pub use cylinder::*;
pub use data::*;
pub use defaults::*;
pub use detections::*;
pub use detector::*;
pub use frame::*;
pub use handle::cylfuse_fitter;
pub use library::{
    CYLFUSE_ABI_VERSION, cylfuse_abi_version, cylfuse_build_info, cylfuse_status_string,
    cylfuse_version_number, cylfuse_version_string,
};
pub use lifetime::*;
pub use outcomes::*;
#[doc(hidden)]
pub use panic_test::panic_in_a_call;
pub use results::*;
pub use setup::*;
pub use solve::*;
pub use status::{STATUSES, cylfuse_status};
pub use strings::*;
pub use structs::*;
