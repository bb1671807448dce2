//! How uncertain the minimum of an objective is.
//!
//! To first order the minimum moves by −A⁻¹ g, with half the gradient g of the objective at the true cylinder and its
//! expected derivative A. With the covariance B of g the covariance of the minimum is A⁻¹ B A⁻¹: the sandwich formula
//! of M-estimators (Huber, Robust Statistics, 1981, section 6.3). It holds whatever the weights are, good or bad:
//! they only have to be the ones that were used.

use crate::geometry::{Tangent, TangentMap};
use nalgebra::SymmetricEigen;

/// What rounding leaves of nothing in sums of squares over thousands of points, as a part of their terms.
const ROUNDING: f64 = 1e-13;

/// What one kind of residuals adds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SandwichPart {
    /// Half the gradient of its part of the objective, g.
    pub gradient: Tangent,
    /// The expected derivative of that, A.
    pub derivative: TangentMap,
    /// Its covariance, B.
    pub covariance: TangentMap,
}

/// Gradient, its expected derivative and its covariance, in the tangent of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sandwich {
    /// What the points add.
    pub points: SandwichPart,
    /// What the image adds: given segments, located limb lines and arcs of the ends. Zero where none count.
    pub image: SandwichPart,
}

impl SandwichPart {
    /// No residuals.
    #[must_use]
    pub fn zero() -> Self {
        Self { gradient: Tangent::zeros(), derivative: TangentMap::zeros(), covariance: TangentMap::zeros() }
    }

    /// Adds a part that the objective takes `factor` times.
    pub(super) fn add_scaled(&mut self, factor: f64, part: &Self) {
        self.gradient += part.gradient * factor;
        self.derivative += part.derivative * factor;
        self.covariance += part.covariance * (factor * factor);
    }
}

impl Sandwich {
    /// A of everything.
    #[must_use]
    pub fn derivative(&self) -> TangentMap {
        self.points.derivative + self.image.derivative
    }

    /// The covariance of the minimum, A⁻¹ B A⁻¹, over the degrees of freedom that are not `known`; these have none.
    /// `None` where the data do not determine the others.
    #[must_use]
    pub fn covariance(&self, known: &[bool; 5]) -> Option<TangentMap> {
        let inverse = self.inverse(known)?;
        let of_gradient = self.points.covariance + self.image.covariance;
        let root = root(&(inverse * of_gradient * inverse))?;
        Some(root * root.transpose())
    }

    /// The step to the minimum from where the gradient is not 0, −A⁻¹ g, to first order, over the degrees of freedom that are
    /// not `known`. `None` where the data do not determine it.
    #[must_use]
    pub fn step(&self, known: &[bool; 5]) -> Option<Tangent> {
        let step = -(self.inverse(known)? * (self.points.gradient + self.image.gradient));
        step.iter().all(|x| x.is_finite()).then_some(step)
    }

    /// A⁻¹ over the degrees of freedom that are not `known`, 0 in the rows and columns of the others.
    fn inverse(&self, known: &[bool; 5]) -> Option<TangentMap> {
        let mut derivative = self.derivative();
        let known = || (0..5).filter(|&k| known[k]);
        for k in known() {
            derivative.fill_row(k, 0.0);
            derivative.fill_column(k, 0.0);
            derivative[(k, k)] = 1.0;
        }
        if !is_determined(&derivative) {
            return None;
        }
        let mut inverse = derivative.cholesky()?.inverse();
        known().for_each(|k| inverse[(k, k)] = 0.0);
        Some(inverse)
    }
}

/// Whether what is known of every degree of freedom stands out of the rounding of the sums, each in its own unit.
fn is_determined(derivative: &TangentMap) -> bool {
    let Some(scaled) = scaled(derivative) else { return false };
    scaled.1.symmetric_eigenvalues().min() > ROUNDING
}

/// A matrix L with L Lᵀ = C for a covariance C, where rounding made its small variances negative too; `None` where a
/// number is not finite.
pub(crate) fn root(covariance: &TangentMap) -> Option<TangentMap> {
    let (sizes, correlation) = scaled(covariance)?;
    let SymmetricEigen { eigenvalues, eigenvectors } = correlation.symmetric_eigen();
    let roots = eigenvalues.map(|variance| variance.max(0.0).sqrt());
    Some(TangentMap::from_diagonal(&sizes) * eigenvectors * TangentMap::from_diagonal(&roots))
}

/// The roots of the diagonal, and the symmetric matrix in units of them; where the diagonal is not positive the row is 0.
fn scaled(matrix: &TangentMap) -> Option<(Tangent, TangentMap)> {
    let sizes = matrix.diagonal().map(|variance| variance.max(0.0).sqrt());
    let inverse = TangentMap::from_diagonal(&sizes.map(|size| if size > 0.0 { size.recip() } else { 0.0 }));
    let scaled = inverse * (matrix + matrix.transpose()) * inverse * 0.5;
    (sizes.iter().chain(&scaled).all(|x| x.is_finite())).then_some((sizes, scaled))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(derivative: TangentMap, covariance: TangentMap) -> SandwichPart {
        SandwichPart { gradient: Tangent::zeros(), derivative, covariance }
    }

    fn of_points(derivative: TangentMap, covariance: TangentMap) -> Sandwich {
        Sandwich { points: part(derivative, covariance), image: SandwichPart::zero() }
    }

    /// Six rows, of which five are independent, in units as different as can be.
    fn derivative(last: f64) -> TangentMap {
        let units = Tangent::new(1.0, 1e-5, 1e4, 1.0, last);
        let row =
            |k: u32| Tangent::from_fn(|i, _| (f64::from(k) * (1.3 + i as f64)).sin()).component_mul(&units);
        (1..=6).map(row).map(|row| row * row.transpose()).sum()
    }

    #[test]
    fn the_root_of_a_covariance_gives_it_back() {
        let covariance = derivative(1e-3);
        let root = root(&covariance).unwrap();
        let difference = root * root.transpose() - covariance;
        for (row, column) in (0..5).flat_map(|row| (0..5).map(move |column| (row, column))) {
            let size = (covariance[(row, row)] * covariance[(column, column)]).sqrt();
            assert!(difference[(row, column)].abs() <= 1e-14 * size, "{row} {column}");
        }
    }

    #[test]
    fn variances_that_rounding_made_negative_are_none() {
        let mut covariance = TangentMap::identity();
        (covariance[(0, 1)], covariance[(1, 0)]) = (1.0 + 1e-9, 1.0 + 1e-9);
        covariance[(4, 4)] = -1e-20;
        let root = root(&covariance).unwrap();
        let mended = root * root.transpose();
        assert!(mended.diagonal().iter().all(|variance| *variance >= 0.0));
        assert!(mended[(0, 1)].powi(2) <= (1.0 + 1e-15) * mended[(0, 0)] * mended[(1, 1)]);
        covariance[(2, 2)] = f64::NAN;
        assert!(super::root(&covariance).is_none());
    }

    #[test]
    fn the_step_leads_to_the_minimum_and_leaves_what_is_known() {
        let minimum = Tangent::new(0.3, -2e4, 1e-5, 0.4, -0.5);
        let mut sandwich = of_points(derivative(1e-3), TangentMap::identity());
        sandwich.points.gradient = -(derivative(1e-3) * minimum);
        let step = sandwich.step(&[false; 5]).unwrap();
        assert!(step.iter().zip(&minimum).all(|(a, b)| (a / b - 1.0).abs() < 1e-6), "{step}");
        assert_eq!(sandwich.step(&[false, false, false, false, true]).unwrap()[4], 0.0);
    }

    #[test]
    fn what_nothing_determines_has_no_covariance() {
        let known = [false; 5];
        let sandwich = of_points(derivative(1e-3), TangentMap::identity());
        assert!(sandwich.covariance(&known).is_some());
        // Two rows alike but for rounding.
        let mut singular = derivative(1e-3);
        for k in 0..5 {
            singular[(4, k)] = singular[(3, k)] * 1e-3;
            singular[(k, 4)] = singular[(4, k)];
        }
        singular[(4, 4)] = singular[(3, 3)] * 1e-6 * (1.0 + 1e-15);
        let sandwich = of_points(singular, TangentMap::identity());
        assert_eq!(sandwich.covariance(&known), None);
        assert!(sandwich.covariance(&[false, false, false, false, true]).is_some());
    }
}
