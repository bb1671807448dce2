//! Figure 7: noise on the endpoints of the edges.

use super::{head, mark, panels, series_of};
use crate::bench::Bench;
use crate::bench::methods::{Errors, METRICS, Method, Variation, errors_of, fit_with};
use crate::bench::page::{Csv, Section, digits, paragraph, pictures, table};
use crate::bench::plot::{Axis, Mark, Series};
use crate::bench::published::ENDPOINTS;
use crate::bench::statistics::Summary;
use crate::failure::Failure;

const METHODS: [Method; 2] = [Method::Paper, Method::Default];
const LEVELS: [u32; 5] = [0, 1, 2, 3, 4];

/// Trials that are one step of the progress bar.
const BATCH: usize = 10;

fn trials(bench: &Bench) -> usize {
    bench.scale.of(100, 10, 10)
}

pub fn count(bench: &Bench) -> usize {
    bench.scale.of(6, 6, 2) * LEVELS.len() * (trials(bench) / BATCH)
}

pub fn run(bench: &Bench) -> Result<Section, Failure> {
    let samples = bench.validation()?;
    let trials = trials(bench);
    let mut jobs = Vec::new();
    for level in LEVELS {
        for sample in 0..samples.len() {
            jobs.extend((0..trials / BATCH).map(|batch| (level, sample, batch)));
        }
    }
    let rows = bench.map(&jobs, |(level, sample, batch)| {
        let trial = |k: usize| {
            let seed = bench.seed(10, sample * 1000 + *level as usize * 100 + batch * BATCH + k);
            let edges = samples[*sample].disturbed_edges(f64::from(*level), seed);
            let variation = || Variation { edges: Some(&edges), ..Variation::default() };
            METHODS.map(|method| errors_of(fit_with(&samples[*sample], method, &variation()).as_ref()))
        };
        // Without noise all trials are the same.
        let count = if *level == 0 && *batch > 0 { 0 } else { BATCH };
        Ok((*level, (0..if *level == 0 { count.min(1) } else { count }).map(trial).collect::<Vec<_>>()))
    })?;
    let errors = |level: u32, method: usize| -> Vec<Errors> {
        let of_level = rows.iter().filter(|(other, _)| *other == level);
        of_level.flat_map(|(_, trials)| trials.iter().map(|both| both[method])).collect()
    };
    let mut csv = Csv::new("endpoints", "noise_px,method,error,mean,deviation,median,90_percent,worst,fits");
    let mut table_rows = Vec::new();
    for level in LEVELS {
        for (k, method) in METHODS.iter().enumerate() {
            let of_method = errors(level, k);
            let mut cells = vec![format!("{level} px, {}", method.name())];
            for (index, metric) in METRICS.iter().enumerate() {
                let s = Summary::of(of_method.iter().map(|errors| errors[index]));
                let numbers = [s.mean, s.deviation, s.median, s.ninety, s.worst].map(digits).join(",");
                csv.push(&format!("{level},{},{},{numbers},{}", method.name(), metric.symbol, s.count));
                cells.push(s.cell());
            }
            table_rows.push(cells);
        }
        if let Some((_, published)) = ENDPOINTS.iter().find(|(other, _)| *other == level) {
            let sign = if level == 2 { "< " } else { "" };
            let cells = published.iter().map(|error| format!("{sign}{error}"));
            table_rows
                .push(std::iter::once(format!("{level} px, published by the paper")).chain(cells).collect());
        }
    }
    let axis = Axis::linear("noise of the endpoints (px)");
    let (plots, legend) = panels("six frames, mean and deviation", &axis, 0.06, |metric| {
        let own = METHODS.iter().enumerate().map(|(k, method)| {
            let marks = LEVELS.iter().map(|level| mark(f64::from(*level), &errors(*level, k), metric));
            series_of(*method, marks.collect())
        });
        let published = Series {
            name: "published by the paper".into(),
            color: [90, 90, 90],
            marks: ENDPOINTS
                .iter()
                .map(|(level, errors)| Mark { x: f64::from(*level), y: errors[metric], spread: 0.0 })
                .collect(),
            joined: false,
        };
        own.chain([published]).collect()
    })?;
    let body = paragraph(&format!(
        "Section 5.4.1 of the paper: normal noise on both coordinates of every endpoint, {trials} trials on each of {} \
         frames. cylfuse takes edges as hints only and locates the limbs in the image. The published figures are means on \
         the paper's own camera, that of 2 px an upper bound.",
        samples.len()
    )) + &legend
        + &pictures(&plots)
        + &table(&head("mean ± deviation"), &table_rows);
    Ok(Section {
        name: "endpoints",
        title: "Noise of the edges (Fig. 7)".into(),
        body,
        numbers: vec![csv],
        said: None,
    })
}
