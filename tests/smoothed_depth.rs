//! Depth that filters smoothed, as many cameras deliver it: beside its limbs a body goes on into what lies behind it. And depth of
//! networks, whose errors wander slowly over the image.
#![allow(clippy::unwrap_used, reason = "a test program")]

#[path = "support/frames.rs"]
mod frames;
mod support;

use cylfuse::camera::{Camera, Distortion, Intrinsics};
use cylfuse::extent::EndSource;
use cylfuse::fitter::Fitter;
use cylfuse::geometry::{Cylinder, RigidMotion};
use cylfuse::observations::{DepthCamera, DepthRange, DepthView, Frame, ImageView, MaskView};
use cylfuse::scene::{Detector, DetectorOptions};
use nalgebra::{Vector2, Vector3};
use std::path::Path;
use support::Noise;

/// A camera whose principal point is the middle of its image.
fn centred((width, height): (u32, u32), focal: f64) -> Intrinsics {
    let [cx, cy] = [width, height].map(|size| f64::from(size - 1) / 2.0);
    Intrinsics { width, height, fx: focal, fy: focal, cx, cy, distortion: Distortion::None }
}

/// Where nothing was measured the depth to the left, then the averages of 1/z over square windows.
fn smoothed(depth: &[u16], (width, height): (usize, usize), window: usize) -> Vec<u16> {
    let half = window / 2;
    let mut last = depth.iter().copied().find(|z| *z > 0).unwrap();
    let mut inverse = Vec::with_capacity(depth.len());
    for z in depth {
        last = if *z > 0 { *z } else { last };
        inverse.push(1.0 / f64::from(last));
    }
    let average = |x: usize, y: usize| {
        let columns = x.saturating_sub(half)..(x + half + 1).min(width);
        let rows = y.saturating_sub(half)..(y + half + 1).min(height);
        let count = rows.len() * columns.len();
        let row = |y: usize| &inverse[y * width..][columns.clone()];
        (count as f64 / rows.flat_map(row).sum::<f64>()).round() as u16
    };
    (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| average(x, y)).collect()
}

#[test]
fn bodies_whose_limbs_are_smoothed_are_found() {
    let inputs = frames::Inputs::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/scene"));
    let radii = |depth: &[u16], use_image: bool| {
        let mut frame = Frame::new(Camera::new(inputs.intrinsics).unwrap());
        let depth = DepthView::from_u16(depth, inputs.size, inputs.depth_scale).unwrap();
        frame.set_depth(&depth, &DepthRange::default()).unwrap();
        frame.set_image(&ImageView::from_u8(&inputs.image, inputs.size).unwrap()).unwrap();
        let mut detector = Detector::new();
        detector.set_options(DetectorOptions { use_image, ..DetectorOptions::default() }).unwrap();
        let scene = detector.detect(&frame).unwrap();
        let radii = scene.cylinders.iter().map(|found| found.result.cylinder.radius);
        radii.collect::<Vec<f64>>()
    };
    assert_eq!(radii(&inputs.depth, true).len(), 5);
    // Four were found before.
    for (window, use_image) in [(7, false), (11, true)] {
        let found = radii(&smoothed(&inputs.depth, inputs.size, window), use_image);
        assert_eq!(found.len(), 5, "window of {window}, image: {use_image}: {found:.4?}");
    }
}

/// A pipe before a wall. The disparity is off by 0.2 pixels, from one place to another 30 pixels away, and hardly from pixel to pixel.
/// Each wave was a surface of its own: the pipe was found in pieces, or not at all.
#[test]
fn a_pipe_is_found_whole_in_depth_whose_errors_wander() {
    const DISPARITY: f64 = 68.4; // At the distance 1.
    const WANDERS: f64 = 0.2;
    const WAVES: usize = 40;
    const LENGTH: f64 = 1.1;
    let camera = Camera::new(centred((640, 480), 570.0)).unwrap();
    let pipe = Cylinder::new(Vector3::new(0.0, 0.0, 1.3), Vector3::x(), 0.035).unwrap();
    let size = camera.size();
    for seed in 0..6 {
        let mut noise = Noise::new(seed);
        // Of waves in all directions the sum has the variance 1, and its correlation falls off over some 30 pixels.
        let waves: Vec<[f64; 3]> = (0..WAVES)
            .map(|_| [0.035 * noise.normal(), 0.035 * noise.normal(), 10.0 * noise.normal()])
            .collect();
        let depth_at = |k: usize| {
            let at = Vector2::new((k % size.0) as f64, (k / size.0) as f64);
            let ray = camera.unproject(&at).unwrap();
            let hit = pipe.first_hit(&ray).filter(|point| point.x.abs() < LENGTH / 2.0);
            let depth = hit.map_or(1.6, |point| point.z);
            let wave: f64 = waves.iter().map(|[u, v, phase]| (u * at.x + v * at.y + phase).cos()).sum();
            let error = WANDERS * wave * (2.0 / WAVES as f64).sqrt() + 0.02 * noise.normal();
            (DISPARITY / (DISPARITY / depth + error)) as f32
        };
        let depth: Vec<f32> = (0..size.0 * size.1).map(depth_at).collect();
        let mut frame = Frame::new(camera.clone());
        frame.set_depth(&DepthView::from_f32(&depth, size, 1.0).unwrap(), &DepthRange::default()).unwrap();
        let scene = Detector::new().detect(&frame).unwrap();
        let [found] = &scene.cylinders[..] else {
            panic!("{} found with seed {seed}", scene.cylinders.len())
        };
        let length = found.extent.as_ref().unwrap().length;
        assert!((length / LENGTH - 1.0).abs() < 0.05, "{length} with seed {seed}");
    }
}

/// A shaft before a wall in a close-up of 1280 columns. A depth camera of 640 columns smears its ends over a deviation of 1.5 of its
/// pixels. The ends were taken where the depth begins to leave the surface, 9 pixels inside, for a standard deviation of two.
#[test]
fn ends_are_not_where_smeared_depth_begins_to_leave_the_surface() {
    const DEVIATION: f64 = 3.0;
    const REACH: i32 = 12;
    const LENGTH: f64 = 0.1;
    let intrinsics = centred((1280, 960), 1400.0);
    let camera = Camera::new(intrinsics).unwrap();
    let shaft = Cylinder::new(Vector3::new(0.0, 0.0, 0.3), Vector3::x(), 0.02).unwrap();
    let size = camera.size();
    let mut noise = Noise::new(1);
    let hits = |k: usize| {
        let ray = camera.unproject(&Vector2::new((k % size.0) as f64, (k / size.0) as f64)).unwrap();
        shaft.first_hit(&ray).filter(|point| point.x.abs() < LENGTH / 2.0)
    };
    let sharp: Vec<Option<f64>> = (0..size.0 * size.1).map(|k| hits(k).map(|point| point.z)).collect();
    let mask: Vec<u8> = sharp.iter().map(|depth| u8::from(depth.is_some())).collect();
    // Along the rows: the limbs are not what is looked at here.
    let weights: Vec<f64> =
        (-REACH..=REACH).map(|k| (-0.5 * (f64::from(k) / DEVIATION).powi(2)).exp()).collect();
    let smeared = |k: usize| {
        let (column, row) = ((k % size.0) as i32, k / size.0);
        let at =
            |k: i32| sharp[row * size.0 + (column + k).clamp(0, size.0 as i32 - 1) as usize].unwrap_or(0.5);
        let sum: f64 = (-REACH..=REACH).zip(&weights).map(|(k, weight)| weight * at(k)).sum();
        (sum / weights.iter().sum::<f64>() + 1e-4 * noise.normal()) as f32
    };
    let depth: Vec<f32> = (0..sharp.len()).map(smeared).collect();
    let depth = DepthView::from_f32(&depth, size, 1.0).unwrap();

    let mut fitter = Fitter::new();
    fitter.set_intrinsics(intrinsics).unwrap();
    let mask = MaskView::from_u8(&mask, size).unwrap();
    fitter.push_depth(&depth, Some(&mask), &DepthRange::default()).unwrap();
    fitter.fit().unwrap();
    let of_mask = fitter.extent(None, None).unwrap();
    assert!((of_mask.length - LENGTH).abs() < 2e-4, "{}", of_mask.length);

    let mut frame = Frame::new(camera);
    frame.set_depth(&depth, &DepthRange::default()).unwrap();
    let scene = Detector::new().detect(&frame).unwrap();
    let [found] = &scene.cylinders[..] else { panic!("{} found", scene.cylinders.len()) };
    let found = found.extent.as_ref().unwrap();
    let deviation = found.start_deviation.unwrap().hypot(found.end_deviation.unwrap());
    let off = (found.length - LENGTH).abs() / deviation;
    assert!(off < 3.0, "{} of {LENGTH}, {off} deviations", found.length);
}

/// The length of the pipes below, and the distance of the wall behind them.
const LENGTH: f64 = 0.4;
const WALL: f64 = 1.4;

/// The depth that a pipe before a wall has at a position of an image.
fn depth_at(camera: &Camera, pipe: &Cylinder, column: f64, row: f64) -> f64 {
    let ray = camera.unproject(&Vector2::new(column, row)).unwrap();
    let hit = pipe.first_hit(&ray).filter(|point| pipe.axis.position_of(point).abs() < LENGTH / 2.0);
    hit.map_or(WALL, |point| point.z)
}

/// Where the pixels of an image are, row by row.
fn pixels(camera: &Camera) -> impl Iterator<Item = (usize, usize)> {
    let (width, height) = camera.size();
    (0..width * height).map(move |k| (k % width, k / width))
}

/// An image of a pipe that is brighter than the wall: of each pixel by how much of it the pipe covers.
fn picture(camera: &Camera, pipe: &Cylinder) -> Vec<u8> {
    const SAMPLES: usize = 4;
    let grey = |(x, y): (usize, usize)| {
        let samples = (0..SAMPLES * SAMPLES)
            .map(|k| [k % SAMPLES, k / SAMPLES].map(|k| (k as f64 + 0.5) / SAMPLES as f64 - 0.5));
        let covered = samples.filter(|[u, v]| depth_at(camera, pipe, x as f64 + u, y as f64 + v) < WALL);
        40 + (6 * covered.count()) as u8
    };
    pixels(camera).map(grey).collect()
}

/// A pipe, and its depth as windows draw it out: each pixel of the wall has the nearest depth of those that are no more than a reach away.
fn drawn_out(reach: usize) -> Frame {
    let camera = Camera::new(centred((640, 480), 570.0)).unwrap();
    let size = camera.size();
    let pipe = Cylinder::new(Vector3::new(0.0, 0.0, 0.9), Vector3::new(0.9, 0.2, 0.1), 0.04).unwrap();
    let sharp: Vec<f64> =
        pixels(&camera).map(|(x, y)| depth_at(&camera, &pipe, x as f64, y as f64)).collect();
    let mut noise = Noise::new(2);
    let nearest = |(x, y): (usize, usize)| {
        let columns = x.saturating_sub(reach)..(x + reach + 1).min(size.0);
        let rows = y.saturating_sub(reach)..(y + reach + 1).min(size.1);
        let of_row = |row: usize| sharp[row * size.0..][columns.clone()].iter().copied();
        let own = sharp[y * size.0 + x];
        let depth = if own < WALL { own } else { rows.flat_map(of_row).fold(own, f64::min) };
        (depth + 5e-4 * noise.normal()) as f32
    };
    let depth: Vec<f32> = pixels(&camera).map(nearest).collect();
    let image = picture(&camera, &pipe);
    let mut frame = Frame::new(camera);
    frame.set_depth(&DepthView::from_f32(&depth, size, 1.0).unwrap(), &DepthRange::default()).unwrap();
    frame.set_image(&ImageView::from_u8(&image, size).unwrap()).unwrap();
    frame
}

/// The region, which has no pixels beyond the limbs, seemed to be a mask that is too small: its ends were moved outward by so much, past
/// where the image shows them.
#[test]
fn ends_that_windows_draw_out_are_those_of_the_image() {
    let scene = Detector::new().detect(&drawn_out(4)).unwrap();
    let [found] = &scene.cylinders[..] else { panic!("{} found", scene.cylinders.len()) };
    let extent = found.extent.as_ref().unwrap();
    assert!((extent.length / LENGTH - 1.0).abs() < 2e-3, "{extent:?}");
    assert_eq!([extent.start_source, extent.end_source], [EndSource::Image; 2]);
}

/// Moved to one side, depth that is drawn out to both has one of its limbs where the image shows it: that is no shift.
#[test]
fn depth_that_windows_draw_out_is_not_moved() {
    for reach in 4..=8 {
        let scene = Detector::new().detect(&drawn_out(reach)).unwrap();
        assert_eq!(scene.depth_moved, [0; 2], "{reach} pixels");
    }
}

/// A phone: its depth camera has 256 columns for the 1,280 of the image, and smears over some of its pixels. With masks that are some pixels
/// too large the smear at an end was taken for a shoulder, as those of bottles, which has no rim to look for in the image.
#[test]
fn the_smear_of_large_depth_pixels_is_no_shoulder() {
    const DEVIATION: f64 = 1.2;
    const REACH: i32 = 4;
    let camera = Camera::new(centred((1280, 960), 1120.0)).unwrap();
    let own = DepthCamera {
        camera: Camera::new(centred((256, 192), 224.0)).unwrap(),
        to_color: RigidMotion::identity(),
    };
    let pipe = Cylinder::new(Vector3::new(0.0, 0.0, 1.1), Vector3::new(0.8, 0.2, -0.4), 0.06).unwrap();
    let (width, height) = own.camera.size();
    let sharp: Vec<f64> =
        pixels(&own.camera).map(|(x, y)| depth_at(&own.camera, &pipe, x as f64, y as f64)).collect();
    let weight = |k: i32| (-0.5 * (f64::from(k) / DEVIATION).powi(2)).exp();
    let mut noise = Noise::new(3);
    let smeared = |(x, y): (usize, usize)| {
        let [mut sum, mut of_all] = [0.0; 2];
        for (v, u) in (-REACH..=REACH).flat_map(|v| (-REACH..=REACH).map(move |u| (v, u))) {
            let column = (x as i32 + u).clamp(0, width as i32 - 1) as usize;
            let row = (y as i32 + v).clamp(0, height as i32 - 1) as usize;
            sum += weight(u) * weight(v) * sharp[row * width + column];
            of_all += weight(u) * weight(v);
        }
        (sum / of_all + 5e-4 * noise.normal()) as f32
    };
    let depth: Vec<f32> = pixels(&own.camera).map(smeared).collect();
    let image = picture(&camera, &pipe);
    for grown in 0..=6 {
        // Half of the brightness or more is half of a pixel or more.
        let columns = camera.size().0;
        let set: Vec<usize> = (0..image.len()).filter(|&k| image[k] >= 88).collect();
        let mut mask = vec![0; image.len()];
        for (v, u) in (-grown..=grown).flat_map(|v| (-grown..=grown).map(move |u: i32| (v, u))) {
            if u * u + v * v <= grown * grown {
                set.iter().for_each(|&k| mask[(k as i32 + v * columns as i32 + u) as usize] = 1);
            }
        }
        let mut fitter = Fitter::new();
        fitter.set_intrinsics(*camera.intrinsics()).unwrap();
        fitter.set_depth_camera(Some(own.clone())).unwrap();
        let depth = DepthView::from_f32(&depth, (width, height), 1.0).unwrap();
        let mask = MaskView::from_u8(&mask, camera.size()).unwrap();
        fitter.push_depth(&depth, Some(&mask), &DepthRange::default()).unwrap();
        fitter.push_image(&ImageView::from_u8(&image, camera.size()).unwrap()).unwrap();
        fitter.fit().unwrap();
        let extent = fitter.extent(None, None).unwrap();
        assert!((extent.length / LENGTH - 1.0).abs() < 0.01, "{grown} pixels: {extent:?}");
    }
}
