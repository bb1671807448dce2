//! Clouds of points for the tests of this folder.

use crate::geometry::{Cylinder, rejection};
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// A cylinder as a camera at the origin might see it.
pub(super) fn oblique() -> Cylinder {
    Cylinder::new(Vector3::new(0.05, -0.03, 0.7), Vector3::new(0.35, 0.9, 0.2), 0.02).unwrap()
}

/// A number between 0 and 1.
pub(super) fn uniform(rng: &mut ChaCha8Rng) -> f64 {
    f64::from(rng.next_u32()) / f64::from(u32::MAX)
}

/// A number of the standard normal distribution (Box and Muller).
pub(super) fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let radius = (-2.0 * (1.0 - uniform(rng)).max(1e-300).ln()).sqrt();
    radius * (std::f64::consts::TAU * uniform(rng)).cos()
}

/// What the points of a cloud are like.
pub(super) struct Arc {
    pub cylinder: Cylinder,
    /// Half the visible angle about the line of sight from the origin, in radians.
    pub half_angle: f64,
    /// Length along the axis.
    pub length: f64,
    pub points: usize,
    /// Standard deviation of the noise along the surface normal.
    pub noise: f64,
    /// The part of the points that is spread over a box around the rest instead.
    pub outliers: f64,
}

impl Default for Arc {
    fn default() -> Self {
        Self {
            cylinder: oblique(),
            half_angle: 70_f64.to_radians(),
            length: 0.1,
            points: 2000,
            noise: 0.0,
            outliers: 0.0,
        }
    }
}

impl Arc {
    /// Points and outward normals.
    pub fn sample(&self, seed: u64) -> (Vec<Vector3<f64>>, Vec<Vector3<f64>>) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let d = self.cylinder.axis.direction;
        let c = self.cylinder.axis.point;
        let facing = -rejection(&c, &d).normalize();
        let sideways = d.cross(&facing);
        (0..self.points)
            .map(|_| {
                let angle = (2.0 * uniform(&mut rng) - 1.0) * self.half_angle;
                let along = d * ((uniform(&mut rng) - 0.5) * self.length);
                let normal_direction = facing * angle.cos() + sideways * angle.sin();
                let radius = self.cylinder.radius + self.noise * normal(&mut rng);
                if uniform(&mut rng) < self.outliers {
                    let box_point = Vector3::from_fn(|_, _| uniform(&mut rng) - 0.5);
                    let direction = Vector3::from_fn(|_, _| normal(&mut rng)).normalize();
                    return (c + box_point * self.length, direction);
                }
                (c + along + normal_direction * radius, normal_direction)
            })
            .unzip()
    }
}
