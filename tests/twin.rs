//! The twin against closed forms of its geometry, and against what is known of its sensors.
#![cfg(feature = "twin")]
#![allow(clippy::unwrap_used, reason = "a test program")]

use cylfuse::camera::{Camera, Distortion, Intrinsics};
use cylfuse::geometry::{Cylinder, RigidMotion};
use cylfuse::observations::DepthCamera;
use cylfuse::twin::{
    ActiveStereo, Body, CaptureOptions, DepthSensor, Kind, Material, Part, PictureOptions, Scene, Shape,
    StructuredLight, TimeOfFlight, Viewpoint, capture, exact_depth, random_scene,
};
use nalgebra::{Matrix3, Vector2, Vector3};

fn camera(distortion: Distortion) -> Camera {
    let (width, height) = (640, 480);
    Camera::new(Intrinsics { width, height, fx: 570.0, fy: 570.0, cx: 319.5, cy: 239.5, distortion }).unwrap()
}

fn body(object: u16, shape: Shape, rotation: Matrix3<f64>, at: Vector3<f64>) -> Body {
    let pose = RigidMotion::new(rotation, at).unwrap();
    Body { object, shape, pose, material: Material::default(), measured: false }
}

fn scene(bodies: Vec<Body>) -> Scene {
    Scene { bodies, lamp: Vector3::new(0.5, -1.0, 0.0), ambient: 0.4, ..Scene::default() }
}

/// A wall that faces the camera.
fn wall(z: f64) -> Body {
    body(0, Shape::Plane, Matrix3::identity(), Vector3::new(0.0, 0.0, z))
}

/// A box of 12 cm before it: its sides are edges at one depth.
fn block(z: f64) -> Body {
    let shape = Shape::Box { half: Vector3::new(0.061, 0.06, 0.02) };
    body(1, shape, Matrix3::identity(), Vector3::new(0.0, 0.0, z + 0.02))
}

/// The depth of a sensor on the grid of its own camera, and that camera.
fn measured(sensor: &DepthSensor, scene: &Scene) -> (Vec<f32>, DepthCamera) {
    let own = sensor.camera().unwrap().unwrap();
    (sensor.measure(scene, &own, 5), own)
}

#[test]
fn exact_depth_is_that_of_the_closed_form() {
    let mut checked = [0; 3];
    for (seed, lens) in (0..6).flat_map(|seed| [(seed, 0.0), (seed, 0.1)]) {
        let camera = camera(Distortion::brown_conrady(&[lens, -0.02, 0.001, 0.0005]).unwrap());
        let scene = random_scene(if seed % 2 == 0 { Kind::Table } else { Kind::Pipes }, seed).unwrap();
        let depth =
            exact_depth(&scene, &DepthCamera { camera: camera.clone(), to_color: RigidMotion::identity() });
        let eye = Viewpoint::new(&scene, Vector3::zeros());
        for k in (0..depth.len()).step_by(7) {
            let ray = camera.unproject(&Vector2::new((k % 640) as f64, (k / 640) as f64)).unwrap();
            let Some(hit) = eye.look(&ray) else { continue };
            let body = &scene.bodies[hit.body];
            let expected = match (body.shape, hit.part) {
                (Shape::Turned { radii, .. }, Part::Body) if radii[0] == radii[1] => {
                    let axis = body.pose.rotation().column(2).into_owned();
                    let cylinder = Cylinder::new(*body.pose.translation(), axis, radii[0]).unwrap();
                    checked[0] += 1;
                    cylinder.first_hit(&ray).unwrap().z
                }
                (Shape::Plane, _) => {
                    let normal = body.pose.rotation().column(2).into_owned();
                    checked[1] += 1;
                    normal.dot(body.pose.translation()) / normal.dot(&ray)
                }
                (Shape::Sphere { radius }, _) => {
                    let center = body.pose.translation();
                    let (a, b) = (ray.norm_squared(), ray.dot(center));
                    checked[2] += 1;
                    (b - (b * b - a * (center.norm_squared() - radius * radius)).sqrt()) / a
                }
                _ => continue,
            };
            assert!(
                (depth[k] / expected - 1.0).abs() < 1e-6,
                "seed {seed}, pixel {k}: {} {expected}",
                depth[k]
            );
        }
    }
    assert!(checked.iter().all(|count| *count > 100), "{checked:?}");
}

/// Measured pixels and all in columns and rows.
fn share(
    depth: &[f32],
    columns: std::ops::Range<usize>,
    rows: std::ops::Range<usize>,
    good: impl Fn(f32) -> bool,
) -> f64 {
    let all = columns.len() * rows.len();
    let count = rows.map(|y| columns.clone().filter(|x| good(depth[y * 640 + x])).count()).sum::<usize>();
    count as f64 / all as f64
}

/// Where the block of a scene begins and ends along the middle row of the depth camera.
fn block_columns(own: &DepthCamera, z: f64) -> [usize; 2] {
    let to_own = own.to_color.inverse();
    [-0.061, 0.061].map(|x| {
        let corner = to_own.point(&Vector3::new(x, 0.0, z));
        own.camera.project(&corner).unwrap().x.round() as usize
    })
}

#[test]
fn structured_light_is_blind_in_the_shadow_of_its_projector() {
    let sensor = DepthSensor::StructuredLight(StructuredLight::default());
    let (depth, own) = measured(&sensor, &scene(vec![wall(1.0), block(0.7)]));
    let [left, right] = block_columns(&own, 0.7);
    // The projector stands to the right: its shadow, f b (1 / 0.7 − 1) = 18 pixels, falls to the left of the block.
    let missing = |columns| share(&depth, columns, 220..260, |z| z == 0.0);
    assert!(missing(left - 14..left - 6) > 0.9, "{}", missing(left - 14..left - 6));
    assert!(missing(right + 10..right + 24) < 0.05);
    assert!(missing(left + 8..right - 8) < 0.05);
    assert!(missing(left - 60..left - 30) < 0.05);
}

#[test]
fn structured_light_fattens_what_is_in_front() {
    let sensor = DepthSensor::StructuredLight(StructuredLight::default());
    let (depth, own) = measured(&sensor, &scene(vec![wall(1.0), block(0.7)]));
    let [_, right] = block_columns(&own, 0.7);
    let near = |columns| share(&depth, columns, 220..260, |z| (z - 0.7).abs() < 0.05);
    assert!(near(right + 1..right + 3) > 0.2, "{}", near(right + 1..right + 3));
    assert_eq!(near(right + 10..right + 20), 0.0);
}

#[test]
fn pixels_fly_at_edges_of_time_of_flight_and_nowhere_else() {
    let sensor = TimeOfFlight { scatter: 0.0, ..TimeOfFlight::default() };
    let (depth, own) = measured(&DepthSensor::TimeOfFlight(sensor), &scene(vec![wall(1.0), block(0.7)]));
    let [left, _] = block_columns(&own, 0.7);
    let between = |columns| share(&depth, columns, 220..260, |z| z > 0.73 && z < 0.97);
    assert!(between(left - 1..left + 2) > 0.2, "{}", between(left - 1..left + 2));
    assert_eq!(between(left + 6..left + 40) + between(left - 40..left - 6), 0.0);
}

#[test]
fn scatter_pulls_what_is_far_towards_what_is_near() {
    // Half a metre is less than half of a period, 0.75 m; light from farther in front would push.
    let scene = scene(vec![wall(1.0), block(0.5)]);
    let mean = |scatter| {
        let sensor = TimeOfFlight { scatter, ..TimeOfFlight::default() };
        let (depth, own) = measured(&DepthSensor::TimeOfFlight(sensor), &scene);
        let [left, _] = block_columns(&own, 0.5);
        let row = &depth[240 * 640 + left - 60..240 * 640 + left - 20];
        f64::from(row.iter().sum::<f32>()) / row.len() as f64
    };
    let (clear, hazy) = (mean(0.0), mean(0.02));
    assert!((clear - 1.0).abs() < 0.003 && hazy < clear - 0.002, "{clear} {hazy}");
}

/// The standard deviation of the depth of a wall that leans a little, about its plane.
fn noise_of_a_wall(sensor: &DepthSensor, distance: f64) -> f64 {
    let lean = Matrix3::new(0.98, 0.0, 0.198_997_487_421, 0.0, 1.0, 0.0, -0.198_997_487_421, 0.0, 0.98);
    let scene = scene(vec![body(0, Shape::Plane, lean, Vector3::new(0.0, 0.0, distance))]);
    let (depth, own) = measured(sensor, &scene);
    let exact = exact_depth(&scene, &own);
    let middle = (160..320).flat_map(|y| (220..420).map(move |x| y * 640 + x)).filter(|k| depth[*k] > 0.0);
    let errors: Vec<f64> = middle.map(|k| f64::from(depth[k]) - exact[k]).collect();
    assert!(errors.len() > 20_000, "{} measured at {distance} m", errors.len());
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    // A plane has no bias; a tenth of a disparity step would be one.
    assert!(mean.abs() < 0.002 * distance * distance, "bias of {mean} at {distance} m");
    (errors.iter().map(|e| (e - mean) * (e - mean)).sum::<f64>() / errors.len() as f64).sqrt()
}

#[test]
fn noise_grows_with_the_square_of_the_distance() {
    for sensor in [
        DepthSensor::StructuredLight(StructuredLight::default()),
        DepthSensor::ActiveStereo(ActiveStereo::default()),
        DepthSensor::TimeOfFlight(TimeOfFlight { scatter: 0.0, ..TimeOfFlight::default() }),
    ] {
        let [near, far] = [0.7, 1.4].map(|distance| noise_of_a_wall(&sensor, distance));
        assert!((0.0001..0.005).contains(&near), "{near} {sensor:?}");
        // Twice the distance: four times the noise for triangulation and for a phase beside other light, twice for the
        // noise of the signal alone.
        assert!((1.9..7.0).contains(&(far / near)), "{near} {far} {sensor:?}");
    }
}

/// A sum that changes with every bit (FNV-1a).
fn checksum(bytes: impl Iterator<Item = u8>) -> u64 {
    bytes.fold(0xcbf2_9ce4_8422_2325, |sum, byte| (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

#[test]
fn alike_bodies_touch_and_never_overlap() {
    for seed in 0..40 {
        let cylinders = random_scene(Kind::Alike, seed).unwrap().cylinders;
        let radius = cylinders[0].cylinder.radius;
        let apart = |k: usize| {
            let axes = cylinders.iter().map(|truth| truth.cylinder.axis);
            let others = axes.enumerate().filter(|(other, _)| *other != k);
            others
                .map(|(_, axis)| cylinders[k].cylinder.axis.distance_to_line(&axis))
                .fold(f64::INFINITY, f64::min)
        };
        for k in 0..cylinders.len() {
            let gap = apart(k) / radius - 2.0;
            assert!((-1e-9..0.4).contains(&gap), "{seed}: {gap}");
        }
    }
}

#[test]
fn frames_never_change() {
    let sums = [
        (Kind::Table, DepthSensor::StructuredLight(StructuredLight::default())),
        (Kind::Pipes, DepthSensor::TimeOfFlight(TimeOfFlight::default())),
        (Kind::Single, DepthSensor::ActiveStereo(ActiveStereo::default())),
        (Kind::NoCylinders, DepthSensor::Exact),
        (Kind::Alike, DepthSensor::Exact),
    ]
    .map(|(kind, sensor)| {
        let picture = PictureOptions { gamma: 2.2, ..PictureOptions::default() };
        let options = CaptureOptions { camera: camera(Distortion::None), picture, sensor, registered: true };
        let frame = capture(&random_scene(kind, 4).unwrap(), &options, 4).unwrap();
        let depth = frame.depth.iter().flat_map(|z| z.to_le_bytes());
        let labels = frame.labels.iter().flat_map(|label| label.to_le_bytes());
        checksum(frame.image.iter().copied().chain(depth).chain(labels))
    });
    assert_eq!(
        sums,
        [
            1086396921322813189,
            17112717579149680572,
            6274761176693163350,
            544333533049806689,
            15904920342636176916
        ]
    );
}
