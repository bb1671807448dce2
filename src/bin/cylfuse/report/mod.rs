//! What is said about one input: the JSON object.

mod result;
mod views;

pub use views::{ExtentValues, Fitted, ViewValues};

use crate::failure::Failure;
use crate::page::Illustration;
use cylfuse::extent::Extent;
use cylfuse::fitter::{FitResult, Flags, Options, RadiusComparison, Uncertainty};
use cylfuse::geometry::Cylinder;
use result::ResultValues;
use serde::Serialize;
use std::path::Path;

/// One object of the JSON output. Numbers that are not finite become null in JSON.
#[derive(Debug, Serialize)]
pub struct Report {
    /// The path of the input.
    pub frame: String,
    /// How it went.
    #[serde(flatten)]
    pub outcome: Outcome,
}

/// A measurement, or why there is none.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub enum Outcome {
    /// It went well.
    Measured(Box<Measurement>),
    /// It did not.
    Failed {
        /// Why.
        error: Failure,
    },
}

impl Report {
    /// The report on the input at a path.
    pub fn new(path: &Path, outcome: Result<Measurement, Failure>) -> Self {
        let outcome = match outcome {
            Ok(measurement) => Outcome::Measured(Box::new(measurement)),
            Err(error) => Outcome::Failed { error },
        };
        Self { frame: path.display().to_string(), outcome }
    }
}

/// Everything about one fit.
#[derive(Debug, Serialize)]
pub struct Measurement {
    /// The cylinder.
    pub cylinder: CylinderValues,
    /// Its uncertainty; none where it is not known.
    pub uncertainty: Option<UncertaintyValues>,
    /// Its visible piece; none without a mask.
    pub extent: Option<ExtentValues>,
    /// How the fit went.
    pub result: ResultValues,
    /// What the only view shows, or what can be said of all views together.
    #[serde(flatten)]
    pub view: ViewValues,
    /// The same of each view where there are several.
    pub views: Option<Vec<ViewValues>>,
    /// Warnings and what is missing, in words.
    pub notes: Vec<String>,
    /// Those of them that put radius and length in doubt, whatever their deviations are.
    #[serde(skip)]
    pub undecided_by: Vec<String>,
    /// The folder of the files about it.
    pub out: Option<String>,
    /// What a page shows of it.
    #[serde(skip)]
    pub illustration: Option<Illustration>,
    /// Time spent.
    pub seconds: SecondsValues,
}

/// A cylinder.
#[derive(Debug, Serialize)]
pub struct CylinderValues {
    pub point: [f64; 3],
    /// Unit vector along the axis.
    pub direction: [f64; 3],
    /// The radius.
    pub radius: f64,
}

impl From<&Cylinder> for CylinderValues {
    fn from(cylinder: &Cylinder) -> Self {
        Self {
            point: cylinder.axis.point.into(),
            direction: cylinder.axis.direction.into(),
            radius: cylinder.radius,
        }
    }
}

/// Standard deviations of a cylinder.
#[derive(Debug, Serialize)]
pub struct UncertaintyValues {
    /// Of the radius.
    pub radius: f64,
    /// Of the direction, in radians.
    direction: f64,
    /// Of the position of the axis across itself.
    position: f64,
    /// Covariance of point, direction and radius, row by row.
    covariance: [[f64; 7]; 7],
}

impl From<&Uncertainty> for UncertaintyValues {
    fn from(uncertainty: &Uncertainty) -> Self {
        Self {
            radius: uncertainty.radius(),
            direction: uncertainty.direction(),
            position: uncertainty.position(),
            covariance: uncertainty.covariance().into(),
        }
    }
}

/// Wall-clock seconds by phase.
#[derive(Debug, Default, Serialize)]
pub struct SecondsValues {
    /// Reading and decoding the files.
    pub read: f64,
    /// Finding the start.
    pub start: f64,
    /// Iterating.
    pub solve: f64,
    /// The fit: start, iterations, checks.
    pub fit: f64,
    /// All of it, the output files excepted.
    pub total: f64,
}

impl Measurement {
    /// What a fit gives.
    pub fn new(options: &Options, result: &FitResult) -> Self {
        let explained = |flags: Flags| flags.iter().map(|flag| explain(flag, result)).collect();
        Self {
            cylinder: (&result.cylinder).into(),
            uncertainty: result.uncertainty.as_ref().map(UncertaintyValues::from),
            extent: None,
            result: ResultValues::new(options, result),
            view: ViewValues::new(Fitted::Cloud),
            views: None,
            notes: explained(result.flags),
            undecided_by: explained(result.flags.intersection(UNDECIDED_BY)),
            out: None,
            illustration: None,
            seconds: SecondsValues {
                start: result.seconds.start,
                solve: result.seconds.solve,
                fit: result.seconds.total,
                ..SecondsValues::default()
            },
        }
    }

    /// Adds what was used and found in the views.
    pub fn set_views(&mut self, views: Vec<ViewValues>) {
        let without = |view: &ViewValues| view.fitted == Fitted::AllMeasuredPixels;
        let mut notes = Vec::new();
        if views.iter().all(without) {
            notes.push(format!(
                "no mask: all {} measured pixels are fitted, including the background, and there is no extent \
                 and no completion",
                self.result.points_used
            ));
        } else {
            for index in (0..views.len()).filter(|&index| without(&views[index])) {
                notes.push(format!(
                    "no mask in view {index}: all its measured pixels are fitted, including the background"
                ));
            }
        }
        self.notes.splice(0..0, notes);
        match <[ViewValues; 1]>::try_from(views) {
            Ok([only]) => self.view = only,
            Err(views) => {
                self.view = ViewValues::together(&views);
                self.views = Some(views);
            }
        }
    }

    /// Adds the extent.
    pub fn set_extent(&mut self, extent: &Extent) {
        self.extent = Some(extent.into());
    }
}

/// The warnings of which a stated deviation says nothing: no verdict rests on such a result (docs/warnings.md).
const UNDECIDED_BY: Flags = Flags::POOR_FIT
    .union(Flags::POINTS_AND_LIMBS_DISAGREE)
    .union(Flags::BODY_TAPERS)
    .union(Flags::HIDDEN_WALL)
    .union(Flags::MASK_ENDS_WITH_DEPTH)
    .union(Flags::NOT_CONVERGED)
    .union(Flags::RADIUS_AT_LIMIT)
    .union(Flags::AXIS_AT_LIMIT)
    .union(Flags::SCALE_HELD)
    .union(Flags::RESOLUTION_LOST)
    .union(Flags::UNCERTAINTY_UNKNOWN);

/// A flag in words.
fn explain(flag: Flags, result: &FitResult) -> String {
    let text = match flag {
        Flags::EDGES_IGNORED => "none of the edge segments was used",
        Flags::SEGMENTS_UNUSABLE => {
            "some edge segments have no length or lie outside the field of the camera"
        }
        Flags::EDGES_CROSS => "the two edge segments cross each other, so they are not the two limbs",
        Flags::EDGES_COINCIDE => "the two edge segments lie on the same limb",
        Flags::EDGES_BEHIND => "the edge segments do not meet the cylinder in front of the camera",
        Flags::SCALE_HELD => "edges alone do not determine the scale; that of the start was kept",
        Flags::WEAK_RADIUS => "the data hardly determine the radius",
        Flags::RESOLUTION_LOST => {
            "the coordinates are coarser than 0.01 % of the radius; store them as doubles"
        }
        Flags::NOT_CONVERGED => "not converged; allow more iterations",
        Flags::HIDDEN_WALL => "most points lie on the wall that the camera cannot see",
        Flags::CAMERA_INSIDE => "the camera is inside the cylinder, which has no limbs then",
        Flags::RADIUS_AT_LIMIT => "the radius is at its limit; the data fit better beyond it",
        Flags::AXIS_AT_LIMIT => "the axis is on the border of its cone; the data fit better beyond it",
        Flags::UNCERTAINTY_UNKNOWN => "the data do not determine the uncertainty of the result",
        Flags::POINTS_NOT_FINITE => {
            return format!("{} points are not finite and were left out", result.dropped.not_finite);
        }
        Flags::POINTS_AND_LIMBS_DISAGREE => return disagreement(result),
        Flags::DEPTH_SHIFTED => return shifted(result),
        Flags::MASK_ENDS_WITH_DEPTH => {
            "the mask ends where the depth does; its sides are no hint where the limbs are"
        }
        Flags::POOR_FIT => return poor(result),
        Flags::BODY_TAPERS => return tapers(result),
        _ => return format!("flag {:#x}", flag.bits()),
    };
    text.into()
}

/// The scatter of the points in words.
fn poor(result: &FitResult) -> String {
    let (scale, radius) = (result.point_scale, result.cylinder.radius);
    format!("the points do not lie on the cylinder: they scatter by {scale:.3} about a radius of {radius:.3}")
}

/// The shift in words.
fn shifted(result: &FitResult) -> String {
    let numbers = result
        .shift
        .map_or_else(String::new, |shift| format!(": {:.2} ± {:.2} px", shift.pixels, shift.deviation));
    format!("depth and image are shifted against each other across the axis{numbers}")
}

/// The taper in words.
fn tapers(result: &FitResult) -> String {
    let numbers = result.taper.map_or_else(String::new, |taper| {
        format!(": by {:.1} ± {:.1} % of the length", 100.0 * taper.slope, 100.0 * taper.deviation)
    });
    format!("the radius changes along the axis{numbers}; the body tapers, or one limb is something else")
}

/// The two radii in words.
fn disagreement(result: &FitResult) -> String {
    let numbers = result.radii.map_or_else(String::new, |radii| {
        let RadiusComparison { from_points, from_points_deviation, from_limbs, from_limbs_deviation } = radii;
        format!(
            ": {from_points:.5} ± {from_points_deviation:.5} against {from_limbs:.5} ± {from_limbs_deviation:.5}"
        )
    });
    format!("the points and the limbs disagree about the radius{numbers}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn every_flag_has_words() {
        let result = cylfuse_result();
        for flag in Flags::all().iter() {
            assert!(!explain(flag, &result).starts_with("flag"), "{flag:?}");
        }
    }

    #[test]
    fn what_is_not_finite_is_null() {
        let mut result = cylfuse_result();
        result.condition = f64::INFINITY;
        result.gradient_norm = f64::NAN;
        let measurement = Measurement::new(&Options::default(), &result);
        let text = serde_json::to_string(&Report::new(Path::new("a.ply"), Ok(measurement))).unwrap();
        assert!(text.starts_with(r#"{"frame":"a.ply","cylinder":{"point":["#), "{text}");
        assert!(text.contains(r#""condition":null"#) && text.contains(r#""gradient_norm":null"#));
        let failure = Report::new(Path::new("b"), Err(Failure { status: "BAD_FRAME", message: "m".into() }));
        let text = serde_json::to_string(&failure).unwrap();
        assert_eq!(text, r#"{"frame":"b","error":{"status":"BAD_FRAME","message":"m"}}"#);
    }

    /// The fit of a small exact cloud.
    fn cylfuse_result() -> FitResult {
        let point = |k: u32| {
            let (angle, z) = (f64::from(k), 0.1 * f64::from(k % 7));
            [angle.cos(), angle.sin(), z]
        };
        let points: Vec<[f64; 3]> = (0..40).map(point).collect();
        let mut fitter = cylfuse::fitter::Fitter::new();
        let cylinder = Cylinder::new(Vector3::zeros(), Vector3::z(), 1.0).unwrap();
        fitter.push_points(&cylfuse::observations::PointsView::from_f64(&points), None).unwrap();
        fitter.evaluate(&cylinder).unwrap()
    }
}
