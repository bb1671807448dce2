//! From pushed segments to the limbs of an objective.

use super::result::Flags;
use crate::camera::Camera;
use crate::geometry::Cylinder;
use crate::memory::List;
use crate::noise::ImageNoise;
use crate::observations::EdgeSegment;
use crate::residuals::{LimbPair, PixelSegment, PixelTerm};
use crate::start::limbs::from_limbs;
use nalgebra::{Vector2, Vector3};

/// The usable segments, without distortion.
#[derive(Debug, Clone)]
pub(super) struct UsableEdges {
    pub segments: List<PixelSegment>,
    pub rays: List<[Vector3<f64>; 2]>,
    pub flags: Flags,
}

impl UsableEdges {
    /// Undistorts segments and drops those that cannot be limbs, with a flag for each reason.
    pub fn new(camera: Option<&Camera>, segments: &[EdgeSegment], noise: &ImageNoise) -> Self {
        let mut usable = Self { segments: List::new(), rays: List::new(), flags: Flags::empty() };
        for segment in segments.iter().filter(|segment| segment.weight > 0.0) {
            let [a, b] = segment.endpoints.map(|q| camera.and_then(|camera| undistort(camera, &q)));
            match (a, b) {
                (Some((a, ray_a)), Some((b, ray_b))) if (a - b).norm() > 0.0 => {
                    usable.segments.push(PixelSegment {
                        endpoints: [a, b],
                        weight: segment.weight,
                        limb: None,
                        growth: 0.0,
                    });
                    usable.rays.push([ray_a, ray_b]);
                }
                _ => usable.flags |= Flags::SEGMENTS_UNUSABLE,
            }
        }
        if let [first, second] = &mut usable.segments[..] {
            (first.limb, second.limb) = (Some(0), Some(1));
            let warning = if coincide(first, second, noise.apart()) {
                Flags::EDGES_COINCIDE
            } else if cross(first, second) {
                Flags::EDGES_CROSS
            } else {
                Flags::empty()
            };
            if !warning.is_empty() {
                usable.flags |= warning;
                usable.clear();
            }
        }
        if usable.segments.is_empty() && !segments.is_empty() {
            usable.flags |= Flags::EDGES_IGNORED;
        }
        usable
    }

    /// Signed distances in pixels of the endpoints from the limb lines of a cylinder in the coordinates of the view;
    /// `None` where it has no limbs.
    pub fn distances(&self, camera: &Camera, seen: &Cylinder) -> Option<List<f64>> {
        if self.segments.is_empty() {
            return Some(List::new());
        }
        let lines = PixelTerm::new(self.segments.iter().copied(), camera.line_projection());
        Some(lines.distances(seen)?.into_iter().flatten().collect())
    }

    /// The cylinder of the two longest segments, which say most about the limbs, and of some points.
    pub fn cylinder(&self, points: &[Vector3<f64>]) -> Option<Cylinder> {
        let mut order: List<usize> = (0..self.segments.len()).collect();
        let length = |k: &usize| {
            let [a, b] = self.segments[*k].endpoints;
            (a - b).norm()
        };
        order.sort_by(|a, b| length(b).total_cmp(&length(a)));
        let [first, second, ..] = order[..] else { return None };
        from_limbs(&self.rays[first], &self.rays[second], points)
    }

    /// Drops all segments.
    pub fn clear(&mut self) {
        self.segments.clear();
        self.rays.clear();
    }

    /// The pair of limbs of the paper, for exactly two segments.
    pub fn limb_pair(&self) -> Option<LimbPair> {
        let ([first, second], [a, b]) = (&self.rays[..], &self.segments[..]) else { return None };
        Some(LimbPair { rays: [*first, *second], pixels: [a.endpoints, b.endpoints] })
    }
}

fn undistort(camera: &Camera, pixel: &Vector2<f64>) -> Option<(Vector2<f64>, Vector3<f64>)> {
    let ray = camera.unproject(pixel)?;
    Some((camera.ideal_pixel(&ray)?, ray))
}

/// Twice the signed area of a triangle.
fn area(a: &Vector2<f64>, b: &Vector2<f64>, c: &Vector2<f64>) -> f64 {
    (b - a).perp(&(c - a))
}

/// Whether two segments cross between their endpoints.
fn cross(first: &PixelSegment, second: &PixelSegment) -> bool {
    let ([a, b], [c, d]) = (&first.endpoints, &second.endpoints);
    area(a, b, c) * area(a, b, d) < 0.0 && area(c, d, a) * area(c, d, b) < 0.0
}

/// Whether two segments lie on one line, to some pixels.
fn coincide(first: &PixelSegment, second: &PixelSegment, apart: f64) -> bool {
    let length = |segment: &PixelSegment| (segment.endpoints[1] - segment.endpoints[0]).norm();
    let (long, short) = if length(first) >= length(second) { (first, second) } else { (second, first) };
    let [a, b] = &long.endpoints;
    short.endpoints.iter().all(|q| area(a, b, q).abs() < apart * length(long))
}
