//! The algebraic least-squares cylinder from moments: one pass over the points, then a cost per direction
//! that does not depend on their number.
//!
//! After D. Eberly, "Fitting 3D Data with a Cylinder" (Geometric Tools). For an axis direction d̂ and (u, v)
//! across it, with x = q·u, y = q·v and h = q·d̂, the residual
//!
//! f = x² + y² − 2αx − 2βy − K
//!
//! vanishes on the cylinder with the axis through αu + βv and r² = K + α² + β². It is linear in (α, β, K),
//! so these follow in closed form, and G(d̂) = mean f² is a function on the sphere. f is a quadratic
//! polynomial of q, so G and its derivatives are quadratic forms of the matrix of moments up to degree four.
//! Eberly searches a grid; here the lowest grid directions are refined by Newton's method with the exact
//! Hessian.
//!
//! f = (ρ − r)(ρ + r) for a point at distance ρ from the axis weighs outer points more: with noise and an arc
//! that is not the full circle the radius comes out too small. This is a start, not a result.

mod spread;

use crate::geometry::{AxisCone, Cylinder, any_orthogonal, rotate_direction};
use crate::memory::List;
use nalgebra::{Matrix2, Matrix3, Matrix3x2, SMatrix, SVector, Vector2, Vector3};
use pulp::{Arch, Simd, WithSimd};
pub use spread::Spread;
use spread::{about, covariance, is_flat};

/// Coefficients of a quadratic polynomial in the monomials 1, x, y, z, x², xy, xz, y², yz, z².
type Polynomial = SVector<f64, 10>;

/// Those of the last six of them.
type Quadratic = SVector<f64, 6>;

/// Directions of the grid that [`Moments::best`] searches.
const DEFAULT_SEEDS: usize = 128;

/// Grid minima that are refined. G has a handful of minima on the half sphere.
const REFINED_SEEDS: usize = 6;

/// Limit of Newton steps; quadratic convergence needs about five.
const NEWTON_STEPS: usize = 30;

/// After a step of this size (radians) the next would be lost in rounding.
const CONVERGED: f64 = 1e-10;

/// Two minima closer than this (radians) are the same one.
const SAME_DIRECTION: f64 = 1e-4;

/// The weighted moments of a cloud up to degree four.
#[derive(Debug, Clone)]
pub struct Moments {
    /// Mean of m mᵀ for the monomials m of q = (p − center) / unit.
    gram: SMatrix<f64, 10, 10>,
    /// Weighted mean of the points.
    center: Vector3<f64>,
    /// Weighted root mean square distance of the points from the mean.
    unit: f64,
}

/// A cylinder that fits algebraically.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AlgebraicFit {
    /// The cylinder. Its axis point is the one nearest to the mean of the points.
    pub cylinder: Cylinder,
    /// G, the weighted mean of (ρ² − r²)² for points at distance ρ from the axis, in the fourth power of the
    /// unit of length of the data.
    pub mean_square: f64,
}

impl AlgebraicFit {
    /// √G / 2r, in the unit of length of the data: to first order the root mean square of the orthogonal
    /// distances ρ − r.
    #[must_use]
    pub fn distance_rms(&self) -> f64 {
        self.mean_square.sqrt() / (2.0 * self.cylinder.radius)
    }
}

/// The optimum for one direction, in coordinates q.
#[derive(Clone, Copy)]
struct Slice {
    direction: Vector3<f64>,
    u: Vector3<f64>,
    v: Vector3<f64>,
    alpha: f64,
    beta: f64,
    radius: f64,
    /// The matrix of moments times the coefficients of f.
    weighted_residual: Polynomial,
    /// G.
    mean_square: f64,
}

impl Moments {
    /// The moments of points with weights.
    ///
    /// Points with a coordinate that is not finite or a weight that is not positive and finite are left out.
    /// `None` when fewer than five remain, or when they lie in one plane or on one line to rounding.
    #[must_use]
    pub fn new(points: impl Iterator<Item = (Vector3<f64>, f64)> + Clone) -> Option<Self> {
        let Spread { center, size: unit } = Spread::unchecked(points.clone())?;
        let gram = about(points, center, unit, monomials)?;
        let moments = Self { gram, center, unit };
        (!is_flat(&moments.covariance())).then_some(moments)
    }

    /// The minima of G that are reached from the lowest local minima of a grid of `seeds` directions on the
    /// half sphere, least [`AlgebraicFit::distance_rms`] first: G itself, 4r² times as large, would favour
    /// the thinner of two cylinders. The search of the grid takes time with the square of `seeds`; a hundred
    /// miss few minima. A Newton step of less than `converged` (radians) is the last one: the next would be about its
    /// square. All within a cone of directions, if there is one.
    #[must_use]
    pub fn minima(&self, cone: Option<&AxisCone>, seeds: usize, converged: f64) -> List<AlgebraicFit> {
        match cone {
            None => Arch::new().dispatch(Minima { moments: self, seeds, converged }),
            Some(cone) => self.minima_within(cone, seeds, converged),
        }
    }

    /// A minimum on the border of the cone is found by a search along it.
    fn minima_within(&self, cone: &AxisCone, seeds: usize, converged: f64) -> List<AlgebraicFit> {
        let at = |w: Vector2<f64>| self.slice(&cone.direction_at(&w));
        if cone.max_angle == 0.0 {
            return self.sorted(at(Vector2::zeros()).as_slice());
        }
        let grid: List<Slice> = disc(seeds).filter_map(|w| at(w * cone.max_angle)).collect();
        let area = std::f64::consts::PI * cone.max_angle * cone.max_angle;
        let mut minima = self.minima_of_grid(&grid, area, converged);
        minima.retain(|minimum| cone.contains(&minimum.direction));
        let border = |angle: f64| at(Vector2::new(angle.cos(), angle.sin()) * cone.max_angle);
        minima.extend(lowest_on_circle(border, seeds));
        self.sorted(&minima)
    }

    /// The minima that Newton's method reaches from the lowest local minima of a grid over some area of the sphere,
    /// in steradian.
    #[inline(always)]
    fn minima_of_grid(&self, grid: &[Slice], area: f64, converged: f64) -> List<Slice> {
        // One and a half times the distance of neighbours.
        let neighbour = (1.5 * (area / grid.len().max(1) as f64).sqrt()).cos();
        let mut lowest: List<Slice> = grid
            .iter()
            .filter(|a| {
                grid.iter().all(|b| {
                    b.mean_square >= a.mean_square || b.direction.dot(&a.direction).abs() < neighbour
                })
            })
            .copied()
            .collect();
        lowest.sort_by(|a, b| a.mean_square.total_cmp(&b.mean_square));

        let mut minima: List<Slice> = List::new();
        for seed in lowest.iter().take(REFINED_SEEDS) {
            let minimum = self.newton(*seed, converged);
            let known =
                minima.iter().any(|other| other.direction.cross(&minimum.direction).norm() < SAME_DIRECTION);
            if !known {
                minima.push(minimum);
            }
        }
        minima
    }

    /// The cylinders of slices, least distance first.
    fn sorted(&self, slices: &[Slice]) -> List<AlgebraicFit> {
        let mut fits: List<AlgebraicFit> = slices.iter().map(|slice| self.fit(slice)).collect();
        fits.sort_by(|a, b| a.distance_rms().total_cmp(&b.distance_rms()));
        fits
    }

    /// The first of the minima, of all directions or within a cone.
    #[must_use]
    pub fn best(&self, cone: Option<&AxisCone>) -> Option<AlgebraicFit> {
        self.minima(cone, DEFAULT_SEEDS, CONVERGED).first().copied()
    }

    /// Covariance of q.
    fn covariance(&self) -> Matrix3<f64> {
        covariance(&self.gram.fixed_view::<4, 4>(0, 0).into_owned())
    }

    /// Minimises over (α, β, K) for a direction of unit length.
    #[inline(always)]
    fn slice(&self, direction: &Vector3<f64>) -> Option<Slice> {
        let (u, v) = any_orthogonal(direction);
        let square = quadratic(&u, &u) + quadratic(&v, &v);
        // Means of x, y and x² + y², and their products about the means.
        let means = self.gram.fixed_view::<3, 1>(1, 0);
        let between = self.gram.fixed_view::<3, 3>(1, 1);
        let (mean_x, mean_y) = (means.dot(&u), means.dot(&v));
        let mean_square = self.gram.fixed_view::<6, 1>(4, 0).dot(&square);
        let (between_x, between_y) = (between * u, between * v);
        let with_square = self.gram.fixed_view::<3, 6>(1, 4) * square;
        let xx = between_x.dot(&u) - mean_x * mean_x;
        let xy = between_x.dot(&v) - mean_x * mean_y;
        let yy = between_y.dot(&v) - mean_y * mean_y;
        let xs = with_square.dot(&u) - mean_x * mean_square;
        let ys = with_square.dot(&v) - mean_y * mean_square;
        // Regular because the cloud is not flat, and no projection is flatter than the cloud.
        let determinant = xx * yy - xy * xy;
        let alpha = 0.5 * (yy * xs - xy * ys) / determinant;
        let beta = 0.5 * (xx * ys - xy * xs) / determinant;
        let constant = mean_square - 2.0 * (alpha * mean_x + beta * mean_y);
        let radius = (constant + alpha * alpha + beta * beta).sqrt();
        if !(radius > 0.0 && radius.is_finite()) {
            return None;
        }

        let mut residual = Polynomial::zeros();
        residual[0] = -constant;
        residual.fixed_rows_mut::<3>(1).copy_from(&((u * alpha + v * beta) * -2.0));
        residual.fixed_rows_mut::<6>(4).copy_from(&square);
        let weighted_residual = self.gram * residual;
        // Rounding can carry the zero of points without noise below zero.
        let mean_square = residual.dot(&weighted_residual).max(0.0);
        Some(Slice { direction: *direction, u, v, alpha, beta, radius, weighted_residual, mean_square })
    }

    /// Gradient and Hessian of ½ G in the tangent (a, b) of the exponential map, d̂' = d̂ + a u + b v to
    /// first order.
    ///
    /// To second order h'² = (h + ax + by)² (1 − a² − b²), and u − a d̂, v − b d̂ span the plane across d̂'.
    /// What they lack of unit length is taken up by α and β, which G is minimised over:
    /// f = |q|² − h'² − 2α(x − ah) − 2β(y − bh) − K.
    #[inline(always)]
    fn derivatives(&self, slice: &Slice) -> Option<(Vector2<f64>, Matrix2<f64>)> {
        let Slice { direction, u, v, alpha, beta, .. } = slice;
        let axial = quadratic(direction, direction);
        let tilt = |across: &Vector3<f64>, shift: f64| {
            let mut tilt = Polynomial::zeros();
            tilt.fixed_rows_mut::<3>(1).copy_from(&(direction * (2.0 * shift)));
            tilt.fixed_rows_mut::<6>(4).copy_from(&(quadratic(direction, across) * -2.0));
            tilt
        };
        let tilts = SMatrix::<f64, 10, 2>::from_columns(&[tilt(u, *alpha), tilt(v, *beta)]);

        // E[f f_ij], the part of the Hessian that Gauss and Newton leave out.
        let curvature = |second: &Quadratic| slice.weighted_residual.fixed_rows::<6>(4).dot(second);
        let aa = curvature(&((axial - quadratic(u, u)) * 2.0));
        let bb = curvature(&((axial - quadratic(v, v)) * 2.0));
        let ab = curvature(&(quadratic(u, v) * -2.0));
        let h_mean = 2.0 * slice.weighted_residual.fixed_rows::<3>(1).dot(direction);

        let weighted_tilts = self.gram * tilts;
        let gradient = tilts.transpose() * slice.weighted_residual;
        let tilt_block = tilts.transpose() * weighted_tilts + Matrix2::new(aa, ab, ab, bb);
        // The derivatives in α, β and K are −2x, −2y and −1.
        let across = Matrix3x2::from_columns(&[*u, *v]) * -2.0;
        let mut mixed = Matrix3x2::zeros();
        mixed
            .fixed_view_mut::<2, 2>(0, 0)
            .copy_from(&(across.transpose() * weighted_tilts.fixed_view::<3, 2>(1, 0)));
        mixed.fixed_view_mut::<1, 2>(2, 0).copy_from(&-weighted_tilts.row(0));
        mixed[(0, 0)] += h_mean;
        mixed[(1, 1)] += h_mean;
        let of_shift = across.transpose() * self.gram.fixed_view::<3, 3>(1, 1) * across;
        let with_constant = across.transpose() * -self.gram.fixed_view::<3, 1>(1, 0);
        let mut linear_block = Matrix3::zeros();
        linear_block.fixed_view_mut::<2, 2>(0, 0).copy_from(&of_shift);
        linear_block.fixed_view_mut::<2, 1>(0, 2).copy_from(&with_constant);
        linear_block.fixed_view_mut::<1, 2>(2, 0).copy_from(&with_constant.transpose());
        linear_block[(2, 2)] = self.gram[(0, 0)];

        let eliminated = linear_block.cholesky()?.solve(&mixed);
        let hessian = tilt_block - mixed.transpose() * eliminated;
        (gradient.iter().chain(hessian.iter()).all(|x| x.is_finite())).then_some((gradient, hessian))
    }

    /// Newton's method on the sphere, downhill: negative curvature is turned round, and a step that does not
    /// lower G is halved.
    #[inline(always)]
    fn newton(&self, start: Slice, converged: f64) -> Slice {
        /// The longest step in radians, about the distance within which a minimum can be followed.
        const LONGEST: f64 = 0.3;
        /// Most lengths of a step that are tried.
        const HALVINGS: usize = 20;
        // Near the optimum G no longer tells two directions apart but its gradient still does.
        let rounding = 1e-15 * self.gram.amax();

        let mut slice = start;
        for _ in 0..NEWTON_STEPS {
            let Some((gradient, hessian)) = self.derivatives(&slice) else { break };
            let eigen = hessian.symmetric_eigen();
            let floor = 1e-9 * eigen.eigenvalues.amax() + f64::MIN_POSITIVE;
            let mut step = Vector2::zeros();
            for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
                let mut along = -gradient.dot(&vector) / value.abs().max(floor);
                // A saddle or a maximum has no gradient to follow.
                if *value < -floor && along.abs() < 1e-3 {
                    along = if along < 0.0 { -0.1 } else { 0.1 };
                }
                step += vector * along;
            }
            let mut length = (LONGEST / step.norm()).min(1.0);
            let mut lower = None;
            // No closures, as in `Minima`.
            for _ in 0..HALVINGS {
                let tangent = slice.u * (step.x * length) + slice.v * (step.y * length);
                length *= 0.5;
                lower = self.slice(&rotate_direction(&slice.direction, &tangent));
                lower = lower.filter(|trial| trial.mean_square <= slice.mean_square + rounding);
                if lower.is_some() {
                    break;
                }
            }
            let Some(lower) = lower else { break };
            slice = lower;
            if step.norm() < converged {
                break;
            }
        }
        slice
    }

    /// The cylinder of a slice, in space.
    fn fit(&self, slice: &Slice) -> AlgebraicFit {
        let across = slice.u * slice.alpha + slice.v * slice.beta;
        let axis =
            crate::geometry::Line { point: self.center + across * self.unit, direction: slice.direction };
        AlgebraicFit {
            cylinder: Cylinder { axis, radius: slice.radius * self.unit },
            mean_square: slice.mean_square * self.unit.powi(4),
        }
    }
}

/// The polynomial (q·a)(q·b): the coefficients of its quadratic monomials.
fn quadratic(a: &Vector3<f64>, b: &Vector3<f64>) -> Quadratic {
    Quadratic::new(
        a.x * b.x,
        a.x * b.y + a.y * b.x,
        a.x * b.z + a.z * b.x,
        a.y * b.y,
        a.y * b.z + a.z * b.y,
        a.z * b.z,
    )
}

/// The minima over all directions.
struct Minima<'a> {
    moments: &'a Moments,
    seeds: usize,
    converged: f64,
}

impl WithSimd for Minima<'_> {
    type Output = List<AlgebraicFit>;

    /// Products of small matrices, which the compiler makes the widest instructions of the machine of where they are inlined
    /// here; they all round alike.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> List<AlgebraicFit> {
        let Self { moments, seeds, converged } = self;
        let mut grid = List::with_capacity(seeds);
        for direction in half_sphere(seeds) {
            grid.extend(moments.slice(&direction));
        }
        let minima = moments.minima_of_grid(&grid, std::f64::consts::TAU, converged);
        moments.sorted(&minima)
    }
}

/// Evenly spread directions of the half sphere z > 0 (Fibonacci).
fn half_sphere(count: usize) -> impl Iterator<Item = Vector3<f64>> {
    let golden_angle = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    (0..count).map(move |i| {
        let z = (i as f64 + 0.5) / count as f64;
        let (sin, cos) = (i as f64 * golden_angle).sin_cos();
        let across = (1.0 - z * z).sqrt();
        Vector3::new(across * cos, across * sin, z)
    })
}

/// Evenly spread points of the unit disc, by the same rule.
fn disc(count: usize) -> impl Iterator<Item = Vector2<f64>> {
    let golden_angle = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    (0..count).map(move |i| {
        let (sin, cos) = (i as f64 * golden_angle).sin_cos();
        Vector2::new(cos, sin) * ((i as f64 + 0.5) / count as f64).sqrt()
    })
}

/// The lowest slice on a circle: the best of evenly spaced ones, and a golden-section search about it.
fn lowest_on_circle(at: impl Fn(f64) -> Option<Slice>, count: usize) -> Option<Slice> {
    /// The search narrows by 0.618 a step, to 1e-8 of the spacing.
    const STEPS: usize = 40;
    let spacing = std::f64::consts::TAU / count as f64;
    let value = |angle: f64| at(angle).map_or(f64::INFINITY, |slice| slice.mean_square);
    let angles = (0..count).map(|k| k as f64 * spacing);
    let best = angles.min_by(|a, b| value(*a).total_cmp(&value(*b)))?;
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut low, mut high) = (best - spacing, best + spacing);
    for _ in 0..STEPS {
        let reach = golden * (high - low);
        if value(high - reach) < value(low + reach) {
            high = low + reach;
        } else {
            low = high - reach;
        }
    }
    at(f64::midpoint(low, high))
}

/// The ten monomials up to degree two at q.
fn monomials(q: &Vector3<f64>) -> [f64; 10] {
    let [x, y, z] = [q.x, q.y, q.z];
    [1.0, x, y, z, x * x, x * y, x * z, y * y, y * z, z * z]
}

#[cfg(test)]
mod tests;
