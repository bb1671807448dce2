//! The paper's test of the start (its section 5.4.2, equation 33): noise on the true direction, centre and radius,
//! 100 trials a level on six frames. Prints the table; `cargo test --release --test start_perturbation --
//! --nocapture`.

#![allow(clippy::unwrap_used)]

mod support;

#[path = "support/frames.rs"]
mod frames;

use cylfuse::fitter::{NearWall, ObjectiveKind, Options, StartKind};
use cylfuse::geometry::Cylinder;
use nalgebra::Rotation3;
use std::path::Path;
use support::Noise;

const TRIALS: usize = 100;

/// (σ_d in degrees, σ_p in metres, σ_r relative) and the least successes in percent, without and with the
/// near-wall rule. Without it the last level meets the mirror minimum.
const LEVELS: [([f64; 3], [f64; 2]); 4] = [
    ([3.0, 0.003, 0.05], [99.0, 99.0]),
    ([5.0, 0.005, 0.10], [99.0, 99.0]),
    ([8.0, 0.008, 0.15], [99.0, 99.0]),
    ([10.0, 0.015, 0.20], [85.0, 99.0]),
];

/// How many of the trials reach the reference optimum.
fn successes(folder: &Path, [sigma_d, sigma_p, sigma_r]: [f64; 3], near_wall: NearWall) -> usize {
    let truth = frames::cylinder(&frames::json(&folder.join("truth.json")), "center", "axis");
    let optimum = frames::solution(folder, 0.6);
    let (cost, radius) = (optimum["cost"].as_f64().unwrap(), optimum["radius"].as_f64().unwrap());
    let mut fitter = frames::fitter(folder);
    let options =
        Options { objective: ObjectiveKind::Paper, start: StartKind::Model, near_wall, ..Options::default() };
    fitter.set_options(options).unwrap();
    let mut noise = Noise::new(33);
    let reached = |_: &usize| {
        let turn = Rotation3::new(noise.vector() * sigma_d.to_radians());
        let (direction, shift) = (turn * truth.axis.direction, noise.vector() * sigma_p);
        let start = truth.radius * (1.0 + sigma_r * noise.normal());
        let Ok(start) = Cylinder::new(truth.axis.point + shift, direction, start) else { return false };
        fitter.set_start(Some(start));
        let result = fitter.fit();
        result.is_ok_and(|result| {
            (result.cost / cost - 1.0).abs() < 1e-6 && (result.cylinder.radius / radius - 1.0).abs() < 1e-5
        })
    };
    (0..TRIALS).filter(reached).count()
}

#[test]
fn perturbed_starts_reach_the_optimum() {
    let names = ["r20_a0_f0", "r20_a30_f0", "r30_a0_f0", "r30_a30_f0", "r60_a0_f0", "r60_a30_f0"];
    let mut folders = frames::shared_frames("frames/paper");
    if folders.is_empty() {
        return; // `shared_frames` has said so.
    }
    folders.retain(|folder| names.iter().any(|name| folder.ends_with(name)));
    assert_eq!(folders.len(), names.len());
    println!("noise of direction (deg), centre (m), radius: reached alone, with the near-wall rule (%)");
    for (sigmas, least) in LEVELS {
        let percent = [NearWall::Off, NearWall::On].map(|rule| {
            let reached: usize = folders.iter().map(|folder| successes(folder, sigmas, rule)).sum();
            100.0 * reached as f64 / (TRIALS * folders.len()) as f64
        });
        println!("{sigmas:?}: {:.1}, {:.1}", percent[0], percent[1]);
        assert!(percent[0] >= least[0] && percent[1] >= least[1], "{sigmas:?}: {percent:?} below {least:?}");
    }
}
