//! The pixel distance of segment endpoints from the projected limb lines.
//!
//! With the limb plane normal m_j = −cos γ ŝ + σ_j sin γ ĉ (up to the scale, the moment (13)) and
//! l_j = K_L m_j (9), the residual of an endpoint q̃ is l_j · q̃ / ‖(l_j₁, l_j₂)‖.

use super::limbs::{AxisMotion, LimbRow};
use super::pixel_terms::{PixelResiduals, PixelRow};
use crate::geometry::{Cylinder, LimbFrame, LocalFrame, Tangent};
use crate::memory::List;
use nalgebra::{Matrix3, SMatrix, Vector2, Vector3};

/// One observed segment in ideal pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelSegment {
    /// The endpoints.
    pub endpoints: [Vector2<f64>; 2],
    /// How much it counts, 1 for an ordinary segment.
    pub weight: f64,
    /// Segments with the same number, 0 or 1, lie on the same limb, those with different numbers on different
    /// limbs; `None`: on either.
    pub limb: Option<usize>,
    /// The standard deviation of an error outwards that it shares with all others that have one, in pixels: the growth of
    /// a mask.
    pub growth: f64,
}

impl PixelSegment {
    /// The middle of the endpoints.
    #[must_use]
    pub fn middle(&self) -> Vector2<f64> {
        (self.endpoints[0] + self.endpoints[1]) / 2.0
    }
}

/// Any number of segments, each belonging to one of the limbs.
#[derive(Debug, Clone, PartialEq)]
pub struct PixelTerm {
    segments: List<PixelSegment>,
    line_projection: Matrix3<f64>,
}

/// A limb line in the image and its derivative in the tangent of the frame.
struct LimbLine {
    line: Vector3<f64>,
    derivative: SMatrix<f64, 3, 5>,
}

impl LimbLine {
    /// The signed distance of a pixel and its derivative.
    fn distance(&self, q: &Vector2<f64>) -> LimbRow {
        let q = q.push(1.0);
        let normal = self.line.xy();
        let norm = normal.norm();
        let distance = self.line.dot(&q) / norm;
        let unit = normal / norm;
        let of_product = self.derivative.transpose() * q;
        let of_norm = self.derivative.fixed_rows::<2>(0).transpose() * unit;
        (distance, (of_product - of_norm * distance) / norm)
    }
}

impl PixelResiduals for PixelTerm {
    /// `None` where there are no limbs.
    fn pixel_rows(&self, frame: &LocalFrame) -> Option<List<PixelRow>> {
        let rows = self.rows(frame)?;
        let weighted = |(segment, rows): (&PixelSegment, &[LimbRow; 2])| {
            let PixelSegment { weight, growth, .. } = *segment;
            // A limb moves outwards as the radius grows, and an endpoint that does has the other sign.
            rows.map(|(residual, jacobian)| PixelRow {
                weight,
                residual,
                jacobian,
                shared: -growth * jacobian[4].signum(),
            })
        };
        Some(self.segments.iter().zip(&rows).flat_map(weighted).collect())
    }
}

impl PixelTerm {
    /// The term of segments seen by a camera with the line projection K_L (10).
    #[must_use]
    pub fn new(segments: impl IntoIterator<Item = PixelSegment>, line_projection: Matrix3<f64>) -> Self {
        Self { segments: segments.into_iter().collect(), line_projection }
    }

    /// Signed pixel distances of the endpoints from the limb lines, by segment; `None` where there are no limbs.
    #[must_use]
    pub fn distances(&self, cylinder: &Cylinder) -> Option<List<[f64; 2]>> {
        let frame = LocalFrame::new(cylinder, &cylinder.axis.point, 1.0);
        Some(self.rows(&frame)?.iter().map(|rows| rows.map(|(distance, _)| distance)).collect())
    }

    /// The weighted mean of the squares of these distances, in square pixels.
    #[must_use]
    pub fn mean_square(&self, cylinder: &Cylinder) -> Option<f64> {
        let distances = self.distances(cylinder)?;
        let squares = self.segments.iter().zip(&distances);
        let sum: f64 = squares.map(|(segment, [a, b])| segment.weight * (a * a + b * b)).sum();
        Some(sum / (2 * self.segments.len()) as f64)
    }

    fn rows(&self, frame: &LocalFrame) -> Option<List<[LimbRow; 2]>> {
        let limbs = LimbFrame::new(&frame.cylinder)?;
        let lines = self.limb_lines(frame, &limbs);
        let row = |segment: &PixelSegment, limb: usize| segment.endpoints.map(|q| lines[limb].distance(&q));
        let sum = |rows: &[LimbRow; 2]| rows[0].0.abs() + rows[1].0.abs();
        let both: List<[[LimbRow; 2]; 2]> =
            self.segments.iter().map(|segment| [row(segment, 0), row(segment, 1)]).collect();
        // The smaller sum of distances tells which number goes with which limb (17)–(20). A segment without a
        // number goes with the nearer limb.
        let numbered =
            || self.segments.iter().zip(&both).filter_map(|(segment, rows)| Some((segment.limb?, rows)));
        let direct: f64 = numbered().map(|(limb, rows)| sum(&rows[limb])).sum();
        let swapped: f64 = numbered().map(|(limb, rows)| sum(&rows[1 - limb])).sum();
        let turn = usize::from(swapped < direct);
        let chosen = |(segment, rows): (&PixelSegment, &[[LimbRow; 2]; 2])| {
            rows[segment.limb.map_or(usize::from(sum(&rows[1]) < sum(&rows[0])), |limb| limb ^ turn)]
        };
        Some(self.segments.iter().zip(&both).map(chosen).collect())
    }

    fn limb_lines(&self, frame: &LocalFrame, limbs: &LimbFrame) -> [LimbLine; 2] {
        let motion = AxisMotion::new(frame, limbs);
        let LimbFrame { toward, sideways, direction, distance, sin_gamma, cos_gamma } = *limbs;
        let in_units = distance / frame.unit;
        // δγ from sin γ = r / ‖c‖.
        let radius = Tangent::ith(4, 1.0);
        let delta_gamma = (radius - motion.toward * sin_gamma) / (in_units * cos_gamma);
        // δĉ = (ŝ·δc / ‖c‖) ŝ − (ĉ·δd) d̂ and δŝ = −(ŝ·δc / ‖c‖) ĉ − (ŝ·δd) d̂.
        let turn = motion.sideways / in_units;
        let delta_toward = sideways * turn.transpose() - direction * motion.tilt_toward.transpose();
        let delta_sideways = -toward * turn.transpose() - direction * motion.tilt_sideways.transpose();
        [1.0, -1.0].map(|side| {
            let moment = toward * (side * sin_gamma) - sideways * cos_gamma;
            let along_gamma = (toward * (side * cos_gamma) + sideways * sin_gamma) * delta_gamma.transpose();
            let delta = along_gamma + delta_toward * (side * sin_gamma) - delta_sideways * cos_gamma;
            LimbLine { line: self.line_projection * moment, derivative: self.line_projection * delta }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene() -> (LocalFrame, PixelTerm) {
        let cylinder =
            Cylinder::new(Vector3::new(0.01, -0.02, 0.7), Vector3::new(0.2, 0.95, 0.15), 0.03).unwrap();
        let frame = LocalFrame::new(&cylinder, &Vector3::new(0.03, 0.06, 0.66), 0.05);
        let (fx, fy, cx, cy) = (570.0, 560.0, 319.5, 239.5);
        let projection = Matrix3::new(fy, 0.0, 0.0, 0.0, fx, 0.0, -fy * cx, -fx * cy, fx * fy);
        let segment = |a: [f64; 2], b: [f64; 2]| PixelSegment {
            endpoints: [Vector2::from(a), Vector2::from(b)],
            weight: 1.0,
            limb: None,
            growth: 0.0,
        };
        let segments = vec![
            segment([287.5, 212.5], [303.9, 287.9]),
            segment([350.9, 204.9], [372.0, 282.8]),
            segment([354.0, 220.0], [360.0, 240.0]),
        ];
        (frame, PixelTerm::new(segments, projection))
    }

    #[test]
    fn distances_are_those_of_the_projected_limb_lines() {
        let (frame, term) = scene();
        let limbs = LimbFrame::new(&frame.cylinder).unwrap();
        let lines = limbs.limb_plane_normals().map(|moment| term.line_projection * moment);
        for (segment, distances) in term.segments.iter().zip(&term.distances(&frame.cylinder).unwrap()) {
            let to = |line: &Vector3<f64>| {
                segment.endpoints.map(|q| (line.dot(&q.push(1.0)) / line.x.hypot(line.y)).abs())
            };
            let nearest = if to(&lines[0])[0] < to(&lines[1])[0] { to(&lines[0]) } else { to(&lines[1]) };
            for k in 0..2 {
                assert!((distances[k].abs() - nearest[k]).abs() < 1e-10);
            }
        }
    }

    #[test]
    fn the_mean_square_is_that_of_the_weighted_distances() {
        let (frame, mut term) = scene();
        term.segments[1].weight = 0.25;
        let distances = term.distances(&frame.cylinder).unwrap();
        let square = |k: usize| distances[k][0].powi(2) + distances[k][1].powi(2);
        let expected = (square(0) + 0.25 * square(1) + square(2)) / 6.0;
        assert!((term.mean_square(&frame.cylinder).unwrap() - expected).abs() < 1e-12 * expected);
    }

    #[test]
    fn segments_with_numbers_go_with_limbs_together() {
        let (frame, mut term) = scene();
        let nearest = term.distances(&frame.cylinder).unwrap();
        let limbs = |term: &mut PixelTerm, numbers: [Option<usize>; 3]| {
            for (segment, number) in term.segments.iter_mut().zip(numbers) {
                segment.limb = number;
            }
            term.distances(&frame.cylinder).unwrap()
        };
        // The first lies on one limb, the others on the other: the order of the numbers does not matter.
        assert_eq!(limbs(&mut term, [Some(0), Some(1), Some(1)]), nearest);
        assert_eq!(limbs(&mut term, [Some(1), Some(0), None]), nearest);
        // On different limbs against all appearance: one of the two goes with the far one.
        let forced = limbs(&mut term, [None, Some(0), Some(1)]);
        assert_eq!(forced[0], nearest[0]);
        let moved: Vec<usize> = (1..3).filter(|&k| forced[k] != nearest[k]).collect();
        assert_eq!(moved.len(), 1);
        assert!(forced[moved[0]][0].abs() > 10.0 + nearest[moved[0]][0].abs());
    }

    #[test]
    fn jacobians_agree_with_central_differences() {
        let (frame, term) = scene();
        let rows = term.rows(&frame).unwrap();
        let h = 1e-6;
        for k in 0..5 {
            let at = |sign: f64| {
                let moved = frame.retract(&Tangent::ith(k, sign * h));
                term.rows(&LocalFrame { cylinder: moved, ..frame }).unwrap()
            };
            let (ahead, behind) = (at(1.0), at(-1.0));
            for (segment, row) in rows.iter().enumerate() {
                for end in 0..2 {
                    let difference = (ahead[segment][end].0 - behind[segment][end].0) / (2.0 * h);
                    assert!((difference - row[end].1[k]).abs() < 1e-5, "{k} {difference} {}", row[end].1[k]);
                }
            }
        }
    }
}
