//! Whole scenes: what the detector finds without masks and edges.

use super::{Hits, Truths};
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

impl Hits {
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
        let truths = Truths::new(&scene, &taken);
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
