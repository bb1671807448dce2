//! Cubes of space about the points of a cloud.

use super::{Asked, BETWEEN_QUESTIONS, STRAY};
use crate::error::Result;
use crate::geometry::Cylinder;
use crate::observations::PointsView;
use crate::statistics::at_both_ends;
use nalgebra::Vector3;

/// The box of the points of a cloud, but for single ones far away.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds {
    low: Vector3<f64>,
    /// The longest side.
    size: f64,
}

/// Cubes that a box is cut into, laid half an edge off it: no border is one with edges half as long.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cubes {
    bounds: Bounds,
    edge: f64,
    /// How many along each axis.
    count: usize,
}

/// All points of a cloud, in rows.
pub(super) fn all<'a>(points: &PointsView<'a>) -> impl Iterator<Item = Vector3<f64>> + 'a {
    let (width, height, points) = (points.width(), points.height(), points.points);
    (0..height).flat_map(move |row| (0..width).map(move |column| points.at(column, row)))
}

impl Bounds {
    /// `None` where there are no points, or all at one place.
    pub fn of(points: &PointsView<'_>, asked: &Asked<'_>) -> Result<Option<Self>> {
        let (mut low, mut size) = (Vector3::zeros(), 0.0_f64);
        for axis in 0..3 {
            asked()?;
            let values: Vec<f64> = all(points).map(|point| point[axis]).filter(|x| x.is_finite()).collect();
            if values.is_empty() {
                return Ok(None);
            }
            asked()?;
            let [first, last] = at_both_ends(&values, (STRAY * values.len() as f64) as usize);
            low[axis] = first;
            size = size.max(last - first);
        }
        Ok((size > 0.0).then_some(Self { low, size }))
    }

    /// Cubes with edges of 2^-level of the longest side.
    pub fn cubes(&self, level: u32) -> Cubes {
        let parts = 1_usize << level;
        Cubes { bounds: *self, edge: self.size / parts as f64, count: parts + 1 }
    }
}

impl Cubes {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.count.pow(3)
    }

    /// The number of the cube of a point; `None` outside.
    pub fn number(&self, point: &Vector3<f64>) -> Option<usize> {
        let at = ((point - self.bounds.low) / self.edge).add_scalar(0.5);
        let inside = at.iter().all(|x| (0.0..self.count as f64).contains(x));
        inside.then(|| at.iter().fold(0, |number, x| number * self.count + *x as usize))
    }

    fn middle(&self, number: usize) -> Vector3<f64> {
        let count = self.count;
        let place = Vector3::new(number / (count * count), number / count % count, number % count);
        self.bounds.low + self.edge * place.map(|k| k as f64)
    }
}

/// So many cubes along the longest side, as a power of 2: it matters to time alone.
const FINE: u32 = 5;

/// The points of a cloud cube by cube: what is near a surface is found without a look at all of them.
#[derive(Debug)]
pub(crate) struct Places {
    cubes: Cubes,
    /// The numbers of the points of one cube after the other; at the end those that lie in none.
    numbers: Vec<u32>,
    /// Where the numbers of each cube begin, those of no cube last, and where all end.
    firsts: Vec<u32>,
}

impl Places {
    pub(super) fn of(points: &PointsView<'_>, bounds: &Bounds, asked: &Asked<'_>) -> Result<Self> {
        let cubes = bounds.cubes(FINE);
        let mut of_points = Vec::with_capacity(points.width() * points.height());
        // Where those of each cube end.
        let mut firsts = vec![0_u32; cubes.len() + 1];
        for (k, point) in all(points).enumerate() {
            if k % BETWEEN_QUESTIONS == 0 {
                asked()?;
            }
            let cube = cubes.number(&point).unwrap_or(cubes.len()) as u32;
            firsts[cube as usize] += 1;
            of_points.push(cube);
        }
        let mut end = 0;
        for first in &mut firsts {
            end += *first;
            *first = end;
        }
        asked()?;
        let mut numbers = vec![0; of_points.len()];
        for (k, cube) in of_points.iter().enumerate().rev() {
            let first = &mut firsts[*cube as usize];
            *first -= 1;
            numbers[*first as usize] = k as u32;
        }
        firsts.push(end);
        Ok(Self { cubes, numbers, firsts })
    }

    /// The numbers of all points, and of some others, that lie within a reach of the surface of a cylinder, cube by cube.
    pub fn near(&self, cylinder: &Cylinder, reach: f64) -> impl Iterator<Item = usize> + '_ {
        // Half the diagonal of a cube.
        let reach = reach + 0.5 * f64::sqrt(3.0) * self.cubes.edge;
        let cylinder = *cylinder;
        let is_near = move |&number: &usize| {
            let distance = cylinder.distance(&self.cubes.middle(number)).abs();
            // It overflows where single points are so far away that cubes are as large as numbers go.
            number == self.cubes.len() || distance <= reach || !distance.is_finite()
        };
        let of_cube = |number: usize| self.firsts[number] as usize..self.firsts[number + 1] as usize;
        let filled = (0..=self.cubes.len()).filter(move |&number| !of_cube(number).is_empty());
        filled
            .filter(is_near)
            .flat_map(move |number| self.numbers[of_cube(number)].iter().map(|&k| k as usize))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Line;

    /// A cube of 30 × 30 × 30 points, one point far away and one that is none.
    fn cloud() -> Vec<[f64; 3]> {
        let point = |k: u32| [k % 30, k / 30 % 30, k / 900].map(|x| f64::from(x) - 7.0);
        let mut points: Vec<[f64; 3]> = (0..27_000).map(point).collect();
        points.extend([[1e6, 0.0, 0.0], [f64::NAN, 0.0, 0.0]]);
        points
    }

    #[test]
    fn nothing_near_is_lost_where_distances_overflow() {
        let mut points = cloud();
        points.extend((0..300).map(|k| [if k % 2 == 0 { 1e200 } else { -0.7e200 }; 3]));
        let view = PointsView::from_f64(&points);
        let bounds = Bounds::of(&view, &|| Ok(())).unwrap().unwrap();
        assert!(bounds.size > 1e200);
        let places = Places::of(&view, &bounds, &|| Ok(())).unwrap();
        let axis = Line { point: Vector3::new(3.0, 4.0, 5.0), direction: Vector3::new(0.6, 0.0, 0.8) };
        let near = places.near(&Cylinder { axis, radius: 6.0 }, 0.5);
        assert_eq!(near.filter(|&k| k < 27_000).count(), 27_000);
    }

    #[test]
    fn what_is_near_a_surface_is_in_the_cubes_next_to_it() {
        let points = cloud();
        let view = PointsView::from_f64(&points);
        let bounds = Bounds::of(&view, &|| Ok(())).unwrap().unwrap();
        assert!(bounds.size <= 30.0);
        let places = Places::of(&view, &bounds, &|| Ok(())).unwrap();
        let axis = Line { point: Vector3::new(3.0, 4.0, 5.0), direction: Vector3::new(0.6, 0.0, 0.8) };
        let cylinder = Cylinder { axis, radius: 6.0 };
        let distance = |k: usize| cylinder.distance(&Vector3::from(points[k])).abs();
        let mut near: Vec<usize> = places.near(&cylinder, 0.5).collect();
        near.sort_unstable();
        assert!(near.is_sorted_by(|a, b| a < b) && near.len() < points.len() / 3);
        let all = (0..points.len()).filter(|&k| distance(k) <= 0.5);
        assert!(all.clone().count() > 1000 && all.clone().all(|k| near.binary_search(&k).is_ok()));
        // A cube has a diagonal of less than 2.
        assert!(near.iter().all(|&k| distance(k) <= 2.5 || k >= 27_000));
    }
}
