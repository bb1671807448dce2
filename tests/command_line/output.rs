//! What is printed and written.

use crate::support::{Copy, data, fails, fit, fitted, run, vector, without_seconds};
use serde_json::Value;
use std::ffi::OsStr;
use std::path::Path;
use std::process::{Command, Stdio};
use tempfile::TempDir;

fn keys(value: &Value) -> Vec<&str> {
    value.as_object().unwrap().keys().map(String::as_str).collect()
}

#[test]
fn json_has_the_documented_shape() {
    let run = run(["fit", "--json"].map(Into::into).into_iter().chain([data("").into_os_string()]));
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.is_empty(), "no progress bar where stderr is no terminal: {}", run.stderr);
    let objects = run.objects();
    let names: Vec<&str> =
        objects.iter().map(|o| Path::new(o["frame"].as_str().unwrap()).parent().unwrap()).map(last).collect();
    assert_eq!(names, ["r40_a20_f0", "w004", "w022"]);
    for object in &objects {
        check_shape(object);
    }
    // Both ends of this pipe are beyond the border of the image.
    assert_eq!(objects[2]["extent"]["start_state"], "cut");
    assert_eq!(objects[2]["extent"]["end_state"], "cut");
}

fn last(path: &Path) -> &str {
    path.file_name().unwrap().to_str().unwrap()
}

fn check_shape(object: &Value) {
    let mut top = keys(object);
    top.sort_unstable();
    let expected = [
        "arc_samples",
        "completion",
        "cylinder",
        "extent",
        "fitted",
        "frame",
        "limbs",
        "notes",
        "out",
        "result",
        "seconds",
        "uncertainty",
        "views",
    ];
    assert_eq!(top, expected);
    assert!(object["views"].is_null(), "the only view is the whole");
    let direction = vector(&object["cylinder"]["direction"]);
    assert!((direction.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-14);
    vector(&object["cylinder"]["point"]);
    assert!(object["cylinder"]["radius"].as_f64().unwrap() > 0.0);

    let extent = &object["extent"];
    let length = extent["length"].as_f64().unwrap();
    let (start, end, center) = (vector(&extent["start"]), vector(&extent["end"]), vector(&extent["center"]));
    for k in 0..3 {
        assert!((start[k] + length * direction[k] - end[k]).abs() < 1e-14);
        assert!((0.5 * (start[k] + end[k]) - center[k]).abs() < 1e-14);
    }
    for state in ["start_state", "end_state"] {
        assert!(["seen", "cut", "hidden", "unknown"].contains(&extent[state].as_str().unwrap()));
    }

    for source in ["start_source", "end_source"] {
        assert!(["mask", "image", "border"].contains(&extent[source].as_str().unwrap()), "{extent}");
    }
    assert_eq!((&extent["start_view"], &extent["end_view"]), (&0.into(), &0.into()));
    assert!(object["arc_samples"].as_array().unwrap().iter().all(Value::is_u64));

    let uncertainty = &object["uncertainty"];
    let covariance = &uncertainty["covariance"];
    let radius = uncertainty["radius"].as_f64().unwrap();
    assert!((covariance[6][6].as_f64().unwrap().sqrt() / radius - 1.0).abs() < 1e-12);
    assert_eq!(covariance[2][5], covariance[5][2]);
    assert!(
        uncertainty["direction"].as_f64().unwrap() > 0.0 && uncertainty["position"].as_f64().unwrap() > 0.0
    );
    assert!(extent["length_deviation"].as_f64().unwrap() > extent["start_deviation"].as_f64().unwrap());
    assert!(extent["center_covariance"][2][2].as_f64().unwrap() > 0.0);

    for limb in object["limbs"].as_array().unwrap() {
        assert_ne!(limb["line"].is_null(), limb["not_visible"].is_null());
        assert!(limb["samples_used"].is_u64() && limb["samples_refused"].is_u64());
        if let Some(sigma) = limb["line"]["sigma"].as_f64() {
            assert!(
                sigma > 0.0 && limb["line"]["ends"][1][1].is_f64() && limb["blur"].as_f64().unwrap() > 0.0
            );
        }
    }
    let result = &object["result"];
    let radii = &result["radii"];
    let number = |name: &str| radii[name].as_f64().unwrap();
    let deviation = number("from_points_deviation").hypot(number("from_limbs_deviation"));
    let z_score = (number("from_points") - number("from_limbs")) / deviation;
    assert!((z_score - number("z_score")).abs() < 1e-9);
    for name in [
        "cost",
        "energy_points",
        "energy_edges",
        "initial_cost",
        "point_rms",
        "point_scale",
        "independent_points",
        "edge_rms_pixels",
        "near_wall_fraction",
        "condition",
        "lambda",
        "gradient_norm",
        "step_norm",
    ] {
        assert!(result[name].is_f64(), "{name}: {result}");
    }
    for name in
        ["iterations", "rejected_steps", "points_used", "points_given", "segments_used", "segments_given"]
    {
        assert!(result[name].is_u64(), "{name}: {result}");
    }
    for name in ["method", "objective", "termination", "start_kind"] {
        assert!(result[name].is_string(), "{name}: {result}");
    }
    assert!(result["edge_weight"].is_null(), "the robust objective has no w_L");
    assert!(result["flags"].as_array().unwrap().iter().all(Value::is_string));
    vector(&result["start"]["point"]);
    let dropped = result["dropped"].as_object().unwrap();
    assert_eq!(dropped.len(), 7);
    let total: u64 = dropped.values().map(|count| count.as_u64().unwrap()).sum();
    assert_eq!(total + result["points_used"].as_u64().unwrap(), result["points_given"].as_u64().unwrap());

    assert_eq!(object["fitted"], "mask");
    assert!(object["completion"]["points"].as_u64().unwrap() > 0);
    assert!(object["out"].is_null());
    for name in ["read", "start", "solve", "fit", "total"] {
        assert!(object["seconds"][name].as_f64().unwrap() >= 0.0);
    }
}

#[test]
fn the_table_is_short_and_says_what_counts() {
    let run = run([data("w004")].map(|path| ["fit".into(), path.into_os_string()]).into_iter().flatten());
    assert_eq!(run.code, 0);
    for word in ["radius mm", "length mm", "w004", "5269", " ± "] {
        assert!(run.stdout.contains(word), "no {word} in:\n{}", run.stdout);
    }
    assert!(!run.stdout.contains("frame.json") && run.stdout.lines().count() < 8, "{}", run.stdout);
}

#[test]
fn files_of_one_frame_go_to_the_folder_itself() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("new/results");
    let object = fitted(&data("w004/frame.json"), &["--out", out.to_str().unwrap()]);
    assert_eq!(object["out"], out.to_str().unwrap());
    let saved: Value = serde_json::from_slice(&std::fs::read(out.join("result.json")).unwrap()).unwrap();
    assert_eq!(saved, object);

    let overlay = image::open(out.join("overlay.png")).unwrap().to_rgb8();
    assert!(overlay.width() == 1280 && overlay.height() > 960);
    let colourful = |p: &&image::Rgb<u8>| p.0.iter().max().unwrap() - p.0.iter().min().unwrap() > 40;
    assert!(overlay.pixels().filter(colourful).count() > 5000, "something is drawn over the grey image");

    let completed = object["completion"]["points"].as_u64().unwrap();
    for (name, header_end) in [("completed.ply", "end_header\n"), ("completed.pcd", "DATA binary\n")] {
        let bytes = std::fs::read(out.join(name)).unwrap();
        let header =
            bytes.windows(header_end.len()).position(|window| window == header_end.as_bytes()).unwrap();
        assert_eq!(bytes.len() - header - header_end.len(), 12 * completed as usize, "{name}");
        // The points lie on the cylinder that they were completed from.
        let cloud = run(["fit", "--json", "--points", out.join(name).to_str().unwrap()]).object();
        assert_eq!(cloud["result"]["points_used"], completed, "{name}");
        let [expected, radius] = [&object, &cloud].map(|o| o["cylinder"]["radius"].as_f64().unwrap());
        assert!((radius / expected - 1.0).abs() < 1e-4, "{name}: {radius} for {expected}");
    }
}

#[test]
fn several_frames_keep_their_order_whatever_fails() {
    let folder = tempfile::tempdir().unwrap();
    let broken = folder.path().join("w004.json");
    std::fs::write(&broken, "{}").unwrap();
    let missing = folder.path().join("missing/frame.json");
    let out = folder.path().join("out");
    let paths = [data("w022"), broken, data("w004"), missing, data("r40_a20_f0/frame.json"), data("w004")];
    let mut arguments = vec!["fit".into(), "--json".into(), "--out".into(), out.clone().into_os_string()];
    arguments.extend(paths.iter().map(|path| path.clone().into_os_string()));
    let run = run(arguments);
    assert_eq!(run.code, 1);
    let objects = run.objects();
    assert_eq!(objects.len(), paths.len());
    let statuses: Vec<_> = objects.iter().map(|o| o["error"]["status"].as_str()).collect();
    assert_eq!(statuses, [None, Some("BAD_FRAME"), None, Some("FILE_NOT_READABLE"), None, None]);
    for (object, path) in objects.iter().zip(&paths) {
        assert!(Path::new(object["frame"].as_str().unwrap()).starts_with(path), "{}", object["frame"]);
    }
    for (index, name) in ["w022", "w004", "w004-2", "missing", "r40_a20_f0", "w004-3"].iter().enumerate() {
        let saved = std::fs::read(out.join(name).join("result.json")).unwrap();
        assert_eq!(serde_json::from_slice::<Value>(&saved).unwrap(), objects[index]);
        assert_eq!(out.join(name).join("overlay.png").exists(), statuses[index].is_none());
    }
}

#[test]
fn the_table_goes_on_when_a_frame_fails() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("bad.json"), "{").unwrap();
    let bad = folder.path().join("bad.json");
    let run = run(["fit", bad.to_str().unwrap(), data("w004").to_str().unwrap()]);
    assert_eq!(run.code, 1);
    assert!(run.stdout.contains("failed") && run.stdout.contains("5269"), "{}", run.stdout);
    assert!(run.stderr.contains("bad.json") && run.stderr.contains("BAD_FRAME"), "{}", run.stderr);
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let all = |threads: &str| {
        let run = fit(&data(""), &["--threads", threads]);
        run.objects().into_iter().map(without_seconds).collect::<Vec<_>>()
    };
    assert_eq!(all("1"), all("3"));
}

#[test]
fn without_an_image_it_is_not_opened() {
    let copy = Copy::new();
    std::fs::remove_file(copy.path("image.png")).unwrap();
    let frame = copy.write();
    fails(&frame, &[], "FILE_NOT_READABLE", &["image.png"]);
    let out = copy.path("out");
    let object = fitted(&frame, &["--no-image", "--out", out.to_str().unwrap()]);
    assert_eq!(object["result"]["segments_used"], 2, "the segments stay");
    assert_eq!(object["fitted"], "mask", "the mask stays");
    assert!(image::open(out.join("overlay.png")).is_ok(), "the depth is the ground then");
}

#[test]
fn without_edges_the_segments_do_not_count() {
    let frame = data("w004");
    let object = fitted(&frame, &["--no-edges"]);
    let result = &object["result"];
    assert_eq!((&result["segments_given"], &result["segments_used"]), (&0.into(), &0.into()));
    assert!(result["energy_edges"].is_null() && result["edge_rms_pixels"].is_null());
    let points = fitted(&frame, &["--no-edges", "--objective", "paper", "--edge-weight", "0"]);
    assert_eq!(points["result"]["edge_weight"], 0.0);
    fails(
        &frame,
        &["--no-edges", "--objective", "paper"],
        "UNSUPPORTED",
        &["exactly 2 edge segments, not 0"],
    );
}

#[test]
fn without_a_mask_all_pixels_are_fitted_and_that_is_said() {
    let mut copy = Copy::new();
    // Nothing but the cylinder has a depth, so that a fit of all pixels succeeds.
    let mask = image::open(copy.path("mask.png")).unwrap().to_luma8();
    let mut depth = image::open(copy.path("depth.png")).unwrap().to_luma16();
    for (pixel, mask) in depth.pixels_mut().zip(mask.pixels()) {
        pixel.0[0] *= u16::from(mask.0[0] != 0);
    }
    depth.save(copy.path("depth.png")).unwrap();
    // The paper's objective has no other use for a mask than to choose points.
    let masked = fitted(&copy.write(), &["--objective", "paper"]);
    copy.json.as_object_mut().unwrap().remove("mask");
    let out = copy.path("out");
    let object = fitted(&copy.write(), &["--objective", "paper", "--out", out.to_str().unwrap()]);
    assert_eq!(object["cylinder"], masked["cylinder"]);
    assert_eq!(object["extent"]["start_source"], "points");
    let length = object["extent"]["length"].as_f64().unwrap();
    assert!((length / 0.107 - 1.0).abs() < 0.05, "{length}");
    assert!(object["completion"].is_null());
    assert_eq!(object["fitted"], "all_measured_pixels");
    assert!(object["notes"][0].as_str().unwrap().starts_with("no mask: 4211 measured pixels were fitted"));
    assert!(out.join("overlay.png").exists() && !out.join("completed.ply").exists());
    copy.json["mask"] = Value::Null;
    let table = run(["fit", copy.write().to_str().unwrap()]);
    assert!(table.stdout.contains("no mask: 4211 measured pixels were fitted"), "{}", table.stdout);
}

#[test]
fn the_demo_leaves_its_files_where_it_says() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("here");
    let demo = run(["demo", "--out", out.to_str().unwrap()]);
    assert_eq!(demo.code, 0, "{}", demo.stderr);
    assert!(demo.stdout.contains(out.to_str().unwrap()) && demo.stdout.contains("radius mm"));
    for name in ["result.json", "overlay.png", "completed.ply", "completed.pcd"] {
        assert!(demo.stdout.contains(name) && out.join(name).is_file(), "{name}");
    }
    let scene = ["frame.json", "image.png", "depth.png", "overlay.png", "labels.png", "completed.ply"];
    assert!(
        demo.stdout.contains("scene/") && scene.iter().all(|name| out.join("scene").join(name).is_file())
    );
    let again = fitted(&out.join("frame"), &[]);
    assert_eq!(again["cylinder"], fitted(&data("r40_a20_f0"), &[])["cylinder"]);
    let default = Command::new(env!("CARGO_BIN_EXE_cylfuse")).arg("demo").current_dir(folder.path()).output();
    assert!(default.unwrap().status.success() && folder.path().join("cylfuse-demo/overlay.png").is_file());
}

#[test]
fn a_reader_that_leaves_early_is_no_failure() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_cylfuse"))
        .args(["fit", "--json", data("").to_str().unwrap()])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
}

#[test]
fn a_folder_that_cannot_be_made_is_a_failure_of_its_own() {
    let out = TempDir::new().unwrap();
    std::fs::write(out.path().join("w004"), "").unwrap();
    let frames = [data("w004"), data("w022")];
    let run = run(["fit".as_ref(), "--json".as_ref(), "--out".as_ref(), out.path().as_os_str()]
        .into_iter()
        .chain(frames.iter().map(|frame| frame.as_os_str())));
    let objects = run.objects();
    assert_eq!(
        (run.code, &objects[0]["error"]["status"]),
        (1, &"FILE_NOT_WRITABLE".into()),
        "{}",
        run.stdout
    );
    assert!(objects[1]["cylinder"].is_object() && out.path().join("w022/overlay.png").is_file());
}

/// Every frame was fitted before it came out that nothing could be written.
#[test]
fn a_folder_that_cannot_be_made_is_told_before_the_work() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "").unwrap();
    let out = file.join("out");
    let demo = run(["demo", "--out", out.to_str().unwrap()]);
    assert!(demo.code == 1 && demo.stderr.contains("FILE_NOT_WRITABLE"), "{}", demo.stderr);
    for command in ["fit", "detect"] {
        let arguments: [&OsStr; 4] = [command.as_ref(), "no frame".as_ref(), "--out".as_ref(), out.as_ref()];
        let run = run(arguments);
        assert_eq!((run.code, run.stdout.as_str()), (1, ""), "{}", run.stderr);
        assert!(run.stderr.contains("file/out") && !run.stderr.contains("no frame"), "{}", run.stderr);
    }
}
