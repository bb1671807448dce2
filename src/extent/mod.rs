//! The finite extent of the visible cylinder (the paper's section 4.5.2) and what its ends look like.
//!
//! The paper takes the extreme points completed over the mask, so that one stray pixel of the mask moves an end.
//! Here an end is located from all generators (lines of the surface along the axis) together, in three steps:
//!
//! 1. in the mask: where each generator leaves it, robustly averaged, and freed of the mask's bias, which shows
//!    at the limbs (`silhouette`);
//! 2. in the depth image: what lies beyond, from which the state of the end follows (`surroundings`);
//! 3. in the grey image: the arc of the end circle that bounds the visible surface (`arc`).

mod arc;
mod border;
mod silhouette;
mod surface;
mod surroundings;

#[cfg(test)]
mod scene;
#[cfg(test)]
mod tests;

use crate::completion::Region;
use crate::error::{Error, Result};
use crate::fitter::{Fitter, Method, ObjectiveKind, Options};
use crate::geometry::Cylinder;
use crate::observations::{GreyImage, MaskView};
pub use arc::ArcSample;
use nalgebra::{Vector2, Vector3};
use silhouette::Silhouette;
use surface::Surface;
use surroundings::Surroundings;

/// What an end of the visible cylinder is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EndState {
    /// The surface ends there: what lies beyond is farther than the surface would be.
    Seen,
    /// The border of the image cuts the cylinder off.
    Cut,
    /// Something nearer than the surface covers what lies beyond.
    Hidden,
    /// No depth was measured beyond the end.
    Unknown,
}

/// What the position of an end was taken from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EndSource {
    /// The extreme point completed over the mask.
    Extreme,
    /// Where the generators leave the mask.
    Mask,
    /// The arc of the end circle in the grey image.
    Image,
    /// The last of the surface inside the border of the image.
    Border,
}

/// How the ends are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ExtentRule {
    /// The paper's rule: the extreme positions along the axis of the points completed over the mask.
    Extremes,
    /// From all generators together, in the mask and, when there is one, in the grey image. From inside a pipe,
    /// which shows no end circle, the paper's rule.
    #[default]
    Located,
}

impl ExtentRule {
    /// The rule that goes with the settings of a fit: the paper's for its objective and its baselines.
    #[must_use]
    pub fn of(options: &Options) -> Self {
        match (options.method, options.objective) {
            (Method::Fused, ObjectiveKind::Robust) => Self::Located,
            _ => Self::Extremes,
        }
    }
}

/// The settings of the extent.
#[derive(Debug, Clone, Copy, Default)]
pub struct ExtentOptions<'a> {
    /// How the ends are found.
    pub rule: ExtentRule,
    /// The grey image, on the grid of the mask.
    pub image: Option<&'a GreyImage>,
    /// Whether the limbs of the model are good to a fraction of a pixel, so that the bias of the mask may be
    /// read off at them. `None`: when the last fit used edge segments.
    pub limbs_known: Option<bool>,
}

/// The visible piece of the cylinder: `end` = `start` + `length` · direction of the model. Lengths are in the
/// unit of the data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// c₀, the middle of the ends.
    pub center: Vector3<f64>,
    /// l_c, the distance of the ends.
    pub length: f64,
    /// The end against the direction.
    pub start: Vector3<f64>,
    /// The end along the direction.
    pub end: Vector3<f64>,
    /// What the start is.
    pub start_state: EndState,
    /// What the end is.
    pub end_state: EndState,
    /// What the position of the start was taken from.
    pub start_source: EndSource,
    /// What the position of the end was taken from.
    pub end_source: EndSource,
    /// Standard deviation of the position of the start along the axis, for a model without error; `None` for an
    /// extreme.
    pub start_deviation: Option<f64>,
    /// The same for the end.
    pub end_deviation: Option<f64>,
}

/// An end as it was found.
#[derive(Debug, Clone)]
struct End {
    /// Position along the axis, from the axis point of the model.
    position: f64,
    deviation: Option<f64>,
    state: EndState,
    source: EndSource,
    samples: Vec<ArcSample>,
}

impl Fitter {
    /// The extent by the rule that goes with the method ([`ExtentRule::of`]), in the image that was pushed. See
    /// [`Fitter::extent_with`].
    ///
    /// # Errors
    /// Those of [`Fitter::extent_with`].
    pub fn extent(&self, model: Option<&Cylinder>, mask: Option<&MaskView<'_>>) -> Result<Extent> {
        let rule = ExtentRule::of(self.options());
        let options = ExtentOptions { rule, image: self.image(), limbs_known: None };
        self.extent_with(model, mask, &options)
    }

    /// The ends of the visible cylinder. `model` and `mask` stand in for the last fit and the mask of the last
    /// depth image, which also tells what the ends are.
    ///
    /// # Errors
    /// `BadState` without a model, intrinsics or mask; `SizeMismatch`, `EmptyMask`; `EdgeGeometry` when no ray of
    /// the mask meets the cylinder.
    pub fn extent_with(
        &self,
        model: Option<&Cylinder>,
        mask: Option<&MaskView<'_>>,
        options: &ExtentOptions<'_>,
    ) -> Result<Extent> {
        Ok(self.extent_and_arcs(model, mask, options)?.0)
    }

    /// The same, and the places of the arcs of start and end in the grey image, which also know the tilt of the
    /// axis. They are empty for an end that the image did not show.
    ///
    /// # Errors
    /// Those of [`Fitter::extent_with`].
    pub fn extent_and_arcs(
        &self,
        model: Option<&Cylinder>,
        mask: Option<&MaskView<'_>>,
        options: &ExtentOptions<'_>,
    ) -> Result<(Extent, [Vec<ArcSample>; 2])> {
        let cylinder = self.model_or_result("finding the extent", model)?;
        let region = Region::new("finding the extent", self, mask)?;
        if let Some(image) = options.image {
            region.mask().check_size("grey image", (image.width(), image.height()))?;
        }
        let surface = match options.rule {
            ExtentRule::Extremes => None,
            ExtentRule::Located => Surface::new(region.camera, &cylinder),
        };
        // Generators are only followed between the extremes, so that they need not be exact.
        let stride = if surface.is_some() { BOUNDS_STRIDE } else { 1 };
        let extremes = extremes(&region, &cylinder, stride)?;
        // A single pixel has no generators to follow.
        let surface = surface.filter(|_| extremes.0 < extremes.1);
        let surroundings = Surroundings {
            camera: region.camera,
            mask: region.mask(),
            depth: self.depth(),
            cylinder: &cylinder,
            tolerance: self.depth_tolerance(&cylinder),
        };
        let limbs_known = options
            .limbs_known
            .unwrap_or_else(|| self.result().is_some_and(|result| result.segments_used > 0));
        let ends = match &surface {
            None => [(extremes.0, -1.0), (extremes.1, 1.0)].map(|(position, outward)| End {
                position,
                deviation: None,
                state: surroundings.state(position, outward),
                source: EndSource::Extreme,
                samples: Vec::new(),
            }),
            Some(surface) => {
                let silhouette = Silhouette::new(surface, region.mask(), extremes, limbs_known);
                [-1.0, 1.0].map(|outward| locate(&silhouette, &surroundings, options.image, outward))
            }
        };
        let [start, end] = ends;
        let at = |position: f64| cylinder.axis.point + cylinder.axis.direction * position;
        let extent = Extent {
            center: at(0.5 * (start.position + end.position)),
            length: end.position - start.position,
            start: at(start.position),
            end: at(end.position),
            start_state: start.state,
            end_state: end.state,
            start_source: start.source,
            end_source: end.source,
            start_deviation: start.deviation,
            end_deviation: end.deviation,
        };
        Ok((extent, [start.samples, end.samples]))
    }

    /// The depth differences that are noise about a model: three standard deviations, from the median so that
    /// background among the points does not count.
    fn depth_tolerance(&self, cylinder: &Cylinder) -> f64 {
        let stride = self.cloud().len() / TOLERANCE_POINTS + 1;
        let mut distances: Vec<f64> =
            self.cloud().points().step_by(stride).map(|point| cylinder.distance(&point).abs()).collect();
        let middle = distances.len() / 2;
        let median = match distances.is_empty() {
            true => 0.0,
            false => *distances.select_nth_unstable_by(middle, f64::total_cmp).1,
        };
        (3.0 * 1.4826 * median).max(LEAST_TOLERANCE * cylinder.radius)
    }
}

/// Rows and columns of the mask from one to the next that bound the search for the ends.
const BOUNDS_STRIDE: usize = 2;

/// About how many points tell the noise of the depth.
const TOLERANCE_POINTS: usize = 2000;

/// A step of this part of the radius is a bead or a lid, not something in front of the cylinder.
const LEAST_TOLERANCE: f64 = 0.1;

/// The least and the greatest position along the axis of the points completed over every `stride`-th row and
/// column of the mask.
fn extremes(region: &Region<'_>, cylinder: &Cylinder, stride: usize) -> Result<(f64, f64)> {
    let (mask, axis) = (region.mask(), cylinder.axis);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for row in (0..mask.height()).step_by(stride) {
        for column in (0..mask.width()).step_by(stride).filter(|&column| mask.contains(column, row)) {
            let ray = region.camera.unproject(&Vector2::new(column as f64, row as f64));
            if let Some(point) = ray.and_then(|ray| cylinder.first_hit(&ray)) {
                let position = (point - axis.point).dot(&axis.direction);
                low = low.min(position);
                high = high.max(position);
            }
        }
    }
    if low < high {
        return Ok((low, high));
    }
    if stride > 1 {
        return extremes(region, cylinder, 1);
    }
    if low.is_finite() {
        return Ok((low, high));
    }
    Err(Error::EdgeGeometry {
        reason: "no ray of the mask meets the cylinder".into(),
        remedy: "check that mask and model belong to the same image",
    })
}

/// Locates the end on the side of `outward` (± 1, along the axis direction).
fn locate(
    silhouette: &Silhouette<'_>,
    surroundings: &Surroundings<'_>,
    image: Option<&GreyImage>,
    outward: f64,
) -> End {
    let Some(rough) = silhouette.end(surroundings, outward) else {
        let position = silhouette.extreme(outward);
        let state = surroundings.state(position, outward);
        return End { position, deviation: None, state, source: EndSource::Extreme, samples: Vec::new() };
    };
    let state = surroundings.state(rough.position, outward);
    let cut = (state == EndState::Cut).then(|| border::last_inside(silhouette, outward)).flatten();
    if let Some(position) = cut {
        // The last pixel lies within a pixel of the border.
        let deviation = Some(rough.pixel);
        return End { position, deviation, state, source: EndSource::Border, samples: Vec::new() };
    }
    let arc = image
        .filter(|_| state != EndState::Hidden)
        .and_then(|image| arc::locate(silhouette.surface(), silhouette.mask(), image, &rough, outward));
    match arc {
        Some(arc) => End {
            position: arc.position,
            deviation: Some(arc.deviation),
            state,
            source: EndSource::Image,
            samples: arc.samples,
        },
        None => End {
            position: rough.position,
            deviation: Some(rough.deviation),
            state,
            source: EndSource::Mask,
            samples: Vec::new(),
        },
    }
}
