//! Whether the radius changes along the axis: a body that tapers is no cylinder.

use super::Fitter;
use crate::detection::slope_by_points;

/// Points farther from the surface than this many standard deviations do not count.
const REACH: f64 = 3.0;

impl Fitter {
    /// By how much the radius grows along the axis of the last fit, and the standard deviation of that, by the points of the selected
    /// view and both limbs in its image; `None` where one of them was not located, and for a cylinder that was kept and not
    /// fitted. Two lines tell it far better than depth does. One that the fit refused counts, too: the limbs of a body that
    /// tapers contradict every cylinder.
    pub(crate) fn slope_by_limbs(&self) -> Option<[f64; 2]> {
        let result = self.result.as_ref().filter(|result| result.termination.is_some())?;
        let (camera, view) = (self.camera()?, self.view());
        let cylinder = view.pose().inverse().cylinder(&result.cylinder);
        let [Ok(a), Ok(b)] = self.limbs()?.each_ref().map(|limb| limb.line) else { return None };
        let intrinsics = camera.intrinsics();
        let pixel = 0.5 * (1.0 / intrinsics.fx + 1.0 / intrinsics.fy);
        let mut ends = Vec::with_capacity(4);
        for line in [a, b] {
            for end in &line.ends {
                let ray = camera.ideal_ray(end);
                let t = cylinder.axis.nearest_on_ray(&ray);
                // A line may be said by an end beyond the vanishing point of the axis.
                if !(t > 0.0) {
                    return None;
                }
                let p = ray * t;
                ends.push((p, (line.sigma * pixel * p.z).powi(-2)));
            }
        }
        let scale = result.point_scale;
        let weight = result.independent_points / (result.points_used as f64 * scale * scale);
        let points = view.cloud.points().filter_map(|p| {
            let part = 1.0 - (cylinder.distance(&p) / (REACH * scale)).powi(2);
            (part > 0.0).then_some((p, weight * part * part))
        });
        slope_by_points(&cylinder, points.chain(ends))
    }
}
