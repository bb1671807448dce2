//! `cylfuse bench --frames`: frames with their truth from a folder, single cylinders and whole scenes.

use super::Bench;
use super::experiments::{Hits, SCENES_HEAD, Target, Truths, summary_table};
use super::methods::{Errors, Method, errors_of, fit};
use super::page::{Csv, Section, digits, paragraph, table};
use super::sample::Sample;
use crate::failure::Failure;
use crate::frame::Frame;
use crate::inputs::{Input, find_frames};
use cylfuse::geometry::{Cylinder, RigidMotion};
use cylfuse::scene::Detector;
use nalgebra::Vector3;
use serde::Deserialize;
use std::path::{Path, PathBuf};

const METHODS: [Method; 6] =
    [Method::Ransac, Method::Eberly, Method::Points, Method::Paper, Method::Default, Method::NoEdges];

/// The truth of a scene.
#[derive(Deserialize)]
struct SceneFile {
    cylinders: Vec<TargetFile>,
    #[serde(default)]
    ignore: Vec<TargetFile>,
}

#[derive(Deserialize)]
struct TargetFile {
    center: [f64; 3],
    axis: [f64; 3],
    radius: f64,
    visible_along: Option<[f64; 2]>,
    #[serde(default)]
    countable: bool,
}

/// What a frame gave.
enum Scored {
    Single(String, Vec<Errors>),
    Scene(String, Hits),
}

/// The frame files of a folder that have a truth beside them.
///
/// # Errors
/// `NO_FRAMES`.
pub fn inputs(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let frames = find_frames(&[folder.to_path_buf()]).into_iter().filter_map(|input| match input {
        Input::Frame(path) => path.with_file_name("truth.json").is_file().then_some(path),
        _ => None,
    });
    let frames: Vec<PathBuf> = frames.collect();
    if frames.is_empty() {
        let message =
            "has no frame.json with a truth.json beside it; name a folder of frames with their truth";
        return Err(Failure { status: "NO_FRAMES", message: format!("{}: {message}", folder.display()) });
    }
    Ok(frames)
}

/// Scores them.
///
/// # Errors
/// The first file that cannot be read.
pub fn run(bench: &Bench, inputs: &[PathBuf]) -> Result<Vec<Section>, Failure> {
    let scored = bench.map(inputs, |path| match scene_truth(path)? {
        Some(truths) => score_scene(path, &truths),
        None => {
            let sample = Sample::read(path)?;
            let errors = METHODS.iter().map(|method| errors_of(fit(&sample, *method).as_ref()));
            Ok(Scored::Single(sample.name.clone(), errors.collect()))
        }
    })?;
    let (mut singles, mut scenes) = (Vec::new(), Vec::new());
    for one in scored {
        match one {
            Scored::Single(name, errors) => singles.push((name, errors)),
            Scored::Scene(name, hits) => scenes.push((name, hits)),
        }
    }
    let mut sections = Vec::new();
    if !singles.is_empty() {
        sections.push(section_of_singles(&singles));
    }
    if !scenes.is_empty() {
        sections.push(section_of_scenes(&scenes));
    }
    Ok(sections)
}

fn section_of_singles(singles: &[(String, Vec<Errors>)]) -> Section {
    let mut csv = Csv::new("frames", "frame,method,E_o_deg,E_p_mm,E_r_pct,E_l_pct");
    for (name, by_method) in singles {
        for (method, errors) in METHODS.iter().zip(by_method) {
            let method = method.name().replace(',', "");
            csv.push(&format!("{},{method},{}", name.replace(',', " "), errors.map(digits).join(",")));
        }
    }
    let rows: Vec<(String, Vec<Errors>)> = (METHODS.iter().enumerate())
        .map(|(k, method)| (method.name().into(), singles.iter().map(|(_, errors)| errors[k]).collect()))
        .collect();
    let text = format!(
        "{} frames. The paper's objective takes two edges and fails without; what the truth does not tell (centre and length \
         where an end is hidden, a radius that was not measured) counts nowhere.",
        singles.len()
    );
    let body = paragraph(&text) + &summary_table("method", &rows);
    Section { name: "frames", title: "Frames of one cylinder".into(), body, numbers: vec![csv], said: None }
}

fn section_of_scenes(scenes: &[(String, Hits)]) -> Section {
    let mut csv = Csv::new("scenes", "scene,found,missed,wrong");
    for (name, hits) in scenes {
        csv.push(&format!("{},{},{},{}", name.replace(',', " "), hits.found.len(), hits.missed, hits.wrong));
    }
    let all = Hits::together(scenes.iter().map(|(_, hits)| hits));
    let row = std::iter::once(format!("{} scenes", scenes.len())).chain(all.cells()).collect();
    let head: Vec<&str> = std::iter::once("").chain(SCENES_HEAD).collect();
    let body =
        paragraph("What the detector finds with the image, without mask or edge.") + &table(&head, &[row]);
    Section { name: "scenes", title: "Whole scenes".into(), body, numbers: vec![csv], said: None }
}

/// The truth of a scene; `None` where the frame is one of a single cylinder.
fn scene_truth(path: &Path) -> Result<Option<Truths>, Failure> {
    let truth_path = path.with_file_name("truth.json");
    let text = std::fs::read(&truth_path).map_err(|error| Failure::not_readable(&truth_path, &error))?;
    let Ok(file) = serde_json::from_slice::<SceneFile>(&text) else { return Ok(None) };
    let targets = |list: Vec<TargetFile>| -> Result<Vec<Target>, Failure> {
        let target = |one: TargetFile| {
            let center = Vector3::from(one.center);
            let cylinder = Cylinder::new(center, one.axis.into(), one.radius)?;
            let along = one.visible_along.map_or(0.0, |[from, to]| 0.5 * (from + to));
            let middle = center + cylinder.axis.direction * along;
            Ok(Target { cylinder, middle, countable: one.countable })
        };
        list.into_iter().map(target).collect()
    };
    Ok(Some(Truths { cylinders: targets(file.cylinders)?, ignored: targets(file.ignore)? }))
}

fn score_scene(path: &Path, truths: &Truths) -> Result<Scored, Failure> {
    let views = Frame::read(path, true)?.views;
    let [view] = &views[..] else {
        return Err(Failure::bad_frame(path, "views: a scene with a truth has one view"));
    };
    let mut frame = view.observed()?;
    frame.set_pose(RigidMotion::identity());
    let scene = Detector::new().detect(&frame)?;
    let found: Vec<Cylinder> = scene.cylinders.iter().map(|one| one.result.cylinder).collect();
    let name = path
        .parent()
        .and_then(Path::file_name)
        .map_or_else(String::new, |name| name.to_string_lossy().into());
    Ok(Scored::Scene(name, truths.score(&found)))
}
