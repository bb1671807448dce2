//! Builds the C program in tests/c, which walks the whole interface, and runs it against the library in several
//! ways.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "a test program")]

mod common;

use common::{c_compiler, library, root, run, scratch};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What `rustc --print native-static-libs` lists.
const SYSTEM_LIBRARIES: [&str; 7] = ["-lgcc_s", "-lutil", "-lrt", "-lpthread", "-lm", "-ldl", "-lc"];

/// The walk asks for more memory than there is, on purpose.
const ASAN_OPTIONS: &str = "allocator_may_return_null=1:detect_stack_use_after_return=1";

/// The program linked with the shared library, next to which it finds it.
fn build(name: &str, shared_library: &Path, flags: &[&str]) -> PathBuf {
    link_shared(name, shared_library, compile(flags))
}

fn link_shared(name: &str, shared_library: &Path, mut compiler: Command) -> PathBuf {
    let folder = scratch(name);
    // The linker looks for the first name, the loader for the soname, which begins with it.
    let link = |file: &str| std::os::unix::fs::symlink(shared_library, folder.join(file)).unwrap();
    link("libcylfuse.so");
    link(&soname());
    let program = folder.join("walk");
    let rpath = format!("-Wl,-rpath,{}", folder.display());
    run(compiler.arg("-o").arg(&program).arg("-L").arg(&folder).args(["-lcylfuse", "-lm", &rpath]));
    program
}

fn compile(flags: &[&str]) -> Command {
    compile_folder(flags, "tests/c")
}

fn compile_folder(flags: &[&str], folder: &str) -> Command {
    let mut sources: Vec<_> =
        std::fs::read_dir(root().join(folder)).unwrap().map(|entry| entry.unwrap().path()).collect();
    sources.retain(|path| path.extension().is_some_and(|extension| extension == "c"));
    sources.sort();
    let mut compiler = c_compiler();
    compiler
        .args(["-std=c99", "-D_POSIX_C_SOURCE=200809L", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-g"])
        .arg("-pthread")
        .args(flags)
        .arg("-I")
        .arg(root().join("include"))
        .args(sources);
    compiler
}

/// A program that finds the library by its rpath only: the path that cargo sets for tests may lead to a library
/// from an earlier build.
fn start(program: impl AsRef<OsStr>) -> Command {
    let mut command = Command::new(program);
    command.env_remove("LD_LIBRARY_PATH");
    command
}

/// The same with sanitizers. Where the kernel draws addresses at random over a wide range, as some do, memory comes to lie
/// where those of gcc 12 keep their own now and then.
fn start_sanitized(program: impl AsRef<OsStr>) -> Command {
    let fixed = Command::new("setarch").args(["-R", "true"]).output();
    if fixed.is_ok_and(|output| output.status.success()) {
        let mut command = start("setarch");
        command.arg("-R").arg(program);
        command
    } else {
        start(program)
    }
}

fn soname() -> String {
    let [major, minor] = [env!("CARGO_PKG_VERSION_MAJOR"), env!("CARGO_PKG_VERSION_MINOR")];
    if major == "0" { format!("libcylfuse.so.0.{minor}") } else { format!("libcylfuse.so.{major}") }
}

#[test]
fn the_walk_holds_with_the_shared_library() {
    let program = build("c_shared", &library("libcylfuse.so"), &["-O2"]);
    assert_eq!(run(&mut start(program)), "all checks hold\n");
}

#[test]
fn the_walk_holds_with_the_static_library() {
    let program = scratch("c_static").join("walk");
    run(compile(&[]).arg("-o").arg(&program).arg(library("libcylfuse.a")).args(SYSTEM_LIBRARIES));
    assert_eq!(run(&mut start(program)), "all checks hold\n");
}

#[test]
fn the_walk_holds_with_sanitizers() {
    let flags =
        ["-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-fno-omit-frame-pointer"];
    let program = build("c_sanitized", &library("libcylfuse.so"), &flags);
    assert_eq!(run(start_sanitized(program).env("ASAN_OPTIONS", ASAN_OPTIONS)), "all checks hold\n");
}

#[test]
fn the_walk_holds_under_valgrind() {
    if Command::new("valgrind").arg("--version").output().is_err() {
        assert!(std::env::var_os("CI").is_none(), "valgrind is missing (Debian package valgrind)");
        eprintln!("skipped: valgrind is missing (Debian package valgrind)");
        return;
    }
    let program = build("c_valgrind", &library("libcylfuse.so"), &["-O1"]);
    let leaks = "--errors-for-leak-kinds=definite,indirect,possible";
    let suppressions = format!("--suppressions={}", root().join("tests/c/valgrind.supp").display());
    let valgrind = ["-q", "--error-exitcode=99", "--leak-check=full", leaks, &suppressions];
    assert_eq!(run(start("valgrind").args(valgrind).arg(program)), "all checks hold\n");
}

/// Runs one case of tests/c/defects, by its name: nothing but its own line may be printed, by the library neither.
fn defect(arguments: &[&str]) {
    let name = format!("c_defect_{}", arguments.join("_"));
    let compiler = compile_folder(&["-O1"], "tests/c/defects");
    let program = link_shared(&name, &library("libcylfuse.so"), compiler);
    let output = start(program).args(arguments).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let (stdout, stderr) = (text(&output.stdout), text(&output.stderr));
    assert_eq!((stdout.as_str(), stderr.as_str()), ("all checks hold\n", ""), "{}", output.status);
}

#[test]
fn a_mask_without_pixels_is_refused() {
    defect(&["empty_masks"]);
}

#[test]
fn an_extent_takes_bounded_time() {
    defect(&["endless_extents"]);
}

#[test]
fn memory_that_runs_out_is_told() {
    for call in ["push", "residuals", "fit", "diagnose", "detect"] {
        defect(&["short_memory", call]);
    }
}

#[test]
fn a_thread_that_cannot_be_started_is_done_without() {
    defect(&["no_threads"]);
}

#[test]
fn variances_are_possible_or_unknown() {
    defect(&["impossible_variances"]);
}

#[test]
fn intrinsics_in_a_wrong_unit_break_nothing() {
    defect(&["intrinsics_in_a_wrong_unit"]);
}

#[test]
fn ransac_can_be_cancelled() {
    defect(&["deaf_ransac"]);
}

#[test]
fn limits_that_no_arithmetic_keeps_are_named() {
    defect(&["endless_limits"]);
}

#[test]
fn calls_return_what_they_list() {
    defect(&["statuses_and_overflow"]);
}

#[test]
fn texts_are_those_of_the_last_call_and_whole() {
    defect(&["stale_and_cut_texts"]);
}

#[test]
fn evaluate_agrees_with_fit() {
    defect(&["evaluate_and_fit"]);
}

#[test]
fn a_panic_inside_leaves_the_process_alive_and_silent() {
    let program = build("c_panic", &library_that_panics(), &["-O1", "-DCYLFUSE_PANIC_TEST"]);
    let output = start(program).output().unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stdout), "all checks hold\n");
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    assert!(output.status.success(), "{}", output.status);
}

/// Sanitises the Rust side too, where all pointers of the caller are read and written.
#[test]
#[ignore = "needs a nightly toolchain and compiles everything anew, for minutes"]
fn the_walk_holds_with_a_sanitized_library() {
    let triple = "x86_64-unknown-linux-gnu";
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("sanitized");
    let arguments =
        ["run", "nightly", "cargo", "rustc", "--lib", "--crate-type", "staticlib", "--target", triple];
    let mut cargo = Command::new("rustup");
    cargo.current_dir(root()).env_remove("CARGO").env_remove("RUSTC").env("RUSTFLAGS", "-Zsanitizer=address");
    run(cargo.args(arguments).arg("--target-dir").arg(&target));
    let program = scratch("c_sanitized_library").join("walk");
    let library = target.join(triple).join("debug/libcylfuse.a");
    run(compile(&["-fsanitize=address"]).arg("-o").arg(&program).arg(library).args(SYSTEM_LIBRARIES));
    assert_eq!(run(start_sanitized(program).env("ASAN_OPTIONS", ASAN_OPTIONS)), "all checks hold\n");
}

/// The library with one more export, of what this test is linked with.
fn library_that_panics() -> PathBuf {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.current_dir(root()).args(["build", "--locked", "--example", "panic_library"]);
    if !cfg!(debug_assertions) {
        cargo.arg("--release");
    }
    if cfg!(feature = "bench") {
        cargo.args(["--features", "bench"]);
    }
    run(&mut cargo);
    // Examples lie beside the folder of what they and the tests depend on.
    library("libcylfuse.so").ancestors().nth(2).unwrap().join("examples/libpanic_library.so")
}
