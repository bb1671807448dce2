//! A piece of a cylinder in front of nothing, drawn without any noise for cameras that stand anywhere.
// Each test program uses a part; this is test code wherever it is included.
#![allow(dead_code, clippy::unwrap_used)]

use cylfuse::camera::{Camera, Distortion, Intrinsics};
use cylfuse::geometry::{Cylinder, LimbFrame, RigidMotion};
use cylfuse::observations::EdgeSegment;
use nalgebra::{Matrix3, Vector2, Vector3};

/// Half the length of the piece.
pub const HALF_LENGTH: f64 = 0.09;

/// Light inside a pixel is the mean of so many rows and columns of rays.
const RAYS: usize = 4;

/// The whole cylinder in the frame of reference; the middle of the piece is the point of its axis.
pub fn cylinder() -> Cylinder {
    Cylinder::new(Vector3::new(0.02, -0.01, 0.7), Vector3::new(0.9, 0.4, 0.1), 0.04).unwrap()
}

/// A small pinhole camera.
pub fn intrinsics(width: u32, height: u32, focal_length: f64) -> Intrinsics {
    let middle = |size: u32| f64::from(size) / 2.0 - 0.5;
    Intrinsics {
        width,
        height,
        fx: focal_length,
        fy: focal_length,
        cx: middle(width),
        cy: middle(height),
        distortion: Distortion::None,
    }
}

/// The colour camera of the views.
pub fn camera() -> Camera {
    Camera::new(intrinsics(160, 120, 190.0)).unwrap()
}

/// A depth camera with other optics.
pub fn depth_camera() -> Camera {
    Camera::new(intrinsics(144, 108, 160.0)).unwrap()
}

/// Where the depth camera stands beside the colour camera: x_colour = R x_depth + t.
pub fn beside() -> RigidMotion {
    let rotation = nalgebra::Rotation3::new(Vector3::new(0.01, -0.02, 0.005)).into_inner();
    RigidMotion::new(rotation, Vector3::new(0.025, 0.002, -0.001)).unwrap()
}

/// The pose of a camera at `eye` that looks at the middle of the piece, its rows along the x axis as far as possible.
pub fn looking_from(eye: [f64; 3]) -> RigidMotion {
    let eye = Vector3::from(eye);
    let forward = (cylinder().axis.point - eye).normalize();
    let down = forward.cross(&Vector3::x()).normalize();
    RigidMotion::new(Matrix3::from_columns(&[down.cross(&forward), down, forward]), eye).unwrap()
}

/// Two motions one after the other.
pub fn after(second: &RigidMotion, first: &RigidMotion) -> RigidMotion {
    let translation = second.point(first.translation());
    RigidMotion::new(second.rotation() * first.rotation(), translation).unwrap()
}

/// The surface as a camera sees it.
pub struct Seen {
    pub camera: Camera,
    cylinder: Cylinder,
}

impl Seen {
    /// By a camera with a pose.
    pub fn new(camera: &Camera, pose: &RigidMotion) -> Self {
        Self { camera: camera.clone(), cylinder: pose.inverse().cylinder(&cylinder()) }
    }

    /// Where the ray of a position in the image meets the piece from outside.
    fn hit(&self, pixel: &Vector2<f64>) -> Option<Vector3<f64>> {
        let axis = &self.cylinder.axis;
        let hit = self.cylinder.first_hit(&self.camera.unproject(pixel)?)?;
        (axis.position_of(&hit).abs() <= HALF_LENGTH).then_some(hit)
    }

    fn pixels<T>(&self, value: impl Fn(Vector2<f64>) -> T) -> Vec<T> {
        let (width, height) = self.camera.size();
        (0..width * height).map(|k| value(Vector2::new((k % width) as f64, (k / width) as f64))).collect()
    }

    /// Depth z of each pixel, 0 beside the piece.
    pub fn depth(&self) -> Vec<f32> {
        self.pixels(|pixel| self.hit(&pixel).map_or(0.0, |hit| hit.z as f32))
    }

    /// Pixels whose centre sees the piece.
    pub fn mask(&self) -> Vec<u8> {
        self.pixels(|pixel| u8::from(self.hit(&pixel).is_some()) * 255)
    }

    /// Light from the camera on a matt surface, before a grey ground.
    pub fn image(&self) -> Vec<u8> {
        self.pixels(|pixel| {
            let offset = |k: usize| (k as f64 + 0.5) / RAYS as f64 - 0.5;
            let light = |k: usize| {
                let hit = self.hit(&(pixel + Vector2::new(offset(k % RAYS), offset(k / RAYS))));
                hit.map_or(60.0, |hit| {
                    let normal = (hit - self.cylinder.axis.nearest_to(&hit)) / self.cylinder.radius;
                    120.0 - 100.0 * normal.dot(&hit.normalize())
                })
            };
            ((0..RAYS * RAYS).map(light).sum::<f64>() / (RAYS * RAYS) as f64).round() as u8
        })
    }

    /// The exact limbs of the piece.
    pub fn edges(&self) -> Vec<EdgeSegment> {
        let axis = &self.cylinder.axis;
        let limbs = LimbFrame::new(&self.cylinder).unwrap().limb_lines();
        let segment = |line: &cylfuse::geometry::Line| {
            let middle = line.nearest_to(&axis.point);
            let end = |side: f64| self.camera.project(&(middle + axis.direction * (side * HALF_LENGTH)));
            EdgeSegment { endpoints: [-1.0, 1.0].map(|side| end(side).unwrap()), weight: 1.0 }
        };
        limbs.iter().map(segment).collect()
    }
}
