//! The limbs of a first fit, located in the image for a second one.

use super::Fitter;
use super::options::{EdgeUse, Method, ObjectiveKind, Options};
use super::problem::Problem;
use super::solve::ENDPOINT_PIXELS;
use crate::geometry::Cylinder;
use crate::limb_location::{LimbSearch, axial_range, locate_limbs};
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

    /// The limb lines that the image shows near those of a fit to given segments, each weighed by its own standard
    /// deviation. A limb that is not seen is left to the given segment.
    pub(super) fn locate(&self, problem: &Problem<'_>, cylinder: &Cylinder) -> Vec<PixelSegment> {
        let (Some(image), Some(camera)) = (&self.image, &self.camera) else { return Vec::new() };
        if problem.pixels.is_none() || self.options.edge_use == EdgeUse::AsGiven {
            return Vec::new();
        }
        let endpoints = self.segments.iter().flat_map(|segment| segment.endpoints);
        let Some(range) = axial_range(camera, cylinder, endpoints, 0.0) else { return Vec::new() };
        let search = LimbSearch { range, reach: [REACH_PIXELS; 2], deviation: [DEVIATION_PIXELS; 2] };
        let located = locate_limbs(image, camera, cylinder, &search);
        located
            .iter()
            .filter_map(|limb| limb.line.as_ref().ok())
            .map(|line| PixelSegment { endpoints: line.ends, weight: (ENDPOINT_PIXELS / line.sigma).powi(2) })
            .collect()
    }
}
