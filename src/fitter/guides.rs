//! The lines that guide the limbs of the first fit: given segments, sides of the mask, or some of both.

use super::data::ViewData;
use crate::camera::Camera;
use crate::geometry::{Cylinder, across};
use crate::limb_location::{LimbLine, Outline, Side, axial_range};
use crate::memory::List;
use crate::noise::{ImageNoise, MASK_COMMON};
use crate::residuals::PixelSegment;
use nalgebra::{Vector2, Vector3};
use std::f64::consts::SQRT_2;

/// A line is another one than the limb when it is so many standard deviations off: of the lines in reach of the search one
/// in ten is the edge of something else, and beyond two deviations these are the more likely.
pub(super) const BESIDE: f64 = 2.0;

/// The same of where it is and how it is turned together: of two numbers as rare as two deviations of one. Of 1692 located lines 12
/// were beyond it, and 8 of these were something else.
const BESIDE_OR_TURNED: f64 = 2.45;

/// The lines that a fit before the location of the limbs holds them to, numbered by limb.
#[derive(Debug, Clone, Default)]
pub(super) struct Guides {
    /// Segments that were given.
    pub given: List<PixelSegment>,
    /// Sides of the mask.
    pub sides: List<PixelSegment>,
    /// Sides at which something in front ends the mask, something touches the body, or the image ends.
    pub cut: List<PixelSegment>,
    /// The parts of sides beside which the limb is seen, and beyond which of their ends something in front hides it.
    pub seen: List<(PixelSegment, [bool; 2])>,
}

impl Guides {
    /// Given segments alone.
    pub fn given(segments: &[PixelSegment]) -> Self {
        Self { given: List::from(segments), ..Self::default() }
    }

    /// All lines, and how many of them, the first ones, are given segments.
    pub fn all(&self) -> (usize, List<PixelSegment>) {
        (self.given.len(), self.given.iter().chain(&self.sides).copied().collect())
    }

    /// The same where no limb was located.
    pub fn all_growing(&self, growth: f64) -> (usize, List<PixelSegment>) {
        let sides = self.sides.iter().map(|side| PixelSegment { growth, ..*side });
        (self.given.len(), self.given.iter().copied().chain(sides).collect())
    }

    /// Numbers the lines by the limbs of a cylinder: given segments each by the one that they lie on, the two sides of a mask
    /// together, as one that is cut may be as near to the limb of the other.
    pub fn number(&mut self, camera: &Camera, cylinder: &Cylinder) {
        for guide in &mut self.given {
            let Some([first, second]) = apart(camera, cylinder, guide) else { return };
            guide.limb = Some(usize::from(second < first));
        }
        let of_mask = self.sides.iter().chain(&self.cut).chain(self.seen.iter().map(|part| &part.0));
        let of_mask = of_mask.filter_map(|side| Some((side.limb?, apart(camera, cylinder, side)?)));
        let [as_they_are, swapped] = of_mask.fold([0.0; 2], |[as_they_are, swapped], (limb, apart)| {
            [as_they_are + apart[limb], swapped + apart[1 - limb]]
        });
        if swapped < as_they_are {
            let seen = self.seen.iter_mut().map(|part| &mut part.0);
            for side in self.sides.iter_mut().chain(&mut self.cut).chain(seen) {
                side.limb = side.limb.map(|limb| 1 - limb);
            }
        }
    }

    /// The limbs of which nothing is seen: no side of the mask but one that is cut.
    pub fn covered(&self) -> [bool; 2] {
        let on = |lines: &[PixelSegment], limb: usize| lines.iter().any(|line| line.limb == Some(limb));
        [0, 1].map(|limb| on(&self.cut, limb) && !on(&self.sides, limb))
    }

    /// Of a range along the axis of a cylinder, the part along which each limb is seen.
    pub fn seen_of(&self, range: [f64; 2], camera: &Camera, cylinder: &Cylinder) -> [[f64; 2]; 2] {
        let position = |q: &Vector2<f64>| {
            let pixel = camera.project(&camera.ideal_ray(q));
            axial_range(camera, cylinder, pixel.into_iter(), 0.0).map(|[position, _]| position)
        };
        [0, 1].map(|limb| {
            let mut seen = range;
            for (part, hidden) in self.seen.iter().filter(|(part, _)| part.limb == Some(limb)) {
                let [Some(a), Some(b)] = part.endpoints.each_ref().map(position) else { continue };
                for ((end, other), _) in
                    [(a, b), (b, a)].into_iter().zip(hidden).filter(|(_, hidden)| **hidden)
                {
                    let k = usize::from(end > other);
                    seen[k] = if k == 0 { seen[k].max(end) } else { seen[k].min(end) };
                }
            }
            if seen[0] < seen[1] { seen } else { range }
        })
    }

    /// Which of two lines are not the limbs by whose sides of the mask they are: farther off than masks are, and not
    /// because the mask is too large or too small all round, as far as masks are; or, where sides tell something of their own,
    /// turned away from them.
    pub fn beside(&self, lines: [Option<&LimbLine>; 2], sides_tell: bool, noise: &ImageNoise) -> [bool; 2] {
        let side = |limb: usize| self.sides.iter().find(|side| side.limb == Some(limb));
        let growth =
            [0, 1].map(|limb| Some(outside(&lines[limb]?.ends, side(limb)?, &side(1 - limb)?.middle())));
        let turn = [0, 1].map(|limb| {
            let told = side(limb).zip(lines[limb]).filter(|_| sides_tell);
            told.map_or(0.0, |(side, line)| turn(line, side, noise))
        });
        let apart = growth[0].zip(growth[1]).map_or(f64::INFINITY, |(first, second)| (first - second).abs());
        let uneven = BESIDE * noise.unevenness;
        let alike =
            apart <= uneven && growth.iter().flatten().all(|growth| growth.abs() <= noise.growth + uneven);
        [0, 1].map(|limb| {
            let off = growth[limb].filter(|_| !alike).map_or(0.0, |growth| growth.abs() / noise.side);
            off > BESIDE || off.hypot(turn[limb]) > BESIDE_OR_TURNED
        })
    }

    /// The lines of a limb that was not located. Where the other one was, its side of the mask shows by how much the
    /// mask is too large.
    pub fn of_limb(
        &self,
        limb: usize,
        other: Option<&PixelSegment>,
        view: &ViewData<'_>,
    ) -> List<PixelSegment> {
        let side = |limb: usize| self.sides.iter().find(|side| side.limb == Some(limb));
        let given = self.given.iter().filter(|guide| guide.limb == Some(limb));
        let mut lines: List<PixelSegment> = given.copied().collect();
        let Some(own) = side(limb) else { return lines };
        lines.push(match (other, side(1 - limb)) {
            (Some(located), Some(beside)) => {
                let growth = outside(&located.endpoints, beside, &own.middle());
                let growth = growth.clamp(-view.noise.growth, view.noise.growth);
                moved(own, &beside.middle(), growth, &view.noise)
            }
            _ => PixelSegment { growth: view.growth_of_mask(), ..*own },
        });
        lines
    }
}

impl ViewData<'_> {
    /// Standard deviation of what all sides of the mask are off outwards besides, in pixels. Regions of a detection and masks that
    /// end with the depth do so where depth leaves the surface, on either side by itself.
    pub fn growth_of_mask(&self) -> f64 {
        if self.view.mask_is_drawn() { MASK_COMMON.get() * self.noise.side } else { 0.0 }
    }
}

/// Distance of a segment from each limb of a cylinder: the sum over its endpoints, in pixels; `None` where it has no limbs.
fn apart(camera: &Camera, cylinder: &Cylinder, segment: &PixelSegment) -> Option<[f64; 2]> {
    Some(camera.distances_from_limbs(cylinder, &segment.endpoints)?.map(|distances| distances.abs().sum()))
}

/// The segments nearest to the limbs of a cylinder, at most `count`; the first ones where it has no limbs.
pub(super) fn nearest_to_limbs(
    segments: &[PixelSegment],
    camera: &Camera,
    cylinder: &Cylinder,
    count: usize,
) -> List<PixelSegment> {
    let mut nearest = List::from(segments);
    let nearer = |segment: &PixelSegment| {
        apart(camera, cylinder, segment).map_or(0.0, |[first, second]| first.min(second))
    };
    nearest.sort_by(|a, b| nearer(a).total_cmp(&nearer(b)));
    nearest.truncate(count);
    nearest
}

/// Signed distance of a point from a line, positive on the side away from `inner`.
fn outward(line: &[Vector2<f64>; 2], inner: &Vector2<f64>, q: &Vector2<f64>) -> f64 {
    -across(line, inner).signum() * across(line, q)
}

/// How far the middle of a line lies outside of a side of a mask, in pixels. `inner` is a point on the inner side.
pub(super) fn outside(line: &[Vector2<f64>; 2], side: &PixelSegment, inner: &Vector2<f64>) -> f64 {
    let [a, b] = line.map(|q| outward(&side.endpoints, inner, &q));
    f64::midpoint(a, b)
}

/// By how many standard deviations a line is turned against a side of a mask. The ends of both are off independently.
fn turn(line: &LimbLine, side: &PixelSegment, noise: &ImageNoise) -> f64 {
    let [along, of_side] = [&line.ends, &side.endpoints].map(|ends| ends[1] - ends[0]);
    let sine = along.perp(&of_side) / (along.norm() * of_side.norm());
    sine.abs() / (SQRT_2 * (line.sigma / along.norm()).hypot(noise.side / of_side.norm()))
}

/// A side of a mask of known growth, moved away from `inner`.
fn moved(side: &PixelSegment, inner: &Vector2<f64>, by: f64, noise: &ImageNoise) -> PixelSegment {
    let along = (side.endpoints[1] - side.endpoints[0]).normalize();
    let across = Vector2::new(-along.y, along.x);
    let step = across * (by * (side.middle() - inner).dot(&across).signum());
    let weight = (noise.endpoint / noise.unevenness).powi(2);
    PixelSegment { endpoints: side.endpoints.map(|q| q + step), weight, ..*side }
}

/// The two sides of a mask along the axis of a rough fit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sides {
    sides: [Side; 2],
    /// Which of them are where another body has its limb.
    of_others: [bool; 2],
    noise: ImageNoise,
}

/// How given segments lie to the sides of a mask.
#[derive(Debug, Clone)]
pub(super) struct Agreement {
    /// By segment: the side that it goes with.
    pub sides: List<usize>,
    /// By segment: the root mean square distance of its endpoints from that side in pixels, apart from what may be
    /// the growth of the mask all round.
    pub apart: List<f64>,
    /// The root mean square distance of all endpoints, growth included, in pixels.
    pub total: f64,
    /// The largest distance of a segment that agrees with its side.
    limit: f64,
    /// Whether a segment goes with a side that is cut, which says nothing about it.
    untold: bool,
}

impl Agreement {
    /// Whether to believe the segments without more ado: both limbs have one, and all are where the mask is.
    pub fn holds(&self) -> bool {
        // One segment says nothing about the other limb.
        !self.untold
            && self.sides.contains(&0)
            && self.sides.contains(&1)
            && self.apart.iter().all(|&apart| apart <= self.limit)
    }
}

impl Sides {
    /// The sides about a rough fit in a view with these pieces of the limbs of other bodies.
    pub fn new(
        outline: &Outline,
        camera: &Camera,
        rough: &Cylinder,
        others: &[[Vector2<f64>; 2]],
        noise: &ImageNoise,
    ) -> Option<Self> {
        let sides = outline.sides(camera, rough)?;
        let of_others = [0, 1].map(|k| {
            let on_side = |q: &Vector2<f64>| across(&sides[k].ends, q).abs() <= BESIDE * noise.side;
            others.iter().any(|piece| piece.iter().all(on_side))
        });
        Some(Self { sides, of_others, noise: *noise })
    }

    /// The sides that are limbs as segments of little weight.
    pub fn segments(&self) -> List<PixelSegment> {
        self.all(false).collect()
    }

    fn all(&self, cut: bool) -> impl Iterator<Item = PixelSegment> {
        let sides = self.sides.into_iter().zip(self.of_others).enumerate();
        let of_body = sides.filter(move |(_, (side, of_other))| side.cut == cut && !of_other);
        of_body.map(|(k, (side, _))| self.segment(k, side.ends))
    }

    fn segment(&self, side: usize, endpoints: [Vector2<f64>; 2]) -> PixelSegment {
        let weight = (self.noise.endpoint / self.noise.side).powi(2);
        PixelSegment { endpoints, weight, limb: Some(side), growth: 0.0 }
    }

    /// No lines but what is known of the limbs where something in front hides them.
    pub fn hidden(&self) -> Guides {
        let parts = self.sides.iter().enumerate();
        let seen = parts.filter_map(|(k, side)| {
            let (ends, hidden) = side.seen?;
            Some((self.segment(k, ends), hidden))
        });
        let seen = seen.collect();
        Guides { cut: self.all(true).collect(), seen, ..Guides::default() }
    }

    /// The rays through the ends of the sides.
    pub fn rays(&self, camera: &Camera) -> [[Vector3<f64>; 2]; 2] {
        self.sides.map(|side| side.ends.map(|q| camera.ideal_ray(&q)))
    }

    /// The ends of the sides in pixels of the (distorted) image.
    pub fn pixels(&self, camera: &Camera) -> List<Vector2<f64>> {
        self.rays(camera).iter().flatten().filter_map(|ray| camera.project(ray)).collect()
    }

    /// Signed distance of a point from a side, positive outside.
    fn outward(&self, side: usize, q: &Vector2<f64>) -> f64 {
        let other = &self.sides[1 - side].ends;
        outward(&self.sides[side].ends, &((other[0] + other[1]) / 2.0), q)
    }

    /// How segments lie to the sides; `None` for no segments.
    pub fn compare(&self, segments: &[PixelSegment]) -> Option<Agreement> {
        let distances =
            |segment: &PixelSegment, side: usize| segment.endpoints.map(|q| self.outward(side, &q));
        let sum = |distances: &[f64; 2]| distances[0].abs() + distances[1].abs();
        let side =
            |segment: &PixelSegment| usize::from(sum(&distances(segment, 1)) < sum(&distances(segment, 0)));
        let sides: List<usize> = segments.iter().map(side).collect();
        let outward: List<[f64; 2]> =
            segments.iter().zip(&sides).map(|(segment, &side)| distances(segment, side)).collect();
        // A side that is cut says nothing.
        let told = outward.iter().zip(&sides).filter(|&(_, &side)| !self.sides[side].cut);
        let mut all: List<f64> = told.flat_map(|(distances, _)| *distances).collect();
        all.sort_by(f64::total_cmp);
        let middle = all.len() / 2;
        let growth = f64::midpoint(*all.get(middle.checked_sub(1)?)?, all[middle]);
        let growth = growth.clamp(-self.noise.growth, self.noise.growth);
        let total = (all.iter().map(|d| d * d).sum::<f64>() / all.len() as f64).sqrt();
        let apart = |([a, b], &side): (&[f64; 2], &usize)| {
            let told = if self.sides[side].cut { 0.0 } else { 1.0 };
            told * (((a - growth).powi(2) + (b - growth).powi(2)) / 2.0).sqrt()
        };
        let apart = outward.iter().zip(&sides).map(apart).collect();
        let untold = sides.iter().any(|&side| self.sides[side].cut);
        Some(Agreement { apart, sides, total, limit: self.noise.agreement(), untold })
    }

    /// Segments and sides together, each segment weighed by how far it is from its side.
    pub fn with_segments(&self, segments: &[PixelSegment]) -> Guides {
        let mut given = List::from(segments);
        if let Some(agreement) = self.compare(segments) {
            let ImageNoise { endpoint, unevenness, .. } = self.noise;
            let gross = self.noise.gross();
            // One hand sets all segments alike, those apart that are grossly wrong.
            let alike: List<f64> = agreement.apart.iter().copied().filter(|&apart| apart < gross).collect();
            let pooled = alike.iter().map(|apart| apart * apart).sum::<f64>() / alike.len().max(1) as f64;
            for (k, guide) in given.iter_mut().enumerate() {
                let apart = agreement.apart[k];
                let of_both = if apart < gross { pooled } else { apart * apart };
                let variance = of_both - unevenness.powi(2);
                guide.weight *= endpoint.powi(2) / variance.max(endpoint.powi(2));
                guide.limb = Some(agreement.sides[k]);
            }
        }
        Guides { given, sides: self.segments(), ..self.hidden() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Distortion, Intrinsics};
    use crate::noise::NoiseModel;

    fn line(x: f64) -> LimbLine {
        LimbLine { ends: [Vector2::new(x, 100.0), Vector2::new(x, 200.0)], sigma: 0.1 }
    }

    /// Sides of a mask of 40 pixels.
    fn guides() -> Guides {
        let side = |x: f64, limb: usize| PixelSegment {
            endpoints: line(x).ends,
            weight: 1.0,
            limb: Some(limb),
            growth: 0.0,
        };
        Guides { sides: [side(300.0, 0), side(340.0, 1)].into(), ..Guides::default() }
    }

    #[test]
    fn lines_far_from_their_sides_are_others_unless_the_mask_is_too_large_all_round() {
        let noise = NoiseModel::default().in_image((640, 480));
        let guides = guides();
        let beside =
            |first: f64, second: f64| guides.beside([Some(&line(first)), Some(&line(second))], true, &noise);
        assert_eq!(beside(301.0, 338.0), [false, false]);
        assert_eq!(beside(300.0, 345.0), [false, true]);
        assert_eq!(beside(296.0, 340.0), [true, false]);
        assert_eq!(beside(296.0, 344.5), [false, false], "a mask that is four pixels too small all round");
        assert_eq!(beside(294.5, 344.5), [true, true], "no mask is five pixels and more too small all round");
        assert_eq!(guides.beside([None, Some(&line(345.0))], true, &noise), [false, true]);
        assert_eq!(Guides::default().beside([Some(&line(1.0)), None], true, &noise), [false, false]);
    }

    #[test]
    fn lines_that_are_turned_away_from_their_sides_are_others() {
        let noise = NoiseModel::default().in_image((640, 480));
        let beside = |ends: [Vector2<f64>; 2], sigma: f64, sides_tell: bool| {
            guides().beside([Some(&LimbLine { ends, sigma }), None], sides_tell, &noise)[0]
        };
        let ends = |top: f64, bottom: f64| [Vector2::new(top, 100.0), Vector2::new(bottom, 200.0)];
        // The ends of a side are off by 1.6 pixels each, which turns it by 2.3 from end to end.
        assert!(!beside(ends(302.0, 298.0), 0.1, true));
        assert!(beside(ends(303.0, 297.0), 0.1, true));
        assert!(!beside(ends(304.0, 299.0), 0.1, true), "by less, and within the side by one deviation");
        assert!(beside(ends(305.0, 300.0), 0.1, true), "by as much, and farther within");
        assert!(!beside(ends(303.0, 297.0), 0.1, false), "a side that was drawn about a cylinder");
        let short = [Vector2::new(301.0, 140.0), Vector2::new(299.0, 160.0)];
        assert!(!beside(short, 1.0, true), "too short to tell");
    }

    #[test]
    fn a_side_that_is_cut_confirms_no_segment() {
        let noise = NoiseModel::default().in_image((640, 480));
        let line = |x: f64| [Vector2::new(x, 100.0), Vector2::new(x, 200.0)];
        let segment = |x: f64| PixelSegment { endpoints: line(x), weight: 1.0, limb: None, growth: 0.0 };
        let holds = |cut: bool, x: f64| {
            let sides =
                [(300.0, false), (340.0, cut)].map(|(x, cut)| Side { ends: line(x), seen: None, cut });
            Sides { sides, of_others: [false; 2], noise }
                .compare(&[segment(300.0), segment(x)])
                .is_some_and(|told| told.holds())
        };
        assert!(holds(false, 340.5));
        assert!(!holds(false, 346.0));
        assert!(!holds(true, 346.0), "nothing shows where the second limb is");
    }

    #[test]
    fn a_side_at_the_limb_of_another_body_guides_no_limb() {
        let noise = NoiseModel::default().in_image((640, 480));
        let side = |x: f64, cut: bool| Side { ends: line(x).ends, seen: None, cut };
        let of_others = [false, true];
        let guides = Sides { sides: [side(300.0, false), side(340.0, false)], of_others, noise };
        assert_eq!(guides.segments().len(), 1);
        assert_eq!(guides.segments()[0].endpoints[0].x, 300.0);
        // An edge within the region may be the limb all the same.
        let guides = Sides { sides: [side(300.0, false), side(340.0, true)], of_others, noise };
        assert!(guides.hidden().cut.is_empty());
    }

    /// Pipes that lie side by side: something in front cuts one off beyond its axis, as near to one limb as to the other.
    #[test]
    fn a_side_that_is_cut_beyond_the_axis_is_not_that_of_the_limb_which_is_seen() {
        let distortion = Distortion::None;
        let intrinsics =
            Intrinsics { width: 640, height: 480, fx: 500.0, fy: 500.0, cx: 320.0, cy: 240.0, distortion };
        let camera = Camera::new(intrinsics).unwrap();
        let cylinder = Cylinder::new(Vector3::z(), Vector3::y(), 0.04).unwrap();
        let limbs = camera.limb_lines(&cylinder).unwrap().map(|limb| -(limb.y * 150.0 + limb.z) / limb.x);
        for seen in [0, 1] {
            let side = |x: f64, limb: usize| PixelSegment {
                endpoints: line(x).ends,
                weight: 1.0,
                limb: Some(limb),
                growth: 0.0,
            };
            let cut = 0.6 * limbs[seen] + 0.4 * limbs[1 - seen];
            // The sides of a mask come in one order whatever the limbs are.
            for first in [0, 1] {
                let mut guides = Guides {
                    sides: [side(limbs[seen], first)].into(),
                    cut: [side(cut, 1 - first)].into(),
                    ..Guides::default()
                };
                guides.number(&camera, &cylinder);
                assert_eq!(guides.sides[0].limb, Some(seen));
                assert_eq!(guides.covered(), [0, 1].map(|limb| limb != seen));
            }
        }
    }
}
