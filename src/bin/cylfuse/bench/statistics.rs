//! Means and quantiles of errors.

use super::page::shown;

/// What a list of errors comes to. Values that are not finite are those of fits that failed, or that have no truth.
#[derive(Debug, Clone, Copy)]
pub struct Summary {
    /// The finite values.
    pub count: usize,
    /// Their mean.
    pub mean: f64,
    /// Their standard deviation.
    pub deviation: f64,
    /// Their median.
    pub median: f64,
    /// The value that nine of ten do not exceed.
    pub ninety: f64,
    /// The largest.
    pub worst: f64,
}

impl Summary {
    /// The summary of values in any order; all NaN where none is finite.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).collect();
        values.sort_by(f64::total_cmp);
        let count = values.len();
        let mean = values.iter().sum::<f64>() / count as f64;
        let squares = values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>();
        let at = |share: f64| {
            let index = ((share * count as f64).ceil() as usize).max(1) - 1;
            values.get(index).copied().unwrap_or(f64::NAN)
        };
        let median = if count > 0 && count.is_multiple_of(2) {
            0.5 * (values[count / 2 - 1] + values[count / 2])
        } else {
            at(0.5)
        };
        Self {
            count,
            mean,
            deviation: match count {
                0 => f64::NAN,
                // A single value shows no scatter.
                1 => 0.0,
                _ => (squares / (count - 1) as f64).sqrt(),
            },
            median,
            ninety: at(0.9),
            worst: at(1.0),
        }
    }

    /// Mean and standard deviation for a table.
    pub fn cell(&self) -> String {
        format!("{} ± {}", shown(self.mean), shown(self.deviation))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn summaries_leave_failures_out() {
        let summary = Summary::of([4.0, f64::NAN, 1.0, 2.0, 3.0]);
        assert_eq!((summary.count, summary.mean, summary.median), (4, 2.5, 2.5));
        assert_eq!((summary.ninety, summary.worst), (4.0, 4.0));
        assert!((summary.deviation - (5.0_f64 / 3.0).sqrt()).abs() < 1e-15);
        let Summary { mean, deviation, worst, .. } = Summary::of([]);
        assert!([mean, deviation, worst].iter().all(|value| value.is_nan()));
    }
}
