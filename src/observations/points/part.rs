//! A part of very many points, for what need not be known of all of them.

use super::PointCloud;
use crate::memory::List;

/// Points that lead to a minimum, and that tell the correlation of noise: that of neighbours is known to 1/√n then.
pub(crate) const ENOUGH_POINTS_TO_FIT: usize = 20_000;

/// Where there are more than so many times as many, a part of them comes first.
const MANY: usize = 2;

/// The fractional part of the golden ratio, whose multiples lie evenly in any period.
const GOLDEN: f64 = 0.618_033_988_749_895;

/// Whether there are so many points that a part of them comes first.
pub(crate) fn are_many(count: usize) -> bool {
    count > MANY * ENOUGH_POINTS_TO_FIT
}

impl PointCloud {
    /// So many of the points, or all, evenly spread over their order without the period of rows.
    pub(crate) fn spread(&self, count: usize) -> Self {
        self.listed(&spread(self.len(), count))
    }
}

/// So many indices of a list, evenly spread over it, none of them twice; without the period of rows where they are no more than
/// half of it.
pub(crate) fn spread(length: usize, count: usize) -> List<usize> {
    let count = count.min(length);
    if count > length / 2 {
        return (0..count).map(|k| k * length / count).collect();
    }
    let step = length as f64 / count as f64;
    (0..count).map(|k| ((k as f64 + (k as f64 * GOLDEN).fract()) * step) as usize).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spread_takes_all_columns_alike() {
        let (count, columns) = (1_000_000, 1000);
        let indices = spread(count, ENOUGH_POINTS_TO_FIT);
        assert!(
            indices.is_sorted() && indices.len() == ENOUGH_POINTS_TO_FIT && *indices.last().unwrap() < count
        );
        let mut taken = vec![0; columns];
        indices.iter().for_each(|index| taken[index % columns] += 1);
        assert!(taken.iter().all(|taken| (15..=25).contains(taken)), "{taken:?}");
        assert_eq!(*spread(5, 20), [0, 1, 2, 3, 4]);
    }

    #[test]
    fn a_spread_takes_no_index_twice() {
        for length in (2000..6000).step_by(7) {
            let indices = spread(length, 2000);
            assert!(indices.is_sorted_by(|a, b| a < b) && indices.len() == 2000, "{length}");
            assert!(*indices.last().unwrap() < length, "{length}");
        }
    }
}
