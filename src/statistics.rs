//! Robust location and scale of numbers.

use crate::memory::List;
use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};

/// The standard deviation of normal errors over the median of their absolute values.
pub(crate) const DEVIATION_OF_MEDIAN: f64 = 1.4826;

/// The lower quartile of the absolute values of normal errors, in standard deviations.
pub(crate) const LOWER_QUARTILE: f64 = 0.3186;

/// The least and the largest of some numbers.
pub(crate) fn min_max_of(numbers: impl Iterator<Item = f64>) -> [f64; 2] {
    numbers
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], number| [low.min(number), high.max(number)])
}

/// The least and the largest of the numbers in a list.
pub(crate) fn min_max(numbers: &[f64]) -> [f64; 2] {
    // Several side by side: none waits for another.
    let (mut low, mut high) = ([f64::INFINITY; 8], [f64::NEG_INFINITY; 8]);
    for some in numbers.chunks(low.len()) {
        for ((low, high), number) in low.iter_mut().zip(&mut high).zip(some) {
            *low = if number < low { *number } else { *low };
            *high = if number > high { *number } else { *high };
        }
    }
    [low.into_iter().fold(f64::INFINITY, f64::min), high.into_iter().fold(f64::NEG_INFINITY, f64::max)]
}

/// The upper median, 0 for no values; they come out in another order.
pub(crate) fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// The upper median of points along each axis, 0 for none.
pub(crate) fn median_point(points: &[Vector3<f64>]) -> Vector3<f64> {
    Vector3::from_fn(|axis, _| median(&mut points.iter().map(|point| point[axis]).collect::<List<_>>()))
}

/// The upper median, and the standard deviation about it, from the median of the distances: 0 for no values, in place of which these
/// distances are left.
pub(crate) fn median_and_deviation(values: &mut [f64]) -> [f64; 2] {
    let middle = median(values);
    values.iter_mut().for_each(|value| *value = (*value - middle).abs());
    [middle, DEVIATION_OF_MEDIAN * median(values)]
}

/// The upper median of the absolute values of numbers, 0 for none.
pub(crate) fn median_absolute(numbers: impl Iterator<Item = f64>) -> f64 {
    quantile_absolute(numbers, 2)
}

/// The same of numbers whose upper median of the absolute values is about known. What is known changes nothing but the time.
pub(crate) fn median_absolute_near(numbers: &[f64], near: f64) -> f64 {
    let median = median_absolute_between(beside(near), numbers.len(), |receive| receive(numbers));
    median.unwrap_or_else(|| median_absolute(numbers.iter().copied()))
}

/// The bounds about a median that is about known, between which it is found at once.
pub(crate) fn beside(near: f64) -> [f64; 2] {
    const PART: f64 = 0.02;
    [(1.0 - PART) * near, (1.0 + PART) * near]
}

/// Adds the bits of absolute values to a list that are not below a first nor above a last one, of which there are few, and counts
/// those that are below. No closures: what is not inlined does without vector instructions.
struct BetweenAbsolute<'a> {
    numbers: &'a [f64],
    first: u64,
    last: u64,
    found: &'a mut List<u64>,
}

impl WithSimd for BetweenAbsolute<'_> {
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> usize {
        let Self { numbers, first, last, found } = self;
        let mut below = 0_u64;
        for number in numbers {
            below += u64::from(number.abs().to_bits() < first);
        }
        let (blocks, rest) = numbers.as_chunks::<8>();
        for block in blocks {
            // Most have none.
            let mut any = false;
            for number in block {
                let size = number.abs().to_bits();
                any |= (size >= first) & (size <= last);
            }
            if any {
                add_absolute(block, [first, last], found);
            }
        }
        add_absolute(rest, [first, last], found);
        below as usize
    }
}

#[inline(always)]
fn add_absolute(numbers: &[f64], [first, last]: [u64; 2], found: &mut List<u64>) {
    for number in numbers {
        let size = number.abs().to_bits();
        if size >= first && size <= last {
            found.push(size);
        }
    }
}

/// The sum of the products of two lists of the same length, four side by side.
#[inline(always)]
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    let (mut sums, mut rest) = ([0.0; 4], 0.0);
    for (a, b) in a.iter().zip(b) {
        for k in 0..4 {
            sums[k] += a[k] * b[k];
        }
    }
    for (a, b) in a_rest.iter().zip(b_rest) {
        rest += a * b;
    }
    total(sums, rest)
}

#[inline(always)]
pub(crate) fn total(sums: [f64; 4], rest: f64) -> f64 {
    (sums[0] + sums[2]) + (sums[1] + sums[3]) + rest
}

/// The part of residuals in their order that tells as much as all of them do: (1 − ρ) / (1 + ρ) with the correlation ρ of
/// neighbours, as of a first-order autoregression.
pub(crate) fn independent_part(residuals: &[f64]) -> f64 {
    let squares: f64 = residuals.iter().map(|e| e * e).sum();
    let products: f64 = residuals.windows(2).map(|pair| pair[0] * pair[1]).sum();
    if !(products > 0.0) {
        return 1.0;
    }
    (squares - products) / (squares + products)
}

/// Between which absolute values the median of many numbers is that a `sample` is like; `None` for a small one.
pub(crate) fn bounds_of_median_absolute(sample: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let mut sample: List<u64> = sample.map(|number| number.abs().to_bits()).collect();
    sample.sort_unstable();
    // Four standard deviations of the rank of the median in the sample.
    let (middle, reach) = (sample.len() / 2, 2 * sample.len().isqrt() + 1);
    let [low, high] = [sample.get(middle.checked_sub(reach)?)?, sample.get(middle + reach)?];
    Some([low, high].map(|bits| f64::from_bits(*bits)))
}

/// The upper median of the absolute values of so many numbers that come in blocks, of which those between two bounds are kept; `None`
/// where it is not one of these.
pub(crate) fn median_absolute_between(
    bounds: [f64; 2],
    count: usize,
    blocks: impl FnOnce(&mut dyn FnMut(&[f64])),
) -> Option<f64> {
    let [first, last] = bounds.map(|bound| bound.abs().to_bits());
    let mut found = List::with_capacity(count / 8);
    let mut below = 0;
    blocks(&mut |numbers| {
        below += Arch::new().dispatch(BetweenAbsolute { numbers, first, last, found: &mut found });
    });
    let rank = (count / 2).checked_sub(below).filter(|&rank| rank < found.len())?;
    Some(f64::from_bits(nth(&mut found, rank)))
}

/// The lower quartile of the absolute values of numbers, 0 for none.
pub(crate) fn lower_quartile_absolute(numbers: impl Iterator<Item = f64>) -> f64 {
    quantile_absolute(numbers, 4)
}

/// The 1/`parts` quantile of the absolute values of numbers, 0 for none.
fn quantile_absolute(numbers: impl Iterator<Item = f64>, parts: usize) -> f64 {
    // Numbers without sign are ordered as their bits are, which are quicker to compare.
    let mut sizes: List<u64> = numbers.map(|number| number.abs().to_bits()).collect();
    if sizes.is_empty() {
        return 0.0;
    }
    let rank = sizes.len() / parts;
    f64::from_bits(nth(&mut sizes, rank))
}

const SIGN: u64 = 1 << 63;

/// The bits of a number, in the order of `f64::total_cmp`: those of negative ones are turned round.
pub(crate) fn ordered(number: f64) -> u64 {
    let bits = number.to_bits();
    // All bits of those below zero are turned, of others the sign alone.
    bits ^ ((bits.cast_signed() >> 63).cast_unsigned() | SIGN)
}

/// The same of a number of 32 bits.
pub(crate) fn ordered_single(number: f32) -> u32 {
    let bits = number.to_bits();
    bits ^ ((bits.cast_signed() >> 31).cast_unsigned() | 1 << 31)
}

/// Order statistics: the numbers that have some ranks, from 0 on, of which there must be as many.
pub(crate) fn order_statistics<const N: usize>(
    numbers: impl Iterator<Item = f64>,
    ranks: [usize; N],
) -> [f64; N] {
    let mut ordered: List<u64> = numbers.map(ordered).collect();
    ranks.map(|rank| number(nth(&mut ordered, rank)))
}

/// The number that has these ordered bits.
fn number(bits: u64) -> f64 {
    f64::from_bits(if bits & SIGN == 0 { !bits } else { bits & !SIGN })
}

/// The numbers that have so many below them and so many above.
pub(crate) fn at_both_ends(numbers: &[f64], outer: usize) -> [f64; 2] {
    let count = numbers.len();
    if outer < FEW_OUTER {
        return few_outer(numbers, outer);
    }
    let all = || order_statistics(numbers.iter().copied(), [outer, count - 1 - outer]);
    // Their rank in a sample, with three standard deviations of that.
    let rank = outer as f64 * SAMPLE as f64 / count as f64;
    let reach = (rank + 3.0 * rank.sqrt() + 3.0) as usize;
    if count < 8 * SAMPLE || 2 * reach >= SAMPLE {
        return all();
    }
    let mut sample: [u64; SAMPLE] = std::array::from_fn(|k| ordered(numbers[k * count / SAMPLE]));
    sample.sort_unstable();
    let [low, high] = [sample[reach], sample[SAMPLE - 1 - reach]].map(number);
    let room = 2 * reach * count / SAMPLE;
    let (mut lowest, mut highest) = (List::with_capacity(room), List::with_capacity(room));
    for number in numbers {
        if *number <= low {
            lowest.push(*number);
        } else if *number >= high {
            highest.push(*number);
        }
    }
    let (Some(last), true) = (highest.len().checked_sub(outer + 1), lowest.len() > outer) else {
        return all();
    };
    let nth = |numbers: &mut [f64], rank: usize| *numbers.select_nth_unstable_by(rank, f64::total_cmp).1;
    [nth(&mut lowest, outer), nth(&mut highest, last)]
}

/// Fewer outer numbers than this are kept in their order while all are gone through.
const FEW_OUTER: usize = 24;

/// The numbers that have so few below them and so few above.
fn few_outer(numbers: &[f64], outer: usize) -> [f64; 2] {
    let (mut least, mut most) = ([f64::INFINITY; FEW_OUTER], [f64::INFINITY; FEW_OUTER]);
    for block in numbers.chunks(16) {
        // Most blocks have none of them.
        let [low, high] = min_max(block);
        if low < least[outer] {
            block.iter().for_each(|number| insert(&mut least[..=outer], *number));
        }
        if -high < most[outer] {
            block.iter().for_each(|number| insert(&mut most[..=outer], -number));
        }
    }
    [least[outer], -most[outer]]
}

/// Puts a number into its place in an ordered list of the least ones.
fn insert(least: &mut [f64], number: f64) {
    let last = least.len() - 1;
    if number < least[last] {
        let index = least.partition_point(|other| *other <= number);
        least.copy_within(index..last, index + 1);
        least[index] = number;
    }
}

/// Numbers of a sample, which tells about where another one is.
const SAMPLE: usize = 256;

/// The number of a rank in the ordered list; few numbers come out in another order.
fn nth(numbers: &mut [u64], rank: usize) -> u64 {
    let count = numbers.len();
    if count < 4 * SAMPLE {
        return *numbers.select_nth_unstable(rank).1;
    }
    let mut sample: [u64; SAMPLE] = std::array::from_fn(|k| numbers[k * count / SAMPLE]);
    let (lower, &mut near, upper) = sample.select_nth_unstable(rank * SAMPLE / count);
    let below = Arch::new().dispatch(|| numbers.iter().map(|number| u64::from(*number < near)).sum::<u64>());
    let below = below as usize;
    // As many of the sample as lie between that number and the wanted one, and three standard deviations more.
    let expected = (rank.abs_diff(below) * SAMPLE) as f64 / count as f64;
    let reach = (expected + 3.0 * expected.sqrt() + 3.0) as usize;
    let mut found = List::with_capacity(count);
    let at = if rank >= below {
        let last = if reach < upper.len() { *upper.select_nth_unstable(reach).1 } else { u64::MAX };
        Arch::new().dispatch(Between { numbers, first: near, last, found: &mut found });
        Some(rank - below)
    } else {
        let first = lower.len().checked_sub(reach + 1).map_or(0, |k| *lower.select_nth_unstable(k).1);
        // Some of the sample may be as large as that number.
        let last = near - 1;
        Arch::new().dispatch(Between { numbers, first: first.min(last), last, found: &mut found });
        found.len().checked_sub(below - rank)
    };
    match at {
        Some(at) if at < found.len() => *found.select_nth_unstable(at).1,
        _ => *numbers.select_nth_unstable(rank).1,
    }
}

/// Adds those numbers to a list that are not below a first nor above a last one, of which there are few. No closure: what is not
/// inlined does without vector instructions.
struct Between<'a> {
    numbers: &'a [u64],
    first: u64,
    last: u64,
    found: &'a mut List<u64>,
}

impl WithSimd for Between<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { numbers, first, last, found } = self;
        let reach = last - first;
        let (blocks, rest) = numbers.as_chunks::<32>();
        for block in blocks {
            // All of a block are asked at once.
            let mut bits = 0_u32;
            for (k, number) in block.iter().enumerate() {
                bits |= u32::from(number.wrapping_sub(first) <= reach) << k;
            }
            while bits != 0 {
                found.push(block[bits.trailing_zeros() as usize]);
                bits &= bits - 1;
            }
        }
        found.extend(rest.iter().filter(|number| number.wrapping_sub(first) <= reach));
    }
}

/// A random number between −1 and 1.
#[cfg(test)]
pub(crate) fn random_number(rng: &mut rand_chacha::ChaCha8Rng) -> f64 {
    use rand_chacha::rand_core::Rng;
    f64::from(rng.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};

    #[test]
    fn the_median_is_the_upper_one() {
        assert_eq!(median(&mut [3.0, -1.0, 7.0]), 3.0);
        assert_eq!(median(&mut [3.0, -1.0, 7.0, 4.0]), 4.0);
        assert_eq!(median(&mut []), 0.0);
    }

    #[test]
    fn what_is_known_of_a_median_does_not_change_it() {
        let numbers: Vec<f64> = (0..1003).map(|k| f64::from((k * 7919) % 1009) - 500.0).collect();
        let median = median_absolute(numbers.iter().copied());
        for near in [0.0, 0.5, 0.94, 0.96, 1.0, 1.04, 1.2, f64::INFINITY, f64::NAN] {
            assert_eq!(median_absolute_near(&numbers, near * median), median);
            assert_eq!(median_absolute_near(&numbers[..3], near * median), 356.0);
        }
        assert_eq!(median_absolute_near(&[], 1.0), 0.0);
    }

    #[test]
    fn residuals_that_err_with_their_neighbours_count_less() {
        // Noise with variance 1, of which each residual keeps ρ from the one before it.
        let series = |correlation: f64| {
            let mut rng = ChaCha8Rng::seed_from_u64(5);
            let mut last = 0.0;
            let next = |_| {
                let fresh = (f64::from(rng.next_u32()) / f64::from(u32::MAX) - 0.5) * 12.0_f64.sqrt();
                last = correlation * last + (1.0 - correlation * correlation).sqrt() * fresh;
                last
            };
            (0..20_000).map(next).collect::<Vec<f64>>()
        };
        for (correlation, part) in [(0.0, 1.0), (0.3, 0.538), (0.6, 0.25), (0.9, 0.0526)] {
            let found = independent_part(&series(correlation));
            assert!((found - part).abs() < 0.03, "{correlation}: {found}");
        }
        // Never more than there are, and exact where nothing is left.
        assert_eq!(independent_part(&series(-0.5)), 1.0);
        assert_eq!(independent_part(&[0.0; 10]), 1.0);
    }

    #[test]
    fn many_numbers_have_the_same_rank_as_few() {
        let mut state = 1_u64;
        let mut random = || {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            state >> 40
        };
        let many: Vec<u64> = (0..5000).map(|_| random()).collect();
        let equal = vec![7; 4000];
        let rising: Vec<u64> = (0..3000).collect();
        // The sample sees one of them alone.
        let periodic: Vec<u64> =
            (0..256 * 16).map(|k| if k % 16 == 0 { 1 << 50 } else { random() }).collect();
        // Whole numbers, of which many are the same.
        let few: Vec<u64> = (0..5000).map(|_| random() % 3).collect();
        // The sample sees the largest far too often.
        let largest: Vec<u64> = (0..256 * 16).map(|k| if k % 16 < 3 { 9 } else { k % 5 }).collect();
        for numbers in [many, equal, rising, periodic, few, largest] {
            let mut ordered = numbers.clone();
            ordered.sort_unstable();
            for rank in [0, numbers.len() / 4, numbers.len() / 2, numbers.len() - 1] {
                assert_eq!(nth(&mut numbers.clone(), rank), ordered[rank]);
            }
        }
    }

    #[test]
    fn ranks_count_from_the_lowest_number() {
        let numbers = [3.0, -1.0, 0.0, -7.5, 2.0];
        assert_eq!(order_statistics(numbers.into_iter(), [0, 1, 2, 4]), [-7.5, -1.0, 0.0, 3.0]);
    }

    #[test]
    fn the_outer_numbers_are_those_of_the_ordered_list() {
        let wave =
            |count: usize| (0..count).map(|k| (k as f64 * 12.9898).sin() * 43758.5453).collect::<Vec<f64>>();
        // Many that the sample does not see, all above or all below those that it sees.
        let unseen = |far: f64| {
            let mut numbers = vec![far; 5000];
            (0..SAMPLE).for_each(|k| numbers[k * 5000 / SAMPLE] = k as f64);
            numbers
        };
        for numbers in
            [wave(3), wave(100), wave(5000), wave(70_001), vec![2.0; 4000], unseen(1e9), unseen(-1e9)]
        {
            let mut ordered = numbers.clone();
            ordered.sort_unstable_by(f64::total_cmp);
            for outer in [0, numbers.len() / 100, numbers.len() / 3] {
                let expected = [ordered[outer], ordered[numbers.len() - 1 - outer]];
                assert_eq!(at_both_ends(&numbers, outer), expected);
            }
        }
    }

    #[test]
    fn the_median_absolute_has_no_sign() {
        let numbers = [3.0, -1.0, 7.0, -4.0, 1e-300, -0.0, 5.0, f64::INFINITY];
        let mut sizes = numbers.map(f64::abs);
        assert_eq!(median_absolute(numbers.into_iter()), median(&mut sizes));
        assert_eq!(median_absolute(std::iter::empty()), 0.0);
        assert_eq!(lower_quartile_absolute([5.0, -2.0, 3.0, -1.0].into_iter()), 2.0);
        assert_eq!(lower_quartile_absolute(std::iter::empty()), 0.0);
    }
}
