//! Hypotheses from random samples.

use crate::geometry::{AxisCone, Cylinder, Line};
use crate::memory::List;
use crate::start::moments::Moments;
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::Rng;

/// Points of a sample without normals: one more than a cylinder has degrees of freedom, so that the residual
/// ranks the cylinders through nearly the same points.
pub(super) const PLAIN_SAMPLE: usize = 6;

/// Grid directions for the fit of a sample. Of the minima that fewer directions miss, another sample finds
/// the cylinder.
const SEEDS: usize = 12;

/// A step of the fit of a sample below this (radians) is the last one: what is left is far below what noise does.
const CONVERGED: f64 = 1e-3;

/// Cylinders that are taken from one sample.
const KEPT: usize = 2;

/// Neighbourhoods of a local sample, by their radius in units of the size of the cloud.
const NEIGHBOURHOODS: [f64; 2] = [0.5, 1.0];

/// Squared sine of the angle between two normals below which their cylinder is lost in noise: 5 degrees.
const PARALLEL: f64 = 0.0076;

/// Draws samples and makes cylinders from them.
pub(super) struct Sampler<'a> {
    pub points: &'a [Vector3<f64>],
    /// One for each point, if any.
    pub normals: Option<&'a [Vector3<f64>]>,
    /// Root mean square distance of the points from their mean.
    pub size: f64,
    pub observer_at_origin: bool,
    /// The directions that an axis may have, if not all.
    pub cone: Option<&'a AxisCone>,
}

impl Sampler<'_> {
    /// The cylinders of one sample; none when it is degenerate.
    pub fn draw(&self, rng: &mut ChaCha8Rng) -> List<Cylinder> {
        match self.normals {
            Some(normals) => self.draw_oriented(normals, rng).into_iter().collect(),
            None => self.draw_plain(rng),
        }
    }

    /// Two points with normals: the axis is orthogonal to both normals and meets both normal lines.
    fn draw_oriented(&self, normals: &[Vector3<f64>], rng: &mut ChaCha8Rng) -> Option<Cylinder> {
        let [i, j] = [0; 2].map(|_| below(rng, self.points.len()));
        let (p, q) = (self.points[i], self.points[j]);
        let (mut along_p, mut along_q) = (normals[i].normalize(), normals[j].normalize());
        let mut direction = along_p.cross(&along_q);
        if let (Some(cone), Some(unit)) = (self.cone, direction.try_normalize(0.0)) {
            // The normals of a cylinder about the nearest direction that is allowed.
            let axis = cone.nearest(&unit);
            along_p = (along_p - axis * axis.dot(&along_p)).normalize();
            along_q = (along_q - axis * axis.dot(&along_q)).normalize();
            direction = along_p.cross(&along_q);
        }
        let sine_squared = direction.norm_squared();
        // False for normals that vanish or are not finite.
        let determined = sine_squared > PARALLEL;
        if !determined {
            return None;
        }
        // Where the two normal lines come nearest to each other.
        let from_p = (q - p).cross(&along_q).dot(&direction) / sine_squared;
        let from_q = (q - p).cross(&along_p).dot(&direction) / sine_squared;
        let middle = (p + along_p * from_p + q + along_q * from_q) * 0.5;
        let axis = Line::new(middle, direction);
        let cylinder = Cylinder { axis, radius: 0.5 * (axis.distance(&p) + axis.distance(&q)) };
        Some(self.on_the_visible_wall(cylinder, &[p, q]))
    }

    /// Six points, from everywhere or, for every other sample on average, from a neighbourhood.
    fn draw_plain(&self, rng: &mut ChaCha8Rng) -> List<Cylinder> {
        let local = below(rng, 2) == 0;
        let reach = if local { self.size * NEIGHBOURHOODS[below(rng, 2)] } else { f64::INFINITY };
        let mut sample = List::with_capacity(PLAIN_SAMPLE);
        sample.push(self.points[below(rng, self.points.len())]);
        // Lonely points have no neighbours.
        for _ in 0..20 * PLAIN_SAMPLE {
            let p = self.points[below(rng, self.points.len())];
            if (p - sample[0]).norm() <= reach && !sample.contains(&p) {
                sample.push(p);
            }
            if sample.len() == PLAIN_SAMPLE {
                break;
            }
        }
        let Some(moments) = Moments::new(sample.iter().map(|p| (*p, 1.0))) else { return List::new() };
        let minima = moments.minima(self.cone, SEEDS, CONVERGED);
        let fits = minima.into_iter().take(KEPT);
        fits.map(|fit| self.on_the_visible_wall(fit.cylinder, &sample)).collect()
    }

    /// The cylinder or, when the observer could not see most of the sample on it, its mirror image behind
    /// the sample: noise turns the curvature of a sample round.
    fn on_the_visible_wall(&self, cylinder: Cylinder, sample: &[Vector3<f64>]) -> Cylinder {
        let hidden = self.observer_at_origin
            && !cylinder.contains_origin()
            && cylinder.visible_wall(sample.iter().copied()).fraction() < 0.5;
        if hidden { cylinder.mirrored_away() } else { cylinder }
    }
}

/// A random index below `count`, which must be less than 2³².
pub(crate) fn below(rng: &mut ChaCha8Rng, count: usize) -> usize {
    ((u64::from(rng.next_u32()) * count as u64) >> 32) as usize
}
