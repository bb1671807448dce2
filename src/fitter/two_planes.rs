//! Two planes, one on either side of a line along the axis of a cylinder: the sides of a box that is fitted as one.

use crate::statistics::min_max_of;
use nalgebra::{Matrix3, Vector2, Vector3};

/// Parts of equal width across the axis, between any two of which one plane may end and the other begin.
const PARTS: usize = 16;

/// What the correlation of where points lie along and across the axis leaves at least of their variance.
const LEAST_SPREAD: f64 = 0.01;

/// A point with its weight: where it lies along the axis of the cylinder, and in two directions across it, of which the last one
/// leads from the axis to the points.
#[derive(Debug, Clone, Copy)]
pub(super) struct Weighted {
    pub weight: f64,
    pub position: Vector3<f64>,
}

/// A plane on either side of a line along the axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct TwoPlanes([Plane; 2]);

impl TwoPlanes {
    /// How many numbers the points determine: three of each plane.
    pub const NUMBERS: f64 = 6.0;

    /// Those from which the points are least far, and the weighted mean of the squared distances.
    pub fn new(points: &[Weighted]) -> Option<(Self, f64)> {
        let [first, last] = min_max_of(points.iter().map(|point| point.position.y));
        let step = (last - first) / PARTS as f64;
        let mut moments = [Moments::default(); PARTS];
        for point in points {
            let part = ((point.position.y - first) / step) as usize;
            moments[part.min(PARTS - 1)].add(point);
        }
        let all = moments.iter().fold(Moments::default(), |all, part| all.with(part));
        let mut one = Moments::default();
        let divided = (1..PARTS).filter_map(|part| {
            one = one.with(&moments[part - 1]);
            Self::of([&one, &all.without(&one)])
        });
        let (best, _) = divided.min_by(|a, b| a.1.total_cmp(&b.1))?;
        // A part may have points of both.
        let mut moments = [Moments::default(); 2];
        points.iter().for_each(|point| moments[best.seen_at(&point.position)].add(point));
        Self::of(moments.each_ref())
    }

    /// The planes through two sets of points, and the weighted mean of the squared distances.
    fn of(moments: [&Moments; 2]) -> Option<(Self, f64)> {
        let [(a, of_a), (b, of_b)] = [moments[0].plane()?, moments[1].plane()?];
        Some((Self([a, b]), (of_a + of_b) / (moments[0].weight + moments[1].weight)))
    }

    /// Which plane is the surface at a position across: that of a box is the lower one, as z leads away from the axis.
    fn seen_at(&self, position: &Vector3<f64>) -> usize {
        let [one, other] = self.0.map(|plane| plane.height_of(position));
        usize::from(one > other)
    }

    /// How far a position lies outside of the surface.
    pub fn distance(&self, position: &Vector3<f64>) -> f64 {
        self.0[self.seen_at(position)].distance(position)
    }
}

/// The plane z = z₀ + s · ((x, y) − (x₀, y₀)) through a point with slopes s.
#[derive(Debug, Clone, Copy)]
struct Plane {
    point: Vector3<f64>,
    slopes: Vector2<f64>,
}

impl Plane {
    fn height_of(&self, position: &Vector3<f64>) -> f64 {
        self.point.z + self.slopes.dot(&(position - self.point).xy())
    }

    fn distance(&self, position: &Vector3<f64>) -> f64 {
        (position.z - self.height_of(position)) / (1.0 + self.slopes.norm_squared()).sqrt()
    }
}

/// Weights of points, and their first and second moments.
#[derive(Clone, Copy, Default)]
struct Moments {
    weight: f64,
    first: Vector3<f64>,
    second: Matrix3<f64>,
}

impl Moments {
    fn add(&mut self, Weighted { weight, position }: &Weighted) {
        self.weight += weight;
        self.first += position * *weight;
        self.second += position * position.transpose() * *weight;
    }

    fn with(&self, other: &Self) -> Self {
        Self {
            weight: self.weight + other.weight,
            first: self.first + other.first,
            second: self.second + other.second,
        }
    }

    fn without(&self, some: &Self) -> Self {
        Self {
            weight: self.weight - some.weight,
            first: self.first - some.first,
            second: self.second - some.second,
        }
    }

    /// The plane from which the points are least far along z, and the sum of the squared distances from it; `None` where the points
    /// lie along a line.
    fn plane(&self) -> Option<(Plane, f64)> {
        let point = self.first / self.weight;
        let about = self.second - self.first * point.transpose();
        let along_z = Vector2::new(about[(0, 2)], about[(1, 2)]);
        let across = about.fixed_view::<2, 2>(0, 0).into_owned();
        let spread = across.determinant() > LEAST_SPREAD * across[(0, 0)] * across[(1, 1)];
        let slopes = spread.then(|| across.try_inverse()).flatten()? * along_z;
        let squares = (about[(2, 2)] - slopes.dot(&along_z)) / (1.0 + slopes.norm_squared());
        // Less than nothing is rounding.
        Some((Plane { point, slopes }, squares.max(0.0)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of a surface z = f(x, y) on a grid of 20 × 16.
    fn points(height: impl Fn(f64, f64) -> f64) -> Vec<Weighted> {
        let grid =
            (0..20).flat_map(|i| (0..16).map(move |j| (f64::from(i) / 10.0 - 1.0, f64::from(j) / 8.0 - 0.9)));
        grid.map(|(x, y)| Weighted { weight: 1.0, position: Vector3::new(x, y, height(x, y)) }).collect()
    }

    #[test]
    fn the_sides_of_a_box_are_two_planes() {
        let (planes, variance) = TwoPlanes::new(&points(|x, y| 0.1 * x - (y - 0.1).abs())).unwrap();
        assert!(variance < 1e-15, "{variance} {planes:?}");
        // At x = 0 and y = −0.9 the surface is at z = −1, and steep by 1 across and by 0.1 along the axis.
        let distance = planes.distance(&Vector3::new(0.0, -0.9, -0.5));
        assert!((distance - 0.5 / 2.01_f64.sqrt()).abs() < 1e-9, "{distance}");
    }

    #[test]
    fn a_cylinder_is_not_two_planes() {
        let (planes, variance) = TwoPlanes::new(&points(|_, y| (1.0 - y * y).sqrt())).unwrap();
        assert!(variance > 1e-3, "{variance} {planes:?}");
    }

    #[test]
    fn no_points_and_points_along_lines_are_no_planes() {
        let weighted =
            |x: f64, y: f64| Weighted { weight: 1.0, position: Vector3::new(x, y, (97.0 * x).sin()) };
        let columns: Vec<Weighted> = (0..40).map(|k| weighted(f64::from(k / 2), f64::from(k % 2))).collect();
        for points in [&[][..], &[weighted(0.1, 0.2); 20], &columns] {
            assert!(TwoPlanes::new(points).is_none(), "{points:?}");
        }
    }
}
