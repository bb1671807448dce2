//! Sequences of calls on fitters, frames and functions without a handle.

use crate::checks;
use crate::inputs::{Room, Source, may_use_threads};
use crate::memory::{Arena, held};
use crate::random_views::View;
use crate::statuses::Statuses;
use crate::{setting, watch};
use cylfuse::ffi::*;
use std::ffi::{CStr, c_char, c_void};
use std::ptr::null_mut;

/// Calls by default.
const CALLS: u64 = 101_000;

/// A test ends after so many cases that failed.
const MOST_FAILURES: u64 = 20;

/// Calls of a case.
const STEPS: usize = 60;

/// A case, with the handles that it uses.
pub struct Case<'a> {
    pub source: Source<'a>,
    statuses: &'a Statuses,
    pub calls: u64,
    pub fits: u64,
    fitters: [*mut cylfuse_fitter; 2],
    frame: *mut cylfuse_frame,
    pub detector: *mut cylfuse_detector,
}

/// Makes a call and returns its status after all checks that need no look at the outputs.
#[macro_export]
macro_rules! call {
    ($case:expr, $handle:expr, $function:ident($($argument:expr),* $(,)?)) => {{
        let status = unsafe { $function($($argument),*) };
        $case.after(stringify!($function), $handle, status)
    }};
}

/// Whose text tells about a call.
#[derive(Clone, Copy)]
pub enum Teller {
    Fitter(*const cylfuse_fitter),
    Frame(*const cylfuse_frame),
    Detector(*const cylfuse_detector),
    None,
}

impl<'a> Case<'a> {
    pub fn new(seed: u64, arena: &'a mut Arena, statuses: &'a Statuses) -> Self {
        let source = Source::new(seed, arena);
        let mut case = Self {
            source,
            statuses,
            calls: 0,
            fits: 0,
            fitters: [null_mut(); 2],
            frame: null_mut(),
            detector: null_mut(),
        };
        for k in 0..2 {
            let mut fitter = null_mut();
            call!(case, Teller::None, cylfuse_fitter_create(CYLFUSE_ABI_VERSION, &raw mut fitter));
            case.fitters[k] = fitter;
        }
        let mut frame = null_mut();
        call!(case, Teller::None, cylfuse_frame_create(CYLFUSE_ABI_VERSION, &raw mut frame));
        let mut detector = null_mut();
        call!(case, Teller::None, cylfuse_detector_create(CYLFUSE_ABI_VERSION, &raw mut detector));
        (case.frame, case.detector) = (frame, detector);
        case
    }

    pub fn end(mut self) -> (u64, u64) {
        for fitter in self.fitters {
            call!(self, Teller::None, cylfuse_fitter_destroy(fitter));
        }
        let (frame, detector) = (self.frame, self.detector);
        call!(self, Teller::None, cylfuse_frame_destroy(frame));
        call!(self, Teller::None, cylfuse_detector_destroy(detector));
        (self.calls, self.fits)
    }

    /// The checks after every call; whether it succeeded.
    pub fn after(&mut self, function: &str, teller: Teller, status: cylfuse_status) -> bool {
        self.calls += 1;
        let text = unsafe {
            CStr::from_ptr(match teller {
                Teller::Fitter(fitter) => cylfuse_fitter_last_error(fitter),
                Teller::Frame(frame) => cylfuse_frame_last_error(frame),
                Teller::Detector(detector) => cylfuse_detector_last_error(detector),
                Teller::None => cylfuse_fitter_last_error(std::ptr::null()),
            })
        };
        let text = text.to_str().unwrap_or_else(|error| panic!("{function}: a text is not UTF-8: {error}"));
        self.statuses.check(function, status.0, text);
        let succeeded = status == cylfuse_status::OK;
        assert_eq!(text.is_empty(), succeeded, "{function} returned {} and says: {text}", status.0);
        assert!(text.is_ascii() && !text.contains('\n'), "{function} says: {text}");
        succeeded
    }

    fn fitter(&mut self) -> *mut cylfuse_fitter {
        if self.source.strikes() && self.source.strikes() {
            return null_mut();
        }
        self.fitters[usize::from(self.source.dice.one_in(5))]
    }

    fn frame(&mut self) -> *mut cylfuse_frame {
        if self.source.strikes() && self.source.strikes() { null_mut() } else { self.frame }
    }

    /// What most programs do first, so that there is something to go wrong later.
    pub fn prepare(&mut self) {
        for _ in 0..2 {
            let frame = self.frame();
            let (teller, intrinsics) = (Teller::Frame(frame), self.source.intrinsics());
            call!(self, teller, cylfuse_frame_set_intrinsics(frame, intrinsics));
            let depth = self.source.depth();
            call!(self, teller, cylfuse_frame_set_depth(frame, depth));
            let image = self.source.image();
            call!(self, teller, cylfuse_frame_set_image(frame, image));
            self.source.arena.release(false);
            let fitter = self.fitter();
            let mask = self.source.mask();
            call!(self, Teller::Fitter(fitter), cylfuse_fitter_use_frame(fitter, frame, mask));
            self.source.arena.release(false);
        }
    }

    pub fn step(&mut self) {
        match self.source.dice.below(26) {
            0..4 => self.set_up(),
            4..8 => self.push(),
            8..10 => self.fill_frame(),
            10..13 => self.solve(),
            13..17 => self.list(),
            17..20 => self.apply(),
            20..24 => self.without_handle(),
            24 => self.initialise(),
            _ => self.new_view(),
        }
        let take_away = self.source.dice.one_in(4);
        self.source.arena.release(take_away);
    }

    fn new_view(&mut self) {
        self.source.view = View::new(&mut self.source.dice);
        self.source.view.spoil(&mut self.source.dice);
    }

    fn set_up(&mut self) {
        let fitter = self.fitter();
        let t = Teller::Fitter(fitter);
        match self.source.dice.below(14) {
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

    fn push(&mut self) {
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

    pub fn fill_frame(&mut self) {
        let frame = self.frame();
        let t = Teller::Frame(frame);
        match self.source.dice.below(6) {
            0 => {
                let intrinsics = self.source.intrinsics();
                call!(self, t, cylfuse_frame_set_intrinsics(frame, intrinsics));
            }
            1 => {
                let (rotation, translation) = self.source.motion();
                call!(self, t, cylfuse_frame_set_pose(frame, rotation, translation));
            }
            2 => {
                let intrinsics = self.source.intrinsics();
                let (rotation, translation) = self.source.motion();
                call!(self, t, cylfuse_frame_set_depth_camera(frame, intrinsics, rotation, translation));
            }
            3 => {
                let depth = self.source.depth();
                call!(self, t, cylfuse_frame_set_depth(frame, depth));
            }
            4 => {
                let image = self.source.image();
                call!(self, t, cylfuse_frame_set_image(frame, image));
            }
            _ => {
                let mut other = null_mut();
                let version = if self.source.strikes() { 2 } else { CYLFUSE_ABI_VERSION };
                if call!(self, Teller::None, cylfuse_frame_create(version, &raw mut other)) {
                    call!(self, Teller::None, cylfuse_frame_destroy(self.frame));
                    self.frame = other;
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

    fn solve(&mut self) {
        let fitter = self.fitter();
        let t = Teller::Fitter(fitter);
        let (result, estimate) = (self.source.output(), self.source.output());
        match self.source.dice.below(7) {
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
            4 => {
                if call!(self, t, cylfuse_fitter_get_result(fitter, result.pointer)) && result.is_whole() {
                    checks::result(&result.read().unwrap());
                }
            }
            5 => {
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

    fn list(&mut self) {
        let fitter = self.fitter();
        let t = Teller::Fitter(fitter);
        match self.source.dice.below(5) {
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
            3 => {
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

    fn apply(&mut self) {
        let fitter = self.fitter();
        let t = Teller::Fitter(fitter);
        let (model, mask) = (self.source.model_or_last(), self.source.mask_or_none());
        match self.source.dice.below(4) {
            0 => self.complete(fitter, model, mask),
            1 => self.complete_depth(fitter, model, mask),
            2 => {
                let out = self.source.output();
                if call!(self, t, cylfuse_fitter_extent(fitter, model, mask, out.pointer)) && out.is_whole() {
                    checks::extent(&out.read().unwrap());
                }
            }
            _ => {
                let (segments, count) = self.source.segments();
                let reach = self.source.number(3.0);
                let room = self.source.room::<u8>(count.min(100));
                let capacity = count.min(100);
                call!(
                    self,
                    t,
                    cylfuse_fitter_select_edges(fitter, model, segments, reach, room.pointer, capacity)
                );
            }
        }
    }

    fn complete(
        &mut self,
        fitter: *mut cylfuse_fitter,
        model: *const cylfuse_cylinder,
        mask: *const cylfuse_mask_view,
    ) {
        let t = Teller::Fitter(fitter);
        let layout = cylfuse_layout(self.source.constant(1));
        let bound = self.source.room::<usize>(1);
        if !call!(self, t, cylfuse_fitter_complete_bound(fitter, mask, layout, bound.pointer)) {
            return;
        }
        let bound = bound.read().unwrap();
        // Intrinsics of many pixels may have been set; a program with less room is told so.
        let capacity = bound.min(30_000);
        let capacity = if self.source.strikes() { capacity / 2 } else { capacity };
        let wide = self.source.dice.one_in(2);
        let size = if wide { 24 } else { 12 };
        let room = self.source.room::<u8>(capacity * size);
        let value = cylfuse_points_out {
            struct_size: 0,
            scalar: cylfuse_scalar(if wide { 2 } else { 1 }),
            data: room.pointer.cast(),
            capacity,
            point_stride: 0,
            row_stride: 0,
        };
        let out = self.source.input(&value);
        let completion = self.source.output();
        if call!(self, t, cylfuse_fitter_complete(fitter, model, mask, layout, out, completion.pointer)) {
            let completion: cylfuse_completion = completion.read().unwrap();
            let count = if layout == cylfuse_layout(0) { completion.count as usize } else { bound };
            for k in 0..count * 3 {
                let number = unsafe {
                    if wide {
                        room.pointer.cast::<f64>().add(k).read_unaligned()
                    } else {
                        room.pointer.cast::<f32>().add(k).read_unaligned().into()
                    }
                };
                let allowed = number.is_finite() || (number.is_nan() && layout == cylfuse_layout(1));
                assert!(allowed, "a completed point has {number}");
            }
        }
    }

    fn complete_depth(
        &mut self,
        fitter: *mut cylfuse_fitter,
        model: *const cylfuse_cylinder,
        mask: *const cylfuse_mask_view,
    ) {
        let (width, height) = self.source.view.size;
        let narrow = self.source.dice.one_in(2);
        let size = if narrow { 2 } else { 4 };
        let room = self.source.room::<u8>(width * height * size);
        let value = cylfuse_depth_out {
            struct_size: 0,
            format: cylfuse_depth_format(if narrow { 1 } else { 2 }),
            data: room.pointer.cast(),
            width: width as u32,
            height: height as u32,
            row_stride: 0,
            pixel_stride: 0,
            scale: self.source.number(if narrow { 0.001 } else { 1.0 }),
        };
        let out = self.source.input(&value);
        let completion = self.source.output::<cylfuse_completion>();
        let t = Teller::Fitter(fitter);
        if call!(self, t, cylfuse_fitter_complete_depth(fitter, model, mask, out, completion.pointer))
            && !narrow
        {
            for k in 0..width * height {
                let depth = unsafe { room.pointer.cast::<f32>().add(k).read_unaligned() };
                assert!(depth.is_finite() && depth >= 0.0, "a completed depth is {depth}");
            }
        }
    }

    fn without_handle(&mut self) {
        let t = Teller::None;
        match self.source.dice.below(6) {
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
    fn initialise(&mut self) {
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
        // SAFETY: a static text.
        assert!(!unsafe { CStr::from_ptr(cylfuse_status_string(status)) }.is_empty());
    }

    /// The frame of the case.
    pub fn own_frame(&self) -> *mut cylfuse_frame {
        self.frame
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

unsafe extern "C" fn listen(_: cylfuse_log_level, message: *const c_char, _: *mut c_void) {
    // SAFETY: a text that is valid until this returns.
    let text = unsafe { CStr::from_ptr(message) };
    assert!(text.to_bytes().is_ascii());
}

/// Runs cases until that many calls were made.
pub fn run(
    watch: &'static watch::Watch,
    calls: u64,
    body: impl Fn(u64, &mut Arena, &Statuses) -> (u64, u64),
) -> (u64, u64, u64) {
    let statuses = Statuses::read();
    let mut arena = Arena::new();
    let mut done = (0, 0, 0);
    let mut failed = Vec::new();
    let one = setting("CYLFUSE_FUZZ_CASE");
    let first = one.or(setting("CYLFUSE_FUZZ_FIRST")).unwrap_or(0);
    for case in first.. {
        let before = held();
        let outcome = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            watch.run(case, || body(case, &mut arena, &statuses))
        }));
        if let Ok((made, fits)) = outcome {
            done = (done.0 + made, done.1 + fits, done.2 + 1);
            let kept = held() - before;
            // The first cases fill what a thread keeps for its next calls. What one thread takes another gives back.
            if kept > 0 && case > first + 3 && !may_use_threads(case) {
                eprintln!("case {case} keeps {kept} bytes");
                failed.push(case);
            }
        } else {
            eprintln!("^ in case {case}");
            failed.push(case);
            arena = Arena::new();
        }
        if done.0 >= calls
            || one.is_some()
            || failed.len() as u64 >= setting("CYLFUSE_FUZZ_FAILURES").unwrap_or(MOST_FAILURES)
        {
            break;
        }
    }
    assert!(failed.is_empty(), "in cases {failed:?}");
    done
}

#[test]
fn calls() {
    let calls = setting("CYLFUSE_FUZZ_CALLS").unwrap_or(CALLS);
    let (made, fits, cases) = run(&watch::CALLS, calls, |seed, arena, statuses| {
        let mut case = Case::new(seed, arena, statuses);
        case.prepare();
        for _ in 0..STEPS {
            case.step();
        }
        case.end()
    });
    println!("fuzz: {made} calls in {cases} cases, {fits} fits succeeded");
    assert!(
        fits > made / 500 || made < 10_000,
        "the cases have become too hostile: {fits} fits in {made} calls"
    );
}
