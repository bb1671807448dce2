//! All places that name the version of the release name the same one.
#![allow(clippy::unwrap_used, reason = "a test program")]

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

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

/// A command, with the tools that the scripts of this project install.
fn command(program: &str) -> Command {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let path = std::env::var("PATH").unwrap_or_default();
    let mut command = Command::new(program);
    command.current_dir(root).env("PATH", format!("{}:{path}", root.join("target/tools/bin").display()));
    command
}

/// By CycloneDX 1.5: what each component must have, and the packages that cargo links, with their licences. A few more are
/// listed, which other packages could use but for their features.
#[test]
fn the_bill_of_materials_lists_what_the_library_is_made_of() {
    let present = command("cargo").args(["cyclonedx", "--version"]).output();
    if !present.is_ok_and(|output| output.status.success()) {
        eprintln!("skipped: cargo-cyclonedx is missing; `make sbom` installs it");
        return;
    }
    let run = |program: &str, arguments: &[&str]| {
        let output = command(program).args(arguments).output().unwrap();
        assert!(output.status.success(), "{program}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cylfuse.cdx.json");
    let written = || {
        run("packaging/sbom.sh", &[file.to_str().unwrap()]);
        std::fs::read_to_string(&file).unwrap()
    };
    let text = written();
    assert!(!text.contains(env!("CARGO_MANIFEST_DIR")), "it names the folder of this checkout");
    assert_eq!(text, written());
    let bill: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!((bill["bomFormat"].as_str(), bill["specVersion"].as_str()), (Some("CycloneDX"), Some("1.5")));
    let own = &bill["metadata"]["component"];
    assert_eq!((own["name"].as_str(), own["version"].as_str()), (Some("cylfuse"), Some(VERSION)));
    let mut listed = BTreeSet::new();
    for component in bill["components"].as_array().unwrap() {
        let of = |key: &str| component[key].as_str().unwrap_or_else(|| panic!("no {key}: {component}"));
        assert_eq!(of("type"), "library");
        assert!(of("purl").starts_with("pkg:cargo/") && !of("bom-ref").is_empty());
        assert!(component["licenses"][0].is_object() && component["hashes"][0].is_object(), "{component}");
        listed.insert(format!("{} v{}", of("name"), of("version")));
    }
    let tree = run("cargo", &["tree", "--locked", "-e", "normal", "--prefix", "none", "--format", "{p}"]);
    let words = |line: &str| line.split(' ').take(2).collect::<Vec<_>>().join(" ");
    let linked: BTreeSet<String> = tree.lines().skip(1).map(words).collect();
    let missing: Vec<_> = linked.difference(&listed).collect();
    assert!(missing.is_empty() && linked.len() > 30 && listed.len() < 2 * linked.len(), "{missing:?}");
}
