//! The command line: what can be asked for, and the checks that need more than one option.

#![allow(clippy::doc_markdown, reason = "the comments on options are the help text, which is no Markdown")]

#[cfg(feature = "bench")]
use crate::bench::BenchArguments;
use crate::common_arguments::{CommonArguments, NOISE, parse_numbers};
use crate::detect_arguments::DetectArguments;
use crate::plan_arguments::PlanArguments;
#[cfg(feature = "twin")]
use crate::twin_arguments::TwinArguments;
use clap::{ArgGroup, Args, Parser, Subcommand, ValueEnum};
use cylfuse::error::Result;
use cylfuse::fitter::{
    ChartChoice, EdgeUse, ExtentRule, Method, NearWall, ObjectiveKind, Options, StartKind,
};
use cylfuse::geometry::{Cylinder, CylinderLimits};
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
#[command(after_help = format!("{FRAME_FORMAT}\n\n{NOISE}"))]
pub struct FitArguments {
    /// Frame files, or folders that are searched for frame.json.
    #[arg(value_name = "FRAME")]
    pub frames: Vec<PathBuf>,

    /// Fit point clouds without a camera instead: .ply, .pcd, or .xyz (x y z on each line; also .txt, .csv, .asc).
    #[arg(long, value_name = "CLOUD", num_args = 1..)]
    pub points: Vec<PathBuf>,

    /// Write result.json, overlay.png, completed.ply and completed.pcd to this folder, with several views also overlay-0.png,
    /// overlay-1.png and so on; with several frames to a subfolder for each.
    #[arg(long, value_name = "DIR", help_heading = "Output")]
    pub out: Option<PathBuf>,

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

    /// The radius, if it is known.
    #[arg(long, value_name = "R", conflicts_with_all = ["radius_min", "radius_max"])]
    #[arg(allow_hyphen_values = true, help_heading = "Limits")]
    pub radius: Option<f64>,

    /// Ignore the edge segments.
    #[arg(long, help_heading = "Estimation")]
    pub no_edges: bool,

    /// Use the edge segments as measurements: do not locate the limbs in the image, only the ends. The paper's objective
    /// always does so, and by default takes the extremes of the mask for the ends.
    #[arg(long, conflicts_with = "no_edges", help_heading = "Estimation")]
    pub edges_as_given: bool,

    /// How to find the ends of the visible cylinder in a mask.
    #[arg(long, value_enum, default_value_t = ExtentName::Auto, help_heading = "Estimation")]
    pub extent_rule: ExtentName,

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

    /// The number of points of a view whose noise is independent [default: 0, estimated from the data].
    #[arg(long, value_name = "N", allow_hyphen_values = true, help_heading = "Noise")]
    pub independent_points: Option<f64>,

    /// What `cylfuse detect` takes too.
    #[command(flatten)]
    pub common: CommonArguments,

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

Without a mask, all measured pixels are given to the fit, including the background. With the default
method, objective and start, a single view and no edges, the fit searches them for a cylinder, and takes
the likely one that has most of them; a warning tells where these are few. Otherwise, or where it finds
none, all are fitted. With an image, the outline of the fitted pixels then serves as the mask; without
one, the ends are those of the points on the cylinder. There is no completion. A mask is more accurate.
To find every cylinder of a frame use cylfuse detect.";

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
    /// Located for the method fused with the objective robust, extremes otherwise
    Auto,
    /// The paper's rule: the extreme positions along the axis of the points completed over the mask
    Extremes,
    /// From all lines along the surface together, in the mask and, when there is one, in the image
    Located,
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
        self.common.check()?;
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
            cylinder_limits: match self.radius {
                Some(radius) => {
                    CylinderLimits { radius_min: radius, radius_max: radius, ..self.common.limits() }
                }
                None => self.common.limits(),
            },
            edge_use: if self.edges_as_given { EdgeUse::AsGiven } else { EdgeUse::Refine },
            extent_rule: match self.extent_rule {
                ExtentName::Auto => ExtentRule::Auto,
                ExtentName::Extremes => ExtentRule::Extremes,
                ExtentName::Located => ExtentRule::Located,
            },
            noise: self.common.noise_model(),
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
