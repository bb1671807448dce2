//! The ends as points alone show them: without a mask, and from inside a pipe.
//!
//! A surface ends somewhere between its last point and where the next one would be. Between points at positions that have
//! nothing to do with the end, the way from the last one to the end has the mean Σg² / 2Σg and the mean square Σg³ / 3Σg over
//! the gaps g between neighbours: half a spacing on a grid, a whole one where points lie at random.

use super::{End, EndSource, EndState};
use crate::geometry::Cylinder;
use crate::memory::List;
use crate::statistics::median_and_deviation;
use nalgebra::Vector3;

constants! {
    /// The most strips along the axis, with as many points each, of which each tells both ends.
    STRIPS = 12.0, "";

    /// The fewest points of a strip, if there are enough for two.
    LEAST_OF_STRIP = 24.0, "";

    /// The fewest points of a piece of surface behind a gap: fewer happen to lie where the surface would go on.
    LEAST_POINTS = 8.0, "";

    /// The least width of a strip.
    LEAST_WIDTH = 3.0, "spacing";

    /// The outer part of a strip whose gaps count for the way from its last point to the end, unless there are hardly any.
    LAST_PART = 0.25, "length";

    /// A gap this many times as long as the way to be expected may be the end of a strip,
    DIVIDING = 8.0, "";

    /// if it is so many times as long as the longest of the last ones as well: seen from inside a pipe, points become sparser with the
    /// cube of the distance, and the last gap is the longest by far.
    SPARSER = 3.0, "";

    /// What lies farther from the surface than this part of the radius is not on it, however much the points scatter.
    WIDEST = 0.5, "radius";

    /// Strips whose end is this many deviations off do not count: something hides the surface there, or it is torn.
    FAR = 3.0, "σ";
}

/// The middle of points all around an axis lies this near to it, as a part of the radius.
const LEAST_MIDDLE: f64 = 1e-6;

/// One part in so many of the points at either end tells nothing about the spacing of the others.
const OUTER: usize = 10;

/// Two rows of points have a single gap, and no hole: without it there is less than this part of them.
const LEAST_REST: f64 = 0.05;

/// So many points, evenly spread over all on the surface, are enough.
const MOST_POINTS: usize = 1 << 17;

/// The ends of what lies on a cylinder within the tolerance; `None` where that is a single row of points across the axis, or less.
///
/// The errors of `alike` points in a row are alike, of one where all are independent: what a sensor measures in one position it has from a
/// window of that width. Where within the last one the surface ends, nothing tells: depth is missing there, or is measured beyond it.
#[must_use]
pub fn ends_of_points(
    points: impl Iterator<Item = Vector3<f64>> + Clone,
    cylinder: &Cylinder,
    tolerance: f64,
    alike: f64,
) -> Option<[End; 2]> {
    let (coordinates, middle) = on_surface(points, cylinder, tolerance.min(WIDEST.get() * cylinder.radius));
    if coordinates.is_empty() {
        return None;
    }
    let inner = coordinates.len() / 20;
    let arc = cylinder.radius * (coordinates[coordinates.len() - 1 - inner].0 - coordinates[inner].0);
    let all = surface_of(&coordinates);
    // Points may become sparser along the axis, as those of what leads away from a scanner do.
    let spacings = [-1.0, 1.0].map(|outward| {
        let beside = outer_part(&all, outward);
        (arc * (beside[beside.len() - 1] - beside[0]) / beside.len() as f64).sqrt()
    });
    let strips = strips_of(&coordinates, arc, spacings[0].max(spacings[1]));
    let [start, end] = [-1.0, 1.0].map(|outward| end_of(&strips, outward));
    let (start, end) = (start?, end?);
    let length = end.position - start.position;
    let shown = |end: EndOfStrips, spacing: f64| {
        // Anywhere within it.
        let of_window = alike * spacing.max(end.way) / 12.0_f64.sqrt();
        let middle = Some(cylinder.axis.at(end.position) + middle);
        let deviation = Some(end.variance.sqrt().hypot(of_window));
        End { middle, ..End::new(end.position, deviation, EndState::Unknown, EndSource::Points) }
    };
    // One row across the axis has no ends.
    (length * coordinates.len() as f64 > arc).then(|| [shown(start, spacings[0]), shown(end, spacings[1])])
}

/// The positions on the surface by strip, each in order. A strip is at least three spacings wide: one that is narrower than a column of
/// points would be a section of it.
fn strips_of(coordinates: &[(f64, f64)], arc: f64, spacing: f64) -> List<List<f64>> {
    let most = (coordinates.len() / LEAST_OF_STRIP.count()).min(STRIPS.count());
    let count = ((arc / (LEAST_WIDTH.get() * spacing)) as usize).min(most).max(1);
    (0..count)
        .map(|k| surface_of(&coordinates[k * coordinates.len() / count..(k + 1) * coordinates.len() / count]))
        .collect()
}

/// Nearly all of positions in order, without those farthest out.
fn inner_part(positions: &[f64]) -> &[f64] {
    let outer = positions.len() / OUTER;
    &positions[outer..positions.len() - outer]
}

/// Angle about the axis and position along it of the points on a cylinder, around it from the side that most of them are away from, and
/// the mean of how they lie off the axis.
fn on_surface(
    points: impl Iterator<Item = Vector3<f64>> + Clone,
    cylinder: &Cylinder,
    tolerance: f64,
) -> (List<(f64, f64)>, Vector3<f64>) {
    let axis = &cylinder.axis;
    let on_it = points.filter(|point| cylinder.distance(point).abs() <= tolerance);
    let step = on_it.clone().count().div_ceil(MOST_POINTS).max(1);
    let on_it: List<_> = on_it.step_by(step).collect();
    let sum: Vector3<f64> = on_it.iter().map(|point| point - axis.nearest_to(point)).sum();
    let middle = sum / (on_it.len() as f64).max(1.0);
    let mut least_along = Vector3::zeros();
    least_along[axis.direction.iamin()] = 1.0;
    // All around a cylinder any side will do: what is left of the middle is rounding, and may lie along the axis.
    let is_a_side = middle.norm() > LEAST_MIDDLE * cylinder.radius;
    let sideways = axis.direction.cross(if is_a_side { &middle } else { &least_along }).normalize();
    let toward = sideways.cross(&axis.direction);
    let coordinates = |point: &Vector3<f64>| {
        let across = point - axis.point;
        (across.dot(&sideways).atan2(across.dot(&toward)), across.dot(&axis.direction))
    };
    let mut coordinates: List<_> = on_it.iter().map(coordinates).collect();
    coordinates.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    (coordinates, middle)
}

/// The positions in order, from the first to the last that lie on the surface.
fn surface_of(coordinates: &[(f64, f64)]) -> List<f64> {
    let mut positions: List<f64> = coordinates.iter().map(|coordinates| coordinates.1).collect();
    positions.sort_unstable_by(f64::total_cmp);
    let backward: List<f64> = positions.iter().rev().map(|position| -position).collect();
    let usual = usual_way(inner_part(&positions));
    let first = positions.len() - on_surface_before(&backward, usual);
    let last = on_surface_before(&positions, usual);
    positions[first..last].iter().copied().collect()
}

/// The outer part of a surface at one of its ends.
fn outer_part(positions: &[f64], outward: f64) -> &[f64] {
    let (first, last) = (positions[0], positions[positions.len() - 1]);
    let part = LAST_PART.get() * (last - first);
    let beside = if outward < 0.0 {
        &positions[..positions.partition_point(|position| *position <= first + part)]
    } else {
        &positions[positions.partition_point(|position| *position < last - part)..]
    };
    // Of few rows the part may hold a single one.
    let is_enough = beside[beside.len() - 1] - beside[0] > 0.5 * part;
    if is_enough { beside } else { positions }
}

/// The mean way to the end of points at these positions, but for a hole: without the longest gap, unless that is nearly all there is.
fn usual_way(positions: &[f64]) -> f64 {
    let all = Gaps::of(positions);
    let longest = positions.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    let others = Gaps { sums: std::array::from_fn(|k| all.sums[k] - longest.powi(k as i32 + 1)) };
    if others.sums[0] > LEAST_REST * all.sums[0] { others.mean_way() } else { all.mean_way() }
}

/// How many of the positions, in order on the way out, are not beyond the surface of the middle one. It goes on over gaps of up to
/// [`DIVIDING`] times the usual way to its end, in all or in the part before the gap, or of [`SPARSER`] times the last ones, and behind a
/// longer one where there are enough points for a piece of surface.
fn on_surface_before(positions: &[f64], usual: f64) -> usize {
    let low = inner_part(positions)[0];
    let middle = positions.len() / 2;
    let (mut kept, mut begin) = (middle + 1, middle);
    // Behind an end there may be thousands of strays, each after a wide gap.
    let mut way_before = None;
    for k in middle + 1..positions.len() {
        let gap = positions[k] - positions[k - 1];
        let is_wide = |way: f64| gap > DIVIDING.get() * way;
        let before = || usual_way(part_before(&positions[..kept], low));
        let last = &positions[kept.saturating_sub(LEAST_POINTS.count() + 1)..kept];
        let is_longest = || last.windows(2).all(|pair| gap > SPARSER.get() * (pair[1] - pair[0]));
        if is_wide(usual) && is_longest() && is_wide(*way_before.get_or_insert_with(before)) {
            begin = k;
        }
        if begin == middle || k + 1 - begin >= LEAST_POINTS.count() {
            kept = k + 1;
            way_before = None;
        }
    }
    kept
}

/// The outer part of positions that begin at `low`, but enough of them to tell how far apart they are.
fn part_before(positions: &[f64], low: f64) -> &[f64] {
    let last = positions[positions.len() - 1];
    let begin = positions.partition_point(|position| *position < last - LAST_PART.get() * (last - low));
    &positions[begin.min(positions.len().saturating_sub(LEAST_OF_STRIP.count()))..]
}

/// An end as all strips tell it.
struct EndOfStrips {
    position: f64,
    /// By the ways between points alone.
    variance: f64,
    /// The mean way from the last point to the end.
    way: f64,
}

/// The end of all strips towards `outward`.
fn end_of(strips: &[List<f64>], outward: f64) -> Option<EndOfStrips> {
    let mut gaps = Gaps::default();
    for strip in strips.iter().filter(|strip| !strip.is_empty()) {
        gaps.add(outer_part(strip, outward));
    }
    let (way, of_way) = (gaps.mean_way(), gaps.variance_of_way());
    let last = |strip: &List<f64>| if outward < 0.0 { strip.first() } else { strip.last() }.copied();
    let mut ends: List<f64> = strips.iter().filter_map(last).map(|last| last + outward * way).collect();
    let [middle, spread] = median_and_deviation(&mut ends.clone());
    let far = FAR.get() * spread.max(of_way.sqrt());
    ends.retain(|end| (end - middle).abs() <= far);
    if ends.is_empty() {
        return None;
    }
    let count = ends.len() as f64;
    let position = ends.iter().sum::<f64>() / count;
    let scatter = ends.iter().map(|end| (end - position).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
    // Strips that agree better than the ways between their points differ have their points at the same positions, as rows of pixels
    // have them: what the end is off by is then the same in all.
    let common = if ends.len() > 1 { (of_way - scatter).max(0.0) } else { 0.0 };
    Some(EndOfStrips { position, variance: scatter.max(of_way) / count + common, way })
}

/// The sums of the powers of gaps between neighbours.
#[derive(Debug, Default)]
struct Gaps {
    sums: [f64; 3],
}

impl Gaps {
    fn of(positions: &[f64]) -> Self {
        let mut gaps = Self::default();
        gaps.add(positions);
        gaps
    }

    fn add(&mut self, positions: &[f64]) {
        for pair in positions.windows(2) {
            let gap = (pair[1] - pair[0]).abs();
            let [first, second, third] = &mut self.sums;
            (*first, *second, *third) = (*first + gap, *second + gap.powi(2), *third + gap.powi(3));
        }
    }

    /// The mean way from the last point to the end, Σg² / 2Σg.
    fn mean_way(&self) -> f64 {
        let [first, second, _] = self.sums;
        if first > 0.0 { second / (2.0 * first) } else { 0.0 }
    }

    /// Its variance, Σg³ / 3Σg less the square of the mean.
    fn variance_of_way(&self) -> f64 {
        let [first, _, third] = self.sums;
        if first > 0.0 { third / (3.0 * first) - self.mean_way().powi(2) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};

    const ENDS: [f64; 2] = [-0.0613, 0.0592];
    const TOLERANCE: f64 = 0.004;

    fn cylinder() -> Cylinder {
        Cylinder::new(Vector3::new(0.01, -0.005, 0.7), Vector3::new(0.3, 0.9, 0.2), 0.04).unwrap()
    }

    /// The point at an angle and a position.
    fn point(angle: f64, position: f64) -> Vector3<f64> {
        let Cylinder { axis, radius } = cylinder();
        let across = axis.direction.cross(&Vector3::x()).normalize();
        let other = axis.direction.cross(&across);
        axis.at(position) + (across * angle.cos() + other * angle.sin()) * radius
    }

    /// Rows across the axis, `spacing` apart, the first one `first` beyond the start.
    fn rows(spacing: f64, first: f64) -> impl Iterator<Item = Vector3<f64>> {
        let count = ((ENDS[1] - ENDS[0] - first) / spacing) as usize + 1;
        let position = move |k: usize| ENDS[0] + first + spacing * k as f64;
        (0..count).flat_map(move |k| (0..50).map(move |j| point(1.0 + 0.04 * f64::from(j), position(k))))
    }

    fn number(rng: &mut ChaCha8Rng) -> f64 {
        f64::from(rng.next_u32()) / f64::from(u32::MAX)
    }

    fn random(rng: &mut ChaCha8Rng, count: usize, [low, high]: [f64; 2]) -> Vec<Vector3<f64>> {
        (0..count).map(|_| point(1.0 + 2.0 * number(rng), low + (high - low) * number(rng))).collect()
    }

    fn ends(points: impl Iterator<Item = Vector3<f64>>) -> [End; 2] {
        let points: Vec<_> = points.collect();
        ends_of_points(points.into_iter(), &cylinder(), TOLERANCE, 1.0).unwrap()
    }

    #[test]
    fn rows_end_half_a_spacing_after_the_last_one() {
        for [spacing, first] in [[2e-3, 0.0], [2e-3, 1e-3], [5e-3, 4e-3]] {
            for (end, truth) in ends(rows(spacing, first)).iter().zip(ENDS) {
                let off = (end.position - truth).abs();
                assert!(off <= 0.5 * spacing + 1e-9, "{spacing} {first}: {off}");
                // All strips end alike, so that none tells more than another.
                assert!(end.deviation.unwrap() > 0.28 * spacing, "{end:?}");
                assert_eq!((end.state, end.source), (EndState::Unknown, EndSource::Points));
            }
        }
    }

    /// As a scanner inside a pipe sees it, from the middle of 10 to 30 radii. The mean was 20 % too short, the worst 42 %; now 7 and 31 %.
    #[test]
    fn points_that_become_sparser_end_where_the_last_ones_are() {
        let (mut rng, cylinder) = (ChaCha8Rng::seed_from_u64(3), cylinder());
        let (mut parts, trials) = (vec![], 20);
        for k in 0..trials {
            let half = cylinder.radius * (5.0 + 10.0 * f64::from(k) / f64::from(trials));
            let seen = |_| {
                // Directions are evenly spread over a sphere.
                let z = 2.0 * number(&mut rng) - 1.0;
                (std::f64::consts::TAU * number(&mut rng), cylinder.radius * z / (1.0 - z * z).sqrt())
            };
            let seen: Vec<(f64, f64)> =
                (0..10_000).map(seen).filter(|(_, along)| along.abs() < half).collect();
            let [start, end] = ends(seen.iter().map(|(angle, along)| point(*angle, *along)));
            parts.push((end.position - start.position) / (2.0 * half));
        }
        let [mean, least] =
            [parts.iter().sum::<f64>() / 20.0, parts.iter().fold(1.0, |a, b| f64::min(a, *b))];
        assert!(mean > 0.9 && least > 0.65, "{mean} {least}");
    }

    #[test]
    fn random_points_end_a_mean_gap_after_the_last_one() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut sum = [0.0; 2];
        let trials = 200;
        for _ in 0..trials {
            let found = ends(random(&mut rng, 600, ENDS).into_iter());
            for ((end, truth), sum) in found.iter().zip(ENDS).zip(&mut sum) {
                *sum += (end.position - truth) / f64::from(trials);
                assert!((end.position - truth).abs() < 4.0 * end.deviation.unwrap());
            }
        }
        // Fifty points of a strip lie 2.4 mm apart, and twelve strips see each end.
        assert!(sum.iter().all(|off| off.abs() < 2.4e-4), "{sum:?}");
    }

    #[test]
    fn points_elsewhere_do_not_move_the_ends() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let body = random(&mut rng, 2000, ENDS);
        let alone = ends(body.iter().copied());
        // Some near where the surface would go on, others far from it.
        let strays = random(&mut rng, 60, [-0.5, 0.5]);
        let cap = (0..500).map(|_| {
            let far = point(1.0 + 2.0 * number(&mut rng), ENDS[1] + 0.01);
            let middle = cylinder().axis.nearest_to(&far);
            middle + (far - middle) * 0.8
        });
        let among = ends(body.iter().copied().chain(strays).chain(cap));
        for (end, alone) in among.iter().zip(&alone) {
            assert!((end.position - alone.position).abs() < alone.deviation.unwrap(), "{end:?} {alone:?}");
        }
    }

    #[test]
    fn a_surface_goes_on_after_a_hole() {
        let body = rows(1e-3, 5e-4).filter(|point| {
            let position = cylinder().axis.position_of(point);
            !(-0.02..0.03).contains(&position)
        });
        for (end, truth) in ends(body).iter().zip(ENDS) {
            assert!((end.position - truth).abs() < 1e-3, "{end:?}");
        }
    }

    #[test]
    fn strays_beside_a_hole_do_not_move_the_ends() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        for strays in [0, 5, 20] {
            let mut points = random(&mut rng, 4000, ENDS);
            points.retain(|point| !(-0.03..0.03).contains(&cylinder().axis.position_of(point)));
            points.extend(random(&mut rng, strays, [-0.5, 0.6]));
            for (end, truth) in ends(points.into_iter()).iter().zip(ENDS) {
                assert!((end.position - truth).abs() < 1e-3, "{strays} {end:?}");
            }
        }
    }

    #[test]
    fn points_may_become_sparser_towards_an_end() {
        // A scanner beside a pipe that leads away from it: points become fewer along and across, and a few lie beyond.
        let mut rng = ChaCha8Rng::seed_from_u64(6);
        let (mut distance, mut points) = (1.0_f64, vec![]);
        while distance < 6.0 {
            let count = 40.0 / distance;
            let first = number(&mut rng);
            points.extend(
                (0..count as i32).map(|j| point(1.0 + 2.0 * (f64::from(j) + first) / count, 0.1 * distance)),
            );
            distance += 0.006 * distance * distance;
        }
        points.extend(random(&mut rng, 8, [-2.0, 3.0]));
        let [start, end] = ends(points.into_iter());
        let last = 0.1 * distance;
        assert!(
            (start.position - 0.1).abs() < 3e-3 && (end.position - last).abs() < 0.03,
            "{start:?} {end:?}"
        );
        assert!(start.deviation.unwrap() < 0.3 * end.deviation.unwrap(), "{start:?} {end:?}");
    }

    #[test]
    fn what_hides_an_end_from_a_few_strips_does_not_shorten() {
        let seen = rows(1e-3, 5e-4).filter(|p| {
            let hidden = (p - cylinder().axis.nearest_to(p))
                .dot(&(point(1.2, 0.0) - point(1.2 + std::f64::consts::PI, 0.0)));
            hidden < 0.98 * 2.0 * 0.04 * 0.04 || cylinder().axis.position_of(p) < 0.0
        });
        assert!((ends(seen)[1].position - ENDS[1]).abs() < 1e-3);
    }

    #[test]
    fn a_cylinder_that_is_seen_all_around_has_ends() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let all_around = random(&mut rng, 3000, ENDS).into_iter().enumerate().map(|(k, near)| {
            let middle = cylinder().axis.nearest_to(&near);
            if k % 2 == 0 { near } else { middle + middle - near }
        });
        let points: Vec<_> = all_around.collect();
        for (end, truth) in ends(points.iter().copied()).iter().zip(ENDS) {
            assert!((end.position - truth).abs() < 1e-3, "{end:?}");
        }
    }

    #[test]
    fn an_exact_grid_all_around_ends_half_a_spacing_after_its_last_row() {
        let step = std::f64::consts::TAU / 30.0;
        let row = |k: u32| (0..30).map(move |j| point(step * f64::from(j), 0.01 * f64::from(k)));
        let found = ends((0..20).flat_map(row));
        assert!(
            (found[0].position + 0.005).abs() < 1e-9 && (found[1].position - 0.195).abs() < 1e-9,
            "{found:?}"
        );
    }

    #[test]
    fn few_columns_and_few_rows_have_the_same_ends() {
        for tilt in [0.0, 0.01] {
            for columns in [1, 2, 3, 4, 5, 6, 8] {
                let all = (0..121).flat_map(|k| {
                    let position = ENDS[0] + 5e-4 + 1e-3 * f64::from(k);
                    let angle = move |j: i32| 1.0 + 0.2 * f64::from(j) + tilt * f64::from(k - 60) / 60.0;
                    (0..columns).map(move |j| point(angle(j), position))
                });
                for (end, truth) in
                    ends(all.filter(|p| cylinder().axis.position_of(p) < ENDS[1])).iter().zip(ENDS)
                {
                    assert!((end.position - truth).abs() < 6e-3, "{columns} {tilt} {end:?}");
                }
            }
        }
        // Six rows of many points.
        let spacing = (ENDS[1] - ENDS[0]) / 6.0;
        for count in [10, 100, 300] {
            let row = |k: i32| {
                (0..count).map(move |j| {
                    point(
                        1.0 + 2.0 * f64::from(j) / f64::from(count),
                        ENDS[0] + spacing * (0.5 + f64::from(k)),
                    )
                })
            };
            for (end, truth) in ends((0..6).flat_map(row)).iter().zip(ENDS) {
                assert!((end.position - truth).abs() < 0.1 * spacing, "{count} {end:?}");
            }
        }
    }

    #[test]
    fn too_little_has_no_ends() {
        let none = |points: Vec<Vector3<f64>>| {
            ends_of_points(points.into_iter(), &cylinder(), TOLERANCE, 1.0).is_none()
        };
        assert!(none(vec![]));
        assert!(none(vec![point(1.0, 0.01)]));
        assert!(none(vec![point(1.0, 0.01); 100]));
        assert!(none((0..100).map(|k| point(0.05 * f64::from(k), 0.01)).collect()));
        assert!(none(rows(1e-3, 0.0).map(|point| point * 2.0).collect()));
        // Two are the least.
        let two = ends([point(1.0, 0.0), point(1.2, 0.01)].into_iter());
        assert!(two[0].position < two[1].position && two[0].deviation.unwrap().is_finite());
    }
}
