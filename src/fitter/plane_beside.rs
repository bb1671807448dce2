//! A plane among points alone: a wall, the ground, a flange.
//!
//! Where it touches the body or crosses it, its points lie on the surface of the body as well: those of a floor draw a pipe that lies on
//! it outwards. And a strip of it is a wide cylinder, which explains more points than a body that has fewer than half of them.

use super::among_points::FEWEST;
use crate::error::Result;
use crate::geometry::{Cylinder, Plane};
use crate::memory::List;
use crate::observations::spread;
use crate::residuals::TUKEY_EFFICIENT;
use crate::start::ransac::below;
use crate::statistics::{DEVIATION_OF_MEDIAN, LOWER_QUARTILE, lower_quartile_absolute, median_absolute};
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// Samples of three points: of a plane with a quarter of them one in 64 is its own.
const SAMPLES: usize = 300;

/// Points on which the planes of samples are scored.
const SCORED: usize = 500;

/// Least squares, each about the points that are on the plane before.
const ROUNDS: usize = 4;

/// Less than this part of the size of the cloud is rounding.
const ROUNDING: f64 = 1e-7;

/// Planes that cross the body or touch it, at most.
const MOST_PLANES: usize = 3;

constants! {
    /// One sensor measures plane and body: their points scatter alike, within this factor.
    ALIKE = 2.0, "";
}

/// A fit without the points of planes that touch its cylinder or cross it, what is left of its points, and all planes about it.
///
/// Of a fit `surface` gives the cylinder and how far points scatter about it, `around` some of all points near it; `point_of` is where one
/// of its own points lies. `refit` makes a fit to fewer of them, or `None` where they lie on a cylinder worse than those of the fit
/// before.
pub(crate) fn off_planes<Fit, Number: Copy + Send + 'static>(
    (mut fit, mut points): (Fit, List<Number>),
    surface: impl Fn(&Fit) -> (Cylinder, f64),
    point_of: impl Fn(Number) -> Vector3<f64>,
    around: impl Fn(&Fit) -> List<Vector3<f64>>,
    mut refit: impl FnMut(&Fit, &[Number]) -> Result<Option<Fit>>,
) -> Result<(Fit, List<Number>, List<PlaneBeside>)> {
    let mut planes: List<PlaneBeside> = List::new();
    for _ in 0..MOST_PLANES {
        let (cylinder, scale) = surface(&fit);
        let is_on = |point: &Vector3<f64>| cylinder.distance(point).abs() <= TUKEY_EFFICIENT * scale;
        let mut beyond = around(&fit);
        beyond.retain(|point| !is_on(point) && !planes.iter().any(|plane| plane.holds(point)));
        let Some(plane) = PlaneBeside::among(&beyond, ALIKE.get() * scale) else { break };
        let is_on_both = |point: Vector3<f64>| is_on(&point) && plane.holds(&point);
        if points.iter().any(|&number| is_on_both(point_of(number))) {
            let is_beside = |&number: &Number| !plane.holds(&point_of(number));
            let rest: List<Number> = points.iter().copied().filter(is_beside).collect();
            let Some(again) = refit(&fit, &rest)? else { break };
            (fit, points) = (again, rest);
        }
        planes.push(plane);
    }
    Ok((fit, points, planes))
}

/// A plane with the noise of its points.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlaneBeside {
    plane: Plane,
    scale: f64,
}

impl PlaneBeside {
    /// The plane that a quarter of some points are nearest to. `None` where they scatter about it by more than `largest`, or are fewer.
    pub fn among(points: &[Vector3<f64>], largest: f64) -> Option<Self> {
        if points.len() < FEWEST {
            return None;
        }
        let rng = &mut ChaCha8Rng::seed_from_u64(0);
        let some: List<Vector3<f64>> =
            spread(points.len(), SCORED).iter().map(|&index| points[index]).collect();
        let quartile =
            |plane: &Plane| lower_quartile_absolute(some.iter().map(|point| plane.distance(point)));
        let sample = |_| Plane::through([0; 3].map(|_| some[below(rng, some.len())]));
        let scored = (0..SAMPLES).filter_map(sample).map(|plane| (quartile(&plane), plane));
        let (quartile, plane) = scored.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let size = Plane::nearest(points.iter())?.covariance.trace().sqrt();
        // As if all points were on the plane: what is too large becomes smaller with each round.
        let mut found = Self { plane, scale: quartile / LOWER_QUARTILE };
        for _ in 0..ROUNDS {
            found.scale = found.scale.max(ROUNDING * size);
            let own: List<Vector3<f64>> = points.iter().filter(|point| found.holds(point)).copied().collect();
            let plane = Plane::nearest(own.iter())?;
            let scale = median_absolute(own.iter().map(|point| plane.distance(point)));
            found = Self { plane, scale: DEVIATION_OF_MEDIAN * scale };
        }
        let own = points.iter().filter(|point| found.holds(point)).count();
        (4 * own >= points.len() && found.scale <= largest).then_some(found)
    }

    /// How far points are from it in the median.
    pub fn median_distance(&self, points: impl Iterator<Item = Vector3<f64>>) -> f64 {
        median_absolute(points.map(|point| self.plane.distance(&point)))
    }

    /// Whether a point lies on the plane.
    pub fn holds(&self, point: &Vector3<f64>) -> bool {
        self.plane.distance(point) <= TUKEY_EFFICIENT * self.scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::random_number as number;

    /// Some points of the plane x = 1, with noise of a uniform distribution, and others in a cube.
    fn points(on_plane: usize, noise: f64, others: usize) -> Vec<Vector3<f64>> {
        let rng = &mut ChaCha8Rng::seed_from_u64(1);
        let mut point =
            |half: f64| Vector3::new(1.0 + half * number(rng), 3.0 * number(rng), 3.0 * number(rng));
        let mut points: Vec<_> = (0..on_plane).map(|_| point(noise)).collect();
        points.extend((0..others).map(|_| point(3.0)));
        points
    }

    #[test]
    fn a_third_of_the_points_tells_a_plane_and_its_noise() {
        for noise in [0.0, 0.02] {
            let found = PlaneBeside::among(&points(400, noise, 800), 0.03).unwrap();
            assert!(found.plane.normal.x.abs() > 0.9999, "{found:?}");
            // The median of a uniform distribution is at half of it.
            assert!((found.scale - DEVIATION_OF_MEDIAN * noise / 2.0).abs() < 0.003, "{found:?}");
            assert!(found.holds(&Vector3::new(1.0, -2.0, 2.0)));
            assert!(!found.holds(&Vector3::new(1.2, -2.0, 2.0)));
        }
    }

    #[test]
    fn a_fifth_of_the_points_more_noise_and_few_points_are_none() {
        assert!(PlaneBeside::among(&points(200, 0.02, 800), 0.03).is_none());
        assert!(PlaneBeside::among(&points(400, 0.1, 800), 0.03).is_none());
        assert!(PlaneBeside::among(&points(FEWEST - 1, 0.02, 0), 0.03).is_none());
        assert!(PlaneBeside::among(&[Vector3::z(); 100], 0.03).is_none());
    }
}
