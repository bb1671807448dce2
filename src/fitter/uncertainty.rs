//! How uncertain a result is, and whether points and limbs agree about the radius.

use super::constraints::Constraints;
use super::data::Data;
use super::result::Flags;
use super::scales::Scales;
use crate::geometry::{Cylinder, LocalFrame, Tangent, TangentMap};
use crate::residuals::{Sandwich, Sum, root};
use nalgebra::{Matrix2, SMatrix, SVector, SymmetricEigen, Vector3};

/// The step of central differences in standard deviations: small against any curvature, large against rounding.
const DIFFERENCE_STEP: f64 = 1e-3;

/// An eigenvalue of the covariance below this part of the largest stands for something that is known: rounding leaves
/// so much of 0.
const SINGULAR: f64 = 1e-13;

/// What is known may differ by rounding, in radians or units of the size of the data.
const KNOWN_TO: f64 = 1e-9;

/// Points and limbs disagree when their radii differ by more than this many standard deviations of the difference.
/// Normal errors do that once in 16,000 fits; the noise of real depth has longer tails than its estimated scale and
/// correlation know of, and a flag that is raised by them says nothing.
pub(super) const DISAGREEMENT: f64 = 4.0;

/// Points and the sides of a drawn mask, where no limb is seen, disagree from here on. What both are taken to be off is generous: of 244
/// frames without an image the largest is 2.2, and where masks are 5 px too small it is 2.8 in the median.
pub(super) const MASK_DISAGREEMENT: f64 = 2.5;

/// Standard deviation of the shift between depth and image of a camera that is calibrated, in pixels of the drawing:
/// registrations are good to half a pixel.
const USUAL_SHIFT: f64 = 0.25;

/// Depth and image are shifted when the shift is more than this many standard deviations: of 189 twin and recorded frames
/// that are not, the largest is at 2.8.
const SHIFTED: f64 = 3.0;

/// Limbs that add a smaller part than this to what is known of the radius have no radius of their own.
const LEAST_SHARE: f64 = 1e-3;

/// Independent points without which the noise cannot be told from the residuals: with five degrees of freedom fitted,
/// the variance of Student's t is finite from three others on.
const LEAST_INDEPENDENT: f64 = 8.0;

impl Data<'_> {
    /// The uncertainty of a minimum, in the frame of the direction that a result shows, and its radius by points and by limbs or
    /// the sides of a mask, where these take part. The minimum of the points may lie `beside` where it should by each of these steps.
    pub fn uncertainty(
        &self,
        constraints: &Constraints,
        frame: &LocalFrame,
        scales: &Scales,
        objective: &Sum<'_>,
        beside: &[Tangent],
    ) -> (Option<Uncertainty>, Option<RadiusComparison>, Option<ImageShift>) {
        let cylinder = &frame.cylinder;
        if !self.tells_noise(cylinder, scales) {
            return (None, None, None);
        }
        let Some(mut sandwich) = objective.sandwich(frame) else { return (None, None, None) };
        for step in beside {
            let gradient = sandwich.points.derivative * step;
            sandwich.points.covariance += gradient * gradient.transpose();
        }
        let uncertainty = sandwich.covariance(&self.known()).map(|tangent| Uncertainty {
            frame: *frame,
            tangent,
            center: self.center,
        });
        let radii = (uncertainty.is_some() && constraints.has_lines())
            .then(|| RadiusComparison::new(cylinder.radius, &sandwich, self.unit))
            .flatten();
        let shift = uncertainty.and_then(|_| self.image_shift(constraints, &sandwich, frame, scales));
        (uncertainty, radii, shift)
    }

    /// Which degrees of freedom the limits fix.
    fn known(&self) -> [bool; 5] {
        let limits = &self.options.cylinder_limits;
        let (radius, axis) = (limits.fix_radius(), limits.fix_axis());
        [false, false, axis, axis, radius]
    }

    /// Whether the residuals about a cylinder tell the noise.
    fn tells_noise(&self, cylinder: &Cylinder, scales: &Scales) -> bool {
        let minimises = self.count() > 0 && self.options.method.minimises();
        minimises && self.has_independent_inliers(cylinder, scales, LEAST_INDEPENDENT)
    }

    /// What the data contradict of what the limits fix: the minimum with everything free lies, to first order, farther from the
    /// known radius or direction than its uncertainty allows.
    pub fn contradicted(&self, frame: &LocalFrame, scales: &Scales, objective: &Sum<'_>) -> Flags {
        let [_, _, axis, _, radius] = self.known();
        let Some(sandwich) = (axis || radius).then(|| objective.sandwich(frame)).flatten() else {
            return Flags::empty();
        };
        let free = [false; 5];
        let found = sandwich.step(&free).zip(sandwich.covariance(&free)).and_then(|(step, covariance)| {
            // What is wrong passes for noise that neighbours share, which is less where the step leads.
            let cylinder = frame.retract(&step);
            let there = self.scales(&cylinder);
            let noise = |cylinder: &Cylinder, scales: &Scales| {
                scales.all / self.independent_inliers(cylinder, scales).sqrt()
            };
            let part = (noise(&cylinder, &there) / noise(&frame.cylinder, scales)).min(1.0);
            let turn = step.fixed_rows::<2>(2);
            let of_turn =
                covariance.fixed_view::<2, 2>(2, 2).into_owned().cholesky()?.solve(&turn).dot(&turn);
            let deviations = [of_turn.sqrt(), step[4].abs() / covariance[(4, 4)].sqrt()];
            let told = self.tells_noise(&cylinder, &there) || self.tells_noise(&frame.cylinder, scales);
            told.then(|| deviations.map(|deviations| deviations / part))
        });
        let [turn, step] = found.unwrap_or_default();
        let mut contradicted = Flags::empty();
        contradicted.set(Flags::AXIS_AT_LIMIT, axis && turn > DISAGREEMENT);
        contradicted.set(Flags::RADIUS_AT_LIMIT, radius && step > DISAGREEMENT);
        contradicted
    }

    /// The uncertainty of a cylinder that takes the place of a minimum and is none, by what it is `about` it as if it were: how far
    /// the minimum lies from it, to first order, is an error like others. `None` where nothing tells that.
    pub fn uncertainty_beside_minimum(
        &self,
        constraints: &Constraints,
        cylinder: &Cylinder,
        about: &Uncertainty,
    ) -> Option<Uncertainty> {
        let objective = self.objective(constraints, cylinder, &self.scales(cylinder));
        let step = objective.sandwich(&about.frame)?.step(&self.known())?;
        Some(Uncertainty { tangent: about.tangent + step * step.transpose(), ..*about })
    }

    /// The shift between depth and image, where both limbs of a single view were located.
    fn image_shift(
        &self,
        constraints: &Constraints,
        sandwich: &Sandwich,
        frame: &LocalFrame,
        scales: &Scales,
    ) -> Option<ImageShift> {
        let ([view], [of_view]) = (&self.views[..], &constraints.views[..]) else { return None };
        if of_view.located < 2 || !view.observed {
            return None;
        }
        let camera = view.camera()?;
        let eye = view.into_view.inverse().point(&Vector3::zeros());
        let Cylinder { axis, .. } = frame.cylinder;
        let center = axis.nearest_to(&self.center);
        let across = axis.direction.cross(&(center - eye)).try_normalize(0.0)?;
        let e = Tangent::new(across.dot(&frame.u), across.dot(&frame.v), 0.0, 0.0, 0.0);
        let Contrast { points, limbs } = Contrast::new(&e, sandwich)?;
        let pixel = |at: f64| camera.ideal_pixel(&view.into_view.point(&(center + across * at)));
        let step = DIFFERENCE_STEP * frame.cylinder.radius;
        let pixels = self.unit * (pixel(step)? - pixel(-step)?).norm() / (2.0 * step);
        let usual = USUAL_SHIFT * view.noise.pixel;
        // The shift that is usual is counted by itself.
        let near = frame.moved(&view.into_view);
        let shared = self.shared_errors(view, of_view, &near, &scales.views[0]);
        let usual_of_points = shared.map_or(0.0, |shared| shared.across / self.unit);
        let of_points = (points.deviation.powi(2) - usual_of_points.powi(2)).max(0.0).sqrt();
        let of_noise = pixels * of_points.hypot(limbs.deviation);
        let mut shift =
            ImageShift { pixels: pixels * (points.step - limbs.step), deviation: of_noise.hypot(usual) };
        if shift.pixels.abs() > of_noise {
            // Between points and limbs the residuals of a shift pass for noise. Where the points have the axis they do not.
            let [here, there] = [scales, &self.scales(&moved_across(frame, &across, points.step))]
                .map(|scales| scales.views[0])
                .map(|scales| scales.point / scales.independent_points.sqrt());
            let part = (there / here).min(1.0);
            shift.deviation = (part * of_noise).hypot(usual);
        }
        (shift.pixels.is_finite() && shift.deviation.is_finite()).then_some(shift)
    }
}

/// The uncertainty of a fitted cylinder: a normal distribution of the five degrees of freedom about it, to first order
/// in the noise.
///
/// It is that of the noise of the data, with the weights that the fit used and the correlation of the depth noise
/// between neighbours. For the robust objective the errors that all points of a view share are in it, as far as
/// [`NoiseModel::depth_shared`](crate::noise::NoiseModel::depth_shared) tells them: a bend of the profile, an offset, a tilt.
/// A radius or a direction that the limits fix has none; a limit that a minimum lies on is not felt. Errors of the
/// calibration, the registration and a scale of the depth are not in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Uncertainty {
    /// The frame at the cylinder.
    frame: LocalFrame,
    /// The covariance in the tangent of the frame.
    tangent: TangentMap,
    /// The middle of the points.
    center: Vector3<f64>,
}

impl Uncertainty {
    /// Standard deviation of the radius, in the unit of length.
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.frame.unit * self.tangent[(4, 4)].max(0.0).sqrt()
    }

    /// Standard deviation of the direction in radians: the tilt of the axis in the plane in which it is least certain.
    #[must_use]
    pub fn direction(&self) -> f64 {
        larger_deviation(&self.tangent.fixed_view::<2, 2>(2, 2).into())
    }

    /// Standard deviation of the position of the axis across itself, at its point nearest to the middle of the points
    /// and in the direction in which it is least certain, in the unit of length.
    #[must_use]
    pub fn position(&self) -> f64 {
        self.frame.unit * larger_deviation(&self.tangent.fixed_view::<2, 2>(0, 0).into())
    }

    /// The covariance of (axis point, unit direction, radius) of the result: 7 × 7, in the reference frame and the unit of
    /// length. The axis point is the one nearest to the middle of the points. The rank is 5: the direction keeps its
    /// length, and along the axis the point only moves as the tilt moves it.
    #[must_use]
    pub fn covariance(&self) -> SMatrix<f64, 7, 7> {
        // The tangent was made of such a root: there is one. The product of a matrix with its transpose is symmetric to the
        // last bit, its variances are not negative and its correlations are at most 1.
        let root = self.jacobian() * root(&self.tangent).unwrap_or_default();
        root * root.transpose()
    }

    /// The derivative of (axis point, unit direction, radius) in the tangent of the frame.
    ///
    /// The axis point P nearest to the middle g of the points has (g − P)·d̂ = 0. A shift Δ across the axis moves it by
    /// Δ; a tilt δd turns the axis about P and moves the nearest point along it by d̂ ((g − P)·δd).
    fn jacobian(&self) -> SMatrix<f64, 7, 5> {
        let LocalFrame { cylinder, u, v, unit } = self.frame;
        let direction = cylinder.axis.direction;
        let aside = self.center - cylinder.axis.point;
        let mut jacobian = SMatrix::<f64, 7, 5>::zeros();
        for (k, across) in [u, v].into_iter().enumerate() {
            jacobian.fixed_view_mut::<3, 1>(0, k).copy_from(&(across * unit));
            jacobian.fixed_view_mut::<3, 1>(0, 2 + k).copy_from(&(direction * aside.dot(&across)));
            jacobian.fixed_view_mut::<3, 1>(3, 2 + k).copy_from(&across);
        }
        jacobian[(6, 4)] = unit;
        jacobian
    }

    /// How far another cylinder lies from the result, as a squared number of standard deviations (squared Mahalanobis
    /// distance). For the true cylinder it is χ² of 5 degrees of freedom: up to 11.07 is the 95 % region. Infinite when
    /// the other has another radius or direction than what is known.
    #[must_use]
    pub fn squared_distance(&self, other: &Cylinder) -> f64 {
        let difference = self.frame.difference(other);
        let SymmetricEigen { eigenvalues, eigenvectors } = self.tangent.symmetric_eigen();
        let least = SINGULAR * eigenvalues.max();
        let parts = eigenvectors.tr_mul(&difference);
        let terms = parts.iter().zip(&eigenvalues).map(|(part, variance)| match *variance > least {
            true => part * part / variance,
            // What is known is not elsewhere.
            false if part.abs() <= KNOWN_TO => 0.0,
            false => f64::INFINITY,
        });
        terms.sum()
    }

    /// The cylinder that lies so many standard deviations away along five independent steps: for independent normal
    /// numbers it is a draw from the distribution.
    #[must_use]
    pub fn displaced(&self, deviations: &[f64; 5]) -> Cylinder {
        let SymmetricEigen { eigenvalues, eigenvectors } = self.tangent.symmetric_eigen();
        let roots = eigenvalues.map(|variance| variance.max(0.0).sqrt());
        self.frame.retract(&(eigenvectors * roots.component_mul(&Tangent::from(*deviations))))
    }

    /// The covariance of whatever follows from the cylinder, to first order; `None` where `function` is for a
    /// neighbouring cylinder.
    pub fn propagate<const N: usize>(
        &self,
        function: impl Fn(&Cylinder) -> Option<SVector<f64, N>>,
    ) -> Option<SMatrix<f64, N, N>> {
        let mut covariance = SMatrix::zeros();
        for k in 0..5 {
            let at = |size: f64| {
                let mut deviations = [0.0; 5];
                deviations[k] = size;
                function(&self.displaced(&deviations))
            };
            let change = (at(DIFFERENCE_STEP)? - at(-DIFFERENCE_STEP)?) / (2.0 * DIFFERENCE_STEP);
            covariance += change * change.transpose();
        }
        Some(covariance)
    }
}

/// A cylinder moved across its axis by a step in units of its frame.
fn moved_across(frame: &LocalFrame, across: &Vector3<f64>, step: f64) -> Cylinder {
    let mut cylinder = frame.cylinder;
    cylinder.axis.point += across * (step * frame.unit);
    cylinder
}

/// The root of the larger eigenvalue of a covariance.
pub(crate) fn larger_deviation(covariance: &Matrix2<f64>) -> f64 {
    covariance.symmetric_eigenvalues().max().max(0.0).sqrt()
}

/// The radius by the points and the radius by the limbs, to first order about the result.
///
/// A scale of the depth changes both alike: the points scale, and the limbs say r / ‖c‖ with the distance from the
/// points. An offset of the depth, depth that is smeared or bent, wrong intrinsics or edges that are not the limbs
/// change one of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RadiusComparison {
    /// The radius by the curvature of the points alone, in the unit of length.
    pub from_points: f64,
    /// Its standard deviation.
    pub from_points_deviation: f64,
    /// The radius by the limbs, with distance and tilt of the axis from the points (and from the arcs of the ends,
    /// where these take part), in the unit of length.
    pub from_limbs: f64,
    /// Its standard deviation.
    pub from_limbs_deviation: f64,
}

impl RadiusComparison {
    /// The difference, points minus limbs, in its own standard deviations: the two are uncorrelated.
    #[must_use]
    pub fn z_score(&self) -> f64 {
        (self.from_points - self.from_limbs) / self.from_points_deviation.hypot(self.from_limbs_deviation)
    }

    /// Whether the difference is more than so many standard deviations.
    pub(super) fn disagree(&self, most: f64) -> bool {
        self.z_score().abs() > most
    }

    /// `None` where the points alone determine no cylinder or the limbs add nothing to the radius.
    fn new(radius: f64, sandwich: &Sandwich, unit: f64) -> Option<Self> {
        let Contrast { points, limbs } = Contrast::new(&Tangent::ith(4, 1.0), sandwich)?;
        let comparison = Self {
            from_points: radius + unit * points.step,
            from_points_deviation: unit * points.deviation,
            from_limbs: radius + unit * limbs.step,
            from_limbs_deviation: unit * limbs.deviation,
        };
        comparison.z_score().is_finite().then_some(comparison)
    }
}

/// How far the points are from where the limbs are, across the axis: depth and image that are shifted against each other,
/// by a wrong registration or wrong principal points. Along the axis nothing tells it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImageShift {
    /// The shift in pixels of the image, from the middle of the limbs to the image of the axis by the points. Positive
    /// towards d̂ × ĉ, with the direction d̂ of the axis in the coordinates of the view and the direction ĉ from the
    /// camera to it.
    pub pixels: f64,
    /// Its standard deviation, for the noise of points and limbs and what is usual between calibrated cameras.
    pub deviation: f64,
}

impl ImageShift {
    /// Whether it is more than noise and what is usual.
    pub(super) fn is_wrong(&self) -> bool {
        self.pixels.abs() > SHIFTED * self.deviation
    }
}

/// What the points alone and what the limbs say of one combination of the degrees of freedom, as steps from the result to
/// first order.
struct Contrast {
    points: Said,
    limbs: Said,
}

struct Said {
    step: f64,
    deviation: f64,
}

impl Contrast {
    /// With A = A_p + A_l, one Newton step from the result leads to the minimum of the points, x_p, and to that of
    /// everything, x_f. With k = 1 − (eᵀA⁻¹e) / (eᵀA_p⁻¹e), the part of the information on the combination e that the limbs
    /// bring, x_f = (1 − k) x_p + k x_l defines x_l. So much of x_p is taken out that the two are uncorrelated.
    fn new(e: &Tangent, sandwich: &Sandwich) -> Option<Self> {
        let Sandwich { points, image } = sandwich;
        let of_points = points.derivative.cholesky()?;
        let of_all = sandwich.derivative().cholesky()?;
        // eᵀA_p⁻¹ and eᵀA⁻¹.
        let (row_points, row_all) = (of_points.solve(e), of_all.solve(e));
        let share = 1.0 - row_all.dot(e) / row_points.dot(e);
        if !(share >= LEAST_SHARE) {
            return None;
        }
        let step_points = -row_points.dot(&points.gradient);
        let step_all = -row_all.dot(&(points.gradient + image.gradient));
        let variance = |row: &Tangent, covariance: &TangentMap| row.dot(&(covariance * row));
        // How x_l follows from the gradient of the points and from that of the limbs.
        let by_limbs = row_all / share;
        let by_points = row_points * (1.0 - 1.0 / share) + by_limbs;
        let limbs_variance =
            variance(&by_points, &points.covariance) + variance(&by_limbs, &image.covariance);
        Some(Self {
            points: Said { step: step_points, deviation: variance(&row_points, &points.covariance).sqrt() },
            limbs: Said {
                step: step_points + (step_all - step_points) / share,
                deviation: limbs_variance.sqrt(),
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::residuals::SandwichPart;

    fn uncertainty() -> Uncertainty {
        let cylinder =
            Cylinder::new(Vector3::new(0.1, -0.2, 0.9), Vector3::new(-0.4, 0.8, 0.3), 0.07).unwrap();
        let center = Vector3::new(0.13, -0.1, 0.85);
        let frame = LocalFrame::new(&cylinder, &center, 0.05);
        let root = TangentMap::from_fn(|row, column| 1e-3 * ((3 * row + 5 * column) as f64).sin())
            + TangentMap::identity() * 2e-3;
        Uncertainty { frame, tangent: root * root.transpose(), center }
    }

    /// (axis point nearest to the middle of the points, direction, radius).
    fn seven(cylinder: &Cylinder, center: &Vector3<f64>) -> SVector<f64, 7> {
        let (point, direction) = (cylinder.axis.nearest_to(center), cylinder.axis.direction);
        let numbers = point.iter().chain(&direction).copied().chain([cylinder.radius]);
        SVector::from_iterator(numbers)
    }

    #[test]
    fn points_and_limbs_say_what_each_of_them_alone_would() {
        let part = |derivative: TangentMap, minimum: Tangent| SandwichPart {
            gradient: -(derivative * minimum),
            derivative,
            covariance: derivative,
        };
        // The limbs tell one combination only, across the axis.
        let across = Tangent::new(0.6, 0.8, 0.0, 0.0, 0.0);
        let root = TangentMap::from_fn(|row, column| ((2 * row + 3 * column) as f64).cos());
        let of_points = root * root.transpose() + TangentMap::identity();
        let minimum_of_points = Tangent::new(0.3, -0.2, 0.1, 0.4, -0.5);
        let sandwich = Sandwich {
            points: part(of_points, minimum_of_points),
            image: part(across * across.transpose() * 25.0, across * 2.0),
        };
        let Contrast { points, limbs } = Contrast::new(&across, &sandwich).unwrap();
        assert!((points.step - minimum_of_points.dot(&across)).abs() < 1e-12);
        assert!((limbs.step - 2.0).abs() < 1e-12 && (limbs.deviation - 0.2).abs() < 1e-12);
        let shift = ImageShift { pixels: points.step - limbs.step, deviation: 0.5 };
        assert!(shift.is_wrong() && !ImageShift { deviation: 1.0, ..shift }.is_wrong());
    }

    #[test]
    fn the_jacobian_of_the_seven_numbers_agrees_with_central_differences() {
        let uncertainty = uncertainty();
        let jacobian = uncertainty.jacobian();
        let h = 1e-6;
        for k in 0..5 {
            let at =
                |size: f64| seven(&uncertainty.frame.retract(&Tangent::ith(k, size)), &uncertainty.center);
            let difference = (at(h) - at(-h)) / (2.0 * h);
            assert!((difference - jacobian.column(k)).norm() < 1e-9, "{k} {difference}");
        }
    }

    #[test]
    fn the_covariance_has_rank_five_and_is_what_propagation_gives() {
        let uncertainty = uncertainty();
        let covariance = uncertainty.covariance();
        let mut eigenvalues: Vec<f64> = covariance.symmetric_eigenvalues().iter().copied().collect();
        eigenvalues.sort_by(f64::total_cmp);
        assert!(eigenvalues[1].abs() < 1e-12 * eigenvalues[6] && eigenvalues[2] > 1e-6 * eigenvalues[6]);
        let propagated = uncertainty.propagate(|c| Some(seven(c, &uncertainty.center))).unwrap();
        assert!((propagated - covariance).norm() < 1e-6 * covariance.norm());
        assert!((uncertainty.radius().powi(2) / covariance[(6, 6)] - 1.0).abs() < 1e-12);
        // The least certain tilt is that of the covariance of the direction.
        let of_direction = covariance.fixed_view::<3, 3>(3, 3).symmetric_eigenvalues().max();
        assert!((uncertainty.direction().powi(2) / of_direction - 1.0).abs() < 1e-9);
    }

    #[test]
    fn the_squared_distance_counts_standard_deviations() {
        let uncertainty = uncertainty();
        let moved = uncertainty.displaced(&[0.0, 6e-4, 0.0, -8e-4, 0.0]);
        assert!((uncertainty.squared_distance(&moved) - 1e-6).abs() < 1e-10);
        let mut turned = moved;
        turned.axis.direction = -turned.axis.direction;
        assert!((uncertainty.squared_distance(&turned) - 1e-6).abs() < 1e-10);
    }
}
