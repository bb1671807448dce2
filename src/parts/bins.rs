//! Values dealt out to bins, by counting.

use crate::memory::List;

/// Values by bin; those of one bin in the order in which they came.
pub(super) struct Bins<T: Send + 'static> {
    values: List<T>,
    /// Where each bin begins, and where the last one ends.
    bounds: List<usize>,
}

impl<T: Clone + Default + Send + 'static> Bins<T> {
    /// Deals out values, each with the index of its bin, to so many bins.
    pub(super) fn new(count: usize, values: impl Iterator<Item = (usize, T)> + Clone) -> Self {
        // The bounds begin one bin late: dealing a bin out moves where it begins to where it ends.
        let mut bounds = List::filled(0, count + 2);
        values.clone().for_each(|(bin, _)| bounds[bin + 2] += 1);
        for bin in 0..count {
            bounds[bin + 2] += bounds[bin + 1];
        }
        let mut dealt_out = List::filled(T::default(), bounds[count + 1]);
        for (bin, value) in values {
            let next = &mut bounds[bin + 1];
            dealt_out[*next] = value;
            *next += 1;
        }
        Self { values: dealt_out, bounds }
    }

    /// How many values a bin has.
    pub(super) fn len_of(&self, bin: usize) -> usize {
        self.bounds[bin + 1] - self.bounds[bin]
    }

    /// The values of a bin.
    pub(super) fn of(&mut self, bin: usize) -> &mut [T] {
        &mut self.values[self.bounds[bin]..self.bounds[bin + 1]]
    }

    /// All values, bin by bin.
    pub(super) fn values(&self) -> &[T] {
        &self.values
    }
}
