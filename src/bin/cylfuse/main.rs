//! `cylfuse`: fits cylinders to RGB-D frames and point clouds from the command line.

mod arguments;
#[cfg(feature = "bench")]
mod bench;
mod canvas;
mod cloud;
mod common_arguments;
mod demo;
mod detect;
mod detect_arguments;
mod failure;
mod fit;
mod frame;
mod ground;
mod images;
mod inputs;
mod overlay;
mod page;
mod plan;
mod plan_arguments;
mod remarks;
mod report;
mod scene_picture;
mod table;
#[cfg(feature = "twin")]
mod twin;
#[cfg(feature = "twin")]
mod twin_arguments;

use arguments::{Arguments, Command, DemoArguments, FitArguments};
use clap::error::ErrorKind;
use clap::{CommandFactory, Parser};
use detect::{SceneOutcome, SceneReport};
use detect_arguments::DetectArguments;
use failure::Failure;
use fit::Settings;
use indicatif::{ProgressBar, ProgressStyle};
use inputs::Input;
use plan_arguments::PlanArguments;
use report::{Outcome, Report};
use std::fmt::Display;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

fn main() -> ExitCode {
    let failed = match Arguments::parse().command {
        Command::Fit(arguments) => fit_all(&arguments),
        Command::Detect(arguments) => detect_all(&arguments),
        Command::Demo(arguments) => run_demo(&arguments),
        Command::Plan(arguments) => print_plan(&arguments),
        #[cfg(feature = "twin")]
        Command::Twin(arguments) => make_frames(&arguments),
        #[cfg(feature = "bench")]
        Command::Bench(arguments) => run_bench(&arguments),
    };
    match failed {
        Ok(false) => ExitCode::SUCCESS,
        Ok(true) => ExitCode::FAILURE,
        // Whoever reads the output has seen enough, as `head` does.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Err(error) => {
            complain(format_args!("the output cannot be written: {error}"));
            ExitCode::FAILURE
        }
    }
}

/// Why the library refuses an option.
fn option_error(error: &cylfuse::error::Error) -> String {
    format!("{} ({})", failure::in_words(error), error.name())
}

/// Whether results can be written, before there is work to lose.
fn can_write(out: Option<&Path>, report: Option<&Path>) -> bool {
    out.is_none_or(|folder| !complained(fit::create_folder(folder)))
        && report.is_none_or(|path| !complained(fit::check_writable(path)))
}

/// Fits everything; tells whether something failed.
fn fit_all(arguments: &FitArguments) -> io::Result<bool> {
    let settings = match arguments.check() {
        Ok(()) => Settings::new(arguments),
        Err(message) => usage_error("fit", ErrorKind::ArgumentConflict, &message),
    };
    let settings = match settings {
        Ok(settings) => settings,
        Err(error) => usage_error("fit", ErrorKind::ValueValidation, &option_error(&error)),
    };
    let inputs = inputs::of(&arguments.points, &arguments.frames, arguments.out.as_deref());
    if !can_write(arguments.out.as_deref(), arguments.common.report.as_deref()) {
        return Ok(true);
    }
    let metres = arguments.points.is_empty();
    let progress = progress_bar(inputs.len());
    let mut failed = false;
    let mut reports = Vec::new();
    let mut written = Ok(());
    let mut take = |report: Report| {
        failed |= matches!(report.outcome, Outcome::Failed { .. });
        if arguments.common.json && written.is_ok() {
            written = progress.suspend(|| print_json(&report));
        }
        if !arguments.common.json || arguments.common.report.is_some() {
            reports.push(report);
        }
        progress.inc(1);
    };
    fit::run_all(&inputs, settings, &mut take).map_err(io::Error::other)?;
    progress.finish_and_clear();
    written?;
    if !arguments.common.json {
        print_table(&reports, metres)?;
    }
    if let Some(path) = &arguments.common.report {
        failed |= complained(page::write_fits(path, &reports, &arguments.common.tolerance, metres));
    }
    Ok(failed)
}

/// Searches everything; tells whether something failed.
fn detect_all(arguments: &DetectArguments) -> io::Result<bool> {
    if let Err(message) = arguments.common.check() {
        usage_error("detect", ErrorKind::ValueValidation, &message);
    }
    let options = match arguments.options() {
        Ok(options) => options,
        Err(error) => usage_error("detect", ErrorKind::ValueValidation, &option_error(&error)),
    };
    let illustrate = arguments.common.report.is_some();
    let settings = detect::Settings { options, image: !arguments.common.no_image, illustrate };
    let inputs = inputs::of(&arguments.points, &arguments.frames, arguments.out.as_deref());
    if !can_write(arguments.out.as_deref(), arguments.common.report.as_deref()) {
        return Ok(true);
    }
    let metres = arguments.points.is_empty();
    let progress = progress_bar(inputs.len());
    let mut failed = false;
    let mut reports = Vec::new();
    let mut written = Ok(());
    let mut take = |report: SceneReport| {
        failed |= matches!(report.outcome, SceneOutcome::Failed { .. });
        if written.is_ok() {
            let print =
                || if arguments.common.json { print_json(&report) } else { print_scene(&report, metres) };
            written = progress.suspend(print);
        }
        if illustrate {
            reports.push(report);
        }
        progress.inc(1);
    };
    let search =
        |(input, folder): &(Input, Option<PathBuf>)| detect::run(input, &settings, folder.as_deref());
    fit::in_order(&inputs, arguments.threads, &search, &mut take).map_err(io::Error::other)?;
    progress.finish_and_clear();
    written?;
    if let Some(path) = &arguments.common.report {
        failed |= complained(page::write_scenes(path, &reports, &arguments.common.tolerance, metres));
    }
    Ok(failed)
}

fn print_scene(report: &SceneReport, metres: bool) -> io::Result<()> {
    match &report.outcome {
        SceneOutcome::Searched(scene) => {
            writeln!(io::stdout(), "{}", table::render_scene(&report.frame, scene, metres))
        }
        SceneOutcome::Failed { error } => {
            complain(error);
            Ok(())
        }
    }
}

fn run_demo(arguments: &DemoArguments) -> io::Result<bool> {
    let folder = arguments.out.display();
    match demo::run(&arguments.out) {
        Ok((report, scene)) => {
            print_table(&[report], true)?;
            print_scene(&scene, true)?;
            let contents = demo::CONTENTS;
            writeln!(
                io::stdout(),
                "\n{folder}/\n{contents}\n\nTry: cylfuse fit --objective paper {folder}/frame\n     cylfuse detect --no-image {folder}/scene"
            )?;
            Ok(false)
        }
        Err(failure) => {
            complain(failure);
            Ok(true)
        }
    }
}

/// Prints what a camera will measure; tells whether some row failed.
fn print_plan(arguments: &PlanArguments) -> io::Result<bool> {
    let base = match arguments.plan() {
        Ok(base) => base,
        Err(failure) if plan::of_command_line(&failure) => bad_plan(&failure),
        Err(failure) => {
            complain(failure);
            return Ok(true);
        }
    };
    let rows = plan::rows(arguments, &base);
    // A mistake of the command line that every row has is none of the varied value: it ends with the code of such mistakes.
    let mut failures = rows.iter().map(|row| row.expected.as_ref().err());
    if let Some(Some(first)) = failures.next()
        && plan::of_command_line(first)
        && failures.all(|failure| failure.is_some_and(plan::of_command_line))
    {
        bad_plan(first)
    }
    #[cfg(feature = "twin")]
    let rows = with_captures(rows, arguments)?;
    let failed = rows.iter().any(|row| row.expected.is_err());
    if arguments.json {
        for row in &rows {
            print_json(&plan::RowJson::from(row))?;
        }
        return Ok(failed);
    }
    write!(io::stdout(), "{}", plan::render(&rows, arguments.vary.as_ref()))?;
    if let (Some(percent), Some(vary)) = (arguments.within, &arguments.vary) {
        writeln!(io::stdout(), "{}", plan::within(&rows, &base, vary, percent))?;
    }
    Ok(failed)
}

fn bad_plan(Failure { status, message }: &Failure) -> ! {
    usage_error("plan", ErrorKind::ValueValidation, &format!("{message} ({status})"))
}

#[cfg(feature = "twin")]
fn with_captures(mut rows: Vec<plan::Row>, arguments: &PlanArguments) -> io::Result<Vec<plan::Row>> {
    let Some(count) = arguments.simulate else { return Ok(rows) };
    let progress = progress_bar(rows.len().saturating_mul(count as usize));
    for row in rows.iter_mut().filter(|row| row.expected.is_ok()) {
        plan::simulate(row, arguments, count, &|| progress.inc(1)).map_err(io::Error::other)?;
    }
    progress.finish_and_clear();
    Ok(rows)
}

/// Makes all frames; tells whether something failed.
#[cfg(feature = "twin")]
fn make_frames(arguments: &twin_arguments::TwinArguments) -> io::Result<bool> {
    let options = match arguments.options() {
        Ok(options) => options,
        Err(error) => usage_error("twin", ErrorKind::ValueValidation, &format!("{error} ({})", error.name())),
    };
    let seeds: Vec<u64> = (0..u64::from(arguments.count)).map(|k| arguments.seed.wrapping_add(k)).collect();
    let progress = progress_bar(seeds.len());
    let mut failures = Vec::new();
    let make = |seed: &u64| twin::run(*seed, arguments, &options);
    fit::in_order(&seeds, arguments.threads, &make, &mut |made| {
        failures.extend(made.err());
        progress.inc(1);
    })
    .map_err(io::Error::other)?;
    progress.finish_and_clear();
    failures.iter().for_each(complain);
    let made = seeds.len() - failures.len();
    writeln!(io::stdout(), "{made} frames in {}", arguments.out.display())?;
    Ok(!failures.is_empty())
}

/// Runs the experiments and writes the report; tells whether that failed.
#[cfg(feature = "bench")]
fn run_bench(arguments: &bench::BenchArguments) -> io::Result<bool> {
    match bench::run(arguments) {
        Ok(said) => writeln!(io::stdout(), "{said}").map(|()| false),
        Err(failure) => {
            complain(failure);
            Ok(true)
        }
    }
}

fn print_json(report: &impl serde::Serialize) -> io::Result<()> {
    let line = serde_json::to_string(report).map_err(io::Error::other)?;
    writeln!(io::stdout(), "{line}")
}

fn print_table(reports: &[Report], metres: bool) -> io::Result<()> {
    write!(io::stdout(), "{}", table::render(reports, metres))?;
    for report in reports {
        if let Outcome::Failed { error } = &report.outcome {
            // Most messages start with the path of a file of the frame.
            let name = table::short_name(&report.frame);
            let whose = if error.message.starts_with(name) { String::new() } else { format!("{name}: ") };
            complain(format_args!("{whose}{error}"));
        }
    }
    Ok(())
}

/// A bar on stderr while several frames are under way; none when that is no terminal.
fn progress_bar(count: usize) -> ProgressBar {
    if count < 2 {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{wide_bar} {pos}/{len} {elapsed}, {eta} left");
    ProgressBar::new(count as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// A mistake in the command line: explained on stderr, exit status 2.
fn usage_error(name: &str, kind: ErrorKind, message: &str) -> ! {
    let mut command = Arguments::command();
    command.build();
    match command.find_subcommand_mut(name) {
        Some(subcommand) => subcommand.error(kind, message).exit(),
        None => command.error(kind, message).exit(),
    }
}

/// Tells on stderr of a failure; whether there was one.
fn complained(outcome: Result<(), Failure>) -> bool {
    let failure = outcome.err();
    if let Some(failure) = &failure {
        complain(failure);
    }
    failure.is_some()
}

/// A line on stderr. When even that is gone, nobody is left to be told.
fn complain(message: impl Display) {
    let _ = writeln!(io::stderr(), "cylfuse: {message}");
}
