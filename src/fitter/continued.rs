//! A fit that goes on from the last one of a sequence: all stages at once, with what the last image showed.
//!
//! The limbs are looked for where the last cylinder has them, or that cylinder after it was moved to the points, and as they
//! looked in the last image. What does not agree with that takes all stages.

use super::arcs::{ARC_ROUNDS, KnownEnds, SETTLED_TURN, contradicts, with_arcs};
use super::constraints::{Constraints, EndPosition, ViewConstraints};
use super::data::{Data, ViewData};
use super::fit::Fit;
use super::guided::GuidedView;
use super::guides::Guides;
use super::located::{Located, Observations, constraints, lines_of};
use super::objective::Precision;
use super::options::{EdgeUse, Options, StartKind};
use super::result::Flags;
use super::run::Run;
use super::scales::Scales;
use super::start::{Candidate, EXPLAINED, SAMPLE, median_distance};
use crate::error::{Result, unless_cancelled};
use crate::geometry::{Cylinder, CylinderLimits};
use crate::limb_location::{Appearance, LimbSearch, locate_limbs_again};
use crate::memory::List;
use crate::residuals::RobustScales;

constants! {
    /// A cylinder has not moved when its limbs are within so many pixels of where it had them: it moves the arcs of its
    /// ends by as little.
    RESTING = 0.5, "px";

    /// One that was moved to the points has its limbs within so many pixels of there. The steps find a limb from about as
    /// far.
    MOVED = 1.5, "px";
}

/// What a fit leaves to the next one.
#[derive(Debug, Clone)]
pub(super) struct Last {
    /// In the reference frame. The direction of the axis says which limb is which.
    pub cylinder: Cylinder,
    /// The scale of the points of all views together; `None` where no scale was measured.
    scale: Option<f64>,
    views: List<LastView>,
}

/// The same of one view.
#[derive(Debug, Clone)]
struct LastView {
    /// Which view of the fitter it is.
    index: usize,
    scales: Option<RobustScales>,
    appearance: Option<Appearance>,
    ends: [Option<EndPosition>; 2],
}

impl Last {
    pub fn new(fit: &Fit) -> Self {
        let scales = fit.scales.as_ref();
        let view = |(k, constraints): (usize, &ViewConstraints)| LastView {
            index: constraints.index,
            scales: scales.and_then(|scales| scales.views.get(k).copied()),
            appearance: constraints.appearance.clone(),
            ends: constraints.ends,
        };
        Self {
            cylinder: fit.cylinder,
            scale: scales.map(|scales| scales.all),
            views: fit.constraints.views.iter().enumerate().map(view).collect(),
        }
    }

    fn view(&self, index: usize) -> Option<&LastView> {
        self.views.iter().find(|view| view.index == index)
    }

    /// The scales of the points of some data; `None` where not all are known.
    fn scales(&self, data: &Data<'_>) -> Option<Scales> {
        let of_view = |view: &ViewData<'_>| self.view(view.index)?.scales;
        let views = data.views.iter().map(of_view).collect::<Option<_>>()?;
        Some(Scales { views, all: self.scale? })
    }
}

/// The limbs and arcs near the last cylinder, and the minimum with them. `None` where there was no fit before, or the data
/// do not go on from it.
pub(super) fn locate(data: &Data<'_>, run: &mut Run<'_>) -> Result<Option<(Candidate, Located)>> {
    let Some(last) = data.last else { return Ok(None) };
    let known = |view: &ViewData<'_>| {
        view.view.image().is_none() || last.view(view.index).is_some_and(|view| view.appearance.is_some())
    };
    let searched = data.locates() && data.options.edge_use != EdgeUse::AsGiven;
    if !searched || !data.views.iter().all(known) {
        return Ok(None);
    }
    let Some(scales) = last.scales(data) else { return Ok(None) };
    let start = data.start_of(last);
    if median_distance(&start.cylinder, &data.sample(SAMPLE)) > EXPLAINED * start.cylinder.radius {
        return Ok(None);
    }
    let sequence = Sequence { data, last, scales };
    let mut located = sequence.locate_about(&start.cylinder, true, run)?;
    if located.is_none()
        && let Some(moved) = sequence.moved(&start.cylinder, run)?
    {
        located = sequence.locate_about(&moved, false, run)?;
    }
    Ok(located.map(|located| (start, located)))
}

impl Data<'_> {
    /// The start from the last cylinder.
    pub fn start_of(&self, last: &Last) -> Candidate {
        Candidate { kind: StartKind::Last, cylinder: self.within_limits(&last.cylinder) }
    }
}

/// A frame and what is known from the one before.
struct Sequence<'d, 'a> {
    data: &'d Data<'a>,
    last: &'a Last,
    scales: Scales,
}

impl Sequence<'_, '_> {
    /// The last cylinder moved to the points. It keeps its radius: depth is smeared at the limbs, and with the radius of the
    /// points the limbs would be elsewhere.
    fn moved(&self, cylinder: &Cylinder, run: &mut Run<'_>) -> Result<Option<Cylinder>> {
        let Cylinder { radius, .. } = *cylinder;
        let of_user = self.data.options;
        let cylinder_limits =
            CylinderLimits { radius_min: radius, radius_max: radius, ..of_user.cylinder_limits };
        let options = Options { cylinder_limits, ..*of_user };
        let data = Data { options: &options, views: self.data.views.clone(), ..*self.data };
        let without_lines = |view: &ViewData<'_>| ViewConstraints::new(view, &[], 0, 0);
        let constraints =
            Constraints { views: data.views.iter().map(without_lines).collect(), ..Constraints::default() };
        let minimum = data.minimise_near(&constraints, cylinder, self.scales.clone(), Precision::Rough, run);
        Ok(unless_cancelled(minimum)?.ok().map(|minimum| *minimum.cylinder()))
    }

    /// The limbs and arcs near a cylinder, which is the last one or, where that is not at rest, near it, and the minimum with
    /// both.
    fn locate_about(&self, cylinder: &Cylinder, rest: bool, run: &mut Run<'_>) -> Result<Option<Located>> {
        let data = self.data;
        let guided: List<GuidedView> = data.views.iter().map(|view| guided(view, cylinder)).collect();
        let Some(observations) = self.observe(&guided, cylinder, rest, run)? else { return Ok(None) };
        let flags = data.views.iter().fold(Flags::empty(), |flags, view| flags | view.edges.flags);
        let mut lines = lines_of(data, &observations);
        data.loosen(&mut lines, &observations, cylinder, &self.scales);
        let mut without = constraints(data, &guided, flags, &lines);
        without.keep(observations);
        without.settle(&self.scales);
        if without.contradicts_segments(data, &guided) {
            return Ok(None);
        }
        let at_rest = |view: &ViewData<'_>| {
            let ends = self.last.view(view.index).map_or([None; 2], |last| last.ends);
            KnownEnds { whole: view.whole, last: ends.map(|end| end.map(|end| end.on(cylinder))) }
        };
        let mut known: List<KnownEnds> = match rest {
            true => data.views.iter().map(at_rest).collect(),
            false => List::filled(KnownEnds::default(), data.views.len()),
        };
        let mut before = *cylinder;
        let mut located: Option<Located> = None;
        for _ in 0..ARC_ROUNDS {
            let constraints = with_arcs(data, &without, &known, &before, run)?;
            let minimum = match &located {
                None => data.minimise_near(&constraints, &before, self.scales.clone(), Precision::Full, run),
                Some(located) => data.minimise_again(&constraints, &located.minimum, Precision::Full, run),
            };
            let Ok(minimum) = unless_cancelled(minimum)? else { return Ok(None) };
            if contradicts(data, &constraints, &minimum, self.scales.all) {
                return Ok(None);
            }
            let after = *minimum.cylinder();
            let arcs = |view: &ViewConstraints| KnownEnds {
                whole: view.is_whole(),
                last: view.ends.map(|end| end.map(|end| end.on(&after))),
            };
            known = constraints.views.iter().map(arcs).collect();
            located = Some(Located { minimum, constraints });
            if !known.iter().any(|known| known.whole) || before.axis.angle(&after.axis) < SETTLED_TURN {
                break;
            }
            before = after;
        }
        Ok(located)
    }

    /// What the images show of the limbs; `None` where one is not as it was.
    fn observe(
        &self,
        guided: &[GuidedView],
        cylinder: &Cylinder,
        rest: bool,
        run: &mut Run<'_>,
    ) -> Result<Option<Observations>> {
        let mut observations = List::new();
        for (view, guided) in self.data.views.iter().zip(guided) {
            run.check()?;
            let (Some(image), Some(camera)) = (view.view.image(), view.camera()) else {
                observations.push(None);
                continue;
            };
            let appearance = self.last.view(view.index).and_then(|last| last.appearance.as_ref());
            let (Some(range), Some(appearance)) = (guided.range, appearance) else { return Ok(None) };
            let reach = [view.noise.pixel * if rest { RESTING.get() } else { MOVED.get() }; 2];
            let search = LimbSearch {
                ranges: [range; 2],
                reach,
                deviation: [guided.deviation; 2],
                covered: [false; 2],
                noise: view.noise,
            };
            let seen = view.seen(cylinder);
            let seen = locate_limbs_again(image, camera, &seen, &search, appearance, rest);
            if seen.is_none() {
                return Ok(None);
            }
            observations.push(seen);
        }
        Ok(Some(observations))
    }
}

/// What guides the limbs of a view: the given segments.
fn guided(view: &ViewData<'_>, cylinder: &Cylinder) -> GuidedView {
    let mut guides = Guides::given(&view.edges.segments);
    let range = view.camera().and_then(|camera| {
        guides.number(camera, &view.seen(cylinder));
        match guides.given.is_empty() {
            true => Some(view.range_of_points(cylinder)),
            false => view.range_of_given(camera, cylinder),
        }
    });
    GuidedView { guides, range, deviation: view.noise.limb_of_points, unconfirmed: false }
}
