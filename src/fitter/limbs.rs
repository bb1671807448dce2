//! The limbs of a first fit, located in the image for a second one.

use super::Fitter;
use super::options::{EdgeUse, Method, ObjectiveKind, Options};
use super::problem::Problem;
use super::solve::ENDPOINT_PIXELS;
use crate::geometry::Cylinder;
use crate::limb_location::{LimbObservation, LimbSearch, axial_range, locate_limbs};
use crate::residuals::PixelSegment;

/// How far a limb may be from that of a fit to hand-set segments at most, and its standard deviation, in pixels.
const REACH_PIXELS: f64 = 4.0;
const DEVIATION_PIXELS: f64 = 1.0;

impl Fitter {
    /// Whether the fit looks at the image.
    pub(super) fn locates(&self) -> bool {
        let Options { method, objective, .. } = self.options();
        self.image.is_some() && *method == Method::Fused && *objective == ObjectiveKind::Robust
    }

    /// What the image shows of the limbs near those of a fit to given segments; `None` when it is not to be searched.
    pub(super) fn observe(&self, problem: &Problem<'_>, cylinder: &Cylinder) -> Option<[LimbObservation; 2]> {
        let (image, camera) = (self.image.as_ref()?, self.camera.as_ref()?);
        if problem.pixels.is_none() || self.options.edge_use == EdgeUse::AsGiven {
            return None;
        }
        let endpoints = self.segments.iter().flat_map(|segment| segment.endpoints);
        let range = axial_range(camera, cylinder, endpoints, 0.0)?;
        let search = LimbSearch { range, reach: [REACH_PIXELS; 2], deviation: [DEVIATION_PIXELS; 2] };
        Some(locate_limbs(image, camera, cylinder, &search))
    }
}

/// The lines that were located, each weighed by its own standard deviation. A limb that is not seen is left to the
/// given segment.
pub(super) fn located_lines(observations: &[LimbObservation; 2]) -> Vec<PixelSegment> {
    observations
        .iter()
        .filter_map(|limb| limb.line.as_ref().ok())
        .map(|line| PixelSegment { endpoints: line.ends, weight: (ENDPOINT_PIXELS / line.sigma).powi(2) })
        .collect()
}
