//! What a person or a network would say of one cylinder: a mask and two edges, and the true ones.

use super::random::{Purpose, Stream};
use super::sampling::blur;
use super::scene::TrueCylinder;
use crate::camera::Camera;
use nalgebra::{Vector2, Vector3};

/// Standard deviation in pixels of the blur through which a mask is moved.
const SMEAR: f64 = 1.5;

/// The two visible limbs of a cylinder from end to end, each by its two points in pixels, of the (distorted) image;
/// `None` where the camera is inside it or a point is behind the camera.
#[must_use]
pub fn true_edges(truth: &TrueCylinder, camera: &Camera) -> Option<[[Vector2<f64>; 2]; 2]> {
    let axis = &truth.cylinder.axis;
    let nearest = axis.nearest_to_origin();
    let distance = nearest.norm();
    let sine = truth.cylinder.radius / distance;
    if !(sine < 1.0) {
        return None;
    }
    let facing = -nearest / distance;
    let aside = axis.direction.cross(&facing);
    let project = |side: f64, end: f64| {
        // Where a plane through the camera touches.
        let across = facing * sine + aside * (side * (1.0 - sine * sine).sqrt());
        let point =
            truth.center + across * truth.cylinder.radius + axis.direction * (end * 0.5 * truth.length);
        camera.project(&point)
    };
    let edge = |side: f64| Some([project(side, -1.0)?, project(side, 1.0)?]);
    Some([edge(1.0)?, edge(-1.0)?])
}

/// The part of a segment inside the image; `None` where there is none.
#[must_use]
pub fn clipped(edge: &[Vector2<f64>; 2], (width, height): (usize, usize)) -> Option<[Vector2<f64>; 2]> {
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    let along = edge[1] - edge[0];
    for (axis, size) in [(0, width), (1, height)] {
        let [a, b] = [-0.5, size as f64 - 0.5].map(|border| (border - edge[0][axis]) / along[axis]);
        if along[axis] == 0.0 {
            if !(edge[0][axis] >= -0.5 && edge[0][axis] <= size as f64 - 0.5) {
                return None;
            }
            continue;
        }
        from = from.max(a.min(b));
        to = to.min(a.max(b));
    }
    (from < to).then(|| [edge[0] + along * from, edge[0] + along * to])
}

/// Edges as a hand sets them: shorter than the limbs, each end off by 0.2 to 1 pixel.
#[must_use]
pub fn hand_set(edges: &[[Vector2<f64>; 2]; 2], size: (usize, usize), seed: u64) -> Vec<[Vector2<f64>; 2]> {
    let mut stream = Stream::new(seed, Purpose::Annotation);
    let sigma = stream.log_between(0.2, 1.0);
    let mut off = |p: Vector2<f64>| p + Vector2::new(stream.normal(), stream.normal()) * sigma;
    let inner = |[a, b]: [Vector2<f64>; 2]| [a.lerp(&b, 0.02), a.lerp(&b, 0.98)];
    edges.iter().filter_map(|edge| clipped(edge, size)).map(|edge| inner(edge).map(&mut off)).collect()
}

/// A mask as a person draws it: its boundary is off by up to a pixel all round, and by 0.8 pixels here and there.
#[must_use]
pub fn drawn_mask(body: &[bool], (width, height): (usize, usize), seed: u64) -> Vec<u8> {
    let mut stream = Stream::new(seed ^ 1, Purpose::Annotation);
    let bias = stream.between(-1.0, 1.0);
    let mut smeared: Vec<[f64; 1]> = body.iter().map(|inside| [f64::from(u8::from(*inside))]).collect();
    blur(&mut smeared, (width, height), SMEAR);
    let mut wander: Vec<[f64; 1]> = body.iter().map(|_| [stream.normal()]).collect();
    const LENGTH: f64 = 6.0;
    blur(&mut wander, (width, height), LENGTH);
    // A blur of white noise leaves the deviation 1 / (2 σ √π).
    let strength = 0.8 * 2.0 * LENGTH * std::f64::consts::PI.sqrt();
    let inside = |(value, wander): (&[f64; 1], &[f64; 1])| {
        // A straight edge moves by x pixels where the threshold is that of the blurred step at −x.
        let shift = bias + strength * wander[0];
        let threshold = 0.5 * libm::erfc(shift / (SMEAR * std::f64::consts::SQRT_2));
        if value[0] > threshold.clamp(0.02, 0.98) { 255 } else { 0 }
    };
    smeared.iter().zip(&wander).map(inside).collect()
}

/// Whether an end of a cylinder is in the image and nothing hides its rim: most of the near half of it.
#[must_use]
pub(super) fn end_seen(
    truth: &TrueCylinder,
    camera: &Camera,
    side: f64,
    visible: impl Fn(&Vector3<f64>) -> bool,
) -> bool {
    const SAMPLES: usize = 24;
    let axis = &truth.cylinder.axis;
    let facing = -axis.nearest_to_origin().normalize();
    let aside = axis.direction.cross(&facing);
    // A little inside of the end, where a lid does not stand in front of it.
    let middle = truth.center + axis.direction * (side * (0.5 * truth.length - 0.01 * truth.cylinder.radius));
    let seen = |k: usize| {
        let (sine, cosine) =
            libm::sincos(std::f64::consts::PI * ((k as f64 + 0.5) / SAMPLES as f64 - 0.5) * 0.9);
        let point = middle + (facing * cosine + aside * sine) * truth.cylinder.radius;
        camera.project(&point).is_some_and(|pixel| camera.contains(&pixel)) && visible(&point)
    };
    (0..SAMPLES).filter(|k| seen(*k)).count() * 10 >= SAMPLES * 9
}
