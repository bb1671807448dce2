//! A cloud in cubes: what is near lies one after the other.

use super::points::Points;
use super::{BETWEEN_QUESTIONS, CancelCheck, STRAY};
use crate::error::Result;
use crate::geometry::Cylinder;
use crate::observations::PointsView;
use crate::statistics::at_both_ends;
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::ops::Range;

/// So many cubes along the longest side of a cloud, as a power of 2. Tiles of all levels have borders of cubes for borders.
const FINE: u32 = super::looks::LEVELS + 1;

/// Cubes beyond the box of a cloud to each side: as many as the largest tiles lie over it.
const MARGIN: u32 = 1 << (FINE - 2);

/// Cubes along each axis.
const COUNT: u32 = (1 << FINE) + 2 * MARGIN;

/// The number of no cube.
const NONE: u32 = COUNT.pow(3);

constants! {
    /// Fewest points of a tile: fewer show no body.
    FEWEST = 500.0, "points";
}

/// A grid of cubes about the box of the points of a cloud, but for single ones far away.
#[derive(Debug, Clone, Copy)]
struct Cubes {
    low: Vector3<f64>,
    edge: f64,
}

impl Cubes {
    /// `None` where there are no points, or all coincide.
    fn about(points: &Points, check_cancel: &CancelCheck<'_>) -> Result<Option<Self>> {
        let (mut low, mut size) = (Vector3::zeros(), 0.0_f64);
        for (axis, low) in points.axes.iter().zip(&mut low) {
            check_cancel()?;
            let values: Vec<f64> = axis.iter().filter(|x| !x.is_nan()).map(|x| f64::from(*x)).collect();
            if values.is_empty() {
                return Ok(None);
            }
            check_cancel()?;
            let [first, last] = at_both_ends(&values, (STRAY.get() * values.len() as f64) as usize);
            *low = first;
            size = size.max(last - first);
        }
        Ok((size > 0.0).then(|| Self { low: points.origin + low, edge: size / f64::from(1_u32 << FINE) }))
    }

    /// The number of the cube of a point, [`NONE`] outside.
    fn number(&self, point: &Vector3<f64>) -> u32 {
        let at = ((point - self.low) / self.edge).add_scalar(f64::from(MARGIN));
        let inside = at.iter().all(|x| (0.0..f64::from(COUNT)).contains(x));
        if inside { at.iter().fold(0, |number, x| number * COUNT + *x as u32) } else { NONE }
    }

    fn indices(number: u32) -> [u32; 3] {
        [number / (COUNT * COUNT), number / COUNT % COUNT, number % COUNT]
    }

    fn middle(&self, number: u32) -> Vector3<f64> {
        let middle = Vector3::from(Self::indices(number)).map(|k| f64::from(k) - f64::from(MARGIN) + 0.5);
        self.low + self.edge * middle
    }

    /// The tile in which a cube lies, an edge of a tile being 2^-level of the longest side. They are laid half an edge off the box: no
    /// border is one of the next level.
    fn tile(number: u32, level: u32) -> Option<[u32; 3]> {
        if number == NONE {
            return None;
        }
        let edge = 1 << (FINE - level);
        let tile = Self::indices(number).map(|k| (k + edge / 2).checked_sub(MARGIN).map(|k| k / edge));
        let [Some(x), Some(y), Some(z)] = tile else { return None };
        [x, y, z].iter().all(|k| *k <= 1 << level).then_some([x, y, z])
    }
}

/// The cubes of a cloud that have points, and which.
#[derive(Debug)]
pub(super) struct Order {
    cubes: Cubes,
    /// The number of each cube and its first point; the last, beyond all points, ends the one before.
    firsts: Vec<(u32, u32)>,
    /// The numbers that points have for the caller.
    pub numbers: Vec<u32>,
}

impl Order {
    /// The order of points of the caller's, and these in it, where they do not all coincide. What is far away or of no use comes
    /// last.
    pub fn of(
        view: &PointsView<'_>,
        points: Points,
        check_cancel: &CancelCheck<'_>,
    ) -> Result<(Option<Self>, Points)> {
        let Some(cubes) = Cubes::about(&points, check_cancel)? else { return Ok((None, points)) };
        let count = points.len();
        // Much memory in a large cloud.
        drop(points);
        let (width, height) = (view.width(), view.height());
        let mut of_points = Vec::with_capacity(count);
        let mut ends = vec![0_u32; NONE as usize + 1];
        for row in 0..height {
            for column in 0..width {
                if of_points.len().is_multiple_of(BETWEEN_QUESTIONS) {
                    check_cancel()?;
                }
                let cube = cubes.number(&view.points.at(column, row));
                ends[cube as usize] += 1;
                of_points.push(cube);
            }
        }
        let mut firsts: Vec<(u32, u32)> = Vec::new();
        let mut end = 0;
        for (cube, points) in (0..).zip(&mut ends) {
            if *points > 0 {
                firsts.push((cube, end));
            }
            end += *points;
            *points = end;
        }
        firsts.push((NONE + 1, end));
        check_cancel()?;
        let mut numbers = vec![0; count];
        for (k, cube) in of_points.iter().enumerate().rev() {
            let end = &mut ends[*cube as usize];
            *end -= 1;
            numbers[*end as usize] = k as u32;
        }
        drop((of_points, ends));
        let mut points = Points::with_room(cubes.low, count)?;
        for numbers in numbers.chunks(BETWEEN_QUESTIONS) {
            check_cancel()?;
            for &number in numbers {
                let number = number as usize;
                let (column, row) = if height == 1 { (number, 0) } else { (number % width, number / width) };
                points.push_given(view, column, row);
            }
        }
        Ok((Some(Self { cubes, firsts, numbers }), points))
    }

    /// The cubes that have points, with these.
    fn filled(&self) -> impl Iterator<Item = (u32, Range<usize>)> {
        self.firsts.windows(2).map(|two| (two[0].0, two[0].1 as usize..two[1].1 as usize))
    }

    /// The points of each tile of a level that has enough of them.
    pub fn tiles(&self, level: u32) -> Vec<Vec<Range<usize>>> {
        let mut tiles: BTreeMap<[u32; 3], Vec<Range<usize>>> = BTreeMap::new();
        for (cube, range) in self.filled() {
            let Some(tile) = Cubes::tile(cube, level) else { continue };
            let ranges = tiles.entry(tile).or_default();
            match ranges.last_mut() {
                Some(last) if last.end == range.start => last.end = range.end,
                _ => ranges.push(range),
            }
        }
        let is_large =
            |ranges: &Vec<Range<usize>>| ranges.iter().map(Range::len).sum::<usize>() >= FEWEST.count();
        tiles.into_values().filter(is_large).collect()
    }

    /// All points, and some others, that lie within a reach of the surface of a cylinder, cube by cube.
    pub fn near(&self, cylinder: &Cylinder, reach: f64) -> impl Iterator<Item = usize> + '_ {
        // Half the diagonal of a cube.
        let reach = reach + 0.5 * f64::sqrt(3.0) * self.cubes.edge;
        let cylinder = *cylinder;
        let is_near = move |cube: u32| {
            let distance = cylinder.distance(&self.cubes.middle(cube)).abs();
            // It overflows where single points are so far away that cubes are as large as numbers go.
            cube == NONE || distance <= reach || !distance.is_finite()
        };
        self.filled().filter(move |(cube, _)| is_near(*cube)).flat_map(|(_, range)| range)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;
    use crate::geometry::Line;
    use crate::statistics::min_max_of;

    /// A cube of 30 × 30 × 30 points, one point far away and one that is none.
    fn cloud() -> Vec<[f64; 3]> {
        let point = |k: u32| [k % 30, k / 30 % 30, k / 900].map(|x| f64::from(x) - 7.0);
        let mut points: Vec<[f64; 3]> = (0..27_000).map(point).collect();
        points.extend([[1e6, 0.0, 0.0], [f64::NAN, 0.0, 0.0]]);
        points
    }

    fn order(points: &[[f64; 3]]) -> (Order, Points) {
        let (view, check_cancel) = (PointsView::from_f64(points), || Ok(()));
        let (order, points) =
            Order::of(&view, Points::read(&view, Vector3::zeros(), &check_cancel).unwrap(), &check_cancel)
                .unwrap();
        (order.unwrap(), points)
    }

    #[test]
    fn an_ordered_cloud_has_each_point_once() {
        let given = cloud();
        let (order, points) = order(&given);
        assert_eq!((points.len(), points.usable), (given.len(), 27_001));
        let mut numbers = order.numbers.clone();
        numbers.sort_unstable();
        assert!(numbers.into_iter().eq(0..given.len() as u32));
        for (k, &number) in order.numbers.iter().enumerate().filter(|(k, _)| points.is_usable(*k)) {
            assert!(
                (points.point(k) - Vector3::from(given[number as usize])).norm()
                    < 1e-5 * given[number as usize][0].abs().max(1.0)
            );
        }
        let view = PointsView::from_f64(&given);
        let read = Points::read(&view, Vector3::zeros(), &|| Ok(())).unwrap();
        let cancelled = Order::of(&view, read, &|| Err(Error::Cancelled { iterations: 0 }));
        assert!(matches!(cancelled, Err(Error::Cancelled { .. })));
    }

    #[test]
    fn nothing_near_is_lost_where_distances_overflow() {
        let mut given = cloud();
        given.extend((0..300).map(|k| [if k % 2 == 0 { 1e38 } else { -0.7e38 }; 3]));
        let (order, points) = order(&given);
        let axis = Line { point: Vector3::new(3.0, 4.0, 5.0), direction: Vector3::new(0.6, 0.0, 0.8) };
        let near = order.near(&Cylinder { axis, radius: 6.0 }, 0.5);
        assert_eq!(near.filter(|&k| order.numbers[k] < 27_000).count(), 27_000);
        assert_eq!(points.usable, 27_301);
    }

    #[test]
    fn what_is_near_a_surface_is_in_the_cubes_next_to_it() {
        let given = cloud();
        let (order, points) = order(&given);
        let axis = Line { point: Vector3::new(3.0, 4.0, 5.0), direction: Vector3::new(0.6, 0.0, 0.8) };
        let cylinder = Cylinder { axis, radius: 6.0 };
        let distance = |k: usize| cylinder.distance(&points.point(k)).abs();
        let near: Vec<usize> = order.near(&cylinder, 0.5).collect();
        assert!(near.is_sorted_by(|a, b| a < b) && near.len() < given.len() / 3);
        let all = (0..points.len()).filter(|&k| distance(k) <= 0.5);
        assert!(all.clone().count() > 1000 && all.clone().all(|k| near.binary_search(&k).is_ok()));
        // A cube has a diagonal of less than 2.
        assert!(near.iter().all(|&k| distance(k) <= 2.5 || order.numbers[k] >= 27_000));
    }

    #[test]
    fn each_point_is_in_one_tile_with_those_near_it() {
        let (order, points) = order(&cloud()[..27_000]);
        let tiles = order.tiles(1);
        // The grid is half an edge off the box, which has 8, 14 and 8 points along a side of its tiles.
        assert_eq!(tiles.len(), 27);
        let mut counts = vec![0; points.len()];
        for tile in &tiles {
            let numbers = || tile.iter().cloned().flatten();
            let range = |axis: usize| {
                let [low, high] = min_max_of(numbers().map(|k| points.at(k)[axis]));
                high - low
            };
            assert!([0, 1, 2].into_iter().all(|axis| range(axis) <= 14.5));
            numbers().for_each(|k| counts[k] += 1);
        }
        assert!(counts.iter().all(|count| *count == 1));
    }
}
