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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_the_upper_one() {
        assert_eq!(median(&mut [3.0, -1.0, 7.0]), 3.0);
        assert_eq!(median(&mut [3.0, -1.0, 7.0, 4.0]), 4.0);
        assert_eq!(median(&mut []), 0.0);
    }
}
