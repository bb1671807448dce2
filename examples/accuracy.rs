//! Errors of every method against the truth of the frames in ../shared, as tables:
//! `cargo run --release --example accuracy`.
#![allow(clippy::unwrap_used)] // A measurement that can't run should stop.

#[path = "../tests/support/frames.rs"]
mod frames;

use cylfuse::fitter::{Method, ObjectiveKind, Options};
use std::path::Path;

/// E_o (degrees), E_p (mm), E_r (%), E_l (%) of one frame, or why there is none.
fn errors(
    folder: &Path,
    options: Options,
    edges: bool,
    image: bool,
) -> Result<[f64; 4], cylfuse::error::Error> {
    let truth = frames::json(&folder.join("truth.json"));
    let cylinder = frames::cylinder(&truth, "center", "axis");
    let mut fitter = frames::fitter_with_edges(folder, edges);
    if image {
        frames::push_image(&mut fitter, folder);
    }
    fitter.set_options(options)?;
    let result = fitter.fit()?;
    let extent = fitter.extent(None, None)?;
    let difference = cylinder.compare(&result.cylinder);
    let length = truth["length"].as_f64().unwrap();
    Ok([
        difference.angle.to_degrees(),
        (extent.center - cylinder.axis.point).norm() * 1e3,
        difference.radius_relative.abs() * 100.0,
        (extent.length / length - 1.0).abs() * 100.0,
    ])
}

/// mean / median / 90 % / worst of one column.
fn summary(mut values: Vec<f64>) -> String {
    values.sort_by(f64::total_cmp);
    let count = values.len();
    let mean = values.iter().sum::<f64>() / count as f64;
    format!("{mean:.2} / {:.2} / {:.2} / {:.2}", values[count / 2], values[count * 9 / 10], values[count - 1])
}

fn main() {
    let fused = |objective| Options { objective, ..Options::default() };
    let alone = |method| Options { method, ..Options::default() };
    let rows = [
        ("paper, w_L = 0.6", fused(ObjectiveKind::Paper), true),
        ("points, w_L = 0", alone(Method::Points), true),
        ("RANSAC", alone(Method::Ransac), true),
        ("Eberly", alone(Method::Eberly), true),
        ("robust with image", fused(ObjectiveKind::Robust), true),
        ("robust", fused(ObjectiveKind::Robust), true),
        ("robust, no edges", fused(ObjectiveKind::Robust), false),
    ];
    for set in ["frames/paper", "frames/wild", "frames/repeat"] {
        let folders = frames::shared_frames(set);
        if folders.is_empty() {
            continue;
        }
        println!("\n### {set}: {} frames, mean / median / 90 % / worst\n", folders.len());
        println!("| method | E_o (deg) | E_p (mm) | E_r (%) | E_l (%) | failed |\n|---|---|---|---|---|---|");
        for (name, options, edges) in &rows {
            let image = name.ends_with("image");
            let all: Vec<_> = folders.iter().map(|folder| errors(folder, *options, *edges, image)).collect();
            let good: Vec<[f64; 4]> = all.iter().filter_map(|outcome| outcome.clone().ok()).collect();
            let columns = [0, 1, 2, 3].map(|k| summary(good.iter().map(|e| e[k]).collect()));
            println!("| {name} | {} | {} |", columns.join(" | "), all.len() - good.len());
        }
    }
}
