//! Many cylinders in one image.
#![allow(clippy::unwrap_used, reason = "a test program")]

mod support;

use cylfuse::camera::{Camera, Distortion, Intrinsics};
use cylfuse::geometry::Cylinder;
use cylfuse::observations::{DepthRange, DepthView, Frame, ImageView};
use cylfuse::scene::Detector;
use nalgebra::{Vector2, Vector3};
use support::Noise;

const SIZE: (usize, usize) = (1280, 720);

/// Half the length of each.
const HALF_LENGTH: f64 = 0.095;

/// Depth of the wall behind.
const WALL: f64 = 1.8;

fn camera() -> Camera {
    let (width, height) = (SIZE.0 as u32, SIZE.1 as u32);
    let distortion = Distortion::None;
    Camera::new(Intrinsics { width, height, fx: 910.0, fy: 910.0, cx: 639.5, cy: 359.5, distortion }).unwrap()
}

/// Ten by five short pipes that stand before the wall, nearly upright.
fn pipes(noise: &mut Noise) -> Vec<Cylinder> {
    let mut pipe = |k: usize| {
        let [column, row] = [k % 10, k / 10].map(|number| number as f64);
        let middle = Vector3::new(0.17 * (column - 4.5), 0.23 * (row - 2.0), 1.6);
        let direction = Vector3::new(0.18 * noise.normal(), 1.0, 0.18 * noise.normal());
        Cylinder::new(middle, direction, 0.021 + 0.00042 * (k * 17 % 50) as f64).unwrap()
    };
    (0..50).map(&mut pipe).collect()
}

/// Depth and grey value of a ray, by the first pipe that it meets between its ends.
fn look(pipes: &[Cylinder], ray: &Vector3<f64>) -> (f64, f64) {
    let seen = |pipe: &Cylinder| {
        let point = ray * pipe.intersect_ray(ray)?.0;
        let offset = point - pipe.axis.point;
        let along = offset.dot(&pipe.axis.direction);
        let normal = (offset - pipe.axis.direction * along) / pipe.radius;
        let light = normal.dot(&Vector3::new(0.3, -0.4, -0.87)).max(0.0);
        (along.abs() <= HALF_LENGTH).then_some((point.z, 70.0 + 60.0 * light))
    };
    pipes.iter().filter_map(seen).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((WALL, 110.0))
}

/// The search works with cells of several pixels and finds such pipes up to a quarter too narrow. Of so many each gets one fit, and
/// where that was right the cylinder of the search was kept all the same, as the two were too far apart.
#[test]
fn a_radius_that_points_and_limbs_tell_alike_is_believed() {
    let (camera, mut noise) = (camera(), Noise::new(1));
    let pipes = pipes(&mut noise);
    let (mut depth, mut image) = (Vec::new(), Vec::new());
    for k in 0..SIZE.0 * SIZE.1 {
        let at = |dx: f64, dy: f64| {
            let pixel = Vector2::new((k % SIZE.0) as f64 + dx, (k / SIZE.0) as f64 + dy);
            look(&pipes, &camera.unproject(&pixel).unwrap())
        };
        depth.push((at(0.0, 0.0).0 + 0.0003 * noise.normal()) as f32);
        let light: f64 = [-0.25, 0.25].iter().flat_map(|x| [-0.25, 0.25].map(|y| at(*x, y).1)).sum();
        image.push((0.25 * light + noise.normal()).round() as u8);
    }
    let mut frame = Frame::new(camera);
    frame.set_depth(&DepthView::from_f32(&depth, SIZE, 1.0).unwrap(), &DepthRange::default()).unwrap();
    frame.set_image(&ImageView::from_u8(&image, SIZE).unwrap()).unwrap();
    let found = Detector::new().detect(&frame).unwrap();
    let is_right = |pipe: &&Cylinder| {
        let change = found.cylinders.iter().map(|found| pipe.compare(&found.result.cylinder));
        let near = |axis: f64, radius: f64| axis < 0.1 * pipe.radius && radius.abs() < 0.02;
        change.filter(|change| near(change.axis_distance, change.radius_relative)).count() == 1
    };
    let right = pipes.iter().filter(is_right).count();
    // Two have faint limbs: one is kept as the search found it and says so, the other is 2.2 % too narrow.
    assert!(right >= 48, "{right}");
    assert_eq!(found.cylinders.len(), pipes.len());
}
