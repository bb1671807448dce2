//! Masks of whole objects: what in them is the body of the cylinder.
#![allow(clippy::unwrap_used)]

mod support;

use cylfuse::camera::{Camera, Distortion, Intrinsics};
use cylfuse::extent::EndState;
use cylfuse::fitter::{Fitter, Flags, Options, Part};
use cylfuse::geometry::{AxisCone, Cylinder, CylinderLimits};
use cylfuse::observations::{DepthRange, DepthView, MaskView};
use nalgebra::{Vector2, Vector3};
use support::{Noise, limb_segments};

const SIZE: (usize, usize) = (240, 200);

/// Half the length of the body.
const HALF_LENGTH: f64 = 0.06;

/// Depth of the wall behind.
const WALL: f64 = 1.2;

/// How the end that faces the camera looks.
#[derive(Clone, Copy, PartialEq)]
enum Top {
    Closed,
    /// Its bottom is seen, too, from far enough above.
    Open,
    /// Closed, and no depth is measured on it.
    Dark,
    /// A shoulder and a neck half as wide, as those of a bottle.
    Neck,
    /// A lid that is wider than the body, whose last part is in it.
    Lid,
    /// A ring about the body, and no lid.
    Ring,
    /// Closed, with a flange about its foot.
    Flange,
    /// Closed by a lid that lies lower than its rim, as that of a tin.
    Recessed,
    /// A cap in line with the body that is a little narrower, as that of a spray can.
    Narrower,
}

/// Length of a shoulder, and of the neck on it.
const SHOULDER: f64 = 0.02;
const NECK: f64 = 0.05;

/// How much wider a lid is, and how high.
const LID_WIDER: f64 = 1.06;
const LID: f64 = 0.025;

/// How much wider a ring is, and where it is along the axis.
const RING_WIDER: f64 = 1.3;
const RING: [f64; 2] = [-0.02, 0.0];

/// How much wider a flange is, and how high.
const FLANGE_WIDER: f64 = 1.4;
const FLANGE: f64 = 0.02;

/// How much narrower a cap is, and how high.
const NARROWER: f64 = 0.92;
const CAP: f64 = 0.04;

/// How much lower than its rim a lid lies.
const RECESS: f64 = 0.006;

struct Scene {
    camera: Camera,
    cylinder: Cylinder,
    top: Top,
}

impl Scene {
    /// A can that leans towards the camera by 30 degrees.
    fn new(top: Top) -> Self {
        Self::with_axis(top, Vector3::new(0.1, -0.86, -0.5))
    }

    /// A can with an axis that points to the end which is seen.
    fn with_axis(top: Top, direction: Vector3<f64>) -> Self {
        let intrinsics = Intrinsics {
            width: SIZE.0 as u32,
            height: SIZE.1 as u32,
            fx: 500.0,
            fy: 500.0,
            cx: 119.5,
            cy: 99.5,
            distortion: Distortion::None,
        };
        let cylinder = Cylinder::new(Vector3::new(0.01, 0.0, 0.7), direction, 0.04).unwrap();
        Self { camera: Camera::new(intrinsics).unwrap(), cylinder, top }
    }

    /// What a pixel sees, and its depth.
    fn look(&self, column: usize, row: usize) -> (Option<Part>, f64) {
        let ray = self.camera.unproject(&Vector2::new(column as f64, row as f64)).unwrap();
        let axis = &self.cylinder.axis;
        if let Some(seen) = match self.top {
            Top::Lid => self.look_at_ring(&ray, LID_WIDER, [HALF_LENGTH - LID, HALF_LENGTH], Part::Cap),
            Top::Flange => {
                self.look_at_ring(&ray, FLANGE_WIDER, [-HALF_LENGTH, FLANGE - HALF_LENGTH], Part::Other)
            }
            Top::Ring => self.look_at_ring(&ray, RING_WIDER, RING, Part::Other),
            Top::Narrower => self.look_at_ring(&ray, NARROWER, [HALF_LENGTH, HALF_LENGTH + CAP], Part::Cap),
            _ => None,
        } {
            return seen;
        }
        let Some((near, far)) = self.cylinder.intersect_ray(&ray) else { return (None, WALL) };
        let (near, far) = (ray * near, ray * far);
        if axis.position_of(&near).abs() <= HALF_LENGTH {
            return (Some(Part::Body), near.z);
        }
        if self.top == Top::Neck {
            return self.look_at_neck(&ray).map_or((None, WALL), |z| (Some(Part::Other), z));
        }
        let rim = axis.at(HALF_LENGTH);
        let cap = ray * (rim.dot(&axis.direction) / ray.dot(&axis.direction));
        if (cap - rim).norm() > self.cylinder.radius {
            return (None, WALL);
        }
        let lid = ray * (axis.at(HALF_LENGTH - RECESS).dot(&axis.direction) / ray.dot(&axis.direction));
        let bottom = ray * (axis.at(-HALF_LENGTH).dot(&axis.direction) / ray.dot(&axis.direction));
        match self.top {
            Top::Closed | Top::Ring | Top::Flange | Top::Narrower => (Some(Part::Cap), cap.z),
            Top::Dark => (Some(Part::Cap), 0.0),
            Top::Recessed => (Some(Part::Cap), far.z.min(lid.z)),
            Top::Open | Top::Neck | Top::Lid => (Some(Part::InnerWall), far.z.min(bottom.z)),
        }
    }

    /// The wall or the top of a lid or ring, if a ray meets them and nothing is before them.
    fn look_at_ring(
        &self,
        ray: &Vector3<f64>,
        wider: f64,
        stretch: [f64; 2],
        top: Part,
    ) -> Option<(Option<Part>, f64)> {
        let Cylinder { axis, radius } = self.cylinder;
        let ring = Cylinder { axis, radius: wider * radius };
        let wall = ray * ring.intersect_ray(ray)?.0;
        let along = axis.position_of(&wall);
        if (stretch[0]..=stretch[1]).contains(&along) {
            return Some((Some(Part::Other), wall.z));
        }
        let middle = axis.at(stretch[1]);
        let on_top = ray * (middle.dot(&axis.direction) / ray.dot(&axis.direction));
        let outer = (on_top - middle).norm() <= ring.radius;
        let body = || self.cylinder.intersect_ray(ray).is_some_and(|(near, _)| near < on_top.z);
        (outer && (top == Part::Cap || !body())).then_some((Some(top), on_top.z))
    }

    /// The depth at which a ray meets shoulder or neck, step by step.
    fn look_at_neck(&self, ray: &Vector3<f64>) -> Option<f64> {
        let Cylinder { axis, radius } = &self.cylinder;
        let is_inside = |z: f64| {
            let beyond = axis.position_of(&(ray * z)) - HALF_LENGTH;
            let narrower = 0.5 * (beyond / SHOULDER).min(1.0);
            (0.0..=SHOULDER + NECK).contains(&beyond)
                && axis.distance(&(ray * z)) <= radius * (1.0 - narrower)
        };
        (0..3000).map(|k| 0.5 + 1e-4 * f64::from(k)).find(|z| is_inside(*z))
    }

    fn pixels<T>(&self, mut value: impl FnMut(Option<Part>, f64) -> T) -> Vec<T> {
        (0..SIZE.0 * SIZE.1)
            .map(|k| {
                let (part, depth) = self.look(k % SIZE.0, k / SIZE.0);
                value(part, depth)
            })
            .collect()
    }

    /// A fitter with every depth.
    fn fitter_without_mask(&self) -> Fitter {
        let depth = self.pixels(|_, depth| depth as f32);
        let mut fitter = Fitter::new();
        fitter.set_intrinsics(*self.camera.intrinsics()).unwrap();
        fitter
            .push_depth(&DepthView::from_f32(&depth, SIZE, 1.0).unwrap(), None, &DepthRange::default())
            .unwrap();
        fitter
    }

    /// A fitter with the depth within a mask of the parts that are wanted.
    fn fitter(&self, wanted: impl Fn(Part) -> bool) -> Fitter {
        self.fitter_with(wanted, &self.pixels(|_, depth| depth as f32))
    }

    /// The same with this depth.
    fn fitter_with(&self, wanted: impl Fn(Part) -> bool, depth: &[f32]) -> Fitter {
        self.fitter_within(&self.pixels(|part, _| u8::from(part.is_some_and(&wanted))), depth)
    }

    /// A fitter with the depth of the whole object, with noise of half a millimetre.
    fn noisy_fitter(&self, seed: u64) -> Fitter {
        let mut noise = Noise::new(seed);
        let depth = self.pixels(|_, depth| depth as f32 + 5e-4 * noise.normal() as f32);
        self.fitter_with(|_| true, &depth)
    }

    /// A fitter with this mask and this depth.
    fn fitter_within(&self, mask: &[u8], depth: &[f32]) -> Fitter {
        let mut fitter = Fitter::new();
        fitter.set_intrinsics(*self.camera.intrinsics()).unwrap();
        let depth = DepthView::from_f32(depth, SIZE, 1.0).unwrap();
        let mask = MaskView::from_u8(mask, SIZE).unwrap();
        fitter.push_depth(&depth, Some(&mask), &DepthRange::default()).unwrap();
        fitter
    }

    /// The parts of the pixels of the whole object that have a depth.
    fn parts(&self) -> Vec<Part> {
        self.pixels(|part, depth| part.filter(|_| depth > 0.0)).into_iter().flatten().collect()
    }
}

#[test]
fn the_body_is_measured_whatever_the_mask_holds() {
    for top in [Top::Closed, Top::Open, Top::Dark] {
        let scene = Scene::new(top);
        for whole in [false, true] {
            let mut fitter = scene.fitter(|part| whole || part == Part::Body);
            let fit = fitter.fit().unwrap();
            assert!(!fit.flags.contains(Flags::MASK_DISAGREES), "whole {whole}");
            let difference = scene.cylinder.compare(&fit.cylinder);
            assert!(difference.angle < 0.005, "{}", difference.angle);
            assert!(difference.radius_relative.abs() < 0.01, "{}", difference.radius_relative);
            let extent = fitter.extent(None, None).unwrap();
            let length = extent.length / (2.0 * HALF_LENGTH) - 1.0;
            assert!(length.abs() < 0.02, "whole {whole}: {length}");
            let states = [extent.start_state, extent.end_state];
            // Beyond the rim of a dark cap nothing was measured.
            let of_rim = if top == Top::Dark { EndState::Unknown } else { EndState::Seen };
            assert!(states.contains(&of_rim) && states.contains(&EndState::Seen), "{states:?}");
        }
    }
}

/// The wall in such a mask was another body, though the caller had cut it off.
#[test]
fn what_is_beyond_the_depths_that_count_is_no_other_body() {
    let scene = Scene::new(Top::Closed);
    let depth = scene.pixels(|_, depth| depth as f32);
    let depth = DepthView::from_f32(&depth, SIZE, 1.0).unwrap();
    let of_object: Vec<bool> = scene.pixels(|part, _| part.is_some());
    let columns: Vec<usize> = (0..of_object.len()).filter(|k| of_object[*k]).map(|k| k % SIZE.0).collect();
    let (first, last) = (columns.iter().min().unwrap(), columns.iter().max().unwrap());
    let rows: Vec<usize> = (0..of_object.len()).filter(|k| of_object[*k]).map(|k| k / SIZE.0).collect();
    let in_box = |k: usize| {
        (first - 10..=last + 10).contains(&(k % SIZE.0))
            && (rows[0]..=rows[rows.len() - 1]).contains(&(k / SIZE.0))
    };
    let mask: Vec<u8> = (0..of_object.len()).map(|k| u8::from(in_box(k))).collect();
    let mask = MaskView::from_u8(&mask, SIZE).unwrap();
    for (max, told) in [(f64::INFINITY, true), (0.9 * WALL, false)] {
        let mut fitter = Fitter::new();
        fitter.set_intrinsics(*scene.camera.intrinsics()).unwrap();
        fitter.push_depth(&depth, Some(&mask), &DepthRange { max, ..DepthRange::default() }).unwrap();
        fitter.push_edges(&limb_segments(&scene.cylinder, &scene.camera)).unwrap();
        let fit = fitter.fit().unwrap();
        assert_eq!(fit.flags.contains(Flags::MASK_DISAGREES), told, "{max}: {fit:?}");
    }
}

/// The far rim of an end was taken to be where the neck ends: the surface is not seen up to there.
#[test]
fn a_bottle_ends_at_its_shoulder() {
    for direction in [Vector3::new(0.1, -0.86, -0.5), Vector3::new(-0.2, -0.9, -0.2)] {
        let scene = Scene::with_axis(Top::Neck, direction);
        let mut fitter = scene.fitter(|_| true);
        let fit = fitter.fit().unwrap();
        assert!(!fit.flags.contains(Flags::MASK_DISAGREES));
        let difference = scene.cylinder.compare(&fit.cylinder);
        assert!(difference.angle < 0.01, "{}", difference.angle);
        assert!(difference.radius_relative.abs() < 0.02, "{}", difference.radius_relative);
        let extent = fitter.extent(None, None).unwrap();
        let length = extent.length - 2.0 * HALF_LENGTH;
        assert!(length.abs() < 0.1 * scene.cylinder.radius, "{length}");
    }
}

/// The end was where the lid is, and certain to half a pixel.
#[test]
fn a_body_ends_at_the_rim_of_a_recessed_lid() {
    for direction in [Vector3::new(0.1, -0.86, -0.5), Vector3::new(-0.2, -0.9, -0.4)] {
        for seed in 0..5 {
            let scene = Scene::with_axis(Top::Recessed, direction);
            let mut fitter = scene.noisy_fitter(seed);
            fitter.fit().unwrap();
            let extent = fitter.extent(None, None).unwrap();
            let off = (extent.length - 2.0 * HALF_LENGTH).abs();
            let stated = extent.uncertainty.unwrap().length;
            assert!(off < 3.0 * stated && off < 0.7 * RECESS, "{off} {stated}");
        }
    }
}

/// The cap counted as body, which was two thirds longer, and the axis tilted.
#[test]
fn a_body_ends_where_a_narrower_cap_begins() {
    for direction in [Vector3::new(0.1, -0.97, -0.1), Vector3::new(-0.2, -0.97, -0.15)] {
        for seed in 0..5 {
            let scene = Scene::with_axis(Top::Narrower, direction);
            let mut fitter = scene.noisy_fitter(seed);
            let difference = scene.cylinder.compare(&fitter.fit().unwrap().cylinder);
            assert!(difference.angle < 0.005, "{}", difference.angle);
            assert!(difference.radius_relative.abs() < 0.02, "{}", difference.radius_relative);
            let length = fitter.extent(None, None).unwrap().length / (2.0 * HALF_LENGTH) - 1.0;
            assert!(length.abs() < 0.03, "{length}");
        }
    }
}

/// A fit to a body with something wider on it: axis and radius are those of the body, within an angle and a part, and what is wider is told.
fn check_body_within(top: Top, direction: Vector3<f64>, most: [f64; 2]) {
    let scene = Scene::with_axis(top, direction);
    let mut fitter = scene.noisy_fitter(1);
    let fit = fitter.fit().unwrap();
    assert!(!fit.flags.contains(Flags::MASK_DISAGREES));
    let difference = scene.cylinder.compare(&fit.cylinder);
    assert!(difference.angle < most[0], "{}", difference.angle);
    assert!(difference.radius_relative.abs() < most[1], "{}", difference.radius_relative);
    // It is seen, and with it the body is as long as the object.
    let length = fitter.extent(None, None).unwrap().length / (2.0 * HALF_LENGTH) - 1.0;
    assert!(length.abs() < 0.05, "{length}");
    let parts = scene.parts().into_iter().zip(fitter.point_parts(None).unwrap());
    let wider: Vec<Part> = parts.filter(|(part, _)| *part == Part::Other).map(|(_, told)| told).collect();
    let told = wider.iter().filter(|told| **told == Part::Other).count();
    assert!(told as f64 > 0.9 * wider.len() as f64, "{told} of {}", wider.len());
}

/// The axis lay between the foot and the edge of the lid: it was off by one to two degrees.
#[test]
fn a_lid_that_is_wider_does_not_tilt_the_axis() {
    for direction in [Vector3::new(0.1, -0.86, -0.5), Vector3::new(-0.2, -0.97, -0.15)] {
        check_body_within(Top::Lid, direction, [0.005, 0.02]);
    }
}

/// The sides of the mask follow a ring, and the radius lay between that of the body and that of the ring.
#[test]
fn a_ring_that_is_wider_is_no_body() {
    for direction in [Vector3::new(0.1, -0.97, -0.1), Vector3::new(-0.2, -0.97, -0.15)] {
        check_body_within(Top::Ring, direction, [0.01, 0.03]);
    }
}

/// The lower edge of the flange was looked for on the surface of the body, and found a flange farther down.
#[test]
fn a_body_ends_with_the_flange_that_closes_it() {
    for direction in [Vector3::new(0.1, -0.86, -0.5), Vector3::new(-0.2, -0.9, -0.3)] {
        for seed in 0..5 {
            let scene = Scene::with_axis(Top::Flange, direction);
            let mut fitter = scene.noisy_fitter(seed);
            let difference = scene.cylinder.compare(&fitter.fit().unwrap().cylinder);
            assert!(difference.angle < 0.01, "{}", difference.angle);
            let length = fitter.extent(None, None).unwrap().length / (2.0 * HALF_LENGTH) - 1.0;
            assert!(length.abs() < 0.03, "{length}");
        }
    }
}

/// A generator ended at the last pixel of the mask on its way, though that was a speck far away.
#[test]
fn specks_in_the_mask_are_no_ends() {
    let scene = Scene::new(Top::Closed);
    let mut mask = scene.pixels(|part, _| u8::from(part == Some(Part::Body)));
    for speck in 0..200 {
        let (column, row) = (speck * 37 % (SIZE.0 - 3), speck * 61 % (SIZE.1 - 3));
        (0..9).for_each(|k| mask[(row + k / 3) * SIZE.0 + column + k % 3] = 1);
    }
    let mut fitter = scene.fitter_within(&mask, &scene.pixels(|_, depth| depth as f32));
    fitter.fit().unwrap();
    let extent = fitter.extent(None, None).unwrap();
    let length = extent.length / (2.0 * HALF_LENGTH) - 1.0;
    assert!(length.abs() < 0.02, "{length} {:?} {:?}", extent.start_state, extent.end_state);
}

/// What is seen of such a body bends less than the noise, and with its cap the points lie on a cylinder across it as well.
#[test]
fn a_body_seen_along_its_axis_is_found_by_its_cap() {
    let scene = Scene::with_axis(Top::Closed, Vector3::new(0.12, -0.12, -1.0));
    for seed in 0..8 {
        let mut noise = Noise::new(seed);
        // Structured light: an error of 1/z, which the pixels of a matching window share.
        let errors: Vec<f64> = (0..35 * 35).map(|_| 0.004 * noise.normal()).collect();
        let mut depth = scene.pixels(|_, depth| depth as f32);
        for (k, depth) in depth.iter_mut().enumerate() {
            *depth += depth.powi(2) * errors[k / SIZE.0 / 7 * 35 + k % SIZE.0 / 7] as f32;
        }
        let Cylinder { axis, radius } = scene.cylinder;
        let known_radius =
            CylinderLimits { radius_min: radius, radius_max: radius, ..CylinderLimits::default() };
        let cone = AxisCone { direction: axis.direction, max_angle: 0.02 };
        let known_axis = CylinderLimits { axis: Some(cone), ..CylinderLimits::default() };
        for cylinder_limits in [CylinderLimits::default(), known_radius, known_axis] {
            let mut fitter = scene.fitter_with(|_| true, &depth);
            fitter.set_options(Options { cylinder_limits, ..Options::default() }).unwrap();
            let difference = scene.cylinder.compare(&fitter.fit().unwrap().cylinder);
            assert!(difference.angle < 0.05, "{seed}, {cylinder_limits:?}: {}", difference.angle);
            assert!(difference.axis_distance < 0.1 * radius, "{seed}: {}", difference.axis_distance);
        }
    }
}

/// The bottom was taken for a cap at the near end, nothing of the body was left, and the axis came out across.
#[test]
fn the_bottom_of_an_open_body_is_no_cap() {
    let scene = Scene::with_axis(Top::Open, Vector3::new(0.1, -0.45, -0.89));
    let mut fitter = scene.fitter(|_| true);
    let difference = scene.cylinder.compare(&fitter.fit().unwrap().cylinder);
    assert!(difference.angle < 1e-3, "{}", difference.angle);
    assert!(difference.radius_relative.abs() < 1e-3, "{}", difference.radius_relative);
}

/// Most of the points are of a wall far behind, which says nothing of the noise of the surface.
#[test]
fn the_background_is_told_without_a_mask() {
    let scene = Scene::new(Top::Dark);
    let found = scene.fitter_without_mask().point_parts(Some(&scene.cylinder)).unwrap();
    let truth: Vec<Option<Part>> =
        scene.pixels(|part, depth| (depth > 0.0).then_some(part)).into_iter().flatten().collect();
    assert_eq!(found.len(), truth.len());
    for (part, want) in [(Some(Part::Body), Part::Body), (None, Part::Behind)] {
        let of_part = || found.iter().zip(&truth).filter(|(_, truth)| **truth == part);
        let right = of_part().filter(|(found, _)| **found == want).count();
        assert!(
            right as f64 >= 0.93 * of_part().count() as f64,
            "{want:?}: {right} of {}",
            of_part().count()
        );
    }
}

#[test]
fn points_are_labelled() {
    for top in [Top::Closed, Top::Open] {
        let scene = Scene::new(top);
        let mut fitter = scene.fitter(|_| true);
        fitter.fit().unwrap();
        let (found, truth) = (fitter.point_parts(None).unwrap(), scene.parts());
        assert_eq!(found.len(), truth.len());
        for part in [Part::Body, Part::Cap, Part::InnerWall] {
            let of_part = || found.iter().zip(&truth).filter(|(_, truth)| **truth == part);
            let right = of_part().filter(|(found, truth)| found == truth).count();
            assert!(
                right as f64 >= 0.93 * of_part().count() as f64,
                "{part:?}: {right} of {}",
                of_part().count()
            );
        }
    }
}

#[test]
fn a_mask_of_the_body_is_left_as_it_is() {
    let scene = Scene::new(Top::Closed);
    let mut fitter = scene.fitter(|part| part == Part::Body);
    let fit = fitter.fit().unwrap();
    assert_eq!(fit.points_used, fitter.cloud().len());
    let mut whole = scene.fitter(|_| true);
    let fit = whole.fit().unwrap();
    let body = scene.parts().iter().filter(|part| **part == Part::Body).count();
    assert!(fit.points_used.abs_diff(body) * 50 < body, "{} of {body}", fit.points_used);
}

#[test]
fn a_start_that_is_near_hides_nothing_in_the_mask() {
    for top in [Top::Closed, Top::Open] {
        let scene = Scene::new(top);
        let body = scene.parts().iter().filter(|part| **part == Part::Body).count();
        for (aside, tilt, scale) in [(0.0, 0.0, 1.0), (0.001, 0.02, 1.03), (-0.001, -0.02, 0.97)] {
            let Cylinder { axis, radius } = scene.cylinder;
            let (point, direction) =
                (axis.point + Vector3::x() * aside, axis.direction + Vector3::x() * tilt);
            let mut whole = scene.fitter(|_| true);
            whole.set_start(Some(Cylinder::new(point, direction, radius * scale).unwrap()));
            let fit = whole.fit().unwrap();
            assert!(fit.points_used.abs_diff(body) * 50 < body, "{} of {body}", fit.points_used);
        }
    }
}

/// Matching windows widen thin bodies: the points lie on a cylinder that is larger than the body, and its outline is not.
#[test]
fn the_sides_of_a_mask_contest_the_radius_of_points_that_are_bent() {
    let scene = Scene::new(Top::Closed);
    let Cylinder { axis, radius } = scene.cylinder;
    let larger = 0.002;
    // The generator nearest to the camera stays where it is.
    let back = axis.point - axis.direction * axis.point.dot(&axis.direction);
    let bent =
        Cylinder::new(axis.point + back.normalize() * larger, axis.direction, radius + larger).unwrap();
    let bent = Scene { cylinder: bent, ..Scene::new(Top::Closed) };
    let mask = scene.pixels(|part, _| u8::from(part == Some(Part::Body)));
    let mut depth = bent.pixels(|_, depth| depth as f32);
    for (k, depth) in depth.iter_mut().enumerate() {
        // Half a millimetre of noise, from the digits of a multiplicative sequence.
        *depth += ((k * 7919 % 1009) as f32 / 1009.0 - 0.5) * 0.0017;
    }
    let mut fitter = Fitter::new();
    fitter.set_intrinsics(*scene.camera.intrinsics()).unwrap();
    let depth = DepthView::from_f32(&depth, SIZE, 1.0).unwrap();
    let mask = MaskView::from_u8(&mask, SIZE).unwrap();
    fitter.push_depth(&depth, Some(&mask), &DepthRange::default()).unwrap();
    let fit = fitter.fit().unwrap();
    let off = (fit.cylinder.radius - radius) / larger;
    // Either contests the other: with the deviations of both, about half of the error is left.
    assert!((0.2..0.7).contains(&off), "{off} of the error is left");
    let deviation = fit.uncertainty.unwrap().radius();
    assert!((fit.cylinder.radius - radius).abs() < 2.0 * deviation, "{deviation}");
}

/// Points that are exact but for the rounding of their depth share no error, however the mask was drawn.
#[test]
fn exact_depth_keeps_its_radius_beside_a_mask_that_is_too_narrow() {
    let scene = Scene::new(Top::Closed);
    let body = scene.pixels(|part, _| part == Some(Part::Body));
    let inner = |k: usize| body[k] && body[k.saturating_sub(2)] && body[(k + 2).min(body.len() - 1)];
    let mask: Vec<u8> = (0..body.len()).map(|k| u8::from(inner(k))).collect();
    let depth = scene.pixels(|_, depth| (depth * 1e4).round() as u16);
    let mut fitter = Fitter::new();
    fitter.set_intrinsics(*scene.camera.intrinsics()).unwrap();
    let depth = DepthView::from_u16(&depth, SIZE, 1e-4).unwrap();
    let mask = MaskView::from_u8(&mask, SIZE).unwrap();
    fitter.push_depth(&depth, Some(&mask), &DepthRange::default()).unwrap();
    let off = fitter.fit().unwrap().cylinder.radius / scene.cylinder.radius - 1.0;
    assert!(off.abs() < 6e-3, "{off}");
}

/// All of a scene was explained best by a cylinder around the camera, and that was the error.
#[test]
fn a_scene_without_a_mask_shows_its_body() {
    let intrinsics = *Scene::new(Top::Closed).camera.intrinsics();
    let camera = Camera::new(intrinsics).unwrap();
    let direction = Vector3::new(0.506, -0.277, -0.69);
    let cylinder = Cylinder::new(Vector3::new(0.0, 0.0, 0.6), direction, 0.03).unwrap();
    let up = Vector3::new(0.0, -0.8, -0.395);
    let height = Vector3::new(0.0, 0.0, 0.743).dot(&up);
    let depth: Vec<f32> = (0..SIZE.0 * SIZE.1)
        .map(|k| {
            let ray = camera.unproject(&Vector2::new((k % SIZE.0) as f64, (k / SIZE.0) as f64)).unwrap();
            let on_floor = Some(height / ray.dot(&up)).filter(|z| (0.0..3.0).contains(z)).unwrap_or(1.5);
            let near = cylinder.intersect_ray(&ray).map(|(near, _)| ray * near);
            let on_body = near.filter(|point| cylinder.axis.position_of(point).abs() < 0.1);
            on_body.map_or(on_floor, |point| point.z.min(on_floor)) as f32
        })
        .collect();
    let mut fitter = Fitter::new();
    fitter.set_intrinsics(intrinsics).unwrap();
    let depth = DepthView::from_f32(&depth, SIZE, 1.0).unwrap();
    fitter.push_depth(&depth, None, &DepthRange::default()).unwrap();
    let fit = fitter.fit().unwrap();
    assert!((fit.cylinder.radius / 0.03 - 1.0).abs() < 0.01, "{}", fit.cylinder.radius);
}

/// A shaft whose radius is 6 % smaller over the rest of its length, seen at a slant, with a mask of both parts, with the face between them
/// or without it, and depth that ends where the surface is seen too flat. The axis was off by a degree in three of these, stated to a third,
/// without a warning: the outline about the face hid the step, or what was known before the fit was too rough to show it.
#[test]
fn a_step_of_a_shaft_does_not_tip_the_axis() {
    const HALF: f64 = 0.075;
    const STEP: f64 = -0.0075;
    let (width, height) = (640, 480);
    let distortion = Distortion::None;
    let intrinsics = Intrinsics { width, height, fx: 700.0, fy: 700.0, cx: 319.5, cy: 239.5, distortion };
    let camera = Camera::new(intrinsics).unwrap();
    let size = (width as usize, height as usize);
    for (slant, face, flattest) in
        [(-0.4_f64, false, 0.0), (-0.7, true, 0.6), (-0.5, true, 0.75), (0.4, true, 0.0)]
    {
        let direction = Vector3::new(slant.cos(), 0.1, slant.sin()).normalize();
        let point = Vector3::new(0.0, 0.0, 0.35);
        let [thick, thin] = [0.03, 0.0282].map(|radius| Cylinder::new(point, direction, radius).unwrap());
        let mut noise = Noise::new(1);
        let depth_at = |k: usize| {
            let ray = camera.unproject(&Vector2::new((k % size.0) as f64, (k / size.0) as f64)).unwrap();
            let on = |cylinder: &Cylinder, low: f64, high: f64| {
                let along = |hit: &Vector3<f64>| direction.dot(&(hit - point));
                cylinder.first_hit(&ray).filter(|hit| (low..high).contains(&along(hit)))
            };
            let at_step = ray * ((point + direction * STEP).dot(&direction) / ray.dot(&direction));
            let on_face = face && thick.distance(&at_step) < 0.0 && thin.distance(&at_step) > 0.0;
            let hits = [on(&thick, -HALF, STEP), on(&thin, STEP, HALF), on_face.then_some(at_step)];
            hits.into_iter().flatten().map(|hit| hit.z).min_by(f64::total_cmp)
        };
        let depths: Vec<Option<f64>> = (0..size.0 * size.1).map(depth_at).collect();
        let mask: Vec<u8> = depths.iter().map(|depth| u8::from(depth.is_some())).collect();
        let measured = |k: usize| {
            let is_flat = |z: &f64| {
                let point =
                    camera.unproject(&Vector2::new((k % size.0) as f64, (k / size.0) as f64)).unwrap() * *z;
                let normal = (point - thick.axis.nearest_to(&point)).normalize();
                normal.dot(&point.normalize()).abs() < flattest
            };
            if depths[k].as_ref().is_some_and(is_flat) {
                0.0
            } else {
                (depths[k].unwrap_or(0.6) + 2e-4 * noise.normal()) as f32
            }
        };
        let depth: Vec<f32> = (0..depths.len()).map(measured).collect();
        let mut fitter = Fitter::new();
        fitter.set_intrinsics(intrinsics).unwrap();
        let depth = DepthView::from_f32(&depth, size, 1.0).unwrap();
        let mask = MaskView::from_u8(&mask, size).unwrap();
        fitter.push_depth(&depth, Some(&mask), &DepthRange::default()).unwrap();
        let fit = fitter.fit().unwrap();
        let tipped = fit.cylinder.axis.direction.dot(&direction).abs().min(1.0).acos().to_degrees();
        assert!(tipped < 0.05, "{slant} {face} {flattest}: {tipped}°");
    }
}
