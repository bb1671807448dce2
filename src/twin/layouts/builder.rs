//! Puts bodies into a scene by their positions in the room: x to the right, y away from the camera, z up.

use crate::error::Result;
use crate::geometry::{Cylinder, RigidMotion, any_orthogonal};
use crate::twin::random::Stream;
use crate::twin::scene::{Body, Material, Scene, Style, Texture, TrueCylinder};
use crate::twin::shape::Shape;
use nalgebra::{Matrix3, Vector2, Vector3};

/// A cylinder that is to be put somewhere.
#[derive(Debug, Clone, Copy)]
pub struct Cylindrical {
    pub style: Style,
    pub radius: f64,
    /// Of the body, without lids.
    pub length: f64,
    /// The height of a lid, 0 for none.
    pub lid: f64,
    /// The radius of a lid.
    pub lid_radius: f64,
}

impl Cylindrical {
    /// Lids 1 to 3 % wider on most cans.
    pub fn random(style: Style, radius: f64, length: f64, stream: &mut Stream) -> Self {
        let lid = if style == Style::Can { stream.between(0.003, 0.007) } else { 0.0 };
        let wider = if stream.chance(0.7) { stream.between(1.01, 1.03) } else { 1.0 };
        Self { style, radius, length, lid, lid_radius: if lid > 0.0 { wider * radius } else { radius } }
    }

    /// The length with lids.
    pub fn whole(&self) -> f64 {
        self.length + 2.0 * self.lid
    }

    /// The largest radius.
    pub fn widest(&self) -> f64 {
        self.lid_radius.max(self.radius)
    }
}

/// What stands on the table: a disc swept along a line.
#[derive(Debug, Clone, Copy)]
pub struct Footprint {
    pub ends: [Vector2<f64>; 2],
    pub radius: f64,
}

impl Footprint {
    pub fn disc(at: Vector2<f64>, radius: f64) -> Self {
        Self { ends: [at; 2], radius }
    }

    fn overlaps(&self, other: &Self) -> bool {
        const STEPS: usize = 12;
        let along = |ends: &[Vector2<f64>; 2], k: usize| ends[0].lerp(&ends[1], k as f64 / STEPS as f64);
        let apart = self.radius + other.radius;
        (0..=STEPS)
            .any(|i| (0..=STEPS).any(|j| (along(&self.ends, i) - along(&other.ends, j)).norm() < apart))
    }
}

/// A scene that grows.
pub struct Builder {
    pub scene: Scene,
    /// From the room to the colour camera.
    to_camera: RigidMotion,
    objects: u16,
    footprints: Vec<Footprint>,
}

impl Builder {
    /// An empty room seen from `distance` metres, `elevation` radians above the horizon and turned by `roll`, with the
    /// origin of the room in the middle of the image.
    pub fn new(distance: f64, elevation: f64, roll: f64) -> Result<Self> {
        let (sine, cosine) = libm::sincos(elevation);
        let forward = Vector3::new(0.0, cosine, -sine);
        let (sine, cosine) = libm::sincos(roll);
        let down = forward.cross(&Vector3::x());
        let right = Vector3::x() * cosine + down * sine;
        let rotation = Matrix3::from_columns(&[right, forward.cross(&right), forward]).transpose();
        let to_camera = RigidMotion::new(rotation, Vector3::new(0.0, 0.0, distance))?;
        Ok(Self { scene: Scene::default(), to_camera, objects: 0, footprints: Vec::new() })
    }

    /// A lamp at a position of the room.
    pub fn light(&mut self, at: Vector3<f64>, ambient: f64) {
        self.scene.lamp = self.to_camera.point(&at);
        self.scene.ambient = ambient;
    }

    /// The lamp of a room: somewhere above, more or less from the side.
    pub fn random_light(&mut self, stream: &mut Stream) {
        let at = Vector3::new(stream.between(-1.2, 1.2), stream.between(-1.0, 0.4), stream.between(1.0, 2.0));
        let ambient = stream.between(0.25, 0.6);
        self.light(at, ambient);
    }

    /// A number for a new object.
    pub fn new_object(&mut self) -> u16 {
        self.objects += 1;
        self.objects
    }

    /// Adds a body with its middle at `at` and its z axis along `axis`, turned about it by `spin`.
    pub fn add(
        &mut self,
        object: u16,
        shape: Shape,
        (at, axis, spin): (Vector3<f64>, Vector3<f64>, f64),
        material: Material,
    ) -> Result<()> {
        let axis = axis.normalize();
        let (sine, cosine) = libm::sincos(spin);
        let (u, _) = any_orthogonal(&axis);
        let x = u * cosine + axis.cross(&u) * sine;
        let own = Matrix3::from_columns(&[x, axis.cross(&x), axis]);
        let pose = RigidMotion::new(self.to_camera.rotation() * own, self.to_camera.point(&at))?;
        self.scene.bodies.push(Body { object, shape, pose, material, measured: false });
        Ok(())
    }

    /// A plane through a position with a normal.
    pub fn plane(&mut self, at: Vector3<f64>, normal: Vector3<f64>, material: Material) -> Result<()> {
        self.add(0, Shape::Plane, (at, normal, 0.0), material)
    }

    /// Adds a cylinder with the middle of its body at `at`, lids and all. It is to be found, unless it belongs to the
    /// object `part_of`.
    pub fn cylinder(
        &mut self,
        cylinder: &Cylindrical,
        (at, axis): (Vector3<f64>, Vector3<f64>),
        material: Material,
        part_of: Option<u16>,
    ) -> Result<u16> {
        let object = part_of.unwrap_or_else(|| self.new_object());
        let Cylindrical { style, radius, length, lid, lid_radius } = *cylinder;
        let axis = axis.normalize();
        let bore = (style == Style::Open).then_some(0.93 * radius);
        self.add(object, Shape::Turned { radii: [radius; 2], length, bore }, (at, axis, 0.0), material)?;
        if let Some(body) = self.scene.bodies.last_mut() {
            body.measured = part_of.is_none();
        }
        let lid_material = Material { albedo: material.cap_albedo, texture: Texture::Plain, ..material };
        if lid > 0.0 {
            let shape = Shape::Turned { radii: [lid_radius; 2], length: lid, bore: None };
            for side in [-1.0, 1.0] {
                let middle = at + axis * (side * 0.5 * (length + lid));
                self.add(object, shape, (middle, axis, 0.0), lid_material)?;
            }
        }
        let truth = TrueCylinder {
            object,
            style,
            center: self.to_camera.point(&at),
            cylinder: Cylinder::new(self.to_camera.point(&at), self.to_camera.direction(&axis), radius)?,
            length,
        };
        let list = if part_of.is_none() { &mut self.scene.cylinders } else { &mut self.scene.ignored };
        list.push(truth);
        Ok(object)
    }

    /// Takes a position on the table, unless something stands there.
    pub fn claim(&mut self, footprint: Footprint) -> bool {
        let free = !self.footprints.iter().any(|other| other.overlaps(&footprint));
        if free {
            self.footprints.push(footprint);
        }
        free
    }
}

/// The surface of an ordinary thing: paint, print or grain, mat or glossy.
pub fn random_material(stream: &mut Stream) -> Material {
    let texture = match stream.below(5) {
        0 | 1 => Texture::Plain,
        2 | 3 => Texture::Cells {
            size: [stream.log_between(0.004, 0.03), stream.log_between(0.004, 0.03)],
            share: stream.between(0.1, 0.5),
            contrast: stream.between(0.3, 0.9),
            seed: stream.seed(),
        },
        _ => Texture::Grain {
            size: [stream.log_between(0.002, 0.02), stream.log_between(0.01, 0.1)],
            contrast: stream.between(0.1, 0.5),
            seed: stream.seed(),
        },
    };
    let glossy = stream.chance(0.5);
    Material {
        albedo: stream.log_between(0.12, 0.9),
        cap_albedo: stream.log_between(0.2, 0.9),
        texture,
        highlight: if glossy { stream.between(0.1, 0.6) } else { 0.0 },
        gloss: stream.log_between(12.0, 120.0),
    }
}

/// The surface of a table or a wall.
pub fn random_ground(stream: &mut Stream) -> Material {
    let texture = match stream.below(3) {
        0 => Texture::Plain,
        1 => Texture::Grain {
            size: [stream.log_between(0.01, 0.05), stream.log_between(0.1, 0.6)],
            contrast: stream.between(0.1, 0.5),
            seed: stream.seed(),
        },
        _ => Texture::Cells {
            size: [stream.log_between(0.01, 0.06); 2],
            share: stream.between(0.1, 0.5),
            contrast: stream.between(0.1, 0.6),
            seed: stream.seed(),
        },
    };
    Material { albedo: stream.between(0.25, 0.8), texture, ..Material::default() }
}
