//! The finite extent of the visible cylinder (the paper's section 4.5.2) and what its ends look like.

use crate::camera::Camera;
use crate::completion::Region;
use crate::error::{Error, Result};
use crate::fitter::Fitter;
use crate::geometry::{Cylinder, any_orthogonal};
use crate::observations::{DepthImage, Mask, MaskView};
use nalgebra::Vector3;

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

/// The visible piece of the cylinder: `end` = `start` + `length` · direction of the model.
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
}

/// How far beyond an end its surroundings are looked at, in pixels: past the reach of a mask that is off by a
/// pixel or two and of depth that a matching window carries over the edge, yet still beside the end.
const BEYOND_PIXELS: [f64; 4] = [4.0, 6.0, 8.0, 10.0];

/// Lines along the surface on which the surroundings of an end are looked at.
const GENERATORS: usize = 15;

/// The part of the visible arc that these lines cover: near the limbs depth is worst.
const ARC_PART: f64 = 0.7;

impl Fitter {
    /// The extreme positions along the axis of the points completed over a mask. `model` and `mask` stand in
    /// for the last fit and the mask of the last depth image, which also tells what the ends are.
    ///
    /// # Errors
    /// `BadState` without a model, intrinsics or mask; `SizeMismatch`, `EmptyMask`; `EdgeGeometry` when no ray of
    /// the mask meets the cylinder.
    pub fn extent(&self, model: Option<&Cylinder>, mask: Option<&MaskView<'_>>) -> Result<Extent> {
        let cylinder = self.model_or_result("finding the extent", model)?;
        let region = Region::new("finding the extent", self, mask)?;
        let axis = cylinder.axis;
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        self.complete(model, mask, &mut |_, _, point| {
            if let Some(point) = point {
                let position = (point - axis.point).dot(&axis.direction);
                low = low.min(position);
                high = high.max(position);
            }
        })?;
        if !(low.is_finite() && high.is_finite()) {
            return Err(Error::EdgeGeometry {
                reason: "no ray of the mask meets the cylinder".into(),
                remedy: "check that mask and model belong to the same image",
            });
        }
        let surroundings = Surroundings {
            camera: region.camera,
            mask: region.mask(),
            depth: self.depth(),
            cylinder: &cylinder,
            tolerance: 3.0 * self.result().map_or(0.0, |result| result.point_rms),
        };
        let at = |position: f64| axis.point + axis.direction * position;
        Ok(Extent {
            center: at(0.5 * (low + high)),
            length: high - low,
            start: at(low),
            end: at(high),
            start_state: surroundings.state(&at(low), &-axis.direction),
            end_state: surroundings.state(&at(high), &axis.direction),
        })
    }
}

/// What is looked at beyond an end.
struct Surroundings<'a> {
    camera: &'a Camera,
    mask: &'a Mask,
    depth: Option<&'a DepthImage>,
    cylinder: &'a Cylinder,
    /// Depth differences up to this are noise.
    tolerance: f64,
}

impl Surroundings<'_> {
    /// Continues the surface beyond the axis point `end` in the direction `outward` and lets what is seen there
    /// vote.
    fn state(&self, end: &Vector3<f64>, outward: &Vector3<f64>) -> EndState {
        let (mut cut, mut hidden, mut seen, mut unknown) = (0, 0, 0, 0);
        for rim in self.rim(end) {
            let Some(at_rim) = self.camera.project(&rim) else {
                cut += 1;
                continue;
            };
            // Length along the axis of one pixel, by a step of 1 % of the radius.
            let step = 0.01 * self.cylinder.radius;
            let Some(ahead) = self.camera.project(&(rim + outward * step)) else {
                cut += 1;
                continue;
            };
            let pixel = step / (ahead - at_rim).norm().max(1e-6);
            for beyond in BEYOND_PIXELS {
                let point = rim + outward * (pixel * beyond);
                let Some(at) = self.camera.project(&point).filter(|at| self.camera.contains(at)) else {
                    cut += 1;
                    continue;
                };
                let (column, row) = (at.x.round() as usize, at.y.round() as usize);
                if self.mask.contains(column, row) {
                    continue;
                }
                match self.depth.and_then(|depth| depth.depth(column, row)) {
                    None => unknown += 1,
                    Some(z) if z < point.z - self.tolerance => hidden += 1,
                    Some(_) => seen += 1,
                }
            }
        }
        let most = cut.max(hidden).max(seen).max(unknown);
        match most {
            0 => EndState::Unknown,
            _ if most == cut => EndState::Cut,
            _ if most == seen => EndState::Seen,
            _ if most == hidden => EndState::Hidden,
            _ => EndState::Unknown,
        }
    }

    /// Points of the visible arc of the surface around an axis point.
    fn rim(&self, end: &Vector3<f64>) -> impl Iterator<Item = Vector3<f64>> {
        let Cylinder { axis, radius } = *self.cylinder;
        let across = end - axis.direction * end.dot(&axis.direction);
        let distance = across.norm();
        let inside = self.cylinder.contains_origin();
        let toward = if distance > 0.0 { -across / distance } else { any_orthogonal(&axis.direction).0 };
        let sideways = axis.direction.cross(&toward);
        // From outside the surface is visible up to the limbs, at acos(r / ‖c‖) from the line of sight; from
        // inside all of it.
        let half_arc = if inside { std::f64::consts::PI } else { (radius / distance).acos() } * ARC_PART;
        let end = *end;
        (0..GENERATORS).map(move |k| {
            let angle = half_arc * (2.0 * k as f64 / (GENERATORS - 1) as f64 - 1.0);
            end + (toward * angle.cos() + sideways * angle.sin()) * radius
        })
    }
}
