//! How uncertain the ends are: their own location, and that of the cylinder they were located on.

use crate::end_location::End;
use crate::fitter::Uncertainty;
use crate::geometry::{Cylinder, LimbFrame, RigidMotion};
use crate::residuals::{Rim, on_wall};
use nalgebra::{Matrix3, SVector, Vector3};

/// The generators at which an arc of an end is held in the image, and the part of the width that they cover: beside the
/// limbs a generator may leave a neighbouring cylinder.
const GENERATORS: usize = 9;
const WIDTH_PART: f64 = 0.7;

/// The uncertainty of an extent: covariances in the reference frame, in the unit of length squared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtentUncertainty {
    /// Covariance of the start.
    pub start: Matrix3<f64>,
    /// Covariance of the end.
    pub end: Matrix3<f64>,
    /// Covariance of the centre.
    pub center: Matrix3<f64>,
    /// Standard deviation of the length, in the unit of length.
    pub length: f64,
}

/// The uncertainty of two ends (start, end) on the surface of a fit, each with the motion into the view that shows it;
/// `None` where the position of one has no deviation,
/// or the covariance of the fit is singular.
///
/// What is seen of an end is its arc in the image, and that stays where it is when the cylinder changes within its
/// uncertainty: the ends move along the axis with it, as a cylinder that is farther away is longer. Points stay where they are, too.
/// The errors by which ends were located are independent of that, and of each other but for points.
pub(super) fn of_ends(
    cylinder: &Cylinder,
    fit: &Uncertainty,
    ends: [(&End, RigidMotion); 2],
) -> Option<ExtentUncertainty> {
    let [of_start, of_end] = [ends[0].0.deviation?.powi(2), ends[1].0.deviation?.powi(2)];
    let [at_start, at_end] = ends.map(|(end, into_view)| {
        let seen = into_view.cylinder(cylinder);
        let at = match end.middle {
            Some(point) => Fixed::Point(point),
            None => Fixed::Rays(rays(&seen, &LimbFrame::new(&seen)?, end.position)),
        };
        Some((at, into_view))
    });
    let (at_start, at_end) = (at_start?, at_end?);
    // Start, end and length.
    let joint = fit.propagate(|cylinder| {
        let position = |(at, into_view): &(Fixed, RigidMotion)| at.position_on(&into_view.cylinder(cylinder));
        let [start, end] = [position(&at_start)?, position(&at_end)?];
        let ends = [start, end].map(|position| cylinder.axis.at(position));
        let numbers = ends.iter().flatten().copied().chain([end - start]);
        Some(SVector::<f64, 7>::from_iterator(numbers))
    })?;
    // Points fall short of both ends alike, or go beyond them. The centre is no better known for that, as their noise is not shared.
    let both_points = ends.iter().all(|(end, _)| end.middle.is_some());
    let shared = if both_points { 2.0 * (of_start * of_end).sqrt() } else { 0.0 };
    let block = |row: usize, column: usize| -> Matrix3<f64> { joint.fixed_view::<3, 3>(row, column).into() };
    let (start, end, both) = (block(0, 0), block(3, 3), block(0, 3) + block(3, 0));
    let direction = cylinder.axis.direction;
    let along = direction * direction.transpose();
    Some(ExtentUncertainty {
        start: start + along * of_start,
        end: end + along * of_end,
        center: (start + end + both + along * (of_start + of_end)) * 0.25,
        length: (joint[(6, 6)] + of_start + of_end + shared).sqrt(),
    })
}

/// What of an end stays where it is, in the coordinates of the view, when the cylinder changes within its uncertainty.
enum Fixed {
    /// The rays to its arc in the image.
    Rays([Vector3<f64>; GENERATORS]),
    /// The middle of the points beside it.
    Point(Vector3<f64>),
}

impl Fixed {
    /// The position of the end along the axis of a cylinder; `None` when a ray does not meet it.
    fn position_on(&self, cylinder: &Cylinder) -> Option<f64> {
        match self {
            Self::Rays(rays) => position_on(cylinder, rays),
            Self::Point(point) => Some(cylinder.axis.position_of(point)),
        }
    }
}

/// The rays to the arc of an end: to the generators that are evenly spaced between the limbs.
fn rays(cylinder: &Cylinder, frame: &LimbFrame, position: f64) -> [Vector3<f64>; GENERATORS] {
    let middle = cylinder.axis.at(position);
    let ray = |k: usize| {
        let part = WIDTH_PART * (2.0 * (k as f64 + 0.5) / GENERATORS as f64 - 1.0);
        // The limbs are at the sine cos γ of the angle from the side that faces the camera.
        let sine = part * frame.cos_gamma;
        let normal = frame.sideways * sine - frame.toward * (1.0 - sine * sine).sqrt();
        middle + normal * cylinder.radius
    };
    std::array::from_fn(ray)
}

/// The mean position along the axis at which rays meet a cylinder; `None` when one does not.
fn position_on(cylinder: &Cylinder, rays: &[Vector3<f64>]) -> Option<f64> {
    let sum = rays.iter().map(|ray| Some(on_wall(cylinder, ray, Rim::Near)?.0)).sum::<Option<f64>>()?;
    Some(sum / rays.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::super::scene::{SIZE, Scene};
    use super::super::{EndSource, EndState};
    use super::*;
    use crate::fitter::{Fitter, Options, StartKind};
    use crate::observations::{ImageView, PointsView};
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};

    /// A normal number, by the sum of twelve even ones.
    fn normal(rng: &mut ChaCha8Rng) -> f64 {
        (0..12).map(|_| f64::from(rng.next_u32()) / f64::from(u32::MAX)).sum::<f64>() - 6.0
    }

    #[test]
    fn intervals_of_length_and_centre_cover_what_they_say() {
        const TRIALS: usize = 10_000;
        const DEVIATION: f64 = 3e-4;
        let scene = Scene::tilted(0.4);
        let truth = &scene.cylinder;
        let frame = LimbFrame::new(truth).unwrap();
        let arcs = [scene.ends.0, scene.ends.1].map(|position| rays(truth, &frame, position));
        let [start, end] = arcs.each_ref().map(|rays| position_on(&scene.cylinder, rays).unwrap());
        let center = scene.cylinder.axis.at(0.5 * (start + end));
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let (mut length_held, mut center_held) = (0, 0);
        for _ in 0..TRIALS {
            let points: Vec<[f64; 3]> = (0..300)
                .map(|k| {
                    let (angle, part) = (0.31 * f64::from(k % 9 - 4), f64::from(k) / 299.0);
                    let along = scene.ends.0 + part * (scene.ends.1 - scene.ends.0);
                    let outward = frame.sideways * angle.sin() - frame.toward * angle.cos();
                    let point = truth.axis.at(along) + outward * truth.radius;
                    point.map(|x| x + DEVIATION * normal(&mut rng)).into()
                })
                .collect();
            let mut fitter = Fitter::new();
            fitter.push_points(&PointsView::from_f64(&points), None).unwrap();
            fitter.set_start(Some(scene.cylinder));
            fitter
                .set_options(Options { start: StartKind::Model, threads: 1, ..Options::default() })
                .unwrap();
            let result = fitter.fit().unwrap();
            // The arcs stay in the image, and are located with an error of their own.
            let ends = arcs.each_ref().map(|rays| End {
                position: position_on(&result.cylinder, rays).unwrap() + DEVIATION * normal(&mut rng),
                deviation: Some(DEVIATION),
                state: EndState::Seen,
                source: EndSource::Image,
                rim: false,
                samples: crate::memory::List::new(),
                far_rim: crate::memory::List::new(),
                arc: None,
                middle: None,
            });
            let at = |end| (end, RigidMotion::identity());
            let both = [at(&ends[0]), at(&ends[1])];
            let uncertainty = of_ends(&result.cylinder, &result.uncertainty.unwrap(), both).unwrap();
            // The direction of the result may be the opposite one.
            let error = (ends[1].position - ends[0].position).abs() - (end - start);
            length_held += usize::from(error.abs() <= 1.960 * uncertainty.length);
            let axis = result.cylinder.axis;
            let off = axis.at(0.5 * (ends[0].position + ends[1].position)) - center;
            let chi = off.dot(&uncertainty.center.cholesky().unwrap().solve(&off));
            center_held += usize::from(chi <= 7.815);
        }
        for held in [length_held, center_held] {
            let part = held as f64 / TRIALS as f64;
            assert!((0.94..=0.96).contains(&part), "{part}");
        }
    }

    #[test]
    fn an_end_located_on_a_neighbouring_cylinder_moves_as_predicted() {
        let scene = Scene::tilted(0.4);
        let (image, mut depth, mask) = scene.render(0);
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        depth.iter_mut().for_each(|z| *z += 2e-3 * normal(&mut rng) as f32);
        let mut fitter = Scene::fitter(&depth, &mask);
        // Without the image the fit is as uncertain as the test needs it.
        let fit = fitter.fit().unwrap().uncertainty.unwrap();
        let image = ImageView::from_f32(&image, SIZE).unwrap();
        fitter.push_image(&image).unwrap();
        let find = |model: Option<&Cylinder>| fitter.find_extent(model, None, Some(true)).unwrap().0;
        let extent = find(None);
        let uncertainty = extent.uncertainty.unwrap();
        let of_ends = extent.start_deviation.unwrap().powi(2) + extent.end_deviation.unwrap().powi(2);
        let mut of_fit = 0.0;
        for k in 0..5 {
            let at = |size: f64| {
                let mut deviations = [0.0; 5];
                deviations[k] = size;
                let cylinder = fit.displaced(&deviations);
                find(Some(&cylinder)).length
            };
            // Near enough for first order: the fit is uncertain by more than a pixel.
            of_fit += (at(0.5) - at(-0.5)).powi(2);
        }
        let predicted = uncertainty.length.powi(2) - of_ends;
        assert!((of_fit / predicted - 1.0).abs() < 0.2, "{of_fit} {predicted}");
        // A given model has no known error.
        let given = find(Some(&scene.cylinder));
        assert!(given.uncertainty.is_none() && given.start_deviation.is_some());
    }
}
