//! Depth that lies pixels beside the image, as sensors whose registration is a little off deliver it: the limbs of the bodies
//! that the depth shows all have their edges at the same distance, to the same side.

use super::candidate::{Candidate, Marks, Scene, Sides};
use super::limb_pairs::{ImageEdges, Limb, part};
use super::search::Judged;
use super::surface::Surface;
use crate::geometry::Cylinder;
use nalgebra::Vector2;

/// Positions are looked at in steps of this many pixels.
const STEP: f64 = 0.5;

/// Largest shift along columns and along rows that is looked for, in steps.
const FARTHEST: i32 = 12;

/// The largest shift across an axis, aslant, in steps.
const MOST_ACROSS: i32 = 17;

/// By how many steps depth may be drawn out at the limbs of a body.
const DRAWN_OUT: std::ops::RangeInclusive<i32> = -2..=8;

/// Steps from a limb to the edges that are looked at: the largest shift aslant, and depth that is drawn out.
const REACH: i32 = 26;

constants! {
    /// An edge counts so many pixels to both sides of it.
    BESIDE_EDGE = 0.8, "px";

    /// How far an edge may turn from a limb, in pixels from one end to the other.
    TURN = 2.0, "px";

    /// What a limb that is covered whole counts less for each pixel of a shift: of two that explain as much the smaller one is meant.
    PRICE = 0.03, "limb/px";

    /// The least shift in pixels that matters: limbs are found beside depth that lies a pixel beside them.
    LEAST = 1.5, "px";

    /// By how much of both limbs, and how many times, edges must cover more of them where the depth would be moved to than where it
    /// is. Another search in the moved depth decides.
    LEAST_GAIN = 0.3, "limb";
    LEAST_RATIO = 1.2, "";

    /// Cylinders with less than this score tell nothing of a shift.
    TELLING = 0.2, "";
}

/// Which parts of a limb edges cover, by their distance from it in steps.
struct Profile([u32; 2 * REACH as usize + 1]);

impl Profile {
    /// The part that edges cover at a distance.
    fn covered(&self, steps: i32) -> f64 {
        part(self.0[(steps + REACH) as usize])
    }
}

/// What edges of the image cover of the limbs of a cylinder that the depth shows, were it moved.
struct Coverage {
    /// The direction across the axis in the image.
    across: Vector2<f64>,
    /// The part of both limbs together that edges cover, by the shift across the axis in steps from −[`MOST_ACROSS`] on.
    covered: Vec<f64>,
    /// How certain it is that there is a cylinder.
    weight: f64,
}

impl Coverage {
    fn new(edges: &ImageEdges, cylinder: &Cylinder, range: [f64; 2], weight: f64) -> Option<Self> {
        let [a, b] = edges.limbs(cylinder, range)?;
        let across = a.across;
        let profile = |limb: &Limb| {
            let mut pieces = [0_u32; 2 * REACH as usize + 1];
            for edge in &edges.edges {
                let [first, last] = edge.ends.map(|p| (p - limb.start).dot(&limb.across) / edges.pixel);
                let position = 0.5 * (first + last) / STEP;
                if (first - last).abs() > TURN.get() || position.abs() > f64::from(REACH) {
                    continue;
                }
                let Some(bits) = limb.pieces(edge) else { continue };
                let half = BESIDE_EDGE.get() / STEP;
                for steps in (position - half).ceil() as i32..=(position + half).floor() as i32 {
                    if let Some(pieces) = pieces.get_mut((steps + REACH) as usize) {
                        *pieces |= bits;
                    }
                }
            }
            Profile(pieces)
        };
        let [first, second] = [profile(&a), profile(&b)];
        // The true limbs lie between those of depth that is drawn out. Both tell: an edge along one may be anything.
        let inward = if (b.start - a.start).dot(&across) > 0.0 { 1 } else { -1 };
        let covered = |shift: i32| {
            let both = |out: i32| {
                2.0 * first.covered(shift + inward * out).min(second.covered(shift - inward * out))
            };
            DRAWN_OUT.map(both).fold(0.0, f64::max)
        };
        Some(Self { across, covered: (-MOST_ACROSS..=MOST_ACROSS).map(covered).collect(), weight })
    }

    fn at(&self, shift: [i32; 2]) -> f64 {
        let across = self.across.dot(&Vector2::from(shift.map(f64::from))).round() as i32;
        self.weight * self.covered[(across + MOST_ACROSS) as usize]
    }
}

impl Scene<'_> {
    /// The pixels along columns and rows by which the depth would have to be moved to lie where the image shows the same bodies;
    /// `None` where it does, or nothing tells.
    pub fn shift(&self, found: &[Judged], marks: &mut Marks) -> Option<[i32; 2]> {
        let (edges, _) = self.image?;
        // Where the depth shows the limbs, whatever edges led to a cylinder.
        let by_depth = |judged: &Judged, marks: &mut Marks| {
            let Candidate { surface, cells, .. } = &judged.candidate;
            let surface = self.refit(surface, cells, Sides::Outline, marks)?;
            let Surface::Cylinder(cylinder, _) = surface else { return None };
            self.effort.spend(edges.edges.len());
            Coverage::new(edges, &cylinder, self.range(&cylinder, cells), judged.score)
        };
        let telling = found.iter().filter(|judged| judged.score >= TELLING.get());
        let coverages: Vec<_> = telling.filter_map(|judged| by_depth(judged, marks)).collect();
        let weight: f64 = coverages.iter().map(|coverage| coverage.weight).sum();
        let covered = |shift: [i32; 2]| coverages.iter().map(|coverage| coverage.at(shift)).sum::<f64>();
        let pixels = |[x, y]: [i32; 2]| STEP * f64::from(x).hypot(f64::from(y));
        let mut best = ([0; 2], f64::NEG_INFINITY);
        for x in -FARTHEST..=FARTHEST {
            for y in -FARTHEST..=FARTHEST {
                let worth = covered([x, y]) - PRICE.get() * weight * pixels([x, y]);
                if worth > best.1 {
                    best = ([x, y], worth);
                }
            }
        }
        let (here, there) = (covered([0; 2]), covered(best.0));
        let tells = there - here > LEAST_GAIN.get() * weight && there > LEAST_RATIO.get() * here;
        (pixels(best.0) >= LEAST.get() && tells)
            .then(|| best.0.map(|steps| (STEP * f64::from(steps)).round() as i32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detection::edges::Edge;
    use nalgebra::Vector3;

    /// Depth that windows draw out by 6 pixels has one limb where the image shows it when it is moved by 2 to either side, as far as the
    /// other one may be drawn out.
    #[test]
    fn a_body_tells_by_both_its_limbs() {
        let pixel = 1.0 / 570.0;
        let body = Cylinder::new(Vector3::new(0.0, 0.0, 1.0), Vector3::x(), 0.05).unwrap();
        let none = ImageEdges::new(Vec::new(), pixel);
        let limbs = none.limbs(&body, [-0.2, 0.2]).unwrap();
        let inward = (limbs[1].start - limbs[0].start).dot(&limbs[0].across).signum();
        let edge = |limb: &Limb, out: f64| {
            let start = limb.start + limb.across * (out * pixel);
            Edge { ends: [start, start + Vector2::new(limb.across.y, -limb.across.x) * 0.4] }
        };
        let covered = |out: f64, shift: i32| {
            let edges = vec![edge(&limbs[0], inward * out), edge(&limbs[1], -inward * out)];
            let coverage = Coverage::new(&ImageEdges::new(edges, pixel), &body, [-0.2, 0.2], 1.0).unwrap();
            coverage.covered[(shift + MOST_ACROSS) as usize]
        };
        assert_eq!([covered(3.0, 0), covered(6.0, 4), covered(6.0, -4)], [2.0, 0.0, 0.0]);
    }
}
