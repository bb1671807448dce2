//! The header is what the generator makes of the sources, and valid C99 and C++11.
//!
//! `CYLFUSE_REGENERATE_HEADER=1 cargo test --test header` writes it anew.

#![allow(clippy::unwrap_used, reason = "a test program")]

mod common;

use common::{c_compiler, cpp_compiler, header, root, run, scratch};
use std::process::Command;

/// The files of src/ffi in the order of the header. `panic_test` is not part of it.
const SOURCES: [&str; 23] = [
    "status",
    "constants",
    "outcomes",
    "structs",
    "results",
    "handle",
    "callbacks",
    "library",
    "defaults",
    "lifetime",
    "setup",
    "data",
    "frame",
    "detector",
    "detections",
    "solve",
    "batch",
    "arrays",
    "apply",
    "cylinder",
    "camera",
    "conformity",
    "strings",
];

fn version_macros() -> String {
    let [major, minor, patch] = version();
    let number = major << 16 | minor << 8 | patch;
    format!(
        "\n/** The first part of the version of this header; compare with `cylfuse_version_number()`. */\n\
         #define CYLFUSE_VERSION_MAJOR {major}\n\
         /** The second part. */\n\
         #define CYLFUSE_VERSION_MINOR {minor}\n\
         /** The third part. */\n\
         #define CYLFUSE_VERSION_PATCH {patch}\n\
         /** All three, with points between them. */\n\
         #define CYLFUSE_VERSION_STRING \"{}\"\n\
         /** major * 65536 + minor * 256 + patch. */\n\
         #define CYLFUSE_VERSION_NUMBER {number}\n",
        env!("CARGO_PKG_VERSION"),
    )
}

fn version() -> [u32; 3] {
    [env!("CARGO_PKG_VERSION_MAJOR"), env!("CARGO_PKG_VERSION_MINOR"), env!("CARGO_PKG_VERSION_PATCH")]
        .map(|part| part.parse().unwrap())
}

fn generate() -> String {
    let mut config = cbindgen::Config::from_file(root().join("cbindgen.toml")).unwrap();
    let after = config.after_includes.take().unwrap_or_default();
    config.after_includes = Some(version_macros() + &after);
    let mut builder = cbindgen::Builder::new().with_config(config);
    for source in SOURCES {
        builder = builder.with_src(root().join("src/ffi").join(source).with_extension("rs"));
    }
    let mut header = Vec::new();
    builder.generate().unwrap().write(&mut header);
    parenthesise(&String::from_utf8(header).unwrap())
}

/// The generator writes negative numbers without parentheses.
fn parenthesise(header: &str) -> String {
    let line = |line: &str| match line.split(' ').collect::<Vec<_>>()[..] {
        ["#define", name, value] if value.starts_with('-') => format!("#define {name} ({value})\n"),
        _ => format!("{line}\n"),
    };
    header.lines().map(line).collect()
}

#[test]
fn the_header_is_the_generated_one() {
    let path = root().join("include/cylfuse/cylfuse.h");
    let generated = generate();
    if std::env::var_os("CYLFUSE_REGENERATE_HEADER").is_some() {
        std::fs::write(&path, &generated).unwrap();
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    let differs = committed.lines().zip(generated.lines()).position(|(old, new)| old != new);
    assert!(
        committed == generated,
        "{} is out of date, first in line {:?}; write it with CYLFUSE_REGENERATE_HEADER=1 cargo test --test header",
        path.display(),
        differs.map(|line| line + 1),
    );
}

/// What a program reads in the macros, against the version of the package.
#[test]
fn the_version_macros_are_those_of_the_package() {
    let header = header();
    let value = |name: &str| -> &str {
        let line =
            header.lines().find_map(|line| line.strip_prefix(&format!("#define CYLFUSE_VERSION_{name} ")));
        line.unwrap()
    };
    let [major, minor, patch] = ["MAJOR", "MINOR", "PATCH"].map(|part| value(part).parse::<u32>().unwrap());
    assert_eq!([major, minor, patch], version());
    assert_eq!(value("STRING"), format!("\"{major}.{minor}.{patch}\""));
    assert_eq!(value("NUMBER").parse(), Ok(major * 65536 + minor * 256 + patch));
    assert_eq!(cylfuse::ffi::cylfuse_version_number(), major * 65536 + minor * 256 + patch);
}

/// Compiles a program that includes the header twice, with every warning an error, padding too.
fn compile(compiler: &mut Command, standard: &str, name: &str, text: &str) {
    let path = scratch(&format!("header_{name}")).join(name);
    std::fs::write(&path, format!("#include <cylfuse/cylfuse.h>\n#include <cylfuse/cylfuse.h>\n{text}"))
        .unwrap();
    let include = root().join("include");
    let warnings = ["-Wall", "-Wextra", "-Wpedantic", "-Wpadded", "-Werror", "-fsyntax-only"];
    run(compiler.arg(standard).args(warnings).arg("-I").arg(include).arg(path));
}

#[test]
fn the_header_is_c99() {
    let text = "int main(void) { return cylfuse_abi_version() == CYLFUSE_ABI_VERSION ? 0 : 1; }\n";
    compile(&mut c_compiler(), "-std=c99", "program.c", text);
}

#[test]
fn the_header_is_cpp11_and_throws_nothing() {
    let text = "static_assert(noexcept(cylfuse_abi_version()), \"\");\n\
                static_assert(noexcept(cylfuse_fitter_fit(nullptr, nullptr, nullptr)), \"\");\n\
                extern \"C\" int32_t progress(const cylfuse_progress *, void *) { return 0; }\n\
                int main() { return cylfuse_fitter_set_progress(nullptr, progress, nullptr); }\n";
    compile(&mut cpp_compiler(), "-std=c++11", "program.cpp", text);
}

/// The program at the top of the header.
#[test]
fn the_smallest_program_compiles() {
    let header = header();
    let program: Vec<&str> = header
        .lines()
        .take_while(|line| *line != " */")
        .filter_map(|line| line.strip_prefix(" *     "))
        .collect();
    assert!(program.len() > 20, "the program has gone");
    let text = format!(
        "#include <stdio.h>\nvoid measure(const uint16_t *depth_pixels, const uint8_t *mask_pixels);\n\
         void measure(const uint16_t *depth_pixels, const uint8_t *mask_pixels) {{\n{}\n}}\n",
        program.join("\n")
    );
    compile(&mut c_compiler(), "-std=c99", "smallest.c", &text);
}

/// Every function and constant of the interface is described.
#[test]
fn everything_in_the_header_is_documented() {
    let header = header();
    let lines: Vec<&str> = header.lines().collect();
    let start = lines.iter().position(|line| line.contains("#define CYLFUSE_ABI_VERSION")).unwrap();
    for (index, line) in lines.iter().enumerate().skip(start) {
        let declares =
            ["CYLFUSE_API", "#define CYLFUSE_", "typedef "].iter().any(|start| line.starts_with(start));
        assert!(!declares || lines[index - 1].trim() == "*/", "{line} is without a text");
    }
}
