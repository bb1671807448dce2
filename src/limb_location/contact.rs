//! Whether a side of a region is a line of contact rather than a limb: what lies beyond it touches the body there.
//!
//! Beyond a limb the next surface is farther away than the limb. A body that is sunk in a plane, or on which something flat
//! leans, ends in the image where both meet, on the wall that faces the camera and so in front of the limb. The depth beyond
//! tells: carried on to the line, it is nearer than the limb would be, by up to a radius. What is nearer by more stands in front.
//!
//! Another cylinder that touches the limb from beside is as near as that a few pixels beyond it, but bends away towards the limb.
//! So only what is flat is a contact. Where the depth is not known along most of the line, nothing is told.

use super::region::NEARER;
use crate::camera::Camera;
use crate::geometry::Cylinder;
use crate::memory::List;
use crate::noise::ImageNoise;
use crate::observations::DepthImage;
use crate::statistics::median;
use nalgebra::{Vector2, Vector3};

constants! {
    /// A contact lies in front of the limb by so many radii at least: 0.15 are a width that is 1.3 % too small.
    LEAST_FRONT = 0.15, "radius";

    /// The same at most: one radius, and the error of the points that tell it.
    MOST_FRONT = 1.2, "radius";

    /// What bends by less than this part of the step between the places is flat. Behind the limb of a cylinder of any radius the
    /// depth bends by 0.7 to 0.9 of it.
    FLAT = 0.25, "step";

    /// Places along the line.
    POSITIONS = 32.0, "";
}

/// How many places beyond each position are compared.
const PLACES: usize = 4;

/// A part of the boundary of a region, seen from a body.
pub(super) struct Boundary<'a> {
    pub camera: &'a Camera,
    pub depth: &'a DepthImage,
    /// The body as a rough fit has it.
    pub body: &'a Cylinder,
    pub noise: &'a ImageNoise,
}

impl Boundary<'_> {
    /// Whether the body touches what is beyond a line between two points in ideal pixels, towards `outward` (of length 1).
    pub fn is_contact(&self, ends: &[Vector2<f64>; 2], outward: &Vector2<f64>) -> bool {
        // The first place is past the reach of a boundary that is off, the others are as far from each other.
        let [step, ..] = self.noise.beyond();
        let count = POSITIONS.count();
        let mut profile: [List<f64>; PLACES] = Default::default();
        let mut distance = 0.0;
        for k in 0..count {
            let q = ends[0].lerp(&ends[1], (k as f64 + 0.5) / count as f64);
            let limb = self.limb_depth(&self.camera.ideal_ray(&q));
            if !(limb > 0.0) {
                return false;
            }
            distance += limb / count as f64;
            for (place, depths) in profile.iter_mut().enumerate() {
                let beyond = q + outward * (step * (place + 1) as f64);
                depths.extend(self.depth_at(&beyond).map(|depth| depth / limb - 1.0));
            }
        }
        if profile.iter().any(|depths| 2 * depths.len() < count) {
            return false;
        }
        let [a, b, c, d] = profile.map(|mut depths| median(&mut depths));
        // The line through the four places, carried on to where the region ends, and how much they bend.
        let (away, bend) = (a + 0.5 * (b - d), a - b - c + d);
        let radius = self.body.radius / distance;
        let intrinsics = self.camera.intrinsics();
        let pixel = 0.5 * (1.0 / intrinsics.fx + 1.0 / intrinsics.fy);
        let least = (LEAST_FRONT.get() * radius).max(NEARER.get());
        bend.abs() <= FLAT.get() * step * pixel && (least..=MOST_FRONT.get() * radius).contains(&-away)
    }

    /// The depth of a limb on a ray: where the ray is nearest to the axis.
    fn limb_depth(&self, ray: &Vector3<f64>) -> f64 {
        let axis = &self.body.axis;
        let across = ray - axis.direction * ray.dot(&axis.direction);
        ray.z * axis.nearest_to_origin().dot(&across) / across.norm_squared()
    }

    fn depth_at(&self, ideal: &Vector2<f64>) -> Option<f64> {
        let pixel = self.camera.project(&self.camera.ideal_ray(ideal))?;
        let (x, y) = (pixel.x.round(), pixel.y.round());
        if x >= 0.0 && y >= 0.0 { self.depth.depth(x as usize, y as usize) } else { None }
    }
}
