//! What is said about one input: the JSON object.

use crate::failure::Failure;
use cylfuse::completion::CompletionCounts;
use cylfuse::extent::{EndState, Extent};
use cylfuse::fitter::{
    FitResult, Flags, Method, ObjectiveKind, Options, RadiusComparison, StartKind, Uncertainty,
};
use cylfuse::geometry::{Cylinder, CylinderLimits};
use cylfuse::limb_location::{LimbObservation, NotVisible};
use cylfuse::observations::Dropped;
use cylfuse::solver::Termination;
use nalgebra::Vector3;
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
    /// What the image shows of the two limbs; none when it was not searched.
    pub limbs: Option<[LimbValues; 2]>,
    /// Which points were fitted.
    pub fitted: Fitted,
    /// What became of the pixels of the mask; none without one.
    pub completion: Option<CompletionValues>,
    /// Doubts and what is missing, in words.
    pub notes: Vec<String>,
    /// The folder of the files about it.
    pub out: Option<String>,
    /// Time spent.
    pub seconds: SecondsValues,
}

/// Which points were fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Fitted {
    /// The measured pixels of the mask.
    Mask,
    /// All measured pixels of a frame without a mask.
    AllMeasuredPixels,
    /// A bare point cloud.
    Cloud,
}

/// A cylinder.
#[derive(Debug, Serialize)]
pub struct CylinderValues {
    point: [f64; 3],
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

/// The radius by the points and by the limbs, each with its standard deviation.
#[derive(Debug, Serialize)]
struct RadiiValues {
    from_points: f64,
    from_points_deviation: f64,
    from_limbs: f64,
    from_limbs_deviation: f64,
    z_score: f64,
}

impl From<&RadiusComparison> for RadiiValues {
    fn from(radii: &RadiusComparison) -> Self {
        let RadiusComparison { from_points, from_points_deviation, from_limbs, from_limbs_deviation } =
            *radii;
        let z_score = radii.z_score();
        Self { from_points, from_points_deviation, from_limbs, from_limbs_deviation, z_score }
    }
}

/// The visible piece.
#[derive(Debug, Serialize)]
pub struct ExtentValues {
    center: [f64; 3],
    /// The distance of the ends.
    pub length: f64,
    start: [f64; 3],
    end: [f64; 3],
    /// What the start is.
    pub start_state: &'static str,
    /// What the end is.
    pub end_state: &'static str,
    start_deviation: Option<f64>,
    end_deviation: Option<f64>,
    /// Standard deviation of the length.
    pub length_deviation: Option<f64>,
    start_covariance: Option<[[f64; 3]; 3]>,
    end_covariance: Option<[[f64; 3]; 3]>,
    center_covariance: Option<[[f64; 3]; 3]>,
}

impl ExtentValues {
    /// The two ends on the axis, each with its state.
    pub fn ends(&self) -> [(Vector3<f64>, &'static str); 2] {
        [(Vector3::from(self.start), self.start_state), (Vector3::from(self.end), self.end_state)]
    }
}

/// What was seen of one limb.
#[derive(Debug, Serialize)]
pub struct LimbValues {
    /// The line; none when it was not located.
    line: Option<LineValues>,
    /// Why there is no line.
    not_visible: Option<&'static str>,
    samples_used: usize,
    samples_refused: usize,
    /// Standard deviation of the blur of the image in pixels.
    blur: Option<f64>,
}

/// A line by two points whose errors across it are independent.
#[derive(Debug, Serialize)]
struct LineValues {
    /// In pixels without distortion.
    ends: [[f64; 2]; 2],
    /// Standard deviation of either end across the line, in pixels.
    sigma: f64,
}

impl From<&LimbObservation> for LimbValues {
    fn from(limb: &LimbObservation) -> Self {
        let used = limb.samples.iter().filter(|sample| limb.uses(sample)).count();
        Self {
            line: limb
                .line
                .ok()
                .map(|line| LineValues { ends: line.ends.map(Into::into), sigma: line.sigma }),
            not_visible: limb.line.err().map(|reason| match reason {
                NotVisible::NoLimbs => "no_limbs",
                NotVisible::TooShort => "too_short",
                NotVisible::NoEdge => "no_edge",
                NotVisible::OutOfReach => "out_of_reach",
                NotVisible::Uncertain => "uncertain",
                NotVisible::Patchy => "patchy",
                NotVisible::SameLine => "same_line",
            }),
            samples_used: used,
            samples_refused: limb.samples.len() - used,
            blur: limb.blur,
        }
    }
}

/// What became of the pixels of the mask.
#[derive(Debug, Serialize)]
pub struct CompletionValues {
    points: usize,
    misses: usize,
    outside_camera: usize,
}

/// The fields of [`FitResult`], and the method.
#[derive(Debug, Serialize)]
pub struct ResultValues {
    method: &'static str,
    /// The objective of the fused method.
    pub objective: Option<&'static str>,
    cost: f64,
    energy_points: f64,
    energy_edges: Option<f64>,
    edge_weight: Option<f64>,
    /// Linear solves.
    pub iterations: usize,
    termination: Option<&'static str>,
    rejected_steps: Option<usize>,
    initial_cost: Option<f64>,
    /// Points that took part.
    pub points_used: usize,
    points_given: usize,
    dropped: DroppedValues,
    /// Segments that took part.
    pub segments_used: usize,
    segments_given: usize,
    /// Limbs that were located in the image.
    pub limbs_located: usize,
    /// Root mean square distance of the points from the surface.
    pub point_rms: f64,
    /// Root mean square distance of the endpoints from the limb lines.
    pub edge_rms_pixels: Option<f64>,
    near_wall_fraction: Option<f64>,
    condition: f64,
    lambda: Option<f64>,
    gradient_norm: f64,
    step_norm: Option<f64>,
    radii: Option<RadiiValues>,
    /// What the cylinder keeps; none without limits.
    limits: Option<LimitsValues>,
    start: CylinderValues,
    start_kind: &'static str,
    flags: Vec<String>,
}

/// Limits of radius and axis; an infinite radius is null.
#[derive(Debug, Serialize)]
struct LimitsValues {
    radius_min: f64,
    radius_max: f64,
    axis: Option<[f64; 3]>,
    axis_max_angle_degrees: Option<f64>,
}

impl LimitsValues {
    fn new(limits: &CylinderLimits) -> Option<Self> {
        (*limits != CylinderLimits::default()).then(|| Self {
            radius_min: limits.radius_min,
            radius_max: limits.radius_max,
            axis: limits.axis.map(|cone| cone.direction.into()),
            axis_max_angle_degrees: limits.axis.map(|cone| cone.max_angle.to_degrees()),
        })
    }
}

#[derive(Debug, Serialize)]
struct DroppedValues {
    not_finite: usize,
    zero_weight: usize,
    outside_mask: usize,
    no_depth: usize,
    out_of_range: usize,
    outside_camera: usize,
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
    pub fn new(fitted: Fitted, options: &Options, result: &FitResult) -> Self {
        let mut notes = Vec::new();
        if fitted == Fitted::AllMeasuredPixels {
            notes.push(format!(
                "no mask: all {} measured pixels are fitted, the background included, and there is no extent \
                 and no completion",
                result.points_used
            ));
        }
        notes.extend(result.flags.iter().map(|flag| doubt(flag, result)));
        Self {
            cylinder: (&result.cylinder).into(),
            uncertainty: result.uncertainty.as_ref().map(UncertaintyValues::from),
            extent: None,
            limbs: None,
            result: ResultValues::new(options, result),
            fitted,
            completion: None,
            notes,
            out: None,
            seconds: SecondsValues {
                start: result.seconds.start,
                solve: result.seconds.solve,
                fit: result.seconds.total,
                ..SecondsValues::default()
            },
        }
    }

    /// Adds the extent.
    pub fn set_extent(&mut self, extent: &Extent) {
        let state = |state| match state {
            EndState::Seen => "seen",
            EndState::Cut => "cut",
            EndState::Hidden => "hidden",
            EndState::Unknown => "unknown",
        };
        self.extent = Some(ExtentValues {
            center: extent.center.into(),
            length: extent.length,
            start: extent.start.into(),
            end: extent.end.into(),
            start_state: state(extent.start_state),
            end_state: state(extent.end_state),
            start_deviation: extent.start_deviation,
            end_deviation: extent.end_deviation,
            length_deviation: extent.uncertainty.map(|uncertainty| uncertainty.length),
            start_covariance: extent.uncertainty.map(|uncertainty| uncertainty.start.into()),
            end_covariance: extent.uncertainty.map(|uncertainty| uncertainty.end.into()),
            center_covariance: extent.uncertainty.map(|uncertainty| uncertainty.center.into()),
        });
    }

    /// Adds the counts of the completion.
    pub fn set_completion(&mut self, counts: &CompletionCounts) {
        let CompletionCounts { hits, misses, outside_camera } = *counts;
        self.completion = Some(CompletionValues { points: hits, misses, outside_camera });
    }
}

impl ResultValues {
    fn new(options: &Options, result: &FitResult) -> Self {
        let fused = options.method == Method::Fused;
        // Methods without iterations have nothing to say about them.
        let iterated = result.termination.is_some();
        let Dropped { not_finite, zero_weight, outside_mask, no_depth, out_of_range, outside_camera } =
            result.dropped;
        Self {
            method: match options.method {
                Method::Fused => "fused",
                Method::Points => "points",
                Method::Ransac => "ransac",
                Method::Eberly => "eberly",
            },
            objective: fused.then_some(match options.objective {
                ObjectiveKind::Robust => "robust",
                ObjectiveKind::Paper => "paper",
            }),
            cost: result.cost,
            energy_points: result.energy_points,
            energy_edges: result.energy_edges,
            edge_weight: result.edge_weight,
            iterations: result.iterations,
            termination: result.termination.map(|termination| match termination {
                Termination::Cost => "cost",
                Termination::Stalled => "stalled",
                Termination::MaxIterations => "max_iterations",
                Termination::RadiusRanAway => "radius_ran_away",
            }),
            rejected_steps: iterated.then_some(result.rejected_steps),
            initial_cost: iterated.then_some(result.initial_cost),
            points_used: result.points_used,
            points_given: result.points_given,
            dropped: DroppedValues {
                not_finite,
                zero_weight,
                outside_mask,
                no_depth,
                out_of_range,
                outside_camera,
            },
            segments_used: result.segments_used,
            segments_given: result.segments_given,
            limbs_located: result.limbs_located,
            point_rms: result.point_rms,
            edge_rms_pixels: result.edge_rms_pixels,
            near_wall_fraction: result.near_wall_fraction,
            condition: result.condition,
            lambda: iterated.then_some(result.lambda),
            gradient_norm: result.gradient_norm,
            step_norm: iterated.then_some(result.step_norm),
            radii: result.radii.as_ref().map(RadiiValues::from),
            limits: LimitsValues::new(&options.cylinder_limits),
            start: (&result.start).into(),
            start_kind: match result.start_kind {
                StartKind::Auto => "auto",
                StartKind::Limbs => "limbs",
                StartKind::Moments => "moments",
                StartKind::Ransac => "ransac",
                StartKind::Model => "model",
            },
            flags: result.flags.iter_names().map(|(name, _)| name.to_lowercase()).collect(),
        }
    }
}

/// A flag in words.
fn doubt(flag: Flags, result: &FitResult) -> String {
    let text = match flag {
        Flags::EDGES_IGNORED => "the edge segments do not count",
        Flags::SEGMENTS_UNUSABLE => {
            "some edge segments have no length or lie outside the field of the camera"
        }
        Flags::EDGES_CROSS => "the two edge segments cross each other, so they are not the two limbs",
        Flags::EDGES_COINCIDE => "the two edge segments lie on the same limb",
        Flags::EDGES_BEHIND => "the edge segments do not meet the cylinder in front of the camera",
        Flags::SCALE_HELD => "edges alone do not tell the scale: that of the start was kept",
        Flags::WEAK_RADIUS => "the data hardly determine the radius",
        Flags::RESOLUTION_LOST => {
            "the coordinates are coarser than 0.01 % of the radius; store them as doubles"
        }
        Flags::NOT_CONVERGED => "not converged; allow more iterations",
        Flags::HIDDEN_WALL => "most points lie on the wall that the camera cannot see",
        Flags::CAMERA_INSIDE => "the camera is inside the cylinder, which has no limbs then",
        Flags::RADIUS_AT_LIMIT => "a limit holds the radius: the data want another one",
        Flags::AXIS_AT_LIMIT => "the axis is on the border of its cone: the data want another one",
        Flags::POINTS_NOT_FINITE => {
            return format!("{} points are not finite and were left out", result.dropped.not_finite);
        }
        Flags::POINTS_AND_LIMBS_DISAGREE => return disagreement(result),
        _ => return format!("flag {:#x}", flag.bits()),
    };
    text.into()
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

    #[test]
    fn every_flag_has_words() {
        let result = cylfuse_result();
        for flag in Flags::all().iter() {
            assert!(!doubt(flag, &result).starts_with("flag"), "{flag:?}");
        }
    }

    #[test]
    fn what_is_not_finite_is_null() {
        let mut result = cylfuse_result();
        result.condition = f64::INFINITY;
        result.gradient_norm = f64::NAN;
        let measurement = Measurement::new(Fitted::Cloud, &Options::default(), &result);
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
