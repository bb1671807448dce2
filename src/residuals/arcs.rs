//! Arcs of the end circles: points of the image at which the surface ends.
//!
//! The ray v of such a sample meets the near wall, or the far one where it is on the far rim, at p = λ v, at the position
//! t = (p − c) · d̂ along the axis. All samples of one end lie at the same position, which is unknown: the residual is the
//! distance of t from the mean of the end, in pixels across the arc. With the outward unit normal n at p and
//! κ = (d̂ · v) / (n · v), δt = κ (n · δc + t n · δd + δr) + r n · δd.

use super::pixel_terms::{PixelResiduals, PixelRow};
use crate::geometry::{Cylinder, LocalFrame, Tangent};
use crate::memory::List;
use nalgebra::Vector3;

/// A rim of an end: a half of its circle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rim {
    /// The one on the near wall, which bounds the surface that is seen from outside.
    Near,
    /// The one on the far wall, which is seen over a cap or through an open end.
    Far,
}

/// One sample of an arc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArcRay {
    /// Its ray, of any positive length.
    pub ray: Vector3<f64>,
    /// Which rim it is on.
    pub rim: Rim,
    /// Pixels across the arc by length along the axis.
    pub across: f64,
    /// How much it counts, 1 for a standard deviation of an ordinary endpoint.
    pub weight: f64,
    /// How far a standard deviation of the radius of its circle moves the position where it says that the end is, by that of an
    /// ordinary endpoint in pixels; 0 where the circle is that of the body, and not perhaps of a lid.
    pub widening: f64,
}

/// The samples of any number of ends.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ArcTerm {
    /// The samples by end.
    pub ends: List<List<ArcRay>>,
}

/// Where a ray meets the wall of a rim: position along the axis and outward unit normal; `None` when it misses.
#[must_use]
pub fn on_wall(cylinder: &Cylinder, ray: &Vector3<f64>, rim: Rim) -> Option<(f64, Vector3<f64>)> {
    let hit = match rim {
        Rim::Near => cylinder.first_hit(ray)?,
        Rim::Far => ray * cylinder.intersect_ray(ray)?.1,
    };
    let from_axis = hit - cylinder.axis.point;
    let position = from_axis.dot(&cylinder.axis.direction);
    let normal = (from_axis - cylinder.axis.direction * position) / cylinder.radius;
    Some((position, normal))
}

impl PixelResiduals for ArcTerm {
    /// A sample whose ray misses the cylinder is left out.
    fn pixel_rows(&self, frame: &LocalFrame) -> Option<List<PixelRow>> {
        let mut all = List::new();
        for end in &self.ends {
            let mut rows: List<ArcRow> = end.iter().filter_map(|sample| Self::row(frame, sample)).collect();
            // The position of the end is eliminated: what is left is orthogonal to it.
            subtract(&mut rows, |_| 1.0, |_| 1.0);
            // With u, what one standard deviation of the radius of the circle makes of the weighed residuals, their covariance
            // is I + u uᵀ, whose inverse has the root I − (1 − 1 / √(1 + uᵀu)) u uᵀ / uᵀu.
            subtract(&mut rows, |row| row.widening, |square| 1.0 - 1.0 / (1.0 + square).sqrt());
            all.extend(rows.iter().map(|ArcRow { sample, position, jacobian, .. }| PixelRow {
                weight: sample.weight,
                residual: position * sample.across,
                jacobian: jacobian * sample.across,
                shared: 0.0,
            }));
        }
        Some(all)
    }
}

/// A sample with where it says that the end is, and how that changes with the cylinder and the radius of the end circle.
struct ArcRow {
    sample: ArcRay,
    position: f64,
    jacobian: Tangent,
    widening: f64,
}

/// Takes from all numbers of the rows a part of what lies along a direction, which depends on its square, in pixels.
fn subtract(rows: &mut [ArcRow], direction: impl Fn(&ArcRow) -> f64, part: impl Fn(f64) -> f64) {
    let (mut square, mut position, mut jacobian, mut widening) = (0.0, 0.0, Tangent::zeros(), 0.0);
    for row in &*rows {
        let along = direction(row);
        let w = row.sample.weight * row.sample.across * row.sample.across * along;
        square += w * along;
        position += w * row.position;
        jacobian += row.jacobian * w;
        widening += w * row.widening;
    }
    if !(square > 0.0) {
        return;
    }
    let part = part(square) / square;
    for row in rows {
        let along = part * direction(row);
        row.position -= along * position;
        row.jacobian -= jacobian * along;
        row.widening -= along * widening;
    }
}

impl ArcTerm {
    fn row(frame: &LocalFrame, sample: &ArcRay) -> Option<ArcRow> {
        let LocalFrame { cylinder, u, v, unit } = frame;
        let (position, normal) = on_wall(cylinder, &sample.ray, sample.rim)?;
        let (a, b) = (normal.dot(u), normal.dot(v));
        let lean = cylinder.axis.direction.dot(&sample.ray) / normal.dot(&sample.ray);
        let (t, r) = (position / unit, cylinder.radius / unit);
        let of_tilt = lean * t + r;
        let jacobian = Tangent::new(lean * a, lean * b, of_tilt * a, of_tilt * b, lean) * *unit;
        let row = ArcRow { sample: *sample, position, jacobian, widening: sample.widening };
        row.jacobian.iter().all(|x| x.is_finite()).then_some(row)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::rejection;
    use std::f64::consts::PI;

    fn scene() -> (LocalFrame, ArcTerm) {
        let cylinder =
            Cylinder::new(Vector3::new(0.01, -0.02, 0.7), Vector3::new(0.2, 0.95, 0.15), 0.03).unwrap();
        let frame = LocalFrame::new(&cylinder, &Vector3::new(0.03, 0.06, 0.66), 0.05);
        let facing = -rejection(&cylinder.axis.point, &cylinder.axis.direction).normalize();
        let sideways = cylinder.axis.direction.cross(&facing);
        let sample = |position: f64, k: i32, rim: Rim| {
            let angle = 0.2 * f64::from(k) + if rim == Rim::Far { PI } else { 0.0 };
            let normal = facing * angle.cos() + sideways * angle.sin();
            let ray = cylinder.axis.at(position) + normal * cylinder.radius;
            let widening = if rim == Rim::Far || position > 0.0 { (0.7 * f64::from(k)).sin() } else { 0.0 };
            ArcRay {
                ray,
                rim,
                across: 800.0 + 5.0 * f64::from(k),
                weight: 1.0 + 0.1 * f64::from(k),
                widening,
            }
        };
        let ends = [-0.04, 0.06]
            .map(|position| {
                [Rim::Near, Rim::Far]
                    .iter()
                    .flat_map(|rim| (-5..=5).map(move |k| sample(position, k, *rim)))
                    .collect()
            })
            .into_iter()
            .collect();
        (frame, ArcTerm { ends })
    }

    #[test]
    fn samples_on_two_circles_have_no_residual() {
        let (frame, term) = scene();
        let cost = |frame: &LocalFrame| -> f64 {
            term.pixel_rows(frame).unwrap().iter().map(|row| row.weight * row.residual.powi(2)).sum()
        };
        assert!(cost(&frame) < 1e-20);
        let tilted =
            LocalFrame { cylinder: frame.retract(&Tangent::new(0.0, 0.0, 0.05, 0.05, 0.0)), ..frame };
        assert!(cost(&tilted) > 1.0);
    }

    #[test]
    fn jacobians_agree_with_central_differences() {
        let (frame, term) = scene();
        // Not at the minimum.
        let frame = LocalFrame::new(
            &frame.retract(&Tangent::new(0.01, -0.02, 0.03, 0.02, -0.02)),
            &frame.cylinder.axis.point,
            0.05,
        );
        let rows = term.pixel_rows(&frame).unwrap();
        let h = 1e-6;
        for k in 0..5 {
            let at = |sign: f64| {
                let moved = frame.retract(&Tangent::ith(k, sign * h));
                term.pixel_rows(&LocalFrame { cylinder: moved, ..frame }).unwrap()
            };
            for ((ahead, behind), row) in at(1.0).iter().zip(&at(-1.0)).zip(&rows) {
                let difference = (ahead.residual - behind.residual) / (2.0 * h);
                assert!(
                    (difference - row.jacobian[k]).abs() < 1e-5 * (1.0 + difference.abs()),
                    "{k} {difference} {}",
                    row.jacobian[k]
                );
            }
        }
    }
}
