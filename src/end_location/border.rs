//! Ends that the border of the image cuts off.

use super::silhouette::Silhouette;
use nalgebra::Vector2;
use std::ops::Range;

constants! {
    /// How many rows and columns along the border are looked at: beside a limb, where the line of sight grazes the
    /// surface, a pixel one row further in may show a point further out. In pixels of the drawing.
    BORDER_PIXELS = 4.0, "drawn px";
}

/// The last position towards `outward` at which a pixel of the image still shows the surface. On a surface that
/// runs out of the image that is a pixel of the border.
pub(super) fn last_inside(silhouette: &Silhouette<'_>, outward: f64) -> Option<f64> {
    let surface = silhouette.surface();
    let (mask, axis) = (silhouette.mask(), surface.cylinder.axis);
    let (width, height) = (mask.width(), mask.height());
    let noise = silhouette.noise();
    // A pixel of the border may lie so far from the mask and still show the cylinder.
    let near = noise.beyond()[0].round() as i64;
    let border = (BORDER_PIXELS.get() * noise.pixel).round() as usize;
    let around = |range: Range<usize>, size: usize| {
        range.start.saturating_sub(near as usize)..(range.end + near as usize).min(size)
    };
    let (columns, rows) = mask.bounds();
    let (columns, rows) = (around(columns, width), around(rows, height));
    let near_mask = |column: usize, row: usize| {
        let span = -near..=near;
        span.clone().any(|down| {
            span.clone().any(|right| {
                // Outside the image a negative number becomes a large one, which the mask does not contain.
                mask.contains((column as i64 + right) as usize, (row as i64 + down) as usize)
            })
        })
    };
    // The pixels beside the border, without those that are nowhere near the mask.
    let (left, right) = (border.min(columns.end), (width - border.min(width)).max(border).max(columns.start));
    let pixels = rows.flat_map(|row| {
        let inner = row >= border && row + border < height;
        let [first, second] =
            if inner { [columns.start..left, right..columns.end] } else { [columns.clone(), 0..0] };
        first.chain(second).map(move |column| (column, row))
    });
    let mut last: Option<f64> = None;
    for (column, row) in pixels {
        let ray = surface.camera.unproject(&Vector2::new(column as f64, row as f64));
        let Some(point) = ray.and_then(|ray| surface.cylinder.first_hit(&ray)) else { continue };
        let position = (point - axis.point).dot(&axis.direction);
        let beyond = (position - silhouette.middle()) * outward;
        if beyond > 0.0 && last.is_none_or(|last| (position - last) * outward > 0.0) && near_mask(column, row)
        {
            last = Some(position);
        }
    }
    last
}
