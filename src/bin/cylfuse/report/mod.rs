//! What is said about one input: the JSON object.

mod result;
mod views;

pub use views::{ExtentValues, Fitted, ViewValues};

use crate::failure::Failure;
use crate::page::Illustration;
use cylfuse::error::Error;
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
    /// Its visible piece; none where no mask and no points show one.
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
            undecided_by: explained(result.flags.intersection(Flags::UNDECIDED)),
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
                "no mask: {} measured pixels were fitted, which may include the background, and there is no completion",
                self.result.points_used
            ));
        } else {
            for index in (0..views.len()).filter(|&index| without(&views[index])) {
                notes.push(format!(
                    "no mask in view {index}: the pixels that were fitted may include the background"
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

    /// Adds why there is none.
    pub fn no_extent(&mut self, error: &Error) {
        self.notes.push(format!("no extent: {error}"));
    }
}

/// A flag in words, with its numbers where the result has some.
fn explain(flag: Flags, result: &FitResult) -> String {
    if flag == Flags::NOT_CONVERGED {
        // Of a detector: the fit was left out or dropped, and more iterations would not help.
        return if result.iterations == 0 {
            "not fitted: the cylinder is as the search found it".into()
        } else {
            "not converged; allow more iterations".into()
        };
    }
    let numbers = match flag {
        Flags::POINTS_NOT_FINITE => Some(result.dropped.not_finite.to_string()),
        Flags::POINTS_AND_LIMBS_DISAGREE => result.radii.as_ref().map(disagreement),
        Flags::DEPTH_SHIFTED => {
            result.shift.map(|shift| format!("{:.2} ± {:.2} px", shift.pixels, shift.deviation))
        }
        Flags::POOR_FIT => {
            let (scale, radius) = (result.point_scale, result.cylinder.radius);
            Some(format!("they scatter by {scale:.3} about a radius of {radius:.3}"))
        }
        Flags::BODY_TAPERS => result.taper.filter(|taper| taper.is_wrong()).map(|taper| {
            format!("by {:.1} ± {:.1} % of the length", 100.0 * taper.slope, 100.0 * taper.deviation)
        }),
        _ => None,
    };
    let meaning = flag.meaning();
    numbers.map_or_else(|| meaning.into(), |numbers| format!("{meaning}: {numbers}"))
}

/// The two radii in words.
fn disagreement(radii: &RadiusComparison) -> String {
    let RadiusComparison { from_points, from_points_deviation, from_limbs, from_limbs_deviation } = radii;
    format!(
        "{from_points:.5} ± {from_points_deviation:.5} against {from_limbs:.5} ± {from_limbs_deviation:.5}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn every_flag_has_words() {
        let mut result = cylfuse_result();
        result.iterations = 1;
        for flag in (Flags::all() - Flags::NOT_CONVERGED).iter() {
            assert!(explain(flag, &result).starts_with(flag.meaning()), "{flag:?}");
        }
        assert!(explain(Flags::NOT_CONVERGED, &result).starts_with("not converged"));
        result.iterations = 0;
        assert!(explain(Flags::NOT_CONVERGED, &result).starts_with("not fitted"));
    }

    /// One of the limbs may be the edge of a neighbour.
    #[test]
    fn no_verdict_rests_on_limbs_beside_the_points() {
        let mut result = cylfuse_result();
        result.flags = Flags::DEPTH_SHIFTED | Flags::CAMERA_INSIDE;
        let undecided_by = Measurement::new(&Options::default(), &result).undecided_by;
        assert!(matches!(&undecided_by[..], [only] if only.starts_with(Flags::DEPTH_SHIFTED.meaning())));
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
