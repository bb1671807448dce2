//! Which points of a cloud lie on the cylinders that its image shows.

use super::image::Image;
use super::points::Points;
use super::{BETWEEN_QUESTIONS, CancelCheck};
use crate::detection::{Detection, Detections};
use crate::error::Result;
use crate::geometry::Cylinder;
use crate::memory::List;
use crate::statistics::median_and_deviation;
use nalgebra::Vector3;
use std::ops::Range;

constants! {
    /// Points lie on a surface up to so many standard deviations from it.
    REACH = 4.0, "σ";

    /// A cylinder that the wall which is seen gave is off by this part of its radius on the other side, at most: its radius and its axis both
    /// are, by some percent.
    OFF = 0.15, "radius";
}

/// Points of a surface that are enough to tell the reach.
const SAMPLE: usize = 20_000;

/// Points that follow each other, of which none is asked where all are far from a surface.
const BLOCK: usize = 64;

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
    off.abs() + REACH.get() * scatter
}

/// A ball about points that follow each other.
struct Ball {
    middle: Vector3<f64>,
    radius: f64,
}

impl Ball {
    /// Those about all points of an image, block by block.
    fn all(points: &Points, image: &Image) -> Vec<Self> {
        let of_block = |first: usize| {
            let [low, high] = bounds(points, first..points.len().min(first + BLOCK));
            // A little more for what single precision leaves.
            let radius = 0.5005 * (high - low).norm();
            Self { middle: image.raster.pose.turn(&(0.5 * (low + high))), radius }
        };
        (0..points.len()).step_by(BLOCK).map(of_block).collect()
    }

    /// Whether it may have points of a surface.
    fn meets(&self, surface: &Surface) -> bool {
        surface.cylinder.distance(&self.middle).abs() <= surface.reach + self.radius
    }
}

/// The surfaces of the cylinders that a closed image shows, by points on all sides of them.
fn surfaces_all_around(points: &Points, image: &Image, seen: &Detections, balls: &[Ball]) -> Vec<Surface> {
    let surface = |detection: &Detection| {
        let Detection { cylinder, along, .. } = *detection;
        let about = Surface { cylinder, along, reach: OFF.get() * cylinder.radius };
        let near: Vec<usize> = (0..balls.len()).filter(|&block| balls[block].meets(&about)).collect();
        let step = (near.len() * BLOCK).div_ceil(SAMPLE).max(1);
        let of_block = |block: usize| block * BLOCK..points.len().min((block + 1) * BLOCK);
        let sample = near.into_iter().flat_map(of_block).step_by(step);
        let positions = sample.map(|k| image.raster.pose.turn(&points.at(k)));
        Surface::new(detection, positions.filter(|point| about.distance(point).is_some()))
    };
    seen.cylinders.iter().map(surface).collect()
}

/// The surfaces of the cylinders that an image shows, by the points that are seen.
fn surfaces(points: &Points, image: &Image, seen: &Detections) -> Vec<Surface> {
    let position = |k: usize| image.raster.pose.turn(&points.at(k));
    let mut of_cylinders: Vec<Vec<usize>> = seen.cylinders.iter().map(|_| Vec::new()).collect();
    for (pixel, &label) in seen.labels.iter().enumerate().filter(|(_, label)| **label != 0) {
        of_cylinders[usize::from(label) - 1].extend(image.point_at(pixel));
    }
    let cylinders = seen.cylinders.iter().zip(of_cylinders);
    cylinders.map(|(detection, own)| Surface::new(detection, own.into_iter().map(position))).collect()
}

/// The number of the cylinder of each point.
pub(super) fn labels(
    points: &Points,
    image: &Image,
    seen: &Detections,
    check_cancel: &CancelCheck<'_>,
) -> Result<Vec<u16>> {
    let mut labels = vec![0; points.len()];
    if image.closed {
        label_all_around(points, image, seen, &mut labels, check_cancel)?;
    } else {
        let surfaces = surfaces(points, image, seen);
        label_where_seen(points, image, (seen, &surfaces), &mut labels, check_cancel)?;
    }
    Ok(labels)
}

/// Gives points the cylinders on whose surfaces they lie, on whatever side.
fn label_all_around(
    points: &Points,
    image: &Image,
    seen: &Detections,
    labels: &mut [u16],
    check_cancel: &CancelCheck<'_>,
) -> Result<()> {
    let pose = &image.raster.pose;
    let balls = Ball::all(points, image);
    let surfaces = surfaces_all_around(points, image, seen, &balls);
    for (block, (labels, ball)) in labels.chunks_mut(BLOCK).zip(&balls).enumerate() {
        let first = block * BLOCK;
        if first.is_multiple_of(BETWEEN_QUESTIONS) {
            check_cancel()?;
        }
        let near: Vec<(u16, &Surface)> = (1..).zip(&surfaces).filter(|(_, own)| ball.meets(own)).collect();
        if near.is_empty() {
            continue;
        }
        for (k, label) in (first..).zip(labels) {
            let point = pose.turn(&points.at(k));
            let distances = near.iter().filter_map(|(label, own)| Some((*label, own.distance(&point)?)));
            *label = distances.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(label, _)| label);
        }
    }
    Ok(())
}

/// The box of some points of use that follow each other.
fn bounds(points: &Points, range: Range<usize>) -> [Vector3<f64>; 2] {
    let ends = points.axes.each_ref().map(|axis| {
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for x in &axis[range.clone()] {
            low = if *x < low { *x } else { low };
            high = if *x > high { *x } else { high };
        }
        [f64::from(low), f64::from(high)]
    });
    [0, 1].map(|end| Vector3::from(ends.map(|ends| ends[end])))
}

/// Gives points the cylinders that their pixels see. The nearest point is seen there; those behind it belong to something else, unless they
/// are as near as a pixel is wide, or lie on the same wall: the nearest points alone would be a wall that is too near.
fn label_where_seen(
    points: &Points,
    image: &Image,
    (seen, surfaces): (&Detections, &[Surface]),
    labels: &mut [u16],
    check_cancel: &CancelCheck<'_>,
) -> Result<()> {
    let raster = &image.raster;
    raster.project(points, check_cancel, |first, pixels, depths| {
        for (k, (&pixel, &depth)) in (first..).zip(pixels.iter().zip(depths)) {
            let Some(&label) = seen.labels.get(pixel as usize).filter(|label| **label != 0) else { continue };
            let nearest = f64::from(image.depth_at(pixel as usize));
            let beside = f64::from(depth) - nearest <= 2.0 * raster.spacing * nearest;
            let own = &surfaces[usize::from(label) - 1];
            if beside || own.shows(&raster.pose.turn(&points.at(k))) {
                labels[k] = label;
            }
        }
    })
}
