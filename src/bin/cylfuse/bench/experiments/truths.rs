//! What is true of a scene, and how found cylinders compare with it.

use cylfuse::geometry::Cylinder;
use cylfuse::twin::{Capture, Scene};
use nalgebra::Vector3;

/// The largest angle between the axes, in degrees, that counts as a hit.
const MOST_ANGLE: f64 = 5.0;

/// The largest distance of the axes at the middle of what is seen, in true radii.
const MOST_ACROSS: f64 = 0.5;

/// The largest relative error of the radius.
const MOST_RADIUS: f64 = 0.15;

/// A true cylinder.
#[derive(Debug, Clone, Copy)]
pub struct Target {
    /// Axis and radius.
    pub cylinder: Cylinder,
    /// The middle of what is seen of its axis.
    pub middle: Vector3<f64>,
    /// Whether so much is seen that it has to be found.
    pub countable: bool,
}

/// What is true of a scene.
#[derive(Debug, Clone, Default)]
pub struct Truths {
    /// Its cylinders.
    pub cylinders: Vec<Target>,
    /// Cylinders of bottles, which may be found or not.
    pub ignored: Vec<Target>,
}

/// How found cylinders compare with true ones.
#[derive(Debug, Clone, Default)]
pub struct Hits {
    /// Countable cylinders that were found: errors of the axis in degrees and of the radius in %.
    pub found: Vec<[f64; 2]>,
    /// Countable cylinders that were not.
    pub missed: usize,
    /// What was found and is none, and second hits.
    pub wrong: usize,
}

impl Target {
    /// How far a cylinder is off, in radii, degrees and %; `None` where it is no hit.
    pub fn hit(&self, found: &Cylinder) -> Option<[f64; 3]> {
        let angle = self.cylinder.axis.angle(&found.axis).to_degrees();
        let across = (found.axis.nearest_to(&self.middle) - self.middle).norm() / self.cylinder.radius;
        let radius = (found.radius / self.cylinder.radius - 1.0).abs();
        let hit = angle <= MOST_ANGLE && across <= MOST_ACROSS && radius <= MOST_RADIUS;
        hit.then_some([across, angle, 100.0 * radius])
    }
}

impl Truths {
    /// The truth of a scene that was taken.
    pub fn new(scene: &Scene, taken: &Capture) -> Self {
        let cylinders = taken.cylinders.iter().map(|seen| {
            let middle = 0.5 * (seen.visible_along[0] + seen.visible_along[1]);
            Target {
                cylinder: seen.truth.cylinder,
                middle: seen.truth.center + seen.truth.cylinder.axis.direction * middle,
                countable: seen.countable,
            }
        });
        let ignored = scene.ignored.iter().map(|bottle| Target {
            cylinder: bottle.cylinder,
            middle: bottle.center,
            countable: false,
        });
        Self { cylinders: cylinders.collect(), ignored: ignored.collect() }
    }

    /// Compares what was found, best first. Each true cylinder is hit once, by the first that hits it; one that hits
    /// several counts for the nearest. Hits on what is not countable are neither right nor wrong.
    pub fn score(&self, found: &[Cylinder]) -> Hits {
        let mut used = vec![false; self.cylinders.len()];
        let mut hits = Hits::default();
        for cylinder in found {
            let open = self.cylinders.iter().enumerate().filter(|(index, _)| !used[*index]);
            let nearest = open
                .filter_map(|(index, target)| Some((target.hit(cylinder)?, index)))
                .min_by(|a, b| a.0[0].total_cmp(&b.0[0]));
            if let Some(([_, angle, radius], index)) = nearest {
                used[index] = true;
                if self.cylinders[index].countable {
                    hits.found.push([angle, radius]);
                }
                continue;
            }
            let again: Vec<_> =
                self.cylinders.iter().filter(|target| target.hit(cylinder).is_some()).collect();
            let bottle = self.ignored.iter().any(|target| target.hit(cylinder).is_some());
            let wrong = if again.is_empty() { !bottle } else { again.iter().any(|target| target.countable) };
            hits.wrong += usize::from(wrong);
        }
        let countable = self.cylinders.iter().zip(&used).filter(|(target, used)| target.countable && !**used);
        hits.missed = countable.count();
        hits
    }
}

impl Hits {
    /// Those of several scenes together.
    pub fn together<'a>(all: impl IntoIterator<Item = &'a Hits>) -> Self {
        let mut sum = Hits::default();
        for hits in all {
            sum.found.extend(&hits.found);
            sum.missed += hits.missed;
            sum.wrong += hits.wrong;
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn target(x: f64, countable: bool) -> Target {
        let middle = Vector3::new(x, 0.0, 1.0);
        Target { cylinder: Cylinder::new(middle, Vector3::y(), 0.05).unwrap(), middle, countable }
    }

    #[test]
    fn each_cylinder_is_hit_once() {
        let truths = Truths {
            cylinders: vec![target(0.0, true), target(0.3, false)],
            ignored: vec![target(-0.3, false)],
        };
        let at = |x: f64, radius| Cylinder::new(Vector3::new(x, 0.2, 1.0), Vector3::y(), radius).unwrap();
        let right = truths.score(&[at(0.01, 0.052), at(0.3, 0.05), at(-0.3, 0.05)]);
        assert_eq!((right.found.len(), right.missed, right.wrong), (1, 0, 0));
        assert!((right.found[0][1] - 4.0).abs() < 1e-9);
        // The same again, one too thick, one too far aside.
        let wrong = truths.score(&[at(0.0, 0.05), at(0.0, 0.05), at(0.0, 0.06), at(0.03, 0.05)]);
        assert_eq!((wrong.found.len(), wrong.missed, wrong.wrong), (1, 0, 3));
        assert_eq!(truths.score(&[]).missed, 1);
    }
}
