//! Frames in the format of the command line, read with as little code as the tests need.
#![allow(dead_code, clippy::unwrap_used)]

use cylfuse::camera::{Distortion, Intrinsics};
use cylfuse::fitter::Fitter;
use cylfuse::geometry::Cylinder;
use cylfuse::observations::{DepthRange, DepthView, EdgeSegment, ImageView, MaskView, PointsView};
use nalgebra::{Vector2, Vector3};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Folders of frames below `../shared` beside the checkout; empty with a message when they are not there.
pub fn shared_frames(set: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared").join(set);
    let mut folders: Vec<PathBuf> = std::fs::read_dir(&folder)
        .into_iter()
        .flatten()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.join("frame.json").exists())
        .collect();
    if folders.is_empty() {
        eprintln!("skipped: no frames in ../shared/{set}");
    }
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

/// What a frame holds as input, decoded.
#[derive(Clone)]
pub struct Inputs {
    pub intrinsics: Intrinsics,
    pub size: (usize, usize),
    pub depth: Vec<u16>,
    pub depth_scale: f64,
    /// Empty where the frame has none.
    pub mask: Vec<u8>,
    pub image: Vec<u8>,
    pub edges: Vec<EdgeSegment>,
}

impl Inputs {
    pub fn read(folder: &Path) -> Self {
        let frame = json(&folder.join("frame.json"));
        let camera = &frame["camera"];
        let number = |key: &str| camera[key].as_f64().unwrap();
        let coefficients: Vec<f64> =
            camera["distortion"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
        let open = |key: &str| image::open(folder.join(frame[key].as_str().unwrap())).unwrap();
        let depth = open("depth").into_luma16();
        let mask = frame["mask"].as_str().map(|_| open("mask").into_luma8().into_raw());
        let end = |q: &Value| Vector2::new(q[0].as_f64().unwrap(), q[1].as_f64().unwrap());
        let edge = |e: &Value| EdgeSegment { endpoints: [end(&e[0]), end(&e[1])], weight: 1.0 };
        Self {
            intrinsics: Intrinsics {
                width: number("width") as u32,
                height: number("height") as u32,
                fx: number("fx"),
                fy: number("fy"),
                cx: number("cx"),
                cy: number("cy"),
                distortion: Distortion::brown_conrady(&coefficients).unwrap(),
            },
            size: (depth.width() as usize, depth.height() as usize),
            depth: depth.into_raw(),
            depth_scale: frame["depth_scale"].as_f64().unwrap(),
            mask: mask.unwrap_or_default(),
            image: open("image").into_luma8().into_raw(),
            edges: frame["edges"].as_array().map_or_else(Vec::new, |edges| edges.iter().map(edge).collect()),
        }
    }

    /// A fitter with camera, depth and mask.
    pub fn fitter(&self) -> Fitter {
        let mut fitter = Fitter::new();
        fitter.set_intrinsics(self.intrinsics).unwrap();
        let depth = DepthView::from_u16(&self.depth, self.size, self.depth_scale).unwrap();
        let mask = MaskView::from_u8(&self.mask, self.size).unwrap();
        fitter.push_depth(&depth, Some(&mask), &DepthRange::default()).unwrap();
        fitter
    }

    /// A fitter with camera, the points in the mask but not the mask, and edges.
    pub fn fitter_without_mask(&self, edges: &[EdgeSegment]) -> Fitter {
        let points: Vec<[f64; 3]> = self.fitter().cloud().points().map(Into::into).collect();
        let mut fitter = Fitter::new();
        fitter.set_intrinsics(self.intrinsics).unwrap();
        fitter.push_points(&PointsView::from_f64(&points), None).unwrap();
        fitter.push_edges(edges).unwrap();
        fitter
    }

    /// Gives the image to a fitter.
    pub fn push_image(&self, fitter: &mut Fitter) {
        fitter.push_image(&ImageView::from_u8(&self.image, self.size).unwrap()).unwrap();
    }
}

/// A fitter with everything in a frame but its image.
pub fn fitter(folder: &Path) -> Fitter {
    fitter_with_edges(folder, true)
}

/// The same, with or without the edges.
pub fn fitter_with_edges(folder: &Path, with_edges: bool) -> Fitter {
    let inputs = Inputs::read(folder);
    let mut fitter = inputs.fitter();
    if with_edges {
        fitter.push_edges(&inputs.edges).unwrap();
    }
    fitter
}

/// Gives the image of a frame to its fitter.
pub fn push_image(fitter: &mut Fitter, folder: &Path) {
    Inputs::read(folder).push_image(fitter);
}
