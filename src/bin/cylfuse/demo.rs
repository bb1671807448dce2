//! `cylfuse demo`: a frame that comes with the program.

use crate::failure::Failure;
use crate::fit::{self, Settings};
use crate::inputs::Input;
use crate::report::{Outcome, Report};
use cylfuse::fitter::Options;
use std::io::Write;
use std::path::Path;

macro_rules! frame_file {
    ($name:literal) => {
        ($name, include_bytes!(concat!("../../../tests/data/frames/r40_a20_f0/", $name)))
    };
}

/// The files of the frame.
const FILES: [(&str, &[u8]); 4] =
    [frame_file!("frame.json"), frame_file!("image.png"), frame_file!("depth.png"), frame_file!("mask.png")];

/// What each of the files in the folder is.
pub const CONTENTS: &str = "  frame/          the input: camera, image, depth, mask and two edges
  result.json     all numbers
  overlay.png     limbs, ends, axis and completed surface over the image
  completed.ply   the points on the fitted surface, for any viewer of point clouds
  completed.pcd   the same for the Point Cloud Library";

/// Unpacks the frame into a folder and fits it there.
pub fn run(folder: &Path) -> Result<Report, Failure> {
    let frame = folder.join("frame");
    fit::create_folder(&frame)?;
    for (name, bytes) in FILES {
        fit::write_file(&frame.join(name), |to| to.write_all(bytes))?;
    }
    let settings =
        Settings { options: Options::default(), start: None, edges: true, image: true, threads: 1 };
    let report = fit::run(&Input::Frame(frame.join("frame.json")), &settings, Some(folder));
    match report.outcome {
        Outcome::Failed { error } => Err(error),
        Outcome::Measured(_) => Ok(report),
    }
}
