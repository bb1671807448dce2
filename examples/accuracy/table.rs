//! Summaries and tables.

use crate::frame::Errors;

/// The heads of the four columns of errors.
pub const HEAD: &str = "E_o (deg) | E_p (mm) | E_r (%) | E_l (%)";

/// Mean, median, 90 % and worst of one column.
#[derive(Clone, Copy)]
pub struct Summary {
    pub mean: f64,
    pub median: f64,
    pub ninety: f64,
    pub worst: f64,
}

impl Summary {
    pub fn new(mut values: Vec<f64>) -> Self {
        values.retain(|value| !value.is_nan());
        values.sort_by(f64::total_cmp);
        let count = values.len();
        if count == 0 {
            return Self { mean: f64::NAN, median: f64::NAN, ninety: f64::NAN, worst: f64::NAN };
        }
        let mean = values.iter().sum::<f64>() / count as f64;
        let median = f64::midpoint(values[(count - 1) / 2], values[count / 2]);
        Self { mean, median, ninety: values[count * 9 / 10], worst: values[count - 1] }
    }

    fn text(&self) -> String {
        format!("{:.2} / {:.2} / {:.2} / {:.2}", self.mean, self.median, self.ninety, self.worst)
    }
}

/// The largest value of each statistic that a column may have; infinity for no limit.
#[derive(Clone, Copy)]
pub struct Target {
    pub mean: f64,
    pub median: f64,
    pub ninety: f64,
    pub worst: f64,
}

impl Target {
    pub const NONE: Self =
        Self { mean: f64::INFINITY, median: f64::INFINITY, ninety: f64::INFINITY, worst: f64::INFINITY };

    pub fn mean(mean: f64) -> Self {
        Self { mean, ..Self::NONE }
    }

    fn text(&self) -> String {
        let one = |value: f64| if value.is_finite() { format!("{value:.2}") } else { "–".into() };
        [self.mean, self.median, self.ninety, self.worst].map(one).join(" / ")
    }

    /// What a summary misses, by name.
    fn missed(&self, summary: &Summary) -> Vec<&'static str> {
        let pairs = [
            ("mean", summary.mean, self.mean),
            ("median", summary.median, self.median),
            ("90 %", summary.ninety, self.ninety),
            ("worst", summary.worst, self.worst),
        ];
        // NaN, which a set without frames gives, meets a target of infinity only.
        let misses = |value: f64, target: f64| !(value <= target || target == f64::INFINITY);
        pairs.into_iter().filter(|(_, value, target)| misses(*value, *target)).map(|pair| pair.0).collect()
    }
}

/// The four columns of what succeeded.
pub fn columns(all: &[Option<Errors>]) -> [Summary; 4] {
    [0, 1, 2, 3].map(|k| Summary::new(all.iter().flatten().map(|errors| errors[k]).collect()))
}

/// Prints the head of a table of errors.
pub fn print_head(title: &str) {
    println!("\n### {title}\n\nmean / median / 90 % / worst\n");
    println!("| row | {HEAD} | failed | missed |\n|---|---|---|---|---|---|---|");
}

/// Prints a row of errors, and says which targets it misses.
pub fn print_row(name: &str, all: &[Option<Errors>], targets: &[Target; 4]) -> [Summary; 4] {
    let columns = columns(all);
    let failed = all.iter().filter(|errors| errors.is_none()).count();
    let mut missed: Vec<String> = Vec::new();
    for ((name, column), target) in ["E_o", "E_p", "E_r", "E_l"].iter().zip(&columns).zip(targets) {
        missed.extend(target.missed(column).iter().map(|statistic| format!("{name} {statistic}")));
    }
    let texts = columns.map(|column| column.text());
    println!("| {name} | {} | {failed} | {} |", texts.join(" | "), missed.join(", "));
    columns
}

/// Prints the row of the targets.
pub fn print_targets(targets: &[Target; 4]) {
    println!("| *target* | {} | 0 | |", targets.map(|target| target.text()).join(" | "));
}
