//! All places that name the version of the release name the same one.
#![allow(clippy::unwrap_used, reason = "a test program")]

use std::path::Path;

const VERSION: &str = env!("CARGO_PKG_VERSION");

fn read(path: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap()
}

/// What follows each occurrence of a text in a file, up to one of the ends.
fn named(path: &str, before: &str, ends: &[char]) -> Vec<String> {
    let text = read(path);
    text.split(before).skip(1).map(|rest| rest.split(ends).next().unwrap().to_string()).collect()
}

#[test]
fn every_manifest_names_the_version_of_the_package() {
    let places = [
        ("Cargo.lock", "name = \"cylfuse\"\nversion = \"", '"'),
        ("CITATION.cff", "\nversion: ", '\n'),
        ("bindings/csharp/Cylfuse.csproj", "<Version>", '<'),
        ("bindings/java/pom.xml", "<artifactId>cylfuse</artifactId>\n  <version>", '<'),
        ("bindings/java/test.sh", "<artifactId>cylfuse</artifactId><version>", '<'),
        ("bindings/node/package.json", "\"version\": \"", '"'),
        ("bindings/node/lib/native.js", "this package needs at least ", ' '),
        ("include/cylfuse/cylfuse.h", "#define CYLFUSE_VERSION_STRING \"", '"'),
        ("tests/abi/0.2.0/include/cylfuse/cylfuse.h", "#define CYLFUSE_VERSION_STRING \"", '"'),
    ];
    for (path, before, end) in places {
        let frozen = path.starts_with("tests/abi/");
        let version = if frozen { "0.2.0" } else { VERSION };
        assert_eq!(named(path, before, &[end]), [version], "{path}");
    }
}

#[test]
fn projects_ask_for_the_versions_that_the_soname_serves() {
    let (major, rest) = VERSION.split_once('.').unwrap();
    let minor = rest.split('.').next().unwrap();
    for (path, before) in [
        ("README.md", "find_package(cylfuse "),
        ("examples-cpp/CMakeLists.txt", "find_package(cylfuse "),
        ("tests/cpp/CMakeLists.txt", "find_package(cylfuse "),
        ("tests/cpp/consumer.cmake", "set(WANTED "),
    ] {
        for wanted in named(path, before, &[' ', ')']) {
            assert!(wanted == "REQUIRED" || wanted == format!("{major}.{minor}"), "{path}: {wanted}");
        }
    }
}

#[test]
fn the_change_log_tells_of_the_version() {
    assert!(read("CHANGELOG.md").contains(&format!("\n## {VERSION}")));
}
