//! The scene of the golden cases of detectors: two cylinders before a wall.

use super::scene::Noise;
use nalgebra::Vector3;
use serde_json::{Value, json};

pub const SIZE: [usize; 2] = [120, 90];
const FOCAL: f64 = 130.0;

/// Point, direction, radius, half the length.
const BODIES: [([f64; 3], [f64; 3], f64, f64); 2] =
    [([-0.12, 0.0, 0.7], [0.1, 0.99, 0.1], 0.05, 0.12), ([0.13, 0.05, 0.8], [0.9, 0.3, 0.2], 0.04, 0.11)];

pub fn camera() -> Value {
    let [width, height] = SIZE;
    json!({
        "width": width, "height": height, "fx": FOCAL, "fy": FOCAL, "cx": 59.5, "cy": 44.5,
        "distortion_model": "NONE", "distortion": vec![0.0; 8],
    })
}

fn ray(column: f64, row: f64) -> Vector3<f64> {
    Vector3::new((column - 59.5) / FOCAL, (row - 44.5) / FOCAL, 1.0)
}

/// The depth that a ray meets first, and whether that is a cylinder.
fn seen(ray: &Vector3<f64>) -> (f64, bool) {
    let mut nearest = (1.2 / (1.0 + 0.1 * ray.x - 0.2 * ray.y), false);
    for (point, direction, radius, half) in BODIES {
        let (point, direction) = (Vector3::from(point), Vector3::from(direction).normalize());
        let off = |v: &Vector3<f64>| v - direction * v.dot(&direction);
        let (k, w) = (off(ray), off(&point));
        let (a, b) = (k.dot(&k), k.dot(&w));
        let root = b * b - a * (w.dot(&w) - radius * radius);
        let z = (b - root.max(0.0).sqrt()) / a;
        if root > 0.0 && z < nearest.0 && (ray * z - point).dot(&direction).abs() <= half {
            nearest = (z, true);
        }
    }
    nearest
}

fn pixels() -> impl Iterator<Item = (f64, f64)> {
    (0..SIZE[0] * SIZE[1]).map(|k| ((k % SIZE[0]) as f64, (k / SIZE[0]) as f64))
}

/// With noise, and here and there nothing is measured.
pub fn depth() -> Vec<f64> {
    let mut noise = Noise(8);
    let depth = pixels().enumerate().map(|(k, (column, row))| {
        let z = seen(&ray(column, row)).0 + 5e-4 * noise.normal();
        if k % 37 == 0 { 0.0 } else { z }
    });
    depth.collect()
}

/// Bright cylinders, each pixel averaged over four rows and columns of rays.
pub fn image() -> Vec<f64> {
    let covered = |(column, row): (f64, f64)| {
        let offset = |k: i32| (f64::from(k) - 1.5) / 4.0;
        let hits = (0..16).filter(|k| seen(&ray(column + offset(k % 4), row + offset(k / 4))).1);
        40.0 + 10.0 * hits.count() as f64
    };
    pixels().map(covered).collect()
}

/// Every second pixel in both directions as an organised cloud; what was not measured is NaN.
pub fn cloud() -> Vec<f64> {
    let depth = depth();
    let [width, height] = SIZE;
    let mut cloud = Vec::new();
    for row in (0..height).step_by(2) {
        for column in (0..width).step_by(2) {
            let z = depth[row * width + column];
            let point = ray(column as f64, row as f64) * if z > 0.0 { z } else { f64::NAN };
            cloud.extend(point.iter());
        }
    }
    cloud
}
