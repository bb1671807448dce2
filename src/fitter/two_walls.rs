//! A pipe that was scanned from outside and from inside: the points of both walls lie on a cylinder between them as well as robust
//! fits ask for, though none is on it.

use super::among_points::FEWEST;
use super::points_alone::is_as_good;
use super::run::Run;
use super::view::View;
use super::{Fitted, Fitter};
use crate::error::{Result, unless_cancelled};
use crate::geometry::Cylinder;
use crate::memory::List;
use crate::observations::spread;
use crate::residuals::TUKEY_EFFICIENT;
use crate::statistics::at_both_ends;

/// About how many points tell two walls.
const SAMPLE: usize = 1000;

/// Nearer to the cylinder than this part of their root mean square distance is less than this part of the points: of normal noise a fifth
/// is, and a ninth where a cylinder is wrong in waves.
const NEAR: f64 = 0.25;
const HARDLY_ANY: f64 = 0.05;

/// Each wall has this part of the points at least: a robust fit passes by fewer.
const LEAST_OF_WALL: f64 = 0.2;

impl Fitter {
    /// The fit to one wall of a pipe where that before lies between both: to the wall with more points, or with the radius that is known.
    #[inline(never)] // Not inlined: its locals would enlarge the caller's stack frame.
    pub(super) fn fit_to_one_wall(&self, view: &View, fit: Fitted, run: &mut Run<'_>) -> Result<Fitted> {
        let cylinder = view.seen(&fit.result.cylinder);
        let Some([inner, outer]) = walls(view, &cylinder, fit.result.point_scale) else { return Ok(fit) };
        let is_outer = match self.known_cylinder() {
            Some(known) => known.radius > cylinder.radius,
            None => outer >= inner,
        };
        let is_of_wall = |k: &usize| (cylinder.distance(&view.cloud.point(*k)) > 0.0) == is_outer;
        let of_wall: List<usize> = (0..view.cloud.len()).filter(is_of_wall).collect();
        if of_wall.len() < FEWEST {
            return Ok(fit);
        }
        let again = unless_cancelled(self.fit_of_points(view, &of_wall, Some(&cylinder), run))?;
        Ok(again.ok().filter(|again| is_as_good(&fit.result, &again.result)).unwrap_or(fit))
    }
}

/// How many of some points about a cylinder, by which they scatter by `scale`, lie within and beyond it, where these are two walls with
/// nothing between them, side by side along the axis.
fn walls(view: &View, cylinder: &Cylinder, scale: f64) -> Option<[usize; 2]> {
    let some = spread(view.cloud.len(), SAMPLE);
    let points = some.iter().map(|&k| view.cloud.point(k));
    let points = points.map(|point| (cylinder.distance(&point), cylinder.axis.position_of(&point)));
    let near: List<(f64, f64)> =
        points.filter(|(distance, _)| distance.abs() <= TUKEY_EFFICIENT * scale).collect();
    let count = near.len() as f64;
    let deviation = (near.iter().map(|(distance, _)| distance * distance).sum::<f64>() / count).sqrt();
    let between = near.iter().filter(|(distance, _)| distance.abs() < NEAR * deviation).count();
    let [mut inner, mut outer] = [List::new(), List::new()];
    near.iter()
        .for_each(|(distance, along)| if *distance > 0.0 { outer.push(*along) } else { inner.push(*along) });
    let counts = [inner.len(), outer.len()];
    let least = (LEAST_OF_WALL * count).max(1.0);
    if between as f64 > HARDLY_ANY * count || counts.iter().any(|&of_wall| (of_wall as f64) < least) {
        return None;
    }
    // Those of a shaft with a step follow each other.
    let [[a, b], [c, d]] = [inner, outer].map(|wall| at_both_ends(&wall, wall.len() / 4));
    (a.max(c) < b.min(d)).then_some(counts)
}

#[cfg(test)]
mod tests {
    use crate::fitter::Fitter;
    use crate::geometry::Cylinder;
    use crate::observations::PointsView;
    use crate::statistics::random_number as number;
    use nalgebra::Vector3;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use std::f64::consts::PI;

    /// So many points of both walls of a pipe about z, of radius 1 and 1 - `thickness`.
    fn pipe(seed: u64, thickness: f64, [outer, inner]: [usize; 2]) -> Vec<[f64; 3]> {
        let rng = &mut ChaCha8Rng::seed_from_u64(seed);
        let mut point = |radius: f64| {
            let (angle, along) = (PI * number(rng), 3.0 * number(rng));
            let radius = radius + 0.005 * number(rng);
            [5.0 + radius * angle.cos(), radius * angle.sin(), along]
        };
        let of_outer: Vec<[f64; 3]> = (0..outer).map(|_| point(1.0)).collect();
        of_outer.into_iter().chain((0..inner).map(|_| point(1.0 - thickness))).collect()
    }

    /// The radius was half a wall too small, stated to a thousandth.
    #[test]
    fn both_walls_of_a_pipe_give_the_radius_of_the_one_with_more_points() {
        for thickness in [0.03, 0.1, 0.2] {
            for counts in [[3000, 3000], [3000, 1800], [1800, 3000]] {
                for seed in 0..3 {
                    let mut fitter = Fitter::new();
                    fitter.push_points(&PointsView::from_f64(&pipe(seed, thickness, counts)), None).unwrap();
                    let fit = fitter.fit().unwrap();
                    let radius = if counts[0] >= counts[1] { 1.0 } else { 1.0 - thickness };
                    let off = (fit.cylinder.radius - radius).abs();
                    let stated = fit.uncertainty.unwrap().radius();
                    assert!(off < 4.0 * stated && stated < 1e-3, "{thickness} {counts:?}: {off} {stated}");
                }
            }
        }
    }

    #[test]
    fn of_two_walls_the_known_one_is_meant() {
        for radius in [0.9, 1.0] {
            let mut fitter = Fitter::new();
            fitter.push_points(&PointsView::from_f64(&pipe(1, 0.1, [3000, 3000])), None).unwrap();
            fitter.set_start(Some(Cylinder::new(Vector3::new(5.0, 0.0, 0.0), Vector3::z(), radius).unwrap()));
            let fit = fitter.fit().unwrap();
            assert!((fit.cylinder.radius - radius).abs() < 1e-3, "{radius}: {}", fit.cylinder.radius);
        }
    }
}
