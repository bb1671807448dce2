//! Points next to something in front that covers one side of the body.
//!
//! Matching windows and filters mix the depth on both sides of an edge. Next to a limb that is seen a fit allows for it. What covers
//! a limb bends the surface that is left towards itself, all along the axis alike. Where only a part of a surface is seen, that changes
//! the radius: rods that touch and are half hidden came out more than twice as wide. So the points next to it have no part in the fit.

use super::view::View;
use crate::geometry::Line;
use crate::limb_location::{Outline, may_be_covered};
use crate::memory::List;
use crate::noise::NoiseModel;
use crate::observations::pixel_at;
use nalgebra::{Matrix3, Vector3};

/// Pixels of the depth beside the edge of what is in front that are left out: half of a window of 5, a small one. Measured:
/// docs/measurements-neighbours.md, "Depth beside what covers a side".
const MIXED: f64 = 2.0;

/// Before a fit the axis is known where the points spread along it so many times as far as across it at least.
const ELONGATED: f64 = 1.5;

/// At least this part of the points is left: of a strip that is all next to what is in front nothing else is known.
const LEAST: f64 = 0.5;

impl View {
    /// The view without its points next to something in front that covers one side of the body; `None` where there are none.
    pub fn without_points_beside_cover(&self, noise: &NoiseModel) -> Option<Self> {
        // A region of a detector ends where the surface does, and so do points.
        if self.is_body || self.mask_of_points {
            return None;
        }
        let (camera, depth, mask) = (self.camera()?, self.depth()?, self.body()?);
        let noise = noise.in_image(camera.size());
        let axis = axis_of(self.mean_and_covariance()?)?;
        if !may_be_covered(mask, depth, &noise) {
            return None;
        }
        let covered = Outline::new(mask, Some(depth), camera, &noise)?.covered_side(camera, &axis);
        if covered.is_empty() {
            return None;
        }
        let (width, height) = (mask.width(), mask.height());
        let mut mixed = List::filled(false, width * height);
        // The pixel at the edge is one of them.
        let reach = (MIXED * depth.pixel() - 1.0).round().max(0.0) as usize;
        for (x, y) in covered {
            for row in y.saturating_sub(reach)..=(y + reach).min(height - 1) {
                let columns = x.saturating_sub(reach)..=(x + reach).min(width - 1);
                mixed[row * width..][columns].fill(true);
            }
        }
        let is_clear = |index: usize| {
            let pixel = camera.project(&self.cloud.point(index)).and_then(|q| pixel_at(&q));
            !pixel.is_some_and(|(x, y)| x < width && y < height && mixed[y * width + x])
        };
        let cloud = self.cloud.chosen(is_clear);
        let left = cloud.len() as f64 / self.cloud.len() as f64;
        (LEAST..1.0).contains(&left).then(|| self.with_points(cloud, self.body.clone()))
    }
}

/// The line along which points of some mean and covariance spread; `None` where they spread as far across it, or not at all.
fn axis_of((mean, covariance): (Vector3<f64>, Matrix3<f64>)) -> Option<Line> {
    let principal = covariance.symmetric_eigen();
    let longest = principal.eigenvalues.imax();
    let across =
        (0..3).filter(|&k| k != longest).map(|k| principal.eigenvalues[k]).fold(0.0, f64::max).sqrt();
    let is_long = across > 0.0 && principal.eigenvalues[longest].sqrt() >= ELONGATED * across;
    is_long.then(|| Line::new(mean, principal.eigenvectors.column(longest).into_owned()))
}
