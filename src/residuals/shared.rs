//! Errors that all points of a view share.
//!
//! Matching windows flatten a profile, the apertures and filters of time of flight round it: the points lie on a
//! cylinder whose radius is larger by b than that of the surface. Its axis is moved by b s, where s is how the axis
//! that suits the points best moves with the radius: what the points say of the axis for a given radius stays.
//! With b ~ N(0, τ²) the cost of a cylinder X is that of the best b, min P(X_b) + κ b², κ = σ² / (N τ²) with the
//! variance σ² / N that a cost of 1 stands for.
//!
//! An offset along the ray and a tilt of all points move the axis, and nothing tells them: they are in the covariance
//! alone.

use super::point_terms::{LossInFrame, Points};
use super::terms::{Row, Source, Term};
use super::{NormalEquations, SandwichPart};
use crate::geometry::{LocalFrame, Tangent, TangentMap};
use nalgebra::Vector3;

/// Standard deviations of the errors that all points of a view share, in the caller's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SharedErrors {
    /// τ, of the radius of the cylinder that the points lie on.
    pub bend: f64,
    /// s, in the coordinates of the view: how the axis moves with that radius.
    pub axis_shift: Vector3<f64>,
    /// Of the distance from the observer.
    pub offset: f64,
    /// Of the tilt of all points together, in radians.
    pub tilt: f64,
}

/// Points with errors that they share, seen from the origin.
#[derive(Debug, Clone, Copy)]
pub struct SharingPoints<'a, L> {
    /// The points with their own errors.
    pub points: Points<'a, L>,
    /// The errors that they share.
    pub shared: SharedErrors,
    /// σ² / N, in the caller's unit squared.
    pub variance: f64,
    /// Whether limbs tell of the radius. Where none do the minimum is that of the points as they are.
    pub contested: bool,
}

/// Most steps to the best b: two or three are usual.
const STEPS: usize = 12;

/// The part of the cost by which a last step may still lower it: rounding.
const SETTLED: f64 = 1e-15;

/// The part of the curvature of squares that is left where many points are nearly out.
const LEAST_CURVATURE: f64 = 0.2;

/// The best b at a cylinder.
struct Bent {
    b: f64,
    /// The direction of b in the tangent.
    direction: Tangent,
    /// The frame at the cylinder that the points lie on, and their normal equations there.
    frame: LocalFrame,
    equations: NormalEquations,
    /// Half the second derivative of the cost by b.
    square: f64,
}

impl<L: LossInFrame> SharingPoints<'_, L> {
    /// κ: a number, as b and residuals are in the same unit.
    fn stiffness(&self) -> f64 {
        self.variance / (self.shared.bend * self.shared.bend)
    }

    fn bent(&self, frame: &LocalFrame) -> Bent {
        let stiffness = self.stiffness();
        let shift = self.shared.axis_shift;
        let direction = Tangent::new(shift.dot(&frame.u), shift.dot(&frame.v), 0.0, 0.0, 1.0);
        let at = |b: f64| {
            let mut bent = *frame;
            bent.cylinder.axis.point += shift * (b * frame.unit);
            bent.cylinder.radius += b * frame.unit;
            let equations = self.points.points.linearise(&bent, self.points.loss.at(&bent));
            let square = direction.dot(&(equations.hessian * direction)) + stiffness;
            (
                Bent { b, direction, frame: bent, equations, square },
                equations.gradient.dot(&direction) + stiffness * b,
            )
        };
        let (mut bent, mut slope) = at(0.0);
        let mut before: Option<(f64, f64)> = None;
        for _ in 0..if self.contested { STEPS } else { 0 } {
            // Points far off make the curvature of the cost less than that of squares: the last two slopes tell it.
            let secant = before.map(|(b, slope_before)| (slope - slope_before) / (bent.b - b));
            let usual = LEAST_CURVATURE * bent.square..=bent.square;
            let curvature = secant.filter(|curvature| usual.contains(curvature)).unwrap_or(bent.square);
            let step = -slope / curvature;
            if !(step * step * curvature > SETTLED * bent.equations.cost) {
                break;
            }
            before = Some((bent.b, slope));
            (bent, slope) = at(bent.b + step);
        }
        bent
    }
}

impl<L: LossInFrame> Term for SharingPoints<'_, L> {
    fn source(&self) -> Source {
        Source::Points
    }

    fn cost(&self, frame: &LocalFrame) -> Option<f64> {
        if !self.contested {
            return self.points.cost(frame);
        }
        let bent = self.bent(frame);
        Some(bent.equations.cost + self.stiffness() * bent.b * bent.b)
    }

    /// The gradient is that at the best b, on which the cost does not depend to first order; the matrix is what is left
    /// when b is eliminated.
    fn linearise(&self, frame: &LocalFrame) -> Option<NormalEquations> {
        if !self.contested {
            return self.points.linearise(frame);
        }
        let Bent { b, direction, equations, square, .. } = self.bent(frame);
        let NormalEquations { cost, gradient, hessian } = equations;
        let column = hessian * direction;
        let hessian = hessian - column * column.transpose() / square;
        Some(NormalEquations { cost: cost + self.stiffness() * b * b, gradient, hessian })
    }

    /// Orthogonal to the column of b, with the row of what is known of it.
    fn rows(&self, frame: &LocalFrame) -> Option<Vec<Row>> {
        let Bent { b, direction, frame: bent, equations, square } = self.bent(frame);
        let column = equations.hessian * direction / square;
        let root = self.stiffness().sqrt();
        let rows = self.points.rows(&bent)?.into_iter();
        let rows = rows.map(|(e, jacobian)| (e, jacobian - column * jacobian.dot(&direction)));
        Some(rows.chain([(root * b, -column * root)]).collect())
    }

    /// b is eliminated, with its own variance τ².
    fn sandwich(&self, frame: &LocalFrame) -> Option<SandwichPart> {
        let stiffness = self.stiffness();
        let Bent { b, direction, frame: bent, .. } = self.bent(frame);
        let SandwichPart { gradient, derivative, covariance } = self.points.sandwich(&bent)?;
        let ray = frame.cylinder.axis.point.normalize() * (self.shared.offset / frame.unit);
        let shared = [
            Tangent::new(ray.dot(&frame.u), ray.dot(&frame.v), 0.0, 0.0, 0.0),
            Tangent::ith(2, self.shared.tilt),
            Tangent::ith(3, self.shared.tilt),
        ];
        let by_shared = shared.map(|step| derivative * step);
        let column = derivative * direction;
        let square = direction.dot(&column) + stiffness;
        let reduce = TangentMap::identity() - column * direction.transpose() / square;
        let slope = gradient.dot(&direction) + stiffness * b;
        let by_bend = column * (self.shared.bend / frame.unit * stiffness / square);
        let covariance = by_shared.iter().fold(covariance, |sum, row| sum + row * row.transpose());
        Some(SandwichPart {
            gradient: gradient - column * (slope / square),
            derivative: derivative - column * column.transpose() / square,
            covariance: reduce * covariance * reduce.transpose() + by_bend * by_bend.transpose(),
        })
    }
}

#[cfg(test)]
mod tests;
