//! On which grids of pixels the limbs are located: coarse enough for the blur of the image, and no coarser.

use super::compression::noise_of_compression;
use super::sharpness::{BLURRED, STILL_BLURRED};
use super::strip::Grid;
use super::{LimbSearch, NotVisible, SeenLimbs, baselines, blur_of, located_on};
use crate::camera::Camera;
use crate::geometry::{Cylinder, across};
use crate::observations::{GreyImage, ReducedImage};
use std::ops::ControlFlow;

/// Most grids of pixels on which the limbs are located: the first by the size of the image or its blur, the second by the blur that
/// they show on it, and one more where that was hardly to be seen.
const GRIDS: usize = 3;

constants! {
    /// No grid is so coarse that the radius of the cylinder is less, in its pixels: the profile reaches 3.5 pixels inside a limb.
    LEAST_RADIUS = 5.0, "px";
}

/// Locates the limbs of a rough cylinder. `check` is asked before each grid, and ends the search.
pub fn locate_limbs(
    image: &GreyImage,
    camera: &Camera,
    model: &Cylinder,
    search: &LimbSearch,
    check: &mut dyn FnMut() -> ControlFlow<()>,
) -> ControlFlow<(), SeenLimbs> {
    let least_noise = noise_of_compression(image);
    // `None` where more than a part is blurred.
    let mut located = |factor: usize, most_blurred: f64| {
        check()?;
        let (camera, search) = (camera.reduced(factor), search.reduced(factor));
        let image = ReducedImage::new(image, factor);
        let grid = Grid { image, camera: &camera, noise: search.noise, least_noise };
        ControlFlow::Continue(located_on(&grid, model, &search, most_blurred))
    };
    let radius = baselines(camera, model, &search.ranges).map_or(0.0, |(_, radius)| radius);
    // By half: a large image has room for hundreds.
    let coarser = |factor: usize| {
        Some(factor + factor.div_ceil(2)).filter(|&factor| radius >= LEAST_RADIUS.get() * factor as f64)
    };
    let first = search.noise.factor(None, 1);
    let mut factor = first;
    // Shading of a small one is as steep as a blurred limb.
    let is_told = search.noise.blur > 0.0;
    let mut most_blurred = if coarser(first).is_some() && !is_told { BLURRED.get() } else { f64::INFINITY };
    let mut seen = loop {
        match (located(factor, most_blurred)?, coarser(factor)) {
            (Some(seen), _) => break seen,
            (None, Some(next)) => factor = next,
            (None, None) => break SeenLimbs::none(NotVisible::Uncertain),
        }
        most_blurred = STILL_BLURRED.get();
    };
    for _ in 1..GRIDS {
        let (wanted, most) = match blur_of(&seen.limbs) {
            Some(blur) => (search.noise.factor(Some(blur), factor), f64::INFINITY),
            // Where no limb tells, a finer grid may, unless it was too fine.
            None if factor > first => break,
            None => ((factor - 1).max(1), most_blurred),
        };
        if wanted == factor {
            break;
        }
        let Some(other) = located(wanted, most)? else { break };
        // What a blurred image shows on a finer grid has to be confirmed.
        if factor > first && !agree(&seen, &other, factor as f64) {
            break;
        }
        (factor, seen) = (wanted, other);
    }
    ControlFlow::Continue(seen)
}

/// Whether the same limbs are seen, within some pixels.
fn agree(seen: &SeenLimbs, other: &SeenLimbs, within: f64) -> bool {
    seen.limbs.iter().zip(&other.limbs).all(|(one, other)| match (one.line, other.line) {
        (Ok(one), Ok(other)) => other.ends.iter().all(|end| across(&one.ends, end).abs() < within),
        (one, other) => one.is_err() && other.is_err(),
    })
}
