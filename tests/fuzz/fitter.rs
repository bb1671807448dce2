//! Calls that set up fitters, push data and fit.

use crate::call;
use crate::calls::{Case, Teller};
use crate::checks;
use crate::inputs::Room;
use cylfuse::ffi::*;
use std::ffi::{CStr, c_char, c_void};
use std::ptr::null_mut;

impl Case<'_> {
    pub fn set_up(&mut self) {
        let fitter = self.fitter();
        let t = Teller::Fitter(fitter);
        match self.source.dice.below(16) {
            0..2 => {
                let intrinsics = self.source.intrinsics();
                call!(self, t, cylfuse_fitter_set_intrinsics(fitter, intrinsics));
            }
            2..4 => {
                let options = self.source.options();
                let options = self.source.input(&options);
                call!(self, t, cylfuse_fitter_set_options(fitter, options));
            }
            4 => {
                let out = self.source.output();
                if call!(self, t, cylfuse_fitter_get_options(fitter, out.pointer)) && out.is_whole() {
                    let again = out.pointer;
                    // What was taken is what is held.
                    assert!(call!(self, t, cylfuse_fitter_set_options(fitter, again)));
                }
            }
            5 => {
                let index = self.source.dice.below(3);
                let index = self.source.hostility.count(&mut self.source.dice, index);
                call!(self, t, cylfuse_fitter_select_view(fitter, index));
            }
            6 => {
                let out = self.source.room::<usize>(1);
                call!(self, t, cylfuse_fitter_view_count(fitter, out.pointer));
            }
            7 => {
                let (rotation, translation) = self.source.motion();
                call!(self, t, cylfuse_fitter_set_pose(fitter, rotation, translation));
            }
            8 => {
                let intrinsics = self.source.intrinsics();
                let (rotation, translation) = self.source.motion();
                call!(self, t, cylfuse_fitter_set_depth_camera(fitter, intrinsics, rotation, translation));
            }
            9 => {
                let model = self.source.model();
                call!(self, t, cylfuse_fitter_set_start_model(fitter, model));
            }
            10 => {
                let which = self.source.dice.below(3);
                let callback: cylfuse_progress_fn = if which == 0 { None } else { Some(meddle) };
                call!(self, t, cylfuse_fitter_set_progress(fitter, callback, fitter.cast()));
                let level = cylfuse_log_level(self.source.constant(4));
                let callback: cylfuse_log_fn = if which == 0 { None } else { Some(listen) };
                call!(self, t, cylfuse_fitter_set_log(fitter, level, callback, null_mut()));
            }
            11 => {
                let points = self.source.hostility.count(&mut self.source.dice, 1000);
                let segments = self.source.hostility.count(&mut self.source.dice, 10);
                call!(self, t, cylfuse_fitter_reserve(fitter, points, segments));
            }
            13 => {
                let out = self.source.output();
                if call!(self, t, cylfuse_fitter_get_intrinsics(fitter, out.pointer)) && out.is_whole() {
                    let again = out.pointer;
                    // What is held may be set.
                    assert!(call!(self, t, cylfuse_fitter_set_intrinsics(fitter, again)));
                }
            }
            14 => {
                let mut clone = null_mut();
                if call!(self, t, cylfuse_fitter_clone(fitter, &raw mut clone)) {
                    let (result, estimate) = (self.source.output(), self.source.output());
                    let own = Teller::Fitter(clone);
                    if call!(self, own, cylfuse_fitter_fit(clone, result.pointer, estimate.pointer)) {
                        Self::check_whole(&result, checks::result);
                        Self::check_whole(&estimate, checks::estimate);
                    }
                    call!(self, Teller::None, cylfuse_fitter_destroy(clone));
                }
            }
            12 => {
                let inputs = cylfuse_input(self.source.constant(15) as u32);
                call!(self, t, cylfuse_fitter_clear_input(fitter, inputs));
            }
            _ => {
                if self.source.dice.one_in(3) {
                    call!(self, t, cylfuse_fitter_clear(fitter));
                } else {
                    call!(self, t, cylfuse_fitter_cancel(fitter));
                }
            }
        }
    }

    pub fn push(&mut self) {
        let fitter = self.fitter();
        let t = Teller::Fitter(fitter);
        match self.source.dice.below(8) {
            0..2 => {
                let (points, _) = self.source.points();
                let mask = self.source.mask_or_none();
                call!(self, t, cylfuse_fitter_push_points(fitter, points, mask));
            }
            2..4 => {
                let depth = self.source.depth();
                let mask = self.source.mask_or_none();
                call!(self, t, cylfuse_fitter_push_depth(fitter, depth, mask));
            }
            4 => {
                let image = self.source.image();
                call!(self, t, cylfuse_fitter_push_image(fitter, image));
            }
            5 => {
                let (segments, _) = self.source.segments();
                call!(self, t, cylfuse_fitter_push_edges(fitter, segments));
            }
            6 => {
                let (frame, mask) = (self.frame(), self.source.mask_or_none());
                call!(self, t, cylfuse_fitter_use_frame(fitter, frame, mask));
            }
            _ => {
                let out = self.source.output();
                if call!(self, t, cylfuse_fitter_counts(fitter, out.pointer)) {
                    let counts: cylfuse_counts = out.read().unwrap();
                    assert!(!out.is_whole() || counts.points_used <= counts.points_given);
                }
            }
        }
    }

    fn check_fit(result: &Room<cylfuse_result>, estimate: &Room<cylfuse_cylinder_estimate>) {
        if let Some(result) = result.is_whole().then(|| result.read()).flatten() {
            checks::result(&result);
        }
        if let Some(estimate) = estimate.is_whole().then(|| estimate.read()).flatten() {
            checks::estimate(&estimate);
        }
    }

    pub fn solve(&mut self) {
        let fitter = self.fitter();
        let t = Teller::Fitter(fitter);
        let (result, estimate) = (self.source.output(), self.source.output());
        match self.source.dice.below(8) {
            0..3 => {
                if call!(self, t, cylfuse_fitter_fit(fitter, result.pointer, estimate.pointer)) {
                    self.fits += 1;
                    Self::check_fit(&result, &estimate);
                }
            }
            3 => {
                let model = self.source.model();
                if call!(self, t, cylfuse_fitter_evaluate(fitter, model, result.pointer, estimate.pointer)) {
                    Self::check_fit(&result, &estimate);
                }
            }
            4 => self.fit_all(),
            5 => {
                if call!(self, t, cylfuse_fitter_get_result(fitter, result.pointer)) && result.is_whole() {
                    checks::result(&result.read().unwrap());
                }
            }
            6 => {
                if call!(self, t, cylfuse_fitter_get_cylinder(fitter, estimate.pointer))
                    && estimate.is_whole()
                {
                    checks::estimate(&estimate.read().unwrap());
                }
            }
            _ => {
                let out = self.source.output();
                let model = self.source.model_or_last();
                if call!(self, t, cylfuse_fitter_diagnose(fitter, model, out.pointer)) && out.is_whole() {
                    let out: cylfuse_cylinder_diagnosis = out.read().unwrap();
                    checks::finite(&out.singular_values);
                    checks::finite(&out.weakest_shift);
                    checks::finite(&out.weakest_tilt);
                    checks::finite(&[out.weakest_radius]);
                    assert!(out.rank <= 5 && !(out.condition < 1.0), "condition {}", out.condition);
                }
            }
        }
    }

    /// Fits both fitters at once, now and then with others that are none.
    fn fit_all(&mut self) {
        let mut fitters = self.fitters.to_vec();
        if self.source.strikes() {
            // A fitter that is there twice, NULL, one alone, none.
            let [a, b] = self.fitters;
            fitters = vec![vec![a, b, a], vec![null_mut(), b], vec![a], vec![]]
                .swap_remove(self.source.dice.below(4));
        }
        let count = fitters.len();
        let bytes: Vec<u8> = fitters.iter().flat_map(|fitter| fitter.addr().to_ne_bytes()).collect();
        let (pointer, claimed) = if self.source.strikes() {
            // Nothing is read from NULL, however many there are said to be.
            (std::ptr::null(), [count, 0, usize::MAX][self.source.dice.below(3)])
        } else {
            (self.source.place(&bytes).cast_const().cast(), count)
        };
        let statuses = self.source.room::<[cylfuse_status; 3]>(1);
        let threads = if self.source.threads { self.source.dice.below(4) as u32 } else { 1 };
        let callback: cylfuse_fit_all_fn = if self.source.dice.one_in(3) { None } else { Some(ended) };
        let data = fitters.as_mut_ptr().cast();
        let out = statuses.pointer.cast();
        if !call!(self, Teller::None, cylfuse_fit_all(pointer, claimed, threads, callback, data, out)) {
            return;
        }
        let Some(statuses) = statuses.read() else { return };
        for (fitter, status) in fitters.into_iter().zip(statuses).take(claimed) {
            let of_fit = status == cylfuse_status::NULL_POINTER && fitter.is_null();
            assert!(of_fit || self.statuses.lists("cylfuse_fitter_fit", status.0), "status {}", status.0);
            if status == cylfuse_status::OK {
                self.fits += 1;
                let result = self.source.output();
                if call!(self, Teller::Fitter(fitter), cylfuse_fitter_get_result(fitter, result.pointer))
                    && result.is_whole()
                {
                    checks::result(&result.read().unwrap());
                }
            }
        }
    }
}

/// A callback that does what none should do.
unsafe extern "C" fn meddle(progress: *const cylfuse_progress, user_data: *mut c_void) -> i32 {
    let fitter: *mut cylfuse_fitter = user_data.cast();
    // SAFETY: the library gives a struct, and the fitter lives as long as its calls.
    unsafe {
        let iteration = (*progress).iteration;
        let busy = cylfuse_status::BUSY;
        match iteration % 5 {
            0 => assert!(cylfuse_fitter_fit(fitter, null_mut(), null_mut()) == busy),
            1 => assert!(cylfuse_fitter_destroy(fitter) == busy),
            2 => assert!(cylfuse_fitter_clear(fitter) == busy),
            _ => {}
        }
        if iteration == 17 {
            cylfuse_fitter_cancel(fitter);
        }
        i32::from(iteration == 23)
    }
}

/// Is called after each fit of many: looks at the one that ended, meddles with the others, and stops the rest now and then.
unsafe extern "C" fn ended(index: usize, status: cylfuse_status, user_data: *mut c_void) -> i32 {
    // SAFETY: the fitters live as long as the call, and the library says which of them ended.
    unsafe {
        let fitter = *user_data.cast::<*mut cylfuse_fitter>().add(index);
        if status == cylfuse_status::OK {
            let mut count = 0;
            let status = cylfuse_fitter_residuals(
                fitter,
                std::ptr::null(),
                cylfuse_residual_kind(1),
                null_mut(),
                0,
                &raw mut count,
            );
            assert!(status == cylfuse_status::OK || status == cylfuse_status::BUFFER_TOO_SMALL);
        }
        i32::from(status == cylfuse_status::TOO_FEW_POINTS)
    }
}

unsafe extern "C" fn listen(_: cylfuse_log_level, message: *const c_char, _: *mut c_void) {
    // SAFETY: a text that is valid until this returns.
    let text = unsafe { CStr::from_ptr(message) };
    assert!(text.to_bytes().is_ascii());
}
