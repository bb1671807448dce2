//! `cylfuse demo`: a frame and a scene that come with the program.

use crate::detect::{self, SceneOutcome, SceneReport};
use crate::failure::Failure;
use crate::fit::{self, Settings};
use crate::inputs::Input;
use crate::report::{Outcome, Report};
use cylfuse::fitter::Options;
use cylfuse::scene::DetectorOptions;
use std::io::Write;
use std::path::Path;

macro_rules! data_file {
    ($folder:literal, $name:literal) => {
        ($name, include_bytes!(concat!("../../../tests/data/", $folder, $name)))
    };
}

/// The files of the frame.
const FRAME: [(&str, &[u8]); 4] = [
    data_file!("frames/r40_a20_f0/", "frame.json"),
    data_file!("frames/r40_a20_f0/", "image.png"),
    data_file!("frames/r40_a20_f0/", "depth.png"),
    data_file!("frames/r40_a20_f0/", "mask.png"),
];

/// The files of the scene.
const SCENE: [(&str, &[u8]); 3] = [
    data_file!("scene/", "frame.json"),
    data_file!("scene/", "image.png"),
    data_file!("scene/", "depth.png"),
];

/// What each of the files in the folder is.
pub const CONTENTS: &str = "  frame/          the input: camera, image, depth, mask and two edges
  result.json     all numbers
  overlay.png     limbs, ends, axis and completed surface over the image
  completed.ply   the points on the fitted surface, for any viewer of point clouds
  completed.pcd   the same for the Point Cloud Library
  scene/          another input, with camera, image and depth of several things on a table; overlay.png there shows
                  all cylinders that were found, labels.png the cylinder of each pixel, completed.ply their surfaces
                  among the other points";

/// Unpacks frame and scene into a folder, fits the one and searches the other there.
pub fn run(folder: &Path) -> Result<(Report, SceneReport), Failure> {
    let (frame, scene) = (folder.join("frame"), folder.join("scene"));
    unpack(&FRAME, &frame)?;
    unpack(&SCENE, &scene)?;
    let settings = Settings {
        options: Options::default(),
        start: None,
        edges: true,
        image: true,
        illustrate: false,
        threads: 1,
    };
    let report = fit::run(&Input::Frame(frame.join("frame.json")), &settings, Some(folder));
    if let Outcome::Failed { error } = report.outcome {
        return Err(error);
    }
    let settings = detect::Settings { options: DetectorOptions::default(), image: true, illustrate: false };
    let found = detect::run(&Input::Frame(scene.join("frame.json")), &settings, Some(&scene));
    if let SceneOutcome::Failed { error } = found.outcome {
        return Err(error);
    }
    Ok((report, found))
}

fn unpack(files: &[(&str, &[u8])], folder: &Path) -> Result<(), Failure> {
    fit::create_folder(folder)?;
    for (name, bytes) in files {
        fit::write_file(&folder.join(name), |to| to.write_all(bytes))?;
    }
    Ok(())
}
