//! What other points of a cloud hide: without a camera nothing else tells that a far wall shines through a near one.

use super::CancelCheck;
use super::image::{Image, NOTHING, depth_of};
use super::looks::LEAST_SIDE;
use super::points::Points;
use crate::detection::grid::STEEPEST;
use crate::error::Result;

/// Of two depths, none of which is no number.
#[inline(always)]
fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

impl Image {
    /// For each pixel the largest depth of a point on the surface that is nearest there or at a pixel beside it: what is farther by more
    /// than the steepest surface falls over a cell is hidden by that. Infinite where there is none.
    fn reach(&self) -> Vec<f32> {
        let (width, height) = (self.raster.width, self.raster.height);
        let factor = (1.0 + STEEPEST.get() * LEAST_SIDE as f64 * self.raster.spacing) as f32;
        // The least of each pixel and those beside it, of three rows.
        let mut rows = [(); 3].map(|()| vec![f32::INFINITY; width]);
        let mut padded = vec![f32::INFINITY; width + 2];
        let mut read = |row: usize, least: &mut [f32]| {
            padded[1..]
                .iter_mut()
                .zip(&self.nearest[row * width..(row + 1) * width])
                .for_each(|(padded, seen)| *padded = depth_of(*seen));
            let beside = padded[..width].iter().zip(&padded[1..]).zip(&padded[2..]);
            for (least, ((left, middle), right)) in least.iter_mut().zip(beside) {
                *least = lesser(lesser(*left, *middle), *right);
            }
        };
        let mut reach = Vec::with_capacity(width * height);
        read(0, &mut rows[1]);
        for row in 0..height {
            let [above, own, below] = &mut rows;
            match row + 1 < height {
                true => read(row + 1, below),
                false => below.fill(f32::INFINITY),
            }
            let beside = above.iter().zip(&*own).zip(&*below);
            reach.extend(beside.map(|((above, own), below)| factor * lesser(lesser(*above, *own), *below)));
            rows.rotate_left(1);
        }
        reach
    }

    /// How many of some points no others hide.
    pub fn count_seen(&self, points: &Points, check_cancel: &CancelCheck<'_>) -> Result<usize> {
        let reach = self.reach();
        let mut count = 0;
        self.raster.project(points, check_cancel, |_, pixels, depths| {
            let seen = |pixel: u32, z: f32| reach.get(pixel as usize).is_some_and(|reach| z <= *reach);
            count += pixels.iter().zip(depths).filter(|(pixel, z)| seen(**pixel, **z)).count();
        })?;
        Ok(count)
    }

    /// Empties the pixels that see something hidden: between the points of a near wall those of a far one shine through.
    pub fn close(&mut self) {
        self.closed = true;
        let reach = self.reach();
        for (seen, reach) in self.nearest.iter_mut().zip(&reach) {
            if depth_of(*seen) > *reach {
                *seen = NOTHING;
            }
        }
    }
}
