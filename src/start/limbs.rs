//! A start from two limb segments in the image and the depth points between them.
//!
//! The limb planes, through the observer and each limb, hold where the axis runs in the image and how wide
//! the cylinder looks: γ with sin γ = r / ‖c‖ (11). They also meet in the axis direction, but so flatly that
//! half a pixel of error tilts a slender cylinder in depth by tens of degrees. So the tilt is left to the
//! points:
//!
//! 1. A trial axis direction d̂ turns in the median plane, which halves the angle between the limb planes.
//! 2. Each limb plane is replaced by the plane through the observer that contains d̂ and fits its segment
//!    best. The two give ĉ and γ, hence the cylinder up to its scale s = ‖c‖, with r = s sin γ.
//! 3. Every point whose ray meets that cylinder votes for the scale that puts it on the near wall.
//! 4. The tilt is right where the votes agree: a grid finds the shortest interval with half of them, then
//!    robust regression of the votes on the tilt refines tilt and scale together.

mod votes;

use crate::geometry::{Cylinder, LimbFrame};
use crate::memory::List;
use crate::residuals::{Progress, Reweighting, Scale};
use crate::statistics::min_max_of;
use nalgebra::Vector3;
use votes::Points;

/// Points that are used at most; more hardly help a start.
const MAX_POINTS: usize = 300;
/// Points that are used at most for each trial of the grid.
const MAX_GRID_POINTS: usize = 150;
/// Votes without which there is no start: as many as a cylinder has degrees of freedom.
const MIN_VOTES: usize = 5;
/// Points farther from the middle than this part of the way to a limb do not vote: near a limb depth is
/// worst, and the vote steepest.
const CENTRAL_PART: f64 = 0.9;
/// Trials of the grid; the refinement finds its way from half their distance, 4°.
const TRIALS: usize = 24;
/// Least angle between the axis and the rays to the ends of the segments, in radians.
const LEAST_ANGLE: f64 = 0.05;
/// Rounds of the refinement at most.
const MAX_ROUNDS: usize = 8;
/// Largest change of the tilt in one round, in radians.
const MAX_TURN: f64 = 0.2;
/// A change of the tilt below this ends the refinement, in radians: far below what depth noise leaves, and
/// where the next change is of the order of its square when there is no noise.
const SMALL_TURN: f64 = 1e-4;
/// Step of the difference quotient in the tilt, in radians.
const DIFFERENCE_STEP: f64 = 1e-5;
/// Residuals of logarithmic votes count as at least this large, so that exact data do not divide by zero.
const LEAST_SIGMA: f64 = 1e-12;

/// The cylinder, seen from outside, whose limbs cover two segments in the image and whose near wall carries
/// most of the points.
///
/// `first` and `second` hold the rays (z = 1, any positive length) through the ends of two segments, one on
/// each limb, in any order and direction; `points` are measured points. Both are in the frame of the camera,
/// whose optical centre is the origin. The result is in the unit of length of the points. A third of the
/// points may be gross outliers (background, occluders, flying pixels); non-finite ones are ignored. At most
/// 300 of the points are used, spread over the whole slice by a fixed rule.
///
/// The radius is as good as the segments: its relative error is that of their distance in the image. The tilt
/// in depth and the distance come from the points.
///
/// `None` when the segments bound no cylinder (an end given twice, both on one limb, a view along the axis) or
/// fewer than five points lie between them.
#[must_use]
pub fn from_limbs(
    first: &[Vector3<f64>; 2],
    second: &[Vector3<f64>; 2],
    points: &[Vector3<f64>],
) -> Option<Cylinder> {
    let limbs = LimbPair::new(first, second)?;
    let middle = limbs.unit_cylinder(0.5 * (limbs.tilt_range.0 + limbs.tilt_range.1));
    let mut central = Points::default();
    spread_sample(points, MAX_POINTS).filter(|p| is_central(&middle, p)).for_each(|p| central.push(&p));
    let points = central;
    if points.len() < MIN_VOTES {
        return None;
    }
    let (tilt, log_scale) = refine(&limbs, &points, grid_search(&limbs, &points)?)?;
    let frame = limbs.unit_cylinder(tilt);
    let scale = log_scale.exp();
    Cylinder::new(frame.toward * scale, frame.direction, frame.sin_gamma * scale).ok()
}

/// Two limb segments and their median plane, in which the axis lies.
struct LimbPair {
    /// Rays of unit length to the ends of the segments.
    rays: [[Vector3<f64>; 2]; 2],
    /// Unit normal of the median plane.
    normal: Vector3<f64>,
    /// Unit vector in the median plane towards the middle of the segments: tilt 0 is a view along the axis.
    forward: Vector3<f64>,
    /// Unit vector in the median plane across `forward`: tilt π/2.
    across: Vector3<f64>,
    /// Tilts at which all ends of the segments lie on one side of the axis, in front of the observer.
    tilt_range: (f64, f64),
}

impl LimbPair {
    fn new(first: &[Vector3<f64>; 2], second: &[Vector3<f64>; 2]) -> Option<Self> {
        let [a, b] = first.map(|v| v.normalize());
        let [mut c, mut d] = second.map(|v| v.normalize());
        if (b - a).dot(&(d - c)) < 0.0 {
            std::mem::swap(&mut c, &mut d);
        }
        let [n1, n2] = [a.cross(&b), c.cross(&d)].map(|n| n.try_normalize(1e-9));
        let normal = (n1? + n2?).try_normalize(1e-9)?;
        let sum = a + b + c + d;
        let forward = (sum - normal * sum.dot(&normal)).try_normalize(1e-9)?;
        let across = normal.cross(&forward);
        let angle = |ray: Vector3<f64>| ray.dot(&across).atan2(ray.dot(&forward));
        let [low, high] = min_max_of([a, b, c, d].into_iter().map(angle));
        let tilt_range = (high + LEAST_ANGLE, low + std::f64::consts::PI - LEAST_ANGLE);
        (tilt_range.0 < tilt_range.1).then_some(Self {
            rays: [[a, b], [c, d]],
            normal,
            forward,
            across,
            tilt_range,
        })
    }

    /// The cylinder at distance 1 with the axis at an angle `tilt` from `forward` in the median plane whose
    /// limb planes fit the segments best.
    fn unit_cylinder(&self, tilt: f64) -> LimbFrame {
        let (sine, cosine) = tilt.sin_cos();
        let direction = self.forward * cosine + self.across * sine;
        let depth = self.forward * sine - self.across * cosine;
        // A plane through the observer and the axis direction appears in the plane across the axis as a line
        // through the origin, at an angle from `depth`: least squares over the ends of the segment.
        let [a, b] = self.rays.map(|ends| {
            let (mut product, mut square) = (0.0, 0.0);
            for ray in ends {
                let y = ray.dot(&depth);
                product += ray.dot(&self.normal) * y;
                square += y * y;
            }
            product.atan2(square)
        });
        let (turn_sine, turn_cosine) = (0.5 * (a + b)).sin_cos();
        let toward = self.normal * turn_sine + depth * turn_cosine;
        let (sin_gamma, cos_gamma) = (0.5 * (a - b).abs()).sin_cos();
        LimbFrame {
            toward,
            sideways: direction.cross(&toward),
            direction,
            distance: 1.0,
            sin_gamma,
            cos_gamma,
        }
    }
}

/// At most `limit` of the points, evenly spread over the slice.
fn spread_sample(points: &[Vector3<f64>], limit: usize) -> impl Iterator<Item = Vector3<f64>> {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let count = points.len().min(limit);
    let stride = points.len() as f64 / count as f64;
    (0..count).map(move |i| {
        // A constant stride could match the rows of an image and sample a single column.
        let jitter = if stride > 1.0 { (i as f64 * GOLDEN).fract() } else { 0.0 };
        points[(((i as f64 + jitter) * stride) as usize).min(points.len() - 1)]
    })
}

/// Whether the ray to a point runs between the limbs and not close to either.
fn is_central(frame: &LimbFrame, p: &Vector3<f64>) -> bool {
    let ahead = p.dot(&frame.toward) * frame.sin_gamma;
    let aside = p.dot(&frame.sideways) * frame.cos_gamma;
    ahead > 0.0 && aside.abs() < CENTRAL_PART * ahead
}

/// The tilt and the logarithm of the scale at which the votes agree best among evenly spaced tilts.
fn grid_search(limbs: &LimbPair, points: &Points) -> Option<(f64, f64)> {
    let points = points.every(points.len().div_ceil(MAX_GRID_POINTS));
    let (low, high) = limbs.tilt_range;
    let (mut votes, mut scales) = (List::with_capacity(MAX_GRID_POINTS), List::new());
    let mut vote_at = |tilt: f64, votes: &mut List<u64>| {
        points.vote(&limbs.unit_cylinder(tilt), &mut scales);
        votes.clear();
        // Votes have no sign: their bits have the same order, and are quicker to compare.
        votes.extend(scales.iter().map(|scale| scale.to_bits()));
    };
    // Bounds are quicker to find than the ratios, of which few are below those of all others.
    let mut trials: [(f64, f64); TRIALS] = std::array::from_fn(|i| {
        let tilt = low + (high - low) * (i as f64 / (TRIALS - 1) as f64);
        vote_at(tilt, &mut votes);
        (least_ratio(&mut votes), tilt)
    });
    trials.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut best = (f64::INFINITY, 0.0, 0.0);
    for (least, tilt) in trials {
        if least >= best.0 {
            break;
        }
        vote_at(tilt, &mut votes);
        let (ratio, center) = shortest_half(&mut votes);
        if ratio < best.0 {
            best = (ratio, tilt, center);
        }
    }
    let (ratio, tilt, center) = best;
    ratio.is_finite().then(|| (tilt, center.ln()))
}

/// A bound from below of the ratio that [`shortest_half`] finds among five or more votes, by their bits. An interval of more than
/// half of them holds their median: it reaches from there either to the quarter below it or to the quarter above.
fn least_ratio(votes: &mut [u64]) -> f64 {
    let (middle, quarter) = (votes.len() / 2, votes.len() / 4);
    let (below, &mut median, above) = votes.select_nth_unstable(middle);
    let low = *below.select_nth_unstable(quarter).1;
    let high = *above.select_nth_unstable(quarter - 1).1;
    let [low, median, high] = [low, median, high].map(f64::from_bits);
    f64::min(median / low, high / median)
}

/// The smallest ratio between the ends of an interval that holds more than half of the votes, given by their bits, and its
/// geometric middle. A missing vote is infinite: so is the ratio when no more than half of them are there.
fn shortest_half(votes: &mut [u64]) -> (f64, f64) {
    votes.sort_unstable();
    let mut best = (f64::INFINITY, f64::INFINITY);
    for window in votes.windows(votes.len() / 2 + 1) {
        let [low, high] = [window[0], window[window.len() - 1]].map(f64::from_bits);
        if high / low < best.0 {
            best = (high / low, (low * high).sqrt());
        }
    }
    best
}

/// Tilt and logarithmic scale μ by iteratively reweighted least squares: ln s = μ for all votes s, with
/// Tukey's weights and the standard deviation from the median residual.
///
/// Logarithms, because a view along the axis shortens all distances alike, and should gain nothing by that.
fn refine(limbs: &LimbPair, points: &Points, start: (f64, f64)) -> Option<(f64, f64)> {
    let (mut tilt, mut log_scale) = start;
    let (low, high) = limbs.tilt_range;
    let mut slopes = List::filled(0.0, points.len());
    let (mut here, mut beside) = (List::new(), List::new());
    // A missing vote is a residual that is not finite.
    let mut linearise = |tilt: f64, log_scale: f64, residuals: &mut [f64], slopes: &mut [f64]| {
        points.vote(&limbs.unit_cylinder(tilt), &mut here);
        points.vote(&limbs.unit_cylinder(tilt + DIFFERENCE_STEP), &mut beside);
        for ((residual, slope), (s, moved)) in residuals.iter_mut().zip(slopes).zip(here.iter().zip(&*beside))
        {
            *slope = (moved - s) / (s * DIFFERENCE_STEP);
            *residual = if slope.is_finite() { s.ln() - log_scale } else { f64::INFINITY };
        }
        residuals.iter().filter(|residual| residual.is_finite()).count() >= MIN_VOTES
    };
    let mut residuals = List::filled(0.0, points.len());
    if !linearise(tilt, log_scale, &mut residuals, &mut slopes) {
        return None;
    }
    Reweighting { rounds: MAX_ROUNDS, scale: Scale::AtLeast(LEAST_SIGMA) }.continue_from(
        &mut residuals,
        |weights, residuals| {
            let (turn, growth) = regress(weights, residuals, &slopes);
            let part = if turn.abs() > MAX_TURN { MAX_TURN / turn.abs() } else { 1.0 };
            tilt = (tilt + part * turn).clamp(low, high);
            log_scale += part * growth;
            if turn.abs() < SMALL_TURN {
                return Some(Progress::Settled);
            }
            linearise(tilt, log_scale, residuals, &mut slopes).then_some(Progress::Moved)
        },
    )?;
    Some((tilt, log_scale))
}

/// The changes (of tilt, of logarithmic scale) that make the weighted squares of the residuals smallest, given their
/// derivatives in the tilt; the tilt stays when the points cannot tell it.
fn regress(weights: &[f64], residuals: &[f64], slopes: &[f64]) -> (f64, f64) {
    let rows = || {
        let rows = weights.iter().zip(residuals.iter().zip(slopes)).map(|(w, (e, s))| (*w, *e, *s));
        rows.filter(|(w, ..)| *w > 0.0)
    };
    let (mut total, mut residual_sum, mut slope_sum) = (0.0, 0.0, 0.0);
    for (w, residual, slope) in rows() {
        total += w;
        residual_sum += w * residual;
        slope_sum += w * slope;
    }
    let (residual_mean, slope_mean) = (residual_sum / total, slope_sum / total);
    let (mut covariance, mut variance) = (0.0, 0.0);
    for (w, residual, slope) in rows() {
        covariance += w * (residual - residual_mean) * (slope - slope_mean);
        variance += w * (slope - slope_mean).powi(2);
    }
    // A slope is about the cotangent of the angle between ray and axis. All are alike when the points lie across
    // the axis: what is left below 1e-8 is rounding in the difference quotient.
    let turn = if variance > 1e-16 * total { -covariance / variance } else { 0.0 };
    (turn, residual_mean + slope_mean * turn)
}

#[cfg(test)]
mod tests {
    use super::*;

    type Segment = [Vector3<f64>; 2];

    /// Rays to the ends of both limbs and the visible points of a piece of a cylinder around `center`.
    fn view(cylinder: &Cylinder, center: &Vector3<f64>, length: f64) -> ([Segment; 2], Vec<Vector3<f64>>) {
        let d = cylinder.axis.direction;
        let segments = LimbFrame::new(cylinder).unwrap().limb_lines().map(|line| {
            [-0.5, 0.5].map(|side| {
                let end = line.nearest_to(center) + d * (side * length);
                end / end.z
            })
        });
        let mut points = Vec::new();
        for i in -80_i32..=80 {
            for j in -80_i32..=80 {
                let ray = center / center.z + Vector3::new(f64::from(i), f64::from(j), 0.0) * 0.002;
                let hit = cylinder.first_hit(&ray);
                points.extend(hit.filter(|p| ((p - center).dot(&d)).abs() < 0.5 * length));
            }
        }
        assert!(points.len() > 100, "{}", points.len());
        (segments, points)
    }

    /// Cylinders at all orientations in the image and tilts in depth up to 75°.
    fn views() -> Vec<(Cylinder, [Segment; 2], Vec<Vector3<f64>>)> {
        let mut views = Vec::new();
        for (i, tilt) in [-75.0, -60.0, -45.0, -20.0, 0.0, 10.0, 35.0, 60.0, 75.0_f64].iter().enumerate() {
            for turn in [0.0, 40.0, 90.0, 155.0_f64] {
                let radius = [0.012, 0.03, 0.06][i % 3];
                let center = Vector3::new(0.05, -0.03, 0.7) + Vector3::new(0.1, 0.1, 0.2) * (turn / 200.0);
                let (sine, cosine) = turn.to_radians().sin_cos();
                let (depth, lateral) = tilt.to_radians().sin_cos();
                let d = Vector3::new(cosine * lateral, sine * lateral, depth);
                let cylinder = Cylinder::new(center, d, radius).unwrap();
                let (segments, points) = view(&cylinder, &center, 0.15);
                views.push((cylinder, segments, points));
            }
        }
        views
    }

    #[test]
    fn no_interval_of_half_of_the_votes_is_shorter_than_its_bound() {
        for count in 5..60 {
            let votes: Vec<u64> = noise(count)
                .take(count)
                .map(|x| if x > 0.7 { f64::INFINITY } else { (1.5 + x).powi(3) })
                .map(f64::to_bits)
                .collect();
            let least = least_ratio(&mut votes.clone());
            let (ratio, _) = shortest_half(&mut votes.clone());
            assert!(least <= ratio && least >= 1.0, "{least} {ratio} of {count}");
            // Of equal steps the quarters are about half as wide.
            let steps =
                |count: usize| (0..count).map(|k| (1.0 + 1e-6 * k as f64).to_bits()).collect::<Vec<_>>();
            let (least, (ratio, _)) = (least_ratio(&mut steps(count)), shortest_half(&mut steps(count)));
            assert!(least - 1.0 >= 0.3 * (ratio - 1.0), "{least} {ratio} of {count}");
        }
    }

    /// Numbers in [−1, 1) without apparent order.
    fn noise(seed: usize) -> impl Iterator<Item = f64> {
        let mut state = seed as u64;
        std::iter::repeat_with(move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        })
    }

    fn assert_close(truth: &Cylinder, found: &Cylinder, angle: f64, relative: f64) {
        let difference = truth.compare(found);
        let text = format!("{truth:?} {found:?} {difference:?}");
        assert!(difference.angle < angle, "{text}");
        assert!(difference.radius_relative.abs() < relative, "{text}");
        let center = truth.axis.point;
        assert!(found.axis.distance(&center) < relative * center.norm(), "{text}");
    }

    #[test]
    fn exact_limbs_and_points_give_back_the_cylinder() {
        for (cylinder, [first, second], points) in views() {
            let found = from_limbs(&first, &second, &points).unwrap();
            assert_close(&cylinder, &found, 1e-6, 1e-6);
        }
    }

    #[test]
    fn order_and_direction_of_the_segments_do_not_matter() {
        for (cylinder, [first, second], points) in views() {
            let [flipped_first, flipped_second] = [[first[1], first[0]], [second[1], second[0]]];
            for (a, b) in [(second, first), (flipped_first, second), (first, flipped_second)] {
                assert_close(&cylinder, &from_limbs(&a, &b, &points).unwrap(), 1e-6, 1e-6);
            }
            // The lengths of the rays do not matter either, nor does the unit of length of the points.
            let millimetres: Vec<_> = points.iter().map(|p| p * 1000.0).collect();
            let longer = first.map(|v| v * 3.0);
            let found = from_limbs(&longer, &second, &millimetres).unwrap();
            assert!((found.radius / (1000.0 * cylinder.radius) - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn noise_and_a_third_of_outliers_leave_a_useful_start() {
        for (i, (cylinder, [first, second], mut points)) in views().into_iter().enumerate() {
            let count = points.len();
            for (k, (p, e)) in points.iter_mut().zip(noise(i)).enumerate() {
                *p *= 1.0 + 0.002 * e;
                // A bar in front, a wall behind, and single wrong depths, a tenth of the points each.
                match (10 * k / count, k % 8) {
                    (2, _) => *p *= 0.5 / p.z,
                    (5, _) => *p *= 1.1 / p.z,
                    (_, 3) => *p *= 1.0 + 0.4 * e,
                    _ => {}
                }
            }
            let found = from_limbs(&first, &second, &points).unwrap();
            assert_close(&cylinder, &found, 0.02, 0.01);
        }
    }

    #[test]
    fn the_tilt_comes_from_the_points_when_the_segments_are_off_by_a_pixel() {
        for (i, (cylinder, segments, points)) in views().into_iter().enumerate() {
            let tilt = cylinder.axis.direction.z.abs();
            if cylinder.radius < 0.03 || tilt > 0.8 {
                continue;
            }
            let mut errors = noise(i);
            let mut error = || errors.next().unwrap() / 600.0;
            let [first, second] = segments.map(|s| s.map(|v| v + Vector3::new(error(), error(), 0.0)));
            assert_close(&cylinder, &from_limbs(&first, &second, &points).unwrap(), 0.03, 0.1);
        }
    }

    #[test]
    fn segments_that_bound_no_cylinder_give_none() {
        let (_, [first, second], points) = views().swap_remove(17);
        let none = |a: &Segment, b: &Segment, p: &[Vector3<f64>]| assert_eq!(from_limbs(a, b, p), None);
        none(&[first[0], first[0]], &second, &points);
        none(&first, &[Vector3::zeros(), second[1]], &points);
        none(&first, &[Vector3::repeat(f64::NAN), second[1]], &points);
        none(&first, &first, &points);
        none(&first, &[first[1], first[0].lerp(&first[1], 0.3)], &points);
        none(&first, &second, &[]);
        none(&first, &second, &points[..MIN_VOTES - 1]);
        let behind: Vec<_> = points.iter().map(|p| -p).collect();
        none(&first, &second, &behind);
        none(&first, &second, &vec![Vector3::repeat(f64::NAN); 50]);
        none(&first, &second, &vec![Vector3::zeros(); 50]);
        // All around the direction of the axis.
        let corner = |x: f64, y: f64| Vector3::new(x, y, 1.0);
        let wide = 1e3;
        none(&[corner(wide, -0.1), corner(-wide, -0.1)], &[corner(wide, 0.1), corner(-wide, 0.1)], &points);
    }

    #[test]
    fn crossing_and_odd_segments_give_a_finite_cylinder_or_none() {
        let mut given = 0;
        for (i, (_, [first, second], mut points)) in views().into_iter().enumerate() {
            points.extend([f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, 1e-300].map(Vector3::repeat));
            let crossing = ([first[0], second[1]], [second[0], first[1]]);
            let mut numbers = noise(i);
            let mut any = || [(); 2].map(|()| Vector3::from_fn(|_, _| numbers.next().unwrap()));
            let mut pairs = vec![crossing, (first, [second[0], first[1]]), (first, first.map(|v| v * 1.001))];
            pairs.extend((0..30).map(|_| (any(), any())));
            pairs.extend((0..30).map(|_| (first.map(|v| v + any()[0] * 0.1), any())));
            for (a, b) in pairs {
                for cloud in [&points[..], &points[points.len() - 12..]] {
                    if let Some(found) = from_limbs(&a, &b, cloud) {
                        let Cylinder { axis, radius } = found;
                        assert!(Cylinder::new(axis.point, axis.direction, radius).is_ok(), "{found:?}");
                        given += 1;
                    }
                }
            }
        }
        assert!(given > 100, "{given}");
    }

    #[test]
    fn points_in_one_image_column_per_stride_are_not_the_sample() {
        // 300 rows of 64: a constant stride of 64 would take one column.
        let points: Vec<_> = (0..300 * 64).map(|i| Vector3::new(f64::from(i % 64), 0.0, 1.0)).collect();
        let columns: Vec<_> = spread_sample(&points, 300).map(|p| p.x).collect();
        assert_eq!(columns.len(), 300);
        let mean = columns.iter().sum::<f64>() / 300.0;
        assert!((mean - 31.5).abs() < 2.0, "{mean}");
        assert_eq!(spread_sample(&points[..7], 300).collect::<Vec<_>>(), points[..7]);
    }
}
