//! What is said about views: points, limbs, ends, completion.

use cylfuse::completion::CompletionCounts;
use cylfuse::extent::{EndSource, EndState, Extent};
use cylfuse::fitter::{LimbObservation, NotVisible};
use nalgebra::Vector3;
use serde::Serialize;

/// What was used and found in a view.
#[derive(Debug, Serialize)]
pub struct ViewValues {
    /// Which points were fitted.
    pub fitted: Fitted,
    /// What the image shows of the two limbs; none when it was not searched, and for several views together.
    pub limbs: Option<[LimbValues; 2]>,
    /// At how many positions the image shows the arcs of start and end; none without an extent, and for several views
    /// together.
    pub arc_samples: Option<[usize; 2]>,
    /// What became of the pixels of the mask; none without one.
    pub completion: Option<CompletionValues>,
}

impl ViewValues {
    /// Nothing but which points were fitted.
    pub fn new(fitted: Fitted) -> Self {
        Self { fitted, limbs: None, arc_samples: None, completion: None }
    }

    /// What can be said of several views together.
    pub fn together(views: &[Self]) -> Self {
        let masks = views.iter().all(|view| view.fitted == Fitted::Mask);
        let completions = views.iter().filter_map(|view| view.completion);
        let completion = completions.reduce(|a, b| CompletionValues {
            points: a.points + b.points,
            misses: a.misses + b.misses,
            outside_camera: a.outside_camera + b.outside_camera,
        });
        Self { completion, ..Self::new(if masks { Fitted::Mask } else { Fitted::AllMeasuredPixels }) }
    }
}

/// Which points were fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Fitted {
    /// The measured pixels of the mask.
    Mask,
    /// The measured pixels of a frame without a mask: all, or those of the cylinder that a search found.
    AllMeasuredPixels,
    /// A bare point cloud.
    Cloud,
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
#[derive(Debug, Clone, Copy, Serialize)]
pub struct CompletionValues {
    points: usize,
    misses: usize,
    outside_camera: usize,
}

impl From<&CompletionCounts> for CompletionValues {
    fn from(counts: &CompletionCounts) -> Self {
        let CompletionCounts { hits, misses, outside_camera } = *counts;
        Self { points: hits, misses, outside_camera }
    }
}

/// The visible piece.
#[derive(Debug, Serialize)]
pub struct ExtentValues {
    center: [f64; 3],
    /// The distance of the ends.
    pub length: f64,
    /// The end against the direction.
    pub start: [f64; 3],
    /// The end along the direction.
    pub end: [f64; 3],
    /// What the start is.
    pub start_state: &'static str,
    /// What the end is.
    pub end_state: &'static str,
    start_source: &'static str,
    end_source: &'static str,
    start_view: usize,
    end_view: usize,
    start_deviation: Option<f64>,
    end_deviation: Option<f64>,
    /// Standard deviation of the length.
    pub length_deviation: Option<f64>,
    start_covariance: Option<[[f64; 3]; 3]>,
    end_covariance: Option<[[f64; 3]; 3]>,
    center_covariance: Option<[[f64; 3]; 3]>,
}

impl ExtentValues {
    /// Whether the cylinder may go on beyond what was measured: at an end that is cut off or hidden, and where no depth was
    /// measured beyond it unless the end itself was located in the image.
    pub fn may_go_on(&self) -> bool {
        let ends = [(self.start_state, self.start_source), (self.end_state, self.end_source)];
        ends.iter().any(|(state, source)| match *state {
            "seen" => false,
            "unknown" => *source != "image",
            _ => true,
        })
    }

    /// The two ends on the axis, each with its state.
    pub fn ends(&self) -> [(Vector3<f64>, &'static str); 2] {
        [(Vector3::from(self.start), self.start_state), (Vector3::from(self.end), self.end_state)]
    }
}

impl From<&Extent> for ExtentValues {
    fn from(extent: &Extent) -> Self {
        let state = |state| match state {
            EndState::Seen => "seen",
            EndState::Cut => "cut",
            EndState::Hidden => "hidden",
            EndState::Unknown => "unknown",
        };
        let source = |source| match source {
            EndSource::Extreme => "extreme",
            EndSource::Mask => "mask",
            EndSource::Image => "image",
            EndSource::Border => "border",
            EndSource::Points => "points",
        };
        Self {
            center: extent.center.into(),
            length: extent.length,
            start: extent.start.into(),
            end: extent.end.into(),
            start_state: state(extent.start_state),
            end_state: state(extent.end_state),
            start_source: source(extent.start_source),
            end_source: source(extent.end_source),
            start_view: extent.start_view,
            end_view: extent.end_view,
            start_deviation: extent.start_deviation,
            end_deviation: extent.end_deviation,
            length_deviation: extent.uncertainty.map(|uncertainty| uncertainty.length),
            start_covariance: extent.uncertainty.map(|uncertainty| uncertainty.start.into()),
            end_covariance: extent.uncertainty.map(|uncertainty| uncertainty.end.into()),
            center_covariance: extent.uncertainty.map(|uncertainty| uncertainty.center.into()),
        }
    }
}
