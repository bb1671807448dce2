//! `cylfuse plan`: what a camera will measure.

use crate::failure::Failure;
use crate::plan_arguments::{PlanArguments, Vary};
use crate::table;
use comfy_table::CellAlignment;
use cylfuse::plan::{Deviations, Expected, Plan};
use serde::Serialize;

const MILLIMETRES: f64 = 1000.0;

/// So many expected deviations are no noise: the fit took something else.
#[cfg(feature = "twin")]
const FAR_OFF: f64 = 5.0;

/// Halvings of an interval in search of a limit: to a ten-thousandth of it.
const HALVINGS: usize = 14;

/// A row: a plan and what is to be expected of it.
#[derive(Debug, Clone)]
pub struct Row {
    /// The varied value.
    pub value: Option<f64>,
    /// The plan.
    pub plan: Plan,
    /// What is expected of it.
    pub expected: Result<Expected, Failure>,
    /// What captures of the twin did.
    pub captures: Option<Captures>,
}

/// What captures of the twin did.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(not(feature = "twin"), allow(dead_code, reason = "only the twin takes captures"))]
pub struct Captures {
    /// How many were fitted.
    pub count: usize,
    /// How many could not be.
    pub failed: usize,
    /// How many of the fitted have a radius that is off by more than `FAR_OFF` expected deviations.
    pub far_off: usize,
    /// Scatter and bias, of two or more.
    pub of: Option<[Deviations; 2]>,
}

/// The rows that a command line asks for about its plan, without captures.
pub fn rows(arguments: &PlanArguments, base: &Plan) -> Vec<Row> {
    let row = |value: Option<f64>, plan: Plan| {
        let expected = plan.expected().map_err(Failure::from);
        Row { value, plan, expected, captures: None }
    };
    let Some(vary) = &arguments.vary else { return vec![row(None, base.clone())] };
    let values = (0..vary.rows).map(|k| vary.value(k));
    values.map(|value| row(Some(value), vary.quantity.set(base, value))).collect()
}

/// Whether a value of the command line is at fault, not what the camera sees.
pub fn of_command_line(failure: &Failure) -> bool {
    ["INVALID_ARGUMENT", "INVALID_INTRINSICS"].contains(&failure.status)
}

/// The captures of a row, several at a time; `done` is called after each.
#[cfg(feature = "twin")]
pub fn simulate(
    row: &mut Row,
    arguments: &PlanArguments,
    count: u64,
    done: &dyn Fn(),
) -> Result<(), rayon::ThreadPoolBuildError> {
    let sensor = arguments.sensor.of_twin();
    let seeds: Vec<u64> = (0..count).map(|k| arguments.seed.wrapping_add(k)).collect();
    let mut trials = Vec::new();
    let take = |seed: &u64| row.plan.trial(&sensor, *seed);
    crate::fit::in_order(&seeds, arguments.threads, &take, &mut |trial| {
        trials.extend(trial.ok());
        done();
    })?;
    let of = cylfuse::plan::Scatter::new(&trials).ok().map(|scatter| [scatter.deviation, scatter.bias]);
    let most = row.expected.as_ref().map_or(f64::INFINITY, |expected| FAR_OFF * expected.total.radius);
    let far_off = trials.iter().filter(|trial| trial.radius.abs() > most).count();
    row.captures = Some(Captures { count: trials.len(), failed: seeds.len() - trials.len(), far_off, of });
    Ok(())
}

#[cfg(feature = "twin")]
impl crate::plan_arguments::Sensor {
    fn of_twin(self) -> cylfuse::twin::DepthSensor {
        use cylfuse::twin::{ActiveStereo, DepthSensor, StructuredLight, TimeOfFlight};
        match self {
            Self::StructuredLight => DepthSensor::StructuredLight(StructuredLight::default()),
            Self::TimeOfFlight => DepthSensor::TimeOfFlight(TimeOfFlight::default()),
            Self::ActiveStereo => DepthSensor::ActiveStereo(ActiveStereo::default()),
        }
    }
}

/// The table for people.
pub fn render(rows: &[Row], vary: Option<&Vary>) -> String {
    let mut table = table::plain();
    let mut titles =
        ["", "radius mm", "radius %", "axis deg", "position mm", "length mm"].map(String::from).to_vec();
    if let Some(vary) = vary {
        let (name, unit) = vary.quantity.title();
        titles.insert(0, format!("{name} {unit}").trim_end().to_string());
    }
    let texts = 1 + usize::from(vary.is_some());
    table.set_header(titles);
    for row in rows {
        let mut lines: Vec<(String, Option<Deviations>)> = Vec::new();
        match &row.expected {
            Ok(expected) => {
                lines.push(("scatter".into(), Some(expected.scatter)));
                lines.push(("total".into(), Some(expected.total)));
            }
            Err(_) => lines.push(("not measured".into(), None)),
        }
        if let Some(Captures { count, failed, far_off, of }) = row.captures {
            let mut what = format!("{count} captures");
            for (count, word) in [(failed, "failed"), (far_off, "far off")] {
                if count > 0 {
                    what.push_str(&format!(", {count} {word}"));
                }
            }
            lines.push((what, of.map(|[scatter, _]| scatter)));
            lines.push(("their bias".into(), of.map(|[_, bias]| bias)));
        }
        let value = row.value.map(shown);
        for (k, (what, deviations)) in lines.into_iter().enumerate() {
            let mut cells = Vec::new();
            if vary.is_some() {
                cells.push(if k == 0 { value.clone().unwrap_or_default() } else { String::new() });
            }
            cells.push(what);
            let numbers = deviations.map(|deviations| cells_of(&deviations, row.plan.radius));
            cells.extend(numbers.unwrap_or_default());
            table.add_row(cells);
        }
    }
    for column in table.column_iter_mut().skip(texts) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    format!("{table}\n{}", reasons(rows, vary))
}

/// Why rows have no result, a line for each run of rows that have the same reason, numbers in it apart.
fn reasons(rows: &[Row], vary: Option<&Vary>) -> String {
    let mut runs: Vec<Vec<(&Row, &Failure)>> = Vec::new();
    let mut last: Option<String> = None;
    for row in rows {
        let kind = row.expected.as_ref().err().map(|failure| failure.message.replace(in_number, ""));
        if let Err(failure) = &row.expected {
            match runs.last_mut().filter(|_| kind == last) {
                Some(run) => run.push((row, failure)),
                None => runs.push(vec![(row, failure)]),
            }
        }
        last = kind;
    }
    let line = |run: Vec<(&Row, &Failure)>| {
        let [(first, failure), ..] = run[..] else { return String::new() };
        let value = |row: &Row| row.value.map(shown).unwrap_or_default();
        let location = match (vary, run.last()) {
            (Some(vary), Some((end, _))) => {
                let (name, unit) = vary.quantity.title();
                let range = if run.len() > 1 { format!(" to {}", value(end)) } else { String::new() };
                let location = format!(" at a {name} of {}{range} {unit}", value(first));
                // The message is that of the first.
                let alike = run.iter().all(|(_, other)| other.message == failure.message);
                let first = format!(" (numbers at {})", format!("{} {unit}", value(first)).trim_end());
                format!("{}{}", location.trim_end(), if alike { "" } else { &first })
            }
            _ => String::new(),
        };
        format!("not measured{location}: {}\n", failure.message)
    };
    runs.into_iter().map(line).collect()
}

/// Whether a character may belong to a number of a message.
fn in_number(character: char) -> bool {
    character.is_ascii_digit() || character == '.' || character == '-'
}

/// A varied value, to four digits or, where it is large, to the fourth decimal.
fn shown(value: f64) -> String {
    let leading = if value == 0.0 { 0.0 } else { value.abs().log10().floor() };
    let decimals = (3.0 - leading).max(4.0) as usize;
    format!("{value:.decimals$}").trim_end_matches('0').trim_end_matches('.').into()
}

fn cells_of(deviations: &Deviations, radius: f64) -> [String; 5] {
    let Deviations { radius: of_radius, direction, position, length } = *deviations;
    [
        format!("{:.4}", of_radius * MILLIMETRES),
        format!("{:.3}", 100.0 * of_radius / radius),
        format!("{:.3}", direction.to_degrees()),
        format!("{:.3}", position * MILLIMETRES),
        length.map_or("-".into(), |length| format!("{:.3}", length * MILLIMETRES)),
    ]
}

/// From where to where the radius is within a limit, in words.
pub fn within(rows: &[Row], base: &Plan, vary: &Vary, percent: f64) -> String {
    let meets = |value: f64| {
        let plan = vary.quantity.set(base, value);
        plan.expected().is_ok_and(|expected| expected.total.radius <= 0.01 * percent * plan.radius)
    };
    let values: Vec<f64> = rows.iter().filter_map(|row| row.value).collect();
    let met: Vec<bool> = values.iter().map(|value| meets(*value)).collect();
    let mut parts = Vec::new();
    let mut first = None;
    for k in 0..values.len() {
        // Where it begins or ends to be met, between two rows.
        let border = |inside: f64, outside: f64| {
            let (mut inside, mut outside) = (inside, outside);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (inside + outside);
                if meets(middle) { inside = middle } else { outside = middle }
            }
            inside
        };
        if met[k] && first.is_none() {
            first = Some(if k > 0 { border(values[k], values[k - 1]) } else { values[k] });
        }
        let last = met[k] && met.get(k + 1) != Some(&true);
        if let (true, Some(from)) = (last, first) {
            let to = values.get(k + 1).map_or(values[k], |next| border(values[k], *next));
            parts.push(format!("{from:.3} to {to:.3}"));
            first = None;
        }
    }
    let (name, unit) = vary.quantity.title();
    let [from, to] = vary.range;
    match parts.is_empty() {
        true => format!("The radius is not within {percent} % at any {name} from {from} to {to} {unit}")
            .trim_end()
            .into(),
        false => {
            let parts = parts.join(" and ");
            format!(
                "The radius is within {percent} % (standard deviation, total) at a {name} of {parts} {unit}"
            )
            .trim_end()
            .into()
        }
    }
}

/// A row as JSON, in metres and radians.
#[derive(Debug, Serialize)]
pub struct RowJson {
    distance: f64,
    radius: f64,
    length: f64,
    tilt: f64,
    turn: f64,
    depth_noise: [f64; 3],
    correlation: f64,
    /// `None` where limbs and ends differ.
    step_noise: Option<f64>,
    limb_noise: [f64; 2],
    end_noise: [f64; 2],
    blur: f64,
    expected: Option<ExpectedJson>,
    error: Option<String>,
    captures: Option<CapturesJson>,
}

#[derive(Debug, Serialize)]
struct ExpectedJson {
    scatter: DeviationsJson,
    total: DeviationsJson,
    points: usize,
    independent_points: f64,
}

#[derive(Debug, Serialize)]
struct CapturesJson {
    count: usize,
    failed: usize,
    far_off: usize,
    scatter: Option<DeviationsJson>,
    bias: Option<DeviationsJson>,
}

#[derive(Debug, Serialize)]
struct DeviationsJson {
    radius: f64,
    direction: f64,
    position: f64,
    length: Option<f64>,
}

impl From<Deviations> for DeviationsJson {
    fn from(Deviations { radius, direction, position, length }: Deviations) -> Self {
        Self { radius, direction, position, length }
    }
}

impl From<&Row> for RowJson {
    fn from(row: &Row) -> Self {
        let Plan { distance, radius, length, tilt, turn, depth, step, .. } = &row.plan;
        let expected = row.expected.as_ref().ok().map(|expected| ExpectedJson {
            scatter: expected.scatter.into(),
            total: expected.total.into(),
            points: expected.points,
            independent_points: expected.independent_points,
        });
        let captures = row.captures.map(|captures| CapturesJson {
            count: captures.count,
            failed: captures.failed,
            far_off: captures.far_off,
            scatter: captures.of.map(|[scatter, _]| scatter.into()),
            bias: captures.of.map(|[_, bias]| bias.into()),
        });
        Self {
            distance: *distance,
            radius: *radius,
            length: *length,
            tilt: *tilt,
            turn: *turn,
            depth_noise: [depth.constant, depth.linear, depth.quadratic],
            correlation: depth.correlation,
            step_noise: step.common(),
            limb_noise: step.limbs,
            end_noise: step.ends,
            blur: step.blur,
            expected,
            error: row.expected.as_ref().err().map(|failure| failure.message.clone()),
            captures,
        }
    }
}
