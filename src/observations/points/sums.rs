//! Sums over the points of a cloud, and their places along a direction, with the widest instructions of the machine.

use nalgebra::{Matrix3, Vector3};
use pulp::{Simd, WithSimd};

/// Mean and covariance of points, in partial sums side by side with the widest instructions of the machine; they all round
/// alike.
pub(super) struct Moments<'a, T>(pub [&'a [T]; 3]);

impl<T: Copy + Into<f64>> WithSimd for Moments<'_, T> {
    type Output = (Vector3<f64>, Matrix3<f64>);

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Self::Output {
        const LANES: usize = 8;
        let count = self.0[0].len() as f64;
        let mean = self.0.map(|axis| {
            let mut sums = [0.0; LANES];
            let (values, rest) = axis.as_chunks::<LANES>();
            for values in values {
                for (sum, value) in sums.iter_mut().zip(values) {
                    *sum += (*value).into();
                }
            }
            let rest: f64 = rest.iter().map(|value| (*value).into()).sum();
            (sums.iter().sum::<f64>() + rest) / count
        });
        const PAIRS: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
        let product = |i: usize, k: usize, a: T, b: T| (a.into() - mean[i]) * (b.into() - mean[k]);
        let mut sums = [[0.0; LANES]; PAIRS.len()];
        let chunks = self.0.map(|axis| axis.as_chunks::<LANES>());
        // Some at a time, of which the processor has all three coordinates at hand.
        for start in (0..chunks[0].0.len()).step_by(BLOCK / LANES) {
            for ((i, k), sums) in PAIRS.into_iter().zip(&mut sums) {
                let part = |axis: usize| chunks[axis].0[start..].iter().take(BLOCK / LANES);
                for (a, b) in part(i).zip(part(k)) {
                    for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
                        *sum += product(i, k, *a, *b);
                    }
                }
            }
        }
        let mut covariance = Matrix3::zeros();
        for ((i, k), sums) in PAIRS.into_iter().zip(&sums) {
            let rest = chunks[i].1.iter().zip(chunks[k].1).map(|(a, b)| product(i, k, *a, *b)).sum::<f64>();
            let mean = (sums.iter().sum::<f64>() + rest) / count;
            (covariance[(i, k)], covariance[(k, i)]) = (mean, mean);
        }
        (Vector3::from(mean), covariance)
    }
}

/// Points that are looked at in one go.
const BLOCK: usize = 1024;

/// Where points are along a direction.
pub(super) struct Along<'a, T, F> {
    pub axes: [&'a [T]; 3],
    pub direction: [f64; 3],
    /// Who gets the places, a block at a time.
    pub block: F,
}

impl<T: Copy + Into<f64>, F: FnMut(&[f64])> WithSimd for Along<'_, T, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { axes: [x, y, z], direction: [a, b, c], block: mut receive } = self;
        let mut places = [0.0; BLOCK];
        for ((x, y), z) in x.chunks(BLOCK).zip(y.chunks(BLOCK)).zip(z.chunks(BLOCK)) {
            for (((place, x), y), z) in places.iter_mut().zip(x).zip(y).zip(z) {
                *place = a * (*x).into() + b * (*y).into() + c * (*z).into();
            }
            receive(&places[..x.len()]);
        }
    }
}
