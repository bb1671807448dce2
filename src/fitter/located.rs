//! Third stage: the limbs, located in the images.

use super::constraints::{Constraints, ViewConstraints};
use super::data::{Data, ViewData};
use super::guided::{Guided, GuidedView, SCALE_CONTRADICTION};
use super::guides::BESIDE;
use super::objective::{Minimum, Precision};
use super::options::EdgeUse;
use super::outlier;
use super::ranges::moved;
use super::result::Flags;
use super::run::Run;
use crate::error::{Result, unless_cancelled};
use crate::geometry::{Cylinder, across};
use crate::limb_location::{LimbObservation, LimbSearch, NotVisible, SeenLimbs, is_crowded, locate_limbs};
use crate::memory::List;
use crate::residuals::{Loss, PixelSegment, TUKEY_EFFICIENT, Tukey, Wall};
use crate::statistics::DEVIATION_OF_MEDIAN;
use std::ops::ControlFlow;

/// How many standard deviations a limb may be from that of a rough fit at most.
const REACH_DEVIATIONS: f64 = 4.0;

/// What a bend of the profile by two standard deviations leaves of one in the residuals: points up to 70 degrees from the
/// middle of a profile keep a quarter of it when the axis moves with the radius.
const BENT: f64 = 0.5;

/// Depth and image that are shifted against each other by up to so many pixels of the drawing across the axis contradict no
/// limb: between the cameras of recorded frames up to 3.2 are seen. One line that is not the limb would turn against the other.
const MOST_SHIFTED: f64 = 4.5;

/// The standard deviation from its limb of a line beyond which something is as near, in pixels of the drawing. In scenes of the twin with alike
/// bodies that touch 58 of 126 are something else, in others 8 of 45; two thirds are nearer than 1.9 and than 0.4.
const DEVIATION_IN_CROWDS: f64 = 1.5;

/// Where two lines are shifted alike, what they say of the radius differs from the points by this part of the shift at most.
const SHIFTED: f64 = 0.5;

/// What a shift of one leaves in the scale of the residuals, where both limbs hold the axis: points that are even across have a
/// median sine of a half.
const LEFT_OF_SHIFT: f64 = 0.5 * DEVIATION_OF_MEDIAN;

/// A minimum and its constraints.
pub(super) struct Located {
    pub minimum: Minimum,
    pub constraints: Constraints,
}

/// By limb: the line that the image of a view shows.
pub(super) type Lines = [Option<PixelSegment>; 2];

/// What the images show of the limbs, by view.
pub(super) type Observations = List<Option<SeenLimbs>>;

/// Locates the limbs near those of the first fit and fits again with them. A limb that is not seen, or that contradicts
/// the points, is left to the constraints of the first fit.
pub(super) fn locate(data: &Data<'_>, guided: &Guided, run: &mut Run<'_>) -> Result<Located> {
    let mut observations = observe(data, guided, guided.minimum.cylinder(), |view| view.deviation, run)?;
    let mut lines = lines_of(data, &observations);
    let mut fit = None;
    let one_limb = |lines: &Lines| lines[0].is_some() != lines[1].is_some();
    if lines.iter().any(one_limb) {
        fit = fit_to(data, guided, &lines, || 0.0, run)?;
        if let Some(fit) = &fit {
            // One limb tells where to look for the other.
            let by_hand = |view: usize| data.views[view].noise.limb_of_segments();
            for (view, lines) in lines.iter_mut().enumerate().filter(|(_, lines)| one_limb(lines)) {
                let missing = usize::from(lines[0].is_some());
                let again = observe_view(data, guided, view, fit.minimum.cylinder(), by_hand(view), run)?;
                if let (Some(again), Some(seen)) = (again, &mut observations[view]) {
                    seen.limbs[missing].clone_from(&again.limbs[missing]);
                    *lines = lines_of_view(&data.views[view], &seen.limbs);
                }
            }
        }
    }
    if lines.iter().any(|lines| lines[0].is_some() && lines[1].is_some()) {
        let shift = || match data.lines_turn(&observations, &guided.minimum) {
            true => 0.0,
            false => left_of_shift(data, &observations, guided.minimum.cylinder()),
        };
        fit = fit_to(data, guided, &lines, shift, run)?;
        if fit.is_none() {
            // One of them is something else: the one without which the points are contradicted least.
            for (view, limb) in (0..lines.len()).flat_map(|view| [(view, 1), (view, 0)]) {
                let mut without = lines.clone();
                if without[view][limb].take().is_some()
                    && let Some(found) = fit_to(data, guided, &without, || 0.0, run)?
                    && fit.as_ref().is_none_or(|best| found.minimum.scale() < best.minimum.scale())
                {
                    fit = Some(found);
                }
            }
        }
    }
    let mut located = fit.unwrap_or_else(|| {
        let none = List::filled([None, None], lines.len());
        Located {
            minimum: guided.minimum.clone(),
            constraints: constraints(data, &guided.views, guided.flags, &none),
        }
    });
    if located.constraints.limbs_located() == 2
        && data.loosen(&mut lines, &observations, located.minimum.cylinder(), &located.minimum.scales)
    {
        located.constraints = constraints(data, &guided.views, guided.flags, &lines);
    }
    located.constraints.keep(observations);
    located.constraints.settle(&located.minimum.scales);
    Ok(located)
}

/// What the images show of the limbs near those of a cylinder.
fn observe(
    data: &Data<'_>,
    guided: &Guided,
    cylinder: &Cylinder,
    deviation: impl Fn(&GuidedView) -> f64,
    run: &mut Run<'_>,
) -> Result<Observations> {
    let views = guided.views.iter().enumerate();
    views.map(|(view, of_view)| observe_view(data, guided, view, cylinder, deviation(of_view), run)).collect()
}

/// The same of one view; `None` when it is not to be searched.
fn observe_view(
    data: &Data<'_>,
    guided: &Guided,
    view: usize,
    cylinder: &Cylinder,
    deviation: f64,
    run: &mut Run<'_>,
) -> Result<Option<SeenLimbs>> {
    let GuidedView { range, guides, .. } = &guided.views[view];
    let view = &data.views[view];
    let (Some(range), Some(image), Some(camera)) = (range, view.view.image(), view.view.camera()) else {
        return Ok(None);
    };
    if data.options.edge_use == EdgeUse::AsGiven {
        return Ok(None);
    }
    let range = moved(range, guided.minimum.cylinder(), cylinder);
    let ranges = guides.seen_of(range, camera, &view.seen(cylinder));
    let beside_others = view.view.reach_beside_others(camera, &view.seen(cylinder), &view.noise);
    let mut located = |reach: [f64; 2]| {
        let deviation = [deviation; 2];
        let reach = [0, 1].map(|limb| reach[limb].min(beside_others[limb]));
        let search = LimbSearch { ranges, reach, deviation, covered: guides.covered(), noise: view.noise };
        let seen = locate_limbs(image, camera, &view.seen(cylinder), &search, &mut || run.poll_cancel());
        let ControlFlow::Continue(seen) = seen else { return Err(run.cancelled()) };
        let lines = seen.limbs.each_ref().map(|limb| limb.line.as_ref().ok());
        let beside = guides.beside(lines, view.view.sides_tell(), &view.noise);
        Ok((seen, beside))
    };
    let (mut seen, mut beside) = located([REACH_DEVIATIONS * deviation; 2])?;
    if beside.contains(&true) && view.is_shifted(&seen.limbs, &view.seen(cylinder)) {
        beside = [false; 2];
    }
    if beside.contains(&true) {
        // What is far from the mask had the clearer edge: the limb may be nearer.
        let reach = |beside| if beside { BESIDE } else { REACH_DEVIATIONS };
        (seen, beside) = located(beside.map(|beside| reach(beside) * deviation))?;
    }
    for (limb, _) in seen.limbs.iter_mut().zip(beside).filter(|(_, beside)| *beside) {
        limb.line = Err(NotVisible::OutOfReach);
        seen.appearance = None;
    }
    let changed = match view.view.sides_tell() {
        true => outlier::weigh(&mut seen.limbs, guides, &view.noise),
        false => guides.given.is_empty() && loosen_crowded(view, &view.seen(cylinder), &mut seen.limbs),
    };
    if changed {
        // In the next image neither mask nor depth would be asked.
        seen.appearance = None;
    }
    if !guides.seen.is_empty() {
        // In the next image it may be another part.
        seen.appearance = None;
    }
    Ok(Some(seen))
}

/// Enlarges the deviations of located lines that may be the edge of something as near beyond the limb of a cylinder, in the coordinates of the
/// view; returns whether there is one.
fn loosen_crowded(view: &ViewData<'_>, cylinder: &Cylinder, limbs: &mut [LimbObservation; 2]) -> bool {
    let seen = view.view;
    let (Some(camera), Some(depth), Some(image)) = (seen.camera(), seen.depth(), seen.image()) else {
        return false;
    };
    let is_crowded = |limb: &LimbObservation| {
        limb.seen().is_some_and(|ends| is_crowded(camera, (depth, image), cylinder, &ends, &view.noise))
    };
    let mut changed = false;
    for limb in limbs.iter_mut().filter(|limb| is_crowded(limb)) {
        if let Ok(line) = &mut limb.line {
            line.sigma = line.sigma.hypot(DEVIATION_IN_CROWDS * view.noise.pixel);
            changed = true;
        }
    }
    changed
}

/// The lines that were located, each weighed by its own standard deviation.
pub(super) fn lines_of(data: &Data<'_>, observations: &Observations) -> List<Lines> {
    let of_view = |(view, seen): (&ViewData<'_>, &Option<SeenLimbs>)| {
        seen.as_ref().map_or([None, None], |seen| lines_of_view(view, &seen.limbs))
    };
    data.views.iter().zip(observations).map(of_view).collect()
}

pub(super) fn lines_of_view(view: &ViewData<'_>, observations: &[LimbObservation; 2]) -> Lines {
    [0, 1].map(|limb| {
        let line = observations[limb].line.ok()?;
        let weight = (view.noise.endpoint / line.sigma).powi(2);
        Some(PixelSegment { endpoints: line.ends, weight, limb: Some(limb), growth: 0.0 })
    })
}

impl ViewData<'_> {
    /// Whether both lines lie beside the limbs of a cylinder of the points, in the coordinates of the view, by a pixel of the drawing at
    /// least and in the same direction: a shift between depth and image does that, and other edges rarely do.
    fn is_shifted(&self, limbs: &[LimbObservation; 2], cylinder: &Cylinder) -> bool {
        // To the same side of both limbs.
        let beside = |limb: usize| {
            let line = limbs[limb].line.as_ref().ok()?;
            Some(self.camera()?.distances_from_limbs(cylinder, &line.ends)?[limb].mean() / self.noise.pixel)
        };
        // The outline of points ends anywhere.
        if self.view.mask_of_points {
            return false;
        }
        let (Some(first), Some(second)) = (beside(0), beside(1)) else { return false };
        let (shift, wider) = ((first + second) / 2.0, (first - second) / 2.0);
        first.abs().min(second.abs()) >= 1.0
            && wider.abs() <= SHIFTED * shift.abs()
            && shift.abs() <= MOST_SHIFTED
    }
}

/// What a shift between the depth and the image of a single view may leave in the scale of the residuals. About masks that
/// were made of depth, which may be too wide or too narrow, other edges contradict the points as much: there both lines must be shifted.
fn left_of_shift(data: &Data<'_>, observations: &Observations, cylinder: &Cylinder) -> f64 {
    let ([view], [Some(seen)]) = (&data.views[..], &observations[..]) else { return 0.0 };
    let is_shifted = || view.is_shifted(&seen.limbs, &view.seen(cylinder));
    let may_be_shifted = view.observed && (view.view.mask_is_drawn() || is_shifted());
    let Some(camera) = view.camera().filter(|_| may_be_shifted) else { return 0.0 };
    let pixel = camera.pixel_size();
    let distance = view.into_view.point(&cylinder.axis.nearest_to(&data.center)).z;
    LEFT_OF_SHIFT * MOST_SHIFTED * view.noise.pixel * pixel * distance.max(0.0)
}

/// The fit to located limbs; `None` where they contradict the points, in whose scale a shift may leave so much.
pub(super) fn fit_to(
    data: &Data<'_>,
    guided: &Guided,
    lines: &[Lines],
    shift: impl FnOnce() -> f64,
    run: &mut Run<'_>,
) -> Result<Option<Located>> {
    let constraints = constraints(data, &guided.views, guided.flags, lines);
    let minimum = data.minimise_again(&constraints, &guided.minimum, Precision::Rough, run);
    let Ok(minimum) = unless_cancelled(minimum)? else { return Ok(None) };
    let bent = BENT * data.largest_bend(&guided.minimum);
    let limit = SCALE_CONTRADICTION * guided.minimum.scale().hypot(bent);
    let agrees = minimum.scale() <= limit || minimum.scale() <= limit.hypot(shift());
    Ok(agrees.then_some(Located { minimum, constraints }))
}

/// The constraints of a fit: the located limbs with the given segments that agree with them, and the guides of the others.
pub(super) fn constraints(
    data: &Data<'_>,
    guided: &[GuidedView],
    flags: Flags,
    lines: &[Lines],
) -> Constraints {
    let views = data.views.iter().zip(guided).zip(lines).map(|((view, guided), lines)| {
        let guides = &guided.guides;
        let (mut all, mut given) = (List::new(), 0);
        for limb in [0, 1] {
            let own = || guides.given.iter().filter(|segment| segment.limb == Some(limb));
            match &lines[limb] {
                Some(line) => {
                    let weighed = own().map(|segment| PixelSegment {
                        weight: segment.weight * agreement(line, segment, view.noise.endpoint),
                        ..*segment
                    });
                    let before = all.len();
                    all.extend(weighed.filter(|segment| segment.weight > 0.0));
                    given += all.len() - before;
                    all.push(*line);
                }
                None => {
                    given += own().count();
                    all.extend(guides.of_limb(limb, lines[1 - limb].as_ref(), view));
                }
            }
        }
        ViewConstraints::new(view, &all, given, lines.iter().flatten().count())
    });
    Constraints { views: views.collect(), flags, edge_weight: 0.0, settled: false }
}

impl Constraints {
    /// Keeps what the images show of the limbs.
    pub fn keep(&mut self, observations: Observations) {
        for (constraints, seen) in self.views.iter_mut().zip(observations) {
            let (limbs, appearance) = seen.map(|seen| (seen.limbs, seen.appearance)).unzip();
            (constraints.limbs, constraints.appearance) = (limbs, appearance.flatten());
        }
    }

    /// Whether the given segments were bad guides: none was believed, no limb was found about some that the mask does not
    /// confirm, or a limb that was found is not where its segment is.
    pub fn contradicts_segments(&self, data: &Data<'_>, views: &[GuidedView]) -> bool {
        let pushed = |view: &ViewData<'_>| !view.edges.segments.is_empty();
        let believed = views.iter().any(|view| !view.guides.given.is_empty());
        let in_vain = self.limbs_located() == 0 && views.iter().any(|view| view.unconfirmed);
        let mut of_views = data.views.iter().zip(views).zip(&self.views);
        data.options.edge_use != EdgeUse::AsGiven
            && data.views.iter().any(pushed)
            && (!believed
                || in_vain
                || of_views.any(|((view, guided), constraints)| contradicts(view, guided, constraints)))
    }
}

/// Whether a located line lies beside a given segment of its limb, however uncertain the mask made that.
fn contradicts(view: &ViewData<'_>, guided: &GuidedView, constraints: &ViewConstraints) -> bool {
    let Some(limbs) = &constraints.limbs else { return false };
    let lines = lines_of_view(view, limbs);
    guided.guides.given.iter().any(|segment| {
        let line = segment.limb.and_then(|limb| lines[limb].as_ref());
        let pushed = view.edges.segments.iter().find(|pushed| pushed.endpoints == segment.endpoints);
        line.zip(pushed).is_some_and(|(line, pushed)| agreement(line, pushed, view.noise.endpoint) == 0.0)
    })
}

/// How much a given segment says beside a located line: 1 where it lies on it, and less the farther it is from there, as far
/// as both are known. With a step two captures of a scene would differ by what the segment pulls.
fn agreement(line: &PixelSegment, given: &PixelSegment, endpoint: f64) -> f64 {
    let variance = endpoint.powi(2) * (1.0 / line.weight + 1.0 / given.weight);
    let distances = given.endpoints.map(|q| across(&line.endpoints, &q).abs());
    let loss = Tukey { cutoff: TUKEY_EFFICIENT * variance.sqrt(), wall: Wall::Either };
    loss.influence(distances[0].max(distances[1]), 0.0).weight
}
