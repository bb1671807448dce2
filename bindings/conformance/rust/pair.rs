//! Whole scenes: two cylinders before a wall, and the cases of a detector.

use super::cases::{call, case, image, options, residuals};
use super::scene::{Noise, f32_array, second_pose, u8_array, u16_array};
use nalgebra::Vector3;
use serde_json::{Map, Value, json};

/// Rays by which a pixel of the image is averaged, in each direction.
const RAYS: usize = 4;

struct Solid {
    middle: Vector3<f64>,
    direction: Vector3<f64>,
    radius: f64,
    half_length: f64,
}

fn solids() -> [Solid; 2] {
    let solid = |middle: [f64; 3], direction: [f64; 3], radius, half_length| Solid {
        middle: middle.into(),
        direction: Vector3::from(direction).normalize(),
        radius,
        half_length,
    };
    [
        solid([-0.12, 0.0, 0.7], [0.1, 0.99, 0.1], 0.05, 0.12),
        solid([0.13, 0.05, 0.8], [0.9, 0.3, 0.2], 0.035, 0.1),
    ]
}

/// A pinhole in the middle of its image.
struct Grid {
    width: usize,
    height: usize,
    focal: f64,
}

/// The images, and the cloud.
const IMAGE: Grid = Grid { width: 100, height: 75, focal: 106.0 };
const CLOUD: Grid = Grid { width: 64, height: 48, focal: 68.0 };

impl Grid {
    fn centre(&self) -> [f64; 2] {
        [self.width as f64 / 2.0 - 0.5, self.height as f64 / 2.0 - 0.5]
    }

    fn ray(&self, column: f64, row: f64) -> Vector3<f64> {
        let [cx, cy] = self.centre();
        Vector3::new((column - cx) / self.focal, (row - cy) / self.focal, 1.0)
    }

    fn pixels(&self) -> impl Iterator<Item = (f64, f64)> + use<> {
        let (width, height) = (self.width, self.height);
        (0..width * height).map(move |k| ((k % width) as f64, (k / width) as f64))
    }

    /// The points that are measured, with noise.
    fn measured(&self, seed: u64) -> Vec<Vector3<f64>> {
        let mut noise = Noise(seed);
        let point = |(column, row)| {
            let ray = self.ray(column, row);
            let wall = 1.2 / (1.0 + 0.1 * ray.x - 0.2 * ray.y);
            ray * (front(&ray).unwrap_or(wall) + 5e-4 * noise.normal())
        };
        self.pixels().map(point).collect()
    }

    /// The grey image, with noise.
    fn grey(&self, seed: u64) -> Vec<f64> {
        let mut noise = Noise(seed);
        let offset = |k: usize| (k as f64 + 0.5) / RAYS as f64 - 0.5;
        let value = |(column, row)| {
            let ray = |k: usize| self.ray(column + offset(k % RAYS), row + offset(k / RAYS));
            let meeting = (0..RAYS * RAYS).filter(|&k| front(&ray(k)).is_some()).count();
            40.0 + 160.0 * meeting as f64 / (RAYS * RAYS) as f64 + 2.0 * noise.normal()
        };
        self.pixels().map(value).collect()
    }
}

/// The depth at which a ray meets the first near wall between its ends.
fn front(ray: &Vector3<f64>) -> Option<f64> {
    let meet = |solid: &Solid| {
        let off = |v: &Vector3<f64>| v - solid.direction * v.dot(&solid.direction);
        let (k, w) = (off(ray), off(&solid.middle));
        // |t k - w| = r
        let (a, b, c) = (k.dot(&k), k.dot(&w), w.dot(&w) - solid.radius * solid.radius);
        let t = (b - (b * b - a * c).max(0.0).sqrt()) / a;
        let along = (ray * t - solid.middle).dot(&solid.direction);
        (b * b >= a * c && along.abs() <= solid.half_length).then_some(t)
    };
    solids().iter().filter_map(meet).min_by(f64::total_cmp)
}

/// The arrays of the scene.
pub fn arrays(arrays: &mut Map<String, Value>) {
    let shape = [IMAGE.height, IMAGE.width];
    arrays.insert("pair_depth".into(), u16_array(&shape, IMAGE.measured(11).iter().map(|p| p.z * 1e4)));
    arrays.insert("pair_image".into(), u8_array(&shape, IMAGE.grey(12)));
    let cloud = CLOUD.measured(13).into_iter().flat_map(|p| [p.x, p.y, p.z]);
    arrays.insert("pair_cloud".into(), f32_array(&[CLOUD.height, CLOUD.width, 3], cloud));
}

/// The camera of the images.
pub fn camera() -> Value {
    let [cx, cy] = IMAGE.centre();
    json!({
        "width": IMAGE.width, "height": IMAGE.height, "fx": IMAGE.focal, "fy": IMAGE.focal, "cx": cx, "cy": cy,
        "distortion_model": "NONE", "distortion": vec![0.0; 8],
    })
}

fn of_cylinder(name: &str, index: usize) -> Value {
    json!({"call": name, "index": index})
}

fn detect_points(points: Value) -> Value {
    json!({"call": "detect_points", "points": points})
}

fn with_options(name: &str, options: Value) -> Value {
    json!({"call": name, "options": options})
}

/// The cases of a detector.
pub fn detectors() -> Vec<Value> {
    let intrinsics = json!({"call": "frame_set_intrinsics", "camera": "pair"});
    let depth = json!({"call": "frame_set_depth", "depth": "pair_depth", "scale": 1e-4});
    let grey = json!({"call": "frame_set_image", "image": "pair_image"});
    let settings = |options| with_options("detector_set_options", options);
    let fits = |options| with_options("detector_set_fit_options", options);
    let set = |about: &str, name: &str, steps: Vec<Value>| case(name, about, steps);
    vec![
        set(
            "two cylinders before a wall, all that can be asked, and the fitter of one of them",
            "detect",
            vec![
                call("detections"),
                call("labels"),
                of_cylinder("indices", 0),
                of_cylinder("make_fitter", 0),
                call("detect"),
                intrinsics.clone(),
                call("detect"),
                depth.clone(),
                grey.clone(),
                call("detector_cancel"),
                call("detect"),
                call("new_frame"),
                call("detections"),
                of_cylinder("detector_get_result", 0),
                of_cylinder("detector_get_cylinder", 0),
                of_cylinder("detector_get_extent", 0),
                of_cylinder("detector_get_result", 1),
                of_cylinder("detector_get_cylinder", 1),
                of_cylinder("detector_get_extent", 1),
                call("labels"),
                of_cylinder("indices", 1),
                of_cylinder("indices", 2),
                of_cylinder("make_fitter", 2),
                of_cylinder("make_fitter", 1),
                call("get_options"),
                call("counts"),
                call("get_result"),
                call("get_cylinder"),
                call("limbs"),
                call("extent"),
                residuals("POINTS"),
                options(json!({"start": "MODEL", "max_iterations": 200})),
                call("fit"),
            ],
        ),
        set(
            "a pose, a range of depths, limits, and options of the fits; the image is not looked at",
            "detect_limits",
            vec![
                settings(json!({
                    "image_use": "IGNORE", "max_threads": 2, "max_count": 1, "min_pixels": 80, "min_score": 0.25,
                    "radius_min": 0.04, "radius_max": 0.06, "axis": [0.0, -3.0, 0.0], "axis_max_angle": 0.5,
                })),
                call("detector_get_options"),
                fits(json!({"depth_noise": 1e-3, "extent_rule": "EXTREMES"})),
                call("detector_get_fit_options"),
                intrinsics.clone(),
                json!({"call": "frame_set_pose", "pose": second_pose()}),
                json!({"call": "frame_set_depth", "depth": "pair_depth", "scale": 1e-4, "max_depth": 1.0}),
                grey,
                call("detect"),
                of_cylinder("detector_get_result", 0),
                of_cylinder("detector_get_cylinder", 0),
                of_cylinder("detector_get_extent", 0),
                settings(json!({"min_pixels": 5000})),
                call("detect"),
                call("labels"),
            ],
        ),
        set(
            "clouds, organised and not, one after the other",
            "detect_points",
            vec![
                call("detector_get_options"),
                settings(json!({"min_pixels": 60})),
                detect_points(json!({"array": "pair_cloud"})),
                of_cylinder("detector_get_result", 0),
                of_cylinder("detector_get_cylinder", 0),
                call("labels"),
                of_cylinder("indices", 0),
                of_cylinder("make_fitter", 0),
                call("counts"),
                residuals("POINTS"),
                call("extent"),
                detect_points(json!({"array": "cloud_f64", "weights": {"array": "negative_weight"}})),
                call("detections"),
                detect_points(json!({"array": "cloud_f64", "weights": {"array": "weights_f64"}})),
                detect_points(json!({"array": "records_f32", "column": 0})),
                call("labels"),
                detect_points(json!({"array": "none"})),
                call("labels"),
                of_cylinder("indices", 0),
            ],
        ),
        set(
            "options that a detector refuses; the old ones stay",
            "bad_detector_options",
            vec![
                settings(json!({"min_score": 1.5})),
                settings(json!({"radius_min": 0.02, "radius_max": 0.01})),
                settings(json!({"axis": [0.0, 1.0, 0.0], "axis_max_angle": 2.0})),
                fits(json!({"edge_weight": 1.4})),
                fits(json!({"max_threads": 2})),
                fits(json!({"start": "MOMENTS"})),
                fits(json!({"radius_max": 0.1})),
                call("detector_get_options"),
                call("detector_get_fit_options"),
                fits(json!({"objective": "PAPER"})),
                intrinsics,
                depth,
                call("detect"),
                image("pair_image"),
            ],
        ),
    ]
}
