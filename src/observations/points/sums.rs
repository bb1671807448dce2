//! Sums over the points of a cloud, and their positions along a direction, with the widest instructions of the machine.

use nalgebra::{Matrix3, Vector3};
use pulp::{Simd, WithSimd};

/// Mean and covariance of points, in partial sums side by side with the widest instructions of the machine; they all round
/// alike.
pub(super) struct Moments<'a, T>(pub [&'a [T]; 3]);

impl<T: Copy + Into<f64>> WithSimd for Moments<'_, T> {
    type Output = (Vector3<f64>, Matrix3<f64>);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        const LANES: usize = 8;
        // Some at a time, of which the processor has all three coordinates at hand, and which take little of the stack.
        const GROUPS: usize = 4;
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
        let mut sums = [[0.0; LANES]; PAIRS.len()];
        let chunks = self.0.map(|axis| axis.as_chunks::<LANES>());
        let mut offsets = [[[0.0; LANES]; GROUPS]; 3];
        for start in (0..chunks[0].0.len()).step_by(GROUPS) {
            for k in 0..3 {
                for (offsets, values) in offsets[k].iter_mut().zip(&chunks[k].0[start..]) {
                    for (offset, value) in offsets.iter_mut().zip(values) {
                        *offset = (*value).into() - mean[k];
                    }
                }
            }
            let count = (GROUPS).min(chunks[0].0.len() - start);
            let [x, y, z] = &offsets;
            // As many lanes as an instruction takes, whose sums the processor holds in its registers.
            for part in 0..LANES / S::F64_LANES {
                let mut own = [simd.splat_f64s(0.0); PAIRS.len()];
                for (own, sums) in own.iter_mut().zip(&sums) {
                    *own = S::as_simd_f64s(sums).0[part];
                }
                for ((x, y), z) in x.iter().zip(y).zip(z).take(count) {
                    let (x, y, z) = (S::as_simd_f64s(x).0, S::as_simd_f64s(y).0, S::as_simd_f64s(z).0);
                    let offsets = [x[part], y[part], z[part]];
                    for (own, (i, k)) in own.iter_mut().zip(&PAIRS) {
                        *own = simd.add_f64s(*own, simd.mul_f64s(offsets[*i], offsets[*k]));
                    }
                }
                for (own, sums) in own.iter().zip(&mut sums) {
                    S::as_mut_simd_f64s(sums).0[part] = *own;
                }
            }
        }
        let product = |i: usize, k: usize, a: T, b: T| (a.into() - mean[i]) * (b.into() - mean[k]);
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
    /// Who gets the positions, a block at a time.
    pub block: F,
}

impl<T: Copy + Into<f64>, F: FnMut(&[f64])> WithSimd for Along<'_, T, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { axes: [x, y, z], direction: [a, b, c], block: mut receive } = self;
        let mut positions = [0.0; BLOCK];
        for ((x, y), z) in x.chunks(BLOCK).zip(y.chunks(BLOCK)).zip(z.chunks(BLOCK)) {
            for (((position, x), y), z) in positions.iter_mut().zip(x).zip(y).zip(z) {
                *position = a * (*x).into() + b * (*y).into() + c * (*z).into();
            }
            receive(&positions[..x.len()]);
        }
    }
}
