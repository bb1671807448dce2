//! What the covariance of a minimum takes of points.

use super::{Coordinates, Groups, Kernel, Notes, Terms, add, products};
use crate::geometry::{Tangent, TangentMap};
use crate::residuals::loss::{Influence, Loss};
use pulp::Simd;

/// Distinct sums of [`Influences`].
const INFLUENCES: usize = 17;

/// What the covariance of a minimum needs of every point with its Jacobian J and weight w.
#[derive(Clone, Copy)]
pub(in super::super) struct Influences<'a, L> {
    pub loss: L,
    /// What the weights of the points are multiplied by.
    pub part: f64,
    /// The step to the minimum of the points, which takes a part of the residuals away.
    pub to_minimum: &'a Tangent,
    /// The leverage of a point is w Jᵀ L J with this matrix L, at most
    pub leverages: &'a TangentMap,
    /// this.
    pub largest_leverage: f64,
}

impl<L: Loss> Influences<'_, L> {
    /// Jᵀ L J of points.
    #[inline(always)]
    fn leverage<S: Simd>(&self, simd: S, [a, b, h]: [S::f64s; 3]) -> S::f64s {
        let once = |i: usize| simd.splat_f64s(self.leverages[(i, i)]);
        let twice = |i: usize, k: usize| simd.splat_f64s(2.0 * self.leverages[(i, k)]);
        let both = simd.splat_f64s(2.0 * (self.leverages[(0, 3)] + self.leverages[(1, 2)]));
        let times_h = |c: S::f64s, d: S::f64s| simd.add_f64s(c, simd.mul_f64s(h, d));
        let of_aa = times_h(once(0), times_h(twice(0, 2), once(2)));
        let of_ab = times_h(twice(0, 1), times_h(both, twice(2, 3)));
        let of_bb = times_h(once(1), times_h(twice(1, 3), once(3)));
        let (of_a, of_b) = (times_h(twice(0, 4), twice(2, 4)), times_h(twice(1, 4), twice(3, 4)));
        let of_a = simd.add_f64s(simd.add_f64s(simd.mul_f64s(of_aa, a), simd.mul_f64s(of_ab, b)), of_a);
        let of_b = simd.add_f64s(simd.mul_f64s(of_bb, b), of_b);
        simd.add_f64s(simd.add_f64s(simd.mul_f64s(of_a, a), simd.mul_f64s(of_b, b)), once(4))
    }
}

impl<L: Loss> Terms<INFLUENCES> for Influences<'_, L> {
    /// Weights, slopes of the influence, their squares, and influence times influence, in rounds as [`Whole`].
    #[inline(always)]
    fn sums<S: Simd>(
        &self,
        simd: S,
        kernel: &Kernel,
        groups: &Groups<'_>,
        notes: &mut Notes<S::f64s>,
    ) -> [S::f64s; INFLUENCES] {
        let zero = simd.splat_f64s(0.0);
        let (mut slopes, mut linear) = ([zero; 3], [zero; 5]);
        let step = self.to_minimum;
        let (part, largest) = (simd.splat_f64s(self.part), simd.splat_f64s(self.largest_leverage));
        for group in groups.range() {
            let (Coordinates { a, b, h, facing, .. }, e, weight) = groups.at(simd, kernel, group);
            let part = simd.mul_f64s(weight, part);
            let Influence { weight, slope, .. } = self.loss.influences(simd, e, facing);
            let w = simd.mul_f64s(part, weight);
            let part_slope = simd.mul_f64s(part, slope);
            // J is the negative of a, b, h a, h b and 1: that matters for the noise alone.
            let leverage = simd.min_f64s(simd.mul_f64s(w, self.leverage(simd, [a, b, h])), largest);
            let mut noise = simd.sub_f64s(e, simd.splat_f64s(step[4]));
            for (k, direction) in [a, b].into_iter().enumerate() {
                let along = simd.mul_f64s(h, simd.splat_f64s(step[k + 2]));
                let along = simd.add_f64s(simd.splat_f64s(step[k]), along);
                noise = simd.sub_f64s(noise, simd.mul_f64s(direction, along));
            }
            let noise = simd.div_f64s(noise, simd.sub_f64s(simd.splat_f64s(1.0), leverage));
            let factor = simd.mul_f64s(w, noise);
            add(simd, &mut slopes, [w, part_slope, simd.mul_f64s(part_slope, slope)]);
            notes[group] = [simd.mul_f64s(factor, factor), zero, a, b, h];
        }
        for [square, of_b, a, b, h] in notes.iter_mut().take(groups.count) {
            let (wa, wb) = (simd.mul_f64s(*square, *a), simd.mul_f64s(*square, *b));
            add(simd, &mut linear, [*square, wa, wb, simd.mul_f64s(wa, *h), simd.mul_f64s(wb, *h)]);
            (*square, *of_b) = (wa, wb);
        }
        let mut sums = [zero; INFLUENCES];
        sums[..3].copy_from_slice(&slopes);
        sums[3..8].copy_from_slice(&linear);
        sums[8..].copy_from_slice(&products(simd, notes, groups.count));
        sums
    }
}
