//! What a plan promises, tried out: captures of the twin of an RGB-D camera, each fitted as any other frame.

use super::{Deviations, Plan};
use crate::error::{Error, Result};
use crate::fitter::{Fitter, Options, larger_deviation};
use crate::geometry::{LimbFrame, RigidMotion, any_orthogonal};
use crate::observations::{DepthRange, DepthView, Frame, ImageView, MaskView};
use crate::twin::{
    Body, Capture, CaptureOptions, DEPTH_UNIT, DepthSensor, Material, PictureOptions, Scene, Shape, Style,
    TrueCylinder, capture, drawn_mask,
};
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// The number of the cylinder in the scene.
const OBJECT: u16 = 1;

/// The seed of the mask: who measures again does not draw it again.
const MASK: u64 = 1;

/// How far the wall is behind the farthest point of the cylinder, in metres.
const WALL: f64 = 0.1;

/// Albedos of the cylinder, and of wall and caps.
const DARK: f64 = 0.35;
const BRIGHT: f64 = 0.7;

/// The step of brightness at limbs and ends of that scene, and the brightness in its middle, as parts of full scale.
const STEP: f64 = 0.46;
const LEVEL: f64 = 0.5;

/// How far one capture was off. Pairs are along the line of sight and across it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trial {
    /// The radius in metres.
    pub radius: f64,
    /// The direction in radians.
    pub direction: [f64; 2],
    /// The position of the axis at the middle of the cylinder in metres.
    pub position: [f64; 2],
    /// The length in metres; `None` where an end was not found.
    pub length: Option<f64>,
}

/// What captures have in common, and how they differ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scatter {
    /// The number of captures.
    pub count: usize,
    /// Size of the mean error. The length is that of the captures that have one.
    pub bias: Deviations,
    /// Standard deviation of the captures about their mean, direction and position where it is greatest.
    pub deviation: Deviations,
}

impl Plan {
    /// The cylinder alone before a wall, with light from everywhere and from a lamp beside the camera.
    ///
    /// # Errors
    /// Those of [`Plan::check`].
    pub fn scene(&self) -> Result<Scene> {
        self.check()?;
        let (cylinder, center) = (self.cylinder()?, self.center());
        let along = cylinder.axis.direction;
        let (u, v) = any_orthogonal(&along);
        let shape = Shape::Turned { radii: [self.radius; 2], length: self.length, bore: None };
        let material = Material { albedo: DARK, cap_albedo: BRIGHT, ..Material::default() };
        let pose = RigidMotion::new(Matrix3::from_columns(&[u, v, along]), center)?;
        let body = Body { object: OBJECT, shape, pose, material, measured: true };
        let behind = 0.5 * self.length * along.z.abs() + self.radius + WALL;
        let pose = RigidMotion::new(Matrix3::identity(), center + Vector3::z() * behind)?;
        let material = Material { albedo: BRIGHT, ..Material::default() };
        let wall = Body { object: 0, shape: Shape::Plane, pose, material, measured: false };
        let truth =
            TrueCylinder { object: OBJECT, style: Style::Plain, center, cylinder, length: self.length };
        Ok(Scene {
            bodies: vec![body, wall],
            cylinders: vec![truth],
            ignored: Vec::new(),
            lamp: Vector3::new(0.3, -0.4, -0.1),
            ambient: 0.7,
        })
    }

    /// Takes a capture of that scene, with the depth of a sensor of the twin in place of the law of the plan, and fits it. The
    /// same seed gives the same bits; all seeds have the same mask.
    ///
    /// # Errors
    /// Those of [`Plan::check`] and of a fit; `InvalidArgument` where limbs and ends differ in their noise, as those of that
    /// scene do not.
    pub fn trial(&self, sensor: &DepthSensor, seed: u64) -> Result<Trial> {
        let noise = self.step.common().ok_or_else(|| {
            let requirement = "be the same at all limbs and ends of simulated captures";
            Error::argument(
                "noise of a step",
                format!("{:?} and {:?}", self.step.limbs, self.step.ends),
                requirement,
            )
        })?;
        let picture = PictureOptions {
            blur: self.step.blur,
            // Light of n electrons has the noise √n.
            full_well: LEVEL / (noise * STEP).powi(2),
            read_noise: 0.0,
            ..PictureOptions::default()
        };
        let options =
            CaptureOptions { camera: self.camera.clone(), picture, sensor: *sensor, registered: true };
        self.measure(&capture(&self.scene()?, &options, seed)?)
    }

    fn measure(&self, taken: &Capture) -> Result<Trial> {
        let size = self.camera.size();
        let mut frame = Frame::new(self.camera.clone());
        frame.set_depth(&DepthView::from_u16(&taken.depth, size, DEPTH_UNIT)?, &DepthRange::default())?;
        frame.set_image(&ImageView::from_u8(&taken.image, size)?)?;
        let mask = drawn_mask(&taken.body, size, MASK);
        let mut fitter = Fitter::new();
        fitter.set_options(Options { threads: 1, ..Options::default() })?;
        fitter.use_frame(&frame, Some(&MaskView::from_u8(&mask, size)?))?;
        let found = fitter.fit()?.cylinder;
        let truth = self.cylinder()?;
        let undetermined = || Error::Numerical { what: "the view does not determine the cylinder" };
        let limbs = LimbFrame::new(&truth).ok_or_else(undetermined)?;
        let cosine = found.axis.direction.dot(&truth.axis.direction);
        let direction = found.axis.direction * cosine.signum();
        let along = (self.center() - found.axis.point).dot(&truth.axis.direction) / cosine;
        let position = found.axis.at(along) - self.center();
        let both = |vector: Vector3<f64>| [vector.dot(&limbs.toward), vector.dot(&limbs.sideways)];
        let length = fitter.extent(None, None).ok().map(|extent| extent.length - self.length);
        Ok(Trial {
            radius: found.radius - self.radius,
            direction: both(direction),
            position: both(position),
            length,
        })
    }
}

impl Scatter {
    /// Of two trials or more.
    ///
    /// # Errors
    /// `InvalidArgument` for fewer.
    pub fn new(trials: &[Trial]) -> Result<Self> {
        let count = trials.len();
        if count < 2 {
            return Err(Error::argument("number of captures", count, "be at least 2"));
        }
        let pairs = |value: fn(&Trial) -> [f64; 2]| {
            let values: Vec<Vector2<f64>> = trials.iter().map(|trial| Vector2::from(value(trial))).collect();
            of_pairs(&values)
        };
        let radius =
            of_pairs(&trials.iter().map(|trial| Vector2::new(trial.radius, 0.0)).collect::<Vec<_>>());
        let lengths: Vec<_> =
            trials.iter().filter_map(|trial| Some(Vector2::new(trial.length?, 0.0))).collect();
        let length = (lengths.len() > 1).then(|| of_pairs(&lengths));
        let [direction, position] = [pairs(|trial| trial.direction), pairs(|trial| trial.position)];
        let deviations = |part: fn((f64, f64)) -> f64| Deviations {
            radius: part(radius),
            direction: part(direction),
            position: part(position),
            length: length.map(part),
        };
        Ok(Self { count, bias: deviations(|(bias, _)| bias), deviation: deviations(|(_, scatter)| scatter) })
    }
}

/// Size of the mean, and the standard deviation about it where that is greatest.
fn of_pairs(values: &[Vector2<f64>]) -> (f64, f64) {
    let mean = values.iter().sum::<Vector2<f64>>() / values.len() as f64;
    let square: Matrix2<f64> = values.iter().map(|value| (value - mean) * (value - mean).transpose()).sum();
    let covariance = square / (values.len() - 1) as f64;
    (mean.norm(), larger_deviation(&covariance))
}
