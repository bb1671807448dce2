//! How much of the truth the stated uncertainties of the frames in ../shared hold, as tables:
//! `cargo run --release --example coverage`.
#![allow(clippy::unwrap_used)] // A measurement that can't run should stop.

#[path = "../tests/support/frames.rs"]
mod frames;

use cylfuse::fitter::{Flags, ObjectiveKind, Options, Uncertainty};
use nalgebra::Vector3;
use std::path::Path;

/// χ² that is exceeded once in 20 times for 5 and 3 degrees of freedom, and the normal deviation.
const REGION: f64 = 11.070;
const CENTER_REGION: f64 = 7.815;
const INTERVAL: f64 = 1.960;

/// What is known of one frame: errors in units of their standard deviation.
struct Outcome {
    radius: f64,
    region: f64,
    center: Option<f64>,
    length: Option<f64>,
    radius_deviation: f64,
    z_score: Option<f64>,
    disagree: bool,
}

fn outcome(
    folder: &Path,
    options: Options,
    edges: bool,
    image: bool,
) -> Result<Outcome, cylfuse::error::Error> {
    let truth = frames::json(&folder.join("truth.json"));
    let cylinder = frames::cylinder(&truth, "center", "axis");
    let mut fitter = frames::fitter_with_edges(folder, edges);
    if image {
        frames::push_image(&mut fitter, folder);
    }
    fitter.set_options(options)?;
    let result = fitter.fit()?;
    let extent = fitter.extent(None, None)?;
    // A fit that does not know its uncertainty holds no truth.
    let of_fit =
        |number: &dyn Fn(&Uncertainty) -> f64| result.uncertainty.as_ref().map_or(f64::INFINITY, number);
    let off: Vector3<f64> = extent.center - cylinder.axis.point;
    Ok(Outcome {
        radius: of_fit(&|u| (result.cylinder.radius - cylinder.radius) / u.radius()),
        region: of_fit(&|u| u.squared_distance(&cylinder)),
        center: extent
            .uncertainty
            .map(|u| u.center.cholesky().map_or(f64::INFINITY, |factor| off.dot(&factor.solve(&off)))),
        length: extent.uncertainty.map(|u| (extent.length - truth["length"].as_f64().unwrap()) / u.length),
        radius_deviation: of_fit(&|u| u.radius() / cylinder.radius),
        z_score: result.radii.map(|radii| radii.z_score()),
        disagree: result.flags.contains(Flags::POINTS_AND_LIMBS_DISAGREE),
    })
}

/// The part of the values that a condition holds for, in percent.
fn part<T>(values: impl IntoIterator<Item = T>, holds: impl Fn(T) -> bool) -> String {
    let held: Vec<bool> = values.into_iter().map(holds).collect();
    if held.is_empty() {
        return "-".into();
    }
    format!("{:.0}", 100.0 * held.iter().filter(|held| **held).count() as f64 / held.len() as f64)
}

/// The median with a number of digits; a dash where there are no values.
fn median(values: impl Iterator<Item = f64>, digits: usize) -> String {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).map_or("-".into(), |value| format!("{value:.digits$}"))
}

fn main() {
    let fused = |objective| Options { objective, ..Options::default() };
    let rows = [
        ("robust with image", fused(ObjectiveKind::Robust), true),
        ("robust", fused(ObjectiveKind::Robust), true),
        ("robust, no edges, with image", fused(ObjectiveKind::Robust), false),
        ("robust, no edges", fused(ObjectiveKind::Robust), false),
        ("paper, w_L = 0.6", fused(ObjectiveKind::Paper), true),
    ];
    for set in ["frames/paper", "frames/wild", "frames/repeat", "frames/tof"] {
        let folders = frames::shared_frames(set);
        if folders.is_empty() {
            continue;
        }
        println!(
            "\n### {set}: {} frames, % of the frames whose truth the 95 % regions hold\n",
            folders.len()
        );
        println!(
            "| method | all five | radius | centre | length | median σ_r (%) | median abs z | disagree (%) |\n\
             |---|---|---|---|---|---|---|---|"
        );
        for (name, options, edges) in rows {
            let image = name.ends_with("image");
            let all: Vec<Outcome> =
                folders.iter().filter_map(|folder| outcome(folder, options, edges, image).ok()).collect();
            println!(
                "| {name} | {} | {} | {} | {} | {} | {} | {} |",
                part(&all, |o| o.region <= REGION),
                part(&all, |o| o.radius.abs() <= INTERVAL),
                part(all.iter().filter_map(|o| o.center), |chi| chi <= CENTER_REGION),
                part(all.iter().filter_map(|o| o.length), |z| z.abs() <= INTERVAL),
                median(all.iter().map(|o| 100.0 * o.radius_deviation), 2),
                median(all.iter().filter_map(|o| o.z_score).map(f64::abs), 1),
                part(all.iter().filter(|o| o.z_score.is_some()), |o| o.disagree),
            );
        }
    }
}
