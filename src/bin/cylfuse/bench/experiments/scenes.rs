//! Whole scenes: what the detector finds without masks and edges.

use crate::bench::Bench;
use crate::bench::page::{Csv, Section, digits, paragraph, shown, table};
use crate::bench::program::Program;
use crate::bench::stage;
use crate::bench::statistics::Summary;
use crate::failure::Failure;
use cylfuse::camera::Camera;
use cylfuse::geometry::Cylinder;
use cylfuse::observations::{DepthRange, DepthView, Frame, ImageView};
use cylfuse::scene::Detector;
use cylfuse::twin::{ActiveStereo, DEPTH_UNIT, DepthSensor, Kind, TimeOfFlight, capture, random_scene};
use nalgebra::{Vector2, Vector3};

/// What counts as a hit: the angle of the axes in degrees, the distance of the axes in true radii at the middle of what is
/// seen, the relative error of the radius.
const LIMITS: [f64; 3] = [5.0, 0.5, 0.15];

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
    /// How far a cylinder is off; `None` where it is no hit.
    fn hit(&self, found: &Cylinder) -> Option<[f64; 3]> {
        let angle = self.cylinder.axis.angle(&found.axis).to_degrees();
        let across = (found.axis.nearest_to(&self.middle) - self.middle).norm() / self.cylinder.radius;
        let radius = (found.radius / self.cylinder.radius - 1.0).abs();
        let hit = angle <= LIMITS[0] && across <= LIMITS[1] && radius <= LIMITS[2];
        hit.then_some([across, angle, 100.0 * radius])
    }
}

impl Truths {
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

    /// Cylinders, recall, precision, errors of radius and axis, as cells of [`HEAD`].
    pub fn cells(&self) -> Vec<String> {
        let (found, all) = (self.found.len() as f64, (self.found.len() + self.missed) as f64);
        let radius = Summary::of(self.found.iter().map(|[_, radius]| *radius));
        let axis = Summary::of(self.found.iter().map(|[angle, _]| *angle));
        let three = |s: Summary| [s.median, s.ninety, s.worst].map(shown).join(" / ");
        vec![
            format!("{all}"),
            shown(found / all),
            shown(found / (found + self.wrong as f64)),
            three(radius),
            three(axis),
        ]
    }
}

/// The head of tables of [`Hits::cells`].
pub const HEAD: [&str; 5] =
    ["to find", "recall", "precision", "E_r (%), median / 90 % / worst", "E_o (°), median / 90 % / worst"];

fn sets() -> [(&'static str, Kind, DepthSensor); 4] {
    let flight = DepthSensor::TimeOfFlight(TimeOfFlight::default());
    let stereo = DepthSensor::ActiveStereo(ActiveStereo::default());
    [
        ("table, structured light", Kind::Table, stage::structured_light()),
        ("pipes, structured light", Kind::Pipes, stage::structured_light()),
        ("table, time of flight", Kind::Table, flight),
        ("table, active stereo", Kind::Table, stereo),
    ]
}

/// The other libraries that are compared.
fn programs(bench: &Bench) -> impl Iterator<Item = &Program> {
    bench.pcl.iter().chain(&bench.cgal)
}

/// The points of a depth image.
fn cloud(camera: &Camera, depth: &[u16]) -> impl Iterator<Item = Vector3<f64>> {
    let (width, _) = camera.size();
    let seen = depth.iter().enumerate().filter(|(_, z)| **z > 0);
    seen.filter_map(move |(k, z)| {
        let ray = camera.unproject(&Vector2::new((k % width) as f64, (k / width) as f64))?;
        Some(ray * (f64::from(*z) * DEPTH_UNIT / ray.z))
    })
}

fn jobs(bench: &Bench) -> Vec<(usize, usize)> {
    let count = |set: usize| bench.scale.of([20, 12, 8, 8][set], 1, usize::from(set == 1));
    (0..sets().len()).flat_map(|set| (0..count(set)).map(move |k| (set, k))).collect()
}

pub fn count(bench: &Bench) -> usize {
    jobs(bench).len()
}

pub fn run(bench: &Bench) -> Result<Section, Failure> {
    let jobs = jobs(bench);
    let rows = bench.map(&jobs, |(set, k)| {
        let (_, kind, sensor) = sets()[*set];
        let seed = bench.seed(30 + *set as u64, *k);
        let scene = random_scene(kind, seed)?;
        let options = stage::capture_options(sensor)?;
        let taken = capture(&scene, &options, seed)?;
        let size = options.camera.size();
        let mut truths = Truths::default();
        for seen in &taken.cylinders {
            let middle = 0.5 * (seen.visible_along[0] + seen.visible_along[1]);
            truths.cylinders.push(Target {
                cylinder: seen.truth.cylinder,
                middle: seen.truth.center + seen.truth.cylinder.axis.direction * middle,
                countable: seen.countable,
            });
        }
        truths.ignored.extend(scene.ignored.iter().map(|bottle| Target {
            cylinder: bottle.cylinder,
            middle: bottle.center,
            countable: false,
        }));
        let mut scored = Vec::new();
        for with_image in [true, false] {
            let mut frame = Frame::new(options.camera.clone());
            frame.set_depth(&DepthView::from_u16(&taken.depth, size, DEPTH_UNIT)?, &DepthRange::default())?;
            if with_image {
                frame.set_image(&ImageView::from_u8(&taken.image, size)?)?;
            }
            let scene = Detector::new().detect(&frame)?;
            let found: Vec<Cylinder> = scene.cylinders.iter().map(|one| one.result.cylinder).collect();
            scored.push(truths.score(&found));
        }
        let points = || cloud(&options.camera, &taken.depth);
        for program in programs(bench) {
            scored.push(truths.score(&program.detect(points())?));
        }
        Ok((*set, scored))
    })?;
    let mut csv = Csv::new(
        "scenes",
        "set,method,to_find,found,wrong,E_r_median_pct,E_r_90_pct,E_o_median_deg,E_o_90_deg",
    );
    let mut table_rows = Vec::new();
    for (index, (name, _, _)) in sets().iter().enumerate() {
        let methods = ["with image", "without image"].into_iter();
        for (which, method) in methods.chain(programs(bench).map(|program| program.library)).enumerate() {
            let own = rows.iter().filter(|(set, _)| *set == index).map(|(_, scored)| &scored[which]);
            let frames = own.clone().count();
            if frames == 0 {
                continue;
            }
            let hits = Hits::together(own);
            let radius = Summary::of(hits.found.iter().map(|[_, radius]| *radius));
            let axis = Summary::of(hits.found.iter().map(|[angle, _]| *angle));
            let numbers = [radius.median, radius.ninety, axis.median, axis.ninety].map(digits).join(",");
            let (found, missed) = (hits.found.len(), hits.missed);
            csv.push(&format!(
                "{},{method},{},{found},{},{numbers}",
                name.replace(',', ""),
                found + missed,
                hits.wrong
            ));
            let first = format!("{frames} of {name}, {method}");
            table_rows.push(std::iter::once(first).chain(hits.cells()).collect());
        }
    }
    let head: Vec<&str> = std::iter::once("scenes").chain(HEAD).collect();
    let body = paragraph(
        "Random scenes of the twin, searched without mask or edge. A hit: axes within 5°, the found axis within half a radius \
         of the true one at the middle of what is seen, radii within 15 %; each cylinder once. Recall counts those of which \
         enough is seen (900 pixels, 540 of them with depth); hits on others and on bottles count neither way. PCL and CGAL, \
         where they are there, get the points of the depth alone and work as tests/cpp/bench_pcl.cpp and bench_cgal.cpp say.",
    ) + &table(&head, &table_rows);
    Ok(Section { name: "scenes", title: "Whole scenes".into(), body, numbers: vec![csv], said: None })
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
