//! What in a mask is the lateral surface of a cylinder, its body, and what is not: caps, inner walls, lids, rims and rings that are wider,
//! things in front.
//!
//! Masks drawn by people or networks cover whole objects. Along the axis the pixels of such a mask see the body, then
//! something else: a cap, which lies in the plane across the axis, or the inner wall of an open end. The depth tells
//! them apart pixel by pixel, and the position where the one turns into the other follows from all of them together.

mod bins;
mod collar;
mod ends;
mod outline;
mod profile;
mod shoulder;
mod sight;
mod steps;
mod turn;

use crate::camera::Camera;
use crate::geometry::Cylinder;
use crate::memory::List;
use crate::noise::ImageNoise;
use crate::observations::{DepthImage, Mask};
use crate::statistics::{LOWER_QUARTILE, lower_quartile_absolute, ordered};
use bins::Bins;
pub use collar::Collar;
use collar::collars;
use ends::{Beyond, EndSearch, depth_pixel_length, most};
use nalgebra::Vector3;
use shoulder::shoulder;
pub(crate) use sight::extremes;
use sight::sights;
use std::cell::OnceCell;
pub(crate) use steps::other_radius;
pub(crate) use turn::turn;

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

    /// Standard deviation of an end by the plane of a cap at least, and by the depth that leaves the surface, in pixels of the depth, and by
    /// the far rim, in pixels of the image.
    CAP_PIXELS = 0.4, "px";
    DEPTH_PIXELS = 1.5, "px";
    FAR_RIM_PIXELS = 1.5, "px";

    /// What the depth behind the surface adds to the odds of a far rim, where it nearly is enough by itself.
    DEPTH_ODDS = 2.0, "";

    /// The depth may show the surface so far beyond an end, in pixels of the depth: matching windows draw it out.
    SURPLUS = 8.0, "px";

    /// The far rim is at least so far beyond the plane of a cap that is recessed, in pixels of the depth.
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
    [CONSTANTS, collar::CONSTANTS, outline::CONSTANTS, shoulder::CONSTANTS, turn::CONSTANTS].concat()
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
        let search = EndSearch { camera, depth, mask, cylinder, noise, reach, least, rims: OnceCell::new() };
        let beyond = [
            Beyond { outward: -1.0, inner: &sights[first], sights: &sights[..first], votes: &votes[..first] },
            Beyond {
                outward: 1.0,
                inner: &sights[last],
                sights: &sights[last + 1..],
                votes: &votes[last + 1..],
            },
        ];
        let ends = beyond.map(|beyond| {
            let end = search.end(&beyond)?;
            let pixel = depth_pixel_length(camera, depth, cylinder, end.position)?;
            Some(shoulder(&end, &sights, cylinder.radius, reach, pixel, beyond.outward).unwrap_or(end))
        });
        let positions = ends.map(|end| Some(end?.position));
        let (collars, of_body) =
            collars(camera, mask, (&sights, stride), cylinder, positions).unwrap_or((List::new(), positions));
        let ends = [0, 1].map(|k| match of_body[k] {
            // Something narrower follows.
            Some(position) if of_body[k] != positions[k] => {
                let pixel = depth_pixel_length(camera, depth, cylinder, position)?;
                let deviation = DEPTH_PIXELS.get() * pixel;
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
    // Numbers are moved about in place of whole sights.
    let key = |k: usize| u128::from(ordered(sights[k].position)) << 64 | k as u128;
    let mut order = Bins::new(stretches, (0..sights.len()).map(|k| (stretch(&sights[k]), key(k))));
    (0..stretches).for_each(|stretch| order.of(stretch).sort_unstable());
    order.values().iter().map(|&key| sights[key as u64 as usize]).collect()
}

/// Whether a ray meets a cylinder, or passes it, between positions along the axis.
fn passes_between(cylinder: &Cylinder, ray: &Vector3<f64>, [first, last]: [Option<f64>; 2]) -> bool {
    let axis = &cylinder.axis;
    let point = cylinder.first_hit(ray).unwrap_or_else(|| ray * axis.nearest_on_ray(ray));
    let position = axis.position_of(&point);
    first.is_none_or(|end| position >= end) && last.is_none_or(|end| position <= end)
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
