//! What other points of a cloud hide: without a camera nothing else tells that a far wall shines through a near one.

use super::Image;
use super::looks::LEAST_SIDE;
use crate::detection::grid::STEEPEST;

impl Image {
    /// For each pixel the largest depth of a point on the surface that is nearest there or at a pixel beside it: what is farther by more
    /// than the steepest surface falls over a cell is hidden by that. Infinite where there is none. In single precision: a large
    /// cloud has as many pixels as points.
    fn reach(&self, depths: &[f64]) -> Vec<f32> {
        let of_none = |k: u32| k as usize == depths.len() - 1;
        let depth = |&k: &u32| if of_none(k) { f32::INFINITY } else { depths[k as usize] as f32 };
        let mut rows: Vec<f32> = Vec::with_capacity(self.nearest.len());
        let mut padded = vec![f32::INFINITY; self.width + 2];
        for row in self.nearest.chunks_exact(self.width) {
            padded[1..].iter_mut().zip(row.iter().map(depth)).for_each(|(padded, depth)| *padded = depth);
            rows.extend(padded.windows(3).map(|three| three[0].min(three[1]).min(three[2])));
        }
        let factor = (1.0 + STEEPEST * LEAST_SIDE as f64 * self.spacing) as f32;
        let row = |k: usize| &rows[k * self.width..(k + 1) * self.width];
        let count = rows.len() / self.width;
        let mut reach = Vec::with_capacity(rows.len());
        for k in 0..count {
            let beside = row(k.saturating_sub(1)).iter().zip(row((k + 1).min(count - 1)));
            reach.extend(
                row(k).iter().zip(beside).map(|(z, (above, below))| factor * z.min(*above).min(*below)),
            );
        }
        reach
    }

    /// How many points no others hide.
    pub fn seen(&self, depths: &[f64]) -> usize {
        let reach = self.reach(depths);
        let seen = |pixel: u32, z: f64| reach.get(pixel as usize).is_some_and(|&reach| z <= f64::from(reach));
        self.pixels.iter().zip(depths).filter(|(pixel, z)| seen(**pixel, **z)).count()
    }

    /// Empties the pixels that see something hidden: between the points of a near wall those of a far one shine through.
    pub fn close(&mut self, depths: &[f64]) {
        self.closed = true;
        let reach = self.reach(depths);
        let none = (depths.len() - 1) as u32;
        for (k, reach) in self.nearest.iter_mut().zip(&reach) {
            if depths[*k as usize] > f64::from(*reach) {
                *k = none;
            }
        }
    }
}
