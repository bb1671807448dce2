//! Ends that the border of the image cuts off.

use super::silhouette::Silhouette;
use crate::memory::List;
use crate::observations::Mask;
use std::ops::Range;

constants! {
    /// How many rows and columns along the border are looked at: beside a limb, where the line of sight grazes the
    /// surface, a pixel one row further in may show a point further out. In pixels of the drawing.
    BORDER_PIXELS = 4.0, "drawn px";

    /// A mask is off by so many deviations of its boundary, beside what it is off by at the limbs.
    DEVIATIONS = 2.0, "σ";
}

/// The last position towards `outward` at which a pixel of the image still shows the surface, and its standard deviation where one pixel
/// is `pixel` long. On a surface that runs out of the image that is a pixel of the border, near the mask. Where a mask that was `drawn`
/// up to the border stops short of a limb there, the surface ends inside the image, and the mask shows the last of it.
pub(super) fn last_inside(
    silhouette: &Silhouette<'_>,
    drawn: bool,
    outward: f64,
    pixel: f64,
) -> Option<[f64; 2]> {
    let surface = silhouette.surface();
    let (mask, axis) = (silhouette.mask(), surface.cylinder.axis);
    let (width, height) = (mask.width(), mask.height());
    let noise = silhouette.noise();
    // A pixel of the border may lie so far from the mask and still show the cylinder: farther where the mask is narrower at the limbs, too.
    let farthest = noise.beyond()[0];
    let off =
        |bias: f64| (DEVIATIONS.get() * noise.boundary - bias).clamp(noise.pixel.min(farthest), farthest);
    let reach = silhouette.bias().filter(|_| drawn).map_or(farthest, off);
    let reach = (reach.round() as usize).min(width.max(height));
    let border = (BORDER_PIXELS.get() * noise.pixel).round() as usize;
    let near_mask = NearMask::new(mask, reach);
    let around = |range: Range<usize>, size: usize| {
        range.start.saturating_sub(2 * reach)..(range.end + 2 * reach).min(size)
    };
    let (columns, rows) = mask.bounds();
    let reaches_border = columns.start == 0 || rows.start == 0 || columns.end == width || rows.end == height;
    let (columns, rows) = (around(columns, width), around(rows, height));
    // The pixels beside the border, without those that are far from the mask.
    let (left, right) = (border.min(columns.end), (width - border.min(width)).max(border).max(columns.start));
    let pixels = rows.flat_map(|row| {
        let inner = row >= border && row + border < height;
        let [first, second] =
            if inner { [columns.start..left, right..columns.end] } else { [columns.clone(), 0..0] };
        first.chain(second).map(move |column| (column, row))
    });
    // In the mask, near it, and of all these pixels: how far beyond the middle.
    let middle = silhouette.middle();
    let [mut in_mask, mut near, mut any] = [0.0_f64; 3];
    for (column, row) in pixels {
        let ray = surface.camera.ray_of_pixel(column, row);
        let Some(point) = ray.and_then(|ray| surface.cylinder.first_hit(&ray)) else { continue };
        let beyond = (axis.position_of(&point) - middle) * outward;
        any = any.max(beyond);
        if beyond > near && near_mask.contains(column, row) {
            near = beyond;
        }
        if beyond > in_mask && mask.contains(column, row) {
            in_mask = beyond;
        }
    }
    let last = if drawn && reaches_border && near < any && in_mask > 0.0 { in_mask } else { near };
    // How far the mask is off there is not known.
    let off = if drawn && in_mask > 0.0 { (near - in_mask) / 3.0_f64.sqrt() } else { 0.0 };
    (last > 0.0).then(|| [middle + outward * last, pixel.hypot(off)])
}

/// The pixels within a square about some pixel of a mask. However large the square, a pixel takes as long: the pixels of the mask
/// in it follow from their numbers above and to the left of its corners.
struct NearMask {
    reach: usize,
    columns: Range<usize>,
    rows: Range<usize>,
    /// The pixels of the mask above and to the left of each corner of a pixel of its bounds, row by row.
    counts: List<u32>,
}

impl NearMask {
    fn new(mask: &Mask, reach: usize) -> Self {
        let (columns, rows) = mask.bounds();
        let width = columns.len() + 1;
        let mut counts = List::filled(0, width * (rows.len() + 1));
        for (y, row) in rows.clone().enumerate() {
            let mut of_row = 0;
            for (x, column) in columns.clone().enumerate() {
                of_row += u32::from(mask.contains(column, row));
                counts[(y + 1) * width + x + 1] = counts[y * width + x + 1] + of_row;
            }
        }
        Self { reach, columns, rows, counts }
    }

    fn contains(&self, column: usize, row: usize) -> bool {
        let span = |at: usize, bounds: &Range<usize>| {
            [at.saturating_sub(self.reach), at + self.reach + 1]
                .map(|x| x.clamp(bounds.start, bounds.end) - bounds.start)
        };
        let [[left, right], [top, bottom]] = [span(column, &self.columns), span(row, &self.rows)];
        let count = |x: usize, y: usize| self.counts[y * (self.columns.len() + 1) + x];
        count(right, bottom) + count(left, top) > count(left, bottom) + count(right, top)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observations::MaskView;

    #[test]
    fn pixels_near_a_mask_are_those_within_a_square() {
        let size = (9, 7);
        let mut pixels = [0_u8; 63];
        for (column, row) in [(2, 1), (6, 4), (7, 4)] {
            pixels[row * size.0 + column] = 255;
        }
        let mask = Mask::copy(&MaskView::from_u8(&pixels, size).unwrap()).unwrap();
        for reach in [0, 1, 2, 9] {
            let near = NearMask::new(&mask, reach);
            for (column, row) in (0..size.1).flat_map(|row| (0..size.0).map(move |column| (column, row))) {
                let within = |x: usize, y: usize| {
                    pixels[y * size.0 + x] > 0 && x.abs_diff(column) <= reach && y.abs_diff(row) <= reach
                };
                let expected = (0..size.1).any(|y| (0..size.0).any(|x| within(x, y)));
                assert_eq!(near.contains(column, row), expected, "{reach}: {column}, {row}");
            }
        }
    }
}
