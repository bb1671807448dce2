//! A fit from top to bottom.
//!
//! Data never change; each stage is a function from them and the value of the stage before to a new value:
//!
//! ```text
//! Data ─ start ─▶ candidates ─ guided ─▶ Guided ─ located ─▶ Located ─ arcs ─▶ Located ─ minimum ─▶ Fit
//! ```

use super::arcs;
use super::data::Data;
use super::guided::{self, reason_without_limbs};
use super::held::Held;
use super::located::{self, Located};
use super::objective::{Minimum, Precision, Scales};
use super::options::{Method, StartKind};
use super::run::Run;
use super::start::Candidate;
use crate::error::{Error, Result};
use crate::geometry::Cylinder;
use crate::solver::Convergence;

/// What a fit ends with.
pub(super) struct Fit {
    pub cylinder: Cylinder,
    pub start: Candidate,
    /// `None` for the methods that do not iterate.
    pub convergence: Option<Convergence>,
    pub held: Held,
    /// The scales at the cylinder, where they are known.
    pub scales: Option<Scales>,
}

/// Fits by the method of the options. `started` is called when a start has been found.
pub(super) fn fit(data: &Data<'_>, run: &mut Run<'_>, started: impl FnOnce()) -> Result<Fit> {
    match data.options.method {
        Method::Eberly => {
            let reason = || Error::NoStart { reason: "the moments of the points give no cylinder".into() };
            without_iteration(data, StartKind::Moments, data.moments_start().ok_or_else(reason)?)
        }
        Method::Ransac => without_iteration(data, StartKind::Ransac, data.ransac(run)?.cylinder),
        Method::Fused | Method::Points if !data.is_robust() => {
            let candidates = data.candidates(run)?;
            started();
            paper(data, &candidates, run)
        }
        Method::Fused | Method::Points => {
            let candidates = data.candidates(run)?;
            started();
            robust(data, &candidates, run)
        }
    }
}

fn without_iteration(data: &Data<'_>, kind: StartKind, cylinder: Cylinder) -> Result<Fit> {
    data.check_radius(&cylinder)?;
    let start = Candidate { kind, cylinder };
    Ok(Fit { cylinder, start, convergence: None, held: Held::as_given(data), scales: None })
}

/// The paper's objective, or its points alone.
fn paper(data: &Data<'_>, candidates: &[Candidate], run: &mut Run<'_>) -> Result<Fit> {
    let mut held = Held::as_given(data);
    if !candidates.iter().any(|candidate| data.edges_are_finite(&held, &candidate.cylinder)) {
        held = Held::without_edges(data, reason_without_limbs(data, candidates));
    }
    let (start, minimum) = data.best_minimum(&held, candidates, Precision::Full, run)?;
    Ok(Fit { scales: None, ..ended(start, minimum, held) })
}

/// The robust objective.
fn robust(data: &Data<'_>, candidates: &[Candidate], run: &mut Run<'_>) -> Result<Fit> {
    let guided = guided::guide(data, candidates, run)?;
    let Located { minimum, held } = match data.locates() {
        true => arcs::bend(data, located::locate(data, &guided, run)?, run)?,
        false => Located { minimum: guided.minimum.clone(), held: guided.held(data) },
    };
    let minimum = data.minimise_again(&held, &minimum, Precision::Full, run)?;
    Ok(ended(guided.start, minimum, held))
}

fn ended(start: Candidate, minimum: Minimum, held: Held) -> Fit {
    let Minimum { convergence, scales } = minimum;
    Fit { cylinder: convergence.cylinder, start, convergence: Some(convergence), held, scales: Some(scales) }
}
