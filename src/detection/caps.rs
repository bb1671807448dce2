//! Caps: planes in a mask that are as wide as the body across which they lie.

use super::candidate::Scene;
use super::grid::Grid;
use super::moments::Moments;
use super::surface::{REACH, Surface};
use crate::geometry::{Cylinder, CylinderLimits, Line, any_orthogonal};
use crate::memory::List;
use nalgebra::{Matrix2, Vector2, Vector3};
use std::collections::BTreeMap;

constants! {
    /// The least ratio of the variances of a cap along its shorter and its longer diameter. Of 920 objects of the twin five caps had 0.80
    /// and more, and what was seen of the front of a body 0.35 at most; this lies between.
    LEAST_ROUND = 0.6, "";

    /// The least part of a plane that lies in the mask: of a table or a wall no more than a strip does.
    LEAST_PART = 0.5, "";
}

/// Cylinders as wide as their caps: the planes in the mask that may be one.
pub(super) fn bodies(
    grid: &Grid,
    planes: &[u16],
    inside: impl Fn(usize) -> bool,
    limits: &CylinderLimits,
) -> List<Cylinder> {
    let mut all: BTreeMap<u16, List<usize>> = BTreeMap::new();
    for (k, &plane) in planes.iter().enumerate().filter(|(_, plane)| **plane > 0) {
        all.entry(plane).or_default().push(k);
    }
    let bodies = all.into_values().filter_map(|plane| {
        let cap: List<usize> = plane.iter().copied().filter(|&k| inside(k)).collect();
        let in_mask = cap.len() as f64 >= LEAST_PART.get() * plane.len() as f64;
        body_of_cap(grid, &cap).filter(|body| in_mask && limits.contain(body))
    });
    bodies.collect()
}

/// Of the bodies of caps the one on which most of what else is in the mask lies. Where a body is seen nearly along its axis, the
/// little that is seen of it bends less than the noise.
pub(super) fn most_covered(scene: &Scene<'_>, bodies: &[Cylinder], open: &[usize]) -> Option<Cylinder> {
    let on = |body: &Cylinder| {
        scene.effort.spend(open.len());
        let misfits = scene.misfits(&Surface::Cylinder(*body, 0.0), open);
        misfits.iter().filter(|misfit| **misfit <= REACH.get() * REACH.get()).count()
    };
    let (most, body) = bodies.iter().map(|body| (on(body), body)).max_by_key(|(on, _)| *on)?;
    (2 * most > open.len()).then_some(*body)
}

/// The cylinder across which a round cap lies.
fn body_of_cap(grid: &Grid, cap: &[usize]) -> Option<Cylinder> {
    let (plane, _) = Moments::new(grid, cap).plane()?;
    // w = a + b x + c y is 1 = b X + c Y + a Z.
    let direction = Vector3::new(plane.y, plane.z, plane.x).try_normalize(0.0)?;
    let points = || cap.iter().map(|&k| grid.cells[k].point);
    let middle = points().sum::<Vector3<f64>>() / cap.len() as f64;
    let (u, v) = any_orthogonal(&direction);
    let across = |p: Vector3<f64>| Vector2::new((p - middle).dot(&u), (p - middle).dot(&v));
    let square = |p: Vector3<f64>| across(p) * across(p).transpose();
    let spread = (points().map(square).sum::<Matrix2<f64>>() / cap.len() as f64).symmetric_eigenvalues();
    // The mean square distance from any diameter of a disc is a quarter of the square of its radius.
    let radius = 2.0 * spread.mean().sqrt();
    let round = spread.min() >= LEAST_ROUND.get() * spread.max();
    round.then_some(Cylinder { axis: Line { point: middle, direction }, radius })
}
