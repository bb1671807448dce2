//! Sums over cells for the plane and the quadratic surface through them, with the widest vector instructions of the machine.
//!
//! The sums run in [`LANES`] partial sums, and multiplications and additions are never fused: every machine gets the same bits.

use super::grid::Grid;
use nalgebra::{Matrix2, Matrix3, SMatrix, SVector, Vector2, Vector3};
use pulp::{Arch, Simd, WithSimd};

/// Positions up to the fourth degree but for their number, their products with w up to the second, and the square of w.
const SUMS: usize = 21;

/// Numbers side by side.
const LANES: usize = 8;

/// Sums over cells at positions (s, t) on the plane z = 1: from a position near them, in units of their size.
pub(super) struct Moments {
    center: Vector2<f64>,
    unit: f64,
    count: f64,
    /// Of s, t, s², st, t², s³, s²t, st², t³, s⁴, s³t, s²t², st³, t⁴, w, sw, tw, s²w, stw, t²w, w².
    sums: [f64; SUMS],
}

impl Moments {
    /// Those of the cells `which`, about the first of them.
    pub fn new(grid: &Grid, which: &[usize]) -> Self {
        let center =
            which.first().map_or(Vector2::zeros(), |&k| Vector2::new(grid.cells[k].x, grid.cells[k].y));
        let sums = Arch::new().dispatch(Pass { grid, which, center });
        Self { center, unit: grid.spacing, count: which.len() as f64, sums }
    }

    /// The number of cells.
    pub fn count(&self) -> f64 {
        self.count
    }

    /// The mean of the positions, in units from the centre.
    pub fn mean(&self) -> Vector2<f64> {
        Vector2::new(self.sums[0], self.sums[1]) / self.count
    }

    /// A position in units from the centre on the plane z = 1.
    pub fn on_plane(&self, position: &Vector2<f64>) -> Vector2<f64> {
        self.center + position * self.unit
    }

    /// The covariance of the positions, in units.
    pub fn covariance(&self) -> Matrix2<f64> {
        let [_, _, ss, st, tt, ..] = self.sums;
        let mean = self.mean();
        Matrix2::new(ss, st, st, tt) / self.count - mean * mean.transpose()
    }

    /// The plane w = a + b x + c y through the cells, and their root mean square distance from it in w.
    pub fn plane(&self) -> Option<(Vector3<f64>, f64)> {
        let (matrix, vector) = self.equations();
        let matrix: Matrix3<f64> = matrix.fixed_view::<3, 3>(0, 0).into();
        let vector: Vector3<f64> = vector.fixed_rows::<3>(0).into();
        let [a, s, t]: [f64; 3] = matrix.cholesky()?.solve(&vector).into();
        let rest = (self.sums[SUMS - 1] - vector.dot(&Vector3::new(a, s, t))).max(0.0);
        let (b, c) = (s / self.unit, t / self.unit);
        let plane = Vector3::new(a - b * self.center.x - c * self.center.y, b, c);
        Some((plane, (rest / (self.count - 3.0).max(1.0)).sqrt()))
    }

    /// The normal equations of w = a₀ + a₁ s + a₂ t + a₃ s² / 2 + a₄ s t + a₅ t² / 2.
    pub fn equations(&self) -> (SMatrix<f64, 6, 6>, SVector<f64, 6>) {
        let [s, t, ss, st, tt, s3, sst, stt, t3, s4, s3t, s2t2, st3, t4, w, sw, tw, ssw, stw, ttw, _] =
            self.sums;
        let rows = [
            [self.count, s, t, 0.5 * ss, st, 0.5 * tt],
            [s, ss, st, 0.5 * s3, sst, 0.5 * stt],
            [t, st, tt, 0.5 * sst, stt, 0.5 * t3],
            [0.5 * ss, 0.5 * s3, 0.5 * sst, 0.25 * s4, 0.5 * s3t, 0.25 * s2t2],
            [st, sst, stt, 0.5 * s3t, s2t2, 0.5 * st3],
            [0.5 * tt, 0.5 * stt, 0.5 * t3, 0.25 * s2t2, 0.5 * st3, 0.25 * t4],
        ];
        // It is symmetric.
        (rows.into(), SVector::from([w, sw, tw, 0.5 * ssw, stw, 0.5 * ttw]))
    }
}

/// One pass over cells.
struct Pass<'a> {
    grid: &'a Grid,
    which: &'a [usize],
    center: Vector2<f64>,
}

impl WithSimd for Pass<'_> {
    type Output = [f64; SUMS];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [f64; SUMS] {
        let Self { grid, which, center } = self;
        let per_unit = simd.splat_f64s(grid.spacing.recip());
        let (left, top) = (simd.splat_f64s(center.x), simd.splat_f64s(center.y));
        let mut sums = [[0.0; LANES]; SUMS];
        for chunk in which.chunks(LANES) {
            // What fills the last group up is at the centre, and adds nothing.
            let mut numbers = [[center.x; LANES], [center.y; LANES], [0.0; LANES]];
            for (k, &which) in chunk.iter().enumerate() {
                let cell = &grid.cells[which];
                (numbers[0][k], numbers[1][k], numbers[2][k]) = (cell.x, cell.y, cell.w);
            }
            for part in 0..LANES / S::F64_LANES {
                let [x, y, w] = [
                    S::as_simd_f64s(&numbers[0]).0[part],
                    S::as_simd_f64s(&numbers[1]).0[part],
                    S::as_simd_f64s(&numbers[2]).0[part],
                ];
                let s = simd.mul_f64s(simd.sub_f64s(x, left), per_unit);
                let t = simd.mul_f64s(simd.sub_f64s(y, top), per_unit);
                let (ss, st, tt) = (simd.mul_f64s(s, s), simd.mul_f64s(s, t), simd.mul_f64s(t, t));
                let products = [
                    s,
                    t,
                    ss,
                    st,
                    tt,
                    simd.mul_f64s(ss, s),
                    simd.mul_f64s(ss, t),
                    simd.mul_f64s(s, tt),
                    simd.mul_f64s(tt, t),
                    simd.mul_f64s(ss, ss),
                    simd.mul_f64s(ss, st),
                    simd.mul_f64s(st, st),
                    simd.mul_f64s(st, tt),
                    simd.mul_f64s(tt, tt),
                    w,
                    simd.mul_f64s(s, w),
                    simd.mul_f64s(t, w),
                    simd.mul_f64s(ss, w),
                    simd.mul_f64s(st, w),
                    simd.mul_f64s(tt, w),
                    simd.mul_f64s(w, w),
                ];
                for k in 0..SUMS {
                    let sum = &mut S::as_mut_simd_f64s(&mut sums[k]).0[part];
                    *sum = simd.add_f64s(*sum, products[k]);
                }
            }
        }
        sums.map(|sums| sums.iter().sum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detection::grid::Cell;
    use crate::memory::List;

    /// A grid whose cells lie on a quadratic surface of this size, with some noise.
    fn grid(size: f64) -> Grid {
        let spacing = 1.0 / 190.0;
        let cell = |k: usize| {
            let (x, y) = (0.3 + spacing * (k % 7) as f64, spacing * (k / 7) as f64 - 0.2);
            let w = size * (1.0 + 0.3 * x - 0.2 * y + 2.0 * x * y + ((k * k) % 11) as f64 * 1e-3);
            Cell { x, y, w, point: Vector3::new(x, y, 1.0) / w, sigma: 0.0, fill: 1.0 }
        };
        Grid {
            columns: 7,
            rows: 5,
            side: 3,
            spacing,
            cells: (0..35).map(cell).collect(),
            rays: Default::default(),
            bounds: Default::default(),
            inner: Vec::new(),
        }
    }

    #[test]
    fn equations_are_those_of_one_cell_after_the_other() {
        for size in [0.0, 1e-9, 1.0, 1e9] {
            let grid = grid(size);
            // More than a group, in any order.
            let which: List<usize> = (0..19).map(|k| k * 11 % 35).collect();
            let moments = Moments::new(&grid, &which);
            let (mut matrix, mut vector) = (SMatrix::<f64, 6, 6>::zeros(), SVector::<f64, 6>::zeros());
            for &k in &which {
                let cell = &grid.cells[k];
                let (s, t) =
                    ((cell.x - grid.cells[0].x) / grid.spacing, (cell.y - grid.cells[0].y) / grid.spacing);
                let row = SVector::<f64, 6>::from([1.0, s, t, 0.5 * s * s, s * t, 0.5 * t * t]);
                matrix += row * row.transpose();
                vector += row * cell.w;
            }
            let found = moments.equations();
            assert!((found.0 - matrix).amax() <= 1e-9 * matrix.amax(), "{} {matrix}", found.0);
            assert!((found.1 - vector).amax() <= 1e-9 * vector.amax(), "{} {vector}", found.1);
            let (plane, rms) = moments.plane().unwrap();
            let mut squares = 0.0;
            for &k in &which {
                let Cell { x, y, w, .. } = grid.cells[k];
                squares += (w - plane.dot(&Vector3::new(1.0, x, y))).powi(2);
            }
            let plain = (squares / (which.len() - 3) as f64).sqrt();
            assert!((rms - plain).abs() <= 1e-6 * plain, "{rms} {plain}");
            let mean = moments.on_plane(&moments.mean());
            let plain: Vector2<f64> =
                which.iter().map(|&k| Vector2::new(grid.cells[k].x, grid.cells[k].y) / 19.0).sum();
            assert!((mean - plain).amax() < 1e-12);
        }
    }
}
