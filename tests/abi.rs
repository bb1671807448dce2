//! Programs of the release that froze the interface run with this library, and what the header says is what it said then, but
//! for what docs/abi.md allows.
//!
//! `CYLFUSE_FREEZE_ABI=1 cargo test --release --test abi` writes tests/abi/0.2.0 and its baseline anew: until that release
//! is out.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "a test program")]

mod common;
#[path = "abi/packages.rs"]
mod packages;

use common::{c_compiler, cpp_compiler, header, library, root, run, scratch};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The release that froze the interface.
const FROZEN: &str = "0.2.0";

fn frozen() -> PathBuf {
    root().join("tests/abi").join(FROZEN)
}

/// Whether the files of the frozen release are written anew. The first test that asks copies the headers.
fn freeze() -> bool {
    static COPIED: std::sync::OnceLock<bool> = std::sync::OnceLock::new();
    *COPIED.get_or_init(|| {
        let wanted = std::env::var_os("CYLFUSE_FREEZE_ABI").is_some();
        if wanted {
            let to = frozen().join("include/cylfuse");
            let _ = std::fs::remove_dir_all(frozen());
            std::fs::create_dir_all(&to).unwrap();
            for entry in std::fs::read_dir(root().join("include/cylfuse")).unwrap() {
                let path = entry.unwrap().path();
                let name = path.file_name().unwrap().to_str().unwrap();
                // What needs another library is frozen with that one.
                if !["eigen", "opencv", "pcl"].iter().any(|library| name.starts_with(library)) {
                    std::fs::copy(&path, to.join(name)).unwrap();
                }
            }
        }
        wanted
    })
}

/// Compiles a client without linking it.
fn compile(compiler: &mut Command, standard: &str, source: &str, headers: &Path, object: &Path) {
    let source = root().join("tests/abi").join(source);
    // No debug information and no position of this checkout.
    let flags = ["-O1", "-fPIC", "-Wall", "-Wextra", "-Werror", "-c", "-o"];
    run(compiler.arg(standard).args(flags).arg(object).arg("-I").arg(headers).arg(source));
}

/// Links a client with the library of this build, and runs it.
fn runs(name: &str, compiler: &mut Command, object: &Path) {
    let folder = scratch(&format!("abi_{name}"));
    let shared = library("libcylfuse.so");
    std::os::unix::fs::symlink(&shared, folder.join("libcylfuse.so")).unwrap();
    let dynamic = run(Command::new("readelf").arg("-d").arg(&shared));
    let soname = dynamic.split("soname: [").nth(1).and_then(|rest| rest.split(']').next()).unwrap();
    std::os::unix::fs::symlink(&shared, folder.join(soname)).unwrap();
    let program = folder.join("client");
    let rpath = format!("-Wl,-rpath,{}", folder.display());
    run(compiler.arg(object).arg("-o").arg(&program).arg("-L").arg(&folder).args([
        "-lcylfuse",
        "-lm",
        &rpath,
    ]));
    assert_eq!(run(Command::new(program).env_remove("LD_LIBRARY_PATH")), "the client runs\n");
}

/// A client compiled with the headers of then, and the object file of then.
fn old_client(name: &str, source: &str, standard: &str, compiler: fn() -> Command) {
    let freeze = freeze();
    let headers = frozen().join("include");
    let object = scratch(&format!("abi_{name}_object")).join("client.o");
    compile(&mut compiler(), standard, source, &headers, &object);
    runs(&format!("{name}_source"), &mut compiler(), &object);
    // The object file is that of one platform.
    if cfg!(all(target_arch = "x86_64", target_env = "gnu")) {
        let kept = frozen().join(format!("{name}-x86_64-linux-gnu.o"));
        if freeze {
            std::fs::copy(&object, &kept).unwrap();
        }
        runs(&format!("{name}_object_of_then"), &mut compiler(), &kept);
    }
}

#[test]
fn a_program_of_the_frozen_release_in_c_runs() {
    old_client("client_c", "client.c", "-std=c99", c_compiler);
}

#[test]
fn a_program_of_the_frozen_release_in_cpp_runs() {
    old_client("client_cpp", "client.cpp", "-std=c++14", cpp_compiler);
}

#[test]
fn a_program_of_a_later_release_degrades_as_documented() {
    let object = scratch("abi_newer_object").join("newer.o");
    compile(&mut c_compiler(), "-std=gnu99", "newer.c", &root().join("include"), &object);
    runs("newer", &mut c_compiler(), &object);
}

/// A library with the functions of a header, which do nothing: all that abidw needs to know of the interface, as programs see
/// it. That the functions of the real library are the same is checked by tests/header.rs, abi_layout.rs and abi_symbols.rs.
fn interface_of(name: &str, header: &str) -> PathBuf {
    let folder = scratch(name);
    let source = folder.join("interface.c");
    std::fs::write(&source, header.replace("CYLFUSE_NOEXCEPT;", "{ return 0; }")).unwrap();
    let shared = folder.join("libcylfuse.so");
    // The position of this checkout is no part of the interface.
    let position = format!("-fdebug-prefix-map={}=.", folder.display());
    let flags = ["-std=c99", "-g", "-shared", "-fPIC", &position, "-o"];
    run(c_compiler().args(flags).arg(&shared).arg(&source));
    shared
}

/// What abidiff finds that is no growth; empty when nothing.
fn breaks(old: &Path, new: &Path) -> String {
    let report = |more: &[&std::ffi::OsStr]| {
        let flags = ["--no-added-syms", "--no-show-locs"];
        let output = Command::new("abidiff").args(flags).args(more).arg(old).arg(new).output().unwrap();
        if output.status.success() {
            return String::new();
        }
        String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned()
    };
    let suppressions = root().join("tests/abi/may-grow.suppr");
    let found = report(&["--suppressions".as_ref(), suppressions.as_ref()]);
    if !found.is_empty() {
        return found;
    }
    // A suppression of fields that were added hides a field that was changed, too.
    let all = report(&[]);
    let changed = all.contains("data member change") || all.contains("data member deletion");
    if changed { all } else { String::new() }
}

fn is_missing(tool: &str, package: &str) -> bool {
    let missing = Command::new(tool).arg("--version").output().is_err();
    if missing {
        assert!(std::env::var_os("CI").is_none(), "{tool} is missing (Debian package {package})");
        eprintln!("skipped: {tool} is missing (Debian package {package})");
    }
    missing
}

#[test]
fn the_interface_is_the_frozen_one_or_has_grown_as_it_may() {
    if is_missing("abidiff", "abigail-tools") {
        return;
    }
    let freeze = freeze();
    let baseline = root().join(format!("tests/abi/cylfuse-{FROZEN}.abi"));
    let now = interface_of("abi_now", &header());
    if freeze {
        let flags = ["--no-show-locs", "--no-comp-dir-path", "--no-corpus-path", "--out-file"];
        run(Command::new("abidw").args(flags).arg(&baseline).arg(&now));
    }
    let found = breaks(&baseline, &now);
    assert!(found.is_empty(), "the interface of {FROZEN} is broken:\n{found}");
}

/// What the check above would miss nobody would see.
#[test]
fn breaks_are_told_from_growth() {
    if is_missing("abidiff", "abigail-tools") {
        return;
    }
    let header = header();
    let before = interface_of("abi_before", &header);
    let changed = |name: &str, from: &str, to: &str| {
        assert!(header.contains(from), "{from}");
        breaks(&before, &interface_of(&format!("abi_{name}"), &header.replacen(from, to, 1)))
    };
    // Growth: a field at the end of a struct that names its size, a function, a constant.
    assert_eq!(changed("grown", "} cylfuse_options;", "double added; } cylfuse_options;"), "");
    assert_eq!(
        changed(
            "more",
            "#ifdef __cplusplus\n}",
            "int cylfuse_added(void) { return 0; }\n#ifdef __cplusplus\n}"
        ),
        ""
    );
    // Breaks.
    let moved = "    uint32_t struct_size;\n    /**\n     * How the cylinder is estimated. Default FUSED.";
    for (name, from, to) in [
        ("moved", moved, "    uint32_t struct_size; uint32_t between;\n    /**\n     * How"),
        ("fixed", "} cylfuse_cylinder;", "double added; } cylfuse_cylinder;"),
        (
            "narrowed",
            "    double edge_weight;\n    /**\n     * Seed",
            "    float edge_weight;\n    /**\n     * Seed",
        ),
        ("argument", "size_t index,\n", "uint32_t index, size_t more,\n"),
        ("removed", "cylfuse_status cylfuse_fitter_clear(", "cylfuse_status cylfuse_fitter_wipe("),
    ] {
        assert!(!changed(name, from, to).is_empty(), "{name} is not found");
    }
}
