//! Second stage: what guides the limbs of each view before they are located in its image.
//!
//! Given segments come first. Where there is a mask, its sides tell whether to believe them, and stand in for them
//! where not. What contradicts the points is not believed: they alone are the last resort. Each view is guided by its own
//! data; a fit to all of them joins the views.

use super::constraints::{Constraints, ViewConstraints};
use super::data::{Data, ViewData};
use super::guides::{Guides, Sides, nearest_to_limbs};
use super::objective::{Minimum, Precision};
use super::options::{EdgeUse, StartKind};
use super::ranges::moved;
use super::result::Flags;
use super::run::Run;
use super::start::{Candidate, EXPLAINED};
use super::uncertainty::DISAGREEMENT;
use crate::camera::Camera;
use crate::error::{Error, Result, unless_cancelled};
use crate::geometry::Cylinder;
use crate::limb_location::{Outline, axial_range};
use crate::memory::List;
use crate::residuals::PixelSegment;
use crate::start::limbs::from_limbs;

/// A fit contradicts the points when their scale is this many times that of a fit to them alone. The sides of right
/// masks raise it by up to a quarter, because depth is biased near the limbs; those of an occluder double it at least.
pub(super) const SCALE_CONTRADICTION: f64 = 1.5;

/// The same for segments that a person set: those are believed against more bias.
pub(super) const GIVEN_CONTRADICTION: f64 = 3.0;

/// The radius by the points contradicts that of edges as they were given when it is surely so many times as large or as
/// small. Depth that is smeared at the limbs makes the points alone overestimate it by up to a third.
const RADIUS_CONTRADICTION: f64 = 1.5;

/// The sides of the mask are drawn again along the axis of the fit to them.
const SIDE_ROUNDS: usize = 2;

/// Most given segments that are tried one by one. A detector of lines gives hundreds, each a fit of its own, but a
/// line that the points admit is one of the few beside the limbs of the fit to them.
const MOST_SINGLE_SEGMENTS: usize = 8;

/// Points from which a fit to the sides of a mask starts, and which tell whether the points contradict segments.
const SAMPLE: usize = 500;

/// Where there are more than this many times as many points, those tell it first: with fewer the rest costs as little.
const MANY: usize = 4;

/// A sample leaves no doubt about a scale that differs from a limit by this factor: of 500 normal errors it tells the scale
/// to 5 %.
const CLEAR_FACTOR: f64 = 1.5;

/// The first fit, and what guides the limbs of each view.
pub(super) struct Guided {
    pub start: Candidate,
    pub minimum: Minimum,
    pub views: List<GuidedView>,
    /// Warnings about the edges.
    pub flags: Flags,
}

/// What guides the limbs of one view.
#[derive(Clone)]
pub(super) struct GuidedView {
    /// The lines, numbered by limb.
    pub guides: Guides,
    /// The part of the axis along which the limbs can be seen, from the point of the axis of the first fit; `None` where
    /// they are not to be located.
    pub range: Option<[f64; 2]>,
    /// Standard deviation of the limbs in pixels.
    pub deviation: f64,
    /// Whether there is a mask whose sides do not confirm the given segments.
    pub unconfirmed: bool,
}

impl Guided {
    /// The fit to the points alone as the first one, with what the sides of the mask of a single view tell but where they are;
    /// `None` where no sides held it, or given segments that they confirm.
    pub fn without_sides(&self, data: &Data<'_>, run: &mut Run<'_>) -> Result<Option<Self>> {
        let ([view], [of_data]) = (&self.views[..], &data.views[..]) else { return Ok(None) };
        let guides = &view.guides;
        let by_sides = !guides.sides.is_empty() && (guides.given.is_empty() || view.unconfirmed);
        // What detection fits has been looked for in many places.
        let Some(camera) = of_data.view.camera().filter(|_| by_sides && !of_data.view.is_body) else {
            return Ok(None);
        };
        let start = Candidate { cylinder: *self.minimum.cylinder(), ..self.start };
        let Ok(alone) = (SingleViewFit { data, run }).attempt(Guides::default(), &[start])? else {
            return Ok(None);
        };
        let range = of_data.range_of_points(alone.cylinder());
        let seen = of_data.seen(alone.cylinder());
        let mut guided = alone.guided(Some(range), of_data.noise.limb_of_points);
        let hidden = &mut guided.views[0].guides;
        *hidden = guides.clone();
        hidden.number(camera, &seen);
        hidden.sides.clear();
        guided.flags = self.flags;
        Ok(Some(guided))
    }

    /// The constraints of the first fit.
    pub fn constraints(&self, data: &Data<'_>) -> Constraints {
        let views = self.views.iter().zip(&data.views);
        let lines = views.map(|(view, of_data)| view.guides.all_growing(of_data.growth_of_mask()));
        let mut constraints = constraints_by(data, lines, self.flags);
        constraints.settle(&self.minimum.scales);
        constraints
    }
}

/// The lines of each view, of which the first ones are given segments, as constraints.
fn constraints_by(
    data: &Data<'_>,
    lines: impl Iterator<Item = (usize, List<PixelSegment>)>,
    flags: Flags,
) -> Constraints {
    let view = |(view, (given, lines)): (&ViewData<'_>, (usize, List<PixelSegment>))| {
        ViewConstraints::new(view, &lines, given, 0)
    };
    Constraints {
        views: data.views.iter().zip(lines).map(view).collect(),
        flags,
        edge_weight: data.edge_weight,
        settled: false,
    }
}

/// The first fit of the robust objective.
pub(super) fn guide(data: &Data<'_>, candidates: &[Candidate], run: &mut Run<'_>) -> Result<Guided> {
    let given = Constraints::as_given(data);
    if !candidates.iter().any(|candidate| data.edges_are_finite(&given, &candidate.cylinder)) {
        // No candidate has limbs that the edges could belong to.
        let mut guided = guide(&data.without_edges(), candidates, run)?;
        guided.flags |= Flags::EDGES_IGNORED | reason_without_limbs(data, candidates);
        return Ok(guided);
    }
    if let [_] = data.views[..] {
        return SingleViewFit { data, run }.guide(candidates);
    }
    let mut alone = List::new();
    for view in 0..data.views.len() {
        // A view that determines no cylinder joins the others all the same.
        let guided = data.only(view).and_then(|data| SingleViewFit { data: &data, run }.guide(candidates));
        alone.push(unless_cancelled(guided)?.ok());
    }
    join(data, candidates, alone, given.flags, run)
}

/// Why no edges count for any candidate.
pub(super) fn reason_without_limbs(data: &Data<'_>, candidates: &[Candidate]) -> Flags {
    let inside = candidates.iter().all(|candidate| data.observer_inside(&candidate.cylinder));
    if inside { Flags::CAMERA_INSIDE } else { Flags::EDGES_BEHIND }
}

/// The fit to all views, each constrained by the guides that it found for itself.
fn join(
    data: &Data<'_>,
    candidates: &[Candidate],
    alone: List<Option<Guided>>,
    flags: Flags,
    run: &mut Run<'_>,
) -> Result<Guided> {
    let flags = alone.iter().flatten().fold(flags, |flags, guided| flags | guided.flags);
    let guides: List<Guides> = alone
        .iter()
        .zip(&data.views)
        .map(|(guided, view)| match guided {
            Some(guided) => guided.views[0].guides.clone(),
            None => Guides::given(&view.edges.segments),
        })
        .collect();
    let constraints = constraints_by(data, guides.iter().map(Guides::all), flags);
    // Every view starts from its own best; the lowest of the minima is that of all.
    let mut best: Option<(Candidate, Minimum)> = None;
    let mut failure = None;
    let onward = |guided: &Guided| Candidate { cylinder: *guided.minimum.cylinder(), ..guided.start };
    let starts = alone.iter().flatten().map(onward).chain(candidates.first().copied());
    for start in starts {
        match unless_cancelled(data.best_minimum(&constraints, &[start], Precision::Rough, run))? {
            Ok(found) => {
                let cost = |found: &(Candidate, Minimum)| found.1.scale();
                if best.as_ref().is_none_or(|best| cost(&found) < cost(best)) {
                    best = Some(found);
                }
            }
            Err(error) => failure = failure.or(Some(error)),
        }
    }
    let nothing = || Error::NoStart { reason: "no view gives a cylinder".into() };
    let (start, minimum) = best.ok_or_else(|| failure.unwrap_or_else(nothing))?;
    let cylinder = *minimum.cylinder();
    let views = data.views.iter().zip(alone).zip(guides);
    let views = views.map(|((view, guided), mut guides)| {
        if let Some(camera) = view.camera() {
            guides.number(camera, &view.seen(&cylinder));
        }
        match guided {
            Some(guided) => {
                let (before, alone) = (guided.minimum.cylinder(), &guided.views[0]);
                let range = alone.range.map(|range| moved(&range, before, &cylinder));
                GuidedView { guides, range, ..*alone }
            }
            None => GuidedView {
                guides,
                range: view.camera().map(|_| view.range_of_points(&cylinder)),
                deviation: view.noise.limb_of_points,
                unconfirmed: false,
            },
        }
    });
    Ok(Guided { start, minimum, views: views.collect(), flags })
}

/// A minimum and the guides that constrain it.
struct Attempt {
    start: Candidate,
    minimum: Minimum,
    guides: Guides,
}

impl Attempt {
    fn cylinder(&self) -> &Cylinder {
        self.minimum.cylinder()
    }

    fn scale(&self) -> f64 {
        self.minimum.scale()
    }

    /// The start of an attempt that goes on from here.
    fn onward(&self) -> Candidate {
        Candidate { cylinder: *self.cylinder(), ..self.start }
    }

    fn guided(self, range: Option<[f64; 2]>, deviation: f64) -> Guided {
        let Self { start, minimum, guides } = self;
        let view = GuidedView { guides, range, deviation, unconfirmed: false };
        Guided { start, minimum, views: List::from([view]), flags: Flags::empty() }
    }
}

/// Data of a single view, and the fit under way.
struct SingleViewFit<'d, 'a, 'r, 'b> {
    data: &'d Data<'a>,
    run: &'r mut Run<'b>,
}

impl<'a> SingleViewFit<'_, 'a, '_, '_> {
    fn view(&self) -> &ViewData<'a> {
        &self.data.views[0]
    }

    /// The first fit of this view.
    fn guide(&mut self, candidates: &[Candidate]) -> Result<Guided> {
        let given = self.view().edges.segments.clone();
        let own_flags = self.view().edges.flags;
        let first = self.attempt(Guides::given(&given), candidates)?;
        let by_hand = self.view().noise.limb_of_segments();
        let Some(camera) = self.view().view.camera() else {
            return Ok(Guided { flags: own_flags, ..first?.guided(None, by_hand) });
        };
        let mut guided = if self.data.options.edge_use == EdgeUse::AsGiven && !given.is_empty() {
            let fit = first?;
            let contradicted = self.points_contradict(&fit, candidates)?;
            let mut guided = fit.guided(None, by_hand);
            guided.flags.set(Flags::POINTS_AND_LIMBS_DISAGREE, contradicted);
            guided
        } else {
            let (view, noise) = (self.view().view, self.view().noise);
            // An image tells where the limbs beside such sides are.
            let sides_tell = view.image().is_some() || !view.mask_ends_with_depth();
            let body = view.body().filter(|_| sides_tell);
            let outline = body.and_then(|mask| Outline::new(mask, view.depth(), camera, &noise));
            self.run.check()?;
            match outline {
                Some(outline) => self.by_mask(camera, &outline, &given, candidates, first)?,
                None => self.by_segments(camera, &given, candidates, first)?,
            }
        };
        guided.flags |= own_flags;
        if !given.is_empty() && guided.views[0].guides.given.is_empty() {
            guided.flags |= Flags::EDGES_IGNORED;
        }
        let seen = self.view().seen(guided.minimum.cylinder());
        guided.views[0].guides.number(camera, &seen);
        Ok(guided)
    }

    /// With a mask: the given segments if its sides agree with them, else segments and sides together, else the segments
    /// alone, else what single lines the points admit.
    #[inline(never)] // Not inlined: its locals would enlarge the caller's stack frame.
    fn by_mask(
        &mut self,
        camera: &Camera,
        outline: &Outline<'_>,
        given: &[PixelSegment],
        candidates: &[Candidate],
        first: Result<Attempt>,
    ) -> Result<Guided> {
        let noise = self.view().noise;
        let by_hand = noise.limb_of_segments();
        let view = self.view().clone();
        let others = &view.view.limbs_of_others;
        let sides_of =
            |fit: &Attempt| Sides::new(outline, camera, &view.seen(fit.cylinder()), others, &noise);
        if !given.is_empty()
            && let Ok(fit) = &first
            && let Some(sides) = sides_of(fit)
            && let Some(agreement) = sides.compare(given)
            && agreement.holds()
            && self.points_admit(fit, candidates)
        {
            // They move the fit by little: the next one holds to them.
            let fit = Attempt { guides: sides.with_segments(given), ..first? };
            let range = view.range_of_given(camera, fit.cylinder());
            // What is stated of hand-set edges may be more than points are off.
            return Ok(fit.guided(range, agreement.total.min(noise.limb_of_points).max(by_hand)));
        }
        let unconfirmed = |mut guided: Guided| {
            guided.views[0].unconfirmed = !given.is_empty();
            Ok(guided)
        };
        let (alone, first) = match first {
            Ok(fit) if given.is_empty() => (fit, None),
            other => (self.alone(candidates)?, other.ok()),
        };
        let mut joined: Option<(Attempt, Sides)> = None;
        for _ in 0..SIDE_ROUNDS {
            self.run.check()?;
            let Some(sides) = sides_of(joined.as_ref().map_or(&alone, |joined| &joined.0)) else { break };
            let mut starts = List::from([alone.start]);
            if matches!(self.data.options.start, StartKind::Auto | StartKind::Limbs | StartKind::Last) {
                let [a, b] = sides.rays(camera);
                let sample: List<_> = view.view.cloud.sampled(SAMPLE).collect();
                let found = from_limbs(&a, &b, &sample);
                let found = found.map(|cylinder| view.into_view.inverse().cylinder(&cylinder));
                starts.splice(0..0, found.map(|cylinder| Candidate { kind: StartKind::Limbs, cylinder }));
            }
            let Ok(fit) = self.attempt(sides.with_segments(given), &starts)? else { break };
            joined = Some((fit, sides));
        }
        if let Some((fit, sides)) = joined
            && fit.scale() <= SCALE_CONTRADICTION * alone.scale()
        {
            let pixels = sides.pixels(camera).into_iter();
            let range = axial_range(camera, &view.seen(fit.cylinder()), pixels, 0.0);
            return unconfirmed(fit.guided(range, noise.side));
        }
        if let Some(fit) = first
            && fit.scale() <= GIVEN_CONTRADICTION * alone.scale()
        {
            let range = view.range_of_given(camera, fit.cylinder());
            return unconfirmed(fit.guided(range, noise.side));
        }
        let (sides, hidden) =
            sides_of(&alone).map(|sides| (sides.segments(), sides.hidden())).unwrap_or_default();
        let mut guided = self.by_one(camera, given, &sides, alone)?;
        let guides = &mut guided.views[0].guides;
        (guides.cut, guides.seen) = (hidden.cut, hidden.seen);
        Ok(guided)
    }

    /// Without a mask: the given segments if the points admit them, else a single one.
    #[inline(never)] // Not inlined: its locals would enlarge the caller's stack frame.
    fn by_segments(
        &mut self,
        camera: &Camera,
        given: &[PixelSegment],
        candidates: &[Candidate],
        first: Result<Attempt>,
    ) -> Result<Guided> {
        let noise = self.view().noise;
        if given.is_empty() {
            let fit = first?;
            let range = self.view().range_of_points(fit.cylinder());
            return Ok(fit.guided(Some(range), noise.limb_of_points));
        }
        if let Ok(fit) = first {
            let limit = fit.scale() / GIVEN_CONTRADICTION;
            if self.subsample_admits(&fit, limit, candidates)? || self.all_admit(&fit, limit, candidates)? {
                let range = self.view().range_of_given(camera, fit.cylinder());
                return Ok(fit.guided(range, noise.limb_of_segments()));
            }
        }
        let alone = self.alone(candidates)?;
        self.by_one(camera, given, &[], alone)
    }

    /// Of the fits to single lines the one that the points contradict least, or the one to the points alone if they
    /// contradict all.
    #[inline(never)] // Not inlined: its locals would enlarge the caller's stack frame.
    fn by_one(
        &mut self,
        camera: &Camera,
        given: &[PixelSegment],
        sides: &[PixelSegment],
        alone: Attempt,
    ) -> Result<Guided> {
        let mut best: Option<Attempt> = None;
        let seen = self.view().seen(alone.cylinder());
        let beside = nearest_to_limbs(given, camera, &seen, MOST_SINGLE_SEGMENTS);
        let given = beside.iter().map(|line| Guides::given(&[*line]));
        let sides = sides.iter().map(|line| Guides { sides: List::from([*line]), ..Guides::default() });
        for single in given.chain(sides) {
            if self.run.is_long(self.data) {
                break;
            }
            if let Ok(fit) = self.attempt(single, &[alone.start])?
                && best.as_ref().is_none_or(|best| fit.scale() < best.scale())
            {
                best = Some(fit);
            }
        }
        let fit = best.filter(|best| best.scale() <= SCALE_CONTRADICTION * alone.scale()).unwrap_or(alone);
        let range = self.view().range_of_points(fit.cylinder());
        Ok(fit.guided(Some(range), self.view().noise.limb_of_points))
    }

    /// Holds the limbs to guides and minimises from the first good candidate. The outer error is a cancelled fit.
    fn attempt(&mut self, guides: Guides, candidates: &[Candidate]) -> Result<Result<Attempt>> {
        let constraints = constraints_by(self.data, std::iter::once(guides.all()), Flags::empty());
        let best = self.data.best_minimum(&constraints, candidates, Precision::Rough, self.run);
        Ok(unless_cancelled(best)?.map(|(start, minimum)| Attempt { start, minimum, guides }))
    }

    /// The fit to the points alone.
    fn alone(&mut self, candidates: &[Candidate]) -> Result<Attempt> {
        let mut starts = List::from(candidates);
        if matches!(self.data.options.start, StartKind::Auto | StartKind::Last) {
            let moments = candidates.iter().find(|candidate| candidate.kind == StartKind::Moments);
            let moments = moments.map(|candidate| candidate.cylinder);
            let samples = self.data.ransac_unless_explained(moments, self.run);
            if let Ok(cylinder) = unless_cancelled(samples)? {
                starts.insert(0, Candidate { kind: StartKind::Ransac, cylinder });
            }
        }
        self.attempt(Guides::default(), &starts)?
    }

    /// Whether the points alone, from a fit and from the starts, would not rather be elsewhere, with a scale below some limit.
    fn all_admit(&mut self, fit: &Attempt, limit: f64, candidates: &[Candidate]) -> Result<bool> {
        let beside = self.attempt(Guides::default(), &[fit.onward()])?;
        let elsewhere = beside.is_ok_and(|beside| beside.scale() < limit);
        Ok(!elsewhere && !self.starts_are_better(limit, candidates))
    }

    /// The same by a subsample of many points. False where they leave doubt, or have no minimum of their own.
    fn subsample_admits(&mut self, fit: &Attempt, limit: f64, candidates: &[Candidate]) -> Result<bool> {
        if self.data.count() < MANY * SAMPLE {
            return Ok(false);
        }
        let view = self.view().view.thinned(SAMPLE);
        let Ok(data) = Data::new(self.data.options, std::iter::once(&view), self.data.start) else {
            return Ok(false);
        };
        // Their solves take next to no time: the bound on those of all points does not count them.
        let solves = self.run.solves;
        let mut subsample = SingleViewFit { data: &data, run: self.run };
        let beside = subsample.attempt(Guides::default(), &[fit.onward()]);
        let better = subsample.starts_are_better(CLEAR_FACTOR * limit, candidates);
        self.run.solves = solves;
        Ok(beside?.is_ok_and(|beside| beside.scale() >= CLEAR_FACTOR * limit) && !better)
    }

    /// Whether the points lie on one of the starts with a scale below some limit.
    fn starts_are_better(&self, limit: f64, candidates: &[Candidate]) -> bool {
        candidates.iter().any(|start| self.data.scale_is_below(&start.cylinder, limit))
    }

    /// Whether the points do not rather lie on one of the starts. Sides drawn along a wrong axis agree with the segments that
    /// made it wrong.
    fn points_admit(&self, fit: &Attempt, candidates: &[Candidate]) -> bool {
        fit.scale() <= EXPLAINED * fit.cylinder().radius
            || !self.starts_are_better(fit.scale() / GIVEN_CONTRADICTION, candidates)
    }

    /// Whether the points alone would rather be another cylinder than that of a fit to edges as they were given.
    fn points_contradict(&mut self, fit: &Attempt, candidates: &[Candidate]) -> Result<bool> {
        let Ok(alone) = unless_cancelled(self.alone(candidates))? else { return Ok(false) };
        let [a, b] = [fit, &alone].map(|fit| fit.cylinder().radius);
        if fit.scale() > SCALE_CONTRADICTION * alone.scale() {
            return Ok(true);
        }
        if a.max(b) <= RADIUS_CONTRADICTION * a.min(b) {
            return Ok(false);
        }
        let constraints = constraints_by(self.data, std::iter::once(alone.guides.all()), Flags::empty());
        let (cylinder, scales) = (alone.cylinder(), &alone.minimum.scales);
        let objective = self.data.objective(&constraints, cylinder, scales);
        let (uncertainty, ..) = self.data.uncertainty(
            &constraints,
            &self.data.frame(&self.data.canonical(cylinder)),
            scales,
            &objective,
            &[],
        );
        Ok(uncertainty.is_some_and(|of_points| (a - b).abs() > DISAGREEMENT * of_points.radius()))
    }
}
