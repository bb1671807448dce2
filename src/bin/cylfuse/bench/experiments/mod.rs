//! The experiments, each with its own section of the report.

mod compare;
mod endpoints;
mod gallery;
mod pipes;
mod scenes;
mod sensors;
mod starts;
mod sweeps;
mod time;
mod truths;
mod weights;

pub use scenes::HEAD as SCENES_HEAD;
pub use truths::{Hits, Target, Truths};

use super::Bench;
use super::methods::{Errors, METRICS, Method};
use super::page::{Section, shown};
use super::plot::{Axis, Mark, Panel, Series};
use super::program::Task;
use super::statistics::Summary;
use crate::failure::Failure;

/// An experiment.
pub struct Experiment {
    /// What `--only` calls it.
    pub name: &'static str,
    /// What it asks of the programs of other libraries.
    pub asks: Option<Task>,
    /// How many steps of the progress bar it takes.
    pub count: fn(&Bench) -> usize,
    /// Does it.
    pub run: fn(&Bench) -> Result<Section, Failure>,
}

/// All experiments in the order of the report.
pub const EXPERIMENTS: [Experiment; NAMES.len()] = [
    Experiment { name: NAMES[0], asks: Some(Task::Fit), count: compare::count, run: compare::run },
    Experiment { name: NAMES[1], asks: None, count: weights::count, run: weights::run },
    Experiment { name: NAMES[2], asks: None, count: endpoints::count, run: endpoints::run },
    Experiment { name: NAMES[3], asks: None, count: starts::count, run: starts::run },
    Experiment { name: NAMES[4], asks: Some(Task::Fit), count: gallery::count, run: gallery::run },
    Experiment { name: NAMES[5], asks: None, count: pipes::count, run: pipes::run },
    Experiment { name: NAMES[6], asks: Some(Task::Fit), count: time::count, run: time::run },
    Experiment { name: NAMES[7], asks: None, count: sensors::count, run: sensors::run },
    Experiment {
        name: NAMES[8],
        asks: None,
        count: |bench| sweeps::DISTANCE.count(bench),
        run: |bench| sweeps::DISTANCE.run(bench),
    },
    Experiment {
        name: NAMES[9],
        asks: None,
        count: |bench| sweeps::TILT.count(bench),
        run: |bench| sweeps::TILT.run(bench),
    },
    Experiment {
        name: NAMES[10],
        asks: None,
        count: |bench| sweeps::ARC.count(bench),
        run: |bench| sweeps::ARC.run(bench),
    },
    Experiment {
        name: NAMES[11],
        asks: None,
        count: |bench| sweeps::BAR.count(bench),
        run: |bench| sweeps::BAR.run(bench),
    },
    Experiment {
        name: NAMES[12],
        asks: None,
        count: |bench| sweeps::LIGHT.count(bench),
        run: |bench| sweeps::LIGHT.run(bench),
    },
    Experiment { name: NAMES[13], asks: Some(Task::Scene), count: scenes::count, run: scenes::run },
];

/// Their names.
pub const NAMES: [&str; 14] = [
    "compare",
    "weights",
    "endpoints",
    "starts",
    "pictures",
    "pipes",
    "time",
    "sensors",
    "distance",
    "tilt",
    "arc",
    "occlusion",
    "light",
    "scenes",
];

/// A series of means with standard deviations.
fn series_of(method: Method, marks: Vec<Mark>) -> Series {
    Series { name: method.name().into(), color: method.color(), marks, joined: true }
}

/// The mean and standard deviation of an error at a position of an axis.
fn mark(x: f64, errors: &[Errors], metric: usize) -> Mark {
    let summary = Summary::of(errors.iter().map(|errors| errors[metric]));
    Mark { x, y: summary.mean, spread: summary.deviation }
}

/// A panel for each of the four errors.
///
/// # Errors
/// Those of drawing.
fn panels(
    title: &str,
    x: &Axis,
    aside: f64,
    series: impl Fn(usize) -> Vec<Series>,
) -> Result<(Vec<String>, String), Failure> {
    let mut pictures = Vec::new();
    for (index, metric) in METRICS.iter().enumerate() {
        let panel = Panel {
            title: title.into(),
            x: x.clone(),
            y: Axis::logarithmic(format!("{} ({})", metric.name, metric.unit)),
            level: None,
            aside,
        };
        let series = series(index);
        // No fit of any method tells this error.
        if series.iter().all(|series| series.marks.iter().all(|mark| !mark.y.is_finite())) {
            continue;
        }
        pictures.push(panel.draw(&series)?);
    }
    Ok((pictures, super::page::legend(&series(0))))
}

/// Mean, median, 90 % and worst of each error, and how many fits failed.
fn summary_row(name: String, errors: &[Errors]) -> Vec<String> {
    let failed = errors.iter().filter(|errors| errors.iter().all(|error| error.is_nan())).count();
    let of = |metric: usize| {
        let s = Summary::of(errors.iter().map(|errors| errors[metric]));
        [s.mean, s.median, s.ninety, s.worst].map(shown).join(" / ")
    };
    let cells = [of(0), of(1), of(2), of(3), format!("{failed} of {}", errors.len())];
    std::iter::once(name).chain(cells).collect()
}

/// The head of a table of the four errors.
fn head(first: &str) -> [&str; 5] {
    [first, "E_o (°)", "E_p (mm)", "E_r (%)", "E_l (%)"]
}

/// A table of [`summary_row`]s.
pub fn summary_table(first: &str, rows: &[(String, Vec<Errors>)]) -> String {
    let head = [&head(first)[..], &["failed"]].concat();
    let rows: Vec<Vec<String>> =
        rows.iter().map(|(name, errors)| summary_row(name.clone(), errors)).collect();
    format!("<p>mean / median / 90 % / worst</p>\n{}", super::page::table(&head, &rows))
}
