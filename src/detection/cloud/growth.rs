//! The body of a region of a cloud: all points on its surface, as far along the axis as that goes on.
//!
//! What one look shows of a body is a side of it, and often a piece: the rest lies behind something, or beyond the image.

use super::members::reach;
use crate::geometry::{Cylinder, any_orthogonal};
use crate::statistics::{DEVIATION_OF_MEDIAN, median, median_absolute};
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;
use std::ops::Bound;

constants! {
    /// Points lie on a surface up to this part of the radius from it, at most.
    MOST_REACH = 0.15, "radius";

    /// They scatter by this part of the radius, at most: what fills all of that reach evenly, and is no surface, does by half as much again.
    MOST_SCATTER = 0.5 * MOST_REACH.value, "radius";

    /// The length of a slice of a body, in radii.
    SLICE = 0.5, "radius";

    /// A slice has this part of the points of those before it, at least, and of their spread about the axis: a plane that touches the body
    /// beyond its end has a strip of points on its surface.
    GOES_ON = 0.25, "";

    /// Slices at either end of a region that tell how many points the next one has.
    OUTER = 5.0, "slices";

    /// The part of the points of a region that may lie beyond its ends, to each side.
    STRAY = 0.02, "";

    /// Sectors about the axis, for what of the residuals is not noise.
    SECTORS = 24.0, "";

    /// By how much a body may be out of round, as a part of its radius.
    OUT_OF_ROUND = 0.03, "radius";

    /// By how many standard deviations of its points a body bends, at least.
    LEAST_BEND = 2.0, "σ";
}

/// Which slice a point belongs to.
fn slice_of(cylinder: &Cylinder, point: &Vector3<f64>) -> i64 {
    (cylinder.axis.position_of(point) / (SLICE.get() * cylinder.radius)).floor() as i64
}

/// The direction from the axis to a point.
fn outward(cylinder: &Cylinder, point: &Vector3<f64>) -> Vector3<f64> {
    (point - cylinder.axis.nearest_to(point)).try_normalize(0.0).unwrap_or_default()
}

/// What is counted of a slice: its points, and the sum of their directions from the axis.
#[derive(Clone, Copy, Default)]
struct Slice {
    count: f64,
    directions: Vector3<f64>,
}

impl Slice {
    fn add(&mut self, direction: &Vector3<f64>) {
        self.count += 1.0;
        self.directions += direction;
    }

    fn join(&mut self, other: &Self) {
        self.count += other.count;
        self.directions += other.directions;
    }

    /// How far the directions are spread: 0 on a line along the surface, 1 all around.
    fn spread(&self) -> f64 {
        1.0 - self.directions.norm() / self.count.max(1.0)
    }
}

/// How far from the surface of a cylinder that was fitted to a region the points of its body lie.
fn reach_of(cylinder: &Cylinder, region: impl Iterator<Item = Vector3<f64>>) -> f64 {
    reach(cylinder, region).min(MOST_REACH.get() * cylinder.radius)
}

/// The points of the body of a region, by their numbers: those on the surface of a cylinder that was fitted to it, as far as the body
/// goes on. `points` gives those that may lie within a reach of that surface.
pub(crate) fn grown<P: Iterator<Item = (u32, Vector3<f64>)>>(
    cylinder: &Cylinder,
    region: impl Iterator<Item = Vector3<f64>> + Clone,
    points: impl FnOnce(f64) -> P,
) -> Vec<u32> {
    let reach = reach_of(cylinder, region.clone());
    let mut of_region: Vec<i64> = region.map(|point| slice_of(cylinder, &point)).collect();
    of_region.sort_unstable();
    let stray = (STRAY.get() * of_region.len() as f64) as usize;
    let [first, last] = [of_region[stray], of_region[of_region.len() - 1 - stray]];
    drop(of_region);
    let mut slices: BTreeMap<i64, Slice> = BTreeMap::new();
    // Runs of points in one slice: those that follow each other lie near each other.
    let (mut on_surface, mut runs): (Vec<u32>, Vec<(i64, usize)>) = (Vec::new(), Vec::new());
    let mut of_run = Slice::default();
    for (k, point) in points(reach).filter(|(_, point)| cylinder.distance(point).abs() <= reach) {
        let slice = slice_of(cylinder, &point);
        match runs.last_mut() {
            Some((last, _)) if *last != slice => {
                slices.entry(*last).or_default().join(&std::mem::take(&mut of_run));
                runs.push((slice, on_surface.len()));
            }
            Some(_) => {}
            None => runs.push((slice, 0)),
        }
        of_run.add(&outward(cylinder, &point));
        on_surface.push(k);
    }
    if let Some((last, _)) = runs.last() {
        slices.entry(*last).or_default().join(&of_run);
    }
    let own = || slices.range(first..=last).map(|(_, slice)| slice);
    let spread = median(&mut own().map(Slice::spread).collect::<Vec<f64>>());
    // Points become sparser along a body that leads away from its sensor.
    let typical = |outer: &mut dyn Iterator<Item = &Slice>| {
        median(&mut outer.take(OUTER.count()).map(|slice| slice.count).collect::<Vec<f64>>())
    };
    let typical = [typical(&mut own()), typical(&mut own().rev())];
    // From the region to both sides.
    let mut body: BTreeSet<i64> = slices.range(first..=last).map(|(number, _)| *number).collect();
    let mut follow = |mut count: f64, beyond: &mut dyn Iterator<Item = (&i64, &Slice)>| {
        for (number, slice) in beyond {
            if slice.count >= GOES_ON.get() * count && slice.spread() >= GOES_ON.get() * spread {
                count = 0.5 * (count + slice.count);
                body.insert(*number);
            }
        }
    };
    follow(typical[0], &mut slices.range(..first).rev());
    follow(typical[1], &mut slices.range((Bound::Excluded(last), Bound::Unbounded)));
    // Those of the body move to the front.
    let mut count = 0;
    for (index, (slice, begin)) in runs.iter().enumerate() {
        let end = runs.get(index + 1).map_or(on_surface.len(), |(_, next)| *next);
        if body.contains(slice) {
            on_surface.copy_within(*begin..end, count);
            count += end - begin;
        }
    }
    on_surface.truncate(count);
    on_surface
}

/// Whether points lie on a cylinder, and neither on planes that meet in an edge or pass it by nor on anything else: they scatter by little,
/// what is left of them is noise but for less, and they bend by more than that.
pub(crate) fn is_round(
    cylinder: &Cylinder,
    region: impl ExactSizeIterator<Item = Vector3<f64>> + Clone,
) -> bool {
    let distances = region.clone().map(|point| cylinder.distance(&point));
    let scatter = DEVIATION_OF_MEDIAN * median_absolute(distances);
    scatter <= MOST_SCATTER.get() * cylinder.radius
        && bend(cylinder, region.clone()) >= LEAST_BEND.get() * scatter
        && lack_of_fit(cylinder, region) <= OUT_OF_ROUND.get() * cylinder.radius
}

/// The standard deviation of the residuals of points beyond their noise: of their means over patches of the surface, where the points of
/// one patch tell the noise.
fn lack_of_fit(cylinder: &Cylinder, region: impl Iterator<Item = Vector3<f64>>) -> f64 {
    let (x, y) = any_orthogonal(&cylinder.axis.direction);
    let patch_of = |point: &Vector3<f64>| {
        let outward = outward(cylinder, point);
        let turn = outward.dot(&y).atan2(outward.dot(&x)) / TAU;
        (slice_of(cylinder, point), (turn * SECTORS.get()).floor() as i64)
    };
    let mut patches: BTreeMap<(i64, i64), [f64; 3]> = BTreeMap::new();
    for point in region {
        let residual = cylinder.distance(&point);
        let [count, sum, squares] = patches.entry(patch_of(&point)).or_default();
        (*count, *sum, *squares) = (*count + 1.0, *sum + residual, *squares + residual * residual);
    }
    // Sums of squares of the means of patches, and of their points about these.
    let [mut count, mut within, mut between, mut of_patches] = [0.0; 4];
    for [n, sum, squares] in patches.into_values().filter(|[n, ..]| *n > 2.0) {
        count += n;
        within += squares - sum * sum / n;
        between += sum * sum / n;
        of_patches += 1.0;
    }
    // Noise alone makes the means differ by as much.
    let of_noise = of_patches * within / f64::max(count - of_patches, 1.0);
    ((between - of_noise) / f64::max(count, 1.0)).max(0.0).sqrt()
}

/// By how much the nearer half of the points about the middle of an arc bends away from its tangent: what is flat does by no more than it
/// scatters.
fn bend(cylinder: &Cylinder, region: impl Iterator<Item = Vector3<f64>> + Clone) -> f64 {
    let middle = region.clone().map(|point| outward(cylinder, &point)).sum::<Vector3<f64>>();
    // All around there is none.
    let middle = middle.try_normalize(0.0).unwrap_or_default();
    let depth = |point: Vector3<f64>| cylinder.radius * (1.0 - middle.dot(&outward(cylinder, &point)));
    let mut depths: Vec<f64> = region.map(depth).collect();
    median(&mut depths)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Line;

    /// A cylinder of radius 1 along z.
    fn cylinder() -> Cylinder {
        Cylinder { axis: Line { point: Vector3::zeros(), direction: Vector3::z() }, radius: 1.0 }
    }

    /// Points of the cylinder over half its circumference and a range of z, off by a part of the radius to both sides.
    fn half(from: f64, to: f64, noise: f64) -> Vec<Vector3<f64>> {
        let point = |k: u32| {
            let turn = std::f64::consts::PI * f64::from(k % 41) / 40.0;
            let z = from + (to - from) * f64::from(k / 41) / 40.0;
            let r = 1.0 + noise * f64::from(k % 3) - noise;
            Vector3::new(r * turn.cos(), r * turn.sin(), z)
        };
        (0..41 * 40).map(point).collect()
    }

    #[test]
    fn a_region_grows_as_far_as_its_body_goes_on() {
        let region = half(0.0, 2.0, 0.01);
        let mut points = half(-3.0, 5.0, 0.01);
        points.extend(half(12.0, 14.0, 0.01));
        let own = points.len();
        // A plane that touches the surface beyond, and a wider body.
        for k in 0..4000 {
            let [x, z] = [f64::from(k % 40) / 10.0 - 2.0, 14.1 + f64::from(k / 40) / 10.0];
            points.push(Vector3::new(x, 1.0, z));
        }
        points.extend(half(-6.0, -4.0, 0.01).iter().map(|p| Vector3::new(1.2 * p.x, 1.2 * p.y, p.z)));
        let grown = grown(&cylinder(), region.iter().copied(), |_| (0..).zip(points.iter().copied()));
        assert_eq!(grown, (0..own as u32).collect::<Vec<u32>>());
    }

    /// A body that leads away from its sensor: each slice has nine tenths of the points of the one before.
    #[test]
    fn a_region_grows_to_where_points_are_sparse() {
        let slice = |k: i32| {
            let [from, to] = [f64::from(k), f64::from(k + 1)].map(|z| SLICE.get() * z);
            let every = (1.0 / 0.9_f64.powi(k)).round() as usize;
            half(from + 0.01, to - 0.01, 0.01).into_iter().step_by(every)
        };
        let points: Vec<_> = (0..50).flat_map(slice).collect();
        // Of the region a fiftieth may be stray, which are many slices here.
        let region: Vec<_> = (0..30).flat_map(slice).collect();
        let grown = grown(&cylinder(), region.iter().copied(), |_| (0..).zip(points.iter().copied()));
        assert_eq!(grown.len(), points.len());
    }

    #[test]
    fn round_is_what_bends_by_more_than_its_noise_and_fits() {
        let round = |points: &[Vector3<f64>]| is_round(&cylinder(), points.iter().copied());
        let lack_of_fit = |points: &[Vector3<f64>]| lack_of_fit(&cylinder(), points.iter().copied());
        let bend = |points: &[Vector3<f64>]| bend(&cylinder(), points.iter().copied());
        assert!(round(&half(0.0, 2.0, 0.0)));
        assert!(round(&half(0.0, 2.0, 0.05)));
        // An ellipse.
        let wider = |part: f64| -> Vec<Vector3<f64>> {
            half(0.0, 2.0, 0.01).iter().map(|p| Vector3::new((1.0 + part) * p.x, p.y, p.z)).collect()
        };
        assert!(round(&wider(0.03)));
        assert!(!round(&wider(0.1)));
        // What fills the reach evenly has no lack of fit, and bends.
        let filled: Vec<Vector3<f64>> = (-15..=15)
            .flat_map(|k| {
                half(0.0, 2.0, 0.0).into_iter().map(move |p| {
                    let r = 1.0 + 0.01 * f64::from(k);
                    Vector3::new(r * p.x, r * p.y, p.z)
                })
            })
            .collect();
        assert!(lack_of_fit(&filled) < OUT_OF_ROUND.get() && bend(&filled) > 0.25);
        assert!(!round(&filled));
        // A strip that bends by less than its noise.
        let strip = half(0.0, 2.0, 0.02).into_iter().filter(|p| p.x.abs() < 0.2).collect::<Vec<_>>();
        assert!(lack_of_fit(&strip) < OUT_OF_ROUND.get());
        assert!(!round(&strip));
    }
}
