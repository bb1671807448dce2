//! What `cylfuse detect` writes about a scene.

use crate::support::{run, vector};
use nalgebra::Vector3;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// A table with five cylinders.
fn scene() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/scene")
}

fn detect(options: &[&str], input: &Path, out: &Path) -> Value {
    let mut arguments = vec!["detect", "--json", "--out", out.to_str().unwrap()];
    arguments.extend(options);
    arguments.push(input.to_str().unwrap());
    let run = run(arguments);
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    let object = run.object();
    assert_eq!(object["out"], out.to_str().unwrap());
    object
}

/// The points of a file and the number of the cylinder of each.
fn points_of(path: &Path) -> Vec<(Vector3<f64>, usize)> {
    const END: &[u8] = b"end_header\n";
    let bytes = std::fs::read(path).unwrap();
    let start = bytes.windows(END.len()).position(|window| window == END).unwrap() + END.len();
    let header = std::str::from_utf8(&bytes[..start]).unwrap();
    assert!(
        header.contains("property float z\n") && header.contains("property ushort cylinder\n"),
        "{header}"
    );
    let vertices = bytes[start..].chunks_exact(17);
    assert!(vertices.remainder().is_empty());
    assert!(header.contains(&format!("element vertex {}\n", vertices.len())), "{header}");
    let coordinate = |vertex: &[u8], k: usize| f32::from_le_bytes(vertex[4 * k..][..4].try_into().unwrap());
    vertices
        .map(|vertex| {
            let point = Vector3::from_fn(|k, _| f64::from(coordinate(vertex, k)));
            (point, usize::from(u16::from_le_bytes([vertex[15], vertex[16]])))
        })
        .collect()
}

/// How far a point is from the surface of a cylinder.
fn off(cylinder: &Value, point: &Vector3<f64>) -> f64 {
    let [on_axis, direction] = ["point", "direction"].map(|name| Vector3::from(vector(&cylinder[name])));
    ((point - on_axis).cross(&direction).norm() - cylinder["radius"].as_f64().unwrap()).abs()
}

#[test]
fn files_of_a_scene_say_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("new/results");
    let object = detect(&[], &scene(), &out);
    let cylinders = object["cylinders"].as_array().unwrap();
    assert!(cylinders.len() >= 4, "{}", cylinders.len());
    assert_eq!(object["complete"], true);
    assert!(image::open(out.join("overlay.png")).unwrap().width() >= 640);
    let labels = image::open(out.join("labels.png")).unwrap().into_luma16();
    let labelled = |number: usize| labels.pixels().filter(|pixel| usize::from(pixel.0[0]) == number).count();
    let points = points_of(&out.join("completed.ply"));
    let of = |number: usize| points.iter().filter(move |(_, own)| *own == number);
    for (index, found) in cylinders.iter().enumerate() {
        let pixels = labelled(index + 1);
        assert_eq!(found["pixels"], pixels, "{index}");
        // The rays of a few pixels at its sides pass a cylinder by; those of the others lie on it.
        let count = of(index + 1).count();
        assert!(count <= pixels && count > pixels * 9 / 10, "{index}: {count} of {pixels}");
        let farthest = of(index + 1).map(|(point, _)| off(&found["cylinder"], point)).fold(0.0, f64::max);
        assert!(farthest < 1e-6, "{index}: {farthest}");
    }
    // All that was measured elsewhere is there.
    let depth = image::open(scene().join("depth.png")).unwrap().into_luma16();
    let both = depth.pixels().zip(labels.pixels());
    let rest: Vec<u16> =
        both.filter(|(z, label)| z.0[0] > 0 && label.0[0] == 0).map(|(z, _)| z.0[0]).collect();
    assert!(rest.len() > 100_000);
    assert_eq!(of(0).count(), rest.len());
    for ((point, _), z) in of(0).zip(&rest) {
        assert!((point.z - 1e-4 * f64::from(*z)).abs() < 1e-6, "{point} for {z}");
    }
}

#[test]
fn points_of_a_cloud_stay_and_have_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let (first, second) = (folder.path().join("first"), folder.path().join("second"));
    detect(&["--no-image"], &scene(), &first);
    let cloud = first.join("completed.ply");
    let object = detect(&["--points"], &cloud, &second);
    let cylinders = object["cylinders"].as_array().unwrap();
    assert!(cylinders.len() >= 4, "{}", cylinders.len());
    let (before, after) = (points_of(&cloud), points_of(&second.join("completed.ply")));
    assert_eq!(before.len(), after.len());
    assert!(before.iter().zip(&after).all(|(old, new)| old.0 == new.0));
    for (index, found) in cylinders.iter().enumerate() {
        assert_eq!(found["extent"]["end_source"], "points");
        assert_eq!(
            found["pixels"],
            after.iter().filter(|(_, number)| *number == index + 1).count(),
            "{index}"
        );
    }
    assert!(!second.join("overlay.png").exists() && !second.join("labels.png").exists());
    // The unit of a cloud is not known, so nothing is said to be millimetres.
    let table = run(["detect", "--points", cloud.to_str().unwrap()]).stdout;
    assert!(table.contains(" radius ") && !table.contains("mm"), "{table}");
    let first = |of: &Value| of["cylinders"][0]["cylinder"]["radius"].as_f64().unwrap();
    assert!(table.contains(&format!("{:.7}", first(&object))), "{table}");
}

#[test]
fn no_maximum_is_written_as_zero() {
    let folder = tempfile::tempdir().unwrap();
    let count = |most: &str| {
        let object = detect(&["--no-image", "--max-count", most], &scene(), folder.path());
        object["cylinders"].as_array().unwrap().len()
    };
    assert_eq!(count("1"), 1);
    assert!(count("0") >= 4);
}

#[test]
fn options_of_a_fit_are_those_of_a_scene() {
    let folder = tempfile::tempdir().unwrap();
    let deviations = |options: &[&str]| -> Vec<f64> {
        let object = detect(options, &scene(), folder.path());
        let of = |found: &Value| found["uncertainty"]["radius"].as_f64().unwrap();
        object["cylinders"].as_array().unwrap().iter().map(of).collect()
    };
    let [none, much] = ["depth-shared=0", "depth-shared=0.01"].map(|noise| deviations(&["--noise", noise]));
    assert!(none.len() >= 4 && much.len() >= 4);
    let mean = |all: &[f64]| all.iter().sum::<f64>() / all.len() as f64;
    assert!(mean(&none) < mean(&much), "{none:?} {much:?}");
    for (options, text) in [
        (&["--noise", "edge=1"][..], "'edge' is none of"),
        (&["--noise=depth-shared=-1"][..], "--noise depth-shared is -1"),
        (
            &["--axis=0,1,0", "--axis-max-angle=91"][..],
            "--axis-max-angle is 91; it must lie in [0, 90] degrees",
        ),
    ] {
        let path = scene();
        let refused = run([&["detect"], options, &[path.to_str().unwrap()]].concat());
        assert!(refused.code == 2 && refused.stderr.contains(text), "{}", refused.stderr);
    }
}

#[test]
fn the_table_has_the_warnings_of_the_cylinders() {
    let searched = run(["detect", "--no-image", scene().to_str().unwrap()]);
    let said = searched.stdout.lines().find(|line| line.contains(": cylinder")).unwrap_or_default();
    assert!(said.contains("not fitted: the cylinder is as the search found it"), "{}", searched.stdout);
}

#[test]
fn depth_that_was_moved_is_told_with_its_pixels() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["frame.json", "image.png"] {
        std::fs::copy(scene().join(name), folder.path().join(name)).unwrap();
    }
    let given = image::open(scene().join("depth.png")).unwrap().into_luma16();
    let mut depth = image::ImageBuffer::new(given.width(), given.height());
    image::imageops::replace(&mut depth, &given, 3, 2);
    depth.save(folder.path().join("depth.png")).unwrap();

    let moved = run(["detect", "--json", folder.path().to_str().unwrap()]).object();
    let [columns, rows] = [0, 1].map(|k| moved["depth_moved"][k].as_i64().unwrap());
    assert!((-4..=-2).contains(&columns) && (-4..=0).contains(&rows), "{columns} {rows}");
    let said = run(["detect", folder.path().to_str().unwrap()]).stdout;
    assert!(said.contains(&format!("the depth was moved by {columns} columns and {rows} rows")), "{said}");

    let as_given = run(["detect", "--json", scene().to_str().unwrap()]).object();
    assert_eq!(as_given["depth_moved"], serde_json::json!([0, 0]));
}
