//! A box before a leaning wall, seen by a colour camera and a coarser depth camera beside it.

mod frames;
mod pushed;

use super::*;
use crate::camera::{Camera, Distortion, Intrinsics};
use crate::geometry::{RigidMotion, exp_so3};
use nalgebra::{Vector2, Vector3};

const COLOR_SIZE: (usize, usize) = (200, 150);

fn camera((width, height): (usize, usize), f: f64, distortion: Distortion) -> Camera {
    let (cx, cy) = (width as f64 / 2.0 - 0.5, height as f64 / 2.0 - 0.5);
    let (width, height) = (width as u32, height as u32);
    Camera::new(Intrinsics { width, height, fx: f, fy: f, cx, cy, distortion }).unwrap()
}

fn color_camera() -> Camera {
    camera(COLOR_SIZE, 180.0, Distortion::BrownConrady([-0.1, 0.02, 1e-3, -5e-4, 0.0, 0.0, 0.0, 0.0]))
}

/// A third as many pixels in each direction.
fn depth_camera() -> DepthCamera {
    let camera =
        camera((80, 60), 65.0, Distortion::BrownConrady([0.08, -0.02, -1e-3, 4e-4, 0.0, 0.0, 0.0, 0.0]));
    let rotation = exp_so3(&Vector3::new(0.02, -0.03, 0.04));
    DepthCamera { camera, to_color: RigidMotion::new(rotation, Vector3::new(0.05, -0.01, 0.02)).unwrap() }
}

/// The corners of the box, low and high.
const BOX: [[f64; 3]; 2] = [[-0.12, -0.1, 0.7], [0.1, 0.08, 0.8]];

/// How far along a ray the scene is, in its lengths.
fn distance(from: &Vector3<f64>, ray: &Vector3<f64>) -> f64 {
    // x / 4 + z = 1.2
    let wall = (1.2 - from.x / 4.0 - from.z) / (ray.x / 4.0 + ray.z);
    let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
    for axis in 0..3 {
        let to = |side: usize| (BOX[side][axis] - from[axis]) / ray[axis];
        enter = enter.max(to(0).min(to(1)));
        leave = leave.min(to(0).max(to(1)));
    }
    if enter < leave { enter.min(wall) } else { wall }
}

fn on_box(point: &Vector3<f64>) -> bool {
    (0..3).all(|axis| (BOX[0][axis] - 1e-6..=BOX[1][axis] + 1e-6).contains(&point[axis]))
}

/// What a camera sees at a position in its image, in the colour frame.
fn seen(camera: &Camera, to_color: &RigidMotion, pixel: &Vector2<f64>) -> Vector3<f64> {
    let ray = to_color.direction(&camera.unproject(pixel).unwrap());
    let from = *to_color.translation();
    from + ray * distance(&from, &ray)
}

/// The depth image of a camera.
fn depths(camera: &Camera, to_color: &RigidMotion) -> Vec<f32> {
    let (width, height) = camera.size();
    let pixels = (0..width * height).map(|k| Vector2::new((k % width) as f64, (k / width) as f64));
    pixels.map(|pixel| to_color.inverse().point(&seen(camera, to_color, &pixel)).z as f32).collect()
}

/// The scene with the depth of the depth camera.
fn frame() -> Frame {
    let own = depth_camera();
    let depths = depths(&own.camera, &own.to_color);
    let size = own.camera.size();
    let mut frame = Frame::new(color_camera());
    frame.set_depth_camera(Some(own)).unwrap();
    frame.set_depth(&DepthView::from_f32(&depths, size, 1.0).unwrap(), &DepthRange::default()).unwrap();
    frame
}

/// The pixels of the colour image around which, up to `margin` pixels away, there is nothing but the box.
fn box_mask(margin: isize) -> Mask {
    let camera = color_camera();
    let (width, height) = (COLOR_SIZE.0 as isize, COLOR_SIZE.1 as isize);
    let mut pixels = vec![0; COLOR_SIZE.0 * COLOR_SIZE.1];
    for row in 0..height {
        for column in 0..width {
            let here = |dx: isize, dy: isize| {
                let pixel = Vector2::new((column + dx) as f64, (row + dy) as f64);
                on_box(&seen(&camera, &RigidMotion::identity(), &pixel))
            };
            let all = (-margin..=margin).all(|dx| (-margin..=margin).all(|dy| here(dx, dy)));
            pixels[(row * width + column) as usize] = u8::from(all);
        }
    }
    Mask::copy(&MaskView::from_u8(&pixels, COLOR_SIZE).unwrap()).unwrap()
}

#[test]
fn a_position_is_in_the_pixel_whose_middle_is_nearest() {
    let at = |x: f64, y: f64| pixel_at(&Vector2::new(x, y));
    assert_eq!(at(-0.4, 1.49), Some((0, 1)));
    assert_eq!(at(2.5, 0.0), Some((3, 0)));
    assert_eq!([at(-0.5, 1.0), at(1.0, -3.0), at(f64::NAN, 1.0)], [None; 3]);
}
