//! Where there is no cylinder, none is found; the wall of a can is no plane, the parts of a pipe are no pipes, and the edge between
//! two pipes is the limb of one.
#![cfg(feature = "twin")]
#![allow(clippy::unwrap_used, reason = "a test program")]

#[path = "support/frames.rs"]
mod frames;
#[path = "support/mod.rs"]
mod support;
#[path = "support/twin_frames.rs"]
mod twin_frames;

use cylfuse::camera::Camera;
use cylfuse::observations::{DepthRange, DepthView, Frame, ImageView};
use cylfuse::scene::{Detector, DetectorOptions, Found, Scene};
use cylfuse::twin::{DEPTH_UNIT, DepthSensor, Kind, StructuredLight, TimeOfFlight, random_scene};
use support::Noise;
use twin_frames::{SIZE, captured, captured_by, intrinsics};

const FOCAL: f64 = 570.0;

/// That of the frames that the command `cylfuse twin` writes.
const TWIN_FOCAL: f64 = 569.6;

/// What is found by a camera of this focal length.
fn found(focal: f64, depth: &[u16], image: Option<&[u8]>) -> Scene {
    found_with(&DetectorOptions::default(), focal, depth, image)
}

fn found_with(options: &DetectorOptions, focal: f64, depth: &[u16], image: Option<&[u8]>) -> Scene {
    let mut frame = Frame::new(Camera::new(intrinsics(focal)).unwrap());
    let depth = DepthView::from_u16(depth, SIZE, DEPTH_UNIT).unwrap();
    frame.set_depth(&depth, &DepthRange::default()).unwrap();
    if let Some(image) = image {
        frame.set_image(&ImageView::from_u8(image, SIZE).unwrap()).unwrap();
    }
    let mut detector = Detector::new();
    detector.set_options(*options).unwrap();
    detector.detect(&frame).unwrap()
}

/// Says what was found where nothing should be.
fn complaint(name: &str, depth: &[u16], image: Option<&[u8]>) -> Option<String> {
    let found = found(FOCAL, depth, image);
    assert!(found.cylinders.is_empty() == found.labels.iter().all(|label| *label == 0), "{name}");
    let one = |found: &Found| {
        let radius = 1e3 * found.result.cylinder.radius;
        format!("radius {radius:.1} mm, score {:.2}, {} pixels", found.score, found.pixels)
    };
    let all: Vec<String> = found.cylinders.iter().map(one).collect();
    (!all.is_empty()).then(|| format!("{name}: {}", all.join("; ")))
}

/// Scenes of 20 in which something is found by depth alone. None is the goal (docs/measurements.md): a frustum
/// passes for a cylinder with a score of 0.65.
const MOST: usize = 1;

/// Boxes, spheres, frustums, planes and some of everything, twice each by both sensors.
#[test]
fn nothing_is_found_among_boxes_spheres_frustums_and_planes() {
    let mut complaints = Vec::new();
    for (name, sensor) in [
        ("structured light", DepthSensor::StructuredLight(StructuredLight::default())),
        ("time of flight", DepthSensor::TimeOfFlight(TimeOfFlight::default())),
    ] {
        for seed in 0..10 {
            let frame = captured_by(sensor, &random_scene(Kind::NoCylinders, seed).unwrap(), FOCAL, seed);
            assert!(frame.depth.iter().filter(|z| **z > 0).count() > 100_000);
            complaints.extend(complaint(&format!("{name}, seed {seed}"), &frame.depth, None));
        }
    }
    assert!(complaints.len() <= MOST, "{} of 20 scenes\n{}", complaints.len(), complaints.join("\n"));
}

/// Frustums of 4 to 10 degrees passed for cylinders with scores of 0.75 to 0.88, though both of their limbs were located.
#[test]
fn limbs_that_turn_against_each_other_tell_frustums() {
    for seed in [74_009, 74_014, 74_019, 74_024, 74_027] {
        let frame = captured(&random_scene(Kind::NoCylinders, seed).unwrap(), FOCAL, seed);
        assert_eq!(complaint(&format!("seed {seed}"), &frame.depth, Some(&frame.image)), None);
    }
}

#[test]
fn nothing_is_found_in_an_empty_depth_image() {
    assert_eq!(complaint("empty", &vec![0; SIZE.0 * SIZE.1], None), None);
}

#[test]
fn nothing_is_found_in_noise() {
    // A linear congruential generator (Numerical Recipes).
    let mut state = 1_u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        state >> 16
    };
    let far: Vec<u16> = (0..SIZE.0 * SIZE.1).map(|_| next() as u16).collect();
    assert_eq!(complaint("noise of all depths", &far, None), None);
    for spread in [100, 1000] {
        let wall: Vec<u16> = (0..SIZE.0 * SIZE.1).map(|_| (8000 + next() % spread) as u16).collect();
        assert_eq!(complaint(&format!("a wall with noise of {spread} units"), &wall, None), None);
    }
}

/// Searches of twelve that find a board by depth alone, which bends by chance.
const BOARDS: usize = 4;

/// Four upright boards of 80 mm before a wall, with depth as a stereo camera has it far away: errors of 60 mm, the same over patches of
/// 9 pixels. Their edges are straight and parallel, and the depth does not tell whether they are flat. 36 of them passed for cylinders
/// in these twelve searches, with scores of up to 0.94, 16 of them with an image.
#[test]
fn boards_in_noise_as_large_as_they_are_pass_for_no_cylinders() {
    let (width, height) = SIZE;
    let board_at = |k: usize| (120..360).contains(&(k / width)) && (k % width + 60) % 150 < 15;
    let image: Vec<u8> = (0..width * height).map(|k| if board_at(k) { 180 } else { 60 }).collect();
    let mut complaints = Vec::new();
    for seed in 0..6 {
        let mut noise = Noise::new(seed);
        let patches: Vec<f64> = (0..(width / 9 + 1) * (height / 9 + 1)).map(|_| noise.normal()).collect();
        let depth = |k: usize| {
            let z = if board_at(k) { 3.1 } else { 3.6 };
            let patch = patches[k / width / 9 * (width / 9 + 1) + k % width / 9];
            ((z + 0.06 * patch + 0.005 * noise.normal()) / DEPTH_UNIT) as u16
        };
        let depth: Vec<u16> = (0..width * height).map(depth).collect();
        for image in [None, Some(&image[..])] {
            let complaint = complaint(&format!("seed {seed}"), &depth, image);
            assert!(image.is_none() || complaint.is_none(), "with an image, {complaint:?}");
            complaints.extend(complaint);
        }
    }
    assert!(complaints.len() <= BOARDS, "{}", complaints.join("\n"));
}

/// Radii in millimetres.
fn radii(scene: &Scene) -> Vec<f64> {
    scene.cylinders.iter().map(|found| 1e3 * found.result.cylinder.radius).collect()
}

/// Their walls are as flat as their noise in strips of a quarter of their width, or bend by less than a plane may together with
/// the line along which that strip cuts the table, and no part of them was left for a cylinder.
#[test]
fn a_wide_can_on_a_table_is_no_plane() {
    for (seed, focal, radius) in [(9152, FOCAL, 53.0), (98_030, TWIN_FOCAL, 48.1), (98_033, TWIN_FOCAL, 53.1)]
    {
        let frame = captured(&random_scene(Kind::Table, seed).unwrap(), focal, seed);
        let radii = radii(&found(focal, &frame.depth, None));
        assert!(radii.iter().any(|found| (found / radius - 1.0).abs() < 0.1), "seed {seed}: {radii:?}");
    }
}

/// What depth near the limbs is off makes the parts of a pipe differ by several percent.
#[test]
fn a_pipe_that_something_divides_is_found_once() {
    let structured_light = DepthSensor::StructuredLight(StructuredLight::default());
    let time_of_flight = DepthSensor::TimeOfFlight(TimeOfFlight::default());
    let of_structured_light = [91_105, 91_121, 91_129].map(|seed| (seed, structured_light));
    for (seed, sensor) in of_structured_light.into_iter().chain([(98_312, time_of_flight)]) {
        let frame = captured_by(sensor, &random_scene(Kind::Pipes, seed).unwrap(), TWIN_FOCAL, seed);
        let found = found(TWIN_FOCAL, &frame.depth, Some(&frame.image)).cylinders;
        assert!(found.len() >= 2, "seed {seed}: {}", found.len());
        for (index, one) in found.iter().enumerate() {
            for other in &found[..index] {
                let change = one.result.cylinder.compare(&other.result.cylinder);
                let same = change.angle < 0.02
                    && change.radius_relative.abs() < 0.1
                    && change.axis_distance < 0.5 * one.result.cylinder.radius;
                assert!(!same, "seed {seed}: {:?} {:?}", one.result.cylinder, other.result.cylinder);
            }
        }
    }
}

/// Where two pipes lie side by side, the limb of one was taken for that of the other as well, across the gap between them.
#[test]
fn an_edge_between_two_pipes_is_the_limb_of_one() {
    for (seed, radius) in [(91_108, 50.7), (91_127, 17.6), (96_118, 52.2)] {
        let frame = captured(&random_scene(Kind::Pipes, seed).unwrap(), TWIN_FOCAL, seed);
        let one = radii(&found(TWIN_FOCAL, &frame.depth, Some(&frame.image)));
        assert!(one.iter().any(|found| (found / radius - 1.0).abs() < 0.045), "seed {seed}: {one:?}");
        let threads = DetectorOptions { threads: 3, ..DetectorOptions::default() };
        assert_eq!(one, radii(&found_with(&threads, TWIN_FOCAL, &frame.depth, Some(&frame.image))));
    }
}
