//! The edge alignment term of the paper (17)–(25).
//!
//! In the plane across the axis, with ĉ towards the axis and ŝ = d̂ × ĉ, the reference plane Π through both
//! limb lines is ĉ · x = A with A = ‖c‖ cos²γ, and limb line j lies in it at ŝ · x = σ_j B with
//! B = ‖c‖ sin γ cos γ, σ₁ = 1, σ₂ = −1. The ray v of an endpoint meets Π at A v / (ĉ · v), so that
//! e = A τ − σ_j B with τ = (ŝ · v) / (ĉ · v): the signed distance within Π from limb line j.

use super::terms::{Row, Source, Term};
use super::{NormalEquations, SandwichPart};
use crate::geometry::{Cylinder, LimbFrame, LocalFrame, Tangent, TangentMap};
use nalgebra::{Matrix3, Vector2, Vector3};

/// The two observed edge segments, without distortion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimbPair {
    /// Rays v = K⁻¹ q̃ through the endpoints (22), by segment.
    pub rays: [[Vector3<f64>; 2]; 2],
    /// The endpoints q in ideal pixels, by segment.
    pub pixels: [[Vector2<f64>; 2]; 2],
}

/// The edge alignment energy E_L.
#[derive(Debug, Clone, Copy)]
pub struct LimbTerm {
    pair: LimbPair,
    line_projection: Matrix3<f64>,
    /// Standard deviation of an endpoint across its limb line, in pixels.
    deviation: f64,
    /// For w_L = 1, the distance of the start's axis from the camera, which stands for the scale that the edges
    /// cannot see.
    held_distance: Option<f64>,
}

/// One endpoint: its residual and its Jacobian in the tangent of the frame.
pub(super) type LimbRow = (f64, Tangent);

impl LimbTerm {
    /// The term of two segments seen by a camera with the line projection K_L (10), whose endpoints have a standard
    /// deviation in pixels across the limb lines.
    #[must_use]
    pub fn new(pair: LimbPair, line_projection: Matrix3<f64>, deviation: f64) -> Self {
        Self { pair, line_projection, deviation, held_distance: None }
    }

    /// The same for w_L = 1, where the scale of the model is not observable: every residual is multiplied by
    /// ‖c₀‖ / ‖c‖ with the distance ‖c₀‖ of the start, which takes the descent along the scale away.
    #[must_use]
    pub fn held_at(self, start_distance: f64) -> Self {
        Self { held_distance: Some(start_distance), ..self }
    }

    /// Whether the observed segments go with the limb lines in the direct order (true) or swapped: the smaller
    /// sum of the pixel distances of the endpoints wins (17)–(20), the direct order when they are equal.
    #[must_use]
    pub fn associate(&self, limbs: &LimbFrame) -> bool {
        let lines = limbs.limb_plane_normals().map(|moment| self.line_projection * moment);
        let sum = |segment: usize, line: &Vector3<f64>| -> f64 {
            let norm = line.x.hypot(line.y);
            self.pair.pixels[segment].iter().map(|q| (line.dot(&q.push(1.0)) / norm).abs()).sum()
        };
        sum(0, &lines[0]) + sum(1, &lines[1]) <= sum(0, &lines[1]) + sum(1, &lines[0])
    }

    /// The residual of each endpoint over its distance from the limb line in pixels. With the unit moment m of the
    /// limb line, e = −‖c‖ cos γ (m·v) / (ĉ·v), and with l = K_L m the distance is l·q̃ / ‖(l₁, l₂)‖, where
    /// l·q̃ = det K (m·v) for v = K⁻¹ q̃.
    fn lengths_of_pixel(&self, limbs: &LimbFrame) -> [[f64; 2]; 2] {
        let direct = self.associate(limbs);
        let determinant = self.line_projection[(2, 2)];
        let norms = limbs.limb_plane_normals().map(|moment| (self.line_projection * moment).xy().norm());
        [0, 1].map(|segment: usize| {
            let norm = norms[if direct { segment } else { 1 - segment }];
            self.pair.rays[segment].map(|ray| {
                let ahead = limbs.toward.dot(&ray) / ray.z;
                limbs.distance * limbs.cos_gamma * norm / (ahead * determinant)
            })
        })
    }

    /// E_L in the caller's unit squared; `None` where it is infinite.
    #[must_use]
    pub fn energy(&self, cylinder: &Cylinder) -> Option<f64> {
        let frame = LocalFrame::new(cylinder, &cylinder.axis.point, 1.0);
        self.cost(&frame)
    }

    /// The residuals of the endpoints by observed segment, with their Jacobians.
    pub(super) fn endpoints(&self, frame: &LocalFrame) -> Option<[[LimbRow; 2]; 2]> {
        let limbs = LimbFrame::new(&frame.cylinder)?;
        let direct = self.associate(&limbs);
        let shared = AxisMotion::new(frame, &limbs);
        let LimbFrame { distance, sin_gamma, cos_gamma, .. } = limbs;
        let radius = frame.cylinder.radius;
        let plane = distance * cos_gamma * cos_gamma;
        let half_width = radius * cos_gamma;
        // Derivatives of A and B in ‖c‖ and r.
        let plane_distance = 1.0 + sin_gamma * sin_gamma;
        let plane_radius = -2.0 * sin_gamma;
        let width_distance = sin_gamma.powi(3) / cos_gamma;
        let width_radius = (1.0 - 2.0 * sin_gamma * sin_gamma) / cos_gamma;

        let mut rows = [[(0.0, Tangent::zeros()); 2]; 2];
        for (segment, endpoints) in self.pair.rays.iter().enumerate() {
            // Limb line 1 lies on the side of ŝ.
            let side = if (segment == 0) == direct { 1.0 } else { -1.0 };
            for (k, ray) in endpoints.iter().enumerate() {
                let ahead = limbs.toward.dot(ray);
                if ahead <= 0.0 {
                    return None;
                }
                let tau = limbs.sideways.dot(ray) / ahead;
                let slope = limbs.direction.dot(ray) / ahead;
                let residual = (plane * tau - side * half_width) / frame.unit;
                // A τ − σ B, with δτ = −(1 + τ²) ŝ·δc / ‖c‖ − (d̂·v / ĉ·v) (ŝ·δd − τ ĉ·δd).
                let in_distance = plane_distance * tau - side * width_distance;
                let in_sideways = -plane * (1.0 + tau * tau) / distance;
                let mut jacobian = shared.toward * in_distance + shared.sideways * in_sideways;
                jacobian -= (shared.tilt_sideways - shared.tilt_toward * tau) * (plane * slope / frame.unit);
                jacobian[4] = plane_radius * tau - side * width_radius;
                rows[segment][k] = (residual, jacobian);
            }
        }
        rows.iter().flatten().all(|(residual, _)| residual.is_finite()).then_some(rows)
    }
}

impl Term for LimbTerm {
    fn source(&self) -> Source {
        Source::Image
    }

    fn cost(&self, frame: &LocalFrame) -> Option<f64> {
        Some(self.linearise(frame)?.cost)
    }

    /// The mean over the four endpoints: cost = E_L / unit². `None` where the energy is infinite: an observer
    /// inside the cylinder, or an endpoint whose ray meets Π behind the camera.
    fn linearise(&self, frame: &LocalFrame) -> Option<NormalEquations> {
        let mut equations = NormalEquations::zero();
        let Some(start_distance) = self.held_distance else {
            for (residual, jacobian) in self.endpoints(frame)?.iter().flatten() {
                equations.add_residual(0.25, *residual, jacobian);
            }
            return Some(equations);
        };
        let limbs = LimbFrame::new(&frame.cylinder)?;
        let factor = start_distance / limbs.distance;
        let distance_row = AxisMotion::new(frame, &limbs).toward * (frame.unit / limbs.distance);
        for (residual, jacobian) in self.endpoints(frame)?.iter().flatten() {
            let scaled = (jacobian - distance_row * *residual) * factor;
            equations.add_residual(0.25, residual * factor, &scaled);
        }
        Some(equations)
    }

    /// Those of E_L itself, also where a distance is held.
    fn rows(&self, frame: &LocalFrame) -> Option<Vec<Row>> {
        Some(self.endpoints(frame)?.iter().flatten().map(|(e, j)| (e * 0.5, j * 0.5)).collect())
    }

    /// The endpoints have independent errors across the limb lines; four are too few to tell their variance, so it is
    /// given. `None` where a distance is held: the scale is left open.
    fn sandwich(&self, frame: &LocalFrame) -> Option<SandwichPart> {
        if self.held_distance.is_some() {
            return None;
        }
        let equations = self.linearise(frame)?;
        let limbs = LimbFrame::new(&frame.cylinder)?;
        let lengths = self.lengths_of_pixel(&limbs);
        let mut covariance = TangentMap::zeros();
        for (lengths, endpoints) in lengths.iter().zip(self.endpoints(frame)?) {
            for (length, (_, jacobian)) in lengths.iter().zip(endpoints) {
                let deviation = self.deviation * length / frame.unit;
                covariance += jacobian * jacobian.transpose() * (0.25 * deviation).powi(2);
            }
        }
        Some(SandwichPart { gradient: equations.gradient, derivative: equations.hessian, covariance })
    }
}

/// How the axis point nearest to the observer and the direction move with the tangent of a frame, in units of
/// the frame.
pub(super) struct AxisMotion {
    /// ĉ · δc, which is δ‖c‖.
    pub(super) toward: Tangent,
    /// ŝ · δc.
    pub(super) sideways: Tangent,
    /// ĉ · δd.
    pub(super) tilt_toward: Tangent,
    /// ŝ · δd.
    pub(super) tilt_sideways: Tangent,
}

impl AxisMotion {
    pub(super) fn new(frame: &LocalFrame, limbs: &LimbFrame) -> Self {
        let axis = &frame.cylinder.axis;
        // The frame sits this far along the axis from the point nearest to the observer, which a tilt moves
        // back by as much.
        let along = axis.point.dot(&axis.direction) / frame.unit;
        let row = |across: &Vector3<f64>| {
            let (u, v) = (across.dot(&frame.u), across.dot(&frame.v));
            let tilt = Tangent::new(0.0, 0.0, u, v, 0.0);
            (Tangent::new(u, v, -along * u, -along * v, 0.0), tilt)
        };
        let (toward, tilt_toward) = row(&limbs.toward);
        let (sideways, tilt_sideways) = row(&limbs.sideways);
        Self { toward, sideways, tilt_toward, tilt_sideways }
    }
}
