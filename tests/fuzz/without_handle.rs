//! Calls without a handle.

use crate::call;
use crate::calls::{Case, Teller};
use crate::checks;
use cylfuse::ffi::*;
use std::ffi::CStr;

impl Case<'_> {
    pub fn without_handle(&mut self) {
        let t = Teller::None;
        match self.source.dice.below(7) {
            0 => {
                let (model, (points, count)) = (self.source.model(), self.source.points());
                let capacity = self.source.hostility.count(&mut self.source.dice, count).min(20_000);
                let out = self.source.room::<f64>(capacity);
                call!(self, t, cylfuse_cylinder_distances(model, points, out.pointer, capacity));
                if let Some(numbers) = (capacity > 0).then(|| out.read()).flatten() {
                    checks::finite_or_nan(&[numbers]);
                }
            }
            1 => {
                let (model, intrinsics) = (self.source.model(), self.source.intrinsics());
                let out = self.source.room::<[f64; 6]>(1);
                if call!(self, t, cylfuse_cylinder_project(model, intrinsics, out.pointer.cast())) {
                    checks::finite(&out.read().unwrap());
                }
            }
            2 => {
                let (a, b) = (self.source.model(), self.source.model());
                let out = [0; 3].map(|_| self.source.room::<f64>(1));
                let [angle, distance, relative] = [0, 1, 2].map(|k: usize| out[k].pointer);
                if call!(self, t, cylfuse_cylinder_compare(a, b, angle, distance, relative)) {
                    checks::finite(&out.map(|room| room.read().unwrap()));
                }
            }
            3 => {
                if self.source.dice.one_in(8) {
                    self.plan();
                }
            }
            5 => {
                let [value, deviation, lower, upper, coverage] =
                    [20.0, 0.1, 19.5, 20.5, 2.0].map(|x| self.source.number(x));
                let flags = cylfuse_result_flags(1 << self.source.dice.below(21));
                let out = self.source.room::<cylfuse_conformity>(1);
                if call!(
                    self,
                    t,
                    cylfuse_decide_conformity(value, deviation, flags, lower, upper, coverage, out.pointer)
                ) {
                    assert!((0..=2).contains(&out.read().unwrap().0));
                }
            }
            4 => {
                let (intrinsics, (points, count)) = (self.source.intrinsics(), self.source.points());
                let capacity = self.source.hostility.count(&mut self.source.dice, count).min(20_000);
                let out = self.source.room::<[f64; 2]>(capacity);
                if call!(
                    self,
                    t,
                    cylfuse_intrinsics_project(intrinsics, points, out.pointer.cast(), capacity)
                ) {
                    for k in 0..count {
                        checks::finite_or_nan(&unsafe { out.pointer.add(k).read_unaligned() });
                    }
                }
            }
            _ => {
                let pixels: Vec<f64> = (0..2 * self.source.dice.below(20))
                    .map(|_| {
                        let x = self.source.dice.between(-20.0, 200.0);
                        self.source.number(x)
                    })
                    .collect();
                let (intrinsics, count) = (self.source.intrinsics(), pixels.len() / 2);
                let pixels = self.source.numbers(&pixels);
                let out = self.source.room::<[f64; 3]>(count);
                if call!(self, t, cylfuse_intrinsics_unproject(intrinsics, pixels, count, out.pointer.cast()))
                {
                    for k in 0..count {
                        let ray = unsafe { out.pointer.add(k).read_unaligned() };
                        checks::finite_or_nan(&ray);
                        assert!(ray[2] == 1.0 || ray.iter().all(|x| x.is_nan()), "{ray:?}");
                    }
                }
            }
        }
    }

    fn plan(&mut self) {
        let cylinder = [1.0, 0.05, 0.2, 0.3, 0.4].map(|x| self.source.number(x));
        let noise = [0.001, 0.0, 0.001, 1.5, 0.02, 0.8].map(|x| self.source.number(x));
        let (intrinsics, cylinder) = (self.source.intrinsics(), self.source.numbers(&cylinder));
        let noise = if self.source.dice.one_in(2) { std::ptr::null() } else { self.source.numbers(&noise) };
        let (scatter, total) = (self.source.room::<[f64; 4]>(1), self.source.room::<[f64; 4]>(1));
        let out = (scatter.pointer.cast(), total.pointer.cast());
        if call!(self, Teller::None, cylfuse_plan(intrinsics, cylinder, noise, out.0, out.1)) {
            for numbers in [scatter.read().unwrap(), total.read().unwrap()] {
                checks::finite(&numbers[..3]);
                checks::finite_or_nan(&numbers[3..]);
            }
        }
    }

    /// The functions that fill a struct with defaults.
    pub fn initialise(&mut self) {
        macro_rules! initialise {
            ($($function:ident $kind:ident),* $(,)?) => {{
                let functions = [$(stringify!($function)),*];
                let which = functions[self.source.dice.below(functions.len())];
                $(if which == stringify!($function) {
                    let size = size_of::<$kind>();
                    let given = self.source.hostility.count(&mut self.source.dice, size);
                    let room = self.source.room::<u8>(given.min(5000));
                    call!(self, Teller::None, $function(room.pointer.cast(), given));
                })*
            }};
        }
        initialise!(
            cylfuse_options_init cylfuse_options,
            cylfuse_detector_options_init cylfuse_detector_options,
            cylfuse_intrinsics_init cylfuse_intrinsics,
            cylfuse_points_view_init cylfuse_points_view,
            cylfuse_depth_view_init cylfuse_depth_view,
            cylfuse_mask_view_init cylfuse_mask_view,
            cylfuse_image_view_init cylfuse_image_view,
            cylfuse_segments_view_init cylfuse_segments_view,
            cylfuse_points_out_init cylfuse_points_out,
            cylfuse_depth_out_init cylfuse_depth_out,
            cylfuse_counts_init cylfuse_counts,
            cylfuse_result_init cylfuse_result,
            cylfuse_cylinder_estimate_init cylfuse_cylinder_estimate,
            cylfuse_cylinder_diagnosis_init cylfuse_cylinder_diagnosis,
            cylfuse_completion_init cylfuse_completion,
            cylfuse_extent_init cylfuse_extent,
        );
        let status = cylfuse_status(self.source.dice.below(200) as i32 - 120);
        let number = status.0;
        for text in [
            cylfuse_status_string(status),
            cylfuse_flag_string(cylfuse_result_flags(number as u32)),
            cylfuse_termination_string(cylfuse_termination(number)),
            cylfuse_start_string(cylfuse_start(number)),
            cylfuse_end_state_string(cylfuse_end_state(number)),
            cylfuse_end_source_string(cylfuse_end_source(number)),
            cylfuse_limb_status_string(cylfuse_limb_status(number)),
            cylfuse_part_string(cylfuse_part(number as u8)),
            cylfuse_conformity_string(cylfuse_conformity(number)),
        ] {
            // SAFETY: a static text.
            assert!(!unsafe { CStr::from_ptr(text) }.is_empty());
        }
    }
}
