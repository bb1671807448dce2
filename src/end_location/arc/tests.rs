//! Arcs before a background that is cut off at white, arcs at which the edge of a wall begins, and how far samples err together.

use super::super::{End, EndSearch, MaskContent, locate_ends};
use super::{LocatedStep, standard_error};
use crate::camera::{Camera, Distortion, Intrinsics};
use crate::geometry::Cylinder;
use crate::memory::List;
use crate::noise::NoiseModel;
use crate::observations::{GreyImage, ImageView, Mask, MaskView};
use crate::statistics::DEVIATION_OF_MEDIAN;
use nalgebra::{Vector2, Vector3};
use std::ops::ControlFlow;

const SIZE: (usize, usize) = (160, 120);
const HALF_LENGTH: f64 = 0.05;
const BLUR: f64 = 0.7;

fn camera() -> Camera {
    Camera::new(Intrinsics {
        width: SIZE.0 as u32,
        height: SIZE.1 as u32,
        fx: 570.0,
        fy: 570.0,
        cx: 79.5,
        cy: 59.5,
        distortion: Distortion::None,
    })
    .unwrap()
}

fn cylinder() -> Cylinder {
    Cylinder::new(Vector3::new(0.0, 0.0, 1.0), Vector3::new(0.02, 0.97, 0.25), 0.04).unwrap()
}

/// The ends in the image of a grey cylinder with some light of what else a pixel sees; 255 is white.
fn ends(beside: impl Fn(&Vector2<f64>) -> f64) -> [End; 2] {
    let (camera, cylinder) = (camera(), cylinder());
    let on_body = |pixel: &Vector2<f64>| {
        let hit = camera.unproject(pixel).and_then(|ray| cylinder.first_hit(&ray));
        hit.is_some_and(|hit| (hit - cylinder.axis.point).dot(&cylinder.axis.direction).abs() <= HALF_LENGTH)
    };
    let light = |pixel: Vector2<f64>| if on_body(&pixel) { 120.0 } else { beside(&pixel) };
    let pixels = (0..SIZE.0 * SIZE.1).map(|k| Vector2::new((k % SIZE.0) as f64, (k / SIZE.0) as f64));
    let steps: Vec<(f64, f64)> = (-6..=6).map(|k| 0.35 * f64::from(k)).map(|x| (x, weight(x))).collect();
    let blurred = |pixel: Vector2<f64>| {
        let (mut sum, mut total) = (0.0, 0.0);
        for (x, by_x) in &steps {
            for (y, by_y) in &steps {
                sum += by_x * by_y * light(pixel + Vector2::new(*x, *y));
                total += by_x * by_y;
            }
        }
        (sum / total).round() as u8
    };
    let values: Vec<u8> = pixels.clone().map(blurred).collect();
    let image = GreyImage::copy(&ImageView::from_u8(&values, SIZE).unwrap()).unwrap();
    let inside: Vec<u8> = pixels.map(|pixel| u8::from(on_body(&pixel))).collect();
    let mask = Mask::copy(&MaskView::from_u8(&inside, SIZE).unwrap()).unwrap();
    let search = EndSearch {
        camera: &camera,
        mask: &mask,
        content: MaskContent::Body,
        drawn: true,
        depth: None,
        image: Some(&image),
        tolerance: 0.01,
        limbs_known: true,
        noise: NoiseModel::default().in_image(SIZE),
        blur: None,
        last: [None; 2],
    };
    match locate_ends(&search, &cylinder, &mut || ControlFlow::Continue(())) {
        ControlFlow::Continue(Some(ends)) => ends,
        other => panic!("{other:?}"),
    }
}

fn weight(x: f64) -> f64 {
    (-0.5 * (x / BLUR).powi(2)).exp()
}

/// Where the samples of an end are in the image beside the true arc, in pixels outward.
fn off(end: &End) -> Vec<f64> {
    let (camera, cylinder) = (camera(), cylinder());
    let axis = cylinder.axis;
    let offset = |sample: &super::ArcSample| {
        let hit = cylinder.first_hit(&camera.unproject(&sample.pixel).unwrap()).unwrap();
        ((hit - axis.point).dot(&axis.direction).abs() - HALF_LENGTH) * sample.across
    };
    end.samples.iter().map(offset).collect()
}

#[test]
fn an_arc_before_a_background_that_is_cut_off_at_white_tells_no_shape() {
    let grey = ends(|_| 250.0);
    for end in &grey {
        assert!(end.samples.len() > 20 && off(end).iter().all(|off| off.abs() < 0.15), "{:?}", off(end));
    }
    for end in ends(|_| 700.0) {
        assert!(end.samples.is_empty(), "off by {:?} px", off(&end));
        let (error, deviation) = (end.position.abs() - HALF_LENGTH, end.deviation.unwrap());
        assert!(error.abs() < 2.0 * deviation, "{error} +- {deviation}");
        // A sequence goes on from the arc by itself, which seems to lie inside, not from what it says with the mask.
        assert!(end.arc.is_some_and(|arc| arc.position.abs() < end.position.abs()), "{end:?}");
    }
}

#[test]
fn where_half_of_the_background_is_cut_off_the_other_half_tells_the_shape() {
    for end in ends(|pixel| if pixel.x < 79.5 { 30.0 } else { 700.0 }) {
        assert!(end.samples.len() >= 8, "{end:?}");
        assert!(end.samples.iter().all(|sample| sample.pixel.x < 80.0), "{end:?}");
        // One of them lies beside the border between both halves.
        assert!(off(&end).iter().filter(|off| off.abs() > 0.15).count() <= 1, "{:?}", off(&end));
    }
}

#[test]
fn the_edge_of_a_wall_at_an_open_end_does_not_shift_it() {
    let (camera, cylinder) = (camera(), cylinder());
    let axis = cylinder.axis;
    let mouth = axis.point - axis.direction * HALF_LENGTH;
    // The inside is as bright as the outside, the edge of the wall between them is not.
    let beside = |pixel: &Vector2<f64>| {
        let ray = camera.unproject(pixel).unwrap();
        let hit = ray * (mouth.dot(&axis.direction) / ray.dot(&axis.direction));
        match (hit - mouth).norm() / cylinder.radius {
            part if part < 0.75 => 118.0,
            part if part < 1.0 => 220.0,
            _ => 30.0,
        }
    };
    let [open, _] = ends(beside);
    assert!(open.samples.len() > 20 && off(&open).iter().all(|off| off.abs() < 0.4), "{:?}", off(&open));
    let across = open.samples[0].across;
    assert!(((open.position + HALF_LENGTH) * across).abs() < 0.4, "{open:?}");
}

#[test]
fn samples_of_an_arc_that_err_together_tell_less_of_its_error() {
    let steps = |edges: &[f64]| -> List<LocatedStep> {
        edges.iter().map(|&edge| LocatedStep { angle: 0.0, across: 2.0, edge, deviation: 0.1 }).collect()
    };
    let error = |edges: &[f64]| standard_error(&steps(edges), 0.0);
    // Half a pixel apart where a length of one is two pixels; alternating errors are independent ones.
    let alternating: Vec<f64> = (0..16).map(|k| if k % 2 == 0 { 0.5 } else { -0.5 }).collect();
    assert!((error(&alternating).unwrap() - DEVIATION_OF_MEDIAN * 0.25 / 4.0).abs() < 1e-12);
    let halves: Vec<f64> = (0..16).map(|k| if k < 8 { 0.5 } else { -0.5 }).collect();
    assert!(error(&halves).unwrap() > 3.0 * error(&alternating).unwrap());
    assert_eq!(error(&[]), None);
}
