//! Scenes: bodies in the frame of the colour camera, their surfaces, the light, and what is seen from a position.

use super::random::hash;
use super::shape::{Face, Part, Shape};
use crate::geometry::{Cylinder, RigidMotion};
use nalgebra::Vector3;

/// What is printed on a surface: a factor of the albedo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Texture {
    /// Nothing.
    Plain,
    /// Rectangles of random brightness, as print on a label has them.
    Cells {
        /// Length of a cell in both coordinates on the surface.
        size: [f64; 2],
        /// The share of cells that are darker than the rest.
        share: f64,
        /// How dark they are at most, from 0 to 1.
        contrast: f64,
        /// The pattern.
        seed: u64,
    },
    /// Smooth variation, as wood and plaster have it.
    Grain {
        /// Length of a variation in both coordinates on the surface.
        size: [f64; 2],
        /// Its depth, from 0 to 1.
        contrast: f64,
        /// The pattern.
        seed: u64,
    },
}

impl Texture {
    fn factor(&self, at: [f64; 2]) -> f64 {
        match *self {
            Texture::Plain => 1.0,
            Texture::Cells { size, share, contrast, seed } => {
                let [x, y] = [0, 1].map(|k| libm::floor(at[k] / size[k]) as i64);
                let value = hash(seed, x, y);
                if value < share { 1.0 - contrast * (0.5 + 0.5 * value / share) } else { 1.0 }
            }
            Texture::Grain { size, contrast, seed } => {
                let coarse = smooth(seed, [at[0] / size[0], at[1] / size[1]]);
                let fine = smooth(seed ^ 1, [3.1 * at[0] / size[0], 3.1 * at[1] / size[1]]);
                1.0 - contrast * (0.65 * coarse + 0.35 * fine)
            }
        }
    }
}

/// Random values at the integers, interpolated between them.
fn smooth(seed: u64, at: [f64; 2]) -> f64 {
    let cell = at.map(libm::floor);
    let [u, v] = [0, 1].map(|k| at[k] - cell[k]).map(|x| x * x * (3.0 - 2.0 * x));
    let [x, y] = cell.map(|x| x as i64);
    let value = |dx, dy| hash(seed, x + dx, y + dy);
    let row = |dy| value(0, dy) * (1.0 - u) + value(1, dy) * u;
    row(0) * (1.0 - v) + row(1) * v
}

/// How a surface sends light back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// The share of light that comes back in all directions (Lambert), from 0 to 1.
    pub albedo: f64,
    /// The share of light that comes back in all directions from the flat ends, from 0 to 1.
    pub cap_albedo: f64,
    /// What is printed on it.
    pub texture: Texture,
    /// The strength of highlights: 0 for none (Blinn, SIGGRAPH 1977).
    pub highlight: f64,
    /// The exponent of highlights.
    pub gloss: f64,
}

impl Default for Material {
    fn default() -> Self {
        Self { albedo: 0.6, cap_albedo: 0.6, texture: Texture::Plain, highlight: 0.0, gloss: 30.0 }
    }
}

/// A body at its position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    /// What the labels call it; bodies of one object share it. 0 for table and walls.
    pub object: u16,
    /// Its shape.
    pub shape: Shape,
    /// From its own frame to that of the colour camera.
    pub pose: RigidMotion,
    /// Its surface.
    pub material: Material,
    /// Whether its lateral surface is that of a cylinder which is to be found.
    pub measured: bool,
}

/// How the ends of a cylinder look.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Style {
    /// Closed, with lids of a slightly larger radius.
    Can,
    /// Closed.
    Plain,
    /// A tube.
    Open,
}

impl Style {
    /// The name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Style::Can => "can",
            Style::Plain => "plain",
            Style::Open => "open",
        }
    }
}

/// A true cylinder of a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrueCylinder {
    /// The object that it is, or belongs to.
    pub object: u16,
    /// How its ends look.
    pub style: Style,
    /// The middle of its axis.
    pub center: Vector3<f64>,
    /// Its axis and radius.
    pub cylinder: Cylinder,
    /// The length between its ends, without lids.
    pub length: f64,
}

/// What is in front of the cameras, in the frame of the colour camera, in metres.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scene {
    /// All bodies.
    pub bodies: Vec<Body>,
    /// The cylinders that are to be found.
    pub cylinders: Vec<TrueCylinder>,
    /// The cylinders that may be found or not: bodies and necks of bottles.
    pub ignored: Vec<TrueCylinder>,
    /// Where the lamp is.
    pub lamp: Vector3<f64>,
    /// Light from everywhere, as a share of all light.
    pub ambient: f64,
}

/// What a ray met.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// How many times the direction of the ray it is away.
    pub t: f64,
    /// The index of the body.
    pub body: usize,
    /// The part of it.
    pub part: Part,
    face: Face,
}

/// The surface at a hit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patch {
    /// Where it is.
    pub point: Vector3<f64>,
    /// The unit normal, on the side of whoever looks.
    pub normal: Vector3<f64>,
    /// The share of light that comes back in all directions.
    pub albedo: f64,
    /// As in [`Material`].
    pub highlight: f64,
    /// As in [`Material`].
    pub gloss: f64,
}

impl Patch {
    /// The light that goes towards `eye` for light of strength 1 on a surface that faces it, from `lamp`: Lambert and
    /// the highlight of Blinn.
    #[must_use]
    pub fn reflect(&self, lamp: &Vector3<f64>, eye: &Vector3<f64>) -> f64 {
        let to_lamp = (lamp - self.point).normalize();
        let cosine = self.normal.dot(&to_lamp);
        if cosine <= 0.0 {
            return 0.0;
        }
        let mut light = self.albedo * cosine;
        if self.highlight > 0.0 {
            let half = (to_lamp + (eye - self.point).normalize()).normalize();
            light += self.highlight * libm::pow(half.dot(&self.normal).max(0.0), self.gloss);
        }
        light
    }
}

/// A position from which rays go out: what does not depend on the ray is computed once.
#[derive(Debug)]
pub struct Viewpoint<'a> {
    scene: &'a Scene,
    origin: Vector3<f64>,
    sights: Vec<Sight>,
}

/// A body as it is seen from a position.
#[derive(Debug)]
struct Sight {
    /// The position in the frame of the body.
    from: Vector3<f64>,
    /// Rays within this cone may meet it: the direction of its middle, and the cosine of the angle.
    toward: Vector3<f64>,
    cosine: f64,
}

impl<'a> Viewpoint<'a> {
    /// A position in a scene.
    #[must_use]
    pub fn new(scene: &'a Scene, origin: Vector3<f64>) -> Self {
        let sight = |body: &Body| {
            let from = body.pose.rotation().transpose() * (origin - body.pose.translation());
            let distance = from.norm();
            let (toward, cosine) = match body.shape.bound() {
                Some(bound) if bound < distance => {
                    let sine = bound / distance;
                    let toward = (body.pose.translation() - origin) / distance;
                    // A little wider than exact, for rounding.
                    (toward, (1.0 - sine * sine).sqrt() - 1e-9)
                }
                _ => (Vector3::zeros(), -1.0),
            };
            Sight { from, toward, cosine }
        };
        Self { scene, origin, sights: scene.bodies.iter().map(sight).collect() }
    }

    /// Where it is.
    #[must_use]
    pub fn origin(&self) -> &Vector3<f64> {
        &self.origin
    }

    /// The first surface on the ray along a direction of any length.
    #[must_use]
    pub fn look(&self, along: &Vector3<f64>) -> Option<Hit> {
        let norm = along.norm();
        let mut first: Option<Hit> = None;
        for (index, (body, sight)) in self.scene.bodies.iter().zip(&self.sights).enumerate() {
            if sight.toward.dot(along) < sight.cosine * norm {
                continue;
            }
            let local = body.pose.rotation().transpose() * along;
            if let Some((t, face)) = body.shape.meet(&sight.from, &local)
                && first.is_none_or(|first| t < first.t)
            {
                first = Some(Hit { t, body: index, part: face.part(), face });
            }
        }
        first
    }

    /// The surface at a hit of the ray along a direction.
    #[must_use]
    pub fn patch(&self, along: &Vector3<f64>, hit: &Hit) -> Patch {
        let body = &self.scene.bodies[hit.body];
        let local = body.pose.rotation().transpose() * along;
        let at = self.sights[hit.body].from + local * hit.t;
        let outward = body.pose.direction(&body.shape.normal(hit.face, &at));
        let material = &body.material;
        let base = if hit.part == Part::Cap { material.cap_albedo } else { material.albedo };
        // Ends carry no print.
        let plain = hit.part != Part::Body;
        let printed = || material.texture.factor(body.shape.surface_coordinates(hit.face, &at));
        Patch {
            point: self.origin + along * hit.t,
            normal: if outward.dot(along) > 0.0 { -outward } else { outward },
            albedo: if plain { base } else { base * printed() },
            highlight: material.highlight,
            gloss: material.gloss,
        }
    }

    /// Whether nothing stands between this position and a point on a surface.
    #[must_use]
    pub fn sees(&self, point: &Vector3<f64>) -> bool {
        // The surface itself is met at 1 to rounding.
        self.look(&(point - self.origin)).is_none_or(|hit| hit.t > 1.0 - 1e-6)
    }
}
