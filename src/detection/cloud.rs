//! Bare clouds: seen again as an image from where they were measured.

mod cubes;
mod growth;
mod hidden;
mod image;
mod looks;
mod members;
mod points;
mod sensor;
mod viewpoints;

#[cfg(feature = "sensitivity")]
/// The constants of the looks at clouds.
pub(super) fn constants() -> Vec<crate::constant::Constant> {
    let files = [
        CONSTANTS,
        cubes::CONSTANTS,
        growth::CONSTANTS,
        image::CONSTANTS,
        looks::CONSTANTS,
        members::CONSTANTS,
        sensor::CONSTANTS,
        viewpoints::CONSTANTS,
    ];
    files.concat()
}

use super::effort::Effort;
use super::grid::Grid;
use super::labels::{count_pixels, label};
use super::search::{Limbs, Searched, search};
use super::{DetectionOptions, Detections, row};
use crate::error::{Result, cancelled_if};
use crate::geometry::{AxisCone, Cylinder, Line};
use crate::memory::{List, apart};
use crate::observations::PointsView;
pub(crate) use growth::{grown, is_round};
use image::Image;
pub(crate) use looks::Looks;
use std::ops::Range;

constants! {
    /// A part of the points that may lie anywhere: single ones far away must not make the image wide.
    STRAY = 0.002, "";
}

/// Points that are gone through between two questions whether to go on: some milliseconds.
const BETWEEN_QUESTIONS: usize = 1 << 18;

/// An error when the search is to stop.
type CancelCheck<'a> = dyn Fn() -> Result<()> + 'a;

/// Finds all cylinders by the present look at the points of a cloud, until `stopped` says so; labels are by point of the part that is
/// looked at, and there are none where nothing is found. `None` where there is nothing to look at.
///
/// # Errors
/// `InvalidArgument`, `OutOfMemory`, `Cancelled`.
pub(crate) fn detect_points_until(
    view: &PointsView<'_>,
    looks: &mut Looks,
    options: &DetectionOptions,
    stopped: &dyn Fn() -> bool,
) -> Result<Option<Detections>> {
    options.check()?;
    let cancelled = || cancelled_if(stopped());
    if !looks.prepare(view, &cancelled)? {
        return Ok(None);
    }
    // Lists for many points are not kept for the looks at few that follow.
    match looks.is_large() {
        true => apart(|| look(view, looks, options, stopped)),
        false => look(view, looks, options, stopped),
    }
}

/// The present look, which there is.
fn look(
    view: &PointsView<'_>,
    looks: &mut Looks,
    options: &DetectionOptions,
    stopped: &dyn Fn() -> bool,
) -> Result<Option<Detections>> {
    let cancelled = || cancelled_if(stopped());
    let Some(viewpoint) = looks.viewpoint().copied() else { return Ok(None) };
    let Some(mut image) = image_of(looks, &cancelled)? else { return Ok(None) };
    if viewpoint.is_sensor() && image.closed {
        // No sensor was there, and there will be more looks.
        looks.put_in_order(view, &cancelled)?;
        looks.memory = image.nearest;
        match image_of(looks, &cancelled)? {
            Some(of_ordered) => image = of_ordered,
            None => return Ok(None),
        }
    }
    let Some(points) = looks.part() else { return Ok(None) };
    let raster = &image.raster;
    let cone = options.limits.axis;
    let cone = cone.map(|cone| AxisCone { direction: viewpoint.rotation * cone.direction, ..cone });
    let mut turned = *options;
    turned.limits.axis = cone;
    let size = (raster.width, raster.height);
    let read_points = |row: usize, columns: Range<usize>, list: &mut [List<f64>; 3]| {
        image.write_row(points, row, columns, list);
    };
    cancelled()?;
    let mut grid = Grid::new(size, raster.spacing, looks.side_of_cells(size), &read_points);
    cancelled()?;
    let effort = Effort::new(stopped);
    let Searched { cylinders: found, independent, .. } =
        search(&mut grid, raster.spacing, &Limbs::None, &turned, &effort)?;
    if found.is_empty() {
        let (cut_short, visits) = (effort.is_cut_short(), effort.visits());
        looks.note(size, image.closed, independent);
        looks.keep(image.nearest);
        return Ok(Some(Detections { cut_short, visits, ..Detections::default() }));
    }
    let read_rays = |row: usize, columns: Range<usize>, list: &mut [List<f64>; 2]| {
        let coordinate = |k: usize, low: f64| low + (k as f64 + 0.5) * raster.spacing;
        row::write(columns, list, |column| {
            [coordinate(column, raster.low[0]), coordinate(row, raster.low[1])]
        });
    };
    let seen = label(&grid, &found, size, raster.spacing, &read_points, &read_rays, &effort);
    drop((grid, found));
    let labels = members::labels(points, &image, &seen, &cancelled)?;
    let mut cylinders = seen.cylinders;
    for detection in &mut cylinders {
        let Cylinder { axis, radius } = detection.cylinder;
        let back = viewpoint.rotation.transpose();
        let axis = Line { point: back * axis.point + viewpoint.origin, direction: back * axis.direction };
        detection.cylinder = Cylinder { axis, radius };
    }
    count_pixels(&mut cylinders, &labels);
    looks.note(size, image.closed, independent);
    // Where points do not share their errors no window has drawn out what is next to a limb.
    let seen_from = (viewpoint.may_be_sensor() && !image.closed && !independent).then_some(viewpoint.origin);
    let whole = viewpoint.is_sensor() && !image.closed;
    looks.keep(image.nearest);
    Ok(Some(Detections { cylinders, labels, seen_from, whole, independent, ..seen }))
}

/// The image of the present look.
fn image_of(looks: &mut Looks, check_cancel: &CancelCheck<'_>) -> Result<Option<Image>> {
    if let Some(image) = looks.image.take() {
        return Ok(Some(image));
    }
    let memory = std::mem::take(&mut looks.memory);
    let (Some(points), Some(sample), Some(viewpoint)) = (looks.part(), looks.sample(), looks.viewpoint())
    else {
        return Ok(None);
    };
    Image::of(points, sample, (&viewpoint.pose(points), viewpoint.widest), memory, check_cancel)
}
