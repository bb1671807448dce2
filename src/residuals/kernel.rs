//! Sums over points with the widest vector instructions of the machine.
//!
//! A sum runs in [`LANES`] partial sums, whose number does not depend on the width of the instructions, and
//! multiplications and additions are never fused: every machine gets the same bits. The mathematics stands here once,
//! for one point ([`Scalar`](pulp::Scalar)) and for as many as an instruction takes.

mod influences;

use super::loss::{Influence, Loss, Wall};
use crate::geometry::LocalFrame;
use crate::memory::List;
pub(super) use influences::Influences;
use nalgebra::{Matrix3, Vector2, Vector3};
use pulp::{Arch, Scalar, Simd, WithSimd};
use std::ops::Range;

/// Partial sums that run side by side.
const LANES: usize = 8;

/// Groups of points that are converted to f64 in one go.
const GROUPS: usize = 16;

/// Distinct sums: loss, slopes of the influence, weights, residual times Jacobian, Jacobian times Jacobian.
pub(super) const SUMS: usize = 21;

/// What is summed over the points.
pub(super) trait Terms<const N: usize>: Copy + Sync {
    /// The sums over some groups of points.
    fn sums<S: Simd>(
        &self,
        simd: S,
        kernel: &Kernel,
        groups: &Groups<'_>,
        notes: &mut Notes<S::f64s>,
    ) -> [S::f64s; N];
}

/// Everything that the normal equations need.
#[derive(Clone, Copy)]
pub(super) struct Whole<L>(pub L);

/// The loss alone, the first of these sums.
#[derive(Clone, Copy)]
pub(super) struct CostAlone<L>(pub L);

/// What one round of sums notes of each group for the next.
pub(super) type Notes<T> = [[T; 5]; GROUPS];

impl<L: Loss> Terms<SUMS> for Whole<L> {
    /// In three rounds, each with sums of its own, which the processor holds in its registers.
    #[inline(always)]
    fn sums<S: Simd>(
        &self,
        simd: S,
        kernel: &Kernel,
        groups: &Groups<'_>,
        notes: &mut Notes<S::f64s>,
    ) -> [S::f64s; SUMS] {
        let zero = simd.splat_f64s(0.0);
        let (mut losses, mut gradient) = ([zero; 3], [zero; 9]);
        for group in groups.range() {
            let (Coordinates { a, b, h, facing, .. }, e, weight) = groups.at(simd, kernel, group);
            let Influence { loss, weight: factor, slope } = self.0.influences(simd, e, facing);
            let w = simd.mul_f64s(weight, factor);
            add(simd, &mut losses, [simd.mul_f64s(weight, loss), simd.mul_f64s(weight, slope), w]);
            notes[group] = [w, simd.mul_f64s(w, e), a, b, h];
        }
        for [w, we, a, b, h] in notes.iter_mut().take(groups.count) {
            let (ea, eb) = (simd.mul_f64s(*we, *a), simd.mul_f64s(*we, *b));
            let (eah, ebh) = (simd.mul_f64s(ea, *h), simd.mul_f64s(eb, *h));
            let (wa, wb) = (simd.mul_f64s(*w, *a), simd.mul_f64s(*w, *b));
            let (wah, wbh) = (simd.mul_f64s(wa, *h), simd.mul_f64s(wb, *h));
            add(simd, &mut gradient, [*we, ea, eb, eah, ebh, wa, wb, wah, wbh]);
            (*w, *we) = (wa, wb);
        }
        let mut sums = [zero; SUMS];
        sums[..3].copy_from_slice(&losses);
        sums[3..12].copy_from_slice(&gradient);
        sums[12..].copy_from_slice(&products(simd, notes, groups.count));
        sums
    }
}

#[inline(always)]
#[allow(clippy::needless_range_loop, reason = "iterators over arrays are not inlined in every build")]
fn add<S: Simd, const N: usize>(simd: S, sums: &mut [S::f64s; N], terms: [S::f64s; N]) {
    for k in 0..N {
        sums[k] = simd.add_f64s(sums[k], terms[k]);
    }
}

/// The last round of sums: products with two or more of a, b and h, of notes with w a and w b.
#[inline(always)]
fn products<S: Simd>(simd: S, notes: &Notes<S::f64s>, count: usize) -> [S::f64s; 9] {
    let mut products = [simd.splat_f64s(0.0); 9];
    for [wa, wb, a, b, h] in notes.iter().take(count) {
        let (aa, ab, bb) = (simd.mul_f64s(*wa, *a), simd.mul_f64s(*wa, *b), simd.mul_f64s(*wb, *b));
        let (aah, abh, bbh) = (simd.mul_f64s(aa, *h), simd.mul_f64s(ab, *h), simd.mul_f64s(bb, *h));
        let (aahh, abhh) = (simd.mul_f64s(aah, *h), simd.mul_f64s(abh, *h));
        add(simd, &mut products, [aa, ab, bb, aah, abh, bbh, aahh, abhh, simd.mul_f64s(bbh, *h)]);
    }
    products
}

/// The number of points at most so far from the surface.
#[derive(Clone, Copy)]
pub(super) struct Within(pub f64);

impl Terms<1> for Within {
    #[inline(always)]
    fn sums<S: Simd>(
        &self,
        simd: S,
        kernel: &Kernel,
        groups: &Groups<'_>,
        _: &mut Notes<S::f64s>,
    ) -> [S::f64s; 1] {
        let mut sums = [simd.splat_f64s(0.0)];
        for group in groups.range() {
            let (_, e, weight) = groups.at(simd, kernel, group);
            let within = simd.less_than_or_equal_f64s(simd.abs_f64s(e), simd.splat_f64s(self.0));
            add(simd, &mut sums, [counted(simd, within, weight)]);
        }
        sums
    }
}

/// The number of points on the side of the surface that the observer sees from outside, and the squares of the residuals.
#[derive(Clone, Copy)]
pub(super) struct FacingAndSquares;

impl Terms<2> for FacingAndSquares {
    #[inline(always)]
    fn sums<S: Simd>(
        &self,
        simd: S,
        kernel: &Kernel,
        groups: &Groups<'_>,
        _: &mut Notes<S::f64s>,
    ) -> [S::f64s; 2] {
        let mut sums = [simd.splat_f64s(0.0); 2];
        for group in groups.range() {
            let (coordinates, e, weight) = groups.at(simd, kernel, group);
            let facing = simd.less_than_f64s(coordinates.facing, simd.splat_f64s(0.0));
            let square = simd.mul_f64s(weight, simd.mul_f64s(e, e));
            add(simd, &mut sums, [counted(simd, facing, weight), square]);
        }
        sums
    }
}

/// One where something is so of a point, else 0. What fills up a block has no weight.
#[inline(always)]
fn counted<S: Simd>(simd: S, is_so: S::m64s, weight: S::f64s) -> S::f64s {
    let (zero, one) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
    let point = simd.select_f64s(simd.greater_than_f64s(weight, zero), one, zero);
    simd.select_f64s(is_so, point, zero)
}

impl<L: Loss> Terms<1> for CostAlone<L> {
    #[inline(always)]
    fn sums<S: Simd>(
        &self,
        simd: S,
        kernel: &Kernel,
        groups: &Groups<'_>,
        _: &mut Notes<S::f64s>,
    ) -> [S::f64s; 1] {
        let mut sums = [simd.splat_f64s(0.0)];
        for group in groups.range() {
            let (coordinates, e, weight) = groups.at(simd, kernel, group);
            let Influence { loss, .. } = self.0.influences(simd, e, coordinates.facing);
            add(simd, &mut sums, [simd.mul_f64s(weight, loss)]);
        }
        sums
    }
}

/// Where points lie in relation to a cylinder, in the frame and its unit.
pub(super) struct Coordinates<T> {
    /// Distance from the axis.
    pub rho: T,
    /// The direction from the axis to the point, (a, b) across the axis; 0 on it.
    pub a: T,
    pub b: T,
    /// The coordinate along the axis.
    pub h: T,
    /// Negative where the outward normal points towards the observer at the origin.
    pub facing: T,
}

/// What all points share: the motion into the local frame.
pub(super) struct Kernel {
    rotation: Matrix3<f64>,
    shift: Vector3<f64>,
    pub radius: f64,
    /// The observer across the axis.
    observer: Vector2<f64>,
}

impl Kernel {
    /// For points given by their offset from an origin.
    pub fn new(origin: &Vector3<f64>, frame: &LocalFrame) -> Self {
        let rotation = frame.rotation() / frame.unit;
        // The difference of two nearby points first: both may be far from the origin of coordinates.
        let shift = rotation * (origin - frame.cylinder.axis.point);
        let observer = -(rotation * frame.cylinder.axis.point).xy();
        Self { rotation, shift, radius: frame.cylinder.radius / frame.unit, observer }
    }

    /// The mathematics of points: everything about them that a residual, its Jacobian or its loss needs.
    #[inline(always)]
    pub fn coordinates<S: Simd>(&self, simd: S, [px, py, pz]: [S::f64s; 3]) -> Coordinates<S::f64s> {
        let (x, y) = (self.coordinate(simd, 0, [px, py, pz]), self.coordinate(simd, 1, [px, py, pz]));
        let h = self.coordinate(simd, 2, [px, py, pz]);
        let rho = simd.sqrt_f64s(simd.add_f64s(simd.mul_f64s(x, x), simd.mul_f64s(y, y)));
        // On the axis the direction of the gradient is undefined; 0 is the mean over all of them.
        let least = simd.max_f64s(rho, simd.splat_f64s(f64::MIN_POSITIVE));
        let inverse = simd.div_f64s(simd.splat_f64s(1.0), least);
        let away_x = simd.sub_f64s(x, simd.splat_f64s(self.observer.x));
        let away_y = simd.sub_f64s(y, simd.splat_f64s(self.observer.y));
        Coordinates {
            rho,
            a: simd.mul_f64s(x, inverse),
            b: simd.mul_f64s(y, inverse),
            h,
            facing: simd.add_f64s(simd.mul_f64s(x, away_x), simd.mul_f64s(y, away_y)),
        }
    }

    /// Signed distances of points from the surface.
    #[inline(always)]
    fn residual<S: Simd>(&self, simd: S, coordinates: &Coordinates<S::f64s>) -> S::f64s {
        simd.sub_f64s(coordinates.rho, simd.splat_f64s(self.radius))
    }

    /// A coordinate of points in the local frame.
    #[inline(always)]
    fn coordinate<S: Simd>(&self, simd: S, k: usize, [px, py, pz]: [S::f64s; 3]) -> S::f64s {
        let x = simd.mul_f64s(simd.splat_f64s(self.rotation[(k, 0)]), px);
        let y = simd.mul_f64s(simd.splat_f64s(self.rotation[(k, 1)]), py);
        let z = simd.mul_f64s(simd.splat_f64s(self.rotation[(k, 2)]), pz);
        simd.add_f64s(simd.add_f64s(simd.add_f64s(x, y), z), simd.splat_f64s(self.shift[k]))
    }

    /// The sums over some points.
    pub fn chunk<T: Coordinate, X: Terms<N>, const N: usize>(
        &self,
        axes: [&[T]; 3],
        weights: Option<&[f32]>,
        range: Range<usize>,
        terms: X,
    ) -> [f64; N] {
        let chunk = Chunk { kernel: self, axes, weights, range, terms };
        match Arch::new() {
            Arch::Scalar => without_vectors(chunk),
            vectors => vectors.dispatch(chunk),
        }
    }

    /// Signed distances of points from the surface, infinite for those on a wall where they cannot be.
    pub fn distances<T: Coordinate>(&self, axes: [&[T]; 3], wall: Wall) -> List<f64> {
        let mut distances = List::with_capacity(axes[0].len());
        self.distances_by_blocks(axes, wall, |block| distances.extend_from_slice(block));
        distances
    }

    /// The same, some at a time.
    pub fn distances_by_blocks<T: Coordinate>(&self, axes: [&[T]; 3], wall: Wall, block: impl FnMut(&[f64])) {
        Arch::new().dispatch(Distances { kernel: self, axes, wall, block });
    }
}

/// The sums without vector instructions. Their numbers take some KB of the stack, which the sums with vectors need not have
/// below them.
#[inline(never)]
fn without_vectors<W: WithSimd>(work: W) -> W::Output {
    work.with_simd(Scalar)
}

/// Points side by side.
type Block = [[f64; LANES]; GROUPS];

const EMPTY: Block = [[0.0; LANES]; GROUPS];

/// The numbers that coordinates are kept as.
pub(super) trait Coordinate: Copy + Into<f64> {
    /// The next coordinates as a block, in `room` where they are not one already.
    #[inline(always)]
    fn block<'a>(values: &'a [Self], room: &'a mut Block) -> &'a Block {
        load(room, values);
        room
    }
}

impl Coordinate for f32 {}

impl Coordinate for f64 {
    #[inline(always)]
    fn block<'a>(values: &'a [Self], room: &'a mut Block) -> &'a Block {
        match values.as_chunks().0.try_into() {
            Ok(block) => block,
            Err(_) => {
                load(room, values);
                room
            }
        }
    }
}

/// The next numbers, as many as a block holds at most; the rest is filled up with zeros.
#[inline(always)]
fn load<T: Copy + Into<f64>>(block: &mut Block, values: &[T]) {
    let flat = block.as_flattened_mut();
    for (value, x) in flat.iter_mut().zip(values) {
        *value = (*x).into();
    }
    flat[values.len()..].fill(0.0);
}

/// The next points of three axes.
#[inline(always)]
fn next<'a, T: Coordinate>(
    axes: [&'a [T]; 3],
    range: Range<usize>,
    [of_x, of_y, of_z]: [&'a mut Block; 3],
) -> [&'a Block; 3] {
    let [x, y, z] = axes.map(|axis| &axis[range.clone()]);
    [T::block(x, of_x), T::block(y, of_y), T::block(z, of_z)]
}

/// As many of a group as an instruction takes.
#[inline(always)]
fn lanes<S: Simd>(_simd: S, group: &[f64; LANES], part: usize) -> S::f64s {
    S::as_simd_f64s(group).0[part]
}

/// Groups of points, of each of which as many as an instruction takes.
pub(super) struct Groups<'a> {
    points: [&'a Block; 3],
    weights: &'a Block,
    count: usize,
    /// Which of them.
    part: usize,
}

impl Groups<'_> {
    /// The numbers of the groups.
    #[inline(always)]
    fn range(&self) -> Range<usize> {
        0..self.count.min(GROUPS)
    }

    /// The coordinates of the points of a group, their residuals and their weights.
    #[inline(always)]
    fn at<S: Simd>(
        &self,
        simd: S,
        kernel: &Kernel,
        group: usize,
    ) -> (Coordinates<S::f64s>, S::f64s, S::f64s) {
        let Self { points: [x, y, z], weights, part, .. } = *self;
        let [x, y, z] = [&x[group], &y[group], &z[group]];
        let coordinates =
            kernel.coordinates(simd, [lanes(simd, x, part), lanes(simd, y, part), lanes(simd, z, part)]);
        let residual = kernel.residual(simd, &coordinates);
        (coordinates, residual, lanes(simd, &weights[group], part))
    }
}

/// The sums over a range of points.
struct Chunk<'a, T, X, const N: usize> {
    kernel: &'a Kernel,
    axes: [&'a [T]; 3],
    weights: Option<&'a [f32]>,
    range: Range<usize>,
    terms: X,
}

impl<T: Coordinate, X: Terms<N>, const N: usize> WithSimd for Chunk<'_, T, X, N> {
    type Output = [f64; N];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [f64; N] {
        let Self { kernel, axes, weights, range, terms } = self;
        let mut sums = [[0.0; LANES]; N];
        let (mut x, mut y, mut z) = (EMPTY, EMPTY, EMPTY);
        let mut weight = [[1.0; LANES]; GROUPS];
        let mut notes = [[simd.splat_f64s(0.0); 5]; GROUPS];
        for start in range.clone().step_by(LANES * GROUPS) {
            let end = range.end.min(start + LANES * GROUPS);
            let points = next(axes, start..end, [&mut x, &mut y, &mut z]);
            if let Some(weights) = weights {
                load(&mut weight, &weights[start..end]);
            } else {
                // Only the last block is not full.
                weight.as_flattened_mut()[end - start..].fill(0.0);
            }
            let count = (end - start).div_ceil(LANES);
            for part in 0..LANES / S::F64_LANES {
                let groups = Groups { points, weights: &weight, count, part };
                let of_block = terms.sums(simd, kernel, &groups, &mut notes);
                for (sum, term) in sums.iter_mut().zip(of_block) {
                    let sum = &mut S::as_mut_simd_f64s(sum).0[part];
                    *sum = simd.add_f64s(*sum, term);
                }
            }
        }
        sums.map(|sums| sums.iter().sum())
    }
}

/// The distances of all points.
struct Distances<'a, T, F> {
    kernel: &'a Kernel,
    axes: [&'a [T]; 3],
    wall: Wall,
    /// Receives each block.
    block: F,
}

impl<T: Coordinate, F: FnMut(&[f64])> WithSimd for Distances<'_, T, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { kernel, axes, wall, block: mut receive } = self;
        let infinity = simd.splat_f64s(f64::INFINITY);
        let count = axes[0].len();
        let (mut x, mut y, mut z) = (EMPTY, EMPTY, EMPTY);
        let mut rho = [[0.0; LANES]; GROUPS];
        for start in (0..count).step_by(LANES * GROUPS) {
            let end = count.min(start + LANES * GROUPS);
            let [x, y, z] =
                next(axes, start..end, [&mut x, &mut y, &mut z]).map(|block| block.as_flattened());
            let (x, y, z) = (S::as_simd_f64s(x).0, S::as_simd_f64s(y).0, S::as_simd_f64s(z).0);
            let rho = rho.as_flattened_mut();
            for (((x, y), z), rho) in x.iter().zip(y).zip(z).zip(S::as_mut_simd_f64s(rho).0) {
                let coordinates = kernel.coordinates(simd, [*x, *y, *z]);
                *rho = kernel.residual(simd, &coordinates);
                if wall != Wall::Either {
                    *rho = simd.select_f64s(wall.hidden(simd, coordinates.facing), infinity, *rho);
                }
            }
            receive(&rho[..end - start]);
        }
    }
}

#[cfg(test)]
mod tests;
