//! The page about a batch: one file that needs no other, for the browser.
//!
//! The page is `page.html` with its style, its program and three.js inside; what is said stands in it as JSON, and the program
//! makes text of it, never markup.

mod tolerance;

pub use tolerance::{Quantity, Tolerance, Verdict};

use crate::canvas::color_of;
use crate::detect::{SceneOutcome, SceneReport};
use crate::failure::Failure;
use crate::fit::write_file;
use crate::report::{Measurement, Outcome, Report};
use crate::table::short_name;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::codecs::jpeg::JpegEncoder;
use image::imageops::{self, FilterType};
use image::{ExtendedColorType, RgbImage};
use serde::Serialize;
use std::io::Write;
use std::path::Path;

const PAGE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
const PROGRAM: &str = include_str!("page.js");
const THREE: &str = include_str!("three.min.js");
const THREE_LICENSE: &str = include_str!("three.LICENSE");

/// Width of a picture in pixels, and its quality: some 20 kB each.
const PICTURE_WIDTH: u32 = 480;
const PICTURE_QUALITY: u8 = 75;

/// Most points of a cylinder and of a scene: enough to see where they lie.
pub const POINTS_OF_CYLINDER: usize = 1500;
pub const POINTS_OF_SCENE: usize = 8000;

/// What a page shows of a frame beside its numbers.
#[derive(Debug, Clone, Default)]
pub struct Illustration {
    /// A JPEG.
    picture: Vec<u8>,
    /// Where the points count from: they may lie far off.
    origin: [f64; 3],
    /// Points in the frame of reference, less the origin.
    points: Vec<[f32; 3]>,
}

impl Illustration {
    /// From a picture, of which only the part above its captions is shown, and points, of which about `most` are.
    pub fn new(
        picture: Option<RgbImage>,
        (width, height): (usize, usize),
        points: &[[f64; 3]],
        most: usize,
    ) -> Self {
        let finite = || points.iter().filter(|point| point.iter().all(|x| x.is_finite()));
        let origin = finite().next().copied().unwrap_or_default();
        let step = finite().count().div_ceil(most).max(1);
        let near = |point: &[f64; 3]| std::array::from_fn(|k| (point[k] - origin[k]) as f32);
        let points = finite().step_by(step).map(near).collect();
        let picture = picture.and_then(|picture| small(&picture, width, height)).unwrap_or_default();
        Self { picture, origin, points }
    }
}

/// The part of a picture above its captions, small.
fn small(picture: &RgbImage, width: usize, height: usize) -> Option<Vec<u8>> {
    let ratio = height as f64 / width as f64;
    let shown = ((f64::from(picture.width()) * ratio).round() as u32).clamp(1, picture.height());
    let shown = imageops::crop_imm(picture, 0, 0, picture.width(), shown).to_image();
    let small_height = ((f64::from(PICTURE_WIDTH) * ratio).round() as u32).max(1);
    let small = imageops::resize(&shown, PICTURE_WIDTH, small_height, FilterType::Triangle);
    let mut bytes = Vec::new();
    let mut encoder = JpegEncoder::new_with_quality(&mut bytes, PICTURE_QUALITY);
    encoder.encode(&small, small.width(), small.height(), ExtendedColorType::Rgb8).ok()?;
    Some(bytes)
}

/// What the program of the page reads.
#[derive(Debug, Serialize)]
struct Content<'a> {
    version: &'static str,
    /// Millimetres in the unit of the data, or none where that is not known.
    millimetres: Option<f64>,
    tolerances: &'a [Tolerance],
    frames: Vec<FrameContent>,
}

#[derive(Debug, Serialize)]
struct FrameContent {
    name: String,
    error: Option<String>,
    /// A JPEG in base 64; empty for none.
    picture: String,
    origin: [f64; 3],
    /// f32, little endian, three a point, less the origin, in base 64.
    points: String,
    cylinders: Vec<CylinderContent>,
}

#[derive(Debug, Serialize)]
struct CylinderContent {
    /// Of a cylinder among several.
    number: Option<usize>,
    /// Red, green and blue, as in the picture.
    color: [u8; 3],
    score: Option<f64>,
    point: [f64; 3],
    direction: [f64; 3],
    radius: f64,
    radius_deviation: Option<f64>,
    ends: Option<[[f64; 3]; 2]>,
    end_states: Option<String>,
    length: Option<f64>,
    length_deviation: Option<f64>,
    warnings: Vec<String>,
    verdict: Option<Verdict>,
}

impl CylinderContent {
    fn new(measurement: &Measurement, tolerances: &[Tolerance]) -> Self {
        let Measurement { cylinder, uncertainty, extent, notes, .. } = measurement;
        let radius_deviation = uncertainty.as_ref().map(|uncertainty| uncertainty.radius);
        let length = extent.as_ref().map(|extent| extent.length);
        let length_deviation = extent.as_ref().and_then(|extent| extent.length_deviation);
        Self {
            number: None,
            color: color_of(0),
            score: None,
            point: cylinder.point,
            direction: cylinder.direction,
            radius: cylinder.radius,
            radius_deviation,
            ends: extent.as_ref().map(|extent| [extent.start, extent.end]),
            end_states: extent.as_ref().map(|extent| format!("{}, {}", extent.start_state, extent.end_state)),
            length,
            length_deviation,
            warnings: notes.clone(),
            verdict: tolerance::verdict(
                tolerances,
                (Some(cylinder.radius), radius_deviation),
                (length, length_deviation),
            ),
        }
    }
}

impl FrameContent {
    fn new(name: &str, illustration: Option<&Illustration>) -> Self {
        let nothing = Illustration::default();
        let Illustration { picture, origin, points } = illustration.unwrap_or(&nothing);
        let bytes: Vec<u8> = points.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        Self {
            name: name.into(),
            error: None,
            picture: STANDARD.encode(picture),
            origin: *origin,
            points: STANDARD.encode(bytes),
            cylinders: Vec::new(),
        }
    }

    fn of_fit(report: &Report, tolerances: &[Tolerance]) -> Self {
        let name = short_name(&report.frame);
        match &report.outcome {
            Outcome::Failed { error } => Self { error: Some(error.message.clone()), ..Self::new(name, None) },
            Outcome::Measured(measurement) => Self {
                cylinders: vec![CylinderContent::new(measurement, tolerances)],
                ..Self::new(name, measurement.illustration.as_ref())
            },
        }
    }

    fn of_scene(report: &SceneReport, tolerances: &[Tolerance]) -> Self {
        let name = short_name(&report.frame);
        match &report.outcome {
            SceneOutcome::Failed { error } => {
                Self { error: Some(error.message.clone()), ..Self::new(name, None) }
            }
            SceneOutcome::Searched(scene) => {
                let cylinders = scene.cylinders.iter().enumerate().map(|(index, found)| CylinderContent {
                    number: Some(index + 1),
                    color: color_of(index),
                    score: Some(found.score),
                    ..CylinderContent::new(&found.measurement, tolerances)
                });
                Self { cylinders: cylinders.collect(), ..Self::new(name, scene.illustration.as_ref()) }
            }
        }
    }
}

/// Writes the page about fits. Frames are in metres; the unit of clouds is not known.
pub fn write_fits(
    path: &Path,
    reports: &[Report],
    tolerances: &[Tolerance],
    metres: bool,
) -> Result<(), Failure> {
    write(path, reports.iter().map(|report| FrameContent::of_fit(report, tolerances)), tolerances, metres)
}

/// Writes the page about scenes.
pub fn write_scenes(
    path: &Path,
    reports: &[SceneReport],
    tolerances: &[Tolerance],
    metres: bool,
) -> Result<(), Failure> {
    write(path, reports.iter().map(|report| FrameContent::of_scene(report, tolerances)), tolerances, metres)
}

fn write(
    path: &Path,
    frames: impl Iterator<Item = FrameContent>,
    tolerances: &[Tolerance],
    metres: bool,
) -> Result<(), Failure> {
    let content = Content {
        version: env!("CARGO_PKG_VERSION"),
        millimetres: metres.then_some(1000.0),
        tolerances,
        frames: frames.collect(),
    };
    let json = serde_json::to_string(&content).map_err(|error| Failure::not_writable(path, error))?;
    // Inside of a script nothing but its end has a meaning in HTML.
    let json = json.replace('<', "\\u003c");
    write_file(path, |to| {
        let parts = [
            ("style", STYLE.to_string()),
            ("content", json),
            ("three", format!("/*\n{THREE_LICENSE}*/\n{THREE}")),
            ("program", PROGRAM.to_string()),
        ];
        let mut rest = PAGE;
        for (name, part) in parts {
            let mark = format!("{{{{{name}}}}}");
            if let Some((before, after)) = rest.split_once(&mark) {
                to.write_all(before.as_bytes())?;
                to.write_all(part.as_bytes())?;
                rest = after;
            }
        }
        to.write_all(rest.as_bytes())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_has_its_place_and_none_ends_a_script() {
        let places: Vec<usize> = ["{{style}}", "{{content}}", "{{three}}", "{{program}}"]
            .iter()
            .map(|mark| PAGE.find(mark).unwrap())
            .collect();
        assert!(places.is_sorted());
        for part in [PROGRAM, THREE, THREE_LICENSE] {
            assert!(!part.contains("</script"));
        }
    }

    #[test]
    fn names_cannot_leave_the_script() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("page.html");
        let failure = Failure { status: "BAD_FRAME", message: "</script><b>".into() };
        let report = Report::new(Path::new("</script><img src=x>/frame.json"), Err(failure));
        write_fits(&path, &[report], &[], true).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains("\\u003c/script>\\u003cimg src=x>"));
        assert_eq!(text.matches("</script>").count(), PAGE.matches("</script>").count());
        assert!(!text.contains("<img src=x>") && !text.contains("{{"), "left unfilled");
    }

    #[test]
    fn pictures_and_points_are_few() {
        let picture = RgbImage::new(1280, 1100);
        let points = vec![[1.0, 2.0, 3.0]; 5000];
        let most = POINTS_OF_CYLINDER;
        let Illustration { picture, points, .. } =
            Illustration::new(Some(picture), (640, 480), &points, most);
        assert!(points.len() <= most && points.len() > most / 2);
        let small = image::load_from_memory(&picture).unwrap();
        assert_eq!((small.width(), small.height()), (480, 360));
    }
}
