//! The tall system by orthogonal factorisation: the reference for the normal equations, and what they cannot
//! tell, because they square the condition of the problem.

use crate::error::{Error, Result};
use crate::geometry::Tangent;
use faer::{Mat, linalg::solvers::Svd};

/// Singular values below this part of the largest one are rounding errors of thousands of rows.
const RANK_TOLERANCE: f64 = 1e-12;

/// A linear least-squares problem J δ ≈ −e of five unknowns, one row a residual, factorised.
#[derive(Debug, Clone)]
pub struct LeastSquares {
    /// R of J = Q R with e as a sixth column: all that the rows say about the unknowns.
    triangle: Mat<f64>,
}

/// What the rows of a least-squares problem determine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rank {
    /// Singular values of the Jacobian, the largest first.
    pub singular_values: [f64; 5],
    /// How many of them stand out of the rounding error.
    pub rank: usize,
    /// Largest over smallest singular value; infinity when the smallest is 0.
    pub condition: f64,
    /// The unit step along which the residuals change least.
    pub weakest: Tangent,
}

impl LeastSquares {
    /// Factorises the rows (residual, Jacobian) by Householder QR.
    ///
    /// # Errors
    /// `TooFewPoints` for fewer than five rows, `Numerical` when a number is not finite.
    pub fn new(rows: &[(f64, Tangent)]) -> Result<Self> {
        if rows.len() < 5 {
            return Err(Error::TooFewPoints {
                usable: rows.len(),
                given: rows.len(),
                left_out: String::new(),
                needed: 5,
                remedy: "give more points",
            });
        }
        if !rows.iter().all(|(e, j)| e.is_finite() && j.iter().all(|x| x.is_finite())) {
            return Err(Error::Numerical { what: "a residual or its derivative is not finite" });
        }
        let stacked = Mat::from_fn(
            rows.len(),
            6,
            |row, column| if column < 5 { rows[row].1[column] } else { rows[row].0 },
        );
        Ok(Self { triangle: stacked.qr().thin_R().to_owned() })
    }

    /// Singular values, rank and the weakest step.
    ///
    /// # Errors
    /// `Numerical` when the factorisation does not converge.
    pub fn rank(&self) -> Result<Rank> {
        let svd = self.singular_value_decomposition()?;
        let singular_values: [f64; 5] = std::array::from_fn(|k| svd.S().column_vector()[k]);
        let threshold = singular_values[0] * RANK_TOLERANCE;
        Ok(Rank {
            singular_values,
            rank: singular_values.iter().filter(|&&value| value > threshold).count(),
            condition: singular_values[0] / singular_values[4],
            weakest: Tangent::from_fn(|k, _| svd.V()[(k, 4)]),
        })
    }

    fn singular_value_decomposition(&self) -> Result<Svd<f64>> {
        let jacobian = self.triangle.get(..5, ..5);
        jacobian
            .thin_svd()
            .map_err(|_| Error::Numerical { what: "singular value decomposition of the Jacobian" })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl LeastSquares {
        /// The step δ that minimises ‖e + J δ‖, of least norm where the rows leave it open.
        fn step(&self) -> Tangent {
            let svd = self.singular_value_decomposition().unwrap();
            let residual = Tangent::from_fn(|k, _| self.triangle[(k, 5)]);
            let largest = svd.S().column_vector()[0];
            let mut step = Tangent::zeros();
            for k in 0..5 {
                let value = svd.S().column_vector()[k];
                if value > largest * RANK_TOLERANCE {
                    let along: f64 = (0..5).map(|row| svd.U()[(row, k)] * residual[row]).sum();
                    step -= Tangent::from_fn(|row, _| svd.V()[(row, k)]) * (along / value);
                }
            }
            step
        }
    }

    fn rows() -> Vec<(f64, Tangent)> {
        (0..60)
            .map(|k| {
                let t = f64::from(k);
                let j = Tangent::new(t.sin(), t.cos(), (0.3 * t).sin(), 0.01 * t, 1.0);
                (0.2 * (1.7 * t).sin() + 0.1, j)
            })
            .collect()
    }

    #[test]
    fn the_step_solves_the_normal_equations() {
        let rows = rows();
        let step = LeastSquares::new(&rows).unwrap().step();
        let remaining: Tangent = rows.iter().map(|(e, j)| j * (e + j.dot(&step))).sum();
        assert!(remaining.norm() < 1e-12, "{remaining}");
    }

    #[test]
    fn a_missing_direction_is_named() {
        let rows: Vec<_> =
            rows().into_iter().map(|(e, j)| (e, Tangent::new(j[0], j[1], 0.0, j[3], j[4]))).collect();
        let rank = LeastSquares::new(&rows).unwrap().rank().unwrap();
        assert_eq!(rank.rank, 4);
        assert!((rank.weakest[2].abs() - 1.0).abs() < 1e-12);
        assert!(rank.condition > 1e12);
    }

    #[test]
    fn too_few_rows_and_bad_numbers_are_errors() {
        assert_eq!(LeastSquares::new(&rows()[..4]).unwrap_err().name(), "TOO_FEW_POINTS");
        let mut bad = rows();
        bad[7].0 = f64::NAN;
        assert_eq!(LeastSquares::new(&bad).unwrap_err().name(), "NUMERICAL");
    }
}
