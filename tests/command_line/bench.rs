//! `cylfuse bench`.

use crate::support::run;
use std::collections::BTreeMap;
use std::path::Path;
use tempfile::TempDir;

/// Runs experiments; returns what the program printed.
fn bench(out: &Path, options: &[&str]) -> String {
    let mut arguments: Vec<&std::ffi::OsStr> = vec!["bench".as_ref(), "--out".as_ref(), out.as_ref()];
    arguments.extend(options.iter().map(|option| std::ffi::OsStr::new(*option)));
    let run = run(arguments);
    assert_eq!(run.code, 0, "{}", run.stderr);
    run.stdout
}

/// The CSV files of a folder by name.
fn numbers(folder: &Path) -> BTreeMap<String, String> {
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let csv = files.filter(|path| path.extension().is_some_and(|extension| extension == "csv"));
    csv.map(|path| {
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        (name, std::fs::read_to_string(path).unwrap())
    })
    .collect()
}

#[test]
fn the_same_seed_gives_the_same_numbers_for_any_number_of_threads() {
    let folders = [TempDir::new().unwrap(), TempDir::new().unwrap()];
    let of_threads = |threads: &str, folder: &TempDir| {
        let only = ["--only", "weights", "--only", "sensors", "--only", "scenes"];
        bench(folder.path(), &[&["--smallest", "--threads", threads][..], &only].concat());
        numbers(folder.path())
    };
    let one = of_threads("1", &folders[0]);
    assert_eq!(one.keys().collect::<Vec<_>>(), ["scenes", "sensors", "weights"]);
    assert!(one == of_threads("2", &folders[1]));
    // Two frames, eleven weights and the default of each, and the head.
    assert_eq!(one["weights"].lines().count(), 1 + 2 * 12);
    let page = std::fs::read_to_string(folders[0].path().join("index.html")).unwrap();
    assert_eq!(page.matches("<section").count(), 3);
    assert!(page.contains("<dt>seed</dt><dd>14000000</dd>") && !page.contains("NaN"));
    // Nothing is loaded from elsewhere.
    for word in ["<script src", "<link", "href=\"http", "src=\"http"] {
        assert!(!page.contains(word), "{word}");
    }
    assert_eq!(page.matches("<svg").count(), page.matches("</svg>").count());
}

#[test]
fn goals_are_judged_by_the_numbers() {
    let folder = TempDir::new().unwrap();
    let printed = bench(folder.path(), &["--smallest", "--only", "compare"]);
    let csv = &numbers(folder.path())["compare_captures"];
    let mean = |method: &str, column: usize| {
        let rows = csv.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let own: Vec<f64> =
            rows.filter(|row| row[3] == method).map(|row| row[4 + column].parse().unwrap()).collect();
        assert_eq!(own.len(), 4);
        own.iter().sum::<f64>() / own.len() as f64
    };
    for (column, line) in printed.lines().take(4).enumerate() {
        let ratio = mean("paper's objective", column) / mean("cylfuse", column);
        let word = if ratio >= 4.0 { "reached (at least 4)" } else { "missed (at least 4)" };
        assert!(line.contains(word), "{ratio}: {line}");
    }
}

#[test]
fn folders_of_frames_are_scored() {
    let folder = TempDir::new().unwrap();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/frames");
    bench(folder.path(), &["--frames", data.to_str().unwrap()]);
    let csv = &numbers(folder.path())["frames"];
    let own: Vec<Vec<&str>> = csv
        .lines()
        .map(|line| line.split(',').collect())
        .filter(|row: &Vec<&str>| row[1] == "cylfuse")
        .collect();
    assert_eq!(own.len(), 3);
    for row in own {
        // Radius and axis of all three are known to be found well.
        assert!(row[2].parse::<f64>().unwrap() < 1.5 && row[4].parse::<f64>().unwrap() < 1.5, "{row:?}");
    }
    let nothing = run(["bench", "--frames", folder.path().to_str().unwrap()]);
    assert!(nothing.code == 1 && nothing.stderr.contains("NO_FRAMES"), "{}", nothing.stderr);
}

#[test]
fn bad_options_are_said() {
    let unknown = run(["bench", "--only", "nonsense"]);
    assert!(unknown.code == 2 && unknown.stderr.contains("occlusion"), "{}", unknown.stderr);
    let missing = run(["bench", "--pcl", "no/such/program"]);
    assert!(missing.code == 1 && missing.stderr.contains("no/such/program"), "{}", missing.stderr);
}

#[cfg(unix)]
#[test]
fn other_libraries_come_by_programs() {
    use std::os::unix::fs::PermissionsExt;
    let folder = TempDir::new().unwrap();
    let program = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, format!("#!/bin/sh\ncat > /dev/null\n{text}\n")).unwrap();
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let two = "[ \"$1\" = scene ] || exit 1; echo 9 9 9 0 1 0 0.1; echo 8 8 8 0 1 0 0.1";
    let (pcl, cgal) = (program("pcl", two), program("cgal", "exit 0"));
    let options = ["--smallest", "--only", "scenes", "--pcl", &pcl, "--cgal", &cgal];
    bench(folder.path(), &options);
    let csv = &numbers(folder.path())["scenes"];
    let row = |method: &str| {
        let own = csv.lines().find(|line| line.contains(method)).unwrap();
        own.split(',').map(str::to_owned).collect::<Vec<_>>()
    };
    // As many to find for all; the cylinders of the first are wrong, the second has none.
    let own = row("without image");
    assert!(row("PCL")[2] == own[2] && row("CGAL")[2] == own[2] && own[2] != "0", "{csv}");
    assert_eq!([&row("PCL")[3..5], &row("CGAL")[3..5]].concat(), ["0", "2", "0", "0"]);
    let page = std::fs::read_to_string(folder.path().join("index.html")).unwrap();
    assert!(page.contains("<dt>CGAL</dt><dd>compared</dd>"));
    for text in ["exit 1", "echo nonsense"] {
        let broken = program("broken", text);
        let out = folder.path().to_str().unwrap();
        let run = run(["bench", "--smallest", "--only", "scenes", "--cgal", &broken, "--out", out]);
        assert!(run.code == 1 && run.stderr.contains("OTHER_LIBRARY"), "{}", run.stderr);
    }
}
