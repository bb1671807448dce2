//! Frames in the format of the command line, read with as little code as the tests need.
#![allow(dead_code, clippy::unwrap_used)]

use cylfuse::camera::{Distortion, Intrinsics};
use cylfuse::fitter::Fitter;
use cylfuse::geometry::Cylinder;
use cylfuse::observations::{DepthRange, DepthView, EdgeSegment, ImageView, MaskView};
use nalgebra::{Vector2, Vector3};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Folders of frames below `../shared` beside the checkout; empty with a message when they are not there.
pub fn shared_frames(set: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared").join(set);
    let Ok(entries) = std::fs::read_dir(&folder) else {
        eprintln!("skipped: no frames in ../shared/{set}");
        return Vec::new();
    };
    let mut folders: Vec<PathBuf> =
        entries.map(|entry| entry.unwrap().path()).filter(|path| path.join("frame.json").exists()).collect();
    folders.sort();
    folders
}

pub fn json(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn vector(value: &Value) -> Vector3<f64> {
    Vector3::from_fn(|k, _| value[k].as_f64().unwrap())
}

/// A cylinder by the keys `point`, `direction` and `radius`.
pub fn cylinder(value: &Value, point: &str, direction: &str) -> Cylinder {
    let radius = value["radius"].as_f64().unwrap();
    Cylinder::new(vector(&value[point]), vector(&value[direction]), radius).unwrap()
}

/// The solution in reference.json for an edge weight.
pub fn solution(folder: &Path, edge_weight: f64) -> Value {
    let reference = json(&folder.join("reference.json"));
    let solutions = reference["solutions"].as_array().unwrap();
    solutions.iter().find(|s| s["edge_weight"].as_f64() == Some(edge_weight)).unwrap().clone()
}

/// A fitter with everything in a frame but its image.
pub fn fitter(folder: &Path) -> Fitter {
    fitter_with_edges(folder, true)
}

/// The same, with or without the edges.
pub fn fitter_with_edges(folder: &Path, with_edges: bool) -> Fitter {
    let frame = json(&folder.join("frame.json"));
    let camera = &frame["camera"];
    let number = |key: &str| camera[key].as_f64().unwrap();
    let coefficients: Vec<f64> =
        camera["distortion"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
    let mut fitter = Fitter::new();
    fitter
        .set_intrinsics(Intrinsics {
            width: number("width") as u32,
            height: number("height") as u32,
            fx: number("fx"),
            fy: number("fy"),
            cx: number("cx"),
            cy: number("cy"),
            distortion: Distortion::brown_conrady(&coefficients).unwrap(),
        })
        .unwrap();
    let open = |key: &str| image::open(folder.join(frame[key].as_str().unwrap())).unwrap();
    let (depth, mask) = (open("depth").into_luma16(), open("mask").into_luma8());
    let size = (depth.width() as usize, depth.height() as usize);
    let scale = frame["depth_scale"].as_f64().unwrap();
    let depth = DepthView::from_u16(&depth, size, scale).unwrap();
    let mask = MaskView::from_u8(&mask, size).unwrap();
    fitter.push_depth(&depth, Some(&mask), &DepthRange::default()).unwrap();
    if !with_edges {
        return fitter;
    }
    let end = |q: &Value| Vector2::new(q[0].as_f64().unwrap(), q[1].as_f64().unwrap());
    let edges: Vec<EdgeSegment> = frame["edges"]
        .as_array()
        .unwrap()
        .iter()
        .map(|edge| EdgeSegment { endpoints: [end(&edge[0]), end(&edge[1])], weight: 1.0 })
        .collect();
    fitter.push_edges(&edges).unwrap();
    fitter
}

/// Gives the image of a frame to its fitter.
pub fn push_image(fitter: &mut Fitter, folder: &Path) {
    let frame = json(&folder.join("frame.json"));
    let image = image::open(folder.join(frame["image"].as_str().unwrap())).unwrap().into_luma8();
    let size = (image.width() as usize, image.height() as usize);
    fitter.push_image(&ImageView::from_u8(&image, size).unwrap()).unwrap();
}
