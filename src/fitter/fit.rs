//! A fit from top to bottom.
//!
//! Data never change; each stage is a function from them and the value of the stage before to a new value:
//!
//! ```text
//! Data ─ start ─▶ candidates ─ guided ─▶ Guided ─ located ─▶ Located ─ arcs ─▶ Located ─ minimum ─▶ Fit
//! ```
//!
//! Of very many points a part goes through all stages but the last minimum: see `subsample`. In a sequence `continued` may lead
//! from the data to the last minimum at once.

use super::arcs;
use super::constraints::Constraints;
use super::continued;
use super::data::Data;
use super::guided::{self, GIVEN_CONTRADICTION, Guided, SCALE_CONTRADICTION, reason_without_limbs};
use super::located::{self, Located};
use super::objective::{Minimum, Precision};
use super::options::{Method, StartKind};
use super::result::Flags;
use super::rims;
use super::run::Run;
use super::scales::Scales;
use super::start::Candidate;
use crate::error::{Error, Result, unless_cancelled};
use crate::geometry::Cylinder;
use crate::solver::Convergence;

/// Points lie on one cylinder as well as on another up to this ratio of the scales of their residuals, which the points of a
/// region tell to some percent.
pub(super) const AS_WELL: f64 = 1.05;

/// What a fit ends with.
pub(super) struct Fit {
    pub cylinder: Cylinder,
    pub start: Candidate,
    /// `None` for the methods that do not iterate.
    pub convergence: Option<Convergence>,
    pub constraints: Constraints,
    /// The scales at the cylinder, where they are known.
    pub scales: Option<Scales>,
}

/// Fits by the method of the options. `started` is called with the seconds until a start was found.
pub(super) fn fit(data: &Data<'_>, run: &mut Run<'_>, mut started: impl FnMut(f64)) -> Result<Fit> {
    let views_of_subsample = data.views_of_subsample();
    let subsample = views_of_subsample.as_ref().map(|views| data.of_subsample(views));
    let subsample = subsample.as_ref().unwrap_or(data);
    match data.options.method {
        Method::Eberly => {
            let reason = || Error::NoStart { reason: "the moments of the points give no cylinder".into() };
            without_iteration(data, StartKind::Moments, data.moments_start().ok_or_else(reason)?)
        }
        Method::Ransac => without_iteration(data, StartKind::Ransac, data.ransac(run)?),
        Method::Fused | Method::Points if !data.is_robust() => {
            let candidates = subsample.candidates(run)?;
            started(run.seconds());
            paper(data, subsample, &candidates, run)
        }
        Method::Fused | Method::Points => {
            started(run.seconds());
            let (start, located) = match continued::locate(subsample, run)? {
                Some(continued) if subsample.count() == data.count() => {
                    return Ok(ended(continued.0, continued.1));
                }
                Some(continued) => continued,
                None => {
                    let candidates = subsample.candidates(run)?;
                    started(run.seconds());
                    robust(subsample, &candidates, run)?
                }
            };
            Ok(ended(start, last_minimum(data, subsample, located, run)?))
        }
    }
}

/// The minimum with all points and in full, in which they give way to lines as far as bent points do.
fn last_minimum(
    data: &Data<'_>,
    subsample: &Data<'_>,
    located: Located,
    run: &mut Run<'_>,
) -> Result<Located> {
    let mut minimise = |constraints: &Constraints, from: &Minimum| match subsample.count() == data.count() {
        true => data.minimise_again(constraints, from, Precision::Full, run),
        false => data.minimise_with_all(constraints, from, run),
    };
    let Located { minimum: mut from, constraints } = located;
    let minimum = minimise(&constraints, &from)?;
    if minimum.scale() <= most_by_bend(&constraints) * from.scale() {
        return Ok(Located { minimum, constraints });
    }
    // From where it was, with the work that was done in vain.
    from.convergence = Convergence { cylinder: *from.cylinder(), ..minimum.convergence };
    let constraints = contradicted(constraints);
    Ok(Located { minimum: minimise(&constraints, &from)?, constraints })
}

/// By how much the scale of the points rises at most where they give way to lines because they are bent. Limbs that an image shows hold
/// the radius before that. Others leave more to it: by time of flight up to 2.3 times, where noise is averaged away.
fn most_by_bend(constraints: &Constraints) -> f64 {
    if constraints.limbs_located() > 0 { SCALE_CONTRADICTION } else { GIVEN_CONTRADICTION }
}

/// The constraints of a cylinder where it is not the points that are bent, but the lines that are wrong: the points do not give way.
fn contradicted(constraints: Constraints) -> Constraints {
    let warning =
        if constraints.has_limbs() { Flags::POINTS_AND_LIMBS_DISAGREE } else { Flags::MASK_DISAGREES };
    Constraints { settled: false, flags: constraints.flags | warning, ..constraints }
}

fn without_iteration(data: &Data<'_>, kind: StartKind, cylinder: Cylinder) -> Result<Fit> {
    data.check_radius(&cylinder)?;
    let start = Candidate { kind, cylinder };
    Ok(Fit { cylinder, start, convergence: None, constraints: Constraints::as_given(data), scales: None })
}

/// The paper's objective, or its points alone.
#[inline(never)] // Not inlined: its locals would enlarge the caller's stack frame.
fn paper(data: &Data<'_>, subsample: &Data<'_>, candidates: &[Candidate], run: &mut Run<'_>) -> Result<Fit> {
    let mut constraints = Constraints::as_given(data);
    if !candidates.iter().any(|candidate| data.edges_are_finite(&constraints, &candidate.cylinder)) {
        constraints = Constraints::without_edges(data, reason_without_limbs(data, candidates));
    }
    let (start, mut minimum) = subsample.best_minimum(&constraints, candidates, Precision::Full, run)?;
    if subsample.count() < data.count() {
        let of_subsample = minimum.convergence;
        minimum = data.minimise(&constraints, &of_subsample.cylinder, Precision::Full, run)?;
        data.check_radius(minimum.cylinder())?;
        minimum.convergence.add_work_of(&of_subsample);
    }
    Ok(Fit { scales: None, ..ended(start, Located { minimum, constraints }) })
}

/// The robust objective.
fn robust(data: &Data<'_>, candidates: &[Candidate], run: &mut Run<'_>) -> Result<(Candidate, Located)> {
    let guided = guided::guide(data, candidates, run)?;
    if run.is_known(guided.minimum.cylinder()) {
        return Err(Error::NoStart { reason: "another start led to the same fit".into() });
    }
    Ok(match data.locates() {
        true => {
            let (start, located) = locate(data, &guided, run)?;
            let located = beside_mask(data, &guided, located, run)?;
            let with_arcs = arcs::fit_with_arcs(data, located, run)?;
            match rims::without_rim(data, &guided, &with_arcs, run)? {
                Some(located) => (start, arcs::fit_with_arcs(data, located, run)?),
                None => (start, with_arcs),
            }
        }
        false => {
            (guided.start, Located { minimum: guided.minimum.clone(), constraints: guided.constraints(data) })
        }
    })
}

/// Locates the limbs about the first fit. Where that shows that the given segments were bad guides, what is found without
/// them stands, unless fewer limbs are found there or the points are contradicted: edges that are wrong must not be worse
/// than none.
fn locate(data: &Data<'_>, guided: &Guided, run: &mut Run<'_>) -> Result<(Candidate, Located)> {
    let located = located::locate(data, guided, run)?;
    if run.is_long(data) || !located.constraints.contradicts_segments(data, &guided.views) {
        return Ok((guided.start, located));
    }
    match unless_cancelled(without_segments(data, run))? {
        Ok((start, without))
            if without.constraints.limbs_located() >= located.constraints.limbs_located().max(1)
                && without.minimum.scale() <= SCALE_CONTRADICTION * located.minimum.scale() =>
        {
            Ok((start, without))
        }
        _ => Ok((guided.start, located)),
    }
}

/// A mask that is far too small or too large draws the first fit to its sides, beside which limbs are not believed. Where both
/// limbs are found about the fit to the points alone, and the points lie on that cylinder as well, these stand.
fn beside_mask(data: &Data<'_>, guided: &Guided, located: Located, run: &mut Run<'_>) -> Result<Located> {
    if located.constraints.limbs_located() == 2 || run.is_long(data) {
        return Ok(located);
    }
    let Some(alone) = guided.without_sides(data, run)? else { return Ok(located) };
    let beside = located::locate(data, &alone, run)?;
    let as_well = beside.minimum.scale() <= AS_WELL * located.minimum.scale();
    Ok(if as_well && beside.constraints.limbs_located() == 2 { beside } else { located })
}

/// What is located without the given segments.
fn without_segments(data: &Data<'_>, run: &mut Run<'_>) -> Result<(Candidate, Located)> {
    let data = data.without_edges();
    let candidates = data.candidates(run)?;
    let mut guided = guided::guide(&data, &candidates, run)?;
    guided.flags |= Flags::EDGES_IGNORED;
    Ok((guided.start, located::locate(&data, &guided, run)?))
}

fn ended(start: Candidate, Located { minimum, constraints }: Located) -> Fit {
    let Minimum { convergence, scales } = minimum;
    Fit {
        cylinder: convergence.cylinder,
        start,
        convergence: Some(convergence),
        constraints,
        scales: Some(scales),
    }
}
