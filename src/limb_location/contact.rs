//! Whether a side of a region is a line of contact rather than a limb: what lies beyond it touches the body there.
//!
//! Beyond a limb the next surface is farther away than the limb. A body that is sunk in a plane, or on which something flat
//! leans, ends in the image where both meet, on the wall that faces the camera and so in front of the limb. The depth beyond
//! tells: carried on to the line, it is nearer than the limb would be, by up to a radius. What is nearer by more stands in front.
//!
//! Another cylinder that touches the limb from beside is as near as that a few pixels beyond it, but bends away towards the limb.
//! So only what is flat, or hollow, is a contact. Where the depth is not known along most of the line, nothing is told.
//!
//! A located line with something as near as the limb beyond it, flat or not, is doubtful: the edge may be the limb of that, or the end of
//! the shadow in the groove between both. Where the image is darker beyond the line, the body ends at it before the dark of the groove.

use super::region::NEARER;
use crate::camera::Camera;
use crate::geometry::{Cylinder, Line, rejection};
use crate::memory::List;
use crate::noise::ImageNoise;
use crate::observations::{DepthImage, GreyImage, pixel_at};
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

    /// What has less than this part of the light within a line is darker.
    DARKER = 0.9, "";
}

/// How far within a line and beyond it the light is compared, in pixels of the drawing: past the blur of the edge.
const ASIDE: [f64; 3] = [1.5, 2.0, 2.5];

/// How many samples beyond each position are compared.
const SAMPLES: usize = 4;

/// Whether an edge between two points in ideal pixels may be another one than the limb of a cylinder beside it, as what lies beyond it is as
/// near as the limb or nearer, along most of it, and no darker.
#[must_use]
pub fn is_crowded(
    camera: &Camera,
    (depth, image): (&DepthImage, &GreyImage),
    cylinder: &Cylinder,
    ends: &[Vector2<f64>; 2],
    noise: &ImageNoise,
) -> bool {
    let half_width = cylinder.radius / cylinder.axis.nearest_to_origin().norm() / camera.pixel_size();
    Beyond::new(camera, depth, cylinder, half_width, noise).is_crowded(ends, image)
}

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

    /// [`is_crowded`].
    fn is_crowded(&self, ends: &[Vector2<f64>; 2], image: &GreyImage) -> bool {
        let Some(outward) = self.outward(ends) else { return false };
        let [_, steps @ ..] = self.noise.beyond();
        let value = |q: &Vector2<f64>| {
            let (x, y) = self.pixel(q).filter(|(x, y)| *x < image.width() && *y < image.height())?;
            Some(f64::from(image.value(x, y)))
        };
        let count = POSITIONS.count();
        let (mut behind, mut within, mut beyond) = (List::new(), 0.0, 0.0);
        for k in 0..count {
            let q = ends[0].lerp(&ends[1], (k as f64 + 0.5) / count as f64);
            let limb = self.limb_depth(&self.camera.ideal_ray(&q));
            let depths = steps.iter().filter_map(|step| self.depth_at(&(q + outward * *step)));
            behind.extend(depths.map(|depth| depth / limb - 1.0));
            for aside in ASIDE.map(|aside| outward * (aside * self.noise.pixel)) {
                if let (Some(inner), Some(outer)) = (value(&(q - aside)), value(&(q + aside))) {
                    within += inner;
                    beyond += outer;
                }
            }
        }
        let is_known = 2 * behind.len() >= steps.len() * count;
        is_known && median(&mut behind) <= 0.0 && beyond >= DARKER.get() * within
    }

    /// Across an edge, away from the axis.
    fn outward(&self, ends: &[Vector2<f64>; 2]) -> Option<Vector2<f64>> {
        let along = (ends[1] - ends[0]).try_normalize(0.0)?;
        let normal = Vector2::new(-along.y, along.x);
        let ray = self.camera.ideal_ray(&ends[0]);
        let axis =
            self.camera.ideal_pixel(&self.axis.nearest_to(&(ray * (self.limb_depth(&ray) / ray.z))))?;
        Some(normal * (ends[0] - axis).dot(&normal).signum())
    }

    /// The depth of a limb on a ray: where the ray is nearest to the axis.
    fn limb_depth(&self, ray: &Vector3<f64>) -> f64 {
        let across = rejection(ray, &self.axis.direction);
        let axis = self.axis.nearest_to_origin().dot(&across) / across.norm_squared();
        ray.z * axis * (1.0 - self.behind)
    }

    fn depth_at(&self, ideal: &Vector2<f64>) -> Option<f64> {
        let (x, y) = self.pixel(ideal)?;
        self.depth.depth(x, y)
    }

    /// The column and row of a point.
    fn pixel(&self, ideal: &Vector2<f64>) -> Option<(usize, usize)> {
        pixel_at(&self.camera.project(&self.camera.ideal_ray(ideal))?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Distortion, Intrinsics};
    use crate::noise::NoiseModel;
    use crate::observations::{DepthView, ImageView};

    const SIZE: (usize, usize) = (640, 480);

    /// Whether the right limb of an upright cylinder is crowded, beyond which the depth has a value and the image has another brightness.
    fn crowded(depth_beyond: f32, light_beyond: u8) -> bool {
        let (width, height) = (640, 480);
        let intrinsics = Intrinsics {
            width,
            height,
            fx: 500.0,
            fy: 500.0,
            cx: 319.5,
            cy: 239.5,
            distortion: Distortion::None,
        };
        let camera = Camera::new(intrinsics).unwrap();
        let cylinder = Cylinder::new(Vector3::new(0.0, 0.0, 1.0), Vector3::y(), 0.05).unwrap();
        let limb = 500.0 * 0.05 / (1.0_f64 - 0.05 * 0.05).sqrt();
        let is_beyond = |k: usize| (k % SIZE.0) as f64 > 319.5 + limb;
        let pixels = || 0..SIZE.0 * SIZE.1;
        let depth: Vec<f32> = pixels().map(|k| if is_beyond(k) { depth_beyond } else { 0.95 }).collect();
        let image: Vec<u8> = pixels().map(|k| if is_beyond(k) { light_beyond } else { 100 }).collect();
        let depth = DepthView::from_f32(&depth, SIZE, 1.0).unwrap();
        let depth = DepthImage::copy(&depth).unwrap();
        let image = GreyImage::copy(&ImageView::from_u8(&image, SIZE).unwrap()).unwrap();
        let ends = [-80.0, 80.0].map(|y| Vector2::new(319.5 + limb, 239.5 + y));
        is_crowded(&camera, (&depth, &image), &cylinder, &ends, &NoiseModel::default().in_image(SIZE))
    }

    #[test]
    fn a_limb_is_crowded_where_what_lies_beyond_is_as_near_and_no_darker() {
        assert!(crowded(0.98, 150));
        assert!(crowded(0.98, 95));
        assert!(!crowded(0.98, 60), "the body hides what is darker");
        assert!(!crowded(1.02, 150), "behind the limb");
        assert!(!crowded(0.0, 150), "nothing measured");
    }
}
