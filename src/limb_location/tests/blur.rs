//! Images that are blurred, of what moved, enlarged or reduced.

use super::super::*;
use super::located;
use super::scene::{BLUR, SIZE, Scene};
use crate::camera::Intrinsics;
use crate::noise::NoiseModel;
use crate::observations::{GreyImage, ImageView};
use std::ops::ControlFlow;

/// An image on a grid that is finer by some factor, interpolated bilinearly.
fn enlarged(image: &GreyImage, factor: usize) -> GreyImage {
    let size = (image.width() * factor, image.height() * factor);
    let beside = |index: usize, count: usize| {
        let at = ((index as f64 + 0.5) / factor as f64 - 0.5).clamp(0.0, (count - 1) as f64);
        let first = (at as usize).min(count - 2);
        (first, (at - first as f64) as f32)
    };
    let value = |k: usize| {
        let (column, right) = beside(k % size.0, image.width());
        let (row, down) = beside(k / size.0, image.height());
        let along = |row| image.value(column, row) * (1.0 - right) + image.value(column + 1, row) * right;
        along(row) * (1.0 - down) + along(row + 1) * down
    };
    let values: Vec<f32> = (0..size.0 * size.1).map(value).collect();
    GreyImage::copy(&ImageView::from_f32(&values, size).unwrap()).unwrap()
}

#[test]
fn what_is_blurred_is_located_as_on_a_coarser_grid() {
    const FACTOR: usize = 3;
    let ratio = FACTOR as f64;
    let scene = Scene { background: 220.0, ..Scene::new() };
    let image = enlarged(&scene.render(), FACTOR);
    let Intrinsics { fx, fy, cx, cy, distortion, .. } = *scene.camera.intrinsics();
    let scaled = |coordinate: f64| ratio * (coordinate + 0.5) - 0.5;
    let (width, height) = (image.width() as u32, image.height() as u32);
    let (fx, fy, cx, cy) = (fx * ratio, fy * ratio, scaled(cx), scaled(cy));
    let large = Scene {
        camera: Camera::new(Intrinsics { width, height, fx, fy, cx, cy, distortion }).unwrap(),
        ..Scene::new()
    };
    let noise = NoiseModel { drawn_pixel: ratio, ..NoiseModel::default() }.in_image(SIZE);
    let search = LimbSearch { reach: [4.0 * ratio; 2], deviation: [1.5 * ratio; 2], noise, ..scene.search() };
    let observations = located(&image, &large.camera, &large.rough(), &search).limbs;
    for (k, observation) in observations.iter().enumerate() {
        for (error, deviation) in large.errors(k, &observation.line.unwrap()) {
            assert!(error.abs() < 0.1 * ratio && error.abs() < 4.0 * deviation, "limb {k}: {error}");
        }
        // The interpolation adds a sixth of a squared pixel.
        let blur = observation.blur.unwrap() / ratio;
        assert!((blur - BLUR.hypot(1.0 / 6.0_f64.sqrt())).abs() < 0.15, "{blur}");
    }
}

#[test]
fn what_is_sharp_is_located_on_its_own_grid() {
    let scene = Scene { background: 220.0, ..Scene::new() };
    let drawn = NoiseModel { drawn_pixel: 3.0, edge_endpoint: 0.5 / 3.0, ..NoiseModel::default() };
    let search = LimbSearch { noise: drawn.in_image(SIZE), ..scene.search() };
    let observations = located(&scene.render(), &scene.camera, &scene.rough(), &search).limbs;
    assert_eq!(observations, scene.locate());
}

/// An image that moved evenly over some columns while it was taken.
fn moved(image: &GreyImage, columns: usize) -> GreyImage {
    let (width, height) = (image.width(), image.height());
    let value = |k: usize| {
        let beside = |d: usize| (k % width + d).saturating_sub(columns / 2).min(width - 1);
        (0..columns).map(|d| image.value(beside(d), k / width)).sum::<f32>() / columns as f32
    };
    let values: Vec<f32> = (0..width * height).map(value).collect();
    GreyImage::copy(&ImageView::from_f32(&values, (width, height)).unwrap()).unwrap()
}

#[test]
fn limbs_of_what_moved_are_located() {
    for background in [20.0, 220.0] {
        let scene = Scene { background, ..Scene::new() };
        let image = scene.render();
        for columns in [5, 7] {
            let image = moved(&image, columns);
            let search = LimbSearch { reach: [8.0; 2], deviation: [2.0; 2], ..scene.search() };
            let seen = located(&image, &scene.camera, &scene.rough(), &search);
            for (k, limb) in seen.limbs.iter().enumerate() {
                let line =
                    limb.line.unwrap_or_else(|reason| panic!("limb {k}, {columns} columns: {reason:?}"));
                for (error, deviation) in scene.errors(k, &line) {
                    let is_right = error.abs() < 0.1 * columns as f64 && error.abs() < 4.0 * deviation;
                    assert!(is_right, "limb {k}, {columns} columns: {error} +- {deviation}");
                }
            }
        }
    }
}

#[test]
fn the_search_may_end_before_each_grid() {
    let scene = Scene { background: 220.0, ..Scene::new() };
    let image = moved(&scene.render(), 7);
    let asked = |end: usize| {
        let mut asked = 0;
        let seen = locate_limbs(&image, &scene.camera, &scene.rough(), &scene.search(), &mut || {
            asked += 1;
            if asked == end { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        (asked, seen.is_break())
    };
    let (grids, _) = asked(usize::MAX);
    assert!(grids > 1);
    for end in 1..=grids {
        assert_eq!(asked(end), (end, true));
    }
}

#[test]
fn what_rests_is_not_looked_at_as_what_moved() {
    let scene = Scene { background: 220.0, ..Scene::new() };
    let image = scene.render();
    let last = located(&moved(&image, 5), &scene.camera, &scene.rough(), &scene.search());
    let last = last.appearance.unwrap();
    let again = locate_limbs_again(&image, &scene.camera, &scene.cylinder, &scene.search(), &last, false);
    assert!(again.is_none());
}
