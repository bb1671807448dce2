//! Where the depth turns from the surface to what is behind, which sensors smear over some of their pixels.

use super::WIDTH_PART;
use super::ends::pixel_length;
use crate::camera::Camera;
use crate::geometry::{Cylinder, rejection};
use crate::memory::List;
use crate::noise::ImageNoise;
use crate::observations::{DepthImage, pixel_at};
use crate::statistics::median;
use std::ops::Range;

constants! {
    /// The turn is at most so long, in pixels of the drawing or, where these are larger, of the depth: matching windows and beams of
    /// depth cameras are.
    LONGEST = 8.0, "px";

    /// Past it the depth behind the surface changes by less than this part of itself over a quarter of that length: that of a
    /// cap or a cone, which begins at the end, by a quarter.
    EVEN = 0.15, "";
}

/// How many generators are looked along, and how many steps as long as the longest turn.
const GENERATORS: i32 = 5;
const STEPS: usize = 16;

/// Where the depth is half way from the surface to what is behind, `outward` (± 1, along the axis) of a position at which it
/// still shows the surface: a smear is alike on both sides of an edge. `None` where nothing farther was measured past a turn, and where
/// a cap or a cone is seen.
pub(crate) fn turn(
    camera: &Camera,
    depth: &DepthImage,
    cylinder: &Cylinder,
    noise: &ImageNoise,
    position: f64,
    outward: f64,
) -> Option<f64> {
    let pixel = noise.pixel.max(depth.pixel()) * pixel_length(camera, cylinder, position)?;
    let step = LONGEST.get() * pixel / STEPS as f64;
    let excess_at = |k: usize| excess(camera, depth, cylinder, position + outward * step * k as f64);
    let middle = |steps: Range<usize>| {
        let mut found: List<f64> = steps.filter_map(excess_at).collect();
        (!found.is_empty()).then(|| median(&mut found))
    };
    // Past the turn what is behind goes on; a cap or a cone falls away farther.
    let [behind, farther] = [middle(STEPS..STEPS * 5 / 4)?, middle(STEPS * 5 / 4..STEPS * 3 / 2)?];
    let is_even = behind > 0.0 && (farther - behind).abs() <= EVEN.get() * behind;
    if !is_even {
        return None;
    }
    let half = 0.5 * behind;
    let (mut steps_before, mut excess_before) = (0.0, 0.0);
    for k in 1..STEPS {
        let Some(excess) = excess_at(k) else { continue };
        if excess >= half {
            let part = ((half - excess_before) / (excess - excess_before)).clamp(0.0, 1.0);
            let steps = steps_before + (k as f64 - steps_before) * part;
            return Some(position + outward * step * steps);
        }
        (steps_before, excess_before) = (k as f64, excess);
    }
    None
}

/// By how much the depth is farther than the surface at a position along the axis, in the median over the generators.
fn excess(camera: &Camera, depth: &DepthImage, cylinder: &Cylinder, position: f64) -> Option<f64> {
    let axis = &cylinder.axis;
    let center = axis.at(position);
    let facing = -rejection(&center, &axis.direction).try_normalize(0.0)?;
    let sideways = axis.direction.cross(&facing);
    let measured = |k: i32| {
        let sine = WIDTH_PART.get() * (2.0 * f64::from(k) / f64::from(GENERATORS - 1) - 1.0);
        let normal = facing * (1.0 - sine * sine).sqrt() + sideways * sine;
        let point = center + normal * cylinder.radius;
        let (column, row) = pixel_at(&camera.project(&point)?)?;
        Some(depth.depth(column, row)? - point.z)
    };
    let mut found: List<f64> = (0..GENERATORS).filter_map(measured).collect();
    (2 * found.len() > GENERATORS as usize).then(|| median(&mut found))
}
