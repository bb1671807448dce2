//! Which straight edges that a line detector found in the image lie on the limbs of a rough cylinder.

use super::axial_range;
use crate::camera::Camera;
use crate::geometry::{Cylinder, LimbFrame};
use crate::noise::ImageNoise;
use crate::observations::EdgeSegment;
use nalgebra::Vector2;

constants! {
    /// How far a limb may be from that of the rough cylinder, as a part of the distance of the two limbs in the image:
    /// a fit to points alone is some per cent wrong in the radius, which is half of that distance, and now and then more
    /// than ten.
    RELATIVE_REACH = 0.15, "";

    /// The least reach in deviations of the limbs of a fit to points alone: those are off by some pixels however thin the
    /// cylinder is.
    LEAST_REACH = 2.0, "σ";

    /// Pieces of one edge agree about its line to this many pixels: line detectors work to about one pixel.
    SAME_EDGE = 1.5, "px";

    /// A piece shorter than this many pixels says little about its direction.
    LEAST_LENGTH = 8.0, "px";

    /// Largest slope of a piece against the limb of the rough cylinder: 6 degrees, where fits to points alone turn the
    /// axis by one or two.
    LARGEST_SLOPE = 0.1, "rad";

    /// The part of the visible limb that the pieces on it must cover together: what is shorter may be anything.
    LEAST_COVER = 0.3, "";
}

/// A detected segment beside a limb.
struct Candidate {
    index: usize,
    /// Positions along the limb and distances across it of both ends, in ideal pixels.
    ends: [(f64, f64); 2],
}

impl Candidate {
    fn length(&self) -> f64 {
        (self.ends[1].0 - self.ends[0].0).abs()
    }

    fn offset(&self) -> f64 {
        f64::midpoint(self.ends[0].1, self.ends[1].1)
    }

    /// Whether it runs along the limb.
    fn along(&self) -> bool {
        (self.ends[1].1 - self.ends[0].1).abs() <= LARGEST_SLOPE.get() * self.length()
    }

    /// The distance across the limb at a position along it.
    fn at(&self, position: f64) -> f64 {
        let [(s0, u0), (s1, u1)] = self.ends;
        u0 + (u1 - u0) * (position - s0) / (s1 - s0)
    }
}

/// Selects, of straight edges in the (distorted) image, those that lie on the two limbs of a rough cylinder, in the
/// order of [`LimbFrame::limb_lines`]: indices into `segments`. For each limb the edge with the longest pieces wins,
/// the nearer the limb the better, if they cover 30 % of it; other edges in reach are left out. `range` is the visible part of the surface, as
/// of [`axial_range`]: pieces with their middle beyond it are of something else. `reach` is how far a limb may be from
/// that of the cylinder in pixels, `None` for 15 % of the distance of the limbs, at least 4. `None` when the cylinder
/// has no limbs that can be seen.
#[must_use]
pub fn edges_on_limbs(
    segments: &[EdgeSegment],
    camera: &Camera,
    rough: &Cylinder,
    range: &[f64; 2],
    reach: Option<f64>,
    noise: &ImageNoise,
) -> Option<[Vec<usize>; 2]> {
    let limbs = LimbFrame::new(rough)?;
    let lines = camera.limb_lines(rough).ok()?;
    let reach = match reach {
        Some(reach) => reach,
        None => {
            let across = limbs.limb_lines().map(|line| camera.ideal_pixel(&line.point));
            let [Some(first), Some(second)] = across else { return None };
            (LEAST_REACH.get() * noise.limb_of_points)
                .max(RELATIVE_REACH.get() * (lines[0].xy().dot(&(second - first))).abs())
        }
    };
    let within = |segment: &EdgeSegment| {
        let [low, high] = axial_range(camera, rough, segment.endpoints.into_iter(), 0.0)?;
        let middle = f64::midpoint(low, high);
        Some(range[0] <= middle && middle <= range[1])
    };
    let mut candidates = [Vec::new(), Vec::new()];
    for (index, segment) in segments.iter().enumerate() {
        let [Some(first), Some(second)] =
            segment.endpoints.map(|pixel| camera.ideal_pixel(&camera.unproject(&pixel)?))
        else {
            continue;
        };
        let beside = lines.map(|line| {
            let along = Vector2::new(-line.y, line.x);
            let end = |q: &Vector2<f64>| (along.dot(q), line.xy().dot(q) + line.z);
            Candidate { index, ends: [end(&first), end(&second)] }
        });
        let far = |candidate: &Candidate| candidate.ends.iter().map(|(_, u)| u.abs()).fold(0.0, f64::max);
        let nearer = usize::from(far(&beside[1]) < far(&beside[0]));
        let [first, second] = beside;
        let candidate = if nearer == 0 { first } else { second };
        let long_enough = candidate.length() >= LEAST_LENGTH.get();
        if far(&candidate) <= reach && long_enough && candidate.along() && within(segment) == Some(true) {
            candidates[nearer].push(candidate);
        }
    }
    let start = rough.axis.point.dot(&rough.axis.direction);
    let visible = limbs.limb_lines().map(|line| {
        let end = |position: f64| camera.ideal_pixel(&line.at(start + position));
        Some((end(range[1])? - end(range[0])?).norm())
    });
    let [first, second] = candidates;
    let chosen = [(first, visible[0]), (second, visible[1])].map(|(candidates, visible)| {
        let pieces = longest_edge(&candidates, reach);
        let length: f64 = pieces.iter().map(|piece| piece.length()).sum();
        // A limb that reaches behind the camera has no length in the image.
        let enough = visible.is_none_or(|visible| length >= LEAST_COVER.get() * visible);
        if enough { pieces.iter().map(|piece| piece.index).collect() } else { Vec::new() }
    });
    Some(chosen)
}

/// The pieces of the edge that is longest and nearest: of all lines through one piece, the one with the most length
/// along it, weighed down to 0 at the reach.
fn longest_edge(candidates: &[Candidate], reach: f64) -> Vec<&Candidate> {
    let pieces = |line: &Candidate| -> Vec<&Candidate> {
        let agrees =
            |piece: &&Candidate| piece.ends.iter().all(|&(s, u)| (u - line.at(s)).abs() <= SAME_EDGE.get());
        candidates.iter().filter(agrees).collect()
    };
    let score = |line: &Candidate| -> f64 {
        let weight = |piece: &&Candidate| piece.length() * (1.0 - (piece.offset() / reach).powi(2));
        pieces(line).iter().map(weight).sum()
    };
    let best = candidates.iter().map(|line| (score(line), line)).max_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or_else(Vec::new, |(_, line)| pieces(line))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Distortion, Intrinsics};
    use crate::noise::NoiseModel;
    use nalgebra::Vector3;

    fn camera() -> Camera {
        let distortion = Distortion::brown_conrady(&[0.1, -0.03, 0.001, -0.001]).unwrap();
        Camera::new(Intrinsics {
            width: 640,
            height: 480,
            fx: 500.0,
            fy: 510.0,
            cx: 320.0,
            cy: 240.0,
            distortion,
        })
        .unwrap()
    }

    /// A piece of a limb in the distorted image, moved across by some pixels.
    fn piece(cylinder: &Cylinder, limb: usize, range: [f64; 2], shift: f64) -> EdgeSegment {
        let line = LimbFrame::new(cylinder).unwrap().limb_lines()[limb];
        let endpoints = range.map(|s| camera().project(&line.at(s)).unwrap() + Vector2::x() * shift);
        EdgeSegment { endpoints, weight: 1.0 }
    }

    #[test]
    fn pieces_of_the_limbs_are_told_from_other_edges() {
        let truth = Cylinder::new(Vector3::new(0.05, 0.0, 0.8), Vector3::new(0.1, 1.0, 0.2), 0.06).unwrap();
        // 8 % off, as a fit to points alone may be.
        let rough =
            Cylinder::new(Vector3::new(0.049, 0.0, 0.79), Vector3::new(0.11, 1.0, 0.25), 0.065).unwrap();
        let middle = EdgeSegment { weight: 1.0, ..piece(&truth, 0, [-0.1, 0.1], 40.0) };
        let across =
            EdgeSegment { endpoints: [Vector2::new(300.0, 200.0), Vector2::new(400.0, 205.0)], weight: 1.0 };
        let segments = [
            middle,
            piece(&truth, 0, [-0.1, 0.0], 0.0),
            across,
            piece(&truth, 0, [0.02, 0.1], 0.3),
            piece(&truth, 1, [-0.05, 0.1], -0.2),
            piece(&truth, 1, [-0.1, -0.06], 5.0),
            piece(&truth, 1, [0.0, 0.001], 0.0),
            piece(&truth, 0, [0.14, 0.2], 0.0),
        ];
        let noise = NoiseModel::default().in_image(camera().size());
        // From the point of the axis, where the pieces are given from the point of it nearest to the camera.
        let range = [-0.12, 0.12].map(|s| s - rough.axis.point.dot(&rough.axis.direction));
        let found = edges_on_limbs(&segments, &camera(), &rough, &range, None, &noise).unwrap();
        assert_eq!(found, [vec![1, 3], vec![4]]);
        // Nothing is nearer than half a pixel to the limbs of the rough cylinder.
        let none = edges_on_limbs(&segments, &camera(), &rough, &range, Some(0.5), &noise).unwrap();
        assert_eq!(none, [Vec::<usize>::new(), Vec::new()]);
    }

    #[test]
    fn there_are_none_from_inside() {
        let noise = NoiseModel::default().in_image(camera().size());
        let pipe = Cylinder::new(Vector3::new(0.0, 0.0, 0.1), Vector3::x(), 0.5).unwrap();
        assert!(edges_on_limbs(&[], &camera(), &pipe, &[-1.0, 1.0], None, &noise).is_none());
    }
}
