//! Whether the radius changes along the axis: a body that tapers is no cylinder, and a line that turns against the other
//! limb may be none.

use super::data::Data;
use super::located::{Lines, Observations};
use super::objective::Minimum;
use super::scales::Scales;
use crate::detection::slope_by_points;
use crate::geometry::{Cylinder, LocalFrame, Tangent, TangentMap};
use crate::limb_location::LimbObservation;
use crate::memory::List;
use crate::residuals::{PointRows, RobustScales, TUKEY_EFFICIENT};
use nalgebra::Vector3;

/// Points that tell how the axis lies to the limbs: their noise is correlated, so that more hardly tell more.
const SAMPLE: usize = 500;

/// The same where points alone tell the taper, most of whose errors may be their own.
const SAMPLE_ALONE: usize = 5000;

/// Points farther from the surface than this many standard deviations do not count.
const REACH: f64 = 3.0;

/// By how much the limbs of a cylinder turn against each other as a slope of its radius, beyond their stated deviations:
/// by a third of a pixel over a hundred, as distortion of the lens does that is not modelled.
const USUAL_TURN: f64 = 0.003;

/// A body tapers when the slope of its radius is more than this many standard deviations: of 374 cylinders whose limbs were
/// located three are beyond, two of which have a radius that is off by 4 and 5 %.
const TAPERS: f64 = 3.0;

/// By how much the radius grows along the axis, as two limbs that turn against each other tell it, or points that no camera saw.
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

/// The step that points within `reach` of a cylinder ask for where its radius grows by one along the axis: −A⁻¹ Σ J ∂e/∂k of
/// e = R − r − k h with the coordinate h along the axis.
fn step_beside_taper(
    frame: &LocalFrame,
    points: impl Iterator<Item = Vector3<f64>>,
    reach: f64,
) -> Option<Tangent> {
    let LocalFrame { cylinder: Cylinder { axis, .. }, unit, .. } = *frame;
    let rows = PointRows::new(frame);
    let (mut normal, mut right) = (TangentMap::zeros(), Tangent::zeros());
    for point in points {
        let (distance, jacobian, _) = rows.row(&point);
        if distance.abs() * unit <= reach {
            let along = (point - axis.point).dot(&axis.direction) / unit;
            normal.ger(1.0, &jacobian, &jacobian, 1.0);
            right += jacobian * along;
        }
    }
    Some(normal.cholesky()?.solve(&right))
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

    /// The taper of a cylinder by the points of a single view alone that no camera saw, and the step from the cylinder to that of the
    /// same points beside which the radius grows so: points on one side of a body that tapers tilt its axis. `None` where it is not
    /// more than noise. Depth of a camera is bent by more.
    pub fn taper_of_points(&self, frame: &LocalFrame, scales: &Scales) -> Option<(Taper, Tangent)> {
        let [view] = &self.views[..] else { return None };
        if view.observed || !self.is_robust() {
            return None;
        }
        let near = &frame.moved(&view.into_view);
        let RobustScales { point: scale, independent_points } = scales.views[0];
        let reach = TUKEY_EFFICIENT * scale;
        let sample = || view.view.cloud.sampled(SAMPLE_ALONE);
        let count = sample().len() as f64;
        let taper = |independent: f64| {
            let weight = independent.min(count) / (count * scale * scale);
            let nothing = std::iter::empty();
            let [slope, deviation] = slope_by_points(&near.cylinder, sample(), (weight, reach), nothing)?;
            Some(Taper { slope, deviation }).filter(|taper| slope.abs() > TAPERS * taper.deviation)
        };
        // What the taper leaves beside a cylinder passes for noise that neighbours share.
        let Taper { slope, .. } = taper(count)?;
        let step = step_beside_taper(near, sample(), reach)? * slope;
        let rows = PointRows::new(near);
        let beside = |point: Vector3<f64>| {
            let along = (point - near.cylinder.axis.point).dot(&near.cylinder.axis.direction) / near.unit;
            let (distance, jacobian, _) = rows.row(&point);
            (distance + jacobian.dot(&step) - slope * along) * near.unit
        };
        let residuals: List<f64> = view.neighbours.cloud(view).points().map(beside).collect();
        let alone = view.neighbours.independent_points(view, near, &residuals, reach);
        Some((taper(alone.max(independent_points))?, step))
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

#[cfg(test)]
mod tests {
    use crate::fitter::{FitResult, Fitter, Flags};
    use crate::observations::PointsView;
    use crate::statistics::random_number as number;
    use nalgebra::Vector3;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    /// The fit to 5,000 points of one side of a body about z, 10 radii long, whose radius grows by `slope` along it, with noise of a
    /// hundredth of it.
    fn fit(seed: u64, degrees: f64, slope: f64) -> FitResult {
        let rng = &mut ChaCha8Rng::seed_from_u64(seed);
        let point = |_| {
            let (angle, along) = (f64::to_radians(degrees / 2.0) * number(rng), 5.0 * number(rng));
            let radius = 1.0 + slope * along + 0.01 * 3.0_f64.sqrt() * number(rng);
            [3.0 + radius * angle.cos(), 2.0 + radius * angle.sin(), 1.0 + along]
        };
        let points: Vec<[f64; 3]> = (0..5000).map(point).collect();
        let mut fitter = Fitter::new();
        fitter.push_points(&PointsView::from_f64(&points), None).unwrap();
        fitter.fit().unwrap()
    }

    /// The axis of the second one was off by 0.7 degrees and stated to 0.05.
    #[test]
    fn points_on_one_side_of_a_body_that_tapers_say_how_far_its_axis_may_tilt() {
        for (degrees, slope) in [(100.0, 0.005), (150.0, 0.01), (180.0, 0.02)] {
            for seed in 0..3 {
                let fit = fit(seed, degrees, slope);
                let stated = fit.uncertainty.unwrap().direction();
                let off = fit.cylinder.axis.direction.angle(&Vector3::z());
                assert!(off < 3.0 * stated && stated < 3.0 * off, "{degrees}° {slope}: {off} {stated}");
                // The robust loss takes the ends, where a cylinder is most wrong, for outliers in part.
                let told = fit.taper.unwrap().slope;
                assert!((told / slope - 1.0).abs() < 0.2, "{degrees}° {slope}: {told}");
                // At a hundredth either may be said.
                let is_told = fit.flags.contains(Flags::BODY_TAPERS);
                assert!(slope == 0.01 || is_told == (slope > 0.01), "{degrees}° {slope}: {is_told}");
            }
        }
    }

    #[test]
    fn points_of_a_cylinder_tell_no_taper() {
        let told = (0..40).filter(|&seed| fit(seed, 120.0, 0.0).taper.is_some()).count();
        assert!(told <= 1, "{told}");
    }
}
