//! Synthetic scenes that the tests share.
// Each test program uses a part; this is test code wherever it is included.
#![allow(dead_code, clippy::unwrap_used)]

use cylfuse::camera::{Camera, Distortion, Intrinsics};
use cylfuse::fitter::Fitter;
use cylfuse::geometry::{Cylinder, LimbFrame, any_orthogonal};
use cylfuse::observations::{EdgeSegment, PointsView};
use nalgebra::{Vector2, Vector3};

pub const SIZE: (usize, usize) = (640, 480);

pub fn intrinsics() -> Intrinsics {
    Intrinsics {
        width: SIZE.0 as u32,
        height: SIZE.1 as u32,
        fx: 570.0,
        fy: 565.0,
        cx: 319.5,
        cy: 239.5,
        distortion: Distortion::None,
    }
}

pub fn camera() -> Camera {
    Camera::new(intrinsics()).unwrap()
}

/// A can of radius 30 mm, 0.7 m away and tilted in depth.
pub fn can() -> Cylinder {
    Cylinder::new(Vector3::new(0.02, -0.01, 0.7), Vector3::new(0.2, 0.9, 0.3), 0.03).unwrap()
}

/// Points of the visible wall of a cylinder: within ±70° of the side that faces `observer`, over a length of
/// three radii.
pub fn visible_points(cylinder: &Cylinder, observer: &Vector3<f64>, count: usize) -> Vec<[f64; 3]> {
    let d = cylinder.axis.direction;
    let foot = cylinder.axis.point;
    let away = observer - foot;
    let across = away - d * away.dot(&d);
    let toward = if across.norm() > 0.0 { across.normalize() } else { any_orthogonal(&d).0 };
    let sideways = d.cross(&toward);
    (0..count)
        .map(|k| {
            // Two irrational steps cover the patch evenly and without order.
            let (a, b) = ((k as f64 * 0.618_033_988_75).fract(), (k as f64 * 0.414_213_562_37).fract());
            let angle = (2.0 * a - 1.0) * 70_f64.to_radians();
            let radial = toward * angle.cos() + sideways * angle.sin();
            let p = foot + d * ((2.0 * b - 1.0) * 1.5 * cylinder.radius) + radial * cylinder.radius;
            [p.x, p.y, p.z]
        })
        .collect()
}

/// Segments on both limbs of a cylinder as the camera sees them, over a length of three radii.
pub fn limb_segments(cylinder: &Cylinder, camera: &Camera) -> Vec<EdgeSegment> {
    let limbs = LimbFrame::new(cylinder).unwrap().limb_lines();
    limbs
        .iter()
        .map(|line| {
            let middle = line.nearest_to(&cylinder.axis.point);
            let end = |side: f64| middle + line.direction * (side * 1.5 * cylinder.radius);
            EdgeSegment { endpoints: [-1.0, 1.0].map(|s| camera.project(&end(s)).unwrap()), weight: 1.0 }
        })
        .collect()
}

pub fn segment(a: [f64; 2], b: [f64; 2]) -> EdgeSegment {
    EdgeSegment { endpoints: [Vector2::from(a), Vector2::from(b)], weight: 1.0 }
}

/// A fitter that has taken a cloud.
pub fn fitter_with(points: &[[f64; 3]]) -> Fitter {
    let mut fitter = Fitter::new();
    fitter.push_points(&PointsView::from_f64(points), None).unwrap();
    fitter
}

/// Normal noise of unit variance, the same at every run.
pub struct Noise(u64);

impl Noise {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(2).wrapping_add(1))
    }

    pub fn uniform(&mut self) -> f64 {
        // SplitMix64.
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform()).cos()
    }

    pub fn vector(&mut self) -> Vector3<f64> {
        Vector3::new(self.normal(), self.normal(), self.normal())
    }
}
