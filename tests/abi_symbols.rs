//! What old programs rely on besides the layout of structs: exported functions, soname, status numbers.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "a test program")]

mod common;

use common::{assert_committed, header, library, root, run};
use cylfuse::ffi::STATUSES;
use std::collections::BTreeMap;
use std::process::Command;

#[test]
fn the_library_exports_the_functions_of_the_interface_and_nothing_else() {
    let listing = run(Command::new("nm")
        .args(["-D", "--defined-only", "--format=posix"])
        .arg(library("libcylfuse.so")));
    let mut names: Vec<&str> = listing.lines().filter_map(|line| line.split(' ').next()).collect();
    names.sort_unstable();
    let list: String = names.iter().map(|name| format!("{name}\n")).collect();
    assert_committed("symbols.txt", &list);

    let header = header();
    for name in names {
        assert!(header.contains(&format!("{name}(")), "{name} is not in the header");
    }
    let declared = header.matches("CYLFUSE_NOEXCEPT;").count();
    assert_eq!(declared, list.lines().count());
}

#[test]
fn the_soname_changes_with_every_version_that_may_break_programs() {
    // cargo-c, whose feature this is, sets a soname of its own.
    if cfg!(feature = "capi") {
        eprintln!("skipped: cargo-c sets the soname");
        return;
    }
    let dynamic = run(Command::new("readelf").arg("-d").arg(library("libcylfuse.so")));
    let [major, minor] = [env!("CARGO_PKG_VERSION_MAJOR"), env!("CARGO_PKG_VERSION_MINOR")];
    let version = if major == "0" { format!("0.{minor}") } else { major.into() };
    assert!(dynamic.contains(&format!("Library soname: [libcylfuse.so.{version}]")), "{dynamic}");
}

/// One list: the committed file, the constants of the header, what `cylfuse_status_string` knows, the errors of the library.
#[test]
fn status_numbers_are_never_changed() {
    let name = |text: &str| text.split(':').next().unwrap_or_default().to_string();
    let known: Vec<(i32, String)> =
        STATUSES.iter().map(|(status, text)| (status.0, name(text.to_str().unwrap()))).collect();
    let list: String = known.iter().map(|(number, name)| format!("{number} {name}\n")).collect();
    assert_committed("status_codes.txt", &list);

    let defined: Vec<(i32, String)> = header()
        .lines()
        .filter_map(|line| line.strip_prefix("#define CYLFUSE_STATUS_")?.split_once(' '))
        .map(|(name, number)| (number.trim_matches(['(', ')']).parse().unwrap(), name.to_string()))
        .collect();
    assert_eq!(defined, known);

    // The numbers and names as `Error::code` and `Error::name` give them, by variant.
    let source = std::fs::read_to_string(root().join("src/error.rs")).unwrap();
    let mut errors: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for line in source.lines() {
        if let Some((variant, value)) = line.trim().split_once(" { .. } => ") {
            errors.entry(variant).or_default().push(value.trim_end_matches(',').trim_matches('"'));
        }
    }
    assert!(errors.len() > 10, "the matches in error.rs look different now");
    for (variant, values) in errors {
        let [number, name] = values[..] else { panic!("{variant}: {values:?}") };
        assert!(known.contains(&(number.parse().unwrap(), name.into())), "{variant} has no status");
    }
}
