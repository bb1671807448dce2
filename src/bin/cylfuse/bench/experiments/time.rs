//! Table 2: how long fits take.

use crate::bench::Bench;
use crate::bench::methods::fit_by_any;
use crate::bench::page::{Csv, Section, digits, paragraph, shown, table};
use crate::bench::published::SECONDS;
use crate::bench::statistics::Summary;
use crate::failure::Failure;

/// The fastest of so many fits counts: the others were interrupted.
const REPEATS: usize = 3;

pub fn count(bench: &Bench) -> usize {
    bench.configurations().len()
}

pub fn run(bench: &Bench) -> Result<Section, Failure> {
    let methods = bench.compared();
    let samples = bench.map(&bench.configurations(), |configuration| bench.capture(*configuration, 0))?;
    let mut csv = Csv::new("time", "method,configuration,seconds");
    let mut seconds = vec![Vec::new(); methods.len()];
    // One at a time: beside another fit both would be slower.
    for sample in &samples {
        for (k, method) in methods.iter().enumerate() {
            let mut fastest = f64::INFINITY;
            for _ in 0..REPEATS {
                let outcome = fit_by_any(sample, *method, bench.pcl.as_ref())?;
                fastest = outcome.map_or(fastest, |outcome| fastest.min(outcome.seconds));
            }
            csv.push(&format!("{},{},{}", method.name(), sample.name.replace(',', ""), digits(fastest)));
            seconds[k].push(fastest);
        }
    }
    let ransac = Summary::of(seconds[0].iter().copied());
    let mut rows = Vec::new();
    for (method, seconds) in methods.iter().zip(&seconds) {
        let s = Summary::of(seconds.iter().copied());
        let cells = [shown(1e3 * s.mean), shown(1e3 * s.deviation), shown(s.mean / ransac.mean)];
        rows.push(std::iter::once(method.name().to_string()).chain(cells).collect());
    }
    for (name, mean, deviation) in SECONDS {
        let cells = [shown(1e3 * mean), shown(1e3 * deviation), shown(mean / SECONDS[0].1)];
        rows.push(std::iter::once(format!("published: {name}")).chain(cells).collect());
    }
    let body = paragraph(&format!(
        "One capture of each of the {} configurations, the fastest of {REPEATS} fits, one thread, nothing beside it. cylfuse also \
         locates limbs and ends in the image. Times depend on the machine and on what else runs there; the last column, \
         ratios within a run, hardly does. The published times are of other machines. The time of PCL contains the start of its \
         program.",
        samples.len()
    )) + &table(&["method", "mean (ms)", "deviation (ms)", "times RANSAC"], &rows);
    Ok(Section { name: "time", title: "Time (Table 2)".into(), body, numbers: vec![csv], said: None })
}
