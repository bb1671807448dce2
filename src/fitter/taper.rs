//! Whether the radius changes along the axis: a body that tapers is no cylinder, and a line that turns against the other
//! limb may be none.

use super::data::Data;
use super::located::{Lines, Observations};
use super::objective::Minimum;
use super::scales::Scales;
use crate::detection::slope_by_points;
use crate::geometry::Cylinder;
use crate::limb_location::LimbObservation;
use crate::residuals::RobustScales;

/// Points that tell how the axis lies to the limbs: their noise is correlated, so that more hardly tell more.
const SAMPLE: usize = 500;

/// Points farther from the surface than this many standard deviations do not count.
const REACH: f64 = 3.0;

/// By how much the limbs of a cylinder turn against each other as a slope of its radius, beyond their stated deviations:
/// by a third of a pixel over a hundred, as distortion of the lens does that is not modelled.
const USUAL_TURN: f64 = 0.003;

/// A body tapers when the slope of its radius is more than this many standard deviations: of 374 cylinders whose limbs were
/// located three are beyond, two of which have a radius that is off by 4 and 5 %.
const TAPERS: f64 = 3.0;

/// By how much the radius grows along the axis, as two limbs that turn against each other tell it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Taper {
    /// The growth of the radius by a unit of length in the direction of the axis.
    pub slope: f64,
    /// Its standard deviation, for the stated deviations of the limbs and the noise of the points.
    pub deviation: f64,
}

impl Taper {
    /// By how much the deviations of the limbs are too small for their turn to be one standard deviation (the ratio of Birge);
    /// 1 where they are large enough.
    fn turn(self) -> f64 {
        f64::max(1.0, (self.slope / self.deviation).abs())
    }

    /// Whether it is more than noise and what is usual.
    #[must_use]
    pub fn is_wrong(self) -> bool {
        self.slope.abs() > TAPERS * self.deviation.hypot(USUAL_TURN)
    }
}

impl Data<'_> {
    /// The taper of a cylinder by both limbs in the image of a single view, which tell it far better than depth does, and
    /// points, which tell how the axis lies to them; `None` where a limb has no line. A limb that the fit refused
    /// counts, too: the limbs of a body that tapers contradict every cylinder.
    pub fn taper(&self, limbs: &[LimbObservation; 2], cylinder: &Cylinder, scales: &Scales) -> Option<Taper> {
        let [view] = &self.views[..] else { return None };
        let (camera, cylinder) = (view.camera()?, view.seen(cylinder));
        let pixel = camera.pixel_size();
        let ends_of = |limb: &LimbObservation| {
            let line = limb.line.as_ref().ok()?;
            let end = |q| {
                let ray = camera.ideal_ray(q);
                let t = cylinder.axis.nearest_on_ray(&ray);
                // A line may be said by an end beyond the vanishing point of the axis.
                (t > 0.0).then(|| (ray * t, (line.sigma * pixel * t * ray.z).powi(-2)))
            };
            Some([end(&line.ends[0])?, end(&line.ends[1])?])
        };
        let ends = [ends_of(&limbs[0])?, ends_of(&limbs[1])?];
        let RobustScales { point: scale, independent_points } = scales.views[0];
        let sample = view.view.cloud.sampled(SAMPLE);
        let weight = independent_points / (sample.len() as f64 * scale * scale);
        let ends = ends.into_iter().flatten();
        let [slope, deviation] = slope_by_points(&cylinder, sample, (weight, REACH * scale), ends)?;
        Some(Taper { slope, deviation })
    }

    /// Whether the lines of a single view turn against each other by more than noise and what is usual.
    pub fn lines_turn(&self, observations: &Observations, minimum: &Minimum) -> bool {
        let [Some(seen)] = &observations[..] else { return false };
        self.taper(&seen.limbs, minimum.cylinder(), &minimum.scales).is_some_and(Taper::is_wrong)
    }

    /// Weighs the lines of a single view less where they turn against each other by more than their stated deviations: either
    /// body or lines are not what a cylinder shows. Says whether there was anything to do. A detector judges by the taper
    /// itself whether there is a cylinder, and by how certain the radius is: the turn would count twice.
    pub fn loosen(
        &self,
        lines: &mut [Lines],
        observations: &Observations,
        cylinder: &Cylinder,
        scales: &Scales,
    ) -> bool {
        let ([lines], [Some(seen)]) = (lines, &observations[..]) else { return false };
        if self.views[0].view.is_body {
            return false;
        }
        let turn = self.taper(&seen.limbs, cylinder, scales).map_or(1.0, Taper::turn);
        lines.iter_mut().flatten().for_each(|line| line.weight /= turn * turn);
        turn > 1.0
    }
}
