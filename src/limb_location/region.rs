//! Where to search: the range along the axis and the expected limbs, from a region or from segments. Never where
//! the limbs are.

use crate::camera::Camera;
use crate::geometry::Cylinder;
use crate::observations::Mask;
use nalgebra::Vector2;

/// The part of the length of the region, at either end, that is left out: rims and ragged ends.
const MARGIN: f64 = 0.15;

/// Fewest positions along the axis that a side is drawn through.
const LEAST_POSITIONS: usize = 8;

/// A side is drawn again through the positions within this many median distances, so that a piece that an
/// occluder cuts off does not turn it.
const MEDIANS: f64 = 3.0;

/// The positions along the axis, measured from its point, that pixels of the (distorted) image reach on the
/// cylinder: endpoints of segments, or the pixels of a mask. Pixels beside the cylinder count at the point of
/// their ray nearest to it. The part `trim` of the pixels at either end is left out, against ragged masks. `None`
/// when no pixel has a ray.
#[must_use]
pub fn axial_range(
    camera: &Camera,
    cylinder: &Cylinder,
    pixels: impl Iterator<Item = Vector2<f64>>,
    trim: f64,
) -> Option<[f64; 2]> {
    let axis = &cylinder.axis;
    let center = axis.nearest_to_origin();
    let position = |pixel: Vector2<f64>| {
        let ray = camera.unproject(&pixel)?;
        let hit = cylinder.first_hit(&ray).unwrap_or_else(|| {
            let across = ray - axis.direction * ray.dot(&axis.direction);
            ray * (center.dot(&across) / across.norm_squared())
        });
        Some((hit - axis.point).dot(&axis.direction)).filter(|position| position.is_finite())
    };
    let mut positions: Vec<f64> = pixels.filter_map(position).collect();
    if positions.is_empty() {
        return None;
    }
    let last = positions.len() - 1;
    let out = ((trim * positions.len() as f64) as usize).min(last / 2);
    let low = *positions.select_nth_unstable_by(out, f64::total_cmp).1;
    let high = *positions.select_nth_unstable_by(last - out, f64::total_cmp).1;
    Some([low, high])
}

/// The two sides of a region along the axis of a rough cylinder, as segments in ideal pixels: a start for the
/// search and for a fit, within some pixels of the limbs where the mask is. Only the direction of the axis in
/// the image is taken from the cylinder. `None` when the axis cannot be seen or the region is too small.
#[must_use]
pub fn sides_of_mask(mask: &Mask, camera: &Camera, rough: &Cylinder) -> Option<[[Vector2<f64>; 2]; 2]> {
    let boundary: Vec<Vector2<f64>> = mask
        .set_pixels()
        .filter(|&(x, y)| {
            let inside = |x: usize, y: usize| mask.contains(x, y);
            // Left of the first column and above the first row lies outside.
            !(x > 0 && y > 0 && inside(x - 1, y) && inside(x + 1, y) && inside(x, y - 1) && inside(x, y + 1))
        })
        .filter_map(|(x, y)| camera.ideal_pixel(&camera.unproject(&Vector2::new(x as f64, y as f64))?))
        .collect();
    if boundary.is_empty() {
        return None;
    }
    let center = boundary.iter().sum::<Vector2<f64>>() / boundary.len() as f64;
    // The image of the axis direction at the point of the axis that projects nearest to the region.
    let ray = camera.ideal_ray(&center);
    let across = ray - rough.axis.direction * ray.dot(&rough.axis.direction);
    let nearest = ray * (rough.axis.nearest_to_origin().dot(&across) / across.norm_squared());
    let step = rough.axis.direction * (1e-3 * nearest.norm());
    let along = (camera.ideal_pixel(&(nearest + step))? - camera.ideal_pixel(&(nearest - step))?).normalize();
    let normal = Vector2::new(-along.y, along.x);

    let coordinates = boundary.iter().map(|p| ((p - center).dot(&along), (p - center).dot(&normal)));
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for (s, _) in coordinates.clone() {
        low = low.min(s);
        high = high.max(s);
    }
    let margin = MARGIN * (high - low);
    let (low, high) = (low + margin, high - margin);
    let count = (high - low).floor();
    if count.is_nan() || count < LEAST_POSITIONS as f64 {
        return None;
    }
    let mut extremes = vec![[f64::INFINITY, f64::NEG_INFINITY]; count as usize];
    for (s, u) in coordinates {
        if let Some(extreme) = ((s - low) >= 0.0).then(|| extremes.get_mut((s - low) as usize)).flatten() {
            *extreme = [extreme[0].min(u), extreme[1].max(u)];
        }
    }
    let side = |k: usize| {
        let points: Vec<(f64, f64)> = extremes
            .iter()
            .enumerate()
            .filter(|(_, extreme)| extreme[0] < extreme[1])
            .map(|(i, extreme)| (low + i as f64 + 0.5, extreme[k]))
            .collect();
        let (offset, slope) = robust_line(points)?;
        Some([low, high].map(|s| center + along * s + normal * (offset + slope * s)))
    };
    Some([side(0)?, side(1)?])
}

/// u = offset + slope · s through most of the points.
fn robust_line(mut points: Vec<(f64, f64)>) -> Option<(f64, f64)> {
    loop {
        if points.len() < LEAST_POSITIONS {
            return None;
        }
        let count = points.len() as f64;
        let mean = points.iter().fold((0.0, 0.0), |sum, p| (sum.0 + p.0 / count, sum.1 + p.1 / count));
        let (square, product) = points.iter().fold((0.0, 0.0), |sum, p| {
            let ds = p.0 - mean.0;
            (sum.0 + ds * ds, sum.1 + ds * (p.1 - mean.1))
        });
        let slope = product / square;
        let offset = mean.1 - slope * mean.0;
        let distance = |p: &(f64, f64)| (p.1 - offset - slope * p.0).abs();
        let mut distances: Vec<f64> = points.iter().map(distance).collect();
        let median = *distances.select_nth_unstable_by(points.len() / 2, f64::total_cmp).1;
        let before = points.len();
        // Half a pixel is the raster of the mask.
        points.retain(|p| distance(p) <= MEDIANS * median.max(0.5));
        if points.len() == before {
            return Some((offset, slope));
        }
    }
}
