//! Two planes that meet along a cylinder: the sides of a box that is fitted as one.

use crate::memory::List;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// Places at which the points are divided between two planes: after every sixteenth of them, but for the outermost.
const PARTS: usize = 16;

/// A point with its weight: where it lies along the axis of the cylinder, and in two directions across it, of which the last one
/// leads from the axis to the points.
#[derive(Clone, Copy)]
pub(super) struct Weighted {
    pub weight: f64,
    pub place: Vector3<f64>,
}

/// A plane with its normal on either side of a place across the axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct TwoPlanes {
    points: [Vector3<f64>; 2],
    normals: [Vector3<f64>; 2],
    edge: f64,
}

impl TwoPlanes {
    /// How many numbers the points determine: three of each plane, and the edge.
    pub const NUMBERS: f64 = 7.0;

    /// Those from which the points are least far; the points are put in order across the axis.
    pub fn new(points: &mut [Weighted]) -> Option<Self> {
        points.sort_by(|a, b| a.place.y.total_cmp(&b.place.y));
        let mut sum = Sums::default();
        let sums: List<Sums> = points
            .iter()
            .map(|point| {
                sum = sum.with(point);
                sum
            })
            .collect();
        let divided = (2..PARTS - 1).filter_map(|part| {
            let first = points.len() * part / PARTS;
            let sums = sums.get(first.checked_sub(1)?)?;
            let planes = [sums.plane()?, sum.without(sums).plane()?];
            Some((planes[0].2 + planes[1].2, planes, points[first].place.y))
        });
        let (_, [a, b], edge) = divided.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(Self { points: [a.0, b.0], normals: [a.1, b.1], edge })
    }

    /// The distance of a place from the plane on its side.
    pub fn distance(&self, place: &Vector3<f64>) -> f64 {
        let side = usize::from(place.y >= self.edge);
        self.normals[side].dot(&(place - self.points[side]))
    }

    /// The weighted mean of the squared distances of the points.
    pub fn variance(&self, points: &[Weighted]) -> f64 {
        let squares = points.iter().map(|point| point.weight * self.distance(&point.place).powi(2));
        squares.sum::<f64>() / points.iter().map(|point| point.weight).sum::<f64>()
    }
}

/// Weights of points, and their first and second moments.
#[derive(Clone, Copy, Default)]
struct Sums {
    weight: f64,
    first: Vector3<f64>,
    second: Matrix3<f64>,
}

impl Sums {
    fn with(&self, Weighted { weight, place }: &Weighted) -> Self {
        Self {
            weight: self.weight + weight,
            first: self.first + place * *weight,
            second: self.second + place * place.transpose() * *weight,
        }
    }

    fn without(&self, some: &Self) -> Self {
        Self {
            weight: self.weight - some.weight,
            first: self.first - some.first,
            second: self.second - some.second,
        }
    }

    /// A point of the plane through the points, its normal, and the sum of the squared distances from it.
    fn plane(&self) -> Option<(Vector3<f64>, Vector3<f64>, f64)> {
        let middle = self.first / self.weight;
        let SymmetricEigen { eigenvalues, eigenvectors } =
            SymmetricEigen::try_new(self.second - self.first * middle.transpose(), f64::EPSILON, 100)?;
        let (least, square) = eigenvalues.argmin();
        Some((middle, eigenvectors.column(least).into(), square.max(0.0)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of a surface z = f(x, y) on a grid of 20 × 16.
    fn points(height: impl Fn(f64, f64) -> f64) -> Vec<Weighted> {
        let grid =
            (0..20).flat_map(|i| (0..16).map(move |j| (f64::from(i) / 10.0 - 1.0, f64::from(j) / 8.0 - 0.9)));
        grid.map(|(x, y)| Weighted { weight: 1.0, place: Vector3::new(x, y, height(x, y)) }).collect()
    }

    #[test]
    fn the_sides_of_a_box_are_two_planes() {
        let mut points = points(|x, y| 0.1 * x - (y - 0.3).abs());
        let planes = TwoPlanes::new(&mut points).unwrap();
        assert!(planes.variance(&points) < 1e-20, "{planes:?}");
        assert!((0.2..=0.5).contains(&planes.edge), "{planes:?}");
        // At x = 0 and y = −0.7 the surface is at z = −1, and steep by 1 across and by 0.1 along the axis.
        let distance = planes.distance(&Vector3::new(0.0, -0.7, 0.0)).abs();
        assert!((distance - 1.0 / 2.01_f64.sqrt()).abs() < 1e-9, "{distance}");
    }

    #[test]
    fn the_sides_of_a_cylinder_are_none() {
        let mut points = points(|_, y| (1.0 - y * y).sqrt());
        let planes = TwoPlanes::new(&mut points).unwrap();
        assert!(planes.variance(&points) > 1e-3, "{planes:?}");
    }

    #[test]
    fn no_points_and_points_without_weight_are_no_sides() {
        assert!(TwoPlanes::new(&mut []).is_none());
        let mut points = points(|_, y| -y.abs());
        points.iter_mut().for_each(|point| point.weight = 0.0);
        assert!(TwoPlanes::new(&mut points).is_none_or(|planes| !(planes.variance(&points) <= 1.0)));
    }
}
