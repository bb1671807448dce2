//! The weights of the scores of detected cylinders (`src/detection/score.rs`), by logistic regressions on the candidates in
//! scenes of the twin: `cargo run --release --features twin --example score_weights`. Prints them, and what they find in
//! those scenes, a fifth of which is left out of the regression in turn.
#![allow(clippy::unwrap_used)] // A measurement that can't run should stop.

#[path = "../tests/support/parallel.rs"]
mod parallel;
#[path = "scenes/taken.rs"]
mod taken;
#[allow(dead_code, reason = "shared with the command bench, which uses all of it")]
#[path = "../src/bin/cylfuse/bench/experiments/truths.rs"]
mod truths;

use cylfuse::detection::{DetectionOptions, Evidence, detect};
use cylfuse::geometry::Cylinder;
use cylfuse::scene::{Detector, DetectorOptions};
use cylfuse::twin::{DepthSensor, Kind, StructuredLight, TimeOfFlight};
use nalgebra::{DMatrix, DVector};
use taken::{camera, capture_frame};
use truths::{Hits, Truths};

/// Kinds, sensors by name, and seeds of the scenes: as many tables and pipes to one by time of flight as in ../shared/scenes, and
/// other seeds than those of tests and measurements.
fn sets() -> [(Kind, DepthSensor, std::ops::Range<u64>); 6] {
    let light = DepthSensor::StructuredLight(StructuredLight::default());
    let flight = DepthSensor::TimeOfFlight(TimeOfFlight::default());
    [
        (Kind::Table, light, 5001..5051),
        (Kind::Pipes, light, 5001..5026),
        (Kind::Table, flight, 6001..6026),
        (Kind::Pipes, flight, 6001..6011),
        (Kind::NoCylinders, light, 7001..7026),
        (Kind::NoCylinders, flight, 7101..7116),
    ]
}

/// As how many scenes one without cylinders counts, by depth alone and with an image: boxes, to which an image gives edges as
/// well, look like cylinders by depth.
const WITHOUT_CYLINDERS: [f64; 2] = [1.5, 0.25];

/// The penalty for the square of a weight of a term that has a standard deviation of 1: terms that tell the same share it.
const RIDGE: f64 = 3.0;

/// Parts of the scenes, each of which is left out in turn.
const PARTS: usize = 5;

/// A candidate.
#[derive(Clone, Copy)]
struct Row {
    cylinder: Cylinder,
    evidence: Evidence,
}

/// A scene with its candidates, by depth alone and with the image, each before and after the fits.
struct Searched {
    truths: Truths,
    rows: [[Vec<Row>; 2]; 2],
}

fn searched(kind: Kind, sensor: DepthSensor, seed: u64) -> Searched {
    let (frame, truths) = capture_frame(kind, sensor, seed, seed);
    let search = DetectionOptions { min_score: 0.0, ..DetectionOptions::default() };
    let rows = [false, true].map(|use_image| {
        let image = frame.image().filter(|_| use_image);
        let seen = detect(&camera(), frame.depth_on_image().unwrap(), image, &search).unwrap();
        // The search takes its choice before it knows the slope.
        let unsloped = |evidence| Evidence { slope: None, ..evidence };
        let before = seen.cylinders.iter().map(|one| (one.cylinder, unsloped(one.evidence)));
        let before = before.map(|(cylinder, evidence)| Row { cylinder, evidence });
        let mut detector = Detector::new();
        detector.set_options(DetectorOptions { search, use_image, ..DetectorOptions::default() }).unwrap();
        let found = detector.detect(&frame).unwrap().cylinders;
        let after = found.iter().map(|one| Row { cylinder: one.result.cylinder, evidence: one.evidence });
        [before.collect(), after.collect()]
    });
    Searched { truths, rows }
}

/// All scenes.
fn all() -> Vec<Searched> {
    let jobs: Vec<_> = sets()
        .into_iter()
        .flat_map(|(kind, sensor, seeds)| seeds.map(move |seed| (kind, sensor, seed)))
        .collect();
    parallel::map(&jobs, |(kind, sensor, seed)| searched(*kind, *sensor, *seed))
}

/// The candidates of a stage in some scenes as terms with a 1 behind, whether there is a cylinder, and as how many each counts.
fn candidates<'a>(
    scenes: impl Iterator<Item = &'a Searched>,
    image: usize,
    stage: usize,
) -> Vec<(Vec<f64>, f64, f64)> {
    let mut found = Vec::new();
    for Searched { truths, rows } in scenes {
        let counts = if truths.cylinders.is_empty() { WITHOUT_CYLINDERS[image] } else { 1.0 };
        for row in &rows[image][stage] {
            // A second part of a pipe, a bottle and what is hidden too far to be asked for are cylinders all the same.
            let mut targets = truths.cylinders.iter().chain(&truths.ignored);
            let right = targets.any(|target| target.hit(&row.cylinder).is_some());
            let terms = row.evidence.terms().into_iter().chain([1.0]).collect();
            found.push((terms, f64::from(u8::from(right)), counts));
        }
    }
    found
}

/// The weights of the terms and the constant, by Newton's method.
fn regression(rows: &[(Vec<f64>, f64, f64)]) -> Vec<f64> {
    let (count, size) = (rows.len() as f64, rows[0].0.len());
    let mean = |k: usize| rows.iter().map(|row| row.0[k]).sum::<f64>() / count;
    let variance = |k: usize| {
        let mean = mean(k);
        rows.iter().map(|row| (row.0[k] - mean).powi(2)).sum::<f64>() / count
    };
    // A term that is the same everywhere, as one that is not known, gets no weight.
    let ridge: Vec<f64> = (0..size).map(|k| if k + 1 == size { 0.0 } else { RIDGE * variance(k) }).collect();
    let mut weights = DVector::zeros(size);
    for _ in 0..50 {
        let mut matrix = DMatrix::zeros(size, size);
        let mut vector = DVector::zeros(size);
        for (terms, right, counts) in rows {
            let row = DVector::from_column_slice(terms);
            let score = 1.0 / (1.0 + (-row.dot(&weights)).exp());
            matrix += &row * row.transpose() * (counts * score * (1.0 - score));
            vector += row * (counts * (right - score));
        }
        for k in 0..size {
            vector[k] -= ridge[k] * weights[k];
            let flat = if k + 1 < size && ridge[k] == 0.0 { 1.0 } else { 0.0 };
            matrix[(k, k)] += ridge[k] + flat;
            vector[k] *= 1.0 - flat;
        }
        let step = matrix.cholesky().unwrap().solve(&vector);
        // The logarithm of the odds changes by a few units at most in one step.
        weights += &step * (3.0 / step.amax()).min(1.0);
    }
    weights.iter().copied().collect()
}

fn score(weights: &[f64], evidence: &Evidence) -> f64 {
    let sum: f64 =
        evidence.terms().iter().chain(&[1.0]).zip(weights).map(|(term, weight)| term * weight).sum();
    1.0 / (1.0 + (-sum).exp())
}

/// Recall and precision of what weights find with a score of a half, each part of the scenes by weights from the others, and
/// the scenes without cylinders in which something is found.
fn left_out(scenes: &[Searched], image: usize, stage: usize) -> String {
    let (mut hits, mut complaints) = (Vec::new(), 0);
    for part in 0..PARTS {
        let others = scenes.iter().enumerate().filter(|(k, _)| k % PARTS != part).map(|(_, scene)| scene);
        let weights = regression(&candidates(others, image, stage));
        for scene in scenes.iter().skip(part).step_by(PARTS) {
            let mut found: Vec<(f64, Cylinder)> = scene.rows[image][stage]
                .iter()
                .map(|row| (score(&weights, &row.evidence), row.cylinder))
                .filter(|(score, _)| *score >= 0.5)
                .collect();
            found.sort_by(|a, b| b.0.total_cmp(&a.0));
            let found: Vec<Cylinder> = found.into_iter().map(|(_, cylinder)| cylinder).collect();
            if scene.truths.cylinders.is_empty() {
                complaints += usize::from(!found.is_empty());
            } else {
                hits.push(scene.truths.score(&found));
            }
        }
    }
    let Hits { found, missed, wrong } = Hits::together(&hits);
    let (right, all) = (found.len() as f64, (found.len() + missed) as f64);
    format!(
        "{all} cylinders, recall {:.3}, precision {:.3}; something in {complaints} scenes without",
        right / all,
        right / (right + wrong as f64)
    )
}

/// By how much fits multiply the odds, by the weights that stand in the code: the most in 99.8 of 100 candidates.
fn most_by_fit(scenes: &[Searched], image: usize) -> f64 {
    let rows = scenes.iter().flat_map(|scene| &scene.rows[image][1]);
    let odds = |evidence: Evidence| evidence.score() / (1.0 - evidence.score());
    let unfitted = |evidence| Evidence { radius_deviation: None, slope: None, ..evidence };
    let mut factors: Vec<f64> = rows.map(|row| odds(row.evidence) / odds(unfitted(row.evidence))).collect();
    factors.sort_by(f64::total_cmp);
    factors[(factors.len() as f64 * 0.998) as usize]
}

fn main() {
    let scenes = all();
    for (image, name) in ["depth", "image"].into_iter().enumerate() {
        for stage in [0, 1] {
            let rows = candidates(scenes.iter(), image, stage);
            let weights = regression(&rows);
            let wrong = rows.iter().filter(|row| row.1 == 0.0).count();
            println!(
                "{name}, {} a fit: {} candidates, {wrong} wrong",
                ["before", "after"][stage],
                rows.len()
            );
            let (constant, terms) = weights.split_last().unwrap();
            let terms: Vec<String> = terms.iter().map(|weight| format!("{weight:.3}")).collect();
            println!("    terms: [{}],\n    constant: {constant:.3},", terms.join(", "));
            println!("  left out: {}", left_out(&scenes, image, stage));
        }
        println!("  a fit multiplies the odds by {:.1} at most", most_by_fit(&scenes, image));
    }
}
