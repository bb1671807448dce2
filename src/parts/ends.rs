//! Where the body ends within a mask: by the depth beyond its surface, or by the far rim in the outline of the mask.

use super::outline::Rims;
use super::turn;
use super::{
    BodyEnd, CAP_PART, CAP_PIXELS, CAP_SPREAD, DEPTH_ODDS, DEPTH_PIXELS, EndSign, FAR_RIM_PIXELS, LEAST_CAP,
    LEAST_RECESS, REACH, SHARED_PART, SURPLUS, Sight,
};
use crate::camera::Camera;
use crate::geometry::{Cylinder, rejection};
use crate::memory::List;
use crate::noise::ImageNoise;
use crate::observations::{DepthImage, Mask};
use crate::statistics::median_and_deviation;
use nalgebra::Vector3;
use std::cell::OnceCell;

/// What the ends of a body are looked for by.
pub(super) struct EndSearch<'a> {
    pub camera: &'a Camera,
    pub depth: &'a DepthImage,
    pub mask: &'a Mask,
    pub cylinder: &'a Cylinder,
    pub noise: &'a ImageNoise,
    /// How far from the surface a depth may be.
    pub reach: f64,
    /// How many more sights of something behind than of the surface tell an end.
    pub least: f64,
    /// The outline of the mask, once it is asked for.
    pub rims: OnceCell<Rims<'a>>,
}

/// What is seen beyond the body at one end.
pub(super) struct Beyond<'a> {
    /// −1 for the end against the axis, 1 for the one along it.
    pub outward: f64,
    /// The outermost sight of the body.
    pub inner: &'a Sight,
    /// The sights beyond that one.
    pub sights: &'a [Sight],
    /// Their votes.
    pub votes: &'a [f64],
}

/// By how much votes are against the surface.
fn against(votes: &[f64]) -> f64 {
    -votes.iter().sum::<f64>()
}

impl EndSearch<'_> {
    /// The end by depth, by the far rim where that is less certain; `None` where neither tells one.
    pub fn end(&self, beyond: &Beyond<'_>) -> Option<BodyEnd> {
        let pixel = pixel_length(self.camera, self.cylinder, beyond.inner.position)?;
        let of_depth = depth_pixel(self.depth) * pixel;
        let by_depth = (against(beyond.votes) >= self.least)
            .then(|| self.by_cap(beyond, of_depth).or_else(|| self.by_leaving(beyond, of_depth)))
            .flatten();
        match by_depth {
            Some(end) if end.deviation <= FAR_RIM_PIXELS.get() * pixel => Some(end),
            _ => self.by_far_rim(beyond, pixel).or(by_depth),
        }
    }

    /// The end where the depth turns from the surface to what is behind; `None` where the mask ends before it has. `pixel` is the length
    /// of one of the depth along the axis.
    fn by_leaving(&self, beyond: &Beyond<'_>, pixel: f64) -> Option<BodyEnd> {
        let end = beyond.leaving(pixel);
        let (inner, outward) = (beyond.inner.position, beyond.outward);
        let found = turn(self.camera, self.depth, self.cylinder, self.noise, inner, outward);
        let Some(position) = found else { return Some(end) };
        let past = beyond.sights.iter().filter(|sight| (sight.position - position) * outward <= 0.0).count();
        let votes =
            if outward > 0.0 { &beyond.votes[past..] } else { &beyond.votes[..beyond.votes.len() - past] };
        let deviation = ((position - inner) / 12.0_f64.sqrt()).hypot(DEPTH_PIXELS.get() * pixel);
        (against(votes) >= self.least).then_some(BodyEnd { position, deviation, ..end })
    }

    fn rims(&self) -> &Rims<'_> {
        self.rims.get_or_init(|| Rims::new(self.camera, self.mask, self.cylinder))
    }

    /// The end by the plane of a cap, where one is seen beyond the body; `pixel` is the length of one of the depth along the axis.
    fn by_cap(&self, beyond: &Beyond<'_>, pixel: f64) -> Option<BodyEnd> {
        let Self { camera, cylinder, noise, reach, .. } = *self;
        let outward = beyond.outward;
        let (position, spread) = cap(beyond.sights, cylinder, reach)?;
        // A plane deeper inside than the surface was measured is the bottom of an open end.
        let measured = cylinder.axis.position_of(&beyond.inner.point);
        let is_at_end = (measured - position) * outward <= SURPLUS.get() * pixel;
        if !is_at_end {
            return None;
        }
        // Matching windows draw the depth of two rims that are near to each other over the end.
        let apart = rims_apart(camera, cylinder, position)
            .is_some_and(|pixels| pixels >= SURPLUS.get() * depth_pixel(self.depth));
        let pixels = if apart { CAP_PIXELS } else { DEPTH_PIXELS };
        let deviation = (SHARED_PART.get() * spread).max(pixels.get() * pixel);
        let far = self.rims().far(outward, DEPTH_ODDS.get(), noise);
        let recess = far.map_or(0.0, |far| (far - position) * outward);
        let is_recessed = (LEAST_RECESS.get() * pixel..=SURPLUS.get() * pixel).contains(&recess);
        let recess = if is_recessed { recess } else { 0.0 };
        Some(BodyEnd { position, deviation, sign: EndSign::Cap, recess })
    }

    /// The end by the far rim in the outline of the mask, where the depth shows the surface up to it and not beyond; `pixel` is the length
    /// of one of the image along the axis.
    fn by_far_rim(&self, beyond: &Beyond<'_>, pixel: f64) -> Option<BodyEnd> {
        let outward = beyond.outward;
        let before = DEPTH_ODDS.get() * (against(beyond.votes) / self.least).clamp(0.0, 1.0);
        let position = self.rims().far(outward, before, self.noise)?;
        let votes_past = |past: bool| -> List<f64> {
            let chosen = |sight: &Sight| ((sight.position - position) * outward > 0.0) == past;
            let pairs = beyond.sights.iter().zip(beyond.votes).filter(|(sight, _)| chosen(sight));
            pairs.map(|(_, vote)| *vote).collect()
        };
        // Where the surface is not seen up to it, it is none: a neck is narrower, or a shoulder rounds the body off.
        if against(&votes_past(false)) >= self.least {
            return None;
        }
        // Nor where the surface itself is seen beyond it.
        let past = votes_past(true);
        let on_surface = past.iter().filter(|vote| **vote > 0.0).count();
        let surplus = SURPLUS.get() * depth_pixel(self.depth) * pixel;
        let nothing = (beyond.inner.position - position) * outward > surplus;
        (!nothing && 2 * on_surface <= past.len()).then_some(BodyEnd {
            position,
            deviation: FAR_RIM_PIXELS.get() * pixel,
            sign: EndSign::FarRim,
            recess: 0.0,
        })
    }
}

impl Beyond<'_> {
    /// The end where the depth leaves the surface: between the last pixel of the body and the first of what is behind.
    fn leaving(&self, pixel: f64) -> BodyEnd {
        let Self { outward, inner, sights, votes } = *self;
        let behind: List<f64> = votes.iter().map(|vote| -vote).collect();
        let first = most(&behind).map(|(first, last)| if outward > 0.0 { first } else { last });
        let outer = first.map_or(inner.position, |k| sights[k].position);
        // Anywhere in between.
        let gap = (outer - inner.position).abs() / 12.0_f64.sqrt();
        BodyEnd {
            position: f64::midpoint(inner.position, outer),
            deviation: gap.hypot(DEPTH_PIXELS.get() * pixel),
            sign: EndSign::Depth,
            recess: 0.0,
        }
    }
}

/// The length along the axis that one pixel shows of the middle of the visible surface.
pub(super) fn pixel_length(camera: &Camera, cylinder: &Cylinder, position: f64) -> Option<f64> {
    let [point, _] = middles_of_rims(cylinder, position)?;
    let step = 0.01 * cylinder.radius;
    let moved = camera.project(&(point + cylinder.axis.direction * step))? - camera.project(&point)?;
    Some(step / moved.norm()).filter(|length| length.is_finite())
}

/// The same of a pixel of the depth, see [`depth_pixel`].
pub(super) fn depth_pixel_length(
    camera: &Camera,
    depth: &DepthImage,
    cylinder: &Cylinder,
    position: f64,
) -> Option<f64> {
    Some(depth_pixel(depth) * pixel_length(camera, cylinder, position)?)
}

/// The size of the pixels in which the depth was measured, in pixels of the image, where these are not larger.
fn depth_pixel(depth: &DepthImage) -> f64 {
    depth.pixel().max(1.0)
}

/// How far the far rim of the end at a position is from the near one in the image, in pixels.
fn rims_apart(camera: &Camera, cylinder: &Cylinder, position: f64) -> Option<f64> {
    let [near, far] = middles_of_rims(cylinder, position)?.map(|point| camera.project(&point));
    Some((far? - near?).norm())
}

/// The points of the circle at a position along the axis that are nearest to the observer and farthest from it.
fn middles_of_rims(cylinder: &Cylinder, position: f64) -> Option<[Vector3<f64>; 2]> {
    let center = cylinder.axis.at(position);
    let away = rejection(&center, &cylinder.axis.direction).try_normalize(0.0)? * cylinder.radius;
    Some([center - away, center + away])
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

/// The first and the last vote of the stretch with the greatest sum; `None` where no vote is positive.
pub(super) fn most(votes: &[f64]) -> Option<(usize, usize)> {
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
