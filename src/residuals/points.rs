//! The point-to-cylinder term: e_i = ‖m − p_i × d̂‖ − r (15), (16).
//!
//! In the local frame, with (x, y, h) = R (p − c) / unit and ρ = √(x² + y²), the residual is ρ − r / unit and
//! its Jacobian (−x/ρ, −y/ρ, −h x/ρ, −h y/ρ, −1).

use super::loss::{Loss, Squared};
use super::{NormalEquations, SandwichPart};
use crate::geometry::{LocalFrame, Tangent, TangentMap};
use crate::observations::{Offsets, PointCloud};
use crate::workers::Workers;
use nalgebra::{Matrix3, Vector2, Vector3};
use pulp::Arch;

/// The points of a fit with the sum of their weights.
#[derive(Debug, Clone, Copy)]
pub struct PointTerm<'a> {
    cloud: &'a PointCloud,
    total_weight: f64,
    workers: Option<&'a Workers>,
}

/// A leverage above this says that the points hardly do more than determine the cylinder: their residuals tell nothing
/// of their noise.
const LARGEST_LEVERAGE: f64 = 0.5;

/// Points summed in one go. A fixed number, so that the sums do not depend on the number of threads.
const CHUNK: usize = 4096;

/// Points that are converted to f64 in one go.
const BLOCK: usize = 64;

/// Partial sums that run side by side, so that the compiler can use vector instructions.
const LANES: usize = 8;

/// Distinct sums: loss, weights, residual times Jacobian, Jacobian times Jacobian.
const SUMS: usize = 20;

impl<'a> PointTerm<'a> {
    /// The term of a cloud, summed on the thread of the caller or by workers, with the same bits.
    #[must_use]
    pub fn new(cloud: &'a PointCloud, workers: Option<&'a Workers>) -> Self {
        let total_weight = match cloud.weights() {
            None => cloud.len() as f64,
            Some(weights) => weights.iter().map(|&weight| f64::from(weight)).sum(),
        };
        Self { cloud, total_weight, workers }
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
        equations
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
            let weight = cloud.weight(index) / total_weight * loss.loss_and_weight(residual, facing).1;
            (residual * weight.sqrt(), jacobian * weight.sqrt())
        })
    }

    /// The signed distances of the points from the surface, in units of the frame.
    #[must_use]
    pub fn distances(&self, frame: &LocalFrame) -> Vec<f64> {
        let kernel = Kernel::new(self.cloud.origin(), frame);
        match self.cloud.offsets() {
            Offsets::F32(axes) => kernel.distances(axes),
            Offsets::F64(axes) => kernel.distances(axes),
        }
    }

    /// What the points add to the covariance of a minimum, of which `independent_points` are independent.
    ///
    /// Every point stands for its own noise, which may depend on the place on the surface as that of depth does on the
    /// slope: B = Σ ψ² J Jᵀ (White's estimator) with the influence ψ = w(e) e and the correction of the residuals by
    /// their leverage (HC3 of MacKinnon and White 1985). A is the mean slope of ψ for Σ w J Jᵀ, so that points without
    /// influence (background) do not count as measured.
    #[must_use]
    pub fn sandwich(&self, frame: &LocalFrame, loss: impl Loss, independent_points: f64) -> SandwichPart {
        let NormalEquations { gradient, hessian, .. } = self.linearise(frame, loss);
        let Some(factor) = hessian.cholesky() else { return SandwichPart::zero() };
        // Other terms pull the cylinder away from the points. The part of the residuals that a step to the minimum of
        // the points would take away is no noise.
        let to_minimum = -factor.solve(&gradient);
        let copies = self.cloud.len() as f64 / independent_points;
        let leverages = factor.inverse() * copies;
        let (mut weights, mut slopes, mut squared_slopes) = (0.0, 0.0, 0.0);
        let mut covariance = TangentMap::zeros();
        let rows = PointRows::new(frame);
        for (index, point) in self.cloud.points().enumerate() {
            let part = self.cloud.weight(index) / self.total_weight;
            let (residual, jacobian, facing) = rows.row(&point);
            let weight = part * loss.loss_and_weight(residual, facing).1;
            let slope = loss.influence_slope(residual, facing);
            weights += weight;
            slopes += part * slope;
            squared_slopes += part * slope * slope;
            let leverage = weight * jacobian.dot(&(leverages * jacobian));
            let noise = (residual + jacobian.dot(&to_minimum)) / (1.0 - leverage.min(LARGEST_LEVERAGE));
            let influence = jacobian * (weight * noise);
            covariance += influence * influence.transpose();
        }
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

    /// E_P: the weighted mean of the squared residuals, in the caller's unit squared.
    #[must_use]
    pub fn energy(&self, frame: &LocalFrame) -> f64 {
        self.linearise(frame, Squared).cost * frame.unit * frame.unit
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

/// What is summed over the points.
trait Terms<const N: usize>: Copy + Sync {
    /// The terms of one point with its weight.
    fn of(&self, place: &Place, residual: f64, weight: f64) -> [f64; N];
}

/// Everything that the normal equations need.
#[derive(Clone, Copy)]
struct Whole<L>(L);

/// The loss alone, the first of these sums.
#[derive(Clone, Copy)]
struct CostAlone<L>(L);

impl<L: Loss> Terms<SUMS> for Whole<L> {
    #[inline(always)]
    fn of(&self, place: &Place, e: f64, weight: f64) -> [f64; SUMS] {
        let Place { a, b, h, facing, .. } = *place;
        let (value, factor) = self.0.loss_and_weight(e, facing);
        let w = weight * factor;
        let (wa, wb, we) = (w * a, w * b, w * e);
        let (aa, ab, bb) = (wa * a, wa * b, wb * b);
        [
            weight * value,
            w,
            we,
            we * a,
            we * b,
            we * a * h,
            we * b * h,
            wa,
            wb,
            wa * h,
            wb * h,
            aa,
            ab,
            bb,
            aa * h,
            ab * h,
            bb * h,
            aa * h * h,
            ab * h * h,
            bb * h * h,
        ]
    }
}

impl<L: Loss> Terms<1> for CostAlone<L> {
    #[inline(always)]
    fn of(&self, place: &Place, e: f64, weight: f64) -> [f64; 1] {
        [weight * self.0.loss_and_weight(e, place.facing).0]
    }
}

/// Where a point lies in relation to a cylinder, in the frame and its unit.
struct Place {
    /// Distance from the axis.
    rho: f64,
    /// The direction from the axis to the point, (a, b) across the axis; 0 on it.
    a: f64,
    b: f64,
    /// The coordinate along the axis.
    h: f64,
    /// Negative where the outward normal points towards the observer at the origin.
    facing: f64,
}

/// What all points share: the motion into the local frame.
struct Kernel {
    rotation: Matrix3<f64>,
    shift: Vector3<f64>,
    radius: f64,
    /// The observer across the axis.
    observer: Vector2<f64>,
}

impl Kernel {
    /// For points given by their offset from an origin.
    fn new(origin: &Vector3<f64>, frame: &LocalFrame) -> Self {
        let rotation = frame.rotation() / frame.unit;
        // The difference of two nearby points first: both may be far from the origin of coordinates.
        let shift = rotation * (origin - frame.cylinder.axis.point);
        let observer = -(rotation * frame.cylinder.axis.point).xy();
        Self { rotation, shift, radius: frame.cylinder.radius / frame.unit, observer }
    }

    /// The mathematics of a point: everything about it that a residual, its Jacobian or its loss needs.
    #[inline(always)]
    fn place(&self, [px, py, pz]: [f64; 3]) -> Place {
        let r = &self.rotation;
        let x = r[(0, 0)] * px + r[(0, 1)] * py + r[(0, 2)] * pz + self.shift.x;
        let y = r[(1, 0)] * px + r[(1, 1)] * py + r[(1, 2)] * pz + self.shift.y;
        let h = r[(2, 0)] * px + r[(2, 1)] * py + r[(2, 2)] * pz + self.shift.z;
        let rho = (x * x + y * y).sqrt();
        // On the axis the direction of the gradient is undefined; 0 is the mean over all of them.
        let inverse = 1.0 / rho.max(f64::MIN_POSITIVE);
        let facing = x * (x - self.observer.x) + y * (y - self.observer.y);
        Place { rho, a: x * inverse, b: y * inverse, h, facing }
    }

    fn distances<T: Copy + Into<f64>>(&self, [xs, ys, zs]: &[Vec<T>; 3]) -> Vec<f64> {
        let distance = |((x, y), z): ((&T, &T), &T)| {
            self.place([(*x).into(), (*y).into(), (*z).into()]).rho - self.radius
        };
        xs.iter().zip(ys).zip(zs).map(distance).collect()
    }

    /// The sums over some points, with the widest vector instructions of the machine. They all round alike, so the bits
    /// do not depend on them.
    fn chunk<T: Copy + Into<f64>, const N: usize>(
        &self,
        axes: &[Vec<T>; 3],
        weights: Option<&[f32]>,
        range: std::ops::Range<usize>,
        terms: impl Terms<N>,
    ) -> [f64; N] {
        Arch::new().dispatch(|| self.plain_chunk(axes, weights, range, terms))
    }

    #[inline(always)]
    fn plain_chunk<T: Copy + Into<f64>, const N: usize>(
        &self,
        axes: &[Vec<T>; 3],
        weights: Option<&[f32]>,
        range: std::ops::Range<usize>,
        terms: impl Terms<N>,
    ) -> [f64; N] {
        let mut lanes = [[0.0; LANES]; N];
        // x, y, z and weight in f64; the last block is filled up with points of weight 0.
        let mut block = [[0.0; BLOCK]; 4];
        for start in range.clone().step_by(BLOCK) {
            let count = BLOCK.min(range.end - start);
            for (values, axis) in block.iter_mut().zip(axes) {
                for (value, x) in values.iter_mut().zip(&axis[start..start + count]) {
                    *value = (*x).into();
                }
            }
            match weights {
                None => block[3][..count].fill(1.0),
                Some(weights) => {
                    for (value, weight) in block[3].iter_mut().zip(&weights[start..start + count]) {
                        *value = f64::from(*weight);
                    }
                }
            }
            block[3][count..].fill(0.0);
            let [x, y, z, w] = block.each_ref().map(|values| values.as_chunks::<LANES>().0);
            for (((x, y), z), w) in x.iter().zip(y).zip(z).zip(w).take(count.div_ceil(LANES)) {
                self.add_block([x, y, z, w], &mut lanes, terms);
            }
        }
        lanes.map(|sums| sums.iter().sum())
    }

    #[inline(always)]
    fn add_block<const N: usize>(
        &self,
        [x, y, z, weights]: [&[f64; LANES]; 4],
        sums: &mut [[f64; LANES]; N],
        terms: impl Terms<N>,
    ) {
        for lane in 0..LANES {
            let place = self.place([x[lane], y[lane], z[lane]]);
            let terms = terms.of(&place, place.rho - self.radius, weights[lane]);
            for (sum, term) in sums.iter_mut().zip(terms) {
                sum[lane] += term;
            }
        }
    }
}

/// The sums as normal equations of the Jacobian (−a, −b, −h a, −h b, −1).
fn unpack(sums: &[f64; SUMS]) -> NormalEquations {
    let [loss, w, e, ea, eb, eah, ebh, a, b, ah, bh, aa, ab, bb, aah, abh, bbh, aahh, abhh, bbhh] = *sums;
    let hessian = TangentMap::new(
        aa, ab, aah, abh, a, //
        ab, bb, abh, bbh, b, //
        aah, abh, aahh, abhh, ah, //
        abh, bbh, abhh, bbhh, bh, //
        a, b, ah, bh, w,
    );
    NormalEquations { cost: loss, gradient: -Tangent::new(ea, eb, eah, ebh, e), hessian }
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
    fn place(&self, point: &Vector3<f64>) -> Place {
        self.kernel.place((point - self.axis_point).into())
    }

    /// Residual, Jacobian, and on which side of the surface the point lies, as in [`Loss::loss_and_weight`].
    #[inline]
    pub fn row(&self, point: &Vector3<f64>) -> (f64, Tangent, f64) {
        let Place { rho, a, b, h, facing } = self.place(point);
        (rho - self.kernel.radius, Tangent::new(-a, -b, -h * a, -h * b, -1.0), facing)
    }

    /// Residual and side alone.
    #[inline]
    pub fn residual(&self, point: &Vector3<f64>) -> (f64, f64) {
        let place = self.place(point);
        (place.rho - self.kernel.radius, place.facing)
    }
}

#[cfg(test)]
mod tests;
