//! Figure 8: disturbed starts.

use super::{head, mark, panels};
use crate::bench::Bench;
use crate::bench::methods::{Errors, METRICS, Method, Variation, errors_of, fit_with};
use crate::bench::page::{Csv, Section, digits, paragraph, pictures, table};
use crate::bench::plot::{Axis, Series};
use crate::bench::published::{PICTURE_ONLY, STARTS, STARTS_SAID};
use crate::bench::sample::Sample;
use crate::bench::statistics::Summary;
use crate::failure::Failure;
use cylfuse::fitter::NearWall;
use cylfuse::geometry::Cylinder;
use cylfuse::twin::{Purpose, Stream};
use nalgebra::{Rotation3, Vector3};

/// What is compared: the method, whether the near-wall rule is on, name and colour.
const ROWS: [(Method, NearWall, &str, [u8; 3]); 3] = [
    (Method::Paper, NearWall::Off, "paper's Algorithm 2 as printed", [213, 94, 0]),
    (Method::Paper, NearWall::On, "the same with the near-wall rule", [230, 159, 0]),
    (Method::Default, NearWall::On, "cylfuse", [0, 114, 178]),
];

const BATCH: usize = 10;

fn trials(bench: &Bench) -> usize {
    bench.scale.of(100, 10, 10)
}

pub fn count(bench: &Bench) -> usize {
    bench.scale.of(6, 6, 2) * STARTS.len() * (trials(bench) / BATCH)
}

/// The truth with normal noise: direction in degrees, centre in millimetres, radius in percent.
fn disturbed(sample: &Sample, [direction, center, radius]: [f64; 3], seed: u64) -> Option<Cylinder> {
    let mut stream = Stream::new(seed, Purpose::Trial);
    let truth = &sample.truth.cylinder;
    let mut normal =
        |deviation: f64| Vector3::new(stream.normal(), stream.normal(), stream.normal()) * deviation;
    let turn = Rotation3::new(normal(direction.to_radians()));
    let at = truth.axis.point + normal(1e-3 * center);
    let factor = 1.0 + normal(0.01 * radius).x;
    Cylinder::new(at, turn * truth.axis.direction, truth.radius * factor).ok()
}

pub fn run(bench: &Bench) -> Result<Section, Failure> {
    let samples = bench.validation()?;
    let trials = trials(bench);
    let mut jobs = Vec::new();
    for severity in 0..STARTS.len() {
        for sample in 0..samples.len() {
            jobs.extend((0..trials / BATCH).map(|batch| (severity, sample, batch)));
        }
    }
    let rows = bench.map(&jobs, |(severity, sample, batch)| {
        let trial = |k: usize| {
            let seed = bench.seed(11, sample * 1000 + severity * 100 + batch * BATCH + k);
            let start = disturbed(&samples[*sample], STARTS[*severity].1, seed);
            ROWS.map(|(method, near_wall, _, _)| {
                let variation = Variation { start, near_wall, ..Variation::default() };
                errors_of(fit_with(&samples[*sample], method, &variation).as_ref())
            })
        };
        Ok((*severity, (0..BATCH).map(trial).collect::<Vec<_>>()))
    })?;
    let errors = |severity: usize, row: usize| -> Vec<Errors> {
        let own = rows.iter().filter(|(other, _)| *other == severity);
        own.flat_map(|(_, trials)| trials.iter().map(|all| all[row])).collect()
    };
    let mut csv =
        Csv::new("starts", "configuration,method,error,mean,deviation,median,90_percent,worst,fits");
    let mut table_rows = Vec::new();
    for (severity, (name, [direction, center, radius])) in STARTS.iter().enumerate() {
        for (row, (_, _, method, _)) in ROWS.iter().enumerate() {
            let mut cells = vec![format!("{name} ({direction}°, {center} mm, {radius} %), {method}")];
            for (index, metric) in METRICS.iter().enumerate() {
                let s = Summary::of(errors(severity, row).iter().map(|errors| errors[index]));
                let numbers = [s.mean, s.deviation, s.median, s.ninety, s.worst].map(digits).join(",");
                csv.push(&format!("{},{method},{},{numbers},{}", severity + 1, metric.symbol, s.count));
                cells.push(s.cell());
            }
            table_rows.push(cells);
        }
        let said = format!("{name}, published by the paper: {}", STARTS_SAID[severity]);
        table_rows.push(std::iter::once(said).chain(METRICS.map(|_| PICTURE_ONLY.into())).collect());
    }
    let axis = Axis { labels: 4, ..Axis::linear("configuration of Table 1").with_range(0.5, 4.5) };
    let (plots, legend) = panels("six frames, mean and deviation", &axis, 0.1, |metric| {
        let of_row = |(row, (_, _, name, color)): (usize, &(Method, NearWall, &str, [u8; 3]))| {
            let marks = (0..STARTS.len()).map(|k| mark(k as f64 + 1.0, &errors(k, row), metric));
            Series { name: (*name).into(), color: *color, marks: marks.collect(), joined: false }
        };
        ROWS.iter().enumerate().map(of_row).collect()
    })?;
    let body = paragraph(&format!(
        "Section 5.4.2 of the paper: the true cylinder with normal noise on direction, centre and radius is the start; \
         {trials} trials on each of {} frames. The paper shows its errors only as a picture; what its text says of each \
         configuration is in the table. A start that leads to the mirror image behind the surface is what the near-wall \
         rule is for.",
        samples.len()
    )) + &legend
        + &pictures(&plots)
        + &table(&head("mean ± deviation"), &table_rows);
    Ok(Section {
        name: "starts",
        title: "Disturbed starts (Fig. 8)".into(),
        body,
        numbers: vec![csv],
        said: None,
    })
}
