//! `cylfuse bench`: the experiments of the paper, and others, on frames of the twin.

mod arguments;
mod experiments;
mod folder;
mod methods;
mod page;
mod picture;
mod plot;
mod program;
mod published;
mod sample;
mod stage;
mod statistics;
mod trial;

pub use arguments::BenchArguments;

use crate::failure::Failure;
use crate::fit::{create_folder, in_order, write_file};
use experiments::{EXPERIMENTS, Experiment};
use indicatif::ProgressBar;
use methods::Method;
use page::Section;
use program::{Program, Task};
use sample::Sample;
use stage::OnBoard;
use std::io::Write;
use std::path::Path;
use std::sync::OnceLock;
use std::time::Duration;

/// Seeds between experiments, of which none takes as many.
const STRIDE: u64 = 10_000;

/// How much is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// As in the paper.
    Full,
    /// About a minute.
    Quick,
    /// The least that runs through every step.
    Smallest,
}

impl Scale {
    /// A number for each scale.
    pub fn of<T>(self, full: T, quick: T, smallest: T) -> T {
        match self {
            Scale::Full => full,
            Scale::Quick => quick,
            Scale::Smallest => smallest,
        }
    }
}

/// What all experiments share.
pub struct Bench {
    /// How much is done.
    pub scale: Scale,
    /// The Point Cloud Library, if there is any.
    pub pcl: Option<Program>,
    /// CGAL, if there is any.
    pub cgal: Option<Program>,
    seed: u64,
    threads: usize,
    progress: ProgressBar,
    validation: OnceLock<Vec<Sample>>,
}

impl Bench {
    /// The seed of a frame or trial of an experiment.
    pub fn seed(&self, experiment: u64, index: usize) -> u64 {
        self.seed.wrapping_add(experiment * STRIDE + index as u64)
    }

    /// The 24 configurations of the paper, or some of them.
    pub fn configurations(&self) -> Vec<(u32, u32)> {
        match self.scale {
            Scale::Full | Scale::Quick => published::configurations(),
            Scale::Smallest => vec![(30, 0), (60, 30)],
        }
    }

    /// The methods that are compared.
    pub fn compared(&self) -> Vec<Method> {
        Method::COMPARED.into_iter().chain(self.pcl.as_ref().map(|_| Method::Pcl)).collect()
    }

    /// Tries the programs of other libraries with what these experiments ask of them.
    ///
    /// # Errors
    /// `OTHER_LIBRARY`.
    fn try_out(&self, experiments: &[&Experiment]) -> Result<(), Failure> {
        let asks = |task| experiments.iter().any(|experiment| experiment.asks == Some(task));
        if let Some(pcl) = self.pcl.as_ref().filter(|_| asks(Task::Fit)) {
            pcl.try_out(Task::Fit)?;
        }
        let mut programs = self.pcl.iter().chain(&self.cgal).filter(|_| asks(Task::Scene));
        programs.try_for_each(|program| program.try_out(Task::Scene))
    }

    /// Does something with all items, side by side; the results come in the order of the items.
    ///
    /// # Errors
    /// The first failure.
    pub fn map<I: Sync, T: Send>(
        &self,
        items: &[I],
        work: impl Fn(&I) -> Result<T, Failure> + Sync,
    ) -> Result<Vec<T>, Failure> {
        self.map_silently(items, |item| {
            let result = work(item);
            self.progress.inc(1);
            result
        })
    }

    /// The same without progress.
    fn map_silently<I: Sync, T: Send>(
        &self,
        items: &[I],
        work: impl Fn(&I) -> Result<T, Failure> + Sync,
    ) -> Result<Vec<T>, Failure> {
        let mut results = Vec::new();
        in_order(items, self.threads, &work, &mut |result| results.push(result))
            .map_err(|error| Failure { status: "THREADS", message: format!("no threads: {error}") })?;
        results.into_iter().collect()
    }

    /// A capture of a configuration of the paper; those of one configuration share scene and annotation, as there.
    ///
    /// # Errors
    /// Those of the twin.
    pub fn capture(&self, configuration: (u32, u32), number: usize) -> Result<Sample, Failure> {
        let (radius, tilt) = configuration;
        let all = published::configurations();
        let index = all.iter().position(|other| *other == configuration).unwrap_or(0);
        let seed = self.seed(0, 100 * index);
        let scene = OnBoard::configuration(configuration).scene(seed)?;
        let options = stage::capture_options(stage::structured_light())?;
        let name = format!("r = {radius} mm, α = {tilt}°");
        Sample::take(name, &scene, &options, [seed + number as u64, seed])
    }

    /// The first frames of the paper's validation subset, made once.
    ///
    /// # Errors
    /// Those of the twin.
    pub fn validation(&self) -> Result<&[Sample], Failure> {
        if let Some(samples) = self.validation.get() {
            return Ok(samples);
        }
        let wanted = match self.scale {
            Scale::Full | Scale::Quick => published::validation(),
            Scale::Smallest => self.configurations(),
        };
        let samples = self.map_silently(&wanted, |configuration| self.capture(*configuration, 0))?;
        Ok(self.validation.get_or_init(|| samples))
    }
}

/// Runs the experiments and writes report and numbers; returns what is to be printed.
///
/// # Errors
/// Where frames cannot be made or read, or files cannot be written. A fit that fails is a figure of the report.
pub fn run(arguments: &BenchArguments) -> Result<String, Failure> {
    let scale = match (arguments.smallest, arguments.quick) {
        (true, _) => Scale::Smallest,
        (_, true) => Scale::Quick,
        _ => Scale::Full,
    };
    let limit = Duration::from_secs(arguments.time_limit);
    let program = |library, path: &Path| Program::new(library, path, limit);
    let mut bench = Bench {
        scale,
        pcl: arguments.pcl.as_deref().map(|path| program("PCL", path)).transpose()?,
        cgal: arguments.cgal.as_deref().map(|path| program("CGAL", path)).transpose()?,
        seed: arguments.seed,
        threads: arguments.threads,
        progress: ProgressBar::hidden(),
        validation: OnceLock::new(),
    };
    let frames = arguments.frames.as_deref().map(folder::inputs).transpose()?;
    // Not after half an hour.
    create_folder(&arguments.out)?;
    let sections = if let Some(frames) = frames {
        bench.progress = crate::progress_bar(frames.len());
        folder::run(&bench, &frames)?
    } else {
        let wanted = |experiment: &&Experiment| {
            arguments.only.is_empty() || arguments.only.iter().any(|name| name == experiment.name)
        };
        let wanted: Vec<&Experiment> = EXPERIMENTS.iter().filter(wanted).collect();
        // Nor does anybody want to learn after half an hour that a program does not work.
        bench.try_out(&wanted)?;
        bench.progress = crate::progress_bar(wanted.iter().map(|one| (one.count)(&bench)).sum());
        let run = |experiment: &&Experiment| (experiment.run)(&bench);
        wanted.iter().map(run).collect::<Result<Vec<_>, _>>()?
    };
    bench.progress.finish_and_clear();
    write(arguments, &bench, &sections)
}

fn write(arguments: &BenchArguments, bench: &Bench, sections: &[Section]) -> Result<String, Failure> {
    let compared = |program: &Option<Program>, option: &str| match program {
        Some(_) => "compared".to_string(),
        None => format!("left out: no program was named by {option}"),
    };
    let facts = [
        ("command", command()),
        ("version", format!("cylfuse {}, commit {}", env!("CARGO_PKG_VERSION"), env!("CYLFUSE_COMMIT"))),
        ("machine", machine()),
        ("seed", arguments.seed.to_string()),
        ("PCL", compared(&bench.pcl, "--pcl")),
        ("CGAL", compared(&bench.cgal, "--cgal")),
    ];
    let page = page::page("What cylfuse measures, and how well", &facts, sections);
    let path = arguments.out.join("index.html");
    write_file(&path, |to| to.write_all(page.as_bytes()))?;
    for csv in sections.iter().flat_map(|section| &section.numbers) {
        let path = arguments.out.join(format!("{}.csv", csv.name));
        write_file(&path, |to| to.write_all(csv.text.as_bytes()))?;
    }
    let said: Vec<String> = sections.iter().filter_map(|section| section.said.clone()).collect();
    Ok(format!("{}{}", said.concat(), path.display()))
}

/// The command line as it was given, the program by its name alone.
fn command() -> String {
    let mut words: Vec<String> = std::env::args().collect();
    if let Some(program) = words.first_mut() {
        *program = "cylfuse".into();
    }
    words.join(" ")
}

/// Processor, cores and system.
fn machine() -> String {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let processor = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_string())
    });
    let processor = processor.unwrap_or_else(|| std::env::consts::ARCH.to_string());
    format!("{processor}, {cores} cores, {}", std::env::consts::OS)
}
