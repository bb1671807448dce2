//! Each layer imports only those before it.

#![allow(clippy::unwrap_used, reason = "a test program")]

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The layers, lowest first. Modules of one layer do not import each other.
const LAYERS: [&[&str]; 17] = [
    &["memory"],
    &["constant", "error", "statistics", "workers"],
    &["noise"],
    &["geometry"],
    &["camera"],
    &["observations"],
    &["residuals", "parts", "twin"],
    &["solver"],
    &["start", "limb_location", "end_location"],
    &["detection"],
    &["fitter"],
    &["completion"],
    &["extent"],
    &["scene"],
    &["plan"],
    &["ffi", "opencv"],
    &["bin"],
];

fn layer(module: &str) -> usize {
    let found = LAYERS.iter().position(|modules| modules.contains(&module));
    found.unwrap_or_else(|| panic!("the module {module} has no layer: add it to LAYERS in tests/layering.rs"))
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// The modules named right after `crate::`, or inside the braces that follow it. Programs say `cylfuse::`, and mean
/// themselves by `crate::`.
fn imports(text: &str, program: bool) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for prefix in if program { &["cylfuse::"][..] } else { &["crate::", "cylfuse::"] } {
        for (start, _) in text.match_indices(prefix) {
            if text[..start].ends_with(|c: char| c.is_alphanumeric() || c == '_') {
                continue;
            }
            found.extend(first_segments(&text[start + prefix.len()..]));
        }
    }
    found
}

fn first_segments(path: &str) -> Vec<String> {
    let name = |text: &str| text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let Some(group) = path.strip_prefix('{') else { return vec![name(path)] };
    let mut names = Vec::new();
    let (mut depth, mut item) = (0, String::new());
    for c in group.chars() {
        match c {
            '{' => depth += 1,
            '}' if depth > 0 => depth -= 1,
            ',' | '}' if depth == 0 => {
                names.push(name(item.trim()));
                item.clear();
                if c == '}' {
                    break;
                }
            }
            c => item.push(c),
        }
    }
    names.retain(|name| !name.is_empty());
    names
}

#[test]
fn no_layer_imports_one_above_it() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&source, &mut files);
    let mut upward = Vec::new();
    for file in files {
        let relative = file.strip_prefix(&source).unwrap();
        let module = relative.iter().next().unwrap().to_str().unwrap().trim_end_matches(".rs");
        if module == "lib" {
            continue;
        }
        for import in imports(&std::fs::read_to_string(&file).unwrap(), module == "bin") {
            // A constant or macro of the crate root is no module.
            let is_module = import.starts_with(|c: char| c.is_lowercase());
            if is_module && import != module && layer(&import) >= layer(module) {
                upward.push(format!("{} imports {import}", relative.display()));
            }
        }
    }
    assert!(upward.is_empty(), "upward imports:\n{}", upward.join("\n"));
}

/// Standard output and error belong to the program around the library.
#[test]
fn the_library_prints_nothing() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&source, &mut files);
    files.retain(|file| !file.starts_with(source.join("bin")));
    for file in files {
        let text = std::fs::read_to_string(&file).unwrap();
        for call in ["print!", "println!", "dbg!", "stdout()", "stderr()"] {
            let here =
                text.lines().position(|line| line.contains(call) && !line.trim_start().starts_with("//"));
            assert!(here.is_none(), "{} prints with {call} in line {}", file.display(), here.unwrap() + 1);
        }
    }
}

#[test]
fn imports_are_found_in_every_form() {
    let text = "use crate::camera::Camera;\nuse crate::{error::{Error, Result}, fitter};\nfn f(x: &crate::geometry::Line) {}\nuse other_crate::start;";
    let expected = ["camera", "error", "fitter", "geometry"].map(String::from);
    assert_eq!(imports(text, false), expected.into());
}
