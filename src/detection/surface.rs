//! Cylinders, cones and spheres through cells: signed distances, and their fits by Gauss–Newton steps.

use super::cone::ToCone;
use super::distances::{self, Numbers};
use super::grid::Cell;
use super::normal_equations::{Cells, NormalEquations};
use crate::geometry::{Cylinder, Line, any_orthogonal, rotate_direction};
use nalgebra::{SVector, Vector3};
use pulp::Scalar;

constants! {
    /// Cells farther from a surface than this many standard deviations do not belong to it, be it a plane or round.
    pub(super) REACH = 3.0, "σ";

    /// How far a cell may be off across the line of sight, in pixels: matching windows and mixed pixels move outlines.
    pub(super) LATERAL_PIXELS = 0.5, "px";

    /// How far depth next to a limb is off across the line of sight, in pixels: matching windows of 7 to 11 pixels draw it
    /// out by 2, mixed pixels of time of flight in by 1.
    BIAS_PIXELS = 2.5, "px";

    /// How far inside of the limb the outline of what is measured is, in pixels: time of flight reaches it, structured
    /// light ends 0 to 3 pixels before it, as the surface turns away.
    pub(super) OUTLINE_SHIFT_PIXELS = 1.2, "px";

    /// Standard deviation of that, in pixels.
    pub(super) OUTLINE_PIXELS = 1.5, "px";
}

/// A step is damped by this part of what the best determined number is.
const DAMPING: f64 = 1e-4;

/// A fit has settled where the radius changes by less than this part of it.
const LEAST_CHANGE: f64 = 1e-4;

/// A surface of revolution about a line, or of a sphere.
#[derive(Debug, Clone, Copy)]
pub(super) enum Surface {
    /// A cylinder, and how far outside of its surface its limbs are measured: depth next to an outline is drawn to
    /// what lies beside it.
    Cylinder(Cylinder, f64),
    /// A cylinder whose radius grows along the axis by this much per length, from the point of the axis on.
    Cone(Cylinder, f64),
    /// Centre and radius.
    Sphere(Vector3<f64>, f64),
}

/// Where a point is relative to a surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Projection {
    /// Signed distance, positive outside.
    pub distance: f64,
    /// The outward normal of the surface next to it.
    pub normal: Vector3<f64>,
    /// Position along the axis from its point.
    pub along: f64,
}

impl Surface {
    #[inline(always)] // Of many points the numbers of the surface are made once.
    pub fn project(&self, p: &Vector3<f64>) -> Projection {
        distances::project(Scalar, self, p.map(|number| number as f32).into()).into()
    }

    /// The numbers that a fit finds.
    pub fn parameters(&self) -> f64 {
        match self {
            Self::Cylinder(..) => 5.0,
            Self::Cone(..) => 6.0,
            Self::Sphere(..) => 4.0,
        }
    }

    /// Two directions across the axis, in which it shifts and tilts.
    fn across(&self) -> (Vector3<f64>, Vector3<f64>) {
        match self {
            Self::Cylinder(cylinder, _) | Self::Cone(cylinder, _) => any_orthogonal(&cylinder.axis.direction),
            Self::Sphere(..) => (Vector3::x(), Vector3::y()),
        }
    }

    fn step(&self, delta: &SVector<f64, 6>) -> Option<Self> {
        let moved = |cylinder: &Cylinder| {
            let Line { point, direction } = cylinder.axis;
            let (u, v) = any_orthogonal(&direction);
            let tilt = u * delta[2] + v * delta[3];
            // More than a radian at once is no step of an iteration that gets anywhere.
            (tilt.norm() < 1.0).then(|| Cylinder {
                axis: Line {
                    point: point + u * delta[0] + v * delta[1],
                    direction: rotate_direction(&direction, &tilt),
                },
                radius: (cylinder.radius + delta[4]).clamp(0.5 * cylinder.radius, 2.0 * cylinder.radius),
            })
        };
        match self {
            Self::Cylinder(cylinder, bias) => Some(Self::Cylinder(moved(cylinder)?, bias + delta[5])),
            Self::Cone(cylinder, taper) => Some(Self::Cone(moved(cylinder)?, taper + delta[5])),
            Self::Sphere(center, radius) => {
                let center = center + Vector3::new(delta[0], delta[1], delta[2]);
                Some(Self::Sphere(center, (radius + delta[3]).clamp(0.5 * radius, 2.0 * radius)))
            }
        }
    }

    /// The same surface with the point of its axis next to a point.
    pub fn at(&self, p: &Vector3<f64>) -> Self {
        let shifted = |cylinder: &Cylinder| {
            let Line { point, direction } = cylinder.axis;
            let along = (p - point).dot(&direction);
            (Line { point: point + direction * along, direction }, along)
        };
        match self {
            Self::Cylinder(cylinder, bias) => {
                Self::Cylinder(Cylinder { axis: shifted(cylinder).0, radius: cylinder.radius }, *bias)
            }
            Self::Cone(cylinder, taper) => {
                let (axis, along) = shifted(cylinder);
                Self::Cone(Cylinder { axis, radius: cylinder.radius + taper * along }, *taper)
            }
            Self::Sphere(..) => *self,
        }
    }

    pub fn radius(&self) -> f64 {
        match self {
            Self::Cylinder(cylinder, _) | Self::Cone(cylinder, _) => cylinder.radius,
            Self::Sphere(_, radius) => *radius,
        }
    }

    /// Whether the observer at the origin is inside.
    pub fn contains_origin(&self) -> bool {
        match self {
            Self::Cylinder(cylinder, _) | Self::Cone(cylinder, _) => cylinder.contains_origin(),
            Self::Sphere(center, radius) => center.norm() <= *radius,
        }
    }
}

impl From<distances::ProjectionOf<f32>> for Projection {
    fn from(projection: distances::ProjectionOf<f32>) -> Self {
        let distances::ProjectionOf { distance, normal, along } = projection;
        Self { distance: distance.into(), normal: normal.map(f64::from).into(), along: along.into() }
    }
}

/// A ray that touches a cylinder, beside a limb.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tangent {
    pub ray: Vector3<f64>,
    /// How far inside of the limb it passes, in pixels.
    pub inset: f64,
    /// Standard deviation of that, in pixels.
    pub deviation: f64,
    /// As how many measurements it counts.
    pub weight: f64,
}

/// How the scene was measured.
#[derive(Debug, Clone, Copy)]
pub(super) struct Optics {
    /// The side of a pixel on the plane z = 1.
    pub pixel: f64,
    /// Cells that share one error.
    pub cells_per_sample: f64,
}

/// The mean of the points of the cells `which`.
pub(super) fn middle(cells: &[Cell], which: &[usize]) -> Vector3<f64> {
    // Four sums side by side: none waits for another.
    let mut sums = [Vector3::zeros(); 4];
    for some in which.chunks(sums.len()) {
        sums.iter_mut().zip(some).for_each(|(sum, &k)| *sum += cells[k].point);
    }
    sums.iter().sum::<Vector3<f64>>() / which.len() as f64
}

/// By how much the radius of a cylinder seems to grow along its axis, and the standard deviation of that: one step from the
/// cylinder to the cone that explains cells and sides best, the bias at the limbs among the unknowns.
pub(super) fn slope(
    surface: &Surface,
    (cells, which): (&[Cell], &[usize]),
    tangents: &[Tangent],
    optics: Optics,
) -> Option<[f64; 2]> {
    let center = middle(cells, which);
    let surface = surface.at(&center);
    let Surface::Cylinder(cylinder, bias) = surface else { return None };
    let pixel = optics.pixel * center.z;
    let mut step = ToCone::new(&cylinder);
    let mut add = |projection: &Projection, distance: f64, sigma: f64, shape: f64, weight: f64| {
        let ratio = distance / (REACH.get() * sigma);
        if ratio.abs() < 1.0 {
            let part = 1.0 - ratio * ratio;
            step.add(projection, distance, shape, weight * part * part / (sigma * sigma));
        }
    };
    for &k in which {
        let Cell { x, y, point, sigma, .. } = cells[k];
        let [x, y, sigma] = [x, y, sigma].map(|number| number as f32);
        let point = point.map(|number| number as f32).into();
        let residual = distances::residual(Scalar, &surface, optics.pixel, point, [x, y], sigma);
        let [distance, information, shape] =
            [residual.distance, residual.information, residual.shape].map(f64::from);
        let sigma = information.sqrt().recip();
        add(&residual.projection.into(), distance, sigma, shape, 1.0 / optics.cells_per_sample);
    }
    for Tangent { ray, inset, deviation, weight } in tangents {
        let projection = surface.project(&(ray * cylinder.axis.nearest_on_ray(ray)));
        add(&projection, projection.distance + inset * pixel, deviation * pixel, 0.0, *weight);
    }
    step.expect(bias, BIAS_PIXELS.get() * pixel);
    step.slope()
}

/// Fits a surface to the cells `which` from a start. Cells beyond `reach` standard deviations do not count; `reach` shrinks to
/// [`REACH`] within the steps.
pub(super) fn fit(
    start: &Surface,
    (cells, which): (&[Numbers], &[usize]),
    tangents: &[Tangent],
    optics: Optics,
    mut reach: f64,
    steps: usize,
) -> Option<Surface> {
    let cells = Cells::new(cells, which, optics);
    let center = cells.middle();
    let as_length = |pixels: f64| pixels * optics.pixel * center.z;
    let mut surface = start.at(&center);
    for _ in 0..steps {
        if !(surface.radius() > 0.0 && surface.radius().is_finite()) {
            return None;
        }
        let (u, v) = surface.across();
        let mut equations = cells.normal_equations(&surface, (&u, &v), reach);
        if equations.count < 8 {
            return None;
        }
        let mut parameters = surface.parameters() as usize;
        if let Surface::Cylinder(cylinder, bias) = surface {
            equations.add_tangents((&surface, &cylinder), (&u, &v), tangents, as_length, reach);
            equations.expect_bias(bias, as_length(BIAS_PIXELS.get()));
            parameters = 6;
        }
        equations.complete(parameters);
        equations.damp(&surface, parameters);
        let delta = equations.step()?;
        let moved = surface.step(&delta)?;
        let change = (moved.radius() - surface.radius()).abs() / surface.radius();
        surface = moved;
        let settled = reach <= REACH.get() && change < LEAST_CHANGE;
        reach = (0.5 * reach).max(REACH.get());
        if settled {
            break;
        }
    }
    surface.radius().is_finite().then_some(surface)
}

impl NormalEquations {
    /// Adds the rays that touch a cylinder beside its limbs. Those beyond `reach` standard deviations do not count.
    fn add_tangents(
        &mut self,
        (surface, cylinder): (&Surface, &Cylinder),
        (u, v): (&Vector3<f64>, &Vector3<f64>),
        tangents: &[Tangent],
        as_length: impl Fn(f64) -> f64,
        reach: f64,
    ) {
        for Tangent { ray, inset, deviation, weight } in tangents {
            let projection = surface.project(&(ray * cylinder.axis.nearest_on_ray(ray)));
            let distance = projection.distance + as_length(*inset);
            let sigma = as_length(*deviation);
            let ratio = distance / sigma;
            if ratio.abs() > reach {
                continue;
            }
            let part = 1.0 - (ratio / reach).powi(2);
            let weight = weight * part * part / (sigma * sigma);
            let (nu, nv) = (projection.normal.dot(u), projection.normal.dot(v));
            let row = SVector::<f64, 6>::from([
                -nu,
                -nv,
                -nu * projection.along,
                -nv * projection.along,
                -1.0,
                0.0,
            ]);
            // The last one is 0: no bias shows in an edge.
            for i in 0..5 {
                let weighted = weight * row[i];
                for j in 0..=i {
                    self.matrix[(i, j)] += weighted * row[j];
                }
            }
            self.vector += row * (weight * distance);
        }
    }

    /// Adds what is expected of the bias at the limbs: 0, with a standard deviation.
    fn expect_bias(&mut self, bias: f64, deviation: f64) {
        self.matrix[(5, 5)] += 1.0 / (deviation * deviation);
        self.vector[5] += bias / (deviation * deviation);
    }

    /// The step to the minimum, by the decomposition L D Lᵀ; `None` where it is not determined. Each root and each division of
    /// Cholesky's would wait for the one before; this has six divisions and no roots. With loops of a known length it takes half as
    /// long as with those of any.
    #[allow(clippy::needless_range_loop, reason = "two columns and a vector by the same indices")]
    fn step(&self) -> Option<SVector<f64, 6>> {
        // Column by column.
        let mut lower = self.matrix.data.0;
        let mut step = -self.vector;
        for j in 0..6 {
            let column = lower[j];
            if !(column[j] > 0.0) {
                return None;
            }
            let inverse = 1.0 / column[j];
            lower[j] = column.map(|number| number * inverse);
            for k in j + 1..6 {
                for i in k..6 {
                    lower[k][i] -= lower[j][k] * column[i];
                }
                step[k] -= step[j] * lower[j][k];
            }
            step[j] *= inverse;
        }
        for j in (0..6).rev() {
            // What is known last comes last.
            for i in (j + 1..6).rev() {
                step[j] -= lower[j][i] * step[i];
            }
        }
        Some(step)
    }

    /// Fills the upper half of the matrix, and holds what is beyond the parameters at 0.
    fn complete(&mut self, parameters: usize) {
        let Self { matrix, vector, .. } = self;
        for i in 0..6 {
            for j in 0..i {
                matrix[(j, i)] = matrix[(i, j)];
            }
            if i >= parameters {
                matrix.row_mut(i).fill(0.0);
                matrix.column_mut(i).fill(0.0);
                vector[i] = 0.0;
                matrix[(i, i)] = 1.0;
            }
        }
    }

    /// Damps the step, so that nearly undetermined combinations stay: by [`DAMPING`] times what the best determined
    /// one is. Of a sphere, whose radius and depth are nearly one combination, by that of its shift across.
    fn damp(&mut self, surface: &Surface, parameters: usize) {
        let matrix = &mut self.matrix;
        let scale = match surface {
            Surface::Sphere(..) => matrix[(0, 0)],
            _ => matrix[(4, 4)].max(matrix[(0, 0)]),
        } * DAMPING;
        let radius = surface.radius();
        for i in 0..parameters {
            let lever = match (surface, i) {
                (Surface::Cylinder(..) | Surface::Cone(..), 2 | 3) | (Surface::Cone(..), 5) => {
                    radius * radius
                }
                _ => 1.0,
            };
            matrix[(i, i)] += scale * lever;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::SMatrix;

    #[test]
    fn a_step_is_that_of_cholesky() {
        for seed in 0..50 {
            let root =
                SMatrix::<f64, 6, 6>::from_fn(|i, j| ((7 * i * i + 13 * i * j + 29 * seed) as f64).sin());
            let vector = SVector::<f64, 6>::from_fn(|i, _| ((5 * i + 3 * seed) as f64).cos());
            let matrix = root * root.transpose() + SMatrix::identity() * 0.01;
            let equations = NormalEquations { matrix, vector, count: 6 };
            let expected = equations.matrix.cholesky().unwrap().solve(&-vector);
            let off = equations.step().unwrap() - expected;
            assert!(off.amax() <= 1e-9 * expected.amax(), "{seed} {off}");
        }
        let vector = SVector::<f64, 6>::zeros();
        for last in [0.0, -1.0, f64::NAN] {
            let mut matrix = SMatrix::<f64, 6, 6>::identity();
            matrix[(5, 5)] = last;
            assert_eq!(NormalEquations { matrix, vector, count: 6 }.step(), None);
        }
    }
}
