//! Clouds that no sensor in their origin has seen: what surrounds it, what was merged from several places, and what a program moved to
//! other coordinates.
#![allow(clippy::unwrap_used)]

#[path = "support/fits.rs"]
mod fits;
#[path = "support/frames.rs"]
mod frames;
#[allow(dead_code)]
#[path = "support/random_views.rs"]
mod random_views;
mod support;

use cylfuse::geometry::{Cylinder, RigidMotion};
use cylfuse::observations::PointsView;
use cylfuse::scene::{Detector, DetectorOptions, Scene};
use nalgebra::{Rotation3, Vector3};
use random_views::Dice;

/// A pipe: the middle of its axis, its direction and its radius, and half its length.
type Pipe = ([f64; 3], [f64; 3], f64, f64);

/// Pipes that stand and lie in a room of 6 × 6 × 3 m about the origin, which is in the middle of its floor.
const PIPES: [Pipe; 5] = [
    ([1.5, 1.0, 1.5], [0.0, 0.0, 1.0], 0.15, 1.5),
    ([-1.8, 0.5, 1.5], [0.0, 0.0, 1.0], 0.2, 1.5),
    ([0.0, 2.6, 2.2], [1.0, 0.0, 0.0], 0.12, 2.8),
    ([0.0, -2.5, 0.8], [1.0, 0.0, 0.0], 0.1, 2.8),
    ([0.5, -0.8, 0.4], [0.6, 0.8, 0.0], 0.18, 1.0),
];

const DENSITY: f64 = 2500.0;

const NOISE: f64 = 0.002;

/// Points on a parallelogram.
fn plane(corner: [f64; 3], sides: [[f64; 3]; 2], dice: &mut Dice) -> Vec<Vector3<f64>> {
    let [a, b] = sides.map(Vector3::from);
    let normal = a.cross(&b);
    let count = (DENSITY * normal.norm()) as usize;
    let mut point = || {
        let [s, t] = [dice.between(0.0, 1.0), dice.between(0.0, 1.0)];
        Vector3::from(corner) + a * s + b * t + normal.normalize() * dice.between(-NOISE, NOISE)
    };
    (0..count).map(|_| point()).collect()
}

fn box_of(low: [f64; 3], size: [f64; 3], dice: &mut Dice) -> Vec<Vector3<f64>> {
    let side = |axis: usize| -> [f64; 3] { std::array::from_fn(|k| if k == axis { size[k] } else { 0.0 }) };
    let high: [f64; 3] = std::array::from_fn(|k| low[k] + size[k]);
    let sides = [0, 1, 2].map(|axis| [side((axis + 1) % 3), side((axis + 2) % 3)]);
    let mut points = Vec::new();
    for own in sides {
        points.extend(plane(low, own, dice));
        points.extend(plane(high, own.map(|side| side.map(|x| -x)), dice));
    }
    points
}

fn pipe((middle, direction, radius, half): Pipe, dice: &mut Dice) -> Vec<Vector3<f64>> {
    let direction = Vector3::from(direction).normalize();
    let x = direction.cross(&Vector3::new(0.3, 0.5, 0.7)).normalize();
    let y = direction.cross(&x);
    let count = (DENSITY * 4.0 * std::f64::consts::PI * radius * half) as usize;
    let mut point = || {
        let turn = dice.between(0.0, std::f64::consts::TAU);
        let r = radius + dice.between(-NOISE, NOISE);
        let along = direction * dice.between(-half, half);
        Vector3::from(middle) + x * (r * turn.cos()) + y * (r * turn.sin()) + along
    };
    (0..count).map(|_| point()).collect()
}

/// The room with its pipes and a cupboard.
fn room(dice: &mut Dice) -> Vec<Vector3<f64>> {
    let mut points = box_of([-3.0, -3.0, 0.0], [6.0, 6.0, 3.0], dice);
    points.extend(box_of([1.8, -1.6, 0.0], [0.8, 0.5, 1.2], dice));
    PIPES.iter().for_each(|own| points.extend(pipe(*own, dice)));
    points
}

fn detect(points: &[Vector3<f64>], threads: usize) -> Scene {
    let points: Vec<[f64; 3]> = points.iter().map(|point| (*point).into()).collect();
    let mut detector = Detector::new();
    detector.set_options(DetectorOptions { threads, ..DetectorOptions::default() }).unwrap();
    detector.detect_points(&PointsView::from_f64(&points)).unwrap()
}

/// What a pipe is found as, in a cloud that was moved by an offset.
fn found<'a>(scene: &'a Scene, pipe: &Pipe, offset: &Vector3<f64>) -> Vec<&'a Cylinder> {
    found_within(scene, pipe, offset, 0.01)
}

/// The same with a radius that is off by this part of it at most.
fn found_within<'a>(scene: &'a Scene, pipe: &Pipe, offset: &Vector3<f64>, error: f64) -> Vec<&'a Cylinder> {
    let (middle, direction, radius, _) = pipe;
    let truth = Cylinder::new(Vector3::from(*middle) + offset, Vector3::from(*direction), *radius).unwrap();
    let is = |found: &&Cylinder| {
        let angle = found.axis.direction.cross(&truth.axis.direction).norm();
        let off = found.axis.distance(&truth.axis.point);
        angle < 0.01 && off < 0.1 * radius && (found.radius / radius - 1.0).abs() < error
    };
    scene.cylinders.iter().map(|found| &found.result.cylinder).filter(is).collect()
}

/// The origin may be anywhere: among the bodies, beside them, or far away.
#[test]
fn pipes_in_a_room_are_found_wherever_its_origin_is() {
    let points = room(&mut Dice::new(21));
    let far = [[4000.0, 5000.0, 120.0], [5e6, 4e6, 7e6]];
    for offset in [[0.0; 3], [3.0, 3.0, 0.0], [0.3, -0.2, 40.0]].into_iter().chain(far) {
        let offset = Vector3::from(offset);
        let moved: Vec<Vector3<f64>> = points.iter().map(|point| point + offset).collect();
        let scene = detect(&moved, 1);
        for pipe in &PIPES {
            assert_eq!(found(&scene, pipe, &offset).len(), 1, "{offset:?} {pipe:?}: {:?}", scene.cylinders);
        }
        let bodies: Vec<&Cylinder> = scene.cylinders.iter().map(|found| &found.result.cylinder).collect();
        assert_eq!(bodies.len(), PIPES.len(), "{offset:?}: {bodies:?}");
    }
}

/// In the coordinates of a robot or a map the densities of the points tell from where they were seen, in whatever order they are.
#[test]
fn what_a_sensor_saw_shows_the_same_bodies_in_other_coordinates() {
    let points = fits::cloud_of_scene();
    let detect = |points: &[[f64; 3]]| Detector::new().detect_points(&PointsView::from_f64(points)).unwrap();
    let there = detect(&points);
    assert_eq!(there.cylinders.len(), 5);
    let rotation = Rotation3::new(Vector3::new(0.9, -0.8, 1.3)).into_inner();
    for position in [[0.4, 0.0, -0.3], [3.0, -2.0, 1.0], [-4e5, 5e6, 120.0]] {
        let motion = RigidMotion::new(rotation, position.into()).unwrap();
        let mut moved: Vec<[f64; 3]> = points.iter().map(|p| motion.point(&(*p).into()).into()).collect();
        let stride = moved.len() / 7 * 3 + 1;
        for k in 0..moved.len() {
            moved.swap(k, k * stride % points.len());
        }
        let here = detect(&moved);
        assert_eq!(here.cylinders.len(), 5, "{position:?}");
        for found in &there.cylinders {
            let expected = motion.cylinder(&found.result.cylinder);
            let is_same = |cylinder: &Cylinder| {
                let change = expected.compare(cylinder);
                change.angle < 0.05
                    && change.axis_distance < 0.1 * expected.radius
                    && change.radius_relative.abs() < 0.1
            };
            let same = here.cylinders.iter().filter(|found| is_same(&found.result.cylinder));
            assert_eq!(same.count(), 1, "{position:?}: {:?}", here.cylinders);
        }
    }
}

/// A floor on which a pipe lies runs into its surface where they touch.
#[test]
fn points_of_a_floor_do_not_draw_a_pipe_that_lies_on_it() {
    let (radius, half) = (0.1, 0.3);
    let lying: Pipe = ([0.0, 0.0, radius], [0.0, 1.0, 0.0], radius, half);
    for seed in 0..5 {
        let dice = &mut Dice::new(seed);
        let mut points = pipe((lying.0, lying.1, radius, 4.0 * half), dice);
        points.iter_mut().for_each(|point| point.y *= 0.25);
        // The side that two sensors see, down to the floor.
        points.retain(|point| point.x > 0.25 * radius);
        points.extend(plane([-0.1, -half, 0.0], [[0.4, 0.0, 0.0], [0.0, 2.0 * half, 0.0]], dice));
        let scene = detect(&points, 1);
        let [found] = &scene.cylinders[..] else { panic!("{seed}: {:?}", scene.cylinders) };
        let stated = found.result.uncertainty.as_ref().unwrap().radius();
        let off = (found.result.cylinder.radius - radius).abs();
        assert!(off < 3.0 * stated && stated < 0.003 * radius, "{seed}: {off} {stated}");
    }
}

/// Noise of each point's own, of 4 % of the radius, is no reason to leave out what lies next to the limbs.
#[test]
fn noise_of_each_point_makes_no_pipe_thinner() {
    for seed in 1..=4 {
        let mut dice = Dice::new(seed);
        let own: Pipe = ([0.0, 0.0, 1.0], [1.0, 0.2, 0.1], 0.05, 0.3);
        let truth = Cylinder::new(Vector3::from(own.0), Vector3::from(own.1), own.2).unwrap();
        let mut points = Vec::new();
        while points.len() < 20_000 {
            let ray = Vector3::new(dice.between(-0.3, 0.3), dice.between(-0.15, 0.15), 1.0).normalize();
            if let Some(hit) = truth.first_hit(&ray)
                && truth.axis.position_of(&hit).abs() < own.3
            {
                points.push(hit + ray * (0.04 * own.2 * dice.normal()));
            }
        }
        let scene = detect(&points, 1);
        assert_eq!(
            found_within(&scene, &own, &Vector3::zeros(), 0.01).len(),
            1,
            "{seed}: {:?}",
            scene.cylinders
        );
    }
}

/// Each look takes what it finds from those after it, in the same order for any number of threads.
#[test]
fn many_looks_give_the_same_bits_for_any_number_of_threads() {
    let points = room(&mut Dice::new(22));
    let [one, three] = [1, 3].map(|threads| detect(&points, threads));
    assert_eq!(one.labels, three.labels);
    let bits = |scene: &Scene| -> Vec<u64> {
        scene.cylinders.iter().map(|found| found.result.cylinder.radius.to_bits()).collect()
    };
    assert_eq!(bits(&one), bits(&three));
    for (index, found) in one.cylinders.iter().enumerate() {
        assert_eq!(one.indices(index).count(), found.pixels);
    }
}

/// Eight pipes side by side before a wall, ten pixels wide each, as a scanner sees them that looks along z.
fn rack() -> (Vec<Pipe>, Vec<Vector3<f64>>) {
    const STEP: f64 = 0.0015;
    let pipes: Vec<Pipe> =
        (0..8).map(|k| ([0.0, 0.1 * f64::from(k) - 0.35, 4.0], [1.0, 0.0, 0.0], 0.03, 1.0)).collect();
    let mut dice = Dice::new(28);
    let mut points = Vec::new();
    for row in -120..120 {
        for column in -100..100 {
            let [x, y] = [column, row].map(|k| (f64::from(k) + 0.5) * STEP);
            let ray = Vector3::new(x, y, 1.0).normalize();
            let across = ray.yz().norm_squared();
            let meets = |([_, y, z], _, radius, _): &Pipe| {
                let along = ray.y * y + ray.z * z;
                let root = along * along - across * (y * y + z * z - radius * radius);
                if root > 0.0 { (along - root.sqrt()) / across } else { f64::INFINITY }
            };
            let far = pipes.iter().map(meets).fold(4.4 / ray.z, f64::min);
            points.push(ray * (far + dice.between(-0.001, 0.001)));
        }
    }
    (pipes, points)
}

/// Each point of a scanner has an error of its own, so that finer cells lose nothing. In other coordinates the origin may lie in front of
/// all points and has not seen them for all that.
#[test]
fn thin_pipes_of_a_scan_are_found_in_the_frame_of_the_scanner_and_in_others() {
    let (pipes, points) = rack();
    for offset in [[0.0; 3], [1.0, 12.0, 4.0]].map(Vector3::from) {
        let moved: Vec<Vector3<f64>> = points.iter().map(|point| point + offset).collect();
        let scene = detect(&moved, 1);
        let bodies: Vec<&Cylinder> = scene.cylinders.iter().map(|found| &found.result.cylinder).collect();
        for pipe in &pipes {
            let count = found_within(&scene, pipe, &offset, 0.05).len();
            assert_eq!(count, 1, "{offset:?} {pipe:?}: {bodies:?}");
        }
        assert_eq!(bodies.len(), pipes.len(), "{offset:?}: {bodies:?}");
    }
}

/// Trunks taper, lean and sway: each is a cylinder for a piece. The sky above them leaves half of what a scanner sees empty.
#[test]
fn trunks_around_a_scanner_are_found_by_pieces() {
    /// Where it stands, its radius at the height of the scanner, and how it leans.
    const TRUNKS: [([f64; 2], f64, [f64; 2]); 6] = [
        ([3.0, 1.0], 0.12, [0.03, -0.02]),
        ([-2.0, 4.0], 0.2, [-0.04, 0.01]),
        ([-5.0, -2.0], 0.25, [0.02, 0.05]),
        ([1.0, -6.0], 0.18, [0.0, 0.03]),
        ([6.0, -4.0], 0.28, [-0.03, -0.03]),
        ([5.0, 5.0], 0.22, [0.05, 0.0]),
    ];
    const STEP: f64 = 0.25;
    let axis_at = |([x, y], _, [a, b]): &([f64; 2], f64, [f64; 2]), z: f64| {
        let sway = 0.04 * (z / 3.0).sin();
        [x + a * z + sway, y + b * z - sway]
    };
    let radius_at = |radius: f64, z: f64| radius - 0.008 * z;
    let mut dice = Dice::new(27);
    let mut points = Vec::new();
    for turn in 0..(360.0 / STEP) as u32 {
        for rise in 0..(100.0 / STEP) as u32 {
            let [turn, rise] = [f64::from(turn) * STEP, f64::from(rise) * STEP - 45.0].map(f64::to_radians);
            let ray = Vector3::new(turn.cos() * rise.cos(), turn.sin() * rise.cos(), rise.sin());
            // The floor is 1.6 m below; each trunk is met where its section at the height of the ray is.
            let floor = if ray.z < 0.0 { -1.6 / ray.z } else { f64::INFINITY };
            let trunk = |trunk: &([f64; 2], f64, [f64; 2])| {
                let (mut far, across) = (f64::INFINITY, ray.xy().norm_squared());
                let mut z = 0.0;
                for _ in 0..6 {
                    let [x, y] = axis_at(trunk, z);
                    let (along, radius) = (ray.x * x + ray.y * y, radius_at(trunk.1, z));
                    let root = along * along - across * (x * x + y * y - radius * radius);
                    if root < 0.0 {
                        return f64::INFINITY;
                    }
                    far = (along - root.sqrt()) / across;
                    z = ray.z * far;
                }
                if far > 0.0 && z < 7.0 { far } else { f64::INFINITY }
            };
            let far = TRUNKS.iter().map(trunk).fold(floor, f64::min) + dice.between(-0.004, 0.004);
            if far < 20.0 {
                points.push(ray * far);
            }
        }
    }
    let scene = detect(&points, 0);
    let is_of = |found: &Cylinder, trunk: &([f64; 2], f64, [f64; 2]), z: f64| {
        let [x, y] = axis_at(trunk, z);
        let off = found.axis.distance(&Vector3::new(x, y, z));
        off < 0.3 * trunk.1 && (found.radius / radius_at(trunk.1, z) - 1.0).abs() < 0.15
    };
    let of_scene = || {
        scene.cylinders.iter().map(|found| (&found.result.cylinder, found.extent.as_ref().unwrap().center.z))
    };
    for trunk in &TRUNKS {
        let count = of_scene().filter(|(found, z)| is_of(found, trunk, *z)).count();
        assert!((1..=2).contains(&count), "{trunk:?}: {count} of {:?}", of_scene().collect::<Vec<_>>());
    }
    let others = of_scene().filter(|(found, z)| !TRUNKS.iter().any(|trunk| is_of(found, trunk, *z)));
    assert_eq!(others.count(), 0, "{:?}", of_scene().collect::<Vec<_>>());
}

/// What fills a surface's reach evenly is none: cylinders that were cut out of noise had scores of up to 0.98.
#[test]
fn noise_in_a_cube_is_no_cylinder() {
    let mut dice = Dice::new(24);
    let noise: Vec<Vector3<f64>> =
        (0..400_000).map(|_| Vector3::from_fn(|_, _| dice.between(-1.0, 1.0))).collect();
    let scene = detect(&noise, 1);
    assert!(scene.cylinders.is_empty(), "{:?}", scene.cylinders);
}

/// Boxes alone: their edges are looked at from all sides, and are none.
#[test]
fn boxes_from_all_sides_are_no_cylinders() {
    let mut dice = Dice::new(23);
    let mut points = plane([-3.0, -3.0, 0.0], [[6.0, 0.0, 0.0], [0.0, 6.0, 0.0]], &mut dice);
    for k in 0..6 {
        let place = f64::from(k);
        let size = [dice.between(0.1, 0.8), dice.between(0.1, 0.8), dice.between(0.3, 2.0)];
        points.extend(box_of([place - 2.8, 2.0 * (place * 1.7).sin(), 0.0], size, &mut dice));
    }
    let scene = detect(&points, 1);
    assert!(scene.cylinders.is_empty(), "{:?}", scene.cylinders);
}
