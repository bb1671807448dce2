//! The program `cylfuse` from outside: what it prints, what it writes, what it refuses.
#![cfg(feature = "cli")]

mod bad_input;
mod clouds;
mod formats;
mod options;
mod output;
mod support;
