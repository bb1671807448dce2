//! Whether a side of a region is a line of contact rather than a limb: what lies beyond it touches the body there.
//!
//! Beyond a limb the next surface is farther away than the limb. A body that is sunk in a plane, or on which something flat
//! leans, ends in the image where both meet, on the wall that faces the camera and so in front of the limb. The depth beyond
//! tells: carried on to the line, it is nearer than the limb would be, by up to a radius. What is nearer by more stands in front.
//!
//! Another cylinder that touches the limb from beside is as near as that a few pixels beyond it, but bends away towards the limb.
//! So only what is flat, or hollow, is a contact. Where the depth is not known along most of the line, nothing is told.

use super::region::NEARER;
use crate::camera::Camera;
use crate::geometry::{Cylinder, Line};
use crate::memory::List;
use crate::noise::ImageNoise;
use crate::observations::{DepthImage, pixel_at};
use crate::statistics::median;
use nalgebra::{Vector2, Vector3};

constants! {
    /// A contact lies in front of the limb by so many radii at least: 0.15 are a width that is 1.3 % too small.
    LEAST_FRONT = 0.15, "radius";

    /// The same at most: one radius, and the error of the points that tell it.
    MOST_FRONT = 1.2, "radius";

    /// What bends towards the line by less than this part of the step between the samples is flat. Behind the limb of a cylinder of
    /// any radius the depth bends by 0.7 to 0.9 of it, as sensors smooth it by 0.3 and more.
    FLAT = 0.25, "step";

    /// What bends the other way by more begins somewhere beyond.
    HOLLOW = 1.0, "step";

    /// Positions along the line.
    POSITIONS = 32.0, "";
}

/// How many samples beyond each position are compared.
const SAMPLES: usize = 4;

/// What the depth shows beyond the region of a body.
pub(super) struct Beyond<'a> {
    camera: &'a Camera,
    depth: &'a DepthImage,
    axis: &'a Line,
    noise: &'a ImageNoise,
    /// Size of a pixel at the distance 1.
    pixel: f64,
    /// The radius as a part of the distance.
    radius: f64,
    /// How much farther than the limbs the axis of the rough fit is, as a part of the distance.
    behind: f64,
}

impl<'a> Beyond<'a> {
    /// Beyond a body of which a rough fit and half of the width of its region in pixels are known. A small part of a surface may
    /// tell a radius that is far off, but where its front is; the radius is that of a body whose limbs both sides are.
    pub fn new(
        camera: &'a Camera,
        depth: &'a DepthImage,
        rough: &'a Cylinder,
        half_width: f64,
        noise: &'a ImageNoise,
    ) -> Self {
        let pixel = camera.pixel_size();
        let radius = half_width * pixel;
        let behind = rough.radius / rough.axis.nearest_to_origin().norm() - radius;
        Self { camera, depth, axis: &rough.axis, noise, pixel, radius, behind }
    }

    /// Whether the body touches what is beyond a line between two points in ideal pixels, towards `outward` (of length 1).
    pub fn touches(&self, ends: &[Vector2<f64>; 2], outward: &Vector2<f64>) -> bool {
        // The first sample is past the reach of a boundary that is off, the others are as far from each other.
        let [step, ..] = self.noise.beyond();
        let slope = step * self.pixel;
        let count = POSITIONS.count();
        let at = |k: usize| {
            let q = ends[0].lerp(&ends[1], (k as f64 + 0.5) / count as f64);
            (q, self.limb_depth(&self.camera.ideal_ray(&q)))
        };
        let positions: List<(Vector2<f64>, f64)> = (0..count).map(at).collect();
        let mut profile = [0.0; SAMPLES];
        for (number, depth) in (1..).zip(&mut profile) {
            let beyond = outward * (step * f64::from(number));
            let behind_limb =
                |(q, limb): &(Vector2<f64>, f64)| Some(self.depth_at(&(q + beyond))? / limb - 1.0);
            let mut depths: List<f64> = positions.iter().filter_map(behind_limb).collect();
            *depth = median(&mut depths);
            // Most lines end here: what is farther away than a surface at 45° to the limb is another one.
            if 2 * depths.len() < count || *depth > slope * f64::from(number) {
                return false;
            }
        }
        let [a, b, c, d] = profile;
        // In front of the limb by the line through the four samples, carried on to where the region ends; and how much they bend.
        let (front, bend) = (-(a + 0.5 * (b - d)), a - b - c + d);
        let least = (LEAST_FRONT.get() * self.radius).max(NEARER.get());
        let most = MOST_FRONT.get() * self.radius;
        (-HOLLOW.get() * slope..=FLAT.get() * slope).contains(&bend) && (least..=most).contains(&front)
    }

    /// The depth of a limb on a ray: where the ray is nearest to the axis.
    fn limb_depth(&self, ray: &Vector3<f64>) -> f64 {
        let across = ray - self.axis.direction * ray.dot(&self.axis.direction);
        let axis = self.axis.nearest_to_origin().dot(&across) / across.norm_squared();
        ray.z * axis * (1.0 - self.behind)
    }

    fn depth_at(&self, ideal: &Vector2<f64>) -> Option<f64> {
        let (x, y) = pixel_at(&self.camera.project(&self.camera.ideal_ray(ideal))?)?;
        self.depth.depth(x, y)
    }
}
