//! Figures 5 and 9: repeated captures of the 24 configurations, fitted by all methods; and what must be reached there.

use super::mark;
use crate::bench::Bench;
use crate::bench::methods::{Errors, METRICS, Method, errors_of, fit_by_any};
use crate::bench::page::{Csv, Section, digits, legend, list, paragraph, pictures, shown, table};
use crate::bench::plot::{Axis, Mark, Panel, Series};
use crate::bench::published::{MAXIMA, PICTURE_ONLY, RADII, TILTS};
use crate::bench::statistics::Summary;
use crate::failure::Failure;
use std::fmt::Write;

/// By how much the default must beat the paper's objective.
const FACTOR: f64 = 4.0;

/// What one capture gave.
struct Row {
    configuration: (u32, u32),
    points: usize,
    /// By method.
    errors: Vec<Errors>,
}

fn jobs(bench: &Bench) -> Vec<((u32, u32), usize)> {
    let captures = bench.scale.of(20, 1, 2);
    let of = |configuration| (0..captures).map(move |number| (configuration, number));
    bench.configurations().into_iter().flat_map(of).collect()
}

pub fn count(bench: &Bench) -> usize {
    jobs(bench).len()
}

pub fn run(bench: &Bench) -> Result<Section, Failure> {
    let methods = bench.compared();
    let jobs = jobs(bench);
    let rows = bench.map(&jobs, |(configuration, number)| {
        let sample = bench.capture(*configuration, *number)?;
        let fits = methods.iter().map(|method| fit_by_any(&sample, *method, bench.pcl.as_ref()));
        let errors = fits.map(|fit| Ok(errors_of(fit?.as_ref()))).collect::<Result<_, Failure>>()?;
        let points = sample.fitter(None)?.cloud().len();
        Ok(Row { configuration: *configuration, points, errors })
    })?;
    let compared = Compared { configurations: bench.configurations(), methods, rows };
    let captures = jobs.len() / compared.configurations.len();
    let mut body = paragraph(&format!(
        "Section 5.5 of the paper on the twin: cylinders of 100 mm on a board 0.7 m away, {} configurations of radius \
         and tilt, {captures} captures each. Captures of a configuration share scene, mask and edges and differ in \
         the noise of image and sensor and in the dots of the projector. All methods get the same points and mask; \
         points alone, the paper's objective (w_L = 0.6) and Eberly's fit start from RANSAC, and take the paper's \
         extent. The paper's figures come from a real camera, ours from a twin: the twin's errors are of its kind, \
         not of its size. Compare methods within a column, not the twin with the camera.",
        compared.configurations.len(),
    ));
    let (verdict, said) = compared.verdict();
    body.push_str("<h3>What must be reached</h3>\n");
    body.push_str(&verdict);
    body.push_str("<h3>All captures of all configurations (Fig. 9 in numbers)</h3>\n");
    let all = compared.methods.iter().enumerate().map(|(k, method)| {
        (method.name().to_string(), compared.rows.iter().map(|row| row.errors[k]).collect())
    });
    body.push_str(&super::summary_table("method", &all.collect::<Vec<_>>()));
    body.push_str("<h3>By configuration (Fig. 9)</h3>\n");
    body.push_str(&paragraph(
        "Mean and standard deviation over the captures of a configuration. The dashed line is the maximum that the \
         paper publishes for its own method on its own camera.",
    ));
    body.push_str(&compared.figure()?);
    body.push_str("<h3>Where cylfuse loses</h3>\n");
    body.push_str(&compared.losses());
    body.push_str("<h3>Points on the cylinder (Fig. 5)</h3>\n");
    body.push_str(&compared.points()?);
    Ok(Section {
        name: "compare",
        title: "24 configurations, all methods (Fig. 5 and 9)".into(),
        body,
        numbers: vec![compared.by_configuration(), compared.by_capture()],
        said: Some(said),
    })
}

struct Compared {
    configurations: Vec<(u32, u32)>,
    methods: Vec<Method>,
    rows: Vec<Row>,
}

impl Compared {
    fn index(&self, method: Method) -> usize {
        self.methods.iter().position(|other| *other == method).unwrap_or(0)
    }

    fn errors(&self, configuration: (u32, u32), method: usize) -> Vec<Errors> {
        let own = self.rows.iter().filter(|row| row.configuration == configuration);
        own.map(|row| row.errors[method]).collect()
    }

    fn summary(&self, configuration: (u32, u32), method: usize, metric: usize) -> Summary {
        Summary::of(self.errors(configuration, method).iter().map(|errors| errors[metric]))
    }

    /// The goals as a table in HTML and in plain text.
    fn verdict(&self) -> (String, String) {
        let (own, paper) = (self.index(Method::Default), self.index(Method::Paper));
        let (mut rows, mut said, mut above) = (Vec::new(), String::new(), Vec::new());
        for (index, metric) in METRICS.iter().enumerate() {
            let mean =
                |method: usize| Summary::of(self.rows.iter().map(|row| row.errors[method][index])).mean;
            let (ours, theirs) = (mean(own), mean(paper));
            let ratio = theirs / ours;
            let worst = self
                .configurations
                .iter()
                .map(|configuration| (self.summary(*configuration, own, index).mean, *configuration))
                .fold((f64::NEG_INFINITY, (0, 0)), |most, next| if next.0 > most.0 { next } else { most });
            let judged = |good: bool| if good { "reached" } else { "missed" };
            let beaten = format!("{} (at least {FACTOR:.0})", judged(ratio >= FACTOR));
            let under = format!("{} (below {})", judged(worst.0 < MAXIMA[index]), MAXIMA[index]);
            for configuration in &self.configurations {
                let mean = self.summary(*configuration, own, index).mean;
                if !(mean < MAXIMA[index]) {
                    above.push(format!(
                        "{} of {}: {} {}, not below {}",
                        metric.symbol,
                        named(*configuration),
                        shown(mean),
                        metric.unit,
                        MAXIMA[index]
                    ));
                }
            }
            let cells = vec![
                format!("{} ({})", metric.symbol, metric.unit),
                shown(ours),
                shown(theirs),
                format!("{ratio:.1}"),
                beaten,
                format!("{} at {}", shown(worst.0), named(worst.1)),
                under,
            ];
            let _ = writeln!(
                said,
                "{:<9} cylfuse {:>6}  paper's objective {:>6}  {:>5} times  {:<22} worst configuration {}, {}",
                cells[0], cells[1], cells[2], cells[3], cells[4], cells[5], cells[6]
            );
            rows.push(cells);
        }
        let head = [
            "mean error",
            "cylfuse",
            "paper's objective",
            "times better",
            "goal",
            "worst configuration",
            "the paper's published maximum",
        ];
        let mut text = table(&head, &rows);
        let own_errors = self.rows.iter().map(|row| row.errors[own]);
        let failed = own_errors.filter(|errors| errors.iter().all(|error| error.is_nan())).count();
        if above.is_empty() {
            text.push_str(&paragraph("No configuration is above a published maximum."));
        } else {
            text.push_str(&paragraph("Configurations whose mean is not below the published maximum:"));
            text.push_str(&list(&above));
        }
        text.push_str(&paragraph(&format!("Fits of cylfuse that failed: {failed} of {}.", self.rows.len())));
        (text, said)
    }

    fn figure(&self) -> Result<String, Failure> {
        let mut plots = Vec::new();
        let mut explained = String::new();
        for (index, metric) in METRICS.iter().enumerate() {
            // One range for all tilts, so that they can be compared.
            let means = self.configurations.iter().flat_map(|configuration| {
                (0..self.methods.len()).map(|method| self.summary(*configuration, method, index))
            });
            let positive: Vec<f64> = means
                .flat_map(|s| [s.mean, s.mean + s.deviation])
                .filter(|x| *x > 0.0 && x.is_finite())
                .collect();
            let (low, high) = (
                positive.iter().copied().fold(MAXIMA[index], f64::min).log10().floor(),
                positive.iter().copied().fold(MAXIMA[index], f64::max).log10().ceil(),
            );
            for tilt in TILTS {
                let of_tilt: Vec<_> =
                    self.configurations.iter().filter(|(_, other)| *other == tilt).collect();
                if of_tilt.is_empty() {
                    continue;
                }
                let series: Vec<Series> = (self.methods.iter().enumerate())
                    .map(|(k, method)| {
                        let at = |configuration: &&(u32, u32)| {
                            mark(f64::from(configuration.0), &self.errors(**configuration, k), index)
                        };
                        super::series_of(*method, of_tilt.iter().map(at).collect())
                    })
                    .collect();
                let panel = Panel {
                    title: format!("tilt {tilt}°"),
                    x: Axis::linear("radius (mm)")
                        .with_range(f64::from(RADII[0]) - 5.0, f64::from(RADII[RADII.len() - 1]) + 5.0),
                    y: Axis::logarithmic(format!("{} ({})", metric.name, metric.unit))
                        .with_range(10_f64.powf(low), 10_f64.powf(high)),
                    level: Some(MAXIMA[index]),
                    aside: 0.9,
                };
                plots.push(panel.draw(&series)?);
                if explained.is_empty() {
                    explained = legend(&series);
                }
            }
        }
        Ok(format!("{explained}{}", pictures(&plots)))
    }

    /// Configurations in which another method has a lower mean error.
    fn losses(&self) -> String {
        let own = self.index(Method::Default);
        let mut lines = Vec::new();
        for configuration in &self.configurations {
            for (index, metric) in METRICS.iter().enumerate() {
                let ours = self.summary(*configuration, own, index).mean;
                for (k, method) in self.methods.iter().enumerate() {
                    let theirs = self.summary(*configuration, k, index).mean;
                    if k != own && theirs < ours {
                        lines.push(format!(
                            "{}: {} {} {} by {}, {} {} by cylfuse",
                            named(*configuration),
                            metric.symbol,
                            shown(theirs),
                            metric.unit,
                            method.name(),
                            shown(ours),
                            metric.unit
                        ));
                    }
                }
            }
        }
        let cases = self.configurations.len() * METRICS.len() * (self.methods.len() - 1);
        let head = format!(
            "In {} of {cases} comparisons (configuration, error, other method) the other method has the lower mean.",
            lines.len()
        );
        paragraph(&head) + &list(&lines)
    }

    fn points(&self) -> Result<String, Failure> {
        let marks = RADII.iter().map(|radius| {
            let of_radius = self.rows.iter().filter(|row| row.configuration.0 == *radius);
            let summary = Summary::of(of_radius.map(|row| row.points as f64));
            Mark { x: f64::from(*radius), y: summary.mean, spread: summary.deviation }
        });
        let series = [Series {
            name: "points in the mask".into(),
            color: Method::Default.color(),
            marks: marks.collect(),
            joined: true,
        }];
        let panel = Panel {
            title: "depth points in the mask".into(),
            x: Axis::linear("radius (mm)"),
            y: Axis::linear("number of points"),
            level: None,
            aside: 0.0,
        };
        let text = paragraph(
            "Mean over tilts and captures; the bars are standard deviations. The paper shows its numbers of points only as a \
             picture, from which none can be copied here.",
        );
        let rows = series[0].marks.iter().map(|mark| {
            let ours = format!("{:.0} ± {:.0}", mark.y, mark.spread);
            vec![format!("{} mm", mark.x), ours, PICTURE_ONLY.into()]
        });
        let rows: Vec<Vec<String>> = rows.collect();
        Ok(text
            + &pictures(&[panel.draw(&series)?])
            + &table(&["radius", "points in the mask of the twin", "published by the paper"], &rows))
    }

    fn by_configuration(&self) -> Csv {
        let mut csv = Csv::new("compare", "radius_mm,tilt_deg,method,error,mean,deviation,worst,fits");
        for configuration in &self.configurations {
            for (k, method) in self.methods.iter().enumerate() {
                for (index, metric) in METRICS.iter().enumerate() {
                    let s = self.summary(*configuration, k, index);
                    let numbers = [s.mean, s.deviation, s.worst].map(digits).join(",");
                    let (radius, tilt) = configuration;
                    csv.push(&format!(
                        "{radius},{tilt},{},{},{numbers},{}",
                        method.name(),
                        metric.symbol,
                        s.count
                    ));
                }
            }
        }
        csv
    }

    fn by_capture(&self) -> Csv {
        let mut csv =
            Csv::new("compare_captures", "radius_mm,tilt_deg,points,method,E_o_deg,E_p_mm,E_r_pct,E_l_pct");
        for row in &self.rows {
            for (method, errors) in self.methods.iter().zip(&row.errors) {
                let (radius, tilt) = row.configuration;
                let numbers = errors.map(digits).join(",");
                csv.push(&format!("{radius},{tilt},{},{},{numbers}", row.points, method.name()));
            }
        }
        csv
    }
}

fn named((radius, tilt): (u32, u32)) -> String {
    format!("r = {radius} mm, α = {tilt}°")
}
