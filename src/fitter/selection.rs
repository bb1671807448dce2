//! Which detected edges lie on the limbs of a rough fit.

use super::Fitter;
use crate::error::{Error, Result, not_negative};
use crate::geometry::Cylinder;
use crate::limb_location::edges_on_limbs;
use crate::observations::{EdgeSegment, check_segments};
use crate::statistics::at_both_ends;

/// The part of the points at either end of the axis that does not tell how far the surface reaches: stray points.
const STRAY: f64 = 0.01;

impl Fitter {
    /// Selects, of straight edges that a line detector found in the (distorted) image, those on the two limbs of a
    /// rough cylinder beside the points that were pushed, such as a fit to these points alone: indices of the pieces
    /// of either limb. For each limb the edge with the longest pieces wins, the nearer the limb the better, if they
    /// cover 30 % of it. `model` stands in for the last fit; `reach` is how far a limb may be from that of the model
    /// in pixels, 0 for 15 % of the distance of the limbs, at least 4.
    ///
    /// # Errors
    /// `InvalidArgument` for a bad segment or reach, `BadState` without intrinsics, points or a model, `EdgeGeometry`
    /// when no limbs can be seen.
    pub fn select_edges(
        &self,
        segments: &[EdgeSegment],
        model: Option<&Cylinder>,
        reach: f64,
    ) -> Result<[Vec<usize>; 2]> {
        const CALL: &str = "selecting edges";
        check_segments(segments)?;
        not_negative("reach", reach)?;
        let cylinder = self.view().seen(&self.model_or_result(CALL, model)?);
        let missing = |missing, remedy| Error::BadState { call: CALL, missing, remedy };
        let camera = self.camera().ok_or_else(|| missing("intrinsics", "set the intrinsics first"))?;
        let axis = &cylinder.axis;
        let positions: Vec<f64> = self.cloud().points().map(|p| axis.position_of(&p)).collect();
        if positions.is_empty() {
            return Err(missing("points", "push points or a depth image first"));
        }
        let stray = (STRAY * (positions.len() - 1) as f64) as usize;
        let range = at_both_ends(&positions, stray);
        let reach = (reach > 0.0).then_some(reach);
        let noise = self.options().noise.in_image(camera.size());
        edges_on_limbs(segments, camera, &cylinder, &range, reach, &noise).ok_or_else(|| {
            Error::EdgeGeometry {
                reason: "the camera is inside the cylinder or a limb cannot be seen".into(),
                remedy: "give a cylinder in front of the camera",
            }
        })
    }
}
