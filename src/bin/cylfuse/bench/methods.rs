//! The ways to fit that are compared, and the errors of their results.

use super::program::Program;
use super::sample::Sample;
use crate::failure::Failure;
use cylfuse::extent::Extent;
use cylfuse::fitter::{self, Fitter, NearWall, ObjectiveKind, Options, StartKind};
use cylfuse::geometry::Cylinder;
use cylfuse::observations::EdgeSegment;
use std::time::Instant;

/// E_o (degrees), E_p (mm), E_r (%), E_l (%) of the paper's section 5.1; NaN where the truth is not known.
pub type Errors = [f64; 4];

/// What they are called.
pub const METRICS: [Metric; 4] = [
    Metric { symbol: "E_o", name: "orientation error E_o", unit: "°" },
    Metric { symbol: "E_p", name: "position error E_p", unit: "mm" },
    Metric { symbol: "E_r", name: "radius error E_r", unit: "%" },
    Metric { symbol: "E_l", name: "length error E_l", unit: "%" },
];

/// An error in words.
#[derive(Debug, Clone, Copy)]
pub struct Metric {
    /// As in the paper.
    pub symbol: &'static str,
    /// Spelled out.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
}

/// A way to fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Random samples with local optimisation.
    Ransac,
    /// Eberly's algebraic fit.
    Eberly,
    /// Least squares of the points, w_L = 0.
    Points,
    /// The paper's objective and algorithm, w_L = 0.6.
    Paper,
    /// This library as it comes: depth, mask, edges, image.
    Default,
    /// The same without edges.
    NoEdges,
    /// The Point Cloud Library.
    Pcl,
}

impl Method {
    /// Those of the paper's section 5.5 and this library.
    pub const COMPARED: [Method; 5] =
        [Method::Ransac, Method::Eberly, Method::Points, Method::Paper, Method::Default];

    /// In tables and legends.
    pub fn name(self) -> &'static str {
        match self {
            Method::Ransac => "RANSAC",
            Method::Eberly => "Eberly",
            Method::Points => "points alone",
            Method::Paper => "paper's objective",
            Method::Default => "cylfuse",
            Method::NoEdges => "cylfuse, no edges",
            Method::Pcl => "PCL",
        }
    }

    /// In plots: colours that people with any colour vision can tell apart (Okabe, Ito, "Color universal design", 2008).
    pub fn color(self) -> [u8; 3] {
        match self {
            Method::Ransac => [86, 180, 233],
            Method::Eberly => [204, 121, 167],
            Method::Points => [230, 159, 0],
            Method::Paper => [213, 94, 0],
            Method::Default => [0, 114, 178],
            Method::NoEdges => [0, 158, 115],
            Method::Pcl => [90, 90, 90],
        }
    }

    /// The library's options. Points alone and the paper's objective start from RANSAC, as in its section 5.2.
    pub fn options(self) -> Options {
        let of = |method| Options { method, start: StartKind::Ransac, ..Options::default() };
        match self {
            Method::Ransac => of(fitter::Method::Ransac),
            Method::Eberly => of(fitter::Method::Eberly),
            Method::Points => of(fitter::Method::Points),
            Method::Paper => Options { objective: ObjectiveKind::Paper, ..of(fitter::Method::Fused) },
            Method::Default | Method::NoEdges | Method::Pcl => Options::default(),
        }
    }
}

/// What a fit gave.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The cylinder.
    pub cylinder: Cylinder,
    /// Its ends, where a mask tells them.
    pub extent: Option<Extent>,
    /// Its errors.
    pub errors: Errors,
    /// The wall-clock seconds of the fit alone.
    pub seconds: f64,
}

/// What is changed of a fit.
#[derive(Default)]
pub struct Variation<'a> {
    /// Edges in place of those of the sample.
    pub edges: Option<&'a [EdgeSegment]>,
    /// w_L.
    pub edge_weight: Option<f64>,
    /// A cylinder to start from.
    pub start: Option<Cylinder>,
    /// Whether points must lie on the wall that the camera sees.
    pub near_wall: NearWall,
}

/// Fits a sample by a method of this library; none where the fit fails.
pub fn fit(sample: &Sample, method: Method) -> Option<Outcome> {
    fit_with(sample, method, &Variation::default())
}

/// The same by any method; the Point Cloud Library needs its program.
///
/// # Errors
/// Where that program does not work, which is no failure of a fit.
pub fn fit_by_any(
    sample: &Sample,
    method: Method,
    pcl: Option<&Program>,
) -> Result<Option<Outcome>, Failure> {
    let (Method::Pcl, Some(pcl)) = (method, pcl) else { return Ok(fit(sample, method)) };
    let mut fitter = sample.fitter(Some(&[]))?;
    // The extent that the paper gives all methods.
    fitter.set_options(Method::Ransac.options())?;
    let clock = Instant::now();
    let cylinder = pcl.fit(fitter.cloud().points())?;
    let seconds = clock.elapsed().as_secs_f64();
    Ok(cylinder.map(|cylinder| outcome(sample, &fitter, cylinder, seconds)))
}

/// Fits a sample by a method of this library with something changed; none where the fit fails.
pub fn fit_with(sample: &Sample, method: Method, variation: &Variation<'_>) -> Option<Outcome> {
    let edges = if method == Method::NoEdges { Some(&[][..]) } else { variation.edges };
    let mut fitter = sample.fitter(edges).ok()?;
    let mut options = method.options();
    options.edge_weight = variation.edge_weight.unwrap_or(options.edge_weight);
    options.near_wall = variation.near_wall;
    if variation.start.is_some() {
        options.start = StartKind::Model;
    }
    fitter.set_options(options).ok()?;
    fitter.set_start(variation.start);
    let clock = Instant::now();
    let cylinder = fitter.fit().ok()?.cylinder;
    Some(outcome(sample, &fitter, cylinder, clock.elapsed().as_secs_f64()))
}

fn outcome(sample: &Sample, fitter: &Fitter, cylinder: Cylinder, seconds: f64) -> Outcome {
    let fitted = fitter.result().is_some_and(|result| result.cylinder == cylinder);
    let extent = fitter.extent((!fitted).then_some(&cylinder), None).ok();
    let truth = &sample.truth;
    let difference = truth.cylinder.compare(&cylinder);
    let of_extent =
        |error: &dyn Fn(&Extent) -> Option<f64>| extent.as_ref().and_then(error).unwrap_or(f64::NAN);
    let errors = [
        difference.angle.to_degrees(),
        of_extent(&|extent| Some((extent.center - truth.center?).norm() * 1e3)),
        if truth.radius_known { difference.radius_relative.abs() * 100.0 } else { f64::NAN },
        of_extent(&|extent| Some((extent.length / truth.length? - 1.0).abs() * 100.0)),
    ];
    Outcome { cylinder, extent, errors, seconds }
}

/// The errors of a fit; NaN where it failed.
pub fn errors_of(outcome: Option<&Outcome>) -> Errors {
    outcome.map_or([f64::NAN; 4], |outcome| outcome.errors)
}
