//! What can be asked of `cylfuse plan`.

#![allow(clippy::doc_markdown, reason = "the comments on options are the help text, which is no Markdown")]

use crate::common_arguments::parse_numbers;
use crate::failure::Failure;
use crate::frame::Frame;
use clap::{ArgGroup, Args, ValueEnum};
use cylfuse::camera::{Camera, Distortion, Intrinsics};
use cylfuse::plan::{DepthNoise, Plan, StepNoise};
use std::path::PathBuf;
use std::str::FromStr;

/// `cylfuse plan`.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("field").args(["focal_length", "field_of_view", "frame"]))]
#[command(after_help = EXAMPLES)]
pub struct PlanArguments {
    /// From the camera to the middle of the cylinder, in metres.
    #[arg(long, value_name = "M", default_value_t = 0.7, help_heading = "Cylinder")]
    pub distance: f64,

    /// Its radius in metres.
    #[arg(long, value_name = "M", default_value_t = 0.03, help_heading = "Cylinder")]
    pub radius: f64,

    /// Its length in metres.
    #[arg(long, value_name = "M", default_value_t = 0.1, help_heading = "Cylinder")]
    pub length: f64,

    /// The angle between its axis and the plane of the image, in degrees: 0 when it is seen from the side.
    #[arg(
        long,
        value_name = "DEG",
        default_value_t = 20.0,
        value_parser = parse_tilt,
        allow_hyphen_values = true,
        help_heading = "Cylinder"
    )]
    pub tilt: f64,

    /// The angle of its axis in the image from the vertical, in degrees.
    #[arg(
        long,
        value_name = "DEG",
        default_value_t = 24.0,
        allow_hyphen_values = true,
        help_heading = "Cylinder"
    )]
    pub turn: f64,

    /// Use the camera of this frame file (of its first view).
    #[arg(long, value_name = "FRAME", help_heading = "Camera", conflicts_with_all = ["width", "height"])]
    pub frame: Option<PathBuf>,

    /// Width of the image in pixels.
    #[arg(long, value_name = "N", default_value_t = 640, help_heading = "Camera")]
    pub width: u32,

    /// Height of the image in pixels.
    #[arg(long, value_name = "N", default_value_t = 480, help_heading = "Camera")]
    pub height: u32,

    /// Focal length of the image in pixels [default: 0.89 times the width].
    #[arg(long, value_name = "PX", help_heading = "Camera")]
    pub focal_length: Option<f64>,

    /// Horizontal field of view of the image in degrees, instead of the focal length.
    #[arg(long, value_name = "DEG", help_heading = "Camera", value_parser = parse_field_of_view)]
    #[arg(allow_hyphen_values = true)]
    pub field_of_view: Option<f64>,

    /// The kind of depth sensor: its noise law, and the simulated sensor for --simulate.
    #[arg(long, value_enum, default_value_t = Sensor::StructuredLight, help_heading = "Noise")]
    pub sensor: Sensor,

    /// Another noise law for the depth, in metres at a depth of z metres: a + b z + c z^2.
    #[arg(long, value_name = "A,B,C", value_parser = parse_numbers::<3>, help_heading = "Noise")]
    #[arg(conflicts_with = "sensor", requires = "correlation")]
    pub depth_noise: Option<[f64; 3]>,

    /// The side of the squares of pixels of the image that share that noise: a matching window, or the reach of a filter.
    #[arg(long, value_name = "PX", help_heading = "Noise", requires = "depth_noise")]
    pub correlation: Option<f64>,

    /// The noise of a pixel of the image, as a fraction of the step of brightness at limbs and ends.
    #[arg(long, value_name = "PART", default_value_t = StepNoise::default().limbs[0], help_heading = "Noise")]
    pub step_noise: f64,

    /// That noise at the first and at the second limb.
    #[arg(long, value_name = "PART,PART", value_parser = parse_numbers::<2>, help_heading = "Noise")]
    pub limb_noise: Option<[f64; 2]>,

    /// That noise at the two ends, for a positive tilt first the nearer.
    #[arg(long, value_name = "PART,PART", value_parser = parse_numbers::<2>, help_heading = "Noise")]
    pub end_noise: Option<[f64; 2]>,

    /// Blur of lens and focus, a standard deviation in pixels.
    #[arg(long, value_name = "PX", default_value_t = StepNoise::default().blur, help_heading = "Noise")]
    pub blur: f64,

    /// Print a row for each of several values of one quantity: distance, radius, length, tilt, turn or step-noise, evenly
    /// spaced between two values; 11 rows by default.
    #[arg(long, value_name = "QUANTITY=FROM..TO[:ROWS]")]
    pub vary: Option<Vary>,

    /// Print also the range of the varied quantity in which the standard deviation of the radius is at most so many percent.
    #[arg(long, value_name = "PERCENT", requires = "vary", conflicts_with = "json", value_parser = parse_percent)]
    pub within: Option<f64>,

    /// Compare each row with so many simulated captures, fitted: their scatter and their bias.
    #[cfg(feature = "twin")]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(2..), conflicts_with_all = ["depth_noise", "limb_noise", "end_noise"])]
    pub simulate: Option<u64>,

    /// The seed of the first capture; the others have the numbers after it.
    #[cfg(feature = "twin")]
    #[arg(long, value_name = "N", default_value_t = 1, requires = "simulate")]
    pub seed: u64,

    /// Maximum number of threads for the captures, 0 for as many as the machine has. Results do not depend on it.
    #[cfg(feature = "twin")]
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,

    /// Print one JSON object per row instead of the table, in metres and radians.
    #[arg(long)]
    pub json: bool,
}

const EXAMPLES: &str =
    "Scatter is how much captures of one scene differ, total how far off a measurement may be, both as
standard deviations; the total includes errors that all points share, 0.2 % of the distance. A capture is far off when its
radius is off by more than five times the total.

How far away may a 20 mm pipe be for 0.5 %?
  cylfuse plan --radius 0.01 --length 0.3 --vary distance=0.4..3 --within 0.5";

/// The largest tilt in degrees: beyond it hardly anything of the lateral surface is seen.
const MOST_TILT: f64 = 80.0;

fn parse_tilt(text: &str) -> Result<f64, String> {
    let degrees = text.parse().map_err(|_| format!("{text:?} is no number"))?;
    in_tilts(degrees).map(|()| degrees)
}

fn in_tilts(degrees: f64) -> Result<(), String> {
    match degrees.abs() <= MOST_TILT {
        true => Ok(()),
        false => Err(format!("a tilt of {degrees} degrees; it must be from {} to {MOST_TILT}", -MOST_TILT)),
    }
}

fn parse_field_of_view(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(degrees) if degrees > 0.0 && degrees < 180.0 => Ok(degrees),
        _ => Err(format!("{text:?} is no angle greater than 0 and less than 180 degrees")),
    }
}

fn parse_percent(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(percent) if percent > 0.0 => Ok(percent),
        _ => Err(format!("{text:?} is no percentage greater than 0")),
    }
}

/// The laws that the library knows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Sensor {
    /// Projected dots, matched with themselves: baseline 75 mm
    StructuredLight,
    /// The phase of modulated light
    TimeOfFlight,
    /// Two cameras and projected dots: baseline 55 mm
    ActiveStereo,
}

/// Something that a plan has a number of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Quantity {
    Distance,
    Radius,
    Length,
    Tilt,
    Turn,
    StepNoise,
}

impl Quantity {
    /// Its name and its unit.
    pub fn title(self) -> (&'static str, &'static str) {
        match self {
            Quantity::Distance => ("distance", "m"),
            Quantity::Radius => ("radius", "m"),
            Quantity::Length => ("length", "m"),
            Quantity::Tilt => ("tilt", "deg"),
            Quantity::Turn => ("turn", "deg"),
            Quantity::StepNoise => ("step noise", ""),
        }
    }

    /// The plan with another value of it.
    pub fn set(self, plan: &Plan, value: f64) -> Plan {
        let mut plan = plan.clone();
        match self {
            Quantity::Distance => plan.distance = value,
            Quantity::Radius => plan.radius = value,
            Quantity::Length => plan.length = value,
            Quantity::Tilt => plan.tilt = value.to_radians(),
            Quantity::Turn => plan.turn = value.to_radians(),
            Quantity::StepNoise => plan.step = StepNoise::alike(value, plan.step.blur),
        }
        plan
    }
}

/// `QUANTITY=FROM..TO[:ROWS]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vary {
    pub quantity: Quantity,
    pub range: [f64; 2],
    pub rows: usize,
}

impl FromStr for Vary {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const ROWS: std::ops::RangeInclusive<usize> = 2..=1000;
        let (name, rest) = text.split_once('=').ok_or("write QUANTITY=FROM..TO, such as distance=0.5..3")?;
        let quantity = Quantity::from_str(name, true).map_err(|_| {
            format!("{name:?} cannot be varied; distance, radius, length, tilt, turn and step-noise can")
        })?;
        let (range, rows) = match rest.split_once(':') {
            Some((range, rows)) => {
                (range, rows.parse().map_err(|_| format!("{rows:?} is no number of rows"))?)
            }
            None => (rest, 11),
        };
        if !ROWS.contains(&rows) {
            return Err(format!("there are {rows} rows; there must be {} to {}", ROWS.start(), ROWS.end()));
        }
        let (from, to) = range.split_once("..").ok_or("write FROM..TO, such as 0.5..3")?;
        let number = |text: &str| match text.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(format!("{text:?} is no number")),
        };
        let range = [number(from)?, number(to)?];
        if quantity == Quantity::Tilt {
            range.into_iter().try_for_each(in_tilts)?;
        }
        Ok(Self { quantity, range, rows })
    }
}

impl Vary {
    /// The value of a row.
    pub fn value(&self, row: usize) -> f64 {
        let part = row as f64 / (self.rows - 1) as f64;
        self.range[0] * (1.0 - part) + self.range[1] * part
    }
}

impl PlanArguments {
    /// The plan of the library, before anything is varied.
    pub fn plan(&self) -> Result<Plan, Failure> {
        let camera = self.camera()?;
        let depth = match (self.depth_noise, self.sensor) {
            (Some([constant, linear, quadratic]), _) => {
                DepthNoise { constant, linear, quadratic, correlation: self.correlation.unwrap_or(1.0) }
            }
            (None, Sensor::StructuredLight) => DepthNoise::structured_light(&camera),
            (None, Sensor::TimeOfFlight) => DepthNoise::time_of_flight(&camera),
            (None, Sensor::ActiveStereo) => DepthNoise::active_stereo(&camera),
        };
        let alike = StepNoise::alike(self.step_noise, self.blur);
        let step = StepNoise {
            limbs: self.limb_noise.unwrap_or(alike.limbs),
            ends: self.end_noise.unwrap_or(alike.ends),
            ..alike
        };
        Ok(Plan {
            distance: self.distance,
            radius: self.radius,
            length: self.length,
            tilt: self.tilt.to_radians(),
            turn: self.turn.to_radians(),
            step,
            ..Plan::new(camera, depth)
        })
    }

    fn camera(&self) -> Result<Camera, Failure> {
        if let Some(path) = &self.frame {
            let views = Frame::read(path, false)?.views;
            let first = views.into_iter().next().map(|view| view.camera);
            return first.ok_or_else(|| Failure::bad_frame(path, "views: the list is empty"));
        }
        let (width, height) = (f64::from(self.width), f64::from(self.height));
        let focal_length = match (self.focal_length, self.field_of_view) {
            (Some(focal_length), _) => focal_length,
            (None, Some(degrees)) => 0.5 * width / (0.5 * degrees.to_radians()).tan(),
            (None, None) => 0.89 * width,
        };
        Ok(Camera::new(Intrinsics {
            width: self.width,
            height: self.height,
            fx: focal_length,
            fy: focal_length,
            cx: 0.5 * (width - 1.0),
            cy: 0.5 * (height - 1.0),
            distortion: Distortion::None,
        })?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_varied_is_read_and_mistakes_are_named() {
        let vary: Vary = "distance=0.5..3".parse().unwrap();
        assert_eq!(
            (vary.quantity, vary.rows, vary.value(0), vary.value(10)),
            (Quantity::Distance, 11, 0.5, 3.0)
        );
        let vary: Vary = "step-noise=0.01..0.1:4".parse().unwrap();
        assert_eq!((vary.quantity, vary.rows), (Quantity::StepNoise, 4));
        assert!((vary.value(1) - 0.04).abs() < 1e-12);
        for (text, expected) in [
            ("distance", "write QUANTITY=FROM..TO"),
            ("colour=1..2", "\"colour\" cannot be varied"),
            ("tilt=1", "write FROM..TO"),
            ("tilt=a..2", "\"a\" is no number"),
            ("tilt=0..91", "a tilt of 91 degrees; it must be from -80 to 80"),
            ("tilt=1..2:1", "there are 1 rows"),
            ("tilt=1..2:x", "\"x\" is no number of rows"),
        ] {
            let error = text.parse::<Vary>().unwrap_err();
            assert!(error.starts_with(expected), "{text}: {error}");
        }
    }
}
