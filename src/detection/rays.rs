//! Rays beside a cylinder, and where they meet it.

use crate::geometry::{Cylinder, Line};
use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};

/// Where a ray passes a cylinder across the axis, in radii: −1 to 1 on the body.
#[inline]
pub(super) fn passes(cylinder: &Cylinder, x: f64, y: f64) -> Option<f64> {
    let normal = Vector3::new(x, y, 1.0).cross(&cylinder.axis.direction);
    let norm = normal.norm();
    if norm < 1e-9 {
        return None;
    }
    Some(normal.dot(&cylinder.axis.point) / (norm * cylinder.radius))
}

/// The rays that pass a cylinder within a part of its radius. Most rays of an image do not, and asking [`passes`] takes a root
/// and a division for each.
pub(crate) struct Band {
    direction: Vector3<f64>,
    /// The moment of the axis about the origin, in parts of the radius.
    moment: Vector3<f64>,
}

impl Band {
    pub fn new(cylinder: &Cylinder, part: f64) -> Self {
        let Line { point, direction } = cylinder.axis;
        Self { direction, moment: direction.cross(&point) / (part * cylinder.radius) }
    }

    /// Whether a ray lies within; one along the axis does not.
    #[inline]
    pub fn contains(&self, ray: &Vector3<f64>) -> bool {
        self.excess(ray.x, ray.y, ray.z) < 0.0
    }

    /// Negative for a ray within.
    #[inline(always)]
    pub(super) fn excess(&self, x: f64, y: f64, z: f64) -> f64 {
        let (d, m) = (&self.direction, &self.moment);
        let along = x * d.x + y * d.y + z * d.z;
        let across = x * m.x + y * m.y + z * m.z;
        across * across - (x * x + y * y + z * z - along * along)
    }

    /// The same for many rays by their positions on the plane z = 1: negative for those within.
    pub(super) fn excesses(&self, x: &[f64], y: &[f64], found: &mut Vec<f64>) {
        found.resize(x.len(), 0.0);
        Arch::new().dispatch(Excesses { band: self, x, y, found });
    }
}

/// One pass over rays.
struct Excesses<'a> {
    band: &'a Band,
    x: &'a [f64],
    y: &'a [f64],
    found: &'a mut [f64],
}

impl WithSimd for Excesses<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        for ((found, x), y) in self.found.iter_mut().zip(self.x).zip(self.y) {
            *found = self.band.excess(*x, *y, 1.0);
        }
    }
}

/// Where a ray meets a cylinder along the axis, or passes it.
pub(crate) fn meets(cylinder: &Cylinder, ray: &Vector3<f64>) -> f64 {
    let axis = &cylinder.axis;
    // The foot of the common perpendicular on the axis, where the ray passes.
    let point = cylinder.first_hit(ray).unwrap_or_else(|| ray * axis.nearest_on_ray(ray));
    axis.position_of(&point)
}
