//! Robust location and scale of numbers.

/// The standard deviation of normal errors over the median of their absolute values.
pub(crate) const DEVIATION_OF_MEDIAN: f64 = 1.4826;

/// The upper median, 0 for no values; they come out in another order.
pub(crate) fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// The upper median of the absolute values of numbers, 0 for none.
pub(crate) fn median_size(numbers: impl Iterator<Item = f64>) -> f64 {
    size_at(numbers, 2)
}

/// The absolute value that a quarter of those of numbers lie below, 0 for none.
pub(crate) fn lower_quartile_size(numbers: impl Iterator<Item = f64>) -> f64 {
    size_at(numbers, 4)
}

/// The absolute value that one part in `parts` of those of numbers lie below, 0 for none.
fn size_at(numbers: impl Iterator<Item = f64>, parts: usize) -> f64 {
    // Numbers without sign are ordered as their bits are, which are quicker to compare.
    let mut sizes: Vec<u64> = numbers.map(|number| number.abs().to_bits()).collect();
    if sizes.is_empty() {
        return 0.0;
    }
    let place = sizes.len() / parts;
    f64::from_bits(*sizes.select_nth_unstable(place).1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_the_upper_one() {
        assert_eq!(median(&mut [3.0, -1.0, 7.0]), 3.0);
        assert_eq!(median(&mut [3.0, -1.0, 7.0, 4.0]), 4.0);
        assert_eq!(median(&mut []), 0.0);
    }

    #[test]
    fn the_median_size_has_no_sign() {
        let numbers = [3.0, -1.0, 7.0, -4.0, 1e-300, -0.0, 5.0, f64::INFINITY];
        let mut sizes = numbers.map(f64::abs);
        assert_eq!(median_size(numbers.into_iter()), median(&mut sizes));
        assert_eq!(median_size(std::iter::empty()), 0.0);
        assert_eq!(lower_quartile_size([5.0, -2.0, 3.0, -1.0].into_iter()), 2.0);
        assert_eq!(lower_quartile_size(std::iter::empty()), 0.0);
    }
}
