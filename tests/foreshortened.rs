//! Cylinders whose axis leads away from the camera: a cap covers most of the object, and the limbs are short.
#![allow(clippy::unwrap_used, reason = "a test program")]

mod support;

use cylfuse::fitter::{FitResult, Fitter, Flags};
use cylfuse::geometry::Cylinder;
use cylfuse::observations::{DepthRange, DepthView, ImageView, MaskView};
use nalgebra::{Vector2, Vector3};
use support::{Noise, SIZE, camera, intrinsics};

/// Depth of the wall behind.
const WALL: f64 = 1.3;

/// Standard deviation of a depth.
const DEPTH_NOISE: f64 = 0.0005;

/// How bright the wall is, and how much brighter a cap.
const GREY: f64 = 60.0;
const BRIGHTER: f64 = 40.0;

#[derive(Clone, Copy, PartialEq)]
enum Part {
    Wall,
    Cap,
    Body,
}

/// A closed cylinder about the point of its axis.
struct Scene {
    cylinder: Cylinder,
    half_length: f64,
}

impl Scene {
    /// An axis that leads away from the camera, by so many degrees from where the image plane is.
    fn tilted(degrees: f64, radius: f64, half_length: f64) -> Self {
        let tilt = degrees.to_radians();
        let point = Vector3::new(0.04, 0.03, 0.8);
        let sight = point.normalize();
        let across = sight.cross(&Vector3::new(0.1, 1.0, 0.0)).normalize();
        let axis = across * tilt.cos() + sight * tilt.sin();
        Self { cylinder: Cylinder::new(point, axis, radius).unwrap(), half_length }
    }

    /// What is seen at a place in the image: its depth, and its brightness where the body is lit from one side.
    fn look(&self, at: &Vector2<f64>) -> (Part, f64, f64) {
        let Self { cylinder: Cylinder { axis, .. }, half_length } = self;
        let ray = camera().unproject(at).unwrap();
        let wall = (Part::Wall, WALL, GREY);
        let Some((near, _)) = self.cylinder.intersect_ray(&ray) else { return wall };
        let hit = ray * near;
        if axis.position_of(&hit).abs() <= *half_length {
            let normal = (hit - axis.nearest_to(&hit)) / self.cylinder.radius;
            let lamp = axis.direction.cross(&axis.point).normalize();
            return (Part::Body, hit.z, GREY + BRIGHTER / 2.0 * (1.0 + normal.dot(&lamp)));
        }
        let front = axis.at(-half_length);
        let cap = ray * (front.dot(&axis.direction) / ray.dot(&axis.direction));
        match (cap - front).norm() <= self.cylinder.radius {
            true => (Part::Cap, cap.z, GREY + BRIGHTER),
            false => wall,
        }
    }

    fn pixels<T>(&self, mut value: impl FnMut(Part, f64, f64) -> T) -> Vec<T> {
        let place = |k: usize| Vector2::new((k % SIZE.0) as f64, (k / SIZE.0) as f64);
        (0..SIZE.0 * SIZE.1)
            .map(|k| {
                let (part, depth, grey) = self.look(&place(k));
                value(part, depth, grey)
            })
            .collect()
    }

    /// The image: means of sixteen places a pixel, with noise.
    fn image(&self) -> Vec<u8> {
        let mut noise = Noise::new(7);
        let pixel = |k: usize| {
            let (x, y) = ((k % SIZE.0) as f64, (k / SIZE.0) as f64);
            let place = |n: u32| Vector2::new(f64::from(n % 4), f64::from(n / 4)) / 4.0;
            let shift = Vector2::new(x - 0.375, y - 0.375);
            let sum: f64 = (0..16).map(|n| self.look(&(shift + place(n))).2).sum();
            (sum / 16.0 + noise.normal()).round() as u8
        };
        (0..SIZE.0 * SIZE.1).map(pixel).collect()
    }

    /// The fit within the right mask of some parts, where a part of the depths are outliers all over the range.
    fn fit(&self, wanted: impl Fn(Part) -> bool, outliers: f64, image: Option<&[u8]>) -> FitResult {
        let mut noise = Noise::new(3);
        let mask = self.pixels(|part, _, _| u8::from(wanted(part)));
        let depth = self.pixels(|_, depth, _| {
            let [outlying, far] = [noise.uniform(), noise.uniform()];
            let off = if outlying < outliers { 0.6 * (far - 0.5) } else { DEPTH_NOISE * noise.normal() };
            (depth + off) as f32
        });
        let mut fitter = Fitter::new();
        fitter.set_intrinsics(intrinsics()).unwrap();
        let depth = DepthView::from_f32(&depth, SIZE, 1.0).unwrap();
        let mask = MaskView::from_u8(&mask, SIZE).unwrap();
        fitter.push_depth(&depth, Some(&mask), &DepthRange::default()).unwrap();
        if let Some(image) = image {
            fitter.push_image(&ImageView::from_u8(image, SIZE).unwrap()).unwrap();
        }
        fitter.fit().unwrap()
    }
}

/// The way from a limb to the axis crosses the cap, which is not in such a mask.
#[test]
fn a_right_mask_of_the_body_does_not_disagree() {
    for degrees in [60.0, 75.0, 80.0] {
        let scene = Scene::tilted(degrees, 0.045, 0.08);
        let result = scene.fit(|part| part == Part::Body, 0.0, None);
        assert!(scene.cylinder.compare(&result.cylinder).radius_relative.abs() < 0.05, "{degrees}");
        assert!(!result.flags.contains(Flags::MASK_DISAGREES), "{degrees}");
    }
}

/// Outlying depths passed for another body.
#[test]
fn outliers_all_over_the_depth_are_no_other_body() {
    for degrees in [0.0, 60.0] {
        let scene = Scene::tilted(degrees, 0.04, 0.1);
        let result = scene.fit(|part| part != Part::Wall, 0.2, None);
        assert!(scene.cylinder.compare(&result.cylinder).radius_relative.abs() < 0.05, "{degrees}");
        assert!(!result.flags.contains(Flags::MASK_DISAGREES), "{degrees}");
    }
}

/// The rim of the bright cap was located in place of a limb that the image hardly shows.
#[test]
fn a_rim_is_not_taken_for_a_limb() {
    let (point, axis) = (Vector3::new(0.0413, 0.0304, 0.8387), Vector3::new(0.2185, 0.0156, 0.9757));
    let scene = Scene { cylinder: Cylinder::new(point, axis, 0.046).unwrap(), half_length: 0.1 };
    let result = scene.fit(|part| part == Part::Body, 0.0, Some(&scene.image()));
    let error = scene.cylinder.compare(&result.cylinder).radius_relative.abs();
    assert!(error < 0.01, "{error}");
    assert!(!result.flags.contains(Flags::POINTS_AND_LIMBS_DISAGREE), "{:?}", result.flags);
}
