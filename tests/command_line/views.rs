//! Several views, and depth cameras of their own.

use crate::scene::{self, Seen, after, beside, camera, depth_camera, looking_from};
use crate::support::{Copy, data, fails, fitted, run, vector};
use cylfuse::camera::Camera;
use cylfuse::geometry::RigidMotion;
use image::{GrayImage, ImageBuffer, Luma};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// Metres per unit of depth.
const DEPTH_SCALE: f64 = 2e-5;

/// Where the cameras stand.
const EYES: [[f64; 3]; 2] = [[0.0, 0.0, 0.0], [0.3, -0.5, 0.2]];

/// A folder with two views, each with a depth camera of its own.
struct Views {
    folder: TempDir,
    json: Value,
}

impl Views {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let view = |(index, eye): (usize, &[f64; 3])| view(folder.path(), index, &looking_from(*eye));
        let views: Vec<Value> = EYES.iter().enumerate().map(view).collect();
        Self { folder, json: json!({ "views": views }) }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a frame file.
    fn write(&self, json: &Value) -> PathBuf {
        let path = self.path("frame.json");
        std::fs::write(&path, json.to_string()).unwrap();
        path
    }

    /// Checks the failure of the views with one value changed.
    fn fails_with(&self, pointer: &str, value: Value, status: &str, fragments: &[&str]) {
        let mut json = self.json.clone();
        *json.pointer_mut(pointer).unwrap_or_else(|| panic!("no {pointer}")) = value;
        fails(&self.write(&json), &[], status, fragments);
    }
}

fn intrinsics(camera: &Camera) -> Value {
    let i = camera.intrinsics();
    json!({ "width": i.width, "height": i.height, "fx": i.fx, "fy": i.fy, "cx": i.cx, "cy": i.cy })
}

fn motion(motion: &RigidMotion) -> Value {
    // nalgebra keeps columns.
    json!({ "rotation": motion.rotation().transpose().as_slice(), "translation": motion.translation().as_slice() })
}

/// Writes the images of a view; gives what the frame file says of it.
fn view(folder: &Path, index: usize, pose: &RigidMotion) -> Value {
    let (color, depth) = (Seen::new(&camera(), pose), Seen::new(&depth_camera(), &after(pose, &beside())));
    let name = |kind: &str| format!("{kind}{index}.png");
    let save = |kind: &str, pixels: Vec<u8>| {
        GrayImage::from_raw(160, 120, pixels).unwrap().save(folder.join(name(kind))).unwrap();
    };
    save("image", color.image());
    save("mask", color.mask());
    let units = depth.depth().iter().map(|z| (f64::from(*z) / DEPTH_SCALE).round() as u16).collect();
    let depth_image = ImageBuffer::<Luma<u16>, Vec<u16>>::from_raw(144, 108, units).unwrap();
    depth_image.save(folder.join(name("depth"))).unwrap();
    let edge = |e: &cylfuse::observations::EdgeSegment| json!(e.endpoints.map(|end| [end.x, end.y]));
    let mut own = intrinsics(&depth_camera());
    for (key, value) in motion(&beside()).as_object().unwrap() {
        own[key] = value.clone();
    }
    json!({
        "camera": intrinsics(&camera()),
        "image": name("image"),
        "mask": name("mask"),
        "depth": name("depth"),
        "depth_scale": DEPTH_SCALE,
        "depth_camera": own,
        "edges": color.edges().iter().map(edge).collect::<Vec<_>>(),
        "pose": motion(pose),
    })
}

/// Checks a cylinder to a part of its radius.
fn assert_near(object: &Value, tolerance: f64) {
    let truth = scene::cylinder();
    let cylinder = cylfuse::geometry::Cylinder::new(
        vector(&object["cylinder"]["point"]).into(),
        vector(&object["cylinder"]["direction"]).into(),
        object["cylinder"]["radius"].as_f64().unwrap(),
    );
    let cylinder = cylinder.unwrap();
    let difference = truth.compare(&cylinder);
    let aside = cylinder.axis.distance(&truth.axis.point) / truth.radius;
    let largest = difference.angle.max(aside).max(difference.radius_relative.abs());
    assert!(largest < tolerance, "{largest}: {}", object["cylinder"]);
}

#[test]
fn two_views_with_depth_cameras_are_fitted_together() {
    let views = Views::new();
    let out = views.path("out");
    let object = fitted(&views.write(&views.json), &["--out", out.to_str().unwrap()]);
    assert_near(&object, 0.003);
    let result = &object["result"];
    assert_eq!((&result["segments_given"], &result["limbs_located"]), (&4.into(), &4.into()));
    assert!(result["point_scale"].as_f64().unwrap() < 1e-4);
    assert!(result["independent_points"].as_f64().unwrap() > 8.0);

    let extent = &object["extent"];
    let length = extent["length"].as_f64().unwrap();
    assert!((length / (2.0 * scene::HALF_LENGTH) - 1.0).abs() < 0.01, "{length}");
    for end in ["start", "end"] {
        assert!([0, 1].contains(&extent[format!("{end}_view")].as_u64().unwrap()), "{extent}");
        let source = &extent[format!("{end}_source")];
        assert!(["mask", "image"].contains(&source.as_str().unwrap()), "{extent}");
    }

    // What is of one view stands there; the whole has the sums.
    assert!(object["limbs"].is_null() && object["arc_samples"].is_null());
    assert_eq!(object["fitted"], "mask");
    let of_views = object["views"].as_array().unwrap();
    assert_eq!(of_views.len(), 2);
    let mut points = 0;
    for view in of_views {
        assert_eq!((&view["fitted"], view["limbs"].as_array().unwrap().len()), (&"mask".into(), 2));
        assert!(view["limbs"][0]["line"]["sigma"].is_f64(), "{view}");
        assert_eq!(view["arc_samples"].as_array().unwrap().len(), 2);
        points += view["completion"]["points"].as_u64().unwrap();
    }
    assert_eq!(object["completion"]["points"], points);

    for name in ["overlay.png", "overlay-0.png", "overlay-1.png"] {
        let overlay = image::open(out.join(name)).unwrap();
        assert!(overlay.width() == 1280 && overlay.height() > 960, "{name}");
    }
    assert!(!out.join("overlay-2.png").exists());
    let bytes = |name: &str| std::fs::read(out.join(name)).unwrap();
    assert_eq!(bytes("overlay.png"), bytes("overlay-0.png"));
    assert_ne!(bytes("overlay-0.png"), bytes("overlay-1.png"));
    // The completed points of both views lie on one cylinder in the frame of reference.
    for name in ["completed.ply", "completed.pcd"] {
        let cloud = run(["fit", "--json", "--points", out.join(name).to_str().unwrap()]).object();
        assert_eq!(cloud["result"]["points_used"], points, "{name}");
        assert!(cloud["result"]["point_rms"].as_f64().unwrap() < 1e-6, "{name}");
        let [expected, radius] = [&object, &cloud].map(|o| o["cylinder"]["radius"].as_f64().unwrap());
        assert!((radius / expected - 1.0).abs() < 1e-4, "{name}");
    }
}

#[test]
fn a_single_view_with_a_depth_camera_keeps_the_shape_of_one_view() {
    let views = Views::new();
    let mut json = views.json["views"][0].clone();
    let object = fitted(&views.write(&json), &[]);
    assert_near(&object, 0.01);
    assert!(object["views"].is_null() && object["limbs"][1]["samples_used"].is_u64());
    assert_eq!(object["arc_samples"].as_array().unwrap().len(), 2);
    // A list of one view is one view.
    let listed = fitted(&views.write(&json!({ "views": [json] })), &[]);
    assert_eq!((&listed["cylinder"], &listed["views"]), (&object["cylinder"], &Value::Null));
    // The first camera stands at the origin; what it is told to be elsewhere moves the result.
    json["pose"]["translation"] = json!([1.0, 2.0, 3.0]);
    let moved = fitted(&views.write(&json), &[]);
    let [at, before] = [&moved, &object].map(|object| vector(&object["extent"]["center"]));
    for k in 0..3 {
        assert!((at[k] - before[k] - 1.0 - k as f64).abs() < 1e-6, "{at:?} {before:?}");
    }
    // Without an image the ground of the picture is the depth that the colour camera sees.
    let out = views.path("out");
    fitted(&views.write(&json), &["--no-image", "--out", out.to_str().unwrap()]);
    let overlay = image::open(out.join("overlay.png")).unwrap().to_rgb8();
    let levels = overlay.pixels().filter(|p| p.0[0] > 40 && p.0[2] >= p.0[0]).count();
    assert!(levels > 10_000 && !out.join("overlay-0.png").exists(), "{levels}");
}

#[test]
fn views_without_a_mask_or_an_image_are_taken_with_the_others() {
    let views = Views::new();
    let mut json = views.json.clone();
    // Nothing but the cylinder has a depth.
    json["views"][0]["mask"] = Value::Null;
    json["views"][0]["image"] = Value::Null;
    let object = fitted(&views.write(&json), &[]);
    assert_near(&object, 0.01);
    assert_eq!(object["fitted"], "all_measured_pixels");
    assert!(
        object["notes"][0].as_str().unwrap().starts_with("no mask in view 0: the pixels that were fitted"),
        "{}",
        object["notes"]
    );
    let of_views = &object["views"];
    assert_eq!(
        (&of_views[0]["fitted"], &of_views[1]["fitted"]),
        (&"all_measured_pixels".into(), &"mask".into())
    );
    assert_eq!((&object["extent"]["start_view"], &object["extent"]["end_view"]), (&1.into(), &1.into()));
    assert!(of_views[0]["completion"].is_null() && of_views[0]["limbs"].is_null());
    assert_eq!(object["completion"], of_views[1]["completion"]);
    for view in json["views"].as_array_mut().unwrap() {
        view["mask"] = Value::Null;
    }
    let object = fitted(&views.write(&json), &[]);
    let note = format!("no mask: {} measured pixels were fitted", object["result"]["points_used"]);
    assert!(object["notes"][0].as_str().unwrap().starts_with(&note), "{}", object["notes"]);
    assert_eq!(object["extent"]["end_source"], "points");
    assert!(object["completion"].is_null());
}

#[test]
fn what_is_wrong_with_a_view_is_named_with_its_place() {
    let views = Views::new();
    let bad_pose = json!([1, 0, 0, 0, 1, 0, 0, 0, -1]);
    let at = "/views/1/pose/rotation";
    views.fails_with(at, bad_pose.clone(), "INVALID_ARGUMENT", &["frame.json: views[1].pose: ", "rotation"]);
    views.fails_with(at, json!([1, 0, 0, 0, 2, 0, 0, 0, 1]), "INVALID_ARGUMENT", &["views[1].pose: "]);
    views.fails_with(at, json!([1, 0, 0]), "BAD_FRAME", &["views[1].pose.rotation"]);
    views.fails_with(at, Value::Null, "BAD_FRAME", &["views[1].pose.rotation"]);
    let at = "/views/0/depth_camera";
    views.fails_with(
        &format!("{at}/rotation"),
        bad_pose,
        "INVALID_ARGUMENT",
        &["views[0].depth_camera: ", "rotation"],
    );
    views.fails_with(
        &format!("{at}/fx"),
        json!(0),
        "INVALID_INTRINSICS",
        &["views[0].depth_camera: ", "fx is 0"],
    );
    views.fails_with(&format!("{at}/width"), json!(143), "SIZE_MISMATCH", &["depth0.png", "144 x 108"]);
    views.fails_with(
        "/views/1/camera/fy",
        json!(-1),
        "INVALID_INTRINSICS",
        &["views[1].camera: ", "fy is -1"],
    );
    views.fails_with("/views/1/depth_scale", json!(0), "INVALID_ARGUMENT", &["views[1]: depth scale is 0"]);
    views.fails_with("/views/1/depth", json!("none.png"), "FILE_NOT_READABLE", &["none.png"]);
    views.fails_with("/views", json!([]), "BAD_FRAME", &["frame.json: views: the list is empty"]);
    views.fails_with("/views", json!({}), "BAD_FRAME", &["views"]);
    views.fails_with("/views/1/edges/0/0", json!([1]), "BAD_FRAME", &["views[1].edges[0][0]"]);

    let mut json = views.json.clone();
    json["views"][0]["deep"] = 1.into();
    fails(&views.write(&json), &[], "BAD_FRAME", &["views[0]", "unknown field `deep`"]);
    json = views.json.clone();
    json["camera"] = json["views"][0]["camera"].clone();
    fails(&views.write(&json), &[], "BAD_FRAME", &["unknown field `camera`"]);
    json = views.json.clone();
    json["views"][0]["depth_camera"].as_object_mut().unwrap().remove("translation");
    fails(&views.write(&json), &[], "BAD_FRAME", &["views[0].depth_camera", "missing field `translation`"]);
    GrayImage::new(160, 120).save(views.path("mask1.png")).unwrap();
    fails(&views.write(&views.json), &[], "EMPTY_MASK", &["frame.json: views[1]: "]);
}

#[test]
fn a_missing_distortion_is_none() {
    let mut copy = Copy::of("w004");
    copy.json["camera"]["distortion"] = json!([]);
    let expected = fitted(&copy.write(), &[])["cylinder"].clone();
    copy.json["camera"].as_object_mut().unwrap().remove("distortion");
    assert_eq!(fitted(&copy.write(), &[])["cylinder"], expected);
    assert_ne!(fitted(&data("w004"), &[])["cylinder"], expected);
}
