//! Where the sensor was that has seen a cloud, by how densely its points lie.
//!
//! A camera takes one point a pixel. On a surface with the normal n at p it puts so many on an area as
//!
//! > λ(p) = k |n · (c − p)| / |c − p|³
//!
//! with its position c and a constant k: fewer where the surface is far away or slanted. So the densities of small pieces of the surface
//! tell c, in whatever coordinates and order the points are, and whichever part of them was kept. Along one plane alone its mirror image
//! is as likely, and other positions may come near: what hides what tells them apart.

use super::points::Points;
use super::viewpoints::middle_of_some;
use crate::memory::List;
use crate::statistics::{DEVIATION_OF_MEDIAN, median, median_absolute};
use nalgebra::{Matrix3, Matrix4, Vector3, Vector4};

/// Points that tell it, evenly spread over the order of the cloud: those that confirm a position, and those that tell one.
pub(super) const FEW_POINTS: usize = 1 << 16;
pub(super) const MANY_POINTS: usize = 1 << 18;

constants! {
    /// Points in a piece of the surface, as a rule, and at least.
    MANY = 60.0, "points";
    FEWEST = 20.0, "points";

    /// A piece is flat where its points scatter across it by this part of its narrow side at most, and that is no strip where it has this part
    /// of the wide one. In variances.
    FLAT = 0.15, "";
    BROAD = 0.1, "";

    /// Fewest pieces that tell a position.
    FEWEST_PIECES = 100.0, "";

    /// How far from the middle positions are sought first, in sizes of the cloud.
    START = 2.0, "size";

    /// Pieces count less from so many standard deviations on.
    DEVIATIONS = 2.0, "σ";

    /// Positions that are nearer to each other than this part of their distance from the middle are the same.
    APART = 0.1, "";

    /// Directions are about the same within this angle, in radians: a search from a position that is off by 8 degrees finds as much as one from
    /// that of the sensor.
    ALIKE = 0.15, "rad";
}

/// The area of a piece by the product of its standard deviations along and across: of a rectangle. Of other convex shapes it differs by
/// up to 15 %, of which k takes what they share.
const AREA: f64 = 12.0;

/// Pieces that are enough for a first look.
const FEW_PIECES: usize = 400;

/// Steps of the first look, and of all pieces.
const STEPS: [usize; 2] = [10, 20];

/// Most positions that are returned.
const MOST_POSITIONS: usize = 6;

/// A flat piece of the surface.
#[derive(Debug, Clone, Copy)]
struct Piece {
    middle: Vector3<f64>,
    normal: Vector3<f64>,
    /// ln λ.
    density: f64,
}

/// A position, the logarithm of k there, and the scale of what is left of the logarithms of the densities.
#[derive(Debug, Clone, Copy)]
struct Fit {
    position: Vector3<f64>,
    factor: f64,
    scale: f64,
}

/// How densely the surface of a cloud has points.
pub(super) struct Densities {
    /// Where the coordinates of the pieces begin, the middle of the points in these, and how far from that they lie.
    origin: Vector3<f64>,
    middle: Vector3<f64>,
    size: f64,
    pieces: List<Piece>,
}

impl Densities {
    /// By so many of some points; `None` where too few pieces are flat.
    pub fn of(points: &Points, count: usize) -> Option<Self> {
        let (_, middle, size) = middle_of_some(points);
        let pieces = pieces(points, count, &middle, size);
        (pieces.len() >= FEWEST_PIECES.count()).then_some(Self {
            origin: points.origin,
            middle,
            size,
            pieces,
        })
    }

    /// Enough of the pieces for a first look.
    fn few(&self) -> List<Piece> {
        self.pieces.iter().copied().step_by(self.pieces.len().div_ceil(FEW_PIECES)).collect()
    }

    /// Whether they have a sensor in about the same direction as some position.
    pub fn confirm(&self, position: &Vector3<f64>) -> bool {
        let towards = position - (self.origin + self.middle);
        let found = self.from(&self.few(), &towards);
        (found.position - self.middle).angle(&towards) < ALIKE.get()
    }

    /// The position that pieces tell, from one in a direction.
    fn from(&self, pieces: &[Piece], towards: &Vector3<f64>) -> Fit {
        let start = self.middle + towards * (START.get() * self.size / towards.norm());
        Fit::new(pieces, &start, self.size, STEPS[0])
    }

    /// The first ones of some positions that are apart.
    fn distinct(&self, fits: &[Fit]) -> List<Fit> {
        let mut distinct: List<Fit> = List::new();
        for found in fits.iter().filter(|found| found.scale.is_finite()) {
            let distance = APART.get() * (found.position - self.middle).norm();
            let near = |other: &Fit| (found.position - other.position).norm() <= distance;
            if distinct.len() < MOST_POSITIONS && !distinct.iter().any(near) {
                distinct.push(*found);
            }
        }
        distinct
    }

    /// Where a sensor may have been, the most likely position first, and the scale of what is left of the logarithms of the densities.
    pub fn positions(&self) -> List<(Vector3<f64>, f64)> {
        let Self { origin, size, pieces, .. } = self;
        let few = self.few();
        let from = directions().map(|direction| self.from(&few, &direction));
        let mut fits: List<Fit> = from.collect();
        let order = |fits: &mut List<Fit>| fits.sort_by(|a, b| a.scale.total_cmp(&b.scale));
        order(&mut fits);
        let of_few = self.distinct(&fits);
        let mut fits: List<Fit> =
            of_few.iter().map(|found| Fit::new(pieces, &found.position, *size, STEPS[1])).collect();
        order(&mut fits);
        let distinct = self.distinct(&fits);
        distinct.iter().map(|found| (origin + found.position, found.scale)).collect()
    }
}

/// To the faces, edges and corners of a cube.
fn directions() -> impl Iterator<Item = Vector3<f64>> {
    let all = (0..27).map(|k| Vector3::new(k % 3, k / 3 % 3, k / 9).map(|x: i32| f64::from(x - 1)));
    all.filter(|direction| direction.norm() > 0.0)
}

/// The flat pieces of the surface in cubes of which one has about as many points as a piece has as a rule, by so many points at most.
fn pieces(points: &Points, count: usize, middle: &Vector3<f64>, size: f64) -> List<Piece> {
    let step = points.usable.div_ceil(count).max(1);
    let some: Vec<Vector3<f64>> = points.all_usable().step_by(step).map(|p| p - middle).collect();
    let edge = 2.5 * size * (MANY.get() / some.len() as f64).sqrt();
    /// Cubes to each side of the middle.
    const HALF: f64 = (1_u32 << 20) as f64;
    let cube = |p: &Vector3<f64>| {
        let cell = (p / edge).map(|x| x.floor() + HALF);
        let inside = cell.iter().all(|x| (0.0..2.0 * HALF).contains(x));
        inside.then(|| cell.iter().fold(0, |number, x| number << 21 | *x as u64))
    };
    let mut in_cubes: Vec<(u64, u32)> =
        (0..).zip(some.iter()).filter_map(|(k, p)| Some((cube(p)?, k))).collect();
    in_cubes.sort_unstable();
    let of_cubes = in_cubes.chunk_by(|a, b| a.0 == b.0);
    of_cubes.filter_map(|cube| Piece::new(cube.iter().map(|(_, k)| some[*k as usize] + middle))).collect()
}

impl Piece {
    fn new(points: impl ExactSizeIterator<Item = Vector3<f64>> + Clone) -> Option<Self> {
        let count = points.len() as f64;
        if count < FEWEST.get() {
            return None;
        }
        let middle = points.clone().sum::<Vector3<f64>>() / count;
        let square = |p: Vector3<f64>| (p - middle) * (p - middle).transpose();
        let eigen = (points.map(square).sum::<Matrix3<f64>>() / count).symmetric_eigen();
        let mut order = [0, 1, 2];
        order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
        let [across, narrow, wide] = order.map(|k| eigen.eigenvalues[k]);
        let normal = eigen.eigenvectors.column(order[0]).into();
        let density = (count / (AREA * (narrow * wide).sqrt())).ln();
        let is_flat = across <= FLAT.get() * narrow && narrow > BROAD.get() * wide;
        (is_flat && density.is_finite()).then_some(Self { middle, normal, density })
    }

    /// ln (λ / k) where a sensor is, and its derivative by the position of that.
    fn expected(&self, sensor: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let ray = sensor - self.middle;
        let (height, squared) = (self.normal.dot(&ray), ray.norm_squared());
        (height.abs().ln() - 1.5 * squared.ln(), self.normal / height - ray * (3.0 / squared))
    }
}

impl Fit {
    /// By so many steps from a position, none longer than half of the size of the cloud.
    fn new(pieces: &[Piece], start: &Vector3<f64>, size: f64, steps: usize) -> Self {
        let mut fit = Self { position: *start, factor: 0.0, scale: f64::NAN };
        fit.settle(pieces);
        for _ in 0..steps {
            let Some(step) = fit.step(pieces) else { break };
            let length = step.norm();
            fit.position += step * (0.5 * size / length.max(0.5 * size));
            fit.settle(pieces);
        }
        fit
    }

    /// The factor and the scale of a position.
    fn settle(&mut self, pieces: &[Piece]) {
        let mut left: List<f64> =
            pieces.iter().map(|piece| piece.density - piece.expected(&self.position).0).collect();
        self.factor = median(&mut left);
        self.scale = DEVIATION_OF_MEDIAN * median_absolute(left.iter().map(|left| left - self.factor));
    }

    /// The step of least squares in which outliers count less.
    fn step(&self, pieces: &[Piece]) -> Option<Vector3<f64>> {
        let (mut hessian, mut gradient) = (Matrix4::zeros(), Vector4::zeros());
        for piece in pieces {
            let (expected, derivative) = piece.expected(&self.position);
            let left = piece.density - expected - self.factor;
            let weight = 1.0 / (1.0 + (left / (DEVIATIONS.get() * self.scale)).powi(2));
            let row = derivative.push(1.0);
            hessian += row * row.transpose() * weight;
            gradient += row * (weight * left);
        }
        let step = hessian.cholesky()?.solve(&gradient).xyz();
        step.iter().all(|x| x.is_finite()).then_some(step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observations::PointsView;

    /// What a camera with 200 × 200 pixels sees of a table and two walls from a position 0.8 m above the table, moved.
    fn seen(shift: &Vector3<f64>) -> Points {
        let position = Vector3::new(0.0, 0.0, 0.8);
        let toward = Vector3::new(1.0, 1.0, -0.6).normalize();
        let right = toward.cross(&Vector3::z()).normalize();
        let down = toward.cross(&right);
        let point = |k: u32| {
            let slope = |k: u32| f64::from(k) / 200.0 - 0.4975;
            let ray = toward + right * slope(k % 200) + down * slope(k / 200);
            // The planes z = 0, x = 1.2 and y = 1.
            let far = [-position.z / ray.z, 1.2 / ray.x, 1.0 / ray.y].into_iter().filter(|far| *far > 0.0);
            let point = position + ray * far.fold(f64::INFINITY, f64::min) + shift;
            [point.x, point.y, point.z]
        };
        let points: Vec<[f64; 3]> = (0..40_000).map(point).collect();
        Points::read(&PointsView::from_f64(&points), *shift, &|| Ok(())).unwrap()
    }

    #[test]
    fn densities_tell_where_the_sensor_was_wherever_the_origin_is() {
        for shift in [Vector3::zeros(), Vector3::new(5.0, -3.0, 2.0), Vector3::new(4e5, 5e6, 100.0)] {
            let densities = Densities::of(&seen(&shift), MANY_POINTS).unwrap();
            let position = Vector3::new(0.0, 0.0, 0.8) + shift;
            assert!((densities.positions()[0].0 - position).norm() < 0.2, "{:?}", densities.positions());
            assert!(densities.confirm(&position));
            assert!(!densities.confirm(&(position + Vector3::new(0.5, 0.0, 0.0))));
        }
    }

    #[test]
    fn what_is_evenly_dense_confirms_no_position_nearby() {
        let plane: Vec<[f64; 3]> =
            (0..40_000).map(|k| [f64::from(k % 200) * 0.005, f64::from(k / 200) * 0.005, 1.0]).collect();
        let points = Points::read(&PointsView::from_f64(&plane), Vector3::zeros(), &|| Ok(())).unwrap();
        let densities = Densities::of(&points, MANY_POINTS).unwrap();
        assert!(
            densities
                .positions()
                .iter()
                .all(|(position, _)| (position - Vector3::new(0.5, 0.5, 1.0)).norm() > 3.0)
        );
    }

    #[test]
    fn the_derivative_of_a_density_agrees_with_central_differences() {
        let middle = Vector3::new(0.3, -0.2, 1.0);
        let piece = Piece { middle, normal: Vector3::new(0.2, 0.5, -0.8).normalize(), density: 0.0 };
        let position = Vector3::new(-0.1, 0.4, -0.3);
        let derivative = piece.expected(&position).1;
        for axis in 0..3 {
            let step = Vector3::ith(axis, 1e-5);
            let [before, after] =
                [position - step, position + step].map(|position| piece.expected(&position).0);
            assert!(((after - before) / 2e-5 - derivative[axis]).abs() < 1e-8, "{axis}");
        }
    }
}
