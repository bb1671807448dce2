//! Limbs of rendered cylinders are located where they are.

mod blur;
mod scene;

use super::*;
use crate::camera::Distortion;
use crate::noise::NoiseModel;
use crate::observations::{DepthImage, DepthView, EdgeSegment, GreyImage, ImageView, Mask, MaskView};
use nalgebra::Vector3;
use scene::{BLUR, SIZE, Scene, camera};
use std::ops::ControlFlow;

fn noise() -> ImageNoise {
    NoiseModel::default().in_image((640, 480))
}

fn located(image: &GreyImage, camera: &Camera, model: &Cylinder, search: &LimbSearch) -> SeenLimbs {
    locate_limbs(image, camera, model, search, &mut || ControlFlow::Continue(())).continue_value().unwrap()
}

#[test]
fn limbs_are_located_to_a_tenth_of_a_pixel_at_either_polarity() {
    for background in [20.0, 220.0] {
        let observations = Scene { background, ..Scene::new() }.check(0.1);
        let blur = observations[0].blur.unwrap();
        assert!((blur - BLUR).abs() < 0.15, "{blur}");
        assert!(observations.iter().all(|o| o.samples.len() >= 8));
    }
}

#[test]
fn limbs_of_sixteen_rows_are_located() {
    let scene = Scene { background: 220.0, ..Scene::new() };
    let search = LimbSearch { ranges: [[-0.012, 0.012]; 2], ..scene.search() };
    let limbs = located(&scene.render(), &scene.camera, &scene.rough(), &search).limbs;
    for (k, limb) in limbs.iter().enumerate() {
        let line = limb.line.unwrap_or_else(|reason| panic!("limb {k}: {reason:?}"));
        assert_eq!(limb.samples.len(), 3);
        // The ends of the whole surface are far from what was looked at.
        let [(first, _), (last, _)] = scene.errors(k, &line);
        assert!(f64::midpoint(first, last).abs() < 0.1, "limb {k}: {first} {last}");
    }
}

#[test]
fn white_that_was_cut_off_does_not_move_the_limbs() {
    Scene { background: 600.0, ..Scene::new() }.check(0.1);
}

#[test]
fn a_shadow_that_fades_beside_the_limbs_does_not_move_them() {
    Scene { background: 220.0, shadow: 0.5, ..Scene::new() }.check(0.35);
}

#[test]
fn a_faint_shadow_does_not_move_the_limbs_either() {
    for background in [160.0, 220.0] {
        Scene { background, shadow: 0.15, ..Scene::new() }.check(0.05);
    }
}

#[test]
fn the_deviation_of_a_line_says_that_a_hard_shadow_ends_beside_it() {
    for width in [2.5, 3.0, 3.5] {
        let scene = Scene { hard_shadow: width, background: 220.0, ..Scene::new() };
        for (k, limb) in scene.locate().iter().enumerate() {
            for (error, deviation) in scene.errors(k, &limb.line.unwrap()) {
                assert!(error.abs() < 3.0 * deviation, "a shadow of {width} px: {error} +- {deviation}");
            }
        }
    }
}

#[test]
fn an_edge_softer_than_any_limb_is_none() {
    let scene = Scene { background: 150.0, albedo: 150.0, shadow: 0.7, ..Scene::new() };
    let image = scene.render();
    // Nothing but the shadow is in reach: its middle is five pixels from the limbs.
    let model = Cylinder { radius: 0.04 * 1.25, ..scene.cylinder };
    let search = LimbSearch { reach: [3.0; 2], ..scene.search() };
    for observation in located(&image, &scene.camera, &model, &search).limbs {
        assert!(observation.line.is_err(), "{observation:?}");
    }
}

#[test]
fn a_lens_does_not_bend_the_lines() {
    let lens = Distortion::brown_conrady(&[-0.25, 0.08, 0.002, -0.001]).unwrap();
    Scene { camera: camera(lens), background: 220.0, ..Scene::new() }.check(0.1);
}

#[test]
fn flat_lines_are_located_as_steep_ones() {
    let cylinder = Cylinder::new(Vector3::new(0.0, 0.01, 0.6), Vector3::new(0.95, 0.2, -0.2), 0.03).unwrap();
    Scene { cylinder, background: 220.0, ..Scene::new() }.check(0.1);
}

#[test]
fn a_label_and_an_occluder_cost_little() {
    Scene { label: true, background: 200.0, ..Scene::new() }.check(0.3);
    let observations = Scene { occluded: 80..100, ..Scene::new() }.check(0.3);
    for observation in &observations {
        let refused = observation.samples.iter().filter(|sample| sample.weight < 0.5).count();
        let hidden = observation.samples.iter().filter(|s| (84.0..96.0).contains(&s.position.y));
        assert!(hidden.clone().count() > 0 && hidden.clone().all(|s| s.weight < 0.5 || s.sigma > 0.5));
        assert!(refused < observation.samples.len() / 2);
    }
}

#[test]
fn the_image_border_may_cut_the_cylinder() {
    let scene = Scene { range: [-0.5, 0.5], background: 220.0, ..Scene::new() };
    let observations = scene.locate();
    for (k, observation) in observations.iter().enumerate() {
        let line = observation.line.unwrap();
        let truth = Scene { range: [-0.1, 0.1], ..Scene::new() };
        for (error, _) in truth.errors(k, &line) {
            assert!(error.abs() < 0.1, "{error}");
        }
    }
}

#[test]
fn what_cannot_be_seen_is_not_found() {
    let scene = Scene { albedo: 0.0, background: 0.0, ..Scene::new() };
    for observation in scene.locate() {
        assert_eq!(observation.line, Err(NotVisible::NoEdge));
    }
    let image = scene.render();
    let reasons = |model: &Cylinder, search: &LimbSearch| {
        located(&image, &scene.camera, model, search).limbs.map(|o| o.line.unwrap_err())
    };
    let around = Cylinder::new(Vector3::new(0.0, 0.1, 0.2), Vector3::x(), 1.0).unwrap();
    assert_eq!(reasons(&around, &scene.search()), [NotVisible::NoLimbs; 2]);
    let short = LimbSearch { ranges: [[0.0, 0.01]; 2], ..scene.search() };
    assert_eq!(reasons(&scene.rough(), &short), [NotVisible::TooShort; 2]);
    let outside = Cylinder::new(Vector3::new(0.9, 0.0, 0.6), Vector3::y(), 0.04).unwrap();
    assert_eq!(reasons(&outside, &scene.search()), [NotVisible::TooShort; 2]);
}

#[test]
fn one_limb_may_be_missing() {
    // The left half of the image shows nothing at all.
    let scene = Scene { background: 220.0, ..Scene::new() };
    let mut bytes: Vec<u8> = Vec::new();
    let image = scene.render();
    let axis = scene.camera.project(&scene.cylinder.axis.point).unwrap();
    for row in 0..SIZE.1 {
        bytes.extend((0..SIZE.0).map(|x| if (x as f64) < axis.x { 90 } else { image.value(x, row) as u8 }));
    }
    let image = GreyImage::copy(&ImageView::from_u8(&bytes, SIZE).unwrap()).unwrap();
    let observations = located(&image, &scene.camera, &scene.rough(), &scene.search()).limbs;
    let found: Vec<usize> = (0..2).filter(|&k| observations[k].line.is_ok()).collect();
    assert_eq!(found.len(), 1, "{observations:?}");
    for (error, _) in scene.errors(found[0], &observations[found[0]].line.unwrap()) {
        assert!(error.abs() < 0.15, "{error}");
    }
}

#[test]
fn a_mask_and_segments_say_where_to_search() {
    let scene = Scene::new();
    let axis = &scene.cylinder.axis;
    let on_surface = |x: usize, y: usize| {
        let ray = scene.camera.unproject(&Vector2::new(x as f64, y as f64)).unwrap();
        let hit = scene.cylinder.first_hit(&ray);
        hit.is_some_and(|p| axis.position_of(&p).abs() <= scene.range[1])
    };
    let bytes: Vec<u8> = (0..SIZE.0 * SIZE.1).map(|k| u8::from(on_surface(k % SIZE.0, k / SIZE.0))).collect();
    let mask = Mask::copy(&MaskView::from_u8(&bytes, SIZE).unwrap()).unwrap();

    let sides = Outline::new(&mask, None, &scene.camera, &noise())
        .unwrap()
        .sides(&scene.camera, &scene.rough())
        .unwrap();
    let limbs = [0, 1].map(|k| {
        let line = LimbLine { ends: sides[k].ends, sigma: 1.0 };
        [0, 1].map(|limb| scene.errors(limb, &line).map(|(error, _)| error.abs()))
    });
    let near = |errors: &[f64; 2]| errors.iter().all(|&error| error < 1.5);
    let order = if near(&limbs[0][0]) { [0, 1] } else { [1, 0] };
    assert!(near(&limbs[0][order[0]]) && near(&limbs[1][order[1]]), "{limbs:?}");

    let pixels = mask.set_pixels().map(|(x, y)| Vector2::new(x as f64, y as f64));
    let range = axial_range(&scene.camera, &scene.cylinder, pixels, 0.0).unwrap();
    for (found, truth) in range.iter().zip(&scene.range) {
        assert!((found - truth).abs() < 0.004, "{range:?}");
    }
    let segment =
        EdgeSegment { endpoints: [Vector2::new(80.0, 30.0), Vector2::new(110.0, 150.0)], weight: 1.0 };
    let range = axial_range(&scene.camera, &scene.cylinder, segment.endpoints.into_iter(), 0.0).unwrap();
    assert!(range[0] < -0.05 && range[1] > 0.05, "{range:?}");
    assert_eq!(axial_range(&scene.camera, &scene.cylinder, std::iter::empty(), 0.1), None);
}

/// The sides of the scene behind something, given which pixels that covers; also told is whether the surface is at a pixel.
fn sides_behind(covers: impl Fn(usize, usize, &dyn Fn(usize, usize) -> bool) -> bool) -> [Side; 2] {
    let scene = Scene::new();
    let axis = &scene.cylinder.axis;
    let hit = |x: usize, y: usize| {
        let ray = scene.camera.unproject(&Vector2::new(x as f64, y as f64)).unwrap();
        let hit = scene.cylinder.first_hit(&ray);
        hit.filter(|p| axis.position_of(p).abs() <= scene.range[1])
    };
    let in_front = |x: usize, y: usize| covers(x, y, &|x, y| hit(x, y).is_some());
    let pixels = (0..SIZE.0 * SIZE.1).map(|k| (k % SIZE.0, k / SIZE.0));
    let bytes: Vec<u8> =
        pixels.clone().map(|(x, y)| u8::from(!in_front(x, y) && hit(x, y).is_some())).collect();
    let depth = |(x, y)| if in_front(x, y) { 0.4 } else { hit(x, y).map_or(2.0, |p| p.z as f32) };
    let depths: Vec<f32> = pixels.map(depth).collect();
    let mask = Mask::copy(&MaskView::from_u8(&bytes, SIZE).unwrap()).unwrap();
    let depth = DepthImage::copy(&DepthView::from_f32(&depths, SIZE, 1.0).unwrap()).unwrap();
    let outline = Outline::new(&mask, Some(&depth), &scene.camera, &noise()).unwrap();
    outline.sides(&scene.camera, &scene.cylinder).unwrap()
}

#[test]
fn the_edge_of_something_in_front_is_no_side() {
    let scene = Scene::new();
    let axis = scene.camera.project(&scene.cylinder.axis.point).unwrap();
    let (column, row) = (axis.x as usize, axis.y as usize);
    let right = |sides: &[Side; 2]| usize::from(sides[1].ends[0].x > sides[0].ends[0].x);
    // The lower half is covered: the side follows the upper one.
    let sides = sides_behind(|x, y, _| x >= column && y >= row);
    assert!(!sides[0].cut && !sides[1].cut, "{sides:?}");
    let line = LimbLine { ends: sides[right(&sides)].ends, sigma: 1.0 };
    let near = |limb: usize| scene.errors(limb, &line).iter().all(|(error, _)| error.abs() < 1.5);
    assert!(near(0) || near(1), "{sides:?}");
    // There the limb is seen.
    let (part, hidden) = sides[right(&sides)].seen.unwrap();
    let covered = usize::from(part[1].y > part[0].y);
    assert!((part[covered].y - row as f64).abs() < 3.0, "{sides:?} {row}");
    assert!(hidden[covered] && !hidden[1 - covered], "{sides:?}");
    assert_eq!(sides[1 - right(&sides)].seen, None);
    // All of it is covered.
    let sides = sides_behind(|x, _, _| x >= column);
    let right = right(&sides);
    assert!(sides[right].cut && !sides[1 - right].cut, "{sides:?}");
    assert_eq!(sides[right].seen, None);
}

#[test]
fn what_is_nearer_beside_a_limb_hides_nothing_of_it() {
    let scene = Scene::new();
    let axis = scene.camera.project(&scene.cylinder.axis.point).unwrap();
    let (column, row) = (axis.x as usize, axis.y as usize);
    let sides = sides_behind(|x, y, on_surface| {
        x >= column && y >= row && (0..4).all(|beside| !on_surface(x - beside, y))
    });
    assert!(sides.iter().all(|side| side.seen.is_none() && !side.cut), "{sides:?}");
}
