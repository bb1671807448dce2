//! Builds the C program in tests/c, which walks the whole interface, and runs it against the library in several
//! ways.

#![allow(clippy::unwrap_used, reason = "a test program")]

mod common;

use common::{c_compiler, library, root, run, scratch};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The program linked with the shared library, next to which it finds it.
fn build(name: &str, shared_library: &Path, flags: &[&str]) -> PathBuf {
    let folder = scratch(name);
    // The linker looks for the first name, the loader for the soname, which begins with it.
    let link = |file: &str| std::os::unix::fs::symlink(shared_library, folder.join(file)).unwrap();
    link("libcylfuse.so");
    link(&soname());
    let program = folder.join("walk");
    let rpath = format!("-Wl,-rpath,{}", folder.display());
    run(compile(flags).arg("-o").arg(&program).arg("-L").arg(&folder).args(["-lcylfuse", "-lm", &rpath]));
    program
}

fn compile(flags: &[&str]) -> Command {
    let mut sources: Vec<_> =
        std::fs::read_dir(root().join("tests/c")).unwrap().map(|entry| entry.unwrap().path()).collect();
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

fn soname() -> String {
    let [major, minor] = [env!("CARGO_PKG_VERSION_MAJOR"), env!("CARGO_PKG_VERSION_MINOR")];
    if major == "0" { format!("libcylfuse.so.0.{minor}") } else { format!("libcylfuse.so.{major}") }
}

#[test]
fn the_walk_holds_with_the_shared_library() {
    let program = build("c_shared", &library("libcylfuse.so"), &["-O2"]);
    assert_eq!(run(&mut Command::new(program)), "all checks hold\n");
}

#[test]
fn the_walk_holds_with_the_static_library() {
    let program = scratch("c_static").join("walk");
    // What `rustc --print native-static-libs` lists.
    let system = ["-lgcc_s", "-lutil", "-lrt", "-lpthread", "-lm", "-ldl", "-lc"];
    run(compile(&[]).arg("-o").arg(&program).arg(library("libcylfuse.a")).args(system));
    assert_eq!(run(&mut Command::new(program)), "all checks hold\n");
}

#[test]
fn the_walk_holds_with_sanitizers() {
    let flags =
        ["-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-fno-omit-frame-pointer"];
    let program = build("c_sanitized", &library("libcylfuse.so"), &flags);
    // The walk asks for more memory than there is, on purpose.
    let options = "allocator_may_return_null=1:detect_stack_use_after_return=1";
    assert_eq!(run(Command::new(program).env("ASAN_OPTIONS", options)), "all checks hold\n");
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
    let valgrind = ["-q", "--error-exitcode=99", "--leak-check=full", leaks];
    assert_eq!(run(Command::new("valgrind").args(valgrind).arg(program)), "all checks hold\n");
}

#[test]
fn a_panic_inside_leaves_the_process_alive_and_silent() {
    let library =
        if cfg!(feature = "panic-test") { library("libcylfuse.so") } else { library_with_panic_test() };
    let program = build("c_panic", &library, &["-O1", "-DCYLFUSE_PANIC_TEST"]);
    let output = Command::new(program).output().unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stdout), "all checks hold\n");
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    assert!(output.status.success(), "{}", output.status);
}

/// The library with one more export, in a target folder of its own: the other tests need the one without.
fn library_with_panic_test() -> PathBuf {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("panic-test");
    let arguments = ["rustc", "--lib", "--crate-type", "cdylib", "--features", "panic-test"];
    // Everything is compiled once more for it: quickly.
    let profile = ["--config", "profile.dev.opt-level=0", "--config", "profile.dev.debug=false"];
    let mut cargo = Command::new(env!("CARGO"));
    run(cargo.current_dir(root()).args(arguments).args(profile).arg("--target-dir").arg(&target));
    target.join("debug/libcylfuse.so")
}
