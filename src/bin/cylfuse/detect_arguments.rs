//! What can be asked of `cylfuse detect`.

#![allow(clippy::doc_markdown, reason = "the comments on options are the help text, which is no Markdown")]

use crate::common_arguments::{CommonArguments, NOISE};
use clap::{ArgGroup, Args};
use cylfuse::detection::DetectionOptions;
use cylfuse::error::Result;
use cylfuse::fitter::Options;
use cylfuse::scene::DetectorOptions;
use std::path::PathBuf;

/// `cylfuse detect`.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("scene").required(true).args(["frames", "points"]))]
#[command(after_help = NOISE)]
pub struct DetectArguments {
    /// Frame files of one view, or folders that are searched for frame.json. Masks, edges and the pose in them are
    /// ignored.
    #[arg(value_name = "FRAME")]
    pub frames: Vec<PathBuf>,

    /// Search point clouds without a camera instead: .ply, .pcd, or .xyz (x y z on each line; also .txt, .csv, .asc).
    #[arg(long, value_name = "CLOUD", num_args = 1..)]
    pub points: Vec<PathBuf>,

    /// Write overlay.png, labels.png (16 bit: 0 none, k the k-th cylinder) and completed.ply to this folder; with several
    /// frames to a subfolder for each. completed.ply has the completed surface of each cylinder, and the measured
    /// points of all other pixels; of a cloud it has the points unchanged. Its property cylinder is the number, as in
    /// labels.png. For a cloud only completed.ply is written.
    #[arg(long, value_name = "DIR", help_heading = "Output")]
    pub out: Option<PathBuf>,

    /// Maximum number of cylinders per frame, 0 for no maximum.
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = "Search")]
    pub max_count: usize,

    /// Minimum score, from 0 to 1: the estimated probability that there is a cylinder [default: 0.5].
    #[arg(long, value_name = "P", allow_hyphen_values = true, help_heading = "Search")]
    pub min_score: Option<f64>,

    /// What `cylfuse fit` takes too.
    #[command(flatten)]
    pub common: CommonArguments,

    /// Maximum number of threads, 0 for as many as the machine has. Results do not depend on it.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
}

impl DetectArguments {
    /// The library's options.
    ///
    /// # Errors
    /// `InvalidArgument` for a value out of range.
    pub fn options(&self) -> Result<DetectorOptions> {
        let defaults = DetectionOptions::default();
        let search = DetectionOptions {
            limits: self.common.limits(),
            max_count: if self.max_count == 0 { defaults.max_count } else { self.max_count },
            min_score: self.min_score.unwrap_or(defaults.min_score),
            ..defaults
        };
        let fit = Options { noise: self.common.noise_model(), ..Options::default() };
        search.check()?;
        fit.check()?;
        Ok(DetectorOptions { search, fit, ..DetectorOptions::default() })
    }
}
