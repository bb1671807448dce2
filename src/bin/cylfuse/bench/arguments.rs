//! What can be asked of `cylfuse bench`.

#![allow(clippy::doc_markdown, reason = "the comments on options are the help text, which is no Markdown")]

use clap::Args;
use std::path::PathBuf;

/// The seed of the first frame. Nothing else in the project uses seeds from here on, and no constant was chosen on them.
pub const SEED: u64 = 14_000_000;

/// `cylfuse bench`.
#[derive(Debug, Args)]
#[command(after_help = CONTENTS)]
pub struct BenchArguments {
    /// Where to put the report and the numbers.
    #[arg(long, value_name = "DIR", default_value = "cylfuse-bench")]
    pub out: PathBuf,

    /// Less of everything: about a minute on two cores, with figures that scatter more.
    #[arg(long)]
    pub quick: bool,

    /// The least that runs through every step, for tests.
    #[arg(long, hide = true, conflicts_with = "quick")]
    pub smallest: bool,

    /// Only these experiments; may be given several times.
    #[arg(long, value_name = "NAME", value_parser = super::experiments::NAMES)]
    pub only: Vec<String>,

    /// Score the frames of this folder that have a truth.json beside their frame.json, instead of the experiments.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["only", "quick", "pcl", "cgal"])]
    pub frames: Option<PathBuf>,

    /// The seed of the experiments. The same seed gives the same numbers, times apart.
    #[arg(long, value_name = "N", default_value_t = SEED)]
    pub seed: u64,

    /// The program bench_pcl of tests/cpp, to compare with the Point Cloud Library; left out without it.
    #[arg(long, value_name = "PROGRAM")]
    pub pcl: Option<PathBuf>,

    /// The program bench_cgal of tests/cpp, to compare the detection in scenes with CGAL; left out without it.
    #[arg(long, value_name = "PROGRAM")]
    pub cgal: Option<PathBuf>,

    /// Seconds that either program has for one cloud; then the bench stops.
    #[arg(long, value_name = "SECONDS", default_value_t = 300, value_parser = clap::value_parser!(u64).range(1..))]
    pub time_limit: u64,

    /// Maximum number of threads, 0 for as many as the machine has. Results do not depend on it.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
}

const CONTENTS: &str = "Files of a report:
  index.html  tables, plots and pictures in one file that needs no other
  *.csv       the numbers behind them; all but time.csv are the same for the same seed";
