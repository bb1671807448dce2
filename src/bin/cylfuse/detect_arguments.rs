//! What can be asked of `cylfuse detect`.

#![allow(clippy::doc_markdown, reason = "the comments on options are the help text, which is no Markdown")]

use crate::arguments::parse_numbers;
use crate::page::Tolerance;
use clap::{ArgGroup, Args};
use cylfuse::detection::DetectionOptions;
use cylfuse::error::Result;
use cylfuse::geometry::{AxisCone, CylinderLimits};
use std::path::PathBuf;

/// `cylfuse detect`.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("scene").required(true).args(["frames", "points"]))]
pub struct DetectArguments {
    /// Frame files of one view, or folders that are searched for frame.json. Masks, edges and the pose in them are
    /// ignored.
    #[arg(value_name = "FRAME")]
    pub frames: Vec<PathBuf>,

    /// Search point clouds without a camera instead: .ply, .pcd, or .xyz (x y z on each line; also .txt, .csv, .asc).
    #[arg(long, value_name = "CLOUD", num_args = 1..)]
    pub points: Vec<PathBuf>,

    /// Print one JSON object per frame, each on a line, in the order of the input, instead of the tables.
    #[arg(long, help_heading = "Output")]
    pub json: bool,

    /// Write overlay.png, labels.png (16 bit: 0 none, k the k-th cylinder) and completed.ply to this folder; with several
    /// frames to a subfolder for each. completed.ply has the completed surface of each cylinder, and the measured
    /// points of all other pixels; of a cloud it has the points unchanged. Its property cylinder is the number, as in
    /// labels.png. For a cloud only completed.ply is written.
    #[arg(long, value_name = "DIR", help_heading = "Output")]
    pub out: Option<PathBuf>,

    /// Write a report on all of them as one HTML page: a table with pictures, a histogram, points and cylinders in 3D. It
    /// needs no other file and no network.
    #[arg(long, value_name = "FILE.html", help_heading = "Output")]
    pub report: Option<PathBuf>,

    /// State in the report whether the radius or the length is within these limits, in the unit of the data: pass, fail, or
    /// undecided because of the uncertainty.
    #[arg(long, value_name = "QUANTITY=LOW..HIGH", requires = "report", help_heading = "Output")]
    pub tolerance: Vec<Tolerance>,

    /// Ignore the image file and do not open it.
    #[arg(long, help_heading = "Search")]
    pub no_image: bool,

    /// The smallest radius of a cylinder, in the unit of the data.
    #[arg(long, value_name = "R", allow_hyphen_values = true, help_heading = "Search")]
    pub radius_min: Option<f64>,

    /// The largest radius of a cylinder.
    #[arg(long, value_name = "R", allow_hyphen_values = true, help_heading = "Search")]
    pub radius_max: Option<f64>,

    /// The direction of the axes in the camera frame, of any length and sign.
    #[arg(long, value_name = "x,y,z", value_parser = parse_numbers::<3>)]
    #[arg(allow_hyphen_values = true, help_heading = "Search")]
    pub axis: Option<[f64; 3]>,

    /// How far an axis may be from --axis, in degrees from 0 to 90 [default: 0, the direction is known].
    #[arg(long, value_name = "DEG", requires = "axis")]
    #[arg(allow_hyphen_values = true, help_heading = "Search")]
    pub axis_max_angle: Option<f64>,

    /// Maximum number of cylinders per frame.
    #[arg(long, value_name = "N", help_heading = "Search")]
    pub max_count: Option<usize>,

    /// Minimum score, from 0 to 1: the estimated probability that there is a cylinder [default: 0.5].
    #[arg(long, value_name = "P", allow_hyphen_values = true, help_heading = "Search")]
    pub min_score: Option<f64>,

    /// Maximum number of threads, 0 for as many as the machine has. Results do not depend on it.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
}

impl DetectArguments {
    /// The library's options.
    ///
    /// # Errors
    /// `InvalidArgument` for a value out of range.
    pub fn options(&self) -> Result<DetectionOptions> {
        let defaults = DetectionOptions::default();
        let degrees = self.axis_max_angle.unwrap_or(0.0);
        let max_angle = degrees.to_radians().min(std::f64::consts::FRAC_PI_2);
        let options = DetectionOptions {
            limits: CylinderLimits {
                radius_min: self.radius_min.unwrap_or(defaults.limits.radius_min),
                radius_max: self.radius_max.unwrap_or(defaults.limits.radius_max),
                axis: self.axis.map(|axis| AxisCone { direction: axis.into(), max_angle }),
            },
            max_count: self.max_count.unwrap_or(defaults.max_count),
            min_score: self.min_score.unwrap_or(defaults.min_score),
            ..defaults
        };
        options.check()?;
        Ok(options)
    }
}
