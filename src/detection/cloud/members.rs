//! Which points of a cloud lie on the cylinders that its image shows.

use super::{Asked, BETWEEN_QUESTIONS, Cloud, Image, OUTSIDE};
use crate::detection::{Detection, Detections};
use crate::error::Result;
use crate::geometry::Cylinder;
use crate::memory::List;
use crate::statistics::median_and_deviation;
use nalgebra::Vector3;

/// Points lie on a surface up to so many standard deviations from it.
const REACH: f64 = 4.0;

/// A cylinder that the wall which is seen gave is off by this part of its radius on the other side, at most: its radius and its axis both
/// are, by some percent.
const OFF: f64 = 0.15;

/// Points of a cloud that are enough to tell the reach: their distances would take as much memory as the points.
const SAMPLE: usize = 100_000;

/// A surface that was found, and how far from it its points lie at most.
struct Surface {
    cylinder: Cylinder,
    along: [f64; 2],
    reach: f64,
}

impl Surface {
    /// With the reach by some of its points.
    fn new(detection: &Detection, points: impl Iterator<Item = Vector3<f64>>) -> Self {
        let Detection { cylinder, along, .. } = *detection;
        Self { cylinder, along, reach: reach(&cylinder, points) }
    }

    /// How far a point lies from the surface, in parts of the reach; `None` beyond it, and beyond its ends.
    fn distance(&self, point: &Vector3<f64>) -> Option<f64> {
        let distance = self.cylinder.distance(point).abs();
        let along = self.cylinder.axis.position_of(point);
        let holds = distance <= self.reach && (self.along[0]..=self.along[1]).contains(&along);
        holds.then(|| distance / self.reach)
    }

    /// Whether a point lies on the wall that is seen.
    fn shows(&self, point: &Vector3<f64>) -> bool {
        let outward = point - self.cylinder.axis.nearest_to(point);
        (outward.norm() - self.cylinder.radius).abs() <= self.reach && outward.dot(point) < 0.0
    }
}

/// How far from the surface of a cylinder points lie at most, by some that do: by their scatter, and by how much the cylinder itself may
/// be off.
pub(crate) fn reach(cylinder: &Cylinder, points: impl Iterator<Item = Vector3<f64>>) -> f64 {
    let mut distances: List<f64> = points.map(|point| cylinder.distance(&point)).collect();
    let [off, scatter] = median_and_deviation(&mut distances);
    off.abs() + REACH * scatter
}

/// The surfaces of the cylinders that an image shows.
fn surfaces(points: &Cloud, image: &Image, seen: &Detections) -> Vec<Surface> {
    if image.closed {
        let surface = |detection: &Detection| {
            let Detection { cylinder, along, .. } = *detection;
            let about = Surface { cylinder, along, reach: OFF * cylinder.radius };
            let sample = points.usable().step_by(points.usable.div_ceil(SAMPLE).max(1));
            Surface::new(detection, sample.filter(|point| about.distance(point).is_some()))
        };
        return seen.cylinders.iter().map(surface).collect();
    }
    let none = points.len() as u32;
    let mut of_cylinders: Vec<Vec<u32>> = seen.cylinders.iter().map(|_| Vec::new()).collect();
    for (&label, &nearest) in seen.labels.iter().zip(&image.nearest) {
        if label != 0 && nearest != none {
            of_cylinders[usize::from(label) - 1].push(nearest);
        }
    }
    let points_of = |own: Vec<u32>| own.into_iter().map(|k| points.at(k as usize));
    let cylinders = seen.cylinders.iter().zip(of_cylinders);
    cylinders.map(|(detection, own)| Surface::new(detection, points_of(own))).collect()
}

/// The number of the cylinder of each point.
pub(super) fn labels(
    points: &Cloud,
    image: &Image,
    seen: &Detections,
    asked: &Asked<'_>,
) -> Result<Vec<u16>> {
    let mut labels = vec![0; points.len()];
    if seen.cylinders.is_empty() {
        return Ok(labels);
    }
    let surfaces = surfaces(points, image, seen);
    for (part, labels) in labels.chunks_mut(BETWEEN_QUESTIONS).enumerate() {
        asked()?;
        for (k, label) in (part * BETWEEN_QUESTIONS..).zip(labels) {
            *label = match image.closed {
                true => all_around(points, k, &surfaces),
                false => where_seen(points, k, image, seen, &surfaces),
            };
        }
    }
    Ok(labels)
}

/// The cylinder on whose surface a point lies, on whatever side.
fn all_around(points: &Cloud, k: usize, surfaces: &[Surface]) -> u16 {
    let point = points.at(k);
    let near = (1..).zip(surfaces).filter_map(|(label, surface)| Some((label, surface.distance(&point)?)));
    near.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(label, _)| label)
}

/// The cylinder that the pixel of a point sees. The nearest point is seen there; those behind it belong to something else, unless they are
/// as near as a pixel is wide, or lie on the same wall: the nearest points alone would be a wall that is too near.
fn where_seen(points: &Cloud, k: usize, image: &Image, seen: &Detections, surfaces: &[Surface]) -> u16 {
    let depths = &points.axes[2];
    let label = match image.pixels[k] {
        OUTSIDE => 0,
        pixel => seen.labels[pixel as usize],
    };
    if label == 0 {
        return 0;
    }
    let depth = depths[image.nearest[image.pixels[k] as usize] as usize];
    let beside = depths[k] - depth <= 2.0 * image.spacing * depth;
    if beside || surfaces[usize::from(label) - 1].shows(&points.at(k)) { label } else { 0 }
}
