//! Errors that all points of a view share.
//!
//! Matching windows flatten a profile, the apertures and filters of time of flight round it: the points lie on a
//! cylinder whose radius is larger by b than that of the surface. Its axis is moved by b s, where s is how the axis
//! that suits the points best moves with the radius: what the points say of the axis for a given radius stays.
//! With b ~ N(0, τ²) the cost of a cylinder X is that of the best b, min P(X_b) + κ b², κ = σ² / (N τ²) with the
//! variance σ² / N that a cost of 1 stands for.
//!
//! An offset along the ray, a shift across it and a tilt of all points move the axis, and nothing tells them: they are in
//! the covariance alone.

use super::point_terms::{LossInFrame, Points};
use super::terms::{Row, Source, Term};
use super::{NormalEquations, SandwichPart};
use crate::geometry::{LocalFrame, Tangent, TangentMap};
use crate::noise::{SHARED_ACROSS, SHARED_RANGE, SHARED_SPREADS};
use nalgebra::Vector3;
use std::cell::Cell;

/// Standard deviations of the errors that all points of a view share, in the caller's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SharedErrors {
    /// τ, of the radius of the cylinder that the points lie on.
    pub bend: f64,
    /// Of the distance from the observer.
    pub offset: f64,
    /// Of a shift across the line of sight and the axis.
    pub across: f64,
    /// Of the tilt of all points together, in radians.
    pub tilt: f64,
}

impl SharedErrors {
    /// Those of points whose offset has this standard deviation, at a distance from the observer, whose standard deviation
    /// from their middle is `spread`.
    #[must_use]
    pub fn of_offset(offset: f64, distance: f64, spread: f64) -> Self {
        let range = (SHARED_RANGE * distance).min(SHARED_SPREADS * spread);
        Self { bend: offset, offset, across: SHARED_ACROSS * offset, tilt: offset / range }
    }

    /// By how much offset, shift across and tilt move the axis: one standard deviation of each.
    #[must_use]
    pub fn steps(&self, frame: &LocalFrame) -> [Tangent; 4] {
        let axis = &frame.cylinder.axis;
        let ray = axis.point.normalize() * (self.offset / frame.unit);
        let across = axis.direction.cross(&axis.point).normalize() * (self.across / frame.unit);
        let shift = |step: Vector3<f64>| Tangent::new(step.dot(&frame.u), step.dot(&frame.v), 0.0, 0.0, 0.0);
        [shift(ray), shift(across), Tangent::ith(2, self.tilt), Tangent::ith(3, self.tilt)]
    }
}

/// Points with errors that they share, seen from the origin.
#[derive(Debug, Clone)]
pub struct SharingPoints<'a, L> {
    /// The points with their own errors.
    pub points: Points<'a, L>,
    /// The errors that they share.
    pub shared: SharedErrors,
    /// σ² / N, in the caller's unit squared.
    pub variance: f64,
    /// Whether lines tell of the radius. Where none do the minimum is that of the points as they are.
    pub contested: bool,
    /// s, in the coordinates of the view: how the axis moves with the radius of the cylinder that the points lie on.
    axis_shift: Vector3<f64>,
    /// Where an iteration asked last.
    last: Cell<Bend>,
    known: Known<'a>,
    /// What was asked last, where the cost is that at the best b.
    asked: Cell<Option<(LocalFrame, Bent)>>,
}

/// What is known of a bend before it is asked for.
#[derive(Debug, Clone, Copy)]
pub enum Known<'a> {
    /// State passed between the successive linearisations of an iteration, which come nearer with every step. Their
    /// cost is that at the b that is expected.
    Iteration(&'a Cell<Option<Bend>>),
    /// Nothing: what is said about a cylinder must not depend on the way to it. The cost is that at the best b.
    Nothing,
}

impl Known<'_> {
    fn bend(&self) -> Option<Bend> {
        match self {
            Self::Iteration(memory) => memory.get(),
            Self::Nothing => None,
        }
    }
}

/// The best b to first order about a cylinder, so that one pass over the points is enough near it.
#[derive(Debug, Clone, Copy)]
pub struct Bend {
    frame: LocalFrame,
    b: f64,
    slope: Tangent,
    /// s, of the first cylinder that was asked for.
    axis_shift: Vector3<f64>,
    /// Half the first derivative of the cost by b at the cylinder for b = 0, where that was asked for.
    at_zero: Option<f64>,
}

/// Most steps to the best b: none or one is usual where it is expected.
const STEPS: usize = 12;

/// Two cylinders are the same that differ by less than this, in units of the frame: the coordinates of one may be
/// another's to rounding.
const SAME: f64 = 1e-12;

/// The part of the cost by which one more step would lower it. That step is taken by the linearisation alone, so what
/// is left is far less.
const SETTLED: f64 = 1e-9;

/// The same for an iteration, which takes a step of b with every step of the cylinder: only where b is far off another
/// pass is worth it.
const SETTLED_BY_ITERATION: f64 = 1e-2;

/// Between these parts of the curvature that the mean slope of the influence tells is that which two slopes tell.
const USUAL_CURVATURE: std::ops::RangeInclusive<f64> = 0.2..=2.0;

/// Next to the best b at a cylinder.
#[derive(Debug, Clone, Copy)]
struct Bent {
    b: f64,
    /// The direction of b in the tangent.
    direction: Tangent,
    /// The frame at the cylinder that the points lie on, and their normal equations there.
    frame: LocalFrame,
    equations: NormalEquations,
    /// Half the first derivative of the cost by b,
    slope: f64,
    /// half the second,
    curvature: f64,
    /// and what JᵀΩJ makes of that.
    square: f64,
}

impl Bent {
    /// The step to the best b.
    fn step(&self) -> f64 {
        -self.slope / self.curvature
    }
}

/// The direction of b in the tangent.
fn direction(frame: &LocalFrame, axis_shift: &Vector3<f64>) -> Tangent {
    Tangent::new(axis_shift.dot(&frame.u), axis_shift.dot(&frame.v), 0.0, 0.0, 1.0)
}

impl<'a, L: LossInFrame> SharingPoints<'a, L> {
    /// Where nothing is known, `near` is the frame of a cylinder near
    /// those at which the term is asked for; `None` where the points there do not determine the axis.
    pub fn new(
        points: Points<'a, L>,
        shared: SharedErrors,
        variance: f64,
        contested: bool,
        known: Known<'a>,
        near: &LocalFrame,
    ) -> Option<Self> {
        let last = match known.bend() {
            Some(last) => last,
            None => {
                // Of very many a part tells it: the steps that follow are those of all.
                let part = points.points.part();
                let of_part = part.unwrap_or(points.points);
                let equations = of_part.linearise(near, points.loss.at(near));
                let hessian = &equations.hessian;
                let shift =
                    -hessian.fixed_view::<2, 2>(0, 0).try_inverse()? * hessian.fixed_view::<2, 1>(0, 4);
                let axis_shift = near.u * shift[0] + near.v * shift[1];
                let direction = direction(near, &axis_shift);
                let column = equations.curvature * direction;
                let square = direction.dot(&column) + variance / (shared.bend * shared.bend);
                let at_zero = equations.gradient.dot(&direction);
                Bend {
                    frame: *near,
                    b: -at_zero / square,
                    slope: -column / square,
                    axis_shift,
                    at_zero: part.is_none().then_some(at_zero),
                }
            }
        };
        let axis_shift = last.axis_shift;
        let last = Cell::new(last);
        let asked = Cell::new(None);
        Some(Self { points, shared, variance, contested, axis_shift, last, known, asked })
    }

    /// κ: a number, as b and residuals are in the same unit.
    fn stiffness(&self) -> f64 {
        self.variance / (self.shared.bend * self.shared.bend)
    }

    fn at(&self, frame: &LocalFrame, b: f64) -> Bent {
        let direction = direction(frame, &self.axis_shift);
        let mut bent = *frame;
        bent.cylinder.axis.point += self.axis_shift * (b * frame.unit);
        bent.cylinder.radius += b * frame.unit;
        let equations = self.points.points.linearise(&bent, self.points.loss.at(&bent));
        let square = direction.dot(&(equations.hessian * direction)) + self.stiffness();
        let curvature = direction.dot(&(equations.curvature * direction)) + self.stiffness();
        let slope = equations.gradient.dot(&direction) + self.stiffness() * b;
        Bent { b, direction, frame: bent, equations, slope, curvature, square }
    }

    fn bent(&self, frame: &LocalFrame) -> Bent {
        let Known::Nothing = self.known else { return self.found(frame) };
        if let Some((_, bent)) = self.asked.get().filter(|(asked, _)| asked == frame) {
            return bent;
        }
        let bent = self.found(frame);
        self.asked.set(Some((*frame, bent)));
        bent
    }

    fn found(&self, frame: &LocalFrame) -> Bent {
        if !self.contested {
            return self.at(frame, 0.0);
        }
        let Bend { frame: near, b, slope, at_zero, .. } = self.last.get();
        let moved = near.difference(&frame.cylinder);
        let before = at_zero.filter(|_| moved.norm() < SAME).map(|slope| (0.0, slope));
        let bent = self.settled(frame, self.at(frame, b + slope.dot(&moved)), before);
        if let Known::Iteration(memory) = self.known {
            let slope = -(bent.equations.curvature * bent.direction) / bent.curvature;
            let b = bent.b + bent.step();
            let last = Bend { frame: *frame, b, slope, axis_shift: self.axis_shift, at_zero: None };
            self.last.set(last);
            memory.set(Some(last));
        }
        bent
    }

    /// From some b to next to the best one, where another one may be known `before` with its slope.
    fn settled(&self, frame: &LocalFrame, mut bent: Bent, mut before: Option<(f64, f64)>) -> Bent {
        let settled = match self.known {
            Known::Iteration(_) => SETTLED_BY_ITERATION,
            Known::Nothing => SETTLED,
        };
        for _ in 0..STEPS {
            // The last two slopes tell the curvature.
            let secant = before.map(|(b, slope)| (bent.slope - slope) / (bent.b - b));
            let secant = secant.filter(|secant| USUAL_CURVATURE.contains(&(secant / bent.curvature)));
            let curvature = secant.unwrap_or(bent.curvature);
            let step = -bent.slope / curvature;
            if !(step * step * curvature > settled * bent.equations.cost) {
                break;
            }
            before = Some((bent.b, bent.slope));
            bent = self.at(frame, bent.b + step);
        }
        bent
    }

    /// The cost of a cylinder, with the step to the best b.
    fn least(&self, bent: &Bent) -> f64 {
        // An iteration compares its costs: they are all those of some b.
        let step = match self.known {
            Known::Iteration(_) => 0.0,
            Known::Nothing => bent.slope * bent.step(),
        };
        bent.equations.cost + self.stiffness() * bent.b * bent.b + step
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
        Some(self.least(&self.bent(frame)))
    }

    /// The gradient is that at the best b, on which the cost does not depend to first order; the matrix is what is left
    /// when b is eliminated.
    fn linearise(&self, frame: &LocalFrame) -> Option<NormalEquations> {
        let bent = self.bent(frame);
        if !self.contested {
            return Some(bent.equations);
        }
        let NormalEquations { gradient, hessian, curvature, .. } = bent.equations;
        let (of_squares, column) = (hessian * bent.direction, curvature * bent.direction);
        Some(NormalEquations {
            cost: self.least(&bent),
            gradient: gradient - of_squares * (bent.slope / bent.square),
            hessian: hessian - of_squares * of_squares.transpose() / bent.square,
            curvature: curvature - column * column.transpose() / bent.curvature,
        })
    }

    /// Orthogonal to the column of b, with the row of what is known of it.
    fn rows(&self, frame: &LocalFrame) -> Option<Vec<Row>> {
        let Bent { b, direction, frame: bent, equations, square, .. } = self.bent(frame);
        let column = equations.hessian * direction / square;
        let root = self.stiffness().sqrt();
        let rows = self.points.rows(&bent)?.into_iter();
        let rows = rows.map(|(e, jacobian)| (e, jacobian - column * jacobian.dot(&direction)));
        Some(rows.chain([(root * b, -column * root)]).collect())
    }

    /// b is eliminated, with its own variance τ².
    fn sandwich(&self, frame: &LocalFrame) -> Option<SandwichPart> {
        let stiffness = self.stiffness();
        let Bent { b, direction, frame: bent, equations, .. } = self.bent(frame);
        let SandwichPart { gradient, derivative, covariance } = self.points.sandwich_with(&bent, &equations);
        let by_shared = self.shared.steps(frame).map(|step| derivative * step);
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
