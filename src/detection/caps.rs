//! Caps: planes in a mask that are as wide as the body across which they lie.

use super::candidate::Scene;
use super::moments::Moments;
use super::region::OUTSIDE;
use super::surface::{REACH, Surface};
use crate::geometry::{Cylinder, CylinderLimits, Line, any_orthogonal};
use crate::memory::List;
use nalgebra::{Matrix2, Vector2, Vector3};
use std::collections::BTreeMap;

/// The least ratio of the variances of a cap along its longer and its shorter diameter. Of 920 objects of the twin five caps had 0.80
/// and more, what was seen of the front of a body 0.35 at most.
const LEAST_ROUND: f64 = 0.6;

/// Cylinders as wide as their caps: the planes in the mask that may be one.
pub(super) fn bodies(scene: &Scene<'_>, planes: &[u16], limits: &CylinderLimits) -> List<Cylinder> {
    let mut caps: BTreeMap<u16, List<usize>> = BTreeMap::new();
    for (k, &plane) in planes.iter().enumerate().filter(|(_, plane)| !matches!(**plane, 0 | OUTSIDE)) {
        caps.entry(plane).or_default().push(k);
    }
    let bodies = caps.values().filter_map(|cap| body_of_cap(scene, cap));
    bodies.filter(|body| limits.contain(body)).collect()
}

/// Of the bodies of caps the one on which most of what else is in the mask lies. Where a body is seen nearly along its axis, the
/// little that is seen of it bends less than the noise.
pub(super) fn most_covered(scene: &Scene<'_>, bodies: &[Cylinder], open: &[usize]) -> Option<Cylinder> {
    let on = |body: &Cylinder| {
        let misfits = scene.misfits(&Surface::Cylinder(*body, 0.0), open);
        misfits.iter().filter(|misfit| **misfit <= REACH * REACH).count()
    };
    let (most, body) = bodies.iter().map(|body| (on(body), body)).max_by_key(|(on, _)| *on)?;
    (2 * most > open.len()).then_some(*body)
}

/// The cylinder whose cap some cells are, if all of it is seen.
fn body_of_cap(scene: &Scene<'_>, cap: &[usize]) -> Option<Cylinder> {
    let (plane, _) = Moments::new(scene.grid, cap).plane()?;
    // w = a + b x + c y is 1 = b X + c Y + a Z.
    let direction = Vector3::new(plane.y, plane.z, plane.x).try_normalize(0.0)?;
    let points = || cap.iter().map(|&k| scene.grid.cells[k].point);
    let middle = points().sum::<Vector3<f64>>() / cap.len() as f64;
    let (u, v) = any_orthogonal(&direction);
    let across = |p: Vector3<f64>| Vector2::new((p - middle).dot(&u), (p - middle).dot(&v));
    let square = |p: Vector3<f64>| across(p) * across(p).transpose();
    let spread = (points().map(square).sum::<Matrix2<f64>>() / cap.len() as f64).symmetric_eigenvalues();
    // The mean square distance from any diameter of a disc is a quarter of the square of its radius.
    let radius = 2.0 * spread.mean().sqrt();
    let round = spread.min() >= LEAST_ROUND * spread.max();
    round.then_some(Cylinder { axis: Line { point: middle, direction }, radius })
}
