//! Many cylinders in one image, and those that touch and hide each other.
#![allow(clippy::unwrap_used, reason = "a test program")]

mod support;

use cylfuse::camera::{Camera, Distortion, Intrinsics};
use cylfuse::fitter::Fitter;
use cylfuse::geometry::Cylinder;
use cylfuse::observations::{DepthRange, DepthView, Frame, ImageView, MaskView};
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

/// Three rods that touch lie on a table, of which the camera looks down at the middle one over the nearest, which hides half of its
/// width. The depth is that of matching windows of 5 pixels: in the groove it is that of both rods.
#[test]
fn depth_beside_what_hides_a_part_of_a_rod_does_not_widen_it() {
    const RADIUS: f64 = 0.011;
    const WINDOW: usize = 5;
    // Disparity in pixels of a point at the distance 1, and its noise before matching windows average it.
    const DISPARITY: f64 = 42.75;
    const NOISE: f64 = 0.25;
    const STEP: f64 = 2.6;
    let (width, height) = (640, 480);
    let distortion = Distortion::None;
    let camera =
        Camera::new(Intrinsics { width, height, fx: 570.0, fy: 570.0, cx: 319.5, cy: 239.5, distortion });
    let camera = camera.unwrap();
    let (width, height) = (width as usize, height as usize);
    let (sine, cosine) = 30.0_f64.to_radians().sin_cos();
    for turned in [false, true] {
        // The camera lies on its side.
        let turn = |v: Vector3<f64>| if turned { Vector3::new(-v.y, v.x, v.z) } else { v };
        let up = turn(Vector3::new(0.0, -cosine, -sine));
        let away = turn(Vector3::new(0.0, -sine, cosine));
        let (along, middle) = (turn(Vector3::x()), Vector3::new(0.0, 0.0, 0.62));
        let rod = |k: f64| Cylinder::new(middle + away * (2.0 * k * RADIUS), along, RADIUS).unwrap();
        let rods = [-1.0, 0.0, 1.0].map(rod);
        let table = (middle - up * RADIUS).dot(&up);
        // The depth, and which rod is seen.
        let look = |k: usize| {
            let ray = camera.unproject(&Vector2::new((k % width) as f64, (k / width) as f64)).unwrap();
            let hit = |k: usize| {
                Some(rods[k].first_hit(&ray)?)
                    .filter(|point| point.dot(&along).abs() < 14.0 * RADIUS)
                    .map(|point| (point.z, Some(k)))
            };
            (0..3).filter_map(hit).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((table / ray.dot(&up), None))
        };
        let seen: Vec<(f64, Option<usize>)> = (0..width * height).map(look).collect();
        let mask: Vec<u8> = seen.iter().map(|(_, rod)| u8::from(*rod == Some(1))).collect();
        for seed in 0..4 {
            let mut noise = Noise::new(seed);
            let disparities: Vec<f64> =
                seen.iter().map(|(depth, _)| DISPARITY / depth + NOISE * noise.normal()).collect();
            let half = WINDOW / 2;
            let matched = |k: usize| {
                let (column, row) = (k % width, k / width);
                let columns = column.saturating_sub(half)..(column + half + 1).min(width);
                let rows = row.saturating_sub(half)..(row + half + 1).min(height);
                // Beyond a larger step another surface is matched.
                let here = DISPARITY / seen[k].0;
                let all = rows.flat_map(|row| columns.clone().map(move |column| row * width + column));
                let of_surface: Vec<f64> = all
                    .filter(|&k| (DISPARITY / seen[k].0 - here).abs() < STEP)
                    .map(|k| disparities[k])
                    .collect();
                (DISPARITY * of_surface.len() as f64 / of_surface.iter().sum::<f64>()) as f32
            };
            let depth: Vec<f32> = (0..width * height).map(matched).collect();
            let mut fitter = Fitter::new();
            fitter.set_intrinsics(*camera.intrinsics()).unwrap();
            let mask = MaskView::from_u8(&mask, (width, height)).unwrap();
            let depth = DepthView::from_f32(&depth, (width, height), 1.0).unwrap();
            fitter.push_depth(&depth, Some(&mask), &DepthRange::default()).unwrap();
            let change = rods[1].compare(&fitter.fit().unwrap().cylinder);
            // Where that depth counts, the rod comes out three times as wide.
            assert!(change.radius_relative.abs() < 0.35, "{change:?}");
        }
    }
}
