//! The outline of a mask at an end: the near rim of the end circle, or the far one beyond a cap.
//!
//! A ray through the near rim meets the near wall of the cylinder at the end, one through the far rim the far wall. So
//! the outline tells which of the rims it is: along it the one position is the same everywhere, the other is not.

use crate::camera::Camera;
use crate::geometry::Cylinder;
use crate::memory::List;
use crate::noise::ImageNoise;
use crate::observations::Mask;
use nalgebra::{Vector2, Vector3};

constants! {
    /// The part of the half width in which the outline is looked at: beside the limbs both rims are one.
    WIDTH_PART = 0.9, "";

    /// Most samples along the outline.
    SAMPLES = 64.0, "";

    /// Fewest samples.
    LEAST_SAMPLES = 6.0, "";

    /// Samples farther inward from the rim than this many standard deviations are something else, all alike: something covers
    /// the rim there.
    REACH = 3.0, "σ";

    /// The same outward: masks rarely reach so far beyond what they are of.
    BEYOND = 6.0, "σ";

    /// How much better the far rim must explain the outline than the near one, as the logarithm of odds.
    LEAST_GAIN = 1.0, "";
}

/// A sample of the outline: where its ray meets near and far wall, along the axis, and by how much these positions change
/// from one pixel to the next.
#[derive(Clone, Copy)]
struct Sample {
    positions: [f64; 2],
    steps: [f64; 2],
}

impl Sample {
    /// How far it is from a rim at a position, in standard deviations.
    fn ratio(&self, wall: usize, position: f64, sigma: f64) -> f64 {
        (self.positions[wall] - position) / (self.steps[wall] * sigma)
    }
}

/// Where the search for a rim starts, as parts of the samples ordered outward.
const STARTS: [f64; 2] = [0.5, 0.875];

/// The mean position of the samples about a first one.
fn mean_about(start: f64, samples: &[Sample], wall: usize, sigma: f64) -> f64 {
    (0..3).fold(start, |position, _| {
        let near = samples.iter().filter(|sample| sample.ratio(wall, position, sigma).abs() <= REACH.get());
        let (mut sum, mut total) = (0.0, 0.0);
        for sample in near {
            let weight = sample.steps[wall].powi(-2);
            sum += weight * sample.positions[wall];
            total += weight;
        }
        if total > 0.0 { sum / total } else { position }
    })
}

/// The outline of a mask about the middle part of a cylinder.
pub(super) struct Rims<'a> {
    camera: &'a Camera,
    cylinder: &'a Cylinder,
    /// Its pixels, by where across the axis their rays pass in parts of the width, and where these meet the near wall along it.
    pixels: List<(f64, f64, Vector2<f64>)>,
    /// The width of that part of the cylinder in the image, in pixels.
    width: f64,
}

impl<'a> Rims<'a> {
    pub fn new(camera: &'a Camera, mask: &Mask, cylinder: &'a Cylinder) -> Self {
        let axis = &cylinder.axis;
        let mut rims = Self { camera, cylinder, pixels: List::new(), width: width(camera, mask, cylinder) };
        for &(column, row) in mask.outline() {
            let pixel = Vector2::new(column as f64, row as f64);
            let Some(ray) = camera.unproject(&pixel) else { continue };
            let normal = ray.cross(&axis.direction);
            let across = normal.dot(&axis.point) / (normal.norm() * cylinder.radius * WIDTH_PART.get());
            if across.abs() >= 1.0 {
                continue;
            }
            let Some([near, _]) = rims.walls(&ray) else { continue };
            rims.pixels.push((0.5 * (across + 1.0), near, pixel));
        }
        rims
    }

    /// Where a ray meets the near and the far wall, along the axis.
    fn walls(&self, ray: &Vector3<f64>) -> Option<[f64; 2]> {
        let axis = &self.cylinder.axis;
        let (near, far) = self.cylinder.intersect_ray(ray)?;
        (near > 0.0).then(|| [near, far].map(|t| axis.position_of(&(ray * t))))
    }

    /// The position of an end whose far rim ends the mask towards `outward` (± 1, along the axis); `None` where its near rim
    /// or something else does. `before` is what else speaks for the far rim, as the logarithm of odds.
    pub fn far(&self, outward: f64, before: f64, noise: &ImageNoise) -> Option<f64> {
        let cylinder = self.cylinder;
        let samples = self.samples(outward)?;
        // The raster of the mask comes to its boundary.
        let sigma = noise.boundary.hypot(0.3);
        let walls = [0, 1].map(|wall| {
            let mut positions: List<f64> =
                samples.iter().map(|sample| outward * sample.positions[wall]).collect();
            positions.sort_unstable_by(f64::total_cmp);
            // Where something stands on a cap, the rim is that of the few outermost.
            let starts = STARTS.map(|part| outward * positions[(part * positions.len() as f64) as usize]);
            let fits = starts.map(|start| {
                let position = mean_about(start, &samples, wall, sigma);
                let ratios = samples.iter().map(|sample| outward * sample.ratio(wall, position, sigma));
                (position, ratios.map(|ratio| ratio.clamp(-REACH.get(), BEYOND.get()).powi(2)).sum::<f64>())
            });
            let [median, outermost] = fits;
            let (position, squares) = if outermost.1 < median.1 { outermost } else { median };
            (position, 0.5 * squares)
        });
        let [(_, near), (position, far)] = walls;
        // A cap is seen where it faces the camera.
        let faces = cylinder.end_faces_origin(position, outward);
        // Neighbours share their error: about so many pixels of the outline come to one sample.
        let independent = (1.0 / noise.correlation).min(1.0) * (self.width / samples.len() as f64);
        (faces && (near - far) * independent + before >= LEAST_GAIN.get()).then_some(position)
    }

    /// The outermost pixels of the mask, by where they are across the axis.
    fn samples(&self, outward: f64) -> Option<List<Sample>> {
        let Self { camera, cylinder, pixels, width } = self;
        // A sample for every other pixel: the raster leaves no gaps then.
        let count = (0.5 * width).min(SAMPLES.get()) as usize;
        if count < LEAST_SAMPLES.count() {
            return None;
        }
        let mut outermost: List<Option<(f64, Vector2<f64>)>> = List::filled(None, count);
        for &(across, near, pixel) in pixels {
            let best = &mut outermost[((across * count as f64) as usize).min(count - 1)];
            if best.is_none_or(|(before, _)| outward * near > outward * before) {
                *best = Some((near, pixel));
            }
        }
        let samples: List<Sample> = outermost
            .iter()
            .flatten()
            .filter_map(|(near, pixel)| {
                // One pixel on along the generator, in the image.
                let point = camera.unproject(pixel).and_then(|ray| cylinder.first_hit(&ray))?;
                let step = 0.01 * cylinder.radius;
                let ahead = camera.project(&(point + cylinder.axis.direction * (outward * step)))?;
                let along = (ahead - pixel).try_normalize(0.0)?;
                // The boundary is half a pixel beyond the last pixel.
                let at = |pixels: f64| self.walls(&camera.unproject(&(pixel + along * pixels))?);
                let (positions, next) = (at(0.5)?, at(-0.5)?);
                let steps = [0, 1].map(|wall| (positions[wall] - next[wall]).abs());
                let whole = near.is_finite() && steps.iter().all(|step| *step > 0.0);
                whole.then_some(Sample { positions, steps })
            })
            .collect();
        (samples.len() >= LEAST_SAMPLES.count()).then_some(samples)
    }
}

/// The width of the middle part of the cylinder in the image, in pixels.
fn width(camera: &Camera, mask: &Mask, cylinder: &Cylinder) -> f64 {
    let (columns, rows) = mask.bounds();
    let middle = [columns, rows].map(|range| 0.5 * (range.start + range.end) as f64);
    let ray = camera.unproject(&Vector2::new(middle[0], middle[1])).unwrap_or_else(Vector3::z);
    let depth = cylinder.first_hit(&ray).map_or(cylinder.axis.nearest_to_origin().norm(), |hit| hit.z);
    let pixel = camera.focal_length();
    2.0 * WIDTH_PART.get() * cylinder.radius * pixel / depth.abs().max(f64::MIN_POSITIVE)
}
