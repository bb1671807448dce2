//! What can be asked of `cylfuse fit` and of `cylfuse detect`.

#![allow(clippy::doc_markdown, reason = "the comments on options are the help text, which is no Markdown")]

use crate::page::{Quantity, Tolerance};
use clap::builder::PossibleValue;
use clap::{Args, ValueEnum};
use cylfuse::geometry::{AxisCone, CylinderLimits};
use cylfuse::noise::NoiseModel;
use std::path::PathBuf;

/// The options that both have.
#[derive(Debug, Args)]
pub struct CommonArguments {
    /// Print one JSON object per frame, each on a line, in the order of the input, instead of tables.
    #[arg(long, help_heading = "Output")]
    pub json: bool,

    /// Write a report on all of them as one HTML page: a table with pictures, a histogram, points and cylinders in 3D. It
    /// needs no other file and no network.
    #[arg(long, value_name = "FILE.html", help_heading = "Output")]
    pub report: Option<PathBuf>,

    /// State in the report whether the radius or the length is within these limits, in the unit of the data: pass, fail, or
    /// undecided because of the uncertainty or of a warning.
    #[arg(long, value_name = "QUANTITY=LOW..HIGH", requires = "report", help_heading = "Output")]
    pub tolerance: Vec<Tolerance>,

    /// Ignore the image file and do not open it.
    #[arg(long, help_heading = "Estimation")]
    pub no_image: bool,

    /// The smallest radius that a cylinder may have, in the unit of the data.
    #[arg(long, value_name = "R", allow_hyphen_values = true, help_heading = "Limits")]
    pub radius_min: Option<f64>,

    /// The largest radius that a cylinder may have.
    #[arg(long, value_name = "R", allow_hyphen_values = true, help_heading = "Limits")]
    pub radius_max: Option<f64>,

    /// The direction of the axis in the frame of the result, of any length and sign.
    #[arg(long, value_name = "x,y,z", value_parser = parse_numbers::<3>)]
    #[arg(allow_hyphen_values = true, help_heading = "Limits")]
    pub axis: Option<[f64; 3]>,

    /// How far an axis may be from --axis, in degrees from 0 to 90 [default: 0, the direction is known].
    #[arg(long, value_name = "DEG", requires = "axis")]
    #[arg(allow_hyphen_values = true, help_heading = "Limits")]
    pub axis_max_angle: Option<f64>,

    /// A standard deviation that you know better than the default, see below; may be given several times.
    #[arg(long, value_name = "NAME=VALUE", value_parser = parse_noise, help_heading = "Noise")]
    pub noise: Vec<(NoiseName, f64)>,
}

/// What follows the list of options.
pub const NOISE: &str = "\
Noise, --noise NAME=VALUE, as standard deviations; a default of 0 means that it is estimated from
the data:
  edge-endpoint      a hand-set endpoint of an edge across its limb [0.5 drawn pixels]
  mask-side          a side of a mask as a whole across its limb [1.6 drawn pixels]
  mask-unevenness    the part of it that differs from one end of a side to the other [1 drawn pixel]
  mask-growth        the largest uniform growth of a mask, a bound [3 drawn pixels]
  mask-boundary      the boundary of a mask at one position [0.8 drawn pixels]
  mask-correlation   the correlation length of that along the boundary [10 drawn pixels]
  limb-of-points     a limb as predicted by a fit to the points alone [2 drawn pixels]
  drawn-pixel        a pixel in which edges and masks were drawn, in pixels of the image [0: by
                     the size of the image]
  depth              a measured point across the surface, in metres [0]
  depth-shared       what all points of a view share: too near or too far, or bent; a part of their
                     distance, 0 for none [0.002]
  image              the values of the image, proportional to light [0]
  blur               the blur of the image, in pixels [0]";

/// The deviations of [`NoiseModel`] by their names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
#[allow(missing_docs, reason = "the fields of the model say it")]
pub enum NoiseName {
    EdgeEndpoint,
    MaskSide,
    MaskUnevenness,
    MaskGrowth,
    MaskBoundary,
    MaskCorrelation,
    LimbOfPoints,
    DrawnPixel,
    Depth,
    DepthShared,
    Image,
    Blur,
}

impl CommonArguments {
    /// What the library would say in other units, and what it does not know of.
    pub fn check(&self) -> Result<(), String> {
        // A name that ends otherwise may be that of a frame or of one of its files.
        let is_page = |path: &&PathBuf| {
            path.extension()
                .is_some_and(|end| end.eq_ignore_ascii_case("html") || end.eq_ignore_ascii_case("htm"))
        };
        if let Some(path) = self.report.as_ref().filter(|path| !is_page(path)) {
            return Err(format!(
                "--report is '{}'; a report is a web page, its name must end in .html",
                path.display()
            ));
        }
        for quantity in [Quantity::Radius, Quantity::Length] {
            let limits = self.tolerance.iter().filter(|tolerance| tolerance.limits(quantity)).count();
            if limits > 1 {
                let name = quantity.name();
                return Err(format!("--tolerance limits the {name} {limits} times; give one range for it"));
            }
        }
        match self.axis_max_angle.filter(|degrees| !(0.0..=90.0).contains(degrees)) {
            Some(degrees) => Err(format!("--axis-max-angle is {degrees}; it must lie in [0, 90] degrees")),
            None => Ok(()),
        }
    }

    /// The limits of radius and axis.
    pub fn limits(&self) -> CylinderLimits {
        let none = CylinderLimits::default();
        let degrees = self.axis_max_angle.unwrap_or(0.0);
        // 90 degrees in radians, rounded, may be more than a right angle.
        let max_angle = degrees.to_radians().min(std::f64::consts::FRAC_PI_2);
        CylinderLimits {
            radius_min: self.radius_min.unwrap_or(none.radius_min),
            radius_max: self.radius_max.unwrap_or(none.radius_max),
            axis: self.axis.map(|axis| AxisCone { direction: axis.into(), max_angle }),
        }
    }

    /// What is known of the errors of the data.
    pub fn noise_model(&self) -> NoiseModel {
        let mut model = NoiseModel::default();
        for &(name, value) in &self.noise {
            *match name {
                NoiseName::EdgeEndpoint => &mut model.edge_endpoint,
                NoiseName::MaskSide => &mut model.mask_side,
                NoiseName::MaskUnevenness => &mut model.mask_unevenness,
                NoiseName::MaskGrowth => &mut model.mask_growth,
                NoiseName::MaskBoundary => &mut model.mask_boundary,
                NoiseName::MaskCorrelation => &mut model.mask_correlation,
                NoiseName::LimbOfPoints => &mut model.limb_of_points,
                NoiseName::DrawnPixel => &mut model.drawn_pixel,
                NoiseName::Depth => &mut model.depth,
                NoiseName::DepthShared => &mut model.depth_shared,
                NoiseName::Image => &mut model.image,
                NoiseName::Blur => &mut model.blur,
            } = value;
        }
        model
    }
}

fn parse_noise(text: &str) -> Result<(NoiseName, f64), String> {
    let (name, value) = text.split_once('=').ok_or("give NAME=VALUE, such as edge-endpoint=0.3")?;
    let known = NoiseName::from_str(name, false).map_err(|_| {
        let names: Vec<_> =
            NoiseName::value_variants().iter().filter_map(ValueEnum::to_possible_value).collect();
        let names: Vec<&str> = names.iter().map(PossibleValue::get_name).collect();
        format!("'{name}' is none of {}", names.join(", "))
    })?;
    let value = value.parse().map_err(|_| format!("'{value}' is not a number"))?;
    Ok((known, value))
}

/// Numbers between commas.
pub fn parse_numbers<const COUNT: usize>(text: &str) -> Result<[f64; COUNT], String> {
    let numbers: Vec<f64> = text
        .split(',')
        .map(|word| word.trim().parse().map_err(|_| format!("'{word}' is not a number")))
        .collect::<Result<_, _>>()?;
    let count = numbers.len();
    numbers.try_into().map_err(|_| format!("{count} numbers were given, but {COUNT} are needed"))
}
