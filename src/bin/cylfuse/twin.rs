//! `cylfuse twin`: frames made by a twin of an RGB-D camera.

use crate::failure::Failure;
use crate::fit::{create_folder, write_file};
use crate::images::{Image, Pixels};
use crate::twin_arguments::{KindName, TwinArguments};
use cylfuse::camera::Camera;
use cylfuse::observations::DepthCamera;
use cylfuse::twin::{
    self, Capture, CaptureOptions, DEPTH_UNIT, Scene, SeenCylinder, TrueCylinder, capture, random_scene,
};
use nalgebra::Vector2;
use serde_json::{Value, json};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Makes one frame into a folder of its own, whose path it returns.
pub fn run(seed: u64, arguments: &TwinArguments, options: &CaptureOptions) -> Result<PathBuf, Failure> {
    let folder = arguments.out.join(format!("{}{seed:04}", arguments.kind.name()));
    let scene = random_scene(arguments.kind.kind(), seed)?;
    let frame = capture(&scene, options, seed)?;
    create_folder(&folder)?;
    let writer = Writer { folder: &folder, scene: &scene, frame: &frame, options, seed };
    writer.images(arguments.jpeg)?;
    writer.json(arguments)?;
    Ok(folder)
}

struct Writer<'a> {
    folder: &'a Path,
    scene: &'a Scene,
    frame: &'a Capture,
    options: &'a CaptureOptions,
    seed: u64,
}

impl Writer<'_> {
    fn images(&self, jpeg: Option<u8>) -> Result<(), Failure> {
        let size = self.options.camera.size();
        let depth_size = self.frame.depth_camera.as_ref().map_or(size, |own| own.camera.size());
        // Of an earlier run with another option.
        remove(&self.folder.join(if jpeg.is_some() { "image.png" } else { "image.jpg" }))?;
        let image = Image::new(size, Pixels::Grey8(self.frame.image.clone()));
        match jpeg {
            None => self.png("image.png", &image)?,
            Some(quality) => {
                write_file(&self.folder.join("image.jpg"), |to| image.write_jpeg(to, quality))?;
            }
        }
        self.png("depth.png", &Image::new(depth_size, Pixels::Grey16(self.frame.depth.clone())))?;
        // No scene has more than 255 objects.
        let labels = self.frame.labels.iter().map(|label| (*label).min(255) as u8).collect();
        self.png("labels.png", &Image::new(size, Pixels::Grey8(labels)))?;
        let body = self.frame.body.iter().map(|body| if *body { 255 } else { 0 }).collect();
        self.png("body.png", &Image::new(size, Pixels::Grey8(body)))
    }

    fn png(&self, name: &str, image: &Image) -> Result<(), Failure> {
        write_file(&self.folder.join(name), |to| image.write_png(to))
    }

    fn json(&self, arguments: &TwinArguments) -> Result<(), Failure> {
        let image = if arguments.jpeg.is_some() { "image.jpg" } else { "image.png" };
        let mut frame = json!({
            "camera": camera_json(&self.options.camera, &arguments.distortion),
            "image": image,
            "image_gamma": self.options.picture.gamma,
            "depth": "depth.png",
            "depth_scale": DEPTH_UNIT,
        });
        if let Some(own) = &self.frame.depth_camera {
            frame["depth_camera"] = depth_camera_json(own);
        }
        let truth = match (arguments.kind, self.frame.cylinders.as_slice()) {
            (KindName::Single, [only]) => {
                let size = self.options.camera.size();
                let mask = twin::drawn_mask(&self.frame.body, size, self.seed);
                self.png("mask.png", &Image::new(size, Pixels::Grey8(mask)))?;
                frame["mask"] = json!("mask.png");
                let edges = twin::true_edges(&only.truth, &self.options.camera);
                if let Some(edges) = &edges {
                    frame["edges"] = segments_json(&twin::hand_set(edges, size, self.seed));
                }
                single_json(
                    only,
                    edges.map(|edges| edges.iter().filter_map(|edge| twin::clipped(edge, size)).collect()),
                )
            }
            _ => json!({
                "cylinders": self.frame.cylinders.iter().map(seen_json).collect::<Vec<_>>(),
                "ignore": self.scene.ignored.iter().map(cylinder_json).collect::<Vec<_>>(),
            }),
        };
        for (name, value) in [("frame.json", frame), ("truth.json", truth)] {
            write_file(&self.folder.join(name), |to| {
                serde_json::to_writer_pretty(&mut *to, &value)?;
                to.write_all(b"\n")
            })?;
        }
        Ok(())
    }
}

/// Removes a file, if it is there.
fn remove(path: &Path) -> Result<(), Failure> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(Failure::not_writable(path, error)),
        _ => Ok(()),
    }
}

fn camera_json(camera: &Camera, distortion: &[f64]) -> Value {
    let i = camera.intrinsics();
    json!({
        "width": i.width, "height": i.height, "fx": i.fx, "fy": i.fy, "cx": i.cx, "cy": i.cy,
        "distortion": distortion,
    })
}

fn depth_camera_json(own: &DepthCamera) -> Value {
    let mut value = camera_json(&own.camera, &[]);
    // nalgebra counts column by column.
    value["rotation"] = json!(own.to_color.rotation().transpose().as_slice());
    value["translation"] = json!(own.to_color.translation().as_slice());
    value
}

fn segments_json(segments: &[[Vector2<f64>; 2]]) -> Value {
    json!(segments.iter().map(|segment| segment.map(<[f64; 2]>::from)).collect::<Vec<_>>())
}

fn cylinder_json(truth: &TrueCylinder) -> Value {
    json!({
        "id": truth.object,
        "center": truth.center.as_slice(),
        "axis": truth.cylinder.axis.direction.as_slice(),
        "radius": truth.cylinder.radius,
        "length": truth.length,
    })
}

fn seen_json(seen: &SeenCylinder) -> Value {
    let mut value = cylinder_json(&seen.truth);
    value["style"] = json!(seen.truth.style.name());
    value["body_pixels"] = json!(seen.body_pixels);
    value["measured_pixels"] = json!(seen.measured_pixels);
    value["visible_along"] = json!(seen.visible_along);
    value["visible_across"] = json!(seen.visible_across);
    value["ends_seen"] = json!(seen.ends_seen);
    value["countable"] = json!(seen.countable);
    value
}

fn single_json(seen: &SeenCylinder, edges: Option<Vec<[Vector2<f64>; 2]>>) -> Value {
    let mut value = seen_json(seen);
    value["true_edges"] = edges.map_or(Value::Null, |edges| segments_json(&edges));
    value
}
