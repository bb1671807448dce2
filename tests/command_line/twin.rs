//! `cylfuse twin`.

use crate::support::{fit, fitted, run};
use serde_json::Value;
use std::path::Path;
use tempfile::TempDir;

/// Makes frames with options; returns what the program printed.
fn make(out: &Path, options: &[&str]) -> String {
    let mut arguments: Vec<&std::ffi::OsStr> = vec!["twin".as_ref(), "--out".as_ref(), out.as_ref()];
    arguments.extend(options.iter().map(|option| std::ffi::OsStr::new(*option)));
    let run = run(arguments);
    assert_eq!(run.code, 0, "{}", run.stderr);
    run.stdout
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// The files of a folder with their bytes, by name.
fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .map(|path| (path.file_name().unwrap().to_str().unwrap().to_owned(), std::fs::read(path).unwrap()))
        .collect();
    files.sort();
    files
}

#[test]
fn frames_of_single_cylinders_can_be_fitted() {
    let folder = TempDir::new().unwrap();
    let printed = make(folder.path(), &["--kind", "single", "--count", "2", "--seed", "3"]);
    assert!(printed.starts_with("2 frames in "), "{printed}");
    for name in ["single0003", "single0004"] {
        let frame = folder.path().join(name);
        let truth = json(&frame.join("truth.json"));
        let fitted = fitted(&frame, &[]);
        let [found, radius] = [&fitted["cylinder"]["radius"], &truth["radius"]].map(|r| r.as_f64().unwrap());
        assert!((found / radius - 1.0).abs() < 0.03, "{name}: {found} {radius}");
        assert_eq!(truth["true_edges"].as_array().unwrap().len(), 2);
    }
}

#[test]
fn the_same_seed_gives_the_same_files_for_any_number_of_threads() {
    let folders = [TempDir::new().unwrap(), TempDir::new().unwrap()];
    let of_threads = |threads: &str, folder: &TempDir| {
        make(folder.path(), &["--count", "3", "--seed", "7", "--threads", threads]);
        ["table0007", "table0008", "table0009"].map(|name| contents(&folder.path().join(name)))
    };
    let one = of_threads("1", &folders[0]);
    assert_eq!(one[0].len(), 6);
    assert!(one == of_threads("2", &folders[1]));
    assert!(one[0] != one[1]);
}

#[test]
fn image_and_depth_come_as_asked_for() {
    let folder = TempDir::new().unwrap();
    let options =
        ["--kind", "single", "--sensor", "exact", "--width", "320", "--height", "240", "--jpeg", "90"];
    make(folder.path(), &[&options[..], &["--gamma", "2.2", "--distortion=-0.05,0.01,0,0"]].concat());
    let frame = folder.path().join("single0001");
    let fields = json(&frame.join("frame.json"));
    assert_eq!(fields["camera"]["width"], 320);
    assert_eq!(fields["camera"]["distortion"][0], -0.05);
    assert_eq!((&fields["image"], &fields["image_gamma"]), (&"image.jpg".into(), &2.2.into()));
    assert_eq!(fit(&frame, &[]).code, 0);
    // Written again as PNG and as JPEG: no image of another run stays.
    let images = || ["image.jpg", "image.png"].map(|name| frame.join(name).exists());
    assert_eq!(images(), [true, false]);
    make(folder.path(), &options[..8]);
    assert_eq!(images(), [false, true]);
    make(folder.path(), &options);
    assert_eq!(images(), [true, false]);

    make(folder.path(), &["--kind", "single", "--sensor", "time-of-flight", "--unregistered", "--seed", "2"]);
    let frame = folder.path().join("single0002");
    assert_eq!(json(&frame.join("frame.json"))["depth_camera"]["translation"][0], 0.032);
    assert_eq!(fit(&frame, &[]).code, 0);
}

#[test]
fn scenes_have_truth_for_every_object() {
    let folder = TempDir::new().unwrap();
    for kind in ["table", "pipes", "no-cylinders"] {
        make(folder.path(), &["--kind", kind, "--sensor", "exact", "--seed", "5"]);
        let frame = folder.path().join(format!("{kind}0005"));
        let truth = json(&frame.join("truth.json"));
        let cylinders = truth["cylinders"].as_array().unwrap();
        assert_eq!(cylinders.is_empty(), kind == "no-cylinders");
        for cylinder in cylinders.iter().filter(|cylinder| cylinder["countable"] == true) {
            assert!(cylinder["measured_pixels"].as_u64().unwrap() >= 540, "{cylinder}");
        }
        assert!(json(&frame.join("frame.json"))["mask"].is_null());
    }
}

#[test]
fn bad_options_are_said() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().to_str().unwrap();
    for (options, fragments) in [
        (&["--focal-length=-5"][..], &["--focal-length", "-5", "from 128 to 12800"][..]),
        (&["--focal-length", "1e9"], &["--focal-length", "from 128 to 12800"]),
        (&["--electrons", "inf"], &["--electrons", "inf", "from 10 to 10000000"]),
        (&["--electrons", "0"], &["--electrons", "from 10 to 10000000"]),
        (&["--blur", "1000"], &["--blur", "1000", "from 0 to 20"]),
        (&["--width", "16"], &["16 is not in 64..=4096"]),
        (&["--height", "100000"], &["100000 is not in 64..=4096"]),
        (&["--gamma", "0"], &["gamma", "0"]),
        (&["--blur", "nan"], &["blur", "NaN"]),
        (&["--count", "0"], &["--count", "0"]),
        (&["--kind", "cones"], &["cones", "no-cylinders"]),
        (&["--jpeg", "101"], &["101"]),
    ] {
        let run = run([&["twin", "--out", out], options].concat());
        assert_eq!(run.code, 2, "{options:?}");
        assert!(
            fragments.iter().all(|fragment| run.stderr.contains(fragment)),
            "{options:?}: {}",
            run.stderr
        );
    }
    let file = folder.path().join("file");
    std::fs::write(&file, "").unwrap();
    let run = run(["twin", "--out", file.to_str().unwrap(), "--kind", "single", "--sensor", "exact"]);
    assert!(run.code == 1 && run.stderr.contains("FILE_NOT_WRITABLE"), "{}", run.stderr);
}
