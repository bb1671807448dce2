//! What in a mask is the lateral surface of a cylinder, its body, and what is not: caps, inner walls, lids, rims and rings that are wider,
//! things in front.
//!
//! Masks drawn by people or networks cover whole objects. Along the axis the pixels of such a mask see the body, then
//! something else: a cap, which lies in the plane across the axis, or the inner wall of an open end. The depth tells
//! them apart pixel by pixel, and the position where the one turns into the other follows from all of them together.

mod collar;
mod outline;
mod profile;
mod shoulder;
mod sight;

use crate::camera::Camera;
use crate::geometry::Cylinder;
use crate::memory::List;
use crate::noise::ImageNoise;
use crate::observations::{DepthImage, Mask};
use crate::statistics::{LOWER_QUARTILE, lower_quartile_absolute, median_and_deviation, ordered};
pub use collar::Collar;
use collar::collars;
use nalgebra::Vector3;
use outline::Rims;
use shoulder::shoulder;
pub(crate) use sight::extremes;
use sight::sights;
use std::cell::OnceCell;

constants! {
    /// About how many pixels of a mask are looked at.
    PIXELS = 5000.0, "px";

    /// The part of the half width that they cover: beside the limbs depth is worst.
    WIDTH_PART = 0.85, "";

    /// A depth is on the surface within this many standard deviations.
    REACH = 3.0, "σ";

    /// A depth is also on the surface within this part of the radius: the cylinder is a rough one, and rims are a few
    /// per cent wider.
    LEAST_REACH = 0.05, "radius";

    /// The part of the radius within which points are looked at for the plane of a cap: beside its rim depth is rounded.
    CAP_PART = 0.8, "";

    /// The most by which the points of a cap may spread along the axis, as a part of the radius: those of an inner wall
    /// spread over the radius.
    CAP_SPREAD = 0.06, "radius";

    /// A mask of the body may reach beyond it by this many standard deviations of its boundary.
    BOUNDARIES = 2.5, "σ";

    /// The part of the error of a depth that all points of a cap share.
    SHARED_PART = 0.35, "σ";

    /// Standard deviation of an end by the plane of a cap at least, by the depth that leaves the surface, and by the far
    /// rim, in pixels.
    CAP_PIXELS = 0.4, "px";
    DEPTH_PIXELS = 1.5, "px";
    FAR_RIM_PIXELS = 1.5, "px";

    /// What the depth behind the surface adds to the odds of a far rim, where it nearly is enough by itself.
    DEPTH_ODDS = 2.0, "";

    /// The depth may show the surface so far beyond an end, in pixels: matching windows draw it out.
    SURPLUS = 8.0, "px";

    /// The far rim is at least so far beyond the plane of a cap that is recessed, in pixels.
    LEAST_RECESS = 1.5, "px";

    /// Fewest pixels of a cap.
    LEAST_CAP = 40.0, "px";
}

/// About how many pixels share a stretch of the axis while they are ordered.
const PER_STRETCH: usize = 4;

#[cfg(feature = "sensitivity")]
/// The constants of the parts of a mask.
#[must_use]
pub fn constants() -> Vec<crate::constant::Constant> {
    [CONSTANTS, collar::CONSTANTS, outline::CONSTANTS, shoulder::CONSTANTS].concat()
}

/// What a point or pixel of a mask belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// The lateral surface.
    Body,
    /// A cap: it lies in the plane across the axis at an end.
    Cap,
    /// The inside of the cylinder, seen through an open end: its inner wall or its bottom.
    InnerWall,
    /// Something nearer than the surface: a lid or a rim that is wider, a handle, what stands in front.
    Other,
    /// Something farther away than the cylinder: the background.
    Behind,
}

/// Where the body ends within a mask.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyEnd {
    /// Position along the axis, from the axis point of the cylinder.
    pub position: f64,
    /// Its standard deviation.
    pub deviation: f64,
    /// What tells it.
    pub sign: EndSign,
    /// How much farther outward the rim may be: a lid lies lower than it, or the mask is too wide.
    pub recess: f64,
}

impl BodyEnd {
    /// Where its rim is, `outward` (± 1, along the axis) of the position, and the standard deviation: anywhere in the recess.
    #[must_use]
    pub fn rim(&self, outward: f64) -> [f64; 2] {
        let position = self.position + 0.5 * outward * self.recess;
        [position, self.deviation.hypot(self.recess / 12.0_f64.sqrt())]
    }
}

/// What tells where the body ends within a mask.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EndSign {
    /// The plane of a cap.
    Cap,
    /// The depth leaves the surface there.
    Depth,
    /// The mask ends in the shape of the far rim of that end.
    FarRim,
    /// The depth leaves the surface little by little from there on, as the shoulder of a bottle does.
    Shoulder,
}

/// What the depth says of the parts of a mask.
#[derive(Debug, Clone)]
pub struct Parts {
    cylinder: Cylinder,
    /// How far from the surface a depth may be.
    reach: f64,
    /// Against and along the axis; `None` where the mask ends with the body.
    pub ends: [Option<BodyEnd>; 2],
    /// Lids, rims and rings that are wider than the body.
    pub collars: List<Collar>,
}

/// A pixel of the mask that was looked at.
#[derive(Clone, Copy)]
struct Sight {
    /// Position along the axis at which its ray meets the surface.
    position: f64,
    /// The point that was measured, and how far it is from the surface.
    point: Vector3<f64>,
    distance: f64,
    /// Whether the point is nearer than the surface.
    nearer: bool,
    /// Whether it is on the wall that the camera sees.
    facing: bool,
}

impl Parts {
    /// The parts of a mask about a cylinder in the coordinates of the camera, from outside. `None` where the depth does
    /// not show the cylinder.
    #[must_use]
    pub fn new(
        camera: &Camera,
        depth: &DepthImage,
        mask: &Mask,
        cylinder: &Cylinder,
        noise: &ImageNoise,
    ) -> Option<Self> {
        if cylinder.contains_origin() {
            return None;
        }
        let stride = (mask.count() as f64 / PIXELS.get()).sqrt().ceil().max(1.0) as usize;
        let sights = along_the_axis(&sights(camera, depth, cylinder, mask.set_pixels_of_grid(stride)));
        let reach = reach(cylinder, sights.iter().map(|sight| sight.distance));
        let votes: List<f64> = sights.iter().map(|sight| sight.vote(reach)).collect();
        let (first, last) = most(&votes)?;
        // A strip as wide as the surface and as long as the boundary of a mask may be off.
        let near = sights[first].point.z.min(sights[last].point.z);
        let width = 2.0 * WIDTH_PART.get() * cylinder.radius * camera.focal_length() / near;
        let least = width * (BOUNDARIES.get() * noise.boundary) / (stride * stride) as f64;
        let sum = |votes: &[f64]| -votes.iter().sum::<f64>();
        let rims = OnceCell::new();
        let end = |outward: f64, inner: &Sight, votes: &[f64], beyond: &[Sight]| {
            let pixel = pixel_length(camera, cylinder, inner.position)?;
            // A plane deeper inside than the surface was measured is the bottom of an open end.
            let measured = cylinder.axis.position_of(&inner.point);
            let at_end =
                |(position, _): &(f64, f64)| (measured - position) * outward <= SURPLUS.get() * pixel;
            let of_depth = (sum(votes) >= least).then(|| match cap(beyond, cylinder, reach).filter(at_end) {
                Some((position, spread)) => {
                    // Matching windows draw the depth of two rims that are near to each other over the end.
                    let apart =
                        rims_apart(camera, cylinder, position).is_some_and(|pixels| pixels >= SURPLUS.get());
                    let pixels = if apart { CAP_PIXELS } else { DEPTH_PIXELS };
                    let deviation = (SHARED_PART.get() * spread).max(pixels.get() * pixel);
                    let rims = rims.get_or_init(|| Rims::new(camera, mask, cylinder));
                    let far = rims.far(outward, DEPTH_ODDS.get(), noise);
                    let recess = far.map_or(0.0, |far| (far - position) * outward);
                    let is_recessed = (LEAST_RECESS.get() * pixel..=SURPLUS.get() * pixel).contains(&recess);
                    let recess = if is_recessed { recess } else { 0.0 };
                    BodyEnd { position, deviation, sign: EndSign::Cap, recess }
                }
                None => leaving(inner, votes, beyond, outward, pixel),
            });
            let far_rim = || {
                let before = DEPTH_ODDS.get() * (sum(votes) / least).clamp(0.0, 1.0);
                let position =
                    rims.get_or_init(|| Rims::new(camera, mask, cylinder)).far(outward, before, noise)?;
                let votes_past = |past: bool| -> List<f64> {
                    let chosen = |sight: &Sight| ((sight.position - position) * outward > 0.0) == past;
                    let pairs = beyond.iter().zip(votes).filter(|(sight, _)| chosen(sight));
                    pairs.map(|(_, vote)| *vote).collect()
                };
                // Where the surface is not seen up to it, it is none: a neck is narrower, or a shoulder rounds the body off.
                if sum(&votes_past(false)) >= least {
                    return None;
                }
                // Nor where the surface itself is seen beyond it.
                let past = votes_past(true);
                let on_surface = past.iter().filter(|vote| **vote > 0.0).count();
                let nothing = (inner.position - position) * outward > SURPLUS.get() * pixel;
                (!nothing && 2 * on_surface <= past.len()).then_some(BodyEnd {
                    position,
                    deviation: FAR_RIM_PIXELS.get() * pixel,
                    sign: EndSign::FarRim,
                    recess: 0.0,
                })
            };
            match of_depth {
                Some(end) if end.deviation <= FAR_RIM_PIXELS.get() * pixel => Some(end),
                Some(end) => Some(far_rim().unwrap_or(end)),
                None => far_rim(),
            }
        };
        let ends = [
            end(-1.0, &sights[first], &votes[..first], &sights[..first]),
            end(1.0, &sights[last], &votes[last + 1..], &sights[last + 1..]),
        ];
        let ends = [(ends[0], -1.0), (ends[1], 1.0)].map(|(end, outward)| {
            let end = end?;
            let pixel = pixel_length(camera, cylinder, end.position)?;
            Some(shoulder(&end, &sights, cylinder.radius, [reach, pixel], outward).unwrap_or(end))
        });
        let positions = ends.map(|end| Some(end?.position));
        let (collars, narrower) =
            collars(camera, mask, (&sights, stride), cylinder, positions).unwrap_or((List::new(), positions));
        let ends = [0, 1].map(|k| match narrower[k] {
            Some(position) if narrower[k] != positions[k] => {
                let deviation = DEPTH_PIXELS.get() * pixel_length(camera, cylinder, position)?;
                Some(BodyEnd { position, deviation, sign: EndSign::Depth, recess: 0.0 })
            }
            // The far rim of a lid that is wider lies beyond that of the body.
            _ if collars.iter().any(|collar| collar.closes(k)) => Some(BodyEnd { recess: 0.0, ..ends[k]? }),
            _ => ends[k],
        });
        Some(Self { cylinder: *cylinder, reach, ends, collars })
    }

    /// The parts of points alone, which do not tell where the body ends.
    #[must_use]
    pub fn of_points(cylinder: &Cylinder, points: impl Iterator<Item = Vector3<f64>>) -> Self {
        // Without a mask most of them may be of the background, which says nothing of the noise.
        let near = |distance: &f64| distance.abs() <= cylinder.radius;
        let reach = reach(cylinder, points.map(|point| cylinder.distance(&point)).filter(near));
        Self { cylinder: *cylinder, reach, ends: [None, None], collars: List::new() }
    }

    /// Whether the whole mask is the body.
    #[must_use]
    pub fn all_body(&self) -> bool {
        self.ends.iter().all(Option::is_none) && self.collars.is_empty()
    }

    /// Whether a ray passes the cylinder between its ends, lids, rims and rings among them.
    #[must_use]
    pub fn within(&self, ray: &Vector3<f64>) -> bool {
        passes_between(&self.cylinder, ray, self.ends.map(|end| Some(end?.position)))
    }

    /// Whether a ray passes the cylinder between its ends, lids, rims and rings that are wider than the body left out.
    #[must_use]
    pub fn within_body(&self, ray: &Vector3<f64>) -> bool {
        let beside = |collar: &Collar| {
            // The collar hides some of the body, too.
            let wider = Cylinder { radius: collar.radius, ..self.cylinder };
            let [begin, end] = collar.stretch.map(Some);
            [[None, begin], [end, None]].into_iter().any(|ends| {
                [&self.cylinder, &wider].into_iter().all(|cylinder| passes_between(cylinder, ray, ends))
            })
        };
        self.within(ray) && self.collars.iter().all(beside)
    }

    /// The pixels of a mask whose rays are chosen; `None` when there are none.
    #[must_use]
    pub fn shown(
        &self,
        camera: &Camera,
        mask: &Mask,
        choose: fn(&Self, &Vector3<f64>) -> bool,
    ) -> Option<Mask> {
        mask.chosen(|column, row| camera.ray_of_pixel(column, row).is_some_and(|ray| choose(self, &ray)))
    }

    /// What a measured point belongs to.
    #[must_use]
    pub fn of_point(&self, point: &Vector3<f64>) -> Part {
        let Self { cylinder, reach, ends, .. } = self;
        let axis = &cylinder.axis;
        let distance = cylinder.distance(point);
        if !self.within(point) {
            let along = axis.position_of(point);
            let in_plane = |end: &BodyEnd| end.sign == EndSign::Cap && (along - end.position).abs() <= *reach;
            if distance <= *reach && ends.iter().flatten().any(in_plane) {
                return Part::Cap;
            }
        } else if distance.abs() <= *reach && faces(cylinder, point) {
            return if self.within_body(point) { Part::Body } else { Part::Other };
        }
        let surface = cylinder.first_hit(point).unwrap_or_else(|| axis.nearest_to(point));
        if point.norm_squared() < surface.norm_squared() {
            Part::Other
        } else if distance <= *reach {
            Part::InnerWall
        } else {
            Part::Behind
        }
    }
}

/// The sights in the order of their positions; those at one position stay in theirs.
fn along_the_axis(sights: &[Sight]) -> List<Sight> {
    // Dealt out to stretches of the axis first: the few of a stretch are quicker to order than all.
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for Sight { position, .. } in sights {
        (low, high) = (low.min(*position), high.max(*position));
    }
    let stretches = sights.len().div_ceil(PER_STRETCH);
    let per_length = stretches as f64 / (high - low);
    // Where there is no length all are in the first one.
    let stretch = |sight: &Sight| (((sight.position - low) * per_length) as u32 as usize).min(stretches - 1);
    let mut ends = List::filled(0, stretches + 1);
    for sight in sights {
        ends[stretch(sight) + 1] += 1;
    }
    for k in 0..stretches {
        ends[k + 1] += ends[k];
    }
    // Numbers are moved about in place of whole sights.
    let mut order = List::filled(0_u128, sights.len());
    for (k, sight) in sights.iter().enumerate() {
        let next = &mut ends[stretch(sight)];
        order[*next] = u128::from(ordered(sight.position)) << 64 | k as u128;
        *next += 1;
    }
    let mut begin = 0;
    for end in &ends[..stretches] {
        order[begin..*end].sort_unstable();
        begin = *end;
    }
    order.iter().map(|&key| sights[key as u64 as usize]).collect()
}

/// The end where the depth leaves the surface: between the last pixel of the body and the first of what is behind.
fn leaving(inner: &Sight, votes: &[f64], beyond: &[Sight], outward: f64, pixel: f64) -> BodyEnd {
    let behind: List<f64> = votes.iter().map(|vote| -vote).collect();
    let first = most(&behind).map(|(first, last)| if outward > 0.0 { first } else { last });
    let outer = first.map_or(inner.position, |k| beyond[k].position);
    // Anywhere in between.
    let gap = (outer - inner.position).abs() / 12.0_f64.sqrt();
    BodyEnd {
        position: f64::midpoint(inner.position, outer),
        deviation: gap.hypot(DEPTH_PIXELS.get() * pixel),
        sign: EndSign::Depth,
        recess: 0.0,
    }
}

/// Whether a ray meets a cylinder, or passes it, between positions along the axis.
fn passes_between(cylinder: &Cylinder, ray: &Vector3<f64>, [first, last]: [Option<f64>; 2]) -> bool {
    let axis = &cylinder.axis;
    let point = cylinder.first_hit(ray).unwrap_or_else(|| ray * axis.nearest_on_ray(ray));
    let position = axis.position_of(&point);
    first.is_none_or(|end| position >= end) && last.is_none_or(|end| position <= end)
}

/// The length along the axis that one pixel shows of the middle of the visible surface.
fn pixel_length(camera: &Camera, cylinder: &Cylinder, position: f64) -> Option<f64> {
    let [point, _] = middles_of_rims(cylinder, position)?;
    let step = 0.01 * cylinder.radius;
    let moved = camera.project(&(point + cylinder.axis.direction * step))? - camera.project(&point)?;
    Some(step / moved.norm()).filter(|length| length.is_finite())
}

/// How far the far rim of the end at a position is from the near one in the image, in pixels.
fn rims_apart(camera: &Camera, cylinder: &Cylinder, position: f64) -> Option<f64> {
    let [near, far] = middles_of_rims(cylinder, position)?.map(|point| camera.project(&point));
    Some((far? - near?).norm())
}

/// The points of the circle at a position along the axis that are nearest to the observer and farthest from it.
fn middles_of_rims(cylinder: &Cylinder, position: f64) -> Option<[Vector3<f64>; 2]> {
    let axis = &cylinder.axis;
    let center = axis.at(position);
    let across = center - axis.direction * center.dot(&axis.direction);
    let away = across.try_normalize(0.0)? * cylinder.radius;
    Some([center - away, center + away])
}

/// How far points of the surface may be from it, by their distances and those of others.
fn reach(cylinder: &Cylinder, distances: impl Iterator<Item = f64>) -> f64 {
    let sigma = lower_quartile_absolute(distances) / LOWER_QUARTILE;
    (REACH.get() * sigma).max(LEAST_REACH.get() * cylinder.radius)
}

fn faces(cylinder: &Cylinder, point: &Vector3<f64>) -> bool {
    (point - cylinder.axis.nearest_to(point)).dot(point) < 0.0
}

impl Sight {
    /// 1 for the surface, −1 for what is farther away, 0 for what hides both.
    fn vote(&self, reach: f64) -> f64 {
        if self.distance.abs() <= reach && self.facing {
            1.0
        } else if self.nearer {
            0.0
        } else {
            -1.0
        }
    }
}

/// The first and the last vote of the stretch with the greatest sum; `None` where no vote is positive.
fn most(votes: &[f64]) -> Option<(usize, usize)> {
    let (mut best, mut found) = (0.0, None);
    let (mut sum, mut start) = (0.0, 0);
    for (k, vote) in votes.iter().enumerate() {
        if sum <= 0.0 {
            (sum, start) = (0.0, k);
        }
        sum += vote;
        if sum > best {
            (best, found) = (sum, Some((start, k)));
        }
    }
    found
}

/// The position of the cap along the axis and the standard deviation of its points, if what is seen beyond an end is one.
fn cap(beyond: &[Sight], cylinder: &Cylinder, reach: f64) -> Option<(f64, f64)> {
    let axis = &cylinder.axis;
    let inner = |sight: &&Sight| sight.distance <= (CAP_PART.get() - 1.0) * cylinder.radius;
    let mut along: List<f64> =
        beyond.iter().filter(inner).map(|sight| axis.position_of(&sight.point)).collect();
    if along.len() < LEAST_CAP.count() {
        return None;
    }
    let [middle, spread] = median_and_deviation(&mut along);
    (spread <= (CAP_SPREAD.get() * cylinder.radius).max(reach / REACH.get())).then_some((middle, spread))
}
