//! The scenes of the paper, and variations of them that isolate one quantity.

use cylfuse::camera::{Camera, Distortion, Intrinsics};
use cylfuse::error::Result;
use cylfuse::geometry::{Cylinder, RigidMotion};
use cylfuse::twin::{
    Body, CaptureOptions, DepthSensor, Material, PictureOptions, Purpose, Scene, Shape, Stream,
    StructuredLight, Style, Texture, TrueCylinder,
};
use nalgebra::{Matrix3, Vector3};

/// The distance of the paper, in metres.
pub const DISTANCE: f64 = 0.7;

/// The length of the paper's cylinders.
pub const LENGTH: f64 = 0.1;

/// How far in front of a cylinder things stand that hide a part of it.
const BEFORE: f64 = 0.03;

/// What stands in front of a cylinder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hidden {
    /// Nothing.
    Nothing,
    /// One side of it: this share of its width is seen, with the other limb.
    Side(f64),
    /// A bar across its middle that hides this share of its length.
    Middle(f64),
}

/// A cylinder on a board, as in the paper's section 5.1.
#[derive(Debug, Clone, Copy)]
pub struct OnBoard {
    /// Radius in metres.
    pub radius: f64,
    /// By how much the axis is turned out of the image plane, in degrees.
    pub tilt: f64,
    /// From the camera to the centre, in metres.
    pub distance: f64,
    /// What is in front of it.
    pub hidden: Hidden,
    /// How far aside the lamp is, as an angle at the cylinder across its axis, in degrees; drawn where it is `None`.
    pub light: Option<f64>,
}

/// The colour camera of all experiments.
pub fn camera() -> Result<Camera> {
    Camera::new(Intrinsics {
        width: 640,
        height: 480,
        fx: 570.0,
        fy: 570.0,
        cx: 319.5,
        cy: 239.5,
        distortion: Distortion::None,
    })
}

/// A frame of a sensor, its depth carried to the grid of the image.
pub fn capture_options(sensor: DepthSensor) -> Result<CaptureOptions> {
    Ok(CaptureOptions { camera: camera()?, picture: PictureOptions::default(), sensor, registered: true })
}

/// The paper's kind of sensor.
pub fn structured_light() -> DepthSensor {
    DepthSensor::StructuredLight(StructuredLight::default())
}

impl OnBoard {
    /// A configuration of the paper: radius in millimetres, tilt in degrees.
    pub fn configuration((radius, tilt): (u32, u32)) -> Self {
        Self {
            radius: 1e-3 * f64::from(radius),
            tilt: f64::from(tilt),
            distance: DISTANCE,
            hidden: Hidden::Nothing,
            light: None,
        }
    }

    /// The scene. The seed draws what the paper does not say: light, paint, and placement to 5 mm and 3 degrees.
    pub fn scene(&self, seed: u64) -> Result<Scene> {
        let mut stream = Stream::new(seed, Purpose::Layout);
        let (sine, cosine) = libm::sincos(self.tilt.to_radians());
        let (aslant, upright) = libm::sincos(stream.between(-3.0, 3.0).to_radians());
        let axis = Vector3::new(aslant * cosine, upright * cosine, sine);
        // Away from the camera, across the axis.
        let away = (Vector3::z() - axis * axis.z).normalize();
        let side = axis.cross(&away);
        let center =
            Vector3::new(stream.between(-0.005, 0.005), stream.between(-0.005, 0.005), self.distance);
        let metal = Material {
            albedo: stream.between(0.35, 0.7),
            cap_albedo: stream.between(0.35, 0.7),
            texture: Texture::Plain,
            highlight: stream.between(0.05, 0.3),
            gloss: stream.between(15.0, 60.0),
        };
        let tags = Texture::Cells { size: [0.008; 2], share: 0.5, contrast: 0.95, seed: stream.seed() };
        let paper = Material { albedo: stream.between(0.7, 0.9), ..Material::default() };
        let printed = Material { texture: tags, ..paper };
        let table = Material { albedo: stream.between(0.2, 0.5), ..Material::default() };
        const THICKNESS: f64 = 0.003;
        let on_board = center + away * (self.radius + THICKNESS);
        let below = center + away * (self.radius + 3.0 * THICKNESS);
        let turned = |z: Vector3<f64>, x: Vector3<f64>| Matrix3::from_columns(&[x, z.cross(&x), z]);
        let shape = Shape::Turned { radii: [self.radius; 2], length: LENGTH, bore: None };
        let mut bodies = vec![
            body(1, shape, turned(axis, side), center, metal)?,
            body(0, Shape::Plane, turned(away, side), below, table)?,
        ];
        // The middle of the board is blank; to its left and right are the tags.
        let board = Matrix3::from_columns(&[side, axis, away]);
        for (from, to, material) in [(-0.07, 0.07, paper), (-0.11, -0.07, printed), (0.07, 0.11, printed)] {
            let half = Vector3::new(0.5 * (to - from), 0.12, THICKNESS);
            let at = on_board + side * (0.5 * (from + to));
            bodies.push(body(2, Shape::Box { half }, board, at, material)?);
        }
        bodies[0].measured = true;
        bodies.extend(self.screen(&center, &axis, &away, &side)?);
        let truth = TrueCylinder {
            object: 1,
            style: Style::Plain,
            center,
            cylinder: Cylinder::new(center, axis, self.radius)?,
            length: LENGTH,
        };
        // As in the twin's own scenes of single cylinders: behind the camera, above or beside it.
        let drawn =
            Vector3::new(stream.between(-1.0, 1.0), stream.between(-1.5, 0.0), stream.between(-0.6, 0.0));
        let lamp = self.light.map_or(drawn, |aside| {
            let (sine, cosine) = libm::sincos(aside.to_radians());
            center + (side * sine - away * cosine) * 1.2
        });
        let ambient = stream.between(0.25, 0.6);
        Ok(Scene { bodies, cylinders: vec![truth], ignored: Vec::new(), lamp, ambient })
    }

    /// What stands in front of the cylinder.
    fn screen(
        &self,
        center: &Vector3<f64>,
        axis: &Vector3<f64>,
        away: &Vector3<f64>,
        side: &Vector3<f64>,
    ) -> Result<Option<Body>> {
        const THIN: f64 = 0.002;
        let card = Material { albedo: 0.5, ..Material::default() };
        let turned = Matrix3::from_columns(&[*side, *axis, *away]);
        // The position in front of a point of the surface on its line of sight.
        let before = |point: Vector3<f64>| {
            let depth = (point - center).dot(away) + self.radius + BEFORE;
            point * (1.0 - depth / point.dot(away))
        };
        match self.hidden {
            Hidden::Nothing => Ok(None),
            Hidden::Side(seen) => {
                let across = 2.0 * seen - 1.0;
                let edge = center + side * (self.radius * across)
                    - away * (self.radius * (1.0 - across * across).max(0.0).sqrt());
                const HALF: f64 = 0.08;
                let half = Vector3::new(HALF, 0.12, THIN);
                body(3, Shape::Box { half }, turned, before(edge) + side * HALF, card).map(Some)
            }
            Hidden::Middle(share) => {
                let near = center - away * self.radius;
                let [from, to] = [-0.5, 0.5].map(|half| before(near + axis * (half * share * LENGTH)));
                let half = Vector3::new(0.15, 0.5 * (to - from).dot(axis), THIN);
                body(3, Shape::Box { half }, turned, (from + to) * 0.5, card).map(Some)
            }
        }
    }
}

/// The pipes of the paper's section 5.7: one of 57 mm on a wall, and one of 19 and three of 25.5 mm below a ceiling.
pub fn pipes(scenario: usize, seed: u64) -> Result<Scene> {
    let mut stream = Stream::new(seed, Purpose::Layout);
    let (radii, distance, gap, aslant): (&[f64], f64, f64, f64) = match scenario {
        0 => (&[0.057], 0.9, 0.04, stream.between(80.0, 100.0)),
        _ => (&[0.019, 0.0255, 0.0255, 0.0255], 1.0, 0.05, stream.between(-10.0, 10.0)),
    };
    let (sine, cosine) = libm::sincos(aslant.to_radians());
    let away = stream.between(-0.15, 0.15);
    let axis = Vector3::new(cosine, sine, away).normalize();
    let beside = Vector3::new(-sine, cosine, 0.0);
    let backward = axis.cross(&beside).normalize();
    // From the camera to the wall.
    let backward = if backward.z < 0.0 { -backward } else { backward };
    let widest = radii.iter().copied().fold(0.0, f64::max);
    let wall = Material {
        albedo: stream.between(0.4, 0.8),
        texture: Texture::Grain { size: [0.03, 0.05], contrast: 0.2, seed: stream.seed() },
        ..Material::default()
    };
    let middle = Vector3::new(0.0, 0.0, distance);
    let turned = |z: Vector3<f64>| Matrix3::from_columns(&[beside, z.cross(&beside), z]);
    let mut bodies = vec![body(0, Shape::Plane, turned(backward), middle + backward * (widest + gap), wall)?];
    let mut cylinders = Vec::new();
    for (index, radius) in radii.iter().enumerate() {
        let object = index as u16 + 1;
        let offset = (index as f64 - 0.5 * (radii.len() - 1) as f64) * 0.1;
        let center = middle + beside * (offset + stream.between(-0.01, 0.01));
        let material = Material {
            albedo: stream.between(0.3, 0.8),
            cap_albedo: 0.5,
            texture: Texture::Grain {
                size: [0.01, 0.08],
                contrast: stream.between(0.05, 0.2),
                seed: stream.seed(),
            },
            highlight: stream.between(0.0, 0.3),
            gloss: 30.0,
        };
        const LONG: f64 = 2.4;
        let shape = Shape::Turned { radii: [*radius; 2], length: LONG, bore: None };
        let mut pipe = body(object, shape, turned(axis), center, material)?;
        pipe.measured = true;
        bodies.push(pipe);
        cylinders.push(TrueCylinder {
            object,
            style: Style::Plain,
            center,
            cylinder: Cylinder::new(center, axis, *radius)?,
            length: LONG,
        });
    }
    // As in the twin's own scenes of pipes.
    let lamp = Vector3::new(stream.between(-1.0, 1.0), stream.between(-1.5, 0.3), stream.between(-0.6, 0.0));
    Ok(Scene { bodies, cylinders, ignored: Vec::new(), lamp, ambient: stream.between(0.25, 0.6) })
}

fn body(
    object: u16,
    shape: Shape,
    rotation: Matrix3<f64>,
    at: Vector3<f64>,
    material: Material,
) -> Result<Body> {
    Ok(Body { object, shape, pose: RigidMotion::new(rotation, at)?, material, measured: false })
}
