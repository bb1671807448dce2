//! Depth images of which pixels beside each other are rarely measured both.
//!
//! Depth that was measured on a coarser grid and was moved to the image pixel by pixel, by a driver or by hand, leaves holes between
//! its pixels. What looks at neighbours sees nothing there.

use super::depth::DepthImage;
use crate::error::Result;

/// The widest spacing that is filled, in pixels.
const WIDEST: usize = 4;

/// Every so many rows and columns tell the spacing: no multiple of any that is filled, or all of them may lie in the gaps.
const EVERY: usize = 7;

/// The distance within which half of the measured pixels of some lines have the next one, 1 for a neighbour; `None` where it is more than
/// [`WIDEST`] or nothing was measured. A line has its values in the order of its pixels.
fn spacing<'a>(lines: impl Iterator<Item = impl Iterator<Item = &'a f32>>) -> Option<usize> {
    let (mut measured, mut next) = (0, [0; WIDEST]);
    for line in lines {
        let mut last = None;
        let present = line.enumerate().filter(|(_, value)| **value > 0.0);
        for (index, _) in present {
            measured += 1;
            let count = last.replace(index).and_then(|last| next.get_mut(index - last - 1));
            count.into_iter().for_each(|count| *count += 1);
        }
    }
    let mut within = 0;
    let is_half = |count: &usize| {
        within += count;
        2 * within >= measured
    };
    next.iter().position(is_half).filter(|_| measured > 0).map(|step| step + 1)
}

/// A line whose pixels without a measurement have the nearest depth of the measured ones that are no farther away than half the spacing.
fn filled(line: &[f32], spacing: usize) -> impl Iterator<Item = f32> {
    let (before, after) = (spacing / 2, (spacing - 1) / 2);
    line.iter().enumerate().map(move |(index, &value)| {
        if value > 0.0 {
            return value;
        }
        let near = &line[index.saturating_sub(before)..(index + after + 1).min(line.len())];
        near.iter().copied().filter(|value| *value > 0.0).reduce(f32::min).unwrap_or(0.0)
    })
}

impl DepthImage {
    /// The image with the holes filled that a coarser grid leaves, by the nearest depth beside them; `None` where there are no such holes.
    ///
    /// # Errors
    /// `OutOfMemory`.
    pub(crate) fn without_gaps(&self) -> Result<Option<Self>> {
        let (width, height) = self.size();
        let rows = (0..height).step_by(EVERY).map(|row| self.values_of_row(row).iter());
        let column = |column: usize| (0..height).map(move |row| &self.values_of_row(row)[column]);
        let columns = (0..width).step_by(EVERY).map(column);
        let (across, down) = (spacing(rows), spacing(columns));
        let (Some(across), Some(down)) = (across, down) else { return Ok(None) };
        if across == 1 && down == 1 {
            return Ok(None);
        }
        let mut image = Self::empty((width, height), self.scale(), self.pixel() * across.max(down) as f64)?;
        for row in 0..height {
            let values = filled(self.values_of_row(row), across);
            image.values_of_row_mut(row).iter_mut().zip(values).for_each(|(to, value)| *to = value);
        }
        let mut before = Vec::with_capacity(height);
        for column in 0..width {
            before.clear();
            before.extend((0..height).map(|row| image.values_of_row(row)[column]));
            let values = filled(&before, down).enumerate();
            values.for_each(|(row, value)| image.values_of_row_mut(row)[column] = value);
        }
        Ok(Some(image))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observations::DepthView;

    /// 60 × 40 pixels, one in `across` × `down` of them measured, at a depth of its column.
    fn image(across: usize, down: usize) -> DepthImage {
        let pixel = |k: usize| match (k % 60 % across, k / 60 % down) {
            (0, 0) => 1000 + (k % 60) as u16,
            _ => 0,
        };
        let pixels: Vec<u16> = (0..60 * 40).map(pixel).collect();
        DepthImage::copy(&DepthView::from_u16(&pixels, (60, 40), 1.0).unwrap()).unwrap()
    }

    #[test]
    fn gaps_are_filled_with_the_depth_beside_them() {
        for (across, down) in [(2, 2), (3, 3), (4, 4), (1, 2), (3, 1)] {
            let filled = image(across, down).without_gaps().unwrap().unwrap();
            for (row, column) in
                (0..40 - 2 * down).flat_map(|row| (0..60 - 2 * across).map(move |column| (row, column)))
            {
                let depth = filled.depth(column, row).unwrap();
                assert!(
                    (depth - 1000.0 - column as f64).abs() <= across as f64 / 2.0,
                    "{across} {down}: {column} {row} {depth}"
                );
            }
        }
    }

    #[test]
    fn gaps_are_told_wherever_the_grid_begins() {
        for (spacing, first) in [(2, 1), (3, 1), (3, 2), (4, 1), (4, 2), (4, 3)] {
            let is_measured = |k: usize| k % spacing == first;
            let pixel = |k: usize| u16::from(is_measured(k % 60) && is_measured(k / 60));
            let pixels: Vec<u16> = (0..60 * 40).map(pixel).collect();
            let image = DepthImage::copy(&DepthView::from_u16(&pixels, (60, 40), 1.0).unwrap()).unwrap();
            assert!(image.without_gaps().unwrap().is_some(), "{spacing} {first}");
        }
    }

    #[test]
    fn images_without_gaps_or_with_wide_ones_stay() {
        assert!(image(1, 1).without_gaps().unwrap().is_none());
        assert!(image(5, 5).without_gaps().unwrap().is_none());
        assert!(image(100, 100).without_gaps().unwrap().is_none());
    }

    #[test]
    fn the_nearest_of_the_depths_beside_a_gap_fills_it() {
        let filled: Vec<f32> = filled(&[2.0, 0.0, 1.0, 0.0, 0.0, 3.0], 3).collect();
        assert_eq!(filled, [2.0, 1.0, 1.0, 1.0, 3.0, 3.0]);
    }
}
