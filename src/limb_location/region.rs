//! Where to search: the range along the axis and the expected limbs, from a region or from segments. Never where
//! the limbs are.

use super::contact::Beyond;
use crate::camera::Camera;
use crate::geometry::{Cylinder, Line, rejection};
use crate::memory::List;
use crate::noise::ImageNoise;
use crate::observations::{DepthImage, Mask, pixel_at};
use crate::statistics::{at_both_ends, median, min_max_of};
use nalgebra::Vector2;
use smallvec::SmallVec;

constants! {
    /// The part of the length of the region, at either end, that is left out: rims and ragged ends.
    MARGIN = 0.15, "";

    /// Fewest positions along the axis that a side is drawn through.
    LEAST_POSITIONS = 8.0, "px";

    /// What is nearer than the surface by this part of its depth lies in front of it: several times the noise of depth
    /// cameras.
    pub(super) NEARER = 0.005, "";

    /// A side is drawn again through the positions within this many median distances, so that a piece that an
    /// occluder cuts off does not turn it.
    MEDIANS = 3.0, "";

    /// A region that ends so many deviations of the unevenness of a side within the limb does not end there with it.
    WITHIN = 2.0, "σ";
}

/// At how many positions beyond the edge of a mask, and within it, depths are compared.
const COMPARED: usize = 3;

/// The positions along the axis, measured from its point, that pixels of the (distorted) image reach on the
/// cylinder: endpoints of segments, or the pixels of a mask. Pixels beside the cylinder count at the point of
/// their ray nearest to it. The part `trim` of the pixels at either end is left out, against ragged masks. `None`
/// when no pixel has a ray.
#[must_use]
pub fn axial_range(
    camera: &Camera,
    cylinder: &Cylinder,
    pixels: impl Iterator<Item = Vector2<f64>>,
    trim: f64,
) -> Option<[f64; 2]> {
    let axis = &cylinder.axis;
    let center = axis.nearest_to_origin();
    let position = |pixel: Vector2<f64>| {
        let ray = camera.unproject(&pixel)?;
        let hit = cylinder.first_hit(&ray).unwrap_or_else(|| {
            let across = rejection(&ray, &axis.direction);
            ray * (center.dot(&across) / across.norm_squared())
        });
        Some(axis.position_of(&hit)).filter(|position| position.is_finite())
    };
    let positions: List<f64> = pixels.filter_map(position).collect();
    if positions.is_empty() {
        return None;
    }
    let out = ((trim * positions.len() as f64) as usize).min((positions.len() - 1) / 2);
    Some(at_both_ends(&positions, out))
}

/// The outline of a region in ideal pixels, from which its sides are drawn.
#[derive(Debug, Clone)]
pub struct Outline<'a> {
    mask: &'a Mask,
    depth: Option<&'a DepthImage>,
    pixels: List<OutlinePixel>,
    center: Vector2<f64>,
    noise: ImageNoise,
}

#[derive(Debug, Clone, Copy)]
struct OutlinePixel {
    position: Vector2<f64>,
    /// Column and row.
    at: (usize, usize),
}

/// One side of a region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Side {
    /// Its ends in ideal pixels.
    pub ends: [Vector2<f64>; 2],
    /// Where something in front hides a part of the limb: the ends of the longest part that is seen, and beyond which of them it
    /// is hidden.
    pub seen: Option<([Vector2<f64>; 2], [bool; 2])>,
    /// Whether it is the border of the image, that of something in front of the cylinder, or where something touches it, rather
    /// than a limb.
    pub cut: bool,
}

impl<'a> Outline<'a> {
    /// The outline of a mask; a depth image on the same grid tells where something in front ends it. `None` when no
    /// pixel of it has a ray.
    #[must_use]
    pub fn new(
        mask: &'a Mask,
        depth: Option<&'a DepthImage>,
        camera: &Camera,
        noise: &ImageNoise,
    ) -> Option<Self> {
        let pixel = |at: (usize, usize)| {
            let ray = camera.ray_of_pixel(at.0, at.1)?;
            Some(OutlinePixel { position: camera.ideal_pixel(&ray)?, at })
        };
        let pixels: List<OutlinePixel> = mask.outline().iter().copied().filter_map(pixel).collect();
        let center = pixels.iter().map(|pixel| pixel.position).sum::<Vector2<f64>>() / pixels.len() as f64;
        (!pixels.is_empty()).then_some(Self { mask, depth, pixels, center, noise: *noise })
    }

    /// Whether the region ends at a pixel for another reason than the limb: the image ends, or something in front covers
    /// the rest.
    fn is_cut(&self, (x, y): (usize, usize)) -> bool {
        let at_border = x == 0 || y == 0 || x == self.mask.width() - 1 || y == self.mask.height() - 1;
        at_border || self.depth.is_some_and(|depth| covered(self.mask, depth, (x, y), &self.noise))
    }

    /// The two sides along the axis of a rough cylinder: a start for the search and for a fit, within some pixels of
    /// the limbs where the mask is. Only the directions of axis and limbs in the image are taken from the cylinder. `None`
    /// when the axis cannot be seen or the region is too small.
    #[must_use]
    pub fn sides(&self, camera: &Camera, rough: &Cylinder) -> Option<[Side; 2]> {
        let center = self.center;
        let along = self.axis_in_image(camera, &rough.axis)?;
        let normal = Vector2::new(-along.y, along.x);
        let coordinates = |pixel: &OutlinePixel| {
            let from_center = pixel.position - center;
            (from_center.dot(&along), from_center.dot(&normal))
        };
        let [low, high] = self.between_ends(&along);
        let count = (high - low).floor();
        if count.is_nan() || count < LEAST_POSITIONS.count() as f64 {
            return None;
        }
        // By position along the axis and side: the outermost pixel.
        let mut extremes =
            List::filled([(f64::INFINITY, (0, 0)), (f64::NEG_INFINITY, (0, 0))], count as usize);
        for pixel in &self.pixels {
            let (s, u) = coordinates(pixel);
            let Some([first, second]) = (s >= low).then(|| extremes.get_mut((s - low) as usize)).flatten()
            else {
                continue;
            };
            if u < first.0 {
                *first = (u, pixel.at);
            }
            if u > second.0 {
                *second = (u, pixel.at);
            }
        }
        let limbs = camera.limb_lines(rough).ok();
        let side = |k: usize| {
            let positions = extremes.iter().enumerate().filter(|(_, extreme)| extreme[0].0 < extreme[1].0);
            let all: List<(f64, f64, bool)> = positions
                .map(|(i, extreme)| (low + i as f64 + 0.5, extreme[k].0, self.is_cut(extreme[k].1)))
                .collect();
            let whole: List<(f64, f64)> =
                all.iter().filter(|position| !position.2).map(|&(s, u, _)| (s, u)).collect();
            // The raster of the mask.
            let least = 0.5 * self.noise.pixel;
            let anyway = || robust_line(all.iter().map(|&(s, u, _)| (s, u)).collect(), least);
            let (line, cut) = match robust_line(whole.clone(), least) {
                Some(line) => (line, false),
                None => (anyway()?, true),
            };
            let ends = line.range.map(|s| center + along * s + normal * (line.offset + line.slope * s));
            let seen = limbs.filter(|_| !cut).and_then(|limbs| {
                let [first, second] = limbs.map(|limb| {
                    move |s: f64| -limb.dot(&(center + along * s).push(1.0)) / limb.xy().dot(&normal)
                });
                let middle = f64::midpoint(low, high);
                let is_first = (first(middle) < second(middle)) == (k == 0);
                let limb = move |s: f64| if is_first { first(s) } else { second(s) };
                // The region, and the depth that the cylinder is from, may be shifted.
                let mut apart: List<f64> = whole.iter().map(|&(s, u)| u - limb(s)).collect();
                let apart = median(&mut apart);
                let limb = |s: f64| limb(s) + apart;
                let least = WITHIN.get() * self.noise.unevenness;
                let is_within = |&(s, u, _): &(f64, f64, bool)| [1.0, -1.0][k] * (u - limb(s)) >= least;
                let (part, hidden) = seen_part(&all, is_within)?;
                Some((part.map(|s| center + along * s + normal * limb(s)), hidden))
            });
            Some(Side { ends, seen, cut })
        };
        let mut sides = [side(0)?, side(1)?];
        if let Some(depth) = self.depth {
            let [first, second] = sides.map(|side| side.ends[0] + side.ends[1]);
            let half_width = (second - first).dot(&normal) / 4.0;
            let beyond = Beyond::new(camera, depth, rough, half_width, &self.noise);
            for (side, outward) in sides.iter_mut().zip([-normal, normal]) {
                if !side.cut && beyond.touches(&side.ends, &outward) {
                    (side.cut, side.seen) = (true, None);
                }
            }
        }
        Some(sides)
    }

    /// The pixels of the outline beyond which something in front covers one side along a rough axis; none where it covers no side
    /// nearly all along, or both.
    #[must_use]
    pub fn covered_side(&self, camera: &Camera, axis: &Line) -> List<(usize, usize)> {
        let Some(along) = self.axis_in_image(camera, axis) else { return List::new() };
        let normal = Vector2::new(-along.y, along.x);
        let from_center = |pixel: &OutlinePixel| pixel.position - self.center;
        let [low, high] = self.between_ends(&along);
        // By side the pixels that are covered, and how many are and are not between the ends.
        let mut sides = [(List::new(), [0; 2]), (List::new(), [0; 2])];
        for pixel in &self.pixels {
            let (pixels, counts) = &mut sides[usize::from(from_center(pixel).dot(&normal) > 0.0)];
            let is_covered = self.depth.is_some_and(|depth| covered(self.mask, depth, pixel.at, &self.noise));
            if is_covered {
                pixels.push(pixel.at);
            }
            counts[usize::from(is_covered)] +=
                usize::from((low..=high).contains(&from_center(pixel).dot(&along)));
        }
        let least = LEAST_POSITIONS.count();
        let is_covered = |(_, [open, covered]): &(List<_>, [usize; 2])| *covered >= least && *open < least;
        let [first, second] = sides;
        match (is_covered(&first), is_covered(&second)) {
            (true, false) => first.0,
            (false, true) => second.0,
            _ => List::new(),
        }
    }

    /// The positions along a direction in the image, from the middle, between which the region is without its ends.
    fn between_ends(&self, along: &Vector2<f64>) -> [f64; 2] {
        let positions = self.pixels.iter().map(|pixel| (pixel.position - self.center).dot(along));
        let [low, high] = min_max_of(positions);
        let margin = MARGIN.get() * (high - low);
        [low + margin, high - margin]
    }

    /// The direction of the axis in the image, at the point of the axis that projects nearest to the middle.
    fn axis_in_image(&self, camera: &Camera, axis: &Line) -> Option<Vector2<f64>> {
        let ray = camera.ideal_ray(&self.center);
        let across = rejection(&ray, &axis.direction);
        let nearest = ray * (axis.nearest_to_origin().dot(&across) / across.norm_squared());
        let step = axis.direction * (1e-3 * nearest.norm());
        let difference = camera.ideal_pixel(&(nearest + step))? - camera.ideal_pixel(&(nearest - step))?;
        difference.try_normalize(0.0)
    }
}

/// The longest part of a side beside which the limb is seen, and beyond which of its ends something in front hides the rest;
/// `None` where it hides none of it. `all` are positions along the axis, where the region ends there, and whether that is
/// beside something nearer. What is nearer may stand beside a limb that is seen: where it hides the limb, the region ends within
/// it. A few positions at an end are left to the search.
fn seen_part(
    all: &[(f64, f64, bool)],
    is_within: impl Fn(&(f64, f64, bool)) -> bool,
) -> Option<([f64; 2], [bool; 2])> {
    // The stretch with the most positions where the limb is seen beyond those where it is hidden.
    let (mut count, mut begin, mut most, mut longest) = (0, 0, 0, None);
    let mut next = 0;
    for run in all.chunk_by(|a, b| is_within(a) == is_within(b)) {
        let cut = run.iter().filter(|position| position.2).count();
        if is_within(&run[0]) && 2 * cut >= run.len() {
            count -= run.len() as i64;
        } else {
            count += run.len() as i64;
        }
        next += run.len();
        if count <= 0 {
            (count, begin) = (0, next);
        } else if count > most {
            (most, longest) = (count, Some((begin, next - 1)));
        }
    }
    let (begin, end) = longest?;
    let hidden = [begin, all.len() - 1 - end].map(|count| count >= LEAST_POSITIONS.count());
    hidden.contains(&true).then(|| ([all[begin].0, all[end].0], hidden))
}

/// Whether something in front may cover a side of a mask; of most it covers nothing. Where it covers nearly all of a side, every few pixels of
/// the outline tell: an odd number, as most rows have one pixel of either side.
#[must_use]
pub fn may_be_covered(mask: &Mask, depth: &DepthImage, noise: &ImageNoise) -> bool {
    let some = mask.outline().iter().step_by((LEAST_POSITIONS.count() / 2) | 1);
    some.copied().any(|at| covered(mask, depth, at, noise))
}

/// Whether something in front of a pixel at the edge of a mask covers what lies beyond it: the depth there is nearer
/// than that inside.
fn covered(mask: &Mask, depth: &DepthImage, (x, y): (usize, usize), noise: &ImageNoise) -> bool {
    let mut outward = Vector2::zeros();
    for (dx, dy) in [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, 1), (-1, 1), (1, -1)] {
        let beside = x.checked_add_signed(dx).zip(y.checked_add_signed(dy));
        if !beside.is_some_and(|(x, y)| mask.contains(x, y)) {
            outward += Vector2::new(dx as f64, dy as f64).normalize();
        }
    }
    let Some(outward) = outward.try_normalize(0.0) else { return false };
    let middle = |side: f64| {
        let beyond = noise.beyond().into_iter().take(COMPARED).filter_map(|distance| {
            let (x, y) = pixel_at(&(Vector2::new(x as f64, y as f64) + outward * (side * distance)))?;
            depth.depth(x, y)
        });
        let mut depths: SmallVec<[f64; COMPARED]> = beyond.collect();
        depths.sort_unstable_by(f64::total_cmp);
        depths.get(depths.len() / 2).copied()
    };
    middle(1.0).zip(middle(-1.0)).is_some_and(|(beyond, inside)| beyond < inside * (1.0 - NEARER.get()))
}

/// A line u = offset + slope · s and the s between which it was drawn.
struct SideLine {
    offset: f64,
    slope: f64,
    range: [f64; 2],
}

/// The line through most of the points, and through all within some distances of `least`.
fn robust_line(mut points: List<(f64, f64)>, least: f64) -> Option<SideLine> {
    loop {
        if points.len() < LEAST_POSITIONS.count() {
            return None;
        }
        let count = points.len() as f64;
        let mean = points.iter().fold((0.0, 0.0), |sum, p| (sum.0 + p.0 / count, sum.1 + p.1 / count));
        let (square, product) = points.iter().fold((0.0, 0.0), |sum, p| {
            let ds = p.0 - mean.0;
            (sum.0 + ds * ds, sum.1 + ds * (p.1 - mean.1))
        });
        let slope = product / square;
        let offset = mean.1 - slope * mean.0;
        let distance = |p: &(f64, f64)| (p.1 - offset - slope * p.0).abs();
        let mut distances: List<f64> = points.iter().map(distance).collect();
        let median = median(&mut distances);
        let before = points.len();
        points.retain(|p| distance(p) <= MEDIANS.get() * median.max(least));
        if points.len() == before {
            let range = [points[0].0, points[points.len() - 1].0];
            return Some(SideLine { offset, slope, range });
        }
    }
}
