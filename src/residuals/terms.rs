//! Objectives as sums of terms.
//!
//! A term is one kind of residuals of one view, in the coordinates of that view. Where the reference frame is another
//! one, the frame of the linearisation is moved there: its tangent stays the same ([`LocalFrame::moved`]), so a term
//! never knows of views. An objective is a list of terms with factors; the paper's and the robust one are two lists.

use super::limbs::LimbTerm;
use super::pixel_terms::InPixels;
use super::point_terms::{Plain, Points, Robust};
use super::shared::SharingPoints;
use super::{NormalEquations, Objective, Sandwich, SandwichPart};
use crate::geometry::{LocalFrame, RigidMotion, Tangent};
use smallvec::SmallVec;
use std::ops::Deref;

/// A weighted residual √w e and its Jacobian √w J.
pub type Row = (f64, Tangent);

/// Where residuals come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// Measured points.
    Points,
    /// Edges in the image: given segments, located limb lines, arcs of the ends.
    Image,
}

/// One kind of residuals of one view. All lengths are in units of the frame; `None` stands for an infinite cost.
pub trait Term {
    /// Whether points or the image tell it.
    fn source(&self) -> Source;

    /// The cost alone: what a trial step needs.
    fn cost(&self, frame: &LocalFrame) -> Option<f64>;

    /// The cost and its linearisation.
    fn linearise(&self, frame: &LocalFrame) -> Option<NormalEquations>;

    /// The weighted residuals one by one: what the normal equations sum.
    fn rows(&self, frame: &LocalFrame) -> Option<Vec<Row>>;

    /// What it adds to the covariance of a minimum; `None` where that cannot be told.
    fn sandwich(&self, frame: &LocalFrame) -> Option<SandwichPart>;
}

/// A term of an objective, in place and not in a box: an objective is made for every round of a fit, and asks for no memory.
#[expect(clippy::large_enum_variant, reason = "an objective has few terms")]
pub enum AnyTerm<'a> {
    /// Points whose squares count.
    Plain(Points<'a, Plain>),
    /// Points by Tukey's loss,
    Robust(Points<'a, Robust>),
    /// with errors that they share.
    Sharing(SharingPoints<'a, Robust>),
    /// The edges of the paper.
    Limbs(LimbTerm),
    /// What the image tells, in pixels.
    Pixels(InPixels<'a>),
}

impl<'a> Deref for AnyTerm<'a> {
    type Target = dyn Term + 'a;

    fn deref(&self) -> &Self::Target {
        match self {
            Self::Plain(term) => term,
            Self::Robust(term) => term,
            Self::Sharing(term) => term,
            Self::Limbs(term) => term,
            Self::Pixels(term) => term,
        }
    }
}

/// A term with its factor in the objective.
pub struct Summand<'a> {
    /// What the term is multiplied by.
    pub factor: f64,
    /// From the reference frame to the view of the term.
    pub into_view: RigidMotion,
    /// The term.
    pub term: AnyTerm<'a>,
}

/// A sum of terms. Infinite for a radius that is not positive.
pub struct Sum<'a> {
    /// The terms: of one view three at most.
    pub summands: SmallVec<[Summand<'a>; 3]>,
}

impl Sum<'_> {
    /// The whole stacked system Ω^½ e, Ω^½ J (27), (28) row by row: what the normal equations sum, without squaring
    /// the condition of the problem. `None` where the cost is infinite.
    #[must_use]
    pub fn rows(&self, frame: &LocalFrame) -> Option<Vec<Row>> {
        let mut all = Vec::new();
        for Summand { factor, into_view, term } in &self.summands {
            let root = factor.sqrt();
            all.extend(term.rows(&frame.moved(into_view))?.iter().map(|(e, j)| (e * root, j * root)));
        }
        Some(all)
    }

    /// What the covariance of the minimum follows from; `None` where the cost is infinite, or a term cannot tell it.
    #[must_use]
    pub fn sandwich(&self, frame: &LocalFrame) -> Option<Sandwich> {
        let mut sandwich = Sandwich { points: SandwichPart::zero(), image: SandwichPart::zero() };
        for Summand { factor, into_view, term } in &self.summands {
            let part = term.sandwich(&frame.moved(into_view))?;
            let sum = match term.source() {
                Source::Points => &mut sandwich.points,
                Source::Image => &mut sandwich.image,
            };
            sum.add_scaled(*factor, &part);
        }
        Some(sandwich)
    }
}

impl Objective for Sum<'_> {
    fn linearise(&self, frame: &LocalFrame) -> Option<NormalEquations> {
        positive(frame.cylinder.radius)?;
        let mut equations = NormalEquations::zero();
        for Summand { factor, into_view, term } in &self.summands {
            equations.add_scaled(*factor, &term.linearise(&frame.moved(into_view))?);
        }
        equations.cost.is_finite().then_some(equations)
    }

    fn cost(&self, frame: &LocalFrame) -> Option<f64> {
        positive(frame.cylinder.radius)?;
        let mut cost = 0.0;
        for Summand { factor, into_view, term } in &self.summands {
            cost += factor * term.cost(&frame.moved(into_view))?;
        }
        cost.is_finite().then_some(cost)
    }
}

fn positive(radius: f64) -> Option<()> {
    (radius > 0.0 && radius.is_finite()).then_some(())
}
