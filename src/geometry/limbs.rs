//! The two lines of the surface that bound it in the image (11)–(13).

use super::cylinder::Cylinder;
use super::line::{Line, PluckerLine};
use nalgebra::Vector3;

/// The plane across the axis through the origin, seen from the origin: everything about limbs is
/// two-dimensional here.
///
/// Invariants: `toward`, `sideways` and the axis direction are a right-handed orthonormal frame, `toward`
/// points from the origin to the axis, and 0 < γ < π/2.
#[derive(Debug, Clone, Copy)]
pub struct LimbFrame {
    /// ĉ, from the origin towards the axis point nearest to it.
    pub toward: Vector3<f64>,
    /// d̂ × ĉ.
    pub sideways: Vector3<f64>,
    /// d̂.
    pub direction: Vector3<f64>,
    /// ‖c‖.
    pub distance: f64,
    /// r / ‖c‖ = sin γ.
    pub sin_gamma: f64,
    /// cos γ.
    pub cos_gamma: f64,
}

impl LimbFrame {
    /// The frame of a cylinder; `None` when the origin is inside it (r ≥ ‖c‖), where no limbs exist.
    #[must_use]
    pub fn new(cylinder: &Cylinder) -> Option<Self> {
        let c = cylinder.axis.nearest_to_origin();
        let distance = c.norm();
        let sin_gamma = cylinder.radius / distance;
        if !(sin_gamma < 1.0) {
            return None;
        }
        let toward = c / distance;
        let direction = cylinder.axis.direction;
        Some(Self {
            toward,
            sideways: direction.cross(&toward),
            direction,
            distance,
            sin_gamma,
            cos_gamma: ((1.0 - sin_gamma) * (1.0 + sin_gamma)).sqrt(),
        })
    }

    /// The limb lines L₁ and L₂: c_Lj = cos γ · Exp((−1)^{j−1} γ d̂) c (12), both along d̂.
    #[must_use]
    pub fn limb_lines(&self) -> [Line; 2] {
        [1.0, -1.0].map(|side| Line {
            point: (self.toward * self.cos_gamma + self.sideways * (side * self.sin_gamma))
                * (self.cos_gamma * self.distance),
            direction: self.direction,
        })
    }

    /// The moments m_Lj = c_Lj × d̂ (13) scaled to unit length: the normals of the planes through the origin
    /// and each limb line.
    #[must_use]
    pub fn limb_plane_normals(&self) -> [Vector3<f64>; 2] {
        self.limb_lines().map(|line| PluckerLine::from(line).moment.normalize())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::exp_so3;

    #[test]
    fn limb_lines_are_those_of_equation_12_and_touch_the_surface() {
        let cylinder =
            Cylinder::new(Vector3::new(0.1, -0.2, 0.9), Vector3::new(0.4, 0.8, 0.3), 0.07).unwrap();
        let frame = LimbFrame::new(&cylinder).unwrap();
        let c = cylinder.axis.nearest_to_origin();
        let d = cylinder.axis.direction;
        let gamma = (cylinder.radius / c.norm()).asin();
        for (j, line) in frame.limb_lines().iter().enumerate() {
            let sign = [1.0, -1.0][j];
            let expected = exp_so3(&(d * (sign * gamma))) * c * gamma.cos();
            assert!((line.point - expected).norm() < 1e-15);
            assert!(cylinder.distance(&line.point).abs() < 1e-15);
            // The sight line to the limb is tangent to the surface.
            let outward = line.point - c;
            assert!(outward.dot(&line.point).abs() < 1e-15);
            let normal = frame.limb_plane_normals()[j];
            assert!(normal.dot(&line.point).abs() < 1e-15 && normal.dot(&d).abs() < 1e-15);
        }
    }

    #[test]
    fn there_are_no_limbs_from_inside() {
        let axis = Vector3::new(0.0, 0.0, 0.5);
        for radius in [0.5, 0.6] {
            let pipe = Cylinder::new(axis, Vector3::x(), radius).unwrap();
            assert!(LimbFrame::new(&pipe).is_none());
        }
    }
}
