//! The points of a view as a term: their mean loss.

use super::loss::{Loss, Squared, TUKEY_EFFICIENT, Tukey, Wall};
use super::points::PointTerm;
use super::terms::{Row, Source, Term};
use super::{NormalEquations, SandwichPart};
use crate::geometry::LocalFrame;
use crate::memory::List;
use std::cell::RefCell;

/// A loss whose scale is a length, for residuals in units of a frame.
pub trait LossInFrame {
    /// The loss.
    type Loss: Loss;

    /// The loss of residuals in units of a frame.
    fn at(&self, frame: &LocalFrame) -> Self::Loss;
}

/// The plain square.
#[derive(Debug, Clone, Copy)]
pub struct Plain;

impl LossInFrame for Plain {
    type Loss = Squared;

    fn at(&self, _frame: &LocalFrame) -> Squared {
        Squared
    }
}

/// Tukey's loss at a scale of the residuals.
#[derive(Debug, Clone, Copy)]
pub struct Robust {
    /// Standard deviation of the distances of good points, in the caller's unit.
    pub scale: f64,
    /// Whether the points are what an observer at the origin sees.
    pub observed: bool,
}

impl LossInFrame for Robust {
    type Loss = Tukey;

    /// From inside a pipe every point of its surface is visible.
    fn at(&self, frame: &LocalFrame) -> Tukey {
        let facing = self.observed && !frame.cylinder.contains_origin();
        let wall = if facing { Wall::Facing } else { Wall::Either };
        Tukey { cutoff: TUKEY_EFFICIENT * self.scale / frame.unit, wall }
    }
}

/// The mean loss of points, of which some number are independent.
#[derive(Debug, Clone)]
pub struct Points<'a, L> {
    /// The points.
    pub points: PointTerm<'a>,
    /// Their loss.
    pub loss: L,
    /// The number of independent points, for the covariance.
    pub independent_points: f64,
    /// What was asked last. In a list, so that no frame is read where there is none: valgrind takes that for an error.
    asked: RefCell<List<(LocalFrame, NormalEquations)>>,
}

impl<'a, L: LossInFrame> Points<'a, L> {
    /// The term of points with a loss.
    pub fn new(points: PointTerm<'a>, loss: L, independent_points: f64) -> Self {
        Self { points, loss, independent_points, asked: RefCell::default() }
    }

    fn equations(&self, frame: &LocalFrame) -> NormalEquations {
        let mut asked = self.asked.borrow_mut();
        if let Some((_, known)) = asked.first().filter(|(known, _)| known == frame) {
            return *known;
        }
        let equations = self.points.linearise(frame, self.loss.at(frame));
        asked.clear();
        asked.push((*frame, equations));
        equations
    }

    /// What they add to the covariance of a minimum where their normal equations are known.
    pub(super) fn sandwich_with(&self, frame: &LocalFrame, equations: &NormalEquations) -> SandwichPart {
        self.points.sandwich(frame, self.loss.at(frame), self.independent_points, equations)
    }
}

impl<L: LossInFrame> Term for Points<'_, L> {
    fn source(&self) -> Source {
        Source::Points
    }

    fn cost(&self, frame: &LocalFrame) -> Option<f64> {
        Some(self.points.cost(frame, self.loss.at(frame)))
    }

    fn linearise(&self, frame: &LocalFrame) -> Option<NormalEquations> {
        Some(self.equations(frame))
    }

    fn rows(&self, frame: &LocalFrame) -> Option<Vec<Row>> {
        Some(self.points.rows(frame, self.loss.at(frame)).collect())
    }

    fn sandwich(&self, frame: &LocalFrame) -> Option<SandwichPart> {
        Some(self.sandwich_with(frame, &self.equations(frame)))
    }
}
