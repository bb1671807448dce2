//! The command line: what can be asked for, and the checks that need more than one option.

#![allow(clippy::doc_markdown, reason = "the comments on options are the help text, which is no Markdown")]

#[cfg(feature = "bench")]
use crate::bench::BenchArguments;
use crate::detect_arguments::DetectArguments;
use crate::page::Tolerance;
use crate::plan_arguments::PlanArguments;
#[cfg(feature = "twin")]
use crate::twin_arguments::TwinArguments;
use clap::builder::PossibleValue;
use clap::{ArgGroup, Args, Parser, Subcommand, ValueEnum};
use cylfuse::error::Result;
use cylfuse::fitter::{
    ChartChoice, EdgeUse, ExtentRule, Method, NearWall, ObjectiveKind, Options, StartKind,
};
use cylfuse::geometry::{AxisCone, Cylinder, CylinderLimits};
use cylfuse::noise::NoiseModel;
use nalgebra::Vector3;
use std::path::PathBuf;

/// Measures cylinders from RGB-D views by fusing depth with the limb lines in the image.
#[derive(Debug, Parser)]
#[command(name = "cylfuse", version, max_term_width = 100, after_help = EXAMPLES)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const EXAMPLES: &str = "Examples:
  cylfuse demo                              fit the built-in frame, write pictures and files
  cylfuse fit frame.json                    fit one frame, print a table
  cylfuse fit --json frames/ > results.txt  fit all frames of a folder, one JSON object per line
  cylfuse fit --out results frames/         fit all, write pictures and completed points
  cylfuse fit --points part.ply             fit a point cloud without a camera
  cylfuse detect --out results frames/      find all cylinders of whole scenes
  cylfuse plan --vary distance=0.5..3       predict how well a camera will measure

Exit status: 0 all fitted, 1 a frame failed, 2 the command line is wrong.";

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Fit a cylinder to each frame or point cloud.
    Fit(Box<FitArguments>),
    /// Find all cylinders of whole frames or point clouds, without masks or edges, and fit each.
    Detect(Box<DetectArguments>),
    /// Fit a built-in frame and scene, and write pictures and files to a folder.
    Demo(DemoArguments),
    /// Predict how well a camera will measure a cylinder.
    Plan(Box<PlanArguments>),
    /// Make frames of random scenes with a simulated RGB-D camera, with their true cylinders.
    #[cfg(feature = "twin")]
    Twin(TwinArguments),
    /// Run the experiments of the paper, and others, on frames of the twin, and write a report.
    #[cfg(feature = "bench")]
    Bench(BenchArguments),
}

/// `cylfuse fit`.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("input").required(true).args(["frames", "points"]))]
#[command(after_help = FRAME_FORMAT)]
pub struct FitArguments {
    /// Frame files, or folders that are searched for frame.json.
    #[arg(value_name = "FRAME")]
    pub frames: Vec<PathBuf>,

    /// Fit point clouds without a camera instead: .ply, .pcd, or .xyz (x y z on each line; also .txt, .csv, .asc).
    #[arg(long, value_name = "CLOUD", num_args = 1..)]
    pub points: Vec<PathBuf>,

    /// Print one JSON object per frame, each on a line, in the order of the input, instead of the table.
    #[arg(long, help_heading = "Output")]
    pub json: bool,

    /// Write result.json, overlay.png, completed.ply and completed.pcd to this folder, with several views also overlay-0.png,
    /// overlay-1.png and so on; with several frames to a subfolder for each.
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

    /// How to estimate the cylinder.
    #[arg(long, value_enum, default_value_t = MethodName::Fused, help_heading = "Estimation")]
    pub method: MethodName,

    /// What the fused method minimises [default: robust].
    #[arg(long, value_enum, help_heading = "Estimation")]
    pub objective: Option<ObjectiveName>,

    /// The paper's w_L, from 0 (points alone) to 1 (edges alone); needs --objective paper [default: 0.6].
    #[arg(long, value_name = "W", allow_hyphen_values = true, help_heading = "Estimation")]
    pub edge_weight: Option<f64>,

    /// Start from this cylinder: axis point, axis direction (any length) and radius, in the unit of the data.
    #[arg(long, value_name = "px,py,pz,dx,dy,dz,r", value_parser = parse_numbers::<7>)]
    #[arg(allow_hyphen_values = true, help_heading = "Estimation")]
    pub start: Option<[f64; 7]>,

    /// How to find a start [default: auto, or model with --start]. The methods ransac and eberly need none.
    #[arg(long, value_enum, help_heading = "Estimation")]
    pub start_from: Option<StartName>,

    /// The smallest radius that the cylinder may have, in the unit of the data.
    #[arg(long, value_name = "R", allow_hyphen_values = true, help_heading = "Limits")]
    pub radius_min: Option<f64>,

    /// The largest radius that the cylinder may have.
    #[arg(long, value_name = "R", allow_hyphen_values = true, help_heading = "Limits")]
    pub radius_max: Option<f64>,

    /// The radius, if it is known.
    #[arg(long, value_name = "R", conflicts_with_all = ["radius_min", "radius_max"])]
    #[arg(allow_hyphen_values = true, help_heading = "Limits")]
    pub radius: Option<f64>,

    /// The direction of the axis in the frame of the result, of any length and sign.
    #[arg(long, value_name = "x,y,z", value_parser = parse_numbers::<3>)]
    #[arg(allow_hyphen_values = true, help_heading = "Limits")]
    pub axis: Option<[f64; 3]>,

    /// How far the axis may be from --axis, in degrees from 0 to 90 [default: 0, the direction is known].
    #[arg(long, value_name = "DEG", requires = "axis")]
    #[arg(allow_hyphen_values = true, help_heading = "Limits")]
    pub axis_max_angle: Option<f64>,

    /// Ignore the edge segments.
    #[arg(long, help_heading = "Estimation")]
    pub no_edges: bool,

    /// Use the edge segments as measurements: do not locate the limbs in the image, only the ends. The paper's objective
    /// always does so, and locates no ends either.
    #[arg(long, conflicts_with = "no_edges", help_heading = "Estimation")]
    pub edges_as_given: bool,

    /// How to find the ends of the visible cylinder.
    #[arg(long, value_enum, default_value_t = ExtentName::Auto, help_heading = "Estimation")]
    pub extent_rule: ExtentName,

    /// Ignore the image file and do not open it; mask and edge segments stay.
    #[arg(long, help_heading = "Estimation")]
    pub no_image: bool,

    /// Accept a cylinder whose points lie on the wall that the camera cannot see.
    #[arg(long, help_heading = "Estimation")]
    pub no_near_wall: bool,

    /// The coordinates in which the iteration takes its steps; all reach the same minimum.
    #[arg(long, value_enum, default_value_t = ChartName::Auto, help_heading = "Estimation")]
    pub chart: ChartName,

    /// Maximum number of iterations [default: 400].
    #[arg(long, value_name = "N", help_heading = "Estimation")]
    pub max_iterations: Option<usize>,

    /// Seed of the random samples of RANSAC.
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = "Estimation")]
    pub seed: u64,

    /// A standard deviation that you know better than the default, see below; may be given several times.
    #[arg(long, value_name = "NAME=VALUE", value_parser = parse_noise, help_heading = "Noise")]
    pub noise: Vec<(NoiseName, f64)>,

    /// The number of points of a view whose noise is independent [default: 0, estimated from the data].
    #[arg(long, value_name = "N", allow_hyphen_values = true, help_heading = "Noise")]
    pub independent_points: Option<f64>,

    /// Maximum number of threads, 0 for as many as the machine has. They fit several frames at once, or share the sums over
    /// the points of a single one. Results do not depend on it [default: 0 for several frames, 1 for a single one].
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
}

const FRAME_FORMAT: &str = "Frame files are JSON, with paths relative to the file:
  { \"camera\": { \"width\": 640, \"height\": 480, \"fx\": 570, \"fy\": 570, \"cx\": 319.5, \"cy\": 239.5,
                \"distortion\": [k1, k2, p1, p2, k3] },
    \"image\": \"image.png\", \"depth\": \"depth.png\", \"depth_scale\": 0.001, \"mask\": \"mask.png\",
    \"edges\": [[[x, y], [x, y]], [[x, y], [x, y]]] }
  camera.model       brown_conrady (default) or kannala_brandt
  camera.distortion  optional; 0, 4, 5 or 8 numbers in the order of OpenCV; 0 or 4 for
                     kannala_brandt
  depth              16-bit grey PNG, z along the optical axis, 0 = not measured
  depth_scale        metres per unit of depth
  image_gamma        optional; light is the value to this power: 1 (default) for values
                     proportional to light, 2.2 for sRGB, as cameras and image files usually have
  image, mask, edges optional; mask, edges and, without a depth_camera, depth are on the pixels
                     of the (distorted) image
  depth_camera       optional; the camera of the depth image if it is not registered: the fields
                     of camera, and rotation (9 numbers, row by row) and translation with
                     x_image = R x_depth + t
  pose               optional; rotation and translation with x_result = R x_image + t
  views              several views of the cylinder, { \"views\": [{ ... }, { ... }] }: a list of
                     objects like the one above, in place of it, each with its pose

Without a mask all measured pixels are fitted, including the background, and there is no extent.

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
  image              the values of the image, proportional to light [0]
  blur               the blur of the image, in pixels [0]";

/// `cylfuse demo`.
#[derive(Debug, Args)]
pub struct DemoArguments {
    /// Where to put the files.
    #[arg(long, value_name = "DIR", default_value = "cylfuse-demo")]
    pub out: PathBuf,
}

/// [`Method`] by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum MethodName {
    /// Points and edges together
    Fused,
    /// Points alone by least squares
    Points,
    /// RANSAC with local optimisation
    Ransac,
    /// Eberly's algebraic fit by moments
    Eberly,
}

/// [`ObjectiveKind`] by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ObjectiveName {
    /// The paper's F = (1 - w_L) E_P + w_L E_L: every point of the mask at the same weight, two edges
    Paper,
    /// Robust points, and edges by their distance in pixels, each weighted by its own standard deviation
    Robust,
}

/// [`StartKind`] by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum StartName {
    /// The one of the following that explains the data best
    Auto,
    /// From two edge segments, scaled by the points
    Limbs,
    /// Eberly's algebraic fit
    Moments,
    /// RANSAC
    Ransac,
    /// The cylinder of --start
    Model,
}

/// [`ChartChoice`] by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ChartName {
    /// That of the paper for the paper's objective, the local one otherwise
    Auto,
    /// Shift and tilt at the data, regular everywhere
    Local,
    /// The paper's {U, W}, singular for an axis through the origin
    Orthonormal,
}

/// [`ExtentRule`] by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ExtentName {
    /// Located for the robust objective, extremes otherwise
    Auto,
    /// The paper's rule: the extreme completed points of the mask
    Extremes,
    /// Located along the whole end, in the mask and the image
    Located,
}

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
    Image,
    Blur,
}

impl FitArguments {
    /// Combinations that make no sense, in words; clap has checked each option by itself.
    pub fn check(&self) -> std::result::Result<(), String> {
        if self.method != MethodName::Fused {
            let method = self.method.to_possible_value().map_or(String::new(), |v| v.get_name().to_string());
            for (given, name) in [
                (self.objective.is_some(), "--objective"),
                (self.edge_weight.is_some(), "--edge-weight"),
                (self.edges_as_given, "--edges-as-given"),
            ] {
                if given {
                    return Err(format!("{name} belongs to --method fused, not to --method {method}"));
                }
            }
        }
        if self.edge_weight.is_some() && self.objective != Some(ObjectiveName::Paper) {
            return Err("--edge-weight belongs to --objective paper; give that too, or leave the weight \
                        out: the robust objective takes its weights from the data"
                .into());
        }
        // The library knows these in radians, and as two limits.
        if let Some(degrees) = self.axis_max_angle.filter(|degrees| !(0.0..=90.0).contains(degrees)) {
            return Err(format!("--axis-max-angle is {degrees}; it must lie in [0, 90] degrees"));
        }
        if let Some(radius) = self.radius.filter(|radius| !(*radius > 0.0 && radius.is_finite())) {
            return Err(format!("--radius is {radius}; it must be finite and greater than 0"));
        }
        match (self.start, self.start_from) {
            (Some(_), Some(kind)) if kind != StartName::Model => {
                Err("--start gives the cylinder to start from; leave --start-from out or set it to model"
                    .into())
            }
            (None, Some(StartName::Model)) => {
                Err("--start-from model needs the cylinder; give it by --start=px,py,pz,dx,dy,dz,r".into())
            }
            _ => Ok(()),
        }
    }

    /// The library's options.
    ///
    /// # Errors
    /// `InvalidArgument` for a value out of range.
    pub fn options(&self) -> Result<Options> {
        let defaults = Options::default();
        let mut options = Options {
            method: match self.method {
                MethodName::Fused => Method::Fused,
                MethodName::Points => Method::Points,
                MethodName::Ransac => Method::Ransac,
                MethodName::Eberly => Method::Eberly,
            },
            objective: match self.objective {
                Some(ObjectiveName::Paper) => ObjectiveKind::Paper,
                Some(ObjectiveName::Robust) => ObjectiveKind::Robust,
                None => defaults.objective,
            },
            edge_weight: self.edge_weight.unwrap_or(defaults.edge_weight),
            start: match self.start_from {
                Some(StartName::Auto) => StartKind::Auto,
                Some(StartName::Limbs) => StartKind::Limbs,
                Some(StartName::Moments) => StartKind::Moments,
                Some(StartName::Ransac) => StartKind::Ransac,
                Some(StartName::Model) => StartKind::Model,
                None if self.start.is_some() => StartKind::Model,
                None => StartKind::Auto,
            },
            near_wall: if self.no_near_wall { NearWall::Off } else { NearWall::Auto },
            threads: self.threads.unwrap_or(defaults.threads),
            seed: self.seed,
            cylinder_limits: self.limits(),
            edge_use: if self.edges_as_given { EdgeUse::AsGiven } else { EdgeUse::Refine },
            extent_rule: match self.extent_rule {
                ExtentName::Auto => ExtentRule::Auto,
                ExtentName::Extremes => ExtentRule::Extremes,
                ExtentName::Located => ExtentRule::Located,
            },
            noise: self.noise_model(),
            independent_points: self.independent_points.unwrap_or(defaults.independent_points),
            ..defaults
        };
        options.chart = match self.chart {
            ChartName::Auto => ChartChoice::Auto,
            ChartName::Local => ChartChoice::Local,
            ChartName::Orthonormal => ChartChoice::Orthonormal,
        };
        if let Some(most) = self.max_iterations {
            options.limits.max_iterations = most;
        }
        options.check()?;
        Ok(options)
    }

    fn noise_model(&self) -> NoiseModel {
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
                NoiseName::Image => &mut model.image,
                NoiseName::Blur => &mut model.blur,
            } = value;
        }
        model
    }

    fn limits(&self) -> CylinderLimits {
        let none = CylinderLimits::default();
        let degrees = self.axis_max_angle.unwrap_or(0.0);
        // 90 degrees in radians, rounded, may be more than a right angle.
        let max_angle = degrees.to_radians().min(std::f64::consts::FRAC_PI_2);
        CylinderLimits {
            radius_min: self.radius.or(self.radius_min).unwrap_or(none.radius_min),
            radius_max: self.radius.or(self.radius_max).unwrap_or(none.radius_max),
            axis: self.axis.map(|axis| AxisCone { direction: axis.into(), max_angle }),
        }
    }

    /// The cylinder of `--start`.
    ///
    /// # Errors
    /// `InvalidArgument` for numbers that are no cylinder.
    pub fn start_model(&self) -> Result<Option<Cylinder>> {
        let cylinder = |[px, py, pz, dx, dy, dz, r]: [f64; 7]| {
            Cylinder::new(Vector3::new(px, py, pz), Vector3::new(dx, dy, dz), r)
        };
        self.start.map(cylinder).transpose()
    }
}

fn parse_noise(text: &str) -> std::result::Result<(NoiseName, f64), String> {
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
pub fn parse_numbers<const COUNT: usize>(text: &str) -> std::result::Result<[f64; COUNT], String> {
    let numbers: Vec<f64> = text
        .split(',')
        .map(|word| word.trim().parse().map_err(|_| format!("'{word}' is not a number")))
        .collect::<std::result::Result<_, _>>()?;
    let count = numbers.len();
    numbers.try_into().map_err(|_| format!("{count} numbers were given, but {COUNT} are needed"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    fn fit(arguments: &[&str]) -> FitArguments {
        let all = ["cylfuse", "fit", "frame.json"].iter().chain(arguments);
        let Command::Fit(fit) = Arguments::try_parse_from(all).unwrap().command else { panic!("not fit") };
        *fit
    }

    #[test]
    fn the_definition_is_consistent() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn a_start_may_have_negative_numbers_and_exponents() {
        for arguments in
            [&["--start=-1e-3,2,-.5,0,-1,0,4E-2"][..], &["--start", "-1e-3, 2, -.5, 0, -1, 0, 4E-2"]]
        {
            let given = fit(arguments);
            assert_eq!(given.start, Some([-1e-3, 2.0, -0.5, 0.0, -1.0, 0.0, 0.04]));
            assert_eq!(given.options().unwrap().start, StartKind::Model);
            assert_eq!(given.start_model().unwrap().unwrap().radius, 0.04);
        }
        assert!(parse_numbers::<7>("1,2,3").unwrap_err().contains("3 numbers"));
        assert!(parse_numbers::<7>("1,2,x,4,5,6,7").unwrap_err().contains("'x'"));
    }

    #[test]
    fn the_defaults_are_those_of_the_library() {
        assert_eq!(fit(&[]).options().unwrap(), Options::default());
    }
}
