//! Calls that list what a fit knows of points, limbs and ends.

use crate::call;
use crate::calls::{Case, Teller};
use crate::checks;
use cylfuse::ffi::*;
use std::ptr::null_mut;

impl Case<'_> {
    /// Asks how much room a list needs, then for the list with as much, or more or less.
    pub fn listed<T: Copy>(
        &mut self,
        mut list: impl FnMut(&mut Self, *mut T, usize, *mut usize) -> bool,
    ) -> Vec<T> {
        let mut needed = usize::MAX;
        let counts = self.source.room::<usize>(1);
        list(self, null_mut(), 0, counts.pointer);
        if let Some(count) = counts.read()
            && count < 100_000
        {
            needed = count;
        }
        let capacity = if needed == usize::MAX { 3 } else { needed };
        let capacity = if self.source.strikes() {
            [0, capacity + 1, capacity.saturating_sub(1)][self.source.dice.below(3)]
        } else {
            capacity
        };
        let room = self.source.room::<T>(capacity);
        let counts = self.source.room::<usize>(1);
        if !list(self, room.pointer, capacity, counts.pointer) {
            return Vec::new();
        }
        let count = counts.read().unwrap();
        assert!(count <= capacity && (needed == usize::MAX || count == needed), "{count} of {needed}");
        // SAFETY: the call filled that many, or there was no room for what is optional.
        if room.pointer.is_null() {
            Vec::new()
        } else {
            (0..count).map(|k| unsafe { room.pointer.add(k).read_unaligned() }).collect()
        }
    }

    fn element_size<T>(&mut self) -> usize {
        let size = size_of::<T>();
        if self.source.strikes() { [0, size - 1, 4097, usize::MAX][self.source.dice.below(4)] } else { size }
    }

    pub fn list(&mut self) {
        let fitter = self.fitter();
        let t = Teller::Fitter(fitter);
        match self.source.dice.below(6) {
            0 => {
                let model = self.source.model_or_last();
                let kind = cylfuse_residual_kind(self.source.constant(2));
                let residuals = self.listed(|case, out, capacity, count| {
                    call!(case, t, cylfuse_fitter_residuals(fitter, model, kind, out, capacity, count))
                });
                checks::finite(&residuals);
            }
            1 => {
                let weights = self.listed(|case, out, capacity, count| {
                    let inliers = case.source.room(capacity);
                    call!(
                        case,
                        t,
                        cylfuse_fitter_point_weights(fitter, out, inliers.pointer, capacity, count)
                    )
                });
                assert!(weights.iter().all(|weight: &f64| (0.0..=1.0).contains(weight)), "{weights:?}");
            }
            2 => {
                let model = self.source.model_or_last();
                let parts: Vec<cylfuse_part> = self.listed(|case, out, capacity, count| {
                    call!(case, t, cylfuse_fitter_point_parts(fitter, model, out, capacity, count))
                });
                assert!(parts.iter().all(|part| (1..=5).contains(&part.0)));
            }
            3 => {
                let size = self.element_size::<cylfuse_limb>();
                let limbs: Vec<cylfuse_limb> = self.listed(|case, out, capacity, count| {
                    call!(case, t, cylfuse_fitter_limbs(fitter, out, size, capacity, count))
                });
                for limb in limbs {
                    let numbers = [limb.line.as_slice(), &[limb.deviation]].concat();
                    if limb.status == cylfuse_limb_status::LOCATED {
                        checks::finite(&numbers);
                    } else {
                        assert!(numbers.iter().all(|x| x.is_nan()), "{numbers:?}");
                    }
                }
            }
            4 => {
                let size = self.element_size::<cylfuse_limb_sample>();
                let samples: Vec<cylfuse_limb_sample> = self.listed(|case, out, capacity, count| {
                    call!(case, t, cylfuse_fitter_limb_samples(fitter, out, size, capacity, count))
                });
                for sample in samples {
                    checks::finite(&[sample.pixel[0], sample.pixel[1], sample.deviation, sample.weight]);
                }
            }
            _ => {
                let size = self.element_size::<cylfuse_end_sample>();
                let (model, mask) = (self.source.model_or_last(), self.source.mask_or_none());
                let samples: Vec<cylfuse_end_sample> = self.listed(|case, out, capacity, count| {
                    call!(
                        case,
                        t,
                        cylfuse_fitter_end_samples(fitter, model, mask, out, size, capacity, count)
                    )
                });
                for sample in samples {
                    checks::finite(&[sample.pixel, sample.normal].concat());
                    checks::finite(&[sample.deviation]);
                }
            }
        }
    }
}
