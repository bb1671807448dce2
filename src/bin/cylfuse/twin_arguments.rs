//! What can be asked of `cylfuse twin`.

#![allow(clippy::doc_markdown, reason = "the comments on options are the help text, which is no Markdown")]

use clap::{Args, ValueEnum};
use cylfuse::camera::{Camera, Distortion, Intrinsics};
use cylfuse::error::{Error, Result};
use cylfuse::twin::{
    ActiveStereo, CaptureOptions, DepthSensor, Kind, PictureOptions, StructuredLight, TimeOfFlight,
};
use std::path::PathBuf;

/// `cylfuse twin`.
#[derive(Debug, Args)]
#[command(after_help = LAYOUT)]
pub struct TwinArguments {
    /// What the frames show.
    #[arg(long, value_enum, default_value_t = KindName::Table)]
    pub kind: KindName,

    /// What measures their depth.
    #[arg(long, value_enum, default_value_t = SensorName::StructuredLight)]
    pub sensor: SensorName,

    /// The seed of the first frame; the others have the numbers after it. The same seed gives the same bits.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,

    /// How many frames.
    #[arg(long, value_name = "N", default_value_t = 1)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..))]
    pub count: u32,

    /// Where to put the frames, each in a folder of its own.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,

    /// Width of the image in pixels.
    #[arg(long, value_name = "N", default_value_t = 640, help_heading = "Camera")]
    #[arg(value_parser = clap::value_parser!(u32).range(SIZES))]
    pub width: u32,

    /// Height of the image in pixels.
    #[arg(long, value_name = "N", default_value_t = 480, help_heading = "Camera")]
    #[arg(value_parser = clap::value_parser!(u32).range(SIZES))]
    pub height: u32,

    /// Focal length of the image in pixels, 0.2 to 20 times the width [default: 0.89 times the width].
    #[arg(long, value_name = "PX", help_heading = "Camera")]
    pub focal_length: Option<f64>,

    /// Distortion of the image by Brown and Conrady: k1,k2,p1,p2 or k1,k2,p1,p2,k3 as in OpenCV.
    #[arg(
        long,
        value_name = "K",
        value_delimiter = ',',
        allow_hyphen_values = true,
        help_heading = "Camera"
    )]
    pub distortion: Vec<f64>,

    /// Standard deviation of the blur of lens and focus, in pixels, up to 20; 0 for none.
    #[arg(long, value_name = "PX", default_value_t = 0.7, help_heading = "Camera")]
    pub blur: f64,

    /// Electrons of a pixel at full scale, 10 to 1e7: the fewer, the noisier the image.
    #[arg(long, value_name = "N", default_value_t = 8000.0, help_heading = "Camera")]
    pub electrons: f64,

    /// The values of the image are its light to the power of 1/G; 2.2 for something like sRGB.
    #[arg(long, value_name = "G", default_value_t = 1.0, help_heading = "Camera")]
    pub gamma: f64,

    /// Write the image as a JPEG of this quality, 1 to 100, instead of a PNG.
    #[arg(long, value_name = "Q", value_parser = clap::value_parser!(u8).range(1..=100), help_heading = "Camera")]
    pub jpeg: Option<u8>,

    /// Do not register the depth to the image; write the pose of the depth camera instead.
    #[arg(long, help_heading = "Camera")]
    pub unregistered: bool,

    /// Maximum number of threads, 0 for as many as the machine has. Results do not depend on it.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
}

/// Columns and rows: fewer show no cylinder, more take gigabytes.
const SIZES: std::ops::RangeInclusive<i64> = 64..=4096;

/// Focal lengths in widths of the image: a field of view of 136° down to 2.9°.
const FOCAL_LENGTHS: [f64; 2] = [0.2, 20.0];

/// Blurs in pixels: no limb is seen beyond.
const BLURS: [f64; 2] = [0.0, 20.0];

/// Electrons of a pixel at full scale: with fewer the image is nothing but noise, with more 8 bits show none.
const ELECTRONS: [f64; 2] = [10.0, 1e7];

const LAYOUT: &str = "Files of a frame:
  frame.json   the input of `cylfuse fit` and `cylfuse detect`
  image.png    8 bit grey
  depth.png    16 bit, 0 = no measurement, times depth_scale metres
  labels.png   the object of each pixel of the image, 0 for table and walls
  body.png     255 on lateral surfaces of cylinders
  mask.png     of a single cylinder: its lateral surface as a person draws it
  truth.json   the true cylinders in metres, in the frame of the colour camera";

/// [`Kind`] by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum KindName {
    /// Cans, bars, tubes and other things on a table
    Table,
    /// Long pipes before a wall
    Pipes,
    /// Alike bodies that touch, in piles and rows
    Alike,
    /// Boxes, spheres, frustums and planes
    NoCylinders,
    /// One cylinder, with mask and edges
    Single,
}

/// [`DepthSensor`] by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SensorName {
    /// Projected dots, matched with themselves
    StructuredLight,
    /// The phase of modulated light
    TimeOfFlight,
    /// Two cameras and projected dots
    ActiveStereo,
    /// No noise at all
    Exact,
}

impl KindName {
    /// The library's kind.
    pub fn kind(self) -> Kind {
        match self {
            KindName::Table => Kind::Table,
            KindName::Pipes => Kind::Pipes,
            KindName::Alike => Kind::Alike,
            KindName::NoCylinders => Kind::NoCylinders,
            KindName::Single => Kind::Single,
        }
    }

    /// The beginning of the names of folders.
    pub fn name(self) -> &'static str {
        match self {
            KindName::Table => "table",
            KindName::Pipes => "pipes",
            KindName::Alike => "alike",
            KindName::NoCylinders => "no-cylinders",
            KindName::Single => "single",
        }
    }
}

impl SensorName {
    fn sensor(self) -> DepthSensor {
        match self {
            SensorName::StructuredLight => DepthSensor::StructuredLight(StructuredLight::default()),
            SensorName::TimeOfFlight => DepthSensor::TimeOfFlight(TimeOfFlight::default()),
            SensorName::ActiveStereo => DepthSensor::ActiveStereo(ActiveStereo::default()),
            SensorName::Exact => DepthSensor::Exact,
        }
    }
}

impl TwinArguments {
    /// The library's options.
    ///
    /// # Errors
    /// `InvalidIntrinsics` or `InvalidArgument` for a value out of range.
    pub fn options(&self) -> Result<CaptureOptions> {
        let focal_length = self.focal_length.unwrap_or(0.89 * f64::from(self.width));
        // Rounded as they are printed.
        let focal_lengths = FOCAL_LENGTHS.map(|part| (part * f64::from(self.width) * 10.0).round() / 10.0);
        for (name, value, [low, high]) in [
            ("--focal-length", focal_length, focal_lengths),
            ("--blur", self.blur, BLURS),
            ("--electrons", self.electrons, ELECTRONS),
        ] {
            if !(low..=high).contains(&value) {
                return Err(Error::InvalidArgument {
                    name: name.into(),
                    value: value.to_string(),
                    requirement: format!("be from {low} to {high}"),
                });
            }
        }
        let distortion = if self.distortion.is_empty() {
            Distortion::None
        } else {
            Distortion::brown_conrady(&self.distortion)?
        };
        let camera = Camera::new(Intrinsics {
            width: self.width,
            height: self.height,
            fx: focal_length,
            fy: focal_length,
            cx: 0.5 * (f64::from(self.width) - 1.0),
            cy: 0.5 * (f64::from(self.height) - 1.0),
            distortion,
        })?;
        let picture = PictureOptions {
            blur: self.blur,
            full_well: self.electrons,
            gamma: self.gamma,
            ..PictureOptions::default()
        };
        picture.check()?;
        Ok(CaptureOptions { camera, picture, sensor: self.sensor.sensor(), registered: !self.unregistered })
    }
}
