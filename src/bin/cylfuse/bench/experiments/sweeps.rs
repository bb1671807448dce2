//! One quantity at a time: distance, tilt, the part of the width that is seen, the part of the length that is hidden.

use super::{head, mark, panels, series_of};
use crate::bench::methods::{Errors, METRICS, Method, errors_of, fit};
use crate::bench::page::{Csv, Section, digits, paragraph, pictures, table};
use crate::bench::plot::Axis;
use crate::bench::sample::Sample;
use crate::bench::stage::{self, DISTANCE as PAPERS, Hidden, OnBoard};
use crate::bench::statistics::Summary;
use crate::bench::{Bench, Scale};
use crate::failure::Failure;

/// An experiment that varies one quantity.
pub struct Sweep {
    name: &'static str,
    title: &'static str,
    intro: &'static str,
    axis: &'static str,
    /// Which seeds are its own.
    seeds: u64,
    values: &'static [f64],
    /// Radii in metres.
    radii: &'static [f64],
    methods: &'static [Method],
    stage: fn(f64, f64) -> OnBoard,
}

const PLAIN: OnBoard =
    OnBoard { radius: 0.03, tilt: 10.0, distance: PAPERS, hidden: Hidden::Nothing, light: None };

pub const DISTANCE: Sweep = Sweep {
    name: "distance",
    title: "Distance",
    intro: "Cylinders of 100 mm length on a board, tilt 10°, from 0.45 to 2 m. The image of a radius of 20 mm at 2 m is 11 \
            pixels wide, that of its length 28.",
    axis: "distance (m)",
    seeds: 20,
    values: &[0.45, 0.6, 0.8, 1.0, 1.25, 1.6, 2.0],
    radii: &[0.02, 0.04],
    methods: &[Method::Ransac, Method::Paper, Method::Default],
    stage: |distance, radius| OnBoard { radius, distance, ..PLAIN },
};

pub const TILT: Sweep = Sweep {
    name: "tilt",
    title: "Tilt",
    intro: "A radius of 30 mm at 0.7 m, the axis turned out of the image plane by up to 75°, past the 40° of the paper.",
    axis: "tilt of the axis (°)",
    seeds: 21,
    values: &[0.0, 15.0, 30.0, 45.0, 60.0, 75.0],
    radii: &[0.03],
    methods: &[Method::Ransac, Method::Paper, Method::Default],
    stage: |tilt, radius| OnBoard { radius, tilt, ..PLAIN },
};

pub const ARC: Sweep = Sweep {
    name: "arc",
    title: "Arc seen",
    intro: "A plate in front of one side hides one limb and a part of the width: of 100 % of the width an arc of nearly 180° \
            is seen, of 50 % one of 90°, of 30 % one of 66°. An edge that is hidden is not given. The paper's objective \
            needs two edges and fails without.",
    axis: "seen of the width (%)",
    seeds: 22,
    values: &[30.0, 40.0, 50.0, 60.0, 75.0, 90.0, 100.0],
    radii: &[0.03],
    methods: &[Method::Ransac, Method::Points, Method::Paper, Method::Default],
    stage: |seen, radius| {
        let hidden = if seen < 100.0 { Hidden::Side(0.01 * seen) } else { Hidden::Nothing };
        OnBoard { radius, hidden, ..PLAIN }
    },
};

pub const BAR: Sweep = Sweep {
    name: "occlusion",
    title: "Occlusion",
    intro: "A bar across the middle hides a part of the length; it also casts the shadow of the projector. The mask leaves the \
            bar out. Edges are given while a third of each limb is seen.",
    axis: "hidden of the length (%)",
    seeds: 23,
    values: &[0.0, 15.0, 30.0, 45.0, 60.0],
    radii: &[0.03],
    methods: &[Method::Ransac, Method::Paper, Method::Default],
    stage: |share, radius| {
        let hidden = if share > 0.0 { Hidden::Middle(0.01 * share) } else { Hidden::Nothing };
        OnBoard { radius, hidden, ..PLAIN }
    },
};

pub const LIGHT: Sweep = Sweep {
    name: "light",
    title: "Direction of light",
    intro: "A lamp 1.2 m from the cylinder, moved aside from straight in front of it. The cylinder lies on the board, so its \
            shadow begins at one limb and runs along it: narrow at small angles, where it is easily taken for a part of the \
            body.",
    axis: "angle of the lamp (°)",
    seeds: 25,
    values: &[0.0, 10.0, 20.0, 30.0, 45.0, 60.0, 75.0],
    radii: &[0.03],
    methods: &[Method::Ransac, Method::Paper, Method::Default],
    stage: |aside, radius| OnBoard { radius, light: Some(aside), ..PLAIN },
};

impl Sweep {
    fn values(&self, bench: &Bench) -> Vec<f64> {
        let step = if bench.scale == Scale::Full { 1 } else { 3 };
        self.values.iter().step_by(step).copied().collect()
    }

    fn radii(&self, bench: &Bench) -> &[f64] {
        if bench.scale == Scale::Full { self.radii } else { &self.radii[..1] }
    }

    fn jobs(&self, bench: &Bench) -> Vec<(usize, f64, usize)> {
        let captures = bench.scale.of(5, 1, 1);
        let mut jobs = Vec::new();
        for radius in 0..self.radii(bench).len() {
            for value in self.values(bench) {
                jobs.extend((0..captures).map(|number| (radius, value, number)));
            }
        }
        jobs
    }

    pub fn count(&self, bench: &Bench) -> usize {
        self.jobs(bench).len()
    }

    pub fn run(&self, bench: &Bench) -> Result<Section, Failure> {
        let jobs: Vec<_> = self.jobs(bench).into_iter().enumerate().collect();
        let options = stage::capture_options(stage::structured_light())?;
        let rows = bench.map(&jobs, |(index, (radius, value, _))| {
            let seed = bench.seed(self.seeds, *index);
            let scene = (self.stage)(*value, self.radii[*radius]).scene(seed)?;
            let sample = Sample::take(String::new(), &scene, &options, [seed, seed])?;
            let errors = self.methods.iter().map(|method| errors_of(fit(&sample, *method).as_ref()));
            Ok((*radius, *value, errors.collect::<Vec<Errors>>()))
        })?;
        let errors = |radius: usize, value: f64, method: usize| -> Vec<Errors> {
            let own = rows.iter().filter(|(r, v, _)| *r == radius && *v == value);
            own.map(|(_, _, errors)| errors[method]).collect()
        };
        let captures = bench.scale.of(5, 1, 1);
        let mut body = paragraph(self.intro);
        body.push_str(&paragraph(&format!(
            "{captures} captures at each place, each with light, paint, placement, dots, mask and edges of its own; mean \
             and standard deviation."
        )));
        let mut csv = Csv::new(self.name, "radius_mm,value,method,error,mean,deviation,median,worst,fits");
        let mut table_rows = Vec::new();
        let mut plots = Vec::new();
        let mut explained = String::new();
        for (index, radius) in self.radii(bench).iter().enumerate() {
            let millimetres = 1e3 * radius;
            for value in self.values(bench) {
                for (k, method) in self.methods.iter().enumerate() {
                    let own = errors(index, value, k);
                    let failed = own.iter().filter(|errors| errors[0].is_nan()).count();
                    let mut cells = vec![format!("r = {millimetres:.0} mm, {value}, {}", method.name())];
                    for (of, metric) in METRICS.iter().enumerate() {
                        let s = Summary::of(own.iter().map(|errors| errors[of]));
                        let numbers = [s.mean, s.deviation, s.median, s.worst].map(digits).join(",");
                        let name = method.name();
                        csv.push(&format!(
                            "{millimetres:.0},{value},{name},{},{numbers},{}",
                            metric.symbol, s.count
                        ));
                        cells.push(s.cell());
                    }
                    cells.push(format!("{failed} of {}", own.len()));
                    table_rows.push(cells);
                }
            }
            let (first, last) = (self.values[0], self.values[self.values.len() - 1]);
            let title = format!("r = {millimetres:.0} mm");
            let (of_radius, legend) =
                panels(&title, &Axis::linear(self.axis), 0.008 * (last - first), |metric| {
                    let of_method = |(k, method): (usize, &Method)| {
                        let marks =
                            self.values(bench).into_iter().map(|x| mark(x, &errors(index, x, k), metric));
                        series_of(*method, marks.collect())
                    };
                    self.methods.iter().enumerate().map(of_method).collect()
                })?;
            plots.extend(of_radius);
            explained = legend;
        }
        body.push_str(&explained);
        body.push_str(&pictures(&plots));
        let first = format!("radius, {}, method", self.axis);
        let head = [&head(&first)[..], &["failed"]].concat();
        let rows = table(&head, &table_rows);
        body.push_str(&format!("<details><summary>the numbers</summary>\n{rows}</details>\n"));
        Ok(Section { name: self.name, title: self.title.into(), body, numbers: vec![csv], said: None })
    }
}
