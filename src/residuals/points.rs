//! The point-to-cylinder term: e_i = ‖m − p_i × d̂‖ − r (15), (16).
//!
//! In the local frame, with (x, y, h) = R (p − c) / unit and ρ = √(x² + y²), the residual is ρ − r / unit and
//! its Jacobian (−x/ρ, −y/ρ, −h x/ρ, −h y/ρ, −1).

use super::kernel::{
    Coordinates, CostAlone, FacingAndSquares, Influences, Kernel, SUMS, Terms, Whole, Within,
};
use super::loss::{BySlopes, Loss, Wall};
use super::{NormalEquations, SandwichPart};
use crate::geometry::{LocalFrame, Tangent, TangentMap, Walls};
use crate::memory::List;
use crate::observations::{Offsets, PointCloud};
use crate::workers::Workers;
use nalgebra::Vector3;

/// The points of a fit with the sum of their weights.
#[derive(Debug, Clone, Copy)]
pub struct PointTerm<'a> {
    cloud: &'a PointCloud,
    total_weight: f64,
    workers: Option<Workers>,
    /// Some of very many points, which are like all of them.
    part: Option<&'a PointCloud>,
    /// The sum of slopes times Jacobian times Jacobian in coordinates in which that with weights for slopes is 1, where a part
    /// of the points has told it.
    slopes: Option<TangentMap>,
}

/// A leverage above this says that the points hardly do more than determine the cylinder: their residuals tell nothing
/// of their noise.
const LARGEST_LEVERAGE: f64 = 0.5;

/// The part of JᵀΩJ that is left of the second derivative where many points are nearly out.
const LEAST_RELIEF: f64 = 0.2;

/// Points summed in one go. A fixed number, so that the sums do not depend on the number of threads.
const CHUNK: usize = 8192;

impl<'a> PointTerm<'a> {
    /// The term of a cloud, summed on the thread of the caller or with those of workers, to the same bits.
    #[must_use]
    pub fn new(cloud: &'a PointCloud, workers: Option<Workers>) -> Self {
        let total_weight = match cloud.weights() {
            None => cloud.len() as f64,
            Some(weights) => weights.iter().map(|&weight| f64::from(weight)).sum(),
        };
        Self { cloud, total_weight, workers, part: None, slopes: None }
    }

    /// The term of another cloud, summed as this one is.
    #[must_use]
    pub fn of<'b>(&self, cloud: &'b PointCloud) -> PointTerm<'b> {
        PointTerm { slopes: self.slopes, ..PointTerm::new(cloud, self.workers) }
    }

    /// The term with some of very many points that are like all of them.
    #[must_use]
    pub fn with_part(self, part: Option<&'a PointCloud>) -> Self {
        Self { part, ..self }
    }

    /// The term of that part.
    #[must_use]
    pub fn part(&self) -> Option<PointTerm<'a>> {
        self.part.map(|part| self.of(part))
    }

    /// The term with curvatures as a part of its points, if there is one, tells them about a cylinder. Noise is not the same
    /// everywhere on a surface, so that steps by the mean slope of the influence miss the minimum by a tenth, and each step
    /// is a pass over all points.
    #[must_use]
    pub fn with_curvature(self, frame: &LocalFrame, loss: impl Loss) -> Self {
        let slopes = self.part().and_then(|part| part.slopes_of_influence(frame, loss));
        Self { slopes, ..self }
    }

    #[inline(never)] // Not inlined: its locals would enlarge the caller's stack frame.
    fn slopes_of_influence(&self, frame: &LocalFrame, loss: impl Loss) -> Option<TangentMap> {
        let root = self.linearise(frame, loss).hessian.cholesky()?.l();
        let by_slopes = self.linearise(frame, BySlopes(loss)).hessian;
        let half = root.solve_lower_triangular(&by_slopes)?;
        let slopes = root.solve_lower_triangular(&half.transpose())?;
        // Where many points are nearly out there may be no minimum.
        (slopes.symmetric_eigenvalues().min() > LEAST_RELIEF).then_some(slopes)
    }

    /// The number of points.
    #[must_use]
    pub fn count(&self) -> usize {
        self.cloud.len()
    }

    /// The sum of their weights.
    #[must_use]
    pub fn total_weight(&self) -> f64 {
        self.total_weight
    }

    /// The mean over the points: cost = Σ w ρ(e) / Σ w, which is E_P / unit² for the plain square.
    #[must_use]
    pub fn linearise(&self, frame: &LocalFrame, loss: impl Loss) -> NormalEquations {
        if self.cloud.is_empty() {
            return NormalEquations::zero();
        }
        let mut equations = NormalEquations::zero();
        equations.add_scaled(1.0 / self.total_weight, &unpack(&self.sums(frame, Whole(loss))));
        let told = self.slopes.and_then(|slopes| {
            let root = equations.hessian.cholesky()?.l();
            Some(root * slopes * root.transpose())
        });
        NormalEquations { curvature: told.unwrap_or(equations.curvature), ..equations }
    }

    /// The cost of [`PointTerm::linearise`] alone, to the last bit.
    #[must_use]
    pub fn cost(&self, frame: &LocalFrame, loss: impl Loss) -> f64 {
        if self.cloud.is_empty() {
            return 0.0;
        }
        let [cost] = self.sums(frame, CostAlone(loss));
        1.0 / self.total_weight * cost
    }

    /// The weighted residuals and their Jacobians one by one: what [`PointTerm::linearise`] sums.
    pub fn rows<L: Loss>(
        &self,
        frame: &LocalFrame,
        loss: L,
    ) -> impl Iterator<Item = (f64, Tangent)> + use<'a, L> {
        let Self { cloud, total_weight, .. } = *self;
        let rows = PointRows::new(frame);
        cloud.points().enumerate().map(move |(index, point)| {
            let (residual, jacobian, facing) = rows.row(&point);
            let weight = cloud.weight(index) / total_weight * loss.influence(residual, facing).weight;
            (residual * weight.sqrt(), jacobian * weight.sqrt())
        })
    }

    /// The signed distances of the points from the surface, in units of the frame.
    #[must_use]
    pub fn distances(&self, frame: &LocalFrame) -> List<f64> {
        self.distances_on(Wall::Either, frame)
    }

    /// The same, infinite for points that cannot be where they are.
    #[must_use]
    pub fn distances_on(&self, wall: Wall, frame: &LocalFrame) -> List<f64> {
        let kernel = Kernel::new(self.cloud.origin(), frame);
        match self.cloud.offsets() {
            Offsets::F32(axes) => kernel.distances(axes, wall),
            Offsets::F64(axes) => kernel.distances(axes, wall),
        }
    }

    /// The same, some at a time and without a list of all.
    pub fn distances_by_blocks(&self, frame: &LocalFrame, block: impl FnMut(&[f64])) {
        let kernel = Kernel::new(self.cloud.origin(), frame);
        match self.cloud.offsets() {
            Offsets::F32(axes) => kernel.distances_by_blocks(axes, Wall::Either, block),
            Offsets::F64(axes) => kernel.distances_by_blocks(axes, Wall::Either, block),
        }
    }

    /// The points on the wall that an observer at the origin sees, see [`Cylinder::visible_wall`](crate::geometry::Cylinder::visible_wall),
    /// and E_P: the weighted mean of the squared residuals, in the caller's unit squared.
    #[must_use]
    pub fn walls_and_energy(&self, frame: &LocalFrame) -> (Walls, f64) {
        let total = self.cloud.len();
        if total == 0 {
            return (Walls::default(), 0.0);
        }
        let [facing, squares] = self.sums(frame, FacingAndSquares);
        let facing = facing as usize;
        let visible = if frame.cylinder.contains_origin() { total - facing } else { facing };
        (Walls { visible, total }, 1.0 / self.total_weight * squares * frame.unit * frame.unit)
    }

    /// How many of the points are at most so far from the surface, in units of the frame.
    #[must_use]
    pub fn count_within(&self, frame: &LocalFrame, limit: f64) -> usize {
        self.sums(frame, Within(limit))[0] as usize
    }

    /// What the points add to the covariance of a minimum, of which `independent_points` are independent. `equations` are
    /// those of [`PointTerm::linearise`] there.
    ///
    /// Every point stands for its own noise, which may depend on the position on the surface as that of depth does on the
    /// slope: B = Σ ψ² J Jᵀ (White's estimator) with the influence ψ = w(e) e and the correction of the residuals by
    /// their leverage (HC3 of MacKinnon and White 1985). A is the mean slope of ψ for Σ w J Jᵀ, so that points without
    /// influence (background) do not count as measured.
    #[must_use]
    pub fn sandwich(
        &self,
        frame: &LocalFrame,
        loss: impl Loss,
        independent_points: f64,
        equations: &NormalEquations,
    ) -> SandwichPart {
        let NormalEquations { gradient, hessian, .. } = *equations;
        let Some(factor) = hessian.cholesky() else { return SandwichPart::zero() };
        // Other terms pull the cylinder away from the points. The part of the residuals that a step to the minimum of
        // the points would take away is no noise.
        let to_minimum = -factor.solve(&gradient);
        let copies = self.cloud.len() as f64 / independent_points;
        let leverages = factor.inverse() * copies;
        let influences = Influences {
            loss,
            part: 1.0 / self.total_weight,
            to_minimum: &to_minimum,
            leverages: &leverages,
            largest_leverage: LARGEST_LEVERAGE,
        };
        let [weights, slopes, squared_slopes, one, a, b, ah, bh, products @ ..] =
            self.sums(frame, influences);
        let covariance = squares([one, a, b, ah, bh], products);
        // Huber's correction for few points (1981, section 7.6): slopes that differ from point to point make the
        // estimate less certain than their mean says.
        let correction = 1.0 + 5.0 / independent_points * (squared_slopes / (slopes * slopes) - 1.0);
        // An error in units of the deviation that n − 5 degrees of freedom tell is Student's t, of this variance.
        let student = (independent_points - 5.0).max(1.0) / (independent_points - 7.0).max(1.0);
        SandwichPart {
            gradient,
            derivative: hessian * (slopes / weights),
            covariance: covariance * (copies * correction * correction * student),
        }
    }

    /// Sums over all chunks, always added in the order of the chunks.
    fn sums<const N: usize>(&self, frame: &LocalFrame, terms: impl Terms<N>) -> [f64; N] {
        let kernel = Kernel::new(self.cloud.origin(), frame);
        let weights = self.cloud.weights();
        match self.cloud.offsets() {
            Offsets::F32(axes) => self.sum(|range| kernel.chunk(axes, weights, range, terms)),
            Offsets::F64(axes) => self.sum(|range| kernel.chunk(axes, weights, range, terms)),
        }
    }

    fn sum<const N: usize>(&self, chunk: impl Fn(std::ops::Range<usize>) -> [f64; N] + Sync) -> [f64; N] {
        let count = self.cloud.len();
        let chunks = count.div_ceil(CHUNK);
        let one = |index: usize| chunk(index * CHUNK..((index + 1) * CHUNK).min(count));
        let mut total = [0.0; N];
        let mut add = |part: &[f64; N]| total.iter_mut().zip(part).for_each(|(t, p)| *t += p);
        let mut parts = Vec::new();
        match self.workers.filter(|_| chunks > 1) {
            // Without memory for the parts the work is done without workers.
            Some(workers) if parts.try_reserve_exact(chunks).is_ok() => {
                parts.resize(chunks, [0.0; N]);
                workers.fill(&mut parts, one);
                parts.iter().for_each(add);
            }
            _ => (0..chunks).for_each(|index| add(&one(index))),
        }
        total
    }
}

/// The matrix of the products of (a, b, h a, h b, 1), which are those of the Jacobian, with each other.
fn squares([one, a, b, ah, bh]: [f64; 5], products: [f64; 9]) -> TangentMap {
    let [aa, ab, bb, aah, abh, bbh, aahh, abhh, bbhh] = products;
    TangentMap::new(
        aa, ab, aah, abh, a, //
        ab, bb, abh, bbh, b, //
        aah, abh, aahh, abhh, ah, //
        abh, bbh, abhh, bbhh, bh, //
        a, b, ah, bh, one,
    )
}

/// The sums as normal equations of the Jacobian (−a, −b, −h a, −h b, −1).
pub(super) fn unpack(sums: &[f64; SUMS]) -> NormalEquations {
    let [loss, slopes, w, e, ea, eb, eah, ebh, a, b, ah, bh, products @ ..] = *sums;
    let hessian = squares([w, a, b, ah, bh], products);
    let relief = slopes / w;
    let curvature = if relief <= 1.0 { hessian * relief.max(LEAST_RELIEF) } else { hessian };
    NormalEquations { cost: loss, gradient: -Tangent::new(ea, eb, eah, ebh, e), hessian, curvature }
}

/// Residuals and their Jacobians one by one, without the sums: for the covariance, the stacked system, and points that
/// are no [`PointCloud`].
pub(crate) struct PointRows {
    /// For points by their offset from the axis point.
    kernel: Kernel,
    axis_point: Vector3<f64>,
}

impl PointRows {
    pub fn new(frame: &LocalFrame) -> Self {
        let axis_point = frame.cylinder.axis.point;
        Self { kernel: Kernel::new(&axis_point, frame), axis_point }
    }

    #[inline(always)]
    fn coordinates(&self, point: &Vector3<f64>) -> Coordinates<f64> {
        self.kernel.coordinates(pulp::Scalar::new(), (point - self.axis_point).into())
    }

    /// Residual, Jacobian, and on which side of the surface the point lies, as in [`Loss::influence`].
    #[inline]
    pub fn row(&self, point: &Vector3<f64>) -> (f64, Tangent, f64) {
        let Coordinates { rho, a, b, h, facing } = self.coordinates(point);
        (rho - self.kernel.radius, Tangent::new(-a, -b, -h * a, -h * b, -1.0), facing)
    }

    /// Residual and side alone.
    #[inline]
    pub fn residual(&self, point: &Vector3<f64>) -> (f64, f64) {
        let coordinates = self.coordinates(point);
        (coordinates.rho - self.kernel.radius, coordinates.facing)
    }
}

#[cfg(test)]
mod tests;
