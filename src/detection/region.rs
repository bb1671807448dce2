//! The one cylinder in a mask.

use super::DetectionOptions;
use super::candidate::{Marks, Scene, Sides};
use super::effort::Effort;
use super::grid::{Grid, side_of_cells};
use super::noise::Noise;
use super::search::{Judged, LEAST_SCORE, Seeds, candidates, distinct};
use super::surface::Surface;
use super::{caps, parts, planes, row};
use crate::camera::Camera;
use crate::error::{Result, cancelled_if};
use crate::geometry::{Cylinder, CylinderLimits};
use crate::memory::List;
use crate::observations::{DepthImage, Mask};
use std::ops::Range;

constants! {
    /// How far around a mask is looked at, in cells: what lies beside a body tells whether it ends there, and the noise of
    /// the depth is estimated from all of it.
    MARGIN = 16.0, "cells";

    /// By how much limits are widened: the cylinder is only to tell the body from the rest. Depth makes the radius up to a third
    /// too large, and caps tell the direction to 0.15 radians.
    RADIUS_FACTOR = 1.33, "";
    DIRECTION_ERROR = 0.15, "rad";

    /// The gain times the score of a cylinder at least: with less, all of the mask is as good a guess.
    LEAST_WORTH = 0.3, "log odds";
}

/// The most that a search may do, patches and all. Of 524 masks of whole objects one in a hundred reaches it, and the median takes a
/// twentieth of it.
const VISITS_OF_PATCHES: u64 = 2_500_000;
const VISITS: u64 = 3_000_000;

/// Seeds lie half the side of a patch divided by this apart: in a scene one, but a mask is small, and of a body of which little is
/// seen few patches lie on nothing else. With three candidates a cell radii were worse: docs/performance-history.md.
const SEEDS: Seeds = Seeds { density: 4, most_visits: 4, strips: false };

/// The cylinder that explains the depth in a mask best, whatever else is in the mask: caps, inner walls, things in
/// front, or else that of a cap. `None` where all of the mask is as good a guess. Asks `stopped` all along.
///
/// # Errors
/// `Cancelled`.
pub(crate) fn detect_in_mask(
    camera: &Camera,
    depth: &DepthImage,
    mask: &Mask,
    limits: &CylinderLimits,
    stopped: &dyn Fn() -> bool,
) -> Result<Option<Cylinder>> {
    let pixel = camera.pixel_size();
    let side = side_of_cells(camera.size(), pixel);
    let (mut grid, [left, top]) = cells_around(camera, depth, mask, pixel, side);
    let Some(noise) = Noise::of_body(&mut grid) else { return Ok(None) };
    let effort = Effort::new(stopped);
    let planes = planes::find_planes(&grid, &noise, &effort);
    let grid = &grid;
    let inside = |k: usize| {
        let [x, y] = [(k % grid.columns, left), (k / grid.columns, top)]
            .map(|(cell, first)| first + cell * side + side / 2);
        mask.contains(x, y)
    };
    let open = planes::open(grid, &planes).into_iter().enumerate().map(|(k, open)| open && inside(k));
    effort.limit(VISITS_OF_PATCHES);
    let scene = Scene::new(grid, noise, open.collect(), None, pixel, &effort);
    let options = DetectionOptions {
        limits: widened(limits),
        min_pixels: 0,
        min_score: 0.0,
        ..DetectionOptions::default()
    };
    let mut marks = Marks::of_open(&scene.open);
    let mut explained = vec![false; grid.cells.len()];
    let open: List<usize> = (0..planes.len()).filter(|&k| scene.open[k]).collect();
    let bodies = caps::bodies(grid, &planes, inside, &options.limits);
    let grown = bodies.iter().take_while(|_| !effort.is_spent()).filter_map(|body| {
        let grown = scene.grow(&Surface::Cylinder(*body, 0.0), &open, Sides::Outline, &mut marks)?;
        Judged::new(&scene, grown, &options, &mut marks)
    });
    let mut found: Vec<Judged> = grown.filter(|judged| judged.score > LEAST_SCORE.get()).collect();
    found.extend(candidates(&scene, &options, SEEDS, &mut explained, &mut marks));
    let mut found = distinct(found);
    effort.limit(VISITS);
    parts::join(&scene, &mut found, &options, &mut marks);
    let worth = |k: usize| found[k].score * found[k].candidate.gain;
    cancelled_if(effort.is_stopped())?;
    let best = (0..found.len())
        .filter(|&k| worth(k) >= LEAST_WORTH.get())
        .max_by(|&a, &b| worth(a).total_cmp(&worth(b)));
    Ok(match best.map(|best| found[best].candidate.surface) {
        Some(Surface::Cylinder(cylinder, _)) => Some(cylinder),
        _ => caps::most_covered(&scene, &bodies, &open),
    })
}

/// The cells around a mask, and the column and row of the image at which they begin.
fn cells_around(
    camera: &Camera,
    depth: &DepthImage,
    mask: &Mask,
    pixel: f64,
    side: usize,
) -> (Grid, [usize; 2]) {
    let size = camera.size();
    let margin = MARGIN.count() * side;
    let (columns, rows) = mask.bounds();
    // Whole cells of the grid of the image.
    let start = |first: usize| first.saturating_sub(margin) / side * side;
    let (left, top) = (start(columns.start), start(rows.start));
    let (right, bottom) = ((columns.end + margin).min(size.0), (rows.end + margin).min(size.1));
    let read_points = |row: usize, columns: Range<usize>, points: &mut [List<f64>; 3]| {
        let y = row + top;
        row::write(columns, points, |column| {
            let x = column + left;
            let point = depth.depth(x, y).and_then(|z| Some(camera.ray_of_pixel(x, y)? * z));
            point.unwrap_or_default().into()
        });
    };
    (Grid::new((right - left, bottom - top), pixel, side, &read_points), [left, top])
}

/// Limits within which a rough cylinder is looked for.
pub(crate) fn widened(limits: &CylinderLimits) -> CylinderLimits {
    limits.widened([1.0 / RADIUS_FACTOR.get(), RADIUS_FACTOR.get()], DIRECTION_ERROR.get())
}
