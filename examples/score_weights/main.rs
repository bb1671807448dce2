//! What the scores of all candidates in folders of scenes are made of, one JSON object a scene and line, for `fit.py`
//! beside this: `cargo run --release --example score_weights -- FOLDER…`.
#![allow(clippy::unwrap_used)] // A measurement that can't run should stop.

use cylfuse::camera::{Camera, Distortion, Intrinsics};
use cylfuse::detection::{DetectionOptions, Evidence, detect};
use cylfuse::geometry::Cylinder;
use cylfuse::observations::{DepthRange, DepthView, Frame, ImageView};
use cylfuse::scene::{Detector, DetectorOptions};
use serde_json::{Value, json};
use std::path::Path;

/// The least score of what counts as a candidate.
const LEAST: f64 = 0.01;

fn row(cylinder: &Cylinder, evidence: &Evidence) -> Value {
    let (point, direction) = (cylinder.axis.point, cylinder.axis.direction);
    json!({
        "cylinder": [point.x, point.y, point.z, direction.x, direction.y, direction.z, cylinder.radius],
        "score": evidence.score(),
        "terms": evidence.terms(),
    })
}

fn scene(folder: &Path) -> Value {
    let frame: Value =
        serde_json::from_str(&std::fs::read_to_string(folder.join("frame.json")).unwrap()).unwrap();
    let open = |key: &str| image::open(folder.join(frame[key].as_str().unwrap())).unwrap();
    let (depth, picture) = (open("depth").into_luma16(), open("image").into_luma8());
    let size = (depth.width() as usize, depth.height() as usize);
    let number = |key: &str| frame["camera"][key].as_f64().unwrap();
    let coefficients: Vec<f64> =
        frame["camera"]["distortion"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
    let camera = Camera::new(Intrinsics {
        width: size.0 as u32,
        height: size.1 as u32,
        fx: number("fx"),
        fy: number("fy"),
        cx: number("cx"),
        cy: number("cy"),
        distortion: Distortion::brown_conrady(&coefficients).unwrap(),
    })
    .unwrap();
    let view = DepthView::from_u16(&depth, size, frame["depth_scale"].as_f64().unwrap()).unwrap();
    let mut input = Frame::new(camera);
    input.set_depth(&view, &DepthRange::default()).unwrap();
    input.set_image(&ImageView::from_u8(&picture, size).unwrap()).unwrap();
    let search = DetectionOptions { min_score: LEAST, ..DetectionOptions::default() };
    let candidates = |use_image: bool| {
        let image = input.image().filter(|_| use_image);
        let seen = detect(input.camera().unwrap(), input.depth_on_image().unwrap(), image, &search).unwrap();
        let before: Vec<Value> = seen.cylinders.iter().map(|one| row(&one.cylinder, &one.evidence)).collect();
        let mut detector = Detector::new();
        detector.set_options(DetectorOptions { search, use_image, ..DetectorOptions::default() }).unwrap();
        let found = detector.detect(&input).unwrap().cylinders;
        let after: Vec<Value> = found.iter().map(|one| row(&one.result.cylinder, &one.evidence)).collect();
        json!({ "before": before, "after": after })
    };
    json!({ "scene": folder, "image": candidates(true), "depth": candidates(false) })
}

fn main() {
    for folder in std::env::args().skip(1) {
        let mut scenes: Vec<_> =
            std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
        scenes.retain(|path| path.join("truth.json").exists());
        scenes.sort();
        for path in scenes {
            println!("{}", scene(&path));
        }
    }
}
