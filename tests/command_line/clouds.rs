//! Bare point clouds.

use crate::support::{Run, run};
use serde_json::Value;
use std::path::Path;

const RADIUS: f64 = 0.05;
/// Half a spacing beyond the first and the last of twenty rows.
const LENGTH: f64 = 0.2;

/// Points all around an oblique cylinder, exact to f64.
fn points() -> Vec<[f64; 3]> {
    let mut points = Vec::new();
    for row in 0..20 {
        for step in 0..30 {
            let (sin, cos) = (f64::from(step) * std::f64::consts::TAU / 30.0).sin_cos();
            let (x, y, z) = (RADIUS * cos, RADIUS * sin, 0.01 * f64::from(row) - 0.1);
            // Axis (0.6, 0, 0.8) through (0.2, -0.1, 0.9).
            points.push([0.2 + 0.8 * x + 0.6 * z, -0.1 + y, 0.9 - 0.6 * x + 0.8 * z]);
        }
    }
    points
}

fn fit(path: &Path) -> Run {
    run(["fit", "--json", "--points", path.to_str().unwrap()])
}

/// Fits a cloud file and checks the cylinder to a relative tolerance.
fn check(name: &str, bytes: impl AsRef<[u8]>, tolerance: f64) -> Value {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    let run = fit(&path);
    let object = run.object();
    assert_eq!(run.code, 0, "{name}: {object}");
    let radius = object["cylinder"]["radius"].as_f64().unwrap();
    assert!((radius / RADIUS - 1.0).abs() < tolerance, "{name}: {radius}");
    assert_eq!(object["fitted"], "cloud");
    let extent = &object["extent"];
    assert!((extent["length"].as_f64().unwrap() - LENGTH).abs() < 1e-3, "{name}: {extent}");
    assert_eq!((&extent["start_source"], &extent["end_state"]), (&"points".into(), &"unknown".into()));
    assert!(object["completion"].is_null());
    assert!(object["result"]["near_wall_fraction"].is_null());
    object
}

fn lines(points: &[[f64; 3]], separator: &str) -> String {
    points.iter().map(|[x, y, z]| format!("{x:?}{separator}{y:?}{separator}{z:?}\n")).collect()
}

fn bytes<const N: usize>(points: &[[f64; 3]], convert: fn(f64) -> [u8; N]) -> Vec<u8> {
    points.iter().flatten().flat_map(|&x| convert(x)).collect()
}

#[test]
fn text_files() {
    let points = points();
    check("cloud.xyz", text_of(&points), 1e-9);
    check("cloud.csv", format!("# x,y,z,i\n{}", lines(&points, ",").replace('\n', ",255\n")), 1e-9);
    let object = check("CLOUD.XYZ", format!("nan 0 0\n{}0 inf 0\n", text_of(&points)), 1e-9);
    assert_eq!(object["result"]["dropped"]["not_finite"], 2);
    assert_eq!(object["result"]["flags"], serde_json::json!(["points_not_finite"]));
}

fn text_of(points: &[[f64; 3]]) -> String {
    lines(points, " ")
}

#[test]
fn ply() {
    let points = points();
    let header = |format: &str, number: &str| {
        let count = points.len();
        format!(
            "ply\nformat {format} 1.0\nelement vertex {count}\nproperty {number} x\nproperty {number} y\n\
             property {number} z\nend_header\n"
        )
        .into_bytes()
    };
    let file = |format, number, body: Vec<u8>| [header(format, number), body].concat();
    check("a.ply", file("ascii", "float", text_of(&points).into_bytes()), 1e-9);
    check("a.ply", file("ascii", "double", text_of(&points).into_bytes()), 1e-9);
    check("a.ply", file("binary_little_endian", "float", bytes(&points, |x| (x as f32).to_le_bytes())), 1e-6);
    check("a.ply", file("binary_little_endian", "double", bytes(&points, f64::to_le_bytes)), 1e-9);
    check("a.ply", file("binary_big_endian", "double", bytes(&points, f64::to_be_bytes)), 1e-9);
}

#[test]
fn pcd() {
    let points = points();
    let file = |data: &str, size: usize, body: Vec<u8>| {
        let count = points.len();
        let header = format!(
            "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE {size} {size} {size}\nTYPE F F F\nCOUNT 1 1 1\n\
             WIDTH {count}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {count}\nDATA {data}\n"
        );
        [header.into_bytes(), body].concat()
    };
    check("a.pcd", file("ascii", 4, text_of(&points).into_bytes()), 1e-9);
    check("a.pcd", file("binary", 4, bytes(&points, |x| (x as f32).to_le_bytes())), 1e-6);
    check("a.pcd", file("binary", 8, bytes(&points, f64::to_le_bytes)), 1e-9);
    // Literal runs only: the other half of the compression has its own test.
    let columns: Vec<u8> = (0..3).flat_map(|k| points.iter().flat_map(move |p| p[k].to_le_bytes())).collect();
    let runs: Vec<u8> = columns.chunks(32).flat_map(|run| [&[run.len() as u8 - 1], run].concat()).collect();
    let sizes = [runs.len() as u32, columns.len() as u32].map(u32::to_le_bytes).concat();
    check("a.pcd", file("binary_compressed", 8, [sizes, runs].concat()), 1e-9);
}

#[test]
fn several_clouds_and_a_table_without_units() {
    let folder = tempfile::tempdir().unwrap();
    let (good, bad) = (folder.path().join("good.xyz"), folder.path().join("bad.xyz"));
    std::fs::write(&good, text_of(&points())).unwrap();
    std::fs::write(&bad, "1 2\n").unwrap();
    let [good, bad] = [&good, &bad].map(|path| path.to_str().unwrap());
    let table = run(["fit", "--points", good, bad]);
    assert_eq!(table.code, 1);
    // The name of the folder is random, and may hold the unit.
    let text = table.stdout.replace(folder.path().to_str().unwrap(), "");
    assert!(text.contains("0.0500000") && text.contains(" 0.200000 ± ") && !text.contains("mm"), "{text}");
    assert!(table.stderr.contains("line 1 has 2 numbers"), "{}", table.stderr);
    let out = folder.path().join("out");
    run(["fit", "--points", good, "--out", out.to_str().unwrap()]);
    assert!(out.join("result.json").is_file() && !out.join("overlay.png").exists());
}

#[test]
fn bad_clouds_are_refused_with_a_reason() {
    let folder = tempfile::tempdir().unwrap();
    for (name, content, status, reason) in [
        ("a.obj", "v 1 2 3\n", "BAD_CLOUD", ".ply, .pcd or .xyz"),
        ("a", "1 2 3\n", "BAD_CLOUD", ".ply, .pcd or .xyz"),
        ("a.ply", "", "BAD_CLOUD", "is an empty file"),
        ("a.ply", "1 2 3\n", "BAD_CLOUD", "PLY header"),
        ("a.pcd", "", "BAD_CLOUD", "is an empty file"),
        ("b.pcd", "\u{1}\u{2}\n", "BAD_CLOUD", "PCD"),
        ("a.xyz", "1 2 three\n", "BAD_CLOUD", "'three' is not a number"),
        ("a.xyz", "", "BAD_CLOUD", "is an empty file"),
        ("b.xyz", "\n", "TOO_FEW_POINTS", "0 of 0 points"),
        ("c.xyz", "0 0 0\n1 0 0\n2 0 0\n3 0 0\n4 0 0\n5 0 0\n", "COLLINEAR_POINTS", "one line"),
        ("d.xyz", "0 0 0\n1 0 0\n2 0 0\n0 1 0\n1 1 0\n2 2 0\n", "PLANAR_POINTS", "plane"),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, content).unwrap();
        let run = fit(&path);
        let object = run.object();
        assert_eq!((run.code, &object["error"]["status"]), (1, &status.into()), "{name}: {object}");
        assert!(object["error"]["message"].as_str().unwrap().contains(reason), "{object}");
    }
    let missing = fit(&folder.path().join("missing.ply")).object();
    assert_eq!(missing["error"]["status"], "FILE_NOT_READABLE");
}
