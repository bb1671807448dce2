//! The short table for people.

use crate::detect::Scene;
use crate::report::{Measurement, Outcome, Report};
use comfy_table::{CellAlignment, LineStyle, Table, TableStyle};

/// Millimetres in a metre: frames are in metres, people read millimetres.
const MILLIMETRES: f64 = 1000.0;

/// A column: its title, whether it holds numbers, and what a measurement has in it.
struct Column {
    title: &'static str,
    number: bool,
    cell: fn(&Measurement) -> String,
}

impl Column {
    const fn number(title: &'static str, cell: fn(&Measurement) -> String) -> Self {
        Self { title, number: true, cell }
    }

    const fn text(title: &'static str, cell: fn(&Measurement) -> String) -> Self {
        Self { title, number: false, cell }
    }
}

const FRAME_COLUMNS: &[Column] = &[
    Column::number("radius mm", |m| {
        let radius = format!("{:.2}", m.cylinder.radius * MILLIMETRES);
        with_deviation(&radius, m.uncertainty.as_ref().map(|u| format!("{:.2}", u.radius * MILLIMETRES)))
    }),
    Column::number("length mm", |m| {
        m.extent.as_ref().map_or("-".into(), |e| {
            let length = format!("{:.1}", e.length * MILLIMETRES);
            with_deviation(&length, e.length_deviation.map(|d| format!("{:.1}", d * MILLIMETRES)))
        })
    }),
    Column::text("ends", |m| {
        m.extent.as_ref().map_or("-".into(), |e| format!("{} {}", e.start_state, e.end_state))
    }),
    DIRECTION,
    POINTS,
    Column::number("noise mm", |m| format!("{:.2}", m.result.point_scale * MILLIMETRES)),
    Column::number("limbs", |m| m.result.limbs_located.to_string()),
    Column::number("edges px", |m| optional(m.result.edge_rms_pixels, 2)),
    ITERATIONS,
    TIME,
];

/// A cloud has no unit that the program knows, so its lengths keep their digits.
const CLOUD_COLUMNS: &[Column] = &[
    Column::number("radius", |m| {
        let deviation = m.uncertainty.as_ref().map(|u| format!("{:.1e}", u.radius));
        with_deviation(&significant(m.cylinder.radius), deviation)
    }),
    Column::number("length", |m| {
        m.extent.as_ref().map_or("-".into(), |e| {
            with_deviation(&significant(e.length), e.length_deviation.map(|d| format!("{d:.1e}")))
        })
    }),
    DIRECTION,
    POINTS,
    Column::number("noise", |m| significant(m.result.point_scale)),
    ITERATIONS,
    TIME,
];

const DIRECTION: Column = Column::text("axis direction", |m| {
    let [x, y, z] = m.cylinder.direction;
    format!("{x:+.3} {y:+.3} {z:+.3}")
});
const POINTS: Column = Column::number("points", |m| m.result.points_used.to_string());
const ITERATIONS: Column = Column::number("its", |m| m.result.iterations.to_string());
const TIME: Column = Column::number("ms", |m| format!("{:.1}", m.seconds.fit * 1000.0));

/// A table with two rules.
pub fn plain() -> Table {
    let mut table = Table::new();
    let rule = LineStyle::none().fill('─').junction('─');
    table.load_style(TableStyle::new().header_separator(rule).bottom_border(rule));
    table
}

/// What is measured, and the columns for it; frames are in `metres`, clouds are not known to be.
fn columns(metres: bool) -> (&'static str, &'static [Column]) {
    if metres { ("frame", FRAME_COLUMNS) } else { ("cloud", CLOUD_COLUMNS) }
}

/// The table, and below it what has to be said about single frames.
pub fn render(reports: &[Report], metres: bool) -> String {
    let (name, columns) = columns(metres);
    let mut table = plain();
    let titles = std::iter::once(name).chain(columns.iter().map(|column| column.title));
    table.set_header(titles.collect::<Vec<_>>());
    for report in reports {
        let cells: Vec<String> = match &report.outcome {
            Outcome::Measured(measurement) => columns.iter().map(|c| (c.cell)(measurement)).collect(),
            Outcome::Failed { .. } => vec!["failed".into()],
        };
        table
            .add_row(std::iter::once(short_name(&report.frame).to_string()).chain(cells).collect::<Vec<_>>());
    }
    for (drawn, column) in table.column_iter_mut().skip(1).zip(columns) {
        if column.number {
            drawn.set_cell_alignment(CellAlignment::Right);
        }
    }
    let mut text = format!("{table}\n");
    for report in reports {
        if let Outcome::Measured(measurement) = &report.outcome {
            for note in &measurement.notes {
                text.push_str(&format!("{}: {note}\n", short_name(&report.frame)));
            }
        }
    }
    text
}

/// The cylinders of one frame or cloud, a line each.
pub fn render_scene(frame: &str, scene: &Scene, metres: bool) -> String {
    let (_, columns) = columns(metres);
    let mut table = plain();
    let titles = ["", "score"].into_iter().chain(columns.iter().map(|column| column.title));
    table.set_header(titles.collect::<Vec<_>>());
    for (index, found) in scene.cylinders.iter().enumerate() {
        let cells = columns.iter().map(|column| (column.cell)(&found.measurement));
        let first = [(index + 1).to_string(), format!("{:.2}", found.score)];
        table.add_row(first.into_iter().chain(cells).collect::<Vec<_>>());
    }
    let numbers = [true, true].into_iter().chain(columns.iter().map(|column| column.number));
    for (drawn, _) in table.column_iter_mut().zip(numbers).filter(|(_, number)| *number) {
        drawn.set_cell_alignment(CellAlignment::Right);
    }
    let milliseconds = scene.seconds.total * 1000.0;
    let count = scene.cylinders.len();
    let plural = if count == 1 { "" } else { "s" };
    let rest = if scene.complete { "" } else { "; more to look at than a search may, some may be missing" };
    let notes: String =
        scene_notes(scene).iter().map(|note| format!("{}: {note}\n", short_name(frame))).collect();
    format!("{frame}: {count} cylinder{plural}, {milliseconds:.0} ms{rest}\n{table}\n{notes}")
}

/// What may be wrong: of the cylinders, each text once with the numbers of those it holds for, then of the frame.
fn scene_notes(scene: &Scene) -> Vec<String> {
    let mut texts: Vec<(&str, Vec<String>)> = Vec::new();
    for (index, found) in scene.cylinders.iter().enumerate() {
        let number = (index + 1).to_string();
        for note in &found.measurement.notes {
            match texts.iter_mut().find(|(text, _)| text == note) {
                Some((_, numbers)) => numbers.push(number.clone()),
                None => texts.push((note, vec![number.clone()])),
            }
        }
    }
    let of_cylinders = texts.into_iter().map(|(text, numbers)| {
        let plural = if numbers.len() == 1 { "" } else { "s" };
        format!("cylinder{plural} {}: {text}", numbers.join(", "))
    });
    of_cylinders.chain(scene.notes.iter().cloned()).collect()
}

/// The folder of a frame.json says which frame it is.
pub fn short_name(path: &str) -> &str {
    path.strip_suffix("frame.json").and_then(|p| p.strip_suffix(['/', '\\'])).unwrap_or(path)
}

/// A number with its standard deviation, where there is one.
fn with_deviation(value: &str, deviation: Option<String>) -> String {
    deviation.map_or_else(|| value.into(), |deviation| format!("{value} ± {deviation}"))
}

fn optional(value: Option<f64>, decimals: usize) -> String {
    value.map_or("-".into(), |value| format!("{value:.decimals$}"))
}

/// Six significant digits.
fn significant(value: f64) -> String {
    if value == 0.0 || !(1e-4..1e6).contains(&value.abs()) {
        return format!("{value:.5e}");
    }
    let decimals = (5 - value.abs().log10().floor() as i32).max(0) as usize;
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn six_digits_are_kept_at_any_size() {
        for (value, text) in
            [(0.0377856, "0.0377856"), (37.7856, "37.7856"), (123_456.7, "123457"), (1.5e-7, "1.50000e-7")]
        {
            assert_eq!(significant(value), text);
        }
    }
}
