//! The scales of the point residuals of a cylinder, and how many points are independent.

use super::data::{Data, ViewData};
use super::subsample;
use crate::geometry::{Cylinder, LocalFrame};
use crate::memory::List;
use crate::observations::are_many;
use crate::residuals::{NormalEquations, RobustScales, Squared, TUKEY_EFFICIENT};
use crate::statistics::{DEVIATION_OF_MEDIAN, median_absolute, median_absolute_near};

/// The part by which a number of independent points may change without another minimum: it is an estimate, good to
/// a tenth at best.
const INFORMATION_TOLERANCE: f64 = 0.1;

/// Of exact points at least this part lies on the cylinder: fewer may by chance.
const EXACT: f64 = 0.9;

/// The scales of the point residuals of a cylinder.
#[derive(Debug, Clone)]
pub(super) struct Scales {
    pub views: List<RobustScales>,
    /// Of all views together.
    pub all: f64,
}

impl Scales {
    /// Whether the numbers of independent points are the same to within what their estimate is good for.
    pub fn same_information(&self, before: &Self) -> bool {
        let count = |scales: &RobustScales| scales.independent_points;
        let mut pairs = self.views.iter().zip(&before.views);
        pairs.all(|(next, before)| (count(next) / count(before) - 1.0).abs() <= INFORMATION_TOLERANCE)
    }

    pub fn differ_by_less_than(&self, part: f64, before: &Self) -> bool {
        let mut pairs = self.views.iter().zip(&before.views);
        pairs.all(|(next, before)| (next.point - before.point).abs() <= part * before.point)
    }
}

/// The residuals of the points at a cylinder.
pub(super) struct Residuals {
    /// By view.
    views: List<List<f64>>,
    /// Their scales, by view,
    points: List<f64>,
    /// and of all together.
    all: f64,
}

impl Residuals {
    /// The scales with the numbers of independent points of others.
    pub fn scales_with_counts_of(&self, before: &Scales) -> Scales {
        let pairs = self.points.iter().zip(&before.views);
        let views = pairs.map(|(&point, before)| RobustScales { point, ..*before });
        Scales { views: views.collect(), all: self.all }
    }
}
impl Data<'_> {
    /// Whether the scale of the point residuals of a cylinder is less than some limit, which takes no median.
    pub fn scale_is_below(&self, cylinder: &Cylinder, limit: f64) -> bool {
        let below = limit / DEVIATION_OF_MEDIAN;
        let of_view = |view: &ViewData<'_>| view.points_within(cylinder, &self.center, below);
        self.rounding() < limit && 2 * self.views.iter().map(of_view).sum::<usize>() > self.count()
    }

    /// By the median absolute deviation. Exact data have no scale: the rounding floor avoids 0 / 0 in the loss.
    fn scale_of(&self, residuals: impl Iterator<Item = f64>) -> f64 {
        (DEVIATION_OF_MEDIAN * median_absolute(residuals)).max(self.rounding())
    }

    /// Whether most points lie on a cylinder to rounding, as exact ones do, but some beside it: depth in coarse steps, of which a few points
    /// are alike, has no scale that says how it scatters.
    pub fn is_exact_by_chance(&self, cylinder: &Cylinder, scales: &Scales) -> bool {
        // Hardly any fit has to look at its points for that.
        if scales.all > self.rounding() {
            return false;
        }
        let within = TUKEY_EFFICIENT * self.rounding();
        let of_view = |view: &ViewData<'_>| view.points_within(cylinder, &self.center, within);
        let exact: usize = self.views.iter().map(of_view).sum();
        (exact as f64) < EXACT * self.count() as f64
    }

    /// What rounding leaves of the residuals of exact data.
    fn rounding(&self) -> f64 {
        64.0 * f64::EPSILON * self.center.amax().max(self.unit)
    }

    /// The number of independent points that count at a cylinder: those that are not outliers.
    pub fn independent_inliers(&self, cylinder: &Cylinder, scales: &Scales) -> f64 {
        let of_view = |(view, scales): (&ViewData<'_>, &RobustScales)| {
            if self.is_paper() {
                return scales.independent_points;
            }
            let inliers = view.points_within(cylinder, &self.center, TUKEY_EFFICIENT * scales.point);
            scales.independent_points * inliers as f64 / view.points.count().max(1) as f64
        };
        self.views.iter().zip(&scales.views).map(of_view).sum()
    }

    /// Whether there are at least so many of them.
    pub fn has_independent_inliers(&self, cylinder: &Cylinder, scales: &Scales, least: f64) -> bool {
        // Half of the points are no farther from the surface than their median, which scales are of unless they were told.
        let by_median = self.options.noise.depth == 0.0;
        let with_points = self.views.iter().zip(&scales.views).filter(|(view, _)| view.points.count() > 0);
        let half = 0.5 * with_points.map(|(_, scales)| scales.independent_points).sum::<f64>();
        by_median && half >= least || self.independent_inliers(cylinder, scales) >= least
    }

    /// The scales of a cylinder.
    pub fn scales(&self, cylinder: &Cylinder) -> Scales {
        self.scales_near(cylinder, None)
    }

    /// The same where they are about known: that changes nothing but the time.
    pub fn scales_near(&self, cylinder: &Cylinder, about: Option<&Scales>) -> Scales {
        self.scales_of(cylinder, &self.residuals(cylinder, about))
    }

    /// The same where the residuals are known.
    pub fn scales_of(&self, cylinder: &Cylinder, residuals: &Residuals) -> Scales {
        let views = self.views.iter().zip(&residuals.views).zip(&residuals.points);
        let views = views.map(|((view, residuals), &point)| {
            let independent_points = self.independent_points(view, cylinder, residuals, point);
            RobustScales { point, independent_points }
        });
        Scales { views: views.collect(), all: residuals.all }
    }

    /// The residuals at a cylinder, next to which the scales are known, if any.
    pub fn residuals(&self, cylinder: &Cylinder, before: Option<&Scales>) -> Residuals {
        let distances = |view: &ViewData<'_>| view.distances(cylinder, &self.center);
        let told = self.options.noise.depth;
        if let [view] = &self.views[..]
            && are_many(view.points.count())
        {
            // Without a list of them: the neighbours have one of their own.
            let frame = LocalFrame { unit: 1.0, ..self.frame(cylinder) }.moved(&view.into_view);
            let near = before.map(|before| before.all / DEVIATION_OF_MEDIAN);
            let median = subsample::median_distance(view, &frame, near);
            let all = (DEVIATION_OF_MEDIAN * median).max(self.rounding());
            let point = if told > 0.0 { told } else { all };
            return Residuals { views: List::from([List::new()]), points: List::from([point]), all };
        }
        let views: List<List<f64>> = self.views.iter().map(distances).collect();
        let scale = |(k, view): (usize, &List<f64>)| match before {
            _ if told > 0.0 => told,
            Some(before) => {
                let near = before.views[k].point / DEVIATION_OF_MEDIAN;
                (DEVIATION_OF_MEDIAN * median_absolute_near(view, near)).max(self.rounding())
            }
            None => self.scale_of(view.iter().copied()),
        };
        let points: List<f64> = views.iter().enumerate().map(scale).collect();
        let all = match points[..] {
            [one] if told == 0.0 => one,
            _ => self.scale_of(views.iter().flatten().copied()),
        };
        Residuals { views, points, all }
    }

    /// The number of independent points of a view whose residuals have some scale, unless the caller told it.
    fn independent_points(
        &self,
        view: &ViewData<'_>,
        cylinder: &Cylinder,
        residuals: &[f64],
        scale: f64,
    ) -> f64 {
        let count = view.stands_for as f64;
        let told = self.options.independent_points;
        if told > 0.0 {
            return told.min(count).max(1.0);
        }
        // What rounding leaves is alike everywhere and no noise.
        if view.points.count() == 0 || scale <= self.rounding() {
            return count.max(1.0);
        }
        let frame = self.frame(cylinder).moved(&view.into_view);
        // The edges of the paper's objective pull the cylinder off the points with a weight of their own: what a step to
        // the minimum of the points would take away is no noise.
        let freed = if self.is_paper() { at_minimum_of_points(view, &frame) } else { None };
        let band = view.neighbours.band();
        let own = match (freed, band) {
            (Some(freed), band) => Some(band.unwrap_or(view.points).distances(&freed)),
            (None, Some(band)) => Some(band.distances(&LocalFrame { unit: 1.0, ..frame })),
            (None, None) => None,
        };
        let residuals = own.as_ref().map_or(residuals, |own| &own[..]);
        view.neighbours.independent_points(view, &frame, residuals, TUKEY_EFFICIENT * scale).max(1.0)
    }
}

/// The frame at the minimum of the points, by a step; `None` where that is not determined.
fn at_minimum_of_points(view: &ViewData<'_>, frame: &LocalFrame) -> Option<LocalFrame> {
    let NormalEquations { gradient, hessian, .. } = view.points.linearise(frame, Squared);
    let cylinder = frame.retract(&-hessian.cholesky()?.solve(&gradient));
    Some(LocalFrame::new(&cylinder, &cylinder.axis.point, 1.0))
}
