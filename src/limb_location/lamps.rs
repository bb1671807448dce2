//! The brightness around a cylinder for many directions of a lamp, fitted side by side with the widest vector instructions of the
//! machine. Each lamp has the sums that it would have alone, and multiplications and additions are never fused: every machine
//! gets the same bits.

use super::shading::{Angle, Median};
use crate::memory::List;
use crate::residuals::TUKEY_EFFICIENT;
use crate::statistics::DEVIATION_OF_MEDIAN;
use nalgebra::{Cholesky, Const, Matrix5, Vector5};
use pulp::{Arch, Scalar, Simd, WithSimd};
use std::array::from_fn;
use std::f64::consts::PI;

constants! {
    /// Standard deviation of d and of b and c, relative to the brightness. One lamp and light from everywhere explain
    /// most scenes; others are weak beside them.
    MAIN_LAMP = 3.0, "";
    OTHER_LAMPS = 0.1, "";

    /// Standard deviation of g, and the exponent of the lobe: common paints and plastics have some tens. The weight
    /// `MATT` holds g at 0.
    GLOSS = 0.5, "";
    GLOSS_EXPONENT = 40.0, "";

    /// Directions φ₀ that are tried, all around.
    LIGHTS = 48.0, "";

    /// Most rounds of reweighting for each of them.
    REWEIGHTINGS = 6.0, "";

    /// The rounds end when no median moves by more.
    SETTLED = 0.01, "σ";
}

const MATT: f64 = 1e12;

/// Lamps side by side.
const LANES: usize = 8;

/// The unknowns a, b, c, d and g.
const UNKNOWNS: usize = 5;

/// A lamp: its angle φ₀, and that at which it is mirrored, where the normal halves the angle between it and the camera.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lamp {
    at: Angle,
    mirrored: Angle,
}

impl Lamp {
    fn new(angle: f64) -> Self {
        Self { at: Angle::new(angle), mirrored: Angle::new(angle / 2.0) }
    }

    /// What the unknowns are multiplied by at an angle.
    pub fn functions(&self, angle: &Angle) -> Vector5<f64> {
        let Self { at, mirrored } = self;
        Vector5::from(functions(Scalar, angle, [at.cos, at.sin, mirrored.cos, mirrored.sin]))
    }
}

/// The functions of lamps at an angle: 1, its cosine and sine, and what comes from the lamp and from its mirror image, whose
/// cosines and sines are `lamp`.
#[inline(always)]
fn functions<S: Simd>(simd: S, angle: &Angle, lamp: [S::f64s; 4]) -> [S::f64s; UNKNOWNS] {
    let (zero, cos, sin) = (simd.splat_f64s(0.0), simd.splat_f64s(angle.cos), simd.splat_f64s(angle.sin));
    let [direct, mirrored] = [[lamp[0], lamp[1]], [lamp[2], lamp[3]]].map(|of_lamp| {
        let cos_to = simd.add_f64s(simd.mul_f64s(cos, of_lamp[0]), simd.mul_f64s(sin, of_lamp[1]));
        simd.max_f64s(cos_to, zero)
    });
    let (mut gloss, mut power, mut left) = (simd.splat_f64s(1.0), mirrored, GLOSS_EXPONENT.count());
    while left > 0 {
        if left % 2 == 1 {
            gloss = simd.mul_f64s(gloss, power);
        }
        power = simd.mul_f64s(power, power);
        left /= 2;
    }
    [simd.splat_f64s(1.0), cos, sin, direct, gloss]
}

/// The fit for one lamp.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fit {
    pub lamp: Lamp,
    pub coefficients: Vector5<f64>,
    pub cost: f64,
    /// The scale of the residuals.
    scale: f64,
    /// The Cholesky factor of the normal equations.
    factor: Matrix5<f64>,
}

impl Fit {
    /// The brightness at an angle.
    pub fn at(&self, angle: &Angle) -> f64 {
        self.lamp.functions(angle).dot(&self.coefficients)
    }

    /// That of the coefficients.
    pub fn covariance(&self) -> Matrix5<f64> {
        Cholesky::<f64, Const<UNKNOWNS>>::pack_dirty(self.factor).inverse() * (self.scale * self.scale)
    }
}

/// The fits of all lamps that explain some medians without taking light away.
pub(super) fn fits(rows: &[Median]) -> List<Fit> {
    let count = LIGHTS.count();
    let lamps: List<Lamp> = (0..count).map(|k| Lamp::new(2.0 * PI * k as f64 / count as f64 - PI)).collect();
    let mut found = List::filled(None, count);
    let mut fit = |which: &[usize], glossy: bool| {
        for which in which.chunks(LANES) {
            // The last lamp is repeated.
            let lamps: [Lamp; LANES] = from_fn(|k| lamps[which[k.min(which.len() - 1)]]);
            let fits = Arch::new().dispatch(SideBySide { rows, lamps: &lamps, glossy });
            which.iter().zip(fits).for_each(|(&k, fit)| found[k] = fit);
        }
        // Neither a lamp takes light away, nor gloss.
        let matt = |fit: &Fit| !(fit.coefficients[3] < 0.0) && fit.coefficients[4] < 0.0;
        which.iter().copied().filter(|&k| glossy && found[k].as_ref().is_some_and(matt)).collect::<List<_>>()
    };
    let matt = fit(&(0..count).collect::<List<_>>(), true);
    fit(&matt, false);
    found.iter().flatten().filter(|fit| !(fit.coefficients[3] < 0.0)).copied().collect()
}

/// Lamps that are fitted side by side.
struct SideBySide<'a> {
    rows: &'a [Median],
    lamps: &'a [Lamp; LANES],
    /// Whether there is a mirror image.
    glossy: bool,
}

/// What a lamp gives in units of the deviation of a median, and how far that is from it.
struct Row<V> {
    functions: [V; UNKNOWNS],
    value: V,
    residual: V,
    weight: V,
}

impl WithSimd for SideBySide<'_> {
    type Output = [Option<Fit>; LANES];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let mut found = [None; LANES];
        let mut rows = List::with_capacity(self.rows.len());
        for (part, found) in found.chunks_mut(S::F64_LANES).enumerate() {
            self.part(simd, part, &mut rows, found);
        }
        found
    }
}

impl SideBySide<'_> {
    /// Fits as many lamps as an instruction takes.
    #[inline(always)]
    fn part<S: Simd>(&self, simd: S, part: usize, rows: &mut List<Row<S::f64s>>, found: &mut [Option<Fit>]) {
        let of_lamps = |number: fn(&Lamp) -> f64| {
            let numbers: [f64; LANES] = from_fn(|k| number(&self.lamps[k]));
            S::as_simd_f64s(&numbers).0[part]
        };
        let lamp = [
            of_lamps(|lamp| lamp.at.cos),
            of_lamps(|lamp| lamp.at.sin),
            of_lamps(|lamp| lamp.mirrored.cos),
            of_lamps(|lamp| lamp.mirrored.sin),
        ];
        let (zero, one) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
        let of_median = simd.splat_f64s(DEVIATION_OF_MEDIAN);
        rows.clear();
        for Median { angle, value, deviation } in self.rows {
            let deviation = simd.splat_f64s(*deviation);
            let functions = functions(simd, angle, lamp).map(|number| simd.div_f64s(number, deviation));
            let value = simd.div_f64s(simd.splat_f64s(*value), deviation);
            let residual = simd.splat_f64s(f64::INFINITY);
            rows.push(Row { functions, value, residual, weight: one });
        }
        let other = OTHER_LAMPS.get().powi(-2);
        let gloss = if self.glossy { GLOSS.get().powi(-2) } else { MATT };
        let prior = [0.0, other, other, MAIN_LAMP.get().powi(-2), gloss];
        let mut ended = [false; LANES];
        for round in 1..=REWEIGHTINGS.count() {
            let (normal, right) = normal_equations(simd, &prior, rows);
            let (factor, positive) = cholesky(simd, normal);
            let coefficients = solve(simd, &factor, right);
            let (mut moved, mut small) = (zero, zero);
            for row in rows.iter_mut() {
                let mut sum = zero;
                for (function, coefficient) in row.functions.iter().zip(coefficients) {
                    sum = simd.add_f64s(sum, simd.mul_f64s(*function, coefficient));
                }
                let residual = simd.sub_f64s(row.value, sum);
                moved = simd.max_f64s(simd.abs_f64s(simd.sub_f64s(residual, row.residual)), moved);
                let size = simd.mul_f64s(of_median, simd.abs_f64s(residual));
                let is_small = simd.less_than_or_equal_f64s(size, one);
                small = simd.add_f64s(small, simd.select_f64s(is_small, one, zero));
                row.residual = residual;
            }
            // Where most are that small no median is needed.
            let most = simd.less_than_f64s(simd.splat_f64s(rows.len() as f64), simd.add_f64s(small, small));
            let scale = if lanes(simd, simd.select_f64s(most, one, zero))[..found.len()].contains(&0.0) {
                simd.max_f64s(simd.mul_f64s(of_median, median_sizes(simd, rows)), one)
            } else {
                one
            };
            let [moved, scales, positive] =
                [moved, scale, simd.select_f64s(positive, one, zero)].map(|numbers| lanes(simd, numbers));
            for k in 0..found.len() {
                ended[k] |= positive[k] == 0.0;
                if ended[k] || (round == 1 || moved[k] >= SETTLED.get()) && round < REWEIGHTINGS.count() {
                    continue;
                }
                ended[k] = true;
                let coefficients = Vector5::from(coefficients.map(|numbers| lanes(simd, numbers)[k]));
                // As far as a bin of the scale of its deviation counts.
                let loss = |row: &Row<_>| lanes(simd, row.residual)[k].abs().min(TUKEY_EFFICIENT).powi(2);
                let squares = Matrix5::from_diagonal(&Vector5::from(prior)) * coefficients;
                found[k] = Some(Fit {
                    lamp: self.lamps[part * S::F64_LANES + k],
                    coefficients,
                    cost: rows.iter().map(loss).sum::<f64>() + coefficients.dot(&squares),
                    scale: scales[k],
                    factor: Matrix5::from_fn(|i, j| lanes(simd, factor[i.max(j)][i.min(j)])[k]),
                });
            }
            if ended[..found.len()].iter().all(|ended| *ended) {
                break;
            }
            // Tukey's weights; where there is no finite residual there is none.
            let per_cutoff = simd.div_f64s(one, simd.mul_f64s(simd.splat_f64s(TUKEY_EFFICIENT), scale));
            for row in rows.iter_mut() {
                let ratio = simd.mul_f64s(row.residual, per_cutoff);
                let left = simd.max_f64s(simd.sub_f64s(one, simd.mul_f64s(ratio, ratio)), zero);
                let finite = simd.less_than_f64s(simd.abs_f64s(row.residual), simd.splat_f64s(f64::INFINITY));
                row.weight = simd.select_f64s(finite, simd.mul_f64s(left, left), zero);
            }
        }
    }
}

/// The numbers of a vector.
#[inline(always)]
fn lanes<S: Simd>(_simd: S, numbers: S::f64s) -> [f64; LANES] {
    let mut lanes = [0.0; LANES];
    S::as_mut_simd_f64s(&mut lanes).0[0] = numbers;
    lanes
}

/// The upper medians of the absolute values of the finite residuals; 0 where there is none. There are so few rows that all are
/// compared with all.
#[inline(always)]
fn median_sizes<S: Simd>(simd: S, rows: &[Row<S::f64s>]) -> S::f64s {
    let (zero, one) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
    let infinite = simd.splat_f64s(f64::INFINITY);
    let mut count = zero;
    for row in rows {
        let finite = simd.less_than_f64s(simd.abs_f64s(row.residual), infinite);
        count = simd.add_f64s(count, simd.select_f64s(finite, one, zero));
    }
    // The least that is not below more than half of them.
    let mut median = infinite;
    for row in rows {
        let size = simd.abs_f64s(row.residual);
        let mut within = zero;
        for other in rows {
            let is_within = simd.less_than_or_equal_f64s(simd.abs_f64s(other.residual), size);
            within = simd.add_f64s(within, simd.select_f64s(is_within, one, zero));
        }
        let enough = simd.less_than_f64s(count, simd.add_f64s(within, within));
        median = simd.min_f64s(simd.select_f64s(enough, size, infinite), median);
    }
    simd.select_f64s(simd.less_than_f64s(median, infinite), median, zero)
}

/// A matrix of which the lower half counts.
type Lower<V> = [[V; UNKNOWNS]; UNKNOWNS];

/// The normal equations of rows with their weights and a prior.
#[inline(always)]
fn normal_equations<S: Simd>(
    simd: S,
    prior: &[f64; UNKNOWNS],
    rows: &[Row<S::f64s>],
) -> (Lower<S::f64s>, [S::f64s; UNKNOWNS]) {
    let zero = simd.splat_f64s(0.0);
    let (mut normal, mut right) = ([[zero; UNKNOWNS]; UNKNOWNS], [zero; UNKNOWNS]);
    for i in 0..UNKNOWNS {
        normal[i][i] = simd.splat_f64s(prior[i]);
    }
    for Row { functions, value, weight, .. } in rows {
        for i in 0..UNKNOWNS {
            let weighted = simd.mul_f64s(functions[i], *weight);
            for j in 0..=i {
                normal[i][j] = simd.add_f64s(normal[i][j], simd.mul_f64s(weighted, functions[j]));
            }
            right[i] = simd.add_f64s(right[i], simd.mul_f64s(weighted, *value));
        }
    }
    (normal, right)
}

/// The Cholesky factor, and where there is one.
#[inline(always)]
fn cholesky<S: Simd>(simd: S, mut matrix: Lower<S::f64s>) -> (Lower<S::f64s>, S::m64s) {
    let zero = simd.splat_f64s(0.0);
    let mut positive = simd.equal_f64s(zero, zero);
    for j in 0..UNKNOWNS {
        for k in 0..j {
            let factor = matrix[j][k];
            for row in &mut matrix[j..] {
                row[j] = simd.sub_f64s(row[j], simd.mul_f64s(factor, row[k]));
            }
        }
        positive = simd.and_m64s(positive, simd.greater_than_f64s(matrix[j][j], zero));
        matrix[j][j] = simd.sqrt_f64s(matrix[j][j]);
        for i in j + 1..UNKNOWNS {
            matrix[i][j] = simd.div_f64s(matrix[i][j], matrix[j][j]);
        }
    }
    (matrix, positive)
}

/// The solution by a Cholesky factor.
#[inline(always)]
fn solve<S: Simd>(simd: S, factor: &Lower<S::f64s>, mut right: [S::f64s; UNKNOWNS]) -> [S::f64s; UNKNOWNS] {
    for i in 0..UNKNOWNS {
        right[i] = simd.div_f64s(right[i], factor[i][i]);
        for j in i + 1..UNKNOWNS {
            right[j] = simd.sub_f64s(right[j], simd.mul_f64s(right[i], factor[j][i]));
        }
    }
    for i in (0..UNKNOWNS).rev() {
        let mut sum = simd.splat_f64s(0.0);
        for j in i + 1..UNKNOWNS {
            sum = simd.add_f64s(sum, simd.mul_f64s(factor[j][i], right[j]));
        }
        right[i] = simd.div_f64s(simd.sub_f64s(right[i], sum), factor[i][i]);
    }
    right
}
