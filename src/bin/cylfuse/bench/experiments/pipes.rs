//! Figures 13 to 15: long pipes that the border of the image cuts off.

use super::{mark, series_of};
use crate::bench::Bench;
use crate::bench::methods::{Errors, Method, errors_of, fit};
use crate::bench::page::{Csv, Section, digits, legend, paragraph, pictures, shown, table};
use crate::bench::picture::{Outline, over_image};
use crate::bench::plot::{Axis, Panel, Series};
use crate::bench::sample::Sample;
use crate::bench::stage;
use crate::bench::statistics::Summary;
use crate::failure::Failure;
use cylfuse::twin::capture;

/// The pipes of the paper by scenario.
const PIPES: [&[(&str, f64)]; 2] = [
    &[("S1-O1, 57 mm", 57.0)],
    &[("S2-O1, 19 mm", 19.0), ("S2-O2, 25.5 mm", 25.5), ("S2-O3, 25.5 mm", 25.5), ("S2-O4, 25.5 mm", 25.5)],
];

fn captures(bench: &Bench) -> usize {
    bench.scale.of(20, 2, 1)
}

pub fn count(bench: &Bench) -> usize {
    PIPES.len() * captures(bench)
}

pub fn run(bench: &Bench) -> Result<Section, Failure> {
    let methods = Method::COMPARED;
    let jobs: Vec<(usize, usize)> =
        (0..PIPES.len()).flat_map(|scenario| (0..captures(bench)).map(move |k| (scenario, k))).collect();
    let rows = bench.map(&jobs, |(scenario, k)| {
        let samples = samples(bench, *scenario, *k)?;
        let errors = samples
            .iter()
            .map(|sample| methods.iter().map(|method| errors_of(fit(sample, *method).as_ref())).collect());
        Ok((*scenario, errors.collect::<Vec<Vec<Errors>>>()))
    })?;
    let errors = |scenario: usize, pipe: usize, method: usize| -> Vec<Errors> {
        let own = rows.iter().filter(|(other, _)| *other == scenario);
        own.filter_map(|(_, pipes)| Some(pipes.get(pipe)?[method])).collect()
    };
    let all: Vec<(usize, usize)> =
        PIPES.iter().enumerate().flat_map(|(s, pipes)| (0..pipes.len()).map(move |k| (s, k))).collect();
    let mut csv = Csv::new(
        "pipes",
        "pipe,radius_mm,method,E_r_mean_pct,E_r_deviation_pct,E_r_worst_pct,E_o_mean_deg,fits",
    );
    let mut table_rows = Vec::new();
    for (scenario, pipe) in &all {
        let (name, radius) = PIPES[*scenario][*pipe];
        for (k, method) in methods.iter().enumerate() {
            let own = errors(*scenario, *pipe, k);
            let s = Summary::of(own.iter().map(|errors| errors[2]));
            let axis = Summary::of(own.iter().map(|errors| errors[0]));
            let numbers = [s.mean, s.deviation, s.worst, axis.mean].map(digits).join(",");
            csv.push(&format!("{},{radius},{},{numbers},{}", &name[..5], method.name(), s.count));
            table_rows.push(vec![
                format!("{name}, {}", method.name()),
                s.cell(),
                shown(s.worst),
                shown(axis.mean),
                format!("{} of {}", own.len() - s.count, own.len()),
            ]);
        }
    }
    let series: Vec<Series> = (methods.iter().enumerate())
        .map(|(k, method)| {
            let point = |(x, (scenario, pipe)): (usize, &(usize, usize))| {
                mark(x as f64 + 1.0, &errors(*scenario, *pipe, k), 2)
            };
            let mut series = series_of(*method, all.iter().enumerate().map(point).collect());
            series.joined = false;
            series
        })
        .collect();
    let panel = Panel {
        title: "radius error by pipe".into(),
        x: Axis {
            labels: 5,
            ..Axis::linear("pipe (1: 57 mm, 2: 19 mm, 3 to 5: 25.5 mm)").with_range(0.5, 5.5)
        },
        y: Axis::logarithmic("radius error E_r (%)"),
        level: None,
        aside: 0.08,
    };
    let mut body = paragraph(&format!(
        "Section 5.7 of the paper: a pipe on a wall and four below a ceiling, longer than the image is wide; {} captures of \
         each scene. The five pipes have the paper's three radii: 57 mm (S1-O1), 19 mm (S2-O1) and 25.5 mm (S2-O2 to S2-O4). \
         The paper publishes its errors only as a picture, and says that its mean errors and deviations are lower than those \
         of the methods that use points alone on all pipes.",
        captures(bench)
    ));
    body.push_str(&legend(&series));
    body.push_str(&pictures(&[panel.draw(&series)?]));
    body.push_str(&table(&["pipe, method", "E_r (%)", "worst (%)", "E_o (°)", "failed"], &table_rows));
    body.push_str(&paragraph(
        "The axis and limbs of each method over the image, the truth in dashed white (Fig. 15):",
    ));
    body.push_str(&pictures(&pictures_of(bench, &methods)?));
    Ok(Section { name: "pipes", title: "Pipes (Fig. 13 to 15)".into(), body, numbers: vec![csv], said: None })
}

/// The pipes of one capture of a scene. All captures of a scene share mask and edges.
fn samples(bench: &Bench, scenario: usize, number: usize) -> Result<Vec<Sample>, Failure> {
    let seed = bench.seed(12, 100 * scenario);
    let scene = stage::pipes(scenario, seed)?;
    let options = stage::capture_options(stage::structured_light())?;
    let taken = capture(&scene, &options, seed + number as u64)?;
    let sample = |pipe: usize| {
        let annotation = seed + 10 + pipe as u64;
        Sample::of_capture(PIPES[scenario][pipe].0.into(), &taken, &options, pipe, annotation)
    };
    (0..taken.cylinders.len()).map(sample).collect()
}

fn pictures_of(bench: &Bench, methods: &[Method]) -> Result<Vec<String>, Failure> {
    // The thinnest pipe, on which the methods differ most.
    let samples = samples(bench, 1, 0)?;
    let Some(sample) = samples.first() else { return Ok(Vec::new()) };
    let mut pictures = Vec::new();
    for method in methods {
        let Some(outcome) = fit(sample, *method) else { continue };
        let Some(extent) = &outcome.extent else { continue };
        let ends = [extent.start, extent.end];
        let axis = sample.truth.cylinder.axis;
        let outlines = [
            Outline { cylinder: outcome.cylinder, ends, color: method.color(), dashed: false },
            Outline {
                cylinder: sample.truth.cylinder,
                ends: ends.map(|end| axis.nearest_to(&end)),
                color: [255, 255, 255],
                dashed: true,
            },
        ];
        let caption = format!("{}, {}: E_r {} %", sample.name, method.name(), shown(outcome.errors[2]));
        pictures.push(over_image(&sample.views[0], &outlines, &caption)?);
    }
    Ok(pictures)
}
