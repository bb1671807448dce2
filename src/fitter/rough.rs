//! The first fit: what holds the limbs before they are located in the image.
//!
//! Given segments come first. Where there is a mask, its sides tell whether to believe them, and stand in for them
//! where not. What contradicts the points is not believed: they alone are the last resort.

use super::Fitter;
use super::guides::{Guides, Sides, nearest_to_limbs};
use super::minimum::best_minimum;
use super::options::{EdgeUse, StartKind};
use super::problem::Problem;
use super::result::Flags;
use super::solve::Report;
use super::starts::Candidate;
use super::uncertainty::DISAGREEMENT;
use crate::camera::Camera;
use crate::error::{Error, Result};
use crate::geometry::Cylinder;
use crate::limb_location::{Outline, axial_range};
use crate::residuals::PixelSegment;
use crate::solver::Convergence;
use crate::start::limbs::from_limbs;

/// A fit contradicts the points when their scale is this many times that of a fit to them alone. The sides of right
/// masks raise it by up to a quarter, because depth is biased near the limbs; those of an occluder double it at least.
pub(super) const CONTRADICTION: f64 = 1.5;

/// The same for segments that a person set: those are believed against more bias.
const GIVEN_CONTRADICTION: f64 = 3.0;

/// The radius by the points contradicts that of edges as they were given when it is surely so many times as large or as
/// small. Depth that is smeared at the limbs makes the points alone overestimate it by up to a third.
const RADIUS_CONTRADICTION: f64 = 1.5;

/// The sides of the mask are drawn again along the axis of the fit to them.
const SIDE_ROUNDS: usize = 2;

/// Most given segments that are tried one by one. A detector of lines gives hundreds, each a fit of its own, but a
/// line that the points admit is one of the few beside the limbs of the fit to them.
const MOST_SINGLE_SEGMENTS: usize = 8;

/// The part of the points at either end that does not tell how long the surface is.
const POINTS_TRIM: f64 = 0.02;

/// The first fit.
pub(super) struct RoughFit {
    pub start: Candidate,
    pub convergence: Convergence,
    /// The lines that it held the limbs to.
    pub guides: Guides,
    /// The part of the axis along which the limbs can be seen, where they are to be located.
    pub range: Option<[f64; 2]>,
    /// Standard deviation of the limbs in pixels.
    pub deviation: f64,
}

/// A minimum and what the limbs were held to.
struct Attempt {
    start: Candidate,
    convergence: Convergence,
    guides: Guides,
    /// Scale of the points.
    scale: f64,
}

/// What the first fit is made from.
struct Evidence<'a> {
    camera: &'a Camera,
    given: &'a [PixelSegment],
    candidates: &'a [Candidate],
    /// The fit to the given segments as they are, or to the points alone where there are none.
    first: Result<Attempt>,
}

impl Attempt {
    fn cylinder(&self) -> &Cylinder {
        &self.convergence.cylinder
    }

    fn rough(self, range: Option<[f64; 2]>, deviation: f64) -> RoughFit {
        let Self { start, convergence, guides, .. } = self;
        RoughFit { start, convergence, guides, range, deviation }
    }

    /// The start of an attempt that goes on from here.
    fn onward(&self) -> Candidate {
        Candidate { cylinder: *self.cylinder(), ..self.start }
    }
}

impl Fitter {
    /// The first fit, to given segments, sides of the mask and points.
    pub(super) fn rough_fit(&self, problem: &mut Problem<'_>, report: Report<'_>) -> Result<RoughFit> {
        let candidates = problem.candidates(self.start.as_ref())?;
        problem.ignore_edges_without_limbs(&candidates);
        if !problem.is_robust() {
            let (start, convergence) = best_minimum(problem, &candidates, report)?;
            let guides = Guides::given(&problem.edges.segments);
            return Ok(RoughFit { start, convergence, guides, range: None, deviation: 0.0 });
        }
        let given = problem.edges.segments.clone();
        let first = problem.attempt(Guides::given(&given), &candidates, report)?;
        let of_segments = problem.noise.limb_of_segments();
        let Some(camera) = &self.camera else { return Ok(first?.rough(None, of_segments)) };
        if self.options.edge_use == EdgeUse::AsGiven && !given.is_empty() {
            let fit = first?;
            if problem.points_contradict(&fit, &candidates, report)? {
                problem.edges.flags |= Flags::POINTS_AND_LIMBS_DISAGREE;
            }
            let mut rough = fit.rough(None, of_segments);
            rough.guides.number(camera, &rough.convergence.cylinder);
            problem.hold_to(&rough.guides.all());
            return Ok(rough);
        }
        let outline = self
            .mask
            .as_ref()
            .and_then(|mask| Outline::new(mask, self.depth.as_ref(), camera, &problem.noise));
        let evidence = Evidence { camera, given: &given, candidates: &candidates, first };
        let mut rough = match outline {
            Some(outline) => self.guided_by_mask(problem, &outline, evidence, report)?,
            None => self.guided_by_segments(problem, evidence, report)?,
        };
        if !given.is_empty() && rough.guides.given.is_empty() {
            problem.ignore_edges(Flags::EDGES_IGNORED);
        }
        rough.guides.number(camera, &rough.convergence.cylinder);
        problem.hold_to(&rough.guides.all());
        Ok(rough)
    }

    /// The first fit with a mask: the given segments if its sides agree with them, else segments and sides together,
    /// else the segments alone, else what single lines the points admit.
    fn guided_by_mask(
        &self,
        problem: &mut Problem<'_>,
        outline: &Outline,
        evidence: Evidence<'_>,
        report: Report<'_>,
    ) -> Result<RoughFit> {
        let Evidence { camera, given, candidates, first } = evidence;
        let noise = problem.noise;
        let sides_of = |fit: &Attempt| Sides::new(outline, camera, &noise, fit.cylinder());
        if let Ok(fit) = &first
            && let Some(sides) = sides_of(fit)
            && let Some(agreement) = sides.compare(given)
            && agreement.holds()
        {
            // On the way to located limbs the sides matter only where one is not found.
            let guides = sides.with_segments(given);
            let start = fit.start;
            let onward = fit.onward();
            let fit = match first {
                Ok(fit) if problem.passing => Attempt { guides, ..fit },
                _ => Attempt { start, ..problem.attempt(guides, &[onward], report)?? },
            };
            let range = self.range_of_given(camera, fit.cylinder());
            return Ok(
                fit.rough(range, agreement.total.clamp(noise.limb_of_segments(), noise.limb_of_points))
            );
        }
        let (alone, first) = match first {
            Ok(fit) if given.is_empty() => (fit, None),
            other => (problem.alone(candidates, report)?, other.ok()),
        };
        let mut guided: Option<(Attempt, Sides)> = None;
        for _ in 0..SIDE_ROUNDS {
            let Some(sides) = sides_of(guided.as_ref().map_or(&alone, |guided| &guided.0)) else { break };
            let mut starts = vec![alone.start];
            if matches!(self.options.start, StartKind::Auto | StartKind::Limbs) {
                let [a, b] = sides.rays(camera);
                let found = from_limbs(&a, &b, &problem.start_sample());
                starts.splice(0..0, found.map(|cylinder| Candidate { kind: StartKind::Limbs, cylinder }));
            }
            let Ok(fit) = problem.attempt(sides.with_segments(given), &starts, report)? else { break };
            guided = Some((fit, sides));
        }
        if let Some((fit, sides)) = guided
            && fit.scale <= CONTRADICTION * alone.scale
        {
            let range = axial_range(camera, fit.cylinder(), sides.pixels(camera).into_iter(), 0.0);
            return Ok(fit.rough(range, noise.side));
        }
        if let Some(fit) = first
            && fit.scale <= GIVEN_CONTRADICTION * alone.scale
        {
            let range = self.range_of_given(camera, fit.cylinder());
            return Ok(fit.rough(range, noise.side));
        }
        let sides: Vec<PixelSegment> = sides_of(&alone).iter().flat_map(Sides::segments).collect();
        problem.guided_by_one(given, &sides, alone, report)
    }

    /// The first fit without a mask: the given segments if the points admit them, else a single one.
    fn guided_by_segments(
        &self,
        problem: &mut Problem<'_>,
        evidence: Evidence<'_>,
        report: Report<'_>,
    ) -> Result<RoughFit> {
        let Evidence { camera, given, candidates, first } = evidence;
        if given.is_empty() {
            let fit = first?;
            let range = problem.range_of_points(fit.cylinder());
            return Ok(fit.rough(Some(range), problem.noise.limb_of_points));
        }
        if let Ok(fit) = first {
            // The points alone show, from there and from the starts, whether they would rather be elsewhere.
            let beside = problem.attempt(Guides::default(), &[fit.onward()], report)?;
            let beside = beside.map_or(fit.scale, |beside| beside.scale);
            let of_starts = candidates.iter().map(|candidate| problem.point_scale(&candidate.cylinder));
            if fit.scale <= GIVEN_CONTRADICTION * of_starts.fold(beside, f64::min) {
                let range = self.range_of_given(camera, fit.cylinder());
                return Ok(fit.rough(range, problem.noise.limb_of_segments()));
            }
        }
        let alone = problem.alone(candidates, report)?;
        problem.guided_by_one(given, &[], alone, report)
    }

    /// The part of the axis along which segments were given.
    fn range_of_given(&self, camera: &Camera, cylinder: &Cylinder) -> Option<[f64; 2]> {
        let endpoints = self.segments.iter().flat_map(|segment| segment.endpoints);
        axial_range(camera, cylinder, endpoints, 0.0)
    }
}

impl Problem<'_> {
    /// Holds the limbs to guides and minimises from the first good candidate. The outer error is a cancelled fit.
    fn attempt(
        &mut self,
        guides: Guides,
        candidates: &[Candidate],
        report: Report<'_>,
    ) -> Result<Result<Attempt>> {
        self.hold_to(&guides.all());
        match best_minimum(self, candidates, report) {
            Ok((start, convergence)) => {
                let scale = self.point_scale(&convergence.cylinder);
                Ok(Ok(Attempt { start, convergence, guides, scale }))
            }
            Err(error @ Error::Cancelled { .. }) => Err(error),
            Err(error) => Ok(Err(error)),
        }
    }

    /// The fit to the points alone.
    fn alone(&mut self, candidates: &[Candidate], report: Report<'_>) -> Result<Attempt> {
        let mut starts = candidates.to_vec();
        if self.options.start == StartKind::Auto
            && let Ok(fit) = self.ransac()
        {
            starts.insert(0, Candidate { kind: StartKind::Ransac, cylinder: fit.cylinder });
        }
        self.attempt(Guides::default(), &starts, report)?
    }

    /// Whether the points alone would rather be another cylinder than that of a fit to edges as they were given.
    fn points_contradict(
        &mut self,
        fit: &Attempt,
        candidates: &[Candidate],
        report: Report<'_>,
    ) -> Result<bool> {
        let alone = match self.alone(candidates, report) {
            Err(error @ Error::Cancelled { .. }) => return Err(error),
            Err(_) => return Ok(false),
            Ok(alone) => alone,
        };
        let [a, b] = [fit, &alone].map(|fit| fit.cylinder().radius);
        let (uncertainty, _) = self.uncertainty(alone.cylinder());
        let surely = uncertainty.is_some_and(|of_points| (a - b).abs() > DISAGREEMENT * of_points.radius());
        Ok(fit.scale > CONTRADICTION * alone.scale || surely && a.max(b) > RADIUS_CONTRADICTION * a.min(b))
    }

    /// Of the fits to single lines the one that the points contradict least, or the one to the points alone if they
    /// contradict all.
    fn guided_by_one(
        &mut self,
        given: &[PixelSegment],
        sides: &[PixelSegment],
        alone: Attempt,
        report: Report<'_>,
    ) -> Result<RoughFit> {
        let mut best: Option<Attempt> = None;
        let beside = self.camera.map_or_else(Vec::new, |camera| {
            nearest_to_limbs(given, camera, alone.cylinder(), MOST_SINGLE_SEGMENTS)
        });
        let given = beside.iter().map(|line| Guides { given: vec![*line], sides: Vec::new() });
        let sides = sides.iter().map(|line| Guides { given: Vec::new(), sides: vec![*line] });
        for single in given.chain(sides) {
            if let Ok(fit) = self.attempt(single, &[alone.start], report)?
                && best.as_ref().is_none_or(|best| fit.scale < best.scale)
            {
                best = Some(fit);
            }
        }
        let fit = best.filter(|best| best.scale <= CONTRADICTION * alone.scale).unwrap_or(alone);
        let range = self.range_of_points(fit.cylinder());
        Ok(fit.rough(Some(range), self.noise.limb_of_points))
    }

    /// The part of the axis along which there are points.
    fn range_of_points(&self, cylinder: &Cylinder) -> [f64; 2] {
        let axis = &cylinder.axis;
        let mut positions: Vec<f64> =
            self.cloud.points().map(|p| (p - axis.point).dot(&axis.direction)).collect();
        positions.sort_unstable_by(f64::total_cmp);
        let last = positions.len() - 1;
        let trim = (POINTS_TRIM * last as f64) as usize;
        [positions[trim], positions[last - trim]]
    }
}
