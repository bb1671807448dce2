//! The page about a batch: one file that needs no other, for the browser.
//!
//! The page is `page.html` with its style, its program and three.js inside; what is said stands in it as JSON, and the program
//! makes text of it, never markup.

mod illustration;
mod tolerance;

pub use illustration::{Illustration, Label, PICTURE_WIDTH, POINTS_OF_CYLINDER, POINTS_OF_SCENE, Picture};
pub use tolerance::{Quantity, Tolerance};

use crate::canvas::color_of;
use crate::detect::{SceneOutcome, SceneReport};
use crate::failure::Failure;
use crate::fit::write_file;
use crate::report::{Measurement, Outcome, Report};
use crate::table::short_name;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;
use std::io::Write;
use std::path::Path;
use tolerance::{Judgement, Measured, Unit};

const PAGE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
const PROGRAM: &str = include_str!("page.js");
const THREE: &str = include_str!("three.min.js");
const THREE_LICENSE: &str = include_str!("three.LICENSE");

/// What the program of the page reads.
#[derive(Debug, Serialize)]
struct Content<'a> {
    version: &'static str,
    /// Millimetres in the unit of the data, or none where that is not known.
    millimetres: Option<f64>,
    tolerances: &'a [Tolerance],
    frames: Vec<FrameContent<'a>>,
}

#[derive(Debug, Serialize)]
struct FrameContent<'a> {
    name: String,
    error: Option<String>,
    /// All of it, with several cylinders.
    picture: Option<&'a Picture>,
    origin: [f64; 3],
    /// f32, little endian, three a point, less the origin, in base 64.
    points: String,
    cylinders: Vec<CylinderContent<'a>>,
}

#[derive(Debug, Serialize)]
struct CylinderContent<'a> {
    /// Of a cylinder among several.
    number: Option<usize>,
    /// Red, green and blue, as in the picture.
    color: [u8; 3],
    score: Option<f64>,
    /// What surrounds it.
    picture: Option<&'a Picture>,
    point: [f64; 3],
    direction: [f64; 3],
    radius: f64,
    radius_deviation: Option<f64>,
    ends: Option<[[f64; 3]; 2]>,
    end_states: Option<String>,
    length: Option<f64>,
    length_deviation: Option<f64>,
    warnings: Vec<String>,
    judgement: Option<Judgement>,
}

/// What all cylinders of a page are judged by.
#[derive(Clone, Copy)]
struct Limits<'a> {
    tolerances: &'a [Tolerance],
    unit: Unit,
}

impl<'a> CylinderContent<'a> {
    fn new(measurement: &'a Measurement, limits: Limits<'_>) -> Self {
        let Measurement { cylinder, uncertainty, extent, notes, .. } = measurement;
        let radius_deviation = uncertainty.as_ref().map(|uncertainty| uncertainty.radius);
        let radius = Measured { value: Some(cylinder.radius), deviation: radius_deviation, at_least: false };
        let length = extent.as_ref().map(|extent| Measured {
            value: Some(extent.length),
            deviation: extent.length_deviation,
            at_least: extent.may_go_on(),
        });
        let length = length.unwrap_or_default();
        let undecided_by = &measurement.undecided_by;
        Self {
            number: None,
            color: color_of(0),
            score: None,
            picture: measurement.illustration.as_ref().and_then(|shown| shown.picture.as_ref()),
            point: cylinder.point,
            direction: cylinder.direction,
            radius: cylinder.radius,
            radius_deviation,
            ends: extent.as_ref().map(|extent| [extent.start, extent.end]),
            end_states: extent.as_ref().map(|extent| format!("{}, {}", extent.start_state, extent.end_state)),
            length: length.value,
            length_deviation: length.deviation,
            warnings: notes.clone(),
            judgement: tolerance::judge(limits.tolerances, radius, length, undecided_by, limits.unit),
        }
    }
}

impl<'a> FrameContent<'a> {
    fn new(name: &str, illustration: Option<&Illustration>) -> Self {
        let nothing = Illustration::default();
        let Illustration { origin, points, .. } = illustration.unwrap_or(&nothing);
        let bytes: Vec<u8> = points.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        Self {
            name: name.into(),
            error: None,
            picture: None,
            origin: *origin,
            points: base_64(&bytes),
            cylinders: Vec::new(),
        }
    }

    fn of_fit(report: &'a Report, limits: Limits<'_>) -> Self {
        let name = short_name(&report.frame);
        match &report.outcome {
            Outcome::Failed { error } => Self { error: Some(error.message.clone()), ..Self::new(name, None) },
            Outcome::Measured(measurement) => Self {
                cylinders: vec![CylinderContent::new(measurement, limits)],
                ..Self::new(name, measurement.illustration.as_ref())
            },
        }
    }

    fn of_scene(report: &'a SceneReport, limits: Limits<'_>) -> Self {
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
                    ..CylinderContent::new(&found.measurement, limits)
                });
                Self {
                    cylinders: cylinders.collect(),
                    picture: scene.illustration.as_ref().and_then(|shown| shown.picture.as_ref()),
                    ..Self::new(name, scene.illustration.as_ref())
                }
            }
        }
    }
}

/// Bytes as text.
fn base_64(bytes: &[u8]) -> String {
    STANDARD.encode(bytes)
}

/// Writes the page about fits. Frames are in metres; the unit of clouds is not known.
pub fn write_fits(
    path: &Path,
    reports: &[Report],
    tolerances: &[Tolerance],
    metres: bool,
) -> Result<(), Failure> {
    let limits = Limits { tolerances, unit: unit(metres) };
    write(path, reports.iter().map(|report| FrameContent::of_fit(report, limits)), tolerances, metres)
}

/// Writes the page about scenes.
pub fn write_scenes(
    path: &Path,
    reports: &[SceneReport],
    tolerances: &[Tolerance],
    metres: bool,
) -> Result<(), Failure> {
    let limits = Limits { tolerances, unit: unit(metres) };
    write(path, reports.iter().map(|report| FrameContent::of_scene(report, limits)), tolerances, metres)
}

/// The unit of a page.
fn unit(metres: bool) -> Unit {
    if metres { Unit { factor: 1000.0, name: " mm" } } else { Unit { factor: 1.0, name: "" } }
}

fn write<'a>(
    path: &Path,
    frames: impl Iterator<Item = FrameContent<'a>>,
    tolerances: &'a [Tolerance],
    metres: bool,
) -> Result<(), Failure> {
    let content = Content {
        version: env!("CARGO_PKG_VERSION"),
        millimetres: metres.then_some(unit(metres).factor),
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
        let offsets: Vec<usize> = ["{{style}}", "{{content}}", "{{three}}", "{{program}}"]
            .iter()
            .map(|mark| PAGE.find(mark).unwrap())
            .collect();
        assert!(offsets.is_sorted());
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
}
