//! The exact view of a plan: what every pixel would see.

use super::Plan;
use crate::geometry::{Cylinder, LimbFrame};
use crate::residuals::{ArcRay, Rim, on_wall};
use nalgebra::{Vector2, Vector3};

/// Rays that meet the surface at a smaller sine bring no depth: windows and pulses see too little of it.
const LEAST_SINE_OF_DEPTH: f64 = 0.2;

/// Samples along a limb that are looked at for the part of it in the image.
const LIMB_SAMPLES: usize = 256;

/// Of an arc, as it is looked for in an image (`end_location`): the most samples, the pixels beside a limb that are left out,
/// the least sine at which a ray meets the surface, and the fewest samples.
const MOST_SAMPLES: usize = 48;
const LIMB_MARGIN: f64 = 2.5;
const LEAST_SINE: f64 = 0.35;
const LEAST_SAMPLES: usize = 8;

/// A point of the surface that a pixel sees.
pub(super) struct SeenPoint {
    pub point: Vector3<f64>,
    /// How far a unit of depth moves it across the surface.
    pub across: f64,
}

impl Plan {
    /// The points of the lateral surface at the centres of the pixels.
    pub(super) fn points(&self, cylinder: &Cylinder, limbs: &LimbFrame) -> Vec<SeenPoint> {
        let [columns, rows] = self.bounds(cylinder, limbs);
        let mut points = Vec::new();
        for (x, y) in rows.flat_map(|y| columns.clone().map(move |x| (x, y))) {
            let Some(ray) = self.camera.ray_of_pixel(x, y) else { continue };
            let Some((position, normal)) = on_wall(cylinder, &ray, Rim::Near) else { continue };
            // The ray has the depth 1.
            let across = -normal.dot(&ray);
            if position.abs() <= 0.5 * self.length && across >= LEAST_SINE_OF_DEPTH * ray.norm() {
                let point = cylinder.axis.at(position) + normal * self.radius;
                points.push(SeenPoint { point, across });
            }
        }
        points
    }

    /// Columns and rows that may see the cylinder.
    fn bounds(&self, cylinder: &Cylinder, limbs: &LimbFrame) -> [std::ops::Range<usize>; 2] {
        let (width, height) = self.camera.size();
        let whole = [0..width, 0..height];
        let mut range = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for (side, k) in [-0.5, 0.5].into_iter().flat_map(|side| (0..64).map(move |k| (side, k))) {
            let (sine, cosine) = libm::sincos(std::f64::consts::TAU * f64::from(k) / 64.0);
            // A little wider, for the samples between.
            let across = (limbs.sideways * sine + limbs.toward * cosine) * (1.01 * self.radius);
            let point = self.center() + cylinder.axis.direction * (1.01 * side * self.length) + across;
            let Some(pixel) = self.camera.project(&point) else { return whole };
            for (range, value) in range.iter_mut().zip(&pixel) {
                *range = [range[0].min(*value), range[1].max(*value)];
            }
        }
        // Lines are bent in a distorted image.
        let margin = 2.0 + 0.05 * (width + height) as f64;
        let clamped = |[low, high]: [f64; 2], size: usize| {
            let end = (high + margin).ceil().clamp(0.0, size as f64) as usize;
            (low - margin).floor().clamp(0.0, end as f64) as usize..end
        };
        [clamped(range[0], width), clamped(range[1], height)]
    }

    /// The two ends of what the image shows of a limb, in ideal pixels; `None` where it shows nothing.
    pub(super) fn limb_in_image(&self, limbs: &LimbFrame, limb: usize) -> Option<[Vector2<f64>; 2]> {
        let line = limbs.limb_lines()[limb];
        let middle = line.nearest_to(&self.center());
        let at = |k: usize| middle + line.direction * ((k as f64 / LIMB_SAMPLES as f64 - 0.5) * self.length);
        let in_image =
            |k: &usize| self.camera.project(&at(*k)).is_some_and(|pixel| self.camera.contains(&pixel));
        let first = (0..=LIMB_SAMPLES).find(in_image)?;
        let last = (first..=LIMB_SAMPLES).rev().find(in_image)?;
        let intrinsics = self.camera.intrinsics();
        let ideal = |p: Vector3<f64>| {
            Vector2::new(intrinsics.fx * p.x / p.z + intrinsics.cx, intrinsics.fy * p.y / p.z + intrinsics.cy)
        };
        (last > first).then(|| [ideal(at(first)), ideal(at(last))])
    }

    /// The samples of the arc at a position along the axis; `None` where the image does not show it all.
    pub(super) fn arc(&self, cylinder: &Cylinder, limbs: &LimbFrame, position: f64) -> Option<Vec<ArcRay>> {
        let half_width = self.radius * self.camera.intrinsics().fx / self.distance;
        let part = 1.0 - LIMB_MARGIN / half_width;
        // One a pixel at most: what lies closer shares its pixels.
        let count = ((2.0 * part * half_width) as usize).min(MOST_SAMPLES);
        let middle = self.center() + cylinder.axis.direction * position;
        let mut samples = Vec::with_capacity(count);
        for k in 0..count {
            let sine = part * (2.0 * (k as f64 + 0.5) / count as f64 - 1.0) * limbs.cos_gamma;
            let normal = limbs.sideways * sine - limbs.toward * (1.0 - sine * sine).sqrt();
            let ray = middle + normal * self.radius;
            let here = self.camera.project(&ray).filter(|pixel| self.camera.contains(pixel))?;
            let step = 1e-4 * self.radius;
            let ahead = self.camera.project(&(ray + cylinder.axis.direction * step))?;
            if -normal.dot(&ray) >= LEAST_SINE * ray.norm() {
                samples.push(ArcRay {
                    ray,
                    rim: Rim::Near,
                    across: (ahead - here).norm() / step,
                    weight: 1.0,
                    widening: 0.0,
                });
            }
        }
        (samples.len() >= LEAST_SAMPLES).then_some(samples)
    }
}
