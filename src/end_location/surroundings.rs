//! What lies beyond an end: its state.

use super::EndState;
use crate::camera::Camera;
use crate::geometry::{Cylinder, any_orthogonal, rejection};
use crate::noise::ImageNoise;
use crate::observations::{DepthImage, Mask, pixel_at};
use nalgebra::{Vector2, Vector3};
use smallvec::SmallVec;

constants! {
    /// Lines along the surface on which the surroundings of an end are looked at.
    GENERATORS = 15.0, "";

    /// The part of the visible arc that these lines cover: near the limbs depth is worst.
    ARC_PART = 0.7, "";

    /// The part of these lines that tell what an end is where the border of the image cuts off the others.
    INSIDE_PART = 0.2, "";
}

/// What is looked at beyond an end.
#[derive(Clone, Copy)]
pub(super) struct Surroundings<'a> {
    pub camera: &'a Camera,
    pub mask: &'a Mask,
    pub depth: Option<&'a DepthImage>,
    pub cylinder: &'a Cylinder,
    /// Depth differences up to this are noise.
    pub tolerance: f64,
    pub noise: ImageNoise,
    /// Whether the mask was drawn in the image, and not made of the depth, of which sensors measure none beside the border.
    pub drawn: bool,
}

/// How often the positions beyond an end told each state.
#[derive(Debug, Clone, Copy, Default)]
struct Votes {
    cut: usize,
    hidden: usize,
    seen: usize,
    unknown: usize,
}

/// What lies beyond one point of an end circle.
struct Beyond {
    votes: Votes,
    /// Whether the mask holds any of it: there the surface goes on.
    in_mask: bool,
    border: Border,
}

/// Where the border of the image is beyond an end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Border {
    /// Beyond all that is looked at.
    Far,
    /// Nearer.
    Near,
    /// At the end, up to half of what a mask may be off by.
    Reached,
}

impl Votes {
    fn add(&mut self, other: &Self) {
        self.cut += other.cut;
        self.hidden += other.hidden;
        self.seen += other.seen;
        self.unknown += other.unknown;
    }

    /// Those inside the image; `None` where there are none.
    fn inside(self) -> Option<Self> {
        (self.hidden + self.seen + self.unknown > 0).then_some(Self { cut: 0, ..self })
    }

    fn state(&self) -> EndState {
        let Self { cut, hidden, seen, unknown } = *self;
        let most = cut.max(hidden).max(seen).max(unknown);
        match most {
            0 => EndState::Unknown,
            _ if most == cut => EndState::Cut,
            _ if most == seen => EndState::Seen,
            _ if most == hidden => EndState::Hidden,
            _ => EndState::Unknown,
        }
    }
}

impl Surroundings<'_> {
    /// Continues the surface beyond a position along the axis in the direction `outward` (± 1 along the axis
    /// direction) and lets what is seen there vote.
    pub fn state(&self, position: f64, outward: f64) -> EndState {
        let mut votes = Votes::default();
        for rim in self.rim(position) {
            votes.add(&self.look(&rim, outward).votes);
        }
        votes.state()
    }

    /// The same by the lines alone on which the surface ends inside the image, where the border may cut off the others; `None` where
    /// there are few, and for a mask that was made of the depth.
    pub fn state_inside(&self, position: f64, outward: f64) -> Option<EndState> {
        if !self.drawn {
            return None;
        }
        let (mut votes, mut lines) = (Votes::default(), 0);
        for rim in self.rim(position) {
            let beyond = self.look(&rim, outward);
            if let Some(inside) = beyond.votes.inside().filter(|_| !beyond.in_mask) {
                votes.add(&inside);
                lines += 1;
            }
        }
        (f64::from(lines) >= INSIDE_PART.get() * GENERATORS.get()).then(|| votes.state())
    }

    /// The same for one point of an end circle, by what lies inside the image for a mask that was drawn, and where the border is.
    pub fn state_on(&self, rim: &Vector3<f64>, outward: f64) -> (EndState, Border) {
        let Beyond { votes, border, .. } = self.look(rim, outward);
        (votes.inside().filter(|_| self.drawn).unwrap_or(votes).state(), border)
    }

    /// Whether the depth at a pixel is that of the cap or the inner wall at an end towards `outward`.
    pub fn shows_inside(&self, pixel: &Vector2<f64>, end: f64, outward: f64) -> bool {
        let point = self.depth.zip(pixel_at(pixel)).and_then(|(depth, (column, row))| {
            Some(self.camera.ray_of_pixel(column, row)? * depth.depth(column, row)?)
        });
        point.is_some_and(|point| {
            let axis = &self.cylinder.axis;
            let beyond = outward * (axis.position_of(&point) - end);
            self.cylinder.distance(&point) <= self.tolerance && beyond <= self.tolerance
        })
    }

    /// Looks beyond one point of an end circle.
    fn look(&self, rim: &Vector3<f64>, outward: f64) -> Beyond {
        let (mut votes, mut in_mask) = (Votes::default(), false);
        let outward = self.cylinder.axis.direction * outward;
        // Length along the axis of one pixel, by a step of 1 % of the radius.
        let step = 0.01 * self.cylinder.radius;
        let pixels = [*rim, rim + outward * step].map(|point| self.camera.project(&point));
        let [Some(at_rim), Some(ahead)] = pixels else {
            return Beyond { votes: Votes { cut: 1, ..votes }, in_mask, border: Border::Near };
        };
        let pixel = step / (ahead - at_rim).norm().max(1e-6);
        let seen_at = |beyond: f64| {
            let point = rim + outward * (pixel * beyond);
            let at = self.camera.project(&point).filter(|at| self.camera.contains(at));
            (point, at)
        };
        // (pixels beyond the end, depth measured there less that of the continued surface)
        let distances = self.noise.beyond();
        let mut steps: SmallVec<[(f64, f64); 4]> = SmallVec::new();
        let mut goes_on = true;
        for beyond in distances {
            let (point, Some(at)) = seen_at(beyond) else {
                votes.cut += 1;
                continue;
            };
            let Some((column, row)) = pixel_at(&at) else { continue };
            if self.mask.contains(column, row) {
                in_mask = true;
                continue;
            }
            match self.depth.and_then(|depth| depth.depth(column, row)) {
                None => votes.unknown += 1,
                Some(z) => {
                    steps.push((beyond, z - point.z));
                    let surface = || self.cylinder.first_hit(&self.camera.ray_of_pixel(column, row)?);
                    goes_on = goes_on && surface().is_some_and(|point| (z - point.z).abs() <= self.tolerance);
                }
            }
        }
        if step_at_end(&steps) < -self.tolerance {
            votes.hidden += steps.len();
        } else if goes_on {
            // The mask ends before the surface does.
            votes.unknown += steps.len();
        } else {
            votes.seen += steps.len();
        }
        let border = match votes.cut {
            0 => Border::Far,
            _ if seen_at(0.5 * distances[0]).1.is_some() => Border::Near,
            _ => Border::Reached,
        };
        Beyond { votes, in_mask, border }
    }

    /// Points of the visible arc of the surface around the axis point at a position.
    fn rim(&self, position: f64) -> impl Iterator<Item = Vector3<f64>> {
        let Cylinder { axis, radius } = *self.cylinder;
        let end = axis.at(position);
        let across = rejection(&end, &axis.direction);
        let distance = across.norm();
        let inside = self.cylinder.contains_origin();
        let facing = if distance > 0.0 { -across / distance } else { any_orthogonal(&axis.direction).0 };
        let sideways = axis.direction.cross(&facing);
        // From outside the surface is visible up to the limbs, at acos(r / ‖c‖) from the line of sight; from
        // inside all of it.
        let half_arc =
            if inside { std::f64::consts::PI } else { (radius / distance).acos() } * ARC_PART.get();
        (0..GENERATORS.count()).map(move |k| {
            let angle = half_arc * (2.0 * k as f64 / (GENERATORS.count() - 1) as f64 - 1.0);
            end + (facing * angle.cos() + sideways * angle.sin()) * radius
        })
    }
}

/// The step of the depth at the end, from the steps seen at some distances beyond it: a line through them at
/// distance 0. A table that the cylinder stands on comes nearer than the continued surface too, but from no step
/// at the end; what covers the cylinder begins with one. Where the line would turn the sign of what is seen there
/// is no step.
fn step_at_end(steps: &[(f64, f64)]) -> f64 {
    let n = steps.len().max(1) as f64;
    let mean = steps.iter().fold((0.0, 0.0), |sum, step| (sum.0 + step.0 / n, sum.1 + step.1 / n));
    let (mut xx, mut xy) = (0.0, 0.0);
    for step in steps {
        xx += (step.0 - mean.0).powi(2);
        xy += (step.0 - mean.0) * (step.1 - mean.1);
    }
    let slope = if xx > 0.0 { xy / xx } else { 0.0 };
    let step = mean.1 - slope * mean.0;
    if step * mean.1 < 0.0 { 0.0 } else { step }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_hides_and_a_table_does_not() {
        let occluder = [(4.0, -0.05), (6.0, -0.052), (8.0, -0.054), (10.0, -0.056)];
        assert!((step_at_end(&occluder) + 0.046).abs() < 1e-12);
        let table = [(4.0, -0.008), (6.0, -0.012), (8.0, -0.016), (10.0, -0.020)];
        assert!(step_at_end(&table).abs() < 1e-12);
        // The table begins a little beyond the end: no step the other way.
        let later = [(4.0, -0.004), (6.0, -0.012), (10.0, -0.028)];
        assert_eq!(step_at_end(&later), 0.0);
        assert_eq!(step_at_end(&[(4.0, -0.05)]), -0.05);
        assert_eq!(step_at_end(&[]), 0.0);
    }
}
