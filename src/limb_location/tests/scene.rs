//! A rendered cylinder with known limbs.

use super::super::*;
use super::{located, noise};
use crate::camera::{Distortion, Intrinsics};
use crate::observations::{GreyImage, ImageView};
use nalgebra::Vector3;

pub(super) const SIZE: (usize, usize) = (240, 180);
pub(super) const BLUR: f64 = 0.9;

/// Pixels over which a shadow fades.
const SHADOW: f64 = 10.0;

/// Rays per pixel and direction.
const SAMPLES: usize = 3;

pub(super) struct Scene {
    pub(super) camera: Camera,
    pub(super) cylinder: Cylinder,
    pub(super) range: [f64; 2],
    pub(super) albedo: f64,
    pub(super) background: f64,
    /// The part of the light that a shadow on the background takes away at the limb; it fades over some pixels.
    pub(super) shadow: f64,
    /// Pixels beside the limbs that a hard shadow covers, which takes a quarter of the light.
    pub(super) hard_shadow: f64,
    /// Whether a label of dark patches is on the surface.
    pub(super) label: bool,
    /// Image rows hidden by something dark.
    pub(super) occluded: std::ops::Range<usize>,
}

impl Scene {
    pub(super) fn new() -> Self {
        let cylinder =
            Cylinder::new(Vector3::new(0.02, -0.01, 0.6), Vector3::new(0.25, 0.95, 0.2), 0.04).unwrap();
        Self {
            camera: camera(Distortion::None),
            cylinder,
            range: [-0.07, 0.07],
            albedo: 150.0,
            background: 40.0,
            shadow: 0.0,
            hard_shadow: 0.0,
            label: false,
            occluded: 0..0,
        }
    }

    fn brightness(&self, pixel: &Vector2<f64>) -> f64 {
        let row = (pixel.y + 0.5) as usize;
        if self.occluded.contains(&row) {
            return 15.0;
        }
        let axis = &self.cylinder.axis;
        let hit = self.camera.unproject(pixel).and_then(|ray| self.cylinder.first_hit(&ray));
        let Some(p) = hit else {
            let apart = self.camera.unproject(pixel).map_or(f64::INFINITY, |ray| {
                let normal = ray.cross(&axis.direction);
                normal.dot(&axis.point).abs() / normal.norm() - self.cylinder.radius
            });
            let pixels = apart * self.camera.intrinsics().fx / axis.point.z;
            let hard = if pixels < self.hard_shadow { 0.75 } else { 1.0 };
            return self.background * hard * (1.0 - self.shadow * (1.0 - pixels / SHADOW).max(0.0));
        };
        let position = axis.position_of(&p);
        if !(self.range[0]..=self.range[1]).contains(&position) {
            return self.background;
        }
        let normal = (p - axis.nearest_to(&p)).normalize();
        let light = Vector3::new(-0.4, -0.3, -1.0).normalize();
        let angle = normal.dot(&axis.direction.cross(&Vector3::z())).atan2(-normal.z);
        let patch = ((position / 0.012).floor() + (angle / 0.35).floor()).rem_euclid(3.0) < 1.0;
        let paint = if self.label && patch { 0.4 } else { 1.0 };
        self.albedo * paint * (0.35 + 0.65 * normal.dot(&light).max(0.0))
    }

    /// The image with blur, noise of 1.5 and 8 bits.
    pub(super) fn render(&self) -> GreyImage {
        let (width, height) = (SIZE.0 * SAMPLES, SIZE.1 * SAMPLES);
        let pixel_of = |k: usize| (k as f64 + 0.5) / SAMPLES as f64 - 0.5;
        let mut fine: Vec<f64> = (0..width * height)
            .map(|k| self.brightness(&Vector2::new(pixel_of(k % width), pixel_of(k / width))))
            .collect();
        // The mean over the samples of a pixel is part of the blur.
        let own = (1.0 - 1.0 / (SAMPLES * SAMPLES) as f64) / 12.0;
        let sigma = (BLUR * BLUR - own).sqrt() * SAMPLES as f64;
        let taps: Vec<f64> = (-9..=9).map(|k| (-0.5 * (f64::from(k) / sigma).powi(2)).exp()).collect();
        let sum: f64 = taps.iter().sum();
        for (count, stride) in [(width, 1), (height, width)] {
            let source = fine.clone();
            for (k, out) in fine.iter_mut().enumerate() {
                let at = (k / stride % count) as i64;
                let value = |d: i64| {
                    let to = (at + d).clamp(0, count as i64 - 1);
                    source[(k as i64 + (to - at) * stride as i64) as usize]
                };
                *out = (-9_i64..=9).zip(&taps).map(|(d, tap)| tap * value(d)).sum::<f64>() / sum;
            }
        }
        let mut state = 1_u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let bytes: Vec<u8> = (0..SIZE.0 * SIZE.1)
            .map(|k| {
                let (x, y) = (k % SIZE.0 * SAMPLES, k / SIZE.0 * SAMPLES);
                let cells = (0..SAMPLES * SAMPLES).map(|c| (x + c % SAMPLES, y + c / SAMPLES));
                let mean = cells.map(|(x, y)| fine[y * width + x]).sum::<f64>() / (SAMPLES * SAMPLES) as f64;
                // Four uniform numbers are nearly Gaussian, with variance 1/3.
                let noise = ((0..4).map(|_| uniform()).sum::<f64>() - 2.0) * 3.0_f64.sqrt() * 1.5;
                (mean + noise).round().clamp(0.0, 255.0) as u8
            })
            .collect();
        GreyImage::copy(&ImageView::from_u8(&bytes, SIZE).unwrap()).unwrap()
    }

    /// The cylinder as a rough fit has it: limbs off by about a pixel, and 1.5 with the radius.
    pub(super) fn rough(&self) -> Cylinder {
        let Cylinder { axis, radius } = self.cylinder;
        let point = axis.point + Vector3::new(0.001, 0.0005, 0.004);
        Cylinder::new(point, axis.direction + Vector3::new(0.008, 0.0, 0.03), radius * 1.05).unwrap()
    }

    pub(super) fn search(&self) -> LimbSearch {
        LimbSearch {
            ranges: [self.range; 2],
            reach: [4.0; 2],
            deviation: [1.5; 2],
            covered: [false; 2],
            noise: noise(),
        }
    }

    pub(super) fn locate(&self) -> [LimbObservation; 2] {
        located(&self.render(), &self.camera, &self.rough(), &self.search()).limbs
    }

    /// The distance of the true limb from a located line at both ends of the range, and its standard deviation
    /// there.
    pub(super) fn errors(&self, limb: usize, line: &LimbLine) -> [(f64, f64); 2] {
        let along = line.ends[1] - line.ends[0];
        let length = along.norm();
        let start = self.cylinder.axis.point.dot(&self.cylinder.axis.direction);
        let truth = LimbFrame::new(&self.cylinder).unwrap().limb_lines()[limb];
        let middle = (line.ends[0] + line.ends[1]) / 2.0;
        self.range.map(|position| {
            let q = self.camera.ideal_pixel(&truth.at(start + position)).unwrap();
            let s = (q - middle).dot(&along) / length;
            let covariance = line.covariance();
            let deviation = (covariance[(0, 0)] + covariance[(1, 1)] * s * s).sqrt();
            (along.perp(&(q - middle)) / length, deviation)
        })
    }

    /// Checks that both limbs are found within a bound, and consistently with their covariance.
    pub(super) fn check(&self, bound: f64) -> [LimbObservation; 2] {
        let observations = self.locate();
        for (k, observation) in observations.iter().enumerate() {
            let line = observation.line.unwrap_or_else(|reason| panic!("limb {k}: {reason:?}"));
            for (error, deviation) in self.errors(k, &line) {
                assert!(error.abs() < bound, "limb {k}: {error} +- {deviation}, {observations:?}");
                assert!(error.abs() < 4.0 * deviation, "limb {k}: {error} +- {deviation}");
            }
        }
        observations
    }
}

pub(super) fn camera(distortion: Distortion) -> Camera {
    let (width, height) = (SIZE.0 as u32, SIZE.1 as u32);
    let intrinsics = Intrinsics { width, height, fx: 420.0, fy: 415.0, cx: 118.0, cy: 91.0, distortion };
    Camera::new(intrinsics).unwrap()
}
