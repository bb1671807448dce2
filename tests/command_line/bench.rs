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
fn what_the_paper_publishes_stands_beside_what_is_measured() {
    let folder = TempDir::new().unwrap();
    let only = ["compare", "weights", "starts", "pipes"].iter().flat_map(|name| ["--only", name]);
    bench(folder.path(), &["--smallest"].into_iter().chain(only).collect::<Vec<_>>());
    let page = std::fs::read_to_string(folder.path().join("index.html")).unwrap();
    let section = |name: &str| {
        let (_, rest) = page.split_once(&format!("<section id=\"{name}\">")).unwrap();
        rest.split_once("</section>").unwrap().0
    };
    // Figure 5: a row a radius.
    assert_eq!(section("compare").matches("<td>only as a picture</td>").count(), 5);
    // Figure 6.
    assert!(section("weights").contains("<td>0.5 to 0.8 for all; 0.6 is taken</td>"));
    // Figure 8: a row a configuration, four errors each.
    assert_eq!(section("starts").matches("<td>only as a picture</td>").count(), 16);
    assert!(section("starts").contains("high, published by the paper: the performance degrades"));
    assert!(
        section("pipes").contains("three radii: 57 mm (S1-O1), 19 mm (S2-O1) and 25.5 mm (S2-O2 to S2-O4)")
    );
    // What is wide scrolls by itself.
    assert_eq!(page.matches("<table>").count(), page.matches("<div class=\"table\"><table>").count());
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

/// A program of another library.
#[cfg(unix)]
fn program(folder: &TempDir, name: &str, text: &str) -> String {
    use std::os::unix::fs::PermissionsExt;
    let path = folder.path().join(name);
    std::fs::write(&path, format!("#!/bin/sh\n{text}\n")).unwrap();
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
    path.to_str().unwrap().to_owned()
}

#[cfg(unix)]
#[test]
fn other_libraries_come_by_programs() {
    let folder = TempDir::new().unwrap();
    let two = "cat > /dev/null; [ \"$1\" = scene ] || exit 1; echo 9 9 9 0 1 0 0.1; echo 8 8 8 0 1 0 0.1";
    let (pcl, cgal) = (program(&folder, "pcl", two), program(&folder, "cgal", "cat > /dev/null"));
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
}

#[cfg(unix)]
#[test]
fn a_program_that_does_not_work_stops_the_bench_at_its_start() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("out");
    let refused = |path: &str, options: &[&str], expected: &str| {
        let fixed = ["bench", "--smallest", "--out", out.to_str().unwrap()];
        let run = run(fixed.iter().chain(options).chain(&[path]));
        assert_eq!(run.code, 1, "{path}: {}", run.stderr);
        let said = run.stderr.contains("OTHER_LIBRARY") && run.stderr.contains(expected);
        assert!(said, "{path}: no {expected:?} in {}", run.stderr);
        // Nothing but the trial was done.
        assert_eq!(std::fs::read_dir(&out).unwrap().count(), 0, "{path}");
    };
    let plain = folder.path().join("plain");
    std::fs::write(&plain, "").unwrap();
    let fit = ["--only", "compare", "--pcl"];
    let scene = ["--only", "scenes", "--cgal"];
    refused(plain.to_str().unwrap(), &fit, "does not run");
    refused(folder.path().to_str().unwrap(), &fit, "does not run");
    for (text, expected) in [
        ("cat > /dev/null; echo no licence >&2; exit 3", "exit status: 3 with 3000 points: no licence"),
        // It reads nothing.
        ("exit 4", "exit status: 4"),
        ("cat > /dev/null; kill -9 $$", "signal: 9"),
        ("cat > /dev/null; echo nonsense", "not point, direction and radius: nonsense"),
        ("cat > /dev/null; echo 1 2 3 radius 4 5 6 7", "not point, direction and radius"),
        ("cat > /dev/null; echo 0 0 1 0 0 0 0.1", "is no cylinder"),
    ] {
        let path = program(&folder, "broken", text);
        refused(&path, &fit, expected);
        refused(&path, &scene, expected);
    }
    for (text, expected) in [
        ("cat > /dev/null", "0 cylinders in the trial cloud"),
        ("cat > /dev/null; echo 9 9 9 0 1 0 0.1", "a radius of 0.1000 m in the trial cloud"),
    ] {
        refused(&program(&folder, "broken", text), &fit, expected);
    }
    // Those that never end, the second after it has closed its output.
    for text in ["exec sleep 1000000", "exec >&-; exec sleep 1000000"] {
        let path = program(&folder, "endless", text);
        let limited = [&["--time-limit", "1"], &scene[..]].concat();
        refused(&path, &limited, "not done with 3000 points after 1 seconds; --time-limit sets this limit");
    }
}

#[cfg(unix)]
#[test]
fn a_cloud_without_a_cylinder_is_a_failure_of_the_library_and_a_crash_is_none() {
    let folder = TempDir::new().unwrap();
    // Right in the trial.
    let after = |what: &str| {
        let trial = "[ $(wc -c) = 36000 ] && exec echo 0.02 -0.01 0.7 0.36 0.8 0.48 0.04";
        program(&folder, "later", &format!("{trial}; {what}"))
    };
    bench(folder.path(), &["--smallest", "--only", "compare", "--pcl", &after("exit 0")]);
    let csv = &numbers(folder.path())["compare"];
    let rows: Vec<&str> = csv.lines().filter(|line| line.contains(",PCL,")).collect();
    assert!(rows.len() == 8 && rows.iter().all(|row| row.ends_with(",,,,0")), "{csv}");
    let (out, crash) = (folder.path().to_str().unwrap(), after("exit 5"));
    let run = run(["bench", "--smallest", "--only", "compare", "--pcl", &crash, "--out", out]);
    assert!(run.code == 1 && run.stderr.contains("exit status: 5"), "{}", run.stderr);
}
